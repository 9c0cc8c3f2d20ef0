//! A control file with the gains that were found, and where they come from in its comments.

use super::lines_of;
use super::tune::{confirmation, origin};
use crate::TuneReport;
use std::f64::consts::TAU;
use std::fmt::Write;
use trueweld_core::JointVector;
use trueweld_core::control::JointGains;
use trueweld_plant::controllers::{DEPTH_KEYS, FORCE_KEYS, GainKey, JOINT_KEYS};
use trueweld_plant::input::{CascadeGains, Control, ParallelGains};

/// Longest line of a comment, but for the sign before it.
const COMMENT_WIDTH: usize = 130;

/// The text of the file.
pub fn control_toml(report: &TuneReport<'_>) -> String {
    let mut lines = origin(report);
    lines.push(String::new());
    lines.extend(confirmation(report));
    let comments = lines.iter().flat_map(|line| lines_of(line, COMMENT_WIDTH));
    let mut text: String =
        comments.map(|line| format!("# {line}").trim_end().to_owned() + "\n").collect();
    gains(&mut text, &report.tuning.control);
    text
}

/// A number as TOML has it.
fn number(value: f64) -> String {
    format!("{value:?}")
}

fn six(values: &JointVector<f64>) -> String {
    format!("[{}]", values.iter().map(|v| number(*v)).collect::<Vec<_>>().join(", "))
}

fn gains(out: &mut String, control: &Control) {
    let mut put = |text: String| out.push_str(&text);
    put(format!("schema = \"control/1\"\nperiod_s = {}\n", number(control.period)));
    for (name, ParallelGains { joint, force }) in
        [("parallel", &control.parallel), ("superposed", &control.superposed)]
    {
        put(format!("\n[{name}]\n{}", scheme(joint, &FORCE_KEYS, *force)));
    }
    let CascadeGains { joint, force } = &control.external;
    put(format!("\n[external]\n{}", scheme(joint, &DEPTH_KEYS, *force)));
    let limits = &control.compensation;
    put("\n[compensation]\n".to_owned());
    put(keys(&[
        ("bandwidth_hz", digits(limits.lateral.bandwidth / TAU)),
        ("max_translation_m", limits.lateral.size),
        ("max_rotation_rad", limits.orientation.size),
        ("max_translation_rate_m_s", limits.lateral.rate),
        ("max_rotation_rate_rad_s", limits.orientation.rate),
        ("following_rad_s", limits.following.rate),
        ("following_along_rad_s", limits.following.along),
        ("following_max_m", limits.following.size),
    ]));
    for (law, table) in control.laws.iter().filter(|(_, table)| !table.is_empty()) {
        put(format!("\n[law.{}]\n{table}", toml_key(law)));
    }
}

/// Hz to three digits: what turning rad/s into Hz leaves in the last digits is no gain.
fn digits(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

fn toml_key(name: &str) -> String {
    if name.contains('+') { format!("{name:?}") } else { name.to_owned() }
}

/// Gains of a position loop, and of a force branch with these keys.
fn scheme<G>(joint: &JointGains<f64>, own: &[GainKey<G>], mut force: G) -> String {
    let JointGains { kp, ki, kd } = joint;
    let joint = JOINT_KEYS.into_iter().zip([kp, ki, kd].map(six));
    let force = own.iter().map(|(key, gain)| (*key, number(*gain(&mut force))));
    joint.chain(force).map(|(key, value)| format!("{key} = {value}\n")).collect()
}

fn keys(all: &[(&str, f64)]) -> String {
    all.iter().fold(String::new(), |mut text, (key, value)| {
        // Writing to a String cannot fail.
        let _ = writeln!(text, "{key} = {}", number(*value));
        text
    })
}
