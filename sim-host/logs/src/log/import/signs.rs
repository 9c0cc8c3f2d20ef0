//! Signs of the axes: by their limits, by the motion that a tracker saw, by the torque that the
//! model needs for it. With the motion comes the clock of the tracker.

use super::proposal::{Doubt, ProposalBasis, ProposedColumn, ProposedFile};
use super::raw::{ENCODER_COLUMN, POSITION, Raw, TORQUE, file_of, series, times};
use crate::ROTATION_LENGTH;
use crate::channel::LogChannel;
use crate::clock::{ClockMap, FittedClock, Points, correlate, fit, rigid};
use crate::fir::LowPass;
use crate::kind::LogKind;
use crate::log::columns::{MAPPABLE_COLUMNS, reflector};
use crate::log::coupling::Coupling;
use crate::log::pose::to_rotation_vectors;
use crate::log::track::FileTrack;
use crate::log::units::unit_named;
use crate::resample::median_step;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose, Robot, Wrench};
use trueweld_plant::input::RobotFile;

/// Rows that signs are told by.
const SIGN_ROWS: usize = 1500;

/// What the right signs may leave of a motion, m: the arm bends by millimetres, and a reflector sits
/// beside the tool's centre.
const FITS: f64 = 0.15;

/// An axis has one sign alone where the other would leave its limits.
pub(super) fn signs_by_limits(columns: &mut [ProposedColumn], robot: Option<&RobotFile>) {
    let room = 10f64.to_radians();
    for proposed in columns.iter_mut() {
        let Ok(mapping) = &mut proposed.mapping else { continue };
        let Some(joint) = mapping.column.checked_sub(ENCODER_COLUMN).filter(|j| *j < JOINTS) else {
            continue;
        };
        let (Some(robot), Some(range)) = (robot, proposed.range) else {
            proposed.doubts.push(Doubt::Sign);
            continue;
        };
        let unit = unit_named(mapping.unit).map_or(1.0, |u| u.factor);
        let [low, high] = robot.parameters.joints[joint].limits;
        let inside = |sign: f64| {
            range.iter().all(|v| (low - room..=high + room).contains(&(sign * unit * v)))
        };
        match (inside(1.0), inside(-1.0)) {
            (true, false) => proposed.bases.push(ProposalBasis::Limits),
            (false, true) => {
                mapping.factor = -mapping.factor;
                proposed.bases.push(ProposalBasis::Limits);
            }
            _ => proposed.doubts.push(Doubt::Sign),
        }
    }
}

/// Every n-th, so that so many are left.
fn thinned<T: Copy>(values: &[T], most: usize) -> Vec<T> {
    values.iter().copied().step_by((values.len() / most).max(1)).collect()
}

/// A motion that the encoders and a tracker both saw.
#[derive(Clone)]
struct SharedMotion<'a> {
    robot: &'a RobotFile,
    /// First of the log's columns that the tracker's points are of.
    first: usize,
    time: Vec<f64>,
    /// A series a joint, rad.
    encoders: Vec<Vec<f64>>,
    seen_time: Vec<f64>,
    /// What the tracker saw, m.
    seen: Vec<Vector3<f64>>,
    /// The tool's rotation vectors as the tracker saw them.
    turned: Option<Vec<Vector3<f64>>>,
    /// True where the rows of both are of the same instants.
    by_rows: bool,
    /// Rows of the encoders that signs are tried on.
    rows: Vec<usize>,
    /// An axis that is counted from the horizontal.
    coupling: Option<Coupling>,
}

impl<'a> SharedMotion<'a> {
    /// With the file of the tracker.
    fn find(
        columns: &[ProposedColumn],
        raws: &[Raw],
        robot: &'a RobotFile,
        kind: LogKind,
    ) -> Option<(Self, usize)> {
        let own = file_of(columns, ENCODER_COLUMN)?;
        let (first, other) = [POSITION, reflector(0).start]
            .into_iter()
            .find_map(|column| Some((column, file_of(columns, column)?)))?;
        let of = |file: usize, column: usize| series(columns, raws, Some(file), column);
        let time = times(columns, raws, own)?;
        let seen_time = times(columns, raws, other)?;
        let encoders =
            (0..JOINTS).map(|i| of(own, ENCODER_COLUMN + i)).collect::<Option<Vec<_>>>()?;
        let points = (0..3).map(|i| of(other, first + i)).collect::<Option<Vec<_>>>()?;
        let seen = (0..seen_time.len())
            .map(|k| Vector3::new(points[0][k], points[1][k], points[2][k]))
            .collect();
        let turned = rotations(columns, raws, other);
        let by_rows =
            other == own || (kind == LogKind::StaticLoad && seen_time.len() == time.len());
        if kind == LogKind::StaticLoad && !by_rows {
            return None;
        }
        let rows = thinned(&(0..time.len()).collect::<Vec<_>>(), SIGN_ROWS);
        let coupling = None;
        let found =
            Self { robot, first, time, encoders, seen_time, seen, turned, by_rows, rows, coupling };
        Some((found, other))
    }

