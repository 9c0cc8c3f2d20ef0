//! Logs, predictions, fits and diagnosis, on recorded and written files.

mod any_file;
mod calibration;
mod compare;
mod dirty;
mod evidence;
mod fit;
mod formats;
mod log;
mod plan;
