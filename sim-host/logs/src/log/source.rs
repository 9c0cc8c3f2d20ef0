//! A file of any kind, opened as rows: text unless its first bytes say otherwise.

use super::files::FileEntry;
use super::format::LogFormat;
use super::rows::{ROW_FILE_BYTES_MAX, RowSource};
use super::text::TextRows;
use std::io::Read;
use trueweld_plant::input::file::InputReader;
use trueweld_plant::input::{InputError, Source, open as open_file};

/// The formats, those that a feature brings as well. What is none of them is text.
static LOG_FORMATS: &[LogFormat] = &[
    LogFormat { name: "a KUKA trace", magic: b"DIAEXTENDED", reader: Ok(super::kuka::TRACE) },
    LogFormat {
        name: "Parquet",
        magic: b"PAR1",
        #[cfg(feature = "parquet")]
        reader: Ok(super::parquet::PARQUET),
        #[cfg(not(feature = "parquet"))]
        reader: Err("parquet"),
    },
    LogFormat {
        name: "MCAP",
        magic: b"\x89MCAP0\r\n",
        #[cfg(feature = "mcap")]
        reader: Ok(super::mcap::MCAP),
        #[cfg(not(feature = "mcap"))]
        reader: Err("mcap"),
    },
    LogFormat {
        name: "a bag of ROS 2 (.db3)",
        magic: b"SQLite format 3\0",
        #[cfg(feature = "rosbag")]
        reader: Ok(super::rosbag::ROSBAG),
        #[cfg(not(feature = "rosbag"))]
        reader: Err("rosbag"),
    },
    LogFormat { name: "NumPy's .npy", magic: b"\x93NUMPY", reader: Ok(super::numpy::NPY) },
    LogFormat { name: "NumPy's .npz", magic: b"PK\x03\x04", reader: Ok(super::numpy::NPZ) },
    LogFormat { name: "MAT (version 5)", magic: b"MATLAB 5.0", reader: Ok(super::matlab::MAT) },
];

/// First bytes of files that are not read, what they are, and what makes text of them.
const FOREIGN: &[(&[u8], &str, &str)] = &[
    (
        b"#ROSBAG",
        "a bag of ROS 1",
        "Write its topics as text, `rostopic echo -b FILE -p TOPIC > TOPIC.csv`, or as MCAP.",
    ),
    (b"\x1f\x8b", "packed by gzip", "Unpack it: gunzip FILE."),
    (b"BZh", "packed by bzip2", "Unpack it: bunzip2 FILE."),
    (b"\xfd7zXZ\0", "packed by xz", "Unpack it: unxz FILE."),
    (b"\x28\xb5\x2f\xfd", "packed by zstd", "Unpack it: unzstd FILE."),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", "Unpack it."),
    (
        b"MATLAB 7.3",
        "a MAT file of version 7.3",
        "Save it anew in MATLAB for the reader of version 7: save(\"log.mat\", \"t\", \"q\", \"-v7\").",
    ),
    (
        b"MATLAB ",
        "a MAT file of another version than 5",
        "Save it anew: save(\"log.mat\", \"t\", \"q\", \"-v7\").",
    ),
    (b"\x89HDF", "HDF5", "Write its data sets as NumPy's .npz, or as text: h5dump."),
    (b"\xd0\xcf\x11\xe0", "a workbook (.xls)", "Save the sheet as CSV."),
    (b"TDSm", "TDMS of LabVIEW", "Save it as text (.lvm or CSV), or with nptdms."),
    (b"MDF ", "a measurement file of ASAM (.mf4)", "Export it as CSV."),
    (b"%PDF", "a PDF document", "Give the file with the numbers."),
    (b"\x89PNG", "a picture", "Give the file with the numbers."),
    (b"ARROW1", "Arrow or Feather", "Write it as Parquet or CSV."),
    (b"{", "JSON", "Write it as CSV, one row a sample."),
    (b"<?xml", "XML", "Write it as CSV, one row a sample."),
];

/// Bytes at a file's start that are looked at.
const START: u64 = 256;

/// What a file is that is no table of text, by its first bytes.
fn foreign(start: &[u8]) -> Option<(&'static str, &'static str)> {
    let known = FOREIGN.iter().find(|(magic, ..)| start.starts_with(magic));
    // Text in UTF-16 is told apart where lines are read.
    let utf16 = start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff");
    let binary = start.iter().any(|byte| *byte < 9 || (14..27).contains(byte)) && !utf16;
    let other =
        ("binary data of no kind that is known", "Save the samples as text: a header, then rows.");
    known.map(|(_, what, help)| (*what, *help)).or(binary.then_some(other))
}

/// A file's first bytes and what follows them; the format that they tell, if any.
type OpenedStart = (Vec<u8>, InputReader, Option<&'static LogFormat>);

fn open_start(entry: &FileEntry) -> Result<OpenedStart, InputError> {
    let mut input = open_file(&entry.path, ROW_FILE_BYTES_MAX)?;
    let mut start = Vec::new();
    if let Err(error) = (&mut input).take(START).read_to_end(&mut start) {
        let message = format!("cannot be read: {error}");
        let source = Source::new(&entry.path.display().to_string(), "");
        return Err(source.error_of_file(message, "Check the path and its permissions."));
    }
    let format = format_of(&start);
    Ok((start, input, format))
}

/// The format that a file's first bytes tell; `None` of text.
pub(super) fn format_of(start: &[u8]) -> Option<&'static LogFormat> {
    LOG_FORMATS.iter().find(|format| start.starts_with(format.magic))
}

/// Opens a file.
pub(super) fn open(entry: &FileEntry) -> Result<Box<dyn RowSource>, InputError> {
    let name = entry.path.display().to_string();
    let (start, input, format) = open_start(entry)?;
    if let Some(LogFormat { name: format, reader, .. }) = format {
        let reader = reader.as_ref().map_err(|feature| left_out(&name, format, feature))?;
        return (reader.open)(entry);
    }
    if let Some((what, help)) = foreign(&start) {
        let names: Vec<&str> = LOG_FORMATS.iter().map(|format| format.name).collect();
        let message = format!("this is {what}; expected one of text, {}", names.join(", "));
        return Err(Source::new(&name, "").error_of_file(message, help));
    }
    open_text(entry, std::io::Cursor::new(start).chain(input))
}

fn left_out(name: &str, format: &str, feature: &str) -> InputError {
    let message = format!("this is {format}, which this build does not read");
    let help = format!(
        "Build it with the feature `{feature}`, or save the samples as text: a header, then rows."
    );
    Source::new(name, "").error_of_file(message, help)
}

/// Topics of a file that holds several kinds of messages; `None` where it is no such file.
pub(super) fn topics(entry: &FileEntry) -> Result<Option<Vec<String>>, InputError> {
    let (.., format) = open_start(entry)?;
    let topics = format.and_then(|format| format.reader.as_ref().ok()?.topics);
    topics.map(|topics| topics(&entry.path)).transpose()
}

/// Text, whatever it is called.
pub(super) fn open_text<'r>(
    entry: &FileEntry,
    input: impl Read + 'r,
) -> Result<Box<dyn RowSource + 'r>, InputError> {
    let name = entry.path.display().to_string();
    Ok(Box::new(TextRows::open(name, input, entry.dialect)?))
}
