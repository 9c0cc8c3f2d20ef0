//! Errors by channel, in their units, of what a diagnosis compares.

use trueweld_estimate::fit::{FitProblem, Fitted, Residuals};
use trueweld_estimate::residuals::error::{ChannelError, channel_errors};

/// Errors of one model after another, by channel. Those of a fit are on blocks in time that were left
/// out of it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DiagnosisErrors {
    /// Of the model as it was given.
    pub before: Vec<ChannelError>,
    /// With calibrations alone.
    pub calibrated: Vec<ChannelError>,
    /// With the best explanation and the calibrations that count.
    pub after: Vec<ChannelError>,
}

/// Errors that residuals make.
pub(crate) fn errors_of(problem: &FitProblem, at: &Residuals) -> Vec<ChannelError> {
    channel_errors(&problem.logs, at.iter().map(|log| log.residual.as_slice()))
}

/// The same of a fit, on blocks in time that were left out of it.
pub(crate) fn errors_from_others(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
) -> Vec<ChannelError> {
    let left = fitted.residuals_from_others(blocks);
    channel_errors(&problem.logs, left.iter().map(Vec::as_slice))
}
