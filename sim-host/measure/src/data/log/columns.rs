//! The columns that a table of samples may have, and the header that says which it has.

use super::LogKind;
use super::lines::Lines;
use std::io::Read;
use trueweld_core::JOINTS;
use trueweld_plant::input::InputError;
use trueweld_plant::input::document::{nearest, unit_of};

/// Index of the first column of each group in [`COLUMNS`].
pub(super) mod at {
    pub const TIME: usize = 0;
    pub const ENCODER: usize = 1;
    pub const LINK_ENCODER: usize = 7;
    pub const MOTOR_TORQUE: usize = 13;
    pub const FORCE: usize = 19;
    pub const MOMENT: usize = 22;
    pub const POSITION: usize = 25;
    pub const ROTATION: usize = 28;
    pub const SPINDLE: usize = 31;
    pub const PAYLOAD: usize = 32;
}

/// Number of columns that are known.
pub(super) const COUNT: usize = 36;

/// A row as it is read: a value a known column, NaN where there is none.
pub(super) type RawRow = [f64; COUNT];

pub(super) const COLUMNS: [&str; COUNT] = [
    "t_s",
    "qe1_rad",
    "qe2_rad",
    "qe3_rad",
    "qe4_rad",
    "qe5_rad",
    "qe6_rad",
    "ql1_rad",
    "ql2_rad",
    "ql3_rad",
    "ql4_rad",
    "ql5_rad",
    "ql6_rad",
    "tm1_nm",
    "tm2_nm",
    "tm3_nm",
    "tm4_nm",
    "tm5_nm",
    "tm6_nm",
    "fx_n",
    "fy_n",
    "fz_n",
    "mx_nm",
    "my_nm",
    "mz_nm",
    "px_m",
    "py_m",
    "pz_m",
    "rx_rad",
    "ry_rad",
    "rz_rad",
    "spindle_rad_s",
    "payload_kg",
    "cx_m",
    "cy_m",
    "cz_m",
];

/// Columns that come together or not at all: first, number.
pub(super) const GROUPS: [(usize, usize); 5] =
    [(at::FORCE, 3), (at::MOMENT, 3), (at::POSITION, 3), (at::ROTATION, 3), (at::PAYLOAD, 4)];

/// Units that people record in, the unit that is read, and the factor between them.
const OTHER_UNITS: &[(&str, &str, &str)] = &[
    ("deg", "rad", "π/180"),
    ("degrees", "rad", "π/180"),
    ("mrad", "rad", "0.001"),
    ("urad", "rad", "1e-6"),
    ("mm", "m", "0.001"),
    ("cm", "m", "0.01"),
    ("um", "m", "1e-6"),
    ("kn", "n", "1000"),
    ("knm", "nm", "1000"),
    ("nmm", "nm", "0.001"),
    ("min", "s", "60"),
    ("ms", "s", "0.001"),
    ("us", "s", "1e-6"),
    ("ns", "s", "1e-9"),
    ("rpm", "rad_s", "2π/60"),
    ("1_min", "rad_s", "2π/60"),
    ("hz", "rad_s", "2π"),
    ("deg_s", "rad_s", "π/180"),
    ("g", "kg", "0.001"),
    ("t", "kg", "1000"),
];

/// Which column stands where.
pub(super) struct Header {
    /// Field of each known column.
    pub place: [Option<usize>; COUNT],
    /// Number of fields in every row.
    pub width: usize,
    /// Names that are not known, for the notice.
    pub unknown: Vec<String>,
}

