//! What people and programs read of finished runs: text for the terminal, JSON, self-contained pages
//! and Rerun recordings; and the progress bar shown meanwhile.
//!
//! Every command hands its result to one [`Report`], from which all of these follow. A report takes
//! finished data and computes nothing about the robot but where to draw it: `text` turns numbers
//! into sentences, `json` into typed files, `document` into text and pages, `rerun` into
//! recordings.
//!
//! ```
//! use trueweld_output::{OutputError, Report, write_file};
//!
//! /// Prints a result, and writes its page and its file for programs.
//! fn show(report: &impl Report) -> Result<(), OutputError> {
//!     print!("{}", report.text());
//!     write_file("page.html".as_ref(), report.page())?;
//!     write_file("result.json".as_ref(), report.json_text())
//! }
//! ```

// The name under which the samples of the tests know this crate.
#[cfg(test)]
extern crate self as trueweld_output;

mod color;
mod document;
mod error;
mod file;
mod finished;
pub mod json;
mod path;
mod progress;
mod report;
#[cfg(feature = "rerun")]
mod rerun;
#[cfg(test)]
#[path = "../tests/sample/mod.rs"]
mod sample;
mod samples;
mod text;

pub use document::{Document, FORMS, Form};
pub use error::OutputError;
pub use file::write_file;
pub use finished::*;
pub use progress::{Progress, ProgressListener};
pub use report::*;
#[cfg(feature = "rerun")]
pub use rerun::{Live, LiveWeld};
pub use samples::{BlockTable, CollectedSamples, SampleValues, SampleWords, is_parquet};
pub use text::control::control_toml;
pub use text::experiment::experiment_protocol;
pub use text::identify::{identified_head, identified_source};
pub use text::import::log_toml;
pub use text::log::notice as log_notice_in_words;
pub use text::log_faults::mistake as mistake_in_words;
pub use text::model_comments;
pub use text::register::table as tracker_table;
pub use text::study::layout::out_of_reach as out_of_reach_in_words;
pub use text::weld::{
    fault as fault_in_words, missed as missed_in_words, warning as warning_in_words,
};

/// Millimetres in a metre, and milliradians in a radian.
pub(crate) const MILLI: f64 = 1e3;
