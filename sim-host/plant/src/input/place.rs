//! Where an effect is, as a file has it.

use super::table::TomlTable;
use super::{InputError, RobotFile};
use crate::effects::{EffectError, EffectKind, Location};

/// The key `at` of a table of an effect, left out for an effect of the whole cell.
pub(super) fn place(
    table: &TomlTable<'_>,
    kind: &EffectKind,
    robot: &RobotFile,
) -> Result<Location, InputError> {
    let written = if table.has("at") { table.text("at")?.text } else { "" };
    place_of(kind, written, robot)
        .map_err(|expected| table.wrong("at", &expected, format!("Expected {expected}.")))
}

/// The place that is written `at`; where there is none, what is expected.
pub(super) fn place_of(kind: &EffectKind, at: &str, robot: &RobotFile) -> Result<Location, String> {
    kind.at(at, robot).map_err(|error| match error {
        EffectError::LocationKind { expected, .. } => expected,
        other => other.to_string(),
    })
}
