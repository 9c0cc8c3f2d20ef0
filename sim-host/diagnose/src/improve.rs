//! Adds what is missing to a model, step by step: each step is kept only if it lowers the error
//! where nothing was fitted, and if the arm with it stays stable.
//!
//! First what recalibration alone can do, then the effects that [`crate::diagnose`] names, each
//! step with everything refitted and those calibrations kept that count; then, where these do not
//! reach the floor, further ones as long as each counts, and where the library has none a law outside
//! it.

use crate::calibration_selection::select_calibrations;
use crate::diagnosis::{
    Candidate, Diagnosed, Diagnosis, DiagnosisFits, DiagnosisVerdict, ExplainedPart, Incomplete,
    ProgressCallback, diagnose, fits_anything, longest_weld,
};
use crate::discover::{self, Discovery, discover};
use crate::errors::{errors_from_others, errors_of};
use crate::found::{FittedEffect, found_beside, found_by_what_is_left, inflate_noise};
use crate::log_evidence::{exceeds_noise, predicts_better};
use crate::rules::{self, parts, score};
use crate::screen::SearchContext;
use crate::search::add_each_effect;
use trueweld_core::JointVector;
use trueweld_estimate::fit::calibration::{self, is_calibration};
use trueweld_estimate::fit::per_log;
use trueweld_estimate::fit::{
    self, FitProblem, FitState, Fitted, PerLogEffect, Residuals, SolverOptions, SortedEffects,
};
use trueweld_estimate::predict::{PredictError, PreparedLog, is_open_factor};
use trueweld_estimate::residuals::compare::{LogComparison, Notice, of_each_log, of_logs};
use trueweld_estimate::residuals::error::ChannelError;
use trueweld_estimate::residuals::localize::{Finding, localize};
use trueweld_logs::log::Log;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{ModelEffect, ModelFile, Scope};
use trueweld_plant::integrate::link_dynamics::{DynamicLinks, Motors};
use trueweld_plant::integrate::substeps;
use trueweld_plant::robot::ElasticRobot;

/// One accepted step.
#[derive(Debug, Clone)]
pub struct ImprovementStep {
    /// What was added; nothing at the start and where only the calibration changed.
    pub added: Vec<FittedEffect>,
    /// Every effect of the model at this step, with the values refitted there.
    pub effects: Vec<FittedEffect>,
    /// The calibrations that count beside them.
    pub calibration: Vec<FittedEffect>,
    /// Score on the logs fitted.
    pub score: f64,
    /// Score where nothing was fitted: on the logs held out, or on blocks in time left out of the
    /// fit.
    pub held_out: f64,
    /// Errors there, by channel.
    pub errors: Vec<ChannelError>,
}

/// A step that was tried and not kept.
#[derive(Debug, Clone)]
pub struct Rejected {
    /// What would have been added; nothing for a recalibration.
    pub added: Vec<FittedEffect>,
    /// Score where nothing was fitted, with it.
    pub held_out: f64,
    /// Why it was not kept.
    pub why: Rejection,
}

/// Why a step is not kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rejection {
    /// The model with it cannot be driven through the logs held out.
    NotPredicted,
    /// The score where nothing was fitted does not fall.
    NoGain,
    /// It falls on blocks in time, but logs are predicted worse from what the other logs tell.
    OtherLogsWorse,
    /// The logs do not tell its values from no effect, or what falls with it falls by no more than
    /// chance.
    NotShown,
    /// The arm with it does not come to rest.
    Unstable,
}

/// A model improved.
#[derive(Debug)]
pub struct Improvement {
    /// Accepted steps, the model as it was given first.
    pub steps: Vec<ImprovementStep>,
    /// What was tried and not kept.
    pub rejected: Vec<Rejected>,
    /// What is to say of the improved model.
    pub verdict: DiagnosisVerdict,
    /// Laws outside the library that were found.
    pub discovered: Vec<Discovery>,
    /// The diagnosis that it rests on.
    pub diagnosis: Diagnosis,
    /// What the residual of the improved model still follows, where it is above the floor.
    pub unexplained: Vec<Finding>,
    /// What there was no time for, and fits that did not converge.
    pub incomplete: Vec<Incomplete>,
    /// Names of the logs that were held out; none where blocks in time were.
    pub held_out_logs: Vec<String>,
}

