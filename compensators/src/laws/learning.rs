//! Iterative learning for repeated parts: the deviation measured along one weld corrects the next.
//!
//! Over the path position s, in segments of equal length, with b what laws on top (seam tracking,
//! the outer integral) added to the demand, and −h·d a measured deviation to be corrected:
//!
//! ```text
//! pass j:         x = x̂₀ + c_j(s) + b,   e_j(s) = mean of −h (h·d) / (h·h) at s,   b_j(s) likewise
//! between passes: c_{j+1} = Q (c_j + γ (e_j + F b_j))
//! ```
//!
//! Q: triangular mean over 24 mm, F: over a quarter of a metre. Both are without phase, since the
//! whole pass is known. While the push rises, the correction rises with it.
//!
//! Why F: what is measured while the tool is off contains what the material answers to that, A times
//! the deviation, and what seam tracking makes of it. With tracking of rate λ on top, and γ = 1,
//!
//! ```text
//! d_{j+1} = (A + (1 − F) λ/s) / (1 + A + λ/s) · d_j
//! ```
//!
//! Where b is kept in full (F = 1), a wave whose A leads by enough grows from pass to pass: on firm
//! material those of 40 to 130 mm. Where none of it is kept (F = 0) every wave becomes smaller on any
//! material that resists (Re A ≥ 0), but long ones hardly. So long waves are kept, short ones not.
//! Waves so short that correction and position loop are late by more than A leads are left to Q.
//!
//! Needs: deviation measurements along the whole weld, and a part that repeats. Not observable:
//! what differs from pass to pass. Tuning: γ = 1 for a sensor whose noise the segments average out (a
//! segment of 8 mm has 65 readings at 10 mm/s), less for fewer readings.

use crate::deviation_history::DeviationHistory;
use crate::gain::{GainError, gains, positive, require, usable_period};
use crate::law::{Law, Needs, Setup};
use crate::{FeedForward, OuterIntegral, SeamTracking, TrackingGains};
use heapless::Vec;
use nalgebra::SVector;
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Segments along a weld.
const SEGMENTS: usize = 256;

/// Push from which on a measurement is used, as a share of the largest push planned so far.
const FULL_PUSH_SHARE: f64 = 0.98;

/// Half width of the triangular mean F over what laws on top added, m: waves shorter than this are
/// not taken over. On material ten times as firm as the arm is across the seam, whose channel has a
/// length of 8 mm, those below 0.125 m would grow at 10 mm/s (k² = λ/(2·10·L·v)).
const LONG: f64 = 0.125;

/// Half width of the triangular mean Q over the correction, m. Waves below 10 mm are left out: at 10
/// mm/s arm, position loop and correction loop follow them more than a quarter of a turn late, and
/// what is learned of them comes with the wrong sign.
const SMOOTHING_HALF_WIDTH: f64 = 0.012;

/// Innovations are clipped at so many standard deviations of the noise. Wide: a first pass is off
/// by millimetres.
const LEARNING_INNOVATION_LIMIT: f64 = 100.0;

/// Share of the rate of the outer integral across the seam. Beside seam tracking as slow as this one,
/// all of it leaves a modulus margin of 0.41 where the tool stands and dry friction holds the drives
/// (docs/margins.md); this share leaves 0.53.
const FOLLOWING: f64 = 5.0 / 6.0;

/// What was measured in one segment.
#[derive(Debug, Clone, Copy)]
struct Segment<T: Real> {
    /// Sum of what laws on top added to the demand.
    added: SVector<T, 6>,
    /// Sum of what was left to correct; between passes c_j + γ (e_j + F b_j).
    left: SVector<T, 6>,
    /// Sum of the weights of both.
    weight: SVector<T, 6>,
}

impl<T: Real> Segment<T> {
    fn empty() -> Self {
        let zero = SVector::zeros();
        Self { added: zero, left: zero, weight: zero }
    }

    /// Sum over weight, zero where nothing was measured.
    fn mean(sum: &SVector<T, 6>, weight: &SVector<T, 6>) -> SVector<T, 6> {
        sum.zip_map(weight, |s, w| if w > T::zero() { s / w } else { T::zero() })
    }
}

gains! {
    /// Gains of the learning law.
    pub struct LearningGains {
        /// γ, above 0 and at most 1. 1: the next pass is corrected by all of this one's error.
        pub share: f64 = 1.0,
        /// λ of the seam tracking on top, rad/s; see [`TrackingGains`].
        pub rate_rad_s: f64 = 3.0,
        /// σ of the seam tracking on top, s/m; see [`TrackingGains`].
        pub seam_shape_s_m: f64 = 0.0,
    }
}

