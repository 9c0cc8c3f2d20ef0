//! A model against measurements: comparison, diagnosis, improvement.

use super::finite;
use crate::words;
use crate::words::compare::notice;
use crate::words::diagnose::{not_kept, undone};
use crate::words::experiment;
use crate::words::finding::sentence;
use crate::{CompareReport, DiagnoseReport, ImproveReport, MistakesReport, RegisterReport};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_vector;
use trueweld_measure::diagnose::evidence::EffectCurve;
use trueweld_measure::diagnose::{Candidate, Diagnosis, FittedEffect, Reason, Verdict};
use trueweld_measure::experiment::Plan;
use trueweld_measure::mistakes::{Mistake, Registered};
use trueweld_measure::residuals::compare::{ChannelComparison, LogComparison};
use trueweld_measure::residuals::localize::{CurvePoint, Finding, Statistic, foremost};
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::input::RobotFile;
use trueweld_plant::provenance::Provenance;

/// A model against measurements.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "compare/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Mistakes in the files; where there are any, nothing else was looked for.
    #[serde(default)]
    pub mistakes: Vec<FileMistake>,
    /// The model file.
    pub model: String,
    /// √mean((residual/noise)²) over all samples; 1 is the noise floor.
    pub score: Option<f64>,
    /// Number of compared samples.
    pub samples: usize,
    /// Every log.
    pub logs: Vec<ComparedLog>,
    /// What the residuals follow, worst first.
    pub worst: Vec<ResidualFinding>,
    /// What a reader should know although nothing is wrong.
    pub notices: Vec<String>,
}

/// A gross mistake in the files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FileMistake {
    /// `sign`, `zero`, `exchanged`, `unit`, `gear-side`, `tracker-frame`, `time-unit`, `wrench-side`
    /// or `payload`.
    pub what: String,
    /// What it is in: joints by their names, or `encoders`, `torque`, `wrench`, `tracker`, `time`,
    /// `payload`.
    pub at: String,
    /// The channel that it is in.
    pub channel: String,
    /// Names of the logs that it is in.
    pub logs: Vec<String>,
    /// What shows it.
    pub evidence: MistakeEvidence,
    /// The line to write; several where it takes several.
    pub change: String,
    /// Where the line belongs.
    pub change_in: String,
    /// The same in words.
    pub sentence: String,
}

/// What a residual is as the files are, and with the mistake undone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MistakeEvidence {
    /// Channel that is compared.
    pub channel: String,
    /// Unit of both figures.
    pub unit: String,
    /// Root mean square as the files are.
    pub rms_before: Option<f64>,
    /// Root mean square with the mistake undone.
    pub rms_after: Option<f64>,
}

/// A model against one log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedLog {
    /// The log's folder.
    pub path: String,
    /// Its name.
    pub name: String,
    /// Kind of the log.
    pub kind: String,
    /// As the whole's.
    pub score: Option<f64>,
    /// Number of compared samples.
    pub samples: usize,
    /// Every channel that is compared.
    pub channels: Vec<ComparedChannel>,
}

/// A model against one channel of a log, or one column of it; figures in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedChannel {
    /// Name of the channel; of a column, with its number from 0.
    pub name: String,
    /// Unit of the figures.
    pub unit: String,
    /// Root mean square of measured less predicted.
    pub rmse: Option<f64>,
    /// Largest magnitude of measured less predicted.
    pub max: Option<f64>,
    /// Root mean square of what the noise leaves in the difference.
    pub noise: Option<f64>,
    /// Whether the logs state the noise: `stated` or `estimated`.
    pub noise_is: String,
    /// As the whole's.
    pub score: Option<f64>,
    /// Number of compared samples.
    pub samples: usize,
    /// What people call a column.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// The columns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<ComparedChannel>,
}

/// A condition that the residual of one channel follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResidualFinding {
    /// Kind of the logs.
    pub kind: String,
    /// The channel.
    pub channel: String,
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Score of this channel in these logs.
    pub score: Option<f64>,
    /// The condition.
    pub variable: String,
    /// Its unit; empty for categories.
    pub unit: String,
    /// Where it shows most: range of the condition, or the category's number twice.
    pub low: Option<f64>,
    /// See `low`.
    pub high: Option<f64>,
    /// Name of the category where it shows most.
    pub category: Option<String>,
    /// Whether the `mean` or the `size` of the residual follows the condition.
    pub how: String,
    /// Share of the squared residual that follows it.
    pub share: Option<f64>,
    /// Share that chance gives.
    pub share_by_chance: Option<f64>,
    /// How often chance does as much.
    pub p: Option<f64>,
    /// Share of the squared residual where it shows most.
    pub share_there: Option<f64>,
    /// Share of the samples where it shows most.
    pub samples_there: Option<f64>,
    /// Conditions that it follows nearly as much.
    pub similar: Vec<String>,
    /// The same in words.
    pub sentence: String,
    /// The residual over the condition.
    pub curve: ResidualCurve,
}

