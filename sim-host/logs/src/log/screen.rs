//! What instruments read that they did not measure: found in the columns themselves, before any
//! model.

use super::columns::shown_name;
use super::noise::NoiseLevels;
use super::notice::LogNotice;
use super::samples::ColumnBuffer;
use crate::channel::LogChannel;
use crate::clipped::clipped;
use crate::floor::relative_rotation;
use crate::kind::LogKind;
use crate::outlier::outliers;
use nalgebra::Vector3;

/// Channels of which a single reading may be out. A drive's torque is none: where friction lets go, a
/// real drive gives two or three rows of twice the torque (the recorded KR 300 does), and its
/// numbers come out of the controller itself.
const SCREENED_CHANNELS: [LogChannel; 5] = [
    LogChannel::LinkEncoder,
    LogChannel::Force,
    LogChannel::Moment,
    LogChannel::Position,
    LogChannel::Rotation,
];

/// Most rows of a channel, as a share, that are left out as outliers: what occurs more often is how
/// the instrument, or the cell, is.
const OUTLIER_SHARE_MAX: f64 = 0.03;

/// Leaves out what was not measured: its values are missing afterwards. `noise`: as stated. Rows at
/// rest have no neighbours in time.
pub(super) fn leave_out(
    columns: &mut ColumnBuffer,
    kind: LogKind,
    noise: &NoiseLevels,
    notices: &mut Vec<LogNotice>,
) {
    if kind == LogKind::StaticLoad {
        return;
    }
    for channel in
        [LogChannel::MotorTorque, LogChannel::Force, LogChannel::Moment, LogChannel::Position]
    {
        leave_out_clipped(columns, channel, notices);
    }
    for channel in SCREENED_CHANNELS {
        leave_out_outliers(columns, channel, noise, notices);
    }
}

fn leave_out_clipped(
    columns: &mut ColumnBuffer,
    channel: LogChannel,
    notices: &mut Vec<LogNotice>,
) {
    let unit = channel.unit();
    let mut found = Vec::new();
    for column in channel.columns() {
        let Some(series) = &columns.values[column] else { continue };
        let others: Vec<&[f64]> = channel
            .columns()
            .filter(|other| *other != column)
            .filter_map(|other| columns.values[other].as_deref())
            .collect();
        let centred = channel != LogChannel::Position;
        let clipped = clipped(series, &others, centred);
        found.extend(clipped.into_iter().map(|clipped| (column, clipped)));
    }
    for (column, clipped) in found {
        if let Some(series) = &mut columns.values[column] {
            clipped.stretches.into_iter().for_each(|rows| series[rows].fill(f64::NAN));
        }
        let (limit, rows) = (clipped.limit, clipped.rows);
        notices.push(LogNotice::Clipped { column: shown_name(column), limit, unit, rows });
    }
}

fn leave_out_outliers(
    columns: &mut ColumnBuffer,
    channel: LogChannel,
    noise: &NoiseLevels,
    notices: &mut Vec<LogNotice>,
) {
    let together = channel.entry().together;
    let levels = noise.of(channel);
    let series = series(columns, channel);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (place, _) in series.iter().enumerate().filter(|(_, s)| s.is_some()) {
        match groups.last_mut() {
            Some(group) if together => group.push(place),
            _ => groups.push(vec![place]),
        }
    }
    for group in groups {
        let mut rows: Vec<usize> = Vec::new();
        let mut largest = 0.0_f64;
        let mut readings = 0;
        for place in &group {
            let Some(series) = &series[*place] else { continue };
            let stated = levels[*place].map_or(0.0, |level| level.deviation);
            let found = outliers(&columns.time, series, stated);
            readings = readings.max(series.iter().filter(|v| v.is_finite()).count());
            largest = found.iter().fold(largest, |most, (_, size)| most.max(*size));
            rows.extend(found.iter().map(|(row, _)| *row));
        }
        rows.sort_unstable();
        rows.dedup();
        if rows.is_empty() {
            continue;
        }
        let left_out = rows.len() as f64 <= OUTLIER_SHARE_MAX * readings as f64;
        let column = |place: &usize| channel.columns().start + place;
        if left_out {
            for place in &group {
                if let Some(series) = &mut columns.values[column(place)] {
                    rows.iter().for_each(|row| series[*row] = f64::NAN);
                }
            }
        }
        notices.push(LogNotice::Outliers {
            columns: group.iter().map(|place| shown_name(column(place))).collect(),
            rows: rows.len(),
            largest,
            unit: channel.entry().unit,
            left_out,
        });
    }
}

/// The series of a channel; rotations as what they turn from row to row, summed up.
fn series(columns: &ColumnBuffer, channel: LogChannel) -> Vec<Option<Vec<f64>>> {
    let of = |column: usize| columns.values[column].clone();
    let all: Vec<Option<Vec<f64>>> = channel.columns().map(of).collect();
    let [Some(x), Some(y), Some(z)] = &all[..] else { return all };
    if channel != LogChannel::Rotation {
        return all;
    }
    let vectors: Vec<Vector3<f64>> = (0..x.len()).map(|k| Vector3::new(x[k], y[k], z[k])).collect();
    let summed = relative_rotation(&vectors);
    [0, 1, 2].map(|c| Some(summed.iter().map(|v| v[c]).collect())).to_vec()
}
