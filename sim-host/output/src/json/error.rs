//! Errors in the units of what is measured.

use super::{finite, result};
use trueweld_estimate::residuals::error::ChannelError;

result! {
    /// Error of one channel over all logs.
    ChannelErrorFigures of (error: &ChannelError) {
        /// `tcp_position`, `tcp_rotation`, `motor_torque`, `link_encoder`, `force` or `moment`.
        channel: &'static str = error.channel,
        /// True for the force's amplitudes at the spindle's orders, false for what is slower.
        ripple: bool = error.ripple,
        /// Unit of the figures.
        unit: &'static str = error.unit,
        /// Root mean square of measured less predicted.
        rmse: Option<f64> = finite(error.rmse),
        /// Root mean square of the noise in the difference.
        noise: f64 = error.noise,
        /// What predictions may be off by; 0 where they are to be as exact as the noise.
        accuracy: f64 = error.accuracy,
        samples: usize = error.samples,
    }
}

impl ChannelErrorFigures {
    pub(crate) fn all(errors: &[ChannelError]) -> Vec<Self> {
        errors.iter().map(Self::of).collect()
    }
}
