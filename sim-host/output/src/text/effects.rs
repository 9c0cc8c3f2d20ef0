//! What is said of effects that were found: each effect's own sentence, filled in with its fitted
//! values, and why it is believed.

use super::{Scale, fixed, listed, probability, score, score_change};
use trueweld_diagnose::{Candidate, ExplanationReason, FittedEffect};
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::Location;
use trueweld_plant::input::RobotFile;
use trueweld_plant::robot::Channel;

/// Two sentences on an explanation: what is there, of which size, and which channel it improves;
/// then how sure that is, and its mark in the data. `all`: the explanations that it is one of.
pub(crate) fn explanation(
    candidate: &Candidate,
    all: &[Candidate],
    reason: &ExplanationReason,
    robot: &RobotFile,
) -> String {
    let found: Vec<String> = candidate.effects.iter().map(|f| statement(f, robot)).collect();
    let what =
        if found.is_empty() { "no effect was found".to_owned() } else { found.join(", and ") };
    let improves = match &reason.improved {
        Some(improved) => {
            let [before, after] = match [improved.before, improved.after] {
                pair if fixed(pair[0], 1) == fixed(pair[1], 1) => pair.map(score),
                pair => pair.map(|error| fixed(error, 1)),
            };
            format!(
                "lowers the error of {} in the {} from {before} to {after} times the noise",
                improved.channel,
                logs(improved.kind)
            )
        }
        None => "lowers the error of no channel".to_owned(),
    };
    let held_out = score_change(candidate.held_out_before, candidate.held_out_after);
    let alike: Vec<String> =
        candidate.others(all).into_iter().map(|effect| effect.name(robot)).collect();
    let alike = match alike.as_slice() {
        [] => "no other explanation that was tried fits as well".to_owned(),
        alike => format!("{} would explain these data as well", listed(alike, "or")),
    };
    let marks: Vec<&str> =
        candidate.effects.iter().map(|f| f.effect.kind.shows).filter(|s| !s.is_empty()).collect();
    let mark = match marks.as_slice() {
        [] => String::new(),
        marks => format!("; its mark in the data: {}", marks.join("; and ")),
    };
    format!(
        "{}, which {improves}. On rows left out of the fit {held_out} (probability {}); {alike}{mark}.",
        capital(&what),
        probability(candidate.probability)
    )
}

fn logs(kind: LogKind) -> &'static str {
    match kind {
        LogKind::StaticLoad => "static loads",
        LogKind::RingDown => "ring-downs",
        LogKind::FreeMotion => "free motions",
        LogKind::Weld => "welds",
    }
}

pub(crate) fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// What one effect is, where, and of which size: its template, or its name and its values where it
/// has none.
fn statement(found: &FittedEffect, robot: &RobotFile) -> String {
    let kind = found.effect.kind;
    let text = if kind.sentence.is_empty() {
        let values: Vec<String> = kind
            .parameters
            .iter()
            .enumerate()
            .map(|(k, p)| format!("{} = {}", p.name, value(found, k, 1.0)))
            .collect();
        let with =
            if values.is_empty() { String::new() } else { format!(" with {}", values.join(", ")) };
        format!("there is {}{with}", found.effect.name(robot))
    } else {
        filled(found, robot)
    };
    match found.log {
        Some(log) => format!("{text} in log {}", log + 1),
        None => text,
    }
}

/// The template of [`EffectKind::sentence`](trueweld_plant::effects::EffectKind::sentence) with
/// everything in braces replaced; what is not understood stays.
fn filled(found: &FittedEffect, robot: &RobotFile) -> String {
    let mut text = String::new();
    let mut rest = found.effect.kind.sentence;
    while let Some((before, after)) = rest.split_once('{') {
        let (slot, after) = after.split_once('}').unwrap_or((after, ""));
        text += before;
        text += &replacement(slot, found, robot).unwrap_or_else(|| format!("{{{slot}}}"));
        rest = after;
    }
    text + rest
}

fn replacement(slot: &str, found: &FittedEffect, robot: &RobotFile) -> Option<String> {
    let effect = &found.effect;
    let index = |text: &str| text.parse().ok().filter(|k: &usize| *k < effect.values.len());
    let plain =
        |k: usize, value: f64| Scale::of_parameter(&effect.kind.parameters[k]).quantity(value);
    let joint = |back: usize| {
        let Location::Joint(joint) = effect.at else { return None };
        robot.joint_names.get(joint.saturating_sub(back)).cloned()
    };
    match slot {
        "joint" => return joint(0),
        "before" => return joint(1),
        "instrument" => return Some(instrument(effect.at).to_owned()),
        _ => {}
    }
    if let Some(k) = slot.strip_prefix("plain ") {
        let k = index(k)?;
        Some(plain(k, effect.values[k]))
    } else if let Some(k) = slot.strip_prefix("norm ") {
        let k = index(k)?;
        let squares: f64 = effect.values.get(k..k + 3)?.iter().map(|v| v * v).sum();
        Some(plain(k, squares.sqrt()))
    } else if let Some(k) = slot.strip_suffix('#') {
        Some(fixed(effect.values[index(k)?], 2))
    } else if let Some((k, words)) = slot.split_once('?') {
        let (word, below_zero) = words.split_once('|')?;
        Some(if effect.values[index(k)?] < 0.0 { below_zero } else { word }.to_owned())
    } else if let Some(k) = slot.strip_prefix('|').and_then(|s| s.strip_suffix('|')) {
        let k = index(k)?;
        Some(value(found, k, effect.values[k].signum()))
    } else {
        Some(value(found, index(slot)?, 1.0))
    }
}

