//! Adds what is missing to a model, step by step: each step is kept only if it lowers the error
//! where nothing was fitted, and if the arm with it stays stable.
//!
//! First what recalibration alone can do, then the effects that [`crate::diagnose`] names, each
//! step with everything refitted and those calibrations kept that count; then, where these do not
//! reach the floor, further ones as long as each counts, and where the library has none a law outside
//! it.

use crate::data::log::Log;
use crate::diagnose::{
    self, Context, Diagnosis, FittedEffect, Progress, Undone, Verdict, fits_anything, further,
    longest_weld, refit, rules, score, sparse,
};
use crate::discover::{self, Discovery, discover};
use crate::fit::calibration::is_calibration;
use crate::fit::per_log;
use crate::fit::{self, Effort, FitProblem, FitState, Fitted, Residuals};
use crate::predict::{Experiment, PredictError};
use crate::residuals::compare::{LogComparison, of_logs};
use crate::residuals::localize::localize;
use trueweld_core::JointVector;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{ModelEffect, ModelFile, Scope};
use trueweld_plant::integrate::link_dynamics::{DynamicLinks, Motors};
use trueweld_plant::integrate::substeps;
use trueweld_plant::robot::ElasticRobot;

/// One accepted step.
#[derive(Debug, Clone)]
pub struct Step {
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
    /// The arm with it does not come to rest.
    Unstable,
}

/// A model improved.
#[derive(Debug)]
pub struct Improvement {
    /// Accepted steps, the model as it was given first.
    pub steps: Vec<Step>,
    /// What was tried and not kept.
    pub rejected: Vec<Rejected>,
    /// What is to say of the improved model.
    pub verdict: Verdict,
    /// Laws outside the library that were found.
    pub discovered: Vec<Discovery>,
    /// The diagnosis it rests on; what stays unexplained is that of the improved model.
    pub diagnosis: Diagnosis,
    /// The improved model's fit; `None` where the model stays as it was given.
    pub fitted: Option<Fitted>,
    /// Names of the logs that were held out; none where blocks in time were.
    pub held_out_logs: Vec<String>,
}

impl Improvement {
    /// Effects that the data do not tell from those of a step; none where it is not the explanation
    /// of the diagnosis.
    pub fn others(&self, step: &Step) -> Vec<&Effect> {
        let place = |f: &FittedEffect| (f.effect.kind.id, f.effect.at);
        let candidates = &self.diagnosis.candidates;
        let same = |best: &&diagnose::Candidate| {
            !step.added.is_empty()
                && best.effects.iter().all(|f| step.effects.iter().any(|e| place(e) == place(f)))
        };
        candidates.first().filter(same).map_or(Vec::new(), |best| best.others(candidates))
    }
}

/// Logs that nothing is fitted to, made ready.
#[derive(Debug)]
pub struct HeldOut {
    /// The baseline over these logs.
    bench: FitProblem,
    /// Their names.
    names: Vec<String>,
}

impl HeldOut {
    /// Logs to judge a model by, and the experiments made of them.
    pub fn new(file: &ModelFile, logs: &[Log], experiments: Vec<Experiment>) -> Self {
        let (known, per_log, own) = (Vec::new(), Vec::new(), Vec::new());
        let bench = FitProblem { known, per_log, own, ..FitProblem::new(file, experiments) };
        Self { bench, names: logs.iter().map(|l| l.name.clone()).collect() }
    }

    /// These logs under the model of a fit to other logs of `bench`; `None`: as it was given. `logs`:
    /// those that this was made of.
    ///
    /// # Errors
    /// [`PredictError`] where the model cannot be driven through them.
    pub fn compare(
        &self,
        logs: &[Log],
        bench: &FitProblem,
        fitted: Option<&Fitted>,
    ) -> Result<Vec<LogComparison>, PredictError> {
        let given = FitState::empty(bench.experiments.len());
        let at = elsewhere(bench, self, fitted.map_or(&given, |fitted| &fitted.point))?;
        Ok(of_logs(logs, &self.bench.experiments, &at))
    }
}

/// Steps at most, the first not counted.
const MOST: usize = 8;

