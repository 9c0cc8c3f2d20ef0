//! Input files that are part of the program: what is read where none is given.

use miette::Result;
use std::path::Path;
use trueweld_evaluate::Requirements;
use trueweld_plant::input::{Control, InputFile, Process, RobotFile, Sensors, Weld, read_text};
use trueweld_plant::provenance::FileDigest;

/// A kind of file with a fixture that is part of the program.
pub trait Embedded: InputFile {
    /// Name and text of the fixture.
    const FIXTURE: [&str; 2];
}

/// Name and text of a fixture.
macro_rules! fixture {
    ($file:literal) => {
        [
            concat!("embedded ", $file),
            include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/", $file)),
        ]
    };
}

macro_rules! embedded {
    ($($type:ty: $file:literal;)*) => {$(
        impl Embedded for $type {
            const FIXTURE: [&str; 2] = fixture!($file);
        }
    )*};
}

embedded! {
    Weld: "welds/vertical.toml";
    RobotFile: "robots/kr500-mt.toml";
    Process: "processes/lap-weld-2024-t3.toml";
    Control: "control/kr500-mt.toml";
    Sensors: "sensors/kr500-mt.toml";
    Requirements: "requirements/lap-weld.toml";
}

/// The welds as they were published, each with its name.
pub(crate) const PUBLISHED_WELDS: [(&str, [&str; 2]); 2] = [
    ("vertical", fixture!("welds/published-vertical.toml")),
    ("inclined", fixture!("welds/published-inclined.toml")),
];

/// Reads a file, or the embedded one where none is given, and adds its digest to `files`.
///
/// # Errors
/// [`InputError`](trueweld_plant::input::InputError): a file that cannot be read, or a value that is
/// not possible, at its place.
pub fn read_input<T: Embedded>(path: Option<&Path>, files: &mut Vec<FileDigest>) -> Result<T> {
    let (name, text) = match path {
        Some(path) => read_text(path)?,
        None => T::FIXTURE.map(str::to_owned).into(),
    };
    files.push(FileDigest::new(T::KIND.name(), &name, text.as_bytes()));
    Ok(T::parse(&text, &name)?)
}
