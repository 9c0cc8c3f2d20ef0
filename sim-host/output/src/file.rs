//! Files that are either whole or not there: written to a temporary name in the same directory, then renamed.

use crate::OutputError;
use std::fs::File;
use std::io::Write;
use std::path::Path;
use tempfile::NamedTempFile;

/// Writes a text output (a page, JSON) to `path`, replacing what was there only once the whole is on the disk.
///
/// # Errors
/// [`OutputError::Write`] with the path; the file is then as it was.
pub fn write_file(path: &Path, contents: &str) -> Result<(), OutputError> {
    replace(path, |file| file.write_all(contents.as_bytes()).map_err(|source| failed(path, source)))
}

/// Lets `write` fill a temporary file beside `path`, then renames it to `path`.
pub(crate) fn replace(
    path: &Path,
    write: impl FnOnce(&mut File) -> Result<(), OutputError>,
) -> Result<(), OutputError> {
    let directory = match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(".");
    // Created by hand rather than by `tempfile_in`, which would leave the file readable by its owner only.
    let mut temporary: NamedTempFile<File> = tempfile::Builder::new()
        .prefix(&name)
        .suffix(".part")
        .make_in(directory, |p| File::options().write(true).create_new(true).open(p))
        .map_err(|source| failed(path, source))?;
    write(temporary.as_file_mut())?;
    temporary.persist(path).map_err(|e| failed(path, e.error))?;
    Ok(())
}

/// The error for `path`.
pub(crate) fn failed(path: &Path, source: std::io::Error) -> OutputError {
    OutputError::Write { path: path.to_owned(), source }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_directory_is_named_and_not_made() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("absent").join("page.html");
        let error = write_file(&path, "x").unwrap_err();
        assert!(error.to_string().contains("absent"), "{error}");
        assert!(std::error::Error::source(&error).is_some());
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_failure_half_way_leaves_the_former_file() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("page.html");
        write_file(&path, "former").unwrap();
        let failure = replace(&path, |file| {
            file.write_all(b"half").unwrap();
            Err(failed(&path, std::io::Error::other("disk full")))
        });
        assert!(failure.is_err());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "former");
        assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
    }
}
