//! How well something hidden shows in a campaign, before anybody looks for it.
//!
//! The same campaign, noise and all, is made with it and without: the difference of what the
//! baseline leaves is what there is to see of it. Calibrations take their share of that; the rest,
//! over the noise and squared, is evidence for whoever finds it, as far as its values count as such.

use super::{CorpusError, Ready, plausible, ready};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use trueweld_diagnose::rules;
use trueweld_estimate::fit::calibration::{calibrations, is_calibration};
use trueweld_estimate::fit::{self, FitState, Linear, Residuals, Slopes};
use trueweld_estimate::predict::{Compared, Prediction, PreparedLog};
use trueweld_laboratory::{OutOfLibrary, Recipe};
use trueweld_plant::effects::{Effect, EffectPlace};

/// Share of its sum of squares by which a channel must grow to show something alone.
const VISIBLE: f64 = 0.08;

/// How well something shows.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Visibility {
    /// Factor on its usual size.
    pub size: f64,
    /// Root of the evidence it adds, over that at which a diagnosis begins to believe in an effect
    /// ([`rules::GAIN`]): 1 is the limit of detection.
    pub ratio: f64,
    /// The most that the sum of squares of any channel of any log grows by, over 8 %: below 1 no channel
    /// alone shows it.
    pub excess: f64,
}

/// A campaign without what is hidden, and what calibrations can do to it.
#[derive(Debug)]
pub struct Context {
    recipe: Recipe,
    without: Ready,
    blocks: Vec<Vec<u8>>,
    at: Residuals,
    point: FitState,
    slopes: Vec<Slopes>,
    /// Root of what each value counts for as evidence, log by log.
    weights: Vec<Vec<f64>>,
}

/// Share of a fit's unit over which slopes are taken.
const STEP: f64 = 0.1;

/// How near the ratio is to come to what it is to be, and in how many tries.
const NEAR: f64 = 1.2;
const TRIES: usize = 4;

impl Context {
    /// Makes the campaign of a recipe. Where it does not state its noise, the usual trueness of its
    /// instruments is what something must show beside.
    ///
    /// # Errors
    /// [`CorpusError`].
    pub fn new(recipe: &Recipe) -> Result<Self, CorpusError> {
        let without = ready(recipe)?;
        let point = calibrations(&without.problem);
        let at = fit::residuals(&without.problem, &FitState::empty(without.problem.logs.len()))?;
        let mut slopes = fit::slopes(&without.problem, &point, &point.free, &at, STEP);
        let root = |log: &PreparedLog| {
            rules::evidence_weights(&log.compared).iter().map(|weight| weight.sqrt()).collect()
        };
        let weights: Vec<Vec<f64>> = without.problem.logs.iter().map(root).collect();
        for (slope, weights) in slopes.iter_mut().flat_map(|of| of.iter_mut().zip(&weights)) {
            slope.iter_mut().for_each(|values| weigh(values, weights));
        }
        let blocks = fit::blocks_of(&without.problem);
        Ok(Self { blocks, recipe: recipe.clone(), without, at, point, slopes, weights })
    }

