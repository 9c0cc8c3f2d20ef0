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

use nalgebra::{DMatrix, DVector};
use trueweld_estimate::fit::calibration::{calibrations, expected};
use trueweld_estimate::fit::{
    self, EffectScope, Factor, FitProblem, FitState, FreeParameter, Linear, Residuals, Slopes,
};
use trueweld_estimate::predict::{Prediction, PreparedLog};
use trueweld_plant::effects::{Effect, EffectPlace};

/// The calibrations, and what the logs so far say of them; slopes are those of the model without
/// any explanation.
#[derive(Debug)]
pub(super) struct SeparationContext<'a> {
    problem: &'a FitProblem,
    /// Calibrations that an explanation consists of, and which no other may use.
    claimed: Vec<EffectPlace>,
    point: FitState,
    slopes: Vec<Slopes>,
}

impl<'a> SeparationContext<'a> {
    /// `None` where the model cannot be driven through the logs.
    pub(crate) fn of(problem: &'a FitProblem, claimed: Vec<EffectPlace>) -> Option<Self> {
        let point = unclaimed(calibrations(problem), &claimed);
        let at = fit::residuals(problem, &point).ok()?;
        let slopes = fit::slopes(problem, &point, &point.free, &at, fit::SLOPE_STEP);
        Some(Self { problem, claimed, point, slopes })
    }

    /// What the logs so far say of a rival. `None` where it cannot be driven through them.
    pub(crate) fn rival(&self, effects: &[Effect]) -> Option<Rival> {
        let problem = self.problem;
        let mut point = self.point.clone();
        for effect in effects {
            point.add_expected(effect.clone(), &expected(effect.kind));
        }
        let at = fit::residuals(problem, &point).ok()?;
        let own =
            fit::slopes(problem, &point, &point.free[self.slopes.len()..], &at, fit::SLOPE_STEP);
        let slopes: Vec<&Slopes> = self.slopes.iter().chain(&own).collect();
        let linear = unexpected(problem, &at, &slopes, weights(&point));
        let cost = linear.cost(&linear.solve(None, 0.0, None)?.step);
        // Where the model misses more than noise, the logs say less of its values than their noise
        // would have it.
        let inflation = (cost / fit::count(&at).max(1) as f64).max(1.0);
        let known = linear.information(None, inflation);
        // What each log has of its own is eliminated.
        let is_shared = |k: &usize| matches!(point.free[*k].of, EffectScope::Shared(_));
        let (shared, own): (Vec<usize>, Vec<usize>) = (0..slopes.len()).partition(is_shared);
        let part =
            |rows: &[usize], columns: &[usize]| known.select_rows(rows).select_columns(columns);
        let mut left = part(&shared, &shared);
        if !own.is_empty() {
            let cross = part(&own, &shared);
            left -= cross.tr_mul(&Factor::new(&part(&own, &own), 0.0)?.solve(&cross));
        }
        let free = shared.iter().map(|k| point.free[*k]).collect();
        Some(Rival { all: point.shared, effects: effects.len(), free, known: left, cost })
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
        let mut point = FitState {
            shared: self.all.clone(),
            per_log: fresh.per_log.clone(),
            free: self.free.clone(),
        };
        for free in &fresh.free {
            match free.of {
                EffectScope::Log(..) => point.free.push(*free),
                EffectScope::Shared(i) => {
                    let effect = &fresh.shared[i];
                    let calibrations = &self.all[..self.all.len() - self.effects];
                    if !calibrations.iter().any(|e| e.place() == effect.place()) {
                        let of = EffectScope::Shared(point.shared.len());
                        point.shared.push(effect.clone());
                        point.free.push(FreeParameter { of, ..*free });
                    }
                }
            }
        }
        point
    }

    /// True for a value of one of the effects.
    fn is_own(&self, free: &FreeParameter) -> bool {
        matches!(free.of, EffectScope::Shared(i) if (self.all.len() - self.effects..self.all.len()).contains(&i))
    }
}

/// True for the same value of the same effect at two points.
fn same_value((a, f): (&FitState, &FreeParameter), (b, g): (&FitState, &FreeParameter)) -> bool {
    let same_effect = match (f.of, g.of) {
        (EffectScope::Shared(i), EffectScope::Shared(j)) => {
            a.shared[i].place() == b.shared[j].place()
        }
        (one, other) => one == other,
    };
    f.parameter == g.parameter && same_effect
}

