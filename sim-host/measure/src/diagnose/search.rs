//! Full fits of the hypotheses that screening leaves, and of pairs of them.

use super::confuse::Confusable;
use super::found::{FittedEffect, found_effects};
use super::rules::{self, counts, standing_out};
use super::screen::{Context, Screened, likeliest, screen};
use crate::fit::calibration::{calibrations, in_proportion, is_calibration};
use crate::fit::{
    self, EffectScope, Effort, End, FitProblem, FitState, Fitted, FreeParameter, Residuals, Slopes,
};
use crate::predict::{PredictError, Quantity};
use rayon::prelude::*;
use std::slice;
use trueweld_core::JOINTS;
use trueweld_plant::effects::{Effect, EffectKind, Location, Role};
use trueweld_plant::robot::{Channel, ElasticRobot};

/// Fits the calibrations alone: those logs first whose residuals follow them nearly in proportion,
/// then all.
///
/// # Errors
/// [`PredictError`].
pub fn calibrated(bench: &FitProblem, blocks: &[Vec<u8>]) -> Result<Fitted, PredictError> {
    let point = calibrations(bench);
    let stale = in_proportion(&point);
    fit::fit(bench, &point, blocks, &[], Effort::full(stale))
}

/// The same point with those calibrations that are free at nothing, and the slopes there.
///
/// # Errors
/// [`PredictError`].
pub(crate) fn uncalibrated(
    bench: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
) -> Result<Fitted, PredictError> {
    let mut point = fitted.point.clone();
    point.reset(|effect| is_calibration(effect.kind));
    // Residuals are in proportion to the first of them: their slopes stay.
    let stale = in_proportion(&point);
    fit::fit(bench, &point, blocks, &fitted.slopes[..stale], Effort::steps(0, stale))
}

/// Fits one hypothesis roughly from where screening left it: beside the calibrations at their best
/// without it, which may have moved far to hide it, and beside none.
fn fit_hypothesis(ground: &Context<'_>, screened: &Screened) -> Vec<Fitted> {
    // The same where nothing is free.
    let bases = if ground.null.slopes.is_empty() { 1 } else { 2 };
    [ground.null, ground.given]
        .into_par_iter()
        .zip(&screened.starts)
        .take(bases)
        .filter_map(|(base, (effect, _))| {
            let point = start(ground, base, effect)?;
            let effort = Effort::steps(ROUGHLY, base.slopes.len());
            fit::fit(ground.bench, &point, ground.blocks, &base.slopes, effort).ok()
        })
        .collect()
}

/// Where a fit of an effect beside `base` starts. Slopes at nothing say little of the size of what
/// is not in proportion to it, a gap or a loop: several sizes are judged with the calibrations at
/// their best beside them.
fn start(ground: &Context<'_>, base: &Fitted, effect: &Effect) -> Option<FitState> {
    let mut with = base.point.clone();
    with.all.push(effect.clone());
    let last = with.all.len() - 1;
    let mut at_size = |factor: f64| {
        with.all[last] = scaled(effect, factor);
        fit::residuals_beside(ground.bench, &with, (&base.at, &with.all[last])).ok()
    };
    let mut tried: Vec<(f64, Residuals)> = Vec::new();
    for factor in FACTORS {
        let same = |f: &f64| scaled(effect, *f).values == scaled(effect, factor).values;
        if tried.iter().any(|(f, _)| same(f)) {
            continue;
        }
        tried.extend(at_size(factor).map(|at| (factor, at)));
        if let [(smaller, below), (larger, above)] = tried.as_slice()
            && follows(&base.at, below, above, smaller / larger)
        {
            // In proportion: the best size is the one that its slopes gave.
            break;
        }
    }
    let judged = tried.into_iter().filter_map(|(factor, at)| {
        let linear = base.linear.beside(ground.blocks, &at, &base.slopes);
        let step = linear.solve(None, 0.0, None)?.step;
        Some((linear.cost(&step), factor, step))
    });
    let (_, factor, step) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut point =
        if base.slopes.is_empty() { base.point.clone() } else { base.point.moved(&step) };
    point.add(scaled(effect, factor));
    Some(point)
}

