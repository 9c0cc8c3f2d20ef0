//! Full fits of the hypotheses that screening leaves, and of pairs of them.

use super::rules::{self, at_floor, counts, standing_out};
use super::screen::{Context, Screened, screen};
use crate::fit::calibration::{calibrations, in_proportion, is_calibration};
use crate::fit::{self, Effort, FitProblem, FitState, Fitted};
use crate::predict::{PredictError, Quantity};
use rayon::prelude::*;
use trueweld_plant::effects::{Effect, Location, Role};
use trueweld_plant::robot::Channel;

/// Fits the calibrations alone: those logs first whose residuals follow them nearly in proportion,
/// then all.
///
/// # Errors
/// [`PredictError`].
pub(crate) fn calibrated(bench: &FitProblem, blocks: &[Vec<u8>]) -> Result<Fitted, PredictError> {
    let point = calibrations(bench);
    let stale = in_proportion(&point);
    fit::fit(bench, &point, blocks, &[], Effort { steps: 4, stale })
}

/// The same point with those calibrations that are free at nothing, and the slopes there.
///
/// # Errors
/// [`PredictError`].
pub(crate) fn uncalibrated(
    bench: &FitProblem,
    blocks: &[Vec<u8>],
    point: &FitState,
) -> Result<Fitted, PredictError> {
    let mut point = point.clone();
    point.reset(|effect| is_calibration(effect.kind));
    fit::fit(bench, &point, blocks, &[], Effort { steps: 0, stale: 0 })
}

/// Fits one hypothesis roughly from where screening left it: beside the calibrations at their best
/// without it, which may have moved far to hide it, and beside none.
fn fit_hypothesis(ground: &Context<'_>, effect: &Effect) -> Option<Fitted> {
    // The same where nothing is free.
    let bases = if ground.null.slopes.is_empty() { 1 } else { 2 };
    [ground.null, ground.given]
        .into_iter()
        .take(bases)
        .filter_map(|base| {
            let point = start(ground, base, effect)?;
            let effort = Effort { steps: ROUGHLY, stale: base.slopes.len() };
            fit::fit(ground.bench, &point, ground.blocks, &base.slopes, effort).ok()
        })
        .min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Where a fit of an effect beside `base` starts. Slopes at nothing say little of the size of what
/// is not in proportion to it, a gap or a loop: several sizes are judged with the calibrations at
/// their best beside them.
fn start(ground: &Context<'_>, base: &Fitted, effect: &Effect) -> Option<FitState> {
    let of_size = |factor: f64| {
        let effect = scaled(effect, factor);
        let with = FitState {
            all: [base.point.all.clone(), vec![effect.clone()]].concat(),
            ..base.point.clone()
        };
        let at = fit::residuals(ground.bench, &with).ok()?;
        let linear = base.linear.beside(ground.blocks, &at, &base.slopes);
        let step = linear.solve(None, 0.0, None)?.step;
        let mut point =
            if base.slopes.is_empty() { base.point.clone() } else { base.point.moved(&step) };
        point.add(effect);
        Some((linear.cost(&step), point))
    };
    let best = FACTORS.iter().filter_map(|f| of_size(*f)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, point)| point)
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

/// Fits hypotheses, best first: all of them roughly, those that come near the best in full, the
/// best with slopes taken afresh.
pub(super) fn fit_all<'s>(
    ground: &Context<'_>,
    screened: impl Iterator<Item = &'s Screened>,
) -> Vec<Fitted> {
    let screened: Vec<&Screened> = screened.filter(|s| s.gain > rules::GAIN * 0.5).collect();
    let mut fits: Vec<Fitted> =
        screened.par_iter().filter_map(|s| fit_hypothesis(ground, &s.effect)).collect();
    let least = fits.iter().map(|f| f.cost).fold(f64::INFINITY, f64::min);
    let near = ground.null.cost - rules::NEARLY * (ground.null.cost - least);
    let stale = ground.null.slopes.len();
    fits.par_iter_mut().filter(|f| f.cost <= near).for_each(|fitted| {
        let effort = Effort { steps: IN_FULL, stale };
        if let Ok(better) =
            fit::fit(ground.bench, &fitted.point, ground.blocks, &fitted.slopes, effort)
            && better.cost < fitted.cost
        {
            *fitted = better;
        }
    });
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    // What such a delay does as well or better is not believed of anything else either.
    let by_delay =
        fits.iter().position(|f| f.point.all.last().is_some_and(|e| held(ground.bench, e)));
    fits.truncate(by_delay.unwrap_or(fits.len()));
    if let Some(best) = fits.first_mut() {
        polish(ground.bench, ground.blocks, best);
    }
    fits
}

/// Steps of a rough fit, and of the rest of a full one.
const ROUGHLY: usize = 2;
const IN_FULL: usize = 4;

