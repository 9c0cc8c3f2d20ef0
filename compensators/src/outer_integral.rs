//! Outer integral: removes the following error that the position loop leaves of a law's demand.
//!
//! The joint loops' integrators leave no error under a constant load, but under a rising load one
//! in proportion to its rate: 9 kN·m/s at A2 and K_i = 6·10⁷ N·m/(rad·s) give 0.15 mrad, a third of
//! a millimetre at the tool. The encoders measure it. With x the demand of the inner law and E the
//! displacement of the encoders' pose from the set-point, both in W,
//!
//! ```text
//! c ← c + μT (x − E), |c| bounded        demand = x + c
//! ```
//!
//! Needs: encoders. Not observable: deflection behind them. Not on top of a law that is fed by the
//! load: that is a positive feedback through the material already, and with an integral around it
//! it oscillates (0.2 mm with an exact model, 0.02 mm without the integral). Tuning: μ across the
//! seam a quarter of the bandwidth of the correction loops. Along the seam nothing but the drives
//! damps the loop: a tool that stands, held by dry friction, and one whose drives have viscous
//! friction alone ask for a third of that there.

use crate::gain::{GainError, positive, usable_period};
use nalgebra::Vector2;
use trueweld_core::compensation::{Compensator, Observation, shortened};
use trueweld_core::scalar::{all_finite, lit};
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Gains of the outer integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowingGains {
    /// μ across the seam, rad/s. 6: a quarter of correction loops of 4 Hz.
    pub rate: f64,
    /// μ along the seam, rad/s. 1.75: a tool that lags along its seam still welds on it.
    pub along: f64,
    /// Largest |c|, m. 0.002.
    pub size: f64,
}

impl Default for FollowingGains {
    fn default() -> Self {
        Self { rate: 6.0, along: 1.75, size: 0.002 }
    }
}

impl FollowingGains {
    /// With a share of the rate across the seam.
    pub(crate) fn across(&self, share: f64) -> Self {
        Self { rate: share * self.rate, ..*self }
    }
}

/// Outer integral on top of another law.
#[derive(Debug, Clone, Copy)]
pub struct OuterIntegral<T: Real, L> {
    inner: L,
    /// μT, along x and y of W.
    share: Vector2<T>,
    size: T,
    /// c, along x and y of W, m.
    correction: Vector2<T>,
}

impl<T: Real, L> OuterIntegral<T, L> {
    /// On top of the law `inner`. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless gains and period are positive and finite.
    // See `RunningCore::new`.
    #[inline(always)]
    pub fn new(inner: L, gains: &FollowingGains, period: T) -> Result<Self, GainError> {
        positive(gains.rate, "following_rad_s")?;
        positive(gains.along, "following_along_rad_s")?;
        positive(gains.size, "following_max_m")?;
        usable_period(period)?;
        let share = Vector2::new(gains.along, gains.rate).map(lit::<T>) * period;
        Ok(Self { inner, share, size: lit(gains.size), correction: Vector2::zeros() })
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for OuterIntegral<T, L> {
    fn reset(&mut self) {
        self.inner.reset();
        self.correction = Vector2::zeros();
    }

    fn freeze(&mut self) {
        self.inner.freeze();
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let mut demand = self.inner.demand(robot, observation)?;
        let error = (demand - observation.encoder_displacement(robot)).linear.xy();
        if !all_finite(error.iter()) {
            return Err(Fault::Compensation);
        }
        self.correction =
            shortened(self.correction + error.component_mul(&self.share), self.size).0;
        demand.linear.x += self.correction.x;
        demand.linear.y += self.correction.y;
        Ok(demand)
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.inner.visit_state(visitor)?;
        visitor.matrix(&mut self.correction)
    }
}
