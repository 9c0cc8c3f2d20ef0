//! What is said of numbers that were identified.

use super::diagnose::known;
use super::{Scale, counted, digits, fixed, listed, score, share, signed_share};
use crate::{IdentifyReport, StiffnessPlanReport};
use trueweld_estimate::identify::plan::{LoadKind, PlannedLoad};
use trueweld_estimate::identify::{
    Identification, IdentificationTarget, Mode, Number, Section, StiffnessCurve, WeldPart,
};
use trueweld_logs::HALF_95;

/// Score from which on the model itself counts as not fitting: a third above the noise.
const MISFIT: f64 = 1.3;

/// Correlation from which on two numbers are told together rather than each.
const TOLD_TOGETHER_CORRELATION: f64 = 0.9;

/// True where residuals are well above the noise at the numbers found.
pub(crate) fn is_misfit(found: &Identification) -> bool {
    found.score > MISFIT
}

/// Half of a number's interval over its value.
pub(crate) fn half_width(number: &Number) -> Option<f64> {
    number.interval.map(|[low, high]| 0.5 * (high - low) / number.value.abs())
}

/// A number with four digits and its power of ten.
pub(crate) fn quantity(value: f64, unit: &str) -> String {
    match unit {
        _ if value.is_nan() => return "–".to_owned(),
        "rad" => return Scale::large("rad").quantity(value),
        "m" => return Scale::small("m").quantity(value),
        "1" => return digits(value, 4),
        _ => {}
    }
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
        Some(half) if number.unit == "rad" => {
            let half = Scale::large("rad").quantity(half * number.value.abs());
            format!("{} ± {half}", quantity(number.value, number.unit))
        }
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
    if is_misfit(found) {
        return format!(
            "The model does not fit these logs, whatever its {}: something else is missing in it.",
            found.target.name()
        );
    }
    if found.target == IdentificationTarget::Process {
        return headline_of_process(found);
    }
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

fn headline_of_process(found: &Identification) -> String {
    let of_file = found.numbers.iter().filter(|n| n.at.is_empty());
    let (told, untold): (Vec<&Number>, Vec<&Number>) = of_file.partition(|n| n.is_identifiable());
    let mut orders: Vec<&str> =
        found.numbers.iter().filter_map(|n| n.at.strip_prefix("order ")).collect();
    orders.dedup();
    let ripple = match orders.as_slice() {
        [] => "no order of the ripple stands out".to_owned(),
        [one] => format!("the ripple has order {one}"),
        all => format!("the ripple has orders {}", listed(all, "and")),
    };
    let rest = if untold.is_empty() {
        String::new()
    } else {
        format!(" They do not tell {}.", named(&untold))
    };
    match told.len() {
        0 => format!("These welds tell none of the process' numbers; {ripple}.{rest}"),
        _ => format!("These welds tell {}; {ripple}.{rest}", named(&told)),
    }
}

/// A weld's part in words.
pub(crate) fn part(section: &Section) -> &'static str {
    match section.part {
        WeldPart::Standing => "standing, the push changes",
        WeldPart::FeedChange => "the feed changes",
        WeldPart::Steady => "steady",
    }
}

/// The joints that hold most of a mode's energy, those with a tenth and more.
pub(crate) fn joints_of(mode: &Mode, names: &[String]) -> String {
    let mut of: Vec<(f64, &String)> = mode.shares.iter().copied().zip(names).collect();
    of.sort_by(|a, b| b.0.total_cmp(&a.0));
    let parts = of
        .iter()
        .filter(|(s, _)| *s >= 0.1)
        .map(|(s, name)| format!("{name} {}", share((s * 100.0).round() / 100.0)));
    parts.collect::<Vec<_>>().join(", ")
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
            "{scores} The numbers are what fits best without it, and their intervals do not hold the truth. Run \
             `trueweld diagnose` first."
        )
    } else {
        scores
    }
}

/// How the result came about.
pub(crate) fn setting(report: &IdentifyReport<'_>) -> String {
    let found = report.found;
    let mut text = format!(
        "Model {}, {} ({}), {} compared. Fitted without a prior, beside {}encoder zeros, tracker registration and \
         mounting of the links.",
        report.model.path.display(),
        counted(found.logs.len(), "log"),
        listed(&found.logs, "and"),
        counted(found.samples, "value"),
        if report.model.known.is_empty() { "" } else { "what is not known of " },
    );
    text += &known(report.model);
    if !found.left_out.is_empty() {
        text += &format!(" Not used: {}.", listed(&found.left_out, "and"));
    }
    text
}

