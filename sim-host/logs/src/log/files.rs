//! Which files a log's samples stand in, and how `log.toml` says that they are to be read: `files`,
//! `[clock]`, `[columns]` and `[reflectors]`.

use super::columns::{Bound, ColumnMapping, REFLECTOR_COUNT};
use super::text::{Dialect, SEPARATORS};
use nalgebra::Vector3;
use std::path::{Path, PathBuf};
use trueweld_plant::input::{Bounds, InputError, TomlTable};

/// Name of the file with the rows, where `log.toml` names no other.
pub const SAMPLES_FILE: &str = "samples.csv";

/// Clocks that are off by more do not drift, they count something else.
const MOST_DRIFT: f64 = 0.01;

/// A file of rows.
#[derive(Debug, Clone)]
pub(super) struct FileEntry {
    /// As `log.toml` writes it.
    pub written: String,
    /// Where it is.
    pub path: PathBuf,
    /// Its clock; `None` for the log's own.
    pub clock: Option<String>,
    /// How it is written, where it is text.
    pub dialect: Dialect,
    /// Which of the messages are read, of a file that holds several kinds.
    pub topic: Option<String>,
}

impl FileEntry {
    /// True where `header` is the name or the number of one of the file's columns, `names`, by
    /// itself or behind the file's own name and a colon.
    fn has(&self, header: &str, names: &[String]) -> bool {
        let rest = header.strip_prefix(&self.written).and_then(|rest| rest.strip_prefix(':'));
        [Some(header), rest].into_iter().flatten().any(|header| {
            let number = header.parse::<usize>().ok();
            names.iter().any(|name| name == header)
                || number.is_some_and(|n| (1..=names.len()).contains(&n))
        })
    }
}

/// An instrument's clock: its time = offset + (1 + drift) · the log's. What is `None` is fitted.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct ClockEntry {
    pub name: String,
    pub offset: Option<f64>,
    pub drift: Option<f64>,
}

/// How the samples of a log are to be read.
#[derive(Debug, Clone)]
pub(super) struct ReadingPlan {
    pub files: Vec<FileEntry>,
    pub clocks: Vec<ClockEntry>,
    pub columns: Vec<ColumnMapping>,
    /// Where the reflectors sit in T, m.
    pub reflectors: [Option<Vector3<f64>>; REFLECTOR_COUNT],
}

/// Keys of `log.toml` that are read here.
pub(super) const KEYS: [&str; 4] = ["files", "clock", "columns", "reflectors"];

impl ReadingPlan {
    /// Reads what the top level of a `log.toml` says.
    pub(crate) fn read(root: &TomlTable<'_>, folder: &Path) -> Result<Self, InputError> {
        let files = if root.has("files") {
            root.each_table("files", |table| file(table, folder))?
        } else {
            vec![FileEntry {
                written: SAMPLES_FILE.to_owned(),
                path: folder.join(SAMPLES_FILE),
                clock: None,
                dialect: Dialect::PLAIN,
                topic: None,
            }]
        };
        if files.is_empty() {
            let help = "Leave `files` out where the samples stand in samples.csv.";
            return Err(root.wrong("files", "at least one file", help));
        }
        Ok(Self {
            clocks: clocks(root, &files)?,
            columns: columns(root)?,
            reflectors: reflectors(root)?,
            files,
        })
    }

    /// Checks that every entry of `[columns]` was found in some file, and is the only one of its
    /// column. `names`: the columns of every file; `bounds`: what is read of them.
    pub(crate) fn all_found(
        &self,
        root: &TomlTable<'_>,
        names: &[&[String]],
        bounds: &[Bound],
    ) -> Result<(), InputError> {
        for entry in &self.columns {
            if !self.files.iter().zip(names).any(|(file, names)| file.has(&entry.header, names)) {
                let table = root.table("columns")?;
                let all = names.iter().flat_map(|names| names.iter()).map(String::as_str);
                let near = trueweld_plant::input::did_you_mean(&entry.header, all.clone());
                let some: Vec<String> = all.take(12).map(|name| format!("{name:?}")).collect();
                let expected = format!("the header or the number of a column of the files{near}");
                let help = format!("The files begin with the columns {}.", some.join(", "));
                return Err(table.wrong_key(&entry.header, &expected, help));
            }
            if !bounds.iter().any(|bound| bound.used.contains(&entry.header)) {
                let table = root.table("columns")?;
                let help = "A column may be named by its header or its number, and by its file before a colon.";
                let expected = "one entry for each column: another one names the same";
                return Err(table.wrong_key(&entry.header, expected, help.to_owned()));
            }
        }
        Ok(())
    }
}

