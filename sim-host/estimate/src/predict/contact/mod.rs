//! The force of a weld: the process under the tool, where the tracker saw the tool.
//!
//! The contact turns the tracker's noise into hundreds of newtons, so forces are compared slowly only,
//! and the tool's motion is taken from the tracker below the spindle's frequency. Forces in the plane are in proportion to the depth force, which the sensor
//! knows far better than the depth gives it: they are predicted for the depth force that was
//! measured. What the spindle's ripple does is predicted at its lines ([`lines`]).

mod spindle_harmonics;
mod tool;

use super::columns::{
    Dropouts, filled, filled_vectors, mean_abs, period, rows_a_vector, spindle_angle,
    turned_from_first, vector,
};
use super::compared::list;
use super::instruments::{sensed, unread, wrench_behind};
use super::{BaselineModel, Compared, ComparedQuantity, NoiseFactors, PredictError, known};
use nalgebra::{Matrix3, Vector3};
use spindle_harmonics::SpindleHarmonics;
use tool::{CONTACT, LoadedTool, RecordedWeld};
use trueweld_core::Wrench;
use trueweld_core::spatial::rotation_from_vector;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::fir::{LowPass, interpolate};
use trueweld_logs::log::Log;
use trueweld_logs::noise::{NoiseLevel, NoiseLevels};
use trueweld_plant::effects::Effect;
use trueweld_plant::input::Process;
use trueweld_plant::robot::{Channel, ElasticRobot, Ports, Readings};
use trueweld_plant::simulate::Seam;

/// Band of the slow force, Hz, and its largest share of the spindle's frequency.
const SLOW_FORCE_BAND: f64 = 1.2;
const SLOW_FORCE_SPINDLE_SHARE: f64 = 0.2;

/// Band up to which a filter of the slow force lets anything through, in its bands.
const PASSED: f64 = 1.5;

/// Band in which the tool is followed, in bands of the slow force. It passes whole what that band
/// passes, so that a force that jumps is smoothed once, as the measured one is, and nothing at the
/// spindle's frequency.
const FOLLOWED_BANDS: f64 = 3.0;

/// What the predicted slow force is exact to, as a share of the push: the ripple's mean effect is
/// taken to second order.
const SLOW_FORCE_ACCURACY: f64 = 2e-4;

/// Push that counts as firm contact, in deviations of the predicted depth force.
const FIRM: f64 = 4.0;

/// A weld with tracker and wrench.
#[derive(Debug, Clone)]
pub(super) struct ContactForcePrediction {
    weld: RecordedWeld,
    moment: Option<[Vec<f64>; 3]>,
    lines: SpindleHarmonics,
    /// What the nominal contact makes of the tracker's noise, at every row, in T, N.
    noise: Vec<Vector3<f64>>,
    /// Deviation of the tracker's noise, m.
    tracker: f64,
    /// Of a log that begins in contact: what is not known of its start.
    start: Option<ChannelStart>,
}

/// The channel behind the tool where a log begins in contact: the log does not say how far beside
/// the tool it lies, if the log was cut there. What one place of it or another would make of the
/// slow force is taken out of the residuals.
#[derive(Debug, Clone)]
struct ChannelStart {
    /// The slow force of a channel elsewhere, over its deviations, normalized.
    direction: Vec<f64>,
    /// Deviations of the slow force, N, in the same order.
    deviation: Vec<f64>,
}

impl ChannelStart {
    /// `None` where the force does not depend on it.
    fn of(weld: &RecordedWeld, process: &Process, deviation: Vec<f64>) -> Option<Self> {
        let n = weld.motion.len();
        let first = weld.motion[0].position.x;
        let elsewhere: Vec<Vector3<f64>> = (0..n)
            .map(|k| {
                let travelled = (weld.motion[k].position.x - first).abs();
                let left = (-travelled / process.model.memory_length()).exp();
                let firmness = process.model.channel_stiffness(weld.push(k));
                let across = weld.axes[k].column(1);
                weld.rotation[k].tr_mul(&(across * (firmness * left)))
            })
            .collect();
        let slow = weld.rows.iter().flat_map(|row| {
            let elsewhere = &elsewhere;
            (0..3).map(move |c| weld.low.at(0, |i| elsewhere[i][c], n, *row))
        });
        let whitened: Vec<f64> = slow.zip(&deviation).map(|(force, by)| force / by).collect();
        let norm = whitened.iter().map(|v| v * v).sum::<f64>().sqrt();
        let direction = whitened.iter().map(|v| v / norm).collect();
        (norm > 0.0 && norm.is_finite()).then_some(Self { direction, deviation })
    }

