//! By how much an experiment would tell two models apart once either was refitted to what the other
//! makes of it.
//!
//! With D the difference of their predictions over the noise, S the slopes of the second model's
//! residuals by all that may be refitted, and P what is known of those values before (priors, and
//! what the logs so far say), the least sum of squares that the second leaves of the first is
//!
//! ```text
//! Δχ² = DᵀD − DᵀS (SᵀS + P)⁻¹ SᵀD
//! ```

use crate::fit::calibration::{calibrations, expected};
use crate::fit::{
    self, EffectScope, Factor, FitProblem, FitState, FreeParameter, Linear, Residuals, Slopes,
};
use crate::predict::{Experiment, Prediction};
use nalgebra::{DMatrix, DVector};
use trueweld_plant::effects::{Effect, Location};

/// Share of a fit's unit over which slopes are taken.
const STEP: f64 = 0.1;

/// The calibrations, and what the logs so far say of them; slopes are those of the model without
/// any explanation.
#[derive(Debug)]
pub(super) struct Context<'a> {
    bench: &'a FitProblem,
    /// Calibrations that an explanation consists of, and which no other may use.
    claimed: Vec<(&'static str, Location)>,
    point: FitState,
    slopes: Vec<Slopes>,
}

impl<'a> Context<'a> {
    /// `None` where the model cannot be driven through the logs.
    pub fn of(bench: &'a FitProblem, claimed: Vec<(&'static str, Location)>) -> Option<Self> {
        let point = unclaimed(calibrations(bench), &claimed);
        let at = fit::residuals(bench, &point).ok()?;
        let slopes = fit::slopes(bench, &point, &point.free, &at, STEP);
        Some(Self { bench, claimed, point, slopes })
    }

    /// What the logs so far say of a rival. `None` where it cannot be driven through them.
    pub fn rival(&self, effects: &[Effect]) -> Option<Rival> {
        let bench = self.bench;
        let mut point = self.point.clone();
        for effect in effects {
            point.add_expected(effect.clone(), &expected(effect.kind));
        }
        let at = fit::residuals(bench, &point).ok()?;
        let own = fit::slopes(bench, &point, &point.free[self.slopes.len()..], &at, STEP);
        let slopes: Vec<&Slopes> = self.slopes.iter().chain(&own).collect();
        let linear = unexpected(bench, &at, &slopes, weights(&point));
        let cost = linear.cost(&linear.solve(None, 0.0, None)?.step);
        // Where the model misses more than noise, the logs say less of its values than their noise
        // would have it.
        let trust = (cost / fit::count(&at).max(1) as f64).max(1.0);
        let known = linear.information(None, trust);
        // What each log has of its own is eliminated.
        let is_shared = |k: &usize| matches!(point.free[*k].of, EffectScope::All(_));
        let (shared, own): (Vec<usize>, Vec<usize>) = (0..slopes.len()).partition(is_shared);
        let part =
            |rows: &[usize], columns: &[usize]| known.select_rows(rows).select_columns(columns);
        let mut left = part(&shared, &shared);
        if !own.is_empty() {
            let cross = part(&own, &shared);
            left -= cross.tr_mul(&Factor::new(&part(&own, &own), 0.0)?.solve(&cross));
        }
        let free = shared.iter().map(|k| point.free[*k]).collect();
        Some(Rival { all: point.all, effects: effects.len(), free, known: left, cost })
    }
}

/// One rival explanation: its effects as fitted, beside the calibrations that hold for all logs,
/// and how well the values of both are known.
#[derive(Debug)]
pub(super) struct Rival {
    /// Calibrations, then effects.
    all: Vec<Effect>,
    /// How many of them are effects.
    effects: usize,
    /// Which of their values are free.
    free: Vec<FreeParameter>,
    /// Inverse covariance of those values, priors and logs so far together, in the fit's units.
    known: DMatrix<f64>,
    /// Least sum of squares and priors over the logs so far.
    pub cost: f64,
}

impl Rival {
    /// The rival on a new log, whose own calibrations are free as well: after its own, in their
    /// order.
    fn on(&self, fresh: &FitState) -> FitState {
        let mut point =
            FitState { all: self.all.clone(), each: fresh.each.clone(), free: self.free.clone() };
        for free in &fresh.free {
            match free.of {
                EffectScope::Log(..) => point.free.push(*free),
                EffectScope::All(i) => {
                    let effect = &fresh.all[i];
                    let calibrations = &self.all[..self.all.len() - self.effects];
                    if !calibrations.iter().any(|e| same(e, effect)) {
                        let of = EffectScope::All(point.all.len());
                        point.all.push(effect.clone());
                        point.free.push(FreeParameter { of, ..*free });
                    }
                }
            }
        }
        point
    }

    /// True for a value of one of the effects.
    fn is_own(&self, free: &FreeParameter) -> bool {
        matches!(free.of, EffectScope::All(i) if (self.all.len() - self.effects..self.all.len()).contains(&i))
    }
}

/// True for the same kind of effect at the same place.
fn same(a: &Effect, b: &Effect) -> bool {
    (a.kind.id, a.at) == (b.kind.id, b.at)
}

