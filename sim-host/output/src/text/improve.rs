//! What is said of an improvement.

use super::diagnose::{
    NAMED_CALIBRATIONS_MAX, calibrations, followed, implausible, in_a_line, setting, spoken,
    values, verdict,
};
use super::{Scale, discover, error, listed, probability, score, score_change};
use crate::ImproveReport;
use trueweld_diagnose::improve::{ImprovementStep, Rejected, Rejection};
use trueweld_diagnose::{DiagnosisVerdict, FittedEffect};
use trueweld_estimate::residuals::compare::NOISE_FLOOR_SCORE;
use trueweld_estimate::residuals::error::ChannelError;
use trueweld_estimate::residuals::localize::Finding;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::RobotFile;

impl ImproveReport<'_> {
    /// What came of it, in a sentence or two.
    pub(crate) fn headline(&self) -> String {
        let steps = &self.improvement.steps;
        let (first, last) = (self.improvement.first(), self.improvement.last());
        let added: Vec<String> = last
            .effects
            .iter()
            .filter(|f| f.log.is_none())
            .map(|f| discover::name(&f.effect, &self.model.robot))
            .collect();
        let recalibrated = match steps.get(1) {
            Some(step) if step.added.is_empty() && steps.len() > 2 => {
                format!(" ({} with recalibration alone)", score(step.held_out))
            }
            _ => String::new(),
        };
        let scores = score_change(first.held_out, last.held_out);
        let fall = match error::change(&first.errors, &last.errors) {
            Some(change) => format!("{change} where nothing was fitted: {scores}{recalibrated}"),
            None => format!("{scores} where nothing was fitted{recalibrated}"),
        };
        match (steps.len(), added.as_slice()) {
            (1, _) => format!(
                "No improvement: the model stays as it was given (score {}); nothing that was tried lowers the error where nothing was \
                 fitted.",
                score(first.held_out)
            ),
            (_, []) => match calibrations(&last.calibration, &self.model.robot) {
                names if names.is_empty() => format!("Recalibrated: {fall}."),
                names => format!("Recalibrated, {names}: {fall}."),
            },
            (_, added) if added.len() > NAMED_CALIBRATIONS_MAX => {
                format!("With {} effects {fall}.", added.len())
            }
            (_, added) => {
                let others = steps.iter().rev().find(|step| !step.added.is_empty());
                let others = others.map_or(Vec::new(), |step| self.improvement.others(step));
                let others: Vec<String> =
                    others.iter().map(|e| e.name(&self.model.robot)).collect();
                let tied = match others.as_slice() {
                    [] => String::new(),
                    others => format!(" These logs explain as well with {}.", listed(others, "or")),
                };
                format!("With {} {fall}.{tied}", added.join(" and "))
            }
        }
    }

    /// The verdict that stays with the improved model.
    pub(crate) fn verdict(&self) -> String {
        let improvement = self.improvement;
        let last = improvement.last();
        match improvement.verdict {
            DiagnosisVerdict::EffectFound
                if improvement.diagnosis.verdict == DiagnosisVerdict::UnknownEffect =>
            {
                match last.effects.len() {
                    1 => "One effect brings every channel near the noise floor; a diagnosis of these logs alone does not name it, so that \
                          it is less certain."
                        .to_owned(),
                    n => format!(
                        "{n} effects together bring every channel near the noise floor; they were added one after another, so that each \
                         for itself is less certain."
                    ),
                }
            }
            DiagnosisVerdict::EffectFound
                if improvement
                    .diagnosis
                    .candidates
                    .first()
                    .is_some_and(|c| c.indistinguishable.is_empty()) =>
            {
                let found: Vec<String> =
                    last.effects.iter().map(|f| in_a_line(f, &self.model.robot)).collect();
                match found.as_slice() {
                    [] => format!(
                        "Nothing was missing but calibrations.{}",
                        implausible(&last.calibration, &self.model.robot)
                    ),
                    found => format!(
                        "What was missing: {}; probability among all effects of the library {}.",
                        found.join(" and "),
                        probability(improvement.diagnosis.candidates[0].probability)
                    ),
                }
            }
            _ if !improvement.discovered.is_empty() => {
                discover::headline(&improvement.discovered, &self.model.robot)
            }
            DiagnosisVerdict::UnknownEffect
                if improvement.is_any() && improvement.diagnosis.ports_alike.is_empty() =>
            {
                format!(
                    "A part is explained. {}, which no effect here explains.",
                    remainder(&last.errors, &improvement.unexplained)
                )
            }
            verdict => {
                let left = (verdict, &improvement.unexplained[..]);
                self::verdict(&improvement.diagnosis, left, &self.model.robot, None)
            }
        }
    }

    /// What is said of the laws outside the library that were found, of several a paragraph each.
    pub(crate) fn laws(&self) -> Vec<String> {
        let robot = &self.model.robot;
        match self.improvement.discovered.as_slice() {
            [one] => {
                let why = std::iter::once(discover::explanation(one));
                why.chain(discover::details(one, robot)).collect()
            }
            all => all.iter().map(|d| discover::one_of(d, robot)).collect(),
        }
    }

    /// What was improved, and what it was judged by.
    pub(crate) fn setting(&self) -> String {
        let judged = match self.improvement.held_out_logs.as_slice() {
            [] => "every tenth of each log, predicted from a fit to the others".to_owned(),
            logs => format!("{}, to which nothing was fitted", logs.join(", ")),
        };
        format!(
            "{} Steps are judged by: {judged}. The improved model: {}.",
            setting(self.model, self.before),
            self.out.display()
        )
    }

    /// What a step did, in a line.
    pub(crate) fn step(&self, k: usize) -> String {
        let ImprovementStep { added, .. } = &self.improvement.steps[k];
        match (k, added.as_slice()) {
            (0, _) => "as given".to_owned(),
            (_, []) => "recalibrated".to_owned(),
            (_, added) => format!("+ {}", listed_names(added, &self.model.robot)),
        }
    }

    /// What a rejected step would have added, and why it was not kept.
    pub(crate) fn rejected(&self, rejected: &Rejected) -> [String; 2] {
        let what = match rejected.added.as_slice() {
            [] => "recalibration alone".to_owned(),
            added => listed_names(added, &self.model.robot),
        };
        [what, not_kept(rejected.why).to_owned()]
    }

    /// Every value of the improved model that was fitted, with its interval and where it comes
    /// from.
    pub(crate) fn fitted(&self) -> Vec<[String; 4]> {
        let last = self.improvement.last();
        let effects = last.effects.iter().map(|f| (f, "effect"));
        let all = effects.chain(last.calibration.iter().map(|f| (f, "calibration")));
        all.flat_map(|(found, sort)| {
            let from = match found.log.and_then(|log| self.before.get(log)) {
                Some(log) => format!("{sort}, fitted to {} alone", log.name),
                None => format!("{sort}, fitted to all logs"),
            };
            let name = found.effect.name(&self.model.robot);
            let row = |(parameter, value): (String, String)| {
                let from = format!("{from}{}", self.with_own(&found.effect, &parameter));
                [name.clone(), parameter, value, from]
            };
            values(found).into_iter().map(row).collect::<Vec<_>>()
        })
        .collect()
    }

    /// What a value comes to with the number of the robot's own that it adds to; nothing where it stands
    /// alone.
    fn with_own(&self, effect: &Effect, parameter: &str) -> String {
        let parameters = effect.kind.parameters.iter().enumerate();
        let numbers = parameters.filter(|(_, p)| spoken(p) == parameter).filter_map(|(k, p)| {
            let own = effect.kind.own(k, effect.at, &self.model.robot.parameters)?;
            let scale = Scale::of_parameter(p);
            let whole = scale.quantity(own + effect.values[k]);
            (own != 0.0).then(|| format!("; with the robot's {}: {whole}", scale.number(own)))
        });
        numbers.collect()
    }
}

