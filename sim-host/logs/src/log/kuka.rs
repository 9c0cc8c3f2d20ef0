//! Traces of KUKA's controllers: a header in DIAdem's text form (`*.dat`), which names the channels,
//! and the numbers beside it (`*.r64`), row by row, 8 bytes each.
//!
//! ```text
//! #BEGINCHANNELHEADER
//! 200,AXIS_ACT_A1      name          213,BLOCK            rows of all channels
//! 202,Grad             unit          214,REAL64
//! 210,EXPLIZIT         in a file     220,5000             number of values
//! 211,trace.r64        which         221,1                column, from 1
//! 240,0  241,1         value = 240 + 241 · number; of 210,IMPLIZIT: 240 + 241 · row
//! #ENDCHANNELHEADER
//! ```
//!
//! Left out: other types of numbers, and channels one after the other.

use super::blocks::{BlockRows, Blocks, damaged};
use super::format::FormatReader;
use super::rows::{MOST_COLUMNS, ROW_FILE_BYTES_MAX, RowSource};
use std::io::{BufReader, Read};
use std::ops::Range;
use std::path::{Path, PathBuf};
use trueweld_plant::input::file::InputReader;
use trueweld_plant::input::{InputError, Source, folder_of, open};

/// Most bytes of a header: a hundred channels take some ten thousand.
const MOST_HEADER: u64 = 4 << 20;

/// Rows in a block.
const KUKA_BLOCK_ROWS: usize = 4096;

/// How they are read.
pub(super) const TRACE: FormatReader =
    FormatReader { open: |entry| open_trace(&entry.path), topics: None };

/// Where a channel's numbers are.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ChannelPlace {
    /// Counted: start and step.
    Counted,
    /// In a file, by its number, and a column there, from 0.
    Column(usize, usize),
}

struct KukaChannel {
    place: ChannelPlace,
    offset: f64,
    factor: f64,
}

/// The files behind a header, read together.
struct KukaTrace {
    name: String,
    channels: Vec<KukaChannel>,
    files: Vec<(PathBuf, BufReader<InputReader>, usize)>,
    rows: usize,
    read: usize,
}

/// Opens a trace by its header.
fn open_trace(path: &Path) -> Result<Box<dyn RowSource>, InputError> {
    let name = path.display().to_string();
    let mut bytes = Vec::new();
    open(path, MOST_HEADER)?.take(MOST_HEADER).read_to_end(&mut bytes).map_err(|error| {
        damaged(&name, format!("cannot be read: {error}"), "Check the path and its permissions.")
    })?;
    // Latin-1, whose bytes are characters.
    let text: String = bytes.iter().map(|byte| char::from(*byte)).collect();
    let (names, trace) = header(&text, &name, folder_of(path))?;
    Ok(Box::new(BlockRows::new(name, names, trace)))
}

/// Reads a header.
fn header(text: &str, name: &str, folder: &Path) -> Result<(Vec<String>, KukaTrace), InputError> {
    let source = Source::new(name, text);
    let mut names: Vec<String> = Vec::new();
    let mut paths: Vec<PathBuf> = Vec::new();
    let mut channels: Vec<KukaChannel> = Vec::new();
    let mut rows: Option<usize> = None;
    let mut entries: Option<Vec<(&str, &str, usize)>> = None;
    let mut at = 0;
    for line in text.split_inclusive('\n') {
        let (start, trimmed) = (at, line.trim());
        at += line.len();
        match trimmed {
            "#BEGINCHANNELHEADER" => entries = Some(Vec::new()),
            "#ENDCHANNELHEADER" => {
                let Some(entries) = entries.take() else { continue };
                let end = start..start + trimmed.len();
                let entries = ChannelEntries { source: &source, entries, end };
                let count = entries.count()?;
                if *rows.get_or_insert(count) != count {
                    return Err(entries.wrong("220", "as many values as the channels before have"));
                }
                let place = entries.place(folder, &mut paths)?;
                names.push(entries.name());
                let offset = entries.number("240", Some(0.0))?;
                let factor = entries.number("241", Some(1.0))?;
                channels.push(KukaChannel { place, offset, factor });
                if channels.len() > MOST_COLUMNS {
                    return Err(entries.wrong("200", "at most 4096 channels"));
                }
            }
            _ => {
                if let (Some(entries), Some((key, value))) = (&mut entries, trimmed.split_once(','))
                {
                    entries.push((key.trim(), value.trim(), start));
                }
            }
        }
    }
    let Some(rows) = rows else {
        let message = "no #BEGINCHANNELHEADER stands in this header; expected channels";
        return Err(source.error_of_file(message, "Is this the header of a trace, a *.dat file?"));
    };
    // Counted numbers alone have no end but the one that the header states.
    if paths.is_empty() {
        let message =
            "every channel of this header is IMPLIZIT; expected one with numbers in a file";
        return Err(source.error_of_file(message, "Was the trace exported whole?"));
    }
    let widths: Vec<usize> = (0..paths.len())
        .map(|file| {
            let of = |channel: &KukaChannel| match channel.place {
                ChannelPlace::Column(f, column) if f == file => Some(column + 1),
                _ => None,
            };
            channels.iter().filter_map(of).max().unwrap_or(1)
        })
        .collect();
    let mut files = Vec::with_capacity(paths.len());
    for (path, width) in paths.into_iter().zip(widths) {
        let input = open(&path, ROW_FILE_BYTES_MAX)?;
        let bytes = std::fs::metadata(&path).map_or(0, |metadata| metadata.len());
        // Rows may hold channels that the header does not name.
        let fits = bytes % (8 * rows as u64) == 0 && bytes / (8 * rows as u64) >= width as u64;
        if !fits {
            let shown = path.display().to_string();
            let message = format!(
                "it has {bytes} bytes; expected {rows} rows of at least {width} numbers of 8 bytes, as {name} says"
            );
            return Err(damaged(&shown, message, "Was the trace copied whole?"));
        }
        let width = (bytes / (8 * rows as u64)) as usize;
        files.push((path, BufReader::with_capacity(1 << 16, input), width));
    }
    Ok((names, KukaTrace { name: name.to_owned(), channels, files, rows, read: 0 }))
}

