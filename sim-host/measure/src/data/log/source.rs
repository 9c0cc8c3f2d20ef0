//! A file of any kind, opened as rows: text unless its first bytes say otherwise.

use super::files::FileEntry;
use super::kuka;
#[cfg(feature = "mcap")]
use super::mcap;
#[cfg(feature = "parquet")]
use super::parquet;
use super::rows::{MOST_ROWS, Rows};
use super::text::TextRows;
use std::io::Read;
use trueweld_plant::input::{InputError, Source, open as open_file};

/// First bytes of the formats that a build may leave out, with the feature that reads each.
#[cfg(not(feature = "parquet"))]
const PARQUET: &[u8] = b"PAR1";
#[cfg(feature = "parquet")]
const PARQUET: &[u8] = parquet::MAGIC;
#[cfg(not(feature = "mcap"))]
const MCAP: &[u8] = b"\x89MCAP0\r\n";
#[cfg(feature = "mcap")]
const MCAP: &[u8] = mcap::MAGIC;

/// Opens a file.
pub(super) fn open(entry: &FileEntry) -> Result<Box<dyn Rows>, InputError> {
    let name = entry.path.display().to_string();
    let mut input = open_file(&entry.path, MOST_ROWS)?;
    let mut start = Vec::new();
    let read = (&mut input).take(16).read_to_end(&mut start);
    if let Err(error) = read {
        let message = format!("cannot be read: {error}");
        let source = Source::new(&name, "");
        return Err(source.error_of_file(message, "Check the path and its permissions."));
    }
    if start.starts_with(kuka::MAGIC) {
        return kuka::open_trace(&entry.path);
    }
    if start.starts_with(PARQUET) {
        #[cfg(feature = "parquet")]
        return parquet::open_parquet(name, input.into_file());
        #[cfg(not(feature = "parquet"))]
        return Err(left_out(&name, "Parquet", "parquet"));
    }
    if start.starts_with(MCAP) {
        #[cfg(feature = "mcap")]
        return mcap::open_mcap(&entry.path, entry.topic.as_deref());
        #[cfg(not(feature = "mcap"))]
        return Err(left_out(&name, "MCAP", "mcap"));
    }
    open_text(entry, std::io::Cursor::new(start).chain(input))
}

#[cfg(not(all(feature = "parquet", feature = "mcap")))]
fn left_out(name: &str, format: &str, feature: &str) -> InputError {
    let message = format!("this is {format}, which this build does not read");
    let help = format!(
        "Build it with the feature `{feature}`, or save the samples as text: a header, then rows."
    );
    Source::new(name, "").error_of_file(message, help)
}

/// Topics of a file that holds several kinds of messages; `None` where it is no such file.
pub(super) fn topics(entry: &FileEntry) -> Result<Option<Vec<String>>, InputError> {
    let mut start = Vec::new();
    let input = open_file(&entry.path, MOST_ROWS)?;
    if input.take(16).read_to_end(&mut start).is_err() || !start.starts_with(MCAP) {
        return Ok(None);
    }
    #[cfg(feature = "mcap")]
    return mcap::topics(&entry.path).map(Some);
    #[cfg(not(feature = "mcap"))]
    Ok(None)
}

/// Text, whatever it is called.
pub(super) fn open_text<'r>(
    entry: &FileEntry,
    input: impl Read + 'r,
) -> Result<Box<dyn Rows + 'r>, InputError> {
    let name = entry.path.display().to_string();
    Ok(Box::new(TextRows::open(name, input, entry.dialect)?))
}