/// Fall of the held-out score by less than this share is no improvement.
const LEAST: f64 = 2e-3;

/// Share by which the squared errors of the channels must fall on average, each in what it was,
/// where the score as a whole, which the worst channel rules, hardly sees it.
const LEAST_BY_CHANNEL: f64 = 0.02;

/// Improves the bench's model. `logs`: those that its experiments were made of; `held_out`: where
/// every step is judged, in place of blocks in time of the same logs.
///
/// # Errors
/// [`PredictError`] where the model as given cannot be driven through the logs.
pub fn improve(
    bench: &FitProblem,
    logs: &[Log],
    held_out: Option<&HeldOut>,
    progress: Progress<'_>,
) -> Result<Improvement, PredictError> {
    let mut diagnosis =
        diagnose::diagnose(bench, logs, &|what, share| progress(what, 0.6 * share))?;
    let discovered =
        discover(bench, logs, &mut diagnosis, &|what, share| progress(what, 0.6 + 0.1 * share));
    let blocks = fit::blocks_of(bench);
    let at_held_out = held_out
        .map(|h| elsewhere(bench, h, &FitState::empty(bench.experiments.len())))
        .transpose()?;
    let start = at_held_out.as_ref().map_or(diagnosis.score_before, score);
    let baseline = Step {
        added: Vec::new(),
        effects: Vec::new(),
        calibration: Vec::new(),
        score: diagnosis.score_before,
        held_out: start,
    };
    let mut path = Path {
        bench,
        logs,
        blocks: &blocks,
        held_out,
        steps: vec![baseline],
        rejected: Vec::new(),
        discovered,
        at_held_out,
        reached: None,
    };
    progress("recalibrating", 0.7);
    if !diagnosis.null.point.free.is_empty() {
        let alone = diagnosis.chosen.is_empty() && path.discovered.is_empty();
        let kept = if alone {
            diagnosis.improved.clone()
        } else {
            sparse(bench, &blocks, &diagnosis.null).0
        };
        path.try_step(kept, Some(&diagnosis.null));
    }
    // What was found outside the library stands in the place of what explains a part within.
    let outside = !path.discovered.is_empty();
    if outside {
        progress("adding what was found", 0.75);
        path.try_step(diagnosis.improved.clone(), Some(&diagnosis.full));
    }
    for (k, full) in diagnosis.chosen.iter().enumerate().filter(|_| !outside) {
        progress("adding what was found", 0.75 + 0.05 * k as f64);
        // The last of them is what the diagnosis keeps.
        let last = k + 1 == diagnosis.chosen.len();
        let kept = if last { diagnosis.improved.clone() } else { sparse(bench, &blocks, full).0 };
        path.try_step(kept, Some(full));
    }
    // A partial explanation is carried on as far as it goes.
    let mut further = false;
    while diagnosis.verdict == Verdict::UnknownEffect
        && path.steps.len() <= MOST
        && !bench.is_late()
    {
        progress("looking for more", 0.85 + 0.15 * path.steps.len() as f64 / MOST as f64);
        if !path.further(longest_weld(logs)) {
            break;
        }
        further = true;
    }
    if let Some(mut whole) = path.reached.clone().filter(|_| further) {
        // What was found one after the other, fitted together.
        refit(bench, &blocks, &mut whole, Effort::full(0));
        path.try_step(whole, None);
    }
    let Path { steps, rejected, mut discovered, reached, .. } = path;
    // The values of the improved model, where all were fitted together once more.
    for law in &mut discovered {
        let own = &law.effect.effect;
        let same =
            |f: &&FittedEffect| std::ptr::eq(f.effect.kind, own.kind) && f.effect.at == own.at;
        if let Some(last) = steps.last().and_then(|step| step.effects.iter().find(same)) {
            law.effect = last.clone();
        }
    }
    let verdict = match &reached {
        Some(fitted)
            if diagnosis.verdict == Verdict::UnknownEffect
                && discovered.is_empty()
                && rules::at_floor(bench, &fitted.at)
                && !fits_anything(bench, fitted) =>
        {
            // Where only calibrations were kept, nothing else was missing.
            match steps.iter().all(|step| step.added.is_empty()) {
                true => Verdict::Adequate,
                false => Verdict::EffectFound,
            }
        }
        _ => diagnosis.verdict,
    };
    if let Some(fitted) = reached.as_ref().filter(|f| !rules::at_floor(bench, &f.at)) {
        diagnosis.unexplained = localize(&bench.experiments, &fitted.at, logs);
    }
    let told = diagnosis.undone.iter().any(|undone| matches!(undone, Undone::Further));
    if bench.is_late() && verdict == Verdict::UnknownEffect && !told {
        diagnosis.undone.push(Undone::Further);
    }
    let held_out_logs = held_out.map_or(Vec::new(), |h| h.names.clone());
    let fitted = reached;
    Ok(Improvement { steps, rejected, verdict, discovered, diagnosis, fitted, held_out_logs })
}

