//! Every sample of a result as one table for other programs: CSV, or Parquet where the file's name
//! ends so. SI units, the unit at the end of a column's name or in a column of its own.

mod measured;
#[cfg(feature = "parquet")]
mod parquet;
mod simulated;
mod study;

pub(crate) use measured::of_logs;
pub(crate) use simulated::{of_laws, of_runs, of_trials};
pub(crate) use study::{of_layout, of_study};

use crate::OutputError;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use trueweld_plant::input::write_atomically_with;

/// A table that is made block by block, while it is written: none need fit into memory as a whole.
pub struct BlockTable<'a> {
    columns: Vec<SampleColumn>,
    blocks: Box<dyn Iterator<Item = SampleBlock<'a>> + 'a>,
}

/// Every sample of a result in memory: columns by name, all of one length.
#[derive(Debug, Clone, PartialEq)]
pub struct CollectedSamples {
    /// Name, with the unit at its end, and values.
    pub columns: Vec<(String, SampleValues)>,
}

/// The values of a column.
#[derive(Debug, Clone, PartialEq)]
pub enum SampleValues {
    /// NaN where there is none.
    Numbers(Vec<f64>),
    /// Words.
    Words(SampleWords),
}

/// A column of words, most of which stand in many rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SampleWords {
    /// Each word once.
    pub words: Vec<String>,
    /// The word of each row, by its place in `words`.
    pub rows: Vec<i32>,
}

impl SampleWords {
    /// A column of these words.
    pub fn of(words: &[String]) -> Self {
        let mut column = Self::default();
        for word in words {
            let code = column.code(word);
            column.rows.push(code);
        }
        column
    }

    fn extend(&mut self, values: &ColumnValues<'_>, rows: usize) {
        if let ColumnValues::Word(word) = values {
            let code = self.code(word);
            self.rows.resize(self.rows.len() + rows, code);
            return;
        }
        for row in 0..rows {
            let code = self.code(values.word(row));
            self.rows.push(code);
        }
    }

    /// The place of a word, which is added where it is new. The last word is the likeliest.
    fn code(&mut self, word: &str) -> i32 {
        if let Some(last) = self.rows.last().filter(|last| self.words[**last as usize] == word) {
            return *last;
        }
        let known = self.words.iter().position(|known| known == word).unwrap_or_else(|| {
            self.words.push(word.to_owned());
            self.words.len() - 1
        });
        i32::try_from(known).unwrap_or(i32::MAX)
    }
}

/// A column of all blocks.
struct SampleColumn {
    name: String,
    /// Words, or numbers.
    words: bool,
}

/// Some rows, column by column.
type SampleBlock<'a> = Vec<ColumnValues<'a>>;

/// The values of a column in one block.
enum ColumnValues<'a> {
    /// NaN where there is none.
    Numbers(Vec<f64>),
    /// Numbers of somebody else.
    Borrowed(&'a [f64]),
    Words(Vec<Cow<'a, str>>),
    /// The same word in every row.
    Word(&'a str),
}

impl ColumnValues<'_> {
    fn numbers(&self) -> &[f64] {
        match self {
            Self::Numbers(values) => values,
            Self::Borrowed(values) => values,
            Self::Words(_) | Self::Word(_) => &[],
        }
    }

    fn word(&self, row: usize) -> &str {
        match self {
            Self::Words(words) => &words[row],
            Self::Word(word) => word,
            Self::Numbers(_) | Self::Borrowed(_) => "",
        }
    }
}

/// Rows of a block.
fn rows_of(block: &SampleBlock<'_>) -> usize {
    let rows = |values: &ColumnValues<'_>| match values {
        ColumnValues::Word(_) => None,
        ColumnValues::Words(words) => Some(words.len()),
        numbers => Some(numbers.numbers().len()),
    };
    block.iter().find_map(rows).unwrap_or(0)
}

impl<'a> BlockTable<'a> {
    /// Columns of words, then columns of numbers.
    fn new<S: Into<String>>(
        words: impl IntoIterator<Item = S>,
        numbers: impl IntoIterator<Item = S>,
        blocks: impl Iterator<Item = SampleBlock<'a>> + 'a,
    ) -> Self {
        let column = |words: bool| move |name: S| SampleColumn { name: name.into(), words };
        let columns = words.into_iter().map(column(true));
        let columns = columns.chain(numbers.into_iter().map(column(false))).collect();
        Self { columns, blocks: Box::new(blocks) }
    }

    /// The whole table in memory, for a program around this one.
    pub fn collect(self) -> CollectedSamples {
        let empty = |column: &SampleColumn| match column.words {
            true => SampleValues::Words(SampleWords::default()),
            false => SampleValues::Numbers(Vec::new()),
        };
        let mut values: Vec<SampleValues> = self.columns.iter().map(empty).collect();
        for block in self.blocks {
            let rows = rows_of(&block);
            for (values, of_block) in values.iter_mut().zip(&block) {
                match values {
                    SampleValues::Numbers(all) => all.extend_from_slice(of_block.numbers()),
                    SampleValues::Words(all) => all.extend(of_block, rows),
                }
            }
        }
        let names = self.columns.into_iter().map(|column| column.name);
        CollectedSamples { columns: names.zip(values).collect() }
    }

