//! How far a weld can be driven.

use crate::StudyLimitsReport;
use crate::json::finite;
use crate::words::study::limits::because;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_evaluate::study::{FoundLimit, Placement};
use trueweld_plant::provenance::Provenance;

/// The largest push, feed and offset that keep requirements, at one place or several.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyLimitsResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "study-limits/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Length that was welded, m.
    pub length_m: f64,
    /// Place by place, the weld's own first.
    pub places: Vec<PlaceLimits>,
    /// Places asked for that the arm does not reach.
    pub out_of_reach: usize,
}

/// The limits at one place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlaceLimits {
    /// Where.
    pub placement: Placement,
    /// What was driven.
    pub limits: Vec<LimitResult>,
}

/// How far something can be driven.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitResult {
    /// What: `force_n`, `feed_m_s` or `offset_m`.
    pub driven: String,
    /// What the weld's file states of it.
    pub nominal: f64,
    /// The largest value that keeps the requirements, SI units; `null` where none looked at does.
    pub largest: Option<f64>,
    /// The value just beyond it that does not; `null` where the whole range keeps them.
    pub beyond: Option<f64>,
    /// What limits, in words.
    pub because: String,
    /// Requirements are kept again at this value beyond the edge.
    pub kept_again: Option<f64>,
    /// Every run.
    pub runs: Vec<LimitRun>,
}

/// One run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LimitRun {
    /// Value of what is driven, SI units.
    pub value: f64,
    /// The figure that takes the largest share of its limit.
    pub figure: Option<String>,
    /// That share; `null` where the run came to no end.
    pub share: Option<f64>,
    /// What stood at a limit, the longest first.
    pub limits: Vec<String>,
    /// Why there are no figures.
    pub failed: Option<String>,
}

impl StudyLimitsResult {
    pub(crate) fn of(report: &StudyLimitsReport<'_>) -> Self {
        Self {
            schema: "study-limits/1".to_owned(),
            provenance: report.provenance.clone(),
            length_m: report.length,
            places: report
                .places
                .iter()
                .map(|place| PlaceLimits {
                    placement: place.at,
                    limits: place.limits.iter().map(LimitResult::of).collect(),
                })
                .collect(),
            out_of_reach: report.out_of_reach,
        }
    }
}

impl LimitResult {
    fn of(found: &FoundLimit) -> Self {
        let runs = found.probes.iter().map(|probe| LimitRun {
            value: probe.value,
            figure: probe.figure.map(|figure| figure.key.to_owned()),
            share: finite(probe.share),
            limits: probe.held.iter().map(ToString::to_string).collect(),
            failed: probe.failed.as_ref().map(ToString::to_string),
        });
        Self {
            driven: found.driven.name().to_owned(),
            nominal: found.nominal,
            largest: found.largest,
            beyond: found.beyond.as_ref().map(|probe| probe.value),
            because: because(found),
            kept_again: found.kept_again,
            runs: runs.collect(),
        }
    }
}
