//! Numbers that were identified.

use super::finite;
use super::register::RegisteredTracker;
use crate::IdentifyReport;
use crate::words::compare::notes;
use crate::words::identify::{headline, is_misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_identify::{CurvePoint, Number, StiffnessCurve};
use trueweld_plant::provenance::Provenance;

/// Numbers of a cell that were identified from logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifyResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "identify/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// The model file.
    pub model: String,
    /// `stiffness`, `damping` or `process`.
    pub target: String,
    /// The finding in words.
    pub sentence: String,
    /// False where residuals are well above the noise: something is missing in the model, and the
    /// intervals do not hold the truth.
    pub fits: bool,
    /// √mean((residual/noise)²) with the numbers found.
    pub score: Option<f64>,
    /// The same with the numbers given.
    pub score_before: Option<f64>,
    /// Compared values.
    pub samples: usize,
    /// Names of the logs used.
    pub logs: Vec<String>,
    /// Names of the logs that show nothing of it.
    pub left_out: Vec<String>,
    /// The numbers.
    pub parameters: Vec<IdentifiedNumber>,
    /// Correlation of the numbers' logarithms, in the order of `parameters`, row by row.
    pub correlation: Vec<Vec<Option<f64>>>,
    /// Stiffness over torque.
    pub curves: Vec<StiffnessOverTorque>,
    /// What a reader should know although nothing is wrong.
    pub notices: Vec<String>,
    /// Trackers that stood elsewhere, and were registered first.
    pub registered: Vec<RegisteredTracker>,
}

/// One number of a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedNumber {
    /// Its key in the file.
    pub name: String,
    /// The joint it is of; empty for one of the whole cell.
    pub at: String,
    /// The value found; the one given where the logs do not tell it.
    pub value: f64,
    /// Lower end of the 95 % interval.
    pub low: Option<f64>,
    /// Upper end of the 95 % interval.
    pub high: Option<f64>,
    /// Unit.
    pub unit: String,
    /// False where the logs do not tell it.
    pub identifiable: bool,
    /// The value given.
    pub given: f64,
}

/// Stiffness of one joint over its torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessOverTorque {
    /// The joint.
    pub at: String,
    /// Torque that the curve is reckoned from, N·m.
    pub origin_nm: f64,
    /// Whether the logs leave it possible that the spring is linear.
    pub linear: bool,
    /// Probability that a linear spring shows as much.
    pub chance: Option<f64>,
    /// The points, by torque.
    pub points: Vec<StiffnessPoint>,
}

/// One point of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct StiffnessPoint {
    pub torque_nm: f64,
    /// Secant from the origin.
    pub stiffness_nm_rad: Option<f64>,
    pub low: Option<f64>,
    pub high: Option<f64>,
}

impl IdentifyResult {
    pub(crate) fn of(report: &IdentifyReport<'_>) -> Self {
        let found = report.found;
        let number = |n: &Number| IdentifiedNumber {
            name: n.name.clone(),
            at: n.at.clone(),
            value: n.value,
            low: n.interval.and_then(|i| finite(i[0])),
            high: n.interval.and_then(|i| finite(i[1])),
            unit: n.unit.to_owned(),
            identifiable: n.is_identifiable(),
            given: n.given,
        };
        let point = |p: &CurvePoint| StiffnessPoint {
            torque_nm: p.torque,
            stiffness_nm_rad: finite(p.stiffness),
            low: finite(p.interval[0]),
            high: finite(p.interval[1]),
        };
        let curve = |c: &StiffnessCurve| StiffnessOverTorque {
            at: report.model.robot.joint_names[c.joint].clone(),
            origin_nm: c.origin,
            linear: c.is_linear(),
            chance: finite(c.chance),
            points: c.points.iter().map(point).collect(),
        };
        Self {
            schema: "identify/1".to_owned(),
            provenance: report.provenance.clone(),
            model: report.model.path.display().to_string(),
            target: found.target.name().to_owned(),
            sentence: headline(found),
            fits: !is_misfit(found),
            score: finite(found.score),
            score_before: finite(found.score_before),
            samples: found.samples,
            logs: found.logs.clone(),
            left_out: found.left_out.clone(),
            parameters: found.numbers.iter().map(number).collect(),
            correlation: found
                .correlation
                .row_iter()
                .map(|row| row.iter().map(|c| finite(*c)).collect())
                .collect(),
            curves: found.curves.iter().map(curve).collect(),
            notices: notes(&found.notices),
            registered: RegisteredTracker::all(&found.notices),
        }
    }
}
