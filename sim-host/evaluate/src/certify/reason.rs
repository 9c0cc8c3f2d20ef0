//! Why a requirement was not met, in words: what the runs came to, and what their symptoms say of
//! the loop.
//!
//! Nothing is said here that a recording does not show. Where no symptom stands out, the figure
//! stands alone.

use super::{FAULT_FIGURES, FaultTrial, Symptoms, Trial};
use crate::Rate;
use crate::figure::Figure;
use crate::margins::{LeastMargin, MARGIN_FIGURES, Margins};
use crate::requirements::Faults;
use crate::weld::WELD_FIGURES;

/// Share of what is needed below which a correction goes the wrong way; so much may be chance where
/// little is needed.
const WRONG_WAY: f64 = -0.2;

/// Share of what is needed above which a correction gives too much, where only its authority holds
/// it.
const TOO_MUCH: f64 = 1.1;

/// Correlation of a swing with itself one period later above which it is one and no noise.
const REGULAR: f64 = 0.5;

/// Least amplitude of a swing that is spoken of, m: noise of a seam sensor comes through with a
/// tenth of it.
const SWINGS: f64 = 1e-4;

/// The figure with a key, of whichever kind of run.
pub fn figure(key: &str) -> Option<&'static Figure> {
    let weld = WELD_FIGURES.iter().map(|of| &of.figure);
    let margins = MARGIN_FIGURES.iter().map(|of| &of.figure);
    let faults = FAULT_FIGURES.iter().map(|of| &of.of.figure);
    weld.chain(margins).chain(faults).find(|figure| figure.key == key)
}

/// A requirement's name in words.
pub fn label(key: &str) -> &str {
    figure(key).map_or(key, |figure| figure.label)
}

/// A value of a figure in mm, degrees, ms, N or as a ratio; "none" where there is none.
pub fn shown(key: &str, value: f64) -> String {
    match figure(key).map_or("1", |figure| figure.unit) {
        _ if !value.is_finite() => "none".to_owned(),
        "s" => format!("{:.0} ms", 1e3 * value),
        "m" => format!("{:.3} mm", 1e3 * value),
        "rad" => format!("{:.3}°", value.to_degrees()),
        "N" => format!("{value:.0} N"),
        _ => format!("{value:.2}"),
    }
}

/// Why a margin is too small.
pub(super) fn margin(name: &str, limit: f64, least: Option<(&Margins, LeastMargin)>) -> String {
    let Some((at, (least, channel))) = least else {
        return "no margins were determined".to_owned();
    };
    let place = format!("{:.2} m along the weld", at.path);
    if at.channels.is_none() {
        let why = match at.spectral_radius {
            _ if at.held => "only a limit holds it".to_owned(),
            radius if radius.is_finite() => format!("spectral radius {radius:.4}"),
            _ => "it runs away".to_owned(),
        };
        return format!("{place}, the loop is not stable: {why}");
    }
    let [reached, limit] = [least, limit].map(|v| shown(name, v));
    format!(
        "{place}, the {} of {channel} is {reached} (limit {limit})",
        label(name).trim_end_matches(", drives")
    )
}

/// "leaves its line by 8.05 mm RMS (limit 0.05 mm)", of a tool or a law.
fn clause(name: &str, value: f64, limit: f64) -> String {
    let [reached, limit] = [value, limit].map(|v| shown(name, v));
    match name.strip_prefix("recovered_").or(name.strip_prefix("fault_")).unwrap_or(name) {
        "lateral_rms_m" => format!("the tool leaves its line by {reached} RMS (limit {limit})"),
        "lateral_max_m" => format!("the tool leaves its line by up to {reached} (limit {limit})"),
        "lateral_before_m" => {
            format!(
                "the tool leaves its line by up to {reached} before the steady part (limit {limit})"
            )
        }
        "depth_rms_m" => format!("depth wanders by {reached} RMS (limit {limit})"),
        "depth_max_m" => format!("depth goes off by up to {reached} (limit {limit})"),
        "push_error_rms_n" => format!("the push is off by {reached} RMS (limit {limit})"),
        "correction_m" | "correction_rad" => {
            format!("the correction is driven to {reached}, beyond the authority of {limit}")
        }
        name => format!("{} comes to {reached} (limit {limit})", label(name)),
    }
}

/// Of the cell as it is believed to be.
pub(super) fn nominal(name: &str, limit: f64, value: f64, trial: &Trial) -> String {
    match &trial.failed {
        Some(why) => format!("with everything as believed the weld is not made: {why}"),
        None => {
            let clause = clause(name, value, limit);
            format!(
                "with everything as believed {clause}{}",
                because(name, trial.symptoms.as_ref())
            )
        }
    }
}

