//! Seam tracking: what a seam sensor sees across the seam, fed back on top of another law.
//!
//! With x̂₀ the demand of the law beneath, the tool's demand is x = x̂₀ + b, and every sighting
//! corrects b:
//!
//! ```text
//! r = h·(E − x̂₀)(t − age) − z − h·(b + shape ahead)          surprise (see `seen`)
//! Δ = g h r / (h·h),  g = 1 − e^(−λT)                         depth left out
//! b ← b + (1 − ρ) Δ,   shape ahead ← shape ahead + ρ Δ
//! ρ = σ v / (1 + σ v)
//! ```
//!
//! A sensor ahead of the tool cannot tell a tool that drifts from a seam that turns. The part ρ of
//! a surprise is taken for the seam's shape and kept until the tool comes to where it was seen
//! (preview); the rest corrects the tool at once. That is the steady Kalman filter of two random
//! walks, b over time and the shape over the path, σ the ratio of their spectral densities, s/m. A
//! tool at rest (v = 0) sees no shape.
//!
//! Needs: sightings; a seam taught to within what σ says. Sees nothing of: depth, and what the
//! sensor does not see, such as the travel angle; there the law beneath stands alone. A yaw that
//! the law beneath does not know of shows as an offset of look-ahead × yaw. Drop-outs hold b; stuck
//! and impossible readings are passed over. Tuning: λ above what the loads change with while the
//! feed rises, and below what the plastic channel behind the tool makes swing, some 4 rad/s; noise
//! z comes through as z √(λT/2).

use crate::deviation_history::{DeviationHistory, beside_depth};
use crate::law::{GainError, Law, Needs, Setup, positive, require, usable_period};
use crate::{FeedForward, OuterIntegral};
use heapless::Deque;
use nalgebra::SVector;
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, Real, Robot, Twist};

/// Places ahead of the tool where a shape is kept.
const PLACES: usize = 64;

/// Deviations of its noise beyond which a reading says no more than so many: a wild one moves the
/// tool by less than it misses.
const CLIPPED: f64 = 10.0;

/// Gains of seam tracking.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "host", derive(serde::Serialize, serde::Deserialize))]
pub struct TrackingGains {
    /// λ, rad/s. 4: as fast as the plastic channel behind the tool lets it be without oscillation.
    pub rate_rad_s: f64,
    /// σ, s/m. 0: the seam is where it was taught; 25 for one that is a line on a drawing.
    pub seam_shape_s_m: f64,
}

impl Default for TrackingGains {
    fn default() -> Self {
        Self { rate_rad_s: 4.0, seam_shape_s_m: 0.0 }
    }
}

/// Seam tracking on top of another law.
#[derive(Debug, Clone)]
pub struct SeamTracking<T: Real, L> {
    inner: L,
    /// g.
    gain: T,
    /// σ, s/m.
    shape: T,
    period: T,
    seen: DeviationHistory<T>,
    /// b, axes of W.
    learned: SVector<T, 6>,
    /// Where along the seam so much shape was seen.
    ahead: Deque<(T, SVector<T, 6>), PLACES>,
    path: Option<T>,
}

impl<T: Real, L> SeamTracking<T, L> {
    /// A tracker on top of the law `inner`. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless rate and period are positive and σ is not negative, all finite.
    pub fn new(inner: L, gains: &TrackingGains, period: T) -> Result<Self, GainError> {
        positive(gains.rate_rad_s, "rate_rad_s")?;
        let shape = gains.seam_shape_s_m;
        require(shape.is_finite() && shape >= 0.0, "seam_shape_s_m", "a number not below 0")?;
        usable_period(period)?;
        Ok(Self {
            inner,
            gain: T::one() - (-lit::<T>(gains.rate_rad_s) * period).exp(),
            shape: lit(shape),
            period,
            seen: DeviationHistory::new(period),
            learned: SVector::zeros(),
            ahead: Deque::new(),
            path: None,
        })
    }

    /// The shape ahead that the tool has come to is the tool's to follow.
    fn arrive(&mut self, path: T) {
        while let Some((place, shape)) = self.ahead.front().copied() {
            if place > path {
                break;
            }
            self.learned += shape;
            self.ahead.pop_front();
        }
    }

    fn keep(&mut self, place: T, shape: SVector<T, 6>) {
        // One place holds what is seen over a share of the look-ahead, so that all of it fits.
        let width = self
            .ahead
            .front()
            .map_or(T::zero(), |first| (place - first.0) / lit((PLACES - 1) as f64));
        match self.ahead.back_mut() {
            Some((last, held)) if place - *last <= width => *held += shape,
            _ => {
                if let Err((_, shape)) = self.ahead.push_back((place, shape))
                    && let Some((_, held)) = self.ahead.back_mut()
                {
                    *held += shape;
                }
            }
        }
    }

    fn correct(&mut self, sighting: &DeviationMeasurement<T>, path: T, share: T) {
        let along = beside_depth(sighting);
        let square = along.norm_squared();
        let pending = self.ahead.iter().fold(self.learned, |sum, (_, shape)| sum + shape);
        let Some(innovation) = self.seen.innovation(sighting, along.dot(&pending), CLIPPED) else {
            return;
        };
        if square <= T::zero() {
            return;
        }
        let step = along * (self.gain * innovation / square);
        self.learned += step * (T::one() - share);
        if share > T::zero() {
            self.keep(path + sighting.ahead, step * share);
        }
    }
}

impl<T: Real> Law<T> for SeamTracking<T, FeedForward> {
    const NAME: &'static str = "seam-tracking";
    const SUMMARY: &'static str = "Feed-forward, corrected by a seam sensor";
    const NEEDS: Needs = Needs { seam_sensor: true, ..Needs::NOTHING };
    type Gains = TrackingGains;
    type Built = OuterIntegral<T, Self>;

    fn build(gains: &TrackingGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        let law = Self::new(FeedForward, gains, setup.period)?;
        OuterIntegral::new(law, &setup.following, setup.period)
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for SeamTracking<T, L> {
    fn reset(&mut self) {
        self.inner.reset();
        self.seen.reset();
        self.learned = SVector::zeros();
        self.ahead.clear();
        self.path = None;
    }

    fn freeze(&mut self) {
        self.inner.freeze();
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let inner = self.inner.demand(robot, observation)?;
        self.seen.remember(robot, observation, &inner)?;
        let speed = self
            .path
            .map_or(T::zero(), |before| (observation.path - before).max(T::zero()) / self.period);
        self.path = Some(observation.path);
        let turns = self.shape * speed;
        let share = turns / (T::one() + turns);
        self.arrive(observation.path);
        for sighting in observation.sightings {
            self.correct(sighting, observation.path, share);
        }
        Ok(inner + Twist::from_vector(&self.learned))
    }
}
