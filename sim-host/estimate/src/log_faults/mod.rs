//! Gross mistakes in the files, looked for before any physics: an axis reversed, a zero elsewhere,
//! axes exchanged, another unit, the motor's side of the gear, a wrench's other side, axes or point, a
//! time in milliseconds, a payload that nobody wrote down.
//!
//! Such a mistake leaves a residual that no effect of a cell does: centimetres, radians, torques of
//! another sign. Each is a hypothesis that changes the numbers as they were read; the one that
//! explains the residual is named, with the line that undoes it. A tracker that stands anywhere is no
//! mistake: its frame is found and taken out ([`Registered`]).

mod current;
mod deflections;
mod line;
mod load;
mod mounted;
mod payload;
mod pose;
mod reading;
mod refine;
mod relation;
mod rows;
mod second;
mod spindle;
mod wrench;
mod write;

use crate::predict::{BaselineModel, period};
use nalgebra::Vector3;
use rows::LogRow;
use trueweld_core::{JOINTS, JointVector, Pose};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{ColumnMapping, Log, LogKind};
use trueweld_logs::register::{self, PosePair, Registration};
use trueweld_plant::input::InputError;
use trueweld_plant::named;
use trueweld_plant::simulate::Seam;

named! {
    /// What is wrong.
    pub enum MistakeKind {
        /// Angles or torques of a joint count the other way.
        Sign = "sign",
        /// Angles of a joint count from another zero.
        Zero = "zero",
        /// Columns of two joints, or of two directions, stand in each other's place.
        Exchanged = "exchanged",
        /// The angle of an axis is counted from the horizontal: it holds that of the joint before.
        Coupling = "coupling",
        /// Values are in another unit.
        Unit = "unit",
        /// Values are of the motor's side of the gear.
        GearSide = "gear-side",
        /// The tracker's frame is left-handed, or another one in every log.
        TrackerFrame = "tracker-frame",
        /// Times are in another unit.
        TimeUnit = "time-unit",
        /// The wrench is what the tool applies.
        WrenchSide = "wrench-side",
        /// The wrench is in other axes than the tool's.
        WrenchAxes = "wrench-axes",
        /// The moment is about another point than the tool centre point.
        WrenchPoint = "wrench-point",
        /// A mass hangs on the flange that neither log nor robot states.
        Payload = "payload",
    }
}

/// What a residual was before a mistake is undone, and after.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MisfitEvidence {
    /// Root mean square as the files are.
    pub before: f64,
    /// Root mean square with the mistake undone.
    pub after: f64,
    /// Unit of both.
    pub unit: &'static str,
    /// What is compared.
    pub channel: LogChannel,
}

/// One line of `[columns]` of a `log.toml`: what a column really holds.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnChange {
    /// The column.
    pub column: &'static str,
    /// The channel that it holds.
    pub channel: &'static str,
    /// Unit that its values are in.
    pub unit: &'static str,
    /// What they are to be multiplied by.
    pub factor: f64,
    /// What a fitted factor is known to, as a share of it (half of 95 %); zero for a plain one.
    pub fitted: f64,
    /// What is then to be added, in the unit.
    pub offset: f64,
    /// Column of a channel that is to be added, and how many times.
    pub plus: Option<(usize, f64)>,
}

/// The lines of `[columns]` that undo a mistake, as they stand in the `log.toml` of some logs
/// afterwards.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnLines {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// The lines.
    pub lines: Vec<ColumnMapping>,
    /// True where they take the place of lines with the same headers.
    pub replace: bool,
}

/// How the force sensor sits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrenchFrame {
    /// The sensor's axes, and the point that its moment is about, in T, m: `t_from_sensor`.
    pub pose: Pose<f64>,
    /// 95 % half-widths of the point along the axes of T, m; zero where it was not fitted.
    pub point_interval: [f64; 3],
    /// 95 % half-widths of the axes about those of T, rad; zero where they are plain or were not
    /// fitted.
    pub axes_interval: [f64; 3],
    /// True where the logs have such a table, in whose place it comes.
    pub replace: bool,
}

