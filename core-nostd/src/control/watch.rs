//! A force sensor that has died without saying so: its reading stands still.
//!
//! A live sensor has noise, and its six channels never all repeat themselves to the last digit for
//! long. One that is stuck, whose bus repeats the last telegram, that stands at the end of its
//! range or has dropped to zero does. What it shows is then made no number, and the controllers and
//! laws do what they do when a sensor is at fault: hold. A force loop that believes a dead sensor
//! pushes the tool in as far as its limits let it.
//!
//! Needs noise above the sensor's resolution wherever the force loop is closed; where nothing
//! touches and nothing shakes, a coarse sensor stands still as well. Cannot see: a sensor that is
//! wrong and goes on trembling.

use crate::scalar::{Real, lit};
use crate::spatial::Wrench;
use nalgebra::Vector3;

/// Readings exactly alike, one after another, from which on a sensor is not believed: four periods
/// of 12 ms move the external force loop's depth by half a millimetre, at most.
pub const STUCK: u8 = 4;

/// Counts how often a reading comes exactly the same again.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RepeatCounter<V> {
    last: Option<V>,
    alike: u8,
}

impl<V: PartialEq> RepeatCounter<V> {
    /// Nothing read yet.
    pub const fn new() -> Self {
        Self { last: None, alike: 0 }
    }

    /// Takes a reading; how many in a row have been like it, itself included.
    pub fn count(&mut self, reading: V) -> u8 {
        if self.last.as_ref() == Some(&reading) {
            self.alike = self.alike.saturating_add(1);
        } else {
            (self.last, self.alike) = (Some(reading), 1);
        }
        self.alike
    }
}

impl<V: PartialEq> Default for RepeatCounter<V> {
    fn default() -> Self {
        Self::new()
    }
}

/// Watches a force sensor for readings that stand still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckDetector<T: Real>(RepeatCounter<Wrench<T>>);

impl<T: Real> StuckDetector<T> {
    /// A watch that has seen nothing.
    pub fn new() -> Self {
        Self(RepeatCounter::new())
    }

    /// Takes the reading of this period: the same, or no number where it has stood still for
    /// [`STUCK`] periods. One reading that differs in any channel is believed again.
    pub fn believed(&mut self, wrench: &Wrench<T>) -> Wrench<T> {
        if self.0.count(*wrench) < STUCK {
            return *wrench;
        }
        let nothing = Vector3::repeat(lit(f64::NAN));
        Wrench { moment: nothing, force: nothing }
    }
}

impl<T: Real> Default for StuckDetector<T> {
    fn default() -> Self {
        Self::new()
    }
}
