//! The lines of a table of samples, one in memory at a time, with the place of every field.
//!
//! Lines are cut here and fields by `csv-core`, so that a line's number is right whatever its
//! ending, an open quote ends with its line, and an error has the line at hand although the file
//! was never held.

use csv_core::{ReadFieldResult, Reader, ReaderBuilder, Terminator};
use std::io::{BufRead, BufReader, Read};
use std::ops::Range;
use trueweld_plant::input::{InputError, Source};

/// No table of samples has a line longer than this, bytes; one line is all that is held.
const LINE_BYTES_MAX: u64 = 1 << 20;

pub(super) struct LineReader<R> {
    name: String,
    input: BufReader<R>,
    parser: Reader,
    /// Any number of blanks and tabs is one separator.
    blanks: bool,
    /// Of the current line, from 1; 0 before the first.
    number: usize,
    /// The current line with `\n` as its ending.
    line: Vec<u8>,
    /// Fields without quotes, one after the other, and each one's end.
    values: Vec<u8>,
    ends: Vec<usize>,
    /// Where each field stands in the line, quotes included.
    spans: Vec<Range<usize>>,
    /// The file ended before this line did.
    cut: bool,
}

impl<R: Read> LineReader<R> {
    /// Lines of a file that errors call `name`, with this byte between the fields.
    pub(crate) fn new(name: String, input: R, delimiter: u8) -> Self {
        let mut parser = ReaderBuilder::new();
        parser.terminator(Terminator::Any(b'\n')).delimiter(delimiter);
        Self {
            name,
            input: BufReader::with_capacity(1 << 16, input),
            parser: parser.build(),
            blanks: delimiter == b' ',
            number: 0,
            line: Vec::new(),
            values: Vec::new(),
            ends: Vec::new(),
            spans: Vec::new(),
            cut: false,
        }
    }

    /// Goes on to the next line that is not blank; false at the end of the file.
    pub(crate) fn advance(&mut self) -> Result<bool, InputError> {
        loop {
            self.line.clear();
            let read = (&mut self.input)
                .take(LINE_BYTES_MAX)
                .read_until(b'\n', &mut self.line)
                .map_err(|error| {
                    self.error_of_file(
                        format!("cannot be read: {error}"),
                        "Check the path and its permissions.",
                    )
                })?;
            if read == 0 {
                return Ok(false);
            }
            self.number += 1;
            self.trim_ending(read as u64)?;
            if !self.line.trim_ascii().is_empty() {
                self.split();
                return Ok(true);
            }
        }
    }

    /// Leaves `\n` as the only ending, and no byte order mark.
    fn trim_ending(&mut self, read: u64) -> Result<(), InputError> {
        self.cut = self.line.pop_if(|byte| *byte == b'\n').is_none();
        self.line.pop_if(|byte| *byte == b'\r');
        if self.number == 1 {
            if self.line.starts_with(b"\xff\xfe") || self.line.starts_with(b"\xfe\xff") {
                let message = "this file is UTF-16; expected UTF-8";
                return Err(self.error(0..2, message, "UTF-16", "Save it as UTF-8 text."));
            }
            if self.line.starts_with(b"\xef\xbb\xbf") {
                self.line.drain(..3);
            }
        }
        if let Some(at) = self.line.iter().position(|byte| *byte == b'\r') {
            let message = "a carriage return alone ends the line here; expected LF or CR LF";
            return Err(self.error(at..at, message, "CR", "Save the file with line feeds (LF)."));
        }
        if self.cut && read == LINE_BYTES_MAX {
            let message = format!(
                "the line is longer than {LINE_BYTES_MAX} bytes; expected a table of samples"
            );
            return Err(self.error(
                0..1,
                message,
                "here",
                "Is this a text file with one row of samples a line?",
            ));
        }
        self.line.push(b'\n');
        Ok(())
    }

    fn split(&mut self) {
        self.parser.reset();
        self.ends.clear();
        self.spans.clear();
        if self.blanks {
            self.split_at_blanks();
            return;
        }
        // Values are never longer than what they are read from.
        self.values.resize(self.line.len() + 1, 0);
        let (mut start, mut read, mut written) = (0, 0, 0);
        loop {
            let (result, taken, put) =
                self.parser.read_field(&self.line[read..], &mut self.values[written..]);
            read += taken;
            written += put;
            match result {
                // An open quote runs past the line's ending: called again on nothing, the parser
                // closes the field.
                ReadFieldResult::InputEmpty => {}
                ReadFieldResult::OutputFull | ReadFieldResult::End => break,
                ReadFieldResult::Field { record_end } => {
                    // Without the separator or the line's ending.
                    self.spans.push(start..read.saturating_sub(1).max(start));
                    self.ends.push(written);
                    start = read;
                    if record_end {
                        break;
                    }
                }
            }
        }
    }

    fn split_at_blanks(&mut self) {
        self.values.clear();
        let mut start = None;
        for (at, byte) in self.line.iter().enumerate() {
            match (byte.is_ascii_whitespace(), start) {
                (false, None) => start = Some(at),
                (true, Some(from)) => {
                    self.values.extend_from_slice(&self.line[from..at]);
                    self.ends.push(self.values.len());
                    self.spans.push(from..at);
                    start = None;
                }
                _ => {}
            }
        }
    }

    /// Number of the line, from 1.
    pub(crate) fn number(&self) -> usize {
        self.number
    }

    /// Number of fields in the line.
    pub(crate) fn width(&self) -> usize {
        self.ends.len()
    }

    /// A field without quotes and the blanks around it; empty past the last one.
    pub(crate) fn field(&self, index: usize) -> &[u8] {
        let Some(end) = self.ends.get(index) else {
            return &[];
        };
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        self.values[start..*end].trim_ascii()
    }

    /// The line without its ending.
    pub(crate) fn line(&self) -> &[u8] {
        self.line.strip_suffix(b"\n").unwrap_or(&self.line)
    }

    /// True where the file ends within this line.
    pub(crate) fn cut(&self) -> bool {
        self.cut
    }

    /// An error at a field; past the last one, at the line's end.
    pub(crate) fn error_at(
        &self,
        index: usize,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        let end = self.line().len();
        self.error(self.spans.get(index).cloned().unwrap_or(end..end), message, label, help)
    }

    /// An error at bytes of the line.
    pub(crate) fn error(
        &self,
        at: Range<usize>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        let line = self.line();
        let text = |range: Range<usize>| String::from_utf8_lossy(&line[range]).into_owned();
        let at = at.start.min(line.len())..at.end.min(line.len());
        let (before, marked) = (text(0..at.start), text(at.clone()));
        let span = before.len()..before.len() + marked.len();
        let whole = before + &marked + &text(at.end..line.len());
        Source::piece(&self.name, self.number, &whole).error(span, message, label, help)
    }

    /// An error of the file as a whole.
    pub(crate) fn error_of_file(
        &self,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        Source::new(&self.name, "").error_of_file(message, help)
    }
}
