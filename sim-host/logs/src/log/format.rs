//! What a format of logs is: one file each, which the table in `source` lists.

use super::files::FileEntry;
use super::rows::RowSource;
use std::path::Path;
use trueweld_plant::input::InputError;

/// A format that is told by the first bytes of its files.
#[derive(Debug)]
pub(super) struct LogFormat {
    /// What messages call it.
    pub name: &'static str,
    /// First bytes of its files.
    pub magic: &'static [u8],
    /// How they are read; the feature that a build must have for it, where this one has not.
    pub reader: Result<FormatReader, &'static str>,
}

/// How files of a format are read.
#[derive(Debug)]
pub(super) struct FormatReader {
    /// Opens a file.
    pub open: OpenFile,
    /// Topics of a file that holds several kinds of messages; `None` where the format has none.
    pub topics: Option<ListTopics>,
}

/// Opens a file as rows.
type OpenFile = fn(&FileEntry) -> Result<Box<dyn RowSource>, InputError>;

/// Lists the topics of a file.
type ListTopics = fn(&Path) -> Result<Vec<String>, InputError>;
