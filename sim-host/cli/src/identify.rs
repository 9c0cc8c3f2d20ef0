//! `trueweld identify`: stiffness, damping and process of a cell from its logs.

use crate::measured::{Measurements, provenance};
use crate::results::{Results, check_outputs, check_targets, write};
use clap::{Args, Subcommand};
use miette::{IntoDiagnostic, Result};
use std::path::PathBuf;
use trueweld_identify::{IdentifyError, Target, file, identify};
use trueweld_output::{IdentifyReport, MistakesReport, identified_head, identified_source};

/// Arguments of `identify`.
#[derive(Args)]
pub struct Arguments {
    #[command(subcommand)]
    what: What,
}

#[derive(Subcommand)]
enum What {
    /// Stiffness of the joints, from loads at rest
    Stiffness(Identified),
    /// Damping of the joints, from ring-downs after a brake's stop
    Damping(Identified),
}

#[derive(Args)]
struct Identified {
    #[command(flatten)]
    measurements: Measurements,
    /// Where to write the robot file with the numbers found
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    results: Results,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    match &arguments.what {
        What::Stiffness(arguments) => arguments.run(Target::Stiffness),
        What::Damping(arguments) => arguments.run(Target::Damping),
    }
}

impl Identified {
    fn run(&self, target: Target) -> Result<()> {
        let mut outputs = self.results.outputs();
        outputs.extend(self.out.as_deref().map(|path| ("--out", path)));
        check_targets(&outputs)?;
        let (model, logs) = self.measurements.read_files()?;
        let provenance = provenance(&format!("identify {}", target.name()), &model, &logs)?;
        check_outputs(&outputs)?;
        let progress = self.results.progress("fitting", 1.0);
        let done = identify(target, &model, logs, &|stage, share| progress.stage(stage, share));
        progress.finish();
        let found = match done {
            Err(IdentifyError::Mistakes(found)) => {
                let report =
                    MistakesReport { model: &model, found: &found, provenance: &provenance };
                return self.results.write(&report);
            }
            other => other.into_diagnostic()?,
        };
        let report = IdentifyReport { model: &model, found: &found, provenance: &provenance };
        self.results.write(&report)?;
        if let Some(out) = &self.out {
            let head = identified_head(&report);
            let source = |number: &_| identified_source(&report, number);
            write(out, &file::robot_text(&found, out, &source, &head)?)?;
        }
        Ok(())
    }
}
