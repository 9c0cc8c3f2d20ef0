//! Which physical effect is missing: every effect of the library, at every place, as a hypothesis.
//!
//! 1. The logs are fitted with calibrations alone ([`crate::fit::calibration`]).
//! 2. Every hypothesis is screened: its slopes at that point, with all calibrations free beside it,
//!    say by how much the sum of squares would fall, how small an effect would have been seen, and
//!    which hypotheses these data cannot tell apart.
//! 3. The best are fitted in full, calibrations with them, and judged by blocks in time that were
//!    left out; then pairs.
//! 4. What remains above the floor says whether the library explains the data at all.

mod beyond;
mod confuse;
pub mod evidence;
mod found;
mod gate;
mod mountings;
pub mod rules;
mod same_calibration;
mod screen;
mod search;
mod sparse;
mod tell;

pub use confuse::Confusable;
pub use found::FittedEffect;
pub(crate) use found::{found, found_beside, found_by_what_is_left, inflate_noise};
pub use mountings::{Combination, Mountings};
pub use rules::{Part, held_out_score, parts, score};
pub(crate) use screen::Context;
pub use screen::Limit;
pub use search::calibrated;
pub(crate) use search::{further, refit};
pub(crate) use sparse::sparse;
pub use tell::{Explanation, ImprovedChannel, Reason, reason_of_best, tell};

use crate::data::log::{Log, LogKind};
use crate::fit::calibration::is_calibration;
use crate::fit::{self, End, FitProblem, FitState, Fitted, Residuals};
use crate::predict::{Experiment, PredictError};
use crate::residuals::localize::{Finding, localize};
use beyond::beyond_expected;
use found::{effects_of, found_effects, has_unseen_wave};
pub(crate) use gate::{HeldOutGain, may_be_named};
use rules::{above, at_floor, counts, floor, stands_out};
use screen::{Screened, likeliest, screen};
use search::{Explained, fit_all, uncalibrated};
use trueweld_plant::effects::{CalibrationScope, Effect, EffectKind, Location, Role};
use trueweld_plant::robot::Channel;
use trueweld_plant::simulate::Seam;

/// Longest weld among the logs, m, for what is looked for along it.
pub(crate) fn longest_weld(logs: &[Log]) -> f64 {
    let length = |log: &Log| log.weld.as_ref().map(|weld| Seam::of(weld).length);
    logs.iter()
        .filter(|l| l.kind == LogKind::Weld)
        .filter_map(length)
        .reduce(f64::max)
        .unwrap_or(0.5)
}

/// What the data say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is missing above the floor.
    Adequate,
    /// An effect of the library, or two, explain what was missing.
    EffectFound,
    /// Something is missing that none of the library's effects explains.
    UnknownEffect,
}

impl Verdict {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::EffectFound => "effect-found",
            Self::UnknownEffect => "unknown-effect",
        }
    }
}

/// One explanation: an effect, or two that act together.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Its effects.
    pub effects: Vec<FittedEffect>,
    /// Score on held-out blocks of the model as it was given.
    pub held_out_before: f64,
    /// Score on held-out blocks with the effects, calibrations refitted.
    pub held_out_after: f64,
    /// How likely this explanation is, given the data and the library.
    pub probability: f64,
    /// Share of what was above the floor that is still there.
    pub left: f64,
    /// True where it may be named: the logs tell its values from no effect, and it predicts rows
    /// that were left out better than calibrations alone by more than chance.
    pub may_be_named: bool,
    /// Other explanations that these data do not tell from this one, by index.
    pub indistinguishable: Vec<usize>,
    /// The fit.
    pub fitted: Fitted,
}

