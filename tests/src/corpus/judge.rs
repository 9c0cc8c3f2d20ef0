//! What an answer is worth against the truth.

use serde::{Deserialize, Serialize};
use trueweld_diagnose::{Candidate, Diagnosis, DiagnosisVerdict};
use trueweld_laboratory::{Hidden, Recipe};
use trueweld_plant::effects::{Effect, EffectPlace};

/// What came of one case, better ones first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// One effect: named, at its place. Two: both. Nothing: adequate. Outside the library: called
    /// unknown.
    Right,
    /// Named another that the data do not tell from the truth, and said so.
    RightTie,
    /// The truth is a calibration and is reported as one, beside others that are there as well.
    RightAsCalibration,
    /// The truth and another effect that is not there.
    RightAndMore,
    /// One of two, or one of two and another that is not there.
    OneOfTwo,
    /// The right effect at another place.
    WrongPlace,
    /// An effect that is not there.
    WrongEffect,
    /// Adequate, though something is hidden.
    Missed,
    /// Unknown, though the library has it, or nothing is there.
    SaidUnknown,
    /// An effect of the library for something outside it.
    NamedSomething,
    /// An effect where there is none.
    FalseAlarm,
}

fn keys(candidate: &Candidate) -> Vec<EffectPlace> {
    candidate.effects.iter().map(|f| f.effect.place()).collect()
}

/// Judges a diagnosis of the campaign of `recipe`, in which `hidden` is hidden.
pub fn judge(hidden: &Hidden, recipe: &Recipe, diagnosis: &Diagnosis) -> Outcome {
    let unknown = matches!(hidden, Hidden::Unknown(_) | Hidden::Law(_));
    let of_library = hidden.effects().into_iter().filter(|_| !unknown);
    let truth: Vec<EffectPlace> = of_library.map(Effect::place).collect();
    let reported = |k: &EffectPlace| diagnosis.calibration.iter().any(|f| f.effect.place() == *k);
    // A calibration that is reported as one is found; what is left is for the explanation to say.
    let left: Vec<EffectPlace> = truth.iter().filter(|k| !reported(k)).copied().collect();
    let adequate = || match (truth.is_empty(), left.is_empty()) {
        (true, _) if unknown => Outcome::Missed,
        (true, _) => Outcome::Right,
        (false, true) => Outcome::RightAsCalibration,
        (false, false) if left.len() < truth.len() => Outcome::OneOfTwo,
        (false, false) => Outcome::Missed,
    };
    match (diagnosis.verdict, diagnosis.candidates.first()) {
        (DiagnosisVerdict::UnknownEffect, _) if unknown => Outcome::Right,
        (DiagnosisVerdict::UnknownEffect, _) => Outcome::SaidUnknown,
        (DiagnosisVerdict::Adequate, _) | (DiagnosisVerdict::EffectFound, None) => adequate(),
        (DiagnosisVerdict::EffectFound, Some(first)) => {
            let named = keys(first);
            // A calibration that the laboratory did get wrong is no answer, and no false one.
            if named.iter().all(|k| is_nuisance(*k, recipe) && !truth.contains(k)) {
                adequate()
            } else if unknown {
                Outcome::NamedSomething
            } else if truth.is_empty() {
                Outcome::FalseAlarm
            } else {
                [&truth, &left]
                    .into_iter()
                    .map(|t| found(t, first, &diagnosis.candidates))
                    .min()
                    .expect("one of two")
            }
        }
    }
}

/// What an explanation is worth where `truth` was to be named.
fn found(truth: &[EffectPlace], first: &Candidate, all: &[Candidate]) -> Outcome {
    let named = keys(first);
    let same = |named: &[EffectPlace]| {
        named.len() == truth.len() && truth.iter().all(|t| named.contains(t))
    };
    if same(&named) {
        Outcome::Right
    } else if first.indistinguishable.iter().any(|k| same(&keys(&all[*k]))) {
        Outcome::RightTie
    } else if truth.iter().all(|t| named.contains(t)) {
        Outcome::RightAndMore
    } else if truth.iter().any(|t| named.contains(t)) {
        Outcome::OneOfTwo
    } else if truth.iter().any(|t| named.iter().any(|n| n.kind.id == t.kind.id)) {
        Outcome::WrongPlace
    } else {
        Outcome::WrongEffect
    }
}

/// True for a calibration that the laboratory of a recipe got wrong.
fn is_nuisance(named: EffectPlace, recipe: &Recipe) -> bool {
    recipe.miscalibrations(0).iter().any(|effect| effect.place() == named)
}
