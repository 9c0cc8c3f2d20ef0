//! Arrays of NumPy: `*.npy`, and several of them in a zip archive, `*.npz`.
//!
//! ```text
//! \x93NUMPY  version  length of the header
//! {'descr': '<f8', 'fortran_order': False, 'shape': (200, 7), }     or, of columns with names,
//! {'descr': [('t', '<f8'), ('q', '<f8', (6,))], … 'shape': (200,), }
//! numbers
//! ```
//!
//! Times (`<M8[ns]`) are read in seconds. Left out: complex numbers, text, and Python's objects.

use super::arrays::{ARRAY_BYTES_MAX, ColumnIndex, NamedArray, open_table, topics};
use super::blocks::damaged;
use super::format::FormatReader;
use super::rows::{MOST_COLUMNS, ROW_FILE_BYTES_MAX};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use trueweld_plant::input::{InputError, open};
use zip::ZipArchive;
use zip::result::ZipError;

/// How a single array is read.
pub(super) const NPY: FormatReader = FormatReader {
    open: |entry| {
        let name = entry.path.display().to_string();
        let arrays = read_npy(&entry.path)?;
        open_table(name, &arrays, ColumnIndex::Square, entry.topic.as_deref(), NUMPY_HELP)
    },
    topics: None,
};

/// How an archive of arrays is read.
pub(super) const NPZ: FormatReader = FormatReader {
    open: |entry| {
        let name = entry.path.display().to_string();
        let arrays = read_npz(&entry.path)?;
        open_table(name, &arrays, ColumnIndex::Square, entry.topic.as_deref(), NUMPY_HELP)
    },
    topics: Some(|path| Ok(topics(&read_npz(path)?, ColumnIndex::Square))),
};

/// What is said of a file that cannot be read.
const NUMPY_HELP: &str = "Write arrays of numbers, with as many rows as there are samples: numpy.savez(\"log.npz\", t=t, q=q).";

/// Most bytes of a header: a name a column.
const NPY_HEADER_BYTES_MAX: usize = 1 << 20;

/// Most bytes of one value: of a text, as numbers have eight.
const NPY_VALUE_BYTES_MAX: usize = 1 << 20;

/// Most levels of lists in a header.
const NPY_HEADER_DEPTH_MAX: usize = 8;

fn read_npy(path: &Path) -> Result<Vec<NamedArray>, InputError> {
    let input = BufReader::new(open(path, ROW_FILE_BYTES_MAX)?);
    array(String::new(), input)
        .map_err(|message| damaged(&path.display().to_string(), message, NUMPY_HELP))
}

fn read_npz(path: &Path) -> Result<Vec<NamedArray>, InputError> {
    let name = path.display().to_string();
    let input = BufReader::new(open(path, ROW_FILE_BYTES_MAX)?.into_file());
    let failed =
        |error: ZipError| damaged(&name, format!("cannot be unpacked: {error}"), NUMPY_HELP);
    let mut archive = ZipArchive::new(input).map_err(failed)?;
    let members = archive.file_names().map(|member| member.map(|name| name.into_owned()));
    let members: Vec<String> = members.collect::<Result<_, _>>().map_err(failed)?;
    if !members.iter().any(|member| member.ends_with(".npy")) {
        return Err(other_archive(&name, &members));
    }
    let (mut arrays, mut held): (Vec<NamedArray>, usize) = (Vec::new(), 0);
    for place in 0..archive.len() {
        let more = member(&mut archive, place);
        let more = more.map_err(|message| damaged(&name, message, NUMPY_HELP))?;
        held += more.iter().map(|array| size_of_val(&array.values[..])).sum::<usize>();
        arrays.extend(more);
        if held as u64 > ARRAY_BYTES_MAX {
            let message = format!("its arrays take more than {ARRAY_BYTES_MAX} bytes together");
            return Err(damaged(&name, message, NUMPY_HELP));
        }
    }
    Ok(arrays)
}