/// True where residuals change from `base` to `below` by so large a `share` of what they change to
/// `above`.
fn follows(base: &Residuals, below: &Residuals, above: &Residuals, share: f64) -> bool {
    let (mut off, mut all) = (0.0, 0.0);
    for ((base, below), above) in base.iter().zip(below).zip(above) {
        for ((r, b), a) in base.residual.iter().zip(&below.residual).zip(&above.residual) {
            off += (b - r - share * (a - r)).powi(2);
            all += (share * (a - r)).powi(2);
        }
    }
    off <= IN_PROPORTION * IN_PROPORTION * all
}

/// Share of a change of residuals to which it is in proportion to a size where no other size needs
/// to be tried.
const IN_PROPORTION: f64 = 0.05;

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
/// best with new slopes.
pub(super) fn fit_all(ground: &Context<'_>, screened: &[&Screened]) -> Vec<Fitted> {
    let in_time = screened.par_iter().filter(|_| !ground.bench.is_late());
    let cheapest = |fits: Vec<Fitted>| fits.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut rough: Vec<Vec<Fitted>> = in_time.map(|s| fit_hypothesis(ground, s)).collect();
    rough.sort_by(|a, b| cost_of(a).total_cmp(&cost_of(b)));
    let mut rough = rough.into_iter();
    // The better of two starts first: the other must promise to come as far.
    let in_full = |mut fits: Vec<Fitted>, goal: f64| {
        fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        fits.into_iter().fold(None, |best: Option<Fitted>, mut fitted| {
            let goal = best.as_ref().map_or(goal, |best| best.cost.min(goal));
            let effort = Effort { goal, ..Effort::full(in_proportion(&fitted.point)) };
            refit(ground.bench, ground.blocks, &mut fitted, effort);
            match best {
                Some(best) if best.cost <= fitted.cost => Some(best),
                _ => Some(fitted),
            }
        })
    };
    let mut fits: Vec<Fitted> = Vec::new();
    fits.extend(rough.next().and_then(|best| in_full(best, f64::INFINITY)));
    let won = fits.first().map_or(0.0, |best| ground.null.cost - best.cost);
    let others = rough.collect::<Vec<_>>().into_par_iter().filter_map(|fits| {
        if cost_of(&fits) <= ground.null.cost - rules::NEARLY * won {
            in_full(fits, ground.null.cost - rules::PROMISED * won)
        } else {
            cheapest(fits)
        }
    });
    fits.extend(others.collect::<Vec<_>>());
    fits.sort_by(|a, b| ground.owed_cost(a).total_cmp(&ground.owed_cost(b)));
    // What such a delay does as well or better is not believed of anything else either.
    let by_delay =
        fits.iter().position(|f| f.point.all.last().is_some_and(|e| held(ground.bench, e)));
    fits.truncate(by_delay.unwrap_or(fits.len()));
    if let Some(best) = fits.first_mut()
        && let Some(last) = best.point.all.len().checked_sub(1)
    {
        polish(ground.bench, ground.blocks, best, last);
    }
    fits
}

/// Cost of the best of some fits.
fn cost_of(fits: &[Fitted]) -> f64 {
    fits.iter().map(|f| f.cost).fold(f64::INFINITY, f64::min)
}

/// Steps of a rough fit.
const ROUGHLY: usize = 3;

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

/// What has a threshold, as a gap has, can hold a fit up: the sizes of one effect are tried a little
/// to either side as well, all else that is free beside them.
pub(super) fn polish(bench: &FitProblem, blocks: &[Vec<u8>], fitted: &mut Fitted, effect: usize) {
    let smooth = !has_play(bench, &fitted.point.all[effect]);
    for _ in 0..ROUNDS {
        if bench.is_late() || (smooth && matches!(fitted.end, End::Arrived | End::Near)) {
            return;
        }
        let aside = ASIDE.par_iter().filter_map(|factor| {
            let mut point = fitted.point.clone();
            point.all[effect] = scaled(&point.all[effect], *factor);
            let effort = Effort::steps(1, fitted.slopes.len());
            fit::fit(bench, &point, blocks, &fitted.slopes, effort).ok()
        });
        let trust = (fit::chi_square(&fitted.at) / fit::count(&fitted.at).max(1) as f64).max(1.0);
        let best = aside.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(better) = best.filter(|b| b.cost < fitted.cost - WORTH * trust) else {
            break;
        };
        *fitted = better;
        refit(bench, blocks, fitted, Effort::full(in_proportion(&fitted.point)));
    }
}