    /// Pose of the tool at a row. `signs`: a bit for each axis that counts the other way.
    fn pose(&self, signs: usize, row: usize) -> Pose<f64> {
        let sign = |i: usize| if signs & (1 << i) == 0 { 1.0 } else { -1.0 };
        let read = JointVector::from_fn(|i, _| sign(i) * self.encoders[i][row]);
        let q = self.coupling.map_or(read, |coupling| coupling.of(&read));
        self.robot.robot.forward_kinematics(&q)
    }

    fn path(&self, signs: usize, rows: impl Iterator<Item = usize>) -> Vec<Vector3<f64>> {
        rows.map(|row| self.pose(signs, row).position).collect()
    }

    /// What these signs leave of the motion that the tracker saw, m.
    fn left(&self, signs: usize) -> f64 {
        let path = self.path(signs, self.rows.iter().copied());
        if self.by_rows {
            let pairs = self.rows.iter().zip(&path).map(|(row, point)| (*point, self.seen[*row]));
            let (a, b): (Vec<_>, Vec<_>) =
                pairs.filter(|(a, b)| a.sum().is_finite() && b.sum().is_finite()).unzip();
            let Some((turn, shift)) = rigid(&a, &b) else { return f64::INFINITY };
            let squares: f64 =
                a.iter().zip(&b).map(|(x, p)| (p - turn * x - shift).norm_squared()).sum();
            let left = (squares / a.len().max(1) as f64).sqrt();
            return left.hypot(self.turn_left(signs, |row| row));
        }
        let time: Vec<f64> = self.rows.iter().map(|row| self.time[*row]).collect();
        let (seen, seen_time) =
            (thinned(&self.seen, 4 * SIGN_ROWS), thinned(&self.seen_time, 4 * SIGN_ROWS));
        let a = Points { time: &time, point: &path };
        let b = Points { time: &seen_time, point: &seen };
        clock_between(&a, &b).map_or(f64::INFINITY, |fitted| {
            let row = |row: usize| {
                let there = fitted.map.offset + (1.0 + fitted.map.drift) * self.time[row];
                self.seen_time.partition_point(|t| *t < there)
            };
            fitted.left.hypot(self.turn_left(signs, row))
        })
    }

    /// How much less or more than seen the tool turned from its first pose, which is the same in
    /// every frame, m at [`ROTATION_LENGTH`]. `there`: the tracker's row at a row of the encoders.
    fn turn_left(&self, signs: usize, there: impl Fn(usize) -> usize) -> f64 {
        let Some(turned) = &self.turned else { return 0.0 };
        let pairs: Vec<_> = self
            .rows
            .iter()
            .map(|row| (self.pose(signs, *row).rotation, turned[there(*row).min(turned.len() - 1)]))
            .filter(|(a, b)| a.sum().is_finite() && b.sum().is_finite())
            .map(|(a, b)| (a, rotation_from_vector(&b)))
            .collect();
        let Some((a0, b0)) = pairs.first().copied() else { return 0.0 };
        let angle =
            |from: &Matrix3<f64>, to: &Matrix3<f64>| rotation_vector(&from.tr_mul(to)).norm();
        let squares: f64 = pairs.iter().map(|(a, b)| (angle(&a0, a) - angle(&b0, b)).powi(2)).sum();
        ROTATION_LENGTH * (squares / pairs.len() as f64).sqrt()
    }
}

/// The clock of `b` against that of `a`.
fn clock_between(a: &Points<'_>, b: &Points<'_>) -> Option<FittedClock> {
    let (offset, step) = correlate(a, b)?;
    fit(a, b, ClockMap { offset, drift: 0.0 }, step, [false; 2])
}