fn file(table: &TomlTable<'_>, folder: &Path) -> Result<FileEntry, InputError> {
    table.only(&["path", "clock", "delimiter", "decimal", "header", "rows", "topic"])?;
    let path = table.file("path", folder)?;
    let clock = table.optional("clock", TomlTable::name)?;
    let delimiter = mark(table, "delimiter", &SEPARATORS.map(|(byte, _)| byte), b',')?;
    let decimal = mark(table, "decimal", b".,", b'.')?;
    if delimiter == decimal {
        let help = "Fields that are parted by commas have dots in their numbers.";
        let key = if table.has("decimal") { "decimal" } else { "delimiter" };
        return Err(table.wrong(key, "another mark than the delimiter", help));
    }
    let header = line_number(table, "header", 1)?;
    let rows = line_number(table, "rows", header + 1)?;
    if rows <= header {
        let help = "`header` is the line with the names, `rows` the first with values.";
        return Err(table.wrong("rows", "a line below the header", help));
    }
    Ok(FileEntry {
        written: table.text("path")?.text.to_owned(),
        path,
        clock,
        dialect: Dialect { delimiter, decimal, header, rows },
        topic: table.optional("topic", TomlTable::name)?,
    })
}

/// The mark under a key, one of `allowed`; `default` without the key.
fn mark(table: &TomlTable<'_>, key: &str, allowed: &[u8], default: u8) -> Result<u8, InputError> {
    if !table.has(key) {
        return Ok(default);
    }
    let text = table.text(key)?.text;
    allowed.iter().copied().find(|byte| text.as_bytes() == [*byte]).ok_or_else(|| {
        let names: Vec<_> =
            allowed.iter().map(|byte| format!("{:?}", char::from(*byte).to_string())).collect();
        let help = "A blank stands for any number of blanks.";
        table.wrong(key, &format!("one of {}", names.join(", ")), help)
    })
}

/// The number of a line under a key, from 1, or 0 for none; `default` without the key.
fn line_number(table: &TomlTable<'_>, key: &str, default: usize) -> Result<usize, InputError> {
    if !table.has(key) {
        return Ok(default);
    }
    let line = table.integer(key)?;
    usize::try_from(line).ok().filter(|line| *line <= 100_000).ok_or_else(|| {
        table.wrong(key, "the number of a line, from 1", "The first line is 1; no header: 0.")
    })
}

fn clocks(root: &TomlTable<'_>, files: &[FileEntry]) -> Result<Vec<ClockEntry>, InputError> {
    let mut clocks: Vec<ClockEntry> = Vec::new();
    for name in files.iter().filter_map(|file| file.clock.clone()) {
        if !clocks.iter().any(|clock| clock.name == name) {
            clocks.push(ClockEntry { name, ..ClockEntry::default() });
        }
    }
    if !root.has("clock") {
        return Ok(clocks);
    }
    let all = root.table("clock")?;
    let names: Vec<&str> = clocks.iter().map(|clock| clock.name.as_str()).collect();
    all.only(&names)?;
    for name in all.keys() {
        let table = all.table(name)?;
        table.only(&["offset_s", "drift"])?;
        let number = |key: &str, most: f64| {
            table.optional(key, |table, key| table.number(key, Bounds::Between(-most, most)))
        };
        let entry = ClockEntry {
            name: name.to_owned(),
            offset: number("offset_s", 1e10)?,
            drift: number("drift", MOST_DRIFT)?,
        };
        if let Some(clock) = clocks.iter_mut().find(|clock| clock.name == name) {
            *clock = entry;
        }
    }
    Ok(clocks)
}

fn columns(root: &TomlTable<'_>) -> Result<Vec<ColumnMapping>, InputError> {
    if !root.has("columns") {
        return Ok(Vec::new());
    }
    let table = root.table("columns")?;
    let entries = table.keys().into_iter();
    entries.map(|header| ColumnMapping::read(header, &table.table(header)?)).collect()
}

fn reflectors(root: &TomlTable<'_>) -> Result<[Option<Vector3<f64>>; REFLECTOR_COUNT], InputError> {
    const REFLECTOR_POINTS: [&str; REFLECTOR_COUNT] =
        ["reflector1_m", "reflector2_m", "reflector3_m"];
    let mut at = [None; REFLECTOR_COUNT];
    if root.has("reflectors") {
        let table = root.table("reflectors")?;
        table.only(&REFLECTOR_POINTS)?;
        for (at, name) in at.iter_mut().zip(REFLECTOR_POINTS).filter(|(_, name)| table.has(name)) {
            *at = Some(Vector3::from(table.numbers::<3>(name, Bounds::Between(-5.0, 5.0))?));
        }
    }
    Ok(at)
}