/// An improvement, and the fits that it rests on.
#[derive(Debug)]
pub struct Improved {
    /// What was done.
    pub improvement: Improvement,
    /// Fits of the diagnosis.
    pub diagnosis: DiagnosisFits,
    /// The improved model's fit; `None` where the model stays as it was given.
    pub fitted: Option<Fitted>,
}

impl Improvement {
    /// True where the model does not stay as it was given.
    pub fn is_any(&self) -> bool {
        self.steps.len() > 1
    }

    /// How much of what was above noise and accuracy the improved model explains.
    pub fn explained(&self) -> ExplainedPart {
        ExplainedPart::of(self.verdict, self.is_any())
    }

    /// The model as it was given.
    pub fn first(&self) -> &ImprovementStep {
        &self.steps[0]
    }

    /// The improved model.
    pub fn last(&self) -> &ImprovementStep {
        &self.steps[self.steps.len() - 1]
    }

    /// True where the model stays as it was given because what was fitted predicts worse where
    /// nothing was fitted.
    pub fn is_worse_elsewhere(&self) -> bool {
        let most = self.first().held_out * (1.0 + IMPROVEMENT_MIN);
        let worse = |step: &Rejected| step.held_out > most;
        !self.is_any() && self.rejected.iter().any(worse)
    }

    /// Effects that the data do not tell from those of a step; none where it is not the explanation
    /// of the diagnosis.
    pub fn others(&self, step: &ImprovementStep) -> Vec<&Effect> {
        let place = |f: &FittedEffect| f.effect.place();
        let candidates = &self.diagnosis.candidates;
        let same = |best: &&Candidate| {
            !step.added.is_empty()
                && best.effects.iter().all(|f| step.effects.iter().any(|e| place(e) == place(f)))
        };
        candidates.first().filter(same).map_or(Vec::new(), |best| best.others(candidates))
    }
}

/// Logs that nothing is fitted to, made ready.
#[derive(Debug)]
pub struct HeldOut {
    /// Effects of the model as it was given.
    given: Vec<ModelEffect>,
    /// The baseline over these logs.
    problem: FitProblem,
    /// Their names.
    names: Vec<String>,
}

impl HeldOut {
    /// Logs to judge a model by, and the experiments made of them.
    pub fn new(file: &ModelFile, logs: &[Log], experiments: Vec<PreparedLog>) -> Self {
        let (known, per_log, own) = (Vec::new(), Vec::new(), Vec::new());
        let problem = FitProblem { known, per_log, own, ..FitProblem::new(file, experiments) };
        let given = file.effects.clone();
        Self { given, problem, names: logs.iter().map(|l| l.name.clone()).collect() }
    }

    /// These logs under the model with what was found beside the given: what each of them has of its
    /// own, and the residuals.
    fn predict<'f>(
        &self,
        found: impl Iterator<Item = &'f FittedEffect>,
    ) -> Result<(Vec<PerLogEffect>, FitState, Residuals), PredictError> {
        let (effects, _) = model_effects(&self.given, found, &self.problem);
        let SortedEffects { known, per_log, .. } =
            SortedEffects::new(&effects, &self.problem.declared, None);
        let (point, at) = per_log::fitted(&self.problem, &per_log, known)?;
        Ok((per_log, point, at))
    }

    /// These logs under the model of a step, and what each of them has of its own there. `logs`:
    /// those that this was made of.
    ///
    /// # Errors
    /// [`PredictError`] where the model cannot be driven through them.
    pub fn compare(
        &self,
        logs: &[Log],
        step: &ImprovementStep,
    ) -> Result<(Vec<LogComparison>, Vec<Notice>), PredictError> {
        let (per_log, point, at) = self.predict(step.found())?;
        let own = logs.first().map(|log| of_each_log(&log.robot, logs, &per_log, &point));
        Ok((of_logs(logs, &self.problem.logs, &at), own.unwrap_or_default()))
    }
}

impl ImprovementStep {
    /// All that was fitted.
    fn found(&self) -> impl Iterator<Item = &FittedEffect> {
        self.effects.iter().chain(&self.calibration)
    }
}

/// Steps at most, the first not counted.
const IMPROVEMENT_STEPS_MAX: usize = 8;

/// Fall of the held-out score by less than this share is no improvement.
const IMPROVEMENT_MIN: f64 = 2e-3;

