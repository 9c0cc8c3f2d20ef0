//! What is told of a diagnosis beside its figures: why its leading explanations are believed, the
//! curves that show them, and what to record next where the logs leave a doubt.
//!
//! Apart from the search, since many diagnoses need none of it.

use crate::diagnosis::{
    Candidate, Diagnosed, Diagnosis, DiagnosisFits, DiagnosisVerdict, ProgressCallback,
};
use crate::evidence::{EffectCurve, evidence};
use crate::experiment::RIVALS_MAX;
use crate::experiment::{Plan, next_experiment};
use crate::found::FittedEffect;
use crate::rules::{self, NAMED, UNNAMED_PROBABILITY_MAX, parts};
use rayon::prelude::*;
use std::collections::BTreeMap;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{FitProblem, Residuals};
use trueweld_logs::log::{Log, LogKind};
use trueweld_plant::effects::Effect;
use trueweld_plant::input::RobotFile;

/// Explanations whose curves are drawn: the first so many.
const DRAWN_EXPLANATIONS: usize = 3;

/// What is told of a diagnosis.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// Of its candidates, in their order.
    pub reasons: Vec<ExplanationReason>,
    /// What to record to tell the leading explanations apart, where they are not.
    pub next_experiment: Option<Plan>,
}

/// Why an explanation is believed.
#[derive(Debug, Clone)]
pub struct ExplanationReason {
    /// What it improves most; `None` where it improves no channel.
    pub improved: Option<ImprovedChannel>,
    /// The curve that shows each of its effects, in their order; `None` where the logs draw none.
    /// Of the first explanations only.
    pub evidence: Vec<Option<EffectCurve>>,
}

/// The channel of one kind of logs that an explanation improves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImprovedChannel {
    /// Kind of the logs.
    pub kind: LogKind,
    /// The channel, as in a comparison.
    pub channel: &'static str,
    /// Its error over the noise with calibrations alone.
    pub before: f64,
    /// Its error over the noise with the explanation.
    pub after: f64,
}

/// Tells of a diagnosis. `problem` and `logs`: those it was made from.
pub fn explain(
    problem: &FitProblem,
    logs: &[Log],
    Diagnosed { diagnosis, fits }: &Diagnosed,
    progress: ProgressCallback<'_>,
) -> Explanation {
    progress("drawing the evidence", 0.0);
    let Some(robot) = logs.first().map(|log| &log.robot) else {
        return Explanation { reasons: Vec::new(), next_experiment: None };
    };
    let all = (0..diagnosis.candidates.len()).into_par_iter();
    let reasons = all
        .map(|k| reason(problem, logs, (diagnosis, fits), (k, k < DRAWN_EXPLANATIONS)))
        .collect();
    progress("planning the next experiment", 0.6);
    let rivals = rivals(diagnosis, robot);
    let mut next_experiment =
        if rivals.is_empty() { None } else { next_experiment(problem, logs, &rivals) };
    // The fits in full say more of the logs so far than what is left from where they end.
    let cost = |name: &String| {
        let of = diagnosis.candidates.iter().position(|c| c.name(robot) == *name);
        of.map(|k| fits.candidates[k].cost)
    };
    if let Some(plan) = &mut next_experiment
        && let [Some(first), Some(second)] = plan.rivals.each_ref().map(cost)
    {
        plan.so_far = second - first;
    }
    Explanation { reasons, next_experiment }
}

/// Why the best explanation is believed, without what else [`explain`] tells; none where there is
/// no explanation.
pub fn reason_of_best(
    problem: &FitProblem,
    logs: &[Log],
    diagnosis: &Diagnosis,
    fits: &DiagnosisFits,
) -> Option<ExplanationReason> {
    let any = !diagnosis.candidates.is_empty();
    any.then(|| reason(problem, logs, (diagnosis, fits), (0, true)))
}

fn reason(
    problem: &FitProblem,
    logs: &[Log],
    (diagnosis, fits): (&Diagnosis, &DiagnosisFits),
    (candidate, drawn): (usize, bool),
) -> ExplanationReason {
    let (candidate, fitted) = (&diagnosis.candidates[candidate], &fits.candidates[candidate]);
    let curve = |effect: &Effect| evidence(problem, logs, &fits.null, fitted, effect);
    // A calibration is what the model without any is judged by.
    let calibrated = !candidate.effects.iter().all(|f| is_calibration(f.effect.kind));
    let without = if calibrated { &fits.null.residuals } else { &fits.before };
    ExplanationReason {
        improved: improved(problem, without, &fitted.residuals),
        evidence: candidate
            .effects
            .iter()
            .filter(|_| drawn)
            .map(|found| curve(&found.effect))
            .collect(),
    }
}

