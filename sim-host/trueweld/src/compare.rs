//! How far a model is from measurements, and where.

use crate::measured::MeasuredLogs;
use miette::{IntoDiagnostic, Result};
use trueweld_estimate::residuals::compare::{self, Comparison};

/// Compares a model with logs: residuals in standard deviations of the noise, and under which
/// conditions they are large. `done` is told the number of every log that is compared, from any
/// thread.
///
/// ```no_run
/// let measured = trueweld::MeasuredLogs::read("my-campaign")?;
/// let comparison = trueweld::compare(&measured, &|_| {})?;
/// println!("{} logs", comparison.logs.len());
/// # Ok::<(), miette::Report>(())
/// ```
///
/// # Errors
/// Gross mistakes in the files; a log that the model cannot be driven through.
pub fn compare(measured: &MeasuredLogs, done: &(impl Fn(usize) + Sync)) -> Result<Comparison> {
    measured.must_be_usable()?;
    let MeasuredLogs { model, logs, found, problem } = measured;
    let mut comparison = compare::compare(model, logs, problem, done).into_diagnostic()?;
    comparison.notices.extend(found.notices());
    Ok(comparison)
}
