//! Rows of files that hold numbers as bytes, a block of them at a time.

use super::rows::RowSource;
use trueweld_plant::input::{InputError, Source};

/// Gives the next rows of a file, a series a column; nothing at its end.
pub(super) trait Blocks {
    /// # Errors
    /// What is wrong with the file.
    fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, InputError>;
}

/// Rows made of blocks.
pub(super) struct BlockRows<B> {
    file: String,
    names: Vec<String>,
    blocks: B,
    block: Vec<Vec<f64>>,
    /// Row within the block, and number of the row in the file, from 1; 0 before the first.
    at: usize,
    number: usize,
}

impl<B: Blocks> BlockRows<B> {
    /// Rows of a file that errors call `file`, with these columns.
    pub(crate) fn new(file: String, names: Vec<String>, blocks: B) -> Self {
        Self { file, names, blocks, block: Vec::new(), at: 0, number: 0 }
    }
}

/// An error of a file that cannot be shown.
pub(super) fn damaged(file: &str, message: impl Into<String>, help: &str) -> InputError {
    Source::new(file, "").error_of_file(message, help)
}

impl<B: Blocks> RowSource for BlockRows<B> {
    fn names(&self) -> &[String] {
        &self.names
    }

    fn advance(&mut self) -> Result<bool, InputError> {
        if self.number > 0 {
            self.at += 1;
        }
        while self.at >= self.block.first().map_or(0, Vec::len) {
            let Some(block) = self.blocks.next()? else {
                return Ok(false);
            };
            (self.block, self.at) = (block, 0);
        }
        self.number += 1;
        Ok(true)
    }

    fn value(&self, column: usize) -> Option<f64> {
        let value = *self.block.get(column)?.get(self.at)?;
        (!value.is_infinite()).then_some(value)
    }

    fn decimals(&self, _column: usize) -> i32 {
        // As finely as a number holds a time.
        9
    }

    fn text(&self, column: usize) -> String {
        match self.block.get(column).and_then(|values| values.get(self.at)) {
            Some(value) => value.to_string(),
            None => self.names.get(column).cloned().unwrap_or_default(),
        }
    }

    fn error_at(
        &self,
        column: Option<usize>,
        message: String,
        _label: &str,
        help: &str,
    ) -> InputError {
        let name = column.and_then(|column| self.names.get(column));
        let name = name.map(|name| format!("column `{}`, ", name.escape_debug()));
        let row = if self.number > 0 { format!("row {}, ", self.number) } else { String::new() };
        let place = format!("{row}{}", name.unwrap_or_default());
        let place = place.trim_end_matches(", ");
        let colon = if place.is_empty() { "" } else { ": " };
        self.error_of_file(format!("{place}{colon}{message}"), help)
    }

    fn error_of_file(&self, message: String, help: &str) -> InputError {
        damaged(&self.file, message, help)
    }
}
