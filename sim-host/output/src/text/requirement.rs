//! Requirements of a certification: their names, their values, and why one is not met.

use super::Scale;
use trueweld_evaluate::certify::{
    EvidenceKind, FaultTrial, Held, MostMissed, Pace, Reason, Requirement, Shortfall, Symptom,
    Verdict, figure,
};
use trueweld_evaluate::margins::{Condition, FrictionSlope};

/// A requirement's name.
pub(crate) fn label(key: &str) -> &str {
    figure(key).map_or(key, |figure| figure.label)
}

/// The name of a margin that is told with its channel.
pub(crate) fn without_drives(label: &str) -> &str {
    label.trim_end_matches(" at speed").trim_end_matches(", drives")
}

/// The unit in which a figure is shown.
pub(crate) fn scale(key: &str) -> Scale {
    match figure(key).map_or("1", |figure| figure.unit) {
        "s" if key.contains("margin") => Scale { factor: 1e3, unit: "ms" },
        unit => scale_of(key, unit),
    }
}

/// The same of a figure of a weld by its key and SI unit.
pub(crate) fn scale_of(key: &str, unit: &'static str) -> Scale {
    match unit {
        "1" if key.contains("share") => Scale { factor: 1e2, unit: "%" },
        unit => Scale::large(unit),
    }
}

/// A value of a figure in mm, degrees, ms, N, per cent or as a ratio; "none" where there is none.
pub(crate) fn shown(key: &str, value: f64) -> String {
    if !value.is_finite() {
        return "none".to_owned();
    }
    let scale = scale(key);
    let decimals = match scale.unit {
        "ms" | "N" => 0,
        "%" => 1,
        "" | "s" => 2,
        // A margin is of tens of degrees, a tilt of hundredths of one.
        "°" if key.contains("margin") => 1,
        _ => 3,
    };
    scale.with_unit(format!("{:.decimals$}", scale.factor * value))
}

/// Why a requirement is not met or not shown; `None` where it is met.
pub(crate) fn reason(of: &Requirement) -> Option<String> {
    Some(match of.reason.as_ref()? {
        Reason::NoRun => match of.case {
            EvidenceKind::Margins => "no margins were determined",
            EvidenceKind::Draws | EvidenceKind::Rare => "no trial was run",
            EvidenceKind::Faults => "no fault was tried",
            EvidenceKind::Nominal => "no run was made",
            EvidenceKind::WorstCase => "no search for the worst cell was made",
        }
        .to_owned(),
        Reason::Run(run) => {
            let cell = match of.case {
                EvidenceKind::WorstCase => "in the worst cell found",
                _ => "with everything as believed",
            };
            format!("{cell} {}", shortfall(of, run))
        }
        Reason::TooFewDraws { of: trials, enough, at_this_rate, most } => {
            too_few(of, *trials, [*enough, *at_this_rate]) + &most_missed(most)
        }
        Reason::Draws { of: trials, allowed, decided, index, worst, most } => {
            let beyond = of.draws.map_or(0, |draws| draws.beyond);
            let surely = match (of.verdict, decided) {
                (Verdict::Fail, _) => String::new(),
                (_, None) => "; more trials are not expected to decide".to_owned(),
                (_, Some(n)) => format!(
                    "; more trials are not expected to show that it is met: at this rate {n} show that it is not"
                ),
            };
            format!(
                "{beyond} of {trials} cells are beyond the limit, {} allowed{surely}{}; in the worst, trial {index}, {}",
                percent(*allowed),
                most_missed(most),
                shortfall(of, worst)
            )
        }
        Reason::Rare { allowed, probability, reached } => {
            let bound = of.draws.map_or(1.0, |draws| draws.failure_probability);
            let what = match (reached, of.verdict) {
                (false, _) => {
                    "no cell beyond a limit was found, yet the levels do not reach so far"
                }
                (true, Verdict::Fail) => "failures are more frequent than that",
                (true, _) => "more trials would narrow it",
            };
            format!(
                "a weld is beyond a limit with a probability of {probability:.1e}, at most {bound:.1e} at {}, where {allowed:.1e} is allowed: {what}",
                percent(of.confidence)
            )
        }
        Reason::Margin { of: condition, channel } => {
            let [reached, limit] = [of.achieved, of.limit].map(|v| shown(of.name, v));
            format!(
                "{}, the {} of {channel} is {reached} (limit {limit})",
                place_of(condition),
                without_drives(label(of.name))
            )
        }
        Reason::Unstable { of: condition, held, spectral_radius } => {
            let why = match spectral_radius {
                _ if *held => {
                    "the loop stands at a limit, at rest or to and fro, and has no margin there"
                        .to_owned()
                }
                radius if radius.is_finite() => {
                    format!("the loop is not stable: spectral radius {radius:.4}")
                }
                _ => "the loop is not stable: it runs away".to_owned(),
            };
            format!("{}, {why}", place_of(condition))
        }
        Reason::Fault { trial, recovery, beyond } => {
            let mut why = of_fault(of, trial, *recovery);
            if beyond.hits > 1 {
                why += &format!(
                    "; {} of {} runs with a fault are beyond the limit, this one farthest",
                    beyond.hits, beyond.of
                );
            }
            why
        }
    })
}

