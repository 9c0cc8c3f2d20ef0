//! An experiment to make next: what someone at the robot does, in order, and what it is expected to
//! tell.

use trueweld_core::JOINTS;
use trueweld_diagnose::experiment::{
    Changed, Excitation, PEAK, PROCEDURE_DWELL, Plan, PlanRow, Procedure, STOP_BRAKE_ONSET,
    STOP_RECORDING_TIME, TOLD_APART,
};
use trueweld_logs::log::LogKind;

const AXIS_LETTERS: [&str; 3] = ["x", "y", "z"];

/// Separation beyond which a number says no more: by then something else limits what can be told.
const MOST_SAID: f64 = 50.0;

/// Postures on whole steps of this are named in whole degrees.
const POSTURE_ROUNDING_DEGREES: f64 = 5.0;

/// One line that says what is done.
pub(crate) fn title(plan: &Plan) -> String {
    let rows = plan.rows.len();
    let name = |joint: usize| &plan.log.robot.joint_names[joint];
    match &plan.procedure {
        Procedure::Load { how: Excitation::Hung, .. } => {
            format!("Static loads, {rows} rows: up to {}, up and down", largest(plan))
        }
        Procedure::Load { .. } => {
            format!("Static loads, {rows} rows: {} to and fro", largest(plan))
        }
        Procedure::Scan { joint, mass, .. } => {
            let with =
                if *mass > 0.0 { format!(", {mass:.0} kg on the flange") } else { String::new() };
            format!("Static poses, {rows} rows: {} through its range{with}", name(*joint))
        }
        Procedure::Rest { .. } => {
            format!("The same pose at rest, {rows} rows in 30 min from cold")
        }
        Procedure::Stop { joint, .. } => {
            format!("Ring-down: {} stopped by its brake", name(*joint))
        }
        Procedure::Move { joint, takes, .. } if takes.len() > 1 => {
            format!("Free motion of {} there and back, slowly and fast", name(*joint))
        }
        Procedure::Move { joint, .. } => {
            format!("Free motion of {} over a long way and back", name(*joint))
        }
        Procedure::Seam { changed, .. } => format!("Weld {}", change(*changed)),
    }
}

/// The protocol that records an experiment: `model`, the path of the model file; `weld`, that of the
/// weld file, where it is a weld.
pub fn experiment_protocol(plan: &Plan, model: &str, weld: &str) -> String {
    let degrees = |angles: &[f64]| {
        let all: Vec<String> =
            angles.iter().map(|a| format!("{:?}", rounded(a.to_degrees()))).collect();
        format!("[{}]", all.join(", "))
    };
    let vector = |v: &[f64]| format!("{:?}", v.iter().map(|x| rounded(*x)).collect::<Vec<_>>());
    let kind = plan.procedure.kind();
    let mut text = format!(
        "# {}\n# {}\nschema = \"protocol/1\"\nmodel = {model:?}\n\n[[log]]\nname = \"next\"\nkind = \"{kind}\"\n",
        title(plan),
        reason(plan)
    );
    match &plan.procedure {
        Procedure::Load { .. } | Procedure::Scan { .. } | Procedure::Rest { .. } => {
            let hung = plan.log.samples.payload.iter().flatten().find(|p| p.mass > 0.0);
            for row in &plan.rows {
                text += &format!(
                    "\n[[log.load]]\ntime_s = {:?}\nposture_deg = {}\nshares = [1]\n",
                    rounded(row.time),
                    degrees(&row.encoder)
                );
                if row.force != [0.0; 3] {
                    text += &format!("force_n = {}\n", vector(&row.force));
                }
                if row.moment != [0.0; 3] {
                    text += &format!("moment_nm = {}\n", vector(&row.moment));
                }
                if let Some(hung) = hung.filter(|_| row.payload > 0.0) {
                    text += &format!(
                        "payload_kg = {:?}\ncentre_m = {}\n",
                        row.payload,
                        vector(hung.centre.as_slice())
                    );
                }
            }
        }
        Procedure::Stop { at, joint, rate } => {
            let mut rates = [0.0; JOINTS];
            rates[*joint] = *rate;
            text += &format!(
                "posture_deg = {}\nrate_deg_s = {}\nlength_s = {STOP_RECORDING_TIME:?}\n",
                degrees(at.as_slice()),
                degrees(&rates)
            );
        }
        Procedure::Move { at, .. } => {
            text += &format!("posture_deg = {}\n", degrees(at.as_slice()));
            for pair in plan.rows.windows(2).filter(|pair| pair[0].encoder != pair[1].encoder) {
                text += &format!(
                    "\n[[log.waypoint]]\nposture_deg = {}\ntakes_s = {:?}\ndwell_s = {PROCEDURE_DWELL:?}\n",
                    degrees(&pair[1].encoder),
                    rounded(pair[1].time - pair[0].time)
                );
            }
        }
        Procedure::Seam { .. } => {
            let spindle = plan.log.process.as_ref().map_or(0.0, |process| process.spindle);
            text += &format!("weld = {weld:?}\nspindle_rad_s = {spindle:?}\n");
        }
    }
    text
}

