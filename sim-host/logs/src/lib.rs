//! What was recorded: logs and campaigns of logs, their formats, columns, clocks and noise, filters
//! for them, and where a tracker stands.
//!
//! Layers, bottom up: [`channel`] is the table of what a log may hold; [`log`] reads one from files of
//! any format and clock; [`campaign`] reads several with the model beside them; [`noise`],
//! [`clock`], [`register`] find what the files do not state: noise, clocks, where a tracker stands; [`pair`] compares two logs with
//! each other.
//! Left out: what a model says of them.
//!
//! ```no_run
//! use trueweld_logs::campaign::read_logs;
//!
//! let (_, logs) = read_logs(&["my-campaign".into()])?;
//! for log in &logs {
//!     println!("{}: {}, {} rows", log.name, log.kind.name(), log.samples.time.len());
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod campaign;
pub mod channel;
pub(crate) mod clipped;
pub mod clock;
pub mod dropout;
pub mod fir;
mod floor;
mod kind;
pub mod log;
pub mod noise;
pub mod outlier;
pub mod pair;
pub mod rates;
pub mod register;
pub mod resample;
pub(crate) mod sample_hold;

/// Standard deviations of half a 95 % interval of a normal distribution.
pub const HALF_95: f64 = 1.96;

/// The same of Student's distribution with the nine degrees of freedom that ten means leave.
pub const HALF_95_OF_TEN: f64 = 2.262;

/// A radian counts as so many metres where rotations and positions are weighed together.
pub const ROTATION_LENGTH: f64 = 0.5;

/// The value in the middle, the upper of two; `None` of no values. They change places.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