/// Improves the problem's model. `logs`: those that its logs were made of; `held_out`: where
/// every step is judged, in place of blocks in time of the same logs.
///
/// # Errors
/// [`PredictError`] where the model as given cannot be driven through the logs.
pub fn improve(
    problem: &FitProblem,
    logs: &[Log],
    held_out: Option<&HeldOut>,
    progress: ProgressCallback<'_>,
) -> Result<Improved, PredictError> {
    let diagnosed = diagnose(problem, logs, &|what, share| progress(what, 0.6 * share))?;
    let (Diagnosed { diagnosis, fits }, discovered) =
        discover(problem, logs, diagnosed, &|what, share| progress(what, 0.6 + 0.1 * share));
    let blocks = fit::blocks_of(problem);
    let at_held_out = held_out.map(|h| h.predict(std::iter::empty())).transpose()?;
    let at_held_out = at_held_out.map(|(.., at)| at);
    let start = at_held_out.as_ref().map_or(diagnosis.score_before, score);
    let errors = match (held_out, &at_held_out) {
        (Some(held_out), Some(at)) => errors_of(&held_out.problem, at),
        _ => errors_of(problem, &fits.before),
    };
    let baseline = ImprovementStep {
        added: Vec::new(),
        effects: Vec::new(),
        calibration: Vec::new(),
        score: diagnosis.score_before,
        held_out: start,
        errors,
    };
    let mut path = ImprovementPath {
        problem,
        logs,
        blocks: &blocks,
        held_out,
        given: &fits.before,
        steps: vec![baseline],
        rejected: Vec::new(),
        discovered,
        at_held_out,
        other_logs: diagnosis.score_before,
        reached: None,
    };
    progress("recalibrating", 0.7);
    if !fits.null.point.free.is_empty() {
        let alone = fits.chosen.is_empty() && path.discovered.is_empty();
        let kept = if alone {
            fits.improved.clone()
        } else {
            select_calibrations(problem, &blocks, &fits.null).0
        };
        path.try_step(kept, Some(&fits.null));
    }
    // What was found outside the library stands in the place of what explains a part within.
    let outside = !path.discovered.is_empty();
    if outside {
        progress("adding what was found", 0.75);
        path.try_step(fits.improved.clone(), Some(&fits.full));
    }
    for (k, full) in fits.chosen.iter().enumerate().filter(|_| !outside) {
        progress("adding what was found", 0.75 + 0.05 * k as f64);
        // The last of them is what the diagnosis keeps.
        let last = k + 1 == fits.chosen.len();
        let kept = if last {
            fits.improved.clone()
        } else {
            select_calibrations(problem, &blocks, full).0
        };
        path.try_step(kept, Some(full));
    }
    // A partial explanation is carried on as far as it goes.
    let mut has_more = false;
    while diagnosis.verdict == DiagnosisVerdict::UnknownEffect
        && diagnosis.ports_alike.is_empty()
        && path.steps.len() <= IMPROVEMENT_STEPS_MAX
        && !problem.is_late()
    {
        progress(
            "looking for more",
            0.85 + 0.15 * path.steps.len() as f64 / IMPROVEMENT_STEPS_MAX as f64,
        );
        if !path.add_effect(longest_weld(logs)) {
            break;
        }
        has_more = true;
    }
    if let Some(mut whole) = path.reached.clone().filter(|_| has_more) {
        // What was found one after the other, fitted together.
        whole = fit::resume(problem, &whole, &blocks, SolverOptions::full(0));
        path.try_step(whole, None);
    }
    let ImprovementPath { steps, rejected, mut discovered, reached, .. } = path;
    // Those that the improved model has, with its values: all were fitted together once more.
    discovered.retain_mut(|law| {
        let own = &law.effect.effect;
        let same = |f: &&FittedEffect| f.effect.place() == own.place();
        let last = steps.last().and_then(|step| step.effects.iter().find(same));
        last.map(|last| law.effect = last.clone()).is_some()
    });
    let verdict = match &reached {
        Some(fitted)
            if diagnosis.verdict == DiagnosisVerdict::UnknownEffect
                && discovered.is_empty()
                && diagnosis.ports_alike.is_empty()
                && rules::within_noise(problem, &fitted.residuals)
                && !fits_anything(problem, fitted) =>
        {
            // Where only calibrations were kept, nothing else was missing.
            match steps.iter().all(|step| step.added.is_empty()) {
                true => DiagnosisVerdict::Adequate,
                false => DiagnosisVerdict::EffectFound,
            }
        }
        _ => diagnosis.verdict,
    };
    let beyond = reached.as_ref().filter(|f| !rules::within_noise(problem, &f.residuals));
    let unexplained = match beyond {
        Some(fitted) => localize(&problem.logs, &fitted.residuals, logs),
        None => diagnosis.unexplained.clone(),
    };
    let mut incomplete = diagnosis.incomplete.clone();
    let told = incomplete.iter().any(|undone| matches!(undone, Incomplete::Further));
    if problem.is_late() && verdict == DiagnosisVerdict::UnknownEffect && !told {
        incomplete.push(Incomplete::Further);
    }
    let improvement = Improvement {
        steps,
        rejected,
        verdict,
        discovered,
        diagnosis,
        unexplained,
        incomplete,
        held_out_logs: held_out.map_or(Vec::new(), |h| h.names.clone()),
    };
    Ok(Improved { improvement, diagnosis: fits, fitted: reached })
}

