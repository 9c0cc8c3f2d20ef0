//! What is compared of links in motion, and the noise of it: the instruments' own, and what the
//! encoders' noise becomes on its way through the arm.

use super::super::columns::{Dropouts, filled, filled_vectors, rows_a_reading, rows_a_vector};
use super::super::compared::{list, none_where_missing};
use super::super::{BaselineModel, Compared, ComparedQuantity, PredictError, known};
use super::{DRIVE_BANDS, DynamicPrediction, MOTOR_BAND};
use nalgebra::{Complex, SMatrix, SVector};
use std::f64::consts::TAU;
use trueweld_core::JointVector;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::fir::{LowPass, finer};
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::{NoiseLevel, NoiseLevels};
use trueweld_plant::integrate::link_dynamics::Motors;
use trueweld_plant::robot::{ElasticRobot, INTERNAL_STATES};

/// Postures along a log at which the noise's way through the arm is worked out, the grid of
/// frequencies for it, Hz (a mode of 10 Hz with 3 % damping is 0.6 Hz wide), and the highest that
/// matters.
const NOISE_POSTURES: usize = 5;
const FREQUENCY_STEP: f64 = 0.1;
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

/// Share of the error of a spline through every other row that one through all rows has: it grows with
/// the third power of the time between them where jerk jumps, as in motions that were planned, and with
/// the second where acceleration does, as under a brake.
const PLANNED: f64 = 1.0 / 8.0;
const BRAKED: f64 = 1.0 / 4.0;

/// What rows that are far apart do not tell of the motors' motion, as it reaches what is predicted: an
/// estimate of its size at each row, in its shape.
#[derive(Default)]
struct Untold {
    /// Link angles, rad.
    link: Vec<JointVector<f64>>,
    /// Motor torque, N·m.
    torque: Vec<JointVector<f64>>,
}

