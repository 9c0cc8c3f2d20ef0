//! Instruments that are read less often than rows are written: each reading stands in every row
//! until the next one comes. What stands there again was not measured again.

use super::floor::resolution;
use super::median;
use super::resample::median_step;
use std::ops::Range;

/// Readings that a judgement rests on, at least.
const HELD_READINGS_MIN: usize = 20;

/// Least share of the readings that stand for about as many rows as most do: what stands still, or
/// creeps by one step of a coarse instrument now and then, repeats itself without a rule.
const REGULAR_SHARE_MIN: f64 = 0.9;

/// Least share of the rows that repeat the one before.
const OFTEN: f64 = 0.2;

/// Least change from one reading to the next, in steps of the instrument's resolution. Below, it may
/// well read the same twice.
const RESOLVED_CHANGE_STEPS: f64 = 3.0;

/// Most that readings may come late, in rows, where they are taken to be evenly apart: each stands in
/// the first row that is written after it.
const LATE: f64 = 1.05;

/// Readings that are held.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SampleHold {
    /// Rows that a reading stands for, on average.
    pub every: f64,
    /// The first row of each reading.
    pub first: Vec<usize>,
}

/// What an instrument reads, where it holds its readings. `series`: all that it reads at once.
pub(crate) fn sample_hold(series: &[&[f64]]) -> Option<SampleHold> {
    let readings = readings(series);
    let mut lengths: Vec<f64> = readings.iter().map(|r| r.len() as f64).collect();
    let usual = median(&mut lengths).filter(|_| readings.len() >= HELD_READINGS_MIN)?;
    let is_regular = |r: &&Range<usize>| (r.len() as f64 - usual).abs() <= 1.0;
    let regular: Vec<&Range<usize>> = readings.iter().filter(is_regular).collect();
    let rows: usize = regular.iter().map(|r| r.len()).sum();
    let often = (rows - regular.len()) as f64 >= OFTEN * rows as f64;
    let rule = regular.len() as f64 >= REGULAR_SHARE_MIN * readings.len() as f64;
    if !(often && rule && series.iter().any(|s| is_resolved(s, &readings))) {
        return None;
    }
    let every = rows as f64 / regular.len() as f64;
    // Of what stands still every reading is as good as the first.
    let again = |r: &Range<usize>| {
        let count = (r.len() as f64 / every).round().max(1.0) as usize;
        (0..count).map(|k| r.start + (k as f64 * every).round() as usize).collect::<Vec<_>>()
    };
    Some(SampleHold { every, first: readings.iter().flat_map(again).collect() })
}

impl SampleHold {
    /// When each reading was taken, as the rows' times tell: evenly apart where each can have come
    /// with the first row after that, and with its row otherwise.
    pub(crate) fn instants(&self, time: &[f64]) -> Vec<f64> {
        let row = median_step(time);
        let came: Vec<f64> = self.first.iter().map(|k| time[*k]).collect();
        let apart = |w: &[f64]| ((w[1] - w[0]) / (self.every * row)).round().max(1.0);
        let mut number = vec![0.0; came.len()];
        for (k, w) in came.windows(2).enumerate() {
            number[k + 1] = number[k] + apart(w);
        }
        let count = came.len() as f64;
        let mean = |of: &[f64]| of.iter().sum::<f64>() / count;
        let (middle, centre) = (mean(&number), mean(&came));
        let moment = |of: &dyn Fn(usize) -> f64| (0..came.len()).map(of).sum::<f64>();
        let period = moment(&|k| (number[k] - middle) * (came[k] - centre))
            / moment(&|k| (number[k] - middle).powi(2));
        let late: Vec<f64> =
            number.iter().zip(&came).map(|(n, t)| t - centre - period * (n - middle)).collect();
        let [least, most] = [f64::min, f64::max].map(|f| late.iter().copied().fold(late[0], f));
        match most - least <= LATE * row {
            true => came.iter().zip(&late).map(|(t, late)| t - (late - least)).collect(),
            false => came,
        }
    }
}

