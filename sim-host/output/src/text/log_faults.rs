//! What is said of gross mistakes in the files.

use super::{Scale, listed};
use crate::text::register::half;
use nalgebra::{Matrix3, Vector3};
use trueweld_core::spatial::rotation_vector;
use trueweld_estimate::log_faults::{
    ColumnLines, Found, Mistake, MistakeKind, Registered, Remedy, WrenchFrame,
};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::ColumnMapping;

/// The finding, first of all that is said.
pub(crate) fn headline(found: &Found, joints: &[String]) -> String {
    let first = found.mistakes.first().map_or(String::new(), |first| sentence(first, joints));
    match found.mistakes.len() {
        0 | 1 => format!("A mistake in the files: {first}"),
        n => format!("{n} mistakes in the files. First: {first}"),
    }
}

/// What a mistake is in: joints by their names, or an instrument.
pub(crate) fn place(mistake: &Mistake, joints: &[String]) -> String {
    let joint = |i: &usize| joints.get(*i).map_or("", String::as_str);
    match mistake.channel {
        LogChannel::Encoder | LogChannel::MotorTorque | LogChannel::LinkEncoder
            if !mistake.columns.is_empty() =>
        {
            mistake.columns.iter().map(joint).collect::<Vec<_>>().join(", ")
        }
        LogChannel::Encoder => "encoders".to_owned(),
        LogChannel::LinkEncoder => "link-encoder".to_owned(),
        LogChannel::MotorTorque => "torque".to_owned(),
        LogChannel::Force | LogChannel::Moment if !mistake.columns.is_empty() => {
            let letter = if mistake.channel == LogChannel::Force { 'F' } else { 'M' };
            let column = |c: &usize| format!("{letter}{}", ["x", "y", "z"][*c]);
            mistake.columns.iter().map(column).collect::<Vec<_>>().join(", ")
        }
        LogChannel::Force | LogChannel::Moment => "wrench".to_owned(),
        LogChannel::Position | LogChannel::Rotation => "tracker".to_owned(),
        LogChannel::Time => "time".to_owned(),
        LogChannel::Spindle => "spindle".to_owned(),
        LogChannel::Payload => "payload".to_owned(),
    }
}

/// The reading that a mistake is in.
fn reading(mistake: &Mistake, at: &str) -> String {
    let joints = mistake.columns.len();
    match mistake.channel {
        LogChannel::Encoder if joints == 0 => "the encoders' angle".to_owned(),
        LogChannel::Encoder => format!("the angle of {at}"),
        LogChannel::MotorTorque if joints == 0 => "the motor torque".to_owned(),
        LogChannel::MotorTorque => format!("the motor torque of {at}"),
        LogChannel::LinkEncoder => format!("the second encoder of {at}"),
        LogChannel::Position => "the tracker's position".to_owned(),
        LogChannel::Force | LogChannel::Moment if joints > 0 => at.to_owned(),
        LogChannel::Force => "the force".to_owned(),
        LogChannel::Moment => "the moment".to_owned(),
        LogChannel::Spindle => "the spindle's speed".to_owned(),
        LogChannel::Time | LogChannel::Rotation | LogChannel::Payload => "the reading".to_owned(),
    }
}

