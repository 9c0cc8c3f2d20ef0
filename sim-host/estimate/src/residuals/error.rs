//! How far predictions are off in the units of what is measured, channel by channel, all logs
//! together: what a person asks for, where a score weighs everything by its noise.

use crate::predict::{Compared, ComparedQuantity, PreparedLog};

/// Error of one channel over all logs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelError {
    /// The channel: `tcp_position`, `tcp_rotation`, `motor_torque`, `link_encoder`, `force` or
    /// `moment`.
    pub channel: &'static str,
    /// True for the force's amplitudes at the spindle's orders, false for what is slower.
    pub ripple: bool,
    /// Unit of the figures.
    pub unit: &'static str,
    /// Root mean square of measured less predicted, in the unit.
    pub rmse: f64,
    /// Root mean square of the deviation that measured and propagated noise leave in the
    /// difference, in the unit.
    pub noise: f64,
    /// Root mean square of what predictions may be off by, in the unit; 0 where they are to be as
    /// exact as the noise.
    pub accuracy: f64,
    /// Number of values.
    pub samples: usize,
}

impl ChannelError {
    /// Share of the squared error `before` that is gone; negative where it has risen.
    pub fn explained(&self, before: &Self) -> f64 {
        1.0 - (self.rmse / before.rmse).powi(2)
    }
}

/// Errors of every channel that logs compare. `residuals`: of each log, over their deviations.
pub fn channel_errors<'r>(
    logs: &[PreparedLog],
    residuals: impl Iterator<Item = &'r [f64]>,
) -> Vec<ChannelError> {
    let mut all: Vec<ChannelError> = Vec::new();
    for (log, residuals) in logs.iter().zip(residuals) {
        for (compared, residual) in log.compared.iter().zip(residuals) {
            let Compared { quantity, deviation, accuracy, .. } = *compared;
            let (channel, ripple) =
                (quantity.channel(), matches!(quantity, ComparedQuantity::Ripple { .. }));
            let own = all.iter().position(|e| (e.channel, e.ripple) == (channel, ripple));
            let own = own.unwrap_or_else(|| {
                let [rmse, noise, accuracy] = [0.0; 3];
                let unit = quantity.unit();
                all.push(ChannelError { channel, ripple, unit, rmse, noise, accuracy, samples: 0 });
                all.len() - 1
            });
            let own = &mut all[own];
            own.rmse += (residual * deviation).powi(2);
            own.noise += deviation * deviation - accuracy * accuracy;
            own.accuracy += accuracy * accuracy;
            own.samples += 1;
        }
    }
    for own in &mut all {
        let mean = |sum: f64| (sum.max(0.0) / own.samples as f64).sqrt();
        (own.rmse, own.noise, own.accuracy) = (mean(own.rmse), mean(own.noise), mean(own.accuracy));
    }
    all
}