/// Signs of the axes and the clock of the tracker, by the motion that both saw.
pub(super) fn motion(
    columns: &mut [ProposedColumn],
    files: &mut [ProposedFile],
    raws: &[Raw],
    robot: &RobotFile,
    kind: LogKind,
) {
    let Some((shared, other)) = SharedMotion::find(columns, raws, robot, kind) else { return };
    // Signs that the limits tell are not tried.
    let axis = |c: &ProposedColumn| {
        (0..JOINTS).find(|i| c.is(ENCODER_COLUMN + i)).filter(|_| c.doubts.contains(&Doubt::Sign))
    };
    let mask = columns.iter().filter_map(axis).fold(0, |mask, i| mask | (1 << i));
    let tried: Vec<usize> = (0..1 << JOINTS).filter(|signs| signs & !mask == 0).collect();
    let search = |shared: &SharedMotion<'_>| {
        let mut results: Vec<(f64, usize)> =
            tried.par_iter().map(|signs| (shared.left(*signs), *signs)).collect();
        results.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        results
    };
    let fits = |results: &[(f64, usize)]| results.first().is_some_and(|(left, _)| *left < FITS);
    let mut shared = shared;
    let mut results = search(&shared);
    if !fits(&results) {
        // The unit that the header says may not be the one of the values.
        let scaled = [1e3, 1e-3].into_iter().find_map(|factor| {
            let seen = shared.seen.iter().map(|point| point * factor).collect();
            let scaled = SharedMotion { seen, ..shared.clone() };
            let results = search(&scaled);
            fits(&results).then_some((scaled, results))
        });
        if let Some(found) = scaled {
            (shared, results) = found;
            let seen = |c: &ProposedColumn| (0..3).any(|i| c.is(shared.first + i));
            columns.iter_mut().filter(|c| seen(c)).for_each(|c| c.doubts.push(Doubt::Scale));
        }
    }
    // A coupled axis may leave little of a small motion: what explains it leaves much less.
    let left = |results: &[(f64, usize)]| results.first().map_or(f64::INFINITY, |(left, _)| *left);
    let coupled = Coupling::all(&robot.robot).into_iter().find_map(|coupling| {
        let coupled = SharedMotion { coupling: Some(coupling), ..shared.clone() };
        let found = search(&coupled);
        (fits(&found) && left(&found) < 0.5 * left(&results)).then_some((coupled, found))
    });
    if let Some(found) = coupled {
        (shared, results) = found;
        shared.coupling.iter().for_each(|coupling| couple(columns, coupling));
    }
    let Some(&(best, signs)) = results.first().filter(|(left, _)| left.is_finite()) else {
        return;
    };
    for column in columns {
        let Some(i) = axis(column) else { continue };
        let flipped = |s: usize| s & (1 << i) != signs & (1 << i);
        let others =
            results.iter().find(|(_, s)| flipped(*s)).map_or(f64::INFINITY, |(left, _)| *left);
        if best < FITS && others > 2.0 * best + 0.002 {
            column.doubts.retain(|d| *d != Doubt::Sign);
            column.bases.push(ProposalBasis::Motion { left: best, others });
            if signs & (1 << i) != 0
                && let Ok(mapping) = &mut column.mapping
            {
                mapping.factor = -mapping.factor;
            }
        }
    }
    if !shared.by_rows && files[other].clock.is_some() {
        let path = shared.path(signs, 0..shared.time.len());
        let a = Points { time: &shared.time, point: &path };
        files[other].fitted =
            clock_between(&a, &Points { time: &shared.seen_time, point: &shared.seen });
    }
}

/// Adds to the column of an axis what it lacks.
fn couple(columns: &mut [ProposedColumn], coupling: &Coupling) {
    let axis = columns.iter_mut().find(|column| column.is(ENCODER_COLUMN + coupling.joint));
    let Some(axis) = axis else { return };
    axis.bases.push(ProposalBasis::Coupling);
    if let Ok(mapping) = &mut axis.mapping {
        mapping.plus = vec![(ENCODER_COLUMN + coupling.other, coupling.times)];
    }
}

