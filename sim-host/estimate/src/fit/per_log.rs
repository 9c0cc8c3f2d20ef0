//! What every log has of its own, where a model meets logs that it was not fitted to: a tracker
//! registered anew, an encoder zeroed anew, a payload hung differently. Everything else of the
//! model stays as it is.

use crate::fit::calibration::per_log;
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
    let stale = point.free.len();
    if stale == 0 {
        let residuals = fit::residuals(problem, &point)?;
        return Ok((point, residuals));
    }
    let found =
        fit::fit(problem, &point, &fit::blocks_of(problem), &[], SolverOptions::full(stale))?;
    Ok((found.point, found.residuals))
}