/// The effects that a step has for the first time; a joint may have several of one kind.
fn added(before: &[FittedEffect], now: &[FittedEffect]) -> Vec<FittedEffect> {
    let place = |f: &FittedEffect| (f.effect.kind.id, f.effect.at);
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
struct Path<'a> {
    bench: &'a FitProblem,
    logs: &'a [Log],
    blocks: &'a [Vec<u8>],
    held_out: Option<&'a HeldOut>,
    steps: Vec<Step>,
    rejected: Vec<Rejected>,
    discovered: Vec<Discovery>,
    /// Residuals of the logs held out under the model reached.
    at_held_out: Option<Residuals>,
    reached: Option<Fitted>,
}

impl Path<'_> {
    /// Takes a step to a fit if it is one forward. `full`: the fit with every calibration free, of
    /// which this keeps those that count; intervals allow for the others where it is there.
    fn try_step(&mut self, fitted: Fitted, full: Option<&Fitted>) -> bool {
        self.try_step_by(fitted, full, false)
    }

    /// The same; `by_channel`: also where the score does not rise, and the error falls with every
    /// channel weighed alike. Fits to blocks left out have shown that before.
    fn try_step_by(&mut self, fitted: Fitted, full: Option<&Fitted>, by_channel: bool) -> bool {
        let all = match full {
            Some(full) => diagnose::found_beside(self.bench, &fitted, full, |_| true),
            None => self.found(&fitted),
        };
        let (calibration, effects): (Vec<FittedEffect>, Vec<FittedEffect>) =
            all.into_iter().partition(|f| is_calibration(f.effect.kind));
        let added = added(self.steps.last().map_or(&[], |s| &s.effects), &effects);
        let before = self.steps.last().map_or(f64::INFINITY, |s| s.held_out);
        let at_held_out = self
            .held_out
            .map(|held_out| elsewhere(self.bench, held_out, &fitted.point))
            .transpose();
        let judged = at_held_out.as_ref().map(|at| match (self.held_out, at, &self.at_held_out) {
            (Some(held_out), Some(at), Some(before)) => {
                let falls = change_by_channel(&held_out.bench, before, at) < 1.0 - LEAST_BY_CHANNEL;
                (score(at), falls)
            }
            _ => (rules::held_out_score(&fitted), true),
        });
        let (held_out, why) = match judged {
            Err(_) => (f64::NAN, Some(Rejection::NotPredicted)),
            Ok((score, falls))
                if score > before * (1.0 - LEAST)
                    && !(by_channel && falls && score < before * (1.0 + LEAST)) =>
            {
                (score, Some(Rejection::NoGain))
            }
            Ok((score, _)) if !stable(self.bench, self.logs, &fitted.point) => {
                (score, Some(Rejection::Unstable))
            }
            Ok((score, _)) => (score, None),
        };
        match why {
            Some(why) => self.rejected.push(Rejected { added, held_out, why }),
            None => {
                self.steps.push(Step {
                    added,
                    effects,
                    calibration,
                    score: score(&fitted.at),
                    held_out,
                });
                self.at_held_out = at_held_out.ok().flatten();
                self.reached = Some(fitted);
            }
        }
        why.is_none()
    }

    /// Fitted effects with their intervals. Where something is left that stands out, each channel is
    /// weighed by what is left in it: one that no model explains says little of the values that others tell.
    fn found(&self, fitted: &Fitted) -> Vec<FittedEffect> {
        let plain = || diagnose::found(self.bench, fitted, |_| true);
        if rules::at_floor(self.bench, &fitted.at) {
            return plain();
        }
        let bench = inflate_noise(self.bench, &fitted.at);
        match fit::fit(&bench, &fitted.point, self.blocks, &[], Effort::steps(0, 0)) {
            Ok(weighed) => diagnose::found_on_the_way(&bench, &weighed),
            Err(_) => plain(),
        }
    }

    /// Adds one more effect where the explanation is a partial one: of the library, and where it
    /// has none a law outside it. What no model explains yet is no noise that instruments state:
    /// every channel is weighed by what is left in it, so that the worst does not hide the others,
    /// and the values found before stay, so that none is spent on it.
    fn further(&mut self, length: f64) -> bool {
        let empty = FitState::empty(self.bench.experiments.len());
        let point = self.reached.as_ref().map_or(empty, |f| f.point.clone());
        let held = FitState { free: Vec::new(), ..point.clone() };
        let nothing_free = Effort::steps(0, 0);
        let Ok(plain) = fit::fit(self.bench, &held, self.blocks, &[], nothing_free) else {
            return false;
        };
        if rules::at_floor(self.bench, &plain.at) {
            return false;
        }
        let inflate_noise = inflate_noise(self.bench, &plain.at);
        let Ok(null) = fit::fit(&inflate_noise, &held, self.blocks, &[], nothing_free) else {
            return false;
        };
        let ground = Context {
            bench: &inflate_noise,
            blocks: self.blocks,
            null: &null,
            given: &null,
            length,
        };
        let Self { bench, logs, blocks, .. } = *self;
        let mut takes = |next: &Fitted| {
            let mut whole = next.point.clone();
            whole.free = point.free.iter().chain(&next.point.free).copied().collect();
            let fitted = fit::fit(bench, &whole, blocks, &[], nothing_free);
            fitted.is_ok_and(|fitted| self.try_step_by(fitted, None, true))
        };
        if further(&ground, &null).iter().any(&mut takes) {
            return true;
        }
        let Some(law) = discover::beside(&inflate_noise, blocks, logs, &null, takes) else {
            return false;
        };
        let [.., before, after] = self.steps.as_slice() else { return true };
        let (held_out_before, held_out_after) = (before.held_out, after.held_out);
        self.discovered.push(Discovery { held_out_before, held_out_after, ..law });
        true
    }
}

