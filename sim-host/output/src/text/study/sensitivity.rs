//! What is said of a weld's sensitivity.

use crate::StudySensitivityReport;
use crate::text::requirement::scale;
use crate::text::{Scale, counted, fixed, listed};
use trueweld_evaluate::study::{Derivative, study_figure};

/// Share of the variance from which an input is worth naming.
const NAMED_VARIANCE_SHARE: f64 = 0.1;

/// An input's name for people: `stiffness.A3` as `stiffness of A3`.
pub(crate) fn input(name: &str) -> String {
    match name.split_once('.') {
        Some(("stiffness", joint)) => format!("stiffness of {joint}"),
        Some((what @ ("process" | "ripple" | "crosstalk"), of)) => {
            format!("{what}, {}", of.replace('_', " "))
        }
        _ => name.to_owned(),
    }
}

/// The scale and unit that a figure is shown in.
pub(crate) fn unit(key: &str) -> Scale {
    match study_figure(key).map(|figure| figure.unit) {
        Some("m") if key.starts_with("depth") => Scale { factor: 1e6, unit: "µm" },
        Some("rad") => Scale::large("rad"),
        Some("s") => Scale { factor: 1e3, unit: "ms" },
        Some(unit) => Scale::small(unit),
        None => scale(key),
    }
}

/// The finding: of the first figure, what makes most of its spread.
pub(crate) fn headline(report: &StudySensitivityReport<'_>) -> String {
    let Some(figure) = report.global.figures.first() else {
        return "No figure of this weld depends on what the requirements call uncertain."
            .to_owned();
    };
    let ranked = report.ranked(figure.figure.key);
    let named =
        ranked.iter().filter(|(_, index)| index.total.value >= NAMED_VARIANCE_SHARE).take(3);
    let named: Vec<String> = named
        .map(|(name, index)| {
            let interval = [index.total.low, index.total.value, index.total.high];
            let [low, value, high] = interval.map(|v| fixed(100.0 * v, 0));
            format!("{} ({value} %, {low} to {high})", input(name))
        })
        .collect();
    let unit = unit(figure.figure.key);
    let [mean, deviation] = [figure.mean, figure.deviation].map(|v| unit.quantity(v));
    let what = capital(figure.figure.label);
    if named.is_empty() {
        return format!(
            "{what}: {mean} ± {deviation} over the cells; no input makes a tenth of its variance."
        );
    }
    format!("{what}: {mean} ± {deviation} over the cells, most of it by {}.", listed(&named, "and"))
}

/// A label at the beginning of a sentence.
pub(crate) fn capital(label: &str) -> String {
    let mut letters = label.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// How the runs were made.
pub(crate) fn setting(report: &StudySensitivityReport<'_>) -> String {
    let study = report.study;
    let rows = report.global.rows;
    format!(
        "Weld {}, {} mm of it, {} control, law {}; {} of {} inputs in {} rows, seed {}. An index is the share of the \
         figure's variance that an input makes by itself (first order) or with all others (total), with its 95 % \
         interval by resampling the rows. A derivative is the change of the figure by one standard deviation of the input, \
         about the middle of what is not known.",
        study.scenario.name,
        fixed(1e3 * report.length, 0),
        study.scenario.controller.name(),
        study.scenario.law.name(),
        counted(report.runs.len(), "run"),
        report.global.inputs.len(),
        rows,
        study.seed,
    )
}

/// What was left out, and why.
pub(crate) fn notices(report: &StudySensitivityReport<'_>) -> Vec<String> {
    let mut told = Vec::new();
    let global = report.global;
    if global.dropped > 0 {
        let why = global.failed.as_deref().unwrap_or_default();
        told.push(format!(
            "{} of {} rows are left out, since a run of theirs came to no end ({why}): the indices are of the cells that weld.",
            global.dropped,
            global.dropped + global.rows
        ));
    }
    if let Some(why) = &report.local.failed {
        told.push(format!("No derivatives: the middle cell has no figures ({why})."));
    }
    let wide = global.figures.iter().filter(|figure| {
        figure.indices.iter().any(|index| index.total.high - index.total.low > 0.3)
    });
    let wide: Vec<&str> = wide.map(|figure| figure.figure.label).collect();
    if !wide.is_empty() {
        told.push(format!(
            "Intervals wider than 30 % of the variance ({}): more rows narrow them, by half for four times as many.",
            wide.join("; ")
        ));
    }
    let rough =
        report.local.figures.iter().filter(|figure| {
            figure.derivatives.iter().flatten().any(|derivative| !derivative.smooth)
        });
    let rough: Vec<&str> = rough.map(|figure| figure.figure.label).collect();
    if !rough.is_empty() {
        told.push(format!(
            "Marked with *, a derivative depends on its step: the figure is not smooth there ({}); the indices tell more.",
            rough.join("; ")
        ));
    }
    told
}

/// A derivative with its unit; marked where it depends on the step.
pub(crate) fn derivative(key: &str, of: Option<Derivative>) -> String {
    let Some(of) = of else { return "none".to_owned() };
    let mark = if of.smooth { "" } else { " *" };
    format!("{}{mark}", unit(key).signed(of.value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_derivative_that_depends_on_its_step_is_marked() {
        let of = Derivative { value: 1.2e-4, wider: 0.2e-4, smooth: false };
        assert_eq!(derivative("lateral_rms_m", Some(of)), "+0.120 mm *");
        let of = Derivative { smooth: true, ..of };
        assert_eq!(derivative("lateral_rms_m", Some(of)), "+0.120 mm");
        assert_eq!(derivative("lateral_rms_m", None), "none");
    }
}
