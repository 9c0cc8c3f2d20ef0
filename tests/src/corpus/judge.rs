//! What an answer is worth against the truth.

use super::Hidden;
use crate::campaign::Recipe;
use serde::{Deserialize, Serialize};
use trueweld_measure::diagnose::{Candidate, Diagnosis, Verdict};
use trueweld_plant::effects::{At, Effect};

/// What came of one case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Outcome {
    /// One effect: named, at its place. Two: both. Nothing: adequate. Outside the library: called unknown.
    Right,
    /// Named another that the data do not tell from the truth, and said so.
    RightTie,
    /// The truth is a calibration and is reported as one, beside others that are there as well.
    RightAsCalibration,
    /// The truth and a second effect that is not there.
    RightAndMore,
    /// The right effect at another place.
    WrongPlace,
    /// An effect that is not there.
    WrongEffect,
    /// One of two, or one of two and another that is not there.
    OneOfTwo,
    /// Adequate, though something is hidden.
    Missed,
    /// Unknown, though the library has it, or nothing is there.
    SaidUnknown,
    /// An effect of the library for something outside it.
    NamedSomething,
    /// An effect where there is none.
    FalseAlarm,
}

type Key = (&'static str, At);

fn key(effect: &Effect) -> Key {
    (effect.kind.id, effect.at)
}

fn keys(candidate: &Candidate) -> Vec<Key> {
    candidate.effects.iter().map(|f| key(&f.effect)).collect()
}

/// Judges a diagnosis of the campaign of `recipe`, in which `hidden` is hidden.
pub fn judge(hidden: &Hidden, recipe: &Recipe, diagnosis: &Diagnosis) -> Outcome {
    let truth: Vec<Key> = match hidden {
        Hidden::None | Hidden::Unknown(_) => Vec::new(),
        Hidden::One(a) => vec![key(a)],
        Hidden::Two(a, b) => vec![key(a), key(b)],
    };
    let unknown = matches!(hidden, Hidden::Unknown(_));
    match diagnosis.verdict {
        Verdict::UnknownEffect if unknown => Outcome::Right,
        Verdict::UnknownEffect => Outcome::SaidUnknown,
        Verdict::Adequate => adequate(&truth, unknown, diagnosis),
        Verdict::EffectFound => match diagnosis.candidates.first() {
            // A calibration that the laboratory did get wrong is no answer, and no false one.
            Some(first) if keys(first).iter().all(|k| is_nuisance(*k, recipe) && !truth.contains(k)) => {
                adequate(&truth, unknown, diagnosis)
            }
            Some(_) if unknown => Outcome::NamedSomething,
            Some(first) => found(&truth, first, &diagnosis.candidates),
            None => Outcome::WrongEffect,
        },
    }
}

/// Nothing but calibrations was reported.
fn adequate(truth: &[Key], unknown: bool, diagnosis: &Diagnosis) -> Outcome {
    let reported = |k: &Key| diagnosis.calibration.iter().any(|f| key(&f.effect) == *k);
    if truth.is_empty() {
        if unknown { Outcome::Missed } else { Outcome::Right }
    } else if truth.iter().all(reported) {
        Outcome::RightAsCalibration
    } else {
        Outcome::Missed
    }
}

fn found(truth: &[Key], first: &Candidate, all: &[Candidate]) -> Outcome {
    let named = keys(first);
    let same = |named: &[Key]| named.len() == truth.len() && truth.iter().all(|t| named.contains(t));
    if truth.is_empty() {
        Outcome::FalseAlarm
    } else if same(&named) {
        Outcome::Right
    } else if first.indistinguishable.iter().any(|k| same(&keys(&all[*k]))) {
        Outcome::RightTie
    } else if truth.len() == 2 {
        if truth.iter().any(|t| named.contains(t)) { Outcome::OneOfTwo } else { Outcome::WrongEffect }
    } else if named.contains(&truth[0]) {
        Outcome::RightAndMore
    } else if named.iter().any(|n| n.0 == truth[0].0) {
        Outcome::WrongPlace
    } else {
        Outcome::WrongEffect
    }
}

/// True for a calibration that the laboratory of a recipe got wrong.
fn is_nuisance((id, at): Key, recipe: &Recipe) -> bool {
    match (id, at) {
        ("stiffness-error", At::Joint(i)) => recipe.stiffness_error[i] != 0.0,
        ("encoder-offset", At::Joint(i)) => recipe.encoder_offset[i] != 0.0,
        ("tracker-registration", _) => recipe.registration_per_log != 0.0,
        _ => false,
    }
}
