//! Mistakes in the spindle's speed: against the speed that the process file states, and against the
//! force across the seam, whose side follows the spindle's sense.

use super::load::join;
use super::pose::column;
use super::rows::Row;
use super::{Change, Evidence, Mistake, MistakeKind};
use crate::data::channel::LogChannel;
use crate::data::log::{Log, LogKind};
use crate::predict::Model;
use nalgebra::Vector3;
use std::f64::consts::{PI, TAU};
use trueweld_core::Robot;
use trueweld_plant::input::Process;
use trueweld_plant::process::planned;
use trueweld_plant::simulate::Seam;

/// Share by which a speed may differ from the stated one.
const NEAR: f64 = 0.05;

/// Units, what one of them is in rad/s, and the factor that goes with it in `[columns]`: the last one
/// is a speed that was taken to rad/s twice.
const UNITS: [(&str, f64, f64); 4] = [
    ("rpm", TAU / 60.0, 1.0),
    ("Hz", TAU, 1.0),
    ("deg/s", PI / 180.0, 1.0),
    ("rad/s", 60.0 / TAU, 60.0 / TAU),
];

/// Mistakes in the spindle's speed of welds whose wrenches are right.
pub(super) fn find(logs: &[Log], rows: &[Vec<Row>], model: &Model) -> Vec<Mistake> {
    let of_log = |(log, rows): (&Log, &Vec<Row>)| {
        let process = model.process.as_ref().or(log.process.as_ref())?;
        of_weld(log, rows, &model.robot, process)
    };
    let mut found = logs.iter().zip(rows).filter_map(of_log).collect();
    join(&mut found);
    found
}

fn of_weld(log: &Log, rows: &[Row], robot: &Robot<f64>, process: &Process) -> Option<Mistake> {
    let read = log.samples.spindle.as_ref().filter(|_| log.kind == LogKind::Weld)?;
    let turning: Vec<f64> = read.iter().copied().filter(|v| v.is_finite()).collect();
    let read = turning.iter().sum::<f64>() / turning.len() as f64;
    let stated = process.spindle;
    let is_stated = |speed: f64| (speed.abs() / stated.abs() - 1.0).abs() < NEAR;
    let own = UNITS.into_iter().find(|(_, factor, _)| is_stated(read * factor));
    let (unit, per, factor) = match own {
        _ if is_stated(read) => ("rad/s", 1.0, 1.0),
        Some(unit) => unit,
        None => return None,
    };
    let speed = read * per;
    // A weld may be made with the spindle the other way: its force tells.
    let across = across(log, rows, robot, &Process { spindle: speed, ..process.clone() });
    let reversed = speed.signum() != stated.signum()
        && across.is_some_and(|[measured, expected]| is_other_way(measured, expected));
    let sign = if reversed { -1.0 } else { 1.0 };
    if per == 1.0 && !reversed {
        return None;
    }
    let (kind, evidence) = match across {
        Some([measured, expected]) if per == 1.0 => {
            let left = |expected: f64| (measured - expected).abs();
            let channel = LogChannel::Force;
            let (before, after) = (left(expected), left(-expected));
            (MistakeKind::Sign, Evidence { before, after, unit: "N", channel })
        }
        _ => {
            let left = |speed: f64| (speed.abs() - stated.abs()).abs();
            let (before, after, channel) = (left(read), left(speed), LogChannel::Spindle);
            (MistakeKind::Unit, Evidence { before, after, unit: "rad/s", channel })
        }
    };
    Some(Mistake {
        kind,
        channel: LogChannel::Spindle,
        columns: Vec::new(),
        logs: vec![log.name.clone()],
        evidence,
        change: Change::Columns(vec![column(LogChannel::Spindle, 0, unit, sign * factor)]),
        lines: Vec::new(),
    })
}

/// True where a force across the seam, N, speaks against the sense of the spindle, or is too small to
/// tell it: one of the files is wrong then.
fn is_other_way(measured: f64, expected: f64) -> bool {
    /// Force that tells nothing, N.
    const FAINT: f64 = 50.0;
    expected.abs() < FAINT || measured * expected < 0.0
}

/// Force across the seam, N, in the later half of the rows that pressed, when the channel behind the
/// tool has followed it: measured, and what the process makes of the measured push. `None` where no
/// force was recorded.
fn across(log: &Log, rows: &[Row], robot: &Robot<f64>, process: &Process) -> Option<[f64; 2]> {
    log.samples.force.as_ref()?;
    let weld = log.weld.as_ref()?;
    let seam = Seam::of(weld);
    let firm: Vec<&Row> =
        rows.iter().filter(|row| -row.wrench.force.z > 0.5 * weld.force).collect();
    let later = &firm[firm.len() / 2..];
    let of_row = |row: &&Row| {
        let tool = robot.forward_kinematics(&row.encoder);
        let axes = seam.place(&tool.position).axes;
        let measured = axes.tr_mul(&(tool.rotation * row.wrench.force));
        let expected: Vector3<f64> = planned(process, -row.wrench.force.z, weld.feed);
        [measured.y, expected.y]
    };
    let sums = later.iter().map(of_row).fold([0.0; 2], |s, f| [s[0] + f[0], s[1] + f[1]]);
    (!later.is_empty()).then(|| sums.map(|sum| sum / later.len() as f64))
}
