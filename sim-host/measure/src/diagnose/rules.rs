//! Rules of decision. Their numbers come from the corpus in `tests/`, never from recorded campaigns.

use crate::fit::{self, Bench, Fitted, Residuals};
use crate::predict::Quantity;
use std::collections::BTreeMap;

/// Fall of the held-out sum of squares that chance does not reach among some hundred hypotheses.
pub const GAIN: f64 = 30.0;
/// Share of what the blocks that get better win that the others may lose.
pub const LOST: f64 = 0.3;
/// Fall of one channel's sum of squares below which its noise is not known well enough, as a share.
pub const VISIBLE: f64 = 0.08;
/// Share of what was above the floor that an explanation may leave.
pub const LEFT: f64 = 0.1;
/// The same, where all together is as near to the floor as this score.
pub const LEFT_NEAR: f64 = 0.5;
/// Share of what one effect leaves that a second one may leave.
pub const HALVED: f64 = 0.5;
/// Score that is near the floor.
pub const NEAR: f64 = 1.05;
/// Score of any channel from which on something is above the floor.
pub const FLOOR: f64 = 1.3;
/// Fall of the sum of squares that a calibration must bring to be kept, and so much more for each value it has.
pub const KEEP: f64 = 25.0;
/// The same for each value.
pub const KEEP_EACH: f64 = 6.0;
/// Residuals of one channel that follow each other are not as many as they are.
pub const CORRELATED: f64 = 4.0;
/// Hypotheses fitted in full, first alone and then beside the best.
pub const FITTED: usize = 8;
/// Of these, how many beside the best.
pub const FITTED_BESIDE: usize = 5;

/// Score of residuals: root mean square.
pub fn score(residuals: &Residuals) -> f64 {
    (fit::chi_square(residuals) / fit::count(residuals).max(1) as f64).sqrt()
}

/// Sum of squares and number of the residuals of one channel in one log.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Part {
    /// Sum of squares.
    pub square: f64,
    /// Number.
    pub count: usize,
}

/// Sums of squares by log and channel.
pub fn parts(bench: &Bench, residuals: &Residuals) -> BTreeMap<(usize, &'static str), Part> {
    let mut parts: BTreeMap<(usize, &'static str), Part> = BTreeMap::new();
    for (log, (experiment, prediction)) in bench.experiments.iter().zip(residuals).enumerate() {
        for (c, r) in experiment.compared.iter().zip(&prediction.residual) {
            let part = parts.entry((log, c.quantity.channel())).or_default();
            part.square += r * r;
            part.count += 1;
        }
    }
    parts
}

/// Sums of squares by log and column; the spindle's orders apart from what is slow.
fn columns(bench: &Bench, residuals: &Residuals) -> BTreeMap<(usize, &'static str, u8, bool), Part> {
    let mut columns: BTreeMap<(usize, &'static str, u8, bool), Part> = BTreeMap::new();
    for (log, (experiment, prediction)) in bench.experiments.iter().zip(residuals).enumerate() {
        for (c, r) in experiment.compared.iter().zip(&prediction.residual) {
            let ripple = matches!(c.quantity, Quantity::Ripple { .. });
            let column = columns.entry((log, c.quantity.channel(), c.component, ripple)).or_default();
            column.square += r * r;
            column.count += 1;
        }
    }
    columns
}

/// True where a fit explains more than chance does and than the noise is known to. `background`: how much more than white
/// noise what is left of it raises such a hypothesis.
pub(crate) fn counts(bench: &Bench, before: &Fitted, after: &Fitted, background: f64) -> bool {
    let (before_out, after_out) = (before.linear.held_out(None), after.linear.held_out(None));
    let differences = || before_out.iter().zip(&after_out).map(|(b, a)| b - a);
    let gained: f64 = differences().filter(|d| *d > 0.0).sum();
    let lost: f64 = -differences().filter(|d| *d < 0.0).sum::<f64>();
    if gained - lost < GAIN * background || lost > LOST * gained {
        return false;
    }
    stands_out(bench, &before.at, &after.at)
}

/// True where some column's sum of squares falls by more than its noise is known to.
pub(crate) fn stands_out(bench: &Bench, before: &Residuals, after: &Residuals) -> bool {
    let after = columns(bench, after);
    columns(bench, before).iter().any(|(key, column)| {
        let fall = column.square - after.get(key).map_or(column.square, |p| p.square);
        fall > VISIBLE * column.square && fall > 0.5 * GAIN
    })
}

/// Sum of squares above the floor.
pub(crate) fn above(residuals: &Residuals) -> f64 {
    (fit::chi_square(residuals) - fit::count(residuals) as f64).max(0.0)
}

/// True where no column of any log stands out of the floor.
pub(crate) fn at_floor(bench: &Bench, residuals: &Residuals) -> bool {
    columns(bench, residuals).values().all(|p| {
        let count = p.count as f64;
        p.square / count < FLOOR.powi(2) + 6.0 * (2.0 / count).sqrt()
    })
}
