//! The force of a weld: the process under the tool, where the tracker saw the tool.
//!
//! The contact turns the tracker's noise into hundreds of newtons, so the tool's motion is taken in bands: slowly, and in
//! step with the spindle's lowest orders, where the arm swings with the ripple. The process acts on that motion at the log's
//! own rate, and its force is compared slowly and by demodulation at the spindle's orders. Forces in the plane are in
//! proportion to the depth force, which the sensor knows far better than the depth gives it: they are predicted for the depth
//! force that was measured.

use super::{
    Compared, Model, PredictError, Quantity, filled, filled_vectors, known, mean_abs, period, pose_behind,
    spindle_angle, wrench_behind,
};
use crate::band::{LowPass, interpolate};
use crate::log::Log;
use crate::noise::Instruments;
use nalgebra::{Complex, Matrix3, Vector3};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{Pose, Wrench};
use trueweld_plant::input::Process;
use trueweld_plant::process::reaction;
use trueweld_plant::robot::{Channel, ElasticRobot};
use trueweld_plant::simulate::Seam;

/// Band of the slow force, Hz, and its largest share of the spindle's frequency.
const BAND: f64 = 1.2;
const SPINDLE_SHARE: f64 = 0.2;

/// Orders of the spindle at which the tool's own motion is followed.
const MOVED_ORDERS: usize = 2;

/// Orders of the spindle at which the force is compared.
const ORDERS: usize = 6;

/// Push that counts as firm contact, in deviations of the predicted depth force.
const FIRM: f64 = 4.0;

/// Depth force from which on there is contact to speak of, as a share of the process' reference force.
const CONTACT: f64 = 0.03;

/// What noise leaves in a predicted force, in W, N.
struct Spread {
    slow: Vector3<f64>,
    orders: [Vector3<f64>; ORDERS],
}

/// A weld with tracker and wrench.
#[derive(Debug)]
pub(super) struct Contact {
    process: Process,
    seam: Seam,
    period: f64,
    /// Spindle angle at every row, rad.
    angle: Vec<f64>,
    /// Twice the cosine and the sine of its multiples.
    waves: Vec<[Vec<f64>; 2]>,
    /// Tracker, all rows.
    position: [Vec<f64>; 3],
    rotation: Vec<Matrix3<f64>>,
    force: Vec<Vector3<f64>>,
    moment: Option<[Vec<f64>; 3]>,
    low: LowPass,
    rows: Vec<usize>,
    /// Motion of the tool as the tracker tells it without a delay or a term of its own.
    motion: Vec<Tool>,
}

/// The tool at one row: TCP and velocity in W, channel behind it, and W's axes in T.
#[derive(Debug, Clone, Copy)]
struct Tool {
    position: Vector3<f64>,
    velocity: Vector3<f64>,
    channel: f64,
}

