//! Findings in plain words.

use super::{ARRANGEMENTS, Finding, Statistic, spectrum};

/// Name of the condition that holds everywhere.
pub(super) const OFFSET: &str = "constant offset";

/// Factor and unit in which people read a residual: millimetres and milliradians.
pub fn readable(unit: &'static str) -> (f64, &'static str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1e3, "mrad"),
        other => (1.0, other),
    }
}

/// Factor and unit in which people read a condition: millimetres and degrees.
pub fn readable_condition(unit: &'static str) -> (f64, &'static str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1f64.to_degrees(), "°"),
        "rad/s" => (1f64.to_degrees(), "°/s"),
        "rad/s²" => (1f64.to_degrees(), "°/s²"),
        other => (1.0, other),
    }
}

pub(super) fn sentence(finding: &Finding) -> String {
    let Finding { kind, channel, variable, how, share, .. } = finding;
    let p = match finding.p {
        p if p < 1.5 / (ARRANGEMENTS + 1) as f64 => {
            format!("p ≤ {:.3}", 1.0 / (ARRANGEMENTS + 1) as f64)
        }
        p => format!("p = {p:.3}"),
    };
    let share = percent(*share);
    let said = match (variable.as_str(), how) {
        (OFFSET, _) => {
            let y = worst(finding)
                .map_or(String::new(), |y| format!(": {} in {}", y.0, finding.category));
            return format!(
                "{kind}, {channel}: {share} of the squared residual is a constant offset ({p}){y}."
            );
        }
        (_, Statistic::Mean) => {
            format!("{share} of the squared residual goes with {} ({p})", article(variable))
        }
        (spectrum::NAME, Statistic::Size) => {
            let (low, high) = (number(finding.low), number(finding.high));
            let noise = percent(finding.samples_there);
            let there = percent(finding.share_there);
            return format!(
                "{kind}, {channel}: {there} of the squared residual lies between {low} and {high} Hz, where white noise has \
                 {noise} ({p})."
            );
        }
        (_, Statistic::Size) => format!(
            "{} of the squared residual lies in {} of the samples, {} ({p})",
            percent(finding.share_there),
            percent(finding.samples_there),
            place(finding)
        ),
    };
    let most = match (how, worst(finding)) {
        (Statistic::Mean, Some((y, _))) => format!("; most {}: {y}", place(finding)),
        _ => String::new(),
    };
    let similar = match finding.similar.as_slice() {
        [] => String::new(),
        all => format!(
            "; nearly as much with {}",
            all.iter().map(|v| article(v)).collect::<Vec<_>>().join(", ")
        ),
    };
    format!("{kind}, {channel}: {said}{most}{similar}.")
}

/// Where a finding shows most.
fn place(finding: &Finding) -> String {
    let variable = article(&finding.variable);
    if !finding.category.is_empty() {
        return match finding.variable.as_str() {
            "log" | "joint" => format!("in {}", finding.category),
            "Cartesian direction" => format!("along {}", finding.category),
            "spindle order" if finding.category == "slow" => {
                "below the spindle's frequency".to_owned()
            }
            "spindle order" => format!("at the spindle's {}", finding.category),
            name if let Some(joint) =
                name.strip_prefix("direction of ").and_then(|n| n.split('\'').next()) =>
            {
                match finding.category.as_str() {
                    "at rest" => format!("while {joint} is at rest"),
                    sense => format!("while {joint} moves in the {sense} sense"),
                }
            }
            name if let Some(quantity) = name.strip_prefix("tendency of ") => {
                format!("while {quantity} is {}", finding.category)
            }
            _ => format!("where {variable} is {}", finding.category),
        };
    }
    let (factor, unit) = readable_condition(finding.unit);
    let (low, high) = (number(finding.low * factor), number(finding.high * factor));
    let variable = variable.split(',').next().unwrap_or_default().to_owned();
    if finding.variable.ends_with("periods a turn") {
        return format!("at a phase of {low} to {high} {unit}");
    }
    format!("where {variable} is {low} to {high} {unit}")
}

/// The mean residual where it is largest, with its column.
fn worst(finding: &Finding) -> Option<(String, f64)> {
    let curve = &finding.curve;
    let point = if finding.variable == OFFSET {
        curve.points.get(finding.low as usize)?
    } else if !curve.categories.is_empty() {
        curve.points.iter().zip(&curve.categories).find(|(_, name)| **name == finding.category)?.0
    } else {
        curve.points.iter().find(|p| p.x >= finding.low && p.x <= finding.high)?
    };
    let (factor, unit) = readable(curve.y_unit);
    let column =
        curve.y_name.split_once(", ").map_or(String::new(), |(_, column)| format!(" in {column}"));
    Some((format!("{:+} {unit}{column}", Rounded(point.y * factor)), point.y))
}

/// A condition as it stands in a sentence: with its article, or as the joint's own.
pub fn article(variable: &str) -> String {
    match variable {
        OFFSET => format!("a {OFFSET}"),
        "log" => "which log it is".to_owned(),
        "time"
        | "payload"
        | "path position"
        | "joint"
        | "Cartesian direction"
        | "spindle order" => {
            format!("the {variable}")
        }
        name if name.starts_with("load")
            || name.starts_with("sign")
            || name.starts_with("tendency") =>
        {
            format!("the {name}")
        }
        name if name.starts_with("direction of") => format!("the {name}"),
        name => match name.split_once(' ') {
            Some((joint, rest)) if !joint.ends_with("'s") => format!("{joint}'s {rest}"),
            _ => name.to_owned(),
        },
    }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn number(value: f64) -> String {
    Rounded(value).to_string()
}

/// A number with three digits that count.
struct Rounded(f64);

impl std::fmt::Display for Rounded {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let decimals = if self.0 == 0.0 {
            0
        } else {
            (2.0 - self.0.abs().log10().floor()).clamp(0.0, 6.0) as usize
        };
        let value = if self.0.abs() < 0.5 * 10f64.powi(-(decimals as i32)) { 0.0 } else { self.0 };
        if f.sign_plus() {
            write!(f, "{value:+.decimals$}")
        } else {
            write!(f, "{value:.decimals$}")
        }
    }
}
