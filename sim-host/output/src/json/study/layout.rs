//! A part that is placed.

use crate::StudyLayoutReport;
use crate::json::finite;
use crate::words::study::layout::{out_of_reach, posture};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueweld_evaluate::margins::MARGIN_FIGURES;
use trueweld_evaluate::study::{
    Allowance, Confirmation, ConfirmedWeld, Limiting, MARGINS_ASKED, PlacedPart, Placement,
    WAY_FIGURES, more_is_better,
};
use trueweld_plant::provenance::Provenance;

/// Where a part is best put, and what it is worth there by full runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyLayoutResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "study-layout/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// What is allowed.
    pub allowed: Vec<AllowedFigure>,
    /// Placements of the grid.
    pub placements: usize,
    /// Those that the arm reaches.
    pub reached: usize,
    /// Those within all that is allowed.
    pub within: usize,
    /// Where the files have the part; `null` where the arm does not reach it.
    pub filed: Option<ConfirmedPlacement>,
    /// Why it does not.
    pub filed_out_of_reach: Option<String>,
    /// The best placement.
    pub chosen: ConfirmedPlacement,
    /// Figures that the front is of.
    pub front_of: Vec<String>,
    /// Placements of the grid that no other one is better than in all of them.
    pub front: Vec<PlacementFigures>,
}

/// The most, or the least, that a figure may be.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AllowedFigure {
    /// Its key.
    pub figure: String,
    /// The limit, SI units.
    pub limit: f64,
    /// True where it is the least.
    pub at_least: bool,
}

/// A placement and what statics have of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlacementFigures {
    /// Where.
    pub placement: Placement,
    /// The arm's posture at every seam.
    pub postures: Vec<String>,
    /// Figures by their keys, the worst of all seams, SI units.
    pub figures: BTreeMap<String, f64>,
    /// The largest share of what is allowed.
    pub share: f64,
    /// The figure that takes it.
    pub limiting: String,
    /// The largest share that deviation and tilt take of what they are allowed: what is made least
    /// where all reserves are kept.
    pub deviation_share: f64,
    /// The figure that takes it.
    pub deviation_limiting: String,
}

/// A placement with its full runs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConfirmedPlacement {
    /// By statics.
    pub statics: PlacementFigures,
    /// Full runs.
    pub welds: Vec<ConfirmedWeldResult>,
    /// The least of every margin of the loop, at both ends and in the middle of every seam, SI units.
    pub margins: BTreeMap<String, f64>,
}

/// A full run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ConfirmedWeldResult {
    /// Number of the seam, from 1.
    pub seam: usize,
    /// Name of the law.
    pub law: String,
    /// Largest lateral deviation, m.
    pub lateral_max_m: Option<f64>,
    /// Lateral deviation, RMS, m.
    pub lateral_rms_m: Option<f64>,
    /// Largest deviation along the seam, m.
    pub longitudinal_max_m: Option<f64>,
    /// Largest tilt, rad.
    pub tilt_max_rad: Option<f64>,
    /// Largest less smallest push, N.
    pub push_envelope_n: Option<f64>,
    /// Whether it is the weld that was asked for.
    pub met: bool,
    /// What stood at a limit, the longest first.
    pub limits: Vec<String>,
    /// Why there are no figures.
    pub failed: Option<String>,
}

impl StudyLayoutResult {
    pub(crate) fn of(report: &StudyLayoutReport<'_>) -> Self {
        let allowed = report.task.allowed;
        let reached = || report.grid.iter().filter_map(|placed| placed.outcome.as_ref().ok());
        let key = |figure: &usize| WAY_FIGURES[*figure].figure.key.to_owned();
        Self {
            schema: "study-layout/1".to_owned(),
            provenance: report.provenance.clone(),
            allowed: allowed
                .iter()
                .map(|of| AllowedFigure {
                    figure: key(&of.figure),
                    limit: of.limit,
                    at_least: more_is_better(of.figure),
                })
                .collect(),
            placements: report.grid.len(),
            reached: reached().count(),
            within: reached().filter(|placed| placed.limiting().share <= 1.0).count(),
            filed: report.filed.as_ref().ok().map(|of| ConfirmedPlacement::of(of, allowed)),
            filed_out_of_reach: report.filed.as_ref().err().map(|why| out_of_reach(*why)),
            chosen: ConfirmedPlacement::of(report.chosen, allowed),
            front_of: report.front_of.iter().map(key).collect(),
            front: report.front.iter().map(|of| PlacementFigures::of(of, allowed)).collect(),
        }
    }
}

impl PlacementFigures {
    fn of(placed: &PlacedPart, allowed: &[Allowance]) -> Self {
        let figures = WAY_FIGURES.iter().zip(placed.values);
        let key = |of: &Limiting| WAY_FIGURES[allowed[of.allowance].figure].figure.key.to_owned();
        let limiting = placed.limiting();
        Self {
            placement: placed.placement,
            postures: placed.branches.iter().map(|branch| posture(*branch)).collect(),
            figures: figures.map(|(of, value)| (of.figure.key.to_owned(), value)).collect(),
            share: limiting.share,
            limiting: key(&limiting),
            deviation_share: placed.deviation.share,
            deviation_limiting: key(&placed.deviation),
        }
    }
}

impl ConfirmedPlacement {
    fn of(confirmed: &Confirmation, allowed: &[Allowance]) -> Self {
        let margins = confirmed.margins.as_ref().map_or(&[][..], Vec::as_slice);
        let least = MARGIN_FIGURES.iter().take(MARGINS_ASKED).filter_map(|of| {
            let least = margins.iter().map(|m| (of.value)(m).0).fold(f64::INFINITY, f64::min);
            Some((of.figure.key.to_owned(), finite(least)?))
        });
        Self {
            statics: PlacementFigures::of(&confirmed.placed, allowed),
            welds: confirmed.welds.iter().map(ConfirmedWeldResult::of).collect(),
            margins: least.collect(),
        }
    }
}

impl ConfirmedWeldResult {
    fn of(weld: &ConfirmedWeld) -> Self {
        let figures = weld.outcome.as_ref().ok().map(|(figures, _)| figures);
        let limits = figures.map_or(&[][..], |figures| &figures.limits);
        Self {
            seam: weld.seam + 1,
            law: weld.law.clone(),
            lateral_max_m: figures.map(|f| f.lateral.max_abs),
            lateral_rms_m: figures.map(|f| f.lateral.rms),
            longitudinal_max_m: figures.map(|f| f.longitudinal.max_abs),
            tilt_max_rad: figures.map(|f| f.tilt.max_abs),
            push_envelope_n: figures.map(|f| f.force.envelope),
            met: figures.is_some_and(|f| f.is_met()),
            limits: limits.iter().map(|span| span.kind.to_string()).collect(),
            failed: weld.outcome.as_ref().err().map(ToString::to_string),
        }
    }
}
