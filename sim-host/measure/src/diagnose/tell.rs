//! What is told of a diagnosis beside its figures: why its leading explanations are believed, the
//! curves that show them, and what to record next where the logs leave a doubt.
//!
//! Apart from the search, since many diagnoses need none of it.

use super::{Candidate, Diagnosis, Progress, Verdict};
use crate::data::log::Log;
use crate::diagnose::evidence::{EffectCurve, ExplainedCase, evidence, explain};
use crate::experiment::{Plan, next_experiment};
use crate::fit::FitProblem;
use rayon::prelude::*;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::RobotFile;

/// Explanations whose curves are drawn: the first so many.
const DRAWN: usize = 3;

/// Explanations that an experiment is to tell apart, at most.
const RIVALS: usize = 3;

/// Probability of the best explanation from which on no further experiment is asked for.
const SURE: f64 = 0.9;

/// What is told of a diagnosis.
#[derive(Debug, Clone)]
pub struct Explanation {
    /// Of its candidates, in their order.
    pub reasons: Vec<Reason>,
    /// What to record to tell the leading explanations apart, where they are not.
    pub next_experiment: Option<Plan>,
}

/// Why an explanation is believed.
#[derive(Debug, Clone)]
pub struct Reason {
    /// In words.
    pub explanation: String,
    /// The curve that shows each of its effects, in their order; `None` where the logs draw none.
    /// Of the first explanations only.
    pub evidence: Vec<Option<EffectCurve>>,
}

/// Tells of a diagnosis. `bench` and `logs`: those it was made from.
pub fn tell(
    bench: &FitProblem,
    logs: &[Log],
    diagnosis: &Diagnosis,
    progress: Progress<'_>,
) -> Explanation {
    progress("drawing the evidence", 0.0);
    let Some(robot) = logs.first().map(|log| &log.robot) else {
        return Explanation { reasons: Vec::new(), next_experiment: None };
    };
    let all = diagnosis.candidates.par_iter().enumerate();
    let reasons = all.map(|(k, c)| reason(bench, logs, diagnosis, (c, k < DRAWN), robot)).collect();
    progress("planning the next experiment", 0.6);
    let rivals = rivals(diagnosis, robot);
    let next_experiment =
        if rivals.is_empty() { None } else { next_experiment(bench, logs, &rivals) };
    Explanation { reasons, next_experiment }
}

fn reason(
    bench: &FitProblem,
    logs: &[Log],
    diagnosis: &Diagnosis,
    (candidate, drawn): (&Candidate, bool),
    robot: &RobotFile,
) -> Reason {
    let curve = |effect: &Effect| evidence(bench, logs, &diagnosis.null, &candidate.fitted, effect);
    let others: Vec<(&str, &str)> = candidate
        .others(&diagnosis.candidates)
        .iter()
        .map(|effect| (effect.kind.id, effect.at_name(robot)))
        .collect();
    Reason {
        explanation: explain(&ExplainedCase {
            robot,
            bench,
            effects: &candidate.effects,
            before: &diagnosis.null.at,
            after: &candidate.fitted.at,
            held_out: [candidate.held_out_before, candidate.held_out_after],
            probability: candidate.probability,
            others: &others,
        }),
        evidence: candidate
            .effects
            .iter()
            .filter(|_| drawn)
            .map(|found| curve(&found.effect))
            .collect(),
    }
}

/// The explanations that an experiment is worth making for: those tied with the best, or else those
/// after it; none where nothing is missing, where the best explains next to nothing, or stands
/// alone and sure.
fn rivals(diagnosis: &Diagnosis, robot: &RobotFile) -> Vec<(String, Vec<Effect>)> {
    let Some(best) = diagnosis.candidates.first() else {
        return Vec::new();
    };
    let tied = &best.indistinguishable;
    let sure =
        diagnosis.verdict == Verdict::EffectFound && best.probability >= SURE && tied.is_empty();
    if diagnosis.verdict == Verdict::Adequate || sure || !best.explains() {
        return Vec::new();
    }
    let beside: Vec<usize> = match tied.as_slice() {
        [] => (1..diagnosis.candidates.len()).collect(),
        tied => tied.to_vec(),
    };
    let candidates =
        std::iter::once(0).chain(beside).take(RIVALS).map(|k| &diagnosis.candidates[k]);
    candidates
        .map(|c| (c.name(robot), c.effects.iter().map(|f| f.effect.clone()).collect()))
        .collect()
}

impl Candidate {
    /// True where it takes away a tenth at least of what is above the floor.
    pub fn explains(&self) -> bool {
        self.left < 0.9
    }

    /// Its effects with their places, such as `backlash at A5`; a pair's with a plus between them.
    pub fn name(&self, robot: &RobotFile) -> String {
        let names: Vec<String> =
            self.effects.iter().map(|found| name(&found.effect, robot)).collect();
        names.join(" + ")
    }

    /// Effects of the explanations that the data do not tell from this one, without its own; each
    /// once.
    pub fn others<'c>(&self, candidates: &'c [Candidate]) -> Vec<&'c Effect> {
        let same = |a: &Effect, b: &Effect| (a.kind.id, a.at) == (b.kind.id, b.at);
        let mut others: Vec<&Effect> = Vec::new();
        for found in self
            .indistinguishable
            .iter()
            .filter_map(|k| candidates.get(*k))
            .flat_map(|c| &c.effects)
        {
            let own = self.effects.iter().any(|f| same(&f.effect, &found.effect));
            if !own && !others.iter().any(|effect| same(effect, &found.effect)) {
                others.push(&found.effect);
            }
        }
        others
    }
}

/// An effect with its place, such as `backlash at A5`.
pub fn name(effect: &Effect, robot: &RobotFile) -> String {
    match effect.at_name(robot) {
        "" => effect.kind.id.to_owned(),
        at => format!("{} at {at}", effect.kind.id),
    }
}
