//! Seam tracking: the reading of a seam sensor fed back on top of another law.
//!
//! With x̂₀ the demand of the inner law, the demand is x = x̂₀ + b. Every measurement corrects b:
//!
//! ```text
//! r = h·(E − x̂₀)(t − age) − z − h·(b + shape ahead)          innovation (see `deviation_history`)
//! Δ = g h r / (h·h),  g = 1 − e^(−λT)                         depth left out
//! b ← b + (1 − ρ) Δ,   shape ahead ← shape ahead + ρ Δ
//! ρ = σ v / (1 + σ v)
//! ```
//!
//! A sensor ahead of the tool cannot separate a drifting tool from a turning seam. The share ρ of an
//! innovation is taken for the seam's shape and kept until the tool arrives where it was seen
//! (preview); the rest corrects the tool at once. That is the steady-state Kalman filter of two
//! random walks, b over time and the shape over the path, with σ the ratio of their spectral
//! densities, s/m. At rest (v = 0) all of it corrects the tool.
//!
//! Needs: deviation measurements. Not observable: depth, and directions that the sensor does not
//! measure, such as the travel angle; there the inner law acts alone. A yaw that the inner law does
//! not know of shows as an offset of look-ahead × yaw. Without readings b is held; repeated and
//! impossible readings are ignored. Tuning: λ above the rate at which loads change while the feed
//! rises, and below some 5 rad/s, from where the plastic channel behind the tool makes the loop
//! oscillate; noise z passes as z √(λT/2).

use crate::deviation_history::DeviationHistory;
use crate::gain::{GainError, gains, positive, require, usable_period};
use crate::law::{Law, Needs, Setup};
use crate::{FeedForward, OuterIntegral};
use heapless::Deque;
use nalgebra::SVector;
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Places ahead of the tool at which a shape is kept.
const SHAPE_PLACES: usize = 64;

/// Innovations are clipped at so many standard deviations of the noise: an outlier moves the tool
/// little.
const SEAM_INNOVATION_LIMIT: f64 = 10.0;

gains! {
    /// Gains of seam tracking.
    pub struct TrackingGains {
        /// λ, rad/s. 4.5: as fast as the plastic channel behind the tool lets it be with margins.
        pub rate_rad_s: f64 = 4.5,
        /// σ, s/m. 0: nothing waits. For seams of unknown shape on material that hardly answers the tool;
        /// on firm material what it answers must not wait for the look-ahead, and the tool swings.
        pub seam_shape_s_m: f64 = 0.0,
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
    history: DeviationHistory<T>,
    /// b, axes of W.
    learned: SVector<T, 6>,
    /// Path position of each place, m, and the shape seen there.
    ahead: Deque<(T, SVector<T, 6>), SHAPE_PLACES>,
    path: Option<T>,
}

impl<T: Real, L> SeamTracking<T, L> {
    /// A tracker on top of the law `inner`. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless rate and period are positive and σ is not negative, all finite.
    // See `RunningCore::new`.
    #[inline(always)]
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
            history: DeviationHistory::new(period),
            learned: SVector::zeros(),
            ahead: Deque::new(),
            path: None,
        })
    }

    /// Moves the shape at which the tool has arrived into the correction.
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
        // One place spans so much of the look-ahead that all of it fits.
        let width = self
            .ahead
            .front()
            .map_or(T::zero(), |first| (place - first.0) / lit((SHAPE_PLACES - 1) as f64));
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

    fn correct(&mut self, measurement: &DeviationMeasurement<T>, path: T, share: T) {
        let pending = self.ahead.iter().fold(self.learned, |sum, (_, shape)| sum + shape);
        let Some((along, innovation)) =
            self.history.innovation_along(measurement, &pending, SEAM_INNOVATION_LIMIT)
        else {
            return;
        };
        let step = along * (self.gain * innovation / along.norm_squared());
        self.learned += step * (T::one() - share);
        if share > T::zero() {
            self.keep(path + measurement.ahead, step * share);
        }
    }
}

impl<T: Real> Law<T> for SeamTracking<T, FeedForward> {
    const NAME: &'static str = "seam-tracking";
    const SUMMARY: &'static str = "Feed-forward, corrected by a seam sensor";
    const NEEDS: Needs = Needs { seam_sensor: true, ..Needs::NOTHING };
    const BANDWIDTH_GAINS: &'static [&'static str] = &["rate_rad_s"];
    type Gains = TrackingGains;
    type Built = OuterIntegral<T, Self>;

    // See `RunningCore::new`.
    #[inline(always)]
    fn build(gains: &TrackingGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        let law = Self::new(FeedForward, gains, setup.period)?;
        OuterIntegral::new(law, &setup.following, setup.period)
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for SeamTracking<T, L> {
    fn reset(&mut self) {
        self.inner.reset();
        self.history.reset();
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
        self.history.remember(robot, observation, &inner)?;
        let speed = self
            .path
            .map_or(T::zero(), |before| (observation.path - before).max(T::zero()) / self.period);
        self.path = Some(observation.path);
        let turns = self.shape * speed;
        let share = turns / (T::one() + turns);
        self.arrive(observation.path);
        for measurement in observation.measurements {
            self.correct(measurement, observation.path, share);
        }
        Ok(inner + Twist::from_vector(&self.learned))
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.inner.visit_state(visitor)?;
        self.history.visit_state(visitor)?;
        visitor.matrix(&mut self.learned)?;
        let blank = (T::zero(), SVector::zeros());
        visitor.queue(&mut self.ahead, blank, |visitor, (place, shape)| {
            visitor.scalar(place)?;
            visitor.matrix(shape)
        })?;
        visitor.scalar_option(&mut self.path)
    }
}
