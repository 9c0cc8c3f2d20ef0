//! What sightings say of the demand, for all laws that learn from them.
//!
//! Encoders that stand at set-point and demand x put the real tool on its nominal pose. Where they
//! stand at E beyond the set-point instead, the tool deviates by d = E − x. A sighting z = h·d
//! therefore says of the demand
//!
//! h·x = h·E(t − age) − z,
//!
//! whatever the robot did meanwhile: laws that learn x from it are observers beside the control
//! loop, and the delay of a sensor does not take away from the loop's phase.

use heapless::Deque;
use nalgebra::SVector;
use trueweld_core::compensation::{DeviationMeasurement, Observation};
use trueweld_core::control::RepeatCounter;
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, Real, Robot, Twist};

/// Periods that a sighting may be old.
const REMEMBERED: usize = 32;

/// A reading that comes so often exactly the same again is no reading: sensors have noise.
const STUCK: u8 = 8;

/// h without depth, which is the force loop's.
pub(crate) fn beside_depth<T: Real>(sighting: &DeviationMeasurement<T>) -> SVector<T, 6> {
    let mut along = sighting.along.to_vector();
    along[5] = T::zero();
    along
}

/// Sightings against what a law expects, with the past that old ones speak of.
#[derive(Debug, Clone)]
pub(crate) struct DeviationHistory<T: Real> {
    period: T,
    /// E less what is already demanded of it, newest last.
    past: Deque<Twist<T>, REMEMBERED>,
    /// By kind of reading, told apart by the direction that it sees most of.
    same: [RepeatCounter<T>; 6],
}

impl<T: Real> DeviationHistory<T> {
    pub fn new(period: T) -> Self {
        Self { period, past: Deque::new(), same: [const { RepeatCounter::new() }; 6] }
    }

    pub fn reset(&mut self) {
        *self = Self::new(self.period);
    }

    /// Takes E − x̂₀ of this period, x̂₀ what is demanded without anything learned.
    ///
    /// # Errors
    /// [`Fault::Compensation`] where that is no number.
    pub fn remember(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
        inner: &Twist<T>,
    ) -> Result<(), Fault> {
        let beyond =
            observation.encoder_deviation(robot) - observation.setpoint_deviation() - *inner;
        if !beyond.is_finite() {
            return Err(Fault::Compensation);
        }
        if self.past.is_full() {
            self.past.pop_front();
        }
        // Room was just made.
        let _ = self.past.push_back(beyond);
        Ok(())
    }

    /// h·(x − x̂₀) as a sighting has it, less what is `expected` of it, no further than so many
    /// deviations of its noise. `None` for a reading that is not to be used: no number, older than
    /// is remembered, or stuck.
    pub fn innovation(
        &mut self,
        sighting: &DeviationMeasurement<T>,
        expected: T,
        clipped: f64,
    ) -> Option<T> {
        if !sighting.is_usable() || self.is_stuck(sighting) {
            return None;
        }
        let periods = sighting.age / self.period;
        let back = (0..self.past.len()).find(|back| lit::<T>(*back as f64 + 0.5) >= periods)?;
        let then = self.past.iter().rev().nth(back)?;
        let innovation = sighting.of(then) - sighting.deviation - expected;
        let most = sighting.noise * lit(clipped);
        innovation.is_finite().then(|| innovation.max(-most).min(most))
    }

    fn is_stuck(&mut self, sighting: &DeviationMeasurement<T>) -> bool {
        let along = sighting.along.to_vector();
        // The direction seen most of, a radian counted as a metre.
        let kind = along.iter().enumerate().fold((0, T::zero()), |(k, most), (i, a)| {
            if a.abs() > most { (i, a.abs()) } else { (k, most) }
        });
        self.same.get_mut(kind.0).is_some_and(|same| same.count(sighting.deviation) >= STUCK)
    }
}
