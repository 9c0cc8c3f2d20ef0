//! Single readings that stand out of their neighbours on both sides: a tracker's beam that was lost
//! for a moment, a spike on a line.
//!
//! What a machine does leaves a trace on one side at least: after an impact the arm rings, where
//! friction turns round the torque stays on its new level, a ripple comes again. A reading is an
//! outlier only if the lines through its neighbours before and after both miss it, on the same side,
//! agree with each other, and miss it by far more than they miss the readings near by.

use super::floor::resolution;
use std::ops::Range;

/// Readings on either side that a line is laid through.
const LINE_READINGS: usize = 5;

/// Most outliers in a row.
const OUTLIERS_IN_A_ROW_MAX: usize = 3;

/// Readings on either side that tell how far a line usually misses.
const SCATTER_NEIGHBOURS: usize = 20;

/// How many deviations of what a line misses by, and of the stated noise, an outlier stands out by.
/// A line's misses are 1.5 times the noise, so that white noise would have to reach 12 deviations.
pub const OUTLIER_DEVIATIONS: f64 = 8.0;

/// Largest difference of both lines, as a share of what they miss an outlier by: a level that stays
/// changed has one of the size of the change.
const AGREE: f64 = 0.4;

/// Rounds: an outlier beside another one is seen when that is out.
const OUTLIER_ROUNDS: usize = 4;

/// Outliers of a series: rows, and by how much each stands out. `noise`: its stated deviation.
pub(crate) fn outliers(time: &[f64], series: &[f64], noise: f64) -> Vec<(usize, f64)> {
    let mut known: Vec<usize> = (0..series.len()).filter(|k| series[*k].is_finite()).collect();
    // A reading that flickers between two steps is none.
    let noise = noise.max(Some(resolution(series)).filter(|r| r.is_finite()).unwrap_or(0.0));
    let mut found = Vec::new();
    for _ in 0..OUTLIER_ROUNDS {
        let round = SeriesReadings { time, series, known: &known, noise }.outliers();
        if round.is_empty() {
            break;
        }
        known.retain(|k| round.iter().all(|(row, _)| row != k));
        found.extend(round);
    }
    found.sort_unstable_by_key(|(row, _)| *row);
    found
}

/// The readings of a series, by number.
struct SeriesReadings<'a> {
    time: &'a [f64],
    series: &'a [f64],
    /// Rows with a reading.
    known: &'a [usize],
    noise: f64,
}

impl SeriesReadings<'_> {
    fn outliers(&self) -> Vec<(usize, f64)> {
        let n = self.known.len();
        let mut found = Vec::new();
        if n < 2 * (LINE_READINGS + 1) + OUTLIERS_IN_A_ROW_MAX {
            return found;
        }
        let bend = |p: usize| (self.value(p - 1) - 2.0 * self.value(p) + self.value(p + 1)).abs();
        let bends: Vec<f64> = (1..n - 1).map(bend).collect();
        let mut sorted = bends.clone();
        let usual = *sorted.select_nth_unstable_by(bends.len() / 2, f64::total_cmp).1;
        let mut steps: Vec<f64> = (1..n).map(|p| self.at(p) - self.at(p - 1)).collect();
        let step = *steps.select_nth_unstable_by(n / 2, f64::total_cmp).1;
        let mut p = LINE_READINGS + 1;
        while p + LINE_READINGS < n {
            // An outlier bends the series at its own place by more than noise does.
            let bent = bends[p - 1] > 4.0 * usual;
            let run = bent.then(|| {
                (1..=OUTLIERS_IN_A_ROW_MAX).find_map(|length| self.outlier_sizes(p, length, step))
            });
            match run.flatten() {
                Some(sizes) => {
                    let rows = (p..).zip(&sizes).map(|(p, size)| (self.known[p], *size));
                    found.extend(rows);
                    p += sizes.len();
                }
                None => p += 1,
            }
        }
        found
    }

    /// By how much the readings from `p` on stand out, each on its own; `None` where one does not.
    fn outlier_sizes(&self, p: usize, length: usize, step: f64) -> Option<Vec<f64>> {
        let after = p + length;
        if after + LINE_READINGS > self.known.len() {
            return None;
        }
        let span = self.at(after + LINE_READINGS - 1) - self.at(p - LINE_READINGS);
        // Across a gap nobody knows.
        if span > 2.0 * step * (2 * LINE_READINGS + length) as f64 {
            return None;
        }
        let (centre, usual) = self.misses(p, after)?;
        let lines = [self.line(p - LINE_READINGS), self.line(after)];
        let far = OUTLIER_DEVIATIONS * usual.max(self.noise);
        let size = |p: usize| {
            let missed = lines.map(|line| self.missed(p, line) - centre);
            let size = missed[0].abs().min(missed[1].abs());
            let agree = (missed[0] - missed[1]).abs() < AGREE * size;
            (agree && size > far).then_some(size)
        };
        (p..after).map(size).collect()
    }

    /// By how much lines miss readings before `p` and from `after` on: what they all miss by where a
    /// series is curved, and, as a deviation, by how much more: of the side where it is more, and by
    /// how much the curve changes.
    fn misses(&self, p: usize, after: usize) -> Option<(f64, f64)> {
        // Lines of its readings do not reach the run.
        let n = self.known.len();
        let before =
            p.saturating_sub(SCATTER_NEIGHBOURS + LINE_READINGS)..p.saturating_sub(LINE_READINGS);
        let behind =
            (after + LINE_READINGS).min(n)..(after + LINE_READINGS + SCATTER_NEIGHBOURS).min(n);
        match (self.scatter(before), self.scatter(behind)) {
            (Some(a), Some(b)) => Some((0.5 * (a.0 + b.0), a.1.max(b.1) + (a.0 - b.0).abs())),
            (one, other) => one.or(other),
        }
    }

    /// Median and deviation of how far the lines beside them miss some readings; `None` of too few.
    fn scatter(&self, rows: Range<usize>) -> Option<(f64, f64)> {
        let mut all: Vec<f64> = rows
            .flat_map(|q| {
                let before = (q >= LINE_READINGS).then(|| self.line(q - LINE_READINGS));
                let after = (q + LINE_READINGS < self.known.len()).then(|| self.line(q + 1));
                before.into_iter().chain(after).map(move |line| self.missed(q, line))
            })
            .collect();
        if all.len() <= SCATTER_NEIGHBOURS / 2 {
            return None;
        }
        let middle = all.len() / 2;
        let centre = *all.select_nth_unstable_by(middle, f64::total_cmp).1;
        all.iter_mut().for_each(|miss| *miss = (*miss - centre).abs());
        let spread = *all.select_nth_unstable_by(middle, f64::total_cmp).1;
        Some((centre, spread / 0.6745))
    }

    /// By how much a line misses a reading.
    fn missed(&self, p: usize, (value, slope): (f64, f64)) -> f64 {
        self.value(p) - value - slope * self.at(p)
    }

    /// The line through readings from `first` on, by medians: value at time 0, and slope.
    fn line(&self, first: usize) -> (f64, f64) {
        const LINE_PAIRS: usize = LINE_READINGS * (LINE_READINGS - 1) / 2;
        let (mut slopes, mut count) = ([0.0; LINE_PAIRS], 0);
        for a in first..first + LINE_READINGS {
            for b in a + 1..first + LINE_READINGS {
                slopes[count] = (self.value(b) - self.value(a)) / (self.at(b) - self.at(a));
                count += 1;
            }
        }
        slopes.sort_unstable_by(f64::total_cmp);
        let slope = 0.5 * (slopes[LINE_PAIRS / 2 - 1] + slopes[LINE_PAIRS / 2]);
        let mut values: [f64; LINE_READINGS] =
            std::array::from_fn(|j| self.value(first + j) - slope * self.at(first + j));
        values.sort_unstable_by(f64::total_cmp);
        (values[LINE_READINGS / 2], slope)
    }

    fn value(&self, p: usize) -> f64 {
        self.series[self.known[p]]
    }

    fn at(&self, p: usize) -> f64 {
        self.time[self.known[p]] - self.time[0]
    }
}

