//! Free motion and ringing down: the links swing on their springs, driven by the encoders.

mod noise;
mod residual;
mod start;
mod swing;

use super::columns::period;
use super::instruments::{sensed, tracker_reading, unread};
use super::play::{BacklashObserver, Observed};
use super::{BaselineModel, Compared, LinkMotion, PredictError, known};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;
pub use swing::SwingGain;
use swing::{Elsewhere, Swing};
use trueweld_core::JointVector;
use trueweld_core::spatial::rotation_from_vector;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::fir::{
    Bands, Beginning, CLOSE_AGREEMENT_DEVIATIONS, LowPass, NOT_BY_CHANCE, Smoothed, finer, start,
};
use trueweld_logs::log::{Log, LogKind, Samples};
use trueweld_logs::noise::NoiseLevels;
use trueweld_plant::integrate::link_dynamics::{DynamicLinks, Motors};
use trueweld_plant::integrate::{Diverged, TooFast, substeps};
use trueweld_plant::robot::{Channel, ElasticRobot, Memory};

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

/// Longest time between two states of the motors that drive the links, s: between rows that are further
/// apart motors move along a spline, and a filter for such rows would cut off what they did.
const DRIVE_PERIOD: f64 = 4e-3;

/// Rows that are further apart tell nothing of a motion, s, nor of an arm's ringing, in periods of its
/// lowest mode.
const MOTION_ROW_INTERVAL_MAX: f64 = 0.1;
const OF_A_PERIOD: f64 = 0.2;

/// Longest step of the links' integration, s: a mode of 50 Hz turns by 0.6 rad in it.
const INTEGRATION_STEP_MAX: f64 = 2e-3;

/// Postures along a log at which its fastest mode is looked for.
const LOG_POSTURES: usize = 32;

/// Time at either end of a log that is driven through but not compared, s: there the smoothed drive
/// has one side only.
const UNCOMPARED_END: f64 = 0.1;

/// Links in motion.
struct Links {
    swinging: DynamicLinks,
    /// Which of them are in the backlash of their gears.
    in_backlash: Option<BacklashObserver>,
    /// Links that are driven with less noise, whose gears tell what is remembered; none where nothing
    /// is.
    even: Option<DynamicLinks>,
    /// Steps of the integration for each state of the motors.
    substeps: usize,
}

impl Links {
    fn new(
        robot: &ElasticRobot,
        swinging: DynamicLinks,
        in_backlash: Option<BacklashObserver>,
        substeps: usize,
    ) -> Self {
        let even = (robot.ports.memories() > 0).then_some(swinging);
        Self { swinging, in_backlash, even, substeps }
    }
}

