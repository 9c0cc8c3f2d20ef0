//! Recordings for the Rerun viewer: the arm, its path and every signal of finished welds, the
//! responses to a step of the push, measurements beside predictions, each with the layout to see
//! them in.
//!
//! Deviations of millimetres on an arm of three metres are drawn enlarged by one factor, the arm's
//! with the path's: joint angles about the angles that would hold the nominal pose, the path about
//! the seam. With a factor of 1 the picture is to scale. Signals are never enlarged.

mod compare;
mod layout;
mod scene;
mod signals;
mod step;
mod writer;

use crate::words::experiment;
use crate::{DiagnoseReport, ImproveReport, OutputError, Report, StepReport, WeldRun, write_file};
use re_chunk::TimeColumn;
use std::path::Path;
use trueweld_measure::residuals::compare::{Comparison, LogComparison};
use trueweld_plant::simulate::Recording;
use writer::{RecordError, Writer};

/// A run and how it appears in the recording.
struct Shown<'a> {
    recording: &'a Recording,
    /// Root of its entities.
    root: String,
    /// Its name for people.
    name: String,
    color: crate::color::Rgb,
    beside: Beside,
}

/// The timeline that a recording has beside `time`.
enum Beside {
    /// `path_um`: distance gone along the seam, m, one value a row; counts only while the tool
    /// moves.
    Path(Vec<f64>),
    /// `since_step`: time since the step of the set-point at this time, s.
    Step(f64),
}

impl Shown<'_> {
    /// The timelines of some rows, which are all on the seam or all off it.
    fn times(&self, picked: impl Iterator<Item = usize> + Clone) -> Vec<TimeColumn> {
        let rows = &self.recording.rows;
        let mut times =
            vec![TimeColumn::new_duration_secs("time", picked.clone().map(|k| rows[k].time))];
        match &self.beside {
            Beside::Path(travelled) => {
                if picked.clone().next().is_some_and(|k| crate::path::moving(rows[k].phase)) {
                    let travelled = picked.map(|k| signals::micrometres(travelled[k]));
                    times.push(TimeColumn::new_sequence("path_um", travelled));
                }
            }
            Beside::Step(at) => {
                times.push(TimeColumn::new_duration_secs(
                    step::TIMELINE,
                    picked.map(|k| rows[k].time - at),
                ));
            }
        }
        times
    }
}

/// Writes welds of one seam into a recording at `path`, each under its own root, with the layout to
/// compare them.
///
/// `exaggeration` enlarges what is drawn in space, not the signals. Timelines: `time`, and
/// `path_um`, the position on the seam in micrometres, for rows in which the tool moves. The same
/// runs give the same bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn weld_recording(
    path: &Path,
    runs: &[WeldRun],
    exaggeration: f64,
) -> Result<(), OutputError> {
    let beside = |r: &Recording| Beside::Path(crate::path::travelled(&r.rows));
    let shown =
        shown(runs.iter().map(|r| r.recording), &crate::words::weld::run_names(runs), beside);
    let id = shown.first().map_or("empty", |s| s.recording.weld.as_str());
    save(path, id, |writer| {
        layout::weld(writer, &shown, exaggeration)?;
        scene::cell(writer, runs, &shown, exaggeration)?;
        for (run, shown) in runs.iter().zip(&shown) {
            scene::arm(writer, run, shown, exaggeration)?;
            signals::all(writer, shown)?;
        }
        Ok(())
    })
}

/// Writes the responses of several controllers to one step of the push into a recording at `path`, with the layout to compare them: push, force error, what the controller
/// does about it, twists and torques of the drives.
///
/// Timelines: `since_step`, and `time` from the start of the run. The same runs give the same
/// bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn step_recording(path: &Path, report: &StepReport<'_>) -> Result<(), OutputError> {
    let StepReport { runs, at, .. } = *report;
    let names = crate::words::step::controller_names(runs);
    let shown = shown(runs.iter().map(|r| r.recording), &names, |_| Beside::Step(at));
    let id = shown.first().map_or("step".to_owned(), |s| format!("{}, step", s.recording.weld));
    save(path, &id, |writer| {
        let step = step::Step::of(&shown, at);
        layout::step(writer, &shown, step.as_ref())?;
        step::references(writer, report.document().markdown(), step.as_ref())?;
        shown.iter().try_for_each(|shown| signals::all(writer, shown))
    })
}

