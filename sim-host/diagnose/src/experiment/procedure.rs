//! Experiments that a laboratory can run: what is commanded, as a log whose driving channels are
//! made up.
//!
//! Measured channels hold what the baseline at rest would show: residuals of two models then differ
//! by what their predictions do, whatever was measured.

use super::cell::ExperimentCell;
use nalgebra::Vector3;
use trueweld_core::spatial::rotation_vector;
use trueweld_core::{JOINTS, JointVector, Pose, Wrench};
use trueweld_logs::log::{Log, LogKind, LogOrigin, NoiseLevels, Payload, Samples};
use trueweld_plant::input::{Process, Source, Weld};
use trueweld_plant::process::reaction;
use trueweld_plant::robot::Ports;
use trueweld_plant::simulate::Seam;

/// Loads as shares of the largest: up, through zero with steps close to it, and back. A gap shows
/// near zero, a loop where the load turns round.
const TO_AND_FRO: [f64; 12] = [0.0, 0.1, 0.3, 1.0, 0.3, 0.1, 0.0, -0.1, -0.3, -1.0, -0.3, 0.0];

/// Weights on the flange as shares of the heaviest: up and down again.
const UP_AND_DOWN: [f64; 7] = [0.0, 0.33, 0.67, 1.0, 0.67, 0.33, 0.0];

/// Postures of a scan.
const SCAN_POSTURES: usize = 12;

/// When a resting arm is read, minutes.
const RESTED: [f64; 12] = [0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0];

/// Time between two loads, s.
const LOAD_TAKES: f64 = 20.0;

/// When the brake falls in the log of a stop, s.
pub const STOP_BRAKE_ONSET: f64 = 0.1;
/// How long a stop is recorded, s.
pub const STOP_RECORDING_TIME: f64 = 1.0;
/// How long the brake takes, s, and the share of the joint's largest rate that it stops.
const STOP_BRAKE_DURATION: f64 = 0.003;
const STOP_SHARE: f64 = 0.1;

/// Share of a joint's largest rate that a motion reaches.
const MOVE_SHARE: f64 = 0.5;
/// The rest before, between and after moves, s.
pub const PROCEDURE_DWELL: f64 = 0.4;

/// Peak rate of a move of least jerk over its mean.
pub const PEAK: f64 = 15.0 / 8.0;

/// Longest time that a weld is recorded, s.
const WELD_LASTS: f64 = 30.0;

/// Sampling periods where no log shows the laboratory's own, s.
const RING_PERIOD: f64 = 0.001;
const FREE_PERIOD: f64 = 0.004;
const WELD_PERIOD: f64 = 0.012;

/// One set point of a plan.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlanRow {
    /// When, s from the start of the log.
    pub time: f64,
    /// Encoder angles on the joint side, rad.
    pub encoder: [f64; JOINTS],
    /// Force on the tool in T, N.
    pub force: [f64; 3],
    /// Moment on the tool at the tool centre point in T, N·m.
    pub moment: [f64; 3],
    /// Extra mass on the flange, kg.
    pub payload: f64,
}

impl PlanRow {
    /// An arm without load at `time`, s, with encoder angles `q`, rad.
    fn free(time: f64, q: JointVector<f64>) -> Self {
        Self { time, encoder: q.into(), ..Self::default() }
    }
}

/// How a static load acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Excitation {
    /// A weight on the flange.
    Hung,
    /// A force along an axis of T.
    Pressed(usize),
    /// A moment about an axis of T.
    Turned(usize),
}

/// How a weld differs from one that was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Changed {
    /// Feed times this.
    Feed(f64),
    /// Depth force times this.
    Force(f64),
    /// Spindle speed times this.
    Spindle(f64),
    /// From its end to its start.
    Backwards,
    /// Starting this share of its length further on.
    Shifted(f64),
}