/// True for an effect that leaves links afloat: the cost has steps where one is held or let go.
fn has_play(bench: &FitProblem, effect: &Effect) -> bool {
    let robot = ElasticRobot::with_effects(&bench.model.robot, slice::from_ref(effect), None);
    robot.is_ok_and(|robot| (0..JOINTS).any(|i| robot.play(i) > 0.0))
}

/// Factors on a size by which it is tried aside, how often, and by how much the cost must fall with
/// it, in what chance makes of a residual: three standard deviations.
const ASIDE: [f64; 6] = [0.8, 0.93, 0.98, 1.02, 1.07, 1.25];
const ROUNDS: usize = 4;
const WORTH: f64 = 9.0;

/// Fits on from where a fit stands.
pub(crate) fn refit(bench: &FitProblem, blocks: &[Vec<u8>], fitted: &mut Fitted, effort: Effort) {
    if let Ok(better) = fit::fit(bench, &fitted.point, blocks, &fitted.slopes, effort)
        && better.cost <= fitted.cost * (1.0 + 1e-9)
    {
        *fitted = better;
    }
}

/// The fit without one of its effects, from where it stands; given up where slopes do not promise
/// the cost `goal`.
fn without(ground: &Context<'_>, fitted: &Fitted, index: usize, goal: f64) -> Option<Fitted> {
    let point = fitted.point.without(index);
    let stale = in_proportion(&point);
    let stays = |(free, slopes): (&FreeParameter, &Slopes)| {
        (free.of != EffectScope::All(index)).then(|| slopes.clone())
    };
    let known: Vec<Slopes> =
        fitted.point.free.iter().zip(&fitted.slopes).filter_map(stays).collect();
    let effort = Effort { goal, ..Effort::full(stale) };
    fit::fit(ground.bench, &point, ground.blocks, &known, effort).ok()
}

/// Explanations in which another effect that does nearly the same stands for one of several, where
/// they explain the data about as well: so many for each effect at most.
pub(super) fn alternatives(
    ground: &Context<'_>,
    fitted: &Fitted,
    confusable: &[Confusable],
) -> Vec<Fitted> {
    let trust = rules::trust(fitted);
    let place = |e: &Effect| (e.kind.id, e.at);
    let all = &fitted.point.all;
    let mut found = Vec::new();
    for index in (0..all.len()).filter(|i| !is_calibration(all[*i].kind)) {
        let others = confusable.iter().filter_map(|pair| {
            let is = |(kind, at): (&EffectKind, Location)| (kind.id, at) == place(&all[index]);
            let other = match (is(pair.first), is(pair.second)) {
                (true, _) => pair.second,
                (_, true) => pair.first,
                _ => return None,
            };
            (!all.iter().any(|e| place(e) == (other.0.id, other.1))).then_some(other)
        });
        let others: Vec<_> = others.take(ALTERNATIVES).collect();
        if others.is_empty() || ground.bench.is_late() {
            continue;
        }
        let Some(base) = without(ground, fitted, index, f64::INFINITY) else { continue };
        let beside = Context { null: &base, given: &base, ..*ground };
        let fits = others.into_iter().filter_map(|(kind, at)| {
            let mut fits = fit_hypothesis(&beside, &beside.screen(kind, at)?);
            fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
            let mut best = fits.into_iter().next()?;
            let effort = Effort::full(in_proportion(&base.point));
            refit(ground.bench, ground.blocks, &mut best, effort);
            Some(best)
        });
        found.extend(fits.filter(|f| f.cost - fitted.cost < rules::TIED * trust));
    }
    found
}

/// Other effects that are tried in place of one.
const ALTERNATIVES: usize = 2;

/// Cost without an effect, in what it is with it, from which on it is surely needed.
const NEEDED: f64 = 1.5;

/// Effects of an explanation at most.
const MOST: usize = 4;

