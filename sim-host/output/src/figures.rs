//! What tables and pages say of runs: names, units for people, the sentence above everything, and
//! the lines of the table, written once for terminal and page.

#[cfg(feature = "rerun")]
use crate::StepRun;
use crate::WeldRun;
use crate::words::{Scale, fixed, listed};
use trueweld_core::control::Limited;
use trueweld_evaluate::{FirstLimit, JudgedFigure, Spread, StepFigures};

/// Millimetres in a metre, and milliradians in a radian.
pub(crate) const MILLI: f64 = 1e3;

/// One line of the table of welds.
pub(crate) struct Line {
    pub label: String,
    pub cells: Vec<FigureCell>,
}

/// What one run has in a line.
pub(crate) enum FigureCell {
    /// Mean, root mean square and largest magnitude.
    Spread([String; 3]),
    /// Words; `bad` where something is not as it should be.
    Text { text: String, bad: bool },
}

/// Short names of the runs, all different: the compensation law alone where that tells them apart.
pub(crate) fn run_names(runs: &[WeldRun]) -> Vec<String> {
    let law = |r: &WeldRun| match r.recording.compensator.as_str() {
        "none" => "no compensation".to_owned(),
        law => law.to_owned(),
    };
    let full =
        |r: &WeldRun| format!("{}, {}, {}", r.recording.weld, r.recording.controller, law(r));
    let laws: Vec<String> = runs.iter().map(law).collect();
    numbered(if all_different(&laws) { laws } else { runs.iter().map(full).collect() })
}

/// The controllers' names, all different.
#[cfg(feature = "rerun")]
pub(crate) fn controller_names(runs: &[StepRun]) -> Vec<String> {
    numbered(runs.iter().map(|r| r.recording.controller.to_owned()).collect())
}

/// Tells equal names apart.
fn numbered(mut names: Vec<String>) -> Vec<String> {
    for i in 1..names.len() {
        let same =
            names[..i].iter().filter(|n| n.split(" #").next() == Some(names[i].as_str())).count();
        if same > 0 {
            names[i] = format!("{} #{}", names[i], same + 1);
        }
    }
    names
}

fn all_different(names: &[String]) -> bool {
    names.iter().enumerate().all(|(i, n)| !names[..i].contains(n))
}

/// What all runs share: weld, controller, push, seed; "several" where they differ.
pub(crate) fn setting(runs: &[WeldRun]) -> String {
    fn shared(values: impl Iterator<Item = String>) -> String {
        let values: Vec<String> = values.collect();
        match values.split_first() {
            Some((first, rest)) if rest.iter().all(|v| v == first) => first.clone(),
            _ => "several".to_owned(),
        }
    }
    format!(
        "Weld {}, controller {}, push {}, seed {}. Figures over the steady part (full feed, full push).",
        shared(runs.iter().map(|r| r.recording.weld.clone())),
        shared(runs.iter().map(|r| r.recording.controller.to_owned())),
        shared(runs.iter().map(|r| format!("{:.1} kN", r.recording.force / MILLI))),
        shared(runs.iter().map(|r| r.recording.seed.to_string())),
    )
}

/// The result in a sentence or two, true of whatever runs there are.
pub(crate) fn headline(runs: &[WeldRun]) -> String {
    if runs.is_empty() {
        return "No weld.".to_owned();
    }
    let several = runs.iter().any(|r| r.recording.weld != runs[0].recording.weld);
    let several_controllers =
        runs.iter().any(|r| r.recording.controller != runs[0].recording.controller);
    let who = |run: &WeldRun| {
        let mut who = match run.recording.compensator.as_str() {
            "none" => "without compensation".to_owned(),
            law => format!("with {law} compensation"),
        };
        if several_controllers {
            who += &format!(" under {} control", run.recording.controller);
        }
        if several {
            who += &format!(" ({})", run.recording.weld);
        }
        who
    };
    let parts = runs.iter().map(|run| {
        let beyond = match Scale::small("m").quantity(run.recording.half_pin) {
            limit if run.figures.of_half_pin >= 1.0 => format!(" (beyond half the pin, {limit})"),
            _ => String::new(),
        };
        format!(
            "by up to {} {}{beyond}",
            Scale::small("m").quantity(run.figures.lateral.max_abs),
            who(run)
        )
    });
    let mut sentence = format!(
        "At full feed the tool leaves the seam {}.",
        listed(&parts.collect::<Vec<_>>(), "and")
    );
    let early: Vec<String> = runs
        .iter()
        .filter(|r| r.figures.of_half_pin < 1.0 && r.figures.lateral_before >= r.recording.half_pin)
        .map(|r| format!("{} {}", Scale::small("m").quantity(r.figures.lateral_before), who(r)))
        .collect();
    if !early.is_empty() {
        sentence +=
            &format!(" Before full feed it is beyond half the pin: {}.", listed(&early, "and"));
    }
    for run in runs {
        // Beyond half the pin is said above.
        let missed = run.figures.judged.iter().skip(1).filter(|judged| !judged.is_met());
        let missed: Vec<String> = missed.map(missed_figure).collect();
        if !missed.is_empty() {
            let missed = listed(&missed, "and");
            sentence += &format!(" It is not the weld that was asked for {}: {missed}.", who(run));
        }
    }
    let first = |run: &WeldRun| {
        run.figures.first_limit.map(|first| format!("{}, {}", who(run), first_limit(&first)))
    };
    let limited: Vec<String> = runs.iter().filter_map(first).collect();
    if !limited.is_empty() {
        sentence += &format!(" At a limit or faulted {}.", limited.join("; "));
    }
    sentence
}

