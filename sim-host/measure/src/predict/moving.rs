//! Free motion and ringing down: the links swing on their springs, driven by the encoders.

use super::play::{BacklashObserver, Observed};
use super::{
    Compared, Model, Motion, PredictError, Quantity, filled, known, list, none_where_missing,
    period, seen, sensed, unread,
};
use crate::data::channel::LogChannel;
use crate::data::fir::{
    Bands, Beginning, CLOSELY, LowPass, NOT_BY_CHANCE, Smoothed, interpolate, start,
};
use crate::data::log::{Log, LogKind};
use crate::data::noise::{Level, NoiseLevels};
use nalgebra::{Complex, DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JointVector, Pose, Wrench};
use trueweld_plant::integrate::Diverged;
use trueweld_plant::integrate::link_dynamics::{DynamicLinks, Motors};
use trueweld_plant::robot::{Channel, Drives, ElasticRobot, INTERNAL_STATES, Memory, Readings};

/// Bands of the encoders that drive the links, Hz, widest first: what a brake does to them, and
/// what is left of their noise where they move smoothly. Noise in the drive makes a gear's memory
/// fade and lightly damped modes swing.
const DRIVE_BANDS: [f64; 5] = [200.0, 60.0, 20.0, 8.0, 3.0];

/// Band of what the motors did, for their torque, Hz: what is compared of it lies well below.
const MOTOR_BAND: f64 = 20.0;

/// Band in which motor torque is compared, Hz: above it the encoders' noise, differentiated twice,
/// drowns the torque's own.
const TORQUE_BAND: f64 = 8.0;

/// Band in which a pose or a second encoder is compared in free motion, as a share of the arm's
/// lowest frequency: the encoders' noise rings the arm there, and what rings is told from an effect
/// by its phase alone, which no sum of squares knows.
const CALM: f64 = 0.5;

/// Longest step of the links' integration, s: a mode of 50 Hz turns by 0.6 rad in it.
const STEP: f64 = 2e-3;

/// Time at either end of a log that is driven through but not compared, s: there the smoothed drive
/// has one side only.
const END: f64 = 0.1;

/// Postures along a log at which the noise's way through the arm is worked out, the grid of
/// frequencies for it, Hz (a mode of 10 Hz with 3 % damping is 0.6 Hz wide), and the highest that
/// matters.
const POSTURES: usize = 5;
const LINE: f64 = 0.1;
const HIGHEST: f64 = 120.0;

/// Standard deviations that the encoders' noise leaves in what is predicted.
struct Through {
    /// Link angles, rad.
    link: SVector<f64, 6>,
    /// Tool: rotation, rad, and position, m, in B.
    tool: SVector<f64, 6>,
    /// Motor torque in its band, N·m.
    torque: SVector<f64, 6>,
}

/// How what was seen in the first rows tells the start of the links.
#[derive(Debug, Clone)]
struct Swing {
    rows: Vec<usize>,
    /// Lowest natural frequency of the arm, rad/s.
    lowest: f64,
    /// Variance of the tracker's position, m².
    variance: [f64; 3],
    /// Angles, rad, and rates, rad/s, by which the links start elsewhere, per residual of the
    /// tracker's position at these rows.
    gain: DMatrix<f64>,
}

impl Swing {
    /// What an angle, rad, or a rate, rad/s, may start elsewhere by.
    fn size(&self, k: usize) -> f64 {
        if k < 6 { SWINGS } else { SWINGS * self.lowest }
    }

    /// Slopes over their noise, and the normal equations.
    fn normal(&self, slopes: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let weighted =
            DMatrix::from_fn(slopes.nrows(), 18, |r, k| slopes[(r, k)] / self.variance[r % 3]);
        let normal = slopes.tr_mul(&weighted) + DMatrix::identity(18, 18);
        (weighted, normal)
    }

    /// What residuals tell of the start, by these slopes.
    fn gain(&self, slopes: &DMatrix<f64>) -> Option<DMatrix<f64>> {
        let (weighted, normal) = self.normal(slopes);
        let mut gain = normal.cholesky()?.solve(&weighted.transpose()).rows(0, 12).into_owned();
        (0..12).for_each(|k| gain.row_mut(k).scale_mut(self.size(k)));
        Some(gain)
    }
}