/// The arrays of one file in an archive.
fn member(
    archive: &mut ZipArchive<BufReader<File>>,
    place: usize,
) -> Result<Vec<NamedArray>, String> {
    let failed = |error: ZipError| format!("cannot be unpacked: {error}");
    let file = archive.by_index(place).map_err(failed)?;
    let name = file.name().map_err(failed)?;
    let name = name.strip_suffix(".npy").unwrap_or(&name).to_owned();
    array(name.clone(), file)
        .map_err(|message| format!("array `{}`: {message}", name.escape_debug()))
}

/// An archive of something else: a workbook is one.
fn other_archive(name: &str, members: &[String]) -> InputError {
    let (what, help) = if members.iter().any(|member| member.starts_with("xl/")) {
        ("a workbook (.xlsx)", "Save the sheet with the samples as CSV.")
    } else {
        ("a zip archive without NumPy's arrays", "Unpack it, and give the files with the samples.")
    };
    damaged(name, format!("this is {what}; expected samples"), help)
}

/// The type of a number in a file.
#[derive(Debug, Clone, Copy, PartialEq)]
struct NumberType {
    /// `f`, `i`, `u`, `b`, `M`, or one that is not read.
    kind: char,
    bytes: usize,
    big: bool,
    /// What one is.
    factor: f64,
}

/// A column of records, or all numbers of an array.
struct Field {
    name: String,
    number: NumberType,
    /// Numbers in each record.
    width: usize,
}

/// Reads an array, or several of one with named columns.
fn array(name: String, mut input: impl Read) -> Result<Vec<NamedArray>, String> {
    let ends = |_| "it ends within its header".to_owned();
    let mut start = [0; 8];
    input.read_exact(&mut start).map_err(ends)?;
    let mut length = [0; 4];
    let size = if start[6] == 1 { 2 } else { 4 };
    input.read_exact(&mut length[..size]).map_err(ends)?;
    let length = u32::from_le_bytes(length) as usize;
    if !start.starts_with(b"\x93NUMPY") || length > NPY_HEADER_BYTES_MAX {
        return Err("it has no header of NumPy".to_owned());
    }
    let mut header = vec![0; length];
    input.read_exact(&mut header).map_err(ends)?;
    let header = Literal::read(&header).ok_or("its header is none of NumPy")?;
    let shape = header.shape().ok_or("its header states no shape")?;
    let fields = header.fields(&name)?;
    let by_rows = header.get("fortran_order") != Some(&Literal::True);
    let record: usize = fields.iter().map(|field| field.width * field.number.bytes).sum();
    if record == 0 {
        return Err("its header states no numbers".to_owned());
    }
    // Every number takes eight bytes as it is held.
    let held = record.max(fields.iter().map(|field| field.width * size_of::<f64>()).sum());
    let count = shape.iter().try_fold(1usize, |all, n| all.checked_mul(*n));
    let most = count.and_then(|count| count.checked_mul(held)).map(|bytes| bytes as u64);
    let Some(bytes) =
        most.filter(|bytes| *bytes <= ARRAY_BYTES_MAX).and_then(|_| Some((count? * record) as u64))
    else {
        return Err(format!("it is larger than {ARRAY_BYTES_MAX} bytes"));
    };
    let mut data = Vec::new();
    let cannot = |error| format!("cannot be read: {error}");
    // Grows with what is there, not with what the header says.
    input.by_ref().take(bytes).read_to_end(&mut data).map_err(cannot)?;
    if data.len() as u64 != bytes {
        return Err(format!("it has {} bytes of numbers; its header says {bytes}", data.len()));
    }
    // At its end an archive compares what was read with its checksum.
    if input.read(&mut [0]).map_err(cannot)? > 0 {
        return Err("it goes on behind its numbers; expected one array a file".to_owned());
    }
    let mut arrays = Vec::with_capacity(fields.len());
    let mut at = 0;
    for field in &fields {
        let size = field.width * field.number.bytes;
        let of = |record: &[u8]| field.number.values(&record[at..at + size]);
        let values: Vec<f64> = data.chunks_exact(record).flat_map(of).collect();
        // A single number, a vector, a table; as many numbers in a record as the table is wide.
        let whole = match shape[..] {
            [] => Some([1, field.width]),
            [n] => Some([n, field.width]),
            [n, m] if field.width == 1 => Some([n, m]),
            _ => None,
        };
        let readable = field.number.is_read() && values.len() == count.unwrap_or(0) * field.width;
        arrays.push(match whole.filter(|_| readable) {
            Some(_) => NamedArray { name: field.name.clone(), shape: whole, by_rows, values },
            None => NamedArray::unread(field.name.clone()),
        });
        at += size;
    }
    Ok(arrays)
}

