//! The force of a weld: the process under the tool, where the tracker saw the tool.
//!
//! The contact turns the tracker's noise into hundreds of newtons, so the tool's motion is taken
//! from it slowly only. Forces in the plane are in proportion to the depth force, which the sensor
//! knows far better than the depth gives it: they are predicted for the depth force that was
//! measured.
//!
//! At the spindle's orders the tool gives way to its own ripple by micrometres, which no tracker
//! sees and which take away most of the force. There the arm's dynamic compliance closes the loop.
//! With θₙ the encoders' amplitude at order n, and Z = k + iωb of the contact, in W:
//!
//! ```text
//! δx = G θₙ + C δF,   δF = Fₙ − Z δx   →   (1 + Z C) δF = Fₙ − Z G θₙ
//! H = (K + iωD − ω²M)⁻¹,   G = J H (K + iωD),   C = J H Jᵀ
//! ```

use super::{
    Compared, Model, PredictError, Quantity, filled, filled_vectors, known, mean_abs, period,
    pose_behind, spindle_angle, wrench_behind,
};
use crate::data::channel::LogChannel;
use crate::data::fir::{LowPass, interpolate};
use crate::data::log::Log;
use crate::data::noise::{Level, NoiseLevels};
use nalgebra::{Complex, Matrix3, Matrix3x6, Matrix6, SVector, Vector3};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JointVector, Pose, Wrench};
use trueweld_plant::input::Process;
use trueweld_plant::process::{Reaction, reaction};
use trueweld_plant::robot::{Channel, ElasticRobot, Ports};
use trueweld_plant::simulate::Seam;

/// Band of the slow force, Hz, and its largest share of the spindle's frequency.
const BAND: f64 = 1.2;
const SPINDLE_SHARE: f64 = 0.2;

/// What the predicted slow force is exact to, as a share of the push: the ripple's mean effect is
/// taken to second order.
const EXACT: f64 = 2e-4;

/// Orders of the spindle at which the force is compared, as far as the sampling tells them apart.
const ORDERS: usize = 6;

/// How far apart two lines must lie for the filter to tell them apart, in widths of its band.
const APART: f64 = 2.0;

/// Push that counts as firm contact, in deviations of the predicted depth force.
const FIRM: f64 = 4.0;

/// Share to which the arm's compliance at the spindle's orders is known: its effects change it, and
/// its motors.
const COMPLIANCE_KNOWN: f64 = 0.5;

/// Depth force from which on there is contact to speak of, as a share of the process' reference
/// force.
const CONTACT: f64 = 0.03;

/// A weld with tracker and wrench.
#[derive(Debug, Clone)]
pub(super) struct Contact {
    process: Process,
    seam: Seam,
    period: f64,
    /// Spindle angle at every row, rad.
    angle: Vec<f64>,
    /// Twice the cosine and the sine of its multiples.
    waves: Vec<[Vec<f64>; 2]>,
    encoder: Vec<JointVector<f64>>,
    /// Tracker, all rows.
    position: [Vec<f64>; 3],
    rotation: Vec<Matrix3<f64>>,
    force: Vec<Vector3<f64>>,
    moment: Option<[Vec<f64>; 3]>,
    low: LowPass,
    rows: Vec<usize>,
    /// Motion of the tool as the tracker tells it without a delay or a term of its own.
    motion: Vec<Tool>,
    /// How the tool shakes at the spindle's orders on top of that: position and velocity at every
    /// row, in W.
    shake: Vec<[Vector3<f64>; 2]>,
    /// What the arm makes of the ripple, for every compared row and order.
    loops: Vec<[Closed; ORDERS]>,
    /// Orders whose lines, folded by the sampling where they lie beyond half its rate, fall on no
    /// lower one.
    orders: Vec<usize>,
    /// How far beside a line, in orders, the filter lets nothing of it through.
    aside: f64,
    /// What was measured at these orders, as it is compared.
    lines: Vec<f64>,
}

