//! Detects a force sensor whose reading is stuck.
//!
//! A live sensor has noise: its six channels do not all repeat to the last digit for long. They do
//! where the sensor is stuck or saturated, has dropped to zero, or its bus repeats the last telegram.
//! Its readings are then replaced by NaN, and controllers and laws hold as for any faulty sensor. A
//! force loop on a stuck reading would press the tool in up to its limits.
//!
//! Requires noise above the sensor's resolution while the force loop is closed: with the tool free
//! and at rest, a coarse sensor repeats its reading too. Not detected: a reading that is wrong but
//! still noisy.

use crate::scalar::{Real, lit};
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// Number of equal readings in a row from which on a sensor counts as stuck: in four periods of
/// 12 ms the external force loop moves the depth by half a millimetre at most.
pub const STUCK: u8 = 4;

/// Counts equal readings in a row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatCounter<V> {
    last: Option<V>,
    equal: u8,
}

impl<V: PartialEq> RepeatCounter<V> {
    /// Nothing read yet.
    pub const fn new() -> Self {
        Self { last: None, equal: 0 }
    }

    /// Takes a reading; returns how many in a row have been equal to it, itself included.
    pub fn count(&mut self, reading: V) -> u8 {
        if self.last.as_ref() == Some(&reading) {
            self.equal = self.equal.saturating_add(1);
        } else {
            (self.last, self.equal) = (Some(reading), 1);
        }
        self.equal
    }
}

impl<V: PartialEq> Default for RepeatCounter<V> {
    fn default() -> Self {
        Self::new()
    }
}

/// Replaces the readings of a stuck force sensor by NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckDetector<T: Real>(RepeatCounter<Wrench<T>>);

impl<T: Real> StuckDetector<T> {
    /// Nothing read yet.
    pub fn new() -> Self {
        Self(RepeatCounter::new())
    }

    /// Takes the reading of this period and returns it, or NaN from the [`STUCK`]th equal reading
    /// on, until one differs in any channel.
    pub fn checked(&mut self, wrench: &Wrench<T>) -> Wrench<T> {
        if self.0.count(*wrench) < STUCK {
            return *wrench;
        }
        let nan = Vector3::repeat(lit(f64::NAN));
        Wrench { moment: nan, force: nan }
    }
}

impl<T: Real> Default for StuckDetector<T> {
    fn default() -> Self {
        Self::new()
    }
}
