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
    text: Arc<Excerpt>,
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

/// Text of a file, or a piece of it, and where in the file it begins.
#[derive(Debug)]
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
    text: Arc<Excerpt>,
}

impl Source {
    /// Text read from `name` (a path, or what the reader should see instead of one).
    pub fn new(name: &str, text: &str) -> Self {
        Self::piece(name, 1, 1, text)
    }

    /// A piece of a file too large to be held, which begins at this line and column, both counted
    /// from 1. Byte ranges count from the piece's start; errors name the place in the file.
    pub fn piece(name: &str, line: usize, column: usize, text: &str) -> Self {
        let (line, column) = (line.saturating_sub(1), column.saturating_sub(1));
        Self {
            text: Arc::new(Excerpt { name: name.to_owned(), text: text.to_owned(), line, column }),
        }
    }

    /// The text.
    pub fn text(&self) -> &str {
        &self.text.text
    }

    /// The name it is shown under.
    pub fn name(&self) -> &str {
        &self.text.name
    }

    /// An error at a byte range of the text. The label stays on the range's first line.
    pub fn error(
        &self,
        span: Range<usize>,
        message: impl Into<String>,
        label: impl Into<String>,
        help: impl Into<String>,
    ) -> InputError {
        let text = self.text();
        let start = floor_char_boundary(text, span.start);
        let end = floor_char_boundary(text, span.end.max(start));
        let first_line = text[start..end].lines().next().unwrap_or_default().len();
        let before = &text[..start];
        let lines = before.matches('\n').count();
        let line = self.text.line + lines + 1;
        let offset = if lines == 0 { self.text.column } else { 0 };
        let column = offset + before.chars().rev().take_while(|c| *c != '\n').count() + 1;
        InputError {
            place: format!("{}:{line}:{column}", self.name()),
            message: message.into(),
            text: self.text.clone(),
            labels: vec![LabeledSpan::new(Some(label.into()), start, first_line)],
            help: help.into(),
        }
    }

    /// An error of the file as a whole.
    pub fn error_of_file(&self, message: impl Into<String>, help: impl Into<String>) -> InputError {
        InputError {
            place: self.name().to_owned(),
            message: message.into(),
            text: self.text.clone(),
            labels: Vec::new(),
            help: help.into(),
        }
    }

    /// What stands at a byte range, on one line and cut where it is long.
    pub(crate) fn excerpt(&self, span: Range<usize>) -> String {
        let text = self.text();
        let start = floor_char_boundary(text, span.start);
        let end = floor_char_boundary(text, span.end.max(start));
        let line = text[start..end].lines().next().unwrap_or_default();
        let short: String = line.chars().take(60).collect();
        if short.len() < end - start { format!("{short} …") } else { short }
    }

    /// The whole line that a byte stands on, without the blanks around it.
    pub(crate) fn line_at(&self, at: usize) -> String {
        let text = self.text();
        let at = floor_char_boundary(text, at);
        let start = text[..at].rfind('\n').map_or(0, |i| i + 1);
        let end = text[at..].find('\n').map_or(text.len(), |i| at + i);
        let indent = text[start..end].len() - text[start..end].trim_start().len();
        self.excerpt(start + indent..end).trim_end().to_owned()
    }
}

fn floor_char_boundary(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0)
}