/// A fitted value times a sign, with its unit and 95 % interval; where the logs leave more than half
/// of the plausible range on either side, they do not bound it.
pub(super) fn value(found: &FittedEffect, k: usize, sign: f64) -> String {
    let (parameter, value) = (&found.effect.kind.parameters[k], found.effect.values[k]);
    let interval = found.interval.get(k).copied().unwrap_or([value; 2]);
    let scale = Scale::of_parameter(parameter);
    if !found.is_bounded(k) {
        return format!("{}, hardly bounded by these logs", scale.quantity(sign * value));
    }
    scale.with_interval(sign * value, interval.map(|end| sign * end))
}

fn instrument(at: Location) -> &'static str {
    match at {
        Location::Channel(Channel::Tracker) => "the tracker",
        Location::Channel(Channel::Wrench) => "the force sensor",
        Location::Channel(Channel::MotorTorque) => "the motor torque",
        Location::Channel(Channel::LinkEncoder) => "the second encoders' reading",
        _ => "the instrument",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use trueweld_diagnose::DiagnosisVerdict;
    use trueweld_plant::effects::{Effect, EffectKind, Role, library};

    fn found(kind: &'static EffectKind, values: Vec<f64>) -> FittedEffect {
        let at = kind.places()[kind.places().len() / 2];
        let interval = values.iter().map(|v| [v - 0.1 * v.abs(), v + 0.1 * v.abs()]).collect();
        FittedEffect { effect: Effect { kind, at, values }, log: None, interval, turns: None }
    }

    #[test]
    fn every_effect_of_the_library_has_a_sentence_that_can_be_filled_in() {
        let robot = sample::diagnosis(DiagnosisVerdict::Adequate).model.robot;
        for (kind, sign) in library().flat_map(|kind| [(kind, 1.0), (kind, -1.0)]) {
            let value = |role: Role| match role {
                Role::Size { step, neutral } => neutral + sign * step,
                _ => 1.0,
            };
            let values = kind.parameters.iter().map(|p| value(p.role)).collect();
            let sentence = statement(&found(kind, values), &robot);
            assert!(!sentence.contains(['{', '}', '|', '?']), "{}: {sentence}", kind.id);
            assert!(!sentence.contains("there is"), "{} has no sentence", kind.id);
        }
    }

    #[test]
    fn a_sentence_says_which_way_and_how_much() {
        let robot = sample::diagnosis(DiagnosisVerdict::Adequate).model.robot;
        let said = |id: &str, values: &[f64]| {
            statement(&found(EffectKind::of(id).unwrap(), values.to_vec()), &robot)
        };
        assert_eq!(said("stiffness-error", &[-0.2]), "A4 is 20.0 ± 2.0 % softer than in the model");
        assert_eq!(
            said("backlash", &[2.4e-4]),
            "A4 has a backlash with a half gap of 0.240 ± 0.024 mrad"
        );
        assert_eq!(
            said("tracker-registration", &[3e-4, 4e-4, 0.0, 0.0, 0.0, 1e-4]),
            "the tracker's frame is off by 0.500 mm and 0.100 mrad"
        );
        assert_eq!(
            said("channel-delay", &[-2e-3]),
            "the motor torque leads the encoders by 2.00 ± 0.20 ms"
        );
    }

    #[test]
    fn an_explanation_names_what_it_improves_and_what_explains_the_data_as_well() {
        let mut parts = sample::diagnosis(DiagnosisVerdict::EffectFound);
        parts.diagnosis.candidates[0].indistinguishable = vec![1];
        let all = &parts.diagnosis.candidates;
        let text = explanation(&all[0], all, &parts.explanation.reasons[0], &parts.model.robot);
        for part in [
            "A5 has a backlash with a half gap of 0.2400 ± 0.0020 mrad, which lowers the error of",
            "the score falls from 3.79 to 1.01 (probability 98 %)",
            "hysteresis at A5 would explain these data as well",
        ] {
            assert!(text.contains(part), "{text}");
        }
    }
}
