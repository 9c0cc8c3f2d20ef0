//! Full fits of the hypotheses that screening leaves, and of pairs of them.

use super::rules::{self, at_floor, counts, standing_out};
use super::screen::{Ground, Screened, screen};
use crate::calibrate::{calibrations, of_logs};
use crate::fit::{self, Bench, Effort, Fitted, Point};
use crate::predict::{PredictError, Quantity};
use rayon::prelude::*;
use trueweld_plant::effects::{At, Effect, Role};
use trueweld_plant::robot::Channel;

/// Fits the calibrations alone: those logs first whose residuals follow them nearly in proportion, then all.
///
/// # Errors
/// [`PredictError`].
pub(crate) fn calibrated(bench: &Bench, blocks: &[Vec<u8>]) -> Result<Fitted, PredictError> {
    let point = calibrations(bench);
    let stale = of_logs(&point);
    fit::fit(bench, &point, blocks, &[], Effort { steps: 4, stale })
}

/// Fits one hypothesis in full from where screening left it.
///
/// # Errors
/// [`PredictError`].
fn fit_hypothesis(ground: &Ground<'_>, effect: &Effect, steps: usize) -> Result<Fitted, PredictError> {
    // Slopes at nothing say little of the size of what is not in proportion to it, a gap or a loop, and calibrations have
    // moved to hide it: sizes are judged with the calibrations at their best beside them.
    let known = ground.null.slopes.len();
    let start = |factor: f64| {
        let effect = scaled(effect, factor);
        let mut point: Point = ground.null.point.clone();
        let at = fit::residuals(
            ground.bench,
            &Point { all: [point.all.clone(), vec![effect.clone()]].concat(), ..point.clone() },
        );
        let linear = ground.null.linear.beside(ground.blocks, &at.ok()?, &ground.null.slopes);
        let step = linear.solve(None, 0.0, None)?.step;
        let cost = linear.cost(&step);
        if known > 0 {
            point = point.moved(&step);
        }
        point.add(effect, f64::INFINITY);
        Some((cost, point))
    };
    let best = FACTORS.iter().filter_map(|f| start(*f)).min_by(|a, b| a.0.total_cmp(&b.0));
    let mut plain: Point = ground.null.point.clone();
    plain.add(effect.clone(), f64::INFINITY);
    let point = best.map_or(plain, |(_, point)| point);
    fit::fit(ground.bench, &point, ground.blocks, &ground.null.slopes, Effort { steps, stale: known })
}

/// An effect with its sizes so many times as large, within their bounds.
fn scaled(effect: &Effect, factor: f64) -> Effect {
    let mut effect = effect.clone();
    for (v, p) in effect.values.iter_mut().zip(effect.kind.parameters) {
        if let Role::Size { neutral, .. } = p.role {
            *v = (neutral + (*v - neutral) * factor).clamp(p.low, p.high);
        }
    }
    effect
}

/// Factors on the size that screening gives, at which a fit may start.
const FACTORS: [f64; 6] = [0.4, 1.0, 2.5, 6.0, 15.0, 40.0];

/// Fits hypotheses, best first: all of them roughly, those that come near the best in full, the best with slopes taken afresh.
pub(super) fn fit_all<'s>(ground: &Ground<'_>, screened: impl Iterator<Item = &'s Screened>) -> Vec<Fitted> {
    let screened: Vec<&Screened> = screened.filter(|s| s.gain > rules::GAIN * 0.5).collect();
    let mut fits: Vec<Fitted> =
        screened.par_iter().filter_map(|s| fit_hypothesis(ground, &s.effect, ROUGHLY).ok()).collect();
    fits.retain(|f| f.point.all.last().is_none_or(|e| !held(ground.bench, e)));
    let least = fits.iter().map(|f| f.cost).fold(f64::INFINITY, f64::min);
    let near = ground.null.cost - rules::NEARLY * (ground.null.cost - least);
    let stale = ground.null.slopes.len();
    fits.par_iter_mut().filter(|f| f.cost <= near).for_each(|fitted| {
        let effort = Effort { steps: IN_FULL, stale };
        if let Ok(better) = fit::fit(ground.bench, &fitted.point, ground.blocks, &ground.null.slopes, effort)
            && better.cost < fitted.cost
        {
            *fitted = better;
        }
    });
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    if let Some(best) = fits.first_mut() {
        polish(ground.bench, ground.blocks, best);
    }
    fits
}

