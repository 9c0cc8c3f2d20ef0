//! One report for each command: what is shown of its result, in every form.

mod certify;
mod compare;
mod diagnose;
mod discover;
mod identify;
mod import;
mod improve;
mod laws;
mod mistakes;
mod record;
mod register;
mod residuals;
mod step;
mod study;
mod tune;
mod weld;

use crate::document::Document;
use crate::json;
use crate::samples::BlockTable;
use serde::Serialize;

#[cfg(feature = "rerun")]
use crate::OutputError;
#[cfg(feature = "rerun")]
use std::path::Path;

/// What a command has found, for people and for programs.
///
/// ```
/// # use trueweld_output::Report;
/// fn show(report: &impl Report) {
///     print!("{}", report.text());
///     std::fs::write("page.html", report.page()).expect("a page");
///     println!("{}", report.json_text());
/// }
/// ```
pub trait Report {
    /// The result as one file for programs.
    type Json: Serialize;

    /// The result for programs.
    fn json(&self) -> Self::Json;

    /// The result as people read it.
    fn document(&self) -> Document;

    /// Every sample behind the result, for other programs; `None` where it has none.
    fn samples(&self) -> Option<BlockTable<'_>> {
        None
    }

    /// The text of the file for programs.
    fn json_text(&self) -> String {
        json::text(&self.json())
    }

    /// The result for a terminal.
    fn text(&self) -> String {
        self.document().text()
    }

    /// The result as one self-contained page.
    fn page(&self) -> String {
        self.document().page()
    }
}

/// A report that can be recorded for the Rerun viewer, where the program is built with it.
pub trait Recorded {
    /// Writes a recording to `path`; the same result gives the same bytes.
    ///
    /// # Errors
    /// [`OutputError`] with the path; no file is left behind.
    #[cfg(feature = "rerun")]
    fn record(&self, path: &Path) -> Result<(), OutputError>;
}