/// The effects that a step has for the first time; a joint may have several of one kind.
fn added(before: &[FittedEffect], now: &[FittedEffect]) -> Vec<FittedEffect> {
    let place = |f: &FittedEffect| f.effect.place();
    let mut known: Vec<_> = before.iter().map(place).collect();
    let mut added = now.to_vec();
    added.retain(|f| match known.iter().position(|k| *k == place(f)) {
        Some(k) => {
            known.swap_remove(k);
            false
        }
        None => true,
    });
    added
}

/// The steps taken so far, and what they are judged by.
struct ImprovementPath<'a> {
    problem: &'a FitProblem,
    logs: &'a [Log],
    blocks: &'a [Vec<u8>],
    held_out: Option<&'a HeldOut>,
    /// Residuals of the model as it was given.
    given: &'a Residuals,
    steps: Vec<ImprovementStep>,
    rejected: Vec<Rejected>,
    discovered: Vec<Discovery>,
    /// Residuals of the logs held out under the model reached.
    at_held_out: Option<Residuals>,
    /// Score of the logs fitted under the model reached, each predicted from what the others tell.
    other_logs: f64,
    reached: Option<Fitted>,
}

impl ImprovementPath<'_> {
    /// Takes a step to a fit if it is one forward. `full`: the fit with every calibration free, of
    /// which this keeps those that count; intervals allow for the others where it is there.
    fn try_step(&mut self, fitted: Fitted, full: Option<&Fitted>) -> bool {
        self.try_step_by(fitted, full, false)
    }

    /// The same; `by_channel`: only where it explains enough of the error with every channel weighed
    /// alike, and then also where the score does not fall.
    fn try_step_by(&mut self, fitted: Fitted, full: Option<&Fitted>, by_channel: bool) -> bool {
        let all = match full {
            Some(full) => found_beside(self.problem, &fitted, full, |_| true),
            None => found_by_what_is_left(self.problem, self.blocks, &fitted),
        };
        let (calibration, effects): (Vec<FittedEffect>, Vec<FittedEffect>) =
            all.into_iter().partition(|f| is_calibration(f.effect.kind));
        let added = added(self.steps.last().map_or(&[], |s| &s.effects), &effects);
        let before = self.steps.last().map_or(f64::INFINITY, |s| s.held_out);
        let given = self.steps.first().map_or(f64::INFINITY, |s| s.held_out);
        // Blocks in time of a log tell what that log is like; another one may be otherwise.
        let logs = self.problem.logs.len();
        let other_logs = if self.held_out.is_none() && logs > 1 {
            let squares = fitted.held_out_logs(self.problem);
            (squares / fit::count(&fitted.residuals).max(1) as f64).sqrt()
        } else {
            f64::NEG_INFINITY
        };
        let at_held_out = self
            .held_out
            .map(|held_out| held_out.predict(effects.iter().chain(&calibration)))
            .transpose()
            .map(|at| at.map(|(.., at)| at));
        let judged = at_held_out.as_ref().map(|at| match (self.held_out, at, &self.at_held_out) {
            (Some(held_out), Some(at), Some(before)) => {
                (score(at), explains(&held_out.problem, before, at))
            }
            _ => {
                let before = self.reached.as_ref().map_or(self.given, |f| &f.residuals);
                let falls = explains(self.problem, before, &fitted.residuals);
                (rules::held_out_score(&fitted), falls)
            }
        });
        // The score, which the worst channel rules, hardly sees a step that is a large one in another.
        let is_kept = |score: f64, explains: bool| match by_channel {
            true => explains && score < before.min(given) * (1.0 + IMPROVEMENT_MIN),
            false => score <= before * (1.0 - IMPROVEMENT_MIN),
        };
        let (held_out, why) = match judged {
            Err(_) => (f64::NAN, Some(Rejection::NotPredicted)),
            Ok((score, falls)) if !is_kept(score, falls) => (score, Some(Rejection::NoGain)),
            Ok(_) if other_logs > self.other_logs * (1.0 + IMPROVEMENT_MIN) => {
                (other_logs, Some(Rejection::OtherLogsWorse))
            }
            Ok((score, _))
                if !added.is_empty() && !self.shows(&fitted, full, &added, &at_held_out) =>
            {
                (score, Some(Rejection::NotShown))
            }
            Ok((score, _)) if !stable(self.problem, self.logs, &fitted.point) => {
                (score, Some(Rejection::Unstable))
            }
            Ok((score, _)) => (score, None),
        };
        match why {
            Some(why) => self.rejected.push(Rejected { added, held_out, why }),
            None => {
                self.steps.push(ImprovementStep {
                    added,
                    effects,
                    calibration,
                    score: score(&fitted.residuals),
                    held_out,
                    errors: match (self.held_out, &at_held_out) {
                        (Some(held_out), Ok(Some(at))) => errors_of(&held_out.problem, at),
                        _ => errors_from_others(self.problem, self.blocks, &fitted),
                    },
                });
                self.at_held_out = at_held_out.ok().flatten();
                self.other_logs = other_logs;
                self.reached = Some(fitted);
            }
        }
        why.is_none()
    }

    /// True where a step shows what it adds, as what a diagnosis names must. The diagnosis has
    /// judged the intervals of what it gives, beside all calibrations, itself.
    fn shows(
        &self,
        fitted: &Fitted,
        full: Option<&Fitted>,
        added: &[FittedEffect],
        at_held_out: &Result<Option<Residuals>, PredictError>,
    ) -> bool {
        let before = self.reached.as_ref().map_or(self.given, |reached| &reached.residuals);
        let predicts = match (self.held_out, at_held_out, &self.at_held_out) {
            (Some(HeldOut { problem, .. }), Ok(Some(after)), Some(before)) => {
                exceeds_noise(problem, before, after)
            }
            _ => predicts_better(self.problem, self.given, self.reached.as_ref(), fitted),
        };
        (full.is_some() || added.iter().all(FittedEffect::is_told_from_nothing))
            && exceeds_noise(self.problem, before, &fitted.residuals)
            && predicts
    }

    /// Adds one more effect where the explanation is a partial one: of the library, and where it
    /// has none a law outside it. What no model explains yet is no noise that instruments state:
    /// every channel is weighed by what is left in it, so that the worst does not hide the others,
    /// and the values found before stay, so that none is spent on it.
    fn add_effect(&mut self, length: f64) -> bool {
        let empty = FitState::empty(self.problem.logs.len());
        let point = self.reached.as_ref().map_or(empty, |f| f.point.clone());
        let held = FitState { free: Vec::new(), ..point.clone() };
        let nothing_free = SolverOptions::steps(0, 0);
        let Ok(plain) = fit::fit(self.problem, &held, self.blocks, &[], nothing_free) else {
            return false;
        };
        if rules::within_noise(self.problem, &plain.residuals) {
            return false;
        }
        let inflated = inflate_noise(self.problem, &plain.residuals);
        let Ok(null) = fit::fit(&inflated, &held, self.blocks, &[], nothing_free) else {
            return false;
        };
        let ctx = SearchContext {
            problem: &inflated,
            blocks: self.blocks,
            null: &null,
            given: &null,
            length,
            screened: &[],
        };
        let Self { problem, logs, blocks, .. } = *self;
        let mut takes = |next: &Fitted| {
            let mut whole = next.point.clone();
            whole.free = point.free.iter().chain(&next.point.free).copied().collect();
            let fitted = fit::fit(problem, &whole, blocks, &[], nothing_free);
            fitted.is_ok_and(|fitted| self.try_step_by(fitted, None, true))
        };
        if add_each_effect(&ctx, &null).iter().any(&mut takes) {
            return true;
        }
        let Some(law) = discover::beside(&inflated, blocks, logs, &null, takes) else {
            return false;
        };
        let [.., before, after] = self.steps.as_slice() else { return true };
        let (held_out_before, held_out_after) = (before.held_out, after.held_out);
        self.discovered.push(Discovery { held_out_before, held_out_after, ..law });
        true
    }
}

