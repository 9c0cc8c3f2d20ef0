//! `trueweld record`: logs of a simulated cell, as a laboratory would record them.

use crate::results::{FormFiles, Results, check_empty_folder, check_outputs, check_targets, write};
use clap::Args;
use miette::{IntoDiagnostic, Result};
use std::path::{Path, PathBuf};
use trueweld::{control_and_sensors, measured_provenance};
use trueweld_laboratory::ProtocolFile;
use trueweld_logs::campaign::Campaign;
use trueweld_output::{RecordReport, RecordedLog};
use trueweld_plant::input::ModelFile;
use trueweld_plant::provenance::{EffectRecord, FileDigest};

/// Arguments of `record`.
#[derive(Args)]
pub(crate) struct Arguments {
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
    /// Write what was recorded as JSON; `-` writes it to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    forms: FormFiles,
    /// No progress bar
    #[arg(long, short)]
    quiet: bool,
}

/// A campaign that is being recorded. Half a campaign is none: where it does not become whole, also
/// where a session stops it, its folder, which was empty before, is removed.
struct HalfCampaign<'a> {
    folder: &'a Path,
    is_whole: bool,
}

impl Drop for HalfCampaign<'_> {
    fn drop(&mut self) {
        if !self.is_whole {
            // What cannot be removed stays, as it does where the program is killed.
            let _ = std::fs::remove_dir_all(self.folder);
        }
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let out = &arguments.out;
    check_empty_folder("--out", out)?;
    let results = Results {
        json: arguments.json.clone(),
        forms: arguments.forms.clone(),
        samples: None,
        quiet: arguments.quiet,
    };
    let mut outputs = results.outputs();
    outputs.extend(arguments.truth.as_deref().map(|path| ("--truth", path)));
    check_targets(&outputs)?;
    let mut protocol = ProtocolFile::read(&arguments.protocol)?;
    protocol.seed = arguments.seed.unwrap_or(protocol.seed);
    let (control, sensors) = control_and_sensors(&protocol)?;
    check_outputs(&outputs)?;
    let progress = results.progress("recording", protocol.logs.len() as f64);
    let mut half = HalfCampaign { folder: out, is_whole: false };
    let done = protocol.record(&control, &sensors, out, &|logs| progress.advance_to(logs as f64));
    progress.finish();
    let truth = done.into_diagnostic()?;
    half.is_whole = true;
    let recorded = Campaign::read(out)?;
    let mut provenance =
        measured_provenance("record", &ModelFile::read(recorded.model)?, &recorded.logs)?;
    let robot = &protocol.model.robot;
    provenance.effects.extend(protocol.effects.iter().map(|e| EffectRecord::new(e, robot)));
    provenance.files.insert(0, FileDigest::of_file("protocol", &arguments.protocol)?);
    results.write(&RecordReport {
        folder: out,
        robot: &robot.name,
        seed: protocol.seed,
        logs: &recorded.logs.iter().map(RecordedLog::of).collect::<Vec<_>>(),
        provenance: &provenance,
    })?;
    if let Some(path) = &arguments.truth {
        write(path, &truth)?;
    }
    Ok(())
}