#[cfg(test)]
mod tests {
    use super::outliers;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const PERIOD: f64 = 0.004;

    /// Rows of what `of` gives over time, with noise.
    fn series(deviation: f64, of: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * PERIOD).collect();
        let values = time.iter().map(|t| of(*t) + deviation * noise()).collect();
        (time, values)
    }

    /// A tool at up to 2 m/s.
    fn moving(t: f64) -> f64 {
        0.5 * (4.0 * t).sin()
    }

    #[test]
    fn jumps_of_a_tracker_are_outliers_however_close_together() {
        let (time, mut values) = series(3e-5, moving);
        let out = [(40, 1), (500, 1), (503, 1), (800, 3), (1200, 2), (1900, 1)];
        let rows: Vec<usize> = out.iter().flat_map(|(k, n)| *k..k + n).collect();
        rows.iter().for_each(|k| values[*k] += if k % 2 == 0 { 5e-3 } else { -5e-3 });
        for noise in [3e-5, 0.0] {
            let found = outliers(&time, &values, noise);
            assert_eq!(found.iter().map(|(row, _)| *row).collect::<Vec<_>>(), rows);
            // By what lines of five readings miss at 8 m/s².
            assert!(found.iter().all(|(_, size)| (size - 5e-3).abs() < 1e-3), "{found:?}");
        }
    }

    #[test]
    fn what_a_machine_does_is_no_outlier() {
        let none = |what: &str, deviation: f64, of: &dyn Fn(f64) -> f64| {
            for noise in [deviation, 0.0] {
                let (time, values) = series(deviation, of);
                let found = outliers(&time, &values, noise);
                assert!(found.is_empty(), "{what}: {found:?}");
            }
        };
        for deviation in [0.0, 3e-5] {
            none("motion", deviation, &moving);
            none("a stop", deviation, &|t| moving(t.min(3.0)));
            none("a step", deviation, &|t| if t < 3.0 { 0.0 } else { 5e-3 });
            // An arm that is struck and rings: 10 and 40 Hz, 3 % of damping.
            for frequency in [10.0, 40.0] {
                let omega = std::f64::consts::TAU * frequency;
                none("ringing", deviation, &|t| {
                    let since = (t - 3.001).max(0.0);
                    moving(t) + 5e-3 * (-0.03 * omega * since).exp() * (omega * since).sin()
                });
            }
        }
        let omega = std::f64::consts::TAU * 31.0;
        none("ripple", 25.0, &|t| 18e3 + 3e3 * (omega * t).sin() + 1e3 * (3.0 * omega * t).sin());
        none("the first touch", 25.0, &|t| if t < 4.0 { 0.0 } else { 9e3 * (t - 4.0).min(0.5) });
        // A reading that changes by one step now and then.
        let (time, _) = series(0.0, moving);
        let steps: Vec<f64> = (0..2000).map(|k| if k % 97 == 50 { 1e-5 } else { 0.0 }).collect();
        assert!(outliers(&time, &steps, 0.0).is_empty());
    }
}