impl DynamicPrediction {
    /// Lists what is compared, with its noise, in the order in which [`poses`](Self::poses) and
    /// [`torques`](Self::torques) give it. `otherwise`: what the motors did, in another band.
    pub(super) fn compare(
        &self,
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        otherwise: &[Motors],
        compared: &mut Vec<Compared>,
    ) -> Result<(), PredictError> {
        let n = self.time.len();
        if self.pose_rows.is_empty() {
            return Ok(());
        }
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        let through = self.through(model, &encoder);
        let untold = self.untold(model, log).unwrap_or_default();
        let untold_link = |row: usize, i: usize| match untold.link.as_slice() {
            [] => 0.0,
            link => self.calmed(link.len(), row, |k| link[k][i]),
        };
        let untold_tool = |row: usize| {
            let moved = JointVector::from_fn(|i, _| untold_link(row, i));
            match moved.amax() > 0.0 {
                true => model.robot.frames(&log.samples.encoder[row]).jacobian().0 * moved,
                false => moved,
            }
        };
        let untold_tool: Vec<_> = self.pose_rows.iter().map(|row| untold_tool(*row)).collect();
        let white = self.calm.as_ref().map_or(1.0, |low| low.gain(0).sqrt());
        // What is compared row by row is as noisy as a reading.
        let seldom = |series| self.calm.as_ref().map_or(1.0, |low| rows_a_vector(series, low));
        let rows = &self.pose_rows;
        if let Some(position) = &self.position {
            let level = known(&noise.position, log, LogChannel::Position)?;
            let white = white * seldom(&log.samples.position).sqrt();
            let bridged = filled_vectors(&self.position).filter(|_| self.calm.is_some());
            list(compared, ComparedQuantity::Position, rows, 0..3, |k, c| {
                let read = |k: usize| bridged.as_ref().map_or(position[k][c], |all| all[c][k]);
                let measured = self.calmed(position.len(), rows[k], read);
                let own = (level[c].deviation * white).hypot(through.tool[3 + c]);
                let deviation = own.hypot(untold_tool[k][3 + c]);
                (measured, deviation, level[c].stated)
            });
        }
        if let Some(rotation) = &self.rotation {
            let level = known(&noise.rotation, log, LogChannel::Rotation)?;
            let white = white * seldom(&log.samples.rotation).sqrt();
            let turned = (through.tool.fixed_rows::<3>(0).norm_squared() / 3.0).sqrt();
            list(compared, ComparedQuantity::Rotation, rows, 0..3, |k, c| {
                let own = (level[c].deviation * white).hypot(turned);
                let deviation = own.hypot(untold_tool[k][c]);
                let is_bridged = self.calm.is_some();
                let measured =
                    if is_bridged { 0.0 } else { none_where_missing(&rotation[rows[k]]) };
                (measured, deviation, level[c].stated)
            });
        }
        for i in 0..6 {
            let Some(series) = &self.link_encoder[i] else { continue };
            let level = known(&noise.link_encoder[i..=i], log, LogChannel::LinkEncoder)?[0];
            let read = series.iter().map(|v| v.is_finite());
            let seldom = self.calm.as_ref().map_or(1.0, |low| rows_a_reading(read, low));
            let own = (level.deviation * white * seldom.sqrt()).hypot(through.link[i]);
            let bridged = filled(series).filter(|_| self.calm.is_some());
            let read = bridged.as_ref().unwrap_or(series);
            list(compared, ComparedQuantity::LinkEncoder, rows, i..i + 1, |k, _| {
                let deviation = own.hypot(untold_link(rows[k], i));
                (self.calmed(read.len(), rows[k], |k| read[k]), deviation, level.stated)
            });
        }
        let rows = &self.torque_rows;
        for i in 0..6 {
            let Some(series) = &self.torque[i] else { continue };
            let Some(whole) = filled(series) else { continue };
            let dropouts = Dropouts::of(series, &self.band);
            let level = known(&noise.motor_torque[i..=i], log, LogChannel::MotorTorque)?[0];
            let seldom = rows_a_reading(series.iter().map(|v| v.is_finite()), &self.band);
            let own = level.deviation * (self.band.gain(0) * seldom).sqrt();
            let white = own.hypot(through.torque[i]);
            let friction = self.friction_slope(model, i);
            let inexact = self.inexact(model, otherwise, i);
            let untold: Vec<f64> = match untold.torque.as_slice() {
                [] => vec![0.0; n],
                torque => torque.iter().map(|t| t[i]).collect(),
            };
            let rate = encoder[i].deviation * self.band.gain(1).sqrt();
            list(compared, ComparedQuantity::MotorTorque, rows, i..i + 1, |k, _| {
                let banded = |series: &[f64]| self.band.at(0, |k| series[k], n, rows[k]);
                // Where a joint turns round, friction makes torque of the noise in its rate.
                let inexact = banded(&inexact).hypot(banded(&untold));
                let deviation = white.hypot(rate * banded(&friction)).hypot(inexact);
                let dropped = dropouts.within(self.band.half(), rows[k]);
                let measured = if dropped { f64::NAN } else { banded(&whole) };
                (measured, deviation, level.stated)
            });
        }
        Ok(())
    }

    /// Error that smoothing the motors' motion leaves in their torque, N·m: by how much it changes
    /// with the band.
    fn inexact(&self, model: &BaselineModel, otherwise: &[Motors], i: usize) -> Vec<f64> {
        let friction = &model.robot.parameters().friction;
        let torque = |m: &Motors| {
            model.robot.rotor_inertia()[i] * m.acceleration[i] + friction.torque(i, m.rate[i]).0
        };
        self.motor.iter().zip(otherwise).map(|(m, o)| torque(m) - torque(o)).collect()
    }

    /// What the rows do not tell: what the arm does otherwise where a spline through every other row
    /// drives it. `None` where rows are as near as what drives the links, or the arm cannot be driven.
    fn untold(&self, model: &BaselineModel, log: &Log) -> Option<Untold> {
        if self.parts == 1 {
            return None;
        }
        let n = self.time.len();
        let robot = ElasticRobot::with_effects(&model.robot, &[], None).ok()?;
        let substeps = self.substeps(&robot).ok()?;
        let driven = |every: usize| self.driven(model, log, &robot, substeps, every);
        let share = if log.kind == LogKind::RingDown { BRAKED } else { PLANNED };
        // Friction turns round at once: not by a share, but in a share of the rows.
        let apart = driven(1)?.into_iter().zip(driven(2)?).map(|(all, half)| {
            let [link, torque, rubbed] = [0, 1, 2].map(|what: usize| all[what] - half[what]);
            (link * share, torque * share + rubbed * share.sqrt())
        });
        let (mut link, mut torque): (Vec<_>, Vec<_>) = apart.unzip();
        link.resize(n, JointVector::zeros());
        torque.resize(n, JointVector::zeros());
        Some(Untold { link, torque })
    }

