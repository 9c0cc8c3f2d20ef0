//! `trueweld improve`: adds what is missing to a model, and writes it.

use crate::measured::{Measurements, digests, read_experiments};
use crate::results::{Results, check_outputs};
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;
use trueweld_measure::data::campaign::read_logs;
use trueweld_measure::data::log::Log;
use trueweld_measure::fit::FitProblem;
use trueweld_measure::improve::{HeldOut, improve, model_file};
use trueweld_measure::mistakes::find;
use trueweld_measure::residuals::compare::{baseline, of_logs};
use trueweld_output::{ImproveReport, Progress, model_comments};
use trueweld_plant::input::ModelFile;

/// Arguments of `improve`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    measurements: Measurements,
    /// Where to write the improved model
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Log or campaign that is judged by and not fitted; may be given several times (default:
    /// blocks in time of the LOGs)
    #[arg(long = "held-out", value_name = "LOG")]
    held_out: Vec<PathBuf>,
    #[command(flatten)]
    results: Results,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let measured = arguments.measurements.read()?;
    let mut provenance = measured.provenance("improve")?;
    let (model, logs) = (&measured.model, &measured.logs);
    let held_out = if arguments.held_out.is_empty() {
        None
    } else {
        let held_out = held_out(arguments, model, logs)?;
        provenance.files.extend(digests("held-out log", &held_out)?);
        let experiments = read_experiments(&held_out, model)?;
        Some(HeldOut::new(model, &held_out, experiments))
    };
    let mut outputs = arguments.results.outputs();
    outputs.push(("--out", &arguments.out));
    check_outputs(&outputs)?;
    if measured.tell_mistakes(&arguments.results, &provenance)? {
        return Ok(());
    }
    measured.tell_registered()?;
    let bench = FitProblem::new(model, measured.experiments);
    let progress =
        if arguments.results.quiet { Progress::silent() } else { Progress::new("comparing", 1.0) };
    let done = improve(&bench, logs, held_out.as_ref(), &|what, share| progress.stage(what, share));
    progress.finish();
    let improvement = done.into_diagnostic()?;
    let (file, origins) = model_file(&improvement, model);
    let comments = model_comments(&improvement, model, logs, &origins);
    file.write(&arguments.out, &comments)?;
    let at = improvement.fitted.as_ref().map_or(&improvement.diagnosis.before, |fitted| &fitted.at);
    let before = of_logs(logs, &bench.experiments, &improvement.diagnosis.before);
    let after = of_logs(logs, &bench.experiments, at);
    arguments.results.write(&ImproveReport {
        model,
        out: &arguments.out,
        improvement: &improvement,
        before: &before,
        after: &after,
        provenance: &provenance,
    })?;
    say!("wrote {}\n", arguments.out.display());
    Ok(())
}

/// Logs that nothing is fitted to.
fn held_out(arguments: &Arguments, model: &ModelFile, fitted: &[Log]) -> Result<Vec<Log>> {
    let (_, mut logs) = read_logs(&arguments.held_out)?;
    for log in &logs {
        log.must_be_of(&model.robot, &format!("the model {}", model.path.display()))?;
        let same = |other: &&Log| matches!((log.path.canonicalize(), other.path.canonicalize()), (Ok(a), Ok(b)) if a == b);
        if fitted.iter().any(|other| same(&other)) {
            return Err(miette!(
                help = "A log that was fitted says nothing of how the model does elsewhere.",
                "--held-out {}: this log is also among those to be fitted; expected another log of the same cell",
                log.path.display()
            ));
        }
    }
    // Their trackers may stand elsewhere too.
    find(&mut logs, &baseline(model))?;
    Ok(logs)
}