/// A figure of a weld that is not what it is to be.
fn missed_figure(judged: &JudgedFigure) -> String {
    let scale = Scale::large(judged.figure.unit);
    let [value, expected, tolerance] =
        [judged.value, judged.expected, judged.tolerance].map(|v| scale.quantity(v));
    let allowed = if judged.expected == 0.0 {
        format!("at most {tolerance}")
    } else {
        format!("expected {expected} ± {tolerance}")
    };
    format!("{} {value} ({allowed})", judged.figure.label)
}

/// Where a run first came to a limit: "first at 3.02 s (feed rising): torque of a drive".
fn first_limit(first: &FirstLimit) -> String {
    let Limited { torque, force_loop, compensation } = first.limited;
    let limits =
        [(torque, "torque of a drive"), (force_loop, "force loop"), (compensation, "compensation")];
    let mut what: Vec<String> =
        limits.into_iter().filter(|(held, _)| *held).map(|(_, name)| name.to_owned()).collect();
    if let Some(fault) = first.fault {
        what = vec![format!("fault {fault:?}")];
    }
    format!("first at {:.2} s ({}): {}", first.time, first.phase.name(), listed(&what, "and"))
}

/// The lines of the table of welds, one cell a run.
pub(crate) fn weld_lines(runs: &[WeldRun]) -> Vec<Line> {
    let spread = |label: &str, decimals: usize, scale: f64, of: fn(&WeldRun) -> Spread| Line {
        label: label.to_owned(),
        cells: runs
            .iter()
            .map(|run| {
                let s = of(run);
                FigureCell::Spread([s.mean, s.rms, s.max_abs].map(|v| fixed(v * scale, decimals)))
            })
            .collect(),
    };
    let text = |label: &str, of: &dyn Fn(&WeldRun) -> (String, bool)| Line {
        label: label.to_owned(),
        cells: runs
            .iter()
            .map(|run| {
                let (text, bad) = of(run);
                FigureCell::Text { text, bad }
            })
            .collect(),
    };
    vec![
        spread("lateral, mm", 3, MILLI, |r| r.figures.lateral),
        spread("longitudinal, mm", 3, MILLI, |r| r.figures.longitudinal),
        spread("depth, mm", 3, MILLI, |r| r.figures.depth),
        spread("tilt, °", 3, 1f64.to_degrees(), |r| r.figures.tilt),
        text("within half the pin?", &|r| {
            let (largest, limit) =
                (r.figures.lateral.max_abs * MILLI, r.recording.half_pin * MILLI);
            let met = r.figures.of_half_pin < 1.0;
            (
                format!("{largest:.2} of ±{limit:.2} mm: {}", if met { "yes" } else { "exceeded" }),
                !met,
            )
        }),
        text("the weld asked for?", &|r| {
            let missed = r.figures.judged.iter().filter(|judged| !judged.is_met()).count();
            match missed {
                0 => ("yes".to_owned(), false),
                n => (format!("no, {n} of {} missed", r.figures.judged.len()), true),
            }
        }),
        text("before the steady part", &|r| {
            let (largest, limit) = (r.figures.lateral_before, r.recording.half_pin);
            (format!("{:.2} mm lateral", largest * MILLI), largest >= limit)
        }),
        text("push, mean", &|r| (format!("{:.3} kN", r.figures.force.mean / MILLI), false)),
        text("push, max − min", &|r| {
            (
                format!(
                    "{:.0} N, error RMS {:.0} N",
                    r.figures.force.envelope, r.figures.force.error_rms
                ),
                false,
            )
        }),
        text("lateral by A1…A6, %", &|r| {
            let shares: Vec<String> =
                r.figures.joint_share.iter().map(|s| fixed(100.0 * s, 0)).collect();
            (shares.join(" / "), false)
        }),
        text("at a limit or faulted", &|r| match r.figures.limited_rows {
            0 => ("never".to_owned(), false),
            n => {
                let first = r.figures.first_limit.map_or(0.0, |first| first.time);
                (format!("{:.2} s, first at {first:.2} s", n as f64 * r.recording.period), true)
            }
        }),
        text("simulated", &|r| (format!("{:.0} s", r.recording.simulated), false)),
    ]
}