/// A unit of NumPy's times, s, as `ns` or `10ms`; `None` of months and years, which have no length.
fn unit_of_time(name: &str) -> Option<f64> {
    let unit = name.trim_start_matches(|c: char| c.is_ascii_digit());
    let count = &name[..name.len() - unit.len()];
    let count: f64 = if count.is_empty() { 1.0 } else { count.parse().ok()? };
    let one = match unit {
        "W" => 604_800.0,
        "D" => 86_400.0,
        "h" => 3600.0,
        "m" => 60.0,
        "s" => 1.0,
        "ms" => 1e-3,
        "us" => 1e-6,
        "ns" => 1e-9,
        "ps" => 1e-12,
        "fs" => 1e-15,
        "as" => 1e-18,
        _ => return None,
    };
    Some(count * one)
}

impl NumberType {
    /// By its name, as `<f8`; `None` where it is no type, or a time without a length.
    fn named(name: &str) -> Option<Self> {
        let big = name.starts_with('>');
        let rest = name.trim_start_matches(['<', '>', '|', '=']);
        let (kind, size) = (rest.chars().next()?, rest.get(1..)?);
        let (size, unit) = size.split_once('[').unwrap_or((size, ""));
        let bytes: usize = size.parse().ok()?;
        let factor = if kind == 'M' { unit_of_time(unit.trim_end_matches(']'))? } else { 1.0 };
        // Text is in four bytes a letter.
        let bytes = bytes.checked_mul(if kind == 'U' { 4 } else { 1 })?;
        (bytes <= NPY_VALUE_BYTES_MAX).then_some(())?;
        Some(Self { kind, bytes, big, factor })
    }

    fn is_read(self) -> bool {
        matches!(
            (self.kind, self.bytes),
            ('f', 4 | 8) | ('i' | 'u', 1 | 2 | 4 | 8) | ('b', 1) | ('M', 8)
        )
    }

    /// Numbers, one after the other; none where the type is not read.
    fn values(self, bytes: &[u8]) -> Vec<f64> {
        if !self.is_read() {
            return Vec::new();
        }
        bytes.chunks_exact(self.bytes).map(|bytes| self.value(bytes)).collect()
    }

    fn value(self, bytes: &[u8]) -> f64 {
        let mut whole = [0; 8];
        for (k, byte) in bytes.iter().enumerate() {
            whole[if self.big { bytes.len() - 1 - k } else { k }] = *byte;
        }
        let number = u64::from_le_bytes(whole);
        // Moves the sign to the front and back.
        let shift = 64 - 8 * bytes.len() as u32;
        let signed = ((number << shift) as i64) >> shift;
        match (self.kind, self.bytes) {
            ('f', 4) => f64::from(f32::from_bits(number as u32)),
            ('f', _) => f64::from_bits(number),
            // No time is i64's least.
            ('M', _) if signed == i64::MIN => f64::NAN,
            ('M', _) => self.factor * signed as f64,
            ('i', _) => signed as f64,
            _ => number as f64,
        }
    }
}

/// A value as Python writes it.
#[derive(Debug, Clone, PartialEq)]
enum Literal {
    Text(String),
    Number(usize),
    True,
    False,
    /// A tuple or a list.
    List(Vec<Literal>),
    /// Keys and values of a dictionary, one after the other.
    Entries(Vec<Literal>),
}

