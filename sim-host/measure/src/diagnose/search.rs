//! Full fits of the hypotheses that screening leaves, and of pairs of them.

use super::rules::{self, above, counts};
use super::screen::{Ground, Screened, screen};
use crate::calibrate::{calibrations, of_logs};
use crate::fit::{self, Bench, Effort, Fitted, Point};
use crate::predict::PredictError;
use rayon::prelude::*;
use trueweld_plant::effects::{Effect, Role};

/// Fits the calibrations alone: those logs first whose residuals follow them nearly in proportion, then all.
///
/// # Errors
/// [`PredictError`].
pub(crate) fn calibrated(bench: &Bench, blocks: &[Vec<u8>]) -> Result<Fitted, PredictError> {
    let point = calibrations(bench);
    let stale = of_logs(&point);
    fit::fit(bench, &point, blocks, &[], Effort { steps: 4, stale })
}

/// A hypothesis fitted in full beside what was known before.
#[derive(Debug, Clone)]
pub struct Tried {
    /// The fit.
    pub fitted: Fitted,
    /// Its sum of squares and priors as it counts among others: what it gains is divided by how far the residual raises
    /// hypotheses like it anyway.
    pub cost: f64,
    pub(crate) background: f64,
}

/// Fits one hypothesis in full from where screening left it.
///
/// # Errors
/// [`PredictError`].
fn fit_hypothesis(ground: &Ground<'_>, effect: &Effect, steps: usize) -> Result<Fitted, PredictError> {
    // Slopes at nothing say little of the size of what is not in proportion to it: a gap, a loop.
    let mut start = None;
    for factor in [1.0, 0.4, 2.5, 6.0] {
        let mut effect = effect.clone();
        for (v, p) in effect.values.iter_mut().zip(effect.kind.parameters) {
            if let Role::Size { neutral, .. } = p.role {
                *v = (neutral + (*v - neutral) * factor).clamp(p.low, p.high);
            }
        }
        let mut point: Point = ground.null.point.clone();
        point.add(effect, f64::INFINITY);
        if let Ok(at) = fit::residuals(ground.bench, &point) {
            let left = fit::chi_square(&at);
            if start.as_ref().is_none_or(|(least, _)| left < *least) {
                start = Some((left, point));
            }
        }
    }
    let point = match start {
        Some((_, point)) => point,
        None => {
            let mut point: Point = ground.null.point.clone();
            point.add(effect.clone(), f64::INFINITY);
            point
        }
    };
    let stale = ground.null.slopes.len();
    fit::fit(ground.bench, &point, ground.blocks, &ground.null.slopes, Effort { steps, stale })
}

/// Fits hypotheses in full, best first; the best with slopes taken afresh.
pub(super) fn fit_all<'s>(ground: &Ground<'_>, screened: impl Iterator<Item = &'s Screened>) -> Vec<Tried> {
    let screened: Vec<&Screened> = screened.filter(|s| s.gain > rules::GAIN * 0.5 * s.background).collect();
    let tried = |s: &&Screened| {
        let fitted = fit_hypothesis(ground, &s.effect, 5).ok()?;
        Some(Tried { cost: weighed(ground, &fitted, s.background), fitted, background: s.background })
    };
    let mut fits: Vec<Tried> = screened.par_iter().filter_map(tried).collect();
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    if let Some(best) = fits.first_mut() {
        polish(ground.bench, ground.blocks, &mut best.fitted);
        best.cost = weighed(ground, &best.fitted, best.background);
    }
    fits
}

fn weighed(ground: &Ground<'_>, fitted: &Fitted, background: f64) -> f64 {
    ground.null.cost - (ground.null.cost - fitted.cost) / background
}

/// Refits with fresh slopes of all that is not in proportion.
fn polish(bench: &Bench, blocks: &[Vec<u8>], fitted: &mut Fitted) {
    let stale = of_logs(&fitted.point);
    let known = fitted.slopes[..stale].to_vec();
    if let Ok(better) = fit::fit(bench, &fitted.point, blocks, &known, Effort { steps: 3, stale })
        && better.cost <= fitted.cost * (1.0 + 1e-9)
    {
        *fitted = better;
    }
}

/// The best pair that the best single effect is a member of, if it brings more than chance; none where the other alone does
/// what both do together.
pub(super) fn second(ground: &Ground<'_>, best: &Tried, singles: &[Tried]) -> Option<Tried> {
    let pair = further(ground, &best.fitted)?;
    // What is left must fall by half at least: a prediction that is not quite right leaves a little for any effect to mend.
    if above(&pair.fitted.at) > rules::HALVED * above(&best.fitted.at) {
        return None;
    }
    let same = |a: &Effect, b: &Effect| (a.kind.id, a.at) == (b.kind.id, b.at);
    let other = pair.fitted.point.all.last()?;
    let alone = singles.iter().find(|s| s.fitted.point.all.last().is_some_and(|e| same(e, other)));
    if alone.is_some_and(|alone| !counts(ground.bench, &alone.fitted, &pair.fitted, pair.background)) {
        return None;
    }
    Some(pair)
}

/// The effect that brings the most beside those of a fit, fitted with them; `None` where none brings more than chance.
pub(crate) fn further(ground: &Ground<'_>, fitted: &Fitted) -> Option<Tried> {
    let beside = Ground { null: fitted, ..*ground };
    let screened = screen(&beside);
    let has = |s: &Screened| fitted.point.all.iter().any(|e| (e.kind.id, e.at) == (s.effect.kind.id, s.effect.at));
    let next = fit_all(&beside, screened.iter().filter(|s| !has(s)).take(rules::FITTED_BESIDE)).into_iter().next()?;
    counts(ground.bench, fitted, &next.fitted, next.background).then_some(next)
}
