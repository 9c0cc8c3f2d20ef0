//! One report for each command: what is shown of its result, in every form.

mod certify;
mod compare;
mod diagnose;
mod improve;
mod laws;
mod mistakes;
mod register;
mod residuals;
#[cfg(test)]
mod snapshots;
mod step;
mod weld;

pub use certify::{CertifiedWeld, CertifyReport};
pub use compare::CompareReport;
pub use diagnose::DiagnoseReport;
pub use improve::ImproveReport;
pub use laws::LawsReport;
pub use mistakes::MistakesReport;
pub use register::RegisterReport;
pub use step::{StepReport, StepRun};
pub use weld::{WeldReport, WeldRun};

use crate::document::Document;
use serde::Serialize;
use trueweld_plant::provenance::Provenance;

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

    /// What the result is of.
    fn provenance(&self) -> &Provenance;

    /// The result for programs.
    fn json(&self) -> Self::Json;

    /// The result as people read it.
    fn document(&self) -> Document;

    /// The text of the file for programs.
    fn json_text(&self) -> String {
        let text = serde_json::to_string_pretty(&self.json());
        text.expect("numbers, texts and lists are written as JSON") + "\n"
    }

    /// The result for a terminal.
    fn text(&self) -> String {
        self.document().text()
    }

    /// The result as one self-contained page.
    fn page(&self) -> String {
        self.document().with_provenance(self.provenance()).page()
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