/// Calibrations but those that an explanation consists of.
fn unclaimed(mut point: FitState, claimed: &[EffectPlace]) -> FitState {
    let free = std::mem::take(&mut point.free);
    let is_claimed = |effect: &Effect| claimed.contains(&effect.place());
    point.free = free.into_iter().filter(|f| !is_claimed(point.effect(f.of))).collect();
    point
}

/// A new experiment, ready to be predicted.
#[derive(Debug)]
pub(super) struct PlannedTrial {
    problem: FitProblem,
}

impl PlannedTrial {
    pub(crate) fn new(problem: &FitProblem, experiment: PreparedLog) -> Self {
        Self { problem: FitProblem { per_log: Vec::new(), ..problem.on(vec![experiment]) } }
    }

    fn at(&self, point: &FitState) -> Option<Residuals> {
        fit::residuals(&self.problem, point).ok()
    }

    /// Difference of two rivals' predictions, in standard deviations of all compared values
    /// together: what refitting can only make less.
    pub(crate) fn apart(&self, a: &[Effect], b: &[Effect]) -> Option<f64> {
        let point = |effects: &[Effect]| FitState {
            shared: effects.to_vec(),
            per_log: vec![Vec::new()],
            free: Vec::new(),
        };
        let square = fit::distance(&self.at(&point(a))?, &self.at(&point(b))?);
        square.is_finite().then(|| square.sqrt())
    }

    /// Expected √Δχ² between rivals and the first of them, whichever is true and the other
    /// refitted: the smaller of both.
    pub(crate) fn separations(
        &self,
        ctx: &SeparationContext<'_>,
        first: &Rival,
        others: &[&Rival],
    ) -> Option<Vec<f64>> {
        let fresh = unclaimed(calibrations(&self.problem), &ctx.claimed);
        let at = self.at(&fresh)?;
        let calibrated = fit::slopes(&self.problem, &fresh, &fresh.free, &at, fit::SLOPE_STEP);
        let a = self.predicted(&fresh, &calibrated, first)?;
        others
            .iter()
            .map(|other| {
                let b = self.predicted(&fresh, &calibrated, other)?;
                let apart: Vec<f64> = b.at.iter().zip(&a.at).map(|(b, a)| b - a).collect();
                let left_of_b = b.left(&self.problem, other, &apart)?;
                let least = left_of_b.min(a.left(&self.problem, first, &apart)?);
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
    ) -> Option<RivalPrediction> {
        let point = rival.on(fresh);
        let at = self.at(&point)?;
        let own: Vec<FreeParameter> =
            point.free.iter().copied().filter(|f| rival.is_own(f)).collect();
        let mut own = fit::slopes(&self.problem, &point, &own, &at, fit::SLOPE_STEP).into_iter();
        let slopes = point
            .free
            .iter()
            .map(|free| {
                if rival.is_own(free) {
                    return own.next();
                }
                let index = fresh.free.iter().position(|f| same_value((fresh, f), (&point, free)));
                // What the logs so far have and this one does not show has no slopes here.
                Some(index.map_or(vec![None], |k| calibrated[k].clone()))
            })
            .collect::<Option<Vec<Slopes>>>()?;
        let at = at.into_iter().next()?.residual;
        Some(RivalPrediction { point, at, slopes })
    }
}

/// A rival's prediction of a new log.
struct RivalPrediction {
    point: FitState,
    at: Vec<f64>,
    slopes: Vec<Slopes>,
}

impl RivalPrediction {
    /// Least sum of squares and priors that a refit leaves of a difference.
    fn left(&self, problem: &FitProblem, rival: &Rival, difference: &[f64]) -> Option<f64> {
        let before = rival.free.len();
        let mut weights = weights(&self.point);
        weights.rows_mut(0, before).fill(0.0);
        let at = vec![Prediction {
            residual: difference.to_vec(),
            motion: None,
            late: None,
            not_evidence: 0.0,
            noise: None,
        }];
        let mut linear = unexpected(problem, &at, &self.slopes.iter().collect::<Vec<_>>(), weights);
        // What the logs so far say counts as one more block.
        let mut shared = linear.jtj[0].view_mut((0, 0), (before, before));
        shared += &rival.known;
        Some(linear.cost(&linear.solve(None, 0.0, None)?.step))
    }
}

/// The linear model of values that are expected where they stand.
fn unexpected(
    problem: &FitProblem,
    at: &Residuals,
    slopes: &[&Slopes],
    weights: DVector<f64>,
) -> Linear {
    let away = DVector::zeros(slopes.len());
    let prior = DMatrix::from_diagonal(&weights);
    Linear::new(&fit::blocks_of(problem), at, slopes, prior, away)
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
