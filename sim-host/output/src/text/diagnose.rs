//! What is said of a diagnosis.

use super::finding::{article, sentence};
use super::{
    Scale, counted, discover, effects, error, experiment, fixed, listed, probability, score,
    score_change, share,
};
use crate::DiagnoseReport;
use trueweld_diagnose::experiment::TOLD_APART;
use trueweld_diagnose::{
    Candidate, Confusable, Diagnosis, DiagnosisVerdict, EffectLimit, ExplanationReason,
    FittedEffect, Incomplete, Mountings,
};
use trueweld_estimate::predict::is_open_factor;
use trueweld_estimate::residuals::compare::{LogComparison, NOISE_FLOOR_SCORE};
use trueweld_estimate::residuals::error::ChannelError;
use trueweld_estimate::residuals::localize::{Finding, foremost};
use trueweld_plant::effects::{Action, Effect, EffectKind, EffectPlace, Location, Parameter};
use trueweld_plant::input::{ModelFile, RobotFile, unit_suffix};

/// Held-out score from which on an explanation is said not to be the end of it.
const INCOMPLETE_SCORE: f64 = 1.5;

/// Score after over score before from which down a calibration is the finding.
const FALL: f64 = 0.95;

/// Calibrations that are named in a sentence.
pub(super) const NAMED_CALIBRATIONS_MAX: usize = 3;

/// Findings of what remains that are told.
pub(crate) const REMAINS: usize = 5;

/// The name of a parameter without its unit: `half gap`.
pub(crate) fn spoken(parameter: &Parameter) -> String {
    let name = parameter.name;
    unit_suffix(name).map_or(name, |(short, _)| short).replace('_', " ")
}

/// A value of a found effect with its 95 % interval.
pub(crate) fn value(found: &FittedEffect, k: usize) -> String {
    effects::value(found, k, 1.0)
}

/// Every value of a found effect with its name; of a table between what its values are.
pub(crate) fn values(found: &FittedEffect) -> Vec<(String, String)> {
    let kind = found.effect.kind;
    if let ([factor, off], true) = (found.effect.values.as_slice(), is_open_factor(kind)) {
        let whole = |off: f64| factor * (1.0 + off);
        let mut told = found.clone();
        told.effect.values[0] = whole(*off);
        let [low, high] = found.interval[1].map(whole);
        told.interval[0] = [low.min(high), low.max(high)];
        return vec![(spoken(&kind.parameters[0]), value(&told, 0))];
    }
    let named = match kind.action {
        Action::Expression(own) => own.definition.named().len(),
        _ => kind.parameters.len(),
    };
    let told = kind.parameters[..named].iter().enumerate();
    let told = told.filter(|(k, _)| found.is_fitted(*k)).map(|(k, p)| (spoken(p), value(found, k)));
    let table = kind.parameters.get(named).map(|first| {
        let (scale, all) = (Scale::of_parameter(first), &found.effect.values[named..]);
        let low = all.iter().copied().fold(f64::INFINITY, f64::min);
        let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let ends = format!("{} to {}", scale.number(low), scale.quantity(high));
        ("table".to_owned(), format!("{} values, {ends}", all.len()))
    });
    told.chain(table).collect()
}

/// An effect with its values in one line.
pub(crate) fn in_a_line(found: &FittedEffect, robot: &RobotFile) -> String {
    let values: Vec<String> =
        values(found).into_iter().map(|(name, value)| format!("{name} {value}")).collect();
    format!("{} ({})", found.effect.name(robot), values.join(", "))
}

/// The best explanation and those that the data do not tell from it, each with its probability.
fn tied(diagnosis: &Diagnosis, robot: &RobotFile) -> Vec<String> {
    let Some(best) = diagnosis.candidates.first() else {
        return Vec::new();
    };
    let others = best.indistinguishable.iter().filter_map(|k| diagnosis.candidates.get(*k));
    let told = |candidate: &Candidate| {
        format!("{} ({})", candidate.name(robot), probability(candidate.probability))
    };
    std::iter::once(best).chain(others).map(told).collect()
}

