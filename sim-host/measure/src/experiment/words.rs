//! Procedures in words: what someone at the robot does, in order.

use super::PlanRow;
use super::cell::{ExperimentCell, whole_steps};
use super::procedure::{
    Changed, DWELL, Excitation, FALLS, PEAK, Procedure, RESTED, RINGS, STOP_SHARE, WELD_LASTS,
};
use crate::data::log::{Log, LogKind};
use nalgebra::Vector3;
use trueweld_core::JOINTS;

const AXES: [&str; 3] = ["x", "y", "z"];

impl Procedure {
    /// One line that says what is done.
    pub fn title(&self, cell: &ExperimentCell<'_>, rows: &[PlanRow]) -> String {
        let name = |joint: &usize| &cell.names[*joint];
        match self {
            Self::Load { how: Excitation::Hung, .. } => {
                format!(
                    "Static loads, {} rows: up to {:.0} kg on the flange, up and down",
                    rows.len(),
                    cell.mass
                )
            }
            Self::Load { how, .. } => {
                format!("Static loads, {} rows: {} to and fro", rows.len(), largest(rows, *how))
            }
            Self::Scan { joint, mass, .. } => {
                let with = if *mass > 0.0 {
                    format!(", {mass:.0} kg on the flange")
                } else {
                    String::new()
                };
                format!(
                    "Static poses, {} rows: {} through its range{with}",
                    rows.len(),
                    name(joint)
                )
            }
            Self::Rest { .. } => {
                format!("The same pose at rest, {} rows in 30 min from cold", rows.len())
            }
            Self::Stop { joint, .. } => format!("Ring-down: {} stopped by its brake", name(joint)),
            Self::Move { joint, takes, .. } if takes.len() > 1 => {
                format!("Free motion of {} there and back, slowly and fast", name(joint))
            }
            Self::Move { joint, .. } => {
                format!("Free motion of {} over a long way and back", name(joint))
            }
            Self::Seam { changed, .. } => format!("Weld {}", changed.words()),
        }
    }

    /// What to do, in order.
    pub fn steps(&self, cell: &ExperimentCell<'_>, log: &Log, rows: &[PlanRow]) -> Vec<String> {
        let record = recorded(cell, self.kind());
        let first = rows.first().map_or([0.0; JOINTS], |r| r.encoder);
        let stand = format!(
            "Move to {}. Check at low speed that the arm is clear of the cell.",
            posture(cell, &first)
        );
        let mut steps = Vec::new();
        match self {
            Self::Load { how, .. } => {
                let list = |value: &dyn Fn(&PlanRow) -> f64| {
                    rows.iter().map(|r| format!("{:.0}", value(r))).collect::<Vec<_>>().join(", ")
                };
                let (what, unit) = match how {
                    Excitation::Hung => (list(&|r| r.payload), "kg"),
                    Excitation::Pressed(axis) => (list(&|r| r.force[*axis]), "N"),
                    Excitation::Turned(axis) => (list(&|r| r.moment[*axis]), "N·m"),
                };
                let way = match how {
                    Excitation::Hung => {
                        let c = cell.centre * 1e3;
                        format!(
                            "Hang weights on the flange, centre at ({:.0}, {:.0}, {:.0}) mm from it in axes of the last link",
                            c.x, c.y, c.z
                        )
                    }
                    Excitation::Pressed(axis) => {
                        format!("Press on the tool centre point along {} of T", AXES[*axis])
                    }
                    Excitation::Turned(axis) => {
                        format!("Apply a moment to the tool about {} of T", AXES[*axis])
                    }
                };
                steps.push(stand);
                steps.push(
                    "Keep the brakes open and the position controller on; do not move the arm in between.".into(),
                );
                steps.push(format!("{way}, in this order and without overshoot: {what} {unit}."));
                steps.push(format!("Wait 2 s at each load, then record one row: {record}."));
            }
            Self::Scan { joint, mass, .. } => {
                let angles: Vec<String> =
                    rows.iter().map(|r| degrees(r.encoder[*joint], 1)).collect();
                steps.push(stand);
                if *mass > 0.0 {
                    let c = cell.centre * 1e3;
                    steps.push(format!(
                        "Hang {mass:.0} kg on the flange, centre at ({:.0}, {:.0}, {:.0}) mm from it in axes of the last link.",
                        c.x, c.y, c.z
                    ));
                }
                steps.push(format!(
                    "Move {} alone, always from the same side, to {}.",
                    cell.names[*joint],
                    angles.join(", ")
                ));
                steps.push(format!("Wait 2 s in each pose, then record one row: {record}."));
            }
            Self::Rest { .. } => {
                let times: Vec<String> = RESTED.iter().map(|m| format!("{m}")).collect();
                steps.push(
                    "Leave the robot switched off until it is cold, two hours at least.".into(),
                );
                steps.push(stand);
                steps.push(format!(
                    "Stay there, brakes open, and record one row after {} min: {record}.",
                    times.join(", ")
                ));
            }
            Self::Stop { joint, sense, .. } => {
                let rate = sense * STOP_SHARE * cell.robot.parameters().joints[*joint].max_rate;
                let name = &cell.names[*joint];
                steps.push(format!("Start a few degrees before this posture, so that {name} runs evenly for 1 s when it gets there: {}.", posture(cell, &first)));
                steps.push(format!(
                    "Run {name} alone at {} a second and let its brake fall there.",
                    degrees(rate, 1)
                ));
                steps.push(format!(
                    "Record from {FALLS} s before the brake falls, for {RINGS} s, at {}: {record}.",
                    rate_of(log)
                ));
                steps.push("Repeat once; keep both logs.".into());
            }
            Self::Move { joint, takes, .. } => {
                let name = &cell.names[*joint];
                let to = rows.get(2).map_or(0.0, |r| r.encoder[*joint]);
                let from = first[*joint];
                steps.push(stand);
                for takes in takes {
                    let peak = (to - from).abs() / takes * PEAK;
                    steps.push(format!(
                        "Move {name} alone from {} to {} in {takes:.1} s (smoothly, peak {} a second), rest {DWELL} s, and back in the same time, rest {DWELL} s.",
                        degrees(from, 0), degrees(to, 0), degrees(peak, 1).trim_start_matches('+')
                    ));
                }
                steps.push(format!(
                    "Record all of it, with {DWELL} s of rest before, at {}: {record}.",
                    rate_of(log)
                ));
            }
            Self::Seam { .. } => {
                let lasts = log.samples.time.last().copied().unwrap_or(WELD_LASTS);
                if let Some(weld) = &log.weld {
                    let turning = log
                        .samples
                        .spindle
                        .as_ref()
                        .and_then(|s| s.first())
                        .copied()
                        .unwrap_or(0.0);
                    let point =
                        |p: &Vector3<f64>| format!("({:.3}, {:.3}, {:.3}) m", p.x, p.y, p.z);
                    steps.push(format!(
                        "Clamp a fresh plate; weld from {} to {} in B, tool axis ({:.3}, {:.3}, {:.3}).",
                        point(&weld.start),
                        point(&weld.end),
                        weld.tool_axis.x,
                        weld.tool_axis.y,
                        weld.tool_axis.z
                    ));
                    steps.push(format!(
                        "Feed {:.1} mm/s, depth force {:.1} kN, spindle {:.0} turns a minute ({}); everything else as before.",
                        weld.feed * 1e3,
                        weld.force * 1e-3,
                        turning.abs() * 60.0 / std::f64::consts::TAU,
                        if turning < 0.0 { "negative about the tool's z axis" } else { "positive about the tool's z axis" },
                    ));
                }
                steps.push(format!(
                    "Record at {}, the first {lasts:.0} s at least: {record}.",
                    rate_of(log)
                ));
            }
        }
        steps
    }
}