/// A log of links in motion.
#[derive(Debug, Clone)]
pub(super) struct DynamicPrediction {
    period: f64,
    /// States of the motors for each row.
    parts: usize,
    time: Vec<f64>,
    /// Band that most of the drive was smoothed in, Hz.
    drive_band: f64,
    /// Twist that is within the noise of the encoders, rad.
    margin: JointVector<f64>,
    /// What drives the links: so many states from row to row as there are parts.
    drive: Vec<Motors>,
    /// The same with less of the encoders' noise, for what gears remember: each wiggle makes them
    /// forget.
    even: Vec<Motors>,
    /// How the links swing at the first row is fitted, where a ring-down begins after its stop.
    swing: Option<(Swing, Arc<SwingGain>)>,
    /// True where motors move at the first row.
    motors_move: bool,
    /// Jerk of the motors at the first row, rad/s³, where a free motion's log begins in motion.
    jerk: Option<JointVector<f64>>,
    /// What the motors did at each row, for their torque: smoothed.
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

/// True where all gaps of a series are so short that a filter bridges them. `read`: whether there is a
/// reading, row by row.
fn is_bridged(mut read: impl Iterator<Item = bool>, low: &LowPass) -> bool {
    let mut gap = 0;
    read.all(|read| {
        gap = if read { 0 } else { gap + 1 };
        gap <= low.bridged()
    })
}

/// True where the filter bridges all gaps of a log's poses and second encoders.
fn is_whole(samples: &Samples, low: &LowPass) -> bool {
    let mut vectors = samples.position.iter().chain(&samples.rotation);
    let mut encoders = samples.link_encoder.iter().flatten();
    vectors.all(|v| is_bridged(v.iter().map(|v| v.sum().is_finite()), low))
        && encoders.all(|v| is_bridged(v.iter().map(|v| v.is_finite()), low))
}

/// The motors in a band, Hz, by each joint's angles, rad, every `part` s.
fn smoothed(columns: &[Vec<f64>; 6], band: f64, part: f64) -> Vec<Motors> {
    let smooth = LowPass::new(band, part);
    let series =
        columns.each_ref().map(|c| [smooth.smooth(0, c), smooth.smooth(1, c), smooth.smooth(2, c)]);
    let six = |d: usize, k: usize| JointVector::from_fn(|i, _| series[i][d][k]);
    (0..columns[0].len())
        .map(|k| Motors { angle: six(0, k), rate: six(1, k), acceleration: six(2, k) })
        .collect()
}

/// Motors that drive the links by smoothed columns, one for each joint.
fn driven_by(columns: &[Vec<Smoothed>]) -> Vec<Motors> {
    let mut motors = Vec::with_capacity(columns[0].len());
    for k in 0..columns[0].len() {
        motors.push(Motors {
            angle: JointVector::from_fn(|i, _| columns[i][k].value),
            rate: JointVector::from_fn(|i, _| columns[i][k].rate),
            acceleration: JointVector::zeros(),
        });
    }
    motors
}

impl DynamicPrediction {
    pub(super) fn new(
        log: &Log,
        noise: &NoiseLevels,
        model: &BaselineModel,
        compared: &mut Vec<Compared>,
    ) -> Result<Self, PredictError> {
        let s = &log.samples;
        let n = s.time.len();
        let period = period(log);
        let frames = model.robot.frames(&s.encoder[n / 2]);
        let lowest = model.robot.natural_frequencies(&frames).map(|omega| omega[0] / TAU);
        let slowest = match lowest {
            Some(hertz) if log.kind == LogKind::RingDown => {
                MOTION_ROW_INTERVAL_MAX.min(OF_A_PERIOD / hertz)
            }
            _ => MOTION_ROW_INTERVAL_MAX,
        };
        if period > slowest * 1.01 {
            let what = "its rows are too far apart to tell what the arm did between them";
            return Err(PredictError::Nothing { log: log.name.clone(), what });
        }
        let encoder = known(&noise.encoder, log, LogChannel::Encoder)?;
        let parts = ((period / DRIVE_PERIOD - 1e-6).ceil() as usize).max(1);
        let part = period / parts as f64;
        // A spline holds the noise of its rows in as narrow a band as they do.
        let scatter = JointVector::from_fn(|i, _| encoder[i].deviation * (parts as f64).sqrt());
        let columns: [Vec<f64>; 6] = std::array::from_fn(|i| {
            finer(&s.encoder.iter().map(|q| q[i]).collect::<Vec<f64>>(), parts)
        });
        let states = columns[0].len();
        let in_bands: [Bands; 6] =
            std::array::from_fn(|i| Bands::of(&DRIVE_BANDS, part, scatter[i], &columns[i]));
        let agreeing = |within: f64| -> Vec<Vec<Smoothed>> {
            in_bands.iter().map(|bands| bands.in_agreement(within)).collect()
        };
        let closely = agreeing(CLOSE_AGREEMENT_DEVIATIONS);
        let mut bands: Vec<usize> =
            closely.iter().flatten().map(|smoothed| smoothed.band).collect();
        bands.sort_unstable();
        let mut drive = driven_by(&closely);
        let mut even = driven_by(&agreeing(NOT_BY_CHANCE));
        // A filter's window has one side only at the ends; where the motors move there, a cubic
        // stands in.
        let mut motor = smoothed(&columns, MOTOR_BAND, part);
        // By how much smoothing changes it.
        let mut otherwise = smoothed(&columns, 2.0 * MOTOR_BAND, part);
        let ends: [Option<[Beginning; 6]>; 2] = [false, true].map(|back| {
            let of = |i: usize| {
                let mut column = columns[i].clone();
                if back {
                    column.reverse();
                }
                Beginning::of(part, scatter[i], &column)
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
                    let [angle, rate, acceleration] = beginning.after(k as f64 * part);
                    let state = if back == 1 { states - 1 - k } else { k };
                    for series in [&mut drive, &mut even, &mut motor, &mut otherwise] {
                        series[state].angle[i] = angle;
                        series[state].rate[i] = sign * rate;
                        series[state].acceleration[i] = acceleration;
                    }
                }
            }
        }
        let jerk = ends[0].map(|all| JointVector::from_fn(|i, _| all[i].derivatives[3]));
        // The links swing on from how they start.
        for i in (0..6).filter(|_| jerk.is_none()) {
            let (angle, rate) = start(part, scatter[i], &columns[i]);
            for series in [&mut drive, &mut even] {
                (series[0].angle[i], series[0].rate[i]) = (angle, rate);
            }
        }
        let skipped = if log.kind == LogKind::RingDown {
            0
        } else {
            (UNCOMPARED_END / period).ceil() as usize
        };
        // A channel with long gaps is compared where it was read.
        let calm = lowest
            .filter(|_| log.kind == LogKind::FreeMotion)
            .map(|frequency| CALM * frequency)
            .filter(|band| band.is_finite() && *band < 0.2 / period)
            .map(|band| (band, LowPass::new(band, period)))
            .filter(|(_, low)| n > 4 * low.half() && is_whole(s, low));
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
        let half = LowPass::new(MOTOR_BAND, part).half().div_ceil(parts);
        let [first, last] =
            ends.each_ref().map(|end| band.half() + if end.is_some() { half } else { 0 });
        let torque_rows: Vec<usize> = (first..n.saturating_sub(last)).step_by(every).collect();

        let at_rows =
            |states: Vec<Motors>| -> Vec<Motors> { states.into_iter().step_by(parts).collect() };
        let otherwise = at_rows(otherwise);
        let mut moving = Self {
            period,
            parts,
            time: s.time.clone(),
            drive,
            even,
            swing: None,
            motors_move,
            jerk,
            motor: at_rows(motor),
            margin: JointVector::from_fn(|i, _| 3.0 * encoder[i].deviation),
            drive_band: DRIVE_BANDS[bands[bands.len() / 2]],
            position: s.position.clone(),
            rotation: s.rotation.as_ref().map(|r| r.iter().map(rotation_from_vector).collect()),
            link_encoder: s.link_encoder.clone(),
            torque: s.motor_torque.clone(),
            band,
            calm,
            pose_rows,
            torque_rows,
        };
        moving.compare(log, noise, model, &otherwise, compared)?;
        if log.kind == LogKind::RingDown {
            moving.swing = moving.swing(log, noise, model);
        }
        Ok(moving)
    }