/// A residual over a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ResidualCurve {
    pub x_name: String,
    pub x_unit: String,
    /// Names of the categories; empty where the condition is a number.
    pub categories: Vec<String>,
    pub y_name: String,
    pub y_unit: String,
    pub x: Vec<Option<f64>>,
    pub y: Vec<Option<f64>>,
    /// Standard errors of `y`.
    pub error: Vec<Option<f64>>,
}

/// Which physical effect is missing in a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Calibrations that are off.
    pub calibration: Vec<FittedEffectValues>,
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

/// An effect and what it is at: a joint, an instrument, or nothing for the whole cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct EffectPlace {
    pub effect: String,
    pub at: String,
}

/// An effect with its fitted values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedEffectValues {
    /// The effect.
    pub effect: String,
    /// What it is at.
    pub at: String,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, FittedValue>,
    /// The log, where it is of one alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<String>,
}

/// A fitted value with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct FittedValue {
    pub value: Option<f64>,
    pub low: Option<f64>,
    pub high: Option<f64>,
    pub unit: String,
}

/// What the measurements show of an effect, and the effect as fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct EffectCurveData {
    pub title: String,
    pub x_name: String,
    pub x_unit: String,
    pub y_name: String,
    pub y_unit: String,
    pub x: Vec<Option<f64>>,
    pub y: Vec<Option<f64>>,
    /// Standard errors of `y`.
    pub error: Vec<Option<f64>>,
    pub fitted_x: Vec<Option<f64>>,
    pub fitted_y: Vec<Option<f64>>,
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

/// A model improved.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
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
    /// Names of the logs that were held out.
    pub held_out: Vec<String>,
    /// What the residual follows that is left.
    pub unexplained: Vec<ResidualFinding>,
    /// What there was no time for, and fits that did not arrive, in words.
    pub undone: Vec<String>,
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

/// Mistakes in the files, in the form of the command that found them.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum MistakesResult {
    /// Of `compare`.
    Compare(CompareResult),
    /// Of `diagnose`.
    Diagnose(DiagnoseResult),
    /// Of `improve`.
    Improve(ImproveResult),
}

impl MistakesResult {
    pub(crate) fn of(report: &MistakesReport<'_>) -> Self {
        let joints = &report.model.robot.joint_names;
        let provenance = report.provenance.clone();
        let model = report.model.path.display().to_string();
        let mistakes = report.found.mistakes.iter().map(|m| FileMistake::of(m, joints)).collect();
        let sentence = words::mistakes::headline(report.found, joints);
        let verdict = Verdict::UnknownEffect.name().to_owned();
        match provenance.command.as_str() {
            "diagnose" => Self::Diagnose(DiagnoseResult {
                schema: "diagnose/1".to_owned(),
                provenance,
                mistakes,
                model,
                verdict,
                sentence,
                score_before: None,
                score_calibrated: None,
                score_after: None,
                candidates: Vec::new(),
                calibration: Vec::new(),
                next_experiment: None,
                undone: Vec::new(),
                unexplained: Vec::new(),
                limits: Vec::new(),
                confusable: Vec::new(),
            }),
            "improve" => Self::Improve(ImproveResult {
                schema: "improve/1".to_owned(),
                provenance,
                mistakes,
                model,
                out: String::new(),
                verdict,
                sentence,
                steps: Vec::new(),
                rejected: Vec::new(),
                held_out: Vec::new(),
                undone: Vec::new(),
                unexplained: Vec::new(),
            }),
            _ => Self::Compare(CompareResult {
                schema: "compare/1".to_owned(),
                provenance,
                mistakes,
                model,
                score: None,
                samples: 0,
                logs: Vec::new(),
                worst: Vec::new(),
                notices: Vec::new(),
            }),
        }
    }
}

impl FileMistake {
    fn of(mistake: &Mistake, joints: &[String]) -> Self {
        use words::mistakes::{change, place, sentence, target};
        Self {
            what: mistake.kind.name().to_owned(),
            at: place(mistake, joints),
            channel: mistake.channel.name().to_owned(),
            logs: mistake.logs.clone(),
            evidence: MistakeEvidence {
                channel: mistake.evidence.channel.name().to_owned(),
                unit: mistake.evidence.unit.to_owned(),
                rms_before: finite(mistake.evidence.before),
                rms_after: finite(mistake.evidence.after),
            },
            change: change(mistake),
            change_in: target(mistake).to_owned(),
            sentence: sentence(mistake, joints),
        }
    }
}