/// Rows that hold the same reading; rows without one stand between them.
fn readings(series: &[&[f64]]) -> Vec<Range<usize>> {
    let rows = series.first().map_or(0, |s| s.len());
    let mut readings: Vec<Range<usize>> = Vec::new();
    for k in (0..rows).filter(|k| series.iter().all(|s| s[*k].is_finite())) {
        match readings.last_mut() {
            Some(last) if last.end == k && series.iter().all(|s| s[k] == s[k - 1]) => {
                last.end = k + 1;
            }
            _ => readings.push(k..k + 1),
        }
    }
    readings
}

/// True where a series changes from reading to reading by more than it resolves.
fn is_resolved(series: &[f64], readings: &[Range<usize>]) -> bool {
    let next = readings.windows(2).filter(|w| w[0].end == w[1].start);
    let mut changes: Vec<f64> =
        next.map(|w| (series[w[1].start] - series[w[0].start]).abs()).collect();
    median(&mut changes).is_some_and(|change| change > RESOLVED_CHANGE_STEPS * resolution(series))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const ROWS: usize = 1500;

    /// Rows of what `of` gives, with noise, rounded to a step.
    fn rows(deviation: f64, step: f64, of: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        let row = |k| ((of(f64::from(k)) + deviation * noise()) / step).round() * step;
        (0..ROWS as i32).map(row).collect()
    }

    fn moving(k: f64) -> f64 {
        0.5 * (k / 120.0).sin()
    }

    #[test]
    fn what_stands_until_the_next_reading_was_read_once() {
        let tracked = [rows(3e-5, 1e-7, moving), rows(3e-5, 1e-7, |k| moving(k + 50.0))];
        // Every row but the first of 3; of 2 and 3 in turn.
        for every in [3.0, 2.5, 1.5] {
            let first = |k: usize| ((k as f64 / every).floor() * every).ceil() as usize;
            let slow = tracked.each_ref().map(|s| (0..ROWS).map(|k| s[first(k)]).collect());
            let slow: [Vec<f64>; 2] = slow;
            let found = sample_hold(&[&slow[0], &slow[1]]).unwrap();
            let own: Vec<usize> = (0..ROWS).filter(|k| first(*k) == *k).collect();
            assert_eq!(found.first, own);
            assert!((found.every - every).abs() < 0.01, "{}", found.every);
            // Rows of 4 ms: they were read evenly, each at most a row before it was written.
            let time: Vec<f64> = (0..ROWS).map(|k| 4e-3 * k as f64).collect();
            for (k, at) in found.instants(&time).iter().enumerate() {
                assert!((at - 4e-3 * every * k as f64).abs() < 1e-5, "{k}: {at}");
            }
        }
    }

    #[test]
    fn what_reads_the_same_for_another_reason_is_not_held() {
        let none = |what: &str, series: &[f64]| assert_eq!(sample_hold(&[series]), None, "{what}");
        none("noise", &rows(20.0, 0.01, |k| 4000.0 * moving(k)));
        none("no noise", &rows(0.0, 1e-8, moving));
        none("a stop", &rows(0.0, 1e-8, |k| moving(k.min(500.0))));
        none("coarse", &rows(1e-4, 1e-3, moving));
        none("slow and coarse", &rows(0.0, 1e-5, |k| 4e-6 * k));
        none("slow, coarse and noisy", &rows(3e-6, 1e-5, |k| 4e-6 * k));
        none("at rest", &rows(0.0, 1e-5, |_| 0.3));
        // An instrument of another rate whose other rows are empty, as they should be.
        let mut empty = rows(3e-5, 1e-7, moving);
        (0..ROWS).filter(|k| k % 3 != 0).for_each(|k| empty[k] = f64::NAN);
        none("empty rows", &empty);
    }
}
