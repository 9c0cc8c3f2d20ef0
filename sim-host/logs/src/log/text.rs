//! Tables as text: a header, then a row a line, with any separator and either decimal mark.

use super::lines::LineReader;
use super::rows::RowSource;
use super::time_of_day::seconds;
use std::borrow::Cow;
use std::io::Read;
use trueweld_plant::input::InputError;

/// How a text file is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    /// Byte between the fields; a blank stands for any number of blanks and tabs.
    pub delimiter: u8,
    /// Decimal mark.
    pub decimal: u8,
    /// Line of the header, from 1; 0 where there is none and columns go by their number.
    pub header: usize,
    /// First line with values; the one after the header where it is not above it.
    pub rows: usize,
}

impl Dialect {
    /// Commas between the fields, dots in the numbers, a header in the first line.
    pub(crate) const PLAIN: Self = Self { delimiter: b',', decimal: b'.', header: 1, rows: 2 };
}

impl Default for Dialect {
    fn default() -> Self {
        Self::PLAIN
    }
}

/// True of a field without a value: an empty one, or what programs write where they have none.
pub(super) fn is_missing(field: &[u8]) -> bool {
    const MISSING_VALUE_WORDS: [&[u8]; 8] =
        [b"", b"-", b"--", b"nan", b"null", b"none", b"na", b"n/a"];
    MISSING_VALUE_WORDS.iter().any(|word| field.eq_ignore_ascii_case(word))
}

/// Separators that people use, and what messages call them.
pub(super) const SEPARATORS: [(u8, &str); 5] =
    [(b',', "`,`"), (b';', "`;`"), (b'\t', "a tab"), (b'|', "`|`"), (b' ', "a blank")];

/// A text file.
pub(super) struct TextRows<R> {
    lines: LineReader<R>,
    dialect: Dialect,
    names: Vec<String>,
    /// The current line is a row that was not given yet.
    pending: bool,
}

/// Text of a field: UTF-8, or else Latin-1.
pub(super) fn decoded(field: &[u8]) -> Cow<'_, str> {
    match std::str::from_utf8(field) {
        Ok(text) => Cow::Borrowed(text),
        Err(_) => Cow::Owned(field.iter().map(|byte| char::from(*byte)).collect()),
    }
}

impl<R: Read> TextRows<R> {
    /// Reads up to the header.
    pub(crate) fn open(name: String, input: R, dialect: Dialect) -> Result<Self, InputError> {
        let mut lines = LineReader::new(name, input, dialect.delimiter);
        let first = dialect.header.max(if dialect.header == 0 { dialect.rows } else { 1 });
        loop {
            if !lines.advance()? {
                let message = match lines.number() {
                    0 => "the file is empty; expected a header with the names of the columns, then rows".to_owned(),
                    n if n < first => format!("the file has {n} lines; expected the columns in line {first}"),
                    _ => "the file is empty; expected a header with the names of the columns, then rows".to_owned(),
                };
                return Err(
                    lines.error_of_file(message, "Was the recording written to another place?")
                );
            }
            // A header that is not where it was said to be is the next line that is not blank.
            if lines.number() >= first {
                break;
            }
        }
        let headed = dialect.header > 0;
        let name = |field| {
            if headed { decoded(lines.field(field)).into_owned() } else { (field + 1).to_string() }
        };
        let names = (0..lines.width()).map(name).collect();
        Ok(Self { lines, dialect, names, pending: !headed })
    }

    /// A row of another width than the header's.
    fn uneven(&self) -> InputError {
        let (lines, width) = (&self.lines, self.names.len());
        let read = lines.width();
        let plural = if read == 1 { "" } else { "s" };
        let message = format!(
            "this row has {read} field{plural}; expected {width}, as many as the header has"
        );
        let line = lines.line();
        let other_separator = [SEPARATORS[1], SEPARATORS[2]]
            .into_iter()
            .find(|(byte, _)| read == 1 && line.contains(byte));
        if let Some((_, name)) = other_separator {
            let message = format!("{message}; it uses {name} as separator; expected `,`");
            return lines.error_at(
                0,
                message,
                "expected `,`",
                "Save the file with one separator, and name it in `files` of log.toml where it is not the comma.",
            );
        }
        if read > width && self.dialect.delimiter == b',' && !line.contains(&b'.') {
            let message = format!(
                "{message}; no number has a dot: it seems that commas are decimal marks here"
            );
            let help = "Save the file with dots in its numbers and commas between the fields.";
            return lines.error_at(width, message, "one too many from here on", help);
        }
        if read > width {
            return lines.error_at(
                width,
                message,
                "one too many from here on",
                "Each row has one field a column.",
            );
        }
        let help = if lines.cut() {
            "The file ends within this row: the recording was cut off. Delete the row."
        } else {
            "Each row has one field a column; a value that is missing is an empty field between two separators."
        };
        lines.error_at(read, message, "the row ends here", help)
    }

