//! Numbers that were identified.

use super::register::RegisteredTracker;
use super::{finite, result};
use crate::text::compare::notes;
use crate::text::identify::{headline, is_misfit, plan_headline};
use crate::{IdentifyReport, StiffnessPlanReport};
use std::f64::consts::TAU;
use trueweld_estimate::identify::plan::{LoadKind, PlanOptions, PlannedLoad};
use trueweld_estimate::identify::{
    ByDecrement, CurvePoint, Mode, Number, Section, StiffnessCurve, WeldPart,
};
use trueweld_logs::HALF_95;
use trueweld_plant::provenance::Provenance;

result! {
    /// Numbers of a cell that were identified from logs.
    IdentifyResult of (report: &IdentifyReport<'_>) with {
        let found = report.found;
        let joints = &report.model.robot.joint_names;
        let decrements = found.decrements.iter().zip(joints);
        let rows = found.correlation.row_iter();
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// The model file.
        model: String = report.model.path.display().to_string(),
        /// `stiffness`, `damping` or `process`.
        target: &'static str = found.target.name(),
        /// The finding in words.
        sentence: String = headline(found),
        /// False where residuals are well above the noise: something is missing in the model, and the
        /// intervals do not hold the truth.
        fits: bool = !is_misfit(found),
        /// √mean((residual/noise)²) with the numbers found.
        score: Option<f64> = finite(found.score),
        /// The same with the numbers given.
        score_before: Option<f64> = finite(found.score_before),
        /// Compared values.
        samples: usize = found.samples,
        /// Names of the logs used.
        logs: Vec<String> = found.logs.clone(),
        /// Names of the logs that show nothing of it.
        left_out: Vec<String> = found.left_out.clone(),
        /// The numbers.
        parameters: Vec<IdentifiedNumber> = found.numbers.iter().map(IdentifiedNumber::of).collect(),
        /// Correlation of the numbers' logarithms, in the order of `parameters`, row by row.
        correlation: Vec<Vec<Option<f64>>> =
            rows.map(|row| row.iter().map(|c| finite(*c)).collect()).collect(),
        /// Stiffness over torque.
        curves: Vec<StiffnessOverTorque> =
            found.curves.iter().map(|curve| StiffnessOverTorque::of(curve, joints)).collect(),
        /// Modes seen in ring-downs.
        modes: Vec<IdentifiedMode> = found.modes.iter().map(IdentifiedMode::of).collect(),
        /// Damping of each joint by the logarithmic decrements alone.
        decrements: Vec<DecrementDamping> =
            decrements.filter_map(|(by, at)| Some(DecrementDamping::of(at, (*by)?))).collect(),
        /// How well the forces are met in the parts of every weld.
        sections: Vec<WeldSection> = found.sections.iter().map(WeldSection::of).collect(),
        /// What a reader should know although nothing is wrong.
        notices: Vec<String> = notes(&found.notices),
        /// Trackers that stood elsewhere, and were registered first.
        registered: Vec<RegisteredTracker> = RegisteredTracker::all(&found.notices),
    }
}

result! {
    /// One number of a file.
    IdentifiedNumber of (number: &Number) {
        /// Its key in the file.
        name: String = number.name.clone(),
        /// The joint it is of; empty for one of the whole cell.
        at: String = number.at.clone(),
        /// The value found; the one given where the logs do not tell it.
        value: f64 = number.value,
        /// Lower end of the 95 % interval.
        low: Option<f64> = number.interval.and_then(|ends| finite(ends[0])),
        /// Upper end of the 95 % interval.
        high: Option<f64> = number.interval.and_then(|ends| finite(ends[1])),
        /// Unit.
        unit: &'static str = number.unit,
        /// False where the logs do not tell it.
        identifiable: bool = number.is_identifiable(),
        /// The value given; null where there was none.
        given: Option<f64> = finite(number.given),
    }
}

result! {
    /// A mode of the arm, motors locked.
    IdentifiedMode of (mode: &Mode) with {
        let ends = |value: f64, half: f64| [0.0, -1.0, 1.0].map(|side| value + side * half);
    } {
        /// The ring-down.
        log: String = mode.log.clone(),
        /// Eigenfrequency of the identified M and K, Hz.
        natural_hz: f64 = mode.natural / TAU,
        /// Damped frequency seen by the tracker, Hz, and its 95 % interval.
        seen_hz: [f64; 3] = ends(mode.frequency, mode.frequency_half).map(|rate| rate / TAU),
        /// c = (2/T) ln(A₁/A₂) by the tracker alone, 1/s, and its 95 % interval.
        decay_1_s: [f64; 3] = ends(mode.decay, mode.decay_half),
        /// c by the identified damping, 1/s.
        fitted_decay_1_s: f64 = mode.fitted,
        /// Damping over critical damping.
        damping_ratio: f64 = mode.ratio,
        /// Share of the mode's energy in each joint's spring.
        shares: [f64; 6] = mode.shares,
    }
}

