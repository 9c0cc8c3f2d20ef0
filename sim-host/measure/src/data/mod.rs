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