/// One experiment. Postures: encoder angles on the joint side, rad.
#[derive(Debug, Clone, PartialEq)]
pub enum Procedure {
    /// Loads to and fro in one posture.
    Load {
        /// The posture.
        at: JointVector<f64>,
        /// The load.
        how: Excitation,
    },
    /// One joint through its range, at rest in every posture, with or without a weight.
    Scan {
        /// The posture of the other joints.
        at: JointVector<f64>,
        /// The joint, from 0.
        joint: usize,
        /// Weight on the flange, kg.
        mass: f64,
    },
    /// The same posture again and again, from cold.
    Rest {
        /// The posture.
        at: JointVector<f64>,
    },
    /// One joint running evenly, stopped by its brake.
    Stop {
        /// Where it begins.
        at: JointVector<f64>,
        /// The joint, from 0.
        joint: usize,
        /// Its rate, rad/s.
        rate: f64,
    },
    /// One joint there and back.
    Move {
        /// Where it begins.
        at: JointVector<f64>,
        /// The joint, from 0.
        joint: usize,
        /// How far, rad.
        span: f64,
        /// Time of each move one way, s.
        takes: Vec<f64>,
    },
    /// A weld made otherwise.
    Seam {
        /// Index of the log that has it.
        of: usize,
        /// The difference.
        changed: Changed,
    },
}

/// Procedures that are much alike.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ProcedureFamily {
    Loads,
    Poses,
    Stops,
    /// At several speeds.
    Speeds,
    LongWay,
    Welds,
}

impl ProcedureFamily {
    /// How many of them are looked at closely: those at rest cost next to nothing.
    pub(crate) fn most(self) -> usize {
        match self {
            Self::Loads | Self::Poses => 16,
            Self::Stops | Self::Speeds | Self::Welds => 2,
            Self::LongWay => 1,
        }
    }
}

/// Everything worth trying for these joints, with what the laboratory has.
pub(super) fn procedures(
    cell: &ExperimentCell<'_>,
    joints: &[usize],
    welds: &[usize],
) -> Vec<Procedure> {
    let mut all = Vec::new();
    let loads = cell.channels(LogKind::StaticLoad);
    if loads.position || loads.rotation {
        for at in cell.postures.iter().copied() {
            let pressed = (0..3).map(Excitation::Pressed).filter(|_| cell.force > 0.0);
            let turned = (0..3).map(Excitation::Turned).filter(|_| cell.moment > 0.0);
            all.extend(
                pressed
                    .chain(turned)
                    .chain([Excitation::Hung])
                    .map(|how| Procedure::Load { at, how }),
            );
        }
        for at in cell.postures.iter().copied().take(3) {
            for &joint in joints {
                all.extend([0.0, cell.mass].map(|mass| Procedure::Scan { at, joint, mass }));
            }
        }
        all.extend(cell.postures.first().map(|at| Procedure::Rest { at: *at }));
    }
    // Of all joints, one that carries the whole arm, one against gravity, one of the wrist.
    let moved = if joints.len() == JOINTS { &[0, 1, 4] } else { joints };
    for at in cell.postures.iter().copied().take(2) {
        for &joint in moved {
            let max_rate = cell.robot.parameters().joints[joint].max_rate;
            all.extend([STOP_SHARE, -STOP_SHARE].map(|share| Procedure::Stop {
                at,
                joint,
                rate: share * max_rate,
            }));
            let rate = max_rate * MOVE_SHARE;
            // Fast and slow over a short way; once over a long one.
            all.push(Procedure::Move { at, joint, span: rate * 1.5 / PEAK, takes: vec![4.0, 1.5] });
            all.push(Procedure::Move { at, joint, span: rate * 6.0 / PEAK, takes: vec![6.0] });
        }
    }
    for &of in welds {
        let changes = [
            Changed::Feed(0.5),
            Changed::Feed(2.0),
            Changed::Force(0.6),
            Changed::Spindle(0.7),
            Changed::Spindle(-1.0),
            Changed::Backwards,
            Changed::Shifted(0.3),
        ];
        all.extend(changes.map(|changed| Procedure::Seam { of, changed }));
    }
    all
}

impl Procedure {
    /// Kind of log to record.
    pub fn kind(&self) -> LogKind {
        match self {
            Self::Load { .. } | Self::Scan { .. } | Self::Rest { .. } => LogKind::StaticLoad,
            Self::Stop { .. } => LogKind::RingDown,
            Self::Move { .. } => LogKind::FreeMotion,
            Self::Seam { .. } => LogKind::Weld,
        }
    }

    pub(super) fn family(&self) -> ProcedureFamily {
        match self {
            Self::Load { .. } => ProcedureFamily::Loads,
            Self::Scan { .. } | Self::Rest { .. } => ProcedureFamily::Poses,
            Self::Stop { .. } => ProcedureFamily::Stops,
            Self::Move { takes, .. } if takes.len() > 1 => ProcedureFamily::Speeds,
            Self::Move { .. } => ProcedureFamily::LongWay,
            Self::Seam { .. } => ProcedureFamily::Welds,
        }
    }

