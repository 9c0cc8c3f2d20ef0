//! Measurements and the model that they judge: read, checked for gross mistakes, made ready.

use crate::cell::is_same_file;
use crate::provenance::of_program;
use miette::{IntoDiagnostic, Result, miette};
use std::path::{Path, PathBuf};
use std::time::Instant;
use trueweld_diagnose::DiagnosisFits;
use trueweld_diagnose::improve::HeldOut;
use trueweld_estimate::align::align_clocks;
use trueweld_estimate::fit::{FitProblem, FitState, residuals};
use trueweld_estimate::log_faults::{Found, find};
use trueweld_estimate::outlying_loads::leave_out_outlying_loads;
use trueweld_estimate::predict::Prediction;
use trueweld_estimate::residuals::compare::{
    LogComparison, Notice, baseline, experiments, notices, of_comparable, of_each_log, of_logs,
};
use trueweld_estimate::residuals::single_load::single_loads;
use trueweld_logs::campaign::read_logs;
use trueweld_logs::log::Log;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{ModelEffect, ModelFile, Scope};
use trueweld_plant::provenance::{EffectRecord, FileDigest, Provenance};

/// A model and logs as their files have them.
pub struct GivenLogs {
    /// The model.
    pub model: ModelFile,
    /// The logs; SI units, frames as their files have them.
    pub logs: Vec<Log>,
}

impl GivenLogs {
    /// Reads folders of logs or of campaigns. `model`: a model file; where none is given, that of the
    /// campaign.
    ///
    /// # Errors
    /// A file that cannot be used, at its place; a log of another robot; no model, or several.
    pub fn read(model: Option<&Path>, folders: &[PathBuf]) -> Result<Self> {
        // Before the logs, of which there may be gigabytes.
        let given = model.map(ModelFile::read).transpose()?;
        let (campaign, logs) = read_logs(folders)?;
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
        must_be_of(&logs, &model)?;
        Ok(Self { model, logs })
    }

    /// What a result of these logs is of.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn provenance(&self, command: &str) -> Result<Provenance> {
        measured_provenance(command, &self.model, &self.logs)
    }

    /// Looks for gross mistakes in the logs, and makes them ready to be compared with the model.
    ///
    /// # Errors
    /// Clocks that cannot be aligned; a log that the model cannot be driven through.
    pub fn prepare(self) -> Result<MeasuredLogs> {
        let Self { mut model, mut logs } = self;
        let (found, mut problem) = ready(&model, &mut logs)?;
        state_found_factors(&mut model, &mut problem);
        Ok(MeasuredLogs { model, logs, found, problem })
    }
}

/// Looks for gross mistakes in logs, and makes them ready to be compared with a model; none where
/// there are mistakes.
fn ready(model: &ModelFile, logs: &mut Vec<Log>) -> Result<(Found, FitProblem)> {
    let baseline = baseline(model);
    // Before the tracker's frame is taken out: a clock is found whatever the frame.
    let aligned = align_clocks(logs, &baseline).into_diagnostic();
    let found = find(logs, &baseline)?;
    if !found.mistakes.is_empty() {
        return Ok((found, FitProblem::new(model, Vec::new())));
    }
    aligned?;
    let mut problem = FitProblem::new(model, of_comparable(logs, &baseline).into_diagnostic()?);
    if leave_out_outlying_loads(&problem, logs).into_diagnostic()? {
        problem = FitProblem::new(model, experiments(logs, &baseline).into_diagnostic()?);
    }
    Ok((found, problem))
}

/// States in a model the torque constants that were found, so that what is improved, and logs held
/// out, have the same ones.
fn state_found_factors(model: &mut ModelFile, problem: &mut FitProblem) {
    let stated = |effect: &Effect| ModelEffect { effect: effect.clone(), scope: Scope::Campaign };
    let found = problem.open_factors(&baseline(model).torque_constants);
    model.effects.extend(found.iter().map(stated));
    problem.known.extend(found);
}

fn must_have_no_mistakes(found: &Found) -> Result<()> {
    match found.mistakes.len() {
        0 => Ok(()),
        count => Err(miette!(
            help = "`found` says what they are: mend the files, and read them again.",
            "mistakes in the files of the logs: {count}; expected none, since they come before any physics"
        )),
    }
}

pub(crate) fn must_be_of(logs: &[Log], model: &ModelFile) -> Result<()> {
    for log in logs {
        log.must_be_of(&model.robot, &format!("the model {}", model.path.display()))?;
    }
    Ok(())
}

/// A model and logs made ready to be compared with it.
///
/// ```no_run
/// use trueweld::{MeasuredLogs, diagnose};
///
/// let mut measured = MeasuredLogs::read("my-campaign")?;
/// let told = diagnose(&mut measured).run()?;
/// println!("{}", told.diagnosis.verdict.name());
/// # Ok::<(), miette::Report>(())
/// ```
pub struct MeasuredLogs {
    /// The model.
    pub model: ModelFile,
    /// The logs that have something to compare.
    pub logs: Vec<Log>,
    /// What was found before any physics: where it holds mistakes, nothing can be said but them.
    pub found: Found,
    /// The logs as they are compared and fitted; none where there are mistakes.
    pub problem: FitProblem,
}

