//! Full fits of the hypotheses that screening leaves, and of pairs of them.

use super::found::{FittedEffect, evaluate_without, found_effects, without};
use super::log_evidence::{RivalEvidence, evidence_in_noise, is_of_library, is_significant};
use super::rules::{self, DECISIVE_FALL, NAMED, noise_excess};
use super::screen::{ScreenedEffect, Screening, SearchContext, likeliest, screen};
use nalgebra::DVector;
use rayon::prelude::*;
use std::slice;
use trueweld_core::JOINTS;
use trueweld_estimate::fit::calibration::{calibrations, in_proportion, is_calibration};
use trueweld_estimate::fit::{
    self, EffectScope, FitProblem, FitState, Fitted, SolverOptions, Termination,
};
use trueweld_estimate::predict::{ComparedQuantity, PredictError};
use trueweld_plant::effects::{Effect, EffectPlace, Location, Role};
use trueweld_plant::robot::{Channel, ElasticRobot};

/// Fits the calibrations alone: those logs first whose residuals follow them nearly in proportion,
/// then all.
///
/// # Errors
/// [`PredictError`].
pub fn fit_calibrations(problem: &FitProblem, blocks: &[Vec<u8>]) -> Result<Fitted, PredictError> {
    let point = calibrations(problem);
    let stale = in_proportion(&point);
    fit::fit(problem, &point, blocks, &[], SolverOptions::full(stale))
}

/// The same point with those calibrations that are free at nothing, with the slopes that the fit has.
///
/// # Errors
/// [`PredictError`].
pub(crate) fn evaluate_uncalibrated(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
) -> Result<Fitted, PredictError> {
    let mut point = fitted.point.clone();
    point.reset(|effect| is_calibration(effect.kind));
    let options = SolverOptions::steps(0, fitted.slopes.len());
    fit::fit_beside(problem, &point, blocks, fitted, options)
}

/// Where a fit starts.
struct FitStart<'a> {
    point: FitState,
    /// What the slopes of `base` promise there.
    cost: f64,
    base: &'a Fitted,
}

/// Where fits of one hypothesis start: beside the calibrations at their best without it, which may
/// have moved far to hide it, and beside none.
fn starts<'a>(ctx: &SearchContext<'a>, screened: &ScreenedEffect) -> Vec<FitStart<'a>> {
    // The same where nothing is free.
    let bases = if ctx.null.slopes.is_empty() { 1 } else { 2 };
    [ctx.null, ctx.given]
        .into_par_iter()
        .zip(&screened.starts)
        .take(bases)
        .filter_map(|(base, promised)| start(ctx, base, promised))
        .collect()
}

/// Fits a hypothesis in so many steps from each start.
fn fit_roughly(
    ctx: &SearchContext<'_>,
    starts: &[FitStart<'_>],
    steps: impl Fn(&FitStart<'_>) -> usize + Sync,
) -> Vec<Fitted> {
    let fit = |start: &FitStart<'_>| {
        let options = SolverOptions::steps(steps(start), start.base.slopes.len());
        fit::fit_beside(ctx.problem, &start.point, ctx.blocks, start.base, options).ok()
    };
    starts.par_iter().filter_map(fit).collect()
}

/// Where a fit of an effect beside `base` starts, of which slopes promise that the cost `falls`.
/// Slopes at nothing say little of the size of what is not in proportion to it, a gap or a loop: several
/// sizes are judged with the calibrations at their best beside them, unless the first keeps the promise.
fn start<'a>(
    ctx: &SearchContext<'a>,
    base: &'a Fitted,
    (effect, falls): &(Effect, f64),
) -> Option<FitStart<'a>> {
    let mut with = base.point.clone();
    with.shared.push(effect.clone());
    let last = with.shared.len() - 1;
    let mut at_size = |effect: &Effect| {
        with.shared[last] = effect.clone();
        let at = fit::residuals_beside(ctx.problem, &with, (&base.residuals, effect)).ok()?;
        let linear = base.beside(ctx.blocks, &at);
        let step = linear.solve(None, 0.0, None)?.step;
        Some((linear.cost(&step), step))
    };
    let mut tried: Vec<Effect> = Vec::new();
    let mut best: Option<(f64, Effect, DVector<f64>)> = None;
    let mut worse = 0;
    for factor in START_SIZE_FACTORS {
        let sized = scaled(effect, factor);
        if tried.iter().any(|known| known.values == sized.values) {
            continue;
        }
        if let Some((cost, step)) = at_size(&sized) {
            worse += 1;
            if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
                (best, worse) = (Some((cost, sized.clone(), step)), 0);
            }
            let short = base.cost - cost - falls;
            if tried.is_empty() && short.abs() <= IN_PROPORTION * falls {
                break;
            }
        }
        tried.push(sized);
        if worse == START_SIZES_WORSE {
            break;
        }
    }
    let (cost, sized, step) = best?;
    let mut point =
        if base.slopes.is_empty() { base.point.clone() } else { base.point.moved(&step) };
    point.add(sized);
    Some(FitStart { point, cost, base })
}