/// What these logs leave open, and what to do.
pub(crate) fn open(report: &IdentifyReport<'_>) -> Vec<String> {
    let found = report.found;
    let mut notes = Vec::new();
    let bent: Vec<&str> = found
        .curves
        .iter()
        .filter(|curve| !curve.is_linear())
        .map(|curve| report.model.robot.joint_names[curve.joint].as_str())
        .collect();
    if !bent.is_empty() {
        notes.push(format!(
            "{}: the spring is not linear, and one number holds for loads like these only. `trueweld improve` finds the effect \
             and adds it.",
            listed(&bent, "and")
        ));
    }
    let untold: Vec<&Number> = found.numbers.iter().filter(|n| !n.is_identifiable()).collect();
    if !untold.is_empty() {
        notes.push(format!(
            "{}: these logs do not tell the {}; the file keeps the value given.",
            named(&untold),
            found.target.name()
        ));
    }
    let rigid = found.model.robot.rigid.iter().zip(&found.model.robot.joint_names);
    let rigid: Vec<&str> = rigid.filter(|(rigid, _)| **rigid).map(|(_, n)| n.as_str()).collect();
    if found.target == IdentificationTarget::Damping && !rigid.is_empty() {
        notes.push(format!(
            "{}: stated to be rigid, without a damping. Loads at rest tell whether it bends: `trueweld identify stiffness`.",
            listed(&rigid, "and")
        ));
    }
    let off = |n: &&Number| {
        let apart = |[low, high]: [f64; 2]| n.given < low || n.given > high;
        found.target == IdentificationTarget::Damping && n.interval.is_some_and(apart)
    };
    let off: Vec<&Number> = found.beside.iter().filter(off).collect();
    if !off.is_empty() {
        let each: Vec<String> = off
            .iter()
            .map(|n| format!("{} {}", n.at, signed_share(n.value / n.given - 1.0)))
            .collect();
        notes.push(format!(
            "The logs ask for another stiffness than the model has: {}. It was free beside the damping; the file keeps the \
             one given. Loads at rest tell it: `trueweld identify stiffness`.",
            listed(&each, "and")
        ));
    }
    let correlated = found.correlation.nrows();
    for i in 0..correlated {
        for j in i + 1..correlated {
            let [a, b] = [&found.numbers[i], &found.numbers[j]];
            let correlation = found.correlation[(i, j)];
            if a.is_identifiable()
                && b.is_identifiable()
                && correlation.abs() > TOLD_TOGETHER_CORRELATION
            {
                notes.push(format!(
                    "{} and {} are told together (correlation {}): only logs of another kind or posture tell them apart.",
                    named(&[a]),
                    named(&[b]),
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
        Some(curve) if curve.is_linear() && curve.chance < 0.01 => "in doubt (p < 0.01)".to_owned(),
        Some(curve) if curve.is_linear() => format!("yes (p = {})", digits(curve.chance, 2)),
        Some(_) => "no (p < 0.000001)".to_owned(),
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

/// 95 % of a logarithm, over the value.
pub(crate) fn expected(deviation: f64) -> String {
    if deviation.is_finite() {
        format!("± {}", share(HALF_95 * deviation))
    } else {
        "not told".to_owned()
    }
}

/// What a plan promises.
pub(crate) fn plan_headline(report: &StiffnessPlanReport<'_>) -> String {
    let plan = report.plan;
    let worst = plan.deviations.iter().copied().fold(0.0, f64::max);
    let loads = counted(plan.loads.len(), "load");
    let names = &report.model.robot.joint_names;
    let untold = |deviations: &[f64; 6]| -> Vec<String> {
        let of = deviations.iter().zip(names).filter(|(d, _)| d.is_infinite());
        of.map(|(_, name)| name.clone()).collect()
    };
    let here = untold(&plan.deviations);
    if !here.is_empty() {
        return format!(
            "{loads} do not tell the stiffness of {}: ask for more loads, or heavier ones.",
            listed(&here, "and")
        );
    }
    let by_hand = untold(&plan.by_hand_deviations);
    let hand = if plan.by_hand.is_empty() {
        String::new()
    } else if by_hand.is_empty() {
        let factor = gain(&plan.deviations, &plan.by_hand_deviations);
        format!(" As many picked by hand leave intervals {} times as wide.", digits(factor, 2))
    } else {
        format!(" As many picked by hand do not tell {}.", listed(&by_hand, "and"))
    };
    format!(
        "{loads} tell the stiffness of all joints to {} or better (95 %).{hand}",
        expected(worst)
    )
}

/// Geometric mean of what intervals are wider by.
fn gain(planned: &[f64; 6], by_hand: &[f64; 6]) -> f64 {
    let logs: f64 = planned.iter().zip(by_hand).map(|(a, b)| (b / a).ln()).sum();
    (logs / 6.0).exp()
}

/// How a load acts.
pub(crate) fn load(report: &StiffnessPlanReport<'_>, planned: &PlannedLoad) -> String {
    match planned.load {
        LoadKind::Payload => format!("{} kg on the flange", fixed(report.options.payload, 0)),
        LoadKind::Push(force) => {
            let [x, y, z] = [force.x, force.y, force.z].map(|f| fixed(f, 0));
            format!("push [{x}, {y}, {z}] N in base axes, both ways")
        }
    }
}

/// How a plan came about, and what it leaves out.
pub(crate) fn plan_setting(report: &StiffnessPlanReport<'_>) -> String {
    format!(
        "D-optimal among {} loads at postures within the limits, above the floor and clear of the base, with at most 0.8 of \
         the drives' torque; three reflectors seen to {} each. The way between postures and what stands in the cell are \
         yours to check.",
        report.plan.candidates,
        Scale::small("m").quantity(report.options.noise)
    )
}