/// Calibrations but those that an explanation consists of.
fn unclaimed(mut point: FitState, claimed: &[(&'static str, Location)]) -> FitState {
    let free = std::mem::take(&mut point.free);
    let is_claimed = |effect: &Effect| claimed.contains(&(effect.kind.id, effect.at));
    point.free = free.into_iter().filter(|f| !is_claimed(point.effect(f.of))).collect();
    point
}

/// A new experiment, ready to be predicted.
#[derive(Debug)]
pub(super) struct PlannedTrial {
    bench: FitProblem,
}

impl PlannedTrial {
    pub fn new(bench: &FitProblem, experiment: Experiment) -> Self {
        Self { bench: FitProblem { per_log: Vec::new(), ..bench.on(vec![experiment]) } }
    }

    fn at(&self, point: &FitState) -> Option<Residuals> {
        fit::residuals(&self.bench, point).ok()
    }

    /// Difference of two rivals' predictions, in standard deviations of all compared values
    /// together: what refitting can only make less.
    pub fn apart(&self, a: &[Effect], b: &[Effect]) -> Option<f64> {
        let point = |effects: &[Effect]| FitState {
            all: effects.to_vec(),
            each: vec![Vec::new()],
            free: Vec::new(),
        };
        let (a, b) = (self.at(&point(a))?, self.at(&point(b))?);
        let square: f64 =
            a[0].residual.iter().zip(&b[0].residual).map(|(a, b)| (a - b).powi(2)).sum();
        square.is_finite().then(|| square.sqrt())
    }

    /// Expected √Δχ² between rivals and the first of them, whichever is true and the other
    /// refitted: the smaller of both.
    pub fn separations(
        &self,
        ground: &Context<'_>,
        first: &Rival,
        others: &[&Rival],
    ) -> Option<Vec<f64>> {
        let fresh = unclaimed(calibrations(&self.bench), &ground.claimed);
        let at = self.at(&fresh)?;
        let calibrated = fit::slopes(&self.bench, &fresh, &fresh.free, &at, STEP);
        let a = self.predicted(&fresh, &calibrated, first)?;
        others
            .iter()
            .map(|other| {
                let b = self.predicted(&fresh, &calibrated, other)?;
                let apart: Vec<f64> = b.at.iter().zip(&a.at).map(|(b, a)| b - a).collect();
                let left_of_b = b.left(&self.bench, other, &apart)?;
                let least = left_of_b.min(a.left(&self.bench, first, &apart)?);
                least.is_finite().then(|| least.max(0.0).sqrt())
            })
            .collect()
    }

    /// A rival's prediction, with slopes of all it may refit.
    fn predicted(
        &self,
        fresh: &FitState,
        calibrated: &[Slopes],
        rival: &Rival,
    ) -> Option<Predicted> {
        let point = rival.on(fresh);
        let at = self.at(&point)?;
        let own: Vec<FreeParameter> =
            point.free.iter().copied().filter(|f| rival.is_own(f)).collect();
        let mut own = fit::slopes(&self.bench, &point, &own, &at, STEP).into_iter();
        let slopes = point
            .free
            .iter()
            .map(|free| {
                if rival.is_own(free) {
                    return own.next();
                }
                let wanted = |f: &&FreeParameter| {
                    f.parameter == free.parameter
                        && match (f.of, free.of) {
                            (EffectScope::All(i), EffectScope::All(j)) => {
                                same(&fresh.all[i], &point.all[j])
                            }
                            (one, other) => one == other,
                        }
                };
                let index = fresh.free.iter().position(|f| wanted(&f));
                // What the logs so far have and this one does not show has no slopes here.
                Some(index.map_or(vec![None], |k| calibrated[k].clone()))
            })
            .collect::<Option<Vec<Slopes>>>()?;
        let at = at.into_iter().next()?.residual;
        Some(Predicted { point, at, slopes })
    }
}

/// A rival's prediction of a new log.
struct Predicted {
    point: FitState,
    at: Vec<f64>,
    slopes: Vec<Slopes>,
}

impl Predicted {
    /// Least sum of squares and priors that a refit leaves of a difference.
    fn left(&self, bench: &FitProblem, rival: &Rival, difference: &[f64]) -> Option<f64> {
        let before = rival.free.len();
        let mut weights = weights(&self.point);
        weights.rows_mut(0, before).fill(0.0);
        let at = vec![Prediction {
            residual: difference.to_vec(),
            motion: None,
            late: None,
            anywhere: 0.0,
        }];
        let mut linear = unexpected(bench, &at, &self.slopes.iter().collect::<Vec<_>>(), weights);
        // What the logs so far say counts as one more block.
        let mut shared = linear.square[0].view_mut((0, 0), (before, before));
        shared += &rival.known;
        Some(linear.cost(&linear.solve(None, 0.0, None)?.step))
    }
}

/// The linear model of values that are expected where they stand.
fn unexpected(
    bench: &FitProblem,
    at: &Residuals,
    slopes: &[&Slopes],
    weights: DVector<f64>,
) -> Linear {
    let away = DVector::zeros(slopes.len());
    let prior = DMatrix::from_diagonal(&weights);
    Linear::new(&fit::blocks_of(bench), at, slopes, prior, away)
}

/// Weight of each free value's prior, in the fit's units.
fn weights(point: &FitState) -> DVector<f64> {
    DVector::from_iterator(
        point.free.len(),
        point.free.iter().map(|free| {
            (fit::unit(point.parameter(free), point.value(free)) / free.expected).powi(2)
        }),
    )
}