    /// Takes it out of residuals of the slow force.
    fn take_out(&self, residual: &mut [f64]) {
        let each = || self.direction.iter().zip(&self.deviation);
        let along: f64 = residual.iter().zip(each()).map(|(r, (d, by))| d * r / by).sum();
        for (r, (d, by)) in residual.iter_mut().zip(each()) {
            *r -= along * d * by;
        }
    }
}

/// A line of the spindle that rows are too far apart for: they show it as a slow force.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Folded {
    /// Order of the ripple.
    pub order: f64,
    /// What the rows show it at, Hz.
    pub frequency: f64,
}

impl Folded {
    /// The first line of a process that rows show within the band of the slow force; `turning` in Hz.
    fn of(process: &Process, turning: f64, band: f64, period: f64) -> Option<Self> {
        let mut lines = process.orders().into_iter().map(|order| {
            let turns = order * turning * period;
            Self { order, frequency: (turns - turns.round()).abs() / period }
        });
        lines.find(|line| line.frequency < PASSED * band)
    }
}

impl ContactForcePrediction {
    /// What can be compared of a weld's forces: nothing where the log lacks what that needs, or where
    /// `folded` is given a line of the spindle that its rows show as a slow force.
    pub(super) fn new(
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        compared: &mut Vec<Compared>,
        folded: &mut Option<Folded>,
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
        // A point beside the tool's centre tells where that is by the tool's rotation alone, which
        // no encoder knows well enough for a contact as stiff.
        if log.origin.target.is_some_and(|at| at != Vector3::zeros()) && s.rotation.is_none() {
            return Ok(None);
        }
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
        let band = SLOW_FORCE_BAND.min(SLOW_FORCE_SPINDLE_SHARE * turning).min(0.2 / period);
        if band.is_nan() || band <= 0.0 {
            return Ok(None);
        }
        *folded = Folded::of(&process, turning, band, period);
        if folded.is_some() {
            return Ok(None);
        }
        let low = LowPass::new(band, period);
        if n < 2 * low.half() + 2 {
            return Ok(None);
        }
        let followed = LowPass::new((FOLLOWED_BANDS * band).min(0.2 / period), period);
        let every = ((0.4 / (band * period)).floor() as usize).max(1);
        // A force is predicted from where the tool was followed to, in a window of its own.
        let unread = Dropouts::of_vectors([&s.force], &low);
        let unseen = Dropouts::of_vectors([&s.position, &s.rotation], &followed);
        let is_read = |row: &usize| {
            !unread.within(low.half(), *row) && !unseen.within(low.half() + followed.half(), *row)
        };
        let rows = (low.half()..n - low.half()).step_by(every);
        let rows: Vec<usize> = rows.filter(is_read).collect();
        // The sensor's axes: the tool's, which turns slowly. Without a tracked rotation, as the
        // encoders have it.
        let rotation: Vec<Matrix3<f64>> = match turned_from_first(&s.rotation) {
            Some((first, turned)) => {
                let turned = turned.map(|v| followed.smooth(0, &v));
                (0..n).map(|k| first * rotation_from_vector(&vector(&turned, k))).collect()
            }
            None => s.encoder.iter().map(|q| model.robot.forward_kinematics(q).rotation).collect(),
        };
        let seam = Seam::real(weld);
        let feed = weld.feed_at(seam.place(&vector(&position, 0)).position.x);
        let axes = (0..n).map(|k| seam.place(&vector(&position, k)).axes).collect();
        let mut weld = RecordedWeld {
            process,
            seam,
            axes,
            feed,
            period,
            angle,
            position,
            rotation,
            force: (0..n).map(|k| vector(&force, k)).collect(),
            unmeasured: s.unmeasured_force,
            rows_a_force: rows_a_vector(&s.force, &low),
            low,
            followed,
            likeliest: None,
            rows,
            motion: Vec::new(),
        };
        weld.motion = weld.tool(None, 0.0, weld.process.model.memory_length());
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        // The mean of fewer readings is noisier.
        let seldom = |mut levels: Vec<NoiseLevel>, rows: f64| {
            levels.iter_mut().for_each(|level| level.deviation *= rows.sqrt());
            levels
        };
        // What was not measured is not compared, whatever its noise.
        let own = [0, 1, 2].map(|c| noise.force[if weld.unmeasured[c] { 2 } else { c }]);
        let level = known(&own, log, LogChannel::Force)?;
        let level = seldom(level, weld.rows_a_force);
        let tracker = known(&noise.position, log, LogChannel::Position)?;
        let tracker = seldom(tracker, rows_a_vector(&s.position, &weld.followed));
        let largest = tracker.iter().map(|l| l.deviation).fold(0.0, f64::max);
        let mean = (tracker.iter().map(|l| l.deviation.powi(2)).sum::<f64>() / 3.0).sqrt();
        let seen = weld.motion.clone();
        weld.distrust(mean);
        // Where the noise is of the size of the push, the predicted tool leaves the plate now and
        // then.
        let is_firm = |row: &usize| {
            let spread = spread(&weld, model, *row, largest, 0.0).z;
            weld.push(*row) > FIRM * spread.max(CONTACT * weld.process.model.reference_force())
        };
        weld.rows = weld.rows.iter().copied().filter(is_firm).collect();
        if weld.rows.is_empty() {
            return Ok(None);
        }
        let lined = |weld: &RecordedWeld| {
            let mut lines =
                SpindleHarmonics::new(weld, (&s.encoder, &encoder), model, turning, band);
            let mut amplitudes = Vec::new();
            lines.compare(weld, model, (&level, &encoder), &mut amplitudes);
            (lines, amplitudes)
        };
        let (mut lines, mut amplitudes) = lined(&weld);
        // A log that begins in contact need not begin with the spindle's angle at 0.
        let begins_in_contact = weld.begins_in_contact();
        if begins_in_contact && let Some(ahead) = lines.start_angle(&weld, model, &amplitudes) {
            weld.angle.iter_mut().for_each(|angle| *angle += ahead);
            (lines, amplitudes) = lined(&weld);
        }
        // As compared: the push that the depth's noise makes is none that the plane's forces have.
        let forces = |motion| {
            let process = weld.process(model);
            let mut force = weld.forces(&process, &Ports::default(), motion, None);
            let share = weld.carried(&process, &weld.force, &force);
            in_plane(&mut force, &share);
            force
        };
        let parts = forces(&seen).into_iter().zip(forces(&weld.motion)).enumerate();
        let unlikely = parts.map(|(k, (seen, likeliest))| weld.in_tool(k, &(seen - likeliest)));
        let unlikely = unlikely.collect();
        let moment = filled_vectors(&s.moment);
        let mut contact = Self { weld, moment, lines, noise: unlikely, tracker: mean, start: None };
        let slow = compared.len();
        contact.compare(log, noise, model, &level, compared)?;
        if begins_in_contact {
            let count = 3 * contact.weld.rows.len();
            let deviation = compared[slow..slow + count].iter().map(|c| c.deviation).collect();
            contact.start =
                ChannelStart::of(&contact.weld, &contact.weld.process(model), deviation);
        }
        compared.append(&mut amplitudes);
        Ok(Some(contact))
    }

