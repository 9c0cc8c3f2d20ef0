//! Iterative learning for repeated parts: the deviation measured along one weld corrects the next.
//!
//! Over the path position s, in segments of equal length, with r the innovation of every measurement
//! (see `deviation_history`):
//!
//! ```text
//! pass j:         x = x̂₀ + c_j(s),   e_j(s) = mean of h r / (h·h) at s
//! between passes: c_{j+1} = Q (c_j + γ e_j)
//! ```
//!
//! Q: mean over three neighbouring segments, without phase, since the whole pass is known. The
//! iteration converges where |1 − γ| < 1 at all wavelengths that Q passes, whatever the dynamics of
//! the loop: e_j is the error of the demand, not of the loop. While the push rises, the correction
//! rises with it.
//!
//! Needs: deviation measurements along the whole weld, and a part that repeats. Not observable:
//! what differs from pass to pass. Tuning: γ = 1 for a sensor whose noise the segments average out (a
//! segment of 8 mm has 65 readings at 10 mm/s), less for fewer readings.

use crate::deviation_history::DeviationHistory;
use crate::gain::{GainError, positive, require, usable_period};
use crate::law::{Law, Needs, Setup};
use crate::{FeedForward, OuterIntegral, SeamTracking, TrackingGains};
use nalgebra::SVector;
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, Real, Robot, Twist};

/// Segments along a weld.
const SEGMENTS: usize = 256;

/// Push from which on a measurement is used, as a share of the largest push planned so far.
const FULL: f64 = 0.98;

/// Innovations are clipped at so many standard deviations of the noise. Wide: a first pass is off
/// by millimetres.
const CLIPPED: f64 = 100.0;

/// What was measured in one segment: sum of the corrections, and of their weights.
#[derive(Debug, Clone, Copy)]
struct Segment<T: Real> {
    sum: SVector<T, 6>,
    weight: SVector<T, 6>,
}

/// Gains of the learning law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "host", derive(serde::Serialize, serde::Deserialize))]
pub struct LearningGains {
    /// γ, above 0 and at most 1. 1: the next pass is corrected by all of this one's error.
    pub share: f64,
    /// λ of the seam tracking on top, rad/s; see [`TrackingGains`].
    pub rate_rad_s: f64,
    /// σ of the seam tracking on top, s/m; see [`TrackingGains`].
    pub seam_shape_s_m: f64,
}

impl Default for LearningGains {
    fn default() -> Self {
        let TrackingGains { rate_rad_s, seam_shape_s_m } = TrackingGains::default();
        Self { share: 1.0, rate_rad_s, seam_shape_s_m }
    }
}

/// Learning law on top of another one.
#[derive(Debug, Clone)]
pub struct Learning<T: Real, L> {
    inner: L,
    gain: T,
    spacing: T,
    history: DeviationHistory<T>,
    learned: [SVector<T, 6>; SEGMENTS],
    pass: [Segment<T>; SEGMENTS],
    /// Largest push planned so far, N.
    push: T,
    frozen: bool,
}

impl<T: Real, L> Learning<T, L> {
    /// A law before its first pass, on top of the law `inner`. `length`: of the weld, m;
    /// `share`: γ; `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless length and period are positive and 0 < γ ≤ 1.
    pub fn new(inner: L, length: T, share: f64, period: T) -> Result<Self, GainError> {
        require(share > 0.0 && share <= 1.0, "share", "a number above 0 and at most 1")?;
        positive(length, "length")?;
        usable_period(period)?;
        Ok(Self {
            inner,
            gain: lit(share),
            spacing: length / lit((SEGMENTS - 1) as f64),
            history: DeviationHistory::new(period),
            learned: [SVector::zeros(); SEGMENTS],
            pass: [Segment { sum: SVector::zeros(), weight: SVector::zeros() }; SEGMENTS],
            push: T::zero(),
            frozen: false,
        })
    }

