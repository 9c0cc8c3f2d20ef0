//! Which physical effect is missing in a model, and what to record next.

use super::compare::ResidualFinding;
use super::discover::DiscoveredLaw;
use super::effects::{EffectCurveData, EffectPlace, FittedEffectValues};
use super::finite;
use super::mistake::FileMistake;
use super::mountings::LinkMountings;
use super::register::RegisteredTracker;
use crate::words::compare::notice;
use crate::words::diagnose::undone;
use crate::words::experiment;
use crate::{DiagnoseReport, words};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_diagnose::experiment::Plan;
use trueweld_diagnose::{Candidate, Diagnosis, ExplanationReason};
use trueweld_plant::input::RobotFile;
use trueweld_plant::provenance::Provenance;

/// Which physical effect is missing in a model.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiagnoseResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "diagnose/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Mistakes in the files; where there are any, nothing else was looked for.
    #[serde(default)]
    pub mistakes: Vec<FileMistake>,
    /// The model file.
    pub model: String,
    /// `adequate`, `effect-found` or `unknown-effect`.
    pub verdict: String,
    /// The verdict in words.
    pub sentence: String,
    /// Score of the model as given.
    pub score_before: Option<f64>,
    /// Score with calibrations alone.
    pub score_calibrated: Option<f64>,
    /// Score with the best explanation and the calibrations that count.
    pub score_after: Option<f64>,
    /// Explanations that were fitted, best first.
    pub candidates: Vec<DiagnosisCandidate>,
    /// Laws outside the library that were found; then the score after is with the first of them.
    #[serde(default)]
    pub discovered: Vec<DiscoveredLaw>,
    /// Calibrations that are off.
    pub calibration: Vec<FittedEffectValues>,
    /// What the logs fix of how links are mounted; null where they see no postures.
    #[serde(default)]
    pub mountings: Option<LinkMountings>,
    /// What to record next.
    pub next_experiment: Option<PlannedExperiment>,
    /// What the residual follows that is left.
    pub unexplained: Vec<ResidualFinding>,
    /// The smallest size of each effect that these logs would have shown.
    pub limits: Vec<DetectionLimit>,
    /// Effects that these logs hardly tell apart.
    pub confusable: Vec<ConfusablePair>,
    /// What there was no time for, and fits that did not arrive, in words.
    pub undone: Vec<String>,
    /// What a reader should know although nothing is wrong.
    #[serde(default)]
    pub notices: Vec<String>,
    /// Trackers that stood elsewhere, and were registered first.
    #[serde(default)]
    pub registered: Vec<RegisteredTracker>,
}

/// One explanation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiagnosisCandidate {
    /// Its effects.
    pub effects: Vec<FittedEffectValues>,
    /// Score on rows left out of the fit, without it.
    pub holdout_score_before: Option<f64>,
    /// Score on rows left out of the fit, with it.
    pub holdout_score_after: Option<f64>,
    /// How likely it is.
    pub probability: Option<f64>,
    /// Share of what is above the noise floor that it leaves.
    pub left: Option<f64>,
    /// Effects that the data do not tell from it.
    pub indistinguishable: Vec<EffectPlace>,
    /// The same in words.
    pub explanation: String,
    /// The curve that shows the first of its effects that has one.
    pub evidence: Option<EffectCurveData>,
    /// The curve of each effect.
    pub evidence_of_effects: Vec<Option<EffectCurveData>>,
}

/// An experiment to make next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedExperiment {
    /// Kind of log to record.
    pub kind: String,
    /// What is done, in a line.
    pub title: String,
    /// What to do, in order.
    pub steps: Vec<String>,
    /// Which explanations it separates.
    pub reason: String,
    /// Expected separation of the first two explanations, standard deviations.
    pub separation: Option<f64>,
    /// Time that it takes, minutes.
    pub minutes: f64,
    /// Set points in order.
    pub rows: Vec<PlanPoint>,
}

/// One set point of a planned experiment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PlanPoint {
    pub t_s: f64,
    pub encoder_rad: Vec<f64>,
    /// Force on the tool, tool axes, N.
    pub force_n: [f64; 3],
    /// Moment on the tool at its centre point, tool axes, N·m.
    pub moment_nm: [f64; 3],
    pub payload_kg: f64,
}

/// The smallest size of an effect that the logs would have shown.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct DetectionLimit {
    pub effect: String,
    pub at: String,
    /// The parameter that is its size.
    pub parameter: String,
    pub value: Option<f64>,
    pub unit: String,
}