/// What is wrong, and the numbers that show it.
pub(crate) fn sentence(mistake: &Mistake, joints: &[String]) -> String {
    let at = place(mistake, joints);
    let of = reading(mistake, &at);
    let lines = match &mistake.change {
        Remedy::Columns(lines) => lines.as_slice(),
        _ => &[],
    };
    let line = lines.first();
    let what = match (mistake.kind, &mistake.change) {
        (MistakeKind::Sign, _) => format!("{of} counts the other way"),
        (MistakeKind::Zero, _) => {
            let offset = line.map_or(0.0, |line| line.offset);
            let whose = if mistake.channel == LogChannel::Encoder { &at } else { &of };
            format!("the zero of {whose} is off by {:.1}°", offset.to_degrees())
        }
        (MistakeKind::Exchanged, _) => {
            let second = match mistake.channel {
                LogChannel::LinkEncoder => "second encoders",
                _ => "columns",
            };
            format!("the {second} of {} stand in each other's place", at.replace(", ", " and "))
        }
        (MistakeKind::Coupling, _) => {
            let times = line.and_then(|line| line.plus).map_or(1.0, |(_, times)| times);
            let (own, other) = at.split_once(", ").unwrap_or((&at, ""));
            let sum = if times > 0.0 { "sum" } else { "difference" };
            format!(
                "the angle of {own} is counted from the horizontal, not from {other}: its {sum} with the angle of {other} is \
                 the joint's"
            )
        }
        (MistakeKind::Unit, _) => {
            let (unit, factor) = line.map_or(("", 1.0), |line| (line.unit, line.factor.abs()));
            if factor == 1.0 {
                format!("{of} is in {unit}")
            } else {
                format!("{of} is in another unit, {factor:.4} of {unit}")
            }
        }
        (MistakeKind::GearSide, _) => {
            let (factor, fitted) = line.map_or((1.0, 0.0), |line| (line.factor.abs(), line.fitted));
            format!(
                "{of} is on the motor's side of the gear or in a unit of the drive, off by a factor of {factor:.4}, which is \
                 fitted to ±{:.2} %: write the data sheet's in its place",
                1e2 * fitted
            )
        }
        (MistakeKind::TrackerFrame, _) => "the tracker's frame is left-handed".to_owned(),
        (MistakeKind::TimeUnit, _) => {
            format!("the times are in {}, not in s", line.map_or("", |line| line.unit))
        }
        (MistakeKind::WrenchSide, _) if lines.len() == 3 => {
            "the force is what the tool applies, not what is applied to the tool".to_owned()
        }
        (MistakeKind::WrenchSide, _) => {
            "the wrench is what the tool applies, not what is applied to the tool".to_owned()
        }
        (_, Remedy::WrenchFrame(frame)) => mounted(frame),
        (MistakeKind::WrenchAxes, _) => "the wrench is in other axes than the tool's".to_owned(),
        (MistakeKind::WrenchPoint, _) => {
            "the moment is about another point than the tool centre point".to_owned()
        }
        (MistakeKind::Payload, Remedy::ToolMass(mass)) => {
            format!(
                "a mass hangs on the flange that neither log nor robot states; the tool weighs {mass:.0} kg"
            )
        }
        (MistakeKind::Payload, Remedy::PayloadColumns(mass)) => {
            format!("about {mass:.0} kg hung on the flange in some rows, and no column says so")
        }
        (MistakeKind::Payload, Remedy::Columns(_)) => "the payload is not written down".to_owned(),
    };
    let evidence = mistake.evidence;
    let scale = Scale::small(evidence.unit);
    let compared = if mistake.kind == MistakeKind::TimeUnit {
        format!(
            "a step of {} would be one of {}",
            scale.quantity(evidence.before),
            scale.quantity(evidence.after)
        )
    } else {
        format!(
            "with the correction {} of {} remain",
            scale.quantity(evidence.after),
            scale.quantity(evidence.before)
        )
    };
    format!("{what} ({}): {compared}.", listed(&mistake.logs, "and"))
}

/// How a force sensor sits, with what its numbers are known to.
fn mounted(frame: &WrenchFrame) -> String {
    let WrenchFrame { pose, point_interval, axes_interval, .. } = frame;
    let widest = |unit: &'static str, widths: &[f64; 3]| {
        half(&Scale::small(unit), widths.iter().copied().fold(0.0, f64::max))
    };
    let mut parts = Vec::new();
    if pose.rotation != Matrix3::identity() {
        let turn = rotation_vector(&pose.rotation);
        let [x, y, z] = rounded(turn / turn.norm(), 3).into();
        parts.push(format!(
            "the wrench is in axes that are turned by {:.2}° about {x:.3}, {y:.3}, {z:.3} of T {}",
            turn.norm().to_degrees(),
            widest("rad", axes_interval)
        ));
    }
    if pose.position != Vector3::zeros() {
        let [x, y, z] = rounded(pose.position, 4).into();
        parts.push(format!(
            "the moment is about a point {:.4} m from the tool centre point, at {x:.4}, {y:.4}, {z:.4} m in T {}",
            pose.position.norm(),
            widest("m", point_interval)
        ));
    }
    let parts: Vec<&str> = parts.iter().map(|part| part.trim_end()).collect();
    parts.join(", and ")
}