/// What a diagnosis found.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// What the data say.
    pub verdict: Verdict,
    /// Score of the model as it was given.
    pub score_before: f64,
    /// Score on held-out blocks with calibrations alone.
    pub held_out_calibrated: f64,
    /// Residuals of the model as it was given.
    pub before: Residuals,
    /// What each log has of its own under the model as it was given.
    pub each_log: FitState,
    /// The fit of calibrations alone.
    pub null: Fitted,
    /// Fits of the explanation: one effect, then two; none where none may be named.
    pub chosen: Vec<Fitted>,
    /// Explanations, best first.
    pub candidates: Vec<Candidate>,
    /// What is a little off in the cell besides.
    pub calibration: Vec<FittedEffect>,
    /// What the logs fix of how links are mounted; `None` where they see no postures.
    pub mountings: Option<Mountings>,
    /// The model with the best explanation and every calibration free.
    pub full: Fitted,
    /// The same with those calibrations alone that count.
    pub improved: Fitted,
    /// Smallest size of each effect that these data would have shown.
    pub limits: Vec<Limit>,
    /// Hypotheses that these data cannot tell apart, most alike first.
    pub confusable: Vec<Confusable>,
    /// What the residual of the improved model still goes with, where it is above the floor.
    pub unexplained: Vec<Finding>,
    /// What there was no time for, and fits that did not arrive.
    pub undone: Vec<Undone>,
}

/// What a diagnosis leaves undone.
#[derive(Debug, Clone)]
pub enum Undone {
    /// Not every effect was looked for.
    Search,
    /// So many of the likeliest effects were not fitted.
    Fits(usize),
    /// No further effect was looked for beside those found.
    Further,
    /// Nothing was looked for outside the library.
    Outside,
    /// A fit took all the steps that it may: of these effects, beside calibrations.
    Arrival(Vec<Effect>),
}

/// What a diagnosis is at, for whoever waits.
pub type Progress<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// Finds out which effect is missing. `logs`: those that the bench's experiments were made of.
///
/// # Errors
/// [`PredictError`] where the model as given cannot be driven through the logs.
pub fn diagnose(
    bench: &FitProblem,
    logs: &[Log],
    progress: Progress<'_>,
) -> Result<Diagnosis, PredictError> {
    let blocks = fit::blocks_of(bench);
    progress("comparing", 0.0);
    let (each_log, before) = fit::per_log::fitted(bench, &bench.per_log, Vec::new())?;
    progress("calibrating", 0.02);
    let length = longest_weld(logs);
    let look = |null: Fitted| look(bench, &blocks, length, null, progress);
    let mut looked = look(calibrated(bench, &blocks)?)?;
    let held = looked.null.cost;
    if let Some(null) = beyond_expected(bench, &blocks, &looked.null, looked.singles.first()) {
        looked = look(null)?;
    }
    let Looked { null, given, screened, mut singles, mut undone } = looked;
    let ground = Context { bench, blocks: &blocks, null: &null, given: &given, length };
    let limits = screened.iter().map(|s| s.limit.clone()).collect();
    let confusable = confuse::confusable(&ground, &screened);
    let (mut chosen, mut alike) = (Vec::new(), Vec::new());
    if let Some(k) = best_that_counts(&ground, &singles) {
        singles[..=k].rotate_right(1);
        progress("looking for more effects", 0.65);
        let mut explained = search::explained(&ground, singles[0].clone());
        if !explained.is_whole(bench)
            && let Some((k, others)) = from_another(&ground, &singles)
        {
            singles[..=k].rotate_right(1);
            explained = others;
        }
        if bench.is_late() && !explained.is_whole(bench) {
            undone.push(Undone::Further);
        }
        (chosen, alike) = (explained.chosen, explained.alike);
        singles[0] = chosen[0].clone();
        while let Some(last) = chosen.last() {
            let before = chosen.len().checked_sub(2).map_or(ground.null, |k| &chosen[k]);
            if is_nameable(&ground, before, last) {
                break;
            }
            chosen.pop();
            alike.clear();
        }
    }
    if let Some(last) = chosen.last().filter(|_| chosen.len() > 1) {
        let mut together = vec![last.clone()];
        together.append(&mut alike);
        for other in search::alternatives(&ground, last, &confusable) {
            if !together.iter().any(|known| same_effects(known, &other)) {
                together.push(other);
            }
        }
        singles.splice(0..0, together);
    }
    // Calibrations that an effect is missing beside need not arrive anywhere.
    let answer = if chosen.is_empty() { std::slice::from_ref(&null) } else { chosen.as_slice() };
    let did_not = |f: &&Fitted| f.end == End::Limit && !bench.is_late();
    undone.extend(answer.iter().filter(did_not).map(|f| {
        Undone::Arrival(effects_of(f).into_iter().map(|i| f.point.all[i].clone()).collect())
    }));
    progress("weighing the evidence", 0.92);
    let unexplained = |at: &Residuals| localize(&bench.experiments, at, logs);
    let told = |chosen: &[Fitted]| {
        conclude(&ground, (&before, held), &singles, chosen, screened.len(), &unexplained)
    };
    let (mut diagnosis, stands) = told(&chosen);
    if !stands {
        diagnosis = told(&[]).0;
    }
    Ok(Diagnosis { each_log, limits, confusable, undone, ..diagnosis })
}

