//! Arguments of the commands about measurements: a model, logs, a budget.

use crate::results::Results;
use clap::Args;
use miette::{Result, miette};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use trueweld::{GivenLogs, MeasuredLogs, MeasuredUnit, WorkProgress, read_units};
use trueweld_estimate::log_faults::Found;
use trueweld_logs::campaign::{CAMPAIGN_FILE, by_unit};
use trueweld_output::{MistakesReport, Progress, mistake_in_words};
use trueweld_plant::input::ModelFile;
use trueweld_plant::provenance::Provenance;

/// A model and logs.
#[derive(Args)]
pub(crate) struct LogArguments {
    /// Model file (default: the campaign's)
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Folders of logs or of campaigns
    #[arg(required = true, value_name = "LOG")]
    logs: Vec<PathBuf>,
}

/// How long a command may take.
#[derive(Args)]
pub(crate) struct BudgetArguments {
    /// Time after which no new work is begun: the best answer so far is given, and what was left
    /// undone (default: none)
    #[arg(long = "budget", value_name = "SECONDS")]
    seconds: Option<f64>,
}

impl BudgetArguments {
    /// When the time is up, from now on.
    pub(crate) fn deadline(&self) -> Result<Option<Instant>> {
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

/// Shows how far some work is.
pub(crate) fn show(progress: &Progress, now: WorkProgress<'_>) {
    match now {
        WorkProgress::Takes([least, most]) => progress.expect(least, most),
        WorkProgress::At(what, share) => progress.stage(what, share),
    }
}

impl LogArguments {
    /// Of a model file and folders of logs.
    pub(crate) fn new(model: Option<PathBuf>, logs: Vec<PathBuf>) -> Self {
        Self { model, logs }
    }

    /// Model and logs as the files have them.
    pub(crate) fn read_files(&self) -> Result<GivenLogs> {
        GivenLogs::read(self.model.as_deref(), &self.logs)
    }

    /// True for campaigns of several units of one type.
    pub(crate) fn is_of_several_units(&self) -> Result<bool> {
        Ok(by_unit(&self.logs)?.len() > 1)
    }

    /// The units of a type, checked for gross mistakes and made ready.
    pub(crate) fn read_units(&self) -> Result<Vec<MeasuredUnit>> {
        read_units(self.model.as_deref(), &self.logs)
    }

    /// Two logs that no model is given for, to be compared with each other.
    pub(crate) fn pair(&self) -> Option<[&Path; 2]> {
        let is_log = |folder: &PathBuf| !folder.join(CAMPAIGN_FILE).is_file();
        match (&self.model, self.logs.as_slice()) {
            (None, [first, second]) if is_log(first) && is_log(second) => Some([first, second]),
            _ => None,
        }
    }

    /// The same, checked for gross mistakes and made ready.
    pub(crate) fn read(&self) -> Result<MeasuredLogs> {
        self.read_files()?.prepare()
    }
}

/// Tells of mistakes in the files, if there are any: true where there is nothing else to tell.
pub(crate) fn tell_mistakes(
    measured: &MeasuredLogs,
    results: &Results,
    provenance: &Provenance,
) -> Result<bool> {
    let MeasuredLogs { model, found, .. } = measured;
    if found.mistakes.is_empty() {
        return Ok(false);
    }
    results.write(&MistakesReport { model, found, provenance })?;
    Ok(true)
}

/// Says that a file is not written, beside mistakes that were told. `what`: what it would hold.
pub(crate) fn say_unwritten(what: &str, path: &Path) -> Result<()> {
    let stays = if path.exists() { "; the file there is of an earlier run" } else { "" };
    say!("no {what} is written to {}{stays}\n", path.display());
    Ok(())
}

/// Refuses logs with mistakes in them, where nothing can be said of these. `what`: the logs.
pub(crate) fn refuse_mistakes(what: &str, found: &Found, model: &ModelFile) -> Result<()> {
    let Some(first) = found.mistakes.first() else { return Ok(()) };
    let [sentence, help] = mistake_in_words(first, &model.robot.joint_names);
    Err(miette!(help = help, "{what}: a mistake in the files: {sentence}"))
}