/// True where a tenth of the squared error goes, each channel's over what it was, on average by
/// samples.
fn explains(problem: &FitProblem, before: &Residuals, after: &Residuals) -> bool {
    let (before, after) = (parts(problem, before), parts(problem, after));
    let (mut left, mut count) = (0.0, 0.0);
    for (channel, was) in &before {
        let now = after.get(channel).map_or(was.square, |part| part.square);
        left += was.count as f64 * now / was.square.max(f64::MIN_POSITIVE);
        count += was.count as f64;
    }
    left < (1.0 - rules::EXPLAINED_SHARE_MIN) * count
}

/// True where the arm, struck in every joint at a posture of the logs, comes to rest.
fn stable(problem: &FitProblem, logs: &[Log], point: &FitState) -> bool {
    const STRUCK_ARM_RATE: f64 = 1e-3;
    const STRUCK_ARM_PERIOD: f64 = 1e-3;
    const STRUCK_ARM_STEP: f64 = 2.5e-4;
    let effects: Vec<Effect> = problem.known.iter().chain(&point.shared).cloned().collect();
    let mut process = problem.model.process.clone();
    let Ok(robot) = ElasticRobot::with_effects(&problem.model.robot, &effects, process.as_mut())
    else {
        return false;
    };
    logs.iter().filter_map(|log| log.samples.encoder.first()).all(|posture| {
        let Ok(substeps) = substeps(&robot, [*posture], STRUCK_ARM_PERIOD, STRUCK_ARM_STEP) else {
            return false;
        };
        let mut swinging = DynamicLinks::start(&robot, &Motors::at_rest(*posture), 0.0);
        let motors = Motors::at_rest(posture + JointVector::repeat(STRUCK_ARM_RATE));
        // Hardest in the first tenth of two seconds; what is left of it in the last.
        let (mut first, mut last) = (0.0f64, 0.0f64);
        for k in 1..=2000 {
            if swinging
                .advance(&robot, &motors, f64::from(k) * STRUCK_ARM_PERIOD, substeps)
                .is_err()
            {
                return false;
            }
            let rate = swinging.drives().link_rate.amax();
            match k {
                ..=200 => first = first.max(rate),
                1800.. => last = last.max(rate),
                _ => {}
            }
        }
        last < 0.5 * first
    })
}