/// Rotation vectors of the tool, in whatever form a file has them.
fn rotations(columns: &[ProposedColumn], raws: &[Raw], file: usize) -> Option<Vec<Vector3<f64>>> {
    let of = |column: usize| series(columns, raws, Some(file), column);
    let columns = (0..MAPPABLE_COLUMNS).map(of).collect();
    let mut track = FileTrack { clock: None, columns, rounding: vec![0.0; MAPPABLE_COLUMNS] };
    to_rotation_vectors(&mut track);
    let rotation = LogChannel::Rotation.columns();
    let rows = 0..track.time().len();
    track
        .has(rotation.clone())
        .then(|| rows.map(|k| track.vector(rotation.start, k)).collect::<Vec<_>>())
        .filter(|rows| !rows.is_empty())
}

/// Signs of the torques, by what the model needs for the motion.
pub(super) fn torque_signs(columns: &mut [ProposedColumn], raws: &[Raw], robot: &RobotFile) {
    let own = file_of(columns, ENCODER_COLUMN);
    let encoders: Option<Vec<Vec<f64>>> =
        (0..JOINTS).map(|i| series(columns, raws, own, ENCODER_COLUMN + i)).collect();
    let time = own.and_then(|own| times(columns, raws, own));
    let whole = |v: &[f64]| v.iter().all(|x| x.is_finite());
    let predicted = match (encoders, time) {
        (Some(q), Some(time)) if time.len() > 200 && q.iter().all(|q| whole(q)) => {
            Some(motor_torques(&robot.robot, &q, &time))
        }
        _ => None,
    };
    for i in 0..JOINTS {
        let measured = series(columns, raws, own, TORQUE + i);
        // Against an angle whose sign is open, a torque's sign is open too.
        let open =
            columns.iter().any(|c| c.is(ENCODER_COLUMN + i) && c.doubts.contains(&Doubt::Sign));
        let Some(column) = columns.iter_mut().find(|c| c.is(TORQUE + i)) else { continue };
        if column.mapping.as_ref().is_ok_and(|mapping| mapping.open) {
            // The factor that is fitted has its sign.
            continue;
        }
        let correlation = match (&predicted, measured) {
            (Some(predicted), Some(measured)) if measured.len() == predicted.len() => {
                let pairs = predicted.iter().map(|p| p[i]).zip(measured);
                correlation(
                    &pairs.filter(|(a, b)| a.is_finite() && b.is_finite()).collect::<Vec<_>>(),
                )
            }
            _ => 0.0,
        };
        if open || correlation.abs() < 0.5 {
            column.doubts.push(Doubt::Sign);
            continue;
        }
        column.bases.push(ProposalBasis::ModelTorque(correlation.abs()));
        if let (true, Ok(mapping)) = (correlation < 0.0, &mut column.mapping) {
            mapping.factor = -mapping.factor;
        }
    }
}

/// Motor torques that a model needs for a motion without load, N·m. `q`: each joint's angles, rad,
/// at the times, s.
pub(super) fn motor_torques(
    model: &Robot<f64>,
    q: &[Vec<f64>],
    time: &[f64],
) -> Vec<JointVector<f64>> {
    let period = median_step(time);
    let low = LowPass::new(5f64.min(0.2 / period), period);
    let smooth: Vec<[Vec<f64>; 3]> =
        q.iter().map(|q| [0, 1, 2].map(|d| low.smooth(d, q))).collect();
    let at = |d: usize, k: usize| JointVector::from_fn(|i, _| smooth[i][d][k]);
    let mut torques = Vec::with_capacity(time.len());
    for k in 0..time.len() {
        let (q, rate, acceleration) = (at(0, k), at(1, k), at(2, k));
        let mut torque = model.rnea(&model.frames(&q), &rate, &acceleration, &Wrench::zero());
        torque[1] -= model.counterbalance_torque(q[1]);
        for i in 0..JOINTS {
            torque[i] += model.rotor_inertia()[i] * acceleration[i]
                + model.parameters().friction.torque(i, rate[i]).0;
        }
        torques.push(torque);
    }
    torques
}

/// Of pairs, with the sign of what they have in common about zero where both hardly vary.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len().max(1) as f64;
    let (a, b) = pairs.iter().fold((0.0, 0.0), |(a, b), pair| (a + pair.0 / n, b + pair.1 / n));
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(x, y)| f(x - a, y - b)).sum::<f64>();
    let (xx, yy, xy) = (sum(&|x, _| x * x), sum(&|_, y| y * y), sum(&|x, y| x * y));
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}
