//! What experiments would show.

use super::diagnose::{ConfusablePair, DetectionLimit};
use super::effects::EffectPlace;
use super::result;
use crate::{PlanReport, RecordedLog};
use trueweld_diagnose::ShownEffect;
use trueweld_plant::provenance::Provenance;

result! {
    /// What experiments would show of each effect.
    PlanResult of (report: &PlanReport<'_>) with {
        let robot = &report.model.robot;
        let (shown, confusable) = (&report.detectability.shown, &report.detectability.confusable);
        let not_shown = report.detectability.not_shown.iter();
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// The experiments, in the protocol's order.
        logs: Vec<RecordedLog> = report.logs.to_vec(),
        /// Effects that they would show.
        shown: Vec<DetectableEffect> =
            shown.iter().map(|shown| DetectableEffect::of(shown, report)).collect(),
        /// Effects of which they would show nothing, at any plausible size.
        not_shown: Vec<EffectPlace> =
            not_shown.map(|effect| EffectPlace::of(*effect, robot)).collect(),
        /// Effects that they would hardly tell apart.
        confusable: Vec<ConfusablePair> =
            confusable.iter().map(|pair| ConfusablePair::of(pair, robot)).collect(),
    }
}

result! {
    /// An effect that experiments would show.
    DetectableEffect of (shown: &ShownEffect, report: &PlanReport<'_>) {
        /// The smallest size of it that all experiments together would show.
        #[serde(flatten)]
        limit: DetectionLimit = DetectionLimit::of(&shown.limit, &report.model.robot),
        /// The experiment that alone would show the smallest; null where it takes several.
        best_log: Option<String> = shown.best_log.map(|log| report.logs[log].name.clone()),
    }
}