/// Share of the fall that slopes promise by which another is as promised: residuals are in proportion to
/// the size.
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
const START_SIZE_FACTORS: [f64; 6] = [1.0, 0.4, 2.5, 6.0, 15.0, 40.0];

/// Sizes in a row that are worse than one before them, after which no other one is tried.
const START_SIZES_WORSE: usize = 2;

/// Fits hypotheses, best first: roughly those whose start promises a part of what the best one's
/// does, in full those that come near the best, the best with new slopes; none in full that says less than
/// its name costs.
pub(super) fn fit_all(ctx: &SearchContext<'_>, screened: &[&ScreenedEffect]) -> Vec<Fitted> {
    let in_time = screened.par_iter().filter(|_| !ctx.problem.is_late());
    let all: Vec<Vec<FitStart<'_>>> = in_time.map(|s| starts(ctx, s)).collect();
    let promised = all.iter().flatten().map(|start| start.cost).fold(f64::INFINITY, f64::min);
    let enough = ctx.null.cost - rules::WORTH_STEPS_GAIN * (ctx.null.cost - promised);
    let steps = |start: &FitStart<'_>| if start.cost <= enough { ROUGHLY } else { 0 };
    let mut rough: Vec<Vec<Fitted>> =
        all.par_iter().map(|starts| fit_roughly(ctx, starts, steps)).collect();
    rough.sort_by(|a, b| cost_of(a).total_cmp(&cost_of(b)));
    let mut rough = rough.into_iter();
    let mut fits: Vec<Fitted> = Vec::new();
    // What has more values than the calibrations cannot fit worse: one that does has not arrived.
    let arrived = |fits: &[Fitted]| cost_of(fits) <= ctx.null.cost;
    let Some(first) = rough.as_slice().first().and_then(|fits| least(fits)) else {
        return Vec::new();
    };
    let evidence = RivalEvidence::over(ctx.problem, ctx.null, &first.residuals);
    let pays = |fitted: &Fitted| evidence.of(fitted) > 0.0;
    let may_count = |fits: &[Fitted]| !arrived(fits) || least(fits).is_some_and(pays);
    fits.extend(rough.next().and_then(|best| match may_count(&best) {
        true => fit_in_full(ctx, best, f64::INFINITY),
        false => least(&best).cloned(),
    }));
    let won = fits.first().map_or(0.0, |best| ctx.null.cost - best.cost);
    let near = |fits: &[Fitted]| cost_of(fits) <= ctx.null.cost - rules::NEAR_BEST_GAIN * won;
    let goal = ctx.null.cost - rules::PROMISED_WIN_SHARE * won;
    let others = rough.collect::<Vec<_>>().into_par_iter().filter_map(|fits| {
        match may_count(&fits) && (near(&fits) || !arrived(&fits)) {
            true => fit_in_full(ctx, fits, goal),
            false => least(&fits).cloned(),
        }
    });
    fits.extend(others.collect::<Vec<_>>());
    let best = least(&fits).filter(|best| is_significant(ctx.problem, ctx.null, best));
    for rival in best.map_or(Vec::new(), |best| rivals(ctx, best, &fits)) {
        match fits.iter_mut().find(|known| last_effect(known) == last_effect(&rival)) {
            Some(known) if known.cost <= rival.cost => {}
            Some(known) => *known = rival,
            None => fits.push(rival),
        }
    }
    fits.retain(|fitted| arrived(slice::from_ref(fitted)));
    let mut fits = by_evidence(ctx, fits);
    // What such a delay does as well or better is not believed of anything else either.
    let by_delay = fits
        .iter()
        .position(|f| f.point.shared.last().is_some_and(|e| is_command_hold(ctx.problem, e)));
    fits.truncate(by_delay.unwrap_or(fits.len()));
    if let Some(best) = fits.first_mut().filter(|best| pays(best))
        && let Some(last) = best.point.shared.len().checked_sub(1)
    {
        refit_scaled(ctx.problem, ctx.blocks, best, last);
    }
    fits
}