/// What one fault did: "with a force sensor stuck at its last value from 85.6 s on, in drawn cell 1,
/// the tool leaves its line by up to 3.021 mm (limit 2.500 mm)".
fn of_fault(of: &Requirement, trial: &FaultTrial, recovery: f64) -> String {
    let cell = trial.draw.map_or(String::new(), |index| format!(", in drawn cell {index}"));
    let with = format!("with a {} from {:.1} s on{cell}", trial.fault, trial.time[0]);
    if let Some(why) = &trial.failed {
        return format!("{with}, the weld is not made: {why}");
    }
    match &trial.worst {
        Some(worst) if of.name == "undetected_of_limit" => {
            let what = clause(&worst.name, worst.value, worst.limit);
            format!("{with}, nothing reports a fault, and {what}")
        }
        _ => {
            let what = clause(of.name, trial.figure(of.name), of.limit);
            match of.name.starts_with("recovered_") {
                true => format!("{recovery} s after the end of the fault, {with}, {what} still"),
                false => format!("{with}, {what}"),
            }
        }
    }
}

/// Where in the weld a loop was looked at, with which friction and in which cell.
pub(crate) fn place_of(condition: &Condition) -> String {
    let Condition { at, friction, draw } = condition;
    let mut place = format!("{:.2} m along the weld", at.path);
    if at.ramp {
        let feed = if at.feed > 0.0 { "as the feed rises" } else { "with the tool standing" };
        place += &format!(", {feed} at {:.0} kN", at.push / 1e3);
    }
    place += match friction {
        FrictionSlope::Viscous => ", viscous friction alone",
        FrictionSlope::AtSpeed => "",
        FrictionSlope::Full => ", the drives held by their friction",
    };
    if let Some(index) = draw {
        place += &format!(", in drawn cell {index}");
    }
    place
}

fn too_few(of: &Requirement, trials: usize, [enough, at_this_rate]: [Option<usize>; 2]) -> String {
    let draws = of.draws.as_ref();
    let beyond = draws.map_or(0, |draws| draws.beyond);
    let shows = percent(draws.map_or(1.0, |draws| draws.failure_probability));
    let confidence = percent(of.confidence);
    let enough = |with: &str| enough.map_or(String::new(), |n| format!("; {n} {with} would do"));
    if beyond == 0 {
        return format!(
            "{trials} trials are too few: none is beyond the limit, which shows no more than {shows} at {confidence}{}",
            enough("without one beyond")
        );
    }
    format!(
        "{beyond} of {trials} cells are beyond the limit: few enough, but so few trials show no more than {shows} at {confidence}{}; at this rate {}",
        enough("trials with no more beyond"),
        match at_this_rate {
            Some(n) => format!("{n} show it"),
            None => "no more are expected to show it".to_owned(),
        }
    )
}

