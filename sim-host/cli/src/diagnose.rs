//! `trueweld diagnose`: which physical effect is missing in a model.

use crate::measured::Measurements;
use crate::results::Results;
use clap::Args;
use miette::{IntoDiagnostic, Result};
use trueweld_measure::diagnose::{diagnose, tell};
use trueweld_measure::fit::FitProblem;
use trueweld_measure::residuals::compare::of_logs;
use trueweld_output::{DiagnoseReport, Progress};

/// Arguments of `diagnose`.
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
    let provenance = measured.provenance("diagnose")?;
    if measured.tell_mistakes(&arguments.results, &provenance)? {
        return Ok(());
    }
    measured.tell_registered()?;
    let (model, logs) = (&measured.model, &measured.logs);
    let bench = FitProblem::new(model, measured.experiments);
    let progress =
        if arguments.results.quiet { Progress::silent() } else { Progress::new("comparing", 1.0) };
    let diagnosis = diagnose(&bench, logs, &|what, share| progress.stage(what, 0.85 * share))
        .into_diagnostic()?;
    let account =
        tell(&bench, logs, &diagnosis, &|what, share| progress.stage(what, 0.85 + 0.15 * share));
    progress.finish();
    let before = of_logs(logs, &bench.experiments, &diagnosis.before);
    let after = of_logs(logs, &bench.experiments, &diagnosis.improved.at);
    arguments.results.write(&DiagnoseReport {
        model,
        diagnosis: &diagnosis,
        account: &account,
        before: &before,
        after: &after,
        provenance: &provenance,
    })
}