impl Header {
    /// Reads the first line.
    pub fn read<R: Read>(lines: &mut Lines<R>, kind: LogKind) -> Result<Self, InputError> {
        if !lines.advance()? {
            let message =
                "the file is empty; expected a header with the names of the columns, then rows";
            return Err(lines.error_of_file(message, "Was the recording written to another place?"));
        }
        refuse_other_separators(lines)?;
        let mut place = [None; COUNT];
        let mut others = Vec::new();
        for field in 0..lines.width() {
            let name = String::from_utf8_lossy(lines.field(field)).into_owned();
            match COLUMNS.iter().position(|column| *column == name) {
                Some(column) if place[column].is_some() => {
                    let message = format!(
                        "column `{name}` stands here a second time; expected each column once"
                    );
                    return Err(lines.error_at(
                        field,
                        message,
                        "again",
                        "Remove or rename one of the two.",
                    ));
                }
                Some(column) => place[column] = Some(field),
                None => others.push((field, name)),
            }
        }
        let header = Self { place, width: lines.width(), unknown: Vec::new() };
        header.refuse_near_misses(lines, kind, &others)?;
        header.require(lines, kind, &others)?;
        Ok(Self { unknown: others.into_iter().map(|(_, name)| name).collect(), ..header })
    }

    /// True where the column is there.
    pub fn has(&self, column: usize) -> bool {
        self.place[column].is_some()
    }

    /// Which of the columns from this one on are there.
    pub fn which<const N: usize>(&self, first: usize) -> [bool; N] {
        std::array::from_fn(|i| self.has(first + i))
    }

    /// What is told about columns that are not read.
    pub fn notices(&self, kind: LogKind) -> Vec<String> {
        let mut notices = Vec::new();
        if !self.unknown.is_empty() {
            let names: Vec<_> =
                self.unknown.iter().map(|name| format!("`{}`", name.escape_debug())).collect();
            notices.push(format!("columns that are not known, left out: {}", names.join(", ")));
        }
        if self.has(at::PAYLOAD) && kind != LogKind::StaticLoad {
            let columns = named(at::PAYLOAD..COUNT);
            notices.push(format!(
                "columns of static-load logs only, left out of this {kind} log: {columns}"
            ));
        }
        notices
    }

    /// A column that is another spelling or another unit of one that is not there would be lost
    /// silently.
    fn refuse_near_misses<R: Read>(
        &self,
        lines: &Lines<R>,
        kind: LogKind,
        others: &[(usize, String)],
    ) -> Result<(), InputError> {
        let bare = |name: &str| name.to_lowercase().replace(|c: char| !c.is_alphanumeric(), "");
        for (field, name) in others {
            for column in (0..kind.columns()).filter(|column| !self.has(*column)) {
                let right = COLUMNS[column];
                let shown = lines.shown(*field);
                if bare(name) == bare(right) {
                    let message =
                        format!("column {shown} is not a name that is known; expected `{right}`");
                    let help =
                        format!("Write `{right}`: small letters, the unit after an underscore.");
                    return Err(lines.error_at(
                        *field,
                        message,
                        format!("expected `{right}`"),
                        help,
                    ));
                }
                let lower = name.to_lowercase();
                let (stem, unit) = lower.split_once(['_', ' ']).unwrap_or((&lower, ""));
                let unit = unit.trim_matches(|c: char| !c.is_alphanumeric()).replace('/', "_");
                let Some((known, reads)) = right.split_once('_') else {
                    continue;
                };
                let is_unit = |u: &str| {
                    COLUMNS.iter().any(|c| c.split_once('_').is_some_and(|(_, ending)| ending == u))
                };
                let factor =
                    OTHER_UNITS.iter().find(|(other, read, _)| *other == unit && *read == reads);
                let read_in = unit_of(right).unwrap_or_default();
                let (is, help) = match factor {
                    _ if known != stem => continue,
                    Some((_, _, factor)) => (
                        format!("is in {unit}"),
                        format!("Multiply the column by {factor} and call it `{right}`."),
                    ),
                    None if unit.is_empty() => (
                        "names no unit".to_owned(),
                        format!("If it is in {read_in}, call it `{right}`."),
                    ),
                    None if is_unit(&unit)
                        || OTHER_UNITS.iter().any(|(other, ..)| *other == unit) =>
                    {
                        (
                            format!("names the unit {unit}"),
                            format!("If it is in {read_in}, call it `{right}`."),
                        )
                    }
                    None => continue,
                };
                let message = format!("column {shown} {is}; expected `{right}`, in {read_in}");
                return Err(lines.error_at(*field, message, format!("expected `{right}`"), help));
            }
        }
        Ok(())
    }