/// Time over which the start of the links is told, periods of the arm's lowest mode, and the rows
/// in it that are looked at.
const SWING_PERIODS: f64 = 1.5;
const SWING_ROWS: usize = 40;

/// What an arm may swing by when a log begins, rad.
const SWINGS: f64 = 1e-3;

/// By how much the sum of squares must fall for an arm to be taken to swing when a log begins: twelve
/// numbers lower it by 12, and by 40 once in ten thousand times.
const STANDS_OUT: f64 = 60.0;

/// Rate by which motors may change while the start is told, rad/s.
const STEADY: f64 = 5e-3;

/// Links in motion.
struct Links {
    swinging: DynamicLinks,
    /// Which of them are afloat in the play of their gears.
    afloat: Option<BacklashObserver>,
    /// Links that are driven with less noise, whose gears tell what is remembered; none where nothing
    /// is.
    even: Option<DynamicLinks>,
}

impl Links {
    fn new(robot: &ElasticRobot, swinging: DynamicLinks, afloat: Option<BacklashObserver>) -> Self {
        let even = (robot.ports.memories() > 0).then_some(swinging);
        Self { swinging, afloat, even }
    }
}

/// A log of links in motion.
#[derive(Debug, Clone)]
pub(super) struct Moving {
    period: f64,
    substeps: usize,
    time: Vec<f64>,
    /// Band that most of the drive was smoothed in, Hz.
    drive_band: f64,
    /// Twist that is within the noise of the encoders, rad.
    margin: JointVector<f64>,
    /// What drives the links.
    drive: Vec<Motors>,
    /// The same with less of the encoders' noise, for what gears remember: each wiggle makes them
    /// forget.
    even: Vec<Motors>,
    /// How the links swing at the first row is fitted, where a ring-down begins after its stop.
    swing: Option<Swing>,
    /// True where motors move at the first row.
    motors_move: bool,
    /// Jerk of the motors at the first row, rad/s³, where a free motion's log begins in motion.
    jerk: Option<JointVector<f64>>,
    /// What the motors did, for their torque: smoothed.
    motor: Vec<Motors>,
    position: Option<Vec<Vector3<f64>>>,
    rotation: Option<Vec<Matrix3<f64>>>,
    link_encoder: [Option<Vec<f64>>; 6],
    torque: [Option<Vec<f64>>; 6],
    band: LowPass,
    /// Filter of poses and second encoders; none where each sample is compared by itself.
    calm: Option<LowPass>,
    pose_rows: Vec<usize>,
    torque_rows: Vec<usize>,
}

