//! `trueweld compare`: how far a model is from measurements, and where.

use crate::measured::Measurements;
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::sync::atomic::{AtomicUsize, Ordering};
use trueweld_measure::fit::FitProblem;
use trueweld_measure::residuals::compare::compare;
use trueweld_output::CompareReport;

/// Arguments of `compare`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    measurements: Measurements,
    #[command(flatten)]
    results: RecordedResults,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let measured = arguments.measurements.read()?;
    check_outputs(&outputs)?;
    let provenance = measured.provenance("compare")?;
    if measured.tell_mistakes(&arguments.results.files, &provenance)? {
        return Ok(());
    }
    let model = &measured.model;
    let rows: Vec<usize> = measured.logs.iter().map(|log| log.samples.time.len()).collect();
    let progress = arguments.results.files.progress("comparing", rows.iter().sum::<usize>() as f64);
    let finished = AtomicUsize::new(0);
    let done = |k: usize| {
        progress.advance_to((finished.fetch_add(rows[k], Ordering::Relaxed) + rows[k]) as f64);
    };
    let compared =
        compare(model, &measured.logs, &FitProblem::new(model, measured.experiments), &done);
    progress.finish();
    let mut comparison = compared.into_diagnostic()?;
    comparison.notices.extend(measured.found.notices());
    arguments.results.write(&CompareReport {
        model: &model.path,
        comparison: &comparison,
        provenance: &provenance,
    })
}
