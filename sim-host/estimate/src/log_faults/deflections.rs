//! How the tool moved under its load, log by log: what tells how a wrench is to be read.

use super::refine::quantile;
use super::relation::RELATION_ROWS_MIN;
use super::rows::LogRow;
use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};
use trueweld_core::spatial::rotation_vector;
use trueweld_core::{JOINTS, Robot, Wrench};
use trueweld_logs::ROTATION_LENGTH;
use trueweld_logs::log::{Log, LogKind};

/// What an arm may give more, or less, than the model says.
pub(super) const COMPLIANCE_RATIO_RANGE: [f64; 2] = [0.3, 3.0];

/// Sums of squares that differ by less are the same.
pub(super) const EQUAL_SQUARES_RATIO: f64 = 1.1;

/// Deflection that tells nothing, m.
pub(super) const TELLING_DEFLECTION_MIN: f64 = 1e-4;

/// How the tool of one log moved under its load, and what the load was.
pub(super) struct Deflections {
    pub rows: Vec<Deflected>,
    /// Sum of the squares of how far it moved, m².
    pub squares: f64,
    /// True where the log has moments.
    pub has_moments: bool,
    /// The wrenches of a weld as they were read, whose moment the model expects to vanish.
    pub weld_wrenches: Vec<Vector6<f64>>,
    /// How many times as much as the log states each column scatters from row to row.
    pub scatter: [Option<f64>; 6],
    /// Joints that are stated to be rigid.
    rigid: [bool; JOINTS],
}

/// One row, less the mean of its posture: position, m, and rotation times [`ROTATION_LENGTH`]; the
/// wrench as it was read, N and N·m; the movement per N or N·m of each of its columns; and the movement
/// of each joint's spring.
#[derive(Clone)]
pub(super) struct Deflected {
    pub moved: Vector6<f64>,
    pub wrench: Vector6<f64>,
    pub compliance: Matrix6<f64>,
    pub by_joint: [JointMovement; JOINTS],
}

/// How one joint's spring moves the tool per N·m, and its torque per N or N·m of the wrench's columns.
#[derive(Clone, Copy)]
pub(super) struct JointMovement {
    moved: Vector6<f64>,
    torque: Vector6<f64>,
}

impl JointMovement {
    /// Of every joint where a row stands.
    fn of(row: &LogRow, robot: &Robot<f64>) -> [Self; JOINTS] {
        let frames = robot.frames(&row.encoder);
        let jacobian = frames.jacobian().0;
        let lever = frames.tcp.rotation * row.point;
        let unit = |c: usize| {
            let mut one = Vector6::zeros();
            one[c] = 1.0;
            frames.joint_torque(&wrench_of(&one).rotated(&frames.tcp.rotation))
        };
        let torque = [0, 1, 2, 3, 4, 5].map(unit);
        std::array::from_fn(|j| {
            let turn: Vector3<f64> = jacobian.fixed_view::<3, 1>(0, j).into_owned();
            let at: Vector3<f64> = jacobian.fixed_view::<3, 1>(3, j) + turn.cross(&lever);
            let turn = turn * ROTATION_LENGTH;
            let moved = Vector6::new(at.x, at.y, at.z, turn.x, turn.y, turn.z);
            Self {
                moved: moved / robot.parameters().joints[j].stiffness,
                torque: Vector6::from_fn(|c, _| torque[c][j]),
            }
        })
    }
}

/// How far a row's load moves the tool, and how far unit loads would; `None` where the arm cannot
/// carry it.
fn deflected(row: &LogRow, robot: &Robot<f64>) -> Option<Deflected> {
    /// N or N·m.
    const UNIT_LOAD: f64 = 1e3;
    let moved = movement(row, robot, &Wrench::zero())?;
    let mut compliance = Matrix6::zeros();
    for c in 0..6 {
        let mut one = Vector6::zeros();
        one[c] = UNIT_LOAD;
        let per_load = (moved - movement(row, robot, &wrench_of(&one))?) / UNIT_LOAD;
        compliance.set_column(c, &per_load);
    }
    let Wrench { force: f, moment: m } = row.wrench;
    let wrench = Vector6::new(f.x, f.y, f.z, m.x, m.y, m.z);
    Some(Deflected { moved, wrench, compliance, by_joint: JointMovement::of(row, robot) })
}

impl Deflections {
    /// `None` where the log does not tell.
    pub(crate) fn of(log: &Log, rows: &[LogRow], robot: &Robot<f64>) -> Option<Self> {
        if log.samples.force.is_none() || log.samples.unmeasured_force.contains(&true) {
            return None;
        }
        let deflected_at = |row: &LogRow| Some((row.encoder, deflected(row, robot)?));
        let mut loaded: Vec<_> = rows.iter().filter_map(deflected_at).collect();
        let weld = log.kind == LogKind::Weld;
        let has_moments = log.samples.moment.is_some();
        let of_weld = || loaded.iter().map(|(_, row): &(_, Deflected)| row.wrench).collect();
        let weld_wrenches = if weld && has_moments { of_weld() } else { Vec::new() };
        // Rows of one posture differ by their load alone; a weld is one.
        let postures = loaded.chunk_by_mut(|a, b| weld || (a.0 - b.0).amax() < 5e-3);
        for posture in postures {
            let count = posture.len() as f64;
            let moved = posture.iter().map(|(_, row)| row.moved).sum::<Vector6<f64>>() / count;
            let wrench = posture.iter().map(|(_, row)| row.wrench).sum::<Vector6<f64>>() / count;
            for (_, row) in posture {
                row.moved -= moved;
                row.wrench -= wrench;
            }
        }
        let rows: Vec<Deflected> = loaded.into_iter().map(|(_, row)| row).collect();
        let squares: f64 = rows.iter().map(|row| row.moved.norm_squared()).sum();
        let tells = rows.len() >= RELATION_ROWS_MIN / 2
            && squares > rows.len() as f64 * TELLING_DEFLECTION_MIN * TELLING_DEFLECTION_MIN;
        let scatter = std::array::from_fn(|c| scatter(log, c));
        let rigid = log.robot.rigid;
        tells.then_some(Self { rows, squares, has_moments, weld_wrenches, scatter, rigid })
    }