impl Contact {
    pub(super) fn new(
        log: &Log,
        noise: &Instruments,
        model: &Model,
        compared: &mut Vec<Compared>,
    ) -> Result<Option<Self>, PredictError> {
        let s = &log.samples;
        let n = s.time.len();
        let (Some(force), Some(position)) = (filled_vectors(&s.force), filled_vectors(&s.position)) else {
            return Ok(None);
        };
        let Some(weld) = &log.weld else { return Ok(None) };
        let named = model.process.as_ref().or(log.process.as_ref());
        let mut process = named.ok_or_else(|| PredictError::NoProcess { log: log.name.clone() })?.clone();
        let spindle = s.spindle.as_ref().and_then(|v| filled(v)).unwrap_or_else(|| vec![process.spindle; n]);
        process.spindle = spindle.iter().sum::<f64>() / n as f64;
        let period = period(log);
        let angle = spindle_angle(log).unwrap_or_else(|| (0..n).map(|k| process.spindle * k as f64 * period).collect());
        let turning = mean_abs(&spindle) / std::f64::consts::TAU;
        let band = BAND.min(SPINDLE_SHARE * turning).min(0.2 / period);
        if !(band > 0.0) {
            return Ok(None);
        }
        let low = LowPass::new(band, period);
        if n < 2 * low.half() + 2 {
            return Ok(None);
        }
        let every = ((0.4 / (band * period)).floor() as usize).max(1);
        let rows: Vec<usize> = (low.half()..n - low.half()).step_by(every).collect();
        // The sensor's axes: the tool's, which turns slowly. Without a tracked rotation, as the encoders have it.
        let rotation: Vec<Matrix3<f64>> = match filled_vectors(&s.rotation) {
            Some(r) => {
                let all: Vec<Matrix3<f64>> =
                    (0..n).map(|k| rotation_from_vector(&Vector3::new(r[0][k], r[1][k], r[2][k]))).collect();
                let turned: Vec<Vector3<f64>> = all.iter().map(|m| rotation_vector(&all[0].tr_mul(m))).collect();
                let turned = [0, 1, 2].map(|i| low.smooth(0, &turned.iter().map(|v| v[i]).collect::<Vec<f64>>()));
                let smooth = |k: usize| rotation_from_vector(&Vector3::new(turned[0][k], turned[1][k], turned[2][k]));
                (0..n).map(|k| all[0] * smooth(k)).collect()
            }
            None => s.encoder.iter().map(|q| model.robot.forward(q).rotation).collect(),
        };
        let moment = filled_vectors(&s.moment);
        let mut contact = Self {
            process,
            seam: Seam::of(weld),
            period,
            waves: (1..=ORDERS)
                .map(|n| {
                    let wave = |f: fn(f64) -> f64| angle.iter().map(|a| 2.0 * f(n as f64 * a)).collect();
                    [wave(f64::cos), wave(f64::sin)]
                })
                .collect(),
            angle,
            position,
            rotation,
            force: (0..n).map(|k| Vector3::new(force[0][k], force[1][k], force[2][k])).collect(),
            moment,
            low,
            rows,
            motion: Vec::new(),
        };
        contact.motion = contact.tool(None, 0.0);
        let tracker = known(&noise.position, log, "the tracker's position")?;
        let tracker = tracker.iter().map(|l| l.deviation).fold(0.0, f64::max);
        // Where the noise is of the size of the push, the predicted tool leaves the plate now and then.
        let firm: Vec<usize> = contact
            .rows
            .iter()
            .copied()
            .filter(|row| {
                let spread = contact.spread(model, *row, tracker, 0.0);
                let all = spread.slow.z.powi(2) + spread.orders.iter().map(|o| o.z.powi(2)).sum::<f64>();
                contact.push(*row) > FIRM * all.sqrt()
            })
            .collect();
        contact.rows = firm;
        contact.compare(log, noise, model, compared)?;
        Ok(Some(contact))
    }

    /// The process of this log: the model's, turning as the spindle was recorded.
    pub(super) fn process(&self, model: &Model) -> Process {
        let mut process = model.process.clone().unwrap_or_else(|| self.process.clone());
        process.spindle = self.process.spindle;
        process
    }

    /// Motion of the tool in the bands it is followed in. `robot`: whose sensor terms are undone; `late`: the tracker's
    /// delay, s.
    fn tool(&self, robot: Option<&ElasticRobot>, late: f64) -> Vec<Tool> {
        let n = self.angle.len();
        let w = &self.seam.b_from_w;
        let raw: Vec<Vector3<f64>> = (0..n)
            .map(|k| {
                let at = |i: usize| {
                    if late == 0.0 {
                        self.position[i][k]
                    } else {
                        interpolate(&self.position[i], k as f64 + late / self.period)
                    }
                };
                let mut pose = Pose { position: Vector3::new(at(0), at(1), at(2)), rotation: self.rotation[k] };
                if let Some(robot) = robot {
                    pose = pose_behind(&robot.ports, &pose, k as f64 * self.period);
                }
                w.rotation.tr_mul(&(pose.position - w.position))
            })
            .collect();
        let mut position = vec![Vector3::zeros(); n];
        let mut velocity = vec![Vector3::zeros(); n];
        for c in 0..3 {
            let series: Vec<f64> = raw.iter().map(|p| p[c]).collect();
            let slow = self.low.smooth(0, &series);
            let rate = self.low.smooth(1, &series);
            let rest: Vec<f64> = series.iter().zip(&slow).map(|(a, b)| a - b).collect();
            for k in 0..n {
                position[k][c] = slow[k];
                velocity[k][c] = rate[k];
            }
            for order in 1..=MOVED_ORDERS {
                let turning = order as f64 * self.process.spindle;
                if turning.abs() * self.period > std::f64::consts::PI {
                    continue;
                }
                let wave = |k: usize| Complex::from_polar(1.0, order as f64 * self.angle[k]);
                let part = |f: &dyn Fn(usize) -> f64| self.low.smooth(0, &(0..n).map(f).collect::<Vec<f64>>());
                let re = part(&|k| 2.0 * rest[k] * wave(k).re);
                let im = part(&|k| -2.0 * rest[k] * wave(k).im);
                for k in 0..n {
                    let z = Complex::new(re[k], im[k]) * wave(k);
                    position[k][c] += z.re;
                    velocity[k][c] += (z * Complex::i() * turning).re;
                }
            }
        }
        let mut channel = position[0].y;
        (0..n)
            .map(|k| {
                let tool = Tool { position: position[k], velocity: velocity[k], channel };
                // ẏ_m = (y − y_m)|v_x|/L, exactly over one row.
                let share = -(-velocity[k].x.abs() * self.period / self.process.memory_length).exp_m1();
                channel += (position[k].y - channel) * share;
                tool
            })
            .collect()
    }

