//! What instruments read that they did not measure: found in the columns themselves, before any
//! model.

use super::columns::{ABC, MATRIX, QUATERNION, REFLECTORS, reflector, shown_name};
use super::noise::NoiseLevels;
use super::notice::LogNotice;
use super::samples::Columns;
use super::track::Track;
use crate::data::channel::{CHANNELS, LogChannel};
use crate::data::clipped::clipped;
use crate::data::floor::relative_rotation;
use crate::data::held::held;
use crate::data::kind::LogKind;
use crate::data::outlier::outliers;
use crate::data::resample::{Resampler, Weights, median_step};
use nalgebra::Vector3;
use std::ops::Range;

/// Channels of which a single reading may be out. A drive's torque is none: where friction lets go, a
/// real drive gives two or three rows of twice the torque (the recorded KR 300 does), and its
/// numbers come out of the controller itself.
const SCREENED: [LogChannel; 5] = [
    LogChannel::LinkEncoder,
    LogChannel::Force,
    LogChannel::Moment,
    LogChannel::Position,
    LogChannel::Rotation,
];

/// Most rows of a channel, as a share, that are left out as outliers: what occurs more often is how
/// the instrument, or the cell, is.
const FEW: f64 = 0.03;

/// Leaves out readings that one file repeats until the next one comes. Encoders, which drive the
/// model, are interpolated there: the number of rows for each of their readings is returned. Rows at
/// rest have nothing between them.
pub(super) fn leave_out_repeats(
    track: &mut Track,
    kind: LogKind,
    notices: &mut Vec<LogNotice>,
) -> f64 {
    let mut rows_an_encoder = 1.0;
    if kind == LogKind::StaticLoad {
        return rows_an_encoder;
    }
    let measured = CHANNELS
        .iter()
        .map(|channel| channel.id)
        .filter(|id| !matches!(id, LogChannel::Time | LogChannel::Spindle | LogChannel::Payload));
    let instruments: Vec<Range<usize>> = measured
        .map(LogChannel::columns)
        .chain([ABC, QUATERNION, MATRIX])
        .chain((0..REFLECTORS).map(reflector))
        .collect();
    for instrument in instruments {
        let there: Vec<usize> = instrument.filter(|c| track.columns[*c].is_some()).collect();
        let series: Vec<&[f64]> =
            there.iter().filter_map(|c| track.columns[*c].as_deref()).collect();
        let Some(held) = held(&series) else { continue };
        let interpolated = LogChannel::Encoder.columns().contains(&there[0]);
        for column in &there {
            let Some(mut series) = track.columns[*column].take() else { continue };
            held.repeats.iter().for_each(|row| series[*row] = f64::NAN);
            if interpolated {
                series = between_readings(track.time(), &series);
            }
            track.columns[*column] = Some(series);
        }
        if interpolated {
            rows_an_encoder = held.every;
        }
        let columns = there.into_iter().map(shown_name).collect();
        notices.push(LogNotice::Held { columns, every: held.every, interpolated });
    }
    rows_an_encoder
}

/// A series with its missing rows interpolated; those before the first reading and after the last stay
/// missing.
fn between_readings(time: &[f64], series: &[f64]) -> Vec<f64> {
    let known = (0..series.len()).filter(|k| series[*k].is_finite());
    let (times, readings): (Vec<f64>, Vec<f64>) = known.map(|k| (time[k], series[k])).unzip();
    let resampler = Resampler::new(&times, median_step(&times));
    let (mut from, mut weights) = (0, Weights::default());
    let at = |(value, time): (&f64, &f64)| {
        if value.is_finite() {
            return *value;
        }
        resampler.at(*time, &mut from, &mut weights);
        let values = readings.get(weights.first..).unwrap_or(&[]);
        match weights.weights.as_slice() {
            [] => f64::NAN,
            weights => weights.iter().zip(values).map(|(w, v)| w * v).sum(),
        }
    };
    series.iter().zip(time).map(at).collect()
}

/// Leaves out what was not measured: its values are missing afterwards. `noise`: as stated. Rows at
/// rest have no neighbours in time.
pub(super) fn leave_out(
    columns: &mut Columns,
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
    for channel in SCREENED {
        leave_out_outliers(columns, channel, noise, notices);
    }
}

fn leave_out_clipped(columns: &mut Columns, channel: LogChannel, notices: &mut Vec<LogNotice>) {
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
    columns: &mut Columns,
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
        let left_out = rows.len() as f64 <= FEW * readings as f64;
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
fn series(columns: &Columns, channel: LogChannel) -> Vec<Option<Vec<f64>>> {
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
