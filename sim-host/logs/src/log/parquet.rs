//! Parquet files: a column of numbers each, as pandas and others write tables.
//!
//! Row groups are read one after the other, each some thousand rows at a time: what is packed in a
//! few bytes may be long. Times are in seconds where the file says that a column
//! is one. Left out: lists, and compression other than Snappy.

use super::blocks::{BlockRows, Blocks, damaged};
use super::files::FileEntry;
use super::format::FormatReader;
use super::rows::{MOST_COLUMNS, ROW_FILE_BYTES_MAX, RowSource};
use parquet::basic::{ConvertedType, LogicalType, TimeUnit, Type};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{DataType, Int96};
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnDescriptor;
use std::fs::File;
use std::panic::{AssertUnwindSafe, catch_unwind};
use trueweld_plant::input::{InputError, open as open_file};

/// How its files are read.
pub(super) const PARQUET: FormatReader = FormatReader { open: open_parquet, topics: None };

/// Most numbers in a block.
const PARQUET_BLOCK_NUMBERS: usize = 1 << 20;

/// What is said of a file that cannot be read.
const PARQUET_HELP: &str = "Write it anew, with Snappy or no compression and numbers in its columns: df.to_parquet(\"log.parquet\").";

/// A column that holds numbers.
#[derive(Debug, Clone, Copy)]
struct NumberColumn {
    index: usize,
    /// Of the file's number in the value that is read.
    factor: f64,
    unsigned: bool,
    /// The level at which there is a value: below it the column, or what it stands in, lacks one.
    whole: i16,
}

struct Groups {
    name: String,
    reader: SerializedFileReader<File>,
    columns: Vec<NumberColumn>,
    next: usize,
    /// Of the group that is being read: its columns, and the rows that are left.
    open: Vec<ColumnReader>,
    left: usize,
}

/// Opens a file.
fn open_parquet(entry: &FileEntry) -> Result<Box<dyn RowSource>, InputError> {
    let name = entry.path.display().to_string();
    let input = open_file(&entry.path, ROW_FILE_BYTES_MAX)?.into_file();
    let failed = |error: ParquetError| {
        damaged(&name, format!("cannot be read as Parquet: {error}"), PARQUET_HELP)
    };
    let reader = caught(|| SerializedFileReader::new(input)).map_err(failed)?;
    let schema = reader.metadata().file_metadata().schema_descr();
    if schema.num_columns() > MOST_COLUMNS {
        let message =
            format!("has {} columns; expected at most {MOST_COLUMNS}", schema.num_columns());
        return Err(damaged(&name, message, PARQUET_HELP));
    }
    let (mut columns, mut names) = (Vec::new(), Vec::new());
    for (index, column) in schema.columns().iter().enumerate() {
        if let Some(factor) = numbers(column) {
            let (unsigned, whole) = (is_unsigned(column), column.max_def_level());
            columns.push(NumberColumn { index, factor, unsigned, whole });
            names.push(column.path().string());
        }
    }
    if columns.is_empty() {
        let message = "no column holds numbers; expected the samples";
        return Err(damaged(&name, message, PARQUET_HELP));
    }
    let groups = Groups { name: name.clone(), reader, columns, next: 0, open: Vec::new(), left: 0 };
    Ok(Box::new(BlockRows::new(name, names, groups)))
}

/// The factor of a column's numbers; `None` where it holds none, or lists of them.
fn numbers(column: &ColumnDescriptor) -> Option<f64> {
    if column.max_rep_level() > 0 {
        return None;
    }
    match column.physical_type() {
        Type::BYTE_ARRAY | Type::FIXED_LEN_BYTE_ARRAY => None,
        // Older writers state the converted type alone.
        Type::INT64 | Type::INT32 => {
            Some(match (column.logical_type_ref(), column.converted_type()) {
                (Some(LogicalType::Timestamp(time) | LogicalType::Time(time)), _) => {
                    match time.unit {
                        TimeUnit::MILLIS => 1e-3,
                        TimeUnit::MICROS => 1e-6,
                        TimeUnit::NANOS => 1e-9,
                    }
                }
                (_, ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS) => 1e-3,
                (_, ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS) => 1e-6,
                (Some(LogicalType::Decimal(decimal)), _) => 10f64.powi(-decimal.scale),
                (_, ConvertedType::DECIMAL) => 10f64.powi(-column.type_scale()),
                _ => 1.0,
            })
        }
        _ => Some(1.0),
    }
}

fn is_unsigned(column: &ColumnDescriptor) -> bool {
    let by_logical =
        matches!(column.logical_type_ref(), Some(LogicalType::Integer(int)) if !int.is_signed);
    let by_converted = matches!(
        column.converted_type(),
        ConvertedType::UINT_8
            | ConvertedType::UINT_16
            | ConvertedType::UINT_32
            | ConvertedType::UINT_64
    );
    by_logical || by_converted
}