/// Of draws: too many beyond the limit, or too few to show that there are few enough. `asked`:
/// allowed probability and confidence; `worst`: the worst trial and its figure.
pub(super) fn draws(
    name: &str,
    limit: f64,
    beyond: Rate,
    asked: [f64; 2],
    worst: Option<(&Trial, f64)>,
) -> String {
    let [probability, confidence] = asked;
    let percent = |p: f64| format!("{} %", (1e4 * p).round() / 100.0);
    let Some((trial, value)) = worst else {
        return "no trial was run".to_owned();
    };
    let needed = (beyond.of..=100_000).find(|n| {
        *n > beyond.hits && Rate { hits: beyond.hits, of: *n }.at_most(confidence) <= probability
    });
    let shows = percent(beyond.at_most(confidence));
    if beyond.hits == 0 {
        let enough = needed.map_or(String::new(), |n| format!("; {n} without one beyond would do"));
        return format!(
            "{} trials are too few: none is beyond the limit, which shows no more than {shows} at {}{enough}",
            beyond.of,
            percent(confidence)
        );
    }
    let share = beyond.hits as f64 / beyond.of as f64;
    let many = format!("{} of {} cells are beyond the limit", beyond.hits, beyond.of);
    if share <= probability {
        let enough =
            needed.map_or(String::new(), |n| format!("; {n} trials with no more beyond would do"));
        let confidence = percent(confidence);
        return format!(
            "{many}: few enough, but so few trials show no more than {shows} at {confidence}{enough}"
        );
    }
    let surely = if beyond.at_least(confidence) > probability {
        ""
    } else {
        "; more trials may tell otherwise"
    };
    let allowed = percent(probability);
    let why = match &trial.failed {
        Some(why) => format!("the weld is not made: {why}"),
        None => format!("{}{}", clause(name, value, limit), because(name, trial.symptoms.as_ref())),
    };
    format!("{many}, {allowed} allowed{surely}; in the worst, trial {}, {why}", trial.index)
}

/// Of the worst cell found.
pub(super) fn worst_case(name: &str, limit: f64, worst: Option<(&Trial, f64)>) -> String {
    match worst {
        None => "no run was made".to_owned(),
        Some((Trial { failed: Some(why), .. }, _)) => {
            format!("in the worst cell found the weld is not made: {why}")
        }
        Some((trial, value)) => {
            let clause = clause(name, value, limit);
            format!("in the worst cell found {clause}{}", because(name, trial.symptoms.as_ref()))
        }
    }
}

/// Of fault cases. `worst`: the worst case and its figure; `many`: cases beyond the limit, and all
/// of them.
pub(super) fn fault(
    name: &str,
    limit: f64,
    asked: &Faults,
    worst: Option<(&FaultTrial, f64)>,
    many: [usize; 2],
) -> String {
    let Some((trial, value)) = worst else {
        return "no fault was tried".to_owned();
    };
    let with = format!("with a {}", trial.fault);
    let others = match many[0] {
        0 | 1 => String::new(),
        beyond => {
            format!("; {beyond} of {} faults are beyond the limit, this one farthest", many[1])
        }
    };
    let why = match &trial.failed {
        Some(why) => return format!("{with} the weld is not made: {why}"),
        None if name.starts_with("recovered_") => {
            let after = asked.recovery;
            format!(
                "{after} s after the end of the fault, {with}, {} still",
                clause(name, value, limit)
            )
        }
        None => format!("{with} {}", clause(name, value, limit)),
    };
    format!("{why}{others}")
}

/// What the symptoms say, from ": " on; empty where nothing stands out.
fn because(name: &str, symptoms: Option<&Symptoms>) -> String {
    let Some(s) = symptoms else {
        return String::new();
    };
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let direction = match name {
        "side_tilt_rms_rad" => 1,
        "travel_angle_rms_rad" => 2,
        _ => 0,
    };
    let pushed = name == "push_error_rms_n" || name == "depth_rms_m";
    let held = match (s.at_authority, s.limited) {
        (authority, _) if authority >= 0.05 => {
            format!(", held at its authority in {} of the time", percent(authority))
        }
        (_, limited) if limited >= 0.05 => {
            format!(", held at a limit in {} of the time", percent(limited))
        }
        _ => String::new(),
    };
    let swing = s.swing;
    // Wherever the sign is wrong it is said first: what follows from it may swing as well.
    if let Some(given) = s.given[direction].filter(|given| *given < WRONG_WAY) {
        return format!(
            ": the correction goes the wrong way (it gives {} of what is needed){held}",
            percent(given)
        );
    }
    if swing.amplitude >= SWINGS && swing.regularity >= REGULAR {
        let grows = if swing.growth > 1.5 { " and grows" } else { "" };
        let [amplitude, frequency] = [1e3 * swing.amplitude, swing.frequency];
        return format!(
            ": the loop swings, the correction by ±{amplitude:.2} mm at {frequency:.2} Hz{grows}{held}"
        );
    }
    if let Some(given) =
        s.given[direction].filter(|given| *given > TOO_MUCH && s.at_authority >= 0.05)
    {
        return format!(": the correction gives {} of what is needed{held}", percent(given));
    }
    if !held.is_empty() {
        return format!(": the correction is{}", held.trim_start_matches(','));
    }
    if pushed || name.starts_with("correction") {
        return String::new();
    }
    if let Some(given) = s.given[direction].filter(|given| *given < 0.5) {
        return format!(": the correction gives only {} of what is needed", percent(given));
    }
    if !name.starts_with("lateral") || name == "lateral_before_m" {
        return String::new();
    }
    let [slow, swinging, ripple] = s.lateral;
    let [whole, most] = [slow.hypot(swinging).hypot(ripple), slow.max(swinging).max(ripple)];
    let what = if most == slow {
        "changes over seconds: the law does not see it, or is off by as much"
    } else if most == ripple {
        "repeats with the spindle, faster than the correction follows"
    } else {
        "comes and goes within seconds"
    };
    format!(": what is left, {:.3} mm RMS of {:.3} mm, {what}", 1e3 * most, 1e3 * whole)
}
