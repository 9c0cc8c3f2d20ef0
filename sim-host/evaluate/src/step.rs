//! Figures of the response to a step of the force set-point.

use trueweld_plant::simulate::{Recording, Row};

/// Response of one controller to a step of the push. "5 %" and overshoot are of the step's height.
#[derive(Debug, Clone, PartialEq)]
pub struct StepFigures {
    /// Name of the controller.
    pub controller: &'static str,
    /// First time after the step at which the push, less its ripple, is within 5 % of the set-point, s; `None` where
    /// it never is.
    pub first_within_5pct: Option<f64>,
    /// Time after which the push, less its ripple, stays within 5 % of the set-point, s; `None` where it does not.
    pub settle_5pct: Option<f64>,
    /// Overshoot over the step's height.
    pub overshoot: f64,
    /// Mean push less set-point over the last half second, N.
    pub static_error: f64,
    /// Largest departure of the push from that mean over the last half second, N: the ripple of the spindle.
    pub ripple: f64,
}

impl StepFigures {
    /// Figures of a recording in which the desired push steps once at `at`, s, by `height`, N.
    ///
    /// The response is the push averaged over one turn of the spindle (`turn`, s), so that the ripple is not taken for
    /// overshoot. `None` where the record ends before the step.
    pub fn of(recording: &Recording, at: f64, height: f64, turn: f64) -> Option<Self> {
        let rows = &recording.rows;
        let push = |r: &Row| -r.force_w.z;
        let goal = rows.last()?.force_desired?;
        let half = ((0.5 * turn / recording.period).round() as usize).max(1);
        let after: Vec<(f64, f64)> = (half..rows.len().saturating_sub(half))
            .filter(|&k| rows[k].time >= at)
            .map(|k| {
                let window = &rows[k - half..k + half];
                (rows[k].time - at, window.iter().map(push).sum::<f64>() / window.len() as f64)
            })
            .collect();
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
        after.first()?;
        Some(Self {
            controller: recording.controller,
            first_within_5pct: first,
            settle_5pct: settle,
            overshoot: highest / height.abs(),
            static_error: mean - goal,
            ripple: tail.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max),
        })
    }
}
