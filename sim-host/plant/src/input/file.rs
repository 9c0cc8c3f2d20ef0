//! Files: which may be read, which were read, and writing one so that nobody ever sees half of it.

use super::error::{InputError, Source};
use sha2::{Digest, Sha256};
use std::cell::RefCell;
use std::fs::{self, File};
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// Most bytes of a TOML file or a URDF: a hundred times the largest that is known.
const MOST_TEXT: u64 = 16 << 20;

thread_local! {
    /// Every file that this thread opened through [`open`], by its canonical path, with the SHA-256
    /// of its bytes where it was read to its end. A command reads its inputs on one thread; commands
    /// of one process that run beside or after each other have inputs of their own.
    static READ: RefCell<Vec<(PathBuf, Option<Hash>)>> = const { RefCell::new(Vec::new()) };
}

/// A SHA-256.
type Hash = [u8; 32];

/// An input file that is read from its beginning. What was read is what its digest is of.
#[derive(Debug)]
pub struct InputReader {
    file: File,
    canonical: PathBuf,
    hasher: Sha256,
}

impl InputReader {
    /// The file itself, for a format whose end is read first. Its digest is taken when it is asked
    /// for.
    pub fn into_file(self) -> File {
        self.file
    }
}

impl Read for InputReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.file.read(buffer)?;
        self.hasher.update(&buffer[..count]);
        if count == 0 && !buffer.is_empty() {
            remember(&self.canonical, Some(self.hasher.clone().finalize().into()));
        }
        Ok(count)
    }
}

fn remember(canonical: &Path, hash: Option<Hash>) {
    READ.with_borrow_mut(|read| match read.iter_mut().find(|(path, _)| path == canonical) {
        Some((_, known)) => *known = hash,
        None => read.push((canonical.to_owned(), hash)),
    });
}

/// SHA-256 of a file's bytes: of those that were read, where it was read to its end.
///
/// # Errors
/// As [`open`].
pub(crate) fn hash_of_file(path: &Path) -> Result<Hash, InputError> {
    let known = |canonical: &Path| {
        let of = |read: &Vec<(PathBuf, Option<Hash>)>| {
            read.iter().find(|(path, _)| path == canonical).and_then(|(_, hash)| *hash)
        };
        READ.with_borrow(of)
    };
    if let Some(hash) = path.canonicalize().ok().and_then(|canonical| known(&canonical)) {
        return Ok(hash);
    }
    let mut reader = open(path, u64::MAX)?;
    io::copy(&mut reader, &mut io::sink()).map_err(|error| refused(path, &error))?;
    Ok(reader.hasher.finalize().into())
}

/// Digits of a digest, as `sha256sum` prints it.
pub fn hexadecimal(digest: &[u8]) -> String {
    digest.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn refused(path: &Path, error: &io::Error) -> InputError {
    let message = format!("cannot be read: {error}; expected a file");
    Source::new(&path.display().to_string(), "")
        .error_of_file(message, "Check the path and its permissions.")
}

/// Opens an input file for reading.
///
/// # Errors
/// A file that is not there or may not be read, one that is not a regular file (a pipe would wait
/// for ever, a device has no end), or one of more than `most` bytes.
pub fn open(path: &Path, most: u64) -> Result<InputReader, InputError> {
    let refuse = |what: String, help: &str| {
        let message = format!("cannot be read: {what}; expected a file");
        Source::new(&path.display().to_string(), "").error_of_file(message, help)
    };
    let failed = |error: io::Error| refused(path, &error);
    let metadata = fs::metadata(path).map_err(failed)?;
    if !metadata.is_file() {
        let what = if metadata.is_dir() { "it is a folder" } else { "it is a pipe or a device" };
        return Err(refuse(what.to_owned(), "Give a regular file."));
    }
    if metadata.len() > most {
        let what = format!("it has {} bytes, and at most {most} are read", metadata.len());
        return Err(refuse(what, "Is this the file that was meant?"));
    }
    let file = File::open(path).map_err(failed)?;
    let canonical = path.canonicalize().map_err(failed)?;
    remember(&canonical, None);
    Ok(InputReader { file, canonical, hasher: Sha256::new() })
}

/// Canonical paths of every input file that this thread has read so far, those that other files name
/// included: what no output may overwrite.
pub fn files_read() -> Vec<PathBuf> {
    READ.with_borrow(|read| read.iter().map(|(path, _)| path.clone()).collect())
}

/// The name to show and the text of a file.
///
/// # Errors
/// As [`open`]; text that is not UTF-8.
pub fn read_text(path: &Path) -> Result<(String, String), InputError> {
    let name = path.display().to_string();
    let mut bytes = Vec::new();
    let reader = open(path, MOST_TEXT)?;
    reader.take(MOST_TEXT).read_to_end(&mut bytes).map_err(|error| refused(path, &error))?;
    let text = String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let byte = error.as_bytes()[good];
        let source = Source::new(&name, &String::from_utf8_lossy(error.as_bytes()));
        let message =
            format!("byte {good} is {byte:#04x}, which is not UTF-8; expected UTF-8 text");
        source.error(good..good, message, "not UTF-8 from here on", "Save the file as UTF-8 text.")
    })?;
    Ok((name, text))
}