/// To a millionth: what a set-point is exact to.
fn rounded(value: f64) -> f64 {
    (value * 1e6).round() / 1e6 + 0.0
}

/// What to do, in order.
pub(crate) fn steps(plan: &Plan) -> Vec<String> {
    let name = |joint: usize| &plan.log.robot.joint_names[joint];
    let angles = |digits: usize, joint: usize| {
        let all = plan.rows.iter().map(|r| degrees(r.encoder[joint], digits));
        all.collect::<Vec<_>>().join(", ")
    };
    let (record, rate) = (recorded(plan), sampling(plan));
    let posture = posture(plan);
    let stand = format!("Move to {posture}. Check at low speed that the arm is clear of the cell.");
    match &plan.procedure {
        Procedure::Load { how, .. } => {
            let way = match how {
                Excitation::Hung => format!("Hang weights on the flange, {}", centre(plan)),
                Excitation::Pressed(axis) => {
                    format!("Press on the tool centre point along {} of T", AXIS_LETTERS[*axis])
                }
                Excitation::Turned(axis) => {
                    format!("Apply a moment to the tool about {} of T", AXIS_LETTERS[*axis])
                }
            };
            let (load, unit) = load(*how);
            let loads: Vec<String> = plan.rows.iter().map(|r| format!("{:.0}", load(r))).collect();
            vec![
                stand,
                "Keep the brakes open and the position controller on; do not move the arm in between."
                    .to_owned(),
                format!("{way}, in this order and without overshoot: {} {unit}.", loads.join(", ")),
                format!("Wait 2 s at each load, then record one row: {record}."),
            ]
        }
        Procedure::Scan { joint, mass, .. } => {
            let hang = format!("Hang {mass:.0} kg on the flange, {}.", centre(plan));
            let mut steps = vec![stand];
            steps.extend((*mass > 0.0).then_some(hang));
            steps.push(format!(
                "Move {} alone, always from the same side, to {}.",
                name(*joint),
                angles(1, *joint)
            ));
            steps.push(format!("Wait 2 s in each pose, then record one row: {record}."));
            steps
        }
        Procedure::Rest { .. } => {
            let times: Vec<String> =
                plan.rows.iter().map(|r| (r.time / 60.0).to_string()).collect();
            vec![
                "Leave the robot switched off until it is cold, two hours at least.".to_owned(),
                stand,
                format!(
                    "Stay there, brakes open, and record one row after {} min: {record}.",
                    times.join(", ")
                ),
            ]
        }
        Procedure::Stop { joint, rate: speed, .. } => {
            let (name, speed) = (name(*joint), degrees(*speed, 1));
            vec![
                format!(
                    "Start a few degrees before this posture, so that {name} runs evenly for 1 s when it gets there: {posture}."
                ),
                format!("Run {name} alone at {speed} a second and let its brake fall there."),
                format!(
                    "Record from {STOP_BRAKE_ONSET} s before the brake falls, for {STOP_RECORDING_TIME} s, at {rate}: {record}."
                ),
                "Repeat once; keep both logs.".to_owned(),
            ]
        }
        Procedure::Move { joint, takes, .. } => {
            let at = |row: usize| plan.rows.get(row).map_or(0.0, |r| r.encoder[*joint]);
            let (from, to) = (at(0), at(2));
            let mut steps = vec![stand];
            steps.extend(takes.iter().map(|takes| {
                let peak = degrees((to - from).abs() / takes * PEAK, 1);
                format!(
                    "Move {} alone from {} to {} in {takes:.1} s (smoothly, peak {} a second), rest {PROCEDURE_DWELL} s, and back in the same time, rest {PROCEDURE_DWELL} s.",
                    name(*joint),
                    degrees(from, 0),
                    degrees(to, 0),
                    peak.trim_start_matches('+')
                )
            }));
            steps.push(format!(
                "Record all of it, with {PROCEDURE_DWELL} s of rest before, at {rate}: {record}."
            ));
            steps
        }
        Procedure::Seam { .. } => {
            let mut steps = Vec::new();
            if let Some(weld) = &plan.log.weld {
                let spindle = plan.log.samples.spindle.as_ref().and_then(|s| s.first());
                let spindle = spindle.copied().unwrap_or(0.0);
                let [start, end, axis] = [weld.start, weld.end, weld.tool_axis]
                    .map(|p| format!("({:.3}, {:.3}, {:.3})", p.x, p.y, p.z));
                steps.push(format!(
                    "Clamp a fresh plate; weld from {start} m to {end} m in B, tool axis {axis}."
                ));
                steps.push(format!(
                    "Feed {:.1} mm/s, depth force {:.1} kN, spindle {:.0} turns a minute ({} about the tool's z axis); everything else as before.",
                    weld.feed * 1e3,
                    weld.force * 1e-3,
                    spindle.abs() * 60.0 / std::f64::consts::TAU,
                    if spindle < 0.0 { "negative" } else { "positive" },
                ));
            }
            let lasts = plan.log.samples.time.last().copied().unwrap_or(0.0);
            steps.push(format!("Record at {rate}, the first {lasts:.0} s at least: {record}."));
            steps
        }
    }
}