/// Where the values of an effect in an improved model come from.
#[derive(Debug, Clone)]
pub enum EffectOrigin {
    /// The model as it was given.
    Given,
    /// What the model's masses and friction make of currents, before any fit.
    FoundBefore,
    /// The fit to all logs.
    Fitted(FittedEffect),
    /// What each log has of its own, fitted to it, or alike in all logs fitted; the model has the mean.
    PerLog(Vec<FittedEffect>),
    /// Of an instrument of which something else is each log's own: nothing was seen of it here, and
    /// another log has it zeroed anew.
    Renewed,
}

/// The improved model as a file, and where each of its effects comes from, in its order. `problem`:
/// of the logs fitted.
pub fn model_file(
    improvement: &Improvement,
    file: &ModelFile,
    problem: &FitProblem,
) -> (ModelFile, Vec<EffectOrigin>) {
    let (effects, origins) = model_effects(&file.effects, improvement.last().found(), problem);
    (ModelFile { posterior: None, effects, ..file.clone() }, origins)
}

/// The effects of a model with what was found beside them, and where each comes from. An
/// instrument's zero, a registration, how the tool is mounted: these are the log's own, although the
/// logs fitted may share them. `problem`: of logs that show which instruments there are.
fn model_effects<'f>(
    given: &[ModelEffect],
    found: impl Iterator<Item = &'f FittedEffect>,
    problem: &FitProblem,
) -> (Vec<ModelEffect>, Vec<EffectOrigin>) {
    let origin = |entry: &ModelEffect| match is_found_factor(entry) {
        true => EffectOrigin::FoundBefore,
        false => EffectOrigin::Given,
    };
    let mut effects: Vec<(ModelEffect, EffectOrigin)> =
        given.iter().map(|entry| (entry.clone(), origin(entry))).collect();
    let is_of_log = |f: &&FittedEffect| f.log.is_some() || is_renewed(&f.effect);
    let (own, common): (Vec<&FittedEffect>, Vec<&FittedEffect>) = found.partition(is_of_log);
    for found in common {
        let entry = ModelEffect { effect: found.effect.clone(), scope: Scope::Campaign };
        add(&mut effects, entry, EffectOrigin::Fitted(found.clone()));
    }
    let stated = SortedEffects::new(given, &problem.declared, None).per_log;
    for (k, found) in own.iter().enumerate() {
        if own[..k].iter().any(|f| f.effect.place() == found.effect.place()) {
            continue;
        }
        let stated = stated.iter().find(|stated| stated.is(&found.effect));
        let all = own.iter().filter(|f| f.effect.place() == found.effect.place());
        let all: Vec<FittedEffect> =
            all.map(|f| stated.map_or((*f).clone(), |stated| whole(f, stated))).collect();
        let mean = (0..found.effect.values.len())
            .map(|v| all.iter().map(|f| f.effect.values[v]).sum::<f64>() / all.len() as f64)
            .collect();
        let effect = Effect { values: mean, ..found.effect.clone() };
        add(&mut effects, ModelEffect { effect, scope: Scope::Log }, EffectOrigin::PerLog(all));
    }
    // Whoever zeroes an instrument zeroes it at every joint.
    let kinds = own.iter().filter(|f| is_renewed(&f.effect)).map(|f| f.effect.kind);
    for kind in kinds {
        for other in kind.places().into_iter().map(|at| kind.neutral(at)).filter(is_renewed) {
            let entry = ModelEffect { effect: other, scope: Scope::Log };
            let entries = std::slice::from_ref(&entry);
            let sorted = SortedEffects::new(entries, &problem.declared, None);
            let shows = !calibration::per_log(problem, &sorted.per_log).free.is_empty();
            if shows && !effects.iter().any(|(e, _)| e.effect.place() == entry.effect.place()) {
                effects.push((entry, EffectOrigin::Renewed));
            }
        }
    }
    effects.into_iter().unzip()
}

