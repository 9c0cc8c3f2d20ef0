//! A file of any kind, opened as rows: text unless its name or its first bytes say otherwise.

use super::files::FileEntry;
use super::rows::{MOST_ROWS, Rows};
use super::text::TextRows;
use std::io::Read;
use trueweld_plant::input::{InputError, open as open_file};

/// Opens a file.
pub(super) fn open(entry: &FileEntry) -> Result<Box<dyn Rows>, InputError> {
    let input = open_file(&entry.path, MOST_ROWS)?;
    open_text(entry, input)
}

/// Text, whatever it is called.
pub(super) fn open_text<'r>(
    entry: &FileEntry,
    input: impl Read + 'r,
) -> Result<Box<dyn Rows + 'r>, InputError> {
    let name = entry.path.display().to_string();
    Ok(Box::new(TextRows::open(name, input, entry.dialect)?))
}