    /// How well what a recipe has more than this campaign shows. `own`: a calibration that is
    /// itself what is hidden.
    ///
    /// # Errors
    /// [`CorpusError`].
    pub fn seen(&self, with: &Recipe, own: Option<EffectPlace>) -> Result<Visibility, CorpusError> {
        let with = ready(with)?;
        let there = fit::residuals(&with.problem, &FitState::empty(with.problem.logs.len()))?;
        let mut difference: Residuals = Vec::new();
        for (log, own) in self.without.problem.logs.iter().enumerate() {
            let key = |c: &Compared| (c.quantity, c.component, c.row);
            let theirs = with.problem.logs[log].compared.iter().zip(&there[log].residual);
            let theirs: HashMap<_, f64> = theirs.map(|(c, r)| (key(c), r * c.deviation)).collect();
            let ours = own.compared.iter().zip(&self.at[log].residual);
            let mut residual: Vec<f64> = ours
                .map(|(c, r)| theirs.get(&key(c)).map_or(0.0, |t| t / c.deviation - r))
                .collect();
            weigh(&mut residual, &self.weights[log]);
            difference.push(Prediction {
                residual,
                motion: None,
                late: None,
                not_evidence: 0.0,
                noise: None,
            });
        }
        let free: Vec<usize> = (0..self.point.free.len())
            .filter(|k| own != Some(self.point.effect(self.point.free[*k].of).place()))
            .collect();
        let weight = DVector::from_fn(free.len(), |i, _| {
            let free = &self.point.free[free[i]];
            (fit::unit(self.point.parameter(free), self.point.value(free)) / free.expected).powi(2)
        });
        let prior = DMatrix::from_diagonal(&weight);
        let slopes: Vec<&Slopes> = free.iter().map(|k| &self.slopes[*k]).collect();
        let away = DVector::zeros(free.len());
        let linear = Linear::new(&self.blocks, &difference, &slopes, prior, away.clone());
        let step = linear.solve(None, 0.0, None).map_or(away, |s| s.step);
        for (k, slopes) in slopes.iter().enumerate() {
            for (log, slope) in slopes.iter().enumerate() {
                let Some(slope) = slope else { continue };
                difference[log].residual.iter_mut().zip(slope).for_each(|(d, s)| *d += s * step[k]);
            }
        }
        Ok(Visibility {
            size: 1.0,
            ratio: (linear.cost(&step) / rules::GAIN).sqrt(),
            excess: self.most(&difference) / VISIBLE,
        })
    }

    /// The largest mean square of any channel of any log.
    fn most(&self, difference: &Residuals) -> f64 {
        let mut parts: BTreeMap<(usize, &str), (f64, f64)> = BTreeMap::new();
        for (log, own) in self.without.problem.logs.iter().enumerate() {
            for (c, d) in own.compared.iter().zip(&difference[log].residual) {
                let part = parts.entry((log, c.quantity.channel())).or_default();
                *part = (part.0 + d * d, part.1 + 1.0);
            }
        }
        parts.values().map(|(square, count)| square / count).fold(0.0, f64::max)
    }

    /// The effect at the size at which it shows as well as `target` says, as far as its values stay
    /// plausible.
    pub fn size_effect(&self, target: f64, drawn: impl Fn(f64) -> Effect) -> (Effect, Visibility) {
        let own = drawn(1.0);
        let own = is_calibration(own.kind).then_some(own.place());
        let seen = self.size(target, |size| {
            let effect = drawn(size);
            plausible(&effect)
                .then(|| self.seen(&self.recipe.clone().with_effect(effect), own).ok())
                .flatten()
        });
        (drawn(seen.size), seen)
    }

    /// The effect outside the library at the size at which it shows as well as `target` says.
    pub fn size_out_of_library(
        &self,
        target: f64,
        effect: OutOfLibrary,
    ) -> (OutOfLibrary, Visibility) {
        let at = |size: f64| OutOfLibrary { size, ..effect };
        let seen = self.size(target, |size| {
            self.seen(&self.recipe.clone().with_out_of_library(at(size)), None).ok()
        });
        (at(seen.size), seen)
    }

    /// The size that comes nearest to `target`. What shows is nearly in proportion to the size;
    /// `seen` gives nothing for a size that is too large to be plausible or for the campaign to
    /// come to an end.
    fn size(&self, target: f64, seen: impl Fn(f64) -> Option<Visibility>) -> Visibility {
        let mut best = Visibility { size: 0.0, ratio: 0.0, excess: 0.0 };
        let away = |s: &Visibility| (s.ratio.max(1e-9) / target).ln().abs();
        let (mut size, mut too_large) = (1.0, f64::INFINITY);
        for _ in 0..TRIES {
            match seen(size) {
                Some(found) => {
                    let found = Visibility { size, ..found };
                    if away(&found) < away(&best) {
                        best = found;
                    }
                    if away(&found) < NEAR.ln() {
                        break;
                    }
                    let next = size * (target / found.ratio.max(1e-9)).clamp(0.02, 20.0);
                    size = if next >= too_large { (size * too_large).sqrt() } else { next };
                }
                None => {
                    too_large = size;
                    size = if best.size > 0.0 { (best.size * size).sqrt() } else { 0.3 * size };
                }
            }
        }
        best
    }
}

/// Values as much as each counts for.
fn weigh(values: &mut [f64], weights: &[f64]) {
    values.iter_mut().zip(weights).for_each(|(value, weight)| *value *= weight);
}