impl Moving {
    pub(super) fn new(
        log: &Log,
        noise: &NoiseLevels,
        model: &Model,
        compared: &mut Vec<Compared>,
    ) -> Result<Self, PredictError> {
        let s = &log.samples;
        let n = s.time.len();
        let period = period(log);
        let columns: Vec<Vec<f64>> =
            (0..6).map(|i| s.encoder.iter().map(|q| q[i]).collect()).collect();
        let smoothed = |band: f64| -> Vec<Motors> {
            let smooth = LowPass::new(band.min(0.2 / period), period);
            let series: Vec<[Vec<f64>; 3]> = columns
                .iter()
                .map(|c| [smooth.smooth(0, c), smooth.smooth(1, c), smooth.smooth(2, c)])
                .collect();
            let six = |d: usize, k: usize| JointVector::from_fn(|i, _| series[i][d][k]);
            (0..n)
                .map(|k| Motors { angle: six(0, k), rate: six(1, k), acceleration: six(2, k) })
                .collect()
        };
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        let in_bands: Vec<Bands> = (0..6)
            .map(|i| Bands::of(&DRIVE_BANDS, period, encoder[i].deviation, &columns[i]))
            .collect();
        let agreeing = |within: f64| -> Vec<Vec<Smoothed>> {
            in_bands.iter().map(|bands| bands.in_agreement(within)).collect()
        };
        let driven_by = |columns: &[Vec<Smoothed>]| -> Vec<Motors> {
            (0..n)
                .map(|k| Motors {
                    angle: JointVector::from_fn(|i, _| columns[i][k].value),
                    rate: JointVector::from_fn(|i, _| columns[i][k].rate),
                    acceleration: JointVector::zeros(),
                })
                .collect()
        };
        let closely = agreeing(CLOSELY);
        let mut bands: Vec<usize> =
            closely.iter().flatten().map(|smoothed| smoothed.band).collect();
        bands.sort_unstable();
        let mut drive = driven_by(&closely);
        let mut even = driven_by(&agreeing(NOT_BY_CHANCE));
        // A filter's window has one side only at the ends; where the motors move there, a cubic
        // stands in.
        let mut motor = smoothed(MOTOR_BAND);
        let mut quicker = smoothed(2.0 * MOTOR_BAND);
        let ends: [Option<[Beginning; 6]>; 2] = [false, true].map(|back| {
            let of = |i: usize| {
                let mut column = columns[i].clone();
                if back {
                    column.reverse();
                }
                Beginning::of(period, encoder[i].deviation, &column)
            };
            let all: Vec<Beginning> = (0..6).map_while(of).collect();
            <[Beginning; 6]>::try_from(all).ok().filter(|e| e.iter().any(|b| b.moving))
        });
        let motors_move = ends[0].is_some();
        let ends = ends.map(|end| end.filter(|_| log.kind == LogKind::FreeMotion));
        for (back, end) in ends.iter().enumerate() {
            for (i, beginning) in end.iter().flatten().enumerate() {
                for k in 0..beginning.length / 2 {
                    let sign = if back == 1 { -1.0 } else { 1.0 };
                    let [angle, rate, acceleration] = beginning.after(k as f64 * period);
                    let row = if back == 1 { n - 1 - k } else { k };
                    for series in [&mut drive, &mut even, &mut motor, &mut quicker] {
                        series[row].angle[i] = angle;
                        series[row].rate[i] = sign * rate;
                        series[row].acceleration[i] = acceleration;
                    }
                }
            }
        }
        let jerk = ends[0].map(|all| JointVector::from_fn(|i, _| all[i].derivatives[3]));
        // The links swing on from how they start.
        for i in (0..6).filter(|_| jerk.is_none()) {
            let (angle, rate) = start(period, encoder[i].deviation, &columns[i]);
            for series in [&mut drive, &mut even] {
                (series[0].angle[i], series[0].rate[i]) = (angle, rate);
            }
        }
        let skipped =
            if log.kind == LogKind::RingDown { 0 } else { (END / period).ceil() as usize };
        // A channel with missing values, or one read more seldom, is compared where it was read.
        let whole = s.position.iter().chain(&s.rotation).flatten().all(|v| v.sum().is_finite())
            && s.link_encoder.iter().flatten().flatten().all(|v| v.is_finite());
        let lowest = || {
            let frames = model.robot.frames(&s.encoder[n / 2]);
            model.robot.natural_frequencies(&frames).map(|omega| omega[0] / TAU)
        };
        let calm = (log.kind == LogKind::FreeMotion && whole)
            .then(lowest)
            .flatten()
            .map(|frequency| CALM * frequency)
            .filter(|band| band.is_finite() && *band < 0.2 / period)
            .map(|band| (band, LowPass::new(band, period)))
            .filter(|(_, low)| n > 4 * low.half());
        let (skipped, every) = match &calm {
            Some((band, low)) => {
                (low.half().max(skipped), ((0.4 / (band * period)).floor() as usize).max(1))
            }
            None => (skipped, 1),
        };
        let calm = calm.map(|(_, low)| low);
        let pose_rows: Vec<usize> = (skipped..n.saturating_sub(skipped)).step_by(every).collect();
        let band = LowPass::new(TORQUE_BAND.min(0.2 / period), period);
        let every =
            ((0.5 / (1.25 * TORQUE_BAND.min(0.2 / period) * period)).floor() as usize).max(1);
        // What is smoothed for the torque is one-sided where the motors move at an end.
        let half = LowPass::new(MOTOR_BAND.min(0.2 / period), period).half();
        let [first, last] =
            ends.each_ref().map(|end| band.half() + if end.is_some() { half } else { 0 });
        let torque_rows: Vec<usize> = (first..n.saturating_sub(last)).step_by(every).collect();

        let mut moving = Self {
            period,
            substeps: (period / STEP - 1e-9).ceil().max(1.0) as usize,
            time: s.time.clone(),
            drive,
            even,
            swing: None,
            motors_move,
            jerk,
            motor,
            margin: JointVector::from_fn(|i, _| 3.0 * encoder[i].deviation),
            drive_band: DRIVE_BANDS[bands[bands.len() / 2]],
            position: s.position.clone(),
            rotation: s.rotation.as_ref().map(|r| r.iter().map(rotation_from_vector).collect()),
            link_encoder: s.link_encoder.clone(),
            torque: std::array::from_fn(|i| s.motor_torque[i].as_ref().and_then(|t| filled(t))),
            band,
            calm,
            pose_rows,
            torque_rows,
        };
        moving.compare(log, noise, model, &quicker, compared)?;
        if log.kind == LogKind::RingDown {
            moving.swing = moving.swing(log, noise, model);
        }
        Ok(moving)
    }