/// What undoes a mistake.
#[derive(Debug, Clone, PartialEq)]
pub enum Remedy {
    /// Lines under `[columns]` of the logs' `log.toml`.
    Columns(Vec<ColumnChange>),
    /// The table `[wrench]` of the logs' `log.toml`.
    WrenchFrame(WrenchFrame),
    /// A mass under `[tool]` of the robot file, kg.
    ToolMass(f64),
    /// Columns of what hangs on the flange, kg.
    PayloadColumns(f64),
}

/// A mistake that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Mistake {
    /// What it is.
    pub kind: MistakeKind,
    /// The channel that it is in.
    pub channel: LogChannel,
    /// Columns of the channel that it is in, from 0; none where it is in all of them.
    pub columns: Vec<usize>,
    /// Names of the logs that it is in.
    pub logs: Vec<String>,
    /// What shows it.
    pub evidence: MisfitEvidence,
    /// What undoes it.
    pub change: Remedy,
    /// The same as lines of `[columns]`, composed with those that the logs have; one entry where the
    /// same lines undo it in all logs.
    pub lines: Vec<ColumnLines>,
}

impl Mistake {
    /// One that other lines of `[columns]` undo, in logs of these names.
    fn of_columns(
        kind: MistakeKind,
        channel: LogChannel,
        columns: Vec<usize>,
        logs: &[String],
        evidence: MisfitEvidence,
        changes: Vec<ColumnChange>,
    ) -> Self {
        let (logs, change) = (logs.to_vec(), Remedy::Columns(changes));
        Self { kind, channel, columns, logs, evidence, change, lines: Vec::new() }
    }
}

/// The frame of a tracker that was found, and taken out of the logs.
#[derive(Debug, Clone)]
pub struct Registered {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Frame and tool's offset.
    pub registration: Registration,
}

/// What was found before any physics.
#[derive(Debug, Clone, Default)]
pub struct Found {
    /// Mistakes; the first one explains most.
    pub mistakes: Vec<Mistake>,
    /// Trackers that stood elsewhere.
    pub registered: Vec<Registered>,
}

/// Sampling period from which on times of a log in motion are not in seconds, s, unless a joint would
/// turn faster in another unit than any does, rad/s.
const SAMPLING_PERIOD_MAX: f64 = 0.25;
const JOINT_RATE_MAX: f64 = 20.0;

/// Looks for gross mistakes. Trackers that stand elsewhere than the model's base are registered: their
/// readings in `logs` are those of a tracker in B afterwards.
///
/// # Errors
/// A value, or a tool, that cannot be right, where no mistake explains it.
pub fn find(logs: &mut [Log], model: &BaselineModel) -> Result<Found, InputError> {
    let implausible = logs.iter().find_map(|log| log.implausible.clone());
    let mut found = match (found(logs, model), implausible) {
        (Ok(found), Some(implausible)) if found.mistakes.is_empty() => return Err(implausible),
        (Err(_), Some(implausible)) => return Err(implausible),
        (found, _) => found?,
    };
    for mistake in &mut found.mistakes {
        mistake.lines = write::lines(mistake, logs);
    }
    Ok(found)
}

/// Turns currents whose factors are not stated into torque, of logs that are compared without a model:
/// by their own robot.
pub fn scale_currents(logs: &mut [Log]) {
    let Some(robot) = logs.first().map(|log| log.robot.robot.clone()) else { return };
    let rows: Vec<Vec<LogRow>> = logs.iter().map(LogRow::of).collect();
    current::scale(logs, &rows, &robot, &[None; JOINTS]);
}