/// A vector to so many decimals, without a sign on its zeros.
fn rounded(v: Vector3<f64>, decimals: i32) -> Vector3<f64> {
    let unit = 10f64.powi(decimals);
    v.map(|v| (v * unit).round() / unit + 0.0)
}

/// The entries of `[wrench]`.
fn wrench_lines(frame: &WrenchFrame) -> String {
    // Tenths of a millimetre, and what a plain angle needs.
    let list = |v: Vector3<f64>, decimals: i32| {
        let [x, y, z] = rounded(v, decimals).into();
        format!("[{x:?}, {y:?}, {z:?}]")
    };
    let pose = &frame.pose;
    let lines = [
        (pose.position != Vector3::zeros())
            .then(|| format!("point_m = {}", list(pose.position, 4))),
        (pose.rotation != Matrix3::identity())
            .then(|| format!("axes_rad = {}", list(rotation_vector(&pose.rotation), 9))),
    ];
    lines.into_iter().flatten().collect::<Vec<_>>().join("\n")
}

/// What to write, and where.
pub(crate) fn change(mistake: &Mistake) -> String {
    match &mistake.change {
        Remedy::Columns(_) => {
            let several = mistake.lines.len() > 1;
            mistake
                .lines
                .iter()
                .flat_map(|of| column_lines(of, several))
                .collect::<Vec<_>>()
                .join("\n")
        }
        Remedy::WrenchFrame(frame) => wrench_lines(frame),
        Remedy::ToolMass(mass) => format!("mass_kg = {mass:.1}"),
        Remedy::PayloadColumns(mass) => format!("payload_kg,cx_m,cy_m,cz_m  # {mass:.0} kg"),
    }
}

/// The lines for some logs; their names above, where others take other lines.
fn column_lines(of: &ColumnLines, named: bool) -> Vec<String> {
    let logs = named.then(|| format!("# {}", of.logs.join(", ")));
    logs.into_iter().chain(of.lines.iter().map(ColumnMapping::line)).collect()
}

/// Where the change belongs.
pub(crate) fn target(mistake: &Mistake) -> &'static str {
    match mistake.change {
        Remedy::Columns(_) if mistake.lines.iter().any(|lines| lines.replace) => {
            "log.toml, under [columns], in place of the lines with the same headers"
        }
        Remedy::Columns(_) => "log.toml, under [columns]",
        Remedy::WrenchFrame(WrenchFrame { replace: true, .. }) => {
            "log.toml, in place of the table [wrench]"
        }
        Remedy::WrenchFrame(_) => "log.toml, under [wrench]",
        Remedy::ToolMass(_) => "robot.toml, under [tool]",
        Remedy::PayloadColumns(_) => "samples.csv, columns",
    }
}

/// A mistake, and what to do about it, each in a sentence.
pub fn mistake(mistake: &Mistake, joints: &[String]) -> [String; 2] {
    let remedy = format!("In {}: {}", target(mistake), change(mistake));
    [sentence(mistake, joints), remedy]
}

/// A tracker that was registered, in a sentence without its full stop.
pub(crate) fn registered(registered: &Registered) -> String {
    let registration = &registered.registration;
    let frame = &registration.mounting.frame;
    let angle = rotation_vector(&frame.rotation).norm();
    format!(
        "{}: the tracker stands elsewhere ({:.4} m away, turned by {:.3}°); its frame was found from {} poses and taken out, \
         which leaves {}",
        listed(&registered.logs, "and"),
        frame.position.norm(),
        angle.to_degrees(),
        registration.poses,
        Scale::small("m").quantity(registration.left[0])
    )
}