/// What comes of a single effect once others were tried beside it.
pub(super) struct Explained {
    /// Fits with one effect more each, the last of them the explanation.
    pub chosen: Vec<Fitted>,
    /// Fits that explain the data about as well as the last, with another effect in place of its last.
    pub alike: Vec<Fitted>,
}

impl Explained {
    /// True where it leaves nothing that stands out of the floor.
    pub fn is_whole(&self, bench: &FitProblem) -> bool {
        self.chosen.last().is_some_and(|f| rules::at_floor(bench, &f.at))
    }
}

/// Tries others beside a single effect, for as long as one more earns its place.
pub(super) fn explained(ground: &Context<'_>, single: Fitted) -> Explained {
    let (mut chosen, mut alike) = (vec![single], Vec::new());
    while chosen.len() < MOST
        && !ground.bench.is_late()
        && let Some(fitted) = chosen.last()
        && let Some((before, after, others)) = one_more(ground, fitted)
    {
        chosen.pop();
        chosen.extend([before, after]);
        alike = others;
    }
    Explained { chosen, alike }
}

/// The fit without one effect more, from where that has taken the others, the fit with it, and those
/// with another in its place that the data do not tell from it. Every effect must earn its place: one
/// that the others do as well without is dropped; of two effects, either of which does what both do,
/// none is. A fit may be at the floor already: how high that lies is known less well than what a
/// second effect brings.
fn one_more(ground: &Context<'_>, fitted: &Fitted) -> Option<(Fitted, Fitted, Vec<Fitted>)> {
    let bench = ground.bench;
    let mut further = further(ground, fitted).into_iter();
    let more = further.next()?;
    let last = more.point.all.len() - 1;
    // What the others gain on the way is not the new one's.
    let mut before = without(ground, &more, last, fitted.cost)?;
    if fitted.cost < before.cost {
        before = fitted.clone();
    }
    // What stands out must fall by half at least: a prediction that is not quite right leaves a little
    // for any effect to mend.
    let enough = standing_out(bench, &more.at) <= rules::HALVED * standing_out(bench, &before.at)
        && fit::chi_square(&before.at) - fit::chi_square(&more.at) > rules::AMPLE;
    if !enough || !counts(bench, &before, &more) {
        return None;
    }
    let own = |i: &usize| !is_calibration(more.point.all[*i].kind);
    let goal = NEEDED * more.cost;
    let spare = |i: usize| without(ground, &more, i, goal).filter(|f| !counts(bench, f, &more));
    match (0..last).filter(own).find_map(spare) {
        None => {
            let beside = Context { null: &before, ..*ground };
            let reach = beside.owed_cost(&more) + rules::TIED * rules::trust(&more);
            let alike = further.filter(|other| beside.owed_cost(other) < reach).collect();
            Some((before, more, alike))
        }
        Some(fewer) if (0..last).filter(own).count() > 1 && fewer.cost < before.cost => {
            Some((before, fewer, Vec::new()))
        }
        Some(_) => None,
    }
}

/// The effects that bring more than chance beside those of a fit, fitted with them, the one that
/// brings the most first.
pub(crate) fn further(ground: &Context<'_>, fitted: &Fitted) -> Vec<Fitted> {
    let Ok(given) = uncalibrated(ground.bench, ground.blocks, fitted) else {
        return Vec::new();
    };
    let beside = Context { null: fitted, given: &given, ..*ground };
    let screened = screen(&beside);
    // A gear has waves of several orders.
    let once = |e: &Effect| e.kind.parameters.iter().all(|p| p.role != Role::Order);
    let has = |s: &Screened| {
        let effect = &s.starts[0].0;
        let same = |e: &Effect| (e.kind.id, e.at) == (effect.kind.id, effect.at);
        once(effect) && fitted.point.all.iter().any(same)
    };
    let others = likeliest(screened.iter().filter(|s| !has(s)), rules::FITTED_BESIDE);
    let mut next = fit_all(&beside, &others);
    // Less than a turn of a wave is none to be named, and a part of the error all the same.
    let open = |f: &Fitted| found_effects(ground.bench, f).iter().any(FittedEffect::has_open_order);
    next.retain(|f| counts(ground.bench, fitted, f) && !open(f));
    next
}
