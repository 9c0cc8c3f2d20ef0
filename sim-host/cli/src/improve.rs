//! `trueweld improve`: adds what is missing to a model, and writes it.

use crate::inputs::same_file;
use crate::measured::{Budget, Measurements, digests, expect, read_experiments, refuse_mistakes};
use crate::results::{RecordedResults, check_outputs, check_targets};
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::path::{Path, PathBuf};
use trueweld_measure::align::align_clocks;
use trueweld_measure::data::campaign::read_logs;
use trueweld_measure::data::log::Log;
use trueweld_measure::diagnose::reason_of_best;
use trueweld_measure::fit::FitProblem;
use trueweld_measure::improve::{HeldOut, improve, model_file};
use trueweld_measure::mistakes::find;
use trueweld_measure::posterior::{not_bounded, posterior};
use trueweld_measure::residuals::compare::{Notice, baseline, notices, of_each_log, of_logs};
use trueweld_measure::residuals::single_load::single_loads;
use trueweld_output::{ImproveReport, model_comments};
use trueweld_plant::input::{Comments, ModelFile, Posterior};

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
    budget: Budget,
    #[command(flatten)]
    results: RecordedResults,
}

/// Predictions of all logs that an improvement asks for: at least, where nothing is missing, and at
/// most, where two effects are.
const PREDICTIONS: [f64; 2] = [400.0, 1600.0];

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<()> {
    let deadline = arguments.budget.deadline()?;
    let mut outputs = arguments.results.outputs();
    outputs.push(("--out", &arguments.out));
    check_targets(&outputs)?;
    let measured = arguments.measurements.read()?;
    let mut provenance = measured.provenance("improve")?;
    let (model, logs) = (&measured.model, &measured.logs);
    let mut apart = held_out(arguments, model, logs)?;
    provenance.files.extend(digests("held-out log", &apart)?);
    let held_out = if apart.is_empty() {
        None
    } else {
        let experiments = read_experiments(&mut apart, model)?;
        Some(HeldOut::new(model, &apart, experiments))
    };
    check_outputs(&outputs)?;
    if measured.tell_mistakes(&arguments.results.files, &provenance)? {
        let stays =
            if arguments.out.exists() { "; the file there is of an earlier run" } else { "" };
        say!("no improved model is written to {}{stays}\n", arguments.out.display());
        return Ok(());
    }
    let mut bench = FitProblem { deadline, ..FitProblem::new(model, measured.experiments) };
    let progress = arguments.results.files.progress("comparing", 1.0);
    expect(&progress, &mut bench, PREDICTIONS);
    let done = improve(&bench, logs, held_out.as_ref(), &|what, share| progress.stage(what, share));
    progress.finish();
    let improvement = done.into_diagnostic()?;
    let (file, origins) = model_file(&improvement, model, &bench);
    let comments = model_comments(&improvement, model, logs, &origins);
    let posterior = if improvement.is_worse_elsewhere() {
        Err("the values that it would hold predict worse where nothing was fitted".to_owned())
    } else {
        posterior(&bench, logs, &improvement, &model.robot).map_err(|error| error.to_string())
    };
    let posterior = write(&file, posterior, &arguments.out, &comments)?;
    let at = improvement
        .fitted
        .as_ref()
        .map_or(&improvement.diagnosis.before, |fitted| &fitted.residuals);
    let before = of_logs(logs, &bench.logs, &improvement.diagnosis.before);
    let after = of_logs(logs, &bench.logs, at);
    let mut notices = notices(logs, &after, at);
    notices.extend(single_loads(logs, &bench.logs, at));
    notices.extend(measured.found.notices());
    let each_log = &improvement.diagnosis.each_log;
    notices.extend(of_each_log(&model.robot, logs, &bench.per_log, each_log));
    let elsewhere = |step| match &held_out {
        Some(held_out) => held_out.compare(&apart, step).into_diagnostic(),
        None => Ok((Vec::new(), Vec::new())),
    };
    let (given, _) = elsewhere(improvement.first())?;
    let (improved, own) = elsewhere(improvement.last())?;
    notices.extend(own);
    match &posterior {
        Ok(posterior) => {
            let names = not_bounded(posterior, &improvement, &model.robot);
            notices.extend((!names.is_empty()).then_some(Notice::NotBounded(names)));
        }
        Err(why) => notices.push(Notice::NoPosterior(why.clone())),
    }
    let reason = reason_of_best(&bench, logs, &improvement.diagnosis);
    arguments.results.write(&ImproveReport {
        model,
        out: &arguments.out,
        improvement: &improvement,
        posterior: posterior.as_ref().ok(),
        before: &before,
        after: &after,
        held_out: [&given, &improved],
        reason: reason.as_ref(),
        notices: &notices,
        provenance: &provenance,
    })?;
    say!("wrote {}\n", arguments.out.display());
    Ok(())
}

