//! What is said of simulated welds.

use super::requirement::scale_of;
use super::{Scale, listed};
use crate::WeldRun;
use trueweld_core::Fault;
use trueweld_evaluate::JudgedFigure;
use trueweld_plant::simulate::{HealthWarning, LimitSpan};

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

/// What was wrong in a control period.
pub fn fault(fault: Fault) -> String {
    match fault {
        Fault::Encoder(joint) => format!("the encoder of A{} jumped", joint + 1),
        Fault::Force => "the force sensor is stuck or beyond its range".to_owned(),
        Fault::Setpoint => "the set-point cannot be".to_owned(),
        Fault::Singular => "the arm is singular".to_owned(),
        Fault::Limit(joint) => format!("A{} is outside its limits", joint + 1),
        Fault::Compensation => {
            "the law could form no correction: a pose out of reach, or a path that jumps".to_owned()
        }
    }
}

/// Tells equal names apart.
pub(super) fn numbered(mut names: Vec<String>) -> Vec<String> {
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

/// The push that a run was asked for.
fn push(run: &WeldRun) -> String {
    match run.recording.force {
        0.0 => "none, held by position".to_owned(),
        force => format!("{:.1} kN", 1e-3 * force),
    }
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
    let steady = match runs.iter().any(|run| run.recording.force > 0.0) {
        true => "full feed, full push",
        false => "full feed",
    };
    format!(
        "Weld {}, controller {}, push {}, seed {}. Figures over the steady part ({steady}).",
        shared(runs.iter().map(|r| r.recording.weld.clone())),
        shared(runs.iter().map(|r| r.recording.controller.to_owned())),
        shared(runs.iter().map(push)),
        shared(runs.iter().map(|r| r.recording.seed.to_string())),
    )
}

/// Whether a weld misses its seam.
pub(crate) fn beyond_tolerance(run: &WeldRun) -> bool {
    run.figures.lateral.max_abs >= run.figures.half_pin_m
}

/// Which of the runs one is: its law, and what they do not share.
fn who(run: &WeldRun, runs: &[WeldRun]) -> String {
    let WeldRun { recording: of, .. } = run;
    let mut who = match of.compensator.as_str() {
        "none" => "without compensation".to_owned(),
        law => format!("with {law} compensation"),
    };
    if runs.iter().any(|other| other.recording.controller != runs[0].recording.controller) {
        who += &format!(" under {} control", of.controller);
    }
    if runs.iter().any(|other| other.recording.weld != runs[0].recording.weld) {
        who += &format!(" ({})", of.weld);
    }
    who
}

/// The result in a sentence or two, true of whatever runs there are.
pub(crate) fn headline(runs: &[WeldRun]) -> String {
    if runs.is_empty() {
        return "No weld.".to_owned();
    }
    let who = |run: &WeldRun| who(run, runs);
    let parts = runs.iter().map(|run| {
        let beyond = match Scale::small("m").quantity(run.recording.half_pin) {
            limit if beyond_tolerance(run) => {
                format!(" (beyond {}, {limit})", run.recording.tolerance_name)
            }
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
        .filter(|r| !beyond_tolerance(r) && r.figures.lateral_before_m >= r.recording.half_pin)
        .map(|r| format!("{} {}", Scale::small("m").quantity(r.figures.lateral_before_m), who(r)))
        .collect();
    if !early.is_empty() {
        let limit = runs[0].recording.tolerance_name;
        sentence += &format!(" Before full feed it is beyond {limit}: {}.", listed(&early, "and"));
    }
    for run in runs {
        // Beyond the tolerance is said above.
        let others = run.figures.judged.iter().skip(1).filter(|judged| !judged.met);
        let others: Vec<String> = others.map(missed).collect();
        if !others.is_empty() {
            let others = listed(&others, "and");
            sentence += &format!(" It is not the weld that was asked for {}: {others}.", who(run));
        }
    }
    for run in runs.iter().filter(|run| !run.figures.limits.is_empty()) {
        let limits = limits(&run.figures.limits);
        sentence += &format!(" At a limit {}: {limits}.", who(run));
    }
    for run in runs.iter().filter(|run| !run.figures.health.is_empty()) {
        let warnings: Vec<String> =
            run.figures.health.iter().take(TOLD_LIMITS).map(warning).collect();
        sentence += &format!(" Warning {}: {}.", who(run), listed(&warnings, "and"));
    }
    sentence
}

/// A figure of a weld that is not what it is to be.
pub fn missed(judged: &JudgedFigure) -> String {
    let scale = scale_of(judged.figure.key, judged.figure.unit);
    let [value, expected, tolerance] =
        [judged.value, judged.expected, judged.tolerance].map(|v| scale.quantity(v));
    let allowed = if judged.expected == 0.0 {
        format!("at most {tolerance}")
    } else {
        format!("expected {expected} ± {tolerance}")
    };
    format!("{} {value} ({allowed})", judged.figure.label)
}

/// Most limits of a run that are told; the others are shorter.
const TOLD_LIMITS: usize = 3;

/// What a run stood at, the longest first: "torque of A2 for 0.20 s, first at 3.02 s (feed rising)".
pub(crate) fn limits(spans: &[LimitSpan]) -> String {
    let told = spans.iter().take(TOLD_LIMITS).map(|span| {
        let LimitSpan { kind, time_s, first_s, phase } = span;
        format!("{kind} for {time_s:.2} s, first at {first_s:.2} s ({})", phase.name())
    });
    match &told.collect::<Vec<_>>()[..] {
        [] => "never at a limit or faulted".to_owned(),
        told => listed(told, "and"),
    }
}

/// A warning of the watch beside the law: "A2 rings at 16.6 Hz, first at 9.10 s (steady)".
pub fn warning(of: &HealthWarning) -> String {
    let line = of.amplitude_n.zip(of.usual_n);
    let line = line.map(|(now, usual)| format!(" to {now:.0} N from its usual {usual:.0} N"));
    let drive = of.frequency_hz.map(|frequency| format!(" at {frequency:.1} Hz"));
    let much = line.or(drive).unwrap_or_default();
    format!("{}{much}, first at {:.2} s ({})", of.kind, of.first_s, of.phase.name())
}

/// How fast the simulation was.
pub(crate) fn speed(runs: &[WeldRun]) -> String {
    let simulated: f64 = runs.iter().map(|r| r.recording.simulated).sum();
    let wall = runs.iter().map(|r| r.recording.wall).fold(1e-9, f64::max);
    format!("{simulated:.0} s simulated in {wall:.1} s, {:.0} × real time.", simulated / wall)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sample;
    use trueweld_plant::simulate::{LimitKind, LimitSpan, Phase};

    #[test]
    fn the_headline_is_true_of_whatever_runs_there_are() {
        let mut welds = sample::welds(400);
        for (figures, largest) in welds.figures.iter_mut().zip([5.24e-3, 0.2e-3]) {
            figures.lateral.max_abs = largest;
            figures.half_pin_m = 2.5e-3;
            figures.limits.clear();
            figures.judged.iter_mut().for_each(|judged| {
                (judged.value, judged.met) = (judged.expected, true);
            });
            figures.lateral_before_m = 0.0;
        }
        let both = "At full feed the tool leaves the seam by up to 5.24 mm without compensation (beyond half the pin, \
                    2.50 mm) and by up to 0.200 mm with elastostatic compensation.";
        assert_eq!(headline(&welds.runs()), both);
        let one = "At full feed the tool leaves the seam by up to 0.200 mm with elastostatic compensation.";
        assert_eq!(headline(&welds.runs()[1..]), one);
        welds.figures[1].lateral_before_m = 2.6e-3;
        let early =
            " Before full feed it is beyond half the pin: 2.60 mm with elastostatic compensation.";
        assert_eq!(headline(&welds.runs()[1..]), one.to_owned() + early);
        welds.figures[1].lateral_before_m = 0.0;
        let kind = LimitKind::Torque(1);
        let spans = vec![LimitSpan { kind, time_s: 1.035, first_s: 3.0, phase: Phase::ForceRamp }];
        welds.figures[1].limits = spans;
        let limited = " At a limit with elastostatic compensation: torque of A2 for 1.03 s, first at 3.00 s (force loop \
                       closed, force rising).";
        assert_eq!(headline(&welds.runs()), both.to_owned() + limited);
        welds.figures[1].limits.clear();
        let push = welds.figures[1].judged.iter_mut().find(|j| j.figure.key == "push_mean_n");
        push.into_iter().for_each(|push| (push.value, push.met) = (1080.0, false));
        let missed = " It is not the weld that was asked for with elastostatic compensation: push, mean 1080 N \
                      (expected 18000 N ± 900 N).";
        assert_eq!(headline(&welds.runs()), both.to_owned() + missed);
        assert_eq!(headline(&[]), "No weld.");
    }
}
