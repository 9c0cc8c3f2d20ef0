//! Which physical effect is missing in a model, and what to record next.

use super::compare::ResidualFinding;
use super::discover::{DiscoveredLaw, PortPlace};
use super::effects::{EffectCurveData, EffectPlace, FittedEffectValues};
use super::error::ChannelErrorFigures;
use super::log_fault::FileMistake;
use super::mountings::LinkMountings;
use super::register::RegisteredTracker;
use super::{finite, result};
use crate::text::compare::notice;
use crate::text::diagnose::incomplete;
use crate::text::experiment;
use crate::{DiagnoseReport, text};
use trueweld_diagnose::experiment::{Plan, PlanRow};
use trueweld_diagnose::{Candidate, Confusable, Diagnosis, EffectLimit, ExplanationReason};
use trueweld_plant::input::RobotFile;
use trueweld_plant::provenance::Provenance;

result! {
    /// Which physical effect is missing in a model.
    #[derive(Default)]
    DiagnoseResult of (report: &DiagnoseReport<'_>) with {
        let DiagnoseReport { diagnosis, explanation, model, before, .. } = *report;
        let robot = &model.robot;
        let candidates = diagnosis.candidates.iter().enumerate().map(|(k, candidate)| {
            DiagnosisCandidate::of(candidate, explanation.reasons.get(k), diagnosis, robot)
        });
        let pairs = diagnosis.confusable.iter();
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// Mistakes in the files; where there are any, nothing else was looked for.
        #[serde(default)]
        mistakes: Vec<FileMistake> = Vec::new(),
        /// The model file.
        model: String = model.path.display().to_string(),
        /// `adequate`, `effect-found` or `unknown-effect`.
        verdict: &'static str = diagnosis.verdict.name(),
        /// `all` of what was above noise and accuracy, a `part`, or `nothing`.
        #[serde(default)]
        explained: &'static str = diagnosis.explained().name(),
        /// The verdict in words.
        sentence: String = report.headline(),
        /// Score of the model as given.
        score_before: Option<f64> = finite(diagnosis.score_before),
        /// Score with calibrations alone.
        score_calibrated: Option<f64> = finite(diagnosis.score_calibrated),
        /// Score with the best explanation and the calibrations that count.
        score_after: Option<f64> = finite(diagnosis.score_after),
        /// Errors by channel of the model as given.
        #[serde(default)]
        errors_before: Vec<ChannelErrorFigures> = ChannelErrorFigures::all(&diagnosis.errors.before),
        /// The same with calibrations alone, on rows left out of the fit.
        #[serde(default)]
        errors_calibrated: Vec<ChannelErrorFigures> =
            ChannelErrorFigures::all(&diagnosis.errors.calibrated),
        /// The same with the best explanation and the calibrations that count.
        #[serde(default)]
        errors_after: Vec<ChannelErrorFigures> = ChannelErrorFigures::all(&diagnosis.errors.after),
        /// Explanations that were fitted, most evidence first.
        candidates: Vec<DiagnosisCandidate> = candidates.collect(),
        /// Laws outside the library that were found; then the score after is with the first of them.
        #[serde(default)]
        discovered: Vec<DiscoveredLaw> = DiscoveredLaw::all(report.discovered, robot),
        /// Ports at which laws outside the library explain the logs about as well, where the library's
        /// explanations are too uncertain beside them to be named.
        #[serde(default)]
        ports_alike: Vec<PortPlace> =
            diagnosis.ports_alike.iter().map(|port| PortPlace::of(*port, robot)).collect(),
        /// Calibrations that are off.
        calibration: Vec<FittedEffectValues> =
            FittedEffectValues::calibrations(&diagnosis.calibration, robot, before),
        /// What the logs fix of how links are mounted; null where they see no postures.
        #[serde(default)]
        mountings: Option<LinkMountings> =
            diagnosis.mountings.as_ref().map(|mountings| LinkMountings::of(mountings, robot)),
        /// What to record next.
        next_experiment: Option<PlannedExperiment> =
            explanation.next_experiment.as_ref().map(PlannedExperiment::of),
        /// What the residual follows that is left.
        unexplained: Vec<ResidualFinding> = ResidualFinding::remaining(&diagnosis.unexplained),
        /// The smallest size of each effect that these logs would have shown.
        limits: Vec<DetectionLimit> =
            diagnosis.limits.iter().map(|limit| DetectionLimit::of(limit, robot)).collect(),
        /// Effects that these logs hardly tell apart.
        confusable: Vec<ConfusablePair> =
            pairs.map(|pair| ConfusablePair::of(pair, robot)).collect(),
        /// What there was no time for, and fits that did not arrive, in words.
        undone: Vec<String> = incomplete(&diagnosis.incomplete, robot),
        /// What a reader should know although nothing is wrong.
        #[serde(default)]
        notices: Vec<String> = report.notices.iter().map(notice).collect(),
        /// Trackers that stood elsewhere, and were registered first.
        #[serde(default)]
        registered: Vec<RegisteredTracker> = RegisteredTracker::all(report.notices),
    }
}

