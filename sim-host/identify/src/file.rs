//! Robot and process files with the numbers found: the file that was given, every other line as it
//! was, and behind each number its interval and where it comes from.

use crate::identification::{Identification, Number};
use std::path::Path;
use trueweld_plant::input::{InputError, InputFile, RobotFile, Source, read_text};

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
        let key = bare.split(['=', ' ']).next().unwrap_or_default();
        let of_joint = |n: &&Number| {
            n.name == key && joint.and_then(|j| joints.get(j)).is_some_and(|at| *at == n.at)
        };
        match found.numbers.iter().find(of_joint).filter(|_| bare.contains('=')) {
            Some(number) if number.is_identifiable() => {
                out += &format!("{key} = {:?}        # {}\n", number.value, said(number));
            }
            Some(number) => out += &format!("{line}        # {}\n", said(number)),
            None => out += &format!("{line}\n"),
        }
    }
    let written = RobotFile::parse(&out, &to.display().to_string())?;
    if written.parameters == found.model.robot.parameters {
        return Ok(out);
    }
    let help = "Write each joint as a [[joint]] table with its numbers on lines of their own.";
    let message = "its numbers cannot be changed in place; expected [[joint]] tables".to_owned();
    Err(Source::new(&name, &text).error_of_file(message, help))
}
