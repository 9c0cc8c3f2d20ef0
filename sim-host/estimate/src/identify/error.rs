//! Why nothing could be identified.

use crate::log_faults::Found;
use crate::predict::PredictError;
use trueweld_core::ModelError;
use trueweld_logs::log::LogKind;
use trueweld_plant::input::InputError;

/// Why nothing could be identified.
#[derive(Debug, thiserror::Error)]
pub enum IdentifyError {
    /// No log is of a kind that shows what is asked for.
    #[error("no log tells the {what}: expected {expected} logs, and these are {given}")]
    NoLogs {
        /// What is asked for.
        what: &'static str,
        /// Kinds of logs that would do.
        expected: String,
        /// Kinds of the logs given.
        given: String,
    },
    /// A process whose numbers no log tells.
    #[error("no log tells the numbers of {process}: expected a process that bears a push")]
    OtherProcess {
        /// The process.
        process: &'static str,
    },
    /// Nothing says which process is welded.
    #[error("the model names no process: expected `process = \"…\"` in the model file, as a start")]
    NoProcess,
    /// No force of any weld can be predicted.
    #[error(
        "no weld has forces to compare: expected tracker and wrench columns, and seconds in firm contact"
    )]
    NoForces,
    /// Mistakes in the files, which come before any physics.
    #[error("there are mistakes in the files")]
    Mistakes(Box<Found>),
    /// The model cannot be driven through the logs.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// A log with a value that cannot be right.
    #[error(transparent)]
    Input(#[from] InputError),
    /// Numbers for which there is no robot.
    #[error("the numbers found leave no possible robot ({0:?})")]
    Model(ModelError),
    /// The fit does not converge.
    #[error(
        "the numbers do not come to rest in {passes} passes: the model may lack something, which `trueweld diagnose` looks for"
    )]
    NotConverged {
        /// Passes made.
        passes: usize,
    },
    /// Fewer rows than numbers.
    #[error("the logs hold {rows} compared values, too few to tell {numbers} numbers")]
    TooFew {
        /// Compared values.
        rows: usize,
        /// Numbers asked for.
        numbers: usize,
    },
}

impl IdentifyError {
    pub(crate) fn no_logs(what: &'static str, expected: &[LogKind], given: &[LogKind]) -> Self {
        Self::NoLogs { what, expected: listed(expected), given: listed(given) }
    }
}

/// Names of kinds of logs, each once.
fn listed(kinds: &[LogKind]) -> String {
    let mut names: Vec<String> = Vec::new();
    for kind in kinds {
        let name = kind.to_string();
        if !names.contains(&name) {
            names.push(name);
        }
    }
    names.join(", ")
}
