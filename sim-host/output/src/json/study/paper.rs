//! What the published study shows, and the same here.

use crate::StudyPaperReport;
use crate::json::result;
use crate::text::study::paper::{Kind, Statement, statements};
use trueweld_evaluate::laws::NoFigures;
use trueweld_evaluate::study::EnvelopePoint;
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::LimitKind;

result! {
    /// The published statements beside ours, and the push near collinear axes.
    StudyPaperResult<'a> of (report: &StudyPaperReport<'a>) with {
        let envelopes = Kind::ALL.iter().flat_map(|kind| {
            kind.points(report).iter().map(|point| EnvelopeResult::of(kind.name(), point))
        });
    } {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// What is published, and what comes out here.
        statements: Vec<Statement> = statements(report),
        /// Welds at several distances, vertical and inclined.
        envelopes: Vec<EnvelopeResult<'a>> = envelopes.collect(),
    }
}

result! {
    /// One weld at one distance.
    EnvelopeResult<'a> of (name: &'static str, point: &'a EnvelopePoint) with {
        let run = point.outcome.as_ref().ok();
    } {
        /// `vertical` or `inclined`.
        weld: &'static str = name,
        /// Distance of the seam's middle along x of B, m.
        x_m: f64 = point.x,
        /// Least angle between the axes of A4 and A6 over the steady part, rad.
        collinearity_rad: Option<f64> = run.map(|run| run.collinearity),
        /// Largest less smallest push over the steady part, N.
        envelope_n: Option<f64> = run.map(|run| run.figures.force.envelope),
        /// Largest lateral deviation, m.
        lateral_max_m: Option<f64> = run.map(|run| run.figures.lateral.max_abs),
        /// What stood at a limit for longest; `null` where nothing did.
        limit: Option<LimitKind> = run.and_then(|run| Some(run.figures.limits.first()?.kind)),
        /// Why there are no figures.
        failed: Option<&'a NoFigures> = point.outcome.as_ref().err(),
    }
}