/// Where trackers stand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisterResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "register/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// The model file.
    pub model: String,
    /// Every tracker that was found.
    pub trackers: Vec<RegisteredTracker>,
}

/// A tracker's frame and what it sees of the tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisteredTracker {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Poses that it rests on.
    pub poses: usize,
    /// The robot's base seen by the tracker.
    pub base: RegisteredPose,
    /// The tracked point and its axes in the tool frame.
    pub tool: RegisteredPose,
    /// Root mean square of what is left of the positions, m.
    pub left_m: Option<f64>,
    /// Root mean square of what is left of the rotations, rad.
    pub left_rad: Option<f64>,
    /// The table for `log.toml`.
    pub table: String,
}

/// A rigid motion with the half-widths of its 95 % intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisteredPose {
    /// Position, m.
    pub position_m: [f64; 3],
    /// Rotation vector, rad.
    pub rotation_rad: [f64; 3],
    /// Half-widths of the position, m.
    pub position_interval_m: [f64; 3],
    /// Half-widths of the rotation, rad.
    pub rotation_interval_rad: [f64; 3],
}

impl RegisterResult {
    pub(crate) fn of(report: &RegisterReport<'_>) -> Self {
        let pose = |pose: &Pose<f64>, interval: &[f64; 6]| RegisteredPose {
            position_m: pose.position.into(),
            rotation_rad: rotation_vector(&pose.rotation).into(),
            position_interval_m: std::array::from_fn(|k| interval[k]),
            rotation_interval_rad: std::array::from_fn(|k| interval[3 + k]),
        };
        let tracker = |registered: &Registered| {
            let found = &registered.registration;
            RegisteredTracker {
                logs: registered.logs.clone(),
                poses: found.poses,
                base: pose(&found.mounting.frame, &found.frame_interval),
                tool: pose(&found.mounting.tool, &found.tool_interval),
                left_m: finite(found.left[0]),
                left_rad: finite(found.left[1]),
                table: words::register::table(&found.mounting),
            }
        };
        Self {
            schema: "register/1".to_owned(),
            provenance: report.provenance.clone(),
            model: report.model.path.display().to_string(),
            trackers: report.registered.iter().map(tracker).collect(),
        }
    }
}

impl CompareResult {
    pub(crate) fn of(report: &CompareReport<'_>) -> Self {
        let comparison = report.comparison;
        let log = |log: &LogComparison| ComparedLog {
            path: log.path.display().to_string(),
            name: log.name.clone(),
            kind: log.kind.name().to_owned(),
            score: finite(log.score),
            samples: log.samples,
            channels: log.channels.iter().map(ComparedChannel::of).collect(),
        };
        Self {
            schema: "compare/1".to_owned(),
            provenance: report.provenance.clone(),
            mistakes: Vec::new(),
            model: report.model.display().to_string(),
            score: finite(comparison.score),
            samples: comparison.samples,
            logs: comparison.logs.iter().map(log).collect(),
            worst: comparison.worst.iter().map(ResidualFinding::of).collect(),
            notices: comparison.notices.iter().map(notice).collect(),
        }
    }
}

impl ComparedChannel {
    fn of(channel: &ChannelComparison) -> Self {
        Self {
            name: channel.name.clone(),
            unit: channel.unit.to_owned(),
            rmse: finite(channel.rmse),
            max: finite(channel.max),
            noise: finite(channel.noise),
            noise_is: if channel.stated { "stated" } else { "estimated" }.to_owned(),
            score: finite(channel.score),
            samples: channel.samples,
            label: channel.label.clone(),
            columns: channel.columns.iter().map(Self::of).collect(),
        }
    }
}

impl ResidualFinding {
    fn of(finding: &Finding) -> Self {
        let curve = &finding.curve;
        let column =
            |of: fn(&CurvePoint) -> f64| curve.points.iter().map(|p| finite(of(p))).collect();
        Self {
            kind: finding.kind.name().to_owned(),
            channel: finding.channel.to_owned(),
            logs: finding.logs.clone(),
            score: finite(finding.score),
            variable: finding.variable.clone(),
            unit: finding.unit.to_owned(),
            low: finite(finding.low),
            high: finite(finding.high),
            category: (!finding.category.is_empty()).then(|| finding.category.clone()),
            how: match finding.how {
                Statistic::Mean => "mean",
                Statistic::Size => "size",
            }
            .to_owned(),
            share: finite(finding.share),
            share_by_chance: finite(finding.by_chance),
            p: finite(finding.p),
            share_there: finite(finding.share_there),
            samples_there: finite(finding.samples_there),
            similar: finding.similar.clone(),
            sentence: sentence(finding),
            curve: ResidualCurve {
                x_name: curve.x_name.clone(),
                x_unit: curve.x_unit.to_owned(),
                categories: curve.categories.clone(),
                y_name: curve.y_name.clone(),
                y_unit: curve.y_unit.to_owned(),
                x: column(|p| p.x),
                y: column(|p| p.y),
                error: column(|p| p.error),
            },
        }
    }

