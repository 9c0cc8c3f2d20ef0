//! What is said of gross mistakes in the files.

use super::{Scale, listed};
use trueweld_core::spatial::rotation_vector;
use trueweld_measure::data::channel::LogChannel;
use trueweld_measure::data::log::ColumnMapping;
use trueweld_measure::mistakes::{Change, ColumnLines, Found, Mistake, MistakeKind, Registered};

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
        LogChannel::Force | LogChannel::Moment => "wrench".to_owned(),
        LogChannel::Position | LogChannel::Rotation => "tracker".to_owned(),
        LogChannel::Time => "time".to_owned(),
        LogChannel::Spindle => "spindle".to_owned(),
        LogChannel::Payload => "payload".to_owned(),
    }
}

/// What is wrong, and the numbers that show it.
pub(crate) fn sentence(mistake: &Mistake, joints: &[String]) -> String {
    let at = place(mistake, joints);
    let of = match mistake.channel {
        LogChannel::Encoder => "angle",
        LogChannel::MotorTorque => "motor torque",
        LogChannel::Position => "tracker's position",
        _ => "reading",
    };
    let line = match &mistake.change {
        Change::Columns(lines) => lines.first(),
        _ => None,
    };
    let what = match (mistake.kind, &mistake.change) {
        (MistakeKind::Sign, _) => format!("the {of} of {at} counts the other way"),
        (MistakeKind::Zero, _) => {
            let offset = line.map_or(0.0, |line| line.offset);
            format!("the zero of {at} is off by {:.1}°", offset.to_degrees())
        }
        (MistakeKind::Exchanged, _) => {
            format!("the columns of {} stand in each other's place", at.replace(", ", " and "))
        }
        (MistakeKind::Unit, _) => {
            let unit = line.map_or("", |line| line.unit);
            format!("the {of} ({at}) is in {unit}")
        }
        (MistakeKind::GearSide, _) => {
            let factor = line.map_or(1.0, |line| line.factor.abs());
            format!(
                "the {of} of {at} is on the motor's side of the gear, off by a factor of {factor:.4}"
            )
        }
        (MistakeKind::TrackerFrame, _) => "the tracker's frame is left-handed".to_owned(),
        (MistakeKind::TimeUnit, _) => {
            format!("the times are in {}, not in s", line.map_or("", |line| line.unit))
        }
        (MistakeKind::WrenchSide, _) => {
            "the wrench is what the tool applies, not what is applied to the tool".to_owned()
        }
        (MistakeKind::Payload, Change::ToolMass(mass)) => {
            format!(
                "a mass hangs on the flange that is written nowhere; the tool weighs {mass:.0} kg"
            )
        }
        (MistakeKind::Payload, Change::PayloadColumns(mass)) => {
            format!("about {mass:.0} kg hung on the flange in some rows, and no column says so")
        }
        (MistakeKind::Payload, Change::Columns(_)) => "the payload is not written down".to_owned(),
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
            "undone, {} of {} remain",
            scale.quantity(evidence.after),
            scale.quantity(evidence.before)
        )
    };
    format!("{what} ({}): {compared}.", listed(&mistake.logs, "and"))
}

/// What to write, and where.
pub(crate) fn change(mistake: &Mistake) -> String {
    match &mistake.change {
        Change::Columns(_) => {
            let several = mistake.lines.len() > 1;
            mistake
                .lines
                .iter()
                .flat_map(|of| column_lines(of, several))
                .collect::<Vec<_>>()
                .join("\n")
        }
        Change::ToolMass(mass) => format!("mass_kg = {mass:.1}"),
        Change::PayloadColumns(mass) => format!("payload_kg,cx_m,cy_m,cz_m  # {mass:.0} kg"),
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
        Change::Columns(_) if mistake.lines.iter().any(|lines| lines.replace) => {
            "log.toml, under [columns], in place of the lines with the same headers"
        }
        Change::Columns(_) => "log.toml, under [columns]",
        Change::ToolMass(_) => "robot.toml, under [tool]",
        Change::PayloadColumns(_) => "samples.csv, columns",
    }
}

/// A mistake, and what to do about it, each in a sentence.
pub fn mistake(mistake: &Mistake, joints: &[String]) -> [String; 2] {
    let remedy = format!("In {}: {}", target(mistake), change(mistake));
    [sentence(mistake, joints), remedy]
}

/// A tracker that was registered, in a sentence without its full stop.
pub fn registered(registered: &Registered) -> String {
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
