//! What every log has of its own, where a model meets logs that it was not fitted to: a tracker
//! registered anew, an encoder zeroed anew, a payload hung differently. Everything else of the
//! model stays as it is.

use crate::fit::calibration::per_log;
use crate::fit::{self, Effort, FitProblem, FitState, PerLogEffect, Residuals};
use crate::predict::PredictError;
use trueweld_plant::effects::Effect;

/// Fits `own`, with values for each log, beside the bench's known effects and `all`, which stay.
/// Where there is nothing to fit, the residuals are those of the model as it is.
///
/// # Errors
/// [`PredictError`] of the first log the model cannot be driven through.
pub fn fitted(
    bench: &FitProblem,
    own: &[PerLogEffect],
    all: Vec<Effect>,
) -> Result<(FitState, Residuals), PredictError> {
    let mut point = per_log(bench, own);
    point.all = all;
    let stale = point.free.len();
    if stale == 0 {
        let residuals = fit::residuals(bench, &point)?;
        return Ok((point, residuals));
    }
    let found = fit::fit(bench, &point, &fit::blocks_of(bench), &[], Effort::full(stale))?;
    Ok((found.point, found.at))
}
