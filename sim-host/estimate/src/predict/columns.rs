//! Columns of a log as predictions take them: missing values filled, rotations counted from the first,
//! the spindle's angle summed up.

use nalgebra::{Matrix3, Vector3};
use std::ops::Range;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_logs::dropout::dropouts;
use trueweld_logs::fir::LowPass;
use trueweld_logs::log::Log;
use trueweld_logs::resample::median_step;

/// Period of an evenly sampled log, s: as stated, or the median step.
pub(crate) fn period(log: &Log) -> f64 {
    log.period.unwrap_or_else(|| median_step(&log.samples.time))
}

/// A series whose missing values are filled along straight lines; `None` where it has none at all.
pub(crate) fn filled(series: &[f64]) -> Option<Vec<f64>> {
    let known: Vec<usize> = (0..series.len()).filter(|k| series[*k].is_finite()).collect();
    let (first, last) = (*known.first()?, *known.last()?);
    let mut out = series.to_vec();
    out[..first].fill(series[first]);
    out[last + 1..].fill(series[last]);
    for pair in known.windows(2) {
        for k in pair[0] + 1..pair[1] {
            let share = (k - pair[0]) as f64 / (pair[1] - pair[0]) as f64;
            out[k] = series[pair[0]] * (1.0 - share) + series[pair[1]] * share;
        }
    }
    Some(out)
}

/// Dropouts of an instrument: what fills them was not measured, and no straight line is what would
/// have been. As beyond the ends of a log, nothing is compared where a filter's window reaches there.
pub(super) struct Dropouts(Vec<Range<usize>>);

impl Dropouts {
    /// Of a series that `low` smooths.
    pub(super) fn of(series: &[f64], low: &LowPass) -> Self {
        Self(dropouts(series.iter().map(|v| v.is_finite()), low.bridged()))
    }

    /// The same of vectors, and of several series of them.
    pub(super) fn of_vectors<'a>(
        series: impl IntoIterator<Item = &'a Option<Vec<Vector3<f64>>>>,
        low: &LowPass,
    ) -> Self {
        let of =
            |v: &Vec<Vector3<f64>>| dropouts(v.iter().map(|v| v.sum().is_finite()), low.bridged());
        Self(series.into_iter().flatten().flat_map(of).collect())
    }

    /// True where one lies within so many rows of a row.
    pub(super) fn within(&self, reach: usize, row: usize) -> bool {
        self.0.iter().any(|gap| gap.start <= row + reach && row < gap.end + reach)
    }
}

/// Rows for each reading of an instrument, dropouts left out: what `low` makes of fewer readings is
/// noisier.
pub(super) fn rows_a_reading(read: impl Iterator<Item = bool> + Clone, low: &LowPass) -> f64 {
    let (rows, readings) = (read.clone().count(), read.clone().filter(|read| *read).count());
    let dropped: usize = dropouts(read, low.bridged()).iter().map(Range::len).sum();
    (rows - dropped) as f64 / readings.max(1) as f64
}

/// The same of vectors.
pub(super) fn rows_a_vector(series: &Option<Vec<Vector3<f64>>>, low: &LowPass) -> f64 {
    let of = |v: &Vec<Vector3<f64>>| rows_a_reading(v.iter().map(|v| v.sum().is_finite()), low);
    series.as_ref().map_or(1.0, of)
}

/// One row of three columns.
pub(super) fn vector(columns: &[Vec<f64>; 3], row: usize) -> Vector3<f64> {
    Vector3::from_fn(|c, _| columns[c][row])
}

/// Rotations as the first one and what every one turns from there, filled: rotation vectors flip their
/// sign near half a turn, where a tool that points down is, so that nothing lies between two of them.
pub(super) fn turned_from_first(
    series: &Option<Vec<Vector3<f64>>>,
) -> Option<(Matrix3<f64>, [Vec<f64>; 3])> {
    let series = series.as_ref()?;
    let is_read = |v: &&Vector3<f64>| v.sum().is_finite();
    let first = rotation_from_vector(series.iter().find(is_read)?);
    let turned = |v: &Vector3<f64>| match is_read(&v) {
        true => rotation_vector(&first.tr_mul(&rotation_from_vector(v))),
        false => *v,
    };
    let turned = filled_vectors(&Some(series.iter().map(turned).collect()))?;
    Some((first, turned))
}

/// Spindle angle at every row, 0 at the first, rad; `None` without a spindle column.
pub(super) fn spindle_angle(log: &Log) -> Option<Vec<f64>> {
    let spindle = filled(log.samples.spindle.as_ref()?)?;
    let time = &log.samples.time;
    let mut angle = vec![0.0; time.len()];
    for k in 1..time.len() {
        angle[k] = angle[k - 1] + 0.5 * (spindle[k - 1] + spindle[k]) * (time[k] - time[k - 1]);
    }
    Some(angle)
}

/// Force and moment at every row, three columns each: filled where a reading is missing, zero where
/// the log has no such columns.
pub(super) fn wrench_columns(log: &Log) -> [[Vec<f64>; 3]; 2] {
    let none = || std::array::from_fn(|_| vec![0.0; log.samples.time.len()]);
    [&log.samples.force, &log.samples.moment].map(|v| filled_vectors(v).unwrap_or_else(none))
}

/// Three columns of vectors, filled.
pub(crate) fn filled_vectors(series: &Option<Vec<Vector3<f64>>>) -> Option<[Vec<f64>; 3]> {
    let series = series.as_ref()?;
    let column = |i: usize| filled(&series.iter().map(|v| v[i]).collect::<Vec<_>>());
    Some([column(0)?, column(1)?, column(2)?])
}

/// Mean size of a series, what is missing left out.
pub(super) fn mean_abs(series: &[f64]) -> f64 {
    let known: Vec<f64> = series.iter().filter(|v| v.is_finite()).map(|v| v.abs()).collect();
    known.iter().sum::<f64>() / known.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tool_that_points_down_is_filled_between_its_readings() {
        // It turns about its own axis, and its rotation vector flips from reading to reading.
        let at = |k: usize| {
            let turn = rotation_from_vector(&Vector3::new(0.0, 0.0, 1e-3 * k as f64));
            let tilt = Vector3::new(0.0, std::f64::consts::PI - 1e-4, 0.0);
            turn * rotation_from_vector(&tilt)
        };
        let other_way = |v: Vector3<f64>| v - v.normalize() * std::f64::consts::TAU;
        let read = |k: usize| match k % 6 {
            0 => rotation_vector(&at(k)),
            3 => other_way(rotation_vector(&at(k))),
            _ => Vector3::repeat(f64::NAN),
        };
        let (first, turned) = turned_from_first(&Some((0..31).map(read).collect())).unwrap();
        for k in 0..31 {
            let filled = first * rotation_from_vector(&vector(&turned, k));
            assert!((filled - at(k)).norm() < 1e-9, "{k}");
        }
    }
}