/// Two effects that the logs hardly tell apart.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ConfusablePair {
    pub first: EffectPlace,
    pub second: EffectPlace,
    /// Correlation of what they do to the measurements.
    pub alike: Option<f64>,
    /// From so many times the detection limit on they are told apart.
    pub told_apart_from_limit_times: Option<f64>,
}

impl DiagnoseResult {
    pub(crate) fn of(report: &DiagnoseReport<'_>) -> Self {
        let DiagnoseReport { diagnosis, explanation, model, before, .. } = *report;
        let robot = &model.robot;
        let limit = |limit: &trueweld_diagnose::EffectLimit| {
            let parameter = &limit.kind.parameters[limit.parameter];
            let EffectPlace { effect, at } = EffectPlace::of(limit.kind, limit.at, robot);
            DetectionLimit {
                effect,
                at,
                parameter: parameter.name.to_owned(),
                value: finite(limit.value),
                unit: parameter.unit.to_owned(),
            }
        };
        let pair = |pair: &trueweld_diagnose::Confusable| ConfusablePair {
            first: EffectPlace::of(pair.first.0, pair.first.1, robot),
            second: EffectPlace::of(pair.second.0, pair.second.1, robot),
            alike: finite(pair.alike),
            told_apart_from_limit_times: finite(pair.factor()),
        };
        let candidates = diagnosis.candidates.iter().enumerate();
        Self {
            schema: "diagnose/1".to_owned(),
            provenance: report.provenance.clone(),
            mistakes: Vec::new(),
            model: model.path.display().to_string(),
            verdict: diagnosis.verdict.name().to_owned(),
            sentence: report.headline(),
            score_before: finite(diagnosis.score_before),
            score_calibrated: finite(trueweld_diagnose::score(&diagnosis.null.residuals)),
            score_after: finite(report.score_after()),
            candidates: candidates
                .map(|(k, c)| {
                    DiagnosisCandidate::of(c, explanation.reasons.get(k), diagnosis, robot)
                })
                .collect(),
            discovered: DiscoveredLaw::all(report.discovered, robot),
            calibration: FittedEffectValues::calibrations(&diagnosis.calibration, robot, before),
            mountings: diagnosis.mountings.as_ref().map(|m| LinkMountings::of(m, robot)),
            next_experiment: explanation.next_experiment.as_ref().map(PlannedExperiment::of),
            unexplained: ResidualFinding::remaining(diagnosis),
            limits: diagnosis.limits.iter().map(limit).collect(),
            confusable: diagnosis.confusable.iter().map(pair).collect(),
            undone: undone(&diagnosis.incomplete, robot),
            notices: report.notices.iter().map(notice).collect(),
            registered: RegisteredTracker::all(report.notices),
        }
    }
}

impl DiagnosisCandidate {
    fn of(
        candidate: &Candidate,
        reason: Option<&ExplanationReason>,
        diagnosis: &Diagnosis,
        robot: &RobotFile,
    ) -> Self {
        let curves: Vec<Option<EffectCurveData>> = reason
            .iter()
            .flat_map(|r| &r.evidence)
            .map(|curve| curve.as_ref().map(|curve| EffectCurveData::of(curve, robot)))
            .collect();
        let others = candidate.others(&diagnosis.candidates);
        Self {
            effects: FittedEffectValues::all(&candidate.effects, robot, &[]),
            holdout_score_before: finite(candidate.held_out_before),
            holdout_score_after: finite(candidate.held_out_after),
            probability: finite(candidate.probability),
            left: finite(candidate.left),
            indistinguishable: others
                .iter()
                .map(|e| EffectPlace::of(e.kind, e.at, robot))
                .collect(),
            explanation: reason.map_or(String::new(), |reason| {
                words::effects::explanation(candidate, &diagnosis.candidates, reason, robot)
            }),
            evidence: curves.iter().flatten().next().cloned(),
            evidence_of_effects: curves,
        }
    }
}

impl PlannedExperiment {
    fn of(plan: &Plan) -> Self {
        let rows = plan.rows.iter().map(|row| PlanPoint {
            t_s: row.time,
            encoder_rad: row.encoder.to_vec(),
            force_n: row.force,
            moment_nm: row.moment,
            payload_kg: row.payload,
        });
        Self {
            kind: plan.log.kind.name().to_owned(),
            title: experiment::title(plan),
            steps: experiment::steps(plan),
            reason: experiment::reason(plan),
            separation: finite(plan.separation),
            minutes: plan.minutes,
            rows: rows.collect(),
        }
    }
}
