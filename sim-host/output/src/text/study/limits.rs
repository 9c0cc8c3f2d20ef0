//! What is said of how far a weld can be driven.

use crate::StudyLimitsReport;
use crate::text::study::sensitivity::capital;
use crate::text::{Scale, fixed, listed};
use trueweld_evaluate::study::{Driven, FoundLimit, LimitProbe};
use trueweld_plant::simulate::LimitKind;

/// Its name for people.
pub(crate) fn name(of: Driven) -> &'static str {
    match of {
        Driven::Force => "push",
        Driven::Feed => "feed",
        Driven::Offset => "offset of the seam",
    }
}

/// The unit that it is shown in.
pub(crate) fn unit(of: Driven) -> Scale {
    match of {
        Driven::Force => Scale { factor: 1e-3, unit: "kN" },
        Driven::Feed => Scale { factor: 1e3, unit: "mm/s" },
        Driven::Offset => Scale { factor: 1e3, unit: "mm" },
    }
}

/// The largest value that keeps the requirements.
pub(crate) fn largest(found: &FoundLimit) -> String {
    let unit = unit(found.driven);
    match (found.largest, &found.beyond) {
        (None, _) => "none".to_owned(),
        (Some(value), None) => format!("{} or more", unit.quantity(value)),
        (Some(value), Some(_)) => unit.quantity(value),
    }
}

/// What limits, just beyond.
pub(crate) fn because(found: &FoundLimit) -> String {
    found.beyond.as_ref().map_or("nothing in this range".to_owned(), of_probe)
}

fn of_probe(probe: &LimitProbe) -> String {
    let drives: Vec<String> = probe
        .held
        .iter()
        .filter(|kind| matches!(kind, LimitKind::Torque(_) | LimitKind::Compensation))
        .map(ToString::to_string)
        .collect();
    let held = match drives.is_empty() {
        true => String::new(),
        false => format!("; at its limit: {}", drives.join(", ")),
    };
    match (&probe.figure, &probe.failed) {
        (Some(figure), _) => {
            format!("{}, {} % of its limit{held}", figure.label, fixed(100.0 * probe.share, 0))
        }
        (None, Some(why)) => format!("{why}{held}"),
        (None, None) => "nothing is limited".to_owned(),
    }
}

/// The finding: at the weld's own place.
pub(crate) fn headline(report: &StudyLimitsReport<'_>) -> String {
    let Some(place) = report.places.first() else {
        return "No place is reached.".to_owned();
    };
    let parts: Vec<String> = place
        .limits
        .iter()
        .map(|found| match found.largest {
            None => format!("no {} keeps the requirements", name(found.driven)),
            Some(_) => {
                let figure = found.beyond.as_ref().and_then(|probe| probe.figure);
                let by = figure.map_or(String::new(), |figure| format!(" ({})", figure.label));
                format!("{} up to {}{by}", name(found.driven), largest(found))
            }
        })
        .collect();
    format!("{}.", capital(&listed(&parts, "and")))
}

/// How the edges were found.
pub(crate) fn setting(report: &StudyLimitsReport<'_>) -> String {
    let scenario = &report.study.scenario;
    let keys: Vec<&str> = report.study.limits.iter().map(|limit| limit.figure.label).collect();
    format!(
        "Weld {}, {} mm of it, {} control, law {}, seed {}. One number is driven at a time, by full runs: nine evenly over its \
         range, then the edge is halved. Offset: the seam lies beside where it was taught, to \
         either side; told is the side that bears less. Required: {}; and the weld that was asked for.",
        scenario.name,
        fixed(1e3 * report.length, 0),
        scenario.controller.name(),
        scenario.law.name(),
        scenario.seed,
        keys.join("; "),
    )
}

/// What should be known besides.
pub(crate) fn notices(report: &StudyLimitsReport<'_>) -> Vec<String> {
    let mut told = Vec::new();
    for place in report.places {
        for found in &place.limits {
            let at = match report.places.len() {
                1 => String::new(),
                _ => format!(" at x {}, y {}, z {} m", place.at.x_m, place.at.y_m, place.at.z_m),
            };
            if let Some(value) = found.kept_again {
                told.push(format!(
                    "More is not always worse: the requirements are kept again at a {} of {}{at}.",
                    name(found.driven),
                    unit(found.driven).quantity(value)
                ));
            }
            if found.largest.is_some_and(|largest| largest < found.nominal) {
                told.push(format!(
                    "The weld's own {} of {} does not keep the requirements{at}.",
                    name(found.driven),
                    unit(found.driven).quantity(found.nominal)
                ));
            }
        }
    }
    told
}
