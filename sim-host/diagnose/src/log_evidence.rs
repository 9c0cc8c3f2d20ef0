//! Evidence of an explanation: by how much it predicts blocks better that were left out of its fit,
//! as a difference of log scores, less the logarithm of how many explanations were tried.
//!
//! All rivals are judged by one noise, of what the best of them leaves. Its variance in each column
//! is uncertain as far as it is stated or was estimated (a scaled inverse χ² with the residuals'
//! own), and what follows itself in time counts as the independent values that it is worth, by its
//! long-run variance: long logs do not make a small misfit significant, and a model that is wrong by
//! a thousand times the noise is judged as one that is wrong by little. Vehtari, Gelman and Gabry
//! 2017 (held-out log scores); Newey and West 1987 (long-run variance).

use crate::rules::{evidence_weights, prior_penalty};
use std::collections::BTreeMap;
use trueweld_estimate::fit::covariance::{columns, long_run_ratios};
use trueweld_estimate::fit::{FitProblem, Fitted};
use trueweld_estimate::predict::ComparedQuantity;

/// Standard error of a noise that is stated, and of one that was read off a recording, as shares: makers
/// state one to two digits; a spectrum's upper half holds a few independent values a column at least.
const STATED_NOISE_ERROR: f64 = 0.03;
const ESTIMATED_NOISE_ERROR: f64 = 0.25;

/// What rivals are judged against and by: a null, and the noise, as what one unit of squared residual
/// counts for, by log and value.
pub(crate) struct RivalNoise<'p> {
    problem: &'p FitProblem,
    blocks: &'p [Vec<u8>],
    precision: Vec<Vec<f64>>,
    null: &'p Fitted,
    /// What the null leaves of blocks that were left out.
    before: Vec<Vec<f64>>,
}

impl<'p> RivalNoise<'p> {
    /// Of what `best` leaves, beside `null`.
    pub(crate) fn left_by(
        problem: &'p FitProblem,
        blocks: &'p [Vec<u8>],
        null: &'p Fitted,
        best: &Fitted,
    ) -> Self {
        let columns = columns(problem);
        let of_log = |(log, experiment): (usize, &trueweld_estimate::predict::PreparedLog)| {
            let left = &best.residuals[log].residual;
            let weights = evidence_weights(&experiment.compared);
            let ratios = long_run_ratios(&columns[log], left);
            let mut sums: BTreeMap<(ComparedQuantity, u8), (f64, f64)> = BTreeMap::new();
            for ((c, weight), r) in experiment.compared.iter().zip(&weights).zip(left) {
                let sum = sums.entry((c.quantity, c.component)).or_default();
                *sum = (sum.0 + weight * r * r, sum.1 + weight);
            }
            let mut ratio: Vec<f64> = vec![1.0; left.len()];
            for column in &columns[log] {
                column.at.iter().for_each(|k| ratio[*k] = ratios[column.level]);
            }
            let of_value = |k: usize| {
                let c = &experiment.compared[k];
                let error = if c.stated { STATED_NOISE_ERROR } else { ESTIMATED_NOISE_ERROR };
                // Degrees of freedom that make an estimate of a variance so uncertain.
                let known = 0.5 / (error * error);
                let (square, count) = sums[&(c.quantity, c.component)];
                let worth = count / ratio[k];
                let variance = (known + square / ratio[k]) / (known + worth);
                weights[k] / (variance.max(1.0) * ratio[k])
            };
            (0..left.len()).map(of_value).collect()
        };
        let precision = problem.logs.iter().enumerate().map(of_log).collect();
        Self { problem, blocks, precision, null, before: null.residuals_from_others(blocks) }
    }

    /// By how much `fitted` predicts blocks better that were left out than the null does, as the
    /// difference of their log scores.
    pub(crate) fn gain(&self, fitted: &Fitted) -> f64 {
        let after = fitted.residuals_from_others(self.blocks);
        let mut fall = -prior_penalty(&self.null.residuals, &fitted.residuals);
        for log in 0..self.problem.logs.len() {
            let pairs = self.before[log].iter().zip(&after[log]).zip(&self.precision[log]);
            fall += pairs.map(|((b, a), precision)| precision * (b * b - a * a)).sum::<f64>();
        }
        0.5 * fall
    }
}