/// What the rest of the residual follows, in a few words.
pub(super) fn followed(unexplained: &[Finding]) -> String {
    match foremost(unexplained, 1).first() {
        Some(f) => {
            let variable = article(f.variable, &f.joints);
            format!(
                "it follows {variable} ({} of the squared residual of {})",
                share(f.share),
                f.channel
            )
        }
        None => "it follows no single condition of those that are looked at".to_owned(),
    }
}

/// Calibrations in a line, of those that are told from nothing: those of the cell with their
/// values, those of single logs by how many. Empty where there are none.
pub(super) fn calibrations(found: &[FittedEffect], robot: &RobotFile) -> String {
    let told = found.iter().filter(|f| f.is_told_from_nothing());
    let (of_logs, of_cell): (Vec<_>, Vec<_>) = told.partition(|f| f.log.is_some());
    let mut told: Vec<String> = of_cell.into_iter().map(|f| in_a_line(f, robot)).collect();
    let mut names: Vec<(String, usize)> = Vec::new();
    for name in of_logs.iter().map(|f| f.effect.name(robot)) {
        match names.iter_mut().find(|(known, _)| *known == name) {
            Some((_, count)) => *count += 1,
            None => names.push((name, 1)),
        }
    }
    let of_logs = names.into_iter();
    told.extend(of_logs.map(|(name, count)| format!("{name} in {}", counted(count, "log"))));
    if told.len() > NAMED_CALIBRATIONS_MAX {
        let more = told.split_off(NAMED_CALIBRATIONS_MAX).len();
        told.push(format!("{more} more"));
    }
    listed(&told, "and")
}

/// What is said of calibrations that are larger than any; nothing where there are none.
pub(super) fn implausible(found: &[FittedEffect], robot: &RobotFile) -> String {
    let beyond: Vec<FittedEffect> = found.iter().filter(|f| f.is_implausible()).cloned().collect();
    match calibrations(&beyond, robot) {
        names if names.is_empty() => names,
        names => format!(
            " More than a calibration: {names}. Something else is wrong there, in the robot file or in the cell."
        ),
    }
}

/// What the logs fix of how links are mounted, in a line.
pub(crate) fn mountings(all: &Mountings, robot: &RobotFile) -> String {
    let best = all.fixed.first().map_or(String::new(), |best| {
        let terms =
            best.terms.iter().take(NAMED_CALIBRATIONS_MAX).map(|(at, parameter, weight)| {
                let joint = match at {
                    Location::Joint(joint) => robot.joint_names[*joint].as_str(),
                    _ => "",
                };
                format!("{} {joint} {parameter}", fixed(*weight, 2))
            });
        let terms = terms.collect::<Vec<_>>().join(", ");
        format!("; best known, to {} of what was expected: {terms}, …", share(best.deviation))
    });
    format!(
        "How links are mounted: of {} these logs fix {}, and leave {} open{best}.",
        counted(all.values, "value"),
        counted(all.fixed.len(), "combination"),
        all.values - all.fixed.len()
    )
}

/// From the score of the model as it was given to another: `score 5.15 to 0.975, 2.44 with
/// calibrations alone`.
fn scores(diagnosis: &Diagnosis, after: f64) -> String {
    let calibrated = diagnosis.held_out_without();
    let alone = match calibrated < FALL * diagnosis.score_before {
        true => format!(", {} with calibrations alone", score(calibrated)),
        false => String::new(),
    };
    format!("score {} to {}{alone}", score(diagnosis.score_before), score(after))
}

/// An explanation that brings the model so far, and how far calibrations alone bring it.
fn found(diagnosis: &Diagnosis, best: &Candidate, robot: &RobotFile) -> String {
    let found: Vec<String> = best.effects.iter().map(|f| in_a_line(f, robot)).collect();
    let errors = &diagnosis.errors;
    let change = match error::change(&errors.before, &errors.after) {
        Some(change) => {
            format!("{change} where it was not fitted: {}", scores(diagnosis, best.held_out_after))
        }
        None => format!(
            "{} where it was not fitted",
            score_change(best.held_out_before, best.held_out_after)
        ),
    };
    format!(
        "What is missing: {}, probability {}. With it {change}",
        found.join(" and "),
        probability(best.probability)
    )
}