/// The last effect of a fit.
pub(super) fn last_effect(fitted: &Fitted) -> Option<EffectPlace> {
    fitted.point.shared.last().map(Effect::place)
}

/// Other effects in place of the last one of a fit, but for those whose fits arrived. Where calibrations
/// hide much of an effect, its slopes beside them at their best without it say little of what it would
/// come to: one that was given up for them is not disproved.
fn rivals(ctx: &SearchContext<'_>, best: &Fitted, fits: &[Fitted]) -> Vec<Fitted> {
    let Some(last) = best.point.shared.len().checked_sub(1) else { return Vec::new() };
    let arrived = fits.iter().filter(|f| f.termination.is_arrival());
    let arrived: Vec<EffectPlace> = arrived.filter_map(last_effect).collect();
    let goal = ctx.null.cost - rules::PROMISED_WIN_SHARE * (ctx.null.cost - best.cost);
    in_place_of(ctx, best, last, (&arrived, goal))
}

/// Explanations in which another effect stands for one of several, where they explain the data about
/// as well or better.
pub(super) fn alternatives(ctx: &SearchContext<'_>, fitted: &Fitted) -> Vec<Fitted> {
    let reach = fitted.cost + DECISIVE_FALL * rules::variance_inflation(fitted);
    let all = &fitted.point.shared;
    let own = (0..all.len()).filter(|index| !is_calibration(all[*index].kind));
    let others = own.flat_map(|index| in_place_of(ctx, fitted, index, (&[], reach)));
    others.filter(|other| other.cost < reach).collect()
}

/// Other effects in place of one of a fit, from where it stands, but for some; in full those that
/// promise the cost `goal`.
fn in_place_of(
    ctx: &SearchContext<'_>,
    fitted: &Fitted,
    index: usize,
    (but_for, goal): (&[EffectPlace], f64),
) -> Vec<Fitted> {
    let Some(base) = evaluate_without(ctx.problem, ctx.blocks, fitted, index) else {
        return Vec::new();
    };
    let beside = SearchContext { null: &base, given: &base, ..*ctx };
    let Some(screening) = Screening::of(&beside) else { return Vec::new() };
    let screened: Vec<ScreenedEffect> =
        ctx.screened.par_iter().filter_map(|s| screening.weighed_again(s)).collect();
    let is_open = |s: &&ScreenedEffect| {
        let own = s.limit.effect;
        !but_for.contains(&own) && fitted.point.shared.iter().all(|e| e.place() != own)
    };
    let others = likeliest(screened.iter().filter(is_open), rules::FITTED_BESIDE);
    let fit = |rival: &&ScreenedEffect| {
        let start = start(&beside, &base, &rival.starts[0])?;
        // It must promise something at least over what there is without any. What it comes to shows
        // once a step has brought it where its slopes are right.
        let promises = start.cost < ctx.null.cost;
        promises.then(|| fit_in_full(&beside, fit_roughly(&beside, &[start], |_| 1), goal))?
    };
    others.par_iter().filter(|_| !ctx.problem.is_late()).filter_map(fit).collect()
}

