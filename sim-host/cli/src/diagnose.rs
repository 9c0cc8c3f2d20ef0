//! `trueweld diagnose`: which physical effect is missing in a model.

use crate::measured::{Budget, Measurements, expect};
use crate::results::{RecordedResults, check_outputs, check_targets, write};
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::path::{Path, PathBuf};
use trueweld_laboratory::weld_file;
use trueweld_measure::diagnose::{diagnose, explain};
use trueweld_measure::discover::{discover, settling_experiment};
use trueweld_measure::experiment::Plan;
use trueweld_measure::fit::FitProblem;
use trueweld_measure::residuals::compare::{notices, of_each_log, of_logs};
use trueweld_measure::residuals::single_load::single_loads;
use trueweld_output::{DiagnoseReport, experiment_protocol};
use trueweld_plant::input::ModelFile;

/// Arguments of `diagnose`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    measurements: Measurements,
    /// Write the experiment to make next as a protocol, which `record` tries in a simulated cell
    #[arg(long, value_name = "FILE")]
    protocol: Option<PathBuf>,
    #[command(flatten)]
    budget: Budget,
    #[command(flatten)]
    results: RecordedResults,
}

/// Predictions of all logs that a diagnosis asks for: at least, where nothing is missing, and at
/// most, where two effects are.
const PREDICTIONS: [f64; 2] = [350.0, 1200.0];

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let deadline = arguments.budget.deadline()?;
    let mut outputs = arguments.results.outputs();
    outputs.extend(arguments.protocol.as_deref().map(|path| ("--protocol", path)));
    check_targets(&outputs)?;
    let measured = arguments.measurements.read()?;
    check_outputs(&outputs)?;
    let provenance = measured.provenance("diagnose")?;
    if measured.tell_mistakes(&arguments.results.files, &provenance)? {
        return Ok(());
    }
    let (model, logs) = (&measured.model, &measured.logs);
    let mut bench = FitProblem { deadline, ..FitProblem::new(model, measured.experiments) };
    let progress = arguments.results.files.progress("comparing", 1.0);
    expect(&progress, &mut bench, PREDICTIONS);
    let mut diagnosis = diagnose(&bench, logs, &|what, share| progress.stage(what, 0.7 * share))
        .into_diagnostic()?;
    let stage = |what: &str, share| progress.stage(what, 0.7 + 0.15 * share);
    let discovered = discover(&bench, logs, &mut diagnosis, &stage);
    let mut account =
        explain(&bench, logs, &diagnosis, &|what, share| progress.stage(what, 0.85 + 0.15 * share));
    if let Some(discovery) = discovered.first() {
        // The other one would tell apart what explains a part within the library.
        account.next_experiment = settling_experiment(&bench, logs, discovery);
    }
    progress.finish();
    let before = of_logs(logs, &bench.logs, &diagnosis.before);
    let after = of_logs(logs, &bench.logs, &diagnosis.improved.residuals);
    let mut notices = notices(logs, &after, &diagnosis.improved.residuals);
    notices.extend(single_loads(logs, &bench.logs, &diagnosis.improved.residuals));
    notices.extend(measured.found.notices());
    notices.extend(of_each_log(&model.robot, logs, &bench.per_log, &diagnosis.each_log));
    arguments.results.write(&DiagnoseReport {
        model,
        diagnosis: &diagnosis,
        explanation: &account,
        discovered: &discovered,
        before: &before,
        after: &after,
        notices: &notices,
        provenance: &provenance,
    })?;
    match (&arguments.protocol, &account.next_experiment) {
        (None, _) => Ok(()),
        (Some(path), None) => {
            say!("there is nothing to tell apart: no {} is written\n", path.display());
            Ok(())
        }
        (Some(path), Some(plan)) => write_protocol(plan, model, path),
    }
}

/// Writes an experiment as a protocol, and its weld beside it.
fn write_protocol(plan: &Plan, model: &ModelFile, path: &Path) -> Result<()> {
    let weld = path.with_extension("weld.toml");
    if let Some(made) = &plan.log.weld {
        write(&weld, &weld_file(made))?;
    }
    let model = model.path.canonicalize().into_diagnostic()?;
    let name = weld.file_name().unwrap_or_default().to_string_lossy();
    write(path, &experiment_protocol(plan, &model.display().to_string(), &name))
}
