//! Which part of a figure's variance each input makes: Sobol indices from a sampled design, with
//! bootstrap intervals.
//!
//! Two independent samples A and B of all inputs, and for every input i the rows of A with that input
//! from B, A_B⁽ⁱ⁾ (Saltelli et al., Computer Physics Communications 181 (2010) 259):
//!
//! ```text
//! S_i  = (1/n) Σ f(B) (f(A_B⁽ⁱ⁾) − f(A)) / V        first order: input i by itself
//! T_i  = (1/2n) Σ (f(A) − f(A_B⁽ⁱ⁾))² / V            total: with all its interactions (Jansen)
//! ```
//!
//! V: the variance of f over A and B together, whose mean is taken off f before. The intervals are
//! percentiles over resampled rows.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_plant::random::Random;

/// Resamples behind an interval.
const RESAMPLES: usize = 500;

/// Ends of a 95 % interval.
const ENDS: [f64; 2] = [0.025, 0.975];

/// A number with its 95 % interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WithInterval {
    /// As estimated.
    pub value: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The indices of one input.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SobolIndex {
    /// Share of the variance that the input makes by itself.
    pub first: WithInterval,
    /// Share that it makes with all others.
    pub total: WithInterval,
}

/// Where a run stands in the design: the row, and the column: A, B, or A with one input of B.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DesignPoint {
    /// Row.
    pub row: u64,
    /// 0: A; 1: B; 2 + i: A with input i of B.
    pub column: usize,
}

impl DesignPoint {
    /// The point of a run of a design with so many inputs.
    pub fn of(index: u64, inputs: usize) -> Self {
        let columns = inputs as u64 + 2;
        Self { row: index / columns, column: (index % columns) as usize }
    }

    /// Whether input `i` is taken from B.
    pub fn of_second(&self, i: usize) -> bool {
        self.column == 1 || self.column == i + 2
    }
}

/// The figure over a design: a row for every row of A, in it f(A), f(B) and f(A_B⁽ⁱ⁾) of every input.
///
/// Returns the mean and the standard deviation of the figure, and the indices of every input; `None`
/// where the figure does not vary, or there are fewer than two rows.
pub fn indices(rows: &[Vec<f64>], seed: u64) -> Option<([f64; 2], Vec<SobolIndex>)> {
    let inputs = rows.first()?.len().checked_sub(2)?;
    let all: Vec<usize> = (0..rows.len()).collect();
    let (mean, deviation) = moments(rows, &all);
    // A figure that differs in rounding alone has no parts.
    if rows.len() < 2 || deviation.is_nan() || deviation <= 1e-12 * mean.abs() {
        return None;
    }
    let mut random = Random::new(seed, u64::MAX - 1);
    let resamples: Vec<Vec<usize>> = (0..RESAMPLES)
        .map(|_| rows.iter().map(|_| random.whole(0, rows.len() - 1)).collect())
        .collect();
    let index = |i: usize| {
        let of = |picked: &Vec<usize>| estimates(rows, picked, i);
        with_intervals(of(&all), resamples.iter().map(of).collect())
    };
    Some(([mean, deviation], (0..inputs).map(index).collect()))
}

/// An index from its first-order and total estimates, with intervals by those over resampled rows.
fn with_intervals([first, total]: [f64; 2], mut again: Vec<[f64; 2]>) -> SobolIndex {
    let mut interval = |value: f64, k: usize| {
        again.sort_by(|a, b| a[k].total_cmp(&b[k]));
        let [low, high] = ENDS.map(|p| again[(p * (RESAMPLES - 1) as f64).round() as usize][k]);
        WithInterval { value, low, high }
    };
    SobolIndex { first: interval(first, 0), total: interval(total, 1) }
}

/// Mean and standard deviation over A and B of picked rows.
fn moments(rows: &[Vec<f64>], picked: &[usize]) -> (f64, f64) {
    let values = || picked.iter().flat_map(|k| [rows[*k][0], rows[*k][1]]);
    let n = 2.0 * picked.len() as f64;
    let mean = values().sum::<f64>() / n;
    let variance = values().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    (mean, variance.sqrt())
}

/// First-order and total index of input `i` over picked rows.
fn estimates(rows: &[Vec<f64>], picked: &[usize], i: usize) -> [f64; 2] {
    let (mean, deviation) = moments(rows, picked);
    let (mut first, mut total) = (0.0, 0.0);
    for k in picked {
        let [a, b, mixed] = [0, 1, i + 2].map(|column| rows[*k][column] - mean);
        first += b * (mixed - a);
        total += 0.5 * (a - mixed).powi(2);
    }
    let scale = picked.len() as f64 * deviation.powi(2);
    [first / scale, total / scale]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// The design of a function of inputs that are even between −π and π.
    fn design(rows: u64, inputs: usize, f: impl Fn(&[f64]) -> f64) -> Vec<Vec<f64>> {
        let sample = |stream: u64| -> Vec<f64> {
            let mut random = Random::new(7, stream);
            (0..inputs).map(|_| random.between(-PI, PI)).collect()
        };
        let mut design = Vec::new();
        for [a, b] in (0..rows).map(|k| [sample(2 * k), sample(2 * k + 1)]) {
            let run = |index: u64| {
                let point = DesignPoint::of(index, inputs);
                let of = |i: usize| if point.of_second(i) { b[i] } else { a[i] };
                f(&(0..inputs).map(of).collect::<Vec<_>>())
            };
            design.push((0..inputs as u64 + 2).map(run).collect());
        }
        design
    }

    #[test]
    fn the_indices_of_ishigamis_function_lie_in_their_intervals() {
        // sin x₁ + 7 sin² x₂ + 0.1 x₃⁴ sin x₁: closed forms by Ishigami and Homma, 1990.
        let rows = design(4000, 3, |x| {
            x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
        });
        let ([mean, deviation], indices) = indices(&rows, 1).unwrap();
        let variance = 49.0 / 8.0 + 0.1 * PI.powi(4) / 5.0 + 0.01 * PI.powi(8) / 18.0 + 0.5;
        // Three standard errors of 8000 values.
        assert!((mean - 3.5).abs() < 3.0 * variance.sqrt() / 8000_f64.sqrt());
        assert!((deviation / variance.sqrt() - 1.0).abs() < 0.05);
        let truth = [[0.3139, 0.5576], [0.4424, 0.4424], [0.0, 0.2437]];
        for (index, [first, total]) in indices.iter().zip(truth) {
            for (found, truth) in [(index.first, first), (index.total, total)] {
                // An interval misses one time in twenty: a sixth of its width is allowed beside it.
                let room = (found.high - found.low) / 6.0;
                assert!(
                    found.low - room <= truth && truth <= found.high + room,
                    "{found:?}, {truth}"
                );
                assert!((found.value - truth).abs() < 0.06, "{found:?}, {truth}");
            }
        }
    }

    #[test]
    fn parts_of_a_sum_are_its_terms_and_what_does_not_vary_has_none() {
        let rows = design(2000, 2, |x| 3.0 * x[0] + x[1]);
        let (_, indices) = super::indices(&rows, 1).unwrap();
        for (index, part) in indices.iter().zip([0.9, 0.1]) {
            assert!((index.total.value - part).abs() < 0.05, "{index:?}");
            assert!((index.first.value - part).abs() < 0.08, "{index:?}");
        }
        assert!(super::indices(&design(10, 2, |_| 4.0), 1).is_none());
        assert!(super::indices(&[], 1).is_none());
    }
}