/// Fits with the most evidence beside the calibrations first.
pub(super) fn by_evidence(ctx: &SearchContext<'_>, fits: Vec<Fitted>) -> Vec<Fitted> {
    let evidence = evidence_of_each(ctx, &fits);
    let mut all: Vec<(f64, Fitted)> = evidence.into_iter().zip(fits).collect();
    all.sort_by(|a, b| b.0.total_cmp(&a.0));
    all.into_iter().map(|(_, fitted)| fitted).collect()
}

/// Evidence of fits beside the calibrations, by the noise of what the cheapest leaves.
pub(super) fn evidence_of_each(ctx: &SearchContext<'_>, fits: &[Fitted]) -> Vec<f64> {
    let Some(cheapest) = least(fits) else { return Vec::new() };
    let evidence = RivalEvidence::over(ctx.problem, ctx.null, &cheapest.residuals);
    fits.par_iter().map(|fitted| evidence.of(fitted)).collect()
}

/// The best of the fits of a hypothesis from several starts, each in full as long as it promises to
/// come to the cost `goal`, and as it is not where the better one arrived, to within what noise hides.
fn fit_in_full(ctx: &SearchContext<'_>, mut fits: Vec<Fitted>, goal: f64) -> Option<Fitted> {
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let mut best: Option<Fitted> = None;
    for mut fitted in fits {
        let goal = best.as_ref().map_or(goal, |best| best.cost.min(goal));
        let arrives_there = |best: &Fitted| {
            best.termination.is_arrival() && best.promised_at(&fitted.point) < best.cost + 1.0
        };
        if best.as_ref().is_some_and(arrives_there) {
            continue;
        }
        // New slopes of its own tell at a few values' cost that it will not come as far.
        let others = SolverOptions { goal, ..SolverOptions::steps(ROUGHLY, calibrated(&fitted)) };
        if goal.is_finite() {
            fitted = fit::resume(ctx.problem, &fitted, ctx.blocks, others);
        }
        if fitted.termination != Termination::Unpromising {
            let full = SolverOptions::full(in_proportion(&fitted.point));
            let options = SolverOptions { goal, ..full };
            fitted = fit::resume(ctx.problem, &fitted, ctx.blocks, options);
        }
        best = match best {
            Some(best) if best.cost <= fitted.cost => Some(best),
            _ => Some(fitted),
        };
    }
    best
}

/// Free values of a fit that come before those of its last effect.
fn calibrated(fitted: &Fitted) -> usize {
    let last = EffectScope::Shared(fitted.point.shared.len().saturating_sub(1));
    fitted.point.free.iter().take_while(|free| free.of != last).count()
}

/// The one of some fits that costs least.
fn least(fits: &[Fitted]) -> Option<&Fitted> {
    fits.iter().min_by(|a, b| a.cost.total_cmp(&b.cost))
}

/// Cost of the best of some fits.
fn cost_of(fits: &[Fitted]) -> f64 {
    least(fits).map_or(f64::INFINITY, |best| best.cost)
}

/// Steps of a rough fit.
const ROUGHLY: usize = 3;

/// True for a delay of motor torque that is no longer than a controller holds its commands.
fn is_command_hold(problem: &FitProblem, effect: &Effect) -> bool {
    if effect.at != Location::Channel(Channel::MotorTorque) {
        return false;
    }
    let seen = problem
        .logs
        .iter()
        .filter(|e| e.compared.iter().any(|c| c.quantity == ComparedQuantity::MotorTorque));
    let period = seen.map(|e| e.period).fold(f64::INFINITY, f64::min);
    period.is_finite() && effect.values[0].abs() < rules::COMMAND_HOLD_SHARE * period
}

