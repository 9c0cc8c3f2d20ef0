//! `trueweld register`: where the tracker stands, and what it sees of the tool.

use crate::measured::{LogArguments, refuse_mistakes};
use crate::results::{Results, check_outputs, check_targets};
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr, miette};
use std::fs;
use trueweld::{GivenLogs, measured_provenance};
use trueweld_estimate::align::align_clocks;
use trueweld_estimate::log_faults::{find, registrations};
use trueweld_estimate::residuals::compare::baseline;
use trueweld_logs::log::LOG_FILE;
use trueweld_output::{RegisterReport, tracker_table, write_file};

/// Arguments of `register`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    measurements: LogArguments,
    /// Write what was found into the log.toml of each log, as its table [tracker]
    #[arg(long)]
    write: bool,
    #[command(flatten)]
    results: Results,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let GivenLogs { model, mut logs } = arguments.measurements.read_files()?;
    align_clocks(&mut logs, &baseline(&model)).into_diagnostic()?;
    check_outputs(&outputs)?;
    let files: Vec<_> = logs.iter().map(|log| log.path.join(LOG_FILE)).collect();
    let written: Vec<_> = files.iter().map(|file| ("--write", file.as_path())).collect();
    check_targets(if arguments.write { &written } else { &[] })?;
    refuse_mistakes("register", &find(&mut logs.clone(), &baseline(&model))?, &model)?;
    if let Some(log) = logs.iter().find(|log| arguments.write && log.origin.is_registered()) {
        return Err(miette!(
            help = "What was found is on top of it. Remove the table, and register again.",
            "{}: there is a table [tracker] already; expected none",
            log.path.join(LOG_FILE).display()
        ));
    }
    let registered = registrations(&logs, &baseline(&model));
    if registered.is_empty() {
        return Err(miette!(
            help = "Record rows in several postures, or the tracker's rotation.",
            "no log tells where the tracker stands; expected tracker columns and poses apart from each other"
        ));
    }
    let provenance = measured_provenance("register", &model, &logs)?;
    let report = RegisterReport { model: &model, registered: &registered, provenance: &provenance };
    arguments.results.write(&report)?;
    for registered in registered.iter().filter(|_| arguments.write) {
        let table = tracker_table(&registered.registration.mounting);
        let mut of_logs: Vec<_> =
            logs.iter().filter(|l| registered.logs.contains(&l.name)).collect();
        // A log that gaps cut into pieces has one file.
        of_logs.dedup_by_key(|log| &log.path);
        for log in of_logs {
            let file = log.path.join(LOG_FILE);
            let text = fs::read_to_string(&file)
                .into_diagnostic()
                .wrap_err_with(|| format!("cannot read {}", file.display()))?;
            write_file(&file, format!("{}\n\n{table}", text.trim_end()))?;
            say!("wrote {}\n", file.display());
        }
    }
    Ok(())
}
