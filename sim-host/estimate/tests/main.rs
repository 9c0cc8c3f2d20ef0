//! Predictions, residuals and fits, on recorded and written files.

mod calibration;
mod compare;
mod dirty;
mod open;