fn found(logs: &mut [Log], model: &BaselineModel) -> Result<Found, InputError> {
    let mut found = Found::default();
    found.mistakes.extend(time_units(logs));
    if !found.mistakes.is_empty() {
        return Ok(found);
    }
    let mut rows: Vec<Vec<LogRow>> = logs.iter().map(LogRow::of).collect();
    let names: Vec<&str> = logs.iter().map(|log| log.name.as_str()).collect();
    let of_poses = pose::find(&names, &rows, &model.robot);
    if let Some((log, misfit)) = of_poses.lost {
        // Poses are compared under the measured load, which may be what is wrong.
        found.mistakes.extend(wrench::find(logs, &rows, model));
        if found.mistakes.is_empty() {
            return Err(logs[log].of_another_robot(misfit));
        }
        return Ok(found);
    }
    found.mistakes.extend(of_poses.mistakes);
    for (in_logs, registration) in of_poses.registered {
        let mounting = &registration.mounting;
        in_logs.iter().for_each(|k| logs[*k].register(mounting, &model.robot));
        let logs = in_logs.iter().map(|k| logs[*k].name.clone()).collect();
        found.registered.push(Registered { logs, registration });
    }
    if found.mistakes.is_empty() {
        // With the trackers where they belong.
        if !found.registered.is_empty() {
            rows = logs.iter().map(LogRow::of).collect();
        }
        if current::scale(logs, &rows, &model.robot, &model.torque_constants) {
            rows = logs.iter().map(LogRow::of).collect();
        }
        found.mistakes.extend(second::find(logs));
        found.mistakes.extend(load::find(logs, &rows, model));
    }
    if found.mistakes.is_empty()
        && let Some(refusal) =
            logs.iter().zip(&rows).find_map(|(log, rows)| off_its_weld(log, rows, model))
    {
        return Err(refusal);
    }
    if found.mistakes.is_empty()
        && let Some(refusal) = wrench::contradicted(logs, &rows, &model.robot)
    {
        return Err(refusal);
    }
    if found.mistakes.is_empty()
        && let Some(log) = load::read_backwards(logs, &rows, &model.robot)
    {
        return Err(log.backwards());
    }
    if found.mistakes.is_empty() && !found.registered.is_empty() {
        refine::refine(logs, &mut found.registered, model);
    }
    Ok(found)
}

/// Why a weld log is none of its seam: its tool was nowhere near it, went the other way, or pressed
/// where there is no plate.
fn off_its_weld(log: &Log, rows: &[LogRow], model: &BaselineModel) -> Option<InputError> {
    /// What a tool may be beside the seam, or go backwards along it, m: a taught path is off by
    /// millimetres.
    const SEAM_DISTANCE_MAX: f64 = 0.1;
    let weld = log.weld.as_ref().filter(|_| log.kind == LogKind::Weld)?;
    let seam = Seam::of(weld);
    let place =
        |row: &LogRow| seam.place(&model.robot.forward_kinematics(&row.encoder).position).position;
    let away = |row: &LogRow| {
        let at = place(row);
        (at - Vector3::x() * at.x.clamp(0.0, seam.length)).norm()
    };
    if let Some(away) =
        refine::quantile(rows.iter().map(away), 5).filter(|away| *away > SEAM_DISTANCE_MAX)
    {
        return Some(log.of_another_weld(away));
    }
    let travel = place(rows.last()?).x - place(rows.first()?).x;
    if travel < -SEAM_DISTANCE_MAX.min(0.5 * seam.length) {
        return Some(log.against_its_weld(-travel));
    }
    let far = far_from_surface(log, &seam, weld.force)?;
    (far > ON_SURFACE).then(|| log.off_its_surface(far))
}

/// What a tool that presses may be from the surface, m: it stands in the plate by less, and plates
/// are clamped, and trackers registered, to a millimetre or two.
const ON_SURFACE: f64 = 5e-3;

/// How far from the surface the tool was seen at most, m, in nine of ten rows in which it pressed by
/// half of `push`, N, at least; `None` where nobody saw the tool's centre, or it never did.
fn far_from_surface(log: &Log, seam: &Seam, push: f64) -> Option<f64> {
    let (force, position) = (log.samples.force.as_ref()?, log.samples.position.as_ref()?);
    if log.origin.target.is_some_and(|at| at != Vector3::zeros()) {
        return None;
    }
    let pressed = force.iter().zip(position).filter(|(f, _)| f.z.abs() > 0.5 * push);
    let far = pressed.map(|(_, at)| seam.place(at).position.z.abs());
    refine::quantile(far.filter(|far| far.is_finite()), 9)
}

