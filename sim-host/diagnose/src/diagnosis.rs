//! The diagnosis: hypotheses screened, fitted, weighed, and what is said of them.

use crate::calibration_selection::{self, select_calibrations};
use crate::confuse::{self, Confusable};
use crate::equivalent_calibrations::{self, equivalent_calibrations};
use crate::errors::{DiagnosisErrors, errors_from_others, errors_of};
use crate::found::{
    FittedEffect, effects_of, found, found_beside, found_by_what_is_left, found_over,
    has_unseen_wave, same_effects,
};
use crate::gate::may_be_named;
use crate::gross_calibration::gross_calibration;
use crate::log_evidence::{
    RivalEvidence, exceeds_noise, is_of_library, is_significant, name_price, predicts_better,
};
use crate::mountings::{self, Mountings};
use crate::rules::{
    self, DECISIVE, NAMED, UNNAMED_PROBABILITY_MAX, excess_chi_square, held_out_score,
    noise_chi_square, noise_excess, score, within_noise,
};
use crate::screen::{EffectLimit, ScreenedEffect, SearchContext, likeliest, screen};
use crate::search::{self, Explained, evaluate_uncalibrated, fit_all, fit_calibrations};
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{self, FitProblem, FitState, Fitted, Residuals, Termination};
use trueweld_estimate::predict::{PredictError, PreparedLog};
use trueweld_estimate::residuals::localize::{Finding, localize};
use trueweld_logs::log::{Log, LogKind};
use trueweld_plant::effects::formula::NamedPort;
use trueweld_plant::effects::{CalibrationScope, Effect, EffectKind, EffectPlace, Location, Role};
use trueweld_plant::named;
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

named! {
    /// What the data say.
    pub enum DiagnosisVerdict {
        /// Nothing is missing above the floor.
        Adequate = "adequate",
        /// An effect of the library, or two, explain what was missing.
        EffectFound = "effect-found",
        /// Something is missing that none of the library's effects explains.
        UnknownEffect = "unknown-effect",
    }
}

named! {
    /// How much of what was above noise and accuracy is explained.
    pub enum ExplainedPart {
        /// All of it, or there was none.
        All = "all",
        /// A part: what explains it is told, and what remains.
        Part = "part",
        /// Nothing.
        Nothing = "nothing",
    }
}