/// Beginning and end of the name of a file that is being written.
const TEMPORARY: [&str; 2] = [".trueweld-", ".tmp"];

/// Age beyond which a temporary file was left behind: none takes a minute to write.
const STALE: Duration = Duration::from_secs(3600);

/// Writes a file under a temporary name in the same folder, then renames it: the path holds either
/// what it held before or all of `bytes`. A path that is no regular file (`/dev/stdout`, a pipe) is
/// written to directly.
///
/// # Errors
/// The operating system's, with the path in its text; the temporary file is gone then.
pub fn write_atomically(path: impl AsRef<Path>, bytes: &[u8]) -> io::Result<()> {
    write_atomically_with(path, |file| file.write_all(bytes))
}

/// The same of what `fill` writes, which need not be in memory as a whole.
///
/// # Errors
/// As [`write_atomically`]; those of `fill`.
pub fn write_atomically_with(
    path: impl AsRef<Path>,
    fill: impl FnOnce(&mut File) -> io::Result<()>,
) -> io::Result<()> {
    let path = path.as_ref();
    replace(path, fill).map_err(|error| {
        io::Error::new(error.kind(), format!("{} cannot be written: {error}", path.display()))
    })
}

fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    // Through links, so that a link to a file stays a link.
    let target = match fs::metadata(path) {
        Ok(existing) if existing.is_dir() => {
            return Err(io::Error::from(io::ErrorKind::IsADirectory));
        }
        Ok(existing) if !existing.is_file() => {
            return fill(&mut File::options().write(true).open(path)?);
        }
        Ok(_) => fs::canonicalize(path)?,
        Err(_) => path.to_owned(),
    };
    let mut file = temporary(folder_of(&target))?;
    fill(file.as_file_mut())?;
    file.as_file().sync_all()?;
    file.persist(&target).map_err(|error| error.error)?;
    Ok(())
}

/// A file that is being written.
fn temporary(folder: &Path) -> io::Result<tempfile::NamedTempFile> {
    let [prefix, suffix] = TEMPORARY;
    let mut builder = tempfile::Builder::new();
    builder.prefix(prefix).suffix(suffix);
    // A temporary file is private by default; a result is as readable as any other new file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

/// Whether [`write_atomically`] may write into a folder: tried, since permissions do not tell of a
/// file system that is read-only or full.
///
/// # Errors
/// The operating system's.
pub fn may_write_into(folder: &Path) -> io::Result<()> {
    temporary(folder).map(drop)
}

/// The folder that a file is in.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Removes the temporary files that a killed [`write_atomically`] left in a folder. Those of the
/// last hour stay: another process may be writing them. What cannot be removed stays too.
pub fn remove_stale(folder: &Path) {
    let [prefix, suffix] = TEMPORARY;
    let ours = |name: &str| name.starts_with(prefix) && name.ends_with(suffix);
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let age = || entry.metadata().ok()?.modified().ok()?.elapsed().ok();
        if entry.file_name().to_str().is_some_and(ours) && age().is_some_and(|age| age > STALE) {
            let _ = fs::remove_file(entry.path());
        }
    }
}