result! {
    /// One explanation.
    DiagnosisCandidate of (
        candidate: &Candidate,
        reason: Option<&ExplanationReason>,
        diagnosis: &Diagnosis,
        robot: &RobotFile,
    ) with {
        let all = &diagnosis.candidates;
        let curves: Vec<Option<EffectCurveData>> = reason
            .iter()
            .flat_map(|r| &r.evidence)
            .map(|curve| curve.as_ref().map(|curve| EffectCurveData::of(curve, robot)))
            .collect();
        let told = |reason| text::effects::explanation(candidate, all, reason, robot);
    } {
        /// Its effects.
        effects: Vec<FittedEffectValues> = FittedEffectValues::all(&candidate.effects, robot, &[]),
        /// Score on rows left out of the fit, without it.
        holdout_score_before: Option<f64> = finite(candidate.held_out_before),
        /// Score on rows left out of the fit, with it.
        holdout_score_after: Option<f64> = finite(candidate.held_out_after),
        /// How likely it is.
        probability: Option<f64> = finite(candidate.probability),
        /// Evidence for it against none: the difference of the log scores on rows left out of the fit, less
        /// the logarithm of how many were tried, nats.
        #[serde(default)]
        evidence_nats: Option<f64> = finite(candidate.evidence),
        /// Share of what is above the noise floor that it leaves.
        left: Option<f64> = finite(candidate.left),
        /// Effects that the data do not tell from it.
        indistinguishable: Vec<EffectPlace> =
            candidate.others(all).iter().map(|e| EffectPlace::of(e.place(), robot)).collect(),
        /// The same in words.
        explanation: String = reason.map_or(String::new(), told),
        /// The curve that shows the first of its effects that has one.
        evidence: Option<EffectCurveData> = curves.iter().flatten().next().cloned(),
        /// The curve of each effect.
        evidence_of_effects: Vec<Option<EffectCurveData>> = curves,
    }
}

result! {
    /// An experiment to make next.
    PlannedExperiment of (plan: &Plan) {
        /// Kind of log to record.
        kind: &'static str = plan.log.kind.name(),
        /// What is done, in a line.
        title: String = experiment::title(plan),
        /// What to do, in order.
        steps: Vec<String> = experiment::steps(plan),
        /// Which explanations it separates.
        reason: String = experiment::reason(plan),
        /// Expected separation of the first two explanations, standard deviations.
        separation: Option<f64> = finite(plan.separation),
        /// Time that it takes, minutes.
        minutes: f64 = plan.minutes,
        /// Set points in order.
        rows: Vec<PlanPoint> = plan.rows.iter().map(PlanPoint::of).collect(),
    }
}

result! {
    /// One set point of a planned experiment.
    PlanPoint of (row: &PlanRow) {
        t_s: f64 = row.time,
        encoder_rad: Vec<f64> = row.encoder.to_vec(),
        /// Force on the tool, tool axes, N.
        force_n: [f64; 3] = row.force,
        /// Moment on the tool at its centre point, tool axes, N·m.
        moment_nm: [f64; 3] = row.moment,
        payload_kg: f64 = row.payload,
    }
}

result! {
    /// The smallest size of an effect that the logs would have shown.
    DetectionLimit of (limit: &EffectLimit, robot: &RobotFile) with {
        let size = &limit.effect.kind.parameters[limit.parameter];
    } {
        effect: &'static str = limit.effect.kind.id,
        at: String = limit.effect.at.name(robot).to_owned(),
        /// The parameter that is its size.
        parameter: &'static str = size.name,
        value: Option<f64> = finite(limit.value),
        unit: &'static str = size.unit,
    }
}

result! {
    /// Two effects that the logs hardly tell apart.
    ConfusablePair of (pair: &Confusable, robot: &RobotFile) {
        first: EffectPlace = EffectPlace::of(pair.first, robot),
        second: EffectPlace = EffectPlace::of(pair.second, robot),
        /// Correlation of what they do to the measurements.
        alike: Option<f64> = finite(pair.alike),
        /// From so many times the detection limit on they are told apart.
        told_apart_from_limit_times: Option<f64> = finite(pair.factor()),
    }
}