/// What was looked for beside the calibrations of one fit.
struct Looked {
    null: Fitted,
    /// The same with no calibrations.
    given: Fitted,
    screened: Vec<Screened>,
    /// Every effect that was fitted, best first.
    singles: Vec<Fitted>,
    undone: Vec<Undone>,
}

fn look(
    bench: &FitProblem,
    blocks: &[Vec<u8>],
    length: f64,
    null: Fitted,
    progress: Progress<'_>,
) -> Result<Looked, PredictError> {
    progress("screening every effect", 0.11);
    let given = if bench.is_late() { null.clone() } else { uncalibrated(bench, blocks, &null)? };
    let ground = Context { bench, blocks, null: &null, given: &given, length };
    let screened = screen(&ground);
    let mut undone = Vec::new();
    if bench.is_late() {
        undone.push(Undone::Search);
    }
    progress("fitting the likeliest", 0.45);
    let wanted = likeliest(screened.iter(), rules::FITTED);
    let singles = fit_all(&ground, &wanted);
    if bench.is_late() && singles.len() < wanted.len() {
        undone.push(Undone::Fits(wanted.len() - singles.len()));
    }
    Ok(Looked { null, given, screened, singles, undone })
}

/// The best of some effects that counts and may be named; of those that the data do not tell from
/// it, one that is no piece of a wave, which bends to almost anything.
fn best_that_counts(ground: &Context<'_>, singles: &[Fitted]) -> Option<usize> {
    let count = |k: &usize| {
        counts(ground.bench, ground.null, &singles[*k])
            && is_nameable(ground, ground.null, &singles[*k])
    };
    let cost = |k: usize| ground.owed_cost(&singles[k]);
    let best = (0..singles.len()).find(count)?;
    let reach = cost(best) + rules::TIED * rules::trust(&singles[best]);
    let mut tied = (best..singles.len()).take_while(|k| cost(*k) <= reach);
    Some(tied.find(|k| !has_unseen_wave(ground.bench, &singles[*k]) && count(k)).unwrap_or(best))
}

/// True for a fit whose effects may be named beside what `before` has.
fn is_nameable(ground: &Context<'_>, before: &Fitted, fitted: &Fitted) -> bool {
    let effects = found_effects(ground.bench, fitted);
    may_be_named(ground.bench, ground.blocks, (before, fitted), &effects)
}

/// True for two fits of the same effects at the same places.
fn same_effects(a: &Fitted, b: &Fitted) -> bool {
    let names = |fitted: &Fitted| {
        let own = effects_of(fitted).into_iter().map(|i| &fitted.point.all[i]);
        own.map(|e| (e.kind.id, e.at)).collect::<Vec<_>>()
    };
    let (a, b) = (names(a), names(b));
    a.len() == b.len() && a.iter().all(|name| b.contains(name))
}

/// An explanation that starts from another single effect than the first and leaves nothing, with the
/// place of that effect. Of two that are missing each may do less alone than a third that does a part
/// of both.
fn from_another(ground: &Context<'_>, singles: &[Fitted]) -> Option<(usize, Explained)> {
    let starts = |k: &usize| {
        counts(ground.bench, ground.null, &singles[*k])
            && !has_unseen_wave(ground.bench, &singles[*k])
    };
    (1..singles.len()).filter(starts).take(rules::STARTS - 1).find_map(|k| {
        let others = search::explained(ground, singles[k].clone());
        others.is_whole(ground.bench).then_some((k, others))
    })
}

/// True for an explanation that bends to almost anything: whatever fits as well is as likely, and far
/// more often it is one thing which the library does not have.
pub(crate) fn fits_anything(bench: &FitProblem, fitted: &Fitted) -> bool {
    at_one_joint(fitted) || has_unseen_wave(bench, fitted)
}