    /// True for the empty fields that many programs end every line with.
    fn trails(&self) -> bool {
        let fields = self.names.len()..self.lines.width();
        self.lines.width() > self.names.len()
            && fields.clone().all(|field| self.lines.field(field).is_empty())
            && fields.len() == 1
            && self.dialect.delimiter != b','
    }
}

impl<R: Read> RowSource for TextRows<R> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, InputError> {
        if std::mem::take(&mut self.pending) {
            return Ok(true);
        }
        loop {
            if !self.lines.advance()? {
                return Ok(false);
            }
            if self.lines.number() >= self.dialect.rows {
                break;
            }
        }
        if self.lines.width() != self.names.len() && !self.trails() {
            return Err(self.uneven());
        }
        Ok(true)
    }

    fn value(&self, column: usize) -> Option<f64> {
        let field = self.lines.field(column);
        if is_missing(field) {
            return Some(f64::NAN);
        }
        let text = std::str::from_utf8(field).ok()?;
        // Where the comma is the decimal mark a dot parts thousands, and is refused.
        let number = match self.dialect.decimal {
            b',' => text.replace('.', "_").replace(',', ".").parse::<f64>(),
            _ => text.parse::<f64>(),
        };
        number.ok().filter(|x| x.is_finite())
    }

    fn time(&self, column: usize) -> Option<f64> {
        let field = std::str::from_utf8(self.lines.field(column)).ok();
        self.value(column).or_else(|| seconds(field?))
    }

    fn decimals(&self, column: usize) -> i32 {
        let text = self.lines.field(column);
        let mut parts = text.split(|byte| matches!(byte, b'e' | b'E'));
        let mantissa = parts.next().unwrap_or_default();
        let exponent = parts
            .next()
            .and_then(|e| std::str::from_utf8(e).ok()?.parse::<i32>().ok())
            .unwrap_or(0);
        let mark = |byte: &u8| *byte == b'.' || *byte == self.dialect.decimal;
        let after = mantissa.iter().position(mark).map_or(0, |at| mantissa.len() - at - 1);
        // Finer than this no time is.
        i32::try_from(after).unwrap_or(i32::MAX).saturating_sub(exponent).clamp(0, 15)
    }

    fn text(&self, column: usize) -> String {
        decoded(self.lines.field(column)).into_owned()
    }

    fn error_at(
        &self,
        column: Option<usize>,
        message: String,
        label: &str,
        help: &str,
    ) -> InputError {
        match column {
            Some(column) => self.lines.error_at(column, message, label, help),
            None => self.lines.error(0..self.lines.line().len(), message, label, help),
        }
    }

    fn error_of_file(&self, message: String, help: &str) -> InputError {
        self.lines.error_of_file(message, help)
    }

    fn misread(&self, known: &dyn Fn(&str) -> bool) -> Option<InputError> {
        let line = self.lines.line();
        let others = SEPARATORS.into_iter().filter(|(byte, _)| *byte != self.dialect.delimiter);
        for (separator, name) in others {
            let mut fields = line.split(|byte| *byte == separator || *byte == b'"');
            if let (true, Some(at)) = (
                fields.any(|field| known(&decoded(field.trim_ascii()))),
                line.iter().position(|byte| *byte == separator),
            ) {
                let (_, expected) =
                    SEPARATORS.into_iter().find(|(byte, _)| *byte == self.dialect.delimiter)?;
                let mark = if self.dialect.decimal == b',' { "comma" } else { "dot" };
                let message = format!(
                    "this file uses {name} as separator; expected {expected}, and the {mark} as decimal mark"
                );
                let help = "Save it with commas between the fields and dots in the numbers, or say how it is written in \
                            log.toml: files = [ { path = \"…\", delimiter = \";\", decimal = \",\" } ].";
                let label = format!("expected {expected}");
                return Some(self.lines.error(at..at + 1, message, label, help));
            }
        }
        None
    }
}
