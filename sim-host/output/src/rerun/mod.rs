//! Recordings for the Rerun viewer: the arm, its path and every signal of finished welds, the
//! responses to a step of the push, measurements beside predictions, each with the layout to see
//! them in.
//!
//! Deviations of millimetres on an arm of three metres are drawn enlarged by one factor, the arm's
//! with the path's: joint angles about the angles that would hold the nominal pose, the path about
//! the seam. With a factor of 1 the picture is to scale. Signals are never enlarged.

mod compare;
mod layout;
mod live;
mod placed;
mod scene;
mod shown;
mod signals;
mod step;
mod writer;

pub use live::{Live, LiveWeld};

use crate::document::Document;
use crate::text::experiment;
use crate::text::weld::limits;
use crate::{
    CompareReport, DiagnoseReport, ImproveReport, OutputError, StepReport, StudyLayoutReport,
    WeldReport, write_file,
};
use re_sdk_types::archetypes::TextDocument;
use re_sdk_types::components::MediaType;
use shown::{Beside, DrawnRun, ORIGIN};
use std::path::Path;
use trueweld_diagnose::improve::ImprovementStep;
use trueweld_estimate::residuals::compare::LogComparison;
use trueweld_plant::simulate::{Recording, limit_spans};
use writer::{RecordError, Store, Writer};

/// Writes welds of one seam into a recording at `path`, each under its own root, with the layout to
/// compare them. `document`: the report in words.
///
/// The exaggeration enlarges what is drawn in space, not the signals. Timelines: `time`, and
/// `path_um`, the position on the seam in micrometres, for rows in which the tool moves. The same
/// runs give the same bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn weld_recording(
    path: &Path,
    report: &WeldReport<'_>,
    document: &Document,
) -> Result<(), OutputError> {
    let WeldReport { runs, exaggeration, .. } = *report;
    let names = crate::text::weld::run_names(runs);
    let beside = |r: &Recording| Beside::Path(crate::path::travelled(&r.rows));
    let shown = DrawnRun::all(runs.iter().map(|r| r.recording), &names, beside);
    let id = shown.first().map_or("empty", |s| s.recording.weld.as_str());
    save(path, id, origin(document, &shown), |writer| {
        layout::weld(writer, &shown, exaggeration)?;
        scene::cell(writer, runs, &shown, exaggeration)?;
        for (run, shown) in runs.iter().zip(&shown) {
            let largest = run.figures.lateral.max_abs;
            scene::arm(writer, run.robot, shown, [exaggeration, largest], 0)?;
            signals::all(writer, shown, 0)?;
        }
        Ok(())
    })
}

/// What simulated runs are of, and what each stood at.
fn origin(document: &Document, shown: &[DrawnRun<'_>]) -> String {
    let limits = shown.iter().map(|s| {
        let spans = limit_spans(s.recording);
        format!("- {}: {}\n", s.name, limits(&spans))
    });
    format!("{}\n### Limits\n\n{}", document.origin_markdown(), limits.collect::<String>())
}

/// Writes the responses of several controllers to one step of the push into a recording at `path`,
/// with the layout to compare them: push, force error, what the controller does about it, twists
/// and torques of the drives. `document`: the report in words.
///
/// Timelines: `since_step`, and `time` from the start of the run. The same runs give the same
/// bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn step_recording(
    path: &Path,
    report: &StepReport<'_>,
    document: &Document,
) -> Result<(), OutputError> {
    let StepReport { runs, at, .. } = *report;
    let names = crate::text::step::controller_names(runs);
    let shown = DrawnRun::all(runs.iter().map(|r| r.recording), &names, |_| Beside::Step(at));
    let id = shown.first().map_or("step".to_owned(), |s| format!("{}, step", s.recording.weld));
    save(path, &id, origin(document, &shown), |writer| {
        let step = step::SetPointStep::of(&shown, at);
        layout::step(writer, &shown, step.as_ref())?;
        step::references(writer, document.markdown(), step.as_ref())?;
        shown.iter().try_for_each(|shown| signals::all(writer, shown, 0))
    })
}

