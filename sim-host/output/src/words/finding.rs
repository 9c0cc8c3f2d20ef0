//! What is said of a residual that follows a condition.

use super::{Scale, listed, share};
use trueweld_measure::residuals::localize::{ARRANGEMENTS, FREQUENCY, Finding, OFFSET, Statistic};

/// The finding in a sentence.
pub(crate) fn sentence(finding: &Finding) -> String {
    let Finding { kind, channel, variable, how, .. } = finding;
    let p = match finding.p {
        p if p < 1.5 / (ARRANGEMENTS + 1) as f64 => {
            format!("p ≤ {:.3}", 1.0 / (ARRANGEMENTS + 1) as f64)
        }
        p => format!("p = {p:.3}"),
    };
    let explained = share(finding.share);
    let said = match (variable.as_str(), how) {
        (OFFSET, _) => {
            let y =
                worst(finding).map_or(String::new(), |y| format!(": {y} in {}", finding.category));
            return format!(
                "{kind}, {channel}: {explained} of the squared residual is a constant offset ({p}){y}."
            );
        }
        (_, Statistic::Mean) => {
            format!("{explained} of the squared residual follows {} ({p})", article(variable))
        }
        (FREQUENCY, Statistic::Size) => {
            let [low, high] = [finding.low, finding.high].map(|f| Scale::small("Hz").number(f));
            let [noise, there] = [finding.samples_there, finding.share_there].map(share);
            return format!(
                "{kind}, {channel}: {there} of the squared residual lies between {low} and {high} Hz, where white noise has \
                 {noise} ({p})."
            );
        }
        (_, Statistic::Size) => format!(
            "{} of the squared residual lies in {} of the samples, {} ({p})",
            share(finding.share_there),
            share(finding.samples_there),
            place(finding)
        ),
    };
    let most = match (how, worst(finding)) {
        (Statistic::Mean, Some(y)) => format!("; most {}: {y}", place(finding)),
        _ => String::new(),
    };
    let similar = match finding.similar.as_slice() {
        [] => String::new(),
        all => format!(
            "; nearly as much {}",
            listed(&all.iter().map(|v| article(v)).collect::<Vec<_>>(), "and")
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
    let scale = Scale::large(finding.unit);
    let range =
        scale.with_unit(format!("{} to {}", scale.number(finding.low), scale.number(finding.high)));
    let variable = variable.split(',').next().unwrap_or_default().to_owned();
    if finding.variable.ends_with("periods a turn") {
        return format!("at a phase of {range}");
    }
    format!("where {variable} is {range}")
}

/// The mean residual where it is largest, with its column.
fn worst(finding: &Finding) -> Option<String> {
    let curve = &finding.curve;
    let point = if finding.variable == OFFSET {
        curve.points.get(finding.low as usize)?
    } else if !curve.categories.is_empty() {
        curve.points.iter().zip(&curve.categories).find(|(_, name)| **name == finding.category)?.0
    } else {
        curve.points.iter().find(|p| p.x >= finding.low && p.x <= finding.high)?
    };
    let column =
        curve.y_name.split_once(", ").map_or(String::new(), |(_, column)| format!(" in {column}"));
    Some(format!("{}{column}", Scale::small(curve.y_unit).signed(point.y)))
}

/// A condition as it stands in a sentence: with its article, or as the joint's own.
pub(crate) fn article(variable: &str) -> String {
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
