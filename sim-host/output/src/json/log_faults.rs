//! Mistakes in the files in place of a result.

use super::compare::CompareResult;
use super::diagnose::DiagnoseResult;
use super::improve::ImproveResult;
use super::log_fault::FileMistake;
use super::register::RegisteredTracker;
use crate::{MistakesReport, text};
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_diagnose::DiagnosisVerdict;

/// Mistakes in the files, in the form of the command that found them.
#[derive(Serialize, JsonSchema)]
#[serde(untagged)]
pub(crate) enum MistakesResult {
    /// Of `compare`.
    Compare(Box<CompareResult>),
    /// Of `diagnose`.
    Diagnose(Box<DiagnoseResult>),
    /// Of `improve`.
    Improve(Box<ImproveResult>),
}

impl MistakesResult {
    pub(crate) fn of(report: &MistakesReport<'_>) -> Self {
        let joints = &report.model.robot.joint_names;
        let provenance = report.provenance.clone();
        let model = report.model.path.display().to_string();
        let mistakes = report.found.mistakes.iter().map(|m| FileMistake::of(m, joints)).collect();
        let sentence = text::log_faults::headline(report.found, joints);
        let registered = report.found.registered.iter().map(RegisteredTracker::of).collect();
        let verdict = DiagnosisVerdict::UnknownEffect.name();
        match provenance.command.as_str() {
            "diagnose" => Self::Diagnose(Box::new(DiagnoseResult {
                provenance,
                mistakes,
                model,
                verdict,
                sentence,
                registered,
                ..DiagnoseResult::default()
            })),
            "improve" => Self::Improve(Box::new(ImproveResult {
                provenance,
                mistakes,
                model,
                verdict,
                sentence,
                registered,
                ..ImproveResult::default()
            })),
            _ => Self::Compare(Box::new(CompareResult {
                provenance,
                mistakes,
                model,
                registered,
                ..CompareResult::default()
            })),
        }
    }
}
