//! Laws side by side.

use super::result;
use crate::LawsReport;
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

result! {
    /// One weld: its figures or why it has none, and the value of what was varied.
    LawPoint of (change: ScenarioChange, point: &SweepPoint) with {
        let figure = |of: fn(&WeldFigures) -> f64| point.as_ref().ok().map(of);
        let lost = match change {
            ScenarioChange::Lost(share) => Some((share, false, false)),
            ScenarioChange::DeadInLastPass => Some((1.0, true, false)),
            ScenarioChange::ForceSensorDies => Some((0.0, false, true)),
            _ => None,
        };
    } {
        /// Lateral deviation, RMS, m.
        #[serde(skip_serializing_if = "Option::is_none")]
        lateral_rms_m: Option<f64> = figure(|f| f.lateral.rms),
        /// Lateral deviation, largest, m.
        #[serde(skip_serializing_if = "Option::is_none")]
        lateral_max_m: Option<f64> = figure(|f| f.lateral.max_abs),
        /// Tilt across the seam, RMS, rad.
        #[serde(skip_serializing_if = "Option::is_none")]
        side_tilt_rms_rad: Option<f64> = figure(|f| f.side_tilt.rms),
        /// Tilt along the seam, RMS, rad.
        #[serde(skip_serializing_if = "Option::is_none")]
        travel_angle_rms_rad: Option<f64> = figure(|f| f.travel_angle.rms),
        /// Why the weld was not made.
        #[serde(skip_serializing_if = "Option::is_none")]
        failed: Option<String> = point.as_ref().err().map(ToString::to_string),
        /// Error of the believed stiffness, as a share.
        #[serde(skip_serializing_if = "Option::is_none")]
        stiffness_error: Option<f64> = match change {
            ScenarioChange::StiffnessError(error) => Some(error),
            _ => None,
        },
        /// Factor on the noise of force and seam sensor.
        #[serde(skip_serializing_if = "Option::is_none")]
        noise_factor: Option<f64> = match change {
            ScenarioChange::Noise(factor) => Some(factor),
            _ => None,
        },
        /// Delay of force and seam sensor, control periods.
        #[serde(skip_serializing_if = "Option::is_none")]
        delay_periods: Option<f64> = match change {
            ScenarioChange::Delay(periods) => Some(periods),
            _ => None,
        },
        /// Share of the seam sensor's readings that are lost.
        #[serde(skip_serializing_if = "Option::is_none")]
        lost_share: Option<f64> = lost.map(|(share, ..)| share),
        /// Whether they are lost in the last pass alone.
        #[serde(skip_serializing_if = "Option::is_none")]
        only_in_last_pass: Option<bool> = lost.map(|(_, last, _)| last),
        /// Whether the force sensor dies half-way.
        #[serde(skip_serializing_if = "Option::is_none")]
        force_sensor_dies: Option<bool> = lost.map(|(.., force)| force),
    }
}