    /// What it costs the laboratory, minutes of the cell: setting up and running.
    pub fn minutes(&self) -> f64 {
        match self {
            Self::Load { how: Excitation::Hung, .. } => 25.0,
            Self::Load { .. } => 15.0,
            Self::Scan { mass, .. } => 8.0 + if *mass > 0.0 { 10.0 } else { 0.0 },
            Self::Rest { .. } => 150.0,
            Self::Stop { .. } => 8.0,
            Self::Move { .. } => 5.0,
            Self::Seam { .. } => 60.0,
        }
    }

    /// The log with its driving channels, and the set points; `None` where the laboratory cannot do
    /// it.
    pub(super) fn log(
        &self,
        cell: &ExperimentCell<'_>,
        logs: &[Log],
        process: Option<&Process>,
    ) -> Option<(Log, Vec<PlanRow>)> {
        match self {
            Self::Load { at, how } => {
                let shares: &[f64] =
                    if *how == Excitation::Hung { &UP_AND_DOWN } else { &TO_AND_FRO };
                let rows = shares.iter().enumerate().map(|(k, share)| {
                    loaded(cell, PlanRow::free(LOAD_TAKES * k as f64, *at), *how, *share)
                });
                at_rest(cell, rows.collect())
            }
            Self::Scan { at, joint, mass } => {
                let [low, high] = cell.space.range[*joint];
                let row = |k: usize| {
                    let mut q = *at;
                    q[*joint] = low + (high - low) * k as f64 / (SCAN_POSTURES - 1) as f64;
                    PlanRow { payload: *mass, ..PlanRow::free(LOAD_TAKES * k as f64, q) }
                };
                at_rest(cell, (0..SCAN_POSTURES).map(row).collect())
            }
            Self::Rest { at } => {
                let row = |minutes: &f64| PlanRow::free(60.0 * minutes, *at);
                at_rest(cell, RESTED.iter().map(row).collect())
            }
            Self::Stop { at, joint, rate } => {
                let angle = |time: f64| {
                    let braked = (time - STOP_BRAKE_ONSET).clamp(0.0, STOP_BRAKE_DURATION);
                    let lost = 0.5 * braked * braked / STOP_BRAKE_DURATION;
                    let mut q = *at;
                    q[*joint] += rate * (time.min(STOP_BRAKE_ONSET) + braked - lost);
                    q
                };
                let log =
                    in_motion(cell, LogKind::RingDown, RING_PERIOD, STOP_RECORDING_TIME, angle)?;
                let row = |time: f64| PlanRow::free(time, angle(time));
                Some((log, vec![row(0.0), row(STOP_BRAKE_ONSET)]))
            }
            Self::Move { at, joint, span, takes } => {
                let to = self.far_end(cell, at, *joint, *span)?;
                let mut corners = vec![(0.0, at[*joint]), (PROCEDURE_DWELL, at[*joint])];
                for takes in takes {
                    for end in [to, at[*joint]] {
                        let begun = corners[corners.len() - 1].0;
                        corners.push((begun + takes, end));
                        corners.push((begun + takes + PROCEDURE_DWELL, end));
                    }
                }
                let lasts = corners[corners.len() - 1].0;
                let posture = |angle: f64| {
                    let mut q = *at;
                    q[*joint] = angle;
                    q
                };
                let angle = |time: f64| {
                    let next = corners.partition_point(|c| c.0 <= time).min(corners.len() - 1);
                    let ((begun, from), (done, to)) = (corners[next - 1], corners[next]);
                    let s = ((time - begun) / (done - begun)).clamp(0.0, 1.0);
                    posture(from + (to - from) * s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s))
                };
                let log = in_motion(cell, LogKind::FreeMotion, FREE_PERIOD, lasts, angle)?;
                let row = |c: &(f64, f64)| PlanRow::free(c.0, posture(c.1));
                Some((log, corners.iter().map(row).collect()))
            }
            Self::Seam { of, changed } => weld(cell, &logs[*of], process, *changed),
        }
    }

    /// Where a move leads: towards the middle of the joint's range, in whole degrees.
    fn far_end(
        &self,
        cell: &ExperimentCell<'_>,
        at: &JointVector<f64>,
        joint: usize,
        span: f64,
    ) -> Option<f64> {
        let [low, high] = cell.space.range[joint];
        let towards = if at[joint] > 0.5 * (low + high) { -1.0 } else { 1.0 };
        let to = (at[joint] + towards * span).clamp(low, high).to_degrees().trunc().to_radians();
        let clear = (0..=8).all(|k| {
            let mut q = *at;
            q[joint] += (to - at[joint]) * f64::from(k) / 8.0;
            cell.space.reaches(&q)
        });
        (clear && (to - at[joint]).abs() > 5f64.to_radians()).then_some(to)
    }
}