/// Logs under the model as it was given and under a better one.
pub(crate) struct ComparedLogs {
    pub before: Vec<LogComparison>,
    pub after: Vec<LogComparison>,
    pub notices: Vec<Notice>,
}

/// Predictions of all logs that come after the time is up: what is under way, and the conclusion.
const CLOSING_PREDICTIONS: u32 = 20;

impl MeasuredLogs {
    /// Reads a campaign, whose folder names its model, and makes it ready.
    ///
    /// # Errors
    /// Those of [`GivenLogs::read`] and [`GivenLogs::prepare`].
    pub fn read(campaign: impl Into<PathBuf>) -> Result<Self> {
        GivenLogs::read(None, &[campaign.into()])?.prepare()
    }

    /// What a result of these logs is of.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub fn provenance(&self, command: &str) -> Result<Provenance> {
        measured_provenance(command, &self.model, &self.logs)
    }

    /// # Errors
    /// Mistakes in the files.
    pub(crate) fn must_be_usable(&self) -> Result<()> {
        must_have_no_mistakes(&self.found)
    }

    /// The logs before a diagnosis and under `best`, and what a person should know of both.
    pub(crate) fn compared(&self, fits: &DiagnosisFits, best: &[Prediction]) -> ComparedLogs {
        let Self { model, logs, found, problem } = self;
        let before = of_logs(logs, &problem.logs, &fits.before);
        let after = of_logs(logs, &problem.logs, best);
        let mut notices = notices(logs, &after, best);
        notices.extend(single_loads(logs, &problem.logs, best));
        notices.extend(found.notices());
        notices.extend(of_each_log(&model.robot, logs, &problem.per_log, &fits.each_log));
        ComparedLogs { before, after, notices }
    }

    /// How long work will take that asks for between so many predictions of all logs, s, by the time
    /// that one takes on this machine; `None` where none can be made. Where there is a deadline, time
    /// to conclude is kept back.
    pub(crate) fn expect(&mut self, [least, most]: [f64; 2]) -> Option<[f64; 2]> {
        let problem = &mut self.problem;
        let begun = Instant::now();
        residuals(problem, &FitState::empty(problem.logs.len())).ok()?;
        let one = begun.elapsed();
        problem.deadline = problem
            .deadline
            .map(|time| time.checked_sub(CLOSING_PREDICTIONS * one).unwrap_or(begun));
        Some([least * one.as_secs_f64(), most * one.as_secs_f64()])
    }
}

/// What a result of a model and logs is of.
///
/// # Errors
/// A file that cannot be read any more.
pub fn measured_provenance(command: &str, model: &ModelFile, logs: &[Log]) -> Result<Provenance> {
    let mut files = FileDigest::of_model(model)?;
    files.extend(log_digests("log", logs)?);
    let effects = model.effects.iter();
    Ok(Provenance {
        robot: model.robot.name.clone(),
        effects: effects.map(|e| EffectRecord::new(&e.effect, &model.robot)).collect(),
        files,
        ..of_program(command)
    })
}

/// Digests of the files of logs, each file once.
pub(crate) fn log_digests(role: &str, logs: &[Log]) -> Result<Vec<FileDigest>> {
    let mut paths: Vec<&PathBuf> = Vec::new();
    for path in logs.iter().flat_map(|log| &log.files) {
        if !paths.contains(&path) {
            paths.push(path);
        }
    }
    Ok(paths.into_iter().map(|p| FileDigest::of_file(role, p)).collect::<Result<_, _>>()?)
}

/// Logs by which a model is judged and to which nothing is fitted.
pub struct HeldOutLogs {
    /// The logs that have something to compare.
    pub logs: Vec<Log>,
    /// What was found before any physics.
    pub found: Found,
    /// The files that were read.
    pub files: Vec<FileDigest>,
    pub(crate) held_out: HeldOut,
}

impl HeldOutLogs {
    /// Reads folders of logs or of campaigns, of the same robot as those that are fitted.
    ///
    /// # Errors
    /// A file that cannot be used, at its place; a log of another robot, or one that is also fitted.
    pub fn read(folders: &[PathBuf], fitted: &MeasuredLogs) -> Result<Self> {
        let model = &fitted.model;
        let (_, mut logs) = read_logs(folders)?;
        for log in &logs {
            must_be_of(std::slice::from_ref(log), model)?;
            if fitted.logs.iter().any(|other| is_same_file(&log.path, &other.path)) {
                return Err(miette!(
                    help = "A log that was fitted says nothing of how the model does elsewhere.",
                    "--held-out {}: this log is also among those to be fitted; expected another log of the same cell",
                    log.path.display()
                ));
            }
        }
        // Their trackers may stand elsewhere too.
        let (found, problem) = ready(model, &mut logs)?;
        let files = log_digests("held-out log", &logs)?;
        let held_out = HeldOut::new(model, &logs, problem.logs);
        Ok(Self { logs, found, files, held_out })
    }

    /// # Errors
    /// Mistakes in the files.
    pub(crate) fn must_be_usable(&self) -> Result<()> {
        must_have_no_mistakes(&self.found)
    }
}