/// The entries of one channel in a header.
struct ChannelEntries<'t> {
    source: &'t Source,
    /// Key, value, and where in the header they stand.
    entries: Vec<(&'t str, &'t str, usize)>,
    /// The line that ends them.
    end: Range<usize>,
}

impl ChannelEntries<'_> {
    fn entry(&self, key: &str) -> Option<&(&str, &str, usize)> {
        self.entries.iter().find(|(k, ..)| *k == key)
    }

    fn text(&self, key: &str) -> Option<&str> {
        self.entry(key).map(|(_, value, _)| *value)
    }

    /// The number of an entry; `default` where it is missing.
    fn number(&self, key: &str, default: Option<f64>) -> Result<f64, InputError> {
        let number = match self.text(key) {
            Some(value) => value.parse::<f64>().ok().filter(|v| v.is_finite()),
            None => default,
        };
        number.ok_or_else(|| self.wrong(key, "a number"))
    }

    /// The number of values.
    fn count(&self) -> Result<usize, InputError> {
        let count = self.number("220", None)?;
        if !(count >= 1.0 && count.fract() == 0.0 && count < 1e9) {
            return Err(self.wrong("220", "the number of values, at least 1"));
        }
        Ok(count as usize)
    }

    /// Where the numbers are; their file is added to `paths` where it is not among them.
    fn place(&self, folder: &Path, paths: &mut Vec<PathBuf>) -> Result<ChannelPlace, InputError> {
        match self.text("210") {
            Some("IMPLIZIT") => return Ok(ChannelPlace::Counted),
            Some("EXPLIZIT") => {}
            _ => return Err(self.wrong("210", "EXPLIZIT or IMPLIZIT")),
        }
        for (key, only) in [("213", "BLOCK"), ("214", "REAL64")] {
            if self.text(key).is_some_and(|value| value != only) {
                return Err(self.wrong(key, only));
            }
        }
        let column = self.number("221", None)?;
        if !(column >= 1.0 && column.fract() == 0.0 && column <= MOST_COLUMNS as f64) {
            return Err(self.wrong("221", "the number of a column, from 1"));
        }
        let Some(file) = self.text("211").filter(|file| !file.is_empty()) else {
            return Err(self.wrong("211", "the name of the file with the numbers"));
        };
        let path = data_file(folder, file);
        let known = paths.iter().position(|p| *p == path);
        let file = known.unwrap_or_else(|| {
            paths.push(path);
            paths.len() - 1
        });
        Ok(ChannelPlace::Column(file, column as usize - 1))
    }

    /// Title and unit.
    fn name(&self) -> String {
        let title = self.text("200").unwrap_or_default();
        match self.text("202").unwrap_or_default() {
            "" => title.to_owned(),
            unit => format!("{title} [{unit}]"),
        }
    }

    fn wrong(&self, key: &str, expected: &str) -> InputError {
        let (value, place) = match self.entry(key) {
            Some((_, value, place)) => (format!("is `{value}`"), *place..*place + 1),
            None => ("is missing".to_owned(), self.end.clone()),
        };
        let help = "Traces of channels in rows of REAL64 are read; export others as CSV.";
        let message = format!("entry {key} of this channel {value}; expected {expected}");
        self.source.error(place, message, "this channel", help)
    }
}

/// The file that a header names: in the header's folder, whatever folder it was written in.
fn data_file(folder: &Path, file: &str) -> PathBuf {
    let last = file.rsplit(['/', '\\']).next().unwrap_or(file);
    folder.join(last)
}

impl KukaTrace {
    /// The number as written in row `k` of what is read next, the bytes of every file.
    fn number(&self, place: ChannelPlace, blocks: &[Vec<u8>], k: usize) -> f64 {
        match place {
            ChannelPlace::Counted => (self.read + k) as f64,
            ChannelPlace::Column(file, column) => {
                let start = 8 * (k * self.files[file].2 + column);
                let bytes = blocks[file].get(start..start + 8).unwrap_or(&[0; 8]);
                f64::from_le_bytes(bytes.try_into().unwrap_or_default())
            }
        }
    }
}

impl Blocks for KukaTrace {
    fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, InputError> {
        let rows = KUKA_BLOCK_ROWS.min(self.rows - self.read);
        if rows == 0 {
            return Ok(None);
        }
        let mut blocks = Vec::with_capacity(self.files.len());
        for (path, input, width) in &mut self.files {
            let mut bytes = vec![0; 8 * rows * *width];
            input.read_exact(&mut bytes).map_err(|error| {
                let shown = path.display().to_string();
                let message = format!("it ends before its {} rows do: {error}", self.rows);
                damaged(&shown, message, &format!("{} says how many there are.", self.name))
            })?;
            blocks.push(bytes);
        }
        let column = |channel: &KukaChannel| -> Vec<f64> {
            let number = |k: usize| self.number(channel.place, &blocks, k);
            (0..rows).map(|k| channel.offset + channel.factor * number(k)).collect()
        };
        let block = self.channels.iter().map(column).collect();
        self.read += rows;
        Ok(Some(block))
    }
}
