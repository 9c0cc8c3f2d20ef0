//! Why files of the evidence cannot be used.

use miette::{Report, miette};
use std::io;
use std::path::{Path, PathBuf};

/// A file or folder of the evidence that cannot be used.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("cannot {what} {}", path.display())]
struct EvidenceFileError {
    what: &'static str,
    path: PathBuf,
    source: io::Error,
}

/// That a file or folder cannot be used so. `source`: the operating system's reason.
pub(super) fn cannot(what: &'static str, path: &Path, source: io::Error) -> Report {
    EvidenceFileError { what, path: path.to_owned(), source }.into()
}

/// That a file cannot be written as a whole; it is as it was.
pub(super) fn unwritten(error: io::Error) -> Report {
    miette!(help = "the folder must exist and be writable", "{error}")
}
