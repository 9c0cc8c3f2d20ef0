//! `trueweld improve`: adds what is missing to a model, and writes it.

use crate::improve_fleet;
use crate::measured::{
    BudgetArguments, LogArguments, refuse_mistakes, say_unwritten, show, tell_mistakes,
};
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::Result;
use std::path::PathBuf;
use trueweld::{HeldOutLogs, improve};
use trueweld_output::{ImproveReport, model_comments};

/// Arguments of `improve`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    measurements: LogArguments,
    /// Where to write the improved model; of several units, the folder for the file of each
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Log or campaign that is judged by and not fitted, of several units each of the one that it states;
    /// may be given several times (default: blocks in time of the LOGs)
    #[arg(long = "held-out", value_name = "LOG")]
    held_out: Vec<PathBuf>,
    #[command(flatten)]
    budget: BudgetArguments,
    #[command(flatten)]
    results: RecordedResults,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let deadline = arguments.budget.deadline()?;
    let mut outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    if arguments.measurements.is_of_several_units()? {
        let Arguments { measurements, out, held_out, results, .. } = arguments;
        return improve_fleet::run(measurements, held_out, out, deadline, results);
    }
    outputs.push(("--out", &arguments.out));
    check_targets(&outputs)?;
    let mut measured = arguments.measurements.read()?;
    let mut provenance = measured.provenance("improve")?;
    let held_out = match arguments.held_out.as_slice() {
        [] => None,
        folders => Some(HeldOutLogs::read(folders, &measured)?),
    };
    if let Some(held_out) = &held_out {
        refuse_mistakes("--held-out", &held_out.found, &measured.model)?;
        provenance.files.extend_from_slice(&held_out.files);
    }
    check_outputs(&outputs)?;
    if tell_mistakes(&measured, &arguments.results.files, &provenance)? {
        return say_unwritten("improved model", &arguments.out);
    }
    let progress = arguments.results.files.progress("comparing", 1.0);
    let done = improve(&mut measured)
        .held_out(held_out.as_ref())
        .deadline(deadline)
        .on_progress(&|now| show(&progress, now))
        .run();
    progress.finish();
    let mut improved = done?;
    let (model, logs) = (&measured.model, &measured.logs);
    let comments = model_comments(&improved.improvement, model, logs, &improved.origins);
    improved.write(&arguments.out, &comments)?;
    let [given, elsewhere] = &improved.held_out;
    arguments.results.write(&ImproveReport {
        model,
        out: &arguments.out,
        improvement: &improved.improvement,
        posterior: improved.posterior.as_ref().ok(),
        before: &improved.before,
        after: &improved.after,
        held_out: [given, elsewhere],
        reason: improved.reason.as_ref(),
        notices: &improved.notices(),
        provenance: &provenance,
    })?;
    say!("wrote {}\n", arguments.out.display());
    Ok(())
}