/// Adds an effect to those of a model, in place of the one that it replaces.
fn add(effects: &mut Vec<(ModelEffect, EffectOrigin)>, entry: ModelEffect, origin: EffectOrigin) {
    let is_replaced = |e: &ModelEffect| match entry.scope {
        Scope::Log => e.scope == Scope::Log,
        // The user's own that were hypotheses, and factors that were found beforehand, come back with
        // their fitted values.
        Scope::Campaign => is_hypothesis(e) || is_found_factor(e),
    };
    match effects
        .iter_mut()
        .find(|(e, _)| e.effect.place() == entry.effect.place() && is_replaced(e))
    {
        Some(replaced) => *replaced = (entry, origin),
        None => effects.push((entry, origin)),
    }
}

/// All of what a log has, of which `found` was fitted to it.
fn whole(found: &FittedEffect, stated: &PerLogEffect) -> FittedEffect {
    let effect = stated.whole(&found.effect);
    let moved = effect.values.iter().zip(&found.effect.values).map(|(all, own)| all - own);
    let interval = found.interval.iter().zip(moved);
    let interval = interval.map(|([low, high], by)| [low + by, high + by]).collect();
    FittedEffect { effect, interval, ..found.clone() }
}

/// True for a calibration that another log has anew.
pub(crate) fn is_renewed(effect: &Effect) -> bool {
    effect.kind.calibration.is_some_and(|c| c.renewed(effect.at).is_some())
}

/// True for a factor as it was found before anything was fitted.
fn is_found_factor(entry: &ModelEffect) -> bool {
    let Effect { kind, at, values } = &entry.effect;
    is_open_factor(kind) && values[1..] == kind.neutral(*at).values[1..]
}

/// True for an effect of the user's own that does nothing as it is written.
fn is_hypothesis(entry: &ModelEffect) -> bool {
    entry.scope == Scope::Campaign && fit::is_own_and_nothing(&entry.effect)
}
