//! Mistakes that show in where the tool was seen: encoders and tracker.
//!
//! A joint that is read wrongly is found by the angle that it must have had in every row for the tool
//! to be where it was seen: against what was read, these angles lie on a line whose slope and offset
//! say what is wrong.

use super::line;
use super::reading::{
    AT_REST, Best, EncoderReading, ExplainedReading, Tracker, WHOLE_SLOPE_TOLERANCE, is_near,
    misfit, pose_pairs, with,
};
use super::rows::LogRow;
use super::{ColumnChange, MisfitEvidence, Mistake, MistakeKind};
use std::f64::consts::PI;
use trueweld_core::{JOINTS, Pose, Robot};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{Coupling, Log, channel_named};
use trueweld_logs::register::{self, PosePair, Registration};
use trueweld_plant::input::unit_suffix;

/// Misfit of pose, m (a radian counts half a metre), that no effect of a cell makes.
const GROSS: f64 = 0.015;

/// Largest share of the misfit that an explanation leaves.
const EXPLAINED_MISFIT_SHARE_MAX: f64 = 0.3;

/// Misfit of pose that is not left to physics where nothing explains it, m.
const EXPLAINED_MISFIT_MIN: f64 = 0.05;

/// What a log saw of the tool.
pub(super) fn plain_pose_pairs(log: &Log, robot: &Robot<f64>) -> Vec<PosePair> {
    pose_pairs(&LogRow::of(log).iter().collect::<Vec<_>>(), robot, EncoderReading::Plain)
}

/// What poses say of some logs.
#[derive(Default)]
pub(super) struct OfPoses {
    /// Mistakes in encoders and tracker.
    pub mistakes: Vec<Mistake>,
    /// Trackers that stand elsewhere, with the logs that they are of.
    pub registered: Vec<(Vec<usize>, Registration)>,
    /// A log whose misfit nothing explains, and the misfit, m. There is no mistake then: what explains
    /// another log may do so by chance.
    pub lost: Option<(usize, f64)>,
}

/// Mistakes in encoders and tracker, and trackers that stand elsewhere.
pub(super) fn find(names: &[&str], rows: &[Vec<LogRow>], robot: &Robot<f64>) -> OfPoses {
    let before = |k: &usize| {
        let rows: Vec<&LogRow> = rows[*k].iter().collect();
        let seen = pose_pairs(&rows, robot, EncoderReading::Plain);
        if seen.is_empty() { 0.0 } else { misfit(&seen, &Pose::identity(), &Pose::identity()) }
    };
    let gross: Vec<usize> = (0..rows.len()).filter(|k| before(k) > GROSS).collect();
    if gross.is_empty() {
        return OfPoses::default();
    }
    // One explanation for all of them, or one for each.
    let all: Vec<&LogRow> = gross.iter().flat_map(|k| &rows[*k]).collect();
    let explained = match explain(&all, robot) {
        Some(explanation) => {
            vec![(whole(rows, robot, &gross, &explanation), all, explanation)]
        }
        None => gross
            .iter()
            .filter_map(|k| {
                let own: Vec<&LogRow> = rows[*k].iter().collect();
                let explanation = explain(&own, robot)?;
                Some((vec![*k], own, explanation))
            })
            .collect(),
    };
    let is_lost = |k: &&usize| {
        before(k) > EXPLAINED_MISFIT_MIN && !explained.iter().any(|(logs, ..)| logs.contains(k))
    };
    if let Some(lost) = gross.iter().find(is_lost) {
        return OfPoses { lost: Some((*lost, before(lost))), ..OfPoses::default() };
    }
    let (mut mistakes, mut registered) = (Vec::new(), Vec::new());
    for (logs, rows, explanation) in explained {
        let (explanation, fitted) = line::refined(explanation, &rows, robot);
        let plain = pose_pairs(&rows, robot, EncoderReading::Plain);
        let before = misfit(&plain, &Pose::identity(), &Pose::identity());
        let in_logs: Vec<String> = logs.iter().map(|k| names[*k].to_owned()).collect();
        let position = LogChannel::Position;
        let evidence =
            MisfitEvidence { before, after: explanation.left, unit: "m", channel: position };
        let named = |kind, channel, columns, changes| {
            Mistake::of_columns(kind, channel, columns, &in_logs, evidence, changes)
        };
        mistakes.extend(of_encoders(explanation.reading, fitted, &named));
        match explanation.tracker {
            Tracker::Plain => {}
            Tracker::Scaled(factor) => {
                let unit = if factor < 1.0 { "mm" } else { "km" };
                let changes = (0..3).map(|c| column(position, c, unit, 1.0)).collect();
                mistakes.push(named(MistakeKind::Unit, position, Vec::new(), changes));
            }
            Tracker::Mirrored(axis) => {
                let change = vec![column(position, axis, "m", -1.0)];
                mistakes.push(named(MistakeKind::TrackerFrame, position, vec![axis], change));
            }
            Tracker::Registered(registration) => registered.push((logs, registration)),
        }
    }
    OfPoses { mistakes, registered, lost: None }
}