/// Rows at rest.
fn at_rest(cell: &ExperimentCell<'_>, rows: Vec<PlanRow>) -> Option<(Log, Vec<PlanRow>)> {
    let channels = cell.channels(LogKind::StaticLoad);
    let mut samples = Samples::default();
    let (mut force, mut moment, mut position, mut rotation, mut payload) =
        (vec![], vec![], vec![], vec![], vec![]);
    for row in &rows {
        let q = JointVector::from(row.encoder);
        let wrench = Wrench { force: row.force.into(), moment: row.moment.into() };
        let weight = cell.weight(&q, row.payload);
        let carried =
            Wrench { force: wrench.force + weight.force, moment: wrench.moment + weight.moment };
        if !cell.space.bears(&q, &carried) {
            return None;
        }
        let pose = cell.pose(&q, &carried);
        samples.time.push(row.time);
        samples.encoder.push(q);
        force.push(wrench.force);
        moment.push(wrench.moment);
        position.push(pose.position);
        rotation.push(rotation_vector(&pose.rotation));
        let centre = if row.payload > 0.0 { cell.centre } else { Vector3::zeros() };
        payload.push(Payload { mass: row.payload, centre });
    }
    samples.force = channels.force.then_some(force);
    samples.moment = channels.moment.then_some(moment);
    samples.position = channels.position.then_some(position);
    samples.rotation = channels.rotation.then_some(rotation);
    samples.payload = rows.iter().any(|r| r.payload > 0.0).then_some(payload);
    Some((log_of(cell, LogKind::StaticLoad, None, samples), rows))
}

/// A row with a share of the largest load.
fn loaded(cell: &ExperimentCell<'_>, mut row: PlanRow, how: Excitation, share: f64) -> PlanRow {
    match how {
        Excitation::Hung => row.payload = (cell.mass * share / 10.0).round() * 10.0,
        Excitation::Pressed(axis) => row.force[axis] = cell.force * share,
        Excitation::Turned(axis) => row.moment[axis] = cell.moment * share,
    }
    row
}

/// A log of motion without contact.
fn in_motion(
    cell: &ExperimentCell<'_>,
    kind: LogKind,
    usual: f64,
    lasts: f64,
    angle: impl Fn(f64) -> JointVector<f64>,
) -> Option<Log> {
    let channels = cell.channels(kind);
    let period = cell.period(kind).unwrap_or(usual);
    let n = (lasts / period) as usize + 1;
    let time: Vec<f64> = (0..n).map(|k| k as f64 * period).collect();
    let encoder: Vec<JointVector<f64>> = time.iter().map(|t| angle(*t)).collect();
    if !encoder.iter().step_by((n / 10).max(1)).all(|q| cell.space.reaches(q)) {
        return None;
    }
    let poses: Vec<Pose<f64>> = encoder.iter().map(|q| cell.robot.forward_kinematics(q)).collect();
    let samples = Samples {
        link_encoder: std::array::from_fn(|i| {
            channels.link_encoder[i].then(|| encoder.iter().map(|q| q[i]).collect())
        }),
        motor_torque: std::array::from_fn(|i| channels.motor_torque[i].then(|| vec![0.0; n])),
        position: channels.position.then(|| poses.iter().map(|p| p.position).collect()),
        rotation: channels
            .rotation
            .then(|| poses.iter().map(|p| rotation_vector(&p.rotation)).collect()),
        time,
        encoder,
        ..Samples::default()
    };
    Some(log_of(cell, kind, Some(period), samples))
}