    /// The nodes before and after a path position, and the share of the way between them.
    fn nodes(&self, path: T) -> (usize, usize, T) {
        let at = (path / self.spacing).max(T::zero()).min(lit((SEGMENTS - 1) as f64));
        // NaN counts as the start.
        let before =
            nalgebra::try_convert::<T, f64>(at).map_or(0, |at| (at as usize).min(SEGMENTS - 2));
        (before, before + 1, at - lit(before as f64))
    }

    /// c(s).
    fn correction(&self, path: T) -> SVector<T, 6> {
        let (before, after, share) = self.nodes(path);
        match (self.learned.get(before), self.learned.get(after)) {
            (Some(a), Some(b)) => a * (T::one() - share) + b * share,
            _ => SVector::zeros(),
        }
    }

    fn see(&mut self, measurement: &DeviationMeasurement<T>, path: T, correction: &SVector<T, 6>) {
        let Some((along, innovation)) =
            self.history.innovation_along(measurement, correction, CLIPPED)
        else {
            return;
        };
        let square = along.norm_squared();
        let (before, after, share) = self.nodes(path);
        let nearest = if share < lit(0.5) { before } else { after };
        if let Some(place) = self.pass.get_mut(nearest) {
            // A measurement weighs most in the direction that it measures most.
            let weight = along.component_mul(&along) / square;
            place.sum += along.component_mul(&weight) * (innovation / square);
            place.weight += weight;
        }
    }

    /// Adds what the last pass measured to the correction.
    fn learn(&mut self) {
        let mut wanted = self.learned;
        for (wanted, place) in wanted.iter_mut().zip(&self.pass) {
            let mean = place
                .sum
                .zip_map(&place.weight, |s, w| if w > T::zero() { s / w } else { T::zero() });
            *wanted += mean * self.gain;
        }
        for (k, learned) in self.learned.iter_mut().enumerate() {
            let around = wanted.iter().skip(k.saturating_sub(1)).take(if k == 0 { 2 } else { 3 });
            let (sum, count) =
                around.fold((SVector::zeros(), T::zero()), |(sum, n), v| (sum + v, n + T::one()));
            *learned = sum / count;
        }
    }
}

impl<T: Real> Law<T> for Learning<T, FeedForward> {
    const NAME: &'static str = "learning";
    const SUMMARY: &'static str = "Seam tracking, corrected from pass to pass (--passes)";
    const NEEDS: Needs = Needs { seam_sensor: true, passes: true, ..Needs::NOTHING };
    const PACE: &'static [&'static str] = &["rate_rad_s"];
    type Gains = LearningGains;
    type Built = OuterIntegral<T, SeamTracking<T, Self>>;

    fn build(gains: &LearningGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        let LearningGains { share, rate_rad_s, seam_shape_s_m } = *gains;
        let law = Self::new(FeedForward, setup.length, share, setup.period)?;
        let tracking = TrackingGains { rate_rad_s, seam_shape_s_m };
        let law = SeamTracking::new(law, &tracking, setup.period)?;
        OuterIntegral::new(law, &setup.following, setup.period)
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for Learning<T, L> {
    fn reset(&mut self) {
        self.learn();
        self.pass = [Segment { sum: SVector::zeros(), weight: SVector::zeros() }; SEGMENTS];
        self.inner.reset();
        self.history.reset();
    }

    fn freeze(&mut self) {
        self.frozen = true;
        self.inner.freeze();
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let inner = self.inner.demand(robot, observation)?;
        self.history.remember(robot, observation, &inner)?;
        let push = -observation.planned.force.z;
        self.push = self.push.max(push);
        let raised =
            if self.push > T::zero() { (push / self.push).max(T::zero()) } else { T::zero() };
        let correction = self.correction(observation.path) * raised;
        if raised >= lit(FULL) && !self.frozen {
            for measurement in observation.measurements {
                self.see(measurement, observation.path, &correction);
            }
        }
        Ok(inner + Twist::from_vector(&correction))
    }
}
