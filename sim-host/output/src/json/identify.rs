//! Numbers that were identified.

use super::finite;
use super::register::RegisteredTracker;
use crate::words::compare::notes;
use crate::words::identify::{headline, is_misfit, plan_headline};
use crate::{IdentifyReport, StiffnessPlanReport};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use trueweld_estimate::identify::plan::LoadKind;
use trueweld_estimate::identify::{CurvePoint, Mode, Number, Section, StiffnessCurve, WeldPart};
use trueweld_logs::HALF_95;
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
    /// Modes seen in ring-downs.
    pub modes: Vec<IdentifiedMode>,
    /// Damping of each joint by the logarithmic decrements alone.
    pub decrements: Vec<DecrementDamping>,
    /// How well the forces are met in the parts of every weld.
    pub sections: Vec<WeldSection>,
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
    /// The value given; null where there was none.
    pub given: Option<f64>,
}

/// A mode of the arm, motors locked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct IdentifiedMode {
    /// The ring-down.
    pub log: String,
    /// Eigenfrequency of the identified M and K, Hz.
    pub natural_hz: f64,
    /// Damped frequency seen by the tracker, Hz, and its 95 % interval.
    pub seen_hz: [f64; 3],
    /// c = (2/T) ln(A₁/A₂) by the tracker alone, 1/s, and its 95 % interval.
    pub decay_1_s: [f64; 3],
    /// c by the identified damping, 1/s.
    pub fitted_decay_1_s: f64,
    /// Damping over critical damping.
    pub damping_ratio: f64,
    /// Share of the mode's energy in each joint's spring.
    pub shares: [f64; 6],
}

/// Damping of a joint by the logarithmic decrements of the modes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct DecrementDamping {
    pub at: String,
    pub value: f64,
    pub low: f64,
    pub high: f64,
    pub unit: String,
}

/// A part of a weld.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WeldSection {
    /// The log.
    pub log: String,
    /// `standing`, `feed-change` or `steady`.
    pub part: String,
    /// How long it is, s.
    pub lasts_s: f64,
    /// √mean((residual/noise)²) of its forces.
    pub score: f64,
    /// Values compared in it.
    pub samples: usize,
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
            given: finite(n.given),
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
        let mode = |m: &Mode| IdentifiedMode {
            log: m.log.clone(),
            natural_hz: m.natural / TAU,
            seen_hz: [0.0, -1.0, 1.0].map(|side| (m.frequency + side * m.frequency_half) / TAU),
            decay_1_s: [0.0, -1.0, 1.0].map(|side| m.decay + side * m.decay_half),
            fitted_decay_1_s: m.fitted,
            damping_ratio: m.ratio,
            shares: m.shares,
        };
        let section = |s: &Section| WeldSection {
            log: s.log.clone(),
            part: match s.part {
                WeldPart::Standing => "standing",
                WeldPart::FeedChange => "feed-change",
                WeldPart::Steady => "steady",
            }
            .to_owned(),
            lasts_s: s.lasts,
            score: s.score,
            samples: s.samples,
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
            modes: found.modes.iter().map(mode).collect(),
            decrements: found
                .decrements
                .iter()
                .zip(&report.model.robot.joint_names)
                .filter_map(|(by, at)| {
                    let by = (*by)?;
                    Some(DecrementDamping {
                        at: at.clone(),
                        value: by.value,
                        low: by.value - by.half,
                        high: by.value + by.half,
                        unit: "N·m·s/rad".to_owned(),
                    })
                })
                .collect(),
            sections: found.sections.iter().map(section).collect(),
            notices: notes(&found.notices),
            registered: RegisteredTracker::all(&found.notices),
        }
    }
}

/// Loads that are to tell the stiffness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StiffnessPlanResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "identify-plan/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// The model file.
    pub model: String,
    /// The protocol that was written.
    pub out: String,
    /// The finding in words.
    pub sentence: String,
    /// The loads, in order.
    pub loads: Vec<PlannedStiffnessLoad>,
    /// What they tell of each joint.
    pub expected: Vec<ExpectedStiffness>,
}

/// A load at a posture.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct PlannedStiffnessLoad {
    pub posture_deg: [f64; 6],
    /// Heaviest payload; null for a push.
    pub payload_kg: Option<f64>,
    /// Largest push, base axes; null for a payload.
    pub force_base_n: Option<[f64; 3]>,
}

/// How well the stiffness of a joint will be told.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ExpectedStiffness {
    /// The joint.
    pub at: String,
    /// Half of the 95 % interval over the value; null where it is not told.
    pub half_share: Option<f64>,
    /// The same of as many loads picked by hand.
    pub by_hand_half_share: Option<f64>,
}

impl StiffnessPlanResult {
    pub(crate) fn of(report: &StiffnessPlanReport<'_>) -> Self {
        let plan = report.plan;
        let half = |deviation: f64| finite(HALF_95 * deviation);
        let load =
            |planned: &trueweld_estimate::identify::plan::PlannedLoad| PlannedStiffnessLoad {
                posture_deg: planned.posture.map(f64::to_degrees).into(),
                payload_kg: (planned.load == LoadKind::Payload).then_some(report.options.payload),
                force_base_n: match planned.load {
                    LoadKind::Payload => None,
                    LoadKind::Push(force) => Some(force.into()),
                },
            };
        let expected = |(j, at): (usize, &String)| ExpectedStiffness {
            at: at.clone(),
            half_share: half(plan.deviations[j]),
            by_hand_half_share: half(plan.by_hand_deviations[j]),
        };
        Self {
            schema: "identify-plan/1".to_owned(),
            provenance: report.provenance.clone(),
            model: report.model.path.display().to_string(),
            out: report.out.display().to_string(),
            sentence: plan_headline(report),
            loads: plan.loads.iter().map(load).collect(),
            expected: report.model.robot.joint_names.iter().enumerate().map(expected).collect(),
        }
    }
}