/// True where the time was up before every effect had its chance: that none explains says nothing
/// then.
pub(super) fn is_cut_short(diagnosis: &Diagnosis) -> bool {
    let never_tried =
        |undone: &Incomplete| matches!(undone, Incomplete::Search | Incomplete::Fits(_));
    diagnosis.incomplete.iter().any(never_tried)
}

/// What the best explanation does where it explains a part; nothing where it does not.
fn partial_explanation(diagnosis: &Diagnosis, best: &Candidate, robot: &RobotFile) -> String {
    if !best.explains() || best.held_out_after >= FALL * best.held_out_before {
        return String::new();
    }
    let piece = match best.has_unseen_wave() {
        true => " (so small a piece of a wave that many other curves are like it)",
        false => "",
    };
    let errors = &diagnosis.errors;
    let change = error::change(&errors.before, &errors.after);
    match change.filter(|_| diagnosis.chosen == 1 && piece.is_empty()) {
        Some(change) => format!(
            " A part is explained, by {}: {change} where it was not fitted ({}).",
            in_a_line(&best.effects[0], robot),
            scores(diagnosis, best.held_out_after)
        ),
        None => format!(
            " The best partial explanation, {}{piece}, brings the score to {} where it was not fitted.",
            best.name(robot),
            score(best.held_out_after)
        ),
    }
}

/// What an error must be above to count.
fn floor(errors: &[ChannelError]) -> &'static str {
    match errors.iter().any(|e| e.accuracy > 0.0) {
        true => "noise and the accuracy asked for",
        false => "the noise floor",
    }
}

