//! Outer integral: what the position loop lacks of a law's demand, made up for on top of any law.
//!
//! The joint loops' integrators leave no error under a constant load, but one in proportion to its rate under a load that
//! rises: 9 kN·m/s at A2 and K_i = 6·10⁷ N·m/(rad·s) are 0.15 mrad, a third of a millimetre at the tool. The encoders see that,
//! and no law that says where they should be does. With x the demand of the law beneath and E where the encoders stand beyond the
//! set-point, both in W,
//!
//! ```text
//! c ← c + μT (x − E), without depth, |c| bounded        demand = x + c
//! ```
//!
//! Needs: encoders. Sees nothing of: what bends behind them. Not on top of a law that is fed by the force: that is a positive feedback
//! through the material already, and an integral around it makes it swing (0.2 mm with everything exact, where 0.02 are reached
//! without). Tuning: μ below the bandwidths of the correction loops and the position
//! loop together, a third of the slower one.

use nalgebra::{Vector2, Vector3};
use trueweld_core::compensation::{Compensator, Observation, shortened};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Tuning of an outer integral.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Following<T: Real> {
    /// μ, rad/s.
    pub rate: T,
    /// Largest |c|, m.
    pub translation: T,
    /// Largest |c|, rad.
    pub rotation: T,
}

/// Outer integral on top of another law.
#[derive(Debug, Clone, Copy)]
pub struct OuterIntegral<T: Real, L> {
    beneath: L,
    tuning: Following<T>,
    period: T,
    /// c, axes of W: linear without depth.
    linear: Vector2<T>,
    angular: Vector3<T>,
}

impl<T: Real, L> OuterIntegral<T, L> {
    /// On top of the law `beneath`. `period`: of control, s.
    ///
    /// `None` unless all numbers are positive and finite.
    pub fn new(beneath: L, tuning: Following<T>, period: T) -> Option<Self> {
        let usable = [tuning.rate, tuning.translation, tuning.rotation, period];
        usable.iter().all(|v| v.is_finite() && *v > T::zero()).then(|| Self {
            beneath,
            tuning,
            period,
            linear: Vector2::zeros(),
            angular: Vector3::zeros(),
        })
    }
}

impl<T: Real, L: Compensator<T>> Compensator<T> for OuterIntegral<T, L> {
    fn reset(&mut self) {
        self.beneath.reset();
        (self.linear, self.angular) = (Vector2::zeros(), Vector3::zeros());
    }

    fn demand(&mut self, robot: &Robot<T>, observation: &Observation<'_, T>) -> Result<Twist<T>, Fault> {
        let demand = self.beneath.demand(robot, observation)?;
        let stands = observation.encoder_deviation(robot) - observation.setpoint_deviation();
        let lack = demand - stands;
        if !lack.is_finite() {
            return Err(Fault::Compensation);
        }
        let step = self.tuning.rate * self.period;
        self.linear = shortened(self.linear + lack.linear.xy() * step, self.tuning.translation).0;
        self.angular = shortened(self.angular + lack.angular * step, self.tuning.rotation).0;
        let made_up = Twist { angular: self.angular, linear: Vector3::new(self.linear.x, self.linear.y, T::zero()) };
        Ok(demand + made_up)
    }
}
