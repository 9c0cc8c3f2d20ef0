//! Single readings that stand out of their neighbours on both sides: a tracker's beam that was lost
//! for a moment, a spike on a line.
//!
//! What a machine does leaves a trace on one side at least: after an impact the arm rings, where
//! friction turns round the torque stays on its new level, a ripple comes again. A reading is an
//! outlier only if the lines through its neighbours before and after both miss it, on the same side,
//! agree with each other, and miss it by far more than they miss any reading near by.

use super::floor::resolution;
use std::ops::Range;

/// Readings on either side that a line is laid through.
const LINE: usize = 5;

/// Most outliers in a row.
const MOST: usize = 3;

/// Readings on either side that tell how far a line usually misses.
const AROUND: usize = 20;

/// How many deviations of what a line misses by, and of the stated noise, an outlier stands out by.
/// A line's misses are 1.5 times the noise, so that white noise would have to reach 12 deviations.
const FAR: f64 = 8.0;

/// Largest difference of both lines, as a share of what they miss an outlier by: a level that stays
/// changed has one of the size of the change.
const AGREE: f64 = 0.4;

/// Rounds: an outlier beside another one is seen when that is out.
const ROUNDS: usize = 4;

/// Outliers of a series: rows, and by how much each stands out. `noise`: its stated deviation.
pub(crate) fn outliers(time: &[f64], series: &[f64], noise: f64) -> Vec<(usize, f64)> {
    let mut known: Vec<usize> = (0..series.len()).filter(|k| series[*k].is_finite()).collect();
    // A reading that flickers between two steps is none.
    let noise = noise.max(Some(resolution(series)).filter(|r| r.is_finite()).unwrap_or(0.0));
    let mut found = Vec::new();
    for _ in 0..ROUNDS {
        let round = Readings { time, series, known: &known, noise }.outliers();
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
struct Readings<'a> {
    time: &'a [f64],
    series: &'a [f64],
    /// Rows with a reading.
    known: &'a [usize],
    noise: f64,
}

impl Readings<'_> {
    fn outliers(&self) -> Vec<(usize, f64)> {
        let n = self.known.len();
        let mut found = Vec::new();
        if n < 2 * (LINE + 1) + MOST {
            return found;
        }
        let bend = |p: usize| (self.value(p - 1) - 2.0 * self.value(p) + self.value(p + 1)).abs();
        let bends: Vec<f64> = (1..n - 1).map(bend).collect();
        let mut sorted = bends.clone();
        let usual = *sorted.select_nth_unstable_by(bends.len() / 2, f64::total_cmp).1;
        let mut steps: Vec<f64> = (1..n).map(|p| self.at(p) - self.at(p - 1)).collect();
        let step = *steps.select_nth_unstable_by(n / 2, f64::total_cmp).1;
        let mut p = LINE + 1;
        while p + LINE < n {
            // An outlier bends the series at its own place by more than noise does.
            let bent = bends[p - 1] > 4.0 * usual;
            let run = bent.then(|| (1..=MOST).find_map(|length| self.stands_out(p, length, step)));
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
    fn stands_out(&self, p: usize, length: usize, step: f64) -> Option<Vec<f64>> {
        let after = p + length;
        if after + LINE > self.known.len() {
            return None;
        }
        let span = self.at(after + LINE - 1) - self.at(p - LINE);
        // Across a gap nobody knows.
        if span > 2.0 * step * (2 * LINE + length) as f64 {
            return None;
        }
        let lines = [self.line(p - LINE), self.line(after)];
        let size = |p: usize| {
            let missed = lines.map(|(value, slope)| self.value(p) - value - slope * self.at(p));
            let size = missed[0].abs().min(missed[1].abs());
            let agree = (missed[0] - missed[1]).abs() < AGREE * size;
            (agree && size > FAR * self.noise).then_some(size)
        };
        let sizes: Vec<f64> = (p..after).map(size).collect::<Option<_>>()?;
        let usual = self.misses(p, after)?;
        sizes.iter().all(|size| *size > FAR * usual).then_some(sizes)
    }

    /// What lines usually miss readings by before `p` and from `after` on, as a deviation: the larger
    /// of both.
    fn misses(&self, p: usize, after: usize) -> Option<f64> {
        let of = |rows: Range<usize>| {
            let miss = |q: usize, first: usize| {
                let (value, slope) = self.line(first);
                (self.value(q) - value - slope * self.at(q)).abs()
            };
            let mut all: Vec<f64> = rows
                .flat_map(|q| {
                    let before = (q >= LINE).then(|| miss(q, q - LINE));
                    let after = (q + LINE < self.known.len()).then(|| miss(q, q + 1));
                    before.into_iter().chain(after)
                })
                .collect();
            let middle = all.len() / 2;
            (all.len() > AROUND / 2)
                .then(|| *all.select_nth_unstable_by(middle, f64::total_cmp).1 / 0.6745)
        };
        // Lines of its readings do not reach the run.
        let before = of(p.saturating_sub(AROUND + LINE)..p.saturating_sub(LINE));
        let behind =
            of((after + LINE).min(self.known.len())..(after + LINE + AROUND).min(self.known.len()));
        match (before, behind) {
            (Some(a), Some(b)) => Some(a.max(b)),
            (one, other) => one.or(other),
        }
    }

    /// The line through readings from `first` on, by medians: value at time 0, and slope.
    fn line(&self, first: usize) -> (f64, f64) {
        const PAIRS: usize = LINE * (LINE - 1) / 2;
        let (mut slopes, mut count) = ([0.0; PAIRS], 0);
        for a in first..first + LINE {
            for b in a + 1..first + LINE {
                slopes[count] = (self.value(b) - self.value(a)) / (self.at(b) - self.at(a));
                count += 1;
            }
        }
        slopes.sort_unstable_by(f64::total_cmp);
        let slope = 0.5 * (slopes[PAIRS / 2 - 1] + slopes[PAIRS / 2]);
        let mut values: [f64; LINE] =
            std::array::from_fn(|j| self.value(first + j) - slope * self.at(first + j));
        values.sort_unstable_by(f64::total_cmp);
        (values[LINE / 2], slope)
    }

    fn value(&self, p: usize) -> f64 {
        self.series[self.known[p]]
    }

    fn at(&self, p: usize) -> f64 {
        self.time[self.known[p]] - self.time[0]
    }
}
