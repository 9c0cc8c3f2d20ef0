//! Mistakes in the spindle's speed: against the speed that the process file states, and against the
//! force across the seam, whose side follows the spindle's sense.

use super::pose::column;
use super::rows::LogRow;
use super::{MisfitEvidence, Mistake, MistakeKind, Remedy};
use crate::predict::BaselineModel;
use std::f64::consts::{PI, TAU};
use trueweld_core::Robot;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{Log, LogKind};
use trueweld_plant::input::Process;
use trueweld_plant::process::planned;
use trueweld_plant::simulate::Seam;

/// Share by which a speed may differ from the stated one.
const SPINDLE_SPEED_TOLERANCE: f64 = 0.05;

/// Shares of the planned push with which the tool is in the plate, and presses.
const TOUCHES: f64 = 0.05;
const PRESSES: f64 = 0.5;

/// Units, what one of them is in rad/s, and the factor that goes with it in `[columns]`: the last one
/// is a speed that was taken to rad/s twice.
const SPINDLE_SPEED_UNITS: [(&str, f64, f64); 4] = [
    ("rpm", TAU / 60.0, 1.0),
    ("Hz", TAU, 1.0),
    ("deg/s", PI / 180.0, 1.0),
    ("rad/s", 60.0 / TAU, 60.0 / TAU),
];

/// Mistakes in the spindle's speed of welds whose wrenches are right.
pub(super) fn find(logs: &[Log], rows: &[Vec<LogRow>], model: &BaselineModel) -> Vec<Mistake> {
    let of_log = |(log, rows): (&Log, &Vec<LogRow>)| {
        let process = model.process.as_ref().or(log.process.as_ref())?;
        of_weld(log, rows, &model.robot, process)
    };
    let mut found = logs.iter().zip(rows).filter_map(of_log).collect();
    join(&mut found);
    found
}

/// The same mistake in several logs is one.
fn join(found: &mut Vec<Mistake>) {
    let mut joined: Vec<Mistake> = Vec::new();
    for mistake in found.drain(..) {
        let same = |m: &&mut Mistake| {
            (m.kind, m.channel, &m.change) == (mistake.kind, mistake.channel, &mistake.change)
        };
        match joined.iter_mut().find(same) {
            Some(first) => first.logs.extend(mistake.logs),
            None => joined.push(mistake),
        }
    }
    *found = joined;
}

fn of_weld(log: &Log, rows: &[LogRow], robot: &Robot<f64>, process: &Process) -> Option<Mistake> {
    let read = log.samples.spindle.as_ref().filter(|_| log.kind == LogKind::Weld)?;
    let turning: Vec<f64> = read.iter().copied().filter(|v| v.is_finite()).collect();
    let read = turning.iter().sum::<f64>() / turning.len() as f64;
    let stated = process.spindle;
    let is_stated = |speed: f64| (speed.abs() / stated.abs() - 1.0).abs() < SPINDLE_SPEED_TOLERANCE;
    let own = SPINDLE_SPEED_UNITS.into_iter().find(|(_, factor, _)| is_stated(read * factor));
    let (unit, per, factor) = match own {
        _ if is_stated(read) => ("rad/s", 1.0, 1.0),
        Some(unit) => unit,
        None => return None,
    };
    let speed = read * per;
    // A weld may be made with the spindle the other way: its force tells.
    let across = Across::of(log, rows, robot, &Process { spindle: speed, ..process.clone() });
    let across = across.filter(|across| speed.signum() != stated.signum() && across.denies());
    let reversed = across.is_some();
    let sign = if reversed { -1.0 } else { 1.0 };
    if per == 1.0 && !reversed {
        return None;
    }
    let (kind, evidence) = match across {
        Some(Across { as_read: before, reversed: after, .. }) if per == 1.0 => {
            let channel = LogChannel::Force;
            (MistakeKind::Sign, MisfitEvidence { before, after, unit: "N", channel })
        }
        _ => {
            let left = |speed: f64| (speed.abs() - stated.abs()).abs();
            let (before, after, channel) = (left(read), left(speed), LogChannel::Spindle);
            (MistakeKind::Unit, MisfitEvidence { before, after, unit: "rad/s", channel })
        }
    };
    Some(Mistake {
        kind,
        channel: LogChannel::Spindle,
        columns: Vec::new(),
        logs: vec![log.name.clone()],
        evidence,
        change: Remedy::Columns(vec![column(LogChannel::Spindle, 0, unit, sign * factor)]),
        lines: Vec::new(),
    })
}

/// Force across the seam against the process, with the spindle as it was read and the other way.
struct Across {
    /// Root mean square of what is left, N.
    as_read: f64,
    reversed: f64,
    /// Mean size of what the sense decides, N.
    side: f64,
}

impl Across {
    /// Of the later half of the rows that pressed; `None` where no force was recorded.
    fn of(log: &Log, rows: &[LogRow], robot: &Robot<f64>, process: &Process) -> Option<Self> {
        let [_, across, _] = log.samples.unmeasured_force;
        if log.samples.force.is_none() || across {
            return None;
        }
        let weld = log.weld.as_ref().filter(|weld| weld.force > 0.0)?;
        let seam = Seam::of(weld);
        // Path and channel behind the tool, m.
        let mut behind: Option<[f64; 2]> = None;
        let mut firm: Vec<[f64; 3]> = Vec::new();
        // The bent arm is millimetres beside what the encoders tell: the one and the other by turns
        // would be a tool that jumps.
        let tracked = rows.iter().any(|row| row.position.is_some());
        for row in rows.iter().filter(|row| row.position.is_some() == tracked) {
            let push = -row.wrench.force.z;
            if push < TOUCHES * weld.force {
                continue;
            }
            let tool = robot.forward_kinematics(&row.encoder);
            let placed = seam.place(&row.position.unwrap_or(tool.position));
            let [path, across] = [placed.position.x, placed.position.y];
            let channel = behind.map_or(across, |[before, channel]| {
                let left = (-(path - before).abs() / process.model.memory_length()).exp();
                across + (channel - across) * left
            });
            behind = Some([path, channel]);
            if push > PRESSES * weld.force {
                let measured = placed.axes.tr_mul(&(tool.rotation * row.wrench.force)).y;
                let reference = process.model.reference_force();
                let stiffness = process.model.channel_stiffness(reference);
                let by_channel = stiffness * (channel - across) * (push / reference);
                let side = planned(process, push, weld.feed).y;
                firm.push([measured, by_channel, side]);
            }
        }
        let later = &firm[firm.len() / 2..];
        let mean =
            |of: &dyn Fn(&[f64; 3]) -> f64| later.iter().map(of).sum::<f64>() / later.len() as f64;
        let left = |sign: f64| mean(&|[m, c, s]| (m - c - sign * s).powi(2)).sqrt();
        (!later.is_empty()).then(|| Self {
            as_read: left(1.0),
            reversed: left(-1.0),
            side: mean(&|[_, _, side]| side.abs()),
        })
    }

    /// True where the force fits the other sense of the spindle better, as the process file does, or is
    /// too small to tell it: one of the files is wrong then.
    fn denies(&self) -> bool {
        /// Force that tells nothing, N.
        const TELLING_FORCE_MIN: f64 = 50.0;
        self.side < TELLING_FORCE_MIN || self.reversed < self.as_read
    }
}
