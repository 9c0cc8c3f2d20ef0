//! Checks of what a period is given, before a controller or a law acts on it.
//!
//! A live force sensor has noise: its six channels do not all repeat to the last digit for long. They
//! do where the sensor is stuck or saturated, has dropped to zero, or its bus repeats the last
//! telegram. And no reading lies beyond what the sensor can measure: one that does is of the bus or
//! of an overloaded sensor. Such readings are replaced by NaN, and controllers and laws hold as for
//! any faulty sensor. A force loop on a stuck reading would press the tool in up to its limits, and a
//! law on a single wrong one moves it by millimetres.
//!
//! Requires noise above the sensor's resolution while the force loop is closed: with the tool free
//! and at rest, a coarse sensor repeats its reading too. Not detected: a reading that is wrong but
//! still noisy and within the range.

use super::{SensorReadings, Setpoint};
use crate::error::Fault;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real, lit};
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

/// Largest reading of each channel of a force sensor. 0: not known, and not checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceRange<T: Real> {
    /// Of a moment, N·m.
    pub moment: T,
    /// Of a force, N.
    pub force: T,
}

impl<T: Real> ForceRange<T> {
    /// Not known.
    pub fn unknown() -> Self {
        Self { moment: T::zero(), force: T::zero() }
    }

    /// True where every channel is within its range; at its end the sensor is saturated.
    fn holds(&self, wrench: &Wrench<T>) -> bool {
        let within = |channels: &Vector3<T>, most: T| {
            most <= T::zero() || channels.iter().all(|channel| channel.abs() < most)
        };
        within(&wrench.moment, self.moment) && within(&wrench.force, self.force)
    }
}

/// Replaces the readings of a force sensor that is stuck or beyond its range by NaN.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceSensorCheck<T: Real> {
    repeated: RepeatCounter<Wrench<T>>,
    range: ForceRange<T>,
}

impl<T: Real> ForceSensorCheck<T> {
    /// Nothing read yet.
    pub fn new(range: ForceRange<T>) -> Self {
        Self { repeated: RepeatCounter::new(), range }
    }

    /// Forgets what was read.
    pub fn reset(&mut self) {
        self.repeated = RepeatCounter::new();
    }

    /// Takes the reading of this period and returns it. Or NaN: from the [`STUCK`]th equal reading
    /// on, until one differs in any channel; and for a reading beyond the range.
    pub fn checked(&mut self, wrench: &Wrench<T>) -> Wrench<T> {
        if self.repeated.count(*wrench) < STUCK && self.range.holds(wrench) {
            return *wrench;
        }
        let nan = Vector3::repeat(lit(f64::NAN));
        Wrench { moment: nan, force: nan }
    }
}

/// Checks encoders and set-point from period to period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InputCheck<T: Real> {
    last_good: JointVector<T>,
}

impl<T: Real> InputCheck<T> {
    /// Starts at these encoder angles, rad.
    pub fn new(encoder: &JointVector<T>) -> Self {
        Self { last_good: *encoder }
    }

    /// Encoder angles of the last period in which they were good, rad.
    pub fn last_good(&self) -> &JointVector<T> {
        &self.last_good
    }

    /// Takes what a period is given. `elapsed`: since the last one, s.
    ///
    /// # Errors
    /// [`Fault::Encoder`], [`Fault::Setpoint`], [`Fault::Limit`].
    pub fn check(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
        elapsed: T,
    ) -> Result<(), Fault> {
        for i in 0..JOINTS {
            let (angle, rate) = (sensed.encoder[i], sensed.encoder_rate[i]);
            let reach = robot.parameters().joints[i].max_rate * elapsed * lit(2.0);
            if !angle.is_finite() || !rate.is_finite() || (angle - self.last_good[i]).abs() > reach
            {
                return Err(Fault::Encoder(i));
            }
        }
        // Good encoders are remembered whatever else is wrong, or an arm that moves meanwhile would
        // stay locked out.
        self.last_good = sensed.encoder;
        if !setpoint.is_sound() {
            return Err(Fault::Setpoint);
        }
        robot.beyond_limits(&sensed.encoder).map_or(Ok(()), |joint| Err(Fault::Limit(joint)))
    }
}
