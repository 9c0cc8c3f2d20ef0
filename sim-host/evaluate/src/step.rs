//! Figures of the response to a step of the force set-point.

use schemars::JsonSchema;
use serde::Serialize;
use trueweld_plant::simulate::{LimitSpan, RecordRow, Recording, limit_spans};

/// Response of one controller to a step of the push. "5 %" and overshoot are of the step's height.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct StepFigures {
    /// Name of the controller.
    #[serde(rename = "name")]
    pub controller: &'static str,
    /// First time within 5 % of the set-point, s.
    pub first_within_5pct_s: Option<f64>,
    /// Time from which the push stays within 5 % of the set-point, s.
    pub settle_5pct_s: Option<f64>,
    /// Overshoot as a share of the step.
    pub overshoot: f64,
    /// Mean push less set-point over the last half second, N.
    pub static_error_n: f64,
    /// Largest departure from that mean, N.
    pub ripple_n: f64,
    // A push that drives cannot bring is no force loop's fault.
    /// What stood at a limit, the longest first; left out where nothing did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LimitSpan>,
}

impl StepFigures {
    /// Figures of a recording in which the desired push steps once at `at`, s, by `height`, N.
    ///
    /// Of the real push as it is, row by row: its ripple is a tenth of the 5 % band, and smoothing
    /// it away would take from the overshoot. `None` where the record ends before the step.
    pub fn of(recording: &Recording, at: f64, height: f64) -> Option<Self> {
        let rows = &recording.rows;
        let push = |r: &RecordRow| -r.force_w.z;
        let goal = rows.last()?.force_desired?;
        // The step is commanded with the row at `at`; a hair of slack for the rounding of row
        // times.
        let step = rows.iter().position(|r| r.time >= at - 0.5 * recording.period)?;
        let after: Vec<(f64, f64)> =
            rows[step..].iter().map(|r| (r.time - rows[step].time, push(r))).collect();
        let within = |value: f64| (value - goal).abs() <= 0.05 * height.abs();
        let first = after.iter().find(|(_, v)| within(*v)).map(|(t, _)| *t);
        let settle = match after.iter().rposition(|(_, v)| !within(*v)) {
            None => after.first().map(|(t, _)| *t),
            Some(last) => after.get(last + 1).map(|(t, _)| *t),
        };
        let highest = after.iter().map(|(_, v)| (v - goal) * height.signum()).fold(0.0, f64::max);
        let end = rows.last()?.time;
        let tail: Vec<f64> = rows.iter().filter(|r| r.time > end - 0.5).map(push).collect();
        let mean = tail.iter().sum::<f64>() / tail.len() as f64;
        Some(Self {
            controller: recording.controller,
            first_within_5pct_s: first,
            settle_5pct_s: settle,
            overshoot: highest / height.abs(),
            static_error_n: mean - goal,
            ripple_n: tail.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max),
            limits: limit_spans(recording),
        })
    }
}