impl ExplainedPart {
    /// Of a verdict, where `any` is explained at least.
    pub(crate) fn of(verdict: DiagnosisVerdict, any: bool) -> Self {
        match verdict {
            DiagnosisVerdict::UnknownEffect if any => Self::Part,
            DiagnosisVerdict::UnknownEffect => Self::Nothing,
            _ => Self::All,
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
    /// Evidence for it against none: the difference of the log scores on held-out blocks, less the
    /// logarithm of how many the library proposes, places and shapes, nats.
    pub evidence: f64,
    /// Share of what was above the floor that is still there.
    pub left: f64,
    /// True where it may be named: the logs tell its values from no effect, and it predicts blocks
    /// that were left out better than calibrations alone by more than chance.
    pub may_be_named: bool,
    /// Other explanations that these data do not tell from this one, by index.
    pub indistinguishable: Vec<usize>,
}

impl Candidate {
    /// One that may not be named, from its fit. Before it: the score held out, and by how much the
    /// residuals exceed their noise, as χ².
    fn new(
        problem: &FitProblem,
        fitted: &Fitted,
        effects: Vec<FittedEffect>,
        [score_before, excess_before]: [f64; 2],
    ) -> Self {
        Self {
            effects,
            held_out_before: score_before,
            held_out_after: held_out_score(fitted),
            probability: 0.0,
            evidence: 0.0,
            left: excess_chi_square(problem, &fitted.residuals) / excess_before,
            may_be_named: false,
            indistinguishable: Vec::new(),
        }
    }
}

impl Candidate {
    /// True for one that has all effects of another.
    fn extends(&self, other: &Self) -> bool {
        let has = |found: &FittedEffect| {
            self.effects.iter().any(|own| own.effect.place() == found.effect.place())
        };
        other.effects.iter().all(has)
    }
}

/// What a diagnosis found.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// What the data say.
    pub verdict: DiagnosisVerdict,
    /// Score of the model as it was given.
    pub score_before: f64,
    /// Score with calibrations alone.
    pub score_calibrated: f64,
    /// Score with the best explanation and the calibrations that count.
    pub score_after: f64,
    /// Score on held-out blocks with calibrations alone.
    pub held_out_calibrated: f64,
    /// Errors by channel, in their units.
    pub errors: DiagnosisErrors,
    /// Steps of the explanation: one effect, then two; 0 where none may be named.
    pub chosen: usize,
    /// Explanations, best first.
    pub candidates: Vec<Candidate>,
    /// What is a little off in the cell besides.
    pub calibration: Vec<FittedEffect>,
    /// What the logs fix of how links are mounted; `None` where they see no postures.
    pub mountings: Option<Mountings>,
    /// Smallest size of each effect that these data would have shown.
    pub limits: Vec<EffectLimit>,
    /// Hypotheses that these data cannot tell apart, most alike first.
    pub confusable: Vec<Confusable>,
    /// What the residual of the improved model still goes with, where it is above the floor.
    pub unexplained: Vec<Finding>,
    /// What there was no time for, and fits that did not converge.
    pub incomplete: Vec<Incomplete>,
    /// Ports at which laws outside the library explain the logs about as well as what it has, where that
    /// is too uncertain beside them to be named.
    pub ports_alike: Vec<PortAt>,
}

/// A port of the plant, at a place.
pub type PortAt = (&'static NamedPort, Location);

impl Diagnosis {
    /// How much is explained: a part where effects that may be named leave something, or where
    /// calibrations alone do.
    pub fn explained(&self) -> ExplainedPart {
        let calibrated = self.calibration.iter().any(FittedEffect::is_told_from_nothing);
        ExplainedPart::of(self.verdict, self.chosen > 0 || calibrated)
    }

    /// The same diagnosis where laws outside the library leave what is named in it no more than this
    /// probability; with the ports of these where that is too little for a name. Those laws and what is
    /// never seen of others are not counted twice.
    pub(crate) fn beside_outside(mut self, most: f64, ports_alike: Vec<PortAt>) -> Self {
        let any: f64 = self.candidates.iter().map(|candidate| candidate.probability).sum();
        let share = (most / any).min(1.0);
        self.candidates.iter_mut().for_each(|candidate| candidate.probability *= share);
        match any * share < NAMED {
            true => Self { verdict: DiagnosisVerdict::UnknownEffect, ports_alike, ..self },
            false => self,
        }
    }
}

/// A diagnosis, and the fits that it rests on.
#[derive(Debug, Clone)]
pub struct Diagnosed {
    /// What was found.
    pub diagnosis: Diagnosis,
    /// How.
    pub fits: DiagnosisFits,
}

/// Fits that a diagnosis rests on, for whoever goes on from it.
#[derive(Debug, Clone)]
pub struct DiagnosisFits {
    /// Residuals of the model as it was given.
    pub before: Residuals,
    /// What each log has of its own under the model as it was given.
    pub each_log: FitState,
    /// Calibrations alone.
    pub null: Fitted,
    /// The explanation: one effect, then two; none where none may be named.
    pub chosen: Vec<Fitted>,
    /// The candidates, in the diagnosis' order.
    pub candidates: Vec<Fitted>,
    /// The best explanation, every calibration free.
    pub full: Fitted,
    /// The same with those calibrations alone that count.
    pub improved: Fitted,
}

/// What a diagnosis leaves undone.
#[derive(Debug, Clone)]
pub enum Incomplete {
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
pub type ProgressCallback<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// Finds out which effect is missing. `logs`: those that the problem's logs were made of.
///
/// # Errors
/// [`PredictError`] where the model as given cannot be driven through the logs.
pub fn diagnose(
    problem: &FitProblem,
    logs: &[Log],
    progress: ProgressCallback<'_>,
) -> Result<Diagnosed, PredictError> {
    let blocks = fit::blocks_of(problem);
    progress("comparing", 0.0);
    let (each_log, before) = fit::per_log::fitted(problem, &problem.per_log, Vec::new())?;
    progress("calibrating", 0.02);
    let length = longest_weld(logs);
    let look = |null: Fitted, known: &[ScreenedEffect]| {
        look(problem, &blocks, length, (null, known), progress)
    };
    let mut looked = look(fit_calibrations(problem, &blocks)?, &[])?;
    let held = looked.null.cost;
    if let Some(null) = looked.gross_calibration(problem, &blocks) {
        looked = look(null, &looked.screened)?;
    }
    let mut explained = looked.explain(problem, &blocks, length, progress);
    let null = explained.as_ref().and_then(|e| e.gross_calibration(problem, &blocks));
    if let Some(mut beside) = null.map(|null| look(null, &looked.screened)).transpose()?
        && let Some(whole) = beside
            .explain(problem, &blocks, length, progress)
            .filter(|explained| explained.is_whole(problem))
    {
        (looked, explained) = (beside, Some(whole));
    }
    let Looked { null, given, screened, mut singles, mut incomplete } = looked;
    let (blocks, screened) = (&blocks, &screened);
    let ctx = SearchContext { problem, blocks, null: &null, given: &given, length, screened };
    let limits = screened.iter().map(|s| s.limit.clone()).collect();
    let confusable = confuse::confusable(&ctx, screened);
    let (mut chosen, mut alike): (Vec<Fitted>, Vec<Vec<Fitted>>) = (Vec::new(), Vec::new());
    if let Some(explained) = explained {
        (chosen, alike) = (explained.chosen, explained.alike);
        singles.retain(|single| !same_effects(single, &chosen[0]));
        singles.insert(0, chosen[0].clone());
        while let Some(last) = chosen.last() {
            let before = chosen.len().checked_sub(2).map_or(ctx.null, |k| &chosen[k]);
            if is_nameable(&ctx, before, last) {
                break;
            }
            chosen.pop();
            alike.pop();
        }
    }
    if let Some(last) = chosen.last().filter(|_| chosen.len() > 1) {
        let mut together = vec![last.clone()];
        together.extend(alike.pop().into_iter().flatten());
        for other in search::alternatives(&ctx, last) {
            if !together.iter().any(|known| same_effects(known, &other)) {
                together.push(other);
            }
        }
        let mut together = search::by_evidence(&ctx, together);
        let before = chosen.len() - 2;
        let likeliest = together.iter().position(|f| is_nameable(&ctx, &chosen[before], f));
        if let Some(likeliest) = likeliest {
            together[..=likeliest].rotate_right(1);
            chosen[before + 1] = together[0].clone();
        }
        singles.splice(0..0, together);
    }
    // Calibrations that an effect is missing beside need not converge.
    let answer = if chosen.is_empty() { std::slice::from_ref(&null) } else { chosen.as_slice() };
    let did_not = |f: &&Fitted| f.termination == Termination::StepLimit && !problem.is_late();
    incomplete.extend(answer.iter().filter(did_not).map(|f| {
        Incomplete::Arrival(effects_of(f).into_iter().map(|i| f.point.shared[i].clone()).collect())
    }));
    progress("weighing the evidence", 0.92);
    let unexplained = |at: &Residuals| localize(&problem.logs, at, logs);
    let told = |chosen: &[Fitted]| conclude(&ctx, (&before, held), &singles, chosen, &unexplained);
    let (mut diagnosed, stands) = told(&chosen);
    if !stands {
        diagnosed = told(&[]).0;
    }
    let Diagnosed { diagnosis, fits } = diagnosed;
    Ok(Diagnosed {
        diagnosis: Diagnosis { limits, confusable, incomplete, ..diagnosis },
        fits: DiagnosisFits { each_log, ..fits },
    })
}

/// What was looked for beside the calibrations of one fit.
struct Looked {
    null: Fitted,
    /// The same with no calibrations.
    given: Fitted,
    screened: Vec<ScreenedEffect>,
    /// Every effect that was fitted, best first.
    singles: Vec<Fitted>,
    incomplete: Vec<Incomplete>,
}

impl Explained {
    /// The calibrations beside an explanation, one of them of any size, where that is likelier and
    /// reaches the floor with it.
    fn gross_calibration(&self, problem: &FitProblem, blocks: &[Vec<u8>]) -> Option<Fitted> {
        let last = self.chosen.last()?;
        let beside = gross_calibration(problem, blocks, last, f64::INFINITY)?;
        search::fit_without(problem, blocks, &beside, (&effects_of(&beside), f64::INFINITY))
    }
}

impl Looked {
    /// The calibrations alone, one of them of any size, where that is all there is to say: it reaches the
    /// floor, and costs less than the best effect and its name.
    fn gross_calibration(&self, problem: &FitProblem, blocks: &[Vec<u8>]) -> Option<Fitted> {
        let tied = |best: &Fitted| rules::DECISIVE_FALL * rules::variance_inflation(best);
        let dearest = self.singles.first().map_or(f64::INFINITY, |best| best.cost - tied(best));
        gross_calibration(problem, blocks, &self.null, dearest)
    }

    /// The best of the effects, and what others explain beside it; `None` where none may be named.
    fn explain(
        &mut self,
        problem: &FitProblem,
        blocks: &[Vec<u8>],
        length: f64,
        progress: ProgressCallback<'_>,
    ) -> Option<Explained> {
        let Self { null, given, screened, singles, incomplete } = self;
        let ctx = SearchContext { problem, blocks, null, given, length, screened };
        let k = best_that_counts(&ctx, singles)?;
        singles[..=k].rotate_right(1);
        progress("looking for more effects", 0.65);
        let mut explained = search::add_effects(&ctx, singles[0].clone());
        if let Some((k, others)) = from_another(&ctx, singles, &explained) {
            singles[..=k].rotate_right(1);
            explained = others;
        }
        if problem.is_late() && !explained.is_whole(problem) {
            incomplete.push(Incomplete::Further);
        }
        Some(explained)
    }
}

/// Looks for effects beside the calibrations of one fit. `known`: what was screened beside another one.
fn look(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    length: f64,
    (null, known): (Fitted, &[ScreenedEffect]),
    progress: ProgressCallback<'_>,
) -> Result<Looked, PredictError> {
    progress("screening every effect", 0.11);
    let given = if problem.is_late() {
        null.clone()
    } else {
        evaluate_uncalibrated(problem, blocks, &null)?
    };
    let ctx =
        SearchContext { problem, blocks, null: &null, given: &given, length, screened: known };
    let screened = screen(&ctx);
    let mut incomplete = Vec::new();
    if problem.is_late() {
        incomplete.push(Incomplete::Search);
    }
    progress("fitting the likeliest", 0.45);
    let wanted = likeliest(screened.iter(), rules::FITTED_HYPOTHESES);
    let singles = fit_all(&SearchContext { screened: &screened, ..ctx }, &wanted);
    if problem.is_late() && singles.len() < wanted.len() {
        incomplete.push(Incomplete::Fits(wanted.len() - singles.len()));
    }
    Ok(Looked { null, given, screened, singles, incomplete })
}

/// The best of some effects that counts and may be named; of those that the data do not tell from
/// it, one that is no piece of a wave, which bends to almost anything.
fn best_that_counts(ctx: &SearchContext<'_>, singles: &[Fitted]) -> Option<usize> {
    let count = |k: &usize| is_nameable(ctx, ctx.null, &singles[*k]);
    let evidence = search::evidence_of_each(ctx, singles);
    let best = (0..singles.len()).find(count)?;
    let mut tied = (best..singles.len()).filter(|k| evidence[*k] > evidence[best] - DECISIVE);
    Some(tied.find(|k| !has_unseen_wave(ctx.problem, &singles[*k]) && count(k)).unwrap_or(best))
}

/// True for a fit whose effects may be named beside what `before` has.
fn is_nameable(ctx: &SearchContext<'_>, before: &Fitted, fitted: &Fitted) -> bool {
    let effects = found_over(ctx.problem, ctx.blocks, before, fitted);
    may_be_named(ctx.problem, (before, fitted), &effects)
}

/// The explanation with the most evidence of those that start from another single effect than the
/// first and leave nothing, where it has more than what the `first` led to or that leaves something;
/// with the place of that effect. Of two that are missing each may do less alone than a third that does
/// a part of both, or nearly both.
fn from_another(
    ctx: &SearchContext<'_>,
    singles: &[Fitted],
    first: &Explained,
) -> Option<(usize, Explained)> {
    let is_whole = first.is_whole(ctx.problem);
    let least = ctx.penalized_cost(first.chosen.last()?) - 2.0 * name_price(ctx.problem);
    let is_start = |single: &Fitted| {
        is_significant(ctx.problem, ctx.null, single)
            && !has_unseen_wave(ctx.problem, single)
            && (!is_whole || search::promised_beside(ctx, single) < least)
    };
    let starts = (1..singles.len()).filter(|k| is_start(&singles[*k]));
    let led_to = |k: usize| (k, search::add_effects(ctx, singles[k].clone()));
    let all = starts.take(rules::STARTING_EFFECTS - 1).map(led_to);
    let mut whole: Vec<_> = all.filter(|(_, others)| others.is_whole(ctx.problem)).collect();
    let ends = |explained: &Explained| explained.chosen.last().cloned();
    let mut fits: Vec<Fitted> = whole.iter().filter_map(|(_, others)| ends(others)).collect();
    fits.extend(ends(first).filter(|_| is_whole));
    let evidence = search::evidence_of_each(ctx, &fits);
    let best = (0..fits.len()).max_by(|a, b| evidence[*a].total_cmp(&evidence[*b]))?;
    (best < whole.len()).then(|| whole.swap_remove(best))
}

/// True for an explanation that bends to almost anything: whatever fits as well is as likely, and far
/// more often it is one thing which the library does not have.
pub(crate) fn fits_anything(problem: &FitProblem, fitted: &Fitted) -> bool {
    at_one_joint(fitted) || has_unseen_wave(problem, fitted)
}

/// True for two effects at the same joint, but for waves of several orders.
fn at_one_joint(fitted: &Fitted) -> bool {
    let effects: Vec<&Effect> =
        effects_of(fitted).into_iter().map(|i| &fitted.point.shared[i]).collect();
    let waves = |a: &Effect, b: &Effect| {
        a.kind.id == b.kind.id && a.kind.parameters.iter().any(|p| p.role == Role::Order)
    };
    let alike =
        |a: &Effect, b: &Effect| matches!(a.at, Location::Joint(_)) && a.at == b.at && !waves(a, b);
    (1..effects.len()).any(|k| effects[..k].iter().any(|other| alike(other, effects[k])))
}

/// What is to say where calibrations alone lead to `null` and the explanation is `chosen`.
fn verdict(problem: &FitProblem, null: &Fitted, chosen: &[Fitted]) -> DiagnosisVerdict {
    let Some(best) = chosen.last() else {
        return if within_noise(problem, &null.residuals) {
            DiagnosisVerdict::Adequate
        } else {
            DiagnosisVerdict::UnknownEffect
        };
    };
    let excess = noise_excess(problem, &best.residuals);
    let left = excess / noise_excess(problem, &null.residuals).max(1.0);
    let squares = rules::chi_square_in_own_noise(&best.residuals);
    let score = (squares / noise_chi_square(problem).max(1.0)).sqrt();
    let mostly = score < rules::TOO_FAR && left < rules::REMAINING_SHARE_MAX;
    let explained = mostly || excess == 0.0;
    if explained && !fits_anything(problem, best) {
        DiagnosisVerdict::EffectFound
    } else {
        DiagnosisVerdict::UnknownEffect
    }
}

/// What is to say with an explanation, and whether that stands: false where the model as it was given
/// predicts as well, or where "none of these" is not much less likely and nothing stands out of the
/// floor. `before`: residuals of the model as it was given; `held`: the cost of calibrations alone,
/// each as large as is expected of it.
fn conclude(
    ctx: &SearchContext<'_>,
    (before, held): (&Residuals, f64),
    singles: &[Fitted],
    chosen: &[Fitted],
    unexplained: &dyn Fn(&Residuals) -> Vec<Finding>,
) -> (Diagnosed, bool) {
    let SearchContext { problem, blocks, null, .. } = *ctx;
    let score_before = score(before);
    let excess = excess_chi_square(problem, &null.residuals).max(1.0);
    let best = chosen.last().unwrap_or(null);
    let mut verdict = verdict(problem, null, chosen);
    let (improved, kept) = improved_by(problem, blocks, best);
    let better = predicts_better(problem, before, None, &improved);
    let mut stands = better;
    let calibration = found_calibrations(problem, blocks, (&improved, best));
    let candidate = |fitted: &Fitted| {
        let effects = found_over(problem, blocks, null, fitted);
        let candidate = Candidate::new(problem, fitted, effects, [score_before, excess]);
        let may_be_named = is_nameable(ctx, null, fitted);
        (Candidate { may_be_named, ..candidate }, fitted.clone())
    };
    let mut candidates: Vec<(Candidate, Fitted)> = singles.iter().map(candidate).collect();
    candidates.sort_by_key(|(candidate, _)| !candidate.may_be_named);
    // What it costs to say nothing where a calibration is the answer: with none.
    let mut nothing = None;
    if verdict == DiagnosisVerdict::Adequate
        && better
        && exceeds_noise(problem, before, &improved.residuals)
        && let Some((name, without)) = single_calibration(ctx, (before, held), &kept, &calibration)
        && !improved.point.per_log.iter().flatten().any(|e| e.place() == name)
    {
        verdict = DiagnosisVerdict::EffectFound;
        nothing = Some(without);
        candidates = calibration_candidates(ctx, before, (&improved, best), name);
    }
    let (mut candidates, fits): (Vec<Candidate>, Vec<Fitted>) = candidates.into_iter().unzip();
    weigh(ctx, (&mut candidates, &fits), nothing, verdict);
    if verdict == DiagnosisVerdict::EffectFound {
        let any: f64 = candidates.iter().map(|c| c.probability).sum();
        // That a calibration is off shows in the model as it was given; which one is the question.
        let is_calibration = |found: &FittedEffect| is_calibration(found.effect.kind);
        let surely = match candidates[0].effects.iter().all(is_calibration) {
            true => 0.5,
            false => NAMED,
        };
        if any < surely && within_noise(problem, &null.residuals) {
            stands = false;
            verdict = DiagnosisVerdict::Adequate;
        } else if any < surely || candidates[0].probability < rules::LEAST_LIKELY {
            // The same where something does; or so many explain the data alike that none is found.
            verdict = DiagnosisVerdict::UnknownEffect;
        }
    }
    let diagnosis = Diagnosis {
        verdict,
        score_before,
        score_calibrated: score(&null.residuals),
        score_after: score(&improved.residuals),
        held_out_calibrated: held_out_score(null),
        errors: DiagnosisErrors {
            before: errors_of(problem, before),
            calibrated: errors_from_others(problem, blocks, null),
            after: errors_from_others(problem, blocks, &improved),
        },
        mountings: mountings::mountings(best),
        chosen: chosen.len(),
        candidates,
        calibration,
        unexplained: if within_noise(problem, &improved.residuals) {
            Vec::new()
        } else {
            unexplained(&improved.residuals)
        },
        limits: Vec::new(),
        confusable: Vec::new(),
        incomplete: Vec::new(),
        ports_alike: Vec::new(),
    };
    let fits = DiagnosisFits {
        before: before.clone(),
        each_log: FitState::empty(problem.logs.len()),
        null: null.clone(),
        chosen: chosen.to_vec(),
        candidates: fits,
        full: best.clone(),
        improved,
    };
    (Diagnosed { diagnosis, fits }, stands)
}

/// The calibrations of an improved model, with intervals by what is left out, and by what no model
/// explains, whichever says less of them. `best`: with all calibrations free.
fn found_calibrations(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    (improved, best): (&Fitted, &Fitted),
) -> Vec<FittedEffect> {
    let mut calibration = found_beside(problem, improved, best, |_| true);
    let weighed = found_by_what_is_left(problem, blocks, improved);
    for (found, weighed) in calibration.iter_mut().zip(weighed) {
        for (own, other) in found.interval.iter_mut().zip(weighed.interval) {
            *own = [own[0].min(other[0]), own[1].max(other[1])];
        }
    }
    calibration.retain(|found| is_calibration(found.effect.kind));
    calibration
}

/// The calibration that is all there is to say, of those that were kept the only one, or the one that is
/// no calibration any more; and what it costs to say nothing. Where each log has its own it is the
/// laboratory's doing, not the cell's.
fn single_calibration(
    ctx: &SearchContext<'_>,
    (before, held): (&Residuals, f64),
    kept: &[EffectPlace],
    calibration: &[FittedEffect],
) -> Option<(EffectPlace, f64)> {
    let SearchContext { problem, null, .. } = *ctx;
    let mut kept = kept.iter().filter(|name| !is_of_registration(problem, name.kind));
    let mut beyond = calibration.iter().filter(|f| f.is_implausible());
    let (name, without) = match (kept.next(), kept.next(), beyond.next(), beyond.next()) {
        (Some(only), None, ..) => {
            let given = fit::chi_square(before);
            (*only, without_calibration(null, *only).map_or(given, |cost| cost.min(given)))
        }
        (.., Some(only), None) => (only.effect.place(), held),
        _ => return None,
    };
    let is_told = |f: &FittedEffect| f.effect.place() == name && f.is_told_from_nothing();
    let is_of_log = problem.per_log.iter().any(|own| own.stated.place() == name);
    (calibration.iter().any(is_told) && !is_of_log).then_some((name, without))
}

/// That calibration as the explanation, and those that the logs do not tell from it. What was tried
/// beside all calibrations has no place beside one of them: none of it counts.
fn calibration_candidates(
    ctx: &SearchContext<'_>,
    before: &Residuals,
    (improved, best): (&Fitted, &Fitted),
    name: EffectPlace,
) -> Vec<(Candidate, Fitted)> {
    let SearchContext { problem, blocks, null, .. } = *ctx;
    let given = [score(before), excess_chi_square(problem, before).max(1.0)];
    let of_calibration = |fitted: &Fitted, mut effects: Vec<FittedEffect>| {
        let may_be_named = effects.iter().any(FittedEffect::is_told_from_nothing);
        effects.truncate(1);
        let candidate = Candidate::new(problem, fitted, effects, given);
        (Candidate { may_be_named, ..candidate }, fitted.clone())
    };
    let is_it = |fitted: &Fitted, name: EffectPlace, of| fitted.point.effect(of).place() == name;
    let named = found_beside(problem, improved, best, |of| is_it(improved, name, of));
    let others = equivalent_calibrations(problem, blocks, (null, improved), name);
    let others = others.iter().map(|(name, fitted)| {
        let mut other = found(problem, fitted, |of| is_it(fitted, *name, of));
        equivalent_calibrations::share(&named, &mut other);
        of_calibration(fitted, other)
    });
    let mut candidates: Vec<(Candidate, Fitted)> = others.collect();
    candidates.insert(0, of_calibration(improved, named));
    candidates
}

/// The fit with those calibrations alone that count beside its effects, and their names.
fn improved_by(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    best: &Fitted,
) -> (Fitted, Vec<EffectPlace>) {
    let (mut improved, kept) = select_calibrations(problem, blocks, best);
    for effect in effects_of(&improved) {
        search::refit_scaled(problem, blocks, &mut improved, effect);
    }
    // Beside an effect of another size others are needed no more.
    calibration_selection::drop_insignificant(problem, blocks, (improved, kept))
}

/// Cost of all calibrations but one, by the slopes of the fit with all.
fn without_calibration(null: &Fitted, name: EffectPlace) -> Option<f64> {
    let is_it = |k: &usize| null.point.effect(null.point.free[*k].of).place() == name;
    let others: Vec<usize> = (0..null.point.free.len()).filter(|k| !is_it(k)).collect();
    Some(null.linear.with_only(&others)?.0)
}

/// True for a calibration of trackers whose frames were fitted: it is what that has left over.
fn is_of_registration(problem: &FitProblem, kind: &EffectKind) -> bool {
    let tracked = |e: &&PreparedLog| e.measures(Channel::Tracker, None);
    kind.calibration.is_some_and(|c| c.scope == CalibrationScope::EachLog(&[Channel::Tracker]))
        && problem.logs.iter().filter(tracked).all(|e| e.registered)
}

/// Probabilities among the explanations, given with their fits, and which of them the data do not
/// tell apart. `nothing`: what it costs to have none, where that is not the calibrations alone.
fn weigh(
    ctx: &SearchContext<'_>,
    (candidates, fits): (&mut [Candidate], &[Fitted]),
    nothing: Option<f64>,
    verdict: DiagnosisVerdict,
) {
    let Some(first) = fits.first() else {
        return;
    };
    let evidence = RivalEvidence::over(ctx.problem, ctx.null, &first.residuals);
    for (candidate, fitted) in candidates.iter_mut().zip(fits) {
        candidate.evidence = evidence.of(fitted);
    }
    let named = candidates.iter().filter(|c| c.may_be_named);
    let likeliest = named.max_by(|a, b| a.evidence.total_cmp(&b.evidence));
    let likeliest = likeliest.unwrap_or(&candidates[0]).clone();
    let best = likeliest.evidence;
    // "None of these" stands beside them: with the calibrations alone, to which evidence is relative.
    let none = nothing.map_or(0.0, |nothing| {
        let worse = (nothing - ctx.penalized_cost(first)) / rules::variance_inflation(first);
        candidates[0].evidence - 0.5 * worse
    });
    let none = match verdict {
        DiagnosisVerdict::Adequate => none.max(best),
        _ => none,
    };
    // What may not be named is no explanation. Where it predicts better than they do by more than a
    // tie, and is not the likeliest of them with something more, "none of these" is the likelier.
    let rivals = |c: &Candidate| c.evidence > best + DECISIVE && !c.extends(&likeliest);
    let weight = |c: &Candidate| match c.may_be_named || rivals(c) {
        true => (c.evidence - best).exp(),
        false => 0.0,
    };
    let weights: Vec<f64> = candidates.iter().map(weight).collect();
    let sum: f64 = weights.iter().sum::<f64>() + (none - best).exp();
    let ceiling = match verdict {
        DiagnosisVerdict::UnknownEffect => UNNAMED_PROBABILITY_MAX,
        _ => is_of_library(best - none),
    };
    let all: Vec<(bool, f64)> = candidates.iter().map(|c| (c.may_be_named, c.evidence)).collect();
    for (k, c) in candidates.iter_mut().enumerate() {
        c.probability = if c.may_be_named { weights[k] / sum * ceiling } else { 0.0 };
        let tied = |j: &usize| *j != k && all[*j].0 && (all[*j].1 - c.evidence).abs() < DECISIVE;
        c.indistinguishable = (0..all.len()).filter(tied).collect();
    }
}