/// "; most often push, RMS of its error: 3 cells, up to 452 N (limit 400 N)".
fn most_missed(most: &Option<MostMissed>) -> String {
    most.map_or(String::new(), |MostMissed { name, limit, beyond, worst }| {
        let cells = if beyond == 1 { "cell" } else { "cells" };
        let [worst, limit] = [worst, limit].map(|value| shown(name, value));
        format!("; most often {}: {beyond} {cells}, up to {worst} (limit {limit})", label(name))
    })
}

/// A probability, to a hundredth of a per cent.
fn percent(p: f64) -> String {
    format!("{} %", (1e4 * p).round() / 100.0)
}

/// What one run came to, and what stands out in its loop.
fn shortfall(of: &Requirement, run: &Shortfall) -> String {
    if let Some(why) = &run.failed {
        return format!("the weld is not made: {why}");
    }
    let percent = super::share;
    let held = run.held.map(|held| match held {
        Held::Torque(joint, share) => {
            format!("A{} stands at its torque limit in {} of the time", joint + 1, percent(share))
        }
        Held::Speed(joint, share) => {
            format!("A{} stands at its speed limit in {} of the time", joint + 1, percent(share))
        }
        Held::Authority(share) => {
            format!("the correction stands at its authority in {} of the time", percent(share))
        }
        Held::Compensation(share) => format!(
            "the correction stands at a limit of its size or its rate in {} of the time",
            percent(share)
        ),
        Held::ForceLoop(share) => {
            format!("the force loop stands at its limit in {} of the time", percent(share))
        }
        Held::Fault(share) => {
            format!("the controller is at fault in {} of the time", percent(share))
        }
    });
    let drive = matches!(run.held, Some(Held::Torque(..) | Held::Speed(..)));
    let symptom = run.symptom.map(|symptom| match symptom {
        Symptom::WrongWay(given) => format!(
            "the correction goes the wrong way (it gives {} of what is needed)",
            percent(given)
        ),
        Symptom::Oscillates { amplitude, frequency, grows } => {
            let grows = if grows { " and grows" } else { "" };
            format!(
                "the loop oscillates, the correction by ±{:.2} mm at {frequency:.2} Hz{grows}",
                1e3 * amplitude
            )
        }
        Symptom::TooMuch(given) => {
            format!("the correction gives {} of what is needed", percent(given))
        }
        Symptom::TooLittle(given) => {
            format!("the correction gives only {} of what is needed", percent(given))
        }
        Symptom::Remains { pace, part, whole } => {
            let what = match pace {
                Pace::Slow => "changes over seconds: the law does not see it, or is off by as much",
                Pace::Ripple => "repeats with the spindle, faster than the correction follows",
                Pace::Middle => "comes and goes within seconds",
            };
            format!("what is left, {:.3} mm RMS of {:.3} mm, {what}", 1e3 * part, 1e3 * whole)
        }
    });
    let clause = clause(of.name, run.value, of.limit);
    match (symptom, held) {
        // What a law is blamed for may follow from a drive that gives no more.
        (Some(symptom), Some(held)) if drive => format!("{clause}: {held}; {symptom}"),
        (Some(symptom), Some(held)) => format!("{clause}: {symptom}; {held}"),
        (Some(why), None) | (None, Some(why)) => format!("{clause}: {why}"),
        (None, None) => clause,
    }
}

