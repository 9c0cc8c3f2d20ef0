//! What is said of gains that were found for a robot.

use super::requirement::{scale_of, shown, without_drives};
use super::{fixed, listed, share};
use crate::TuneReport;
use trueweld_core::JOINTS;
use trueweld_evaluate::ArmAt;
use trueweld_evaluate::tune::{
    LoopCriterion, Rating, TunedController, Tuning, WeldOutcome, stood, worst,
};
use trueweld_plant::simulate::LimitSpan;

/// The finding: what is confirmed, and what is not.
pub(crate) fn headline(report: &TuneReport<'_>) -> String {
    let Tuning { controllers, .. } = report.tuning;
    let (good, bad): (Vec<&TunedController>, Vec<_>) =
        controllers.iter().partition(|tuned| tuned.is_confirmed());
    let names = |all: &[&TunedController]| {
        listed(&all.iter().map(|tuned| tuned.controller.name()).collect::<Vec<_>>(), "and")
    };
    let mut text = match (good.is_empty(), bad.is_empty()) {
        (false, true) => {
            "Margins, step and weld confirm the gains of all three controllers".to_owned()
        }
        (true, _) => "The gains of no controller are confirmed".to_owned(),
        (false, false) => {
            format!("The gains of {} are confirmed, those of {} are not", names(&good), names(&bad))
        }
    };
    let law = report.law();
    text += &match law {
        Some(law) if law.is_confirmed() => format!("; the law {} is confirmed", law.law.name()),
        Some(law) => format!("; the law {} is not confirmed", law.law.name()),
        None => String::new(),
    };
    text
}

/// What limits each controller and law, and what the arm itself is closest to.
pub(crate) fn limits(report: &TuneReport<'_>) -> Vec<String> {
    let tuning = report.tuning;
    let controllers = tuning.controllers.iter().map(|tuned| {
        let not = unconfirmed(tuned.ratings(), &tuned.weld);
        let state =
            if tuned.is_confirmed() { String::new() } else { format!("not confirmed: {not}. ") };
        let closest = [&tuned.margins, &tuned.response].into_iter().filter_map(worst);
        let closest: Vec<String> = closest.map(criterion).collect();
        format!(
            "{}: {state}Closest to its limit: {}.",
            tuned.controller.name(),
            listed(&closest, "and")
        )
    });
    let laws = tuning.laws.iter().map(|tuned| {
        let not = unconfirmed(&tuned.margins, &tuned.weld);
        let state =
            if tuned.is_confirmed() { String::new() } else { format!("not confirmed: {not}. ") };
        let closest = worst(&tuned.margins).map_or(String::new(), criterion);
        format!("{}: {state}Closest to its limit: {closest}.", tuned.law.name())
    });
    controllers.chain(laws).chain(arm(tuning)).collect()
}

/// What is missed.
fn unconfirmed<'a>(ratings: impl IntoIterator<Item = &'a Rating>, weld: &WeldOutcome) -> String {
    let mut missed: Vec<String> =
        ratings.into_iter().filter(|rating| !rating.is_met()).map(criterion).collect();
    match weld {
        Err(why) => missed.push(format!("the weld is not made ({why})")),
        Ok(weld) => {
            let figures = weld.judged.iter().filter(|judged| !judged.met);
            missed.extend(figures.map(|judged| {
                let scale = scale_of(judged.figure.key, judged.figure.unit);
                format!("in the weld {} {}", judged.figure.label, scale.quantity(judged.value))
            }));
            let stands = |span: &LimitSpan| {
                format!("in the weld {} at its limit, first at {:.2} s", span.kind, span.first_s)
            };
            missed.extend(stood(weld).take(2).map(stands));
        }
    }
    listed(&missed, "and")
}

/// A criterion with what was reached of what is asked.
pub(crate) fn criterion(rating: &Rating) -> String {
    let ms = |s: f64| if s.is_finite() { format!("{:.0} ms", 1e3 * s) } else { "never".to_owned() };
    let [value, asked] = [rating.value, rating.asked];
    match rating.criterion {
        LoopCriterion::Margin { figure, channel, path } => format!(
            "{} of {channel} {} at {path:.2} m (least {})",
            without_drives(figure.label),
            shown(figure.key, value),
            shown(figure.key, asked)
        ),
        LoopCriterion::Unstable { path } => format!("the loop is not stable at {path:.2} m"),
        LoopCriterion::Settling => {
            format!("step within 5 % after {} (asked {})", ms(value), ms(asked))
        }
        LoopCriterion::Overshoot => format!("overshoot {} (asked {})", share(value), share(asked)),
        LoopCriterion::StaticError => {
            format!("static error {} (asked {})", share(value), share(asked))
        }
        LoopCriterion::NoStep => "the step of force comes to no end".to_owned(),
    }
}