/// What has a threshold, as a gap has, can hold a fit up: the sizes of one effect are tried a little
/// to either side as well, all else that is free beside them.
pub(super) fn refit_scaled(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &mut Fitted,
    effect: usize,
) {
    let smooth = !has_play(problem, &fitted.point.shared[effect]);
    for _ in 0..SCALED_FIT_ROUNDS {
        if problem.is_late() || (smooth && fitted.termination.is_arrival()) {
            return;
        }
        let aside = SCALED_FIT_FACTORS.par_iter().filter_map(|factor| {
            let mut point = fitted.point.clone();
            point.shared[effect] = scaled(&point.shared[effect], *factor);
            let options = SolverOptions::steps(1, fitted.slopes.len());
            fit::fit_beside(problem, &point, blocks, fitted, options).ok()
        });
        let inflation = (fit::chi_square(&fitted.residuals)
            / fit::count(&fitted.residuals).max(1) as f64)
            .max(1.0);
        let best = aside.min_by(|a, b| a.cost.total_cmp(&b.cost));
        let Some(better) = best.filter(|b| b.cost < fitted.cost - DECISIVE_FALL * inflation) else {
            break;
        };
        let options = SolverOptions::full(in_proportion(&better.point));
        *fitted = fit::resume(problem, &better, blocks, options);
    }
}

/// True for an effect that leaves links free in their backlash: the cost has steps where one is
/// held or let go.
fn has_play(problem: &FitProblem, effect: &Effect) -> bool {
    let robot = ElasticRobot::with_effects(&problem.model.robot, slice::from_ref(effect), None);
    robot.is_ok_and(|robot| (0..JOINTS).any(|i| robot.play(i) > 0.0))
}

/// Factors on a size by which it is tried aside, and how often.
const SCALED_FIT_FACTORS: [f64; 6] = [0.8, 0.93, 0.98, 1.02, 1.07, 1.25];
const SCALED_FIT_ROUNDS: usize = 4;

/// The fit without some of its effects, from where it stands; given up where slopes do not promise
/// the cost `goal`.
pub(super) fn fit_without(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
    (effects, goal): (&[usize], f64),
) -> Option<Fitted> {
    let (point, known) = without(fitted, effects);
    let options = SolverOptions { goal, ..SolverOptions::full(in_proportion(&point)) };
    fit::fit(problem, &point, blocks, &known, options).ok()
}

/// Cost without an effect, in what it is with it, from which on it is surely needed.
const NEEDED: f64 = 1.5;

/// Effects of an explanation at most.
const EXPLANATION_EFFECTS_MAX: usize = 4;

/// What comes of a single effect once others were tried beside it.
pub(super) struct Explained {
    /// Fits with one effect more each, the last of them the explanation.
    pub chosen: Vec<Fitted>,
    /// For each of them those that explain the data about as well, with another effect in place of its
    /// last.
    pub alike: Vec<Vec<Fitted>>,
}

impl Explained {
    /// True where it leaves nothing that stands out of the floor.
    pub(crate) fn is_whole(&self, problem: &FitProblem) -> bool {
        self.chosen.last().is_some_and(|f| rules::within_noise(problem, &f.residuals))
    }
}

/// What slopes promise that the best of the effects beside those of a fit would bring it to cost.
pub(super) fn promised_beside(ctx: &SearchContext<'_>, fitted: &Fitted) -> f64 {
    let beside = SearchContext { null: fitted, given: fitted, ..*ctx };
    let Some(screening) = Screening::of(&beside) else { return f64::INFINITY };
    let falls = ctx.screened.par_iter().filter_map(|s| screening.weighed_again(s));
    let fall = falls.map(|s| s.starts[0].1).reduce(|| 0.0, f64::max);
    ctx.penalized_cost(fitted) - fall
}

/// Tries others beside a single effect, for as long as one more earns its place.
pub(super) fn add_effects(ctx: &SearchContext<'_>, single: Fitted) -> Explained {
    let (mut chosen, mut alike) = (vec![single], vec![Vec::new()]);
    while chosen.len() < EXPLANATION_EFFECTS_MAX
        && !ctx.problem.is_late()
        && let Some(fitted) = chosen.last()
        && let Some((better, others)) = add_effect(ctx, fitted)
    {
        chosen.pop();
        chosen.extend(better);
        alike.resize_with(chosen.len() - 1, Vec::new);
        alike.push(others);
    }
    Explained { chosen, alike }
}

