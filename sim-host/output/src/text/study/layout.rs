//! What is said of a part that is placed.

use crate::text::{Scale, counted, digits, fixed, listed};
use crate::{MILLI, StudyLayoutReport};
use trueweld_core::{Branch, KinematicsError};
use trueweld_evaluate::WeldFigures;
use trueweld_evaluate::study::{
    Allowance, Confirmation, Limiting, OutOfReach, PlacedPart, Placement, WAY_FIGURES,
    more_is_better, numbers,
};

/// The unit that a figure of a way is shown in.
pub(crate) fn unit(figure: usize) -> Scale {
    match WAY_FIGURES[figure].figure.unit {
        "N/m" => Scale { factor: 1e-6, unit: "kN/mm" },
        "rad/s" => Scale { factor: 1.0 / std::f64::consts::TAU, unit: "Hz" },
        "1" => Scale { factor: 1e2, unit: "%" },
        unit => Scale::large(unit),
    }
}

/// What is allowed of a figure: `at most 2.50 mm`.
pub(crate) fn allowed(of: &Allowance) -> String {
    let word = if more_is_better(of.figure) { "at least" } else { "at most" };
    format!("{word} {}", unit(of.figure).quantity(of.limit))
}

/// Names of a placement's six numbers with their units and factors.
pub(crate) const PLACEMENT_NUMBERS: [(&str, &str, f64); 6] = [
    ("x", "m", 1.0),
    ("y", "m", 1.0),
    ("z", "m", 1.0),
    ("turn", "°", 180.0 / std::f64::consts::PI),
    ("inclination", "°", 180.0 / std::f64::consts::PI),
    ("roll", "°", 180.0 / std::f64::consts::PI),
];

/// A number of a placement, with its unit.
pub(crate) fn coordinate(k: usize, value: f64) -> String {
    let (_, unit, factor) = PLACEMENT_NUMBERS[k];
    let space = if unit == "°" { "" } else { " " };
    let decimals = if unit == "°" { 1 } else { 3 };
    format!("{}{space}{unit}", fixed(value * factor, decimals))
}

/// A placement, in the numbers that differ from another one.
fn moved(to: &Placement, from: &Placement) -> String {
    let (to, from) = (numbers(to), numbers(from));
    let differs = (0..6).filter(|k| (to[*k] - from[*k]).abs() > 5e-4);
    let parts: Vec<String> =
        differs.map(|k| format!("{} {}", PLACEMENT_NUMBERS[k].0, coordinate(k, to[k]))).collect();
    if parts.is_empty() { "as its file has it".to_owned() } else { listed(&parts, "and") }
}

/// A posture in words.
pub(crate) fn posture(of: Branch) -> String {
    let wrist = if of.wrist_flipped { "A5 −" } else { "A5 +" };
    let shoulder = of.shoulder_back.then_some("over the shoulder");
    let elbow = of.elbow_flipped.then_some("elbow flipped");
    let parts: Vec<&str> = shoulder.into_iter().chain(elbow).chain([wrist]).collect();
    parts.join(", ")
}

/// Why a seam is not followed.
pub fn out_of_reach((path, why): OutOfReach) -> String {
    let why = match why {
        KinematicsError::NotDecoupled => {
            "this study compares postures by branch, which only an arm with a spherical wrist and A1 \
             vertical has; no posture"
                .to_owned()
        }
        KinematicsError::Unreachable => "out of reach".to_owned(),
        KinematicsError::Singular => "a singular posture".to_owned(),
        KinematicsError::Limit(joint) => format!("the limit of A{}", joint + 1),
        KinematicsError::NotFinite => "no posture".to_owned(),
    };
    format!("{why} {path:.2} m along the seam")
}

/// What full runs under the first law, which is none, leave of a part: the worst of its seams.
struct Bare {
    /// Largest lateral deviation, m.
    lateral: f64,
    /// Largest tilt, rad.
    tilt: f64,
}

/// `None` where a run came to no end.
fn bare(of: &Confirmation) -> Option<Bare> {
    let law = &of.welds.first()?.law;
    let runs = of.welds.iter().filter(|weld| weld.law == *law);
    let figures = runs.map(|weld| weld.outcome.as_ref().ok().map(|(figures, _)| figures));
    let figures = figures.collect::<Option<Vec<&WeldFigures>>>()?;
    let most =
        |value: fn(&WeldFigures) -> f64| figures.iter().map(|f| value(f)).fold(0.0, f64::max);
    Some(Bare { lateral: most(|f| f.lateral.max_abs), tilt: most(|f| f.tilt.max_abs) })
}