impl Groups {
    fn failed(&self, error: &ParquetError) -> InputError {
        damaged(&self.name, format!("cannot be read as Parquet: {error}"), PARQUET_HELP)
    }

    /// Opens the next group; false at the end of the file.
    fn open_group(&mut self) -> Result<bool, InputError> {
        if self.next >= self.reader.num_row_groups() {
            return Ok(false);
        }
        let group = self.reader.get_row_group(self.next).map_err(|e| self.failed(&e))?;
        self.next += 1;
        let rows = group.metadata().num_rows();
        let Ok(rows) = usize::try_from(rows) else {
            let message = format!("row group {} has {rows} rows", self.next);
            return Err(damaged(&self.name, message, PARQUET_HELP));
        };
        let mut open = Vec::with_capacity(self.columns.len());
        for column in &self.columns {
            // The crate panics on what no writer writes.
            let chunk = group.metadata().column(column.index);
            let places = [chunk.data_page_offset(), chunk.compressed_size()];
            if places.into_iter().chain(chunk.dictionary_page_offset()).any(|place| place < 0) {
                let message = format!("row group {} has a column at a negative place", self.next);
                return Err(damaged(&self.name, message, PARQUET_HELP));
            }
            let reader = caught(|| group.get_column_reader(column.index));
            open.push(reader.map_err(|e| self.failed(&e))?);
        }
        (self.open, self.left) = (open, rows);
        Ok(true)
    }
}

impl Blocks for Groups {
    fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, InputError> {
        while self.left == 0 {
            if !self.open_group()? {
                return Ok(None);
            }
        }
        let rows = self.left.min((PARQUET_BLOCK_NUMBERS / self.columns.len()).max(1));
        self.left -= rows;
        let mut open = std::mem::take(&mut self.open);
        let (mut block, mut ends) = (Vec::with_capacity(open.len()), true);
        for (reader, column) in open.iter_mut().zip(&self.columns) {
            let values = caught(|| match reader {
                ColumnReader::BoolColumnReader(r) => column.read(r, rows, f64::from),
                ColumnReader::Int32ColumnReader(r) => match column.unsigned {
                    true => column.read(r, rows, |v: i32| f64::from(v.cast_unsigned())),
                    false => column.read(r, rows, f64::from),
                },
                ColumnReader::Int64ColumnReader(r) => match column.unsigned {
                    true => column.read(r, rows, |v: i64| v.cast_unsigned() as f64),
                    false => column.read(r, rows, |v: i64| v as f64),
                },
                ColumnReader::Int96ColumnReader(r) => {
                    column.read(r, rows, |v: Int96| v.to_nanos() as f64 * 1e-9)
                }
                ColumnReader::FloatColumnReader(r) => column.read(r, rows, f64::from),
                ColumnReader::DoubleColumnReader(r) => column.read(r, rows, |v: f64| v),
                _ => Ok(Vec::new()),
            });
            let mut values = values.map_err(|e| self.failed(&e))?;
            ends &= values.is_empty();
            values.resize(rows, f64::NAN);
            if column.factor != 1.0 {
                values.iter_mut().for_each(|v| *v *= column.factor);
            }
            block.push(values);
        }
        self.open = open;
        if ends {
            let message = format!("row group {} ends before its rows do", self.next);
            return Err(damaged(&self.name, message, PARQUET_HELP));
        }
        Ok(Some(block))
    }
}

/// What the crate makes of a file. It panics on some that no writer writes, as on a page that
/// refers to a dictionary which is not there.
fn caught<T>(work: impl FnOnce() -> Result<T, ParquetError>) -> Result<T, ParquetError> {
    let damaged = |_| Err(ParquetError::General("it contradicts itself".to_owned()));
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(damaged)
}

impl NumberColumn {
    /// The next values in a group, at most so many; NaN where one is missing.
    fn read<T: DataType>(
        &self,
        reader: &mut ColumnReaderImpl<T>,
        rows: usize,
        number: impl Fn(T::T) -> f64,
    ) -> Result<Vec<f64>, ParquetError> {
        let mut out: Vec<f64> = Vec::new();
        let (mut levels, mut values) = (Vec::new(), Vec::new());
        while out.len() < rows {
            levels.clear();
            values.clear();
            let most = rows - out.len();
            let (records, _, count) =
                reader.read_records(most, Some(&mut levels), None, &mut values)?;
            if records == 0 && count == 0 {
                break;
            }
            if levels.is_empty() {
                out.extend(values.drain(..).map(&number));
                continue;
            }
            let mut found = values.drain(..);
            let of = |level: &i16| match *level == self.whole {
                true => found.next().map_or(f64::NAN, &number),
                false => f64::NAN,
            };
            out.extend(levels.iter().map(of));
        }
        Ok(out)
    }
}
