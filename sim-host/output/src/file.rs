//! Files that are either whole or not there.

use crate::OutputError;
use std::path::Path;
use trueweld_plant::input::write_atomically;

/// Writes an output to `path`, replacing what was there only once the whole is on the disk.
///
/// # Errors
/// [`OutputError::Write`] with the path; the file is then as it was.
pub fn write_file(path: &Path, contents: impl AsRef<[u8]>) -> Result<(), OutputError> {
    write_atomically(path, contents.as_ref())
        .map_err(|reason| OutputError::Write { path: path.to_owned(), reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_missing_folder_is_named_and_not_made() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("absent").join("page.html");
        let error = write_file(&path, "x").unwrap_err();
        assert_eq!(error.to_string().matches("page.html").count(), 1, "{error}");
        assert!(matches!(&error, OutputError::Write { path: named, .. } if *named == path));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