/// What deviation and tilt take of what they are allowed, and what is not kept besides.
fn taken(of: &PlacedPart, allowed: &[Allowance]) -> String {
    let label = |of: Limiting| WAY_FIGURES[allowed[of.allowance].figure].figure.label;
    let missed = match of.reserve {
        reserve if reserve.share > 1.0 => format!("; not kept: {}", label(reserve)),
        _ => String::new(),
    };
    let share = fixed(100.0 * of.deviation.share, 0);
    format!("{share} % ({}{missed})", label(of.deviation))
}

/// The finding.
pub(crate) fn headline(report: &StudyLayoutReport<'_>) -> String {
    let chosen = &report.chosen.placed;
    let place = moved(&chosen.placement, &report.task.part.placement());
    let taken = |of: &PlacedPart| taken(of, report.task.allowed);
    let filed = report.filed.as_ref().ok();
    let instead =
        filed.map_or(String::new(), |filed| format!(" instead of {}", taken(&filed.placed)));
    let gain = match (bare(report.chosen), filed.and_then(bare)) {
        (Some(now), Some(before)) => format!(
            " By full runs without compensation {} mm lateral at most and {}° of tilt, instead of {} mm and {}°.",
            fixed(now.lateral * MILLI, 2),
            fixed(now.tilt.to_degrees(), 2),
            fixed(before.lateral * MILLI, 2),
            fixed(before.tilt.to_degrees(), 2),
        ),
        (Some(now), None) if filed.is_none() => format!(
            " By full runs without compensation {} mm lateral at most; where its file has it, the arm does not reach it.",
            fixed(now.lateral * MILLI, 2)
        ),
        _ => String::new(),
    };
    format!(
        "The part is best put at {place}: of what they are allowed deviation and tilt take at most {}{instead}.{gain}",
        taken(chosen)
    )
}

/// How the placements were looked at.
pub(crate) fn setting(report: &StudyLayoutReport<'_>) -> String {
    let reached = report.grid.iter().filter_map(|placed| placed.outcome.as_ref().ok());
    let (count, within) = reached
        .fold((0, 0), |(n, m), placed| (n + 1, m + usize::from(placed.limiting().share <= 1.0)));
    format!(
        "{} by statics and kinematics: {count} are reached, {within} within what is allowed; the best searched between \
         them, and confirmed by full runs. Reserves of torque, speed, collinear axes and joint limits must be kept; among \
         those the best is where deviation and tilt take the least of what they are allowed. Maps lie through the chosen \
         placement, C; F is where the file has the part, in the two numbers of the map. Whether the arm or the tool \
         touches the part or the fixture is not looked at.",
        counted(report.grid.len(), "placement"),
    )
}

/// What statics miss of the full run, and what else should be known.
pub(crate) fn notices(report: &StudyLayoutReport<'_>) -> Vec<String> {
    let mut told = Vec::new();
    let limiting = report.chosen.placed.limiting();
    if limiting.share > 1.0 {
        let of = &report.task.allowed[limiting.allowance];
        let figure = &WAY_FIGURES[of.figure].figure;
        told.push(format!(
            "No placement of this family keeps all that is allowed: the best takes {} % of {} ({}). Widen the family, lower push \
             or feed, or compensate.",
            fixed(100.0 * limiting.share, 0),
            figure.label,
            allowed(of)
        ));
    }
    if let Err(why) = report.filed {
        told.push(format!(
            "Where its file has the part, the arm does not reach it: {}.",
            out_of_reach(*why)
        ));
    }
    let range = &report.task.family.0;
    let at = numbers(&report.chosen.placed.placement);
    let ends: Vec<String> = (0..6)
        .filter(|k| range[*k].high > range[*k].low)
        .filter(|k| at[*k] - range[*k].low < 1e-9 || range[*k].high - at[*k] < 1e-9)
        .map(|k| format!("{} {}", PLACEMENT_NUMBERS[k].0, coordinate(k, at[k])))
        .collect();
    if !ends.is_empty() {
        told.push(format!(
            "The best placement lies at the edge of the family ({}): it may be better beyond.",
            ends.join(", ")
        ));
    }
    let failed = report.chosen.welds.iter().filter_map(|weld| weld.outcome.as_ref().err());
    told.extend(
        failed.map(|why| format!("A full run of the chosen placement came to no end: {why}.")),
    );
    if let (Some(bare), Ok(_)) = (bare(report.chosen), report.filed) {
        let statics = report.chosen.placed.values[0];
        let full = bare.lateral;
        if (full - statics).abs() > 0.1 * full.max(statics) && (full - statics).abs() > 1e-4 {
            told.push(format!(
                "The full run leaves the seam by {} mm where statics expect {} mm.",
                fixed(full * MILLI, 2),
                fixed(statics * MILLI, 2)
            ));
        }
    }
    told
}

/// A placement of the front in a row: its numbers that vary, then figures.
pub(crate) fn value(figure: usize, of: &PlacedPart) -> String {
    digits(of.values[figure] * unit(figure).factor, 3)
}