    /// Lists what is compared, with its noise, in the order in which [`poses`](Self::poses) and
    /// [`torques`](Self::torques) give it. `quicker`: what the motors did, in a wider band.
    fn compare(
        &self,
        log: &Log,
        noise: &NoiseLevels,
        model: &Model,
        quicker: &[Motors],
        compared: &mut Vec<Compared>,
    ) -> Result<(), PredictError> {
        let n = self.time.len();
        if self.pose_rows.is_empty() {
            return Ok(());
        }
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        let through = self.through(model, &encoder);
        let white = self.calm.as_ref().map_or(1.0, |low| low.gain(0).sqrt());
        let rows = &self.pose_rows;
        if let Some(position) = &self.position {
            let level = known(&noise.position, log, LogChannel::Position)?;
            list(compared, Quantity::Position, rows, 0..3, |k, c| {
                let measured = self.calmed(position.len(), rows[k], |k| position[k][c]);
                let deviation = (level[c].deviation * white).hypot(through.tool[3 + c]);
                (measured, deviation, level[c].stated)
            });
        }
        if let Some(rotation) = &self.rotation {
            let level = known(&noise.rotation, log, LogChannel::Rotation)?;
            let turned = (through.tool.fixed_rows::<3>(0).norm_squared() / 3.0).sqrt();
            list(compared, Quantity::Rotation, rows, 0..3, |k, c| {
                let deviation = (level[c].deviation * white).hypot(turned);
                (none_where_missing(&rotation[rows[k]]), deviation, level[c].stated)
            });
        }
        for i in 0..6 {
            let Some(series) = &self.link_encoder[i] else { continue };
            let level = known(&noise.link_encoder[i..=i], log, LogChannel::LinkEncoder)?[0];
            let deviation = (level.deviation * white).hypot(through.link[i]);
            list(compared, Quantity::LinkEncoder, rows, i..i + 1, |k, _| {
                (self.calmed(series.len(), rows[k], |k| series[k]), deviation, level.stated)
            });
        }
        let rows = &self.torque_rows;
        for i in 0..6 {
            let Some(series) = &self.torque[i] else { continue };
            let level = known(&noise.motor_torque[i..=i], log, LogChannel::MotorTorque)?[0];
            let white = (level.deviation * self.band.gain(0).sqrt()).hypot(through.torque[i]);
            let friction = self.friction_slope(model, i);
            let inexact = self.inexact(model, quicker, i);
            let rate = encoder[i].deviation * self.band.gain(1).sqrt();
            list(compared, Quantity::MotorTorque, rows, i..i + 1, |k, _| {
                let banded = |series: &[f64]| self.band.at(0, |k| series[k], n, rows[k]);
                // Where a joint turns round, friction makes torque of the noise in its rate.
                let deviation = white.hypot(rate * banded(&friction)).hypot(banded(&inexact));
                (banded(series), deviation, level.stated)
            });
        }
        Ok(())
    }

    /// A series at one row, in the band it is compared in.
    fn calmed(&self, length: usize, row: usize, series: impl Fn(usize) -> f64) -> f64 {
        self.calm.as_ref().map_or_else(|| series(row), |low| low.at(0, &series, length, row))
    }

    /// Error that smoothing the motors' motion leaves in their torque, N·m: by how much it changes
    /// with the band.
    fn inexact(&self, model: &Model, quicker: &[Motors], i: usize) -> Vec<f64> {
        let friction = &model.robot.parameters().friction;
        let torque = |m: &Motors| {
            model.robot.rotor_inertia()[i] * m.acceleration[i] + friction.torque(i, m.rate[i]).0
        };
        self.motor.iter().zip(quicker).map(|(m, q)| torque(m) - torque(q)).collect()
    }