    /// True where the process has what an effect acts on.
    pub(super) fn has(&self, effect: &Effect) -> bool {
        effect.kind.acts_on.is_none_or(|part| self.weld.process.kind().has(part))
    }

    /// The process of this log: the model's, turning as the spindle was recorded.
    pub(super) fn process(&self, model: &BaselineModel) -> Process {
        self.weld.process(model)
    }

    /// Lists what is compared of the slow force and moment, with its noise: `level` of the measured
    /// force.
    fn compare(
        &self,
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        level: &[NoiseLevel],
        compared: &mut Vec<Compared>,
    ) -> Result<(), PredictError> {
        let RecordedWeld { low, rows, force, .. } = &self.weld;
        let (white, n) = (low.gain(0), force.len());
        let spreads: Vec<Vector3<f64>> = rows
            .iter()
            .map(|row| spread(&self.weld, model, *row, self.tracker, level[2].deviation))
            .collect();
        list(compared, ComparedQuantity::Force, rows, 0..3, |k, c| {
            let row = rows[k];
            let variance = level[c].deviation.powi(2) * white
                + self.weld.turned(&spreads[k], row, c)
                + (SLOW_FORCE_ACCURACY * self.weld.push(row)).powi(2);
            let measured = low.at(0, |i| force[i][c], n, row);
            match self.weld.unmeasured[c] {
                true => (f64::NAN, f64::INFINITY, level[c].stated),
                false => (measured, variance.sqrt(), level[c].stated),
            }
        });
        if let Some(moment) = &self.moment {
            let level = known(&noise.moment, log, LogChannel::Moment)?;
            let white = white * rows_a_vector(&log.samples.moment, low);
            let unread = Dropouts::of_vectors([&log.samples.moment], low);
            list(compared, ComparedQuantity::Moment, rows, 0..3, |k, c| {
                let deviation = level[c].deviation * white.sqrt();
                let dropped = unread.within(low.half(), rows[k]);
                let measured =
                    if dropped { f64::NAN } else { low.at(0, |i| moment[c][i], n, rows[k]) };
                (measured, deviation, level[c].stated)
            });
        }
        Ok(())
    }

