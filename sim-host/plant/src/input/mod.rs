//! Input files → checked values.
//!
//! Six kinds of TOML file are read here, each with a `schema` line that says which: the robot, the
//! welding process, the weld, the controllers' gains, the sensors, and the model, which names a
//! robot and a process and lists the effects they have.
//! Every kind is read from a path (`read`) or from text (`parse`), and everything is checked, so
//! that nothing later can fail for a bad file. Values come out in SI units and radians. A URDF
//! becomes a robot file by [`import_urdf`]. Left out: requirements, logs
//! and campaigns, which belong where runs are judged and where measurements are; they are known by
//! name only, so that a file of theirs is not called unknown. So are protocols of the laboratory.

mod accuracy;
mod bounds;
pub mod control;
mod control_file;
pub mod document;
pub mod error;
pub mod file;
pub mod model;
mod nearest;
mod place;
pub mod posterior;
pub mod quantity;
pub mod relation;
pub mod robot;
pub mod sensors;
mod sensors_file;
mod table;
mod unit;
pub mod urdf;
mod value;
pub mod weld;

pub use crate::process::{Process, Ripple, check_weld};
pub use accuracy::Accuracy;
pub use bounds::Bounds;
pub use control::{CascadeGains, CompensationLimits, Control, OwnGains, ParallelGains};
pub use document::TomlDocument;
pub use error::{InputError, Source, printable};
pub(crate) use file::hash_of_file;
pub use file::{
    InputReader, files_read, folder_of, hexadecimal, may_write_into, open, read_text, remove_stale,
    write_atomically, write_atomically_with,
};
pub use model::{Comments, EffectComments, KnownEffect, ModelEffect, ModelFile, Scope};
pub use nearest::{did_you_mean, nearest};
pub use posterior::{MeasuredNumber, Posterior};
pub use quantity::{Quantity, check_option, quantity, warn, warnings};
pub use relation::Relation;
pub use robot::RobotFile;
pub use sensors::{ForceSensor, SeamSensor, Sensors};
pub use table::TomlTable;
pub use unit::{unit_of, unit_suffix};
pub use urdf::{import_urdf, import_urdf_text};
pub use value::{FILL_IN, Text, toml_string};
pub use weld::{RealSeam, Wave, Weld};

use std::fmt;
use std::path::Path;

/// A kind of input file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// `robot/1`, read by [`RobotFile`].
    Robot,
    /// `process/1`, read by [`Process`].
    Process,
    /// `weld/1` and `weld/2`, read by [`Weld`].
    Weld,
    /// `control/1`, read by [`Control`].
    Control,
    /// `sensors/1`, read by [`Sensors`].
    Sensors,
    /// `model/1`, read by [`ModelFile`].
    Model,
    /// `requirements/1`, what a law must reach; read where runs are judged.
    Requirements,
    /// `log/1`, a recorded log; read where measurements are.
    Log,
    /// `campaign/1`, a list of logs of one cell; read where measurements are.
    Campaign,
    /// `protocol/1`, what is to be recorded; read by the laboratory.
    Protocol,
}

/// Every kind of input file.
pub const FILE_KINDS: [FileKind; 10] = [
    FileKind::Robot,
    FileKind::Process,
    FileKind::Weld,
    FileKind::Control,
    FileKind::Sensors,
    FileKind::Model,
    FileKind::Requirements,
    FileKind::Log,
    FileKind::Campaign,
    FileKind::Protocol,
];

impl FileKind {
    /// The file's `schema`; the first one where there are several.
    pub fn schema(self) -> &'static str {
        self.schemas()[0]
    }

    /// Every `schema` that such a file may have, the first one first.
    pub fn schemas(self) -> &'static [&'static str] {
        match self {
            Self::Weld => &["weld/1", "weld/2"],
            Self::Robot => &["robot/1"],
            Self::Process => &["process/1"],
            Self::Control => &["control/1"],
            Self::Sensors => &["sensors/1"],
            Self::Requirements => &["requirements/1"],
            Self::Log => &["log/1"],
            Self::Campaign => &["campaign/1"],
            Self::Protocol => &["protocol/1"],
            Self::Model => &["model/1"],
        }
    }

    /// Its name in one word.
    pub fn name(self) -> &'static str {
        self.schema().trim_end_matches("/1")
    }

    /// What such a file describes.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Robot => "a robot",
            Self::Process => "a welding process",
            Self::Weld => "a weld",
            Self::Control => "gains of the controllers",
            Self::Sensors => "sensors",
            Self::Requirements => "requirements of a certification",
            Self::Log => "a log of measurements",
            Self::Campaign => "a campaign of logs",
            Self::Protocol => "a protocol of what is to be recorded",
            Self::Model => "a model of the cell",
        }
    }
}

impl fmt::Display for FileKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.describe())
    }
}

/// An input file of one kind: what its reader makes of the top-level table.
pub trait InputFile: Sized {
    /// Its kind.
    const KIND: FileKind;

    /// Reads and checks the values of the file.
    ///
    /// # Errors
    /// The first thing that does not fit, with its place.
    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError>;

    /// Reads a file.
    ///
    /// # Errors
    /// As [`InputFile::from_root`]; a file that cannot be read, or is of another kind.
    fn read(path: impl AsRef<Path>) -> Result<Self, InputError> {
        let (name, text) = read_text(path.as_ref())?;
        Self::parse(&text, &name)
    }

    /// Reads text; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`InputFile::from_root`]; text of another kind of file.
    fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        let document = TomlDocument::parse(text, name)?;
        Self::from_root(&document.root_of_one(Self::KIND.schemas())?)
    }
}

/// An error for every entry of a file that is still to be filled in, in the file's order.
///
/// # Errors
/// A file that cannot be read, or is not TOML.
pub fn open_entries(path: impl AsRef<Path>) -> Result<Vec<InputError>, InputError> {
    let (name, text) = read_text(path.as_ref())?;
    Ok(TomlDocument::parse(&text, &name)?.open_entries())
}
