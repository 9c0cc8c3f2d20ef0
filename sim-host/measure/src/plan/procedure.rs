//! Experiments that a laboratory can run: what is commanded, as a log whose driving channels are made up, and in words.
//!
//! Measured channels hold what the baseline at rest would show: residuals of two models then differ by what their predictions
//! do, whatever was measured.

use super::Row;
use super::cell::{Cell, whole_steps};
use crate::log::{Log, LogKind, Noise, Payload, Samples};
use nalgebra::Vector3;
use trueweld_core::spatial::rotation_vector;
use trueweld_core::{JOINTS, JointVector, Pose, Wrench};
use trueweld_plant::input::{Process, Source, Weld};
use trueweld_plant::process::reaction;
use trueweld_plant::robot::Ports;
use trueweld_plant::simulate::Seam;

/// Loads as shares of the largest: up, through zero with steps close to it, and back. A gap shows near zero, a loop where the
/// load turns round.
const TO_AND_FRO: [f64; 12] = [0.0, 0.1, 0.3, 1.0, 0.3, 0.1, 0.0, -0.1, -0.3, -1.0, -0.3, 0.0];

/// Weights on the flange as shares of the heaviest: up and down again.
const UP_AND_DOWN: [f64; 7] = [0.0, 0.33, 0.67, 1.0, 0.67, 0.33, 0.0];

/// Postures of a scan.
const SCANNED: usize = 12;

/// When a resting arm is read, minutes.
const RESTED: [f64; 12] = [0.0, 0.5, 1.0, 2.0, 3.0, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0];

/// Time between two loads, s.
const LOAD_TAKES: f64 = 20.0;

/// A stop: when the brake falls, how long it takes, how long is recorded, s; share of the joint's largest rate.
const FALLS: f64 = 0.1;
const BRAKES: f64 = 0.003;
const RINGS: f64 = 1.0;
const STOP_SHARE: f64 = 0.1;

/// Share of a joint's largest rate that a motion reaches, and the rest between two moves, s.
const MOVE_SHARE: f64 = 0.5;
const DWELL: f64 = 0.4;

/// Peak rate of a move of least jerk over its mean.
const PEAK: f64 = 15.0 / 8.0;

/// Longest time that a weld is recorded, s.
const WELD_LASTS: f64 = 30.0;

/// Sampling periods where no log shows the laboratory's own, s.
const RING_PERIOD: f64 = 0.001;
const FREE_PERIOD: f64 = 0.004;
const WELD_PERIOD: f64 = 0.012;

/// How a static load acts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum How {
    /// A weight on the flange.
    Hung,
    /// A force along an axis of T.
    Pressed(usize),
    /// A moment about an axis of T.
    Turned(usize),
}

/// How a weld differs from one that was made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Changed {
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

/// One experiment.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Procedure {
    /// Loads to and fro in one posture.
    Load { at: JointVector<f64>, how: How },
    /// One joint through its range, at rest in every posture, with or without a weight.
    Scan { at: JointVector<f64>, joint: usize, mass: f64 },
    /// The same posture again and again, from cold.
    Rest { at: JointVector<f64> },
    /// Joints running evenly, stopped by their brakes.
    Stop { at: JointVector<f64>, joint: usize, sense: f64 },
    /// One joint there and back, in each of these times, s.
    Move { at: JointVector<f64>, joint: usize, span: f64, takes: Vec<f64> },
    /// A weld made otherwise.
    Seam { of: usize, changed: Changed },
}

