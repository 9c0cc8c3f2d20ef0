//! A model improved.

use super::compare::ResidualFinding;
use super::discover::DiscoveredLaw;
use super::effects::{EffectPlace, FittedEffectValues};
use super::error::ChannelErrorFigures;
use super::log_fault::FileMistake;
use super::register::RegisteredTracker;
use super::{finite, result};
use crate::ImproveReport;
use crate::text::compare::notice;
use crate::text::diagnose::incomplete;
use crate::text::improve::not_kept;
use trueweld_diagnose::improve::{ImprovementStep, Rejected};
use trueweld_logs::HALF_95;
use trueweld_plant::input::{MeasuredNumber, Posterior, RobotFile};
use trueweld_plant::provenance::Provenance;

result! {
    /// A model improved.
    #[derive(Default)]
    ImproveResult of (report: &ImproveReport<'_>) with {
        let ImproveReport { improvement, model, .. } = *report;
        let robot = &model.robot;
        let steps = improvement.steps.iter();
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// Mistakes in the files; where there are any, nothing else was looked for.
        #[serde(default)]
        mistakes: Vec<FileMistake> = Vec::new(),
        /// The model file.
        model: String = model.path.display().to_string(),
        /// The improved model file.
        out: String = report.out.display().to_string(),
        /// `adequate`, `effect-found` or `unknown-effect`.
        verdict: &'static str = improvement.verdict.name(),
        /// `all` of what was above noise and accuracy, a `part`, or `nothing`.
        #[serde(default)]
        explained: &'static str = improvement.explained().name(),
        /// The result in words.
        sentence: String = report.headline(),
        /// Steps that were kept, the model as given first.
        steps: Vec<AddedStep> = steps.map(|step| AddedStep::of(step, report)).collect(),
        /// Steps that were tried and not kept.
        rejected: Vec<RejectedStep> =
            improvement.rejected.iter().map(|step| RejectedStep::of(step, report)).collect(),
        /// Laws outside the library that were found.
        #[serde(default)]
        discovered: Vec<DiscoveredLaw> = DiscoveredLaw::all(&improvement.discovered, robot),
        /// Names of the logs that were held out.
        held_out: Vec<String> = improvement.held_out_logs.clone(),
        /// What the residual follows that is left.
        unexplained: Vec<ResidualFinding> = ResidualFinding::remaining(&improvement.unexplained),
        /// What there was no time for, and fits that did not arrive, in words.
        undone: Vec<String> = incomplete(&improvement.incomplete, robot),
        /// What the logs leave open of every number that they measure; their covariance stands in the
        /// improved model file.
        #[serde(default)]
        posterior: Vec<PosteriorNumber> =
            report.posterior.map_or(Vec::new(), |of| PosteriorNumber::all(of, robot)),
        /// Numbers that were fitted and of which the logs say next to nothing.
        #[serde(default)]
        not_measured: Vec<String> =
            report.posterior.map_or(Vec::new(), |of| of.not_measured.clone()),
        /// What a reader should know although nothing is wrong.
        #[serde(default)]
        notices: Vec<String> = report.notices.iter().map(notice).collect(),
        /// Trackers that stood elsewhere, and were registered first.
        #[serde(default)]
        registered: Vec<RegisteredTracker> = RegisteredTracker::all(report.notices),
    }
}

result! {
    /// A number of the cell with its 95 % interval, every calibration free beside it.
    PosteriorNumber of (n: &MeasuredNumber, half: f64, robot: &RobotFile) with {
        let of = &n.kind.parameters[n.parameter];
        let end = |x: f64| if of.holds(x) { x } else { x.clamp(of.low, of.high) };
    } {
        effect: &'static str = n.kind.id,
        at: String = n.at.name(robot).to_owned(),
        parameter: &'static str = of.name,
        value: f64 = n.value,
        low: f64 = end(n.value - half),
        high: f64 = end(n.value + half),
        unit: &'static str = of.unit,
        /// Standard deviation from log to log, in the unit; 0 for a number of the cell.
        between_logs: f64 = n.between_logs,
        /// True where the value is at the bound of what is possible: the interval ends there.
        at_bound: bool = of.is_at_bound(n.value),
    }
}

impl PosteriorNumber {
    pub(crate) fn all(of: &Posterior, robot: &RobotFile) -> Vec<Self> {
        let numbers = of.numbers.iter().enumerate();
        numbers.map(|(k, n)| Self::of(n, HALF_95 * of.deviation(k), robot)).collect()
    }
}

result! {
    /// A step of an improvement.
    AddedStep of (step: &ImprovementStep, report: &ImproveReport<'_>) with {
        let (robot, before) = (&report.model.robot, report.before);
        let others = report.improvement.others(step).into_iter();
    } {
        /// Effects that it added.
        added: Vec<FittedEffectValues> = FittedEffectValues::all(&step.added, robot, before),
        /// Score on the logs fitted.
        score: Option<f64> = finite(step.score),
        /// Score where nothing was fitted.
        holdout_score: Option<f64> = finite(step.held_out),
        /// Errors there, by channel.
        #[serde(default)]
        holdout_errors: Vec<ChannelErrorFigures> = ChannelErrorFigures::all(&step.errors),
        /// All effects of the model at this step.
        effects: Vec<FittedEffectValues> = FittedEffectValues::all(&step.effects, robot, before),
        /// The calibrations beside them.
        calibration: Vec<FittedEffectValues> =
            FittedEffectValues::calibrations(&step.calibration, robot, before),
        /// Effects that the data do not tell from those that it added.
        #[serde(default)]
        indistinguishable: Vec<EffectPlace> =
            others.map(|e| EffectPlace::of(e.place(), robot)).collect(),
    }
}

result! {
    /// A step that was not kept.
    RejectedStep of (step: &Rejected, report: &ImproveReport<'_>) {
        /// Effects that it would have added; none for a recalibration.
        added: Vec<FittedEffectValues> =
            FittedEffectValues::all(&step.added, &report.model.robot, report.before),
        /// Score where nothing was fitted, with it.
        holdout_score: Option<f64> = finite(step.held_out),
        /// Why it was not kept.
        why: String = not_kept(step.why).to_owned(),
    }
}