    /// Slope of the model's friction by the rate at every row, N·m·s/rad.
    fn friction_slope(&self, model: &Model, i: usize) -> Vec<f64> {
        let friction = &model.robot.parameters().friction;
        self.motor.iter().map(|m| friction.torque(i, m.rate[i]).1).collect()
    }

    /// What the encoders' noise n becomes on its way through the arm, at its mean posture: M θ̈ + D
    /// θ̇ + K θ = K n + D ṅ on the links, Γ = I_m n̈ + K (n − θ) + D (ṅ − θ̇) at the motors. A
    /// lightly damped mode makes several times the noise of it.
    fn through(&self, model: &Model, encoder: &[Level]) -> Through {
        let mut sum =
            (SVector::<f64, 6>::zeros(), SVector::<f64, 6>::zeros(), SVector::<f64, 6>::zeros());
        let drive = LowPass::new(self.drive_band.min(0.2 / self.period), self.period);
        for posture in 0..POSTURES {
            let k = (2 * posture + 1) * (self.drive.len() - 1) / (2 * POSTURES);
            let frames = model.robot.frames(&self.drive[k].angle);
            let jacobian = frames.jacobian().0.map(|x| Complex::new(x, 0.0));
            let top = 0.5 / self.period;
            let step = LINE.min(top / 50.0);
            let mut frequency = 0.5 * step;
            while frequency < top.min(HIGHEST) {
                let w = TAU * frequency;
                let spring =
                    SMatrix::<Complex<f64>, 6, 6>::from_diagonal(&model.robot.dynamic_stiffness(w));
                let pass = drive.response(frequency, self.period);
                if let Some(inverse) = model.robot.dynamic_compliance(&frames, w) {
                    // One-sided density of white noise: 2 σ²/f_s; a step of the grid takes its
                    // share.
                    let density =
                        (2.0 * self.period * step).sqrt() * pass / (POSTURES as f64).sqrt();
                    let noise =
                        SMatrix::<Complex<f64>, 6, 6>::from_diagonal(&SVector::from_fn(|i, _| {
                            Complex::new(encoder[i].deviation * density, 0.0)
                        }));
                    let calm =
                        self.calm.as_ref().map_or(1.0, |low| low.response(frequency, self.period));
                    let link = inverse * spring * noise;
                    let tool = jacobian * link;
                    let band = Complex::new(self.band.response(frequency, self.period), 0.0);
                    let rotor =
                        SMatrix::<Complex<f64>, 6, 6>::from_diagonal(&SVector::from_fn(|i, _| {
                            Complex::new(-w * w * model.robot.rotor_inertia()[i], 0.0)
                        }));
                    let motor = noise / Complex::new(pass.max(1e-3), 0.0);
                    let torque = (rotor * motor + spring * (noise - link)) * band;
                    for i in 0..6 {
                        let power = |m: &SMatrix<Complex<f64>, 6, 6>| {
                            m.row(i).iter().map(|z| z.norm_sqr()).sum::<f64>()
                        };
                        sum.0[i] += power(&link) * calm * calm;
                        sum.1[i] += power(&tool) * calm * calm;
                        sum.2[i] += power(&torque);
                    }
                }
                frequency += step;
            }
        }
        Through {
            link: sum.0.map(f64::sqrt),
            tool: sum.1.map(f64::sqrt),
            torque: sum.2.map(f64::sqrt),
        }
    }

    /// How the start of the links is told; `None` where the arm does not swing when the log begins.
    fn swing(&self, log: &Log, noise: &NoiseLevels, model: &Model) -> Option<Swing> {
        let position = self.position.as_ref()?;
        let level = known(&noise.position, log, LogChannel::Position).ok()?;
        let frames = model.robot.frames(&self.drive[0].angle);
        let lowest = model.robot.natural_frequencies(&frames)?[0];
        let length = (SWING_PERIODS * TAU / lowest / self.period) as usize;
        let rate = self.drive[0].rate;
        let steady = self.drive.iter().take_while(|m| (m.rate - rate).amax() < STEADY).count();
        let length = length.min(steady).min(self.drive.len());
        let every = length.div_ceil(SWING_ROWS).max(1);
        let seen = |row: &usize| position[*row].sum().is_finite();
        let rows: Vec<usize> = (0..length).step_by(every).filter(seen).collect();
        if rows.len() < SWING_ROWS / 4 {
            return None;
        }
        let robot = ElasticRobot::with_effects(&model.robot, &[], None).ok()?;
        let variance = [0, 1, 2].map(|c| level[c].deviation.powi(2));
        let mut swing = Swing { rows, lowest, variance, gain: DMatrix::zeros(0, 0) };
        let (slopes, plain) = self.swing_slopes(&robot, &swing, &[0.0; INTERNAL_STATES])?;
        let (weighted, normal) = swing.normal(&slopes);
        let right = weighted.tr_mul(&plain);
        let explained = |from: usize| {
            let size = 18 - from;
            let normal = normal.view((from, from), (size, size)).into_owned();
            let right = right.rows(from, size).into_owned();
            Some(right.dot(&normal.cholesky()?.solve(&right)))
        };
        if explained(0)? - explained(12)? < STANDS_OUT {
            return None;
        }
        swing.gain = swing.gain(&slopes)?;
        Some(swing)
    }

