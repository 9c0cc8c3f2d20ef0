//! `trueweld export-core`: the constants that a controller's core is built from.

use crate::inputs::WeldArguments;
use crate::names::{ControllerParser, LawParser};
use crate::results::{check_empty_folder, check_outputs};
use clap::Args;
use miette::{IntoDiagnostic, Result, WrapErr};
use std::fs;
use std::path::PathBuf;
use std::slice;
use trueweld::{PLANT_STEP, record_core, write_core_log};
use trueweld_compensators::Entry;
use trueweld_output::write_file;
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::provenance::Provenance;
use trueweld_plant::simulate::WeldProgram;

/// Arguments of `export-core`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Compensation law; no combination
    #[arg(long, value_name = "LAW", value_parser = LawParser)]
    compensator: Entry,
    /// Folder for cell.rs and cell.h
    #[arg(long, value_name = "FOLDER", default_value = "out/core")]
    out: PathBuf,
    /// New folder for what the core is given and commands in every period of the simulated weld, as
    /// `replay` reads it
    #[arg(long, value_name = "FOLDER")]
    log: Option<PathBuf>,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    arguments.log.iter().try_for_each(|folder| check_empty_folder("--log", folder))?;
    let inputs = arguments.files.read()?;
    let controller = arguments.controller;
    let law = &arguments.compensator;
    let scenario = inputs.scenario(WeldProgram::Weld, controller, law);
    let constants = scenario.constants().into_diagnostic()?;
    let simulation = inputs.simulation(&[controller], slice::from_ref(law), 1, PLANT_STEP);
    let heading = heading(&inputs.provenance("export-core", simulation), law);
    fs::create_dir_all(&arguments.out)
        .into_diagnostic()
        .wrap_err_with(|| format!("cannot make the folder {}", arguments.out.display()))?;
    let [rust, header] = ["cell.rs", "cell.h"].map(|file| arguments.out.join(file));
    check_outputs(&[("--out", &rust), ("--out", &header)])?;
    let configuration = &constants.configuration;
    for (path, text) in [
        (rust, configuration.rust_source(&heading)),
        (header, configuration.c_header(&heading, constants.bytes)),
    ] {
        write_file(&path, text)?;
        say!("wrote {}\n", path.display());
    }
    let [single, double] = constants.bytes;
    if !inputs.informed && !inputs.effects.is_empty() {
        let effects = inputs.effects.iter().map(|e| e.name(&inputs.robot)).collect::<Vec<_>>();
        say!("without {}: --informed includes what a core can hold\n", effects.join(", "));
    }
    say!(
        "digest of the core   {}\nmemory in C, bytes   {single} in float, {double} in double\n",
        configuration.digest_text()
    );
    if let Some(folder) = &arguments.log {
        let run = record_core(&inputs, controller, law)?;
        write_core_log(folder, &run)?;
        say!("wrote {} periods into {}\n", run.periods.len(), folder.display());
    }
    Ok(())
}

/// What the constants are of.
fn heading(of: &Provenance, law: &Entry) -> String {
    let files = of.files.iter().map(|f| format!("{} {} {}", f.role, f.file, f.sha256));
    let lines = [
        format!("Written by trueweld {} export-core: do not edit.", of.version),
        format!("{}, law {}.", of.robot, law.name()),
    ];
    lines.into_iter().chain(files).collect::<Vec<_>>().join("\n")
}
