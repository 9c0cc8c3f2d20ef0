//! One report for each command: what is shown of its result, in every form.

mod certify;
mod compare;
mod compare_logs;
mod diagnose;
mod discover;
mod error_fall;
mod identify;
mod import;
mod improve;
mod improve_fleet;
mod laws;
mod log_faults;
mod plan;
mod record;
mod register;
mod replay;
mod residuals;
mod step;
mod study;
mod tune;
mod weld;

use crate::document::Document;
use crate::json;
use crate::samples::BlockTable;
use schemars::{JsonSchema, Schema};
use serde::Serialize;

#[cfg(feature = "rerun")]
use crate::OutputError;
#[cfg(feature = "rerun")]
use std::path::Path;

/// What a file for programs is written of, and its schema made of.
pub trait PublishedResult: Serialize + JsonSchema {}

impl<T: Serialize + JsonSchema> PublishedResult for T {}

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
    /// Name and version of the file for programs.
    const SCHEMA: &'static str;

    /// What that file holds beside name and version.
    fn json(&self) -> impl PublishedResult;

    /// The result as people read it.
    fn document(&self) -> Document;

    /// Every sample behind the result, for other programs; `None` where it has none.
    fn samples(&self) -> Option<BlockTable<'_>> {
        None
    }

    /// The text of the file for programs.
    fn json_text(&self) -> String {
        json::text(Self::SCHEMA, &self.json())
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

/// Declares which reports are recorded, and what writes the recording.
macro_rules! recorded {
    ($($report:ident by $write:ident,)+) => {$(
        impl Recorded for crate::$report<'_> {
            #[cfg(feature = "rerun")]
            fn record(&self, path: &Path) -> Result<(), OutputError> {
                crate::rerun::$write(path, self, &self.document())
            }
        }
    )+};
}

recorded! {
    WeldReport by weld_recording,
    StepReport by step_recording,
    CompareReport by compare_recording,
    DiagnoseReport by diagnose_recording,
    ImproveReport by improve_recording,
    StudyLayoutReport by layout_recording,
}

/// The name of every schema, which a file has as its `schema`, without its version; and the schema.
pub fn schemas() -> Vec<(&'static str, Schema)> {
    fn of<R: Report + 'static, J: JsonSchema>(
        _: impl FnOnce(&'static R) -> J,
    ) -> (&'static str, Schema) {
        json::schema::<J>(R::SCHEMA)
    }
    vec![
        of(crate::WeldReport::json),
        of(crate::CoreReplayReport::json),
        of(crate::StepReport::json),
        of(crate::LawsReport::json),
        of(crate::CertifyReport::json),
        of(crate::TuneReport::json),
        of(crate::StudyLayoutReport::json),
        of(crate::StudyLimitsReport::json),
        of(crate::StudyPaperReport::json),
        of(crate::StudySensitivityReport::json),
        of(crate::CompareReport::json),
        of(crate::CompareLogsReport::json),
        of(crate::DiagnoseReport::json),
        of(crate::ImproveReport::json),
        of(crate::ImproveFleetReport::json),
        of(crate::RecordReport::json),
        of(crate::PlanReport::json),
        of(crate::RegisterReport::json),
        of(crate::ImportReport::json),
        of(crate::IdentifyReport::json),
        of(crate::StiffnessPlanReport::json),
        json::schema::<json::CheckResult>(json::CheckResult::SCHEMA),
    ]
}
