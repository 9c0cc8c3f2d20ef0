//! A part that is placed.

use crate::StudyLayoutReport;
use crate::json::{finite, result};
use crate::text::study::layout::{out_of_reach, posture};
use std::collections::BTreeMap;
use trueweld_evaluate::laws::NoFigures;
use trueweld_evaluate::margins::MARGIN_FIGURES;
use trueweld_evaluate::study::{
    Allowance, Confirmation, ConfirmedWeld, Limiting, MARGINS_ASKED, PlacedPart, Placement,
    WAY_FIGURES, more_is_better,
};
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::LimitKind;

/// Key of a figure of a way along a seam.
fn key(figure: usize) -> &'static str {
    WAY_FIGURES[figure].figure.key
}

result! {
    /// Where a part is best put, and what it is worth there by full runs.
    StudyLayoutResult<'a> of (report: &StudyLayoutReport<'a>) with {
        let asked = report.task.allowed;
        let reached: Vec<&PlacedPart> =
            report.grid.iter().filter_map(|placed| placed.outcome.as_ref().ok()).collect();
    } {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// What is allowed.
        allowed: Vec<AllowedFigure> = asked.iter().map(AllowedFigure::of).collect(),
        /// Placements of the grid.
        placements: usize = report.grid.len(),
        /// Those that the arm reaches.
        reached: usize = reached.len(),
        /// Those within all that is allowed.
        within: usize = reached.iter().filter(|placed| placed.limiting().share <= 1.0).count(),
        /// Where the files have the part; `null` where the arm does not reach it.
        filed: Option<ConfirmedPlacement<'a>> =
            report.filed.as_ref().ok().map(|of| ConfirmedPlacement::of(of, asked)),
        /// Why it does not.
        filed_out_of_reach: Option<String> = report.filed.as_ref().err().map(|why| out_of_reach(*why)),
        /// The best placement.
        chosen: ConfirmedPlacement<'a> = ConfirmedPlacement::of(report.chosen, asked),
        /// Figures that the front is of.
        front_of: Vec<&'static str> = report.front_of.iter().map(|figure| key(*figure)).collect(),
        /// Placements of the grid that no other one is better than in all of them.
        front: Vec<PlacementFigures> =
            report.front.iter().map(|of| PlacementFigures::of(of, asked)).collect(),
    }
}

result! {
    /// The most, or the least, that a figure may be.
    AllowedFigure of (of: &Allowance) {
        /// Its key.
        figure: &'static str = key(of.figure),
        /// The limit, SI units.
        limit: f64 = of.limit,
        /// True where it is the least.
        at_least: bool = more_is_better(of.figure),
    }
}

result! {
    /// A placement and what statics have of it.
    PlacementFigures of (placed: &PlacedPart, allowed: &[Allowance]) with {
        let values = WAY_FIGURES.iter().zip(placed.values);
        let limits = |of: &Limiting| key(allowed[of.allowance].figure);
        let limiting = placed.limiting();
    } {
        /// Where.
        placement: Placement = placed.placement,
        /// The arm's posture at every seam.
        postures: Vec<String> = placed.branches.iter().map(|branch| posture(*branch)).collect(),
        /// Figures by their keys, the worst of all seams, SI units.
        figures: BTreeMap<&'static str, f64> =
            values.map(|(of, value)| (of.figure.key, value)).collect(),
        /// The largest share of what is allowed.
        share: f64 = limiting.share,
        /// The figure that takes it.
        limiting: &'static str = limits(&limiting),
        /// The largest share that deviation and tilt take of what they are allowed: what is made least
        /// where all reserves are kept.
        deviation_share: f64 = placed.deviation.share,
        /// The figure that takes it.
        deviation_limiting: &'static str = limits(&placed.deviation),
    }
}

result! {
    /// A placement with its full runs.
    ConfirmedPlacement<'a> of (confirmed: &'a Confirmation, allowed: &[Allowance]) with {
        let loops = confirmed.margins.as_ref().map_or(&[][..], Vec::as_slice);
        let least = MARGIN_FIGURES.iter().take(MARGINS_ASKED).filter_map(|of| {
            let least = loops.iter().map(|m| (of.value)(m).0).fold(f64::INFINITY, f64::min);
            Some((of.figure.key, finite(least)?))
        });
    } {
        /// By statics.
        statics: PlacementFigures = PlacementFigures::of(&confirmed.placed, allowed),
        /// Full runs.
        welds: Vec<ConfirmedWeldResult<'a>> =
            confirmed.welds.iter().map(ConfirmedWeldResult::of).collect(),
        /// The least of every margin of the loop, at both ends and in the middle of every seam, SI units.
        margins: BTreeMap<&'static str, f64> = least.collect(),
    }
}

result! {
    /// A full run.
    ConfirmedWeldResult<'a> of (weld: &'a ConfirmedWeld) with {
        let figures = weld.outcome.as_ref().ok().map(|(figures, _)| figures);
        let limits = figures.map_or(&[][..], |figures| &figures.limits);
    } {
        /// Number of the seam, from 1.
        seam: usize = weld.seam + 1,
        /// Name of the law.
        law: &'a str = &weld.law,
        /// Largest lateral deviation, m.
        lateral_max_m: Option<f64> = figures.map(|f| f.lateral.max_abs),
        /// Lateral deviation, RMS, m.
        lateral_rms_m: Option<f64> = figures.map(|f| f.lateral.rms),
        /// Largest deviation along the seam, m.
        longitudinal_max_m: Option<f64> = figures.map(|f| f.longitudinal.max_abs),
        /// Largest tilt, rad.
        tilt_max_rad: Option<f64> = figures.map(|f| f.tilt.max_abs),
        /// Largest less smallest push, N.
        push_envelope_n: Option<f64> = figures.map(|f| f.force.envelope),
        /// Whether it is the weld that was asked for.
        met: bool = figures.is_some_and(|f| f.met),
        /// What stood at a limit, the longest first.
        limits: Vec<LimitKind> = limits.iter().map(|span| span.kind).collect(),
        /// Why there are no figures.
        failed: Option<&'a NoFigures> = weld.outcome.as_ref().err(),
    }
}