    /// Measured less predicted, in engineering units.
    pub(super) fn residual(
        &self,
        robot: &ElasticRobot,
        process: &Process,
        residual: &mut Vec<f64>,
    ) {
        let Self { weld, lines, noise, .. } = self;
        let n = weld.angle.len();
        let ports = &robot.ports;
        let late = ports.delay(Channel::Tracker);
        let followed;
        let memory = process.model.memory_length();
        let same_memory = memory == weld.process.model.memory_length();
        let motion = if late != 0.0 || ports.senses(Channel::Tracker) || !same_memory {
            followed = weld.tool(Some(robot), late, memory);
            &followed
        } else {
            &weld.motion
        };
        let behind: Vec<Vector3<f64>> = (0..n)
            .map(|k| {
                let read = Wrench { moment: Vector3::zeros(), force: weld.force[k] };
                wrench_behind(ports, &read, k as f64 * weld.period).force
            })
            .collect();
        let mut still = weld.forces(process, ports, motion, None);
        let under = lines.under(weld, robot, process, &still);
        let mut force = weld.forces(process, ports, motion, Some(&under.shake));
        let share = weld.carried(process, &behind, &force);
        [&mut force, &mut still].into_iter().for_each(|force| in_plane(force, &share));
        let read = |k: usize| {
            let force = weld.in_tool(k, &force[k]);
            let truth = Readings { force, ..unread(k as f64 * weld.period) };
            sensed(ports, Channel::Wrench, truth)
        };
        let (mut force, mut turning): (Vec<_>, Vec<_>) =
            (0..n).map(read).map(|r| (r.force, r.moment)).unzip();
        let lag = ports.delay(Channel::Wrench) / weld.period;
        if lag != 0.0 {
            [force, turning] = [force, turning]
                .map(|series| (0..n).map(|k| interpolate(&series, k as f64 - lag)).collect());
        }
        let left: [Vec<f64>; 3] = [0, 1, 2]
            .map(|c| (0..n).map(|k| weld.force[k][c] - force[k][c] - noise[k][c]).collect());
        let slow = residual.len();
        for &row in &weld.rows {
            residual.extend(left.iter().map(|l| weld.low.at(0, |i| l[i], n, row)));
        }
        if let Some(start) = &self.start {
            start.take_out(&mut residual[slow..]);
        }
        if let Some(moment) = &self.moment {
            for &row in &weld.rows {
                residual.extend(
                    (0..3).map(|c| weld.low.at(0, |i| moment[c][i] - turning[i][c], n, row)),
                );
            }
        }
        lines.residual(weld, robot, (&still, &under), residual);
    }
}

