//! What was recorded: logs, campaigns of logs, the noise of their channels, filters for them.

pub mod campaign;
pub mod channel;
pub mod clock;
pub(crate) mod dropout;
pub mod fir;
mod kind;
pub mod log;
pub mod noise;
pub(crate) mod rates;
pub mod resample;