/// True where an experiment promises to tell some of the explanations apart at least a little.
pub(crate) fn is_worth_recording(plan: &Plan) -> bool {
    let others = plan.others.iter().map(|(_, separation)| *separation);
    others.fold(plan.separation, f64::max) >= WORTH_RECORDING
}

/// Which explanations it separates and by how much, and what the logs so far gave.
pub(crate) fn reason(plan: &Plan) -> String {
    let [a, b] = plan.rivals.each_ref().map(|name| match name.as_str() {
        "" => "nothing beyond calibrations",
        name => name,
    });
    if plan.rivals[1].is_empty() && plan.so_far.max(0.0).sqrt() > MOST_SAID {
        return format!(
            "It only narrows the values of {a}: the logs so far tell it from {b} already."
        );
    }
    let deviations = |s: f64| {
        if s > MOST_SAID { format!("more than {MOST_SAID:.0}") } else { format!("{s:.1}") }
    };
    let expected = format!(
        "expected to set {a} and {b} {} standard deviations apart after refitting the calibrations and the values of either",
        deviations(plan.separation)
    );
    let better = if plan.so_far > 0.0 { a } else { b };
    let before = match deviations(plan.so_far.abs().sqrt()) {
        s if plan.so_far.abs() < 1.0 => format!("the logs so far leave them {s} apart"),
        s => format!("the logs so far set them {s} apart, in favour of {better}"),
    };
    let mut reason = if plan.separation < TOLD_APART {
        format!(
            "No feasible experiment tells {a} from {b}: the best found is {expected}, less than {TOLD_APART:.0}; {before}."
        )
    } else {
        format!("It is {expected}; {before}.")
    };
    if plan.separation < WORTH_RECORDING {
        reason += " Either serves as the model: they predict the same in all that was tried.";
    }
    for (name, separation) in &plan.others {
        reason += &format!(" From {a} to {name} it is {}.", deviations(*separation));
    }
    reason
}

