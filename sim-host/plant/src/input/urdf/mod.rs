//! A URDF → the text of a robot file.
//!
//! Carried over: the six joints' origins, axes, limits and ratings, and the masses, centres and
//! inertias of the links, merged across fixed joints. In a robot file all link frames are parallel
//! to the base at zero, so everything is turned into the axes of the URDF's root link at zero. A
//! URDF knows nothing of elasticity, drives, friction, counterbalance and mounting: those stand as
//! [`FILL_IN`](super::FILL_IN) markers, which the robot reader refuses, as does what a link without
//! `<inertial>` leaves open. A joint that mimics another and carries no axis of its own (a finger of
//! a gripper) is held where it stands when that other is at zero; one that carries an axis is an
//! axis, and its coupling is left out. The file says so of each. Left out: shapes.

mod arm;
mod scan;
mod write;

use super::{InputError, Source, read_text};
use arm::Arm;
use scan::Urdf;
use std::path::Path;

/// Turns a URDF of a six-axis arm into the text of a `robot/1` file.
///
/// # Errors
/// Broken XML, missing or bad numbers, and whatever is no serial chain of six revolute joints with
/// inertias.
pub fn import_urdf(path: impl AsRef<Path>) -> Result<String, InputError> {
    let (name, text) = read_text(path.as_ref())?;
    import_urdf_text(&text, &name)
}

/// As [`import_urdf`], from text; `name` is what errors call it.
///
/// # Errors
/// As [`import_urdf`].
pub fn import_urdf_text(text: &str, name: &str) -> Result<String, InputError> {
    let source = Source::new(name, text);
    let urdf = Urdf::read(&source)?;
    let arm = Arm::from_urdf(&urdf, &source)?;
    Ok(arm.write(&urdf.name, name))
}