    /// All that several logs tell.
    pub(crate) fn together<'d>(all: impl Iterator<Item = &'d Self>) -> Self {
        let none = Self {
            rows: Vec::new(),
            squares: 0.0,
            has_moments: true,
            weld_wrenches: Vec::new(),
            scatter: [None; 6],
            rigid: [false; JOINTS],
        };
        all.fold(none, |mut sum, own| {
            sum.rows.extend_from_slice(&own.rows);
            sum.squares += own.squares;
            sum.has_moments &= own.has_moments;
            sum.rigid = own.rigid;
            sum.weld_wrenches.extend_from_slice(&own.weld_wrenches);
            sum
        })
    }

    /// Sum of squares that is left with the wrench read in some way, m²; the arm may give more or less
    /// than the model says.
    pub(crate) fn left_by(&self, read: impl Fn(&Vector6<f64>) -> Vector6<f64>) -> f64 {
        let (mut across, mut given) = (0.0, 0.0);
        for row in &self.rows {
            let by = row.compliance * read(&row.wrench);
            across += by.dot(&row.moved);
            given += by.norm_squared();
        }
        let gives = (across / f64::max(given, f64::MIN_POSITIVE))
            .clamp(COMPLIANCE_RATIO_RANGE[0], COMPLIANCE_RATIO_RANGE[1]);
        self.squares - 2.0 * gives * across + gives * gives * given
    }

    /// Sum of squares that is left where joints stated to be rigid give way as much as the movement
    /// asks, m²: an arm that is softer than its file is no mistake in a log. The others give more or
    /// less than the model says, all alike. Infinite where none is stated to be rigid.
    pub(crate) fn left_by_springs(&self) -> f64 {
        /// Sweeps over the factors, each put where it leaves least.
        const SPRING_SWEEPS: usize = 100;
        /// The factor of the joints that bend, after one for each that is rigid.
        const BENDING_JOINTS: usize = JOINTS;
        if !self.rigid.contains(&true) {
            return f64::INFINITY;
        }
        let mut normal = SMatrix::<f64, { JOINTS + 1 }, { JOINTS + 1 }>::zeros();
        let mut right = SVector::<f64, { JOINTS + 1 }>::zeros();
        for row in &self.rows {
            let mut by = SMatrix::<f64, 6, { JOINTS + 1 }>::zeros();
            for (j, joint) in row.by_joint.iter().enumerate() {
                let factor = if self.rigid[j] { j } else { BENDING_JOINTS };
                let moved = joint.moved * joint.torque.dot(&row.wrench);
                by.set_column(factor, &(by.column(factor) + moved));
            }
            normal += by.tr_mul(&by);
            right += by.tr_mul(&row.moved);
        }
        let mut gives = SVector::<f64, { JOINTS + 1 }>::repeat(1.0);
        for k in (0..SPRING_SWEEPS).flat_map(|_| 0..=BENDING_JOINTS) {
            let own: f64 = normal[(k, k)];
            if own > 0.0 {
                let [low, high] = COMPLIANCE_RATIO_RANGE;
                let high = if k == BENDING_JOINTS { high } else { f64::INFINITY };
                let rest = right[k] - normal.column(k).dot(&gives) + own * gives[k];
                gives[k] = (rest / own).clamp(low, high);
            }
        }
        self.squares - 2.0 * right.dot(&gives) + gives.dot(&(normal * gives))
    }

    /// Root mean square of a sum of squares.
    pub(crate) fn root(&self, sum: f64) -> f64 {
        (sum.max(0.0) / self.rows.len() as f64).sqrt()
    }
}

/// How many times as much as is stated a column of the wrench scatters from row to row; `None` where
/// nothing is stated or read.
fn scatter(log: &Log, column: usize) -> Option<f64> {
    /// Median of the differences of two normal numbers, in their deviations.
    const MEDIAN: f64 = 0.6745 * std::f64::consts::SQRT_2;
    let (series, levels) = match column {
        ..3 => (&log.samples.force, &log.noise.force),
        _ => (&log.samples.moment, &log.noise.moment),
    };
    let stated = levels[column % 3]?.deviation;
    let steps = series.as_ref()?.windows(2).map(|v| (v[1] - v[0])[column % 3].abs());
    let step = quantile(steps.filter(|step| step.is_finite()), 5)?;
    Some(step / MEDIAN / stated)
}

fn wrench_of(columns: &Vector6<f64>) -> Wrench<f64> {
    let part = |first: usize| columns.fixed_rows::<3>(first).into_owned();
    Wrench { force: part(0), moment: part(3) }
}

/// How far the tool was seen from where it stands under a wrench: position, m, and rotation times
/// [`ROTATION_LENGTH`].
fn movement(row: &LogRow, robot: &Robot<f64>, wrench: &Wrench<f64>) -> Option<Vector6<f64>> {
    let seen = LogRow { wrench: *wrench, ..row.clone() }.pose_pair(robot, &row.encoder)?;
    let away = seen.position - seen.nominal.position;
    let turned = seen.rotation.map_or(Vector3::zeros(), |r| {
        rotation_vector(&(r * seen.nominal.rotation.transpose())) * ROTATION_LENGTH
    });
    Some(Vector6::new(away.x, away.y, away.z, turned.x, turned.y, turned.z))
}