    /// What an arm does at its rows where a spline through every so many of them drives it: link
    /// angles, rad, torque of springs and inertia, and torque of friction, N·m. `None` where it
    /// cannot be driven.
    fn driven(
        &self,
        model: &BaselineModel,
        log: &Log,
        robot: &ElasticRobot,
        substeps: usize,
        every: usize,
    ) -> Option<Vec<[JointVector<f64>; 3]>> {
        let part = self.part();
        let drive = LowPass::new(DRIVE_BANDS[0].min(0.2 / part), part);
        let motor = LowPass::new(MOTOR_BAND, part);
        let friction = &model.robot.parameters().friction;
        let columns: [[Vec<f64>; 4]; 6] = std::array::from_fn(|i| {
            let rows: Vec<f64> = log.samples.encoder.iter().step_by(every).map(|q| q[i]).collect();
            let fine = finer(&rows, every * self.parts);
            let [angle, rate] = [0, 1].map(|d| drive.smooth(d, &fine));
            let [motor_rate, acceleration] = [1, 2].map(|d| motor.smooth(d, &fine));
            [angle, rate, motor_rate, acceleration]
        });
        let six = |d: usize, k: usize| JointVector::from_fn(|i, _| columns[i][d][k]);
        let mut links = self.start(robot, &[0.0; INTERNAL_STATES], &SVector::zeros());
        let mut rows = Vec::with_capacity(self.time.len());
        for state in 0..columns[0][0].len() {
            let motors = Motors {
                angle: six(0, state),
                rate: six(1, state),
                acceleration: JointVector::zeros(),
            };
            if state > 0 {
                let time = state as f64 * part + self.time[0];
                links.advance(robot, &motors, time, substeps).ok()?;
            }
            if state.is_multiple_of(self.parts) {
                let rate = six(2, state);
                let inertia = model.robot.rotor_inertia().component_mul(&six(3, state));
                let rubbed = JointVector::from_fn(|i, _| friction.torque(i, rate[i]).0);
                rows.push([links.drives().link, links.spring(robot) + inertia, rubbed]);
            }
        }
        Some(rows)
    }

    /// Slope of the model's friction by the rate at every row, N·m·s/rad.
    fn friction_slope(&self, model: &BaselineModel, i: usize) -> Vec<f64> {
        let friction = &model.robot.parameters().friction;
        self.motor.iter().map(|m| friction.torque(i, m.rate[i]).1).collect()
    }

    /// What the encoders' noise n becomes on its way through the arm, at its mean posture: M θ̈ + D
    /// θ̇ + K θ = K n + D ṅ on the links, Γ = I_m n̈ + K (n − θ) + D (ṅ − θ̇) at the motors. A
    /// lightly damped mode makes several times the noise of it.
    fn through(&self, model: &BaselineModel, encoder: &[NoiseLevel]) -> Through {
        let mut sum =
            (SVector::<f64, 6>::zeros(), SVector::<f64, 6>::zeros(), SVector::<f64, 6>::zeros());
        let part = self.part();
        let drive = LowPass::new(self.drive_band.min(0.2 / part), part);
        for posture in 0..NOISE_POSTURES {
            let k = (2 * posture + 1) * (self.drive.len() - 1) / (2 * NOISE_POSTURES);
            let frames = model.robot.frames(&self.drive[k].angle);
            let jacobian = frames.jacobian().0.map(|x| Complex::new(x, 0.0));
            let top = 0.5 / self.period;
            let step = FREQUENCY_STEP.min(top / 50.0);
            let mut frequency = 0.5 * step;
            while frequency < top.min(HIGHEST) {
                let w = TAU * frequency;
                let spring =
                    SMatrix::<Complex<f64>, 6, 6>::from_diagonal(&model.robot.dynamic_stiffness(w));
                let pass = drive.response(frequency, part);
                if let Some(inverse) = model.robot.dynamic_compliance(&frames, w) {
                    // One-sided density of white noise: 2 σ²/f_s; a step of the grid takes its
                    // share.
                    let density =
                        (2.0 * self.period * step).sqrt() * pass / (NOISE_POSTURES as f64).sqrt();
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
}