    /// Writes the table to `path`, whole or not at all: Parquet where its name ends in `.parquet`,
    /// else CSV.
    ///
    /// # Errors
    /// [`OutputError::Write`] with the path.
    pub fn write(self, path: &Path) -> Result<(), OutputError> {
        let written = write_atomically_with(path, |file| {
            if is_parquet(path) { self.parquet(file) } else { self.csv(BufWriter::new(file)) }
        });
        written.map_err(|reason| OutputError::Write { path: path.to_owned(), reason })
    }

    /// As RFC 4180 has it: a header, a dot in numbers, quotes where a word needs them; a value that
    /// does not exist is an empty field.
    fn csv(self, mut file: impl Write) -> io::Result<()> {
        let mut line = String::new();
        let end = |line: &mut String| {
            line.pop();
            line.push('\n');
        };
        for column in &self.columns {
            line += &column.name;
            line.push(',');
        }
        end(&mut line);
        file.write_all(line.as_bytes())?;
        for block in self.blocks {
            for row in 0..rows_of(&block) {
                line.clear();
                for (column, values) in self.columns.iter().zip(&block) {
                    if column.words {
                        line += &quoted(values.word(row));
                    } else if let Some(value) =
                        values.numbers().get(row).filter(|value| value.is_finite())
                    {
                        write!(line, "{value}").map_err(io::Error::other)?;
                    }
                    line.push(',');
                }
                end(&mut line);
                file.write_all(line.as_bytes())?;
            }
        }
        file.flush()
    }

    #[cfg(not(feature = "parquet"))]
    fn parquet(self, _: impl Write) -> io::Result<()> {
        Err(io::Error::other("this build has no Parquet; build it with the feature `parquet`"))
    }
}

/// Whether samples of this name are written as Parquet.
pub fn is_parquet(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("parquet"))
}

fn quoted(word: &str) -> String {
    if word.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", word.replace('"', "\"\""))
    } else {
        word.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_needs_them_has_quotes_and_what_does_not_exist_is_empty() {
        let blocks = [
            vec![
                ColumnValues::Word("a, \"b\""),
                ColumnValues::Numbers(vec![0.1, f64::NAN]),
                ColumnValues::Borrowed(&[1.0, -2.5e-7]),
            ],
            vec![
                ColumnValues::Words(vec!["c".into()]),
                ColumnValues::Numbers(vec![3.0]),
                ColumnValues::Numbers(vec![f64::INFINITY]),
            ],
        ];
        let mut text = Vec::new();
        BlockTable::new(["word"], ["x_m", "y_n"], blocks.into_iter()).csv(&mut text).unwrap();
        let expected =
            "word,x_m,y_n\n\"a, \"\"b\"\"\",0.1,1\n\"a, \"\"b\"\"\",,-0.00000025\nc,3,\n";
        assert_eq!(String::from_utf8(text).unwrap(), expected);
    }

    #[cfg(feature = "parquet")]
    #[test]
    fn parquet_and_csv_hold_the_same_to_the_last_digit() {
        use crate::{Report, WeldReport, sample};

        let welds = sample::welds(300);
        let runs = welds.runs();
        let weld = WeldReport {
            runs: &runs,
            from_log: None,
            exaggeration: 1.0,
            provenance: sample::provenance(),
        };
        let parts = sample::diagnosis(trueweld_diagnose::DiagnosisVerdict::EffectFound);
        assert_eq!(rows_of_both(&|path| weld.samples().unwrap().write(path).unwrap()), 600);
        // Three columns of 500 rows, under two models.
        let diagnosed = parts.diagnosed();
        assert_eq!(rows_of_both(&|path| diagnosed.samples().unwrap().write(path).unwrap()), 3000);
    }

    /// Rows that are written as CSV and as Parquet, and hold the same.
    #[cfg(feature = "parquet")]
    fn rows_of_both(write: &dyn Fn(&Path)) -> i64 {
        use ::parquet::file::reader::{FileReader, SerializedFileReader};
        use ::parquet::record::Field;

        let folder = tempfile::tempdir().unwrap();
        let [csv, parquet] = ["a.csv", "a.parquet"].map(|name| folder.path().join(name));
        write(&csv);
        write(&parquet);
        let text = std::fs::read_to_string(csv).unwrap();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        let reader = SerializedFileReader::new(std::fs::File::open(parquet).unwrap()).unwrap();
        let mut rows = 0;
        for (row, line) in reader.get_row_iter(None).unwrap().zip(lines.by_ref()) {
            let row = row.unwrap();
            // Phases of a weld have commas in them.
            let fields = csv_fields(line);
            assert_eq!(fields.len(), names.len());
            for (((name, field), expected), text) in row.get_column_iter().zip(&names).zip(&fields)
            {
                assert_eq!(name, expected);
                match field {
                    Field::Str(word) => assert_eq!(word, text),
                    Field::Double(value) if value.is_nan() => assert_eq!(text, ""),
                    Field::Double(value) => assert_eq!(text.parse(), Ok(*value)),
                    other => panic!("{other:?}"),
                }
            }
            rows += 1;
        }
        assert_eq!((lines.next(), rows), (None, reader.metadata().file_metadata().num_rows()));
        rows
    }

    #[cfg(feature = "parquet")]
    fn csv_fields(line: &str) -> Vec<String> {
        let quoted = |(k, part): (usize, &str)| match k % 2 {
            0 => part.replace(',', "\u{1}"),
            _ => part.to_owned(),
        };
        let line: String = line.split('"').enumerate().map(quoted).collect();
        line.split('\u{1}').map(str::to_owned).collect()
    }
}
