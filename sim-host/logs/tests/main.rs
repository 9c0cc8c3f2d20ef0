//! Logs, good and bad, in every format.

mod formats;
mod log;
mod pair;
mod public;
