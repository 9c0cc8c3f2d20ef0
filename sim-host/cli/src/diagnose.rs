//! `trueweld diagnose`: which physical effect is missing in a model.

use crate::measured::Measurements;
use crate::results::Results;
use clap::Args;
use miette::{IntoDiagnostic, Result};
use trueweld_measure::diagnose::{diagnose, tell};
use trueweld_measure::fit::FitProblem;
use trueweld_measure::residuals::compare::of_logs;
use trueweld_output::{Diagnosed, Progress, html, json, table};

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
    let diagnosed = Diagnosed {
        model,
        diagnosis: &diagnosis,
        account: &account,
        before: &before,
        after: &after,
    };
    say!("{}", table::diagnose_table(&diagnosed));
    let results = &arguments.results;
    results.write(
        &provenance,
        || json::diagnose_json(&diagnosed),
        || html::diagnose_page(&diagnosed),
    )?;
    #[cfg(feature = "rerun")]
    if let Some(path) = &results.rrd {
        trueweld_output::rerun::diagnose_recording(path, &diagnosed)?;
        say!("wrote {}\n", path.display());
    }
    Ok(())
}