/// What remains, and what it follows: `0.0738 mrad of the second encoders remains above noise and
/// accuracy; it follows A1's angle (65 % of …)`.
fn remainder(errors: &[ChannelError], unexplained: &[Finding]) -> String {
    let left: Vec<String> = errors
        .iter()
        .filter(|e| e.rmse > NOISE_FLOOR_SCORE * e.noise.hypot(e.accuracy))
        .map(|e| format!("{} in the {}", Scale::small(e.unit).quantity(e.rmse), error::channel(e)))
        .collect();
    let left = match left.as_slice() {
        [] => "what stands out here and there".to_owned(),
        left => format!("{} RMS", listed(left, "and")),
    };
    format!("What remains is {left}; {}", followed(unexplained))
}

/// Why a step was not kept.
pub(crate) fn not_kept(why: Rejection) -> &'static str {
    match why {
        Rejection::NotPredicted => "the model with it cannot be driven through the logs held out",
        Rejection::NoGain => "the error elsewhere does not fall",
        Rejection::OtherLogsWorse => "logs are predicted worse from what the others tell",
        Rejection::NotShown => "the logs do not tell it from no effect",
        Rejection::Unstable => "the arm with it does not come to rest",
    }
}

fn listed_names(found: &[FittedEffect], robot: &RobotFile) -> String {
    found.iter().map(|f| f.effect.name(robot)).collect::<Vec<_>>().join(" + ")
}