/// The fit without one effect more, from where that has taken the others, the fit with it, and those
/// with another in its place that the data do not tell from it. Every effect must earn its place: one
/// that the others do as well without is dropped; a single one that the new one does without, and
/// better, leaves its place to it; of two, either of which does what both do, none is added. A fit
/// may be at the floor already: how high that lies is known less well than what a second effect
/// brings. One that would not be named for its faintness is none to be added.
fn add_effect(ctx: &SearchContext<'_>, fitted: &Fitted) -> Option<(Vec<Fitted>, Vec<Fitted>)> {
    let problem = ctx.problem;
    let counts = |more: &Fitted| is_significant(problem, fitted, more);
    let mut further = add_each_effect(ctx, fitted).into_iter().filter(counts);
    let more = further.next()?;
    let last = more.point.shared.len() - 1;
    // What the others gain on the way is not the new one's.
    let refitted_without =
        |effect: usize, goal: f64| fit_without(problem, ctx.blocks, &more, (&[effect], goal));
    let mut before = refitted_without(last, fitted.cost)?;
    if fitted.cost < before.cost {
        before = fitted.clone();
    }
    // What stands out must fall by half at least: a prediction that is not quite right leaves a little
    // for any effect to mend.
    let enough = noise_excess(problem, &more.residuals)
        <= rules::HALVED * noise_excess(problem, &before.residuals);
    if !enough || is_of_library(evidence_in_noise(problem, &before, &more)) < NAMED {
        return None;
    }
    let own = |i: &usize| !is_calibration(more.point.shared[*i].kind);
    let goal = NEEDED * more.cost;
    let spare = |i: usize| refitted_without(i, goal).filter(|f| !is_significant(problem, f, &more));
    match (0..last).filter(own).find_map(spare) {
        None => {
            let beside = SearchContext { null: &before, ..*ctx };
            let reach =
                beside.penalized_cost(&more) + DECISIVE_FALL * rules::variance_inflation(&more);
            let alike = further.filter(|other| beside.penalized_cost(other) < reach).collect();
            Some((vec![before, more], alike))
        }
        Some(fewer) if (0..last).filter(own).count() > 1 => {
            (fewer.cost < before.cost).then(|| (vec![before, fewer], Vec::new()))
        }
        Some(other) => {
            let less = fitted.cost - DECISIVE_FALL * rules::variance_inflation(&other);
            (other.cost < less).then(|| (vec![other], Vec::new()))
        }
    }
}

/// The effects that lower the cost beside those of a fit, fitted with them, the one that lowers it
/// most first.
pub(crate) fn add_each_effect(ctx: &SearchContext<'_>, fitted: &Fitted) -> Vec<Fitted> {
    let Ok(given) = evaluate_uncalibrated(ctx.problem, ctx.blocks, fitted) else {
        return Vec::new();
    };
    let beside = SearchContext { null: fitted, given: &given, ..*ctx };
    let screened = screen(&beside);
    // A gear has waves of several orders.
    let once = |e: &Effect| e.kind.parameters.iter().all(|p| p.role != Role::Order);
    let has = |s: &ScreenedEffect| {
        let effect = &s.starts[0].0;
        let same = |e: &Effect| e.place() == effect.place();
        once(effect) && fitted.point.shared.iter().any(same)
    };
    let others = likeliest(screened.iter().filter(|s| !has(s)), rules::FITTED_BESIDE);
    let mut next = fit_all(&beside, &others);
    // Less than a turn of a wave is none to be named, and a part of the error all the same.
    let open = |f: &Fitted| found_effects(ctx.problem, f).iter().any(FittedEffect::has_open_order);
    next.retain(|f| f.cost < fitted.cost && !open(f));
    next
}
