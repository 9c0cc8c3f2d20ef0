//! What was found, in two plain sentences.

use crate::data::log::LogKind;
use crate::diagnose::{FittedEffect, parts};
use crate::fit::{FitProblem, Residuals};
use std::collections::BTreeMap;
use trueweld_plant::effects::{Effect, Location};
use trueweld_plant::input::RobotFile;
use trueweld_plant::robot::Channel;

/// An explanation to be put into words.
#[derive(Debug, Clone, Copy)]
pub struct ExplainedCase<'a> {
    /// The robot, for the names of its joints.
    pub robot: &'a RobotFile,
    /// The logs that were fitted.
    pub bench: &'a FitProblem,
    /// The effects of the explanation, with their intervals.
    pub effects: &'a [FittedEffect],
    /// Residuals with calibrations alone.
    pub before: &'a Residuals,
    /// Residuals with the effects.
    pub after: &'a Residuals,
    /// Score on rows left out of the fit, without and with the effects.
    pub held_out: [f64; 2],
    /// How likely the explanation is, 0 to 1.
    pub probability: f64,
    /// Effects, each with what it is at (nothing for the whole cell), that these data do not tell
    /// from it.
    pub others: &'a [(&'a str, &'a str)],
}

/// Two sentences: what is there, of which size, and which channel it mends; then how sure that is,
/// and its mark in the data.
pub fn explain(case: &ExplainedCase<'_>) -> String {
    let found: Vec<String> = case.effects.iter().map(|f| statement(f, case.robot)).collect();
    let what = match found.as_slice() {
        [] => "no effect was found".to_owned(),
        all => all.join(", and "),
    };
    let mends = match mended(case) {
        Some((kind, channel, before, after)) => format!(
            ", which lowers the error of {channel} in the {} from {before:.1} to {after:.1} times the noise",
            logs(kind)
        ),
        None => ", which lowers the error of no channel".to_owned(),
    };
    let [before, after] = case.held_out;
    let score = match before - after {
        fall if fall > 5e-3 => format!("the score falls from {before:.2} to {after:.2}"),
        fall if fall < -5e-3 => format!("the score rises from {before:.2} to {after:.2}"),
        _ => format!("the score stays at {after:.2}"),
    };
    let alike: Vec<String> = case.others.iter().map(|(id, at)| placed(id, at)).collect();
    let alike = match alike.as_slice() {
        [] => "no other explanation that was tried fits as well".to_owned(),
        all => format!("{} would explain these data as well", listed(all)),
    };
    let marks: Vec<&str> =
        case.effects.iter().map(|f| f.effect.kind.shows).filter(|s| !s.is_empty()).collect();
    let mark = match marks.as_slice() {
        [] => String::new(),
        all => format!("; its mark in the data: {}", all.join("; and ")),
    };
    format!(
        "{}{mends}. On rows left out of the fit {score} (probability {}); {alike}{mark}.",
        capital(&what),
        percent(case.probability)
    )
}

/// The kind of logs and the channel whose sum of squares falls most, with its error over the noise
/// before and after.
fn mended(case: &ExplainedCase<'_>) -> Option<(LogKind, &'static str, f64, f64)> {
    let mut sums: BTreeMap<(usize, &'static str), [f64; 3]> = BTreeMap::new();
    let mut add = |residuals: &Residuals, which: usize| {
        for ((log, channel), part) in parts(case.bench, residuals) {
            let kind = case.bench.experiments[log].kind;
            let place = LogKind::ALL.iter().position(|k| *k == kind).unwrap_or(0);
            let sum = sums.entry((place, channel)).or_default();
            sum[which] += part.square;
            sum[2] += if which == 0 { part.count as f64 } else { 0.0 };
        }
    };
    add(case.before, 0);
    add(case.after, 1);
    let ((place, channel), [before, after, count]) =
        sums.into_iter().max_by(|a, b| (a.1[0] - a.1[1]).total_cmp(&(b.1[0] - b.1[1])))?;
    let error = |square: f64| (square / count).sqrt();
    (before > after).then(|| (LogKind::ALL[place], channel, error(before), error(after)))
}

fn logs(kind: LogKind) -> &'static str {
    match kind {
        LogKind::StaticLoad => "static loads",
        LogKind::RingDown => "ring-downs",
        LogKind::FreeMotion => "free motions",
        LogKind::Weld => "welds",
    }
}

fn placed(id: &str, at: &str) -> String {
    if at.is_empty() { id.to_owned() } else { format!("{id} at {at}") }
}