/// The places at which a drive is closest to its torque and its speed.
fn arm(tuning: &Tuning) -> Vec<String> {
    let most = |of: fn(&ArmAt) -> &[f64; JOINTS]| {
        let all = tuning.arm.iter().flat_map(|at| {
            of(at).iter().copied().enumerate().map(move |(joint, used)| (used, joint, at.path_m))
        });
        all.reduce(|a, b| if b.0 > a.0 { b } else { a }).unwrap_or((0.0, 0, 0.0))
    };
    let limit = |(used, joint, path): (f64, usize, f64), what: &str| {
        let beyond = if used > 1.0 { ": more than there is" } else { "" };
        format!("arm: A{} needs {} of its {what} at {path:.2} m{beyond}", joint + 1, share(used))
    };
    vec![limit(most(|at| &at.torque), "torque"), limit(most(|at| &at.speed), "speed")]
}

/// Where the gains come from, for the head of the file.
pub(crate) fn origin(report: &TuneReport<'_>) -> Vec<String> {
    let Tuning { arm, force_delay, response, .. } = report.tuning;
    let of = report.provenance;
    let start = &arm[0];
    let mut lines = vec![
        format!("Gains for {}, found by trueweld {} tune.", of.robot, of.version),
        "Grade: computed from the model, not measured; they are as good as the model is."
            .to_owned(),
    ];
    lines.extend(
        of.files
            .iter()
            .map(|file| format!("  {}: {}, sha256 {}", file.role, file.file, file.sha256)),
    );
    let inertia: Vec<String> = start.inertia.iter().map(|v| fixed(*v, 1)).collect();
    lines.push(format!(
        "At the start of the weld: rotor and links {} kg m2, first mode {} Hz with the motors locked, {} kN/mm along the tool, force loop {} ms late.",
        inertia.join(", "),
        fixed(start.mode_rad_s / std::f64::consts::TAU, 1),
        fixed(1e-6 * start.stiffness_n_m, 2),
        fixed(1e3 * force_delay, 0)
    ));
    lines.push(format!(
        "Asked: a step of {} N within 5 % after {} ms, overshoot {} at most; margins as in the requirements.",
        fixed(response.height, 0),
        fixed(1e3 * response.settle, 0),
        share(response.overshoot)
    ));
    lines
}

/// What the runs show, for the head of the file.
pub(crate) fn confirmation(report: &TuneReport<'_>) -> Vec<String> {
    let not = if report.is_confirmed() { "" } else { "NOT CONFIRMED. " };
    let mut lines = vec![format!("{not}{}.", headline(report))];
    lines.extend(limits(report).into_iter().map(|line| format!("  {line}")));
    lines
}

/// What was asked, in a sentence.
pub(crate) fn setting(report: &TuneReport<'_>) -> String {
    let Tuning { response, asked, .. } = report.tuning;
    let margins: Vec<String> = asked
        .iter()
        .map(|limit| format!("{} {}", limit.figure.label, shown(limit.figure.key, limit.value)))
        .collect();
    format!(
        "Asked: of a step of the push by {:.1} kN 5 % after {:.0} ms and {} of overshoot at most; margins, at least: {}.",
        1e-3 * response.height,
        1e3 * response.settle,
        share(response.overshoot),
        listed(&margins, "and")
    )
}

/// How a weld came out, in a cell.
pub(crate) fn of_weld(weld: &WeldOutcome) -> String {
    match weld {
        Err(_) => "not made".to_owned(),
        Ok(weld) => {
            let [lateral, error] = [1e3 * weld.lateral.max_abs, weld.force.error_rms];
            format!("{} mm, {} N", fixed(lateral, 2), fixed(error, 0))
        }
    }
}

/// A law's confirmation in a word.
pub(crate) fn confirmed(yes: bool) -> &'static str {
    if yes { "yes" } else { "NO" }
}