/// The logs that an explanation is of: also those in which it hardly shows, unless one says that it
/// is not so.
fn whole(
    rows: &[Vec<LogRow>],
    robot: &Robot<f64>,
    gross: &[usize],
    explanation: &ExplainedReading,
) -> Vec<usize> {
    let read = |k: &usize| {
        let rows: Vec<&LogRow> = rows[*k].iter().collect();
        let seen = pose_pairs(&rows, robot, explanation.reading);
        if seen.is_empty() { 0.0 } else { misfit(&seen, &Pose::identity(), &Pose::identity()) }
    };
    let plain = matches!(explanation.tracker, Tracker::Plain);
    let all: Vec<usize> = (0..rows.len()).collect();
    let others = || all.iter().filter(|k| !gross.contains(k));
    if plain && others().all(|k| read(k) < GROSS) { all } else { gross.to_vec() }
}

/// A column's line with nothing to add.
pub(super) fn column(
    channel: LogChannel,
    place: usize,
    unit: &'static str,
    factor: f64,
) -> ColumnChange {
    let column = channel.entry().columns[place];
    let channel = short(column);
    ColumnChange { column, channel, unit, factor, fitted: 0.0, offset: 0.0, plus: None }
}

/// The line of an axis that is counted from the horizontal.
pub(super) fn coupled(coupling: Coupling) -> ColumnChange {
    let plain = |joint: usize| column(LogChannel::Encoder, joint, "rad", 1.0);
    let other = channel_named(plain(coupling.other).channel);
    ColumnChange { plus: other.map(|other| (other, coupling.times)), ..plain(coupling.joint) }
}

/// The lines of two columns that stand in each other's place.
pub(super) fn exchanged(
    channel: LogChannel,
    a: usize,
    b: usize,
    unit: &'static str,
) -> Vec<ColumnChange> {
    let [first, second] = [a, b].map(|place| column(channel, place, unit, 1.0));
    vec![
        ColumnChange { channel: second.channel, ..first.clone() },
        ColumnChange { channel: first.channel, ..second },
    ]
}