/// (1 + Z C)⁻¹ at one row and order, and what of the force comes with the motors' own motion.
#[derive(Debug, Clone, Copy)]
struct Closed {
    pass: Matrix3<Complex<f64>>,
    driven: Vector3<Complex<f64>>,
    /// δx per δF.
    compliance: Matrix3<Complex<f64>>,
    /// What the motors move, the contact against them.
    moved: Vector3<Complex<f64>>,
    /// Size of the nominal ripple's force, N.
    line: Vector3<f64>,
}

/// What shakes at one angular frequency, in W.
struct Shaken {
    /// The tool's motion per motor's motion.
    carried: Matrix3x6<Complex<f64>>,
    /// The same per force.
    compliance: Matrix3<Complex<f64>>,
    /// The material's force against it per motion.
    contact: Matrix3<Complex<f64>>,
    /// (1 + Z C)⁻¹.
    pass: Matrix3<Complex<f64>>,
}

/// The tool at one row: TCP and velocity in W, and the channel behind it.
#[derive(Debug, Clone, Copy)]
struct Tool {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    channel: f64,
}

/// Orders of a spindle that turns so many times from one sample to the next whose lines lie at
/// least `apart`, as a share of the sampling rate, from every lower one's, from what is slow and
/// from their own mirror image.
fn alone(turning: f64, apart: f64) -> Vec<usize> {
    let folded = |orders: usize| {
        let turns = orders as f64 * turning;
        (turns - turns.round()).abs()
    };
    // From -n to n - 1.
    (1..=ORDERS).filter(|n| (1..=2 * n).all(|away| folded(away) >= apart)).collect()
}

impl Contact {
    pub(super) fn new(
        log: &Log,
        noise: &NoiseLevels,
        model: &Model,
        compared: &mut Vec<Compared>,
    ) -> Result<Option<Self>, PredictError> {
        let s = &log.samples;
        let n = s.time.len();
        let (Some(force), Some(position)) = (filled_vectors(&s.force), filled_vectors(&s.position))
        else {
            return Ok(None);
        };
        let Some(weld) = &log.weld else {
            return Ok(None);
        };
        let named = model.process.as_ref().or(log.process.as_ref());
        let mut process =
            named.ok_or_else(|| PredictError::NoProcess { log: log.name.clone() })?.clone();
        let spindle =
            s.spindle.as_ref().and_then(|v| filled(v)).unwrap_or_else(|| vec![process.spindle; n]);
        process.spindle = spindle.iter().sum::<f64>() / n as f64;
        let period = period(log);
        let angle = spindle_angle(log)
            .unwrap_or_else(|| (0..n).map(|k| process.spindle * k as f64 * period).collect());
        let turning = mean_abs(&spindle) / std::f64::consts::TAU;
        let band = BAND.min(SPINDLE_SHARE * turning).min(0.2 / period);
        if band.is_nan() || band <= 0.0 {
            return Ok(None);
        }
        let low = LowPass::new(band, period);
        if n < 2 * low.half() + 2 {
            return Ok(None);
        }
        let every = ((0.4 / (band * period)).floor() as usize).max(1);
        let rows: Vec<usize> = (low.half()..n - low.half()).step_by(every).collect();
        // The sensor's axes: the tool's, which turns slowly. Without a tracked rotation, as the
        // encoders have it.
        let rotation: Vec<Matrix3<f64>> = match filled_vectors(&s.rotation) {
            Some(r) => {
                let all: Vec<Matrix3<f64>> = (0..n)
                    .map(|k| rotation_from_vector(&Vector3::new(r[0][k], r[1][k], r[2][k])))
                    .collect();
                let turned: Vec<Vector3<f64>> =
                    all.iter().map(|m| rotation_vector(&all[0].tr_mul(m))).collect();
                let turned = [0, 1, 2]
                    .map(|i| low.smooth(0, &turned.iter().map(|v| v[i]).collect::<Vec<f64>>()));
                let smooth = |k: usize| {
                    rotation_from_vector(&Vector3::new(turned[0][k], turned[1][k], turned[2][k]))
                };
                (0..n).map(|k| all[0] * smooth(k)).collect()
            }
            None => s.encoder.iter().map(|q| model.robot.forward_kinematics(q).rotation).collect(),
        };
        let moment = filled_vectors(&s.moment);
        let mut contact = Self {
            process,
            seam: Seam::of(weld),
            period,
            waves: (1..=ORDERS)
                .map(|n| {
                    let wave =
                        |f: fn(f64) -> f64| angle.iter().map(|a| 2.0 * f(n as f64 * a)).collect();
                    [wave(f64::cos), wave(f64::sin)]
                })
                .collect(),
            angle,
            encoder: s.encoder.clone(),
            position,
            rotation,
            force: (0..n).map(|k| Vector3::new(force[0][k], force[1][k], force[2][k])).collect(),
            moment,
            low,
            rows,
            motion: Vec::new(),
            shake: vec![[Vector3::zeros(); 2]; n],
            loops: Vec::new(),
            orders: alone(turning * period, APART * band * period),
            aside: APART * band / turning,
            lines: Vec::new(),
        };
        contact.motion = contact.tool(None, 0.0);
        let tracker = known(&noise.position, log, LogChannel::Position)?;
        let tracker = tracker.iter().map(|l| l.deviation).fold(0.0, f64::max);
        // Where the noise is of the size of the push, the predicted tool leaves the plate now and
        // then.
        let firm: Vec<usize> = contact
            .rows
            .iter()
            .copied()
            .filter(|row| {
                let spread = contact.spread(model, *row, tracker, 0.0);
                contact.push(*row) > FIRM * spread.z.max(CONTACT * contact.process.reference_force)
            })
            .collect();
        contact.rows = firm;
        if contact.rows.is_empty() {
            return Ok(None);
        }
        contact.close(log, model);
        contact.compare(log, noise, model, compared)?;
        let lines = compared.iter().filter(|c| matches!(c.quantity, Quantity::Ripple { .. }));
        contact.lines = lines.map(|c| c.measured).collect();
        Ok(Some(contact))
    }

