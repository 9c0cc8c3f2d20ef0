//! What a proposal holds: files and columns, with what each part rests on and what of it is a
//! guess.

use crate::clock::FittedClock;
use crate::kind::LogKind;
use crate::log::columns::ColumnMapping;
use crate::log::computed::Rigid;
use std::path::PathBuf;

/// Some values of a column as it is proposed to be read.
#[derive(Debug, Clone, PartialEq)]
pub struct Preview {
    /// Times, s.
    pub time: Vec<f64>,
    /// Values, in the channel's unit.
    pub read: Vec<f64>,
    /// What the model makes of the encoders' motion: of a torque what a rigid arm needs, of a second
    /// encoder the first one's angle, of a position where the flange's tool is in the tracker's frame.
    pub predicted: Option<Vec<f64>>,
}

/// What a proposed part rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ProposalBasis {
    /// The header names the channel.
    Header,
    /// No header names a time; the values rise as one does.
    Rises,
    /// A rotation in degrees: a rotation vector as the header has it, or angles about three axes.
    Degrees,
    /// There is no header; a comment above names as many columns as have decimals.
    Comment,
    /// The header, or the row below it, states the unit.
    UnitInHeader,
    /// The tracker saw the motion that the axis makes counted from the horizontal, and no other.
    Coupling,
    /// A number stands for values that were not measured, which are read as missing.
    Sentinel {
        /// The number.
        value: f64,
        /// Rows that hold it.
        rows: usize,
    },
    /// The values are of this size in one unit alone.
    Magnitude,
    /// With the other sign the axis leaves its limits.
    Limits,
    /// The tracker saw the motion that these signs make: what is left, m, and what the best of the
    /// others leaves.
    Motion {
        /// With these signs.
        left: f64,
        /// With the best others.
        others: f64,
    },
    /// The model's torque goes up and down with it: the correlation.
    ModelTorque(f64),
}

/// What is only a guess in a proposed part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// Nothing names the column.
    Channel,
    /// The values fit several units; this is the usual one.
    Unit,
    /// The motion of the encoders says a unit a thousand times as large or as small as the header.
    Scale,
    /// Nothing tells the sign.
    Sign,
    /// A current or a share becomes a torque by a factor that no file holds.
    Factor,
}

/// Why a column is left out.
#[derive(Debug, Clone, PartialEq)]
pub enum LeftOut {
    /// A word of its header is not known, or they name no channel together.
    Unknown,
    /// It was commanded, not measured.
    Commanded,
    /// The controller computes it from its encoders.
    Computed,
    /// It agrees with what the encoders and a rigid robot come to as closely as it is written.
    Rigid(Rigid),
    /// A limit, not a reading.
    Limit,
    /// Something that is no channel: what.
    NoChannel(&'static str),
    /// Its unit is not one of what its header names: which.
    OtherUnit(&'static str),
    /// Its header names a time, and its values do not rise.
    NotRising,
    /// Other components of its vector are not there.
    Incomplete,
    /// The column with this header is the same channel, and is nearer to an instrument.
    Twice(String),
    /// The column with this header claims the same channel, and nothing tells which was measured.
    Rival(String),
    /// It does not hold numbers.
    NoNumbers,
}

/// A column of a file, with what it probably is.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedColumn {
    /// Index of the file.
    pub file: usize,
    /// Its header.
    pub header: String,
    /// Least and largest value.
    pub range: Option<[f64; 2]>,
    /// How it is mapped.
    pub mapping: Result<ColumnMapping, LeftOut>,
    /// What that rests on.
    pub bases: Vec<ProposalBasis>,
    /// What of it is a guess.
    pub doubts: Vec<Doubt>,
    /// Some of its values, where it is mapped and the file has times.
    pub preview: Option<Preview>,
}

impl ProposedColumn {
    /// True if it is mapped to this column of a log.
    #[must_use]
    pub(super) fn is(&self, column: usize) -> bool {
        self.mapping.as_ref().is_ok_and(|m| m.column == column)
    }
}

/// A file, with how it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedFile {
    /// Where it is.
    pub path: PathBuf,
    /// Which messages, of a file that holds several kinds.
    pub topic: Option<String>,
    /// True of text; the next four are of text alone.
    pub text: bool,
    /// Between the fields.
    pub delimiter: char,
    /// Decimal mark.
    pub decimal: char,
    /// Line of the header; 0 without one.
    pub header: usize,
    /// First line with values.
    pub first_row: usize,
    /// Rows that were looked at.
    pub rows: usize,
    /// Period of its rows, s.
    pub period: Option<f64>,
    /// Name of its clock; `None` for the log's own.
    pub clock: Option<String>,
    /// What its clock was fitted to be.
    pub fitted: Option<FittedClock>,
}

/// A log as files of unknown make probably are.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The files; the one with the encoders first.
    pub files: Vec<ProposedFile>,
    /// Their columns.
    pub columns: Vec<ProposedColumn>,
    /// What was done.
    pub kind: LogKind,
    /// True where the kind was given, or only one fits.
    pub kind_sure: bool,
    /// True where no column of the encoders' file is its time: its rows are even, at a period that
    /// has to be stated.
    pub period_open: bool,
    /// That period, where it was stated, s.
    pub period: Option<f64>,
    /// Channels that every log of this kind needs and no column is.
    pub missing: Vec<&'static str>,
}
