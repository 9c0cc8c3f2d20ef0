//! `trueweld register`: where the tracker stands, and what it sees of the tool.

use crate::measured::Measurements;
use crate::results::{Results, check_outputs, check_targets};
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::fs;
use trueweld_measure::align::align_clocks;
use trueweld_measure::data::log::LOG_FILE;
use trueweld_measure::mistakes::registrations;
use trueweld_measure::residuals::compare::baseline;
use trueweld_output::{RegisterReport, tracker_table, write_file};

/// Arguments of `register`.
#[derive(Args)]
pub struct Arguments {
    #[command(flatten)]
    measurements: Measurements,
    /// Write what was found into the log.toml of each log, as its table [tracker]
    #[arg(long)]
    write: bool,
    #[command(flatten)]
    results: Results,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let (model, mut logs) = arguments.measurements.read_files()?;
    align_clocks(&mut logs, &baseline(&model)).into_diagnostic()?;
    check_outputs(&outputs)?;
    let files: Vec<_> = logs.iter().map(|log| log.path.join(LOG_FILE)).collect();
    let written: Vec<_> = files.iter().map(|file| ("--write", file.as_path())).collect();
    check_targets(if arguments.write { &written } else { &[] })?;
    let registered = registrations(&logs, &baseline(&model));
    if registered.is_empty() {
        return Err(miette!(
            help = "Record rows in several postures, or the tracker's rotation.",
            "no log tells where the tracker stands; expected tracker columns and poses apart from each other"
        ));
    }
    let provenance = crate::measured::provenance("register", &model, &logs)?;
    let report = RegisterReport { model: &model, registered: &registered, provenance: &provenance };
    arguments.results.write(&report)?;
    for registered in registered.iter().filter(|_| arguments.write) {
        let table = tracker_table(&registered.registration.mounting);
        for log in logs.iter().filter(|log| registered.logs.contains(&log.name)) {
            let file = log.path.join(LOG_FILE);
            let text = fs::read_to_string(&file)
                .into_diagnostic()
                .wrap_err_with(|| format!("cannot read {}", file.display()))?;
            if text.lines().any(|line| line.trim() == "[tracker]") {
                return Err(miette!(
                    help = "What was found is on top of it. Remove the table, and register again.",
                    "{}: there is a table [tracker] already; expected none",
                    file.display()
                ));
            }
            write_file(&file, format!("{}\n\n{table}", text.trim_end()))?;
            say!("wrote {}\n", file.display());
        }
    }
    Ok(())
}
