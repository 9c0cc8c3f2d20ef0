//! Measured data as the judge of the model: what was recorded, read and checked.

pub mod campaign;
pub mod log;