/// Steps of a rough fit, and of the rest of a full one.
const ROUGHLY: usize = 2;
const IN_FULL: usize = 4;

/// True for a delay that is no longer than a controller holds its values.
fn held(bench: &Bench, effect: &Effect) -> bool {
    let At::Channel(channel) = effect.at else { return false };
    let of = |q: Quantity| match channel {
        Channel::Tracker => matches!(q, Quantity::Position | Quantity::Rotation),
        Channel::Wrench => matches!(q, Quantity::Force | Quantity::Moment | Quantity::Ripple { .. }),
        Channel::MotorTorque => q == Quantity::MotorTorque,
        Channel::LinkEncoder => q == Quantity::LinkEncoder,
    };
    let seen = bench.experiments.iter().filter(|e| e.compared.iter().any(|c| of(c.quantity)));
    let period = seen.map(|e| e.period).fold(f64::INFINITY, f64::min);
    period.is_finite() && effect.values[0].abs() < rules::HELD * period
}

/// Refits with fresh slopes of all that is not in proportion. What has a threshold, as a gap has, can hold such a fit up: its
/// sizes are tried a little to either side as well.
fn polish(bench: &Bench, blocks: &[Vec<u8>], fitted: &mut Fitted) {
    refit(bench, blocks, fitted);
    let Some(last) = fitted.point.all.len().checked_sub(1) else { return };
    if at_floor(bench, &fitted.at) {
        return;
    }
    let aside: Vec<Fitted> = ASIDE
        .par_iter()
        .filter_map(|factor| {
            let mut point = fitted.point.clone();
            point.all[last] = scaled(&point.all[last], *factor);
            let effort = Effort { steps: 1, stale: fitted.slopes.len() };
            fit::fit(bench, &point, blocks, &fitted.slopes, effort).ok()
        })
        .collect();
    if let Some(better) = aside.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost)).filter(|b| b.cost < fitted.cost) {
        *fitted = better;
        refit(bench, blocks, fitted);
    }
}

/// Factors on a size by which it is tried aside.
const ASIDE: [f64; 4] = [0.95, 0.98, 1.02, 1.05];

fn refit(bench: &Bench, blocks: &[Vec<u8>], fitted: &mut Fitted) {
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
pub(super) fn second(ground: &Ground<'_>, best: &Fitted, singles: &[Fitted]) -> Option<Fitted> {
    let pair = further(ground, best).into_iter().next()?;
    // What is left must fall by half at least: a prediction that is not quite right leaves a little for any effect to mend.
    if standing_out(ground.bench, &pair.at) > rules::HALVED * standing_out(ground.bench, &best.at) {
        return None;
    }
    let same = |a: &Effect, b: &Effect| (a.kind.id, a.at) == (b.kind.id, b.at);
    let other = pair.point.all.last()?;
    let alone = singles.iter().find(|s| s.point.all.last().is_some_and(|e| same(e, other)));
    if alone.is_some_and(|alone| !counts(ground.bench, alone, &pair)) {
        return None;
    }
    Some(pair)
}

/// The effects that bring more than chance beside those of a fit, fitted with them, the one that brings the most first.
pub(crate) fn further(ground: &Ground<'_>, fitted: &Fitted) -> Vec<Fitted> {
    let beside = Ground { null: fitted, ..*ground };
    let screened = screen(&beside);
    let has = |s: &Screened| fitted.point.all.iter().any(|e| (e.kind.id, e.at) == (s.effect.kind.id, s.effect.at));
    let mut next = fit_all(&beside, screened.iter().filter(|s| !has(s)).take(rules::FITTED_BESIDE));
    next.retain(|f| counts(ground.bench, fitted, f));
    next
}
