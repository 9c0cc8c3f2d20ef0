//! Folders that a command writes whole.

use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::io::ErrorKind;
use std::path::Path;

/// Makes a folder that is not there yet: nothing is written over.
pub(crate) fn make_folder(path: &Path) -> Result<()> {
    match std::fs::create_dir(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Err(miette!(
            "cannot make the folder {}: it is there already; expected another name, or remove it",
            path.display()
        )),
        made => made
            .into_diagnostic()
            .wrap_err_with(|| format!("cannot make the folder {}", path.display())),
    }
}
