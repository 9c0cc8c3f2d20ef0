//! What is said of numbers that were identified.

use super::{counted, digits, fixed, listed, score, share};
use crate::IdentifyReport;
use trueweld_identify::{Identification, Number, StiffnessCurve};

/// Score from which on the model itself counts as not fitting: a third above the noise.
const MISFIT: f64 = 1.3;

/// Correlation from which on two numbers are told together rather than each.
const TOGETHER: f64 = 0.9;

/// True where residuals are well above the noise at the numbers found.
pub(crate) fn is_misfit(found: &Identification) -> bool {
    found.score > MISFIT
}

/// Half of a number's interval over its value.
pub(crate) fn half_width(number: &Number) -> Option<f64> {
    number.interval.map(|[low, high]| 0.5 * (high - low) / number.value)
}

/// A number with four digits and its power of ten.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    let (factor, prefix) = match value.abs() {
        v if v >= 1e6 => (1e-6, "M"),
        v if v >= 1e4 => (1e-3, "k"),
        _ => (1.0, ""),
    };
    format!("{} {prefix}{unit}", digits(value * factor, 4))
}

/// The same with half of its interval.
pub(crate) fn with_interval(number: &Number) -> String {
    match half_width(number) {
        Some(half) => format!("{} ± {}", quantity(number.value, number.unit), share(half)),
        None => "not told".to_owned(),
    }
}

fn named(numbers: &[&Number]) -> String {
    let names: Vec<&str> =
        numbers.iter().map(|n| if n.at.is_empty() { n.name.as_str() } else { &n.at }).collect();
    listed(&names, "and")
}

/// The finding in a sentence or two.
pub(crate) fn headline(found: &Identification) -> String {
    let (told, untold): (Vec<&Number>, Vec<&Number>) =
        found.numbers.iter().partition(|n| n.is_identifiable());
    let what = found.target.name();
    let widths: Vec<f64> = told.iter().filter_map(|n| half_width(n)).collect();
    let [least, most] = [
        widths.iter().copied().fold(f64::INFINITY, f64::min),
        widths.iter().copied().fold(0.0, f64::max),
    ];
    let to = if told.len() > 1 {
        format!("to between ± {} and ± {}", share(least), share(most))
    } else {
        format!("to ± {}", share(most))
    };
    match (told.is_empty(), untold.is_empty()) {
        (true, _) => format!("These logs tell the {what} of no joint."),
        (_, true) => format!("These logs tell the {what} of {}, {to} (95 %).", named(&told)),
        _ => format!(
            "These logs tell the {what} of {}, {to} (95 %), and not that of {}.",
            named(&told),
            named(&untold)
        ),
    }
}

/// What the residuals say of the model.
pub(crate) fn lead(found: &Identification) -> String {
    let scores = format!(
        "Residuals over noise: {} with these numbers, {} with those given.",
        score(found.score),
        score(found.score_before)
    );
    if is_misfit(found) {
        format!(
            "{scores} The model does not fit at any values: something else is missing in it. The numbers are what fits \
             best without it, and their intervals do not hold the truth. Run `trueweld diagnose` first."
        )
    } else {
        scores
    }
}

/// How the result came about.
pub(crate) fn setting(report: &IdentifyReport<'_>) -> String {
    let found = report.found;
    let mut text = format!(
        "Model {}, {} ({}), {} compared. Fitted without a prior, beside encoder zeros, tracker registration and \
         mounting of the links.",
        report.model.path.display(),
        counted(found.logs.len(), "log"),
        listed(&found.logs, "and"),
        counted(found.samples, "value"),
    );
    if !found.left_out.is_empty() {
        text += &format!(" Not used: {}.", listed(&found.left_out, "and"));
    }
    text
}

/// What these logs leave open, and what to do.
pub(crate) fn open(found: &Identification) -> Vec<String> {
    let mut notes = Vec::new();
    let untold: Vec<&Number> = found.numbers.iter().filter(|n| !n.is_identifiable()).collect();
    if !untold.is_empty() {
        notes.push(format!(
            "{}: these logs do not tell the {}; the file keeps the value given.",
            named(&untold),
            found.target.name()
        ));
    }
    for i in 0..found.numbers.len() {
        for j in i + 1..found.numbers.len() {
            let [a, b] = [&found.numbers[i], &found.numbers[j]];
            let correlation = found.correlation[(i, j)];
            if a.is_identifiable() && b.is_identifiable() && correlation.abs() > TOGETHER {
                notes.push(format!(
                    "{} and {} are told together (correlation {}): another posture tells them apart.",
                    a.at,
                    b.at,
                    fixed(correlation, 2)
                ));
            }
        }
    }
    notes
}

/// Whether a spring is linear, in a word or two.
pub(crate) fn linear(curve: Option<&StiffnessCurve>) -> String {
    match curve {
        None => "not enough loads".to_owned(),
        Some(curve) if curve.is_linear() => format!("yes (p = {})", digits(curve.chance, 2)),
        Some(_) => "no (p < 0.001)".to_owned(),
    }
}

/// What stands at the head of a file with numbers that were identified.
pub fn identified_head(report: &IdentifyReport<'_>) -> String {
    let found = report.found;
    format!(
        "The {} was identified by `trueweld identify {}` from {}: {}\nAll else is as in {}.",
        found.target.name(),
        found.target.name(),
        listed(&found.logs, "and"),
        headline(found),
        found.model.robot_path.display()
    )
}

/// What stands behind one of its numbers.
pub fn identified_source(report: &IdentifyReport<'_>, number: &Number) -> String {
    match number.interval {
        Some([low, high]) => format!(
            "95 %: {low:.6e} to {high:.6e}; identified from {}",
            listed(&report.found.logs, "and")
        ),
        None => "as given: the logs do not tell it".to_owned(),
    }
}
