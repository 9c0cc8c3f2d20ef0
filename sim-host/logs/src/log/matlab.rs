//! MAT files of MATLAB from version 5 to 7: arrays by their names, packed or not.
//!
//! ```text
//! 116 bytes of text, 8 of offsets, version, IM or MI
//! elements: type, length, data       of at most 4 bytes: length and type in 4 bytes, data in 4
//!   matrix: flags (class), dimensions, name, numbers; of a structure its fields, each a matrix
//!   packed: zlib, of one element
//! ```
//!
//! A field of a structure is named `STRUCTURE.FIELD`. Left out: cells, text, objects such as
//! time series, sparse and complex arrays, and structures that are arrays themselves.

use super::arrays::{ARRAY_BYTES_MAX, ColumnIndex, NamedArray, open_table, topics};
use super::blocks::damaged;
use super::format::FormatReader;
use super::rows::ROW_FILE_BYTES_MAX;
use flate2::read::ZlibDecoder;
use std::io::Read;
use std::path::Path;
use trueweld_plant::input::{InputError, open};

/// How its files are read.
pub(super) const MAT: FormatReader = FormatReader {
    open: |entry| {
        let name = entry.path.display().to_string();
        let arrays = read_mat(&entry.path)?;
        open_table(name, &arrays, ColumnIndex::Round, entry.topic.as_deref(), MAT_HELP)
    },
    topics: Some(|path| Ok(topics(&read_mat(path)?, ColumnIndex::Round))),
};

/// What is said of a file that cannot be read.
const MAT_HELP: &str = "Save arrays of numbers, with as many rows as there are samples: save(\"log.mat\", \"t\", \"q\", \"-v7\"). \
                        Of a time series save ts.Time and ts.Data.";

/// Bytes of a file's header.
const MAT_HEADER_BYTES: usize = 128;

/// Most structures within structures.
const STRUCTURE_DEPTH_MAX: usize = 8;

/// Types of elements, by their numbers in the file.
const COMPRESSED: u32 = 15;
const MATRIX_ELEMENT: u32 = 14;

fn read_mat(path: &Path) -> Result<Vec<NamedArray>, InputError> {
    let name = path.display().to_string();
    let mut bytes = Vec::new();
    let read = open(path, ROW_FILE_BYTES_MAX)?.read_to_end(&mut bytes);
    read.map_err(|error| damaged(&name, format!("cannot be read: {error}"), MAT_HELP))?;
    let big = bytes.get(126..MAT_HEADER_BYTES) == Some(b"MI");
    let mut elements = Elements { bytes: bytes.get(MAT_HEADER_BYTES..).unwrap_or(&[]), big };
    let mut arrays = Vec::new();
    let ends = || damaged(&name, "it ends within an array", MAT_HELP);
    while !elements.bytes.is_empty() {
        let (kind, data) = elements.next().ok_or_else(ends)?;
        if kind != COMPRESSED {
            matrix_element(kind, data, big, &mut arrays).ok_or_else(ends)?;
            continue;
        }
        let mut unpacked = Vec::new();
        let read = ZlibDecoder::new(data).take(ARRAY_BYTES_MAX).read_to_end(&mut unpacked);
        read.map_err(|error| {
            damaged(&name, format!("an array cannot be unpacked: {error}"), MAT_HELP)
        })?;
        let (kind, data) = Elements { bytes: &unpacked, big }.next().ok_or_else(ends)?;
        matrix_element(kind, data, big, &mut arrays).ok_or_else(ends)?;
    }
    Ok(arrays)
}

/// The elements of a file or of one of them.
#[derive(Clone, Copy)]
struct Elements<'b> {
    bytes: &'b [u8],
    big: bool,
}

impl<'b> Elements<'b> {
    /// Type and data of the next one; `None` where it is not whole.
    fn next(&mut self) -> Option<(u32, &'b [u8])> {
        let word = |at: usize| -> Option<u32> {
            let bytes = self.bytes.get(at..at + 4)?.try_into().ok()?;
            Some(if self.big { u32::from_be_bytes(bytes) } else { u32::from_le_bytes(bytes) })
        };
        let first = word(0)?;
        // Of at most four bytes.
        if first >> 16 != 0 {
            let data = self.bytes.get(4..4 + (first >> 16) as usize).filter(|d| d.len() <= 4)?;
            self.bytes = self.bytes.get(8..).unwrap_or(&[]);
            return Some((first & 0xffff, data));
        }
        let length = word(4)? as usize;
        let data = self.bytes.get(8..8usize.checked_add(length)?)?;
        // Packed elements alone are not filled up to a multiple of 8.
        let end = if first == COMPRESSED { 8 + length } else { 8 + length.next_multiple_of(8) };
        self.bytes = self.bytes.get(end..).unwrap_or(&[]);
        Some((first, data))
    }