/// The finding in a sentence or two, of whatever kind it is; `next`: what to record next, in a sentence.
pub(crate) fn verdict(
    diagnosis: &Diagnosis,
    (verdict, unexplained): (DiagnosisVerdict, &[Finding]),
    robot: &RobotFile,
    next: Option<&str>,
) -> String {
    let before = score(diagnosis.score_before);
    let best = diagnosis.candidates.first();
    // What the calibrations do, where they are the finding: without what explains the rest in part.
    let after = match diagnosis.chosen {
        0 => diagnosis.score_after,
        _ => diagnosis.score_calibrated,
    };
    let off = calibrations(&diagnosis.calibration, robot);
    let calibrated = (!off.is_empty() && after < FALL * diagnosis.score_before).then(|| {
        format!(
            "The calibration is off: {off}. Correcting it lowers the score from {before} to {}",
            score(after)
        )
    });
    let follows = || followed(unexplained);
    let record = next.map_or(String::new(), |next| format!(" {next}"));
    let partial = || best.map_or(String::new(), |best| partial_explanation(diagnosis, best, robot));
    match (verdict, best, calibrated) {
        (DiagnosisVerdict::EffectFound, Some(best), _) if !best.indistinguishable.is_empty() => {
            format!(
                "Something is missing (score {before}), and these logs cannot separate {}: each brings the score to {} where it was \
                 not fitted.{record}",
                listed(&tied(diagnosis, robot), "and"),
                score(best.held_out_after)
            )
        }
        (DiagnosisVerdict::EffectFound, Some(best), _) => {
            let far = best.held_out_after > INCOMPLETE_SCORE;
            let far = if far { ", which is still far above the noise floor" } else { "" };
            format!("{}{far}.", found(diagnosis, best, robot))
        }
        (_, _, calibrated) if is_cut_short(diagnosis) => {
            let calibrated =
                calibrated.map_or(String::new(), |calibrated| format!(" {calibrated}."));
            format!(
                "The time was up before every effect was tried: what is missing cannot be told yet (score {before}).{calibrated}"
            )
        }
        (DiagnosisVerdict::UnknownEffect, ..) if !diagnosis.ports_alike.is_empty() => {
            let laws = diagnosis.ports_alike.iter().map(|port| discover::of_port(*port, robot));
            let laws = listed(&laws.collect::<Vec<_>>(), "or");
            let within = listed(&tied(diagnosis, robot), "and");
            let likeliest = match none_of_these(diagnosis) < 0.5 {
                true => format!(
                    "likeliest {within}; but a law that no effect here has would explain them about as well: {laws}"
                ),
                false => format!(
                    "likeliest a law that no effect here has: {laws}; of the effects here {within}"
                ),
            };
            format!(
                "Something is missing (score {before}), and these logs do not tell what: {likeliest}.{record}"
            )
        }
        (DiagnosisVerdict::UnknownEffect, ..) if diagnosis.is_faint() => {
            format!(
                "Something is missing (score {before}), too faintly to be named: likeliest {}. Something outside the library may \
                 look alike in so little.{record}",
                listed(&tied(diagnosis, robot), "and"),
            )
        }
        (DiagnosisVerdict::UnknownEffect, _, Some(calibrated)) => {
            let left = "No effect here explains the rest";
            format!("{calibrated}. {left}: {}.{}", follows(), partial())
        }
        (DiagnosisVerdict::UnknownEffect, ..) if diagnosis.score_before <= NOISE_FLOOR_SCORE => {
            format!(
                "The error is at the noise floor on the whole (score {before}), but not everywhere: {}. No effect here explains that.",
                follows()
            )
        }
        (DiagnosisVerdict::UnknownEffect, ..) => format!(
            "Something is missing that no effect here explains (score {before}); {}.{}",
            follows(),
            partial()
        ),
        (_, _, Some(calibrated)) => format!(
            "{calibrated}; beside it no effect lowers the error where it was not fitted by more than chance would."
        ),
        _ if diagnosis.score_before <= NOISE_FLOOR_SCORE => format!(
            "Nothing is missing above {} (score {before}): no effect lowers the error where it was not fitted by more than chance \
             would.",
            floor(&diagnosis.errors.before)
        ),
        _ => format!(
            "The model is off by more than the noise (score {before}), but no effect or calibration lowers the error where it was \
             not fitted by more than chance would; {}.",
            follows()
        ),
    }
}

impl DiagnoseReport<'_> {
    /// The verdict in a sentence or two.
    pub(crate) fn headline(&self) -> String {
        let next = self.explanation.next_experiment.as_ref().map(|plan| {
            if plan.separation < TOLD_APART {
                return "No experiment that the logs show to be possible tells them apart."
                    .to_owned();
            }
            format!("To tell them apart, record: {}.", experiment::title(plan))
        });
        let robot = &self.model.robot;
        if !self.discovered.is_empty() {
            return discover::headline(self.discovered, robot);
        }
        let found = (self.diagnosis.verdict, &self.diagnosis.unexplained[..]);
        let verdict = verdict(self.diagnosis, found, robot, next.as_deref());
        if is_cut_short(self.diagnosis) {
            return verdict;
        }
        format!("{verdict}{}", implausible(&self.diagnosis.calibration, robot))
    }

    /// What is said of a law outside the library, in the order in which it matters.
    pub(crate) fn details(&self) -> Vec<String> {
        let robot = &self.model.robot;
        let mut told: Vec<String> =
            self.discovered.iter().flat_map(|d| discover::details(d, robot)).collect();
        let implausible = implausible(&self.diagnosis.calibration, robot);
        if !told.is_empty() && !implausible.is_empty() {
            told.push(implausible.trim().to_owned());
        }
        told
    }

    /// What was diagnosed.
    pub(crate) fn setting(&self) -> String {
        setting(self.model, self.before)
    }

    /// Why the best explanation is believed; none where nothing is missing, or where it explains
    /// next to nothing.
    pub(crate) fn reason(&self) -> Option<&ExplanationReason> {
        let best = self.diagnosis.candidates.first()?;
        let told = self.discovered.is_empty()
            && match self.diagnosis.verdict {
                DiagnosisVerdict::Adequate => false,
                DiagnosisVerdict::EffectFound => best.explains(),
                DiagnosisVerdict::UnknownEffect => best.explains() && best.is_likely(),
            };
        self.explanation.reasons.first().filter(|_| told)
    }

    /// The same in words.
    pub(crate) fn explanation(&self) -> Option<String> {
        if let Some(discovery) = self.discovered.first() {
            return Some(discover::explanation(discovery));
        }
        let all = &self.diagnosis.candidates;
        Some(effects::explanation(all.first()?, all, self.reason()?, &self.model.robot))
    }

    /// Name of a log.
    pub(crate) fn log(&self, log: usize) -> &str {
        self.before.get(log).map_or("", |log| log.name.as_str())
    }
}

