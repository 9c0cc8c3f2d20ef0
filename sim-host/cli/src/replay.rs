//! `trueweld replay`: a recorded run of a controller's core, period for period on this machine.

use crate::results::{FormFiles, Results, check_outputs, check_targets};
use clap::{Args, ValueEnum};
use miette::{Result, miette};
use std::path::PathBuf;
use trueweld::{CoreFile, of_program, read_core_log};
use trueweld_evaluate::CoreScalar;
use trueweld_output::CoreReplayReport;
use trueweld_plant::provenance::Provenance;

/// Arguments of `replay`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// The core: cell.h of `export-core`, or the folder it is in
    #[arg(value_name = "CORE")]
    core: PathBuf,
    /// Folder with inputs.bin and outputs.bin of the run
    #[arg(value_name = "LOG")]
    log: PathBuf,
    /// In what the recorded core computed
    #[arg(long, value_enum, default_value_t = RecordedScalar::Double)]
    scalar: RecordedScalar,
    /// Write the figures as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    forms: FormFiles,
}

/// [`CoreScalar`] on the command line.
#[derive(Clone, Copy, ValueEnum)]
enum RecordedScalar {
    /// Single precision
    Float,
    /// Double precision
    Double,
}

/// Runs the command; its status is 1 where the runs differ.
pub(crate) fn run(arguments: &Arguments) -> Result<u8> {
    let Arguments { json, forms, .. } = arguments;
    let results = Results { json: json.clone(), forms: forms.clone(), ..Results::default() };
    let outputs = results.outputs();
    check_targets(&outputs)?;
    let core = CoreFile::read(&arguments.core)?;
    let (run, files) = read_core_log(&arguments.log)?;
    check_outputs(&outputs)?;
    let scalar = match arguments.scalar {
        RecordedScalar::Float => CoreScalar::Float,
        RecordedScalar::Double => CoreScalar::Double,
    };
    let replay = run.replay(&core.configuration, scalar).map_err(|error| {
        miette!(
            "{}: no core can be built from it: {error:?}; expected {} of this version",
            core.file.file,
            "cell.h as `export-core` writes it"
        )
    })?;
    let files = std::iter::once(core.file).chain(files).collect();
    let provenance = Provenance { files, ..of_program("replay") };
    results.write(&CoreReplayReport { replay: &replay, provenance: &provenance })?;
    Ok(u8::from(replay.first.is_some()))
}