    /// Whole numbers of the next one.
    fn integers(&mut self) -> Option<Vec<i32>> {
        let (_, data) = self.next()?;
        let of = |bytes: &[u8]| {
            let bytes = bytes.try_into().unwrap_or_default();
            if self.big { i32::from_be_bytes(bytes) } else { i32::from_le_bytes(bytes) }
        };
        Some(data.chunks_exact(4).map(of).collect())
    }

    fn text(&mut self) -> Option<String> {
        Some(String::from_utf8_lossy(self.next()?.1).trim_end_matches('\0').to_owned())
    }
}

/// Takes the arrays of one element of the file; `None` where it is not whole.
fn matrix_element(kind: u32, data: &[u8], big: bool, arrays: &mut Vec<NamedArray>) -> Option<()> {
    if kind != MATRIX_ELEMENT {
        return Some(());
    }
    matrix(Elements { bytes: data, big }, None, arrays, 0)
}

/// Takes a matrix, named by itself or as a field of a structure, or the fields of one.
fn matrix(
    mut parts: Elements<'_>,
    field: Option<String>,
    arrays: &mut Vec<NamedArray>,
    depth: usize,
) -> Option<()> {
    if parts.bytes.is_empty() {
        // An empty field.
        return Some(());
    }
    let flags = *parts.integers()?.first()?;
    let dimensions = parts.integers()?;
    let own = parts.text()?;
    let name = field.unwrap_or(own);
    let shape = match dimensions[..] {
        [rows, columns] => [rows, columns].map(|n| usize::try_from(n).ok()),
        _ => [None; 2],
    };
    let is_complex = flags & 0x800 != 0;
    match (flags & 0xff, shape) {
        // A structure.
        (2, [Some(1), Some(1)]) if depth < STRUCTURE_DEPTH_MAX => {
            let length = usize::try_from(*parts.integers()?.first()?).ok().filter(|n| *n > 0)?;
            let (_, names) = parts.next()?;
            for field in names.chunks_exact(length) {
                let field = field.split(|byte| *byte == 0).next().unwrap_or_default();
                let (_, data) = parts.next()?;
                let inner = Elements { bytes: data, big: parts.big };
                let field = format!("{name}.{}", String::from_utf8_lossy(field));
                matrix(inner, Some(field), arrays, depth + 1)?;
            }
        }
        // Doubles, singles, and whole numbers of 8 to 64 bits.
        (6..=15, [Some(rows), Some(columns)]) if !is_complex => {
            let count = rows.checked_mul(columns)?;
            let (kind, data) = parts.next()?;
            let values = numbers(kind, data, parts.big)?;
            if values.len() != count {
                return None;
            }
            let shape = Some([rows, columns]);
            arrays.push(NamedArray { name, shape, by_rows: false, values });
        }
        // What objects keep beside them has no name.
        _ if name.is_empty() => {}
        _ => arrays.push(NamedArray::unread(name)),
    }
    Some(())
}

/// Numbers as they are stored, which may be in fewer bytes than the array's class.
fn numbers(kind: u32, data: &[u8], big: bool) -> Option<Vec<f64>> {
    fn all<const N: usize>(data: &[u8], big: bool, of: impl Fn([u8; N]) -> f64) -> Vec<f64> {
        let value = |bytes: &[u8]| {
            let mut bytes: [u8; N] = bytes.try_into().unwrap_or([0; N]);
            if big {
                bytes.reverse();
            }
            of(bytes)
        };
        data.chunks_exact(N).map(value).collect()
    }
    Some(match kind {
        1 => all(data, big, |b: [u8; 1]| f64::from(b[0] as i8)),
        2 => all(data, big, |b: [u8; 1]| f64::from(b[0])),
        3 => all(data, big, |b| f64::from(i16::from_le_bytes(b))),
        4 => all(data, big, |b| f64::from(u16::from_le_bytes(b))),
        5 => all(data, big, |b| f64::from(i32::from_le_bytes(b))),
        6 => all(data, big, |b| f64::from(u32::from_le_bytes(b))),
        7 => all(data, big, |b| f64::from(f32::from_le_bytes(b))),
        9 => all(data, big, f64::from_le_bytes),
        12 => all(data, big, |b| i64::from_le_bytes(b) as f64),
        13 => all(data, big, |b| u64::from_le_bytes(b) as f64),
        _ => return None,
    })
}