/// Expected separation below which nobody is sent to record an experiment, standard deviations.
const WORTH_RECORDING: f64 = 1.0;

/// What to record next, in a paragraph.
pub(crate) fn lead(plan: &Plan) -> String {
    if !is_worth_recording(plan) {
        let reason = reason(plan);
        return format!("Nothing: {}{}", reason[..1].to_lowercase(), &reason[1..]);
    }
    format!("{}, about {:.0} minutes. {}", title(plan), plan.minutes.ceil(), reason(plan))
}

fn change(changed: Changed) -> String {
    match changed {
        Changed::Feed(f) if f < 1.0 => "at half the feed".to_owned(),
        Changed::Feed(_) => "at twice the feed".to_owned(),
        Changed::Force(f) => format!("with {:.0} % of the depth force", f * 100.0),
        Changed::Spindle(f) if f < 0.0 => "with the spindle turning the other way".to_owned(),
        Changed::Spindle(f) => format!("at {:.0} % of the spindle speed", f * 100.0),
        Changed::Backwards => "from the end of an earlier seam to its start".to_owned(),
        Changed::Shifted(s) => {
            format!("along an earlier seam, moved on by {:.0} % of its length", s * 100.0)
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

/// The first posture.
fn posture(plan: &Plan) -> String {
    let q = plan.rows.first().map_or([0.0; JOINTS], |r| r.encoder);
    let one = |(name, q): (&String, f64)| {
        let off = (q.to_degrees() / POSTURE_ROUNDING_DEGREES).round() * POSTURE_ROUNDING_DEGREES
            - q.to_degrees();
        format!("{name} {}", degrees(q, usize::from(off.to_radians().abs() > 1e-3)))
    };
    plan.log.robot.joint_names.iter().zip(q).map(one).collect::<Vec<_>>().join(", ")
}

/// Where the weights' centre is.
fn centre(plan: &Plan) -> String {
    let hung = plan.log.samples.payload.iter().flatten().find(|p| p.mass > 0.0);
    let c = hung.map(|p| p.centre * 1e3).unwrap_or_default();
    format!("centre at ({:.0}, {:.0}, {:.0}) mm from it in axes of the last link", c.x, c.y, c.z)
}

/// The load of a row that a procedure varies, and its unit.
fn load(how: Excitation) -> (impl Fn(&PlanRow) -> f64, &'static str) {
    let unit = match how {
        Excitation::Hung => "kg",
        Excitation::Pressed(_) => "N",
        Excitation::Turned(_) => "N·m",
    };
    let of = move |row: &PlanRow| match how {
        Excitation::Hung => row.payload,
        Excitation::Pressed(axis) => row.force[axis],
        Excitation::Turned(axis) => row.moment[axis],
    };
    (of, unit)
}

/// The largest load of the rows.
fn largest(plan: &Plan) -> String {
    let Procedure::Load { how, .. } = plan.procedure else { return String::new() };
    let (load, _) = load(how);
    let most = plan.rows.iter().map(|r| load(r).abs()).fold(0.0, f64::max);
    match how {
        Excitation::Hung => format!("{most:.0} kg on the flange"),
        Excitation::Pressed(axis) => {
            format!("{:.1} kN along {} of T", most * 1e-3, AXIS_LETTERS[axis])
        }
        Excitation::Turned(axis) => format!("{most:.0} N·m about {} of T", AXIS_LETTERS[axis]),
    }
}

fn sampling(plan: &Plan) -> String {
    let rate = 1.0 / plan.log.period.unwrap_or(1.0);
    if rate > 400.0 { format!("{:.0} kHz", rate * 1e-3) } else { format!("{rate:.0} Hz") }
}

/// Channels to record.
fn recorded(plan: &Plan) -> String {
    let (kind, channels) = (plan.log.kind, &plan.channels);
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
