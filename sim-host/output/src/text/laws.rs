//! What is said of compensation laws side by side.

use super::{share, signed_share};
use crate::{LawsReport, MILLI};
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::laws::{
    LawComparison, NoFigures, ScenarioChange, ScenarioSweep, VariedQuantity,
};

/// Which laws stay within what is required, whatever is varied.
pub(crate) fn headline(report: &LawsReport<'_>) -> String {
    let Some(limit) = report.limit else {
        return "Compensation laws side by side.".to_owned();
    };
    let holds = |points: &[Result<WeldFigures, NoFigures>]| {
        points.iter().all(|p| p.as_ref().is_ok_and(|f| f.lateral.rms <= limit))
    };
    let mut groups: Vec<(Vec<&str>, Vec<&str>)> = Vec::new();
    for sweep in report.sweeps {
        let laws = report.comparison.laws.iter().zip(&sweep.points);
        let names: Vec<&str> =
            laws.filter(|(_, points)| holds(points)).map(|(law, _)| law.name()).collect();
        match groups.iter_mut().find(|(others, _)| *others == names) {
            Some((_, quantities)) => quantities.push(noun(sweep.quantity)),
            None => groups.push((names, vec![noun(sweep.quantity)])),
        }
    }
    let parts = groups.iter().map(|(names, quantities)| {
        let who = if names.is_empty() { "no law".to_owned() } else { names.join(", ") };
        format!("whatever the {}: {who}", quantities.join(", the "))
    });
    format!("Within {} mm RMS {}.", limit * MILLI, parts.collect::<Vec<_>>().join("; "))
}

/// How the welds were made.
pub(crate) fn setting(comparison: &LawComparison<'_>) -> String {
    let scenario = &comparison.scenario;
    let learning: Vec<&str> = comparison
        .laws
        .iter()
        .filter(|law| comparison.passes_of(law) > 1)
        .map(|law| law.name())
        .collect();
    let passes = match learning.as_slice() {
        [] => String::new(),
        laws => format!("; {}: pass {}", laws.join(", "), comparison.passes),
    };
    format!(
        "Weld {}, {} control, seed {}{passes}. Figures over the steady part (full feed, full push). \
         Instruments as their file says, but for what is varied; noise and delay of the force sensor \
         are also the force loop's.",
        scenario.name,
        scenario.controller.name(),
        scenario.seed,
    )
}

/// Why there are no figures, a sentence for every law and reason.
pub(crate) fn failures(comparison: &LawComparison<'_>, sweep: &ScenarioSweep) -> Vec<String> {
    let mut told: Vec<(String, Vec<String>)> = Vec::new();
    for (law, points) in comparison.laws.iter().zip(&sweep.points) {
        for (change, point) in sweep.quantity.changes().iter().zip(points) {
            let Err(why) = point else { continue };
            let why = format!("{}: {why}", law.name());
            match told.iter_mut().find(|(other, _)| *other == why) {
                Some((_, levels)) => levels.push(label(*change)),
                None => told.push((why, vec![label(*change)])),
            }
        }
    }
    told.into_iter().map(|(why, levels)| format!("{why} ({})", levels.join("; "))).collect()
}

/// What is varied, and what is not.
pub(crate) fn title(comparison: &LawComparison<'_>, quantity: VariedQuantity) -> String {
    let at = signed_share(comparison.stiffness_error);
    match quantity {
        VariedQuantity::StiffnessError => "Error of the believed stiffness".to_owned(),
        VariedQuantity::Noise => format!("Sensor noise, believed stiffness {at}"),
        VariedQuantity::Delay => {
            let period = comparison.scenario.control.period * MILLI;
            format!("Sensor delay, periods of {period} ms, believed stiffness {at}")
        }
        VariedQuantity::Lost => format!("Lost sensors, believed stiffness {at}"),
    }
}

/// What stands below a picture.
pub(crate) fn axis(quantity: VariedQuantity) -> &'static str {
    match quantity {
        VariedQuantity::StiffnessError => "error of every joint's stiffness; +: believed too stiff",
        VariedQuantity::Noise => "factor on the noise of force and seam sensor",
        VariedQuantity::Delay => "delay of force and seam sensor, periods",
        VariedQuantity::Lost => {
            "seam readings lost; all in the last pass; force sensor dead half-way"
        }
    }
}

/// The quantity in a sentence.
fn noun(quantity: VariedQuantity) -> &'static str {
    match quantity {
        VariedQuantity::StiffnessError => "stiffness error",
        VariedQuantity::Noise => "noise",
        VariedQuantity::Delay => "delay",
        VariedQuantity::Lost => "sensors lost",
    }
}

/// A change in a heading of a table or below a picture.
pub(crate) fn label(change: ScenarioChange) -> String {
    match change {
        ScenarioChange::StiffnessError(error) => signed_share(error),
        ScenarioChange::Noise(factor) => format!("×{factor}"),
        ScenarioChange::Delay(periods) => format!("{periods}"),
        ScenarioChange::Lost(1.0) => "all".to_owned(),
        ScenarioChange::Lost(lost) => share(lost),
        ScenarioChange::DeadInLastPass => "last pass".to_owned(),
        ScenarioChange::ForceSensorDies => "force".to_owned(),
    }
}