/// True for a delay of motor torque that is no longer than a controller holds its commands.
fn held(bench: &FitProblem, effect: &Effect) -> bool {
    if effect.at != Location::Channel(Channel::MotorTorque) {
        return false;
    }
    let seen = bench
        .experiments
        .iter()
        .filter(|e| e.compared.iter().any(|c| c.quantity == Quantity::MotorTorque));
    let period = seen.map(|e| e.period).fold(f64::INFINITY, f64::min);
    period.is_finite() && effect.values[0].abs() < rules::HELD * period
}

/// Refits with fresh slopes of all that is not in proportion. What has a threshold, as a gap has,
/// can hold such a fit up: its sizes are tried a little to either side as well.
fn polish(bench: &FitProblem, blocks: &[Vec<u8>], fitted: &mut Fitted) {
    refit(bench, blocks, fitted);
    let Some(last) = fitted.point.all.len().checked_sub(1) else {
        return;
    };
    if at_floor(bench, &fitted.at) {
        return;
    }
    for _ in 0..ROUNDS {
        let aside = ASIDE.par_iter().filter_map(|factor| {
            let mut point = fitted.point.clone();
            point.all[last] = scaled(&point.all[last], *factor);
            let effort = Effort { steps: 1, stale: fitted.slopes.len() };
            fit::fit(bench, &point, blocks, &fitted.slopes, effort).ok()
        });
        let best = aside.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(better) = best.filter(|b| b.cost < fitted.cost * (1.0 - WORTH)) else {
            break;
        };
        *fitted = better;
        refit(bench, blocks, fitted);
    }
}

/// Factors on a size by which it is tried aside, how often, and the share of the cost that must be
/// won by it.
const ASIDE: [f64; 6] = [0.8, 0.93, 0.98, 1.02, 1.07, 1.25];
const ROUNDS: usize = 4;
const WORTH: f64 = 0.01;

fn refit(bench: &FitProblem, blocks: &[Vec<u8>], fitted: &mut Fitted) {
    let stale = in_proportion(&fitted.point);
    let known = fitted.slopes.iter().take(stale).cloned().collect::<Vec<_>>();
    if let Ok(better) = fit::fit(bench, &fitted.point, blocks, &known, Effort { steps: 3, stale })
        && better.cost <= fitted.cost * (1.0 + 1e-9)
    {
        *fitted = better;
    }
}

/// What comes of the best single effect once a second was tried beside it: the effect alone where
/// that is all there is, or alone and with the second. Both members must earn their place: a pair
/// in which either alone does what both do together is none.
pub(super) fn second(ground: &Context<'_>, best: Fitted, singles: &[Fitted]) -> Vec<Fitted> {
    let Some(pair) = further(ground, &best).into_iter().next() else {
        return vec![best];
    };
    // The first one alone again, from where the pair has taken it: what it gains on the way is not
    // the second one's.
    let mut alone = pair.clone();
    alone.point.drop_last();
    alone.slopes.clear();
    alone.cost = f64::INFINITY;
    refit(ground.bench, ground.blocks, &mut alone);
    let first = if alone.cost < best.cost { alone } else { best };
    // What is left must fall by half at least: a prediction that is not quite right leaves a little
    // for any effect to mend.
    let enough = standing_out(ground.bench, &pair.at)
        <= rules::HALVED * standing_out(ground.bench, &first.at);
    let same = |a: &Effect, b: &Effect| (a.kind.id, a.at) == (b.kind.id, b.at);
    let other = pair.point.all.last();
    let other_alone =
        singles.iter().find(|s| s.point.all.last().zip(other).is_some_and(|(e, o)| same(e, o)));
    let enough = enough && fit::chi_square(&first.at) - fit::chi_square(&pair.at) > rules::SECOND;
    let both = counts(ground.bench, &first, &pair)
        && other_alone.is_none_or(|o| counts(ground.bench, o, &pair));
    if enough && both && !at_floor(ground.bench, &first.at) {
        vec![first, pair]
    } else {
        vec![first]
    }
}

/// The effects that bring more than chance beside those of a fit, fitted with them, the one that
/// brings the most first.
pub(crate) fn further(ground: &Context<'_>, fitted: &Fitted) -> Vec<Fitted> {
    let Ok(given) = uncalibrated(ground.bench, ground.blocks, &fitted.point) else {
        return Vec::new();
    };
    let beside = Context { null: fitted, given: &given, ..*ground };
    let screened = screen(&beside);
    let has = |s: &Screened| {
        fitted.point.all.iter().any(|e| (e.kind.id, e.at) == (s.effect.kind.id, s.effect.at))
    };
    let mut next = fit_all(&beside, screened.iter().filter(|s| !has(s)).take(rules::FITTED_BESIDE));
    next.retain(|f| counts(ground.bench, fitted, f));
    next
}
