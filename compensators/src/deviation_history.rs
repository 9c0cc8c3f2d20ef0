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
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Largest age of a measurement, periods.
const HISTORY_PERIODS: usize = 32;

/// The second equal reading in a row is not used: sensors have noise. A live one whose steps are as
/// coarse as its noise loses a few readings by it.
const REPEATED: u8 = 2;

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
    past: Deque<Twist<T>, HISTORY_PERIODS>,
    /// What was read last in each direction that a sensor measures most.
    read: [DirectionReadings<T>; 6],
}

/// Readings of one direction.
#[derive(Debug, Clone, Copy)]
struct DirectionReadings<T: Real> {
    equal: RepeatCounter<T>,
    /// The last innovation; `None` before the first.
    innovation: Option<T>,
}

impl<T: Real> DeviationHistory<T> {
    pub(crate) fn new(period: T) -> Self {
        let none = DirectionReadings { equal: RepeatCounter::new(), innovation: None };
        Self { period, past: Deque::new(), read: [none; 6] }
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.period);
    }

    /// Stores E − x̂₀ of this period, with x̂₀ the demand without anything learned.
    ///
    /// # Errors
    /// [`Fault::Compensation`] where it is not finite.
    pub(crate) fn remember(
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
    /// the noise. `None` for a measurement that cannot be used: not finite, too old, a repetition, or
    /// to be clipped and as far from the last one: an outlier comes alone, and a sensor that stands at
    /// the end of its range repeats itself.
    pub(crate) fn innovation(
        &mut self,
        measurement: &DeviationMeasurement<T>,
        expected: T,
        clipped: f64,
    ) -> Option<T> {
        if !measurement.is_usable() {
            return None;
        }
        let read = self.read.get_mut(direction(measurement))?;
        if read.equal.count(measurement.deviation) >= REPEATED {
            return None;
        }
        let periods = measurement.age / self.period;
        let back = (0..self.past.len()).find(|back| lit::<T>(*back as f64 + 0.5) >= periods)?;
        let then = self.past.iter().rev().nth(back)?;
        let innovation = measurement.of(then) - measurement.deviation - expected;
        let most = measurement.noise * lit(clipped);
        let last = read.innovation.replace(innovation);
        let jumps = last.is_some_and(|last| (innovation - last).abs() > most);
        let usable = innovation.is_finite() && !(jumps && innovation.abs() > most);
        usable.then(|| innovation.max(-most).min(most))
    }

    /// h without depth, and the innovation against an `expected` x − x̂₀. `None` as for
    /// [`innovation`](Self::innovation), and where nothing but depth was measured.
    pub(crate) fn innovation_along(
        &mut self,
        measurement: &DeviationMeasurement<T>,
        expected: &SVector<T, 6>,
        clipped: f64,
    ) -> Option<(SVector<T, 6>, T)> {
        let along = beside_depth(measurement);
        let innovation = self.innovation(measurement, along.dot(expected), clipped)?;
        (along.norm_squared() > T::zero()).then_some((along, innovation))
    }
}

/// The direction that is measured most, with a radian counted as a metre.
fn direction<T: Real>(measurement: &DeviationMeasurement<T>) -> usize {
    let along = measurement.along.to_vector();
    let most = along.iter().enumerate().fold((0, T::zero()), |(k, most), (i, a)| {
        if a.abs() > most { (i, a.abs()) } else { (k, most) }
    });
    most.0
}

impl<T: Real> Stateful for DeviationHistory<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.queue(&mut self.past, Twist::zero(), |visitor, beyond| visitor.twist(beyond))?;
        self.read.iter_mut().try_for_each(|read| {
            read.equal.visit_state(visitor)?;
            visitor.scalar_option(&mut read.innovation)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What of these readings across the seam a law gets, with no encoder displaced.
    fn used<const N: usize>(readings: [f64; N]) -> [Option<f64>; N] {
        let mut history = DeviationHistory::<f64>::new(0.012);
        history.past.push_back(Twist::zero()).expect("room");
        let along = Twist { linear: nalgebra::Vector3::y(), ..Twist::zero() };
        let read = |deviation| {
            let noise = 1e-4;
            let measurement =
                DeviationMeasurement { deviation, along, noise, age: 0.0, ahead: 0.0 };
            history.innovation(&measurement, 0.0, 10.0)
        };
        readings.map(read)
    }

    #[test]
    fn outliers_repetitions_and_the_end_of_the_range_move_nothing() {
        assert_eq!(used([1e-4, -2e-4, -2e-4, 1e-4]), [Some(-1e-4), Some(2e-4), None, Some(-1e-4)]);
        assert_eq!(
            used([1e-4, 0.01, 0.01, 0.01, 2e-4]),
            [Some(-1e-4), None, None, None, Some(-2e-4)]
        );
        // Two that differ are no outlier: the tool is far off, and comes back by clipped steps.
        assert_eq!(used([0.01, 0.0105, 0.011]), [Some(-1e-3), Some(-1e-3), Some(-1e-3)]);
        assert_eq!(used([1e-4, 0.01, 0.0105]), [Some(-1e-4), None, Some(-1e-3)]);
        // Nor is one that crosses the limit on its way.
        assert_eq!(used([9e-4, 1.1e-3, 9e-4]), [Some(-9e-4), Some(-1e-3), Some(-9e-4)]);
    }
}