impl ContactForcePrediction {
    /// How much larger noise is than the nominal contact makes it, where ports and process of a model make
    /// more or less of the tracker's noise.
    pub(super) fn noise_factors(
        &self,
        model: &BaselineModel,
        (robot, process): (&ElasticRobot, &Process),
        compared: &[Compared],
    ) -> NoiseFactors {
        let Self { weld, tracker, .. } = self;
        let (nominal, none) = (weld.process(model), Ports::default());
        let noise = [0, 1].map(|derivative| tracker * weld.low.gain(derivative).sqrt());
        let of_row = |row: usize| {
            let slopes =
                |process: &Process, ports: &Ports| weld.slopes((process, ports), row, noise);
            let both = slopes(process, &robot.ports).zip(slopes(&nominal, &none));
            both.map_or(Vector3::zeros(), |(own, nominal)| {
                self.more_variance(row, noise, [&own, &nominal])
            })
        };
        let mut known: Option<(usize, Vector3<f64>)> = None;
        let mut factors = NoiseFactors::default();
        for c in compared {
            let mut more = Vector3::zeros();
            if c.quantity == ComparedQuantity::Force {
                more =
                    known.filter(|(row, _)| *row == c.row).map_or_else(|| of_row(c.row), |k| k.1);
                known = Some((c.row, more));
            }
            let factor = |more: &Vector3<f64>| {
                let turn = weld.axes[c.row].tr_mul(&weld.rotation[c.row]);
                let along = |j: usize| turn[(j, usize::from(c.component))].powi(2) * more[j];
                let more: f64 = (0..3).map(along).sum();
                (1.0 + more / c.deviation.powi(2)).max(f64::MIN_POSITIVE).sqrt()
            };
            factors.deviation.push(factor(&more));
            if weld.process.bears_push() {
                more.z = 0.0;
            }
            factors.spread.push(factor(&more));
        }
        factors
    }

    /// By how much more the tracker's noise, which moves place and rate by `noise`, varies the slow force at
    /// a row with the first slopes than with the second, which are nominal: variance in W, N².
    fn more_variance(
        &self,
        row: usize,
        noise: [f64; 2],
        [own, nominal]: [&[Matrix3<f64>; 2]; 2],
    ) -> Vector3<f64> {
        let Some(likeliest) = &self.weld.likeliest else { return Vector3::zeros() };
        let follows = self.weld.process.model.plane_follows_push();
        let variance = |of: &[Matrix3<f64>; 2], c: usize| -> f64 {
            let along = |j: usize, derivative: usize| {
                let slopes = [of, nominal].map(|of| of[derivative][(c, j)]);
                noise[derivative].powi(2) * likeliest.variance((derivative, j), row, slopes)
            };
            axes_seen(c, follows).map(|j| along(j, 0) + along(j, 1)).sum()
        };
        Vector3::from_fn(|c, _| variance(own, c) - variance(nominal, c))
    }
}

/// Axes in W along which noise of the tool's place moves a component of the force: one that goes with the push
/// that was measured does not go with the depth.
fn axes_seen(component: usize, follows_push: bool) -> std::ops::Range<usize> {
    match component {
        _ if !follows_push => 0..3,
        2 => 2..3,
        _ => 0..2,
    }
}

/// Scales what forces in W have in the plane, which goes with the push that is carried, row by row.
fn in_plane(forces: &mut [Vector3<f64>], shares: &[f64]) {
    for (force, share) in forces.iter_mut().zip(shares) {
        force.x *= share;
        force.y *= share;
    }
}

/// What the tracker's noise becomes in the predicted slow force around a row, in W, N.
/// `tracker`, m, and `sensor`, N: deviations of position and of measured depth force.
fn spread(
    weld: &RecordedWeld,
    model: &BaselineModel,
    row: usize,
    tracker: f64,
    sensor: f64,
) -> Vector3<f64> {
    let (value, rate) = (weld.low.gain(0), weld.low.gain(1));
    let LoadedTool { push, reaction: r, .. } = weld.held(&weld.process(model), row);
    let (k, b) = (r.stiffness, r.damping);
    let follows = weld.process.model.plane_follows_push();
    let mut slow = Vector3::from_fn(|c, _| {
        axes_seen(c, follows)
            .map(|j| k[(c, j)].powi(2) * value + b[(c, j)].powi(2) * rate)
            .sum::<f64>()
            * tracker.powi(2)
    });
    for c in if follows { 0..2 } else { 0..0 } {
        slow[c] += (r.force[c] / push * sensor).powi(2) * value;
    }
    // Where the channel behind the tool began is as uncertain as one reading, until the tool
    // has left it behind.
    let travelled = (weld.motion[row].position.x - weld.motion[0].position.x).abs();
    let memory = weld.process.model.memory_length();
    let began = tracker.hypot(weld.lag(memory, |k| weld.motion[k].position));
    slow.y += (k[(1, 1)] * began * (-travelled / memory).exp()).powi(2);
    slow.map(f64::sqrt)
}
