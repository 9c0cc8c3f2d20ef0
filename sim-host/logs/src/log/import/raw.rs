//! How a file is written, by its first lines, and the numbers of its first rows.

use super::proposal::{ProposedColumn, ProposedFile};
use crate::channel::LogChannel;
use crate::log::columns::{MAPPABLE_COLUMNS, TIME_COLUMN};
use crate::log::computed::sketch;
use crate::log::files::FileEntry;
use crate::log::rows::{ROW_FILE_BYTES_MAX, RowSource};
use crate::log::sentinel::{is_apart, is_sentinel};
use crate::log::source;
use crate::log::text::{Dialect, SEPARATORS, decoded, is_missing};
use crate::log::time_of_day::{Midnights, seconds};
use crate::log::track::{FileTrack, WRITTEN};
use crate::log::units::{Unit, unit_named};
use std::io::Read;
use trueweld_plant::input::{InputError, open};

/// Rows that a proposal looks at.
const LOOKED_AT: usize = 200_000;

/// Bytes at a file's start from which its form is told.
const SNIFFED: u64 = 1 << 16;

pub(super) const ENCODER_COLUMN: usize = LogChannel::Encoder.columns().start;
pub(super) const TORQUE: usize = LogChannel::MotorTorque.columns().start;
pub(super) const POSITION: usize = LogChannel::Position.columns().start;

/// A file's numbers.
pub(super) struct Raw {
    pub(super) entry: FileEntry,
    pub(super) text: bool,
    pub(super) names: Vec<String>,
    /// What names each column: its header, or what a comment calls it.
    pub(super) titles: Vec<String>,
    /// Units that stand in a row below the header.
    pub(super) units: Vec<Option<&'static Unit>>,
    /// NaN where it is no number; `None` for a column without any.
    pub(super) values: Vec<Option<Vec<f64>>>,
    /// Numbers that stand for none: which, and in how many rows.
    pub(super) sentinels: Vec<Option<(f64, usize)>>,
    pub(super) rows: usize,
    /// Period of the rows where it was stated, s.
    pub(super) period: Option<f64>,
    /// Decimals that each column is written with.
    decimals: Vec<i32>,
}

#[cfg(test)]
impl Raw {
    /// Columns with these headers and values.
    pub(super) fn of_values(
        entry: FileEntry,
        names: Vec<String>,
        values: Vec<Option<Vec<f64>>>,
    ) -> Self {
        let rows = values.first().and_then(Option::as_ref).map_or(0, Vec::len);
        let (units, decimals) = (vec![None; names.len()], vec![0; names.len()]);
        let (titles, sentinels) = (names.clone(), vec![None; names.len()]);
        Self {
            entry,
            text: true,
            titles,
            names,
            units,
            values,
            sentinels,
            rows,
            period: None,
            decimals,
        }
    }
}

