//! Innovations of deviation measurements, for all laws that learn from them.
//!
//! The real tool is on its nominal pose where the encoders are displaced from the set-point by the
//! right demand x. Where they are displaced by E instead, the tool deviates by d = E − x. A
//! measurement z = h·d therefore measures the demand,
//!
//! h·x = h·E(t − age) − z,
//!
//! whatever the robot did meanwhile. A law that estimates x from it is an observer beside the
//! control loop: the delay of a sensor costs the loop no phase.

use heapless::Deque;
use nalgebra::SVector;
use trueweld_core::compensation::{DeviationMeasurement, Observation};
use trueweld_core::control::RepeatCounter;
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, Real, Robot, Twist};

/// Largest age of a measurement, periods.
const REMEMBERED: usize = 32;

/// A sensor that repeats a reading exactly so often is stuck: sensors have noise.
const STUCK: u8 = 8;

/// h without depth, which is the force loop's.
pub(crate) fn beside_depth<T: Real>(measurement: &DeviationMeasurement<T>) -> SVector<T, 6> {
    let mut along = measurement.along.to_vector();
    along[5] = T::zero();
    along
}

/// The recent displacements of the encoders, which measurements with an age refer to.
#[derive(Debug, Clone)]
pub(crate) struct DeviationHistory<T: Real> {
    period: T,
    /// E − x̂₀, newest last.
    past: Deque<Twist<T>, REMEMBERED>,
    /// One counter for each direction that a sensor measures most.
    same: [RepeatCounter<T>; 6],
}

impl<T: Real> DeviationHistory<T> {
    pub fn new(period: T) -> Self {
        Self { period, past: Deque::new(), same: [const { RepeatCounter::new() }; 6] }
    }

    pub fn reset(&mut self) {
        *self = Self::new(self.period);
    }

    /// Stores E − x̂₀ of this period, with x̂₀ the demand without anything learned.
    ///
    /// # Errors
    /// [`Fault::Compensation`] where it is not finite.
    pub fn remember(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
        inner: &Twist<T>,
    ) -> Result<(), Fault> {
        let beyond = observation.encoder_displacement(robot) - *inner;
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

    /// h·(x − x̂₀) as measured, less the `expected` value, clipped at so many standard deviations of
    /// the noise. `None` for a measurement that cannot be used: not finite, too old, or stuck.
    pub fn innovation(
        &mut self,
        measurement: &DeviationMeasurement<T>,
        expected: T,
        clipped: f64,
    ) -> Option<T> {
        if !measurement.is_usable() || self.is_stuck(measurement) {
            return None;
        }
        let periods = measurement.age / self.period;
        let back = (0..self.past.len()).find(|back| lit::<T>(*back as f64 + 0.5) >= periods)?;
        let then = self.past.iter().rev().nth(back)?;
        let innovation = measurement.of(then) - measurement.deviation - expected;
        let most = measurement.noise * lit(clipped);
        innovation.is_finite().then(|| innovation.max(-most).min(most))
    }

    /// h without depth, and the innovation against an `expected` x − x̂₀. `None` as for
    /// [`innovation`](Self::innovation), and where nothing but depth was measured.
    pub fn innovation_along(
        &mut self,
        measurement: &DeviationMeasurement<T>,
        expected: &SVector<T, 6>,
        clipped: f64,
    ) -> Option<(SVector<T, 6>, T)> {
        let along = beside_depth(measurement);
        let innovation = self.innovation(measurement, along.dot(expected), clipped)?;
        (along.norm_squared() > T::zero()).then_some((along, innovation))
    }

    fn is_stuck(&mut self, measurement: &DeviationMeasurement<T>) -> bool {
        let along = measurement.along.to_vector();
        // The direction measured most, with a radian counted as a metre.
        let kind = along.iter().enumerate().fold((0, T::zero()), |(k, most), (i, a)| {
            if a.abs() > most { (i, a.abs()) } else { (k, most) }
        });
        self.same.get_mut(kind.0).is_some_and(|same| same.count(measurement.deviation) >= STUCK)
    }
}