    /// The process of this log: the model's, turning as the spindle was recorded.
    pub(super) fn process(&self, model: &Model) -> Process {
        let mut process = model.process.clone().unwrap_or_else(|| self.process.clone());
        process.spindle = self.process.spindle;
        process
    }

    /// Motion of the tool in the bands it is followed in. `robot`: whose sensor terms are undone;
    /// `late`: the tracker's delay, s.
    fn tool(&self, robot: Option<&ElasticRobot>, late: f64) -> Vec<Tool> {
        let n = self.angle.len();
        let w = &self.seam.b_from_w;
        let read = |k: usize| {
            let at = |i: usize| match late {
                0.0 => self.position[i][k],
                _ => interpolate(&self.position[i], k as f64 + late / self.period),
            };
            Vector3::new(at(0), at(1), at(2))
        };
        // What the tracker's terms do to a position changes along a weld as slowly as the tool
        // moves.
        let stride = self.stride();
        let undone: Vec<Vector3<f64>> = (0..n + stride)
            .step_by(stride)
            .map(|k| {
                let k = k.min(n - 1);
                let pose = Pose { position: read(k), rotation: self.rotation[k] };
                robot.map_or(Vector3::zeros(), |r| {
                    pose_behind(&r.ports, &pose, k as f64 * self.period).position - pose.position
                })
            })
            .collect();
        let raw: Vec<Vector3<f64>> = (0..n)
            .map(|k| {
                let (before, share) = (k / stride, (k % stride) as f64 / stride as f64);
                let undone = undone[before] * (1.0 - share) + undone[before + 1] * share;
                w.rotation.tr_mul(&(read(k) + undone - w.position))
            })
            .collect();
        let mut position = vec![Vector3::zeros(); n];
        let mut velocity = vec![Vector3::zeros(); n];
        for c in 0..3 {
            let series: Vec<f64> = raw.iter().map(|p| p[c]).collect();
            let slow = self.low.smooth(0, &series);
            let rate = self.low.smooth(1, &series);
            for k in 0..n {
                position[k][c] = slow[k];
                velocity[k][c] = rate[k];
            }
        }
        let mut channel = position[0].y;
        (0..n)
            .map(|k| {
                let tool = Tool { position: position[k], velocity: velocity[k], channel };
                // ẏ_m = (y − y_m)|v_x|/L, exactly over one row.
                let share =
                    -(-velocity[k].x.abs() * self.period / self.process.memory_length).exp_m1();
                channel += (position[k].y - channel) * share;
                tool
            })
            .collect()
    }