/// True for two effects at the same joint, but for waves of several orders.
fn at_one_joint(fitted: &Fitted) -> bool {
    let effects: Vec<&Effect> =
        effects_of(fitted).into_iter().map(|i| &fitted.point.all[i]).collect();
    let waves = |a: &Effect, b: &Effect| {
        a.kind.id == b.kind.id && a.kind.parameters.iter().any(|p| p.role == Role::Order)
    };
    let alike =
        |a: &Effect, b: &Effect| matches!(a.at, Location::Joint(_)) && a.at == b.at && !waves(a, b);
    (1..effects.len()).any(|k| effects[..k].iter().any(|other| alike(other, effects[k])))
}

/// What is to say where calibrations alone lead to `null` and the explanation is `chosen`.
fn verdict(bench: &FitProblem, null: &Fitted, chosen: &[Fitted]) -> Verdict {
    let Some(best) = chosen.last() else {
        return if at_floor(bench, &null.at) { Verdict::Adequate } else { Verdict::UnknownEffect };
    };
    let left = above(bench, &best.at) / above(bench, &null.at).max(1.0);
    let score = (fit::chi_square(&best.at) / floor(bench).max(1.0)).sqrt();
    let (near, most) = (score < rules::NEAR, left < rules::LEFT_NEAR);
    // Two effects together bend to much that neither is: they must come near.
    let partly = score < rules::TOO_FAR && left < rules::LEFT && chosen.len() < 2;
    let explained = partly || (near && most) || (at_floor(bench, &best.at) && (near || most));
    // What lowers everything a little and leaves what stands out is not what stands there.
    let [out, left_out] = [null, best].map(|fitted| rules::standing_out(bench, &fitted.at));
    if explained && left_out <= rules::HALVED * out && !fits_anything(bench, best) {
        Verdict::EffectFound
    } else {
        Verdict::UnknownEffect
    }
}

