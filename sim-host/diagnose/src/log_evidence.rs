//! Evidence of an explanation: by how much it predicts blocks better that were left out of its fit,
//! as a difference of log scores, less the logarithm of how many explanations were tried. What is left
//! out is as uncertain as the other blocks leave the values: an effect that one block alone shows pays
//! for what that block must tell of it, and is no worse for being shown once.
//!
//! All rivals are judged by one noise, of what the best of them leaves. Its variance in each column
//! is uncertain as far as it is stated or was estimated (a scaled inverse χ² with the residuals'
//! own), and what follows itself in time counts as the independent values that it is worth, by its
//! long-run variance: long logs do not make a small misfit significant, and a model that is wrong by
//! a thousand times the noise is judged as one that is wrong by little. Vehtari, Gelman and Gabry
//! 2017 (held-out log scores); Newey and West 1987 (long-run variance).

use crate::found::joint_range;
use crate::rules::{DECISIVE, evidence_weights};
use crate::screen::{alternatives_of, screened_kinds};
use crate::wave_orders::HIGHEST_ORDER;
use std::collections::BTreeMap;
use std::f64::consts::PI;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::covariance::{columns, long_run_ratios};
use trueweld_estimate::fit::{self, FitProblem, Fitted, Residuals};
use trueweld_estimate::predict::{Compared, ComparedQuantity, Prediction, PreparedLog};
use trueweld_plant::effects::{Effect, Location, Parameter, Role};

/// Probability that an explanation with so much evidence, nats, is no neighbour of something outside
/// the library, which is as likely beforehand. Of what that does the likeliest neighbour does some share
/// ρ², all shares alike; the rest stands out as evidence e (1 − ρ²)/ρ² against both, and is not seen
/// below [`DECISIVE`], with probability `DECISIVE`/(e + `DECISIVE`), or where the logs do not move the
/// arm so that it shows.
pub(crate) fn is_of_library(evidence: f64) -> f64 {
    let unseen = DECISIVE / (evidence.max(0.0) + DECISIVE);
    1.0 / (1.0 + unseen.max(NEVER_SEEN))
}

/// Odds of something outside the library of which logs show nothing that a neighbour in it does not do:
/// in the corpora of seeds 7301 and 8117 one law in four of those that are outside, with one case in
/// six such a law.
const NEVER_SEEN: f64 = 0.05;

/// Standard error of a noise that is stated, and of one that was read off a recording, as shares: makers
/// state one to two digits; a spectrum's upper half holds a few independent values a column at least.
const STATED_NOISE_ERROR: f64 = 0.03;
const ESTIMATED_NOISE_ERROR: f64 = 0.25;

/// What rivals are judged by: what one unit of squared residual counts for, by log and value.
struct RivalNoise<'p> {
    problem: &'p FitProblem,
    blocks: Vec<Vec<u8>>,
    precision: Vec<Vec<f64>>,
    /// How many independent values each is worth.
    worth: Vec<Vec<f64>>,
}

impl<'p> RivalNoise<'p> {
    /// Of what the best rival leaves.
    fn left_by(problem: &'p FitProblem, best: &Residuals) -> Self {
        Self::at_least(problem, best, |_| 1.0)
    }