/// Learning law on top of another one.
#[derive(Debug, Clone)]
pub struct Learning<T: Real, L> {
    inner: L,
    gain: T,
    spacing: T,
    history: DeviationHistory<T>,
    /// Empty until the first weld starts: a law that is built is moved to where it runs, and this is
    /// most of it.
    learned: Vec<SVector<T, 6>, SEGMENTS>,
    /// Likewise.
    pass: Vec<Segment<T>, SEGMENTS>,
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
    // See `RunningCore::new`.
    #[inline(always)]
    pub fn new(inner: L, length: T, share: f64, period: T) -> Result<Self, GainError> {
        require(share > 0.0 && share <= 1.0, "share", "a number above 0 and at most 1")?;
        positive(length, "length")?;
        usable_period(period)?;
        Ok(Self {
            inner,
            gain: lit(share),
            spacing: length / lit((SEGMENTS - 1) as f64),
            history: DeviationHistory::new(period),
            learned: Vec::new(),
            pass: Vec::new(),
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
            self.history.innovation_along(measurement, correction, LEARNING_INNOVATION_LIMIT)
        else {
            return;
        };
        let square = along.norm_squared();
        let (before, after, share) = self.nodes(path);
        let nearest = if share < lit(0.5) { before } else { after };
        if let Some(place) = self.pass.get_mut(nearest) {
            // A measurement weighs most in the direction that it measures most.
            let weight = along.component_mul(&along) / square;
            let share = along.component_mul(&weight) / square;
            let most = measurement.noise * lit(LEARNING_INNOVATION_LIMIT);
            let left = (-measurement.deviation).max(-most).min(most);
            place.left += share * left;
            place.added += share * (innovation - left);
            place.weight += weight;
        }
    }

    /// Adds what the last pass measured to the correction.
    fn learn(&mut self) {
        for (k, learned) in self.learned.iter().enumerate() {
            let mut long = Segment::empty();
            for (near, share) in around(&self.pass, k, lit::<T>(LONG) / self.spacing) {
                long.added += near.added * share;
                long.weight += near.weight * share;
            }
            let added = Segment::mean(&long.added, &long.weight);
            if let Some(place) = self.pass.get_mut(k) {
                let left = Segment::mean(&place.left, &place.weight);
                place.left = learned + (added + left) * self.gain;
            }
        }
        for (k, learned) in self.learned.iter_mut().enumerate() {
            let (mut sum, mut shares) = (SVector::zeros(), T::zero());
            for (near, share) in
                around(&self.pass, k, lit::<T>(SMOOTHING_HALF_WIDTH) / self.spacing)
            {
                sum += near.left * share;
                shares += share;
            }
            *learned = sum / shares;
        }
    }

    /// A pass of which nothing is measured yet.
    fn begin_pass(&mut self) {
        self.pass.clear();
        // As many as there is room for.
        let _ = self.learned.resize(SEGMENTS, SVector::zeros());
        let _ = self.pass.resize(SEGMENTS, Segment::empty());
    }
}

/// The values about place `k` with their shares in a triangular mean: one at the place itself,
/// falling to none beyond `half` places, or beyond one where that is less.
fn around<V, T: Real>(values: &[V], k: usize, half: T) -> impl Iterator<Item = (&V, T)> {
    let half = half.max(T::one()).min(lit(SEGMENTS as f64));
    let far = nalgebra::try_convert::<T, f64>(half).map_or(1, |half| half as usize);
    let share = move |i: usize| T::one() - lit::<T>(i.abs_diff(k) as f64) / (half + T::one());
    let near = values.iter().enumerate().take(k + far + 1).skip(k.saturating_sub(far));
    near.map(move |(i, value)| (value, share(i)))
}

impl<T: Real> Law<T> for Learning<T, FeedForward> {
    const NAME: &'static str = "learning";
    const SUMMARY: &'static str = "Seam tracking, corrected from pass to pass (--passes)";
    const NEEDS: Needs = Needs { seam_sensor: true, passes: true, ..Needs::NOTHING };
    const BANDWIDTH_GAINS: &'static [&'static str] = &["rate_rad_s"];
    type Gains = LearningGains;
    type Built = OuterIntegral<T, SeamTracking<T, Self>>;

    // See `RunningCore::new`.
    #[inline(always)]
    fn build(gains: &LearningGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        let LearningGains { share, rate_rad_s, seam_shape_s_m } = *gains;
        let law = Self::new(FeedForward, setup.length, share, setup.period)?;
        let tracking = TrackingGains { rate_rad_s, seam_shape_s_m };
        let law = SeamTracking::new(law, &tracking, setup.period)?;
        OuterIntegral::new(law, &setup.following.across(FOLLOWING), setup.period)
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for Learning<T, L> {
    fn reset(&mut self) {
        let has_seen = self.pass.iter().any(|place| place.weight.amax() > T::zero());
        if has_seen && !self.frozen {
            self.learn();
        }
        self.begin_pass();
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
        if self.pass.is_empty() {
            self.begin_pass();
        }
        let inner = self.inner.demand(robot, observation)?;
        self.history.remember(robot, observation, &inner)?;
        let push = -observation.planned.force.z;
        self.push = self.push.max(push);
        let raised =
            if self.push > T::zero() { (push / self.push).max(T::zero()) } else { T::zero() };
        let correction = self.correction(observation.path) * raised;
        if raised >= lit(FULL_PUSH_SHARE) && !self.frozen {
            for measurement in observation.measurements {
                self.see(measurement, observation.path, &correction);
            }
        }
        Ok(inner + Twist::from_vector(&correction))
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.inner.visit_state(visitor)?;
        self.history.visit_state(visitor)?;
        let length = visitor.length(self.learned.len(), SEGMENTS)?;
        // No more than there is room for.
        let _ = self.learned.resize(length, SVector::zeros());
        self.learned.iter_mut().try_for_each(|learned| visitor.matrix(learned))?;
        let length = visitor.length(self.pass.len(), SEGMENTS)?;
        let _ = self.pass.resize(length, Segment::empty());
        self.pass.iter_mut().try_for_each(|place| {
            visitor.matrix(&mut place.added)?;
            visitor.matrix(&mut place.left)?;
            visitor.matrix(&mut place.weight)
        })?;
        visitor.scalar(&mut self.push)?;
        visitor.flag(&mut self.frozen)
    }
}
