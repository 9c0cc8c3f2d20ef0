//! `trueweld compare`: how far a model is from measurements, and where.

use crate::measured::Measurements;
use crate::results::Results;
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::sync::atomic::{AtomicUsize, Ordering};
use trueweld_measure::fit::FitProblem;
use trueweld_measure::residuals::compare::{Notice, compare};
use trueweld_output::{CompareReport, Progress};

/// Arguments of `compare`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    measurements: Measurements,
    #[command(flatten)]
    results: Results,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let measured = arguments.measurements.read()?;
    arguments.results.check()?;
    let provenance = measured.provenance("compare")?;
    if measured.tell_mistakes(&arguments.results, &provenance)? {
        return Ok(());
    }
    let (model, count) = (&measured.model, measured.logs.len());
    let progress = if arguments.results.quiet {
        Progress::silent()
    } else {
        Progress::new("comparing", count as f64)
    };
    let finished = AtomicUsize::new(0);
    let done = || progress.advance_to((finished.fetch_add(1, Ordering::Relaxed) + 1) as f64);
    let compared =
        compare(model, &measured.logs, &FitProblem::new(model, measured.experiments), &done);
    progress.finish();
    let mut comparison = compared.into_diagnostic()?;
    comparison.notices.extend(measured.found.registered.into_iter().map(Notice::Registered));
    arguments.results.write(&CompareReport {
        model: &model.path,
        comparison: &comparison,
        provenance: &provenance,
    })
}
