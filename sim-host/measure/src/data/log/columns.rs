//! The columns that a table of samples may have, and the header that says which it has.

use super::lines::Lines;
use crate::data::channel::{CHANNELS, COUNT, LogChannel, column_name};
use crate::data::kind::LogKind;
use std::io::Read;
use trueweld_plant::input::InputError;
use trueweld_plant::input::{nearest, unit_of};

/// A row as it is read: a value a known column, NaN where there is none.
pub(super) type RawRow = [f64; COUNT];

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
            match (0..COUNT).find(|column| column_name(*column) == name) {
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

    /// Which columns of a channel are there.
    pub fn which<const N: usize>(&self, channel: LogChannel) -> [bool; N] {
        std::array::from_fn(|i| self.has(channel.columns().start + i))
    }

    /// True where a channel has any column.
    pub fn has_channel(&self, channel: LogChannel) -> bool {
        channel.columns().any(|column| self.has(column))
    }

    /// What is told about columns that are not read.
    pub fn notices(&self, kind: LogKind) -> Vec<String> {
        let mut notices = Vec::new();
        if !self.unknown.is_empty() {
            let names: Vec<_> =
                self.unknown.iter().map(|name| format!("`{}`", name.escape_debug())).collect();
            notices.push(format!("columns that are not known, left out: {}", names.join(", ")));
        }
        if self.has_channel(LogChannel::Payload) && kind != LogKind::StaticLoad {
            let columns = named(LogChannel::Payload.columns());
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
            let of_kind = |column: &usize| {
                kind == LogKind::StaticLoad || LogChannel::of(*column).0.id != LogChannel::Payload
            };
            for column in (0..COUNT).filter(|column| !self.has(*column)).filter(of_kind) {
                let right = column_name(column);
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
                    column_names().any(|c| c.split_once('_').is_some_and(|(_, ending)| ending == u))
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
        let required = CHANNELS
            .iter()
            .filter(|channel| channel.needed.contains(&kind))
            .flat_map(|channel| channel.id.columns());
        if let Some(column) = required.into_iter().find(|column| !self.has(*column)) {
            let name = column_name(column);
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
        for columns in CHANNELS.iter().filter(|c| c.together).map(|c| c.id.columns()) {
            let there = columns.clone().find(|column| self.has(*column));
            let missing = columns.clone().find(|column| !self.has(*column));
            if let (Some(there), Some(missing)) = (there, missing) {
                let all = named(columns);
                let message = format!(
                    "`{}` without `{}`; expected all of {all}, or none",
                    column_name(there),
                    column_name(missing)
                );
                let help = format!(
                    "Add `{}`, with empty fields where it has no values.",
                    column_name(missing)
                );
                return Err(lines.error_at(
                    self.place[there].unwrap_or_default(),
                    message,
                    "not alone",
                    help,
                ));
            }
        }
        let predicted = predicted(kind);
        if !predicted.iter().any(|column| self.has(*column)) {
            let message =
                format!("a {kind} log is compared by {}; expected at least one", named(&predicted));
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

fn column_names() -> impl Iterator<Item = &'static str> {
    CHANNELS.iter().flat_map(|channel| channel.columns).copied()
}

/// The columns that a kind of log may be compared by: the first of each channel whose columns come
/// together, all of the others.
pub(super) fn predicted(kind: LogKind) -> Vec<usize> {
    let channels = CHANNELS.iter().filter(|channel| channel.predicted.contains(&kind));
    channels
        .flat_map(|channel| channel.id.columns().take(if channel.together { 1 } else { COUNT }))
        .collect()
}

/// Names of columns as messages show them.
pub(super) fn named(columns: impl IntoIterator<Item = impl std::borrow::Borrow<usize>>) -> String {
    let names: Vec<_> =
        columns.into_iter().map(|column| format!("`{}`", column_name(*column.borrow()))).collect();
    names.join(", ")
}

/// A header that makes sense with another separator was written with it.
fn refuse_other_separators<R: Read>(lines: &Lines<R>) -> Result<(), InputError> {
    let known = |field: &[u8]| column_names().any(|column| column.as_bytes() == field);
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