    /// By how much the residuals of the first rows fall with the links starting elsewhere, a column
    /// for each of their angles and rates, then for where the tracker stands, and how it drifts; and
    /// these residuals.
    fn swing_slopes(
        &self,
        robot: &ElasticRobot,
        swing: &Swing,
        memory: &Memory,
    ) -> Option<(DMatrix<f64>, DVector<f64>)> {
        let still = SVector::<f64, 12>::zeros();
        let begin = |elsewhere: &_| Links::new(robot, self.start(robot, memory, elsewhere), None);
        let plain = self.first_residual(robot, &swing.rows, begin(&still))?;
        let mut columns = DMatrix::<f64>::zeros(plain.len(), 18);
        for k in 0..12 {
            let mut start = still;
            start[k] = 0.1 * swing.size(k);
            let moved = self.first_residual(robot, &swing.rows, begin(&start))?;
            columns.set_column(k, &((&plain - moved) / 0.1));
        }
        let count = swing.rows.len();
        for r in 0..count {
            for c in 0..3 {
                columns[(3 * r + c, 12 + c)] = 1e-2;
                columns[(3 * r + c, 15 + c)] = 1e-2 * (r as f64 / count as f64 - 0.5);
            }
        }
        Some((columns, plain))
    }

    /// Measured less predicted position of the tool at the first rows, m, with the links starting
    /// so.
    fn first_residual(
        &self,
        robot: &ElasticRobot,
        rows: &[usize],
        start: Links,
    ) -> Option<DVector<f64>> {
        let mut links = start;
        let mut left = Vec::with_capacity(3 * rows.len());
        let mut at = 0;
        for &row in rows {
            while at <= row {
                self.advance(robot, &mut links, at).ok()?;
                at += 1;
            }
            left.extend(self.seen(robot, &links.swinging.drives().link, row).tool.iter());
        }
        Some(DVector::from_vec(left))
    }

    /// Takes the links from the row before to this one; those afloat to where they were seen.
    fn advance(&self, robot: &ElasticRobot, links: &mut Links, row: usize) -> Result<(), Diverged> {
        if row > 0 {
            let time = row as f64 * self.period + self.time[0];
            links.swinging.advance(robot, &self.drive[row], time, self.substeps)?;
            if let Some(even) = &mut links.even {
                even.advance(robot, &self.even[row], time, self.substeps)?;
                links.swinging.remember(&even.memory());
            }
        }
        if let Some(afloat) = &mut links.afloat {
            let link = links.swinging.drives().link;
            let seen = self.seen(robot, &link, row);
            let moved = afloat.moved(robot, &self.drive[row].angle, &link, &seen);
            for links in [&mut links.swinging].into_iter().chain(&mut links.even) {
                links.displace(&moved.by, &moved.rate);
            }
        }
        Ok(())
    }

    /// The links at the first row, elsewhere by so much than the motors' motion asks for.
    fn start(
        &self,
        robot: &ElasticRobot,
        memory: &Memory,
        elsewhere: &SVector<f64, 12>,
    ) -> DynamicLinks {
        let (first, time) = (&self.drive[0], self.time[0]);
        let mut swinging = match &self.jerk {
            Some(jerk) => DynamicLinks::start_in_motion(robot, first, jerk, memory, time),
            None => DynamicLinks::start_remembering(robot, first, memory, time),
        };
        let part = |from: usize| elsewhere.fixed_rows::<6>(from).into_owned();
        swinging.displace(&part(0), &part(6));
        swinging
    }