    /// Lists what is compared, with its noise.
    fn compare(
        &self,
        log: &Log,
        noise: &NoiseLevels,
        model: &Model,
        compared: &mut Vec<Compared>,
    ) -> Result<(), PredictError> {
        let force = known(&noise.force, log, LogChannel::Force)?;
        let tracker = known(&noise.position, log, LogChannel::Position)?;
        let tracker = (tracker.iter().map(|l| l.deviation.powi(2)).sum::<f64>() / 3.0).sqrt();
        let spreads: Vec<Vector3<f64>> = self
            .rows
            .iter()
            .map(|row| self.spread(model, *row, tracker, force[2].deviation))
            .collect();
        let measured = [0, 1, 2].map(|c| self.force.iter().map(|f| f[c]).collect::<Vec<f64>>());
        let turned = |spread: &Vector3<f64>, row: usize, c: usize| {
            let turn = self.seam.b_from_w.rotation.tr_mul(&self.rotation[row]);
            (0..3).map(|j| (turn[(j, c)] * spread[j]).powi(2)).sum::<f64>()
        };
        let value = self.low.gain(0);
        for (&row, spread) in self.rows.iter().zip(&spreads) {
            for c in 0..3 {
                compared.push(Compared {
                    quantity: Quantity::Force,
                    component: c as u8,
                    row,
                    measured: self.low.at(0, |i| measured[c][i], measured[c].len(), row),
                    deviation: (force[c].deviation.powi(2) * value
                        + turned(spread, row, c)
                        + (EXACT * self.push(row)).powi(2))
                    .sqrt(),
                    stated: force[c].stated,
                });
            }
        }
        if let Some(moment) = &self.moment {
            let level = known(&noise.moment, log, LogChannel::Moment)?;
            for &row in &self.rows {
                for c in 0..3 {
                    compared.push(Compared {
                        quantity: Quantity::Moment,
                        component: c as u8,
                        row,
                        measured: self.low.at(0, |i| moment[c][i], moment[c].len(), row),
                        deviation: level[c].deviation * value.sqrt(),
                        stated: level[c].stated,
                    });
                }
            }
        }
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        let measured = measured.map(|series| self.quick(&series));
        for &order in &self.orders {
            let beside = measured.each_ref().map(|series| self.beside(order, series));
            for (k, &row) in self.rows.iter().enumerate() {
                let driven = self.driven_noise(model, &encoder, order, k);
                for c in 0..3 {
                    let arm = self.loops[k][order - 1].line.map(|z| COMPLIANCE_KNOWN * z);
                    let through = 2.0 * value * turned(&driven, row, c) + turned(&arm, row, c);
                    for sine in [false, true] {
                        compared.push(Compared {
                            quantity: Quantity::Ripple { order: order as u8, sine },
                            component: c as u8,
                            row,
                            measured: self.demodulated(order, sine, row, |i| measured[c][i]),
                            deviation: (2.0 * value * force[c].deviation.powi(2) + through)
                                .max(beside[c])
                                .sqrt(),
                            stated: force[c].stated,
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// A series without what is slow in it: thousands of newtons that change slowly would show at
    /// every order, little as the filter lets through of what is far from it.
    fn quick(&self, series: &[f64]) -> Vec<f64> {
        let (n, stride) = (series.len(), self.stride());
        let slow: Vec<f64> = (0..n + stride)
            .step_by(stride)
            .map(|k| self.low.at(0, |i| series[i], n, k.min(n - 1)))
            .collect();
        series
            .iter()
            .enumerate()
            .map(|(k, s)| s - interpolate(&slow, k as f64 / stride as f64))
            .collect()
    }

    /// The same of every component.
    fn quick_vectors(&self, series: &[Vector3<f64>]) -> [Vec<f64>; 3] {
        [0, 1, 2].map(|c| self.quick(&series.iter().map(|v| v[c]).collect::<Vec<f64>>()))
    }

    /// Samples between two that tell what is slow.
    fn stride(&self) -> usize {
        (self.low.half() / 12).max(1)
    }

    /// Mean square of what a series holds to either side of an order's line: the arm shakes a
    /// little of itself, and most where it likes to.
    fn beside(&self, order: usize, series: &[f64]) -> f64 {
        let mut squares = Vec::new();
        for order in [order as f64 - self.aside, order as f64 + self.aside] {
            let wave = |f: fn(f64) -> f64| {
                self.angle.iter().map(|a| 2.0 * f(order * a)).collect::<Vec<f64>>()
            };
            for wave in [wave(f64::cos), wave(f64::sin)] {
                let at = |row: &usize| {
                    self.low.at(0, |k| series[k] * wave[k], series.len(), *row).powi(2)
                };
                squares.extend(self.rows.iter().map(at));
            }
        }
        squares.iter().sum::<f64>() / squares.len() as f64
    }

    /// What the tracker's noise becomes in the predicted slow force around a row, in W, N.
    /// `tracker`, m, and `sensor`, N: deviations of position and of measured depth force.
    fn spread(&self, model: &Model, row: usize, tracker: f64, sensor: f64) -> Vector3<f64> {
        let (value, rate) = (self.low.gain(0), self.low.gain(1));
        let (push, r) = self.held(&self.process(model), row);
        let (k, b) = (r.stiffness, r.damping);
        let from = |c: usize| if c == 2 { 2..3 } else { 0..2 };
        let mut slow = Vector3::from_fn(|c, _| {
            from(c).map(|j| k[(c, j)].powi(2) * value + b[(c, j)].powi(2) * rate).sum::<f64>()
                * tracker.powi(2)
        });
        for c in 0..2 {
            slow[c] += (r.force[c] / push * sensor).powi(2) * value;
        }
        // Where the channel behind the tool began is as uncertain as one reading, until the tool
        // has left it behind.
        let travelled = (self.motion[row].position.x - self.motion[0].position.x).abs();
        slow.y += (k[(1, 1)] * tracker * (-travelled / self.process.memory_length).exp()).powi(2);
        slow.map(f64::sqrt)
    }

    /// Measured push around a row, N, and the reaction of a tool that carries it: the noisy depth
    /// itself may have lost contact.
    fn held(&self, process: &Process, row: usize) -> (f64, Reaction) {
        let none = trueweld_plant::robot::Ports::default();
        let tool = &self.motion[row];
        let push = self.push(row).max(1.0);
        let position =
            Vector3::new(tool.position.x, tool.position.y, push / process.depth_stiffness);
        let velocity = Vector3::new(tool.velocity.x, tool.velocity.y, 0.0);
        (push, reaction(process, &none, 0.0, &position, &velocity, tool.channel, self.angle[row]))
    }

    /// Angular frequency of an order, rad/s; signed, as a spindle turns.
    fn turning(&self, order: usize) -> f64 {
        order as f64 * self.process.spindle
    }

    /// The slowest angular frequency whose samples are those of an order, rad/s; negative where
    /// they run backwards. Motors move this slowly rather than as fast as an order beyond half the
    /// sampling rate.
    fn folded(&self, order: usize) -> f64 {
        let rate = std::f64::consts::TAU / self.period;
        self.turning(order) - rate * (self.turning(order) / rate).round()
    }

    /// Arm and contact at an angular frequency, with the links at `q`. `held`: the reaction of a
    /// tool that carries the push.
    fn shaken(&self, model: &Model, held: &Reaction, q: &JointVector<f64>, turning: f64) -> Shaken {
        let frames = model.robot.frames(q);
        let jacobian =
            self.seam.b_from_w.rotation.transpose() * frames.jacobian().0.fixed_rows::<3>(3);
        let jacobian = jacobian.map(|x| Complex::new(x, 0.0));
        let spring = Matrix6::from_diagonal(&model.robot.dynamic_stiffness(turning));
        let h = model.robot.dynamic_compliance(&frames, turning).unwrap_or_else(Matrix6::zeros);
        let contact = held.stiffness.zip_map(&held.damping, |k, b| Complex::new(k, turning * b));
        let compliance = jacobian * h * jacobian.transpose();
        let pass = (Matrix3::identity() + contact * compliance)
            .try_inverse()
            .unwrap_or_else(Matrix3::zeros);
        Shaken { carried: jacobian * h * spring, compliance, contact, pass }
    }

    /// Closes the loop of contact and arm at every compared row, and shakes the tool with what
    /// comes of it.
    fn close(&mut self, log: &Log, model: &Model) {
        let process = self.process(model);
        let encoder: Vec<Vec<f64>> =
            (0..6).map(|i| log.samples.encoder.iter().map(|q| q[i]).collect()).collect();
        let smooth: Vec<Vec<f64>> = encoder.iter().map(|e| self.low.smooth(0, e)).collect();
        let shaking: Vec<Vec<f64>> = encoder
            .iter()
            .zip(&smooth)
            .map(|(e, s)| e.iter().zip(s).map(|(a, b)| a - b).collect())
            .collect();
        let loops: Vec<[Closed; ORDERS]> = self
            .rows
            .iter()
            .map(|&row| {
                let (_, held) = self.held(&process, row);
                let q = JointVector::from_fn(|i, _| smooth[i][row]);
                std::array::from_fn(|n| {
                    let order = n + 1;
                    let motor = SVector::<_, 6>::from_fn(|i, _| {
                        self.amplitude_of(order, row, |k| shaking[i][k])
                    });
                    let Shaken { compliance, pass, .. } =
                        self.shaken(model, &held, &q, self.turning(order));
                    let slow = self.shaken(model, &held, &q, self.folded(order));
                    let free = slow.carried * motor;
                    let driven = -(slow.pass * slow.contact * free);
                    let moved = free + slow.compliance * driven;
                    Closed { pass, driven, compliance, moved, line: Vector3::zeros() }
                })
            })
            .collect();
        self.loops = loops;
        // The nominal ripple shakes the tool: in step with the ripple itself it adds to the mean
        // force.
        let force =
            self.forces(&process, &trueweld_plant::robot::Ports::default(), &self.motion, false);
        let mut amplitude = vec![[[Vector3::<Complex<f64>>::zeros(); 2]; ORDERS]; self.rows.len()];
        let force = self.quick_vectors(&force);
        for (k, &row) in self.rows.iter().enumerate() {
            for n in self.orders.iter().map(|order| order - 1) {
                let closed = &self.loops[k][n];
                let force = closed.pass * self.amplitude(n + 1, row, &force);
                amplitude[k][n] = [closed.compliance * force, closed.moved];
                self.loops[k][n].line = (force + closed.driven).map(|z| z.norm());
            }
        }
        // Before the first row and after the last one it shakes as it does there: what is slow
        // there reaches that far.
        for row in 0..self.angle.len() {
            let after = self.rows.partition_point(|r| *r <= row).min(self.rows.len() - 1);
            let before = after.saturating_sub(1);
            let span = (self.rows[after] - self.rows[before]).max(1) as f64;
            let share = ((row as f64 - self.rows[before] as f64) / span).clamp(0.0, 1.0);
            for n in self.orders.iter().map(|order| order - 1) {
                let wave = Complex::from_polar(1.0, (n + 1) as f64 * self.angle[row]);
                for (part, turning) in
                    [self.turning(n + 1), self.folded(n + 1)].into_iter().enumerate()
                {
                    for c in 0..3 {
                        let at = |k: usize| amplitude[k][n][part][c];
                        let z = (at(before) * (1.0 - share) + at(after) * share) * wave;
                        self.shake[row][0][c] += z.re;
                        self.shake[row][1][c] += (z * Complex::new(0.0, turning)).re;
                    }
                }
            }
        }
    }

    /// What the encoders' noise becomes in the force at an order of the spindle, in W: deviation
    /// per deviation of a demodulated reading.
    fn driven_noise(
        &self,
        model: &Model,
        encoder: &[Level],
        order: usize,
        k: usize,
    ) -> Vector3<f64> {
        let row = self.rows[k];
        let q = JointVector::from_fn(|i, _| self.encoder[row][i]);
        let (_, held) = self.held(&self.process(model), row);
        let Shaken { carried, contact, pass, .. } =
            self.shaken(model, &held, &q, self.folded(order));
        let noise = SVector::<_, 6>::from_fn(|i, _| Complex::new(encoder[i].deviation, 0.0));
        let all = pass * contact * carried * Matrix6::from_diagonal(&noise);
        Vector3::from_fn(|c, _| all.row(c).iter().map(|z| z.norm_sqr()).sum::<f64>().sqrt())
    }

    /// The process' force at every row, in W, with the tool shaking or not.
    fn forces(
        &self,
        process: &Process,
        ports: &Ports,
        motion: &[Tool],
        shaken: bool,
    ) -> Vec<Vector3<f64>> {
        let force = |k: usize| {
            let tool = &motion[k];
            let [by, at] = if shaken { self.shake[k] } else { [Vector3::zeros(); 2] };
            let time = k as f64 * self.period;
            reaction(
                process,
                ports,
                time,
                &(tool.position + by),
                &(tool.velocity + at),
                tool.channel,
                self.angle[k],
            )
            .force
        };
        (0..self.angle.len()).map(force).collect()
    }

    /// Complex amplitude of a vector series at an order around a row: x = Re(z exp(i n φ)).
    fn amplitude(&self, order: usize, row: usize, series: &[Vec<f64>; 3]) -> Vector3<Complex<f64>> {
        Vector3::from_fn(|c, _| self.amplitude_of(order, row, |k| series[c][k]))
    }

    /// The same of one series.
    fn amplitude_of(
        &self,
        order: usize,
        row: usize,
        series: impl Fn(usize) -> f64,
    ) -> Complex<f64> {
        Complex::new(
            self.demodulated(order, false, row, &series),
            -self.demodulated(order, true, row, &series),
        )
    }

    /// Measured depth force around a row, N.
    fn push(&self, row: usize) -> f64 {
        self.low.at(0, |i| self.force[i].z.abs(), self.force.len(), row)
    }

    /// Amplitude of a series at an order of the spindle around a row: of the cosine or of the sine.
    fn demodulated(
        &self,
        order: usize,
        sine: bool,
        row: usize,
        series: impl Fn(usize) -> f64,
    ) -> f64 {
        let wave = &self.waves[order - 1][usize::from(sine)];
        self.low.at(0, |k| series(k) * wave[k], self.angle.len(), row)
    }

    /// Measured less predicted, in engineering units.
    pub(super) fn residual(
        &self,
        robot: &ElasticRobot,
        process: &Process,
        residual: &mut Vec<f64>,
    ) {
        let n = self.angle.len();
        let ports = &robot.ports;
        let late = ports.delay(Channel::Tracker);
        let followed;
        let motion = if late != 0.0 || !ports.sensor.is_empty() {
            followed = self.tool(Some(robot), late);
            &followed
        } else {
            &self.motion
        };
        let w = &self.seam.b_from_w.rotation;
        let behind: Vec<Vector3<f64>> = (0..n)
            .map(|k| {
                let read = Wrench { moment: Vector3::zeros(), force: self.force[k] };
                wrench_behind(ports, &read, k as f64 * self.period).force
            })
            .collect();
        let mut force = self.forces(process, ports, motion, true);
        let mut still = self.forces(process, ports, motion, false);
        // The depth force as measured against the predicted one, in W, both below the spindle's
        // frequency: as slow as that, a few values a second tell it.
        let depth: Vec<f64> =
            (0..n).map(|k| w.column(2).dot(&(self.rotation[k] * behind[k]))).collect();
        let stride = self.stride();
        let least = CONTACT * process.reference_force;
        let share: Vec<f64> = (0..n + stride)
            .step_by(stride)
            .map(|k| {
                let k = k.min(n - 1);
                let (measured, predicted) =
                    (self.low.at(0, |i| depth[i], n, k), self.low.at(0, |i| force[i].z, n, k));
                if predicted.abs() > least && measured.abs() > least {
                    measured / predicted
                } else {
                    1.0
                }
            })
            .collect();
        for (k, force) in force.iter_mut().enumerate() {
            let share = interpolate(&share, k as f64 / stride as f64);
            for force in [force, &mut still[k]] {
                force.x *= share;
                force.y *= share;
            }
        }
        let mut sensed: Vec<[Vector3<f64>; 2]> = (0..n)
            .map(|k| {
                let mut readings = super::unread(k as f64 * self.period);
                readings.force = self.rotation[k].tr_mul(&(w * force[k]));
                ports.sensor.iter().for_each(|t| t.sense(&mut readings));
                [readings.force, readings.moment]
            })
            .collect();
        let lag = ports.delay(Channel::Wrench) / self.period;
        if lag != 0.0 {
            let column = |j: usize| -> Vec<Vector3<f64>> {
                let series: Vec<Vector3<f64>> = sensed.iter().map(|s| s[j]).collect();
                (0..n).map(|k| interpolate(&series, k as f64 - lag)).collect()
            };
            let (force, moment) = (column(0), column(1));
            sensed = force.into_iter().zip(moment).map(|(f, m)| [f, m]).collect();
        }
        let left: [Vec<f64>; 3] =
            [0, 1, 2].map(|c| (0..n).map(|k| self.force[k][c] - sensed[k][0][c]).collect());
        for &row in &self.rows {
            residual.extend(left.iter().map(|l| self.low.at(0, |i| l[i], n, row)));
        }
        if let Some(moment) = &self.moment {
            for &row in &self.rows {
                residual.extend(
                    (0..3).map(|c| self.low.at(0, |i| moment[c][i] - sensed[i][1][c], n, row)),
                );
            }
        }
        let zero = {
            let mut readings = super::unread(0.0);
            ports.sensor.iter().for_each(|t| t.sense(&mut readings));
            readings.force
        };
        let late_by = ports.delay(Channel::Wrench);
        let still = self.quick_vectors(&still);
        let mut measured = self.lines.iter();
        for &order in &self.orders {
            let back = Complex::from_polar(1.0, -self.turning(order) * late_by);
            let driven_back = Complex::from_polar(1.0, -self.folded(order) * late_by);
            for (k, &row) in self.rows.iter().enumerate() {
                let closed = &self.loops[k][order - 1];
                let ripple = closed.pass * self.amplitude(order, row, &still);
                let force = ripple.map(|z| z * back) + closed.driven.map(|z| z * driven_back);
                let read = |part: Vector3<f64>| {
                    let mut readings = super::unread(row as f64 * self.period);
                    readings.force = self.rotation[row].tr_mul(&(w * part));
                    ports.sensor.iter().for_each(|t| t.sense(&mut readings));
                    readings.force - zero
                };
                let (cosine, sine) = (read(force.map(|z| z.re)), read(force.map(|z| -z.im)));
                let predicted = (0..3).flat_map(|c| [cosine[c], sine[c]]);
                residual.extend(measured.by_ref().zip(predicted).map(|(m, p)| m - p));
            }
        }
    }
}