impl Literal {
    /// Reads the header of an array.
    fn read(bytes: &[u8]) -> Option<Self> {
        let text = std::str::from_utf8(bytes).ok()?;
        let mut rest = text;
        Self::parse(&mut rest, 0).filter(|_| rest.trim_end().is_empty())
    }

    fn parse(rest: &mut &str, depth: usize) -> Option<Self> {
        *rest = rest.trim_start();
        let first = rest.chars().next()?;
        match first {
            '\'' | '"' => {
                let (text, after) = rest[1..].split_once(first)?;
                *rest = after;
                Some(Self::Text(text.to_owned()))
            }
            '(' | '[' | '{' if depth < NPY_HEADER_DEPTH_MAX => {
                *rest = &rest[1..];
                let mut all = Vec::new();
                loop {
                    *rest = rest.trim_start_matches([' ', ',', ':', '\n']);
                    if let Some(after) = rest.strip_prefix([')', ']', '}']) {
                        *rest = after;
                        break;
                    }
                    all.push(Self::parse(rest, depth + 1)?);
                }
                Some(if first == '{' { Self::Entries(all) } else { Self::List(all) })
            }
            _ => {
                let end = rest.find(|c: char| !c.is_alphanumeric()).unwrap_or(rest.len());
                let (word, after) = rest.split_at(end);
                *rest = after;
                match word {
                    "True" => Some(Self::True),
                    "False" => Some(Self::False),
                    _ => word.parse().ok().map(Self::Number),
                }
            }
        }
    }

    fn get(&self, key: &str) -> Option<&Self> {
        let Self::Entries(entries) = self else { return None };
        let mut pairs = entries.chunks_exact(2);
        pairs.find(|pair| matches!(&pair[0], Self::Text(text) if text == key)).map(|pair| &pair[1])
    }

    fn numbers(&self) -> Option<Vec<usize>> {
        let Self::List(all) = self else { return None };
        let number = |literal: &Self| match literal {
            Self::Number(number) => Some(*number),
            _ => None,
        };
        all.iter().map(number).collect()
    }

    fn shape(&self) -> Option<Vec<usize>> {
        self.get("shape")?.numbers()
    }

    /// The columns of records, or one of all numbers.
    fn fields(&self, array: &str) -> Result<Vec<Field>, String> {
        let unknown = || "its header states no type of number".to_owned();
        match self.get("descr").ok_or_else(unknown)? {
            Self::Text(name) => Ok(vec![Field::of(array.to_owned(), name, 1)?]),
            Self::List(fields) if fields.len() <= MOST_COLUMNS => {
                let prefix = if array.is_empty() { String::new() } else { format!("{array}.") };
                let field = |field: &Self| {
                    let Self::List(parts) = field else { return Err(unknown()) };
                    let (name, number, width) = match &parts[..] {
                        [Self::Text(name), Self::Text(number)] => (name, number, Some(1)),
                        [Self::Text(name), Self::Text(number), shape] => {
                            let count = |all: usize, n: &usize| all.checked_mul(*n);
                            let width = shape.numbers().and_then(|s| s.iter().try_fold(1, count));
                            (name, number, width)
                        }
                        _ => return Err(unknown()),
                    };
                    let width = width.filter(|width| *width <= MOST_COLUMNS).ok_or_else(unknown)?;
                    Field::of(format!("{prefix}{name}"), number, width)
                };
                fields.iter().map(field).collect()
            }
            _ => Err(unknown()),
        }
    }
}

impl Field {
    fn of(name: String, number: &str, width: usize) -> Result<Self, String> {
        if number.trim_start_matches(['<', '>', '|', '=']).starts_with('O') {
            return Err("it holds Python's objects; expected numbers".to_owned());
        }
        let Some(number) = NumberType::named(number) else {
            return Err(format!("its numbers are of the type {number:?}, which is not known"));
        };
        Ok(Self { name, number, width })
    }
}