result! {
    /// Damping of a joint by the logarithmic decrements of the modes.
    DecrementDamping of (joint: &str, by: ByDecrement) {
        at: String = joint.to_owned(),
        value: f64 = by.value,
        low: f64 = by.value - by.half,
        high: f64 = by.value + by.half,
        unit: &'static str = "N·m·s/rad",
    }
}

result! {
    /// A part of a weld.
    WeldSection of (section: &Section) {
        /// The log.
        log: String = section.log.clone(),
        /// `standing`, `feed-change` or `steady`.
        part: &'static str = match section.part {
            WeldPart::Standing => "standing",
            WeldPart::FeedChange => "feed-change",
            WeldPart::Steady => "steady",
        },
        /// How long it is, s.
        lasts_s: f64 = section.lasts,
        /// √mean((residual/noise)²) of its forces.
        score: f64 = section.score,
        /// Values compared in it.
        samples: usize = section.samples,
    }
}

result! {
    /// Stiffness of one joint over its torque.
    StiffnessOverTorque of (curve: &StiffnessCurve, joints: &[String]) {
        /// The joint.
        at: String = joints[curve.joint].clone(),
        /// Torque that the curve is reckoned from, N·m.
        origin_nm: f64 = curve.origin,
        /// Whether the logs leave it possible that the spring is linear.
        linear: bool = curve.is_linear(),
        /// Probability that a linear spring shows as much.
        chance: Option<f64> = finite(curve.chance),
        /// The points, by torque.
        points: Vec<StiffnessPoint> = curve.points.iter().map(StiffnessPoint::of).collect(),
    }
}

result! {
    /// One point of it.
    StiffnessPoint of (point: &CurvePoint) {
        torque_nm: f64 = point.torque,
        /// Secant from the origin.
        stiffness_nm_rad: Option<f64> = finite(point.stiffness),
        low: Option<f64> = finite(point.interval[0]),
        high: Option<f64> = finite(point.interval[1]),
    }
}

result! {
    /// Loads that are to tell the stiffness.
    StiffnessPlanResult of (report: &StiffnessPlanReport<'_>) with {
        let StiffnessPlanReport { plan, options, model, .. } = *report;
        let deviations = plan.deviations.iter().zip(&plan.by_hand_deviations);
        let joints = model.robot.joint_names.iter().zip(deviations);
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// The model file.
        model: String = model.path.display().to_string(),
        /// The protocol that was written.
        out: String = report.out.display().to_string(),
        /// The finding in words.
        sentence: String = plan_headline(report),
        /// The loads, in order.
        loads: Vec<PlannedStiffnessLoad> =
            plan.loads.iter().map(|load| PlannedStiffnessLoad::of(load, options)).collect(),
        /// What they tell of each joint.
        expected: Vec<ExpectedStiffness> =
            joints.map(|(at, (ours, by_hand))| ExpectedStiffness::of(at, *ours, *by_hand)).collect(),
    }
}

result! {
    /// A load at a posture.
    PlannedStiffnessLoad of (planned: &PlannedLoad, options: &PlanOptions) {
        posture_deg: [f64; 6] = planned.posture.map(f64::to_degrees).into(),
        /// Heaviest payload; null for a push.
        payload_kg: Option<f64> = (planned.load == LoadKind::Payload).then_some(options.payload),
        /// Largest push, base axes; null for a payload.
        force_base_n: Option<[f64; 3]> = match planned.load {
            LoadKind::Payload => None,
            LoadKind::Push(force) => Some(force.into()),
        },
    }
}

result! {
    /// How well the stiffness of a joint will be told.
    ExpectedStiffness of (joint: &str, deviation: f64, by_hand: f64) {
        /// The joint.
        at: String = joint.to_owned(),
        /// Half of the 95 % interval over the value; null where it is not told.
        half_share: Option<f64> = finite(HALF_95 * deviation),
        /// The same of as many loads picked by hand.
        by_hand_half_share: Option<f64> = finite(HALF_95 * by_hand),
    }
}
