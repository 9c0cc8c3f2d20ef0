//! Outer integral: what the position loop lacks of a law's demand, made up for on top of any law.
//!
//! The joint loops' integrators leave no error under a constant load, but one in proportion to its
//! rate under a load that rises: 9 kN·m/s at A2 and K_i = 6·10⁷ N·m/(rad·s) are 0.15 mrad, a third
//! of a millimetre at the tool. The encoders see that, and no law that says where they should be
//! does. With x the demand of the law beneath and E where the encoders stand beyond the set-point,
//! both in W,
//!
//! ```text
//! c ← c + μT (x − E), along and across the seam, |c| bounded        demand = x + c
//! ```
//!
//! Needs: encoders. Sees nothing of: what bends behind them. Not on top of a law that is fed by the
//! force: that is a positive feedback through the material already, and an integral around it makes
//! it swing (0.2 mm with everything exact, where 0.02 are reached without). Tuning: μ below the
//! bandwidths of the correction loops and the position loop together, a fifth of the slower one.

use crate::law::{GainError, positive, usable_period};
use nalgebra::Vector2;
use trueweld_core::compensation::{Compensator, Observation, shortened};
use trueweld_core::scalar::{all_finite, lit};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Gains of the outer integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowingGains {
    /// μ, rad/s. 5: a fifth of correction loops of 4 Hz.
    pub rate: f64,
    /// Largest |c|, m. 0.002.
    pub size: f64,
}

impl Default for FollowingGains {
    fn default() -> Self {
        Self { rate: 5.0, size: 0.002 }
    }
}

/// Outer integral on top of another law.
#[derive(Debug, Clone, Copy)]
pub struct OuterIntegral<T: Real, L> {
    inner: L,
    /// μT.
    share: T,
    size: T,
    /// c, along x and y of W, m.
    made_up: Vector2<T>,
}

impl<T: Real, L> OuterIntegral<T, L> {
    /// On top of the law `inner`. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless gains and period are positive and finite.
    pub fn new(inner: L, gains: &FollowingGains, period: T) -> Result<Self, GainError> {
        positive(gains.rate, "following_rad_s")?;
        positive(gains.size, "following_max_m")?;
        usable_period(period)?;
        let share = lit::<T>(gains.rate) * period;
        Ok(Self { inner, share, size: lit(gains.size), made_up: Vector2::zeros() })
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for OuterIntegral<T, L> {
    fn reset(&mut self) {
        self.inner.reset();
        self.made_up = Vector2::zeros();
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
        let stands = observation.encoder_deviation(robot) - observation.setpoint_deviation();
        let lack = (demand - stands).linear.xy();
        if !all_finite(lack.iter()) {
            return Err(Fault::Compensation);
        }
        self.made_up = shortened(self.made_up + lack * self.share, self.size).0;
        demand.linear.x += self.made_up.x;
        demand.linear.y += self.made_up.y;
        Ok(demand)
    }
}