    /// Time between two states of the motors that drive the links, s.
    fn part(&self) -> f64 {
        self.period / self.parts as f64
    }

    /// Steps of the integration that these links need for each state of the motors.
    ///
    /// # Errors
    /// Links that move too fast to be followed.
    pub(super) fn substeps(&self, robot: &ElasticRobot) -> Result<usize, TooFast> {
        let every = self.drive.len().div_ceil(LOG_POSTURES).max(1);
        let postures = self.drive.iter().step_by(every).map(|motors| motors.angle);
        substeps(robot, postures, self.part(), INTEGRATION_STEP_MAX)
    }

    /// A series at one row, in the band it is compared in.
    fn calmed(&self, length: usize, row: usize, series: impl Fn(usize) -> f64) -> f64 {
        self.calm.as_ref().map_or_else(|| series(row), |low| low.at(0, &series, length, row))
    }

    /// Takes the links from the row before to this one; those in their backlash to where they were
    /// seen.
    fn advance(&self, robot: &ElasticRobot, links: &mut Links, row: usize) -> Result<(), Diverged> {
        let last = row * self.parts;
        for state in last.saturating_sub(self.parts - 1).max(1)..=last {
            let time = state as f64 * self.part() + self.time[0];
            links.swinging.advance(robot, &self.drive[state], time, links.substeps)?;
            if let Some(even) = &mut links.even {
                even.advance(robot, &self.even[state], time, links.substeps)?;
                links.swinging.remember(&even.memory());
            }
        }
        if let Some(in_backlash) = &mut links.in_backlash {
            let link = links.swinging.drives().link;
            let seen = self.observed(robot, &links.swinging, row);
            let moved = in_backlash.moved(robot, &self.drive[last].angle, &link, &seen);
            for links in [&mut links.swinging].into_iter().chain(&mut links.even) {
                links.displace(&moved.by, &moved.rate);
            }
        }
        Ok(())
    }

    /// The links at the first row, elsewhere by so much than the motors' motion asks for.
    fn start(&self, robot: &ElasticRobot, memory: &Memory, elsewhere: &Elsewhere) -> DynamicLinks {
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

    /// Where the motors were, row by row and between rows that are far apart.
    pub(super) fn motors(&self) -> &[Motors] {
        &self.drive
    }

    /// What the links do, in so many steps for each state of the motors: see
    /// [`PreparedLog::follow`](super::PreparedLog).
    pub(super) fn motion(
        &self,
        robot: &ElasticRobot,
        memory: &Memory,
        known: Option<&Arc<SwingGain>>,
        before: Option<&LinkMotion>,
        substeps: usize,
    ) -> Result<LinkMotion, Diverged> {
        let in_backlash = BacklashObserver::new(robot, self.margin, self.period);
        let links = |elsewhere: &_| {
            let start = self.start(robot, memory, elsewhere);
            Links::new(robot, start, in_backlash.clone(), substeps)
        };
        let begin = |swing| self.begun(robot, swing, memory, known, &links, substeps);
        let (elsewhere, swing) = self.swing.as_ref().map(begin).unzip();
        let elsewhere = elsewhere.unwrap_or_else(Elsewhere::zeros);
        let mut motion =
            LinkMotion { swing, ..LinkMotion::new(self.time.len(), in_backlash.is_some()) };
        self.go_through(robot, links(&elsewhere), before, &mut motion)?;
        Ok(motion)
    }

    /// Takes links that start so through as many rows as a motion has, or as far as what they do
    /// joins what they did `before`.
    fn go_through(
        &self,
        robot: &ElasticRobot,
        mut links: Links,
        before: Option<&LinkMotion>,
        motion: &mut LinkMotion,
    ) -> Result<(), Diverged> {
        for k in 0..motion.rows.len() {
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
        Ok(())
    }

    /// Where tool and links were seen at a row, less where these links put them.
    fn observed(&self, robot: &ElasticRobot, links: &DynamicLinks, row: usize) -> Observed {
        let time = self.time[row] - self.time[0];
        let tool = self.position.as_ref().map_or(Vector3::repeat(f64::NAN), |position| {
            let tool = links.frames(robot, time).tcp;
            position[row] - tracker_reading(&robot.ports, &tool, time).position
        });
        let link = links.drives().link;
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
}