    /// True where motors move at the first row, or links swing.
    pub(super) fn begins_in_motion(&self) -> bool {
        self.motors_move || self.swing.is_some()
    }

    /// Where the motors were at every instant.
    pub(super) fn motors(&self) -> &[Motors] {
        &self.drive
    }

    /// What the links do: see [`Experiment::follow`](super::Experiment).
    pub(super) fn motion(
        &self,
        robot: &ElasticRobot,
        memory: &Memory,
        known: Option<&Arc<DMatrix<f64>>>,
        before: Option<&Motion>,
    ) -> Result<Motion, Diverged> {
        let n = self.drive.len();
        /// The slopes are taken once; a few rounds bring the start to where the model has it.
        const ROUNDS: usize = 3;
        let afloat = BacklashObserver::new(robot, self.margin, self.period);
        let mut elsewhere = SVector::<f64, 12>::zeros();
        let mut gain = None;
        if let Some(swing) = &self.swing {
            // A gear that remembers is another spring: its slopes are its own, and taken once.
            let own = || swing.gain(&self.swing_slopes(robot, swing, memory)?.0).map(Arc::new);
            gain = match known {
                Some(known) => Some(known.clone()),
                None if robot.ports.memories() > 0 => own(),
                None => None,
            };
            for _ in 0..ROUNDS {
                let start = self.start(robot, memory, &elsewhere);
                let start = Links::new(robot, start, afloat.clone());
                let Some(left) = self.first_residual(robot, &swing.rows, start) else { break };
                let by = gain.as_deref().unwrap_or(&swing.gain) * left;
                elsewhere += SVector::<f64, 12>::from_column_slice(by.as_slice());
            }
        }
        let mut motion = Motion { swing: gain, ..Motion::new(n, afloat.is_some()) };
        let mut links = Links::new(robot, self.start(robot, memory, &elsewhere), afloat);
        for k in 0..n {
            self.advance(robot, &mut links, k)?;
            let swinging = &links.swinging;
            motion.link.push(swinging.drives().link);
            motion.spring.push(swinging.spring(robot));
            if robot.ports.frames_give() {
                motion.tool.push(swinging.frames(robot, self.time[k] - self.time[0]).tcp);
            }
            if robot.ports.memories() > 0 {
                motion.memory.push(swinging.memory());
            }
            if let Some(before) = before.filter(|before| motion.joins(before)) {
                motion.go_on(before);
                break;
            }
        }
        Ok(motion)
    }

    /// Where tool and links were seen at a row, less where links at `link` put them.
    fn seen(&self, robot: &ElasticRobot, link: &JointVector<f64>, row: usize) -> Observed {
        let time = self.time[row] - self.time[0];
        let tool = self.position.as_ref().map_or(Vector3::repeat(f64::NAN), |position| {
            position[row]
                - seen(&robot.ports, &robot.frames(link, &Wrench::zero(), time).tcp, time).position
        });
        let link = std::array::from_fn(|i| self.link_left(robot, i, link[i], row));
        // Turned it hardly goes in a gap while motors move; to follow that would be to follow noise.
        Observed { tool, turn: Vector3::repeat(f64::NAN), lever: 0.0, deviation: 0.0, link }
    }

    /// What a joint's second encoder read at a row, less what it would with its link at `link`; NaN
    /// where there is none.
    fn link_left(&self, robot: &ElasticRobot, i: usize, link: f64, row: usize) -> f64 {
        let Some(series) = &self.link_encoder[i] else {
            return f64::NAN;
        };
        let mut truth = unread(self.time[row] - self.time[0]);
        truth.link_encoder[i] = link;
        series[row] - sensed(&robot.ports, Channel::LinkEncoder, truth).link_encoder[i]
    }