pub(super) fn setting(model: &ModelFile, logs: &[LogComparison]) -> String {
    format!(
        "Model {}, {}, {} samples. {} ± and intervals are of 95 %.{}",
        model.path.display(),
        counted(logs.len(), "log"),
        logs.iter().map(|log| log.samples).sum::<usize>(),
        error::score_is(logs),
        known(model)
    )
}

/// What the model declares known without the logs, after a blank; nothing where it declares none.
pub(super) fn known(model: &ModelFile) -> String {
    let each = model.known.iter().map(|known| {
        let name = known.at.map_or(known.kind.id.to_owned(), |at| {
            Effect { kind: known.kind, at, values: Vec::new() }.name(&model.robot)
        });
        let open = known.kind.parameters.iter().zip(&known.deviation);
        let open = open.filter(|(_, deviation)| **deviation > 0.0).map(|(parameter, deviation)| {
            format!(
                "{} within {}",
                spoken(parameter),
                Scale::of_parameter(parameter).quantity(*deviation)
            )
        });
        match open.collect::<Vec<_>>().join(", ") {
            exact if exact.is_empty() => name,
            open => format!("{name} ({open})"),
        }
    });
    match each.collect::<Vec<_>>().join(", ") {
        none if none.is_empty() => String::new(),
        all => format!(" Declared known without these logs: {all}."),
    }
}

/// Detection limits of one kind of effect.
pub(crate) struct Limits {
    pub kind: &'static EffectKind,
    /// The parameter that is its size, with its unit.
    pub size: String,
    /// By joint or instrument, or one for the cell: name and size.
    pub places: Vec<(String, String)>,
}

impl Limits {
    /// Places with their sizes in a line.
    pub(crate) fn by_place(&self) -> String {
        let places = self.places.iter().map(|(at, size)| format!("{at} {size}"));
        places.collect::<Vec<_>>().join("; ").trim().to_owned()
    }
}

/// Detection limits, a line a kind, in the order of the library; places in the order of the robot.
pub(crate) fn limits<'l>(
    all: impl IntoIterator<Item = &'l EffectLimit>,
    robot: &RobotFile,
) -> Vec<Limits> {
    let mut all: Vec<&EffectLimit> =
        all.into_iter().filter(|limit| limit.value.is_finite()).collect();
    let place = |at: Location| match at {
        Location::Joint(joint) => joint,
        Location::Channel(channel) => channel as usize,
        Location::Cell => 0,
    };
    let row = |kind: &EffectKind| {
        trueweld_plant::effects::library().position(|k| k.id == kind.id).unwrap_or(usize::MAX)
    };
    all.sort_by_key(|limit| (row(limit.effect.kind), place(limit.effect.at)));
    let mut lines: Vec<Limits> = Vec::new();
    for limit in all {
        let EffectPlace { kind, at } = limit.effect;
        let parameter = &kind.parameters[limit.parameter];
        let scale = Scale::of_parameter(parameter);
        let entry = (at.name(robot).to_owned(), scale.number(limit.value));
        match lines.last_mut().filter(|line| line.kind.id == kind.id) {
            Some(line) => line.places.push(entry),
            None => {
                let comma = if scale.unit.is_empty() { "" } else { ", " };
                let size = format!("{}{comma}{}", spoken(parameter), scale.unit);
                lines.push(Limits { kind, size, places: vec![entry] });
            }
        }
    }
    lines
}