/// The result of steps in one sentence.
pub(crate) fn step_headline(controllers: &[StepFigures]) -> String {
    let parts: Vec<String> = controllers
        .iter()
        .map(|f| match f.settle_5pct {
            Some(t) => format!("{} in {:.0} ms", f.controller, t * MILLI),
            None => format!("{} not within the time recorded", f.controller),
        })
        .collect();
    format!("The push settles within 5 % of the step: {}.", parts.join(", "))
}

/// Headings of the table of steps, and one line a controller.
pub(crate) const STEP_HEADINGS: [&str; 6] =
    ["controller", "first within 5 %", "stays within 5 %", "overshoot", "static error", "ripple"];

/// One line of the table of steps: ours, or what is published beside it.
pub(crate) struct StepLine {
    pub cells: [String; 6],
    pub published: bool,
}

/// The lines of the table of steps: ours, then the published ones of the same scheme.
pub(crate) fn step_lines(controllers: &[StepFigures]) -> Vec<StepLine> {
    let time = |t: Option<f64>| t.map_or("never".to_owned(), |t| format!("{:.0} ms", t * MILLI));
    let mut lines = Vec::new();
    for ours in controllers {
        lines.push(StepLine {
            cells: [
                ours.controller.to_owned(),
                time(ours.first_within_5pct),
                time(ours.settle_5pct),
                format!("{} %", fixed(100.0 * ours.overshoot, 1)),
                format!("{} N", fixed(ours.static_error, 0)),
                format!("{:.0} N", ours.ripple),
            ],
            published: false,
        });
        if let Some(theirs) = crate::published::step_of(ours.controller) {
            lines.push(StepLine {
                cells: [
                    format!("  published, scheme {}", theirs.scheme),
                    String::new(),
                    time(Some(theirs.settle)),
                    format!("{} %", fixed(100.0 * theirs.overshoot, 1)),
                    theirs.static_error.to_owned(),
                    theirs.ripple.to_owned(),
                ],
                published: true,
            });
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use trueweld_plant::simulate::Phase;

    #[test]
    fn the_headline_is_true_of_whatever_runs_there_are() {
        let mut welds = sample::welds(400);
        for (figures, largest) in welds.figures.iter_mut().zip([5.24e-3, 0.2e-3]) {
            figures.lateral.max_abs = largest;
            figures.of_half_pin = largest / 2.5e-3;
            figures.limited_rows = 0;
            figures.first_limit = None;
            figures.judged.iter_mut().for_each(|judged| judged.value = judged.expected);
            figures.lateral_before = 0.0;
        }
        let both = "At full feed the tool leaves the seam by up to 5.24 mm without compensation (beyond half the pin, \
                    2.50 mm) and by up to 0.200 mm with elastostatic compensation.";
        assert_eq!(headline(&welds.runs()), both);
        let one = "At full feed the tool leaves the seam by up to 0.200 mm with elastostatic compensation.";
        assert_eq!(headline(&welds.runs()[1..]), one);
        welds.figures[1].lateral_before = 2.6e-3;
        let early =
            " Before full feed it is beyond half the pin: 2.60 mm with elastostatic compensation.";
        assert_eq!(headline(&welds.runs()[1..]), one.to_owned() + early);
        welds.figures[1].lateral_before = 0.0;
        welds.figures[1].limited_rows = 3;
        let limited = Limited { torque: true, ..Limited::default() };
        welds.figures[1].first_limit =
            Some(FirstLimit { time: 3.0, phase: Phase::ForceRamp, limited, fault: None });
        let limited = " At a limit or faulted with elastostatic compensation, first at 3.00 s (force loop closed, force                        rising): torque of a drive.";
        assert_eq!(headline(&welds.runs()), both.to_owned() + limited);
        welds.figures[1].first_limit = None;
        let push =
            welds.figures[1].judged.iter_mut().find(|j| j.figure.key == "push_mean_n").unwrap();
        push.value = 1080.0;
        let missed = " It is not the weld that was asked for with elastostatic compensation: push, mean 1080 N (expected                       18000 N ± 900 N).";
        assert_eq!(headline(&welds.runs()), both.to_owned() + missed);
        assert_eq!(headline(&[]), "No weld.");
    }

    #[test]
    fn a_response_that_does_not_settle_is_said_not_to() {
        let mut figures = sample::steps().figures;
        figures[1].settle_5pct = None;
        assert!(
            step_headline(&figures)
                .contains("superposed not within the time recorded, external in ")
        );
    }
}