/// Writes an improved model with its posterior, and gives that; without it, and gives why, where
/// there is none or the file with it could not be read back.
fn write(
    file: &ModelFile,
    posterior: Result<Posterior, String>,
    out: &Path,
    comments: &Comments,
) -> Result<Result<Posterior, String>> {
    let written = posterior.and_then(|posterior| {
        let whole = file.clone().with_posterior(posterior.clone());
        let written = whole.and_then(|file| file.write(out, comments));
        written.map(|()| posterior).map_err(|error| error.message().to_owned())
    });
    if written.is_err() {
        file.write(out, comments)?;
    }
    Ok(written)
}

/// Logs that nothing is fitted to.
fn held_out(arguments: &Arguments, model: &ModelFile, fitted: &[Log]) -> Result<Vec<Log>> {
    if arguments.held_out.is_empty() {
        return Ok(Vec::new());
    }
    let (_, mut logs) = read_logs(&arguments.held_out)?;
    for log in &logs {
        log.must_be_of(&model.robot, &format!("the model {}", model.path.display()))?;
        let same = |other: &&Log| same_file(&log.path, &other.path);
        if fitted.iter().any(|other| same(&other)) {
            return Err(miette!(
                help = "A log that was fitted says nothing of how the model does elsewhere.",
                "--held-out {}: this log is also among those to be fitted; expected another log of the same cell",
                log.path.display()
            ));
        }
    }
    align_clocks(&mut logs, &baseline(model)).into_diagnostic()?;
    // Their trackers may stand elsewhere too.
    let found = find(&mut logs, &baseline(model))?;
    refuse_mistakes("--held-out", &found, model)?;
    Ok(logs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::effects::EffectKind;
    use trueweld_plant::input::MeasuredNumber;

    #[test]
    fn a_posterior_that_cannot_be_read_back_costs_the_posterior_and_not_the_model() {
        let given = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/models/cable-drag.toml");
        let model = ModelFile::read(given).unwrap();
        let kind = EffectKind::of("counterbalance-loss").unwrap();
        let at = kind.places()[0];
        let posterior = |variance: f64| Posterior {
            numbers: vec![MeasuredNumber {
                kind,
                at,
                occurrence: 0,
                parameter: 0,
                value: 0.1,
                between_logs: 0.0,
            }],
            covariance: vec![variance],
            logs: vec!["a log".to_owned()],
            campaign: "00".to_owned(),
            score: 1.0,
            at_bound: Vec::new(),
            undetermined: Vec::new(),
            not_measured: Vec::new(),
            seal: String::new(),
        };
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("improved.toml");
        let written = |posterior| write(&model, posterior, &out, &Comments::default());
        let read = || ModelFile::read(&out).unwrap();
        assert!(written(Ok(posterior(1e-6))).unwrap().is_ok());
        assert!(read().posterior.is_some());
        for none in [Ok(posterior(f64::NAN)), Ok(posterior(-1e-6)), Err("no time".to_owned())] {
            let why = written(none.clone()).unwrap().unwrap_err();
            assert!(why.contains(none.map_or("no time", |_| "covariance")), "{why}");
            assert!(read().posterior.is_none());
            assert_eq!(read().effects.len(), model.effects.len());
        }
        // Where the model itself cannot be written there is none.
        let out = folder.path().join("none/improved.toml");
        assert!(write(&model, Ok(posterior(1e-6)), &out, &Comments::default()).is_err());
    }
}