/// What is to say with an explanation, and whether that stands: false where the model as it was given
/// predicts as well, or where "none of these" is not much less likely and nothing stands out of the
/// floor. `before`: residuals of the model as it was given; `held`: the cost of calibrations alone,
/// each as large as is expected of it.
fn conclude(
    ground: &Context<'_>,
    (before, held): (&Residuals, f64),
    singles: &[Fitted],
    chosen: &[Fitted],
    tried: usize,
    unexplained: &dyn Fn(&Residuals) -> Vec<Finding>,
) -> (Diagnosis, bool) {
    let Context { bench, blocks, null, .. } = *ground;
    let score_before = score(before);
    let excess = above(bench, &null.at).max(1.0);
    let best = chosen.last().unwrap_or(null);
    let mut verdict = verdict(bench, null, chosen);
    let (improved, kept) = improved_by(bench, blocks, best);
    let better = predicts_better(ground, before, &improved);
    let mut stands = better;
    let kept: Vec<_> = kept.into_iter().filter(|name| !is_of_registration(bench, name.0)).collect();
    // By what is left out, and by what no model explains, whichever says less of them.
    let mut calibration = found_beside(bench, &improved, best, |_| true);
    for (found, weighed) in
        calibration.iter_mut().zip(found_by_what_is_left(bench, blocks, &improved))
    {
        for (own, other) in found.interval.iter_mut().zip(weighed.interval) {
            *own = [own[0].min(other[0]), own[1].max(other[1])];
        }
    }
    calibration.retain(|found| is_calibration(found.effect.kind));

    let mut candidates: Vec<Candidate> = singles
        .iter()
        .map(|fitted| Candidate {
            effects: found_effects(bench, fitted),
            held_out_before: score_before,
            held_out_after: held_out_score(fitted),
            probability: 0.0,
            left: above(bench, &fitted.at) / excess,
            may_be_named: is_nameable(ground, null, fitted),
            indistinguishable: Vec::new(),
            fitted: fitted.clone(),
        })
        .collect();
    candidates.sort_by_key(|candidate| !candidate.may_be_named);
    // What it costs to say nothing: with calibrations as they are, or, where a calibration is the
    // answer, with none.
    let mut nothing = null.cost;
    // A single calibration that is all there is to say is the answer, or the one that is no
    // calibration any more. Where each log has its own it is the laboratory's doing, not the cell's.
    let beyond: Vec<&FittedEffect> = calibration.iter().filter(|f| f.is_implausible()).collect();
    let answer = match (kept.as_slice(), beyond.as_slice()) {
        ([only], _) => {
            let given = fit::chi_square(before);
            Some((*only, without_calibration(null, *only).map_or(given, |cost| cost.min(given))))
        }
        (_, [only]) => Some(((only.effect.kind.id, only.effect.at), held)),
        _ => None,
    };
    if let Some((name, without)) = answer
        && verdict == Verdict::Adequate
        && !improved.point.each.iter().flatten().any(|e| (e.kind.id, e.at) == name)
        && !bench.per_log.iter().any(|own| (own.stated.kind.id, own.stated.at) == name)
        && better
        && stands_out(bench, before, &improved.at)
        && calibration.iter().any(|f| is_named(f, name) && f.is_told_from_nothing())
    {
        verdict = Verdict::EffectFound;
        nothing = without;
        // What was tried beside all calibrations has no place beside one of them: none of it
        // counts.
        let of_calibration = |fitted: &Fitted, effects: Vec<FittedEffect>| Candidate {
            may_be_named: effects.iter().any(FittedEffect::is_told_from_nothing),
            effects: effects.into_iter().take(1).collect(),
            held_out_before: score_before,
            held_out_after: held_out_score(fitted),
            probability: 0.0,
            left: above(bench, &fitted.at) / above(bench, before).max(1.0),
            indistinguishable: Vec::new(),
            fitted: fitted.clone(),
        };
        let is_it = |fitted: &Fitted, name: (&str, Location), of| {
            let effect = fitted.point.effect(of);
            (effect.kind.id, effect.at) == name
        };
        let named = found_beside(bench, &improved, best, |of| is_it(&improved, name, of));
        let others = same_calibration::in_its_place(bench, blocks, (null, &improved), name);
        let others = others.iter().map(|(name, fitted)| {
            let mut other = found(bench, fitted, |of| is_it(fitted, *name, of));
            same_calibration::share(&named, &mut other);
            of_calibration(fitted, other)
        });
        candidates = others.collect();
        candidates.insert(0, of_calibration(&improved, named));
    }
    weigh(ground, &mut candidates, nothing, tried, verdict);
    if verdict == Verdict::EffectFound {
        let any: f64 = candidates.iter().map(|c| c.probability).sum();
        // That a calibration is off shows in the model as it was given; which one is the question.
        let is_calibration = |found: &FittedEffect| is_calibration(found.effect.kind);
        let surely = match candidates[0].effects.iter().all(is_calibration) {
            true => 0.5,
            false => rules::SURELY_ONE,
        };
        if any < surely && at_floor(bench, &null.at) {
            stands = false;
            verdict = Verdict::Adequate;
        } else if any < 0.5 || candidates[0].probability < rules::LEAST_LIKELY {
            // The same where something does; or so many explain the data alike that none is found.
            verdict = Verdict::UnknownEffect;
        }
    }
    let diagnosis = Diagnosis {
        verdict,
        score_before,
        held_out_calibrated: held_out_score(null),
        before: before.clone(),
        each_log: FitState::empty(bench.experiments.len()),
        null: null.clone(),
        mountings: mountings::mountings(best),
        full: best.clone(),
        chosen: chosen.to_vec(),
        candidates,
        calibration,
        unexplained: if at_floor(bench, &improved.at) {
            Vec::new()
        } else {
            unexplained(&improved.at)
        },
        improved,
        limits: Vec::new(),
        confusable: Vec::new(),
        undone: Vec::new(),
    };
    (diagnosis, stands)
}

