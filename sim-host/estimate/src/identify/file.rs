//! Robot and process files with the numbers found: the file that was given, every other line as it
//! was, and behind each number its interval and where it comes from.

use crate::identify::identification::Identification;
use crate::identify::number::Number;
use std::path::Path;
use trueweld_plant::input::{InputError, InputFile, Process, RobotFile, Source, read_text};

/// Text of the process file of the model with the numbers found, for a file at `to`; its ripple stands
/// at the end. `said` and `head` as of [`robot_text`].
///
/// # Errors
/// As [`robot_text`]; a model without a process.
pub fn process_text(
    found: &Identification,
    to: &Path,
    said: &dyn Fn(&Number) -> String,
    head: &str,
) -> Result<String, InputError> {
    let path = found.model.process_path.as_deref().unwrap_or(Path::new(""));
    let (name, text) = read_text(path)?;
    let mut out = head.lines().map(|line| format!("# {line}\n")).collect::<String>();
    let mut in_ripple = false;
    for line in text.lines() {
        let bare = line.trim_start();
        if bare.starts_with('[') {
            in_ripple = bare.starts_with("[[ripple]]");
        }
        if in_ripple {
            continue;
        }
        out += &changed(line, said, |key| found.numbers.iter().find(|n| n.name == key));
    }
    for line in found.model.process.iter().flat_map(|process| &process.ripple) {
        out += &format!(
            "\n[[ripple]]\norder = {:?}\naxial = {:?}\nin_plane = {:?}\nphase_rad = {:?}\n",
            line.order, line.axial, line.in_plane, line.phase
        );
        let at = format!("order {}", line.order);
        for number in found.numbers.iter().filter(|n| n.at == at) {
            out += &format!("# {}: {}\n", number.name, said(number));
        }
    }
    let written = Process::parse(&out, &to.display().to_string())?;
    if Some(&written) == found.model.process.as_ref() {
        return Ok(out);
    }
    Err(unchangeable(&name, &text))
}

fn unchangeable(name: &str, text: &str) -> InputError {
    let help = "Write each number on a line of its own, below its [[joint]] or at the file's top.";
    let message = "its numbers cannot be changed in place; expected a line a number".to_owned();
    Source::new(name, text).error_of_file(message, help)
}

/// A line of a file, with the number found where `number` has one for its key.
fn changed<'n>(
    line: &str,
    said: &dyn Fn(&Number) -> String,
    number: impl Fn(&str) -> Option<&'n Number>,
) -> String {
    let bare = line.trim_start();
    let key = bare.split(['=', ' ']).next().unwrap_or_default();
    match number(key).filter(|_| bare.contains('=')) {
        Some(number) if number.is_identifiable() => {
            format!("{key} = {:?}        # {}\n", number.value, said(number))
        }
        Some(number) => format!("{line}        # {}\n", said(number)),
        None => format!("{line}\n"),
    }
}

/// Text of the robot file of the model with the numbers found, for a file at `to`. `said`: what
/// stands behind a number, and at the head of the file.
///
/// # Errors
/// A file that cannot be read again, or whose numbers are written in a way that does not let them be
/// changed: inline tables.
pub fn robot_text(
    found: &Identification,
    to: &Path,
    said: &dyn Fn(&Number) -> String,
    head: &str,
) -> Result<String, InputError> {
    let (name, text) = read_text(&found.model.robot_path)?;
    let joints = &found.model.robot.joint_names;
    let mut out = head.lines().map(|line| format!("# {line}\n")).collect::<String>();
    let mut joint: Option<usize> = None;
    for line in text.lines() {
        let bare = line.trim_start();
        if bare.starts_with('[') {
            let next = joint.map_or(0, |j| j + 1);
            joint = if bare.starts_with("[[joint]]") { Some(next) } else { joint };
        }
        let number = |key: &str| {
            let at = joint.and_then(|j| joints.get(j));
            found.numbers.iter().find(|n| n.name == key && Some(&n.at) == at)
        };
        out += &changed(line, said, number);
        // A spring in place of a rigid drive has a damper beside it, which the file lacks.
        let is_found = |n: &Number| n.given.is_nan() && n.is_identifiable();
        let key = bare.split(['=', ' ']).next().unwrap_or_default();
        if let Some(joint) = joint.filter(|_| number(key).is_some_and(is_found)) {
            let damping = found.model.robot.parameters.joints[joint].damping;
            out += &format!(
                "damping_nms_rad = {damping:?}        # 3 % of critical, not identified\n"
            );
        }
    }
    let written = RobotFile::parse(&out, &to.display().to_string())?;
    if written.parameters == found.model.robot.parameters {
        return Ok(out);
    }
    Err(unchangeable(&name, &text))
}
