//! Long work on measured logs: until when, and who is told how far it is.

use crate::measured::MeasuredLogs;
use std::time::Instant;

/// Work on measured logs: `task` says what is done with them.
#[must_use]
pub struct MeasuredWork<'a, Task> {
    pub(crate) measured: &'a mut MeasuredLogs,
    pub(crate) task: Task,
    deadline: Option<Instant>,
    progress: &'a (dyn Fn(WorkProgress<'_>) + Sync),
}

/// How far some work is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WorkProgress<'a> {
    /// It will take from so many to so many seconds.
    Takes([f64; 2]),
    /// What is done now, and the share of the whole that is done.
    At(&'a str, f64),
}

impl<'a, Task> MeasuredWork<'a, Task> {
    pub(crate) fn new(measured: &'a mut MeasuredLogs, task: Task) -> Self {
        Self { measured, task, deadline: None, progress: &|_| {} }
    }

    /// No new work is begun after this time: the best answer so far is given, and what was left
    /// undone.
    pub fn deadline(self, deadline: Option<Instant>) -> Self {
        Self { deadline, ..self }
    }

    /// Tells how long it will take, and how far it is.
    pub fn on_progress(self, progress: &'a (dyn Fn(WorkProgress<'_>) + Sync)) -> Self {
        Self { progress, ..self }
    }

    /// Begins work that asks for between so many predictions of all logs, and tells how long it takes;
    /// gives whom to tell how far it is.
    pub(crate) fn begin(&mut self, predictions: [f64; 2]) -> &'a (dyn Fn(WorkProgress<'_>) + Sync) {
        self.measured.problem.deadline = self.deadline;
        if let Some(seconds) = self.measured.expect(predictions) {
            (self.progress)(WorkProgress::Takes(seconds));
        }
        self.progress
    }
}
