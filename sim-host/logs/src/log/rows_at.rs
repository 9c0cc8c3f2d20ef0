//! What one instrument measured, at the times of another.

use super::samples::ColumnBuffer;
use super::track::FileTrack;
use crate::channel::{COUNT, LOG_CHANNELS, LogChannel};
use crate::clock::ClockMap;
use crate::fir::interpolate;
use crate::kind::LogKind;
use crate::resample::{Resampler, Weights, median_step};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use trueweld_core::Pose;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};

/// For each time the row that is nearest to it, if it is nearer to no other.
pub(super) fn nearest_rows(own: &[f64], other: &[f64]) -> Vec<Option<usize>> {
    let of = |(k, t): (usize, &f64)| {
        nearest_row(*t, other).filter(|row| nearest_row(other[*row], own) == Some(k))
    };
    own.iter().enumerate().map(of).collect()
}

/// The row whose time is nearest to a time.
fn nearest_row(time: f64, among: &[f64]) -> Option<usize> {
    let after = among.partition_point(|t| *t < time);
    let candidates = [after.checked_sub(1), (after < among.len()).then_some(after)];
    candidates
        .into_iter()
        .flatten()
        .min_by(|a, b| (among[*a] - time).abs().total_cmp(&(among[*b] - time).abs()))
}

/// Tool poses at the times of another track; NaN where there are none.
pub(super) fn poses_at(
    own: &[f64],
    path: &[Pose<f64>],
    times: &[f64],
    map: &ClockMap,
) -> Vec<Pose<f64>> {
    let positions: Vec<Vector3<f64>> = path.iter().map(|pose| pose.position).collect();
    let mut poses = Vec::with_capacity(times.len());
    for tau in times {
        let t = map.own(*tau);
        let after = own.partition_point(|o| *o <= t);
        let inside = after > 0 && (after < own.len() || own.last() == Some(&t));
        if !inside {
            let nowhere = Vector3::repeat(f64::NAN);
            poses.push(Pose { position: nowhere, rotation: Matrix3::identity() });
            continue;
        }
        let k = after - 1;
        let next = (k + 1).min(own.len() - 1);
        let share = if next > k { (t - own[k]) / (own[next] - own[k]) } else { 0.0 };
        let turned = rotation_vector(&path[k].rotation.tr_mul(&path[next].rotation));
        poses.push(Pose {
            position: interpolate(&positions, k as f64 + share),
            rotation: path[k].rotation * rotation_from_vector(&(turned * share)),
        });
    }
    poses
}

/// Reads a track's channels at the times of `columns`. `gain`: what becomes of their noise.
pub(super) fn read_at(
    track: &FileTrack,
    map: &ClockMap,
    kind: LogKind,
    columns: &mut ColumnBuffer,
    gain: &mut [f64; COUNT],
) {
    let times: Vec<f64> = track.time().iter().map(|t| map.own(*t)).collect();
    let resampler = Resampler::new(&times, median_step(&columns.time));
    for channel in LOG_CHANNELS.iter().filter(|c| !matches!(c.id, LogChannel::Time)) {
        if channel.id == LogChannel::Payload && kind != LogKind::StaticLoad {
            continue;
        }
        let all = channel.id.columns();
        let groups: Vec<Range<usize>> =
            if channel.together { vec![all] } else { all.map(|c| c..c + 1).collect() };
        for group in groups.into_iter().filter(|group| track.has(group.clone())) {
            let series: Vec<&[f64]> =
                group.clone().filter_map(|c| track.columns[c].as_deref()).collect();
            let turns = channel.id == LogChannel::Rotation;
            let (values, variance) = if series.iter().all(|s| s.iter().all(|v| v.is_finite())) {
                group_at(&resampler, &series, &columns.time, turns)
            } else {
                // Samples that lack a value are none.
                let whole = |k: &usize| series.iter().all(|s| s[*k].is_finite());
                let kept: Vec<usize> = (0..times.len()).filter(whole).collect();
                let pick = |s: &[f64]| kept.iter().map(|k| s[*k]).collect::<Vec<f64>>();
                let (times, series): (Vec<f64>, Vec<Vec<f64>>) =
                    (pick(&times), series.iter().map(|s| pick(s)).collect());
                let series: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
                let resampler = Resampler::new(&times, median_step(&columns.time));
                group_at(&resampler, &series, &columns.time, turns)
            };
            for (column, values) in group.zip(values) {
                columns.values[column] = Some(values);
                gain[column] = variance;
            }
        }
    }
}

/// Series at a grid of times, and the mean gain of their noise.
fn group_at(
    resampler: &Resampler<'_>,
    series: &[&[f64]],
    grid: &[f64],
    turns: bool,
) -> (Vec<Vec<f64>>, f64) {
    let mut out: Vec<Vec<f64>> = series.iter().map(|_| Vec::with_capacity(grid.len())).collect();
    let (mut from, mut weights) = (0, Weights::default());
    let (mut gains, mut count) = (0.0, 0.0);
    for time in grid {
        resampler.at(*time, &mut from, &mut weights);
        let (first, all) = (weights.first, &weights.weights);
        if all.is_empty() {
            out.iter_mut().for_each(|column| column.push(f64::NAN));
            continue;
        }
        gains += weights.gain();
        count += 1.0;
        if let ([_], true) | ([_], false) = (all.as_slice(), turns) {
            out.iter_mut().zip(series).for_each(|(column, s)| column.push(s[first]));
            continue;
        }
        if turns {
            // Rotations are weighed as what they turn from one of them.
            let vector = |k: usize| Vector3::new(series[0][k], series[1][k], series[2][k]);
            let middle = rotation_from_vector(&vector(first + all.len() / 2));
            let turned = |(k, w): (usize, &f64)| {
                rotation_vector(&middle.tr_mul(&rotation_from_vector(&vector(first + k)))) * *w
            };
            let sum: Vector3<f64> = all.iter().enumerate().map(turned).sum();
            let vector = rotation_vector(&(middle * rotation_from_vector(&sum)));
            out.iter_mut().zip(vector.iter()).for_each(|(column, v)| column.push(*v));
            continue;
        }
        for (column, s) in out.iter_mut().zip(series) {
            column.push(all.iter().zip(&s[first..]).map(|(w, v)| w * v).sum());
        }
    }
    let variance: f64 = if count > 0.0 { gains / count } else { 1.0 };
    (out, variance)
}