fn listed(all: &[String]) -> String {
    match all {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} or {last}", first.join(", ")),
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Nothing that was fitted to data is certain, nor is anything out of the question.
fn percent(share: f64) -> String {
    match 100.0 * share {
        p if p > 99.5 => "above 99 %".to_owned(),
        p if p < 0.5 => "below 1 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// What one effect is, where, and of which size.
fn statement(found: &FittedEffect, robot: &RobotFile) -> String {
    let effect = &found.effect;
    let of_joint =
        |j: usize| robot.joint_names.get(j).cloned().unwrap_or_else(|| format!("joint {}", j + 1));
    let j = if let Location::Joint(j) = effect.at { j } else { 0 };
    let (name, before) = (of_joint(j), of_joint(j.saturating_sub(1)));
    let v = |k: usize| effect.values.get(k).copied().unwrap_or(0.0);
    // The value of a parameter, and its size with what its sign says.
    let is = |k: usize| quantity(found, k, 1.0);
    let size = |k: usize| quantity(found, k, v(k).signum());
    let by = |k: usize, more: &str, less: &str| {
        format!("{} {}", size(k), if v(k) < 0.0 { less } else { more })
    };
    let norm = |k: usize, unit: &str| plain(v(k).hypot(v(k + 1)).hypot(v(k + 2)), unit);
    let text = match effect.kind.id {
        "stiffness-error" => format!("{name} is {} than in the model", by(0, "stiffer", "softer")),
        "damping-error" => {
            format!("the damping of {name} is {} than in the model", by(0, "higher", "lower"))
        }
        "nonlinear-stiffness" => format!(
            "the spring of {name} becomes {} under load than about zero torque, from a twist of {} on",
            by(0, "stiffer", "softer"),
            is(1)
        ),
        "backlash" => format!("{name} has a backlash of ± {}", is(0)),
        "hysteresis" => format!(
            "the gear of {name} has friction under load, a torque–twist loop of ± {} that turns round over {}",
            is(0),
            is(1)
        ),
        "joint-friction" => format!(
            "{name} has {} Coulomb friction and {} viscous friction than the model",
            by(0, "more", "less"),
            by(1, "more", "less")
        ),
        "stribeck" => {
            format!(
                "{name} has {} friction at creep than at speed, fading over {}",
                by(0, "more", "less"),
                is(1)
            )
        }
        "asymmetric-friction" => {
            format!(
                "{name} has {} friction in positive than in negative motion",
                by(0, "more", "less")
            )
        }
        "transmission-error" => {
            format!(
                "the gear of {name} has a transmission error of amplitude {}, {:.2} periods a turn",
                size(0),
                v(1)
            )
        }
        "wrist-coupling" => format!("{name} turns along with {before}, by {} of its angle", is(0)),
        "bearing-tilt" => {
            format!("the bearing of {name} tilts by {} of moment across its axis", is(0))
        }
        "base-compliance" => format!("the base tilts on its foot by {} of moment", is(0)),
        "counterbalance-loss" => match v(0) < 0.0 {
            true => format!("the counterbalance gives {} more torque than in the model", size(0)),
            false => format!("the counterbalance has lost {} of its torque", is(0)),
        },
        "payload-error" => format!(
            "the tool is {} than in the model and its centre of mass lies {} further along x, {} along y and {} along z of the \
             last link",
            by(0, "heavier", "lighter"),
            is(1),
            is(2),
            is(3)
        ),
        "encoder-offset" => format!("{name} stands {} from where its encoder says", is(0)),
        "link-encoder-offset" => format!("the second encoder of {name} reads {} too much", is(0)),
        "link-encoder-ripple" => format!(
            "the second encoder of {name} has an error of its own of amplitude {}, {:.2} periods a turn",
            size(0),
            v(1)
        ),
        "tracker-registration" => {
            format!("the tracker's frame is off by {} and {}", norm(0, "m"), norm(3, "rad"))
        }
        "thermal-drift" => format!(
            "the tool drifts by {} in the end ({} along x, {} along y, {} along z of the base) with a time constant of {}",
            norm(0, "m"),
            plain(v(0), "m"),
            plain(v(1), "m"),
            plain(v(2), "m"),
            is(3)
        ),
        "force-crosstalk" => {
            format!(
                "the force sensor reads {} of the axial force along x and {} along y",
                is(0),
                is(1)
            )
        }
        "force-offset" => {
            format!(
                "the force sensor reads {} too much along x, {} along y and {} along z",
                is(0),
                is(1),
                is(2)
            )
        }
        "channel-delay" => format!(
            "{} {}",
            instrument(effect.at),
            match v(0) < 0.0 {
                true => format!("is {} ahead of the encoders", size(0)),
                false => format!("lags the encoders by {}", is(0)),
            }
        ),
        "process-stiffness-error" => {
            format!("the material resists the push {} than in the model", by(0, "more", "less"))
        }
        "drag-error" => {
            format!("the drag along the seam is {} than in the model", by(0, "higher", "lower"))
        }
        "thermal-softening" => format!(
            "the process forces {} by {} as the weld goes on, with a time constant of {}",
            if v(0) < 0.0 { "rise" } else { "fall" },
            size(0),
            is(1)
        ),
        "feed-power-law" => {
            format!(
                "the drag grows with the feed to the power of {} and not in proportion",
                ratio(found, 0)
            )
        }
        "advancing-side" => {
            format!(
                "a force across the seam of {} of the push acts besides, in the spindle's sense",
                is(0)
            )
        }
        "spindle-harmonic" => format!(
            "the force has one more ripple at {:.2} times the spindle's speed, {} of the push and {} in the plane",
            v(0),
            size(1),
            size(2)
        ),
        "plate-waviness" => {
            format!("the plate is wavy, with an amplitude of {} every {}", size(0), is(1))
        }
        "fixture-compliance" => {
            format!("the fixture gives way under the push, with a stiffness of {}", is(0))
        }
        "material-step" => format!(
            "the process forces are {} beyond {} of the path",
            by(0, "higher", "lower"),
            is(1)
        ),
        _ => own(found, effect, robot),
    };
    match found.log {
        Some(log) => format!("{text} in log {}", log + 1),
        None => text,
    }
}

/// An effect of the user's own: its name and all its values.
fn own(found: &FittedEffect, effect: &Effect, robot: &RobotFile) -> String {
    let values: Vec<String> = effect
        .kind
        .parameters
        .iter()
        .enumerate()
        .map(|(k, p)| format!("{} = {}", p.name, quantity(found, k, 1.0)))
        .collect();
    let place = placed(effect.kind.id, effect.at_name(robot));
    if values.is_empty() {
        format!("there is {place}")
    } else {
        format!("there is {place} with {}", values.join(", "))
    }
}

fn instrument(at: Location) -> &'static str {
    match at {
        Location::Channel(Channel::Tracker) => "the tracker",
        Location::Channel(Channel::Wrench) => "the force sensor",
        Location::Channel(Channel::MotorTorque) => "the motor torque",
        Location::Channel(Channel::LinkEncoder) => "the second encoders' reading",
        _ => "the instrument",
    }
}

/// Factor and unit that engineers read a value in.
fn readable(value: f64, unit: &str) -> (f64, &str) {
    let size = value.abs();
    match unit {
        "rad" if size < 1e-3 => (1e6, "µrad"),
        "rad" => (1e3, "mrad"),
        "rad/s" => (1e3, "mrad/s"),
        "m" if size < 1e-3 => (1e6, "µm"),
        "m" if size < 1.0 => (1e3, "mm"),
        "s" if size < 0.1 => (1e3, "ms"),
        "1" => (1e2, "%"),
        "N" if size >= 1e4 => (1e-3, "kN"),
        "N·m" if size >= 1e4 => (1e-3, "kN·m"),
        "N/m" => (1e-6, "kN/mm"),
        "rad/(N·m)" => (1e9, "nrad/(N·m)"),
        other => (1.0, other),
    }
}

/// A fitted value with its unit and 95 % interval, times a sign.
fn quantity(found: &FittedEffect, k: usize, sign: f64) -> String {
    let unit = found.effect.kind.parameters.get(k).map_or("", |p| p.unit);
    let value = found.effect.values.get(k).copied().unwrap_or(0.0);
    let (factor, unit) = readable(value, unit);
    with_interval(found, k, sign * factor, unit)
}

/// A fitted value that is not read in per cent.
fn ratio(found: &FittedEffect, k: usize) -> String {
    with_interval(found, k, 1.0, "")
}

fn with_interval(found: &FittedEffect, k: usize, factor: f64, unit: &str) -> String {
    let value = factor * found.effect.values.get(k).copied().unwrap_or(0.0);
    let [a, b] = found.interval.get(k).map_or([value; 2], |i| i.map(|end| factor * end));
    let (low, high) = (a.min(b), a.max(b));
    let half = 0.5 * (high - low);
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    if !(half > 0.0 && half.is_finite()) {
        return format!("{}{unit}", digits(value));
    }
    // As many decimals as the interval has something to say of, and three digits where it is wide.
    let decimals = ((1.0 - half.log10().floor()).min(2.0 - value.abs().max(half).log10().floor()))
        .clamp(0.0, 6.0) as usize;
    format!("{value:.decimals$}{unit} (95 %: {low:.decimals$} to {high:.decimals$})")
}

/// A value without an interval.
fn plain(value: f64, unit: &str) -> String {
    let (factor, unit) = readable(value, unit);
    format!("{} {unit}", digits(factor * value))
}

/// Three digits that count.
fn digits(value: f64) -> String {
    let decimals =
        if value == 0.0 { 0 } else { (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize };
    format!("{value:.decimals$}")
}
