//! `trueweld record`: logs of a simulated cell, as a laboratory would record them.

use crate::inputs::read;
use crate::results::{check_empty_folder, check_outputs, check_targets, write};
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::path::PathBuf;
use trueweld_laboratory::ProtocolFile;
use trueweld_plant::input::{Control, Sensors};

/// Arguments of `record`.
#[derive(Args)]
pub struct Arguments {
    /// Protocol file: the cell, its effects, and the logs to record
    protocol: PathBuf,
    /// Folder of the campaign to write; nothing may be in it yet
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Seed of everything random (default: the protocol's)
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// Also write what was built in, to judge answers by
    #[arg(long, value_name = "FILE")]
    truth: Option<PathBuf>,
    /// No progress bar
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let out = &arguments.out;
    check_empty_folder("--out", out)?;
    let truth = arguments.truth.as_deref().map(|path| ("--truth", path));
    check_targets(truth.as_slice())?;
    let mut protocol = ProtocolFile::read(&arguments.protocol)?;
    protocol.seed = arguments.seed.unwrap_or(protocol.seed);
    let control = match protocol.control.clone() {
        Some(control) => control,
        None => read::<Control>(None, &mut Vec::new())?,
    };
    let sensors = match protocol.sensors.clone() {
        Some(sensors) => sensors,
        None => read::<Sensors>(None, &mut Vec::new())?,
    };
    check_outputs(truth.as_slice())?;
    let progress = match arguments.quiet {
        true => trueweld_output::Progress::silent(),
        false => trueweld_output::Progress::new("recording", protocol.logs.len() as f64),
    };
    let done = protocol.record(&control, &sensors, out, &|logs| progress.advance_to(logs as f64));
    progress.finish();
    let text = done.into_diagnostic()?;
    say!(
        "recorded {} log{} of {} into {}, seed {}\n",
        protocol.logs.len(),
        if protocol.logs.len() == 1 { "" } else { "s" },
        protocol.model.robot.name,
        out.display(),
        protocol.seed
    );
    if let Some(path) = &arguments.truth {
        write(path, &text)?;
    }
    Ok(())
}
