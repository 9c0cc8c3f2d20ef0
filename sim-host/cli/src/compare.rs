//! `trueweld compare`: how far a model is from measurements, and where.

use crate::measured::{LogArguments, tell_mistakes};
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::Result;
use std::sync::atomic::{AtomicUsize, Ordering};
use trueweld::compare;
use trueweld_output::CompareReport;

/// Arguments of `compare`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    measurements: LogArguments,
    #[command(flatten)]
    results: RecordedResults,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let measured = arguments.measurements.read()?;
    check_outputs(&outputs)?;
    let provenance = measured.provenance("compare")?;
    if tell_mistakes(&measured, &arguments.results.files, &provenance)? {
        return Ok(());
    }
    let rows: Vec<usize> = measured.logs.iter().map(|log| log.samples.time.len()).collect();
    let progress = arguments.results.files.progress("comparing", rows.iter().sum::<usize>() as f64);
    let finished = AtomicUsize::new(0);
    let done = |k: usize| {
        progress.advance_to((finished.fetch_add(rows[k], Ordering::Relaxed) + rows[k]) as f64);
    };
    let compared = compare(&measured, &done);
    progress.finish();
    let comparison = compared?;
    arguments.results.write(&CompareReport {
        model: &measured.model.path,
        comparison: &comparison,
        provenance: &provenance,
    })
}