/// A weld that was made, made otherwise.
fn weld(
    cell: &ExperimentCell<'_>,
    pattern: &Log,
    process: Option<&Process>,
    changed: Changed,
) -> Option<(Log, Vec<PlanRow>)> {
    let mut weld: Weld = pattern.weld.clone()?;
    // Another seam can be drawn from a straight one only.
    if weld.path.is_some() && matches!(changed, Changed::Backwards | Changed::Shifted(_)) {
        return None;
    }
    let mut process = process.or(pattern.process.as_ref())?.clone();
    let spindle = pattern.samples.spindle.as_ref()?.iter().copied().find(|s| s.is_finite())?;
    process.spindle = spindle;
    match changed {
        Changed::Feed(factor) => weld.feed *= factor,
        Changed::Force(factor) => weld.force *= factor,
        Changed::Spindle(factor) => process.spindle *= factor,
        Changed::Backwards => std::mem::swap(&mut weld.start, &mut weld.end),
        Changed::Shifted(share) => {
            let by = (weld.end - weld.start) * share;
            weld.start += by;
            weld.end += by;
        }
    }
    let seam = Seam::of(&weld);
    let period = cell.period(LogKind::Weld).unwrap_or(WELD_PERIOD);
    let lasts = (weld.force_ramp + (seam.length / weld.feed)).min(WELD_LASTS);
    let n = (lasts / period) as usize + 1;
    let none = Ports::default();
    let channels = cell.channels(LogKind::Weld);
    let mut near = match changed {
        Changed::Backwards => *pattern.samples.encoder.last()?,
        _ => *pattern.samples.encoder.first()?,
    };
    let mut samples = Samples::default();
    let (mut force, mut moment, mut position, mut rotation) = (vec![], vec![], vec![], vec![]);
    let mut path = 0.0;
    for k in 0..n {
        let time = k as f64 * period;
        // Push first, then the feed, both rising evenly: a record begins in firm contact.
        let rise = (0.2 + 0.8 * time / weld.force_ramp).min(1.0);
        let rate = weld.feed * (time / weld.feed_ramp).min(1.0);
        let depth = process.depth_under(weld.force * rise);
        let along = Vector3::new(path, 0.0, depth);
        let angle = process.spindle * time;
        let f = reaction(&process, &none, time, &along, &Vector3::new(rate, 0.0, 0.0), 0.0, angle)
            .force;
        let mut pose = seam.nominal(path);
        let axes = seam.axes(path);
        pose.position += axes.column(2) * depth;
        let in_t = pose.rotation.tr_mul(&(axes * f));
        // The motors carry the mean load; they do not follow the ripple.
        let mean =
            Wrench { moment: Vector3::zeros(), force: Vector3::new(0.0, 0.0, -weld.force * rise) };
        near = cell.robot.inverse_near(&pose, &near).ok()?;
        samples.time.push(time);
        samples.encoder.push(cell.robot.fake_target(&near, &mean));
        force.push(in_t);
        moment.push(Vector3::zeros());
        position.push(pose.position);
        rotation.push(rotation_vector(&pose.rotation));
        path += rate * period;
    }
    samples.force = channels.force.then_some(force);
    samples.moment = channels.moment.then_some(moment);
    samples.position = channels.position.then_some(position);
    samples.rotation = channels.rotation.then_some(rotation);
    samples.spindle = Some(vec![process.spindle; n]);
    let row = |k: usize| PlanRow {
        time: samples.time[k],
        encoder: samples.encoder[k].into(),
        force: [0.0, 0.0, -weld.force],
        ..PlanRow::default()
    };
    let rows = vec![row(0), row(n - 1)];
    let mut log = log_of(cell, LogKind::Weld, Some(period), samples);
    log.weld = Some(weld);
    log.process = Some(process);
    Some((log, rows))
}

fn log_of(cell: &ExperimentCell<'_>, kind: LogKind, period: Option<f64>, samples: Samples) -> Log {
    let like = cell.like(kind);
    Log {
        files: Vec::new(),
        path: "planned".into(),
        name: "planned".to_owned(),
        kind,
        robot: like.robot.clone(),
        weld: None,
        process: None,
        period,
        accuracy: like.accuracy,
        noise: NoiseLevels::default(),
        samples,
        notices: Vec::new(),
        source: Source::new("planned", ""),
        origin: LogOrigin::default(),
        implausible: None,
    }
}
