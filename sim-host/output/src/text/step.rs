//! What is said of responses to a step of the push.

use super::Scale;
use super::weld::limits;
use crate::StepRun;

/// The controllers' names, all different.
#[cfg(feature = "rerun")]
pub(crate) fn controller_names(runs: &[StepRun]) -> Vec<String> {
    super::weld::numbered(runs.iter().map(|r| r.recording.controller.to_owned()).collect())
}

/// What agreement of the step shows, and what it does not.
pub(crate) const SEARCHED_GAINS: &str = "No gains are published: those of the shipped control file were searched until this cell gave the published \
     step. That they agree shows that such gains exist, not that the model is right.";

/// The result in one sentence.
pub(crate) fn headline(runs: &[StepRun]) -> String {
    let parts: Vec<String> = runs
        .iter()
        .map(|run| match run.figures.settle_5pct_s {
            Some(t) => format!("{} in {}", run.figures.controller, milliseconds(t)),
            None => format!("{} not within the time recorded", run.figures.controller),
        })
        .collect();
    let mut sentence = format!("The push settles within 5 % of the step: {}.", parts.join(", "));
    for run in runs.iter().filter(|run| !run.figures.limits.is_empty()) {
        let limits = limits(&run.figures.limits);
        sentence += &format!(" At a limit, {}: {limits}.", run.figures.controller);
    }
    sentence
}

/// How the step was made.
pub(crate) fn setting(height: f64) -> String {
    format!(
        "Step of the push by {}; 5 % and overshoot are of its height, taken from the real push with \
         its ripple. Published figures: Bres et al., Industrial Robot 37(1), 2010. {SEARCHED_GAINS}",
        Scale { factor: 1e-3, unit: "kN" }.quantity(height)
    )
}

/// A time of a response.
pub(crate) fn milliseconds(time: f64) -> String {
    format!("{:.0} ms", 1e3 * time)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use trueweld_plant::simulate::{LimitKind, LimitSpan, Phase};

    #[test]
    fn a_response_that_does_not_settle_is_said_not_to() {
        let mut steps = sample::steps();
        steps.figures[1].settle_5pct_s = None;
        let sentence = headline(&steps.runs());
        assert!(sentence.contains("superposed not within the time recorded, external in "));
    }

    #[test]
    fn a_step_has_no_seam() {
        let mut steps = sample::steps();
        let limit = LimitSpan {
            kind: LimitKind::Torque(1),
            time_s: 0.02,
            first_s: sample::STEP_AT,
            phase: Phase::Hold,
        };
        steps.figures[0].limits = vec![limit];
        let sentence = headline(&steps.runs());
        assert!(sentence.contains("torque of A2") && !sentence.contains("seam"), "{sentence}");
    }
}
