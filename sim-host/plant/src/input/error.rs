//! The one error of the input layer: what was read, where, what was expected and what to do about it.

use miette::{Diagnostic, LabeledSpan, NamedSource};
use std::ops::Range;
use std::sync::Arc;

/// A file that cannot be used.
///
/// Its text opens with the place, `file:line:column`, so that it is complete on one line too; rendered by miette it
/// underlines the place in the file and adds the help.
#[derive(Debug, Clone, thiserror::Error, Diagnostic)]
#[error("{place}: {message}")]
pub struct InputError {
    place: String,
    message: String,
    #[source_code]
    text: Arc<NamedSource<String>>,
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

/// A file's text with the name it is shown under; makes the errors that point into it.
#[derive(Debug, Clone)]
pub struct Source {
    text: Arc<NamedSource<String>>,
}

impl Source {
    /// Text read from `name` (a path, or what the reader should see instead of one).
    pub fn new(name: &str, text: &str) -> Self {
        Self { text: Arc::new(NamedSource::new(name, text.to_owned())) }
    }

    /// The text.
    pub fn text(&self) -> &str {
        self.text.inner()
    }

    /// The name it is shown under.
    pub fn name(&self) -> &str {
        self.text.name()
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
        let line = before.matches('\n').count() + 1;
        let column = before.chars().rev().take_while(|c| *c != '\n').count() + 1;
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
