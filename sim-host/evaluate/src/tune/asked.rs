//! What is asked of a force loop, and why there may be no gains.

use trueweld_plant::simulate::RunError;

/// What is asked of the force loop: of a step of the push at the start of the weld.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AskedResponse {
    /// Height of the step, N.
    pub height: f64,
    /// Time after which the push stays within 5 % of the step, s.
    pub settle: f64,
    /// Largest overshoot over the height.
    pub overshoot: f64,
    /// Largest static error over the height.
    pub static_error: f64,
}

/// Why no gains were found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TuneError {
    /// A run, or a place of the weld, that cannot be.
    #[error(transparent)]
    Run(#[from] RunError),
}