    /// Lists what is compared, with its noise.
    fn compare(
        &self,
        log: &Log,
        noise: &Instruments,
        model: &Model,
        compared: &mut Vec<Compared>,
    ) -> Result<(), PredictError> {
        let force = known(&noise.force, log, "the force sensor")?;
        let tracker = known(&noise.position, log, "the tracker's position")?;
        let tracker = (tracker.iter().map(|l| l.deviation.powi(2)).sum::<f64>() / 3.0).sqrt();
        let spreads: Vec<Spread> =
            self.rows.iter().map(|row| self.spread(model, *row, tracker, force[2].deviation)).collect();
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
                    deviation: (force[c].deviation.powi(2) * value + turned(&spread.slow, row, c)).sqrt(),
                    stated: force[c].stated,
                });
            }
        }
        if let Some(moment) = &self.moment {
            let level = known(&noise.moment, log, "the moment sensor")?;
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
        for order in 1..=ORDERS {
            for (&row, spread) in self.rows.iter().zip(&spreads) {
                for c in 0..3 {
                    let through = turned(&spread.orders[order - 1], row, c);
                    for sine in [false, true] {
                        compared.push(Compared {
                            quantity: Quantity::Ripple { order: order as u8, sine },
                            component: c as u8,
                            row,
                            measured: self.demodulated(order, sine, row, |i| measured[c][i]),
                            deviation: (2.0 * value * force[c].deviation.powi(2) + through).sqrt(),
                            stated: force[c].stated,
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// What the tracker's noise becomes in the predicted force around a row, in W, N: slowly and at the spindle's orders.
    /// `tracker`, m, and `sensor`, N: deviations of position and of measured depth force.
    fn spread(&self, model: &Model, row: usize, tracker: f64, sensor: f64) -> Spread {
        let process = self.process(model);
        let none = trueweld_plant::robot::Ports::default();
        let (value, rate) = (self.low.gain(0), self.low.gain(1));
        // At the depth that carries the push that was measured: the noisy depth itself may have lost contact.
        let tool = &self.motion[row];
        let push = self.push(row).max(1.0);
        let held = Vector3::new(tool.position.x, tool.position.y, push / process.depth_stiffness);
        let velocity = Vector3::new(tool.velocity.x, tool.velocity.y, 0.0);
        let r = reaction(&process, &none, 0.0, &held, &velocity, tool.channel, self.angle[row]);
        let (k, b) = (r.stiffness, r.damping);
        let from = |c: usize| if c == 2 { 2..3 } else { 0..2 };
        let by = |c: usize, stiff: f64, damp: f64| -> f64 {
            from(c).map(|j| k[(c, j)].powi(2) * stiff + b[(c, j)].powi(2) * damp).sum::<f64>() * tracker.powi(2)
        };
        let mut slow = Vector3::from_fn(|c, _| by(c, value, rate));
        let mut orders = [Vector3::zeros(); ORDERS];
        for (n, order) in orders.iter_mut().enumerate().take(MOVED_ORDERS) {
            let turning = (n + 1) as f64 * process.spindle;
            if turning.abs() * self.period <= std::f64::consts::PI {
                *order = Vector3::from_fn(|c, _| 2.0 * value * by(c, 1.0, turning.powi(2)));
                // Forces in the plane follow the depth force.
                let depth = order.z;
                for c in 0..2 {
                    order[c] += (r.force[c] / push).powi(2) * depth;
                }
            }
        }
        for c in 0..2 {
            slow[c] += (r.force[c] / push * sensor).powi(2) * value;
        }
        // Where the channel behind the tool began is as uncertain as one reading, until the tool has left it behind.
        let travelled = (tool.position.x - self.motion[0].position.x).abs();
        slow.y += (k[(1, 1)] * tracker * (-travelled / process.memory_length).exp()).powi(2);
        // The ripple carries noise from one order to its neighbours.
        let (before, plain) = (slow, orders);
        for ripple in &process.ripple {
            let amplitude = |c: usize| 0.5 * if c == 2 { ripple.axial } else { ripple.in_plane };
            for (n, noise) in plain.iter().enumerate() {
                for c in 0..3 {
                    let carried = amplitude(c).powi(2) * noise[c];
                    let near = ((n + 1) as f64 - ripple.order).abs().round() as usize;
                    let far = (n + 1) + ripple.order.round() as usize;
                    match near {
                        0 => slow[c] += carried,
                        m if m <= ORDERS => orders[m - 1][c] += carried,
                        _ => {}
                    }
                    if far <= ORDERS {
                        orders[far - 1][c] += carried;
                    }
                }
            }
            let at = ripple.order.round() as usize;
            if (1..=ORDERS).contains(&at) {
                for c in 0..3 {
                    orders[at - 1][c] += (2.0 * amplitude(c)).powi(2) * before[c];
                }
            }
        }
        // So does the noise in the depth force, which the forces in the plane are in proportion to.
        for (i, depth) in plain.iter().enumerate().take(MOVED_ORDERS) {
            for (j, noise) in plain.iter().enumerate().take(MOVED_ORDERS) {
                for c in 0..2 {
                    let carried = 0.25 * depth.z / push.powi(2) * noise[c];
                    match i.abs_diff(j) {
                        0 => slow[c] += carried,
                        m => orders[m - 1][c] += carried,
                    }
                    if i + j + 2 <= ORDERS {
                        orders[i + j + 1][c] += carried;
                    }
                }
            }
        }
        Spread { slow: slow.map(f64::sqrt), orders: orders.map(|o| o.map(f64::sqrt)) }
    }

    /// Measured depth force around a row, N.
    fn push(&self, row: usize) -> f64 {
        self.low.at(0, |i| self.force[i].z.abs(), self.force.len(), row)
    }

    /// Amplitude of a series at an order of the spindle around a row: of the cosine or of the sine.
    fn demodulated(&self, order: usize, sine: bool, row: usize, series: impl Fn(usize) -> f64) -> f64 {
        let wave = &self.waves[order - 1][usize::from(sine)];
        self.low.at(0, |k| series(k) * wave[k], self.angle.len(), row)
    }

    /// Measured less predicted, in engineering units.
    pub(super) fn residual(&self, robot: &ElasticRobot, process: &Process, residual: &mut Vec<f64>) {
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
        let mut force: Vec<Vector3<f64>> = (0..n)
            .map(|k| {
                let tool = &motion[k];
                let time = k as f64 * self.period;
                reaction(process, ports, time, &tool.position, &tool.velocity, tool.channel, self.angle[k]).force
            })
            .collect();
        // The depth force as measured against the predicted one, in W, both below the spindle's frequency: as slow as that, a
        // few values a second tell it.
        let depth: Vec<f64> = (0..n).map(|k| w.column(2).dot(&(self.rotation[k] * behind[k]))).collect();
        let stride = (self.low.half() / 12).max(1);
        let least = CONTACT * process.reference_force;
        let share: Vec<f64> = (0..n + stride)
            .step_by(stride)
            .map(|k| {
                let k = k.min(n - 1);
                let (measured, predicted) = (self.low.at(0, |i| depth[i], n, k), self.low.at(0, |i| force[i].z, n, k));
                if predicted.abs() > least && measured.abs() > least { measured / predicted } else { 1.0 }
            })
            .collect();
        for (k, force) in force.iter_mut().enumerate() {
            let share = interpolate(&share, k as f64 / stride as f64);
            force.x *= share;
            force.y *= share;
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
        let left: [Vec<f64>; 3] = [0, 1, 2].map(|c| (0..n).map(|k| self.force[k][c] - sensed[k][0][c]).collect());
        for &row in &self.rows {
            residual.extend(left.iter().map(|l| self.low.at(0, |i| l[i], n, row)));
        }
        if let Some(moment) = &self.moment {
            for &row in &self.rows {
                residual.extend((0..3).map(|c| self.low.at(0, |i| moment[c][i] - sensed[i][1][c], n, row)));
            }
        }
        for order in 1..=ORDERS {
            for &row in &self.rows {
                for l in &left {
                    residual.extend([false, true].map(|sine| self.demodulated(order, sine, row, |i| l[i])));
                }
            }
        }
    }
}
