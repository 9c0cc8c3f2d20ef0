//! `trueweld diagnose`: which physical effect is missing in a model.

use crate::measured::{BudgetArguments, LogArguments, say_unwritten, show, tell_mistakes};
use crate::results::{RecordedResults, check_outputs, check_targets, write};
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::path::{Path, PathBuf};
use trueweld::{CellDiagnosis, diagnose};
use trueweld_diagnose::experiment::Plan;
use trueweld_laboratory::weld_file;
use trueweld_output::{DiagnoseReport, experiment_protocol};
use trueweld_plant::input::ModelFile;

/// Arguments of `diagnose`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    measurements: LogArguments,
    /// Write the experiment to make next as a protocol, which `record` tries in a simulated cell
    #[arg(long, value_name = "FILE")]
    protocol: Option<PathBuf>,
    #[command(flatten)]
    budget: BudgetArguments,
    #[command(flatten)]
    results: RecordedResults,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let deadline = arguments.budget.deadline()?;
    let mut outputs = arguments.results.outputs();
    outputs.extend(arguments.protocol.as_deref().map(|path| ("--protocol", path)));
    let weld = arguments.protocol.as_deref().map(weld_beside);
    outputs.extend(weld.as_deref().map(|path| ("--protocol", path)));
    check_targets(&outputs)?;
    let mut measured = arguments.measurements.read()?;
    check_outputs(&outputs)?;
    let provenance = measured.provenance("diagnose")?;
    if tell_mistakes(&measured, &arguments.results.files, &provenance)? {
        return arguments.protocol.iter().try_for_each(|path| say_unwritten("protocol", path));
    }
    let progress = arguments.results.files.progress("comparing", 1.0);
    let done =
        diagnose(&mut measured).deadline(deadline).on_progress(&|now| show(&progress, now)).run();
    progress.finish();
    let CellDiagnosis { diagnosis, explanation, discovered, before, after, notices } = done?;
    arguments.results.write(&DiagnoseReport {
        model: &measured.model,
        diagnosis: &diagnosis,
        explanation: &explanation,
        discovered: &discovered,
        before: &before,
        after: &after,
        notices: &notices,
        provenance: &provenance,
    })?;
    match (&arguments.protocol, &explanation.next_experiment) {
        (None, _) => Ok(()),
        (Some(path), None) => {
            say!("there is nothing to tell apart: no {} is written\n", path.display());
            Ok(())
        }
        (Some(path), Some(plan)) => write_protocol(plan, &measured.model, path),
    }
}

/// The weld file of a protocol.
fn weld_beside(protocol: &Path) -> PathBuf {
    protocol.with_extension("weld.toml")
}

/// Writes an experiment as a protocol, and its weld beside it.
fn write_protocol(plan: &Plan, model: &ModelFile, path: &Path) -> Result<()> {
    let weld = weld_beside(path);
    if let Some(made) = &plan.log.weld {
        // The first line says who wrote it: the next run may write over it.
        let head = "# The weld of an experiment, written by trueweld diagnose.\n";
        write(&weld, &[head, &weld_file(made)].concat())?;
    }
    let model = model.path.canonicalize().into_diagnostic()?;
    let name = weld.file_name().unwrap_or_default().to_string_lossy();
    write(path, &experiment_protocol(plan, &model.display().to_string(), &name))
}