    /// Measured less predicted of tracker and second encoders, in engineering units.
    pub(super) fn poses(&self, robot: &ElasticRobot, motion: &Motion, residual: &mut Vec<f64>) {
        let begin = self.time[0];
        let lag = |channel| robot.ports.delay(channel) / self.period;
        let late = |row: usize, lag: f64| {
            if lag == 0.0 { motion.link[row] } else { interpolate(&motion.link, row as f64 - lag) }
        };
        if self.position.is_some() || self.rotation.is_some() {
            let tracker_lag = lag(Channel::Tracker);
            let pose = |row: &usize| {
                let time = self.time[*row] - begin;
                let tool = match motion.tool.as_slice() {
                    [] => robot.model.frames(&late(*row, tracker_lag)).tcp,
                    tools => between(tools, *row as f64 - tracker_lag),
                };
                seen(&robot.ports, &tool, time)
            };
            // Every row that a window reaches, or only those compared.
            let rows: Vec<usize> = if self.calm.is_some() {
                (0..motion.link.len()).collect()
            } else {
                self.pose_rows.clone()
            };
            let poses: Vec<Pose<f64>> = rows.iter().map(pose).collect();
            let mut extend = |left: Vec<Vector3<f64>>| match &self.calm {
                Some(_) => residual.extend(self.pose_rows.iter().flat_map(|&row| {
                    let left = &left;
                    (0..3).map(move |c| self.calmed(left.len(), row, |k| left[k][c]))
                })),
                None => residual.extend(left.iter().flat_map(|v| v.iter().copied())),
            };
            if let Some(measured) = &self.position {
                extend(
                    rows.iter()
                        .zip(&poses)
                        .map(|(row, pose)| measured[*row] - pose.position)
                        .collect(),
                );
            }
            if let Some(measured) = &self.rotation {
                let left = |(row, pose): (&usize, &Pose<f64>)| {
                    rotation_vector(&pose.rotation.tr_mul(&measured[*row]))
                };
                extend(rows.iter().zip(&poses).map(left).collect());
            }
        }
        let link_lag = lag(Channel::LinkEncoder);
        for (i, series) in self.link_encoder.iter().enumerate() {
            let Some(series) = series else { continue };
            let left = |row: usize| self.link_left(robot, i, late(row, link_lag)[i], row);
            match &self.calm {
                Some(_) => {
                    let all: Vec<f64> = (0..series.len()).map(left).collect();
                    residual.extend(
                        self.pose_rows.iter().map(|&row| self.calmed(all.len(), row, |k| all[k])),
                    );
                }
                None => residual.extend(self.pose_rows.iter().map(|&row| left(row))),
            }
        }
    }

    /// Measured less predicted of motor torque, N·m.
    pub(super) fn torques(&self, robot: &ElasticRobot, motion: &Motion, residual: &mut Vec<f64>) {
        let torque_lag = robot.ports.delay(Channel::MotorTorque) / self.period;
        let begin = self.time[0];
        for (i, series) in self.torque.iter().enumerate() {
            let Some(series) = series else { continue };
            let mut predicted: Vec<f64> = (0..self.motor.len())
                .map(|k| {
                    let m = &self.motor[k];
                    let drives = Drives {
                        link: motion.link[k],
                        link_rate: m.rate,
                        motor: m.angle,
                        motor_rate: m.rate,
                    };
                    robot.model.rotor_inertia()[i] * m.acceleration[i]
                        + motion.spring[k][i]
                        + robot
                            .friction(&drives, i, motion.spring[k][i], self.time[k] - begin)
                            .value
                })
                .collect();
            if torque_lag != 0.0 {
                predicted = (0..predicted.len())
                    .map(|k| interpolate(&predicted, k as f64 - torque_lag))
                    .collect();
            }
            if robot.ports.senses(Channel::MotorTorque) {
                for (k, predicted) in predicted.iter_mut().enumerate() {
                    let mut readings = Readings {
                        encoder: self.motor[k].angle.into(),
                        ..unread(self.time[k] - begin)
                    };
                    readings.motor_torque[i] = *predicted;
                    *predicted =
                        sensed(&robot.ports, Channel::MotorTorque, readings).motor_torque[i];
                }
            }
            for &row in &self.torque_rows {
                residual.push(self.band.at(0, |k| series[k] - predicted[k], series.len(), row));
            }
        }
    }
}

/// A pose at a fractional sample position, straight between its neighbours; the ends are held.
fn between(poses: &[Pose<f64>], position: f64) -> Pose<f64> {
    let position = position.clamp(0.0, (poses.len() - 1) as f64);
    let (k, share) = (position.floor() as usize, position.fract());
    let (before, after) = (&poses[k], &poses[(k + 1).min(poses.len() - 1)]);
    let turned = rotation_vector(&before.rotation.tr_mul(&after.rotation)) * share;
    Pose {
        position: before.position.lerp(&after.position, share),
        rotation: before.rotation * rotation_from_vector(&turned),
    }
}