/// Two hypotheses that are hard to tell apart, and from which multiple of the detection limit on
/// they are.
pub(crate) fn confusable(pair: &Confusable, robot: &RobotFile) -> [String; 3] {
    let apart = match pair.factor() {
        factor if factor > 300.0 => "not at any size".to_owned(),
        factor => format!("{factor:.0}"),
    };
    [pair.first.name(robot), pair.second.name(robot), apart]
}

/// What the explanations leave of the probability: that it is none of them.
pub(crate) fn none_of_these(diagnosis: &Diagnosis) -> f64 {
    (1.0 - diagnosis.candidates.iter().map(|c| c.probability).sum::<f64>()).clamp(0.0, 1.0)
}

/// Candidates that are told: those that are likely at all, and some.
pub(crate) fn ranked(diagnosis: &Diagnosis) -> &[Candidate] {
    &diagnosis.candidates[..diagnosis.candidates.len().min(6)]
}

/// Above the curves of evidence.
pub(crate) const CURVES: &str = "The curve that shows it: points are what the measurements ask for, \
     with standard errors, whatever the form of the effect";

/// Above what is left undone.
pub(crate) const INCOMPLETE_HEADING: &str = "Left undone";

/// What there was no time for, and fits that did not converge, a sentence each.
pub(crate) fn incomplete(all: &[Incomplete], robot: &RobotFile) -> Vec<String> {
    all.iter().map(|incomplete| left_undone(incomplete, robot)).collect()
}

fn left_undone(incomplete: &Incomplete, robot: &RobotFile) -> String {
    match incomplete {
        Incomplete::Search => "Not every effect was looked for: the time was up.".to_owned(),
        Incomplete::Fits(1) => {
            "The fit of a likely effect was left out: the time was up.".to_owned()
        }
        Incomplete::Fits(count) => {
            format!("{count} fits of likely effects were left out: the time was up.")
        }
        Incomplete::Further => {
            "No further effect was looked for, though something is left: the time was up."
                .to_owned()
        }
        Incomplete::Outside => {
            "Outside the library nothing was looked for: the time was up.".to_owned()
        }
        Incomplete::Arrival(effects) => {
            let names: Vec<String> = effects.iter().map(|e| e.name(robot)).collect();
            let of = if names.is_empty() {
                "the calibrations".to_owned()
            } else {
                listed(&names, "and")
            };
            format!("The fit of {of} used all its steps and did not converge.")
        }
    }
}

