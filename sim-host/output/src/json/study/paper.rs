//! What the published study shows, and the same here.

use crate::StudyPaperReport;
use crate::words::study::paper::{Kind, Statement, statements};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_evaluate::study::EnvelopePoint;
use trueweld_plant::provenance::Provenance;

/// The published statements beside ours, and the push near collinear axes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyPaperResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "study-paper/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// What is published, and what comes out here.
    pub statements: Vec<PublishedStatement>,
    /// Welds at several distances, vertical and inclined.
    pub envelopes: Vec<EnvelopeResult>,
}

/// A published statement.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PublishedStatement {
    /// What it is of.
    pub what: String,
    /// As published, in words.
    pub published: String,
    /// Ours, in words.
    pub ours: String,
    /// True where the gains were searched for it, so that it confirms nothing of the model.
    pub tuned: bool,
    /// Whether ours agrees; `null` where nothing measurable is published.
    pub agrees: Option<bool>,
}

/// One weld at one distance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EnvelopeResult {
    /// `vertical` or `inclined`.
    pub weld: String,
    /// Distance of the seam's middle along x of B, m.
    pub x_m: f64,
    /// Least angle between the axes of A4 and A6 over the steady part, rad.
    pub collinearity_rad: Option<f64>,
    /// Largest less smallest push over the steady part, N.
    pub envelope_n: Option<f64>,
    /// Largest lateral deviation, m.
    pub lateral_max_m: Option<f64>,
    /// What stood at a limit for longest; `null` where nothing did.
    pub limit: Option<String>,
    /// Why there are no figures.
    pub failed: Option<String>,
}

impl StudyPaperResult {
    pub(crate) fn of(report: &StudyPaperReport<'_>) -> Self {
        let kinds = Kind::ALL.iter().flat_map(|kind| {
            kind.points(report).iter().map(|point| EnvelopeResult::of(kind.name(), point))
        });
        Self {
            schema: "study-paper/1".to_owned(),
            provenance: report.provenance.clone(),
            statements: statements(report).into_iter().map(PublishedStatement::of).collect(),
            envelopes: kinds.collect(),
        }
    }
}

impl PublishedStatement {
    fn of(Statement { what, published, ours, tuned, agrees }: Statement) -> Self {
        Self { what, published, ours, tuned, agrees }
    }
}

impl EnvelopeResult {
    fn of(weld: &str, point: &EnvelopePoint) -> Self {
        let run = point.outcome.as_ref().ok();
        Self {
            weld: weld.to_owned(),
            x_m: point.x,
            collinearity_rad: run.map(|run| run.collinearity),
            envelope_n: run.map(|run| run.figures.force.envelope),
            lateral_max_m: run.map(|run| run.figures.lateral.max_abs),
            limit: run.and_then(|run| Some(run.figures.limits.first()?.kind.to_string())),
            failed: point.outcome.as_ref().err().map(ToString::to_string),
        }
    }
}
