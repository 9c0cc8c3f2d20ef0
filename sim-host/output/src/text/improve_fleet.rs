//! What is said of units of one type.

use super::diagnose::spoken;
use super::{Scale, counted, listed};
use crate::ImproveFleetReport;
use trueweld_diagnose::fleet::{FleetEffect, FleetParameter, Outlier, OutlierReason, Presence};
use trueweld_estimate::random_effects::UnitValue;
use trueweld_logs::HALF_95;
use trueweld_plant::effects::Parameter;

/// What the units share, and which is unlike the others.
pub(crate) fn headline(report: &ImproveFleetReport<'_>) -> String {
    let fleet = report.fleet;
    let shared = fleet.effects.iter().filter(|effect| effect.is_shared());
    let shared: Vec<String> = shared.map(|e| e.effect.name(report.robot())).collect();
    let units = report.units.len();
    let share = match shared.as_slice() {
        [] => format!("{units} units: no effect is known to be in all of them."),
        names => format!("{units} units share {}.", listed(names, "and")),
    };
    let outlier = |of: &Outlier| {
        let why = of.reasons.iter().map(|why| reason(*why, of.unit, report));
        format!("{} ({})", report.units[of.unit].0, why.collect::<Vec<_>>().join("; "))
    };
    let unlike = match fleet.outliers.as_deref() {
        None => "Of two units nothing says which is the odd one.".to_owned(),
        Some([]) => "None is shown to be an outlier.".to_owned(),
        Some(all) => {
            let all: Vec<String> = all.iter().map(outlier).collect();
            format!("Unlike the others: {}.", all.join(", "))
        }
    };
    format!("{share} {unlike}")
}

/// Why a unit is unlike the others, in a clause.
pub(crate) fn reason(
    reason: OutlierReason,
    unit: usize,
    report: &ImproveFleetReport<'_>,
) -> String {
    let (fleet, robot) = (report.fleet, report.robot());
    let far = |of: &FleetEffect, k: usize| {
        let (parameter, kind) = (&of.parameters[k], &of.effect.kind.parameters[k]);
        let value = parameter.units[unit].map_or(String::new(), |own| with_interval(kind, &own));
        let distance = parameter.left_out[unit].map_or(0.0, |of| of.distance.abs());
        format!(
            "{} of {}: {value}, {} times what the others vary by from their mean",
            spoken(kind),
            of.effect.name(robot),
            super::digits(distance, 2)
        )
    };
    match reason {
        OutlierReason::Alone(k) => {
            format!("it alone has {}", fleet.effects[k].effect.name(robot))
        }
        OutlierReason::Lacking(k) => {
            format!("it alone does not have {}", fleet.effects[k].effect.name(robot))
        }
        OutlierReason::EffectValue(k, p) => far(&fleet.effects[k], p),
        OutlierReason::CalibrationValue(k, p) => far(&fleet.calibrations[k], p),
    }
}

/// A unit's value with its own 95 % interval.
pub(crate) fn with_interval(kind: &Parameter, of: &UnitValue) -> String {
    let half = HALF_95 * of.deviation;
    Scale::of_parameter(kind).with_interval(of.value, [of.value - half, of.value + half])
}

/// Which units have an effect that not all have, and of which it is not known.
pub(crate) fn some_have(of: &FleetEffect, report: &ImproveFleetReport<'_>) -> String {
    let names = |is: &dyn Fn(Presence) -> bool| -> Vec<&str> {
        of.units(is).into_iter().map(|k| report.units[k].0).collect()
    };
    let told = [
        ("in", names(&Presence::is_there)),
        ("not in", names(&|p| p == Presence::Absent)),
        ("not known of", names(&|p| p == Presence::Unknown)),
    ];
    let told = told.iter().filter(|(_, units)| !units.is_empty());
    let told: Vec<String> =
        told.map(|(what, units)| format!("{what} {}", listed(units, "and"))).collect();
    format!("{}: {}.", of.effect.name(report.robot()), told.join(", "))
}

/// Mean and spread of a type, each with its 95 % interval; a spread that two units show is hardly
/// known, and its interval says so.
pub(crate) fn of_type(kind: &Parameter, of: &FleetParameter) -> [String; 2] {
    let Some(fleet) = of.fleet else { return [String::new(), String::new()] };
    let scale = Scale::of_parameter(kind);
    let [low, high] = fleet.spread_interval.map(|end| scale.number(end));
    [
        scale.with_interval(fleet.mean, fleet.mean_interval),
        format!("{} ({low} to {high})", scale.quantity(fleet.spread)),
    ]
}

/// What is told of a unit's value: where it comes from, and how far it is from the others.
pub(crate) fn remark(effect: &FleetEffect, of: &FleetParameter, unit: usize) -> String {
    let there = match effect.presence[unit] {
        _ if effect.effect.kind.calibration.is_some() => "",
        Presence::Named => "",
        Presence::Measured => "measured, not named",
        Presence::Absent => "not there",
        Presence::Unknown => "not known to be there",
    };
    let distance =
        of.left_out[unit].map(|of| format!("distance {}", super::digits(of.distance, 2)));
    let parts: Vec<String> = [distance.unwrap_or_default(), there.to_owned()]
        .into_iter()
        .filter(|p| !p.is_empty())
        .collect();
    parts.join(", ")
}

/// How the result came about.
pub(crate) fn setting(report: &ImproveFleetReport<'_>) -> String {
    let logs: usize = report.units.iter().map(|(_, of)| of.before.len()).sum();
    format!(
        "{} of {}, {}. A unit's value is that of its own logs, not drawn towards the others; what only others have was fitted to it \
         as well. Spread: standard deviation between units beyond what their own intervals make. Distance: from the mean of the \
         other units, over what a unit varies by; from a hundred to one on, over all distances, a unit is an outlier.",
        counted(report.units.len(), "unit"),
        report.robot().name,
        counted(logs, "log"),
    )
}
