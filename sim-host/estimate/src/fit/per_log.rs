//! What every log has of its own, where a model meets logs that it was not fitted to: a tracker
//! registered anew, an encoder zeroed anew, a payload hung differently. Everything else of the
//! model stays as it is.

use crate::fit::calibration::{in_proportion, per_log};
use crate::fit::{self, FitProblem, FitState, PerLogEffect, Residuals, SolverOptions};
use crate::predict::PredictError;
use trueweld_plant::effects::Effect;

/// Fits `own`, with values for each log, beside the problem's known effects and `all`, which stay.
/// Where there is nothing to fit, the residuals are those of the model as it is.
///
/// # Errors
/// [`PredictError`] of the first log the model cannot be driven through.
pub fn fitted(
    problem: &FitProblem,
    own: &[PerLogEffect],
    all: Vec<Effect>,
) -> Result<(FitState, Residuals), PredictError> {
    let mut point = per_log(problem, own);
    point.shared = all;
    if point.free.is_empty() {
        let residuals = fit::residuals(problem, &point)?;
        return Ok((point, residuals));
    }
    let options = SolverOptions::full(in_proportion(&point));
    let found = fit::fit(problem, &point, &fit::blocks_of(problem), &[], options)?;
    Ok((found.point, found.residuals))
}