    /// The same; `least`: the least variance of a value, as a share of what it was weighed by.
    fn at_least(
        problem: &'p FitProblem,
        best: &Residuals,
        least: impl Fn(&Compared) -> f64,
    ) -> Self {
        let columns = columns(problem);
        let of_log = |(log, experiment): (usize, &PreparedLog)| {
            let left = best[log].in_own_noise();
            let weights = evidence_weights(&experiment.compared);
            let ratios = long_run_ratios(&columns[log], &left);
            let mut sums: BTreeMap<(ComparedQuantity, u8), (f64, f64)> = BTreeMap::new();
            for (c, r) in experiment.compared.iter().zip(left.iter()) {
                let sum = sums.entry((c.quantity, c.component)).or_default();
                *sum = (sum.0 + r * r, sum.1 + 1.0);
            }
            // How many values count as one: by what they are known to be off alike, or by how they are
            // seen to follow each other, which is the same seen twice.
            let mut ratio: Vec<f64> = weights.iter().map(|weight| weight.recip()).collect();
            for column in &columns[log] {
                column.at.iter().for_each(|k| ratio[*k] = ratio[*k].max(ratios[column.level]));
            }
            let of_value = |k: usize| {
                let c = &experiment.compared[k];
                let error = if c.stated { STATED_NOISE_ERROR } else { ESTIMATED_NOISE_ERROR };
                // Degrees of freedom that make an estimate of a variance so uncertain.
                let known = 0.5 / (error * error);
                let (square, count) = sums[&(c.quantity, c.component)];
                let worth = count / ratio[k];
                let least = least(c);
                let variance = (known * least + square / ratio[k]) / (known + worth);
                1.0 / (variance.max(least) * ratio[k])
            };
            let precision: Vec<f64> = (0..left.len()).map(of_value).collect();
            (precision, ratio.iter().map(|ratio| ratio.recip()).collect())
        };
        let (precision, worth) = problem.logs.iter().enumerate().map(of_log).unzip();
        Self { problem, blocks: fit::blocks_of(problem), precision, worth }
    }

    /// How well a fit predicts blocks that are left out of it, nats: in the noise that its model makes.
    fn log_score(&self, fitted: &Fitted) -> f64 {
        let score = match fitted.residuals.iter().all(|at| at.noise.is_none()) {
            true => fitted.log_score_from_others(&self.blocks, &self.precision),
            false => {
                let own = fitted.in_own_noise(&self.blocks);
                own.log_score_from_others(&self.blocks, &self.precision)
            }
        };
        score - self.wider(&fitted.residuals) + self.not_evidence(&fitted.residuals)
    }

    /// The same of a model that was not fitted to the logs.
    fn log_score_as_given(&self, at: &Residuals) -> f64 {
        let of_log = |(at, precision): (&Prediction, &Vec<f64>)| {
            at.in_own_noise().iter().zip(precision).map(|(r, w)| w * r * r).sum::<f64>()
        };
        let squares: f64 = at.iter().zip(&self.precision).map(of_log).sum();
        self.not_evidence(at) - 0.5 * squares - self.wider(at)
    }

    /// What a log score loses by values that lie farther apart than they were taken to.
    fn wider(&self, at: &Residuals) -> f64 {
        let of_log = |(worth, at): (&Vec<f64>, &Prediction)| -> f64 {
            let each = worth.iter().zip(at.noise.iter().flat_map(|noise| &noise.spread));
            each.map(|(worth, by)| worth * by.ln()).sum()
        };
        self.worth.iter().zip(at).map(of_log).sum()
    }

    /// The part of a log score that is no evidence: links that are put where they were seen are put there
    /// noise and all, and a clock that is moved was not expected there.
    fn not_evidence(&self, at: &Residuals) -> f64 {
        let of_log = |(at, precision): (&Prediction, &Vec<f64>)| {
            at.not_evidence * precision.iter().sum::<f64>() / precision.len().max(1) as f64
        };
        -0.5 * at.iter().zip(&self.precision).map(of_log).sum::<f64>()
    }
}

/// Evidence for rivals that have more than one and the same fit, nats.
pub(crate) struct RivalEvidence<'a> {
    noise: RivalNoise<'a>,
    null: &'a Fitted,
    before: f64,
}

impl<'a> RivalEvidence<'a> {
    /// Over `null`, by the noise of what `best` leaves.
    pub(crate) fn over(problem: &'a FitProblem, null: &'a Fitted, best: &Residuals) -> Self {
        Self::in_noise(RivalNoise::left_by(problem, best), null)
    }

