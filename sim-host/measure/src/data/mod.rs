//! What was recorded: logs, campaigns of logs, the noise of their channels, filters for them.

pub mod campaign;
pub mod fir;
pub mod log;
pub mod noise;
