//! The curve of an effect, and what it is drawn from.

use crate::data::log::Log;
use crate::fit::{EffectScope, FitProblem, FitState, Fitted, Residuals};
use crate::residuals::localize::CurvePoint;

/// What the measurements say of an effect, and what it says itself.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCurve {
    /// What is shown.
    pub title: String,
    /// The variable that matters for the effect.
    pub x_name: String,
    /// Its unit.
    pub x_unit: &'static str,
    /// The quantity that the data ask for.
    pub y_name: String,
    /// Its unit.
    pub y_unit: &'static str,
    /// What the measurements say. A loop comes in order of time, everything else in order of `x`.
    pub points: Vec<CurvePoint>,
    /// The same quantity as the effect with its fitted values has it, in the same order.
    pub fitted: Vec<[f64; 2]>,
}

/// Everything that a view is drawn from.
pub(super) struct Context<'a> {
    /// The logs made ready, and the logs.
    pub bench: &'a FitProblem,
    pub logs: &'a [Log],
    /// The fit with the effect.
    pub found: &'a Fitted,
    /// The effect in `found`.
    pub of: EffectScope,
    /// `found` without the effect, its calibrations as they are.
    pub bare: &'a FitState,
    /// Residuals there.
    pub without: &'a Residuals,
    /// Residuals with calibrations alone, at their best.
    pub null: &'a Residuals,
}
