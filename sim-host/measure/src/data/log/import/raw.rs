//! How a file is written, by its first lines, and the numbers of its first rows.

use super::proposal::{ProposedColumn, ProposedFile};
use crate::data::channel::LogChannel;
use crate::data::log::files::FileEntry;
use crate::data::log::rows::{MOST_ROWS, Rows};
use crate::data::log::text::{Dialect, SEPARATORS};
use crate::data::log::units::unit_named;
use crate::data::log::{kuka, source};
use std::io::Read;
use trueweld_plant::input::{InputError, open};

/// Rows that a proposal looks at.
const LOOKED_AT: usize = 200_000;

/// Bytes at a file's start from which its form is told.
const SNIFFED: u64 = 1 << 16;

pub(super) const TIME: usize = LogChannel::Time.columns().start;
pub(super) const ENCODER: usize = LogChannel::Encoder.columns().start;
pub(super) const TORQUE: usize = LogChannel::MotorTorque.columns().start;
pub(super) const POSITION: usize = LogChannel::Position.columns().start;

/// A file's numbers.
pub(super) struct Raw {
    pub(super) entry: FileEntry,
    pub(super) text: bool,
    pub(super) names: Vec<String>,
    /// NaN where it is no number; `None` for a column without any.
    pub(super) values: Vec<Option<Vec<f64>>>,
    pub(super) rows: usize,
}

/// Reads a file's first rows, having found out how it is written.
pub(super) fn read(mut entry: FileEntry) -> Result<Raw, InputError> {
    let mut start = Vec::new();
    let sniffed = open(&entry.path, MOST_ROWS)?.take(SNIFFED).read_to_end(&mut start);
    let text = sniffed.is_ok() && looks_like_text(&start);
    if text {
        entry.dialect = sniff(&start);
    }
    let mut rows: Box<dyn Rows> = source::open(&entry)?;
    let names: Vec<String> = rows.names().to_vec();
    let mut values: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); names.len()];
    let mut count = 0;
    while count < LOOKED_AT && rows.advance()? {
        for (column, values) in values.iter_mut().enumerate() {
            if let Some(values) = values {
                values.push(rows.value(column).unwrap_or(f64::NAN));
            }
        }
        count += 1;
    }
    if count == 0 {
        let message = "there is no row after the header; expected the samples".to_owned();
        return Err(rows.error_of_file(message, "Was the recording stopped as soon as it began?"));
    }
    for values in &mut values {
        if values.as_ref().is_some_and(|v| v.iter().all(|x| x.is_nan())) {
            *values = None;
        }
    }
    Ok(Raw { entry, text, names, values, rows: count })
}

fn looks_like_text(start: &[u8]) -> bool {
    let binary = start.iter().filter(|b| **b < 9 || (14..32).contains(*b)).count();
    binary == 0 && !start.starts_with(kuka::MAGIC)
}

/// How a text file is written, by its first lines.
fn sniff(start: &[u8]) -> Dialect {
    let text: String = start.iter().map(|byte| char::from(*byte)).collect();
    let mut lines: Vec<&str> = text.lines().collect();
    // The last one may be cut.
    if lines.len() > 2 {
        lines.pop();
    }
    let split = |line: &str, delimiter: u8| -> Vec<String> {
        let fields: Box<dyn Iterator<Item = &str>> = match delimiter {
            b' ' => Box::new(line.split_whitespace()),
            // Many programs end every line with a separator.
            _ => {
                let line = line.strip_suffix(char::from(delimiter)).unwrap_or(line);
                Box::new(line.split(char::from(delimiter)))
            }
        };
        fields.map(|f| f.trim().trim_matches('"').to_owned()).collect()
    };
    let is_number = |field: &str, decimal: u8| {
        let dotted = if decimal == b',' { field.replace(',', ".") } else { field.to_owned() };
        field.is_empty() || dotted.parse::<f64>().is_ok()
    };
    let mut best = (0, Dialect::PLAIN);
    for (delimiter, _) in SEPARATORS {
        for decimal in [b'.', b','] {
            if decimal == delimiter {
                continue;
            }
            let Some(last) = lines.iter().rev().find(|line| !line.trim().is_empty()) else {
                continue;
            };
            let width = split(last, delimiter).len();
            let numeric = |line: &&str| {
                let fields = split(line, delimiter);
                let numbers = fields.iter().filter(|f| is_number(f, decimal)).count();
                fields.len() == width
                    && fields.iter().any(|f| !f.is_empty())
                    && 2 * numbers > fields.len()
                    && is_number(&fields[0], decimal)
            };
            let rows = lines.iter().copied().filter(numeric).count();
            let numbers: usize = lines
                .iter()
                .copied()
                .filter(numeric)
                .map(|line| {
                    split(line, delimiter)
                        .iter()
                        .filter(|f| !f.is_empty() && is_number(f, decimal))
                        .count()
                })
                .sum();
            // A comma between digits is either; numbers that a dot would make two count as one.
            let score = 2 * numbers + usize::from(decimal == b'.');
            if rows > 0 && width > 1 && score > best.0 {
                let first = lines.iter().position(numeric).unwrap_or(0);
                let header = lines[..first].iter().position(|line| {
                    split(line, delimiter).len() >= width && !line.trim().is_empty()
                });
                // Of several lines of this width the names come first, units below them.
                let header = header.map_or(0, |line| line + 1);
                best = (score, Dialect { delimiter, decimal, header, rows: first + 1 });
            }
        }
    }
    best.1
}

/// A column's values in SI units.
pub(super) fn series(
    columns: &[ProposedColumn],
    raws: &[Raw],
    file: Option<usize>,
    column: usize,
) -> Option<Vec<f64>> {
    let found = columns.iter().find(|c| file.is_none_or(|file| c.file == file) && c.is(column))?;
    let mapping = found.mapping.as_ref().ok()?;
    let raw = &raws[found.file];
    let place = raw.names.iter().position(|name| *name == found.header)?;
    let unit = unit_named(mapping.unit)?.factor;
    let value = |v: &f64| unit * (mapping.factor * v + mapping.offset);
    Some(raw.values[place].as_ref()?.iter().map(value).collect())
}

pub(super) fn file_of(columns: &[ProposedColumn], column: usize) -> Option<usize> {
    columns.iter().find(|c| c.is(column)).map(|c| c.file)
}

pub(super) fn proposed_file(raw: &Raw) -> ProposedFile {
    let dialect = raw.entry.dialect;
    ProposedFile {
        path: raw.entry.path.clone(),
        topic: raw.entry.topic.clone(),
        text: raw.text,
        delimiter: char::from(dialect.delimiter),
        decimal: char::from(dialect.decimal),
        header: dialect.header,
        first_row: dialect.rows,
        rows: raw.rows,
        period: None,
        clock: None,
        fitted: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_form_of_a_text_file_is_found() {
        let german = b"Messung 12\nZeit;A1;A2\nms;Grad;Grad\n0,0;1,25;-90,5\n4,0;1,26;-90,4\n";
        let found = sniff(german);
        assert_eq!((found.delimiter, found.decimal, found.header, found.rows), (b';', b',', 2, 4));
        let plain = b"t_s,qe1_rad\n0.0,1.5\n0.1,1.6\n0.2,1.7\n";
        assert_eq!(sniff(plain), Dialect::PLAIN);
        let bare = b"0.0\t1.5\t2\n0.1\t1.6\t3\n0.2\t1.7\t4\n";
        let found = sniff(bare);
        assert_eq!((found.delimiter, found.header, found.rows), (b'\t', 0, 1));
    }
}