impl Changed {
    fn words(self) -> String {
        match self {
            Self::Feed(f) if f < 1.0 => "at half the feed".to_owned(),
            Self::Feed(_) => "at twice the feed".to_owned(),
            Self::Force(f) => format!("with {:.0} % of the depth force", f * 100.0),
            Self::Spindle(f) if f < 0.0 => "with the spindle turning the other way".to_owned(),
            Self::Spindle(f) => format!("at {:.0} % of the spindle speed", f * 100.0),
            Self::Backwards => "from the end of an earlier seam to its start".to_owned(),
            Self::Shifted(s) => {
                format!("along an earlier seam, moved on by {:.0} % of its length", s * 100.0)
            }
        }
    }
}

/// An angle in degrees, with its sign.
fn degrees(angle: f64, digits: usize) -> String {
    let value = angle.to_degrees();
    let value = if value.abs() < 0.5 * 10f64.powi(-(digits as i32)) { 0.0 } else { value };
    let text = format!("{value:+.digits$}°");
    if value == 0.0 { text.replace('+', "") } else { text.replace('-', "−") }
}

fn posture(cell: &ExperimentCell<'_>, q: &[f64; JOINTS]) -> String {
    let one = |i: usize| {
        let digits = usize::from((q[i] - whole_steps(q[i])).abs() > 1e-3);
        format!("{} {}", cell.names[i], degrees(q[i], digits))
    };
    (0..JOINTS).map(one).collect::<Vec<_>>().join(", ")
}

/// The largest load of some rows, in words.
fn largest(rows: &[PlanRow], how: Excitation) -> String {
    let most =
        |value: &dyn Fn(&PlanRow) -> f64| rows.iter().map(|r| value(r).abs()).fold(0.0, f64::max);
    match how {
        Excitation::Hung => format!("{:.0} kg on the flange", most(&|r| r.payload)),
        Excitation::Pressed(axis) => {
            format!("{:.1} kN along {} of T", most(&|r| r.force[axis]) * 1e-3, AXES[axis])
        }
        Excitation::Turned(axis) => {
            format!("{:.0} N·m about {} of T", most(&|r| r.moment[axis]), AXES[axis])
        }
    }
}

fn rate_of(log: &Log) -> String {
    let rate = 1.0 / log.period.unwrap_or(1.0);
    if rate > 400.0 { format!("{:.0} kHz", rate * 1e-3) } else { format!("{rate:.0} Hz") }
}

/// Channels to record in a log of this kind, in words.
fn recorded(cell: &ExperimentCell<'_>, kind: LogKind) -> String {
    let channels = cell.channels(kind);
    let mut parts = vec!["encoders"];
    if channels.link_encoder.contains(&true) {
        parts.push("link-side encoders");
    }
    if channels.motor_torque.contains(&true) && kind == LogKind::FreeMotion {
        parts.push("motor torques");
    }
    match (channels.position, channels.rotation) {
        (true, true) => parts.push("tracker position and rotation"),
        (true, false) => parts.push("tracker position"),
        _ => {}
    }
    if channels.force && matches!(kind, LogKind::StaticLoad | LogKind::Weld) {
        parts.push("measured wrench");
    }
    if kind == LogKind::Weld {
        parts.push("spindle speed");
    }
    if kind == LogKind::StaticLoad {
        parts.push("payload");
    }
    parts.join(", ")
}