/// Writes measurements beside a model's predictions into a recording at `path`: the way of the tool
/// in every log, deviations drawn too large by a round factor, and the difference of every column,
/// with the layout that shows the worst first. `document`: the report in words.
///
/// Timeline: `time`, from the start of each log. The same comparison gives the same bytes.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn compare_recording(
    path: &Path,
    report: &CompareReport<'_>,
    document: &Document,
) -> Result<(), OutputError> {
    let shown = compare::ShownLog::all(&report.comparison.logs, &[]);
    save(path, "compare", document.origin_markdown(), |writer| {
        layout::compare(writer, &shown)?;
        compare::all(writer, compare::about(report.model, report.comparison), &shown)
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
    document: &Document,
) -> Result<(), OutputError> {
    let mut said = vec![diagnosed.headline()];
    said.extend(diagnosed.explanation());
    if let Some(plan) = &diagnosed.explanation.next_experiment {
        said.push(format!("What to record next: {}", experiment::lead(plan)));
        if experiment::is_worth_recording(plan) {
            said.extend(experiment::steps(plan));
        }
    }
    before_and_after(
        path,
        ["diagnose", &document.origin_markdown()],
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
    document: &Document,
) -> Result<(), OutputError> {
    let steps = improved.improvement.steps.iter().enumerate();
    let step = |(k, step): (usize, &ImprovementStep)| {
        let scores = [step.score, step.held_out].map(|score| format!("{score:.3}"));
        format!("{}: score {}, where nothing was fitted {}", improved.step(k), scores[0], scores[1])
    };
    let said: Vec<String> =
        [improved.headline(), improved.verdict()].into_iter().chain(steps.map(step)).collect();
    before_and_after(
        path,
        ["improve", &document.origin_markdown()],
        (improved.before, improved.after),
        &said,
        &improved.setting(),
    )
}

/// Writes the placements of a part into a recording at `path`: a point for each, coloured by what it
/// takes of what is allowed, and the seams as filed and as chosen. `document`: the report in words.
///
/// # Errors
/// [`OutputError`] with the path; no file is left behind.
pub(crate) fn layout_recording(
    path: &Path,
    report: &StudyLayoutReport<'_>,
    document: &Document,
) -> Result<(), OutputError> {
    save(path, "study layout", document.origin_markdown(), |writer| {
        layout::placed(writer)?;
        placed::all(writer, document.markdown(), report)
    })
}

/// Logs under a model and under a better one, with what is said of it, the most important first.
/// `id`, `origin`: of the recording, and what it is of.
fn before_and_after(
    path: &Path,
    [id, origin]: [&str; 2],
    (before, after): (&[LogComparison], &[LogComparison]),
    said: &[String],
    setting: &str,
) -> Result<(), OutputError> {
    let shown = compare::ShownLog::all(before, after);
    let (first, others) =
        said.split_first().map_or(("", said), |(first, others)| (first.as_str(), others));
    // A step's own plus is no mark of a list.
    let others: String =
        others.iter().map(|line| format!("- {}\n", line.replacen("+ ", "\\+ ", 1))).collect();
    save(path, id, origin.to_owned(), |writer| {
        layout::compare(writer, &shown)?;
        compare::verdict(writer, said)?;
        compare::all(writer, format!("**{first}**\n\n{setting}\n\n{others}"), &shown)
    })
}

/// Puts a recording together in memory and writes it. `origin`: what it is of.
fn save(
    path: &Path,
    id: &str,
    origin: String,
    fill: impl FnOnce(&mut Writer<&mut Vec<u8>>) -> Result<(), RecordError>,
) -> Result<(), OutputError> {
    let mut bytes = Vec::new();
    let written = Writer::new(&mut bytes, id, None).and_then(|mut writer| {
        let origin = TextDocument::new(origin).with_media_type(MediaType::MARKDOWN);
        writer.fixed(Store::Recording, ORIGIN, &origin)?;
        fill(&mut writer)?;
        writer.finish()
    });
    written.map_err(|RecordError(reason)| OutputError::Record { path: path.to_owned(), reason })?;
    write_file(path, &bytes)
}

#[cfg(test)]
mod tests;