/// What is left that the residual follows, a sentence each.
pub(crate) fn remains(unexplained: &[Finding]) -> Vec<String> {
    let all = foremost(unexplained, REMAINS);
    all.into_iter().map(sentence).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;

    #[test]
    fn abstaining_has_three_sentences_and_a_finding_has_its_value() {
        let found = sample::diagnosis(DiagnosisVerdict::EffectFound).diagnosed().headline();
        assert!(
            found.starts_with("What is missing: backlash at A5 (half gap 0.2400 ± 0.0020 mrad)"),
            "{found}"
        );
        let mut parts = sample::diagnosis(DiagnosisVerdict::Adequate);
        let calibration = parts.diagnosed().headline();
        let expected = "The calibration is off: encoder-offset at A5 in 1 log. Correcting it lowers the score from 3.79 to 1.02; beside it";
        assert!(calibration.starts_with(expected), "{calibration}");
        let calibration = std::mem::take(&mut parts.diagnosis.calibration);
        let off = parts.diagnosed().headline();
        let expected =
            "The model is off by more than the noise (score 3.79), but no effect or calibration";
        assert!(off.starts_with(expected), "{off}");
        parts.diagnosis.score_before = 1.02;
        let adequate = parts.diagnosed().headline();
        let expected = "Nothing is missing above the noise floor (score 1.02)";
        assert!(adequate.starts_with(expected), "{adequate}");
        parts.diagnosis.score_before = 3.79;
        parts.diagnosis.verdict = DiagnosisVerdict::UnknownEffect;
        parts.diagnosis.candidates[0].probability = 0.49;
        // What leaves something that stands out is named as part of the answer, and not as the answer.
        let partial = parts.diagnosed().headline();
        let expected = "Something is missing that no effect here explains (score 3.79); it follows";
        assert!(partial.starts_with(expected), "{partial}");
        assert!(partial.contains("The best partial explanation, backlash at A5"), "{partial}");
        // So many explain it alike that none is named.
        let likely = std::mem::replace(&mut parts.diagnosis.candidates[0].probability, 0.08);
        parts.diagnosis.score_before = 0.986;
        let none = parts.diagnosed().headline();
        assert!(none.starts_with("The error is at the noise floor on the whole (score 0.986)"));
        assert!(!none.contains("backlash at A5"), "{none}");
        parts.diagnosis.candidates[0].probability = likely;
        parts.diagnosis.score_before = 3.79;
        parts.diagnosis.candidates[0].held_out_after = 2.5;
        let unknown = parts.diagnosed().headline();
        assert!(
            unknown.starts_with(
                "Something is missing that no effect here explains (score 3.79); it follows"
            ),
            "{unknown}"
        );
        assert!(
            unknown.contains(
                "sign of A5's spring torque (62 % of the squared residual of tcp_position)"
            ),
            "{unknown}"
        );
        // What calibrations bring is told without what explains a part of the rest.
        parts.diagnosis.chosen = 1;
        parts.diagnosis.calibration = calibration;
        let partly = parts.diagnosed().headline();
        assert!(
            partly.contains("Correcting it lowers the score from 3.79 to 2.90. No effect"),
            "{partly}"
        );
        assert!(partly.contains("A part is explained, by backlash at A5 (half gap"), "{partly}");
        parts.diagnosis.verdict = DiagnosisVerdict::EffectFound;
        parts.diagnosis.candidates[0].indistinguishable = vec![1];
        parts.explanation.next_experiment = Some(sample::plan());
        let tied = parts.diagnosed().headline();
        assert!(tied.contains("these logs cannot separate backlash at A5 ("), "{tied}");
        assert!(
            tied.contains("record: Static loads, 3 rows: up to 20 kg on the flange, up and down."),
            "{tied}"
        );
    }

    #[test]
    fn what_is_told_from_nothing_already_is_only_known_better_by_more_logs() {
        let mut plan = sample::plan();
        plan.rivals[1].clear();
        plan.so_far = 1e4;
        let lead = experiment::lead(&plan);
        assert!(lead.contains("only narrows the values of"), "{lead}");
        plan.so_far = 1.0;
        assert!(!experiment::lead(&plan).contains("only narrows"), "{lead}");
    }

    #[test]
    fn what_logs_do_not_bound_is_said_and_not_written_as_a_number() {
        let parts = sample::diagnosis(DiagnosisVerdict::EffectFound);
        let loop_ = &parts.diagnosis.candidates[1].effects[0];
        assert_eq!(value(loop_, 0), "310 N·m, hardly bounded by these logs");
        assert_eq!(values(loop_)[1].0, "twist");
    }

    #[test]
    fn limits_stand_in_the_order_of_the_joints() {
        let parts = sample::diagnosis(DiagnosisVerdict::Adequate);
        let limits = limits(&parts.diagnosis.limits, &parts.model.robot);
        assert_eq!(limits.len(), 1);
        let expected = [("A1", "0.00530"), ("A5", "0.00530")]
            .map(|(at, size)| (at.to_owned(), size.to_owned()));
        assert_eq!(
            (limits[0].size.as_str(), limits[0].places.as_slice()),
            ("half gap, mrad", &expected[..])
        );
    }
}