    /// What is left, the foremost of it.
    fn remaining(diagnosis: &Diagnosis) -> Vec<Self> {
        let all = foremost(&diagnosis.unexplained, words::diagnose::REMAINS);
        all.into_iter().map(Self::of).collect()
    }
}

impl DiagnoseResult {
    pub(crate) fn of(report: &DiagnoseReport<'_>) -> Self {
        let DiagnoseReport { diagnosis, account, model, before, .. } = *report;
        let robot = &model.robot;
        let limit = |limit: &trueweld_measure::diagnose::Limit| {
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
        let pair = |pair: &trueweld_measure::diagnose::Confusable| ConfusablePair {
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
            score_calibrated: finite(trueweld_measure::diagnose::score(&diagnosis.null.at)),
            score_after: finite(report.score_after()),
            candidates: candidates
                .map(|(k, c)| DiagnosisCandidate::of(c, account.reasons.get(k), diagnosis, robot))
                .collect(),
            calibration: FittedEffectValues::calibrations(&diagnosis.calibration, robot, before),
            next_experiment: account.next_experiment.as_ref().map(PlannedExperiment::of),
            unexplained: ResidualFinding::remaining(diagnosis),
            limits: diagnosis.limits.iter().map(limit).collect(),
            confusable: diagnosis.confusable.iter().map(pair).collect(),
            undone: undone(&diagnosis.undone, robot),
        }
    }
}

impl DiagnosisCandidate {
    fn of(
        candidate: &Candidate,
        reason: Option<&Reason>,
        diagnosis: &Diagnosis,
        robot: &RobotFile,
    ) -> Self {
        let curves: Vec<Option<EffectCurveData>> = reason
            .iter()
            .flat_map(|r| &r.evidence)
            .map(|curve| curve.as_ref().map(EffectCurveData::of))
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

impl EffectPlace {
    fn of(kind: &'static EffectKind, at: Location, robot: &RobotFile) -> Self {
        let effect = Effect { kind, at, values: Vec::new() };
        Self { effect: kind.id.to_owned(), at: effect.at_name(robot).to_owned() }
    }
}

impl FittedEffectValues {
    /// Calibrations, with those of their values that the data carry.
    fn calibrations(all: &[FittedEffect], robot: &RobotFile, logs: &[LogComparison]) -> Vec<Self> {
        let carried = |found: &FittedEffect| {
            let mut of = Self::of(found, robot, logs);
            let all = found.effect.kind.parameters.iter().enumerate();
            for (_, p) in all.filter(|(k, _)| !found.is_fitted(*k)) {
                of.parameters.remove(p.name);
            }
            of
        };
        all.iter().map(carried).collect()
    }

    fn all(all: &[FittedEffect], robot: &RobotFile, logs: &[LogComparison]) -> Vec<Self> {
        all.iter().map(|found| Self::of(found, robot, logs)).collect()
    }

    fn of(found: &FittedEffect, robot: &RobotFile, logs: &[LogComparison]) -> Self {
        let EffectPlace { effect, at } = EffectPlace::of(found.effect.kind, found.effect.at, robot);
        let parameters = found.effect.kind.parameters.iter().enumerate().map(|(k, p)| {
            let [low, high] = found.interval[k].map(|v| finite(v).filter(|_| found.is_fitted(k)));
            let value = finite(found.effect.values[k]);
            (p.name.to_owned(), FittedValue { value, low, high, unit: p.unit.to_owned() })
        });
        let log = found.log.and_then(|log| logs.get(log)).map(|log| log.name.clone());
        Self { effect, at, parameters: parameters.collect(), log }
    }
}

impl EffectCurveData {
    fn of(curve: &EffectCurve) -> Self {
        let column =
            |of: fn(&CurvePoint) -> f64| curve.points.iter().map(|p| finite(of(p))).collect();
        let fitted = |axis: usize| curve.fitted.iter().map(|p| finite(p[axis])).collect();
        Self {
            title: curve.title.clone(),
            x_name: curve.x_name.clone(),
            x_unit: curve.x_unit.to_owned(),
            y_name: curve.y_name.clone(),
            y_unit: curve.y_unit.to_owned(),
            x: column(|p| p.x),
            y: column(|p| p.y),
            error: column(|p| p.error),
            fitted_x: fitted(0),
            fitted_y: fitted(1),
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
            held_out: improvement.held_out_logs.clone(),
            unexplained: ResidualFinding::remaining(&improvement.diagnosis),
            undone: undone(&improvement.diagnosis.undone, &model.robot),
        }
    }
}