/// Writes measurements beside a model's predictions into a recording at `path`: the way of the tool
/// in every log, deviations drawn too large by a round factor, and the difference of every column,
/// with the layout that shows the worst first.
///
/// `model`: where the model was read from. Timeline: `time`, from the start of each log. The same
/// comparison gives the same bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn compare_recording(
    path: &Path,
    model: &Path,
    comparison: &Comparison,
) -> Result<(), OutputError> {
    let shown = compare::Shown::all(&comparison.logs, &[]);
    save(path, "compare", |writer| {
        layout::compare(writer, &shown)?;
        compare::all(writer, compare::about(model, comparison), &shown)
    })
}

/// Writes a diagnosis into a recording at `path`: the tool's way as measured, as the model has it
/// and as it is with the best explanation, every column's difference before and after, and the
/// verdict. Timeline: `time`, from the start of each log.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn diagnose_recording(
    path: &Path,
    diagnosed: &DiagnoseReport<'_>,
) -> Result<(), OutputError> {
    let mut said = vec![diagnosed.headline()];
    said.extend(diagnosed.explanation());
    if let Some(plan) = &diagnosed.account.next_experiment {
        said.push(format!(
            "Next experiment: {}. {}",
            experiment::title(plan),
            experiment::reason(plan)
        ));
        said.extend(experiment::steps(plan));
    }
    before_and_after(
        path,
        "diagnose",
        (diagnosed.before, diagnosed.after),
        &said,
        &diagnosed.setting(),
    )
}

/// Writes an improvement into a recording at `path`, as [`diagnose_recording`] does, with the steps
/// in place of the explanation.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn improve_recording(
    path: &Path,
    improved: &ImproveReport<'_>,
) -> Result<(), OutputError> {
    let steps = improved.improvement.steps.iter().enumerate();
    let step = |(k, step): (usize, &trueweld_measure::improve::Step)| {
        format!(
            "{}: score {:.3}, where nothing was fitted {:.3}",
            improved.step(k),
            step.score,
            step.held_out
        )
    };
    let said: Vec<String> =
        [improved.headline(), improved.verdict()].into_iter().chain(steps.map(step)).collect();
    before_and_after(path, "improve", (improved.before, improved.after), &said, &improved.setting())
}

/// Logs under a model and under a better one, with what is said of it, the most important first.
fn before_and_after(
    path: &Path,
    id: &str,
    (before, after): (&[LogComparison], &[LogComparison]),
    said: &[String],
    setting: &str,
) -> Result<(), OutputError> {
    let shown = compare::Shown::all(before, after);
    let (first, others) =
        said.split_first().map_or(("", said), |(first, others)| (first.as_str(), others));
    // A step's own plus is no mark of a list.
    let others: String =
        others.iter().map(|line| format!("- {}\n", line.replacen("+ ", "\\+ ", 1))).collect();
    save(path, id, |writer| {
        layout::compare(writer, &shown)?;
        compare::verdict(writer, said)?;
        compare::all(writer, format!("**{first}**\n\n{setting}\n\n{others}"), &shown)
    })
}

/// Puts a recording together in memory and writes it.
fn save(
    path: &Path,
    id: &str,
    fill: impl FnOnce(&mut Writer<&mut Vec<u8>>) -> Result<(), RecordError>,
) -> Result<(), OutputError> {
    let mut bytes = Vec::new();
    let written = Writer::new(&mut bytes, id).and_then(|mut writer| {
        fill(&mut writer)?;
        writer.finish()
    });
    written.map_err(|RecordError(reason)| OutputError::Record { path: path.to_owned(), reason })?;
    write_file(path, &bytes)
}

fn shown<'a>(
    recordings: impl Iterator<Item = &'a Recording>,
    names: &[String],
    beside: impl Fn(&Recording) -> Beside,
) -> Vec<Shown<'a>> {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
    recordings
        .zip(names)
        .enumerate()
        .map(|(k, (recording, name))| Shown {
            recording,
            root: match name.as_str() {
                "no compensation" => "none".to_owned(),
                name => name.chars().map(plain).collect::<String>().replace("__", "_"),
            },
            name: name.clone(),
            color: crate::color::run(k),
            beside: beside(recording),
        })
        .collect()
}

#[cfg(test)]
mod tests;
