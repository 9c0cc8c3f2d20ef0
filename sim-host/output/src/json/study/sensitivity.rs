//! What a weld's figures depend on.

use crate::StudySensitivityReport;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_evaluate::study::{Derivative, WithInterval};
use trueweld_plant::provenance::Provenance;

/// Derivatives and Sobol indices of a weld's figures by what is not known of a cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudySensitivityResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "study-sensitivity/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Length that was welded, m.
    pub length_m: f64,
    /// Seed of the design.
    pub seed: u64,
    /// Rows of the design that count.
    pub rows: usize,
    /// Rows left out since one of their runs came to no end.
    pub rows_dropped: usize,
    /// Runs of the design.
    pub runs: usize,
    /// Inputs of the indices.
    pub inputs: Vec<StudyInput>,
    /// Figure by figure.
    pub figures: Vec<SensitivityFigure>,
}

/// An input of the indices.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StudyInput {
    /// Its name.
    pub name: String,
    /// How many numbers it moves together.
    pub numbers: usize,
}

/// What one figure depends on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SensitivityFigure {
    /// Its key, the unit at its end.
    pub figure: String,
    /// Its value in the cell in the middle of what is not known.
    pub middle: Option<f64>,
    /// Its mean over the cells.
    pub mean: Option<f64>,
    /// Its standard deviation over the cells.
    pub standard_deviation: Option<f64>,
    /// Indices, the largest total first.
    pub indices: Vec<InputIndices>,
    /// Derivatives, the largest first.
    pub derivatives: Vec<InputDerivative>,
}

/// The indices of one input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputIndices {
    /// The input.
    pub input: String,
    /// Share of the variance that the input makes by itself.
    pub first: WithInterval,
    /// Share that it makes with all others.
    pub total: WithInterval,
}

/// The derivative by one input.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InputDerivative {
    /// The input.
    pub input: String,
    /// Per standard deviation of the input, in the figure's unit; `null` where a run came to no end.
    pub derivative: Option<Derivative>,
}

impl StudySensitivityResult {
    pub(crate) fn of(report: &StudySensitivityReport<'_>) -> Self {
        let (global, local) = (report.global, report.local);
        let figures = report.study.figures().filter_map(|figure| {
            let of_global = global.figures.iter().find(|f| f.figure.key == figure.key);
            let of_local = local.figures.iter().find(|f| f.figure.key == figure.key);
            if of_global.is_none() && of_local.is_none() {
                return None;
            }
            Some(SensitivityFigure {
                figure: figure.key.to_owned(),
                middle: of_local.map(|f| f.value),
                mean: of_global.map(|f| f.mean),
                standard_deviation: of_global.map(|f| f.deviation),
                indices: report
                    .ranked(figure.key)
                    .into_iter()
                    .map(|(input, index)| InputIndices {
                        input: input.to_owned(),
                        first: index.first,
                        total: index.total,
                    })
                    .collect(),
                derivatives: report
                    .derivatives(figure.key)
                    .into_iter()
                    .map(|(input, derivative)| InputDerivative {
                        input: input.to_owned(),
                        derivative,
                    })
                    .collect(),
            })
        });
        Self {
            schema: "study-sensitivity/1".to_owned(),
            provenance: report.provenance.clone(),
            length_m: report.length,
            seed: report.study.seed,
            rows: global.rows,
            rows_dropped: global.dropped,
            runs: report.runs.len(),
            inputs: global
                .inputs
                .iter()
                .map(|input| StudyInput { name: input.name.clone(), numbers: input.count() })
                .collect(),
            figures: figures.collect(),
        }
    }
}