/// The fit with those calibrations alone that count beside its effects, and their names.
fn improved_by(
    bench: &FitProblem,
    blocks: &[Vec<u8>],
    best: &Fitted,
) -> (Fitted, Vec<(&'static str, Location)>) {
    let (mut improved, kept) = sparse(bench, blocks, best);
    for effect in effects_of(&improved) {
        search::polish(bench, blocks, &mut improved, effect);
    }
    // Beside an effect of another size others are needed no more.
    sparse::without_doubtful(bench, blocks, (improved, kept))
}

/// Cost of all calibrations but one, by the slopes of the fit with all.
fn without_calibration(null: &Fitted, name: (&str, Location)) -> Option<f64> {
    let is_it = |k: &usize| {
        let effect = null.point.effect(null.point.free[*k].of);
        (effect.kind.id, effect.at) == name
    };
    let others: Vec<usize> = (0..null.point.free.len()).filter(|k| !is_it(k)).collect();
    Some(null.linear.with_only(&others)?.0)
}

fn is_named(found: &FittedEffect, name: (&str, Location)) -> bool {
    (found.effect.kind.id, found.effect.at) == name
}

/// True where a fit predicts rows that were left out better than the model as it was given does.
fn predicts_better(ground: &Context<'_>, before: &Residuals, fitted: &Fitted) -> bool {
    let Context { bench, blocks, .. } = *ground;
    let owed = rules::owed(before, &fitted.at);
    let before = before.iter().map(|log| log.residual.clone()).collect();
    let after = fitted.residuals_from_others(blocks);
    HeldOutGain::of(bench, blocks, &[before, after], owed).is_more_than_chance()
}

/// True for a calibration of trackers whose frames were fitted: it is what that has left over.
fn is_of_registration(bench: &FitProblem, id: &str) -> bool {
    let calibration = EffectKind::of(id).and_then(|kind| kind.calibration);
    let tracked = |e: &&Experiment| e.measures(Channel::Tracker, None);
    calibration.is_some_and(|c| c.scope == CalibrationScope::EachLog(&[Channel::Tracker]))
        && bench.experiments.iter().filter(tracked).all(|e| e.registered)
}

/// Probabilities among the explanations, and which of them the data do not tell apart. `nothing`:
/// what it costs to have none.
fn weigh(
    ground: &Context<'_>,
    candidates: &mut [Candidate],
    nothing: f64,
    tried: usize,
    verdict: Verdict,
) {
    let costs: Vec<f64> = candidates.iter().map(|c| ground.owed_cost(&c.fitted)).collect();
    let Some(first) = candidates.first() else {
        return;
    };
    let (best, floor) = (costs[0], floor(ground.bench).max(1.0));
    // What is left above the floor says how far the sum of squares can be trusted.
    let trust = rules::trust(&first.fitted);
    let weight = |cost: f64| (-0.5 * (cost - best).max(0.0) / trust).exp();
    // What may not be named is no explanation. Where it fits better than they do by more than a tie,
    // "none of these" is the likelier.
    let unnamed = |cost: f64| match best - cost {
        better if better > rules::TIED * trust => (0.5 * better / trust).exp(),
        _ => 0.0,
    };
    let weights: Vec<f64> = candidates
        .iter()
        .zip(&costs)
        .map(|(c, cost)| if c.may_be_named { weight(*cost) } else { unnamed(*cost) })
        .collect();
    // "None of these" stands beside them: with the calibrations alone, and with what the best
    // leaves above the floor. Of many that are tried one fits well by chance.
    let none = match verdict {
        Verdict::Adequate => (weight(nothing) * tried as f64).max(1.0),
        _ => weight(nothing) * tried as f64,
    };
    let sum: f64 = weights.iter().sum::<f64>() + none;
    let ceiling = match verdict {
        Verdict::UnknownEffect => 0.5,
        _ => 1.0 - (fit::chi_square(&first.fitted.at) / floor - 1.0).clamp(0.0, 0.5),
    };
    // What shows little may be something else that looks alike.
    let near_limit = (rules::FAINT / (nothing - best).max(rules::FAINT)).sqrt();
    let ceiling = ceiling * (1.0 - rules::LOOKS_ALIKE * near_limit);
    let named: Vec<bool> = candidates.iter().map(|c| c.may_be_named).collect();
    for (k, c) in candidates.iter_mut().enumerate() {
        c.probability = if c.may_be_named { weights[k] / sum * ceiling } else { 0.0 };
        c.indistinguishable = (0..costs.len())
            .filter(|j| *j != k && named[*j])
            .filter(|j| (costs[*j] - costs[k]).abs() < rules::TIED * trust)
            .collect();
    }
}
