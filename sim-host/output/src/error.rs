//! Why an output could not be written.

use std::path::PathBuf;

/// An output that could not be written. Nothing half-written is left behind.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum OutputError {
    /// The file system refused.
    #[error("{reason}")]
    #[diagnostic(code(trueweld::output::write), help("the folder must exist and be writable"))]
    Write {
        /// The output asked for.
        path: PathBuf,
        /// What the file system said, with the path.
        reason: std::io::Error,
    },
    /// The recording could not be put together.
    #[error("cannot record into {}: {reason}", .path.display())]
    #[diagnostic(code(trueweld::output::record))]
    Record {
        /// The output asked for.
        path: PathBuf,
        /// What the recording library said.
        reason: String,
    },
    /// No viewer to stream to, or one that went away.
    #[error("{url}: {reason}")]
    #[diagnostic(
        code(trueweld::output::live),
        help("start a viewer of Rerun 0.36 first: rerun; it says where it listens")
    )]
    Live {
        /// The viewer asked for.
        url: String,
        /// What the connection said.
        reason: String,
    },
}
