//! What the commands about measurements work on: a model, and logs made ready to be compared with
//! it.

use crate::inputs::of_program;
use crate::results::Results;
use clap::Args;
use miette::{IntoDiagnostic, Result, miette};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use trueweld_measure::align::align_clocks;
use trueweld_measure::data::campaign::read_logs;
use trueweld_measure::data::log::Log;
use trueweld_measure::fit::{FitProblem, FitState, residuals};
use trueweld_measure::mistakes::{Found, find};
use trueweld_measure::predict::PreparedLog;
use trueweld_measure::residuals::compare::{baseline, of_comparable};
use trueweld_output::{MistakesReport, Progress, mistake_in_words};
use trueweld_plant::input::ModelFile;
use trueweld_plant::provenance::{EffectRecord, FileDigest, Provenance};

/// A model and logs.
#[derive(Args)]
pub struct Measurements {
    /// Model file (default: the campaign's)
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Folders of logs or of campaigns
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
}

/// How long a command may take.
#[derive(Args)]
pub struct Budget {
    /// Time after which no new work is begun: the best answer so far is given, and what was left
    /// undone (default: none)
    #[arg(long = "budget", value_name = "SECONDS")]
    seconds: Option<f64>,
}

impl Budget {
    /// When the time is up, from now on.
    pub fn deadline(&self) -> Result<Option<Instant>> {
        let Some(seconds) = self.seconds else { return Ok(None) };
        let time = Duration::try_from_secs_f64(seconds).ok();
        match time.and_then(|time| Instant::now().checked_add(time)) {
            Some(deadline) => Ok(Some(deadline)),
            None => Err(miette!(
                help = "Give the time in seconds, such as --budget 60.",
                "--budget {seconds}: expected a number of seconds from 0 on"
            )),
        }
    }
}

/// Predictions of all logs that come after the time is up: what is under way, and the conclusion.
const CLOSING: u32 = 20;

/// Says how long work on a bench will take that asks for between so many predictions of all its
/// logs, by the time that one takes on this machine; where there is a budget, time to conclude is
/// kept back.
pub fn expect(progress: &Progress, bench: &mut FitProblem, [least, most]: [f64; 2]) {
    let begun = Instant::now();
    if residuals(bench, &FitState::empty(bench.logs.len())).is_ok() {
        let one = begun.elapsed();
        progress.expect(least * one.as_secs_f64(), most * one.as_secs_f64());
        bench.deadline =
            bench.deadline.map(|time| time.checked_sub(CLOSING * one).unwrap_or(begun));
    }
}

/// Everything read, checked and made ready.
pub struct Measured {
    pub model: ModelFile,
    pub logs: Vec<Log>,
    /// In the order of the logs; none where there are mistakes in the files.
    pub experiments: Vec<PreparedLog>,
    /// What was found before any physics.
    pub found: Found,
}

impl Measurements {
    /// Of a model file and folders of logs.
    pub fn new(model: Option<PathBuf>, logs: Vec<PathBuf>) -> Self {
        Self { model, logs }
    }

    /// Reads the logs, looks for gross mistakes in them, and makes them ready.
    pub fn read(&self) -> Result<Measured> {
        let (model, mut logs) = self.read_files()?;
        // Before the tracker's frame is taken out: a clock is found whatever the frame.
        let aligned = align_clocks(&mut logs, &baseline(&model)).into_diagnostic();
        let found = find(&mut logs, &baseline(&model))?;
        if found.mistakes.is_empty() {
            aligned?;
        }
        let experiments = match found.mistakes.as_slice() {
            [] => read_experiments(&mut logs, &model)?,
            _ => Vec::new(),
        };
        Ok(Measured { model, logs, experiments, found })
    }

    /// Model and logs as the files have them.
    pub fn read_files(&self) -> Result<(ModelFile, Vec<Log>)> {
        // Before the logs, of which there may be gigabytes.
        let given = self.model.as_ref().map(ModelFile::read).transpose()?;
        let (campaign, logs) = read_logs(&self.logs)?;
        let model = match (given, campaign) {
            (Some(model), _) => model,
            (None, Some(path)) => ModelFile::read(path)?,
            (None, None) => {
                return Err(miette!(
                    help = "Give the model that the logs are to be compared with: --model model.toml. Only a campaign names its own, \
                            and several campaigns may name different ones.",
                    "--model is missing; expected a model file"
                ));
            }
        };
        for log in &logs {
            log.must_be_of(&model.robot, &format!("the model {}", model.path.display()))?;
        }
        Ok((model, logs))
    }
}

impl Measured {
    /// Tells of mistakes in the files, if there are any: true where there is nothing else to tell.
    pub fn tell_mistakes(&self, results: &Results, provenance: &Provenance) -> Result<bool> {
        if self.found.mistakes.is_empty() {
            return Ok(false);
        }
        let report = MistakesReport { model: &self.model, found: &self.found, provenance };
        results.write(&report)?;
        Ok(true)
    }

    /// What a result of these measurements is of.
    pub fn provenance(&self, command: &str) -> Result<Provenance> {
        provenance(command, &self.model, &self.logs)
    }
}

/// Refuses logs with mistakes in them, where nothing can be said of these. `what`: the logs.
pub fn refuse_mistakes(what: &str, found: &Found, model: &ModelFile) -> Result<()> {
    let Some(first) = found.mistakes.first() else { return Ok(()) };
    let [sentence, help] = mistake_in_words(first, &model.robot.joint_names);
    Err(miette!(help = help, "{what}: a mistake in the files: {sentence}"))
}

/// What a result of a model and logs is of.
pub fn provenance(command: &str, model: &ModelFile, logs: &[Log]) -> Result<Provenance> {
    let mut files = FileDigest::of_model(model)?;
    files.extend(digests("log", logs)?);
    let effects = model.effects.iter();
    Ok(Provenance {
        robot: model.robot.name.clone(),
        effects: effects.map(|e| EffectRecord::new(&e.effect, &model.robot)).collect(),
        files,
        ..of_program(command)
    })
}

/// Digests of the files of logs, each file once.
pub fn digests(role: &str, logs: &[Log]) -> Result<Vec<FileDigest>> {
    let mut paths: Vec<&PathBuf> = Vec::new();
    for path in logs.iter().flat_map(|log| &log.files) {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
    Ok(paths.into_iter().map(|p| FileDigest::of_file(role, p)).collect::<Result<_, _>>()?)
}

/// Logs made ready to be compared with a model; those that have nothing to compare are taken out of
/// `logs`.
pub fn read_experiments(logs: &mut Vec<Log>, model: &ModelFile) -> Result<Vec<PreparedLog>> {
    of_comparable(logs, &baseline(model)).into_diagnostic()
}
