//! What no recording of a moving arm looks like: columns copied over each other, instruments that
//! stood still, rows at rest that move. A fit would find an effect in each of them.

use super::columns::named;
use super::samples::ColumnBuffer;
use crate::channel::{COUNT, LogChannel, column_name};
use crate::kind::LogKind;
use crate::resample::median_step;
use trueweld_plant::input::RobotFile;

/// Rows that a judgement rests on, at least.
const JUDGED_ROWS_MIN: usize = 20;

/// An arm that turns a joint by this much, rad, is seen to by every instrument.
const SEEN_TURN_MIN: f64 = 0.02;

/// Rows of a log at rest stand for a while: they are compared over this time, s, and may be off by
/// this much, rad. Rows further apart than `REST_ROW_INTERVAL_MAX` seconds say nothing.
const REST_TIME: f64 = 0.5;
const REST_ANGLE_MAX: f64 = 1e-3;
const REST_ROW_INTERVAL_MAX: f64 = 0.1;

/// What is wrong with the rows of a log, and what to do; `None` where they may have been recorded.
pub(super) fn refused(
    columns: &ColumnBuffer,
    kind: LogKind,
    robot: &RobotFile,
) -> Option<(String, &'static str)> {
    if let Some((a, b)) = copied(columns) {
        let message = format!(
            "`{}` and `{}` hold the same values in every row; expected what each was measured to be",
            column_name(a),
            column_name(b)
        );
        return Some((message, "Was one column copied over the other, or mapped twice?"));
    }
    if let (Some((joint, by)), Some(frozen)) = (most_moved(columns), frozen(columns)) {
        let message = format!(
            "{} hold one value in every row, while {} turns by {:.1}°; expected what was measured",
            named(&frozen),
            robot.joint_names[joint],
            by.to_degrees()
        );
        return Some((message, "Leave out the columns of an instrument that did not record."));
    }
    let share = moving(columns).filter(|_| kind == LogKind::StaticLoad)?;
    let message = format!(
        "the arm moves in {:.0} % of the rows; expected rows at rest in a static-load log",
        100.0 * share
    );
    let help =
        "Is the `kind` in log.toml right? Motion is \"free-motion\", \"ring-down\" or \"weld\".";
    Some((message, help))
}

/// Two columns of one channel with the same values.
fn copied(columns: &ColumnBuffer) -> Option<(usize, usize)> {
    let same = |a: usize, b: usize| {
        let (Some(a), Some(b)) = (&columns.values[a], &columns.values[b]) else { return false };
        is_copy(a, b)
    };
    let pairs = (0..COUNT).flat_map(|a| (a + 1..COUNT).map(move |b| (a, b)));
    let of_one = |(a, b): &(usize, usize)| {
        let channel = LogChannel::of(*a).0.id;
        channel == LogChannel::of(*b).0.id && channel != LogChannel::Payload
    };
    pairs.filter(of_one).find(|(a, b)| same(*a, *b))
}

/// True for series with the same values in every row that has both, of which many change.
fn is_copy(a: &[f64], b: &[f64]) -> bool {
    let both = || a.iter().zip(b).filter(|(a, b)| a.is_finite() && b.is_finite());
    let changes = || a.windows(2).filter(|w| w[0] != w[1] && !w[0].is_nan() && !w[1].is_nan());
    both().all(|(a, b)| a == b)
        && both().count() >= JUDGED_ROWS_MIN
        && changes().count() >= JUDGED_ROWS_MIN
}

/// The joint that moves most in a log of some length, and by how much, rad.
fn most_moved(columns: &ColumnBuffer) -> Option<(usize, f64)> {
    let range = |column: usize| {
        let series = columns.values[column].as_ref()?;
        let [low, high] = range(series)?;
        Some(high - low)
    };
    let joints = LogChannel::Encoder.columns().enumerate();
    let moved = joints.filter_map(|(joint, column)| Some((joint, range(column)?)));
    moved.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, by)| *by > SEEN_TURN_MIN)
}

/// Smallest and largest of some values; `None` where there are too few.
fn range(series: &[f64]) -> Option<[f64; 2]> {
    let known = || series.iter().copied().filter(|v| v.is_finite());
    let ends = [known().reduce(f64::min)?, known().reduce(f64::max)?];
    (known().count() >= JUDGED_ROWS_MIN).then_some(ends)
}

/// The columns of an instrument that reads the same in every row.
fn frozen(columns: &ColumnBuffer) -> Option<Vec<usize>> {
    let instruments = [LogChannel::Position, LogChannel::MotorTorque, LogChannel::LinkEncoder];
    instruments.into_iter().find_map(|channel| {
        let there: Vec<usize> =
            channel.columns().filter(|column| columns.values[*column].is_some()).collect();
        let stands = |column: &usize| {
            let series = columns.values[*column].as_ref()?;
            range(series).map(|[low, high]| low == high)
        };
        let all = !there.is_empty() && there.iter().all(|column| stands(column) == Some(true));
        all.then_some(there)
    })
}

/// Share of the rows in which an arm moves, where it is most of them.
fn moving(columns: &ColumnBuffer) -> Option<f64> {
    let step = median_step(&columns.time);
    let lag = (REST_TIME / step).ceil();
    if !(step > 0.0 && step < REST_ROW_INTERVAL_MAX && lag < 0.5 * columns.time.len() as f64) {
        return None;
    }
    let lag = lag as usize;
    let count = columns.time.len() - lag;
    let encoders: Vec<&Vec<f64>> =
        LogChannel::Encoder.columns().filter_map(|c| columns.values[c].as_ref()).collect();
    let moves = |k: &usize| encoders.iter().any(|q| (q[k + lag] - q[*k]).abs() > REST_ANGLE_MAX);
    let share = (0..count).filter(moves).count() as f64 / count as f64;
    (share > 0.5).then_some(share)
}
