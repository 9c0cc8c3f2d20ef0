//! A model improved.

use super::compare::ResidualFinding;
use super::discover::DiscoveredLaw;
use super::effects::{EffectPlace, FittedEffectValues};
use super::finite;
use super::mistake::FileMistake;
use super::register::RegisteredTracker;
use crate::ImproveReport;
use crate::words::compare::notice;
use crate::words::diagnose::undone;
use crate::words::improve::not_kept;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_diagnose::FittedEffect;
use trueweld_logs::HALF_95;
use trueweld_plant::input::{MeasuredNumber, Posterior, RobotFile};
use trueweld_plant::provenance::Provenance;

/// A model improved.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImproveResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "improve/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Mistakes in the files; where there are any, nothing else was looked for.
    #[serde(default)]
    pub mistakes: Vec<FileMistake>,
    /// The model file.
    pub model: String,
    /// The improved model file.
    pub out: String,
    /// `adequate`, `effect-found` or `unknown-effect`.
    pub verdict: String,
    /// The result in words.
    pub sentence: String,
    /// Steps that were kept, the model as given first.
    pub steps: Vec<AddedStep>,
    /// Steps that were tried and not kept.
    pub rejected: Vec<RejectedStep>,
    /// Laws outside the library that were found.
    #[serde(default)]
    pub discovered: Vec<DiscoveredLaw>,
    /// Names of the logs that were held out.
    pub held_out: Vec<String>,
    /// What the residual follows that is left.
    pub unexplained: Vec<ResidualFinding>,
    /// What there was no time for, and fits that did not arrive, in words.
    pub undone: Vec<String>,
    /// What the logs leave open of every number that they measure; their covariance stands in the
    /// improved model file.
    #[serde(default)]
    pub posterior: Vec<PosteriorNumber>,
    /// Numbers that were fitted and of which the logs say next to nothing.
    #[serde(default)]
    pub not_measured: Vec<String>,
    /// What a reader should know although nothing is wrong.
    #[serde(default)]
    pub notices: Vec<String>,
    /// Trackers that stood elsewhere, and were registered first.
    #[serde(default)]
    pub registered: Vec<RegisteredTracker>,
}

/// A number of the cell with its 95 % interval, every calibration free beside it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PosteriorNumber {
    pub effect: String,
    pub at: String,
    pub parameter: String,
    pub value: f64,
    pub low: f64,
    pub high: f64,
    pub unit: String,
    /// Standard deviation from log to log, in the unit; 0 for a number of the cell.
    pub between_logs: f64,
    /// True where the value is at the bound of what is possible: the interval ends there.
    pub at_bound: bool,
}

impl PosteriorNumber {
    pub(crate) fn all(of: &Posterior, robot: &RobotFile) -> Vec<Self> {
        let one = |(k, n): (usize, &MeasuredNumber)| {
            let EffectPlace { effect, at } = EffectPlace::of(n.kind, n.at, robot);
            let parameter = &n.kind.parameters[n.parameter];
            let end = |x: f64| {
                if parameter.holds(x) { x } else { x.clamp(parameter.low, parameter.high) }
            };
            let half = HALF_95 * of.deviation(k);
            Self {
                effect,
                at,
                parameter: parameter.name.to_owned(),
                value: n.value,
                low: end(n.value - half),
                high: end(n.value + half),
                unit: parameter.unit.to_owned(),
                between_logs: n.between_logs,
                at_bound: n.value == parameter.low || n.value == parameter.high,
            }
        };
        of.numbers.iter().enumerate().map(one).collect()
    }
}

/// A step of an improvement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AddedStep {
    /// Effects that it added.
    pub added: Vec<FittedEffectValues>,
    /// Score on the logs fitted.
    pub score: Option<f64>,
    /// Score where nothing was fitted.
    pub holdout_score: Option<f64>,
    /// All effects of the model at this step.
    pub effects: Vec<FittedEffectValues>,
    /// The calibrations beside them.
    pub calibration: Vec<FittedEffectValues>,
    /// Effects that the data do not tell from those that it added.
    #[serde(default)]
    pub indistinguishable: Vec<EffectPlace>,
}

/// A step that was not kept.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RejectedStep {
    /// Effects that it would have added; none for a recalibration.
    pub added: Vec<FittedEffectValues>,
    /// Score where nothing was fitted, with it.
    pub holdout_score: Option<f64>,
    /// Why it was not kept.
    pub why: String,
}

impl ImproveResult {
    pub(crate) fn of(report: &ImproveReport<'_>) -> Self {
        let ImproveReport { improvement, model, before, .. } = *report;
        let all = |list: &[FittedEffect]| FittedEffectValues::all(list, &model.robot, before);
        let steps = improvement.steps.iter().map(|step| AddedStep {
            added: all(&step.added),
            score: finite(step.score),
            holdout_score: finite(step.held_out),
            effects: all(&step.effects),
            calibration: FittedEffectValues::calibrations(&step.calibration, &model.robot, before),
            indistinguishable: improvement
                .others(step)
                .into_iter()
                .map(|e| EffectPlace::of(e.kind, e.at, &model.robot))
                .collect(),
        });
        let rejected = improvement.rejected.iter().map(|step| RejectedStep {
            added: all(&step.added),
            holdout_score: finite(step.held_out),
            why: not_kept(step.why).to_owned(),
        });
        Self {
            schema: "improve/1".to_owned(),
            provenance: report.provenance.clone(),
            mistakes: Vec::new(),
            model: model.path.display().to_string(),
            out: report.out.display().to_string(),
            verdict: improvement.verdict.name().to_owned(),
            sentence: report.headline(),
            steps: steps.collect(),
            rejected: rejected.collect(),
            discovered: DiscoveredLaw::all(&improvement.discovered, &model.robot),
            held_out: improvement.held_out_logs.clone(),
            unexplained: ResidualFinding::remaining(&improvement.diagnosis),
            undone: undone(&improvement.diagnosis.incomplete, &model.robot),
            posterior: report
                .posterior
                .map_or(Vec::new(), |of| PosteriorNumber::all(of, &model.robot)),
            not_measured: report.posterior.map_or(Vec::new(), |of| of.not_measured.clone()),
            notices: report.notices.iter().map(notice).collect(),
            registered: RegisteredTracker::all(report.notices),
        }
    }
}
