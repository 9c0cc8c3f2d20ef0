//! The one error of the input layer: what was read, where, what was expected and what to do about
//! it.

use miette::{
    Diagnostic, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan, SpanContents,
};
use std::ops::Range;
use std::sync::Arc;

/// A file that cannot be used.
///
/// Its text opens with the place, `file:line:column`, so that it is complete on one line too;
/// rendered by miette it underlines the place in the file and adds the help.
#[derive(Debug, Clone, thiserror::Error, Diagnostic)]
#[error("{place}: {message}")]
pub struct InputError {
    place: String,
    message: String,
    #[source_code]
    excerpt: Arc<Excerpt>,
    #[label(collection)]
    labels: Vec<LabeledSpan>,
    #[help]
    help: String,
}

impl InputError {
    /// Where the mistake is: `file:line:column`, or the file alone where no line can be named.
    pub fn place(&self) -> &str {
        &self.place
    }

    /// What was read and what was expected, without the place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// What to do about it.
    pub fn help_text(&self) -> &str {
        &self.help
    }
}

/// Characters of a line that an error shows to either side of the mistake.
const SHOWN_LINE_CHARACTERS: usize = 80;

/// Text without what a terminal obeys instead of showing: control characters but line feed and tab,
/// and marks that turn the direction of writing. Each becomes one visible character.
pub fn printable(text: &str) -> String {
    text.chars().map(visible).collect()
}

fn visible(c: char) -> char {
    match c {
        '\n' | '\t' => c,
        '\0'..='\x1f' => char::from_u32(0x2400 + u32::from(c)).unwrap_or('�'),
        '\x7f' => '␡',
        '\u{80}'..='\u{9f}'
        | '\u{61c}'
        | '\u{200e}'
        | '\u{200f}'
        | '\u{202a}'..='\u{202e}'
        | '\u{2066}'..='\u{2069}' => '�',
        _ => c,
    }
}

/// The lines of a file that an error shows, and where in the file they begin.
#[derive(Debug, Clone)]
struct Excerpt {
    name: String,
    text: String,
    /// Of the first character, from 0.
    line: usize,
    column: usize,
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let read = self.text.read_span(span, lines_before, lines_after)?;
        let column = read.column() + if read.line() == 0 { self.column } else { 0 };
        Ok(Box::new(MietteSpanContents::new_named(
            self.name.clone(),
            read.data(),
            *read.span(),
            read.line() + self.line,
            column,
            read.line_count(),
        )))
    }
}

/// A file's text with the name it is shown under; makes the errors that point into it.
#[derive(Debug, Clone)]
pub struct Source {
    name: String,
    text: String,
    /// Of the first line, from 0.
    line: usize,
}

impl Source {
    /// Text read from `name` (a path, or what the reader should see instead of one).
    pub fn new(name: &str, text: &str) -> Self {
        Self::piece(name, 1, text)
    }

    /// Lines of a file too large to be held, the first of which has this number, from 1. Byte
    /// ranges count from the piece's start; errors name the place in the file.
    pub fn piece(name: &str, line: usize, text: &str) -> Self {
        Self { name: name.to_owned(), text: text.to_owned(), line: line.saturating_sub(1) }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The name it is shown under.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// An error at a byte range of the text. The label stays on the range's first line. A line that
    /// is long is shown around the mistake only.
    pub fn error(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        let text = self.text();
        let start = text.floor_char_boundary(span.start);
        let (line, end_of_line) = line_around(text, start);
        let end = text.floor_char_boundary(span.end.clamp(start, end_of_line));
        let number = self.line + text[..line].matches('\n').count();
        let from = line.max(text.floor_char_boundary(start.saturating_sub(SHOWN_LINE_CHARACTERS)));
        let until = text
            .floor_char_boundary(end.min(start + 2 * SHOWN_LINE_CHARACTERS) + SHOWN_LINE_CHARACTERS)
            .min(end_of_line);
        let whole = from == line && until == end_of_line;
        let neighbour = |at: usize| {
            let (from, end) = line_around(text, at);
            printable(
                &text[from..text.floor_char_boundary(from + 2 * SHOWN_LINE_CHARACTERS).min(end)],
            )
        };
        let mut shown = String::new();
        if whole && line > 0 {
            shown = neighbour(line - 1) + "\n";
        }
        let lines_before = usize::from(!shown.is_empty());
        shown += &printable(&text[from..start]);
        let at = shown.len();
        let marked = printable(&text[start..end.min(until)]);
        shown += &marked;
        shown += &printable(&text[end.min(until)..until]);
        if let Some(next) = text[end_of_line..].find('\n').filter(|_| whole) {
            shown = shown + "\n" + &neighbour(end_of_line + next + 1);
        }
        InputError {
            place: self.place(start),
            message: printable(&message.into()),
            excerpt: Arc::new(Excerpt {
                name: one_line(&self.name),
                text: shown,
                line: number - lines_before,
                column: text[line..from].chars().count(),
            }),
            labels: vec![LabeledSpan::new(Some(printable(&label.into())), at, marked.len())],
            help: printable(&help.into()),
        }
    }

    /// An error of the file as a whole.
    pub fn error_of_file(&self, message: impl Into<String>, help: impl Into<String>) -> InputError {
        let name = one_line(&self.name);
        InputError {
            place: name.clone(),
            message: printable(&message.into()),
            excerpt: Arc::new(Excerpt { name, text: String::new(), line: 0, column: 0 }),
            labels: Vec::new(),
            help: printable(&help.into()),
        }
    }

    /// Where a byte stands: `file:line:column`.
    pub(crate) fn place(&self, at: usize) -> String {
        let before = &self.text[..self.text.floor_char_boundary(at)];
        let number = self.line + before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        format!("{}:{number}:{column}", one_line(&self.name))
    }

    /// What stands at a byte range, on one line and cut where it is long.
    pub(crate) fn excerpt(&self, span: Range<usize>) -> String {
        let text = self.text();
        let start = text.floor_char_boundary(span.start);
        let end = text.floor_char_boundary(span.end.max(start));
        let line = text[start..end].lines().next().unwrap_or_default();
        let short: String = line.chars().take(60).collect();
        if short.len() < end - start { format!("{short} …") } else { short }
    }

    /// The whole line that a byte stands on, without the blanks around it.
    pub(crate) fn line_at(&self, at: usize) -> String {
        let (start, end) = line_around(self.text(), self.text().floor_char_boundary(at));
        let indent = end - start - self.text()[start..end].trim_start().len();
        self.excerpt(start + indent..end).trim_end().to_owned()
    }
}

/// Start and end of the line that a byte stands on, without its ending (LF or CR LF).
fn line_around(text: &str, at: usize) -> (usize, usize) {
    let start = text[..at].rfind('\n').map_or(0, |i| i + 1);
    let end = text[at..].find('\n').map_or(text.len(), |i| at + i);
    (start, end - usize::from(end > at && text[..end].ends_with('\r')))
}

/// A name as one line of visible characters.
fn one_line(name: &str) -> String {
    printable(name).replace('\n', "␊")
}