/// Residuals of a model on other logs; what each log has of its own is found there.
fn elsewhere(
    bench: &FitProblem,
    held_out: &HeldOut,
    point: &FitState,
) -> Result<Residuals, PredictError> {
    let mut own: Vec<Effect> = bench.per_log.clone();
    for effect in point.each.iter().flatten() {
        if !own.iter().any(|e| (e.kind.id, e.at) == (effect.kind.id, effect.at)) {
            own.push(effect.clone());
        }
    }
    let all = [bench.known.clone(), point.all.clone()].concat();
    Ok(per_log::fitted(&held_out.bench, &own, all)?.1)
}

/// Squared errors of the channels after a change, each over what it was, on average by samples.
fn change_by_channel(bench: &FitProblem, before: &Residuals, after: &Residuals) -> f64 {
    let (before, after) = (diagnose::parts(bench, before), diagnose::parts(bench, after));
    let (mut sum, mut count) = (0.0, 0.0);
    for (channel, was) in &before {
        let now = after.get(channel).map_or(was.square, |part| part.square);
        sum += was.count as f64 * now / was.square.max(f64::MIN_POSITIVE);
        count += was.count as f64;
    }
    sum / count
}

/// The same logs, with each channel's noise as large as what these residuals leave of it.
fn inflate_noise(bench: &FitProblem, at: &Residuals) -> FitProblem {
    let parts = diagnose::parts(bench, at);
    let factor = |log: usize, channel: &'static str| {
        parts
            .get(&(log, channel))
            .map_or(1.0, |p| (p.square / p.count.max(1) as f64).sqrt().max(1.0))
    };
    let inflate_noise =
        |(log, e): (usize, &Experiment)| e.inflate_noise(|channel| factor(log, channel));
    let experiments = bench.experiments.iter().enumerate().map(inflate_noise).collect();
    FitProblem { deadline: bench.deadline, ..bench.on(experiments) }
}