/// Reads a file's first rows, having found out how it is written.
pub(super) fn read(mut entry: FileEntry) -> Result<Raw, InputError> {
    let mut start = Vec::new();
    let sniffed = open(&entry.path, ROW_FILE_BYTES_MAX)?.take(SNIFFED).read_to_end(&mut start);
    let text = sniffed.is_ok() && looks_like_text(&start);
    let mut sniffed = Sniffed::default();
    if text {
        sniffed = sniff(&start);
        entry.dialect = sniffed.dialect;
    }
    let mut rows: Box<dyn RowSource> = source::open(&entry)?;
    let names: Vec<String> = rows.names().to_vec();
    let mut titles = names.clone();
    for (column, title) in sniffed.titles {
        if let Some(own) = titles.get_mut(column) {
            *own = title;
        }
    }
    let unit = |column: usize| sniffed.units.get(column).and_then(|text| unit_named(text));
    let mut units: Vec<Option<&'static Unit>> = (0..names.len()).map(unit).collect();
    let mut values: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); names.len()];
    let mut decimals = vec![0; names.len()];
    let mut midnights: Vec<Midnights> = Vec::new();
    midnights.resize_with(names.len(), Midnights::default);
    let mut count = 0;
    while count < LOOKED_AT && rows.advance()? {
        for (column, values) in values.iter_mut().enumerate() {
            if let Some(values) = values {
                let mut value = rows.value(column);
                if value.is_none() {
                    // A time of day is read in seconds.
                    value = rows.time(column).map(|time| midnights[column].continued(time));
                    units[column] = value.and(unit_named("s")).or(units[column]);
                }
                values.push(value.unwrap_or(f64::NAN));
            }
        }
        if count < WRITTEN {
            for (column, decimals) in decimals.iter_mut().enumerate() {
                *decimals = rows.decimals(column).max(*decimals);
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
    let sentinels =
        values.iter_mut().map(|values| leave_out_sentinels(values.as_deref_mut()?)).collect();
    Ok(Raw {
        entry,
        text,
        names,
        titles,
        units,
        values,
        sentinels,
        rows: count,
        period: None,
        decimals,
    })
}

/// Leaves out numbers that stand for none: the last of them, and how many there are.
fn leave_out_sentinels(values: &mut [f64]) -> Option<(f64, usize)> {
    let others: Vec<f64> = values.iter().copied().filter(|value| !is_sentinel(*value)).collect();
    let is_none = |value: &&mut f64| is_sentinel(**value) && is_apart(**value, &others);
    let mut found = None;
    for value in values.iter_mut().filter(is_none) {
        found = Some((*value, found.map_or(1, |(_, count)| count + 1)));
        *value = f64::NAN;
    }
    found
}

fn looks_like_text(start: &[u8]) -> bool {
    let binary = start.iter().filter(|b| **b < 9 || (14..32).contains(*b)).count();
    binary == 0 && source::format_of(start).is_none()
}

/// How a text file is written, and what stands above its rows.
#[derive(Default)]
struct Sniffed {
    dialect: Dialect,
    /// The fields of a row of units.
    units: Vec<String>,
    /// What a comment calls columns without a header.
    titles: Vec<(usize, String)>,
}

/// How a text file is written, by its first lines.
fn sniff(start: &[u8]) -> Sniffed {
    let text = decoded(start);
    let mut lines: Vec<&str> = text.lines().collect();
    // The last one may be cut.
    if lines.len() > 2 {
        lines.pop();
    }
    let mut best = (0, Dialect::PLAIN);
    // Rows that begin with a number or a time; where there is none, with anything.
    for any_first in [false, true] {
        for (delimiter, _) in SEPARATORS {
            for decimal in [b'.', b','] {
                if decimal == delimiter || (best.0 > 0 && any_first) {
                    continue;
                }
                let Some(found) = rows_of(&lines, delimiter, decimal, any_first) else { continue };
                // A comma between digits is either; numbers that a dot would make two count as one.
                let score = 2 * found.numbers + usize::from(decimal == b'.');
                if score > best.0 {
                    let dialect = Dialect { delimiter, decimal, header: 0, rows: found.first + 1 };
                    best = (score, dialect);
                }
            }
        }
    }
    let mut found = Sniffed { dialect: best.1, ..Sniffed::default() };
    if best.0 > 0 {
        found.read_header(&lines);
    }
    found
}

/// Fields of a line.
fn split(line: &str, delimiter: u8) -> Vec<String> {
    let fields: Box<dyn Iterator<Item = &str>> = match delimiter {
        b' ' => Box::new(line.split_whitespace()),
        // Many programs end every line with a separator.
        _ => {
            let line = line.strip_suffix(char::from(delimiter)).unwrap_or(line);
            Box::new(line.split(char::from(delimiter)))
        }
    };
    fields.map(|f| f.trim().trim_matches('"').to_owned()).collect()
}

fn is_number(field: &str, decimal: u8) -> bool {
    let dotted = if decimal == b',' { field.replace(',', ".") } else { field.to_owned() };
    is_missing(field.as_bytes()) || dotted.parse::<f64>().is_ok()
}

/// Rows of numbers as one dialect reads them.
struct FoundRows {
    first: usize,
    numbers: usize,
}

fn rows_of(lines: &[&str], delimiter: u8, decimal: u8, any_first: bool) -> Option<FoundRows> {
    let last = lines.iter().rev().find(|line| !line.trim().is_empty())?;
    let width = split(last, delimiter).len();
    let is_value = |field: &str| is_number(field, decimal) || seconds(field).is_some();
    let is_row = |line: &&&str| {
        let fields = split(line, delimiter);
        fields.len() == width
            && fields.iter().any(|f| !f.is_empty())
            && 2 * fields.iter().filter(|f| is_value(f)).count() > fields.len()
            && (any_first || is_value(&fields[0]))
    };
    let first = lines.iter().position(|line| is_row(&line))?;
    let count = |line: &&str| {
        let fields = split(line, delimiter);
        let filled = fields.iter().filter(|f| !is_missing(f.as_bytes()));
        filled.filter(|f| is_number(f, decimal)).count()
    };
    let numbers = lines.iter().filter(is_row).map(count).sum();
    (width > 1 && numbers > 0).then_some(FoundRows { first, numbers })
}

/// The fields of a line of words, at least `width` of them; `None` of a comment or of numbers.
fn words(line: &str, width: usize, dialect: &Dialect) -> Option<Vec<String>> {
    let fields = split(line, dialect.delimiter);
    let filled = || fields.iter().filter(|field| !field.is_empty());
    let numbers = filled().filter(|field| is_number(field, dialect.decimal)).count();
    let is_comment = line.trim_start().starts_with("//");
    let are_words = fields.len() >= width && filled().count() > 2 * numbers;
    (are_words && !is_comment).then_some(fields)
}

impl Sniffed {
    /// Finds the names of the columns: in the last line of words above the rows that is as wide as
    /// they are, or above a row of units.
    fn read_header(&mut self, lines: &[&str]) {
        let (above, below) = lines.split_at(self.dialect.rows - 1);
        let first_row = split(below.first().unwrap_or(&""), self.dialect.delimiter);
        let (dialect, width) = (self.dialect, first_row.len());
        let words = |(k, line): (usize, &&str)| Some((k, words(line, width, &dialect)?));
        let mut named = above.iter().enumerate().rev().filter_map(words);
        let Some((line, fields)) = named.next() else {
            self.read_comment(above, &first_row);
            return;
        };
        let filled = fields.iter().filter(|field| !field.is_empty());
        let units = filled.clone().filter(|field| unit_named(field).is_some()).count();
        self.dialect.header = line + 1;
        if 2 * units > filled.count()
            && let Some((names, _)) = named.next().filter(|(names, _)| names + 1 == line)
        {
            (self.dialect.header, self.units) = (names + 1, fields);
        }
    }

    /// Takes names out of a comment (`// AXES = CARTESIAN: X, Y, Z (mm)`), where it has as many as
    /// columns have decimals.
    fn read_comment(&mut self, above: &[&str], first_row: &[String]) {
        let decimal = self.dialect.decimal;
        let has_decimals =
            |field: &String| field.contains(char::from(decimal)) && is_number(field, decimal);
        let decimals: Vec<usize> =
            (0..first_row.len()).filter(|k| has_decimals(&first_row[*k])).collect();
        for line in above.iter().rev() {
            let listed = line.rsplit([':', '=']).next().unwrap_or_default();
            let (names, unit) = listed.split_once('(').unwrap_or((listed, ""));
            let names: Vec<&str> = names.split([',', ';', '\t']).map(str::trim).collect();
            let unit = unit.trim_end().trim_end_matches(')');
            if names.len() == decimals.len() && names.len() > 1 && unit_named(unit).is_some() {
                let title = |(column, name): (&usize, &str)| (*column, format!("{name} [{unit}]"));
                self.titles = decimals.iter().zip(names).map(title).collect();
                return;
            }
        }
    }
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
    let mut values: Vec<f64> = raw.values[place].as_ref()?.iter().map(value).collect();
    for (other, times) in &mapping.plus {
        let added = series(columns, raws, Some(found.file), *other)?;
        values.iter_mut().zip(added).for_each(|(value, added)| *value += times * added);
    }
    Some(values)
}

/// Times of a file's rows, s: those of its column, or of a period that was stated.
pub(super) fn times(columns: &[ProposedColumn], raws: &[Raw], file: usize) -> Option<Vec<f64>> {
    let raw = &raws[file];
    let counted = |period: f64| (0..raw.rows).map(|k| period * k as f64).collect();
    series(columns, raws, Some(file), TIME_COLUMN).or_else(|| raw.period.map(counted))
}

/// Some rows of a file as they would be read.
pub(super) fn track(columns: &[ProposedColumn], raws: &[Raw], file: usize) -> FileTrack {
    let all = 0..MAPPABLE_COLUMNS;
    let of_column = |column: usize| columns.iter().find(|c| c.file == file && c.is(column));
    let rounding = |column: usize| {
        let mapping = of_column(column)?.mapping.as_ref().ok()?;
        let place = raws[file].names.iter().position(|name| *name == mapping.header)?;
        let unit = unit_named(mapping.unit)?.factor;
        Some(0.5 * 10f64.powi(-raws[file].decimals[place]) * (unit * mapping.factor).abs())
    };
    sketch(&FileTrack {
        clock: None,
        columns: all.clone().map(|column| series(columns, raws, Some(file), column)).collect(),
        rounding: all.map(|column| rounding(column).unwrap_or(0.0)).collect(),
    })
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
        let dialect = found.dialect;
        assert_eq!((dialect.delimiter, dialect.decimal), (b';', b','));
        assert_eq!((dialect.header, dialect.rows), (2, 4));
        assert_eq!(found.units, ["ms", "Grad", "Grad"]);
        let plain = b"t_s,qe1_rad\n0.0,1.5\n0.1,1.6\n0.2,1.7\n";
        assert_eq!(sniff(plain).dialect, Dialect::PLAIN);
        let found = sniff(b"0.0\t1.5\t2\n0.1\t1.6\t3\n0.2\t1.7\t4\n").dialect;
        assert_eq!((found.delimiter, found.header, found.rows), (b'\t', 0, 1));
    }

    /// A preamble that is as wide as the table, as LabVIEW writes it.
    #[test]
    fn the_header_is_the_last_line_of_words_above_the_numbers() {
        let text = "Date\t2024/05/17\nChannels\t3\t\t\t\nX0\t0,0\t0,0\t0,0\t\n***End***\t\t\t\t\n\
                    X_Value\tFx\tFy\tFz\tComment\n\
                    0,000\t0,5\t50,1\t5000,2\t\n0,001\t0,6\t50,2\t5001,2\t\n0,002\t0,6\t50,2\t5001,2\t\n";
        let found = sniff(text.as_bytes()).dialect;
        assert_eq!((found.delimiter, found.decimal), (b'\t', b','));
        assert_eq!((found.header, found.rows), (5, 6));
    }
}
