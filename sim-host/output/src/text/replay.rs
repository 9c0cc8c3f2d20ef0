//! What is said of a recorded run of a core, and of a recorded weld that is made again.

use super::{Scale, counted, fixed, listed, share};
use crate::{AxisDisturbance, FromLog};
use trueweld_evaluate::{CoreDifference, CoreOutput, CoreReadings, CoreReplay, CoreScalar};

/// Largest difference of a torque over the drive's limit that rounding makes of another library of
/// mathematics: in `double` and in `float`.
const ROUNDING_SHARES: [f64; 2] = [1e-9, 1e-3];

/// Share of what the load bent up to which a replay counts as one.
const REPLAYED_SHARE: f64 = 0.2;

/// Share of what the load bent up to which a path was taught elsewhere; further off it was commanded.
const TAUGHT_SHARE: f64 = 0.5;

/// Words for a law in a sentence.
fn under(law: &str) -> String {
    match law {
        "none" => "without compensation".to_owned(),
        law => format!("with {law} compensation"),
    }
}

/// The finding: equal, or where first not.
pub(crate) fn headline(of: &CoreReplay) -> String {
    let scalar = match of.scalar {
        CoreScalar::Float => "float",
        CoreScalar::Double => "double",
    };
    let run = format!(
        "{} of the core with the law {}, in {scalar}",
        counted(of.periods, "period"),
        of.law
    );
    let Some(first) = &of.first else {
        return format!("Equal to the last bit: {run}.");
    };
    format!(
        "The first difference is in period {} ({:.3} s, {} along the seam): {}. {} of {run} differ, by up to {:.1e} of a drive's \
         largest torque.",
        first.period,
        first.time_s,
        Scale::small("m").quantity(first.readings.path_m),
        difference(first),
        of.differing,
        of.torque_share_max
    )
}

fn difference(of: &CoreDifference) -> String {
    let (recorded, replayed) = (of.recorded, of.replayed);
    let apart = replayed - recorded;
    let pair = |unit: &str| {
        format!(
            "recorded {recorded:e} {unit}, computed here {replayed:e} {unit}, {apart:+.2e} {unit} apart"
        )
    };
    let axis = ["x", "y", "z"][of.index % 3];
    match of.output {
        CoreOutput::Fault => {
            let told = |status: f64| match status {
                0.0 => "no fault".to_owned(),
                call if call < 0.0 => format!("a wrong call (status {call})"),
                _ => "a fault".to_owned(),
            };
            format!("recorded {}, computed here {}", told(recorded), told(replayed))
        }
        CoreOutput::Torque => format!("torque of A{}, {}", of.index + 1, pair("N·m")),
        CoreOutput::Correction if of.index < 3 => {
            format!("correction about {axis} of W, {}", pair("rad"))
        }
        CoreOutput::Correction => format!("correction along {axis} of W, {}", pair("m")),
    }
}

/// What differences as small as rounding mean; empty where they are larger, or there are none.
pub(crate) fn rounding(of: &CoreReplay) -> String {
    let [double, float] = ROUNDING_SHARES;
    let limit = if of.scalar == CoreScalar::Double { double } else { float };
    match &of.first {
        Some(first) if of.torque_share_max <= limit && first.output != CoreOutput::Fault => {
            "Rounding makes differences of this size: a core that takes its sine and cosine from another library differs so. A reading \
             or a gain that differs in its last bits does as well."
                .to_owned()
        }
        _ => String::new(),
    }
}

/// Force sensor and set-point of a period.
pub(crate) fn load(of: &CoreReadings) -> String {
    let [mx, my, mz, fx, fy, fz] = of.wrench.map(|value| fixed(value, 1));
    let push = match of.force_n {
        Some(force) => format!("{} N asked for", fixed(force, 1)),
        None => "force loop open".to_owned(),
    };
    format!(
        "Force sensor, in T: {fx}, {fy}, {fz} N and {mx}, {my}, {mz} N·m; {push}; {} from outside the robot.",
        counted(of.measurements, "measurement")
    )
}

/// How far a recorded weld that is made again can be trusted.
pub(crate) fn replayed(of: &FromLog) -> String {
    let check = &of.check;
    let scale = Scale::small("m");
    let part = check.apart.rms / check.recorded.bent.rms;
    let taught = of.taught_offset_m.abs() / check.recorded.bent.rms;
    let verdict = if taught > TAUGHT_SHARE {
        format!(
            "the encoders went {} beside the path of the replay, and other laws and gains say little of this cell: say with \
             --recorded-law and --recorded-control what was welded with",
            scale.quantity(of.taught_offset_m.abs())
        )
    } else if part <= REPLAYED_SHARE {
        "other laws and gains can be read to that".to_owned()
    } else {
        "the replay does not reproduce the record, and other laws and gains say little of this cell: `trueweld compare` shows where \
         the model is off"
            .to_owned()
    };
    format!(
        "The recorded weld left the seam by up to {} by its tracker, its replay {} by up to {}; along the seam they are {} RMS apart, {} \
         of what the load bent: {verdict}.",
        scale.quantity(check.recorded.lateral.max_abs),
        under(&check.compensator),
        scale.quantity(check.replayed.lateral.max_abs),
        scale.quantity(check.apart.rms),
        share(part)
    )
}

/// What is taken from the log.
pub(crate) fn taken(of: &FromLog) -> Vec<String> {
    let turns = of.spindle_rad_s.abs() * 60.0 / std::f64::consts::TAU;
    vec![
        format!("from {}: robot or model, seam, process", of.log),
        format!("spindle, {turns:.1} turns a minute"),
        feeds(of),
        format!(
            "path as the encoders went, {} across the seam from where the model teaches it",
            Scale::small("m").signed(of.taught_offset_m)
        ),
        format!("force that the model does not explain, {}", forces(of, true)),
    ]
}

/// `feed: that of the seam's file, from 92.1 mm on 7.00 mm/s`.
fn feeds(of: &FromLog) -> String {
    let scale = Scale::small("m");
    let change = |(from, speed): &(f64, f64)| {
        format!(", from {} on {}/s", scale.quantity(*from), scale.quantity(*speed))
    };
    let changes: String = of.feeds.iter().map(change).collect();
    format!("feed, that of the seam's file{changes}")
}

/// What is not.
pub(crate) fn not_taken(of: &FromLog) -> Vec<String> {
    let mut list = vec![
        format!(
            "law and gains of the record, taken to be {} under {}",
            under(&of.check.compensator),
            of.control
        ),
        "noise and delays of the instruments: those of the sensor file".to_owned(),
        "deviations that the tracker saw: they check the replay, and do not enter it".to_owned(),
        "forces above the band of the slow force: ripple and chatter are the model's".to_owned(),
    ];
    if of.disturbance.iter().any(|axis| !axis.taken) {
        let left = forces(of, false);
        list.push(format!(
            "force that the model does not explain, {left}: the force loop holds the push"
        ));
    }
    list
}

/// `RMS along x 120 N (noise 15 N)`.
fn forces(of: &FromLog, taken: bool) -> String {
    let force = |axis: &AxisDisturbance| {
        format!("along {} {:.0} N (noise {:.0} N)", axis.axis, axis.rms_n, axis.noise_n)
    };
    let axes = of.disturbance.iter().filter(|axis| axis.taken == taken);
    format!("RMS {}", listed(&axes.map(force).collect::<Vec<_>>(), "and"))
}
