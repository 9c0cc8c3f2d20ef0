//! What was recorded: logs, campaigns of logs, the noise of their channels, filters for them.

pub mod campaign;
pub mod channel;
pub(crate) mod clipped;
pub mod clock;
pub(crate) mod dropout;
pub mod fir;
mod floor;
mod kind;
pub mod log;
pub mod noise;
mod outlier;
pub(crate) mod rates;
pub mod resample;
pub(crate) mod sample_hold;

/// The value in the middle, the upper of two; `None` of no values. They change places.
fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