    fn in_noise(noise: RivalNoise<'a>, null: &'a Fitted) -> Self {
        Self { before: noise.log_score(null), noise, null }
    }

    /// Evidence for what `fitted` has and the other has not.
    pub(crate) fn of(&self, fitted: &Fitted) -> f64 {
        self.gain(fitted) - price(self.noise.problem, self.null, fitted)
    }

    /// The same before its description is paid for.
    pub(crate) fn gain(&self, fitted: &Fitted) -> f64 {
        self.noise.log_score(fitted) - self.before
    }
}

/// True where a fit with more effects than another explains more than chance makes of any that were
/// tried, on blocks that were left out.
pub(crate) fn is_significant(problem: &FitProblem, null: &Fitted, fitted: &Fitted) -> bool {
    RivalEvidence::over(problem, null, &fitted.residuals).of(fitted) > DECISIVE
}

/// Evidence for what a fit with more effects has more than another, by the noise alone: an accuracy
/// that is asked for says what matters, not what shows.
pub(crate) fn evidence_in_noise(problem: &FitProblem, null: &Fitted, fitted: &Fitted) -> f64 {
    let of_noise = |c: &Compared| 1.0 - (c.accuracy / c.deviation).powi(2);
    let noise = RivalNoise::at_least(problem, &fitted.residuals, of_noise);
    RivalEvidence::in_noise(noise, null).of(fitted)
}

/// True where a fit predicts blocks that were left out of it better than another does, or, without
/// one, than the model as it was `given`, which leaves such residuals.
pub(crate) fn predicts_better(
    problem: &FitProblem,
    given: &Residuals,
    before: Option<&Fitted>,
    fitted: &Fitted,
) -> bool {
    let noise = RivalNoise::left_by(problem, &fitted.residuals);
    let before = before.map_or_else(|| noise.log_score_as_given(given), |f| noise.log_score(f));
    noise.log_score(fitted) - before > DECISIVE
}

/// The same of residuals as they are, of two models that were not fitted to them by more than a few
/// values.
pub(crate) fn exceeds_noise(problem: &FitProblem, before: &Residuals, after: &Residuals) -> bool {
    let noise = RivalNoise::left_by(problem, after);
    noise.log_score_as_given(after) - noise.log_score_as_given(before) > DECISIVE
}

/// Description of what one fit has more than another, nats: the logarithm of how many the library
/// proposes, places and shapes.
fn price(problem: &FitProblem, null: &Fitted, fitted: &Fitted) -> f64 {
    let of_name = name_price(problem);
    let name = |effect: &Effect| effect.place();
    let mut known: Vec<_> = null.point.shared.iter().map(name).collect();
    let mut is_new = |effect: &&Effect| {
        let own = known.iter().position(|known| *known == name(effect));
        own.map(|k| known.swap_remove(k)).is_none()
    };
    let effects = fitted.point.shared.iter().filter(|effect| !is_calibration(effect.kind));
    let new = effects.filter(|effect| is_new(effect));
    new.map(|effect| of_name + shape_price(fitted, effect)).sum()
}

/// The same of a name alone: how many places of all effects.
pub(crate) fn name_price(problem: &FitProblem) -> f64 {
    (screened_kinds(problem).count().max(1) as f64).ln()
}

/// The logarithm of how many shapes of an effect are told apart.
fn shape_price(fitted: &Fitted, effect: &Effect) -> f64 {
    let of_parameter = |parameter: &Parameter| match (parameter.role, effect.at) {
        // Half a turn of phase over the angles that the joint was in tells two orders apart.
        (Role::Order, Location::Joint(joint)) => {
            1.0 + parameter.high.min(HIGHEST_ORDER) * joint_range(fitted, joint) / PI
        }
        (role, _) => alternatives_of(role) as f64,
    };
    effect.kind.parameters.iter().map(|parameter| of_parameter(parameter).ln()).sum()
}