/// True where the arm, struck in every joint at a posture of the logs, comes to rest.
fn stable(bench: &FitProblem, logs: &[Log], point: &FitState) -> bool {
    const STRUCK: f64 = 1e-3;
    const PERIOD: f64 = 1e-3;
    const STEP: f64 = 2.5e-4;
    let effects: Vec<Effect> = bench.known.iter().chain(&point.all).cloned().collect();
    let mut process = bench.model.process.clone();
    let Ok(robot) = ElasticRobot::with_effects(&bench.model.robot, &effects, process.as_mut())
    else {
        return false;
    };
    logs.iter().filter_map(|log| log.samples.encoder.first()).all(|posture| {
        let Ok(substeps) = substeps(&robot, [*posture], PERIOD, STEP) else { return false };
        let mut swinging = DynamicLinks::start(&robot, &Motors::at_rest(*posture), 0.0);
        let motors = Motors::at_rest(posture + JointVector::repeat(STRUCK));
        // Hardest in the first tenth of two seconds; what is left of it in the last.
        let (mut first, mut last) = (0.0f64, 0.0f64);
        for k in 1..=2000 {
            if swinging.advance(&robot, &motors, f64::from(k) * PERIOD, substeps).is_err() {
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
pub enum Origin {
    /// The model as it was given.
    Given,
    /// The fit to all logs.
    Fitted(FittedEffect),
    /// A fit to each log alone; the model has the mean.
    PerLog(Vec<FittedEffect>),
}

/// The improved model as a file, and where each of its effects comes from, in its order.
pub fn model_file(improvement: &Improvement, file: &ModelFile) -> (ModelFile, Vec<Origin>) {
    let last = &improvement.steps[improvement.steps.len() - 1];
    let mut origins = vec![Origin::Given; file.effects.len()];
    let mut improved = ModelFile { posterior: None, ..file.clone() };
    // The user's own that were hypotheses come back with their fitted values.
    let mut add = |effect: Effect, scope: Scope, origin: Origin| {
        let place = improved
            .effects
            .iter()
            .position(|e| std::ptr::eq(e.effect.kind, effect.kind) && e.effect.at == effect.at);
        let entry = ModelEffect { effect, scope };
        match place.filter(|p| scope == Scope::Log || is_hypothesis(&improved.effects[*p])) {
            Some(place) => {
                improved.effects[place] = entry;
                origins[place] = origin;
            }
            None => {
                improved.effects.push(entry);
                origins.push(origin);
            }
        }
    };
    let (own, common): (Vec<&FittedEffect>, Vec<&FittedEffect>) =
        last.effects.iter().chain(&last.calibration).partition(|f| f.log.is_some());
    for found in common {
        add(found.effect.clone(), Scope::Campaign, Origin::Fitted(found.clone()));
    }
    for (k, found) in own.iter().enumerate() {
        let same = |f: &&&FittedEffect| {
            (f.effect.kind.id, f.effect.at) == (found.effect.kind.id, found.effect.at)
        };
        if own[..k].iter().any(|f| same(&f)) {
            continue;
        }
        let all: Vec<FittedEffect> = own.iter().filter(same).map(|f| (*f).clone()).collect();
        let mean = (0..found.effect.values.len())
            .map(|v| all.iter().map(|f| f.effect.values[v]).sum::<f64>() / all.len() as f64)
            .collect();
        let effect = Effect { values: mean, ..found.effect.clone() };
        add(effect, Scope::Log, Origin::PerLog(all));
    }
    (improved, origins)
}

/// True for an effect of the user's own that does nothing as it is written.
fn is_hypothesis(entry: &ModelEffect) -> bool {
    entry.scope == Scope::Campaign && fit::is_own_and_nothing(&entry.effect)
}
