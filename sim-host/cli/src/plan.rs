//! `trueweld plan`: what experiments would show of each effect, before any is made.

use crate::results::{FormFiles, Results, check_outputs, check_targets};
use clap::Args;
use miette::Result;
use std::path::PathBuf;
use trueweld::{measured_provenance, plan};
use trueweld_laboratory::ProtocolFile;
use trueweld_output::{PlanReport, RecordedLog};
use trueweld_plant::provenance::FileDigest;

/// Arguments of `plan`.
#[derive(Args)]
pub(crate) struct Arguments {
    /// Protocol file: the cell and the experiments
    protocol: PathBuf,
    /// Robot file, in place of the protocol's
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Write the figures as JSON; `-` writes them to standard output, and the text to standard error
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    forms: FormFiles,
    /// No progress bar
    #[arg(long, short)]
    quiet: bool,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let results = Results {
        json: arguments.json.clone(),
        forms: arguments.forms.clone(),
        samples: None,
        quiet: arguments.quiet,
    };
    check_targets(&results.outputs())?;
    let protocol = ProtocolFile::read_for(&arguments.protocol, arguments.robot.as_deref())?;
    check_outputs(&results.outputs())?;
    let model = protocol.model.clone();
    let mut provenance = measured_provenance("plan", &model, &[])?;
    provenance.files.insert(0, FileDigest::of_file("protocol", &arguments.protocol)?);
    let progress = results.progress("simulating", 1.0);
    let planned = plan(protocol, &|what, share| progress.stage(what, share));
    progress.finish();
    let planned = planned?;
    results.write(&PlanReport {
        model: &model,
        logs: &planned.logs.iter().map(RecordedLog::of).collect::<Vec<_>>(),
        detectability: &planned.detectability,
        provenance: &provenance,
    })
}