/// The kind of logs and the channel whose sum of squares falls most.
fn improved(
    problem: &FitProblem,
    before: &Residuals,
    after: &Residuals,
) -> Option<ImprovedChannel> {
    let mut sums: BTreeMap<(usize, &'static str), [f64; 3]> = BTreeMap::new();
    for (which, residuals) in [before, after].into_iter().enumerate() {
        for ((log, channel), part) in parts(problem, residuals) {
            let kind = problem.logs[log].kind;
            let place = LogKind::ALL.iter().position(|k| *k == kind).unwrap_or(0);
            let sum = sums.entry((place, channel)).or_default();
            sum[which] += part.square;
            sum[2] += if which == 0 { part.count as f64 } else { 0.0 };
        }
    }
    let ((place, channel), [before, after, count]) =
        sums.into_iter().max_by(|a, b| (a.1[0] - a.1[1]).total_cmp(&(b.1[0] - b.1[1])))?;
    let error = |square: f64| (square / count).sqrt();
    (before > after).then(|| ImprovedChannel {
        kind: LogKind::ALL[place],
        channel,
        before: error(before),
        after: error(after),
    })
}

/// The explanations that an experiment is worth making for: those tied with the best, or else those
/// after it; none where nothing is missing, where the best explains next to nothing, or stands
/// alone and sure.
fn rivals(diagnosis: &Diagnosis, robot: &RobotFile) -> Vec<(String, Vec<Effect>)> {
    let Some(best) = diagnosis.candidates.first() else {
        return Vec::new();
    };
    let tied = &best.indistinguishable;
    let sure = diagnosis.verdict == DiagnosisVerdict::EffectFound
        && best.probability >= NAMED
        && tied.is_empty();
    if diagnosis.verdict == DiagnosisVerdict::Adequate || sure || !best.explains() {
        return Vec::new();
    }
    let beside: Vec<usize> = match tied.as_slice() {
        [] => (1..diagnosis.candidates.len()).collect(),
        tied => tied.to_vec(),
    };
    let candidates =
        std::iter::once(0).chain(beside).take(RIVALS_MAX).map(|k| &diagnosis.candidates[k]);
    candidates
        .map(|c| (c.name(robot), c.effects.iter().map(|f| f.effect.clone()).collect()))
        .collect()
}

impl Diagnosis {
    /// True where the likeliest explanation, with those that the data do not tell from it, is not named
    /// for faintness alone.
    pub fn is_faint(&self) -> bool {
        let Some(best) = self.candidates.first() else { return false };
        let tied = best.indistinguishable.iter().map(|k| self.candidates[*k].probability);
        self.verdict == DiagnosisVerdict::UnknownEffect
            && best.may_be_named
            && best.probability + tied.sum::<f64>() > UNNAMED_PROBABILITY_MAX
    }

    /// Score on held-out blocks without what is missing: with calibrations alone, or, where a
    /// calibration is the answer, of the model as it was given.
    pub fn held_out_without(&self) -> f64 {
        match self.verdict {
            DiagnosisVerdict::EffectFound if self.chosen == 0 => self.score_before,
            _ => self.held_out_calibrated,
        }
    }
}

impl Candidate {
    /// True where it may be named, and takes away a tenth at least of what is above the floor.
    pub fn explains(&self) -> bool {
        self.may_be_named && self.left < 0.9
    }

    /// True where not so many others explain the data as well that it is none to be named.
    pub fn is_likely(&self) -> bool {
        self.may_be_named && self.probability >= rules::LEAST_LIKELY && !self.has_unseen_wave()
    }

    /// True where one of its effects is a wave that the logs do not tell to be one.
    pub fn has_unseen_wave(&self) -> bool {
        self.effects.iter().any(FittedEffect::is_unseen_wave)
    }

    /// Its effects with their places, such as `backlash at A5`; a pair's with a plus between them.
    pub fn name(&self, robot: &RobotFile) -> String {
        let names: Vec<String> =
            self.effects.iter().map(|found| found.effect.name(robot)).collect();
        names.join(" + ")
    }

    /// Effects of the explanations that the data do not tell from this one, without its own; each
    /// once.
    pub fn others<'c>(&self, candidates: &'c [Candidate]) -> Vec<&'c Effect> {
        let mut others: Vec<&Effect> = Vec::new();
        for found in self
            .indistinguishable
            .iter()
            .filter_map(|k| candidates.get(*k))
            .flat_map(|c| &c.effects)
        {
            let own = self.effects.iter().any(|f| f.effect.place() == found.effect.place());
            if !own && !others.iter().any(|effect| effect.place() == found.effect.place()) {
                others.push(&found.effect);
            }
        }
        others
    }
}
