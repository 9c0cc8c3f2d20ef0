//! Units of one type, improved and laid beside each other.

use super::improve::ImproveResult;
use super::result;
use crate::text::improve_fleet::{headline, reason};
use crate::{ImproveFleetReport, ImproveReport};
use trueweld_diagnose::fleet::{FleetEffect, FleetParameter, Outlier};
use trueweld_estimate::random_effects::{LeftOutUnit, UnitValue};
use trueweld_logs::HALF_95;
use trueweld_plant::effects::Parameter;
use trueweld_plant::provenance::Provenance;

result! {
    /// Units of one type: what each has, and what they share.
    ImproveFleetResult of (report: &ImproveFleetReport<'_>) with {
        let (fleet, units) = (report.fleet, report.units.iter());
        let all = |of: &[FleetEffect]| of.iter().map(|e| FleetEffectValues::of(e, report)).collect();
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// The result in words.
        sentence: String = headline(report),
        /// Every unit.
        units: Vec<FleetUnit> = units.map(|(name, of)| FleetUnit::of(name, of)).collect(),
        /// Effects that any unit has.
        effects: Vec<FleetEffectValues> = all(&fleet.effects),
        /// Calibrations of the cell that count in any unit; those that a log or a day has of its own
        /// stand in each unit's result.
        calibration: Vec<FleetEffectValues> = all(&fleet.calibrations),
        /// Units unlike the others; null of two units, where nothing can say which is the odd one.
        outliers: Option<Vec<OutlyingUnit>> = fleet.outliers.as_ref().map(|all| {
            all.iter().map(|outlier| OutlyingUnit::of(outlier, report)).collect()
        }),
    }
}

result! {
    /// A unit.
    FleetUnit of (name: &str, report: &ImproveReport<'_>) {
        /// Its name.
        unit: String = name.to_owned(),
        /// What `improve` finds of it alone.
        result: ImproveResult = ImproveResult::of(report),
    }
}

result! {
    /// An effect over all units.
    FleetEffectValues of (of: &FleetEffect, report: &ImproveFleetReport<'_>) with {
        let (effect, robot) = (&of.effect, report.robot());
        let parameters = effect.kind.parameters.iter().zip(&of.parameters);
    } {
        /// The effect.
        effect: &'static str = effect.kind.id,
        /// What it is at.
        at: String = effect.at.name(robot).to_owned(),
        /// True where every unit has it.
        shared: bool = of.is_shared(),
        /// Of each unit: `named` by its own logs, `measured` to be there although they do not name it,
        /// `absent`, or `unknown`.
        units: Vec<&'static str> = of.presence.iter().map(|p| p.name()).collect(),
        /// Its parameters.
        parameters: Vec<FleetParameterValues> =
            parameters.map(|(kind, of)| FleetParameterValues::of(kind, of)).collect(),
    }
}

result! {
    /// A parameter over all units.
    FleetParameterValues of (kind: &Parameter, of: &FleetParameter) with {
        let fleet = of.fleet.as_ref();
        let units = of.units.iter().zip(&of.left_out);
    } {
        /// Its name.
        name: &'static str = kind.name,
        /// Unit of all numbers but distance and probability.
        unit: &'static str = kind.unit,
        /// Mean of the type, by the units that have the effect; null of fewer than two.
        mean: Option<f64> = fleet.map(|f| f.mean),
        /// 95 % interval of the mean.
        mean_interval: Option<[f64; 2]> = fleet.map(|f| f.mean_interval),
        /// Standard deviation between units, beyond what their own uncertainty makes.
        spread: Option<f64> = fleet.map(|f| f.spread),
        /// 95 % interval of the spread.
        spread_interval: Option<[f64; 2]> = fleet.map(|f| f.spread_interval),
        /// Each unit's value; null where its logs say next to nothing of it.
        units: Vec<Option<FleetValue>> = units
            .map(|(value, left_out)| Some(FleetValue::of(value.as_ref()?, left_out.as_ref())))
            .collect(),
    }
}

result! {
    /// A value of a unit, by its own logs alone: not drawn towards the mean of the type.
    FleetValue of (of: &UnitValue, left_out: Option<&LeftOutUnit>) {
        value: f64 = of.value,
        low: f64 = of.value - HALF_95 * of.deviation,
        high: f64 = of.value + HALF_95 * of.deviation,
        /// Distance from the mean of the other units over what it varies by; null of fewer than three.
        distance: Option<f64> = left_out.map(|of| of.distance),
        /// Probability that a unit of the type is as far away.
        probability: Option<f64> = left_out.map(|of| of.probability),
    }
}

result! {
    /// A unit unlike the others.
    OutlyingUnit of (of: &Outlier, report: &ImproveFleetReport<'_>) {
        /// Its name.
        unit: String = report.units[of.unit].0.to_owned(),
        /// Why.
        reasons: Vec<String> = of.reasons.iter().map(|why| reason(*why, of.unit, report)).collect(),
    }
}
