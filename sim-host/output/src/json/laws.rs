//! Laws side by side.

use super::result;
use crate::LawsReport;
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_compensators::Entry;
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::laws::{ScenarioChange, ScenarioSweep, SweepPoint, VariedQuantity};
use trueweld_plant::provenance::Provenance;

result! {
    /// Compensation laws on one weld, over a wrong stiffness, noise, delay and lost sensors.
    LawsResult<'a> of (report: &LawsReport<'a>) with {
        let comparison = report.comparison;
        let scenario = &comparison.scenario;
    } {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// Name of the weld.
        weld: &'a str = scenario.name,
        /// Name of the hybrid controller.
        controller: &'static str = scenario.controller.name(),
        /// Seed of the sensors' noise.
        seed: u64 = scenario.seed,
        /// Control period, s.
        control_period_s: f64 = scenario.control.period,
        /// Error of the believed stiffness in the sweeps of something else, as a share.
        stiffness_error_where_not_varied: f64 = comparison.stiffness_error,
        /// What the lateral deviation is to stay within, RMS, m.
        lateral_rms_limit_m: Option<f64> = report.limit,
        /// The laws, in the order of all results.
        laws: Vec<ComparedLaw> = {
            let passes = |law: &Entry| comparison.passes_of(law);
            comparison.laws.iter().map(|law| ComparedLaw::of(law, passes(law))).collect()
        },
        /// What was varied, one quantity after the other.
        sweeps: Vec<LawSweep> =
            report.sweeps.iter().map(|sweep| LawSweep::of(sweep, comparison.laws)).collect(),
    }
}

result! {
    /// A law and how often it welds the seam before it counts.
    ComparedLaw of (law: &Entry, welds: usize) {
        /// Name of the law.
        name: String = law.name().to_owned(),
        /// Welds of the seam; the last one counts.
        passes: usize = welds,
    }
}

result! {
    /// All laws over one varied quantity.
    LawSweep of (sweep: &ScenarioSweep, laws: &[Entry]) with {
        let laws = laws.iter().zip(&sweep.points);
        let quantity = sweep.quantity;
    } {
        /// Key of the quantity in the points.
        varied: VariedQuantity = quantity,
        /// Every law's points.
        results: Vec<LawPoints> =
            laws.map(|(law, points)| LawPoints::of(law, quantity, points)).collect(),
    }
}

result! {
    /// One law over one varied quantity.
    LawPoints of (entry: &Entry, quantity: VariedQuantity, of_law: &[SweepPoint]) with {
        let changes = quantity.changes().iter();
    } {
        /// Name of the law.
        law: String = entry.name().to_owned(),
        /// One weld a value of the quantity.
        points: Vec<LawPoint> =
            changes.zip(of_law).map(|(change, point)| LawPoint::of(*change, point)).collect(),
    }
}

/// One weld: its figures or why it has none, and the value of what was varied.
#[derive(Clone, Default, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub(crate) struct LawPoint {
    /// Lateral deviation, RMS, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    lateral_rms_m: Option<f64>,
    /// Lateral deviation, largest, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    lateral_max_m: Option<f64>,
    /// Tilt across the seam, RMS, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    side_tilt_rms_rad: Option<f64>,
    /// Tilt along the seam, RMS, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    travel_angle_rms_rad: Option<f64>,
    /// Why the weld was not made.
    #[serde(skip_serializing_if = "Option::is_none")]
    failed: Option<String>,
    /// Error of the believed stiffness, as a share.
    #[serde(skip_serializing_if = "Option::is_none")]
    stiffness_error: Option<f64>,
    /// Factor on the noise of force and seam sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    noise_factor: Option<f64>,
    /// Delay of force and seam sensor, control periods.
    #[serde(skip_serializing_if = "Option::is_none")]
    delay_periods: Option<f64>,
    /// Share of the seam sensor's readings that are lost.
    #[serde(skip_serializing_if = "Option::is_none")]
    lost_share: Option<f64>,
    /// Whether they are lost in the last pass alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    only_in_last_pass: Option<bool>,
    /// Whether the force sensor dies half-way.
    #[serde(skip_serializing_if = "Option::is_none")]
    force_sensor_dies: Option<bool>,
}

impl LawPoint {
    fn of(change: ScenarioChange, point: &SweepPoint) -> Self {
        let figure = |of: fn(&WeldFigures) -> f64| point.as_ref().ok().map(of);
        let figures = Self {
            lateral_rms_m: figure(|f| f.lateral.rms),
            lateral_max_m: figure(|f| f.lateral.max_abs),
            side_tilt_rms_rad: figure(|f| f.side_tilt.rms),
            travel_angle_rms_rad: figure(|f| f.travel_angle.rms),
            failed: point.as_ref().err().map(ToString::to_string),
            ..Self::default()
        };
        let lost = |share: f64, last: bool, force: bool| Self {
            lost_share: Some(share),
            only_in_last_pass: Some(last),
            force_sensor_dies: Some(force),
            ..figures.clone()
        };
        match change {
            ScenarioChange::StiffnessError(error) => {
                Self { stiffness_error: Some(error), ..figures }
            }
            ScenarioChange::Noise(factor) => Self { noise_factor: Some(factor), ..figures },
            ScenarioChange::Delay(periods) => Self { delay_periods: Some(periods), ..figures },
            ScenarioChange::Lost(share) => lost(share, false, false),
            ScenarioChange::DeadInLastPass => lost(1.0, true, false),
            ScenarioChange::ForceSensorDies => lost(0.0, false, true),
        }
    }
}