    fn require<R: Read>(
        &self,
        lines: &Lines<R>,
        kind: LogKind,
        others: &[(usize, String)],
    ) -> Result<(), InputError> {
        let whole = 0..lines.line().len();
        let mut required: Vec<usize> = (at::TIME..at::ENCODER + JOINTS).collect();
        if kind == LogKind::Weld {
            required.push(at::SPINDLE);
        }
        if let Some(column) = required.into_iter().find(|column| !self.has(*column)) {
            let name = COLUMNS[column];
            let message = format!("missing column `{name}`; expected in every {kind} log");
            let near = nearest(name, others.iter().map(|(_, other)| other.as_str()));
            return Err(match others.iter().find(|(_, other)| near == Some(other)) {
                Some((field, _)) => {
                    let help = format!("If {} is meant, call it `{name}`.", lines.shown(*field));
                    lines.error_at(
                        *field,
                        format!("{message}; read {}", lines.shown(*field)),
                        "meant here?",
                        help,
                    )
                }
                None => {
                    let starts_with_number =
                        std::str::from_utf8(lines.field(0)).is_ok_and(|f| f.parse::<f64>().is_ok());
                    let help = if starts_with_number {
                        "The first line holds the names of the columns; this one begins with a number."
                    } else {
                        "The first line holds the names of the columns, with commas between them."
                    };
                    lines.error(whole, message, format!("`{name}` is not among these"), help)
                }
            });
        }
        for (first, number) in GROUPS {
            let columns = first..first + number;
            let there = columns.clone().find(|column| self.has(*column));
            let missing = columns.clone().find(|column| !self.has(*column));
            if let (Some(there), Some(missing)) = (there, missing) {
                let all = named(columns);
                let message = format!(
                    "`{}` without `{}`; expected all of {all}, or none",
                    COLUMNS[there], COLUMNS[missing]
                );
                let help = format!(
                    "Add `{}`, with empty fields where it has no values.",
                    COLUMNS[missing]
                );
                return Err(lines.error_at(
                    self.place[there].unwrap_or_default(),
                    message,
                    "not alone",
                    help,
                ));
            }
        }
        let predicted = kind.predicted();
        if !predicted.iter().any(|column| self.has(*column)) {
            let message =
                format!("a {kind} log is compared by {}; expected at least one", named(predicted));
            return Err(lines.error(
                whole,
                message,
                "none among these",
                "Without one there is nothing to compare.",
            ));
        }
        Ok(())
    }
}

/// Names of columns as messages show them.
pub(super) fn named(columns: impl IntoIterator<Item = impl std::borrow::Borrow<usize>>) -> String {
    let names: Vec<_> =
        columns.into_iter().map(|column| format!("`{}`", COLUMNS[*column.borrow()])).collect();
    names.join(", ")
}

/// A header that makes sense with another separator was written with it.
fn refuse_other_separators<R: Read>(lines: &Lines<R>) -> Result<(), InputError> {
    let known = |field: &[u8]| COLUMNS.iter().any(|column| column.as_bytes() == field);
    if (0..lines.width()).any(|field| known(lines.field(field))) {
        return Ok(());
    }
    for (separator, name) in [(b';', "`;`"), (b'\t', "a tab"), (b'|', "`|`"), (b' ', "a blank")] {
        if let (true, Some(at)) = (
            lines
                .line()
                .split(|byte| *byte == separator || *byte == b'"')
                .any(|field| known(field.trim_ascii())),
            lines.line().iter().position(|byte| *byte == separator),
        ) {
            let message = format!(
                "this file uses {name} as separator; expected `,`, and the dot as decimal mark"
            );
            let help = "Save it with commas between the fields and dots in the numbers.";
            return Err(lines.error(at..at + 1, message, "expected `,`", help));
        }
    }
    Ok(())
}
