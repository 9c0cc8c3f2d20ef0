//! `trueweld compare`: how far a model is from measurements, or a log from another, and where.

use crate::measured::{LogArguments, tell_mistakes};
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::{Result, miette};
use trueweld::{ComparedPair, compare, compare_logs};
use trueweld_output::{CompareLogsReport, CompareReport};

/// Arguments of `compare`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    measurements: LogArguments,
    #[command(flatten)]
    results: RecordedResults,
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    if let Some([first, second]) = arguments.measurements.pair() {
        if let Some((flag, _)) =
            outputs.iter().find(|(flag, _)| ["--rrd", "--samples"].contains(flag))
        {
            return Err(miette!(
                help = "Without a model two logs are compared with each other. Leave it out, or name a model: --model model.toml.",
                "{flag}: expected none for two logs without a model, whose result is figures and pictures"
            ));
        }
        let ComparedPair { logs, pair, provenance } = compare_logs(first, second)?;
        check_outputs(&outputs)?;
        let report = CompareLogsReport { logs: &logs, pair: &pair, provenance: &provenance };
        return arguments.results.files.write(&report);
    }
    let measured = arguments.measurements.read()?;
    check_outputs(&outputs)?;
    let provenance = measured.provenance("compare")?;
    if tell_mistakes(&measured, &arguments.results.files, &provenance)? {
        return Ok(());
    }
    let rows: Vec<usize> = measured.logs.iter().map(|log| log.samples.time.len()).collect();
    let progress = arguments.results.files.progress("comparing", rows.iter().sum::<usize>() as f64);
    let compared = compare(&measured, &|k: usize| progress.advance_by(rows[k]));
    progress.finish();
    let comparison = compared?;
    arguments.results.write(&CompareReport {
        model: &measured.model.path,
        comparison: &comparison,
        provenance: &provenance,
    })
}