/// Everything worth trying for these joints, with what the laboratory has.
pub(super) fn procedures(cell: &Cell<'_>, joints: &[usize], welds: &[usize]) -> Vec<Procedure> {
    let mut all = Vec::new();
    let loads = cell.channels(LogKind::StaticLoad);
    if loads.position || loads.rotation {
        for at in cell.postures.iter().copied() {
            let pressed = (0..3).map(How::Pressed).filter(|_| cell.force > 0.0);
            let turned = (0..3).map(How::Turned).filter(|_| cell.moment > 0.0);
            all.extend(pressed.chain(turned).chain([How::Hung]).map(|how| Procedure::Load { at, how }));
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
            all.extend([1.0, -1.0].map(|sense| Procedure::Stop { at, joint, sense }));
            let rate = cell.robot.parameters().joints[joint].max_rate * MOVE_SHARE;
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
    pub fn kind(&self) -> LogKind {
        match self {
            Self::Load { .. } | Self::Scan { .. } | Self::Rest { .. } => LogKind::StaticLoad,
            Self::Stop { .. } => LogKind::RingDown,
            Self::Move { .. } => LogKind::FreeMotion,
            Self::Seam { .. } => LogKind::Weld,
        }
    }

    /// What it costs the laboratory, minutes of the cell: setting up and running.
    pub fn minutes(&self) -> f64 {
        match self {
            Self::Load { how: How::Hung, .. } => 25.0,
            Self::Load { .. } => 15.0,
            Self::Scan { mass, .. } => 8.0 + if *mass > 0.0 { 10.0 } else { 0.0 },
            Self::Rest { .. } => 150.0,
            Self::Stop { .. } => 6.0,
            Self::Move { .. } => 5.0,
            Self::Seam { .. } => 60.0,
        }
    }

    /// The log with its driving channels, and the set points; `None` where the laboratory cannot do it.
    pub fn log(&self, cell: &Cell<'_>, logs: &[Log], process: Option<&Process>) -> Option<(Log, Vec<Row>)> {
        match self {
            Self::Load { at, how } => {
                let shares: &[f64] = if *how == How::Hung { &UP_AND_DOWN } else { &TO_AND_FRO };
                let rows = shares.iter().enumerate().map(|(k, share)| {
                    let row = Row { time: LOAD_TAKES * k as f64, encoder: (*at).into(), ..Row::default() };
                    loaded(cell, row, *how, *share)
                });
                at_rest(cell, rows.collect())
            }
            Self::Scan { at, joint, mass } => {
                let [low, high] = cell.range[*joint];
                let row = |k: usize| {
                    let mut q = *at;
                    q[*joint] = low + (high - low) * k as f64 / (SCANNED - 1) as f64;
                    Row { time: LOAD_TAKES * k as f64, encoder: q.into(), payload: *mass, ..Row::default() }
                };
                at_rest(cell, (0..SCANNED).map(row).collect())
            }
            Self::Rest { at } => {
                let row = |minutes: &f64| Row { time: 60.0 * minutes, encoder: (*at).into(), ..Row::default() };
                at_rest(cell, RESTED.iter().map(row).collect())
            }
            Self::Stop { at, joint, sense } => {
                let rate = sense * STOP_SHARE * cell.robot.parameters().joints[*joint].max_rate;
                let angle = |time: f64| {
                    let braked = (time - FALLS).clamp(0.0, BRAKES);
                    let mut q = *at;
                    q[*joint] += rate * (time.min(FALLS) + braked - 0.5 * braked * braked / BRAKES);
                    q
                };
                let log = in_motion(cell, LogKind::RingDown, RING_PERIOD, RINGS, angle)?;
                let row = |time: f64| Row { time, encoder: angle(time).into(), ..Row::default() };
                Some((log, vec![row(0.0), row(FALLS)]))
            }
            Self::Move { at, joint, span, takes } => {
                let to = self.far_end(cell, at, *joint, *span)?;
                let mut corners = vec![(0.0, at[*joint]), (DWELL, at[*joint])];
                for takes in takes {
                    for end in [to, at[*joint]] {
                        let begun = corners[corners.len() - 1].0;
                        corners.push((begun + takes, end));
                        corners.push((begun + takes + DWELL, end));
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
                let row = |c: &(f64, f64)| Row { time: c.0, encoder: posture(c.1).into(), ..Row::default() };
                Some((log, corners.iter().map(row).collect()))
            }
            Self::Seam { of, changed } => weld(cell, &logs[*of], process, *changed),
        }
    }

    /// Where a move leads: towards the middle of the joint's range, in whole degrees.
    fn far_end(&self, cell: &Cell<'_>, at: &JointVector<f64>, joint: usize, span: f64) -> Option<f64> {
        let [low, high] = cell.range[joint];
        let towards = if at[joint] > 0.5 * (low + high) { -1.0 } else { 1.0 };
        let to = (at[joint] + towards * span).clamp(low, high).to_degrees().trunc().to_radians();
        let clear = (0..=8).all(|k| {
            let mut q = *at;
            q[joint] += (to - at[joint]) * f64::from(k) / 8.0;
            cell.reaches(&q)
        });
        (clear && (to - at[joint]).abs() > 5f64.to_radians()).then_some(to)
    }

    /// One line that says what is done.
    pub fn title(&self, cell: &Cell<'_>, rows: &[Row]) -> String {
        let name = |joint: &usize| &cell.names[*joint];
        match self {
            Self::Load { how: How::Hung, .. } => {
                format!("Static loads, {} rows: up to {:.0} kg on the flange, up and down", rows.len(), cell.mass)
            }
            Self::Load { how, .. } => {
                format!("Static loads, {} rows: {} to and fro", rows.len(), largest(rows, *how))
            }
            Self::Scan { joint, mass, .. } => {
                let with = if *mass > 0.0 { format!(", {mass:.0} kg on the flange") } else { String::new() };
                format!("Static poses, {} rows: {} through its range{with}", rows.len(), name(joint))
            }
            Self::Rest { .. } => format!("The same pose at rest, {} rows in 30 min from cold", rows.len()),
            Self::Stop { joint, .. } => format!("Ring-down: {} stopped by its brake", name(joint)),
            Self::Move { joint, takes, .. } if takes.len() > 1 => {
                format!("Free motion of {} there and back, slowly and fast", name(joint))
            }
            Self::Move { joint, .. } => format!("Free motion of {} over a long way and back", name(joint)),
            Self::Seam { changed, .. } => format!("Weld {}", changed.words()),
        }
    }

    /// What to do, in order.
    pub fn steps(&self, cell: &Cell<'_>, log: &Log, rows: &[Row]) -> Vec<String> {
        let record = recorded(cell, self.kind());
        let first = rows.first().map_or([0.0; JOINTS], |r| r.encoder);
        let stand = format!("Move to {}. Check at low speed that the arm is clear of the cell.", posture(cell, &first));
        let mut steps = Vec::new();
        match self {
            Self::Load { how, .. } => {
                let list = |value: &dyn Fn(&Row) -> f64| {
                    rows.iter().map(|r| format!("{:.0}", value(r))).collect::<Vec<_>>().join(", ")
                };
                let (what, unit) = match how {
                    How::Hung => (list(&|r| r.payload), "kg"),
                    How::Pressed(axis) => (list(&|r| r.force[*axis]), "N"),
                    How::Turned(axis) => (list(&|r| r.moment[*axis]), "N·m"),
                };
                let way = match how {
                    How::Hung => {
                        let c = cell.centre * 1e3;
                        format!(
                            "Hang weights on the flange, centre at ({:.0}, {:.0}, {:.0}) mm from it in axes of the last link",
                            c.x, c.y, c.z
                        )
                    }
                    How::Pressed(axis) => format!("Press on the tool centre point along {} of T", AXES[*axis]),
                    How::Turned(axis) => format!("Apply a moment to the tool about {} of T", AXES[*axis]),
                };
                steps.push(stand);
                steps.push(
                    "Keep the brakes open and the position controller on; do not move the arm in between.".into(),
                );
                steps.push(format!("{way}, in this order and without overshoot: {what} {unit}."));
                steps.push(format!("Wait 2 s at each load, then record one row: {record}."));
            }
            Self::Scan { joint, mass, .. } => {
                let angles: Vec<String> = rows.iter().map(|r| degrees(r.encoder[*joint], 1)).collect();
                steps.push(stand);
                if *mass > 0.0 {
                    let c = cell.centre * 1e3;
                    steps.push(format!(
                        "Hang {mass:.0} kg on the flange, centre at ({:.0}, {:.0}, {:.0}) mm from it in axes of the last link.",
                        c.x, c.y, c.z
                    ));
                }
                steps.push(format!(
                    "Move {} alone, always from the same side, to {}.",
                    cell.names[*joint],
                    angles.join(", ")
                ));
                steps.push(format!("Wait 2 s in each pose, then record one row: {record}."));
            }
            Self::Rest { .. } => {
                let times: Vec<String> = RESTED.iter().map(|m| format!("{m}")).collect();
                steps.push("Leave the robot switched off until it is cold, two hours at least.".into());
                steps.push(stand);
                steps.push(format!(
                    "Stay there, brakes open, and record one row after {} min: {record}.",
                    times.join(", ")
                ));
            }
            Self::Stop { joint, sense, .. } => {
                let rate = sense * STOP_SHARE * cell.robot.parameters().joints[*joint].max_rate;
                let name = &cell.names[*joint];
                steps.push(format!("Start a few degrees before this posture, so that {name} runs evenly for 1 s when it gets there: {}.", posture(cell, &first)));
                steps.push(format!("Run {name} alone at {} a second and let its brake fall there.", degrees(rate, 1)));
                steps.push(format!(
                    "Record from {FALLS} s before the brake falls, for {RINGS} s, at {}: {record}.",
                    rate_of(log)
                ));
                steps.push("Repeat once; keep both logs.".into());
            }
            Self::Move { joint, takes, .. } => {
                let name = &cell.names[*joint];
                let to = rows.get(2).map_or(0.0, |r| r.encoder[*joint]);
                let from = first[*joint];
                steps.push(stand);
                for takes in takes {
                    let peak = (to - from).abs() / takes * PEAK;
                    steps.push(format!(
                        "Move {name} alone from {} to {} in {takes:.1} s (smoothly, peak {} a second), rest {DWELL} s, and back in the same time, rest {DWELL} s.",
                        degrees(from, 0), degrees(to, 0), degrees(peak, 1).trim_start_matches('+')
                    ));
                }
                steps.push(format!("Record all of it, with {DWELL} s of rest before, at {}: {record}.", rate_of(log)));
            }
            Self::Seam { .. } => {
                if let Some(weld) = &log.weld {
                    let turning = log.samples.spindle.as_ref().and_then(|s| s.first()).copied().unwrap_or(0.0);
                    let point = |p: &Vector3<f64>| format!("({:.3}, {:.3}, {:.3}) m", p.x, p.y, p.z);
                    steps.push(format!(
                        "Clamp a fresh plate; weld from {} to {} in B, tool axis ({:.3}, {:.3}, {:.3}).",
                        point(&weld.start),
                        point(&weld.end),
                        weld.tool_axis.x,
                        weld.tool_axis.y,
                        weld.tool_axis.z
                    ));
                    steps.push(format!(
                        "Feed {:.1} mm/s, depth force {:.1} kN, spindle {:.0} turns a minute ({}); everything else as before.",
                        weld.feed * 1e3,
                        weld.force * 1e-3,
                        turning.abs() * 60.0 / std::f64::consts::TAU,
                        if turning < 0.0 { "negative about the tool's z axis" } else { "positive about the tool's z axis" },
                    ));
                }
                steps.push(format!("Record at {}, {WELD_LASTS:.0} s at least: {record}.", rate_of(log)));
            }
        }
        steps
    }
}

impl Changed {
    fn words(self) -> String {
        match self {
            Self::Feed(f) if f < 1.0 => "at half the feed".to_owned(),
            Self::Feed(_) => "at twice the feed".to_owned(),
            Self::Force(f) => format!("with {:.0} % of the depth force", f * 100.0),
            Self::Spindle(f) if f < 0.0 => "with the spindle turning the other way".to_owned(),
            Self::Spindle(f) => format!("at {:.0} % of the spindle speed", f * 100.0),
            Self::Backwards => "from the end of an earlier seam to its start".to_owned(),
            Self::Shifted(s) => format!("along an earlier seam, moved on by {:.0} % of its length", s * 100.0),
        }
    }
}

const AXES: [&str; 3] = ["x", "y", "z"];

/// Rows at rest.
fn at_rest(cell: &Cell<'_>, rows: Vec<Row>) -> Option<(Log, Vec<Row>)> {
    let channels = cell.channels(LogKind::StaticLoad);
    let mut samples = Samples::default();
    let (mut force, mut moment, mut position, mut rotation, mut payload) = (vec![], vec![], vec![], vec![], vec![]);
    for row in &rows {
        let q = JointVector::from(row.encoder);
        let wrench = Wrench { force: row.force.into(), moment: row.moment.into() };
        let weight = cell.weight(&q, row.payload);
        let carried = Wrench { force: wrench.force + weight.force, moment: wrench.moment + weight.moment };
        if !cell.bears(&q, &carried) {
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
fn loaded(cell: &Cell<'_>, mut row: Row, how: How, share: f64) -> Row {
    match how {
        How::Hung => row.payload = (cell.mass * share / 10.0).round() * 10.0,
        How::Pressed(axis) => row.force[axis] = cell.force * share,
        How::Turned(axis) => row.moment[axis] = cell.moment * share,
    }
    row
}

/// A log of motion without contact.
fn in_motion(
    cell: &Cell<'_>,
    kind: LogKind,
    usual: f64,
    lasts: f64,
    angle: impl Fn(f64) -> JointVector<f64>,
) -> Option<Log> {
    let channels = cell.channels(kind);
    let period = cell.pattern(kind).and_then(|l| l.period).unwrap_or(usual);
    let n = (lasts / period) as usize + 1;
    let time: Vec<f64> = (0..n).map(|k| k as f64 * period).collect();
    let encoder: Vec<JointVector<f64>> = time.iter().map(|t| angle(*t)).collect();
    if !encoder.iter().step_by((n / 10).max(1)).all(|q| cell.reaches(q)) {
        return None;
    }
    let poses: Vec<Pose<f64>> = encoder.iter().map(|q| cell.robot.forward(q)).collect();
    let samples = Samples {
        link_encoder: std::array::from_fn(|i| channels.link_encoder[i].then(|| encoder.iter().map(|q| q[i]).collect())),
        motor_torque: std::array::from_fn(|i| channels.motor_torque[i].then(|| vec![0.0; n])),
        position: channels.position.then(|| poses.iter().map(|p| p.position).collect()),
        rotation: channels.rotation.then(|| poses.iter().map(|p| rotation_vector(&p.rotation)).collect()),
        time,
        encoder,
        ..Samples::default()
    };
    Some(log_of(cell, kind, Some(period), samples))
}

/// A weld that was made, made otherwise.
fn weld(cell: &Cell<'_>, pattern: &Log, process: Option<&Process>, changed: Changed) -> Option<(Log, Vec<Row>)> {
    let mut weld: Weld = pattern.weld.clone()?;
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
    let period = cell.pattern(LogKind::Weld).and_then(|l| l.period).unwrap_or(WELD_PERIOD);
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
        let depth = weld.force * rise / process.depth_stiffness;
        let along = Vector3::new(path, 0.0, depth);
        let angle = process.spindle * time;
        let f = reaction(&process, &none, time, &along, &Vector3::new(rate, 0.0, 0.0), 0.0, angle).force;
        let mut pose = seam.nominal(path);
        pose.position += seam.b_from_w.rotation * Vector3::new(0.0, 0.0, depth);
        let in_t = pose.rotation.tr_mul(&(seam.b_from_w.rotation * f));
        // The motors carry the mean load; they do not follow the ripple.
        let mean = Wrench { moment: Vector3::zeros(), force: Vector3::new(0.0, 0.0, -weld.force * rise) };
        near = cell.robot.track(&pose, &near).ok()?;
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
    let row = |k: usize| Row {
        time: samples.time[k],
        encoder: samples.encoder[k].into(),
        force: [0.0, 0.0, -weld.force],
        ..Row::default()
    };
    let rows = vec![row(0), row(n - 1)];
    let mut log = log_of(cell, LogKind::Weld, Some(period), samples);
    log.weld = Some(weld);
    log.process = Some(process);
    Some((log, rows))
}

fn log_of(cell: &Cell<'_>, kind: LogKind, period: Option<f64>, samples: Samples) -> Log {
    let like = cell.like(kind);
    Log {
        path: "planned".into(),
        name: "planned".to_owned(),
        kind,
        robot: like.robot.clone(),
        weld: None,
        process: None,
        period,
        noise: Noise::default(),
        samples,
        notices: Vec::new(),
        source: Source::new("planned", ""),
    }
}

/// An angle in degrees, with its sign.
fn degrees(angle: f64, digits: usize) -> String {
    let value = angle.to_degrees();
    let value = if value.abs() < 0.5 * 10f64.powi(-(digits as i32)) { 0.0 } else { value };
    let text = format!("{value:+.digits$}°");
    if value == 0.0 { text.replace('+', "") } else { text.replace('-', "−") }
}

fn posture(cell: &Cell<'_>, q: &[f64; JOINTS]) -> String {
    let one = |i: usize| {
        let digits = usize::from((q[i] - whole_steps(q[i])).abs() > 1e-3);
        format!("{} {}", cell.names[i], degrees(q[i], digits))
    };
    (0..JOINTS).map(one).collect::<Vec<_>>().join(", ")
}

/// The largest load of some rows, in words.
fn largest(rows: &[Row], how: How) -> String {
    let most = |value: &dyn Fn(&Row) -> f64| rows.iter().map(|r| value(r).abs()).fold(0.0, f64::max);
    match how {
        How::Hung => format!("{:.0} kg on the flange", most(&|r| r.payload)),
        How::Pressed(axis) => format!("{:.1} kN along {} of T", most(&|r| r.force[axis]) * 1e-3, AXES[axis]),
        How::Turned(axis) => format!("{:.0} N·m about {} of T", most(&|r| r.moment[axis]), AXES[axis]),
    }
}

fn rate_of(log: &Log) -> String {
    let rate = 1.0 / log.period.unwrap_or(1.0);
    if rate > 400.0 { format!("{:.0} kHz", rate * 1e-3) } else { format!("{rate:.0} Hz") }
}

/// Channels to record in a log of this kind, in words.
fn recorded(cell: &Cell<'_>, kind: LogKind) -> String {
    let channels = cell.channels(kind);
    let mut parts = vec!["encoders"];
    if channels.link_encoder.contains(&true) {
        parts.push("link-side encoders");
    }
    if channels.motor_torque.contains(&true) {
        parts.push("motor torques");
    }
    match (channels.position, channels.rotation) {
        (true, true) => parts.push("tracker position and rotation"),
        (true, false) => parts.push("tracker position"),
        _ => {}
    }
    if channels.force && matches!(kind, LogKind::StaticLoad | LogKind::Weld) {
        parts.push("measured wrench");
    }
    if kind == LogKind::Weld {
        parts.push("spindle speed");
    }
    if kind == LogKind::StaticLoad {
        parts.push("payload");
    }
    parts.join(", ")
}