/// "the tool leaves its line by 8.050 mm RMS (limit 0.050 mm)", of a tool or a law.
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
        "longitudinal_max_m" => {
            format!("the tool is off by up to {reached} along the seam (limit {limit})")
        }
        "depth_error_max_m" => {
            format!("the tool is up to {reached} off the planned depth (limit {limit})")
        }
        "tilt_max_rad" => format!("the tool tilts by up to {reached} (limit {limit})"),
        "push_error_mean_n" => format!("the mean push is off by {reached} (limit {limit})"),
        "speed_error_share" => format!("the mean speed is off by {reached} (limit {limit})"),
        "depth_rms_m" => format!("depth wanders by {reached} RMS (limit {limit})"),
        "depth_max_m" => format!("depth goes off by up to {reached} (limit {limit})"),
        "push_error_rms_n" => format!("the push is off by {reached} RMS (limit {limit})"),
        "measured_push_error_rms_n" => {
            format!("the push that the force sensor reads is off by {reached} RMS (limit {limit})")
        }
        "push_reading_error_n" => {
            format!("the force sensor reads the mean push {reached} wrong (limit {limit})")
        }
        "end.longitudinal_max_m" => {
            format!("the weld ends up to {reached} from where it is to (limit {limit})")
        }
        "correction_m" | "correction_rad" => {
            format!("the correction is driven to {reached} (limit {limit})")
        }
        "torque_share_max" => {
            format!("a drive gives up to {reached} of its torque (limit {limit})")
        }
        "speed_share_max" => {
            format!("a drive runs at up to {reached} of its speed (limit {limit})")
        }
        "of_limit" => format!("a figure comes to {reached} times its limit"),
        name => format!("{} comes to {reached} (limit {limit})", label(name)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_evaluate::Rate;
    use trueweld_evaluate::certify::{Beyond, LimitedFigure};
    use trueweld_evaluate::margins::OperatingPoint;

    /// A requirement that is not met for a reason.
    fn told(case: EvidenceKind, name: &'static str, reason: Reason) -> String {
        let of = Requirement {
            case,
            name,
            limit: 5e-5,
            achieved: 8.05e-3,
            confidence: 0.95,
            draws: Some(Beyond { beyond: 3, failure_probability: 0.31 }),
            verdict: Verdict::NotShown,
            reason: Some(reason),
        };
        super::reason(&of).unwrap() + "\n"
    }

    fn run(symptom: Option<Symptom>, held: Option<Held>) -> Shortfall {
        Shortfall { value: 8.05e-3, failed: None, symptom, held }
    }

    fn trial(key: &str, draw: Option<u64>) -> FaultTrial {
        FaultTrial {
            name: "seam-offset".to_owned(),
            fault: "seam sensor with an offset".to_owned(),
            draw,
            time: [85.6, 88.6],
            detected: None,
            worst: Some(LimitedFigure {
                name: "lateral_max_m".to_owned(),
                value: 6.9e-4,
                limit: 2e-4,
            }),
            figures: Some([(key.to_owned(), 8.05e-3)].into()),
            symptoms: None,
            failed: None,
        }
    }

    #[test]
    fn every_reason_has_its_wording() {
        use EvidenceKind::{Draws, Faults, Margins, Nominal, Rare, WorstCase};
        const RMS: &str = "lateral_rms_m";
        let mut all = String::new();
        for case in [Nominal, Draws, WorstCase, Margins, Faults] {
            all += &told(case, RMS, Reason::NoRun);
        }
        let remains = |pace| Symptom::Remains { pace, part: 3e-5, whole: 4e-5 };
        let oscillates = |grows| Symptom::Oscillates { amplitude: 1.2e-3, frequency: 2.5, grows };
        for symptom in [
            Symptom::WrongWay(-0.8),
            oscillates(false),
            oscillates(true),
            Symptom::TooMuch(1.4),
            Symptom::TooLittle(0.3),
            remains(Pace::Slow),
            remains(Pace::Middle),
            remains(Pace::Ripple),
        ] {
            all += &told(Nominal, RMS, Reason::Run(run(Some(symptom), None)));
        }
        let authority = Held::Authority(0.4);
        all += &told(WorstCase, RMS, Reason::Run(run(Some(oscillates(true)), Some(authority))));
        for held in [
            Held::Torque(1, 0.07),
            Held::Speed(4, 0.004),
            Held::Compensation(0.07),
            Held::ForceLoop(0.07),
            Held::Fault(0.07),
        ] {
            all += &told(WorstCase, RMS, Reason::Run(run(None, Some(held))));
        }
        let drive = run(Some(Symptom::WrongWay(-0.8)), Some(Held::Torque(1, 1.0)));
        all += &told(Nominal, "torque_share_max", Reason::Run(drive));
        let failed =
            || Shortfall { failed: Some("the seam is out of reach".into()), ..run(None, None) };
        all += &told(WorstCase, RMS, Reason::Run(failed()));
        let keys = [
            "lateral_max_m",
            "lateral_before_m",
            "depth_rms_m",
            "push_error_rms_n",
            "correction_m",
            "correction_rad",
            "tilt_rms_rad",
            "longitudinal_max_m",
            "depth_error_max_m",
            "tilt_max_rad",
            "push_error_mean_n",
            "speed_error_share",
            "speed_share_max",
            "at_limit_s",
        ];
        for key in keys {
            all += &told(Nominal, key, Reason::Run(run(None, None)));
        }
        for (enough, at_this_rate) in [(Some(59), Some(260)), (None, None)] {
            let reason = Reason::TooFewDraws { of: 20, enough, at_this_rate, most: None };
            all += &told(Draws, RMS, reason);
        }
        let draws = |most, decided| {
            let worst = run(None, None);
            Reason::Draws { of: 20, allowed: 0.05, decided, index: 7, worst, most }
        };
        all += &told(Draws, RMS, draws(None, None));
        let most = |beyond| {
            Some(MostMissed { name: "push_error_rms_n", limit: 400.0, beyond, worst: 452.0 })
        };
        all += &told(Draws, "of_limit", draws(most(3), Some(120)));
        let few =
            Reason::TooFewDraws { of: 20, enough: Some(93), at_this_rate: None, most: most(1) };
        all += &told(Draws, "of_limit", few);
        for reached in [false, true] {
            let reason = Reason::Rare { allowed: 1e-4, probability: 2e-4, reached };
            all += &told(Rare, "of_limit", reason);
        }
        let at = OperatingPoint { path: 1.2, push: 18e3, feed: 0.01, ramp: false };
        let of = Condition { at, friction: FrictionSlope::AtSpeed, draw: None };
        let standing = OperatingPoint { push: 9e3, feed: 0.0, ramp: true, ..at };
        let conditions = [
            of,
            Condition { friction: FrictionSlope::Viscous, draw: Some(3), ..of },
            Condition { at: standing, friction: FrictionSlope::Full, ..of },
            Condition { at: OperatingPoint { feed: 0.005, ..standing }, ..of },
        ];
        for of in conditions {
            all += &told(Margins, "gain_margin", Reason::Margin { of, channel: "force" });
        }
        for (held, spectral_radius) in [(true, 0.9), (false, 1.02), (false, f64::INFINITY)] {
            let reason = Reason::Unstable { of, held, spectral_radius };
            all += &told(Margins, "gain_margin", reason);
        }
        let failed = FaultTrial { failed: failed().failed, ..trial("", None) };
        let faults = [
            ("recovered_lateral_rms_m", trial("recovered_lateral_rms_m", None), 1),
            ("fault_lateral_max_m", trial("fault_lateral_max_m", Some(1)), 3),
            ("fault_depth_max_m", trial("fault_depth_max_m", None), 1),
            ("undetected_of_limit", trial("undetected_of_limit", None), 2),
            ("fault_depth_max_m", failed, 1),
        ];
        for (key, trial, hits) in faults {
            let beyond = Rate { hits, of: 10 };
            let trial = Box::new(trial);
            all += &told(Faults, key, Reason::Fault { trial, recovery: 15.0, beyond });
        }
        insta::assert_snapshot!(all);
    }
}