/// Where the trackers of some logs stand: one that all of them share, or where that leaves much, one
/// for each log that tells.
pub fn registrations(logs: &[Log], model: &BaselineModel) -> Vec<Registered> {
    /// What one tracker may leave, m, before each log gets its own.
    const SHARED: f64 = 3e-3;
    let seen: Vec<Vec<PosePair>> =
        logs.iter().map(|log| pose::plain_pose_pairs(log, &model.robot)).collect();
    let tracked: Vec<usize> = (0..logs.len()).filter(|k| !seen[*k].is_empty()).collect();
    let mut registered = match one_tracker(logs, &seen, &tracked) {
        Some(all) if all.registration.left[0] < SHARED => vec![all],
        all => {
            let each = tracked.iter().filter_map(|k| one_tracker(logs, &seen, &[*k]));
            let each: Vec<Registered> = each.collect();
            if each.is_empty() { all.into_iter().collect() } else { each }
        }
    };
    let mut logs = logs.to_vec();
    for found in &registered {
        let own = logs.iter_mut().filter(|log| found.logs.contains(&log.name));
        own.for_each(|l| l.register(&found.registration.mounting, &model.robot));
    }
    refine::refine(&mut logs, &mut registered, model);
    registered
}

/// Where the one tracker of some logs stands; `None` where nothing tells it. `seen`: the poses of
/// every log; `members`: the logs by their places.
fn one_tracker(logs: &[Log], seen: &[Vec<PosePair>], members: &[usize]) -> Option<Registered> {
    let of = |wanted: &dyn Fn(&usize) -> bool| -> Vec<PosePair> {
        members.iter().filter(|k| wanted(k)).flat_map(|k| seen[*k].clone()).collect()
    };
    // An arm in motion bends by more than its load at rest.
    let still = of(&|k| logs[*k].kind == LogKind::StaticLoad);
    let pose_pairs = if still.len() >= reading::AT_REST { still } else { of(&|_| true) };
    let alone = register::frame(&pose_pairs)?;
    let whole = register::frame_and_tool(&pose_pairs);
    // Without a reason the tracker sees the tool centre point.
    let found = whole.filter(|w| w.left[0] < 0.5 * alone.left[0]).unwrap_or(alone);
    let names = members.iter().map(|k| logs[*k].name.clone()).collect();
    Some(Registered { logs: names, registration: found })
}

/// True for a weld whose tool moves about as fast as its feed: its times are in seconds.
fn is_at_feed(log: &Log) -> bool {
    let (Some(weld), [begin, .., end]) = (&log.weld, log.samples.time.as_slice()) else {
        return false;
    };
    let robot = &log.robot.robot;
    let at = |q: &JointVector<f64>| robot.forward_kinematics(q).position;
    let ways = log.samples.encoder.windows(2).map(|q| (at(&q[1]) - at(&q[0])).norm());
    let speed = ways.filter(|way| way.is_finite()).sum::<f64>() / (end - begin);
    (0.1..10.0).contains(&(speed / weld.feed))
}

/// Logs in motion whose times are not in seconds.
fn time_units(logs: &[Log]) -> Vec<Mistake> {
    let slow = |log: &&Log| {
        log.kind != LogKind::StaticLoad && period(log) >= SAMPLING_PERIOD_MAX && !is_at_feed(log)
    };
    let mut slow: Vec<&Log> = logs.iter().filter(slow).collect();
    let Some(step) = slow.iter().map(|log| period(log)).reduce(f64::max) else {
        return Vec::new();
    };
    let (unit, factor) = if step < SAMPLING_PERIOD_MAX * 1e3 { ("ms", 1e-3) } else { ("us", 1e-6) };
    slow.retain(|log| {
        let turned = log.samples.encoder.windows(2).map(|q| (q[1] - q[0]).amax());
        turned.fold(0.0, f64::max) < JOINT_RATE_MAX * factor * period(log)
    });
    if slow.is_empty() {
        return Vec::new();
    }
    vec![Mistake {
        kind: MistakeKind::TimeUnit,
        channel: LogChannel::Time,
        columns: Vec::new(),
        logs: slow.iter().map(|log| log.name.clone()).collect(),
        evidence: MisfitEvidence {
            before: step,
            after: step * factor,
            unit: "s",
            channel: LogChannel::Time,
        },
        change: Remedy::Columns(vec![pose::column(LogChannel::Time, 0, unit, 1.0)]),
        lines: Vec::new(),
    }]
}