/// The name of a column's channel: without its unit.
fn short(column: &'static str) -> &'static str {
    unit_suffix(column).map_or(column, |(name, _)| name)
}

/// The mistakes that a reading of the encoders undoes; `fitted`: what a fitted slope is known to.
fn of_encoders(
    reading: EncoderReading,
    fitted: f64,
    named: &dyn Fn(MistakeKind, LogChannel, Vec<usize>, Vec<ColumnChange>) -> Mistake,
) -> Vec<Mistake> {
    let encoder = LogChannel::Encoder;
    let plain = |i: usize, factor: f64| column(encoder, i, "rad", factor);
    match reading {
        EncoderReading::Plain => Vec::new(),
        EncoderReading::Signs(set) => (0..JOINTS)
            .filter(|i| set & (1 << i) != 0)
            .map(|i| named(MistakeKind::Sign, encoder, vec![i], vec![plain(i, -1.0)]))
            .collect(),
        EncoderReading::Exchanged(a, b) => {
            let changes = exchanged(encoder, a, b, "rad");
            vec![named(MistakeKind::Exchanged, encoder, vec![a, b], changes)]
        }
        EncoderReading::Coupled(coupling) => {
            let (columns, change) = (vec![coupling.joint, coupling.other], coupled(coupling));
            vec![named(MistakeKind::Coupling, encoder, columns, vec![change])]
        }
        EncoderReading::Scaled(factor) => {
            let changes = (0..JOINTS).map(|i| in_degrees(plain(i, 1.0), factor)).collect();
            vec![named(MistakeKind::Unit, encoder, Vec::new(), changes)]
        }
        EncoderReading::Line(i, slope, offset) => {
            let change = ColumnChange { offset, ..in_degrees(plain(i, slope), slope.abs()) };
            let degrees = change.unit == "deg";
            let change = if degrees {
                ColumnChange { factor: slope.signum(), offset: offset.to_degrees(), ..change }
            } else {
                ColumnChange { fitted, ..change }
            };
            let kind = if degrees {
                MistakeKind::Unit
            } else if (slope.abs() - 1.0).abs() > 2.0 * WHOLE_SLOPE_TOLERANCE {
                MistakeKind::GearSide
            } else if slope < 0.0 {
                MistakeKind::Sign
            } else {
                MistakeKind::Zero
            };
            vec![named(kind, encoder, vec![i], vec![change])]
        }
    }
}

/// The line in degrees where the factor is that of degrees.
fn in_degrees(change: ColumnChange, factor: f64) -> ColumnChange {
    if is_near(factor, PI / 180.0) {
        ColumnChange { unit: "deg", factor: 1.0, ..change }
    } else if is_near(factor, 180.0 / PI) {
        ColumnChange { factor: 180.0 / PI, ..change }
    } else {
        change
    }
}

/// What a reading explains with a tracker that stands anywhere; `None` where no frame is told.
fn registered(
    rows: &[&LogRow],
    robot: &Robot<f64>,
    reading: EncoderReading,
) -> Option<ExplainedReading> {
    let seen = pose_pairs(rows, robot, reading);
    // An arm in motion bends by more than its load at rest: where there are poses at rest, they
    // tell the frame.
    let still: Vec<&LogRow> = rows.iter().filter(|row| row.at_rest).copied().collect();
    let still = pose_pairs(&still, robot, reading);
    let of_still = (still.len() >= AT_REST).then(|| register::frame(&still)).flatten();
    let of = |found| with(&seen, Tracker::Registered(found));
    let (of_still, of_all) = (of_still.and_then(of), register::frame(&seen).and_then(of));
    let found = of_still.filter(|e| e.left < GROSS).or(of_all)?;
    Some(ExplainedReading { reading, ..found })
}

/// What a reading explains with a tracker that stands anywhere and sees another point of the tool.
fn with_tool(
    rows: &[&LogRow],
    robot: &Robot<f64>,
    reading: EncoderReading,
) -> Option<ExplainedReading> {
    let seen = pose_pairs(rows, robot, reading);
    let found = with(&seen, Tracker::Registered(register::frame_and_tool(&seen)?))?;
    Some(ExplainedReading { reading, ..found })
}

/// What explains the poses of some rows; `None` where nothing does.
fn explain(rows: &[&LogRow], robot: &Robot<f64>) -> Option<ExplainedReading> {
    let plain = pose_pairs(rows, robot, EncoderReading::Plain);
    let before = with(&plain, Tracker::Plain)?.left;
    // The simplest first: one thing wrong, then a tracker elsewhere, then both.
    let mut best = Best { limit: (EXPLAINED_MISFIT_SHARE_MAX * before).min(GROSS), found: None };
    let readings = readings(robot);
    for reading in &readings {
        let seen = pose_pairs(rows, robot, *reading);
        best.take(with(&seen, Tracker::Plain).map(|e| ExplainedReading { reading: *reading, ..e }));
    }
    for factor in [1e-3, 1e3] {
        best.take(with(&plain, Tracker::Scaled(factor)));
    }
    for joint in 0..JOINTS {
        best.take(line::find(rows, robot, joint));
    }
    best.take(registered(rows, robot, EncoderReading::Plain));
    if best.found.is_none() {
        (0..3).for_each(|axis| best.take(with(&plain, Tracker::Mirrored(axis))));
    }
    if best.found.is_none() {
        readings.iter().for_each(|reading| best.take(registered(rows, robot, *reading)));
    }
    if best.found.is_none() {
        best.take(with_tool(rows, robot, EncoderReading::Plain));
    }
    if best.found.is_none() {
        let coupled = Coupling::all(robot).into_iter().map(EncoderReading::Coupled);
        coupled.for_each(|reading| best.take(with_tool(rows, robot, reading)));
    }
    best.found
}

/// Every reading that changes whole joints.
fn readings(robot: &Robot<f64>) -> Vec<EncoderReading> {
    // Fewer reversed axes before more.
    let mut sets: Vec<u8> = (1..1 << JOINTS).collect();
    sets.sort_by_key(|set| set.count_ones());
    let pairs =
        (0..JOINTS).flat_map(|a| (a + 1..JOINTS).map(move |b| EncoderReading::Exchanged(a, b)));
    let scales = [PI / 180.0, 180.0 / PI].map(EncoderReading::Scaled);
    let coupled = Coupling::all(robot).into_iter().map(EncoderReading::Coupled);
    let signs = sets.into_iter().map(EncoderReading::Signs);
    signs.chain(coupled).chain(pairs).chain(scales).collect()
}
