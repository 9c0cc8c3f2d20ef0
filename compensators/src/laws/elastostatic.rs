//! Elastostatic compensation from the measured wrench: the fake target of (1.1)–(1.3), exact in the
//! large.
//!
//! The law computes where the encoders must be for the real, loaded tool to stand on its nominal
//! pose, and demands the displacement of the set-point to there. With θ the joint angles of the
//! nominal pose,
//!
//! θ_E = θ + K⁻¹ (g(θ) − τ_cb(θ₂) − J(θ)ᵀ w),  demand = X(θ_E) ⊖ X_set − its value at w = 0 as taught.
//!
//! The set-point was taught under gravity: of g − τ_cb its change since then is demanded.
//!
//! Needs: a six-axis force sensor, and K. Not observable: backlash, friction in the gears,
//! compliance of bearings, base and links. An error of K passes through one to one, and so does
//! cross-talk of the sensor that is not calibrated: 2 % of 18 kN are a third of the force across.
//! It is a positive feedback: the material answers the correction with force. Tuning: the wrench
//! filter's corner below the spindle's frequency, and the loops' bandwidth below the force loop's.

use crate::gain::{GainError, gains, require};
use crate::law::{Law, Needs, Setup};
use nalgebra::Vector2;
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::filter::{Biquad, Filter, FilterBank};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{Fault, Real, Robot, Twist, Wrench};

gains! {
    /// Gains of the elastostatic law.
    pub struct ElastostaticGains {
        /// Corner of the second-order low-pass on the wrench, Hz. 5: half of a spindle's 600 rpm.
        pub wrench_filter_hz: f64 = 5.0,
        /// What the force sensor gives along x and y of T per axial force, as a calibration under pure
        /// push says. 0 each.
        pub crosstalk: [f64; 2] = [0.0; 2],
    }
}

/// Elastostatic law with a low-pass on the wrench.
#[derive(Debug, Clone, Copy)]
pub struct Elastostatic<T: Real> {
    filter: FilterBank<Biquad<T>, 6>,
    started: bool,
    delay: T,
    crosstalk: Vector2<T>,
}

impl<T: Real> Elastostatic<T> {
    /// A law before its first period. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless 0 < corner < Nyquist and the cross-talk is finite.
    pub fn new(gains: &ElastostaticGains, period: T) -> Result<Self, GainError> {
        let filter = Biquad::low_pass(lit(gains.wrench_filter_hz), period).ok_or(GainError {
            key: "wrench_filter_hz",
            expected: "a number above 0 and below half the control rate",
        })?;
        let [x, y] = gains.crosstalk;
        require(x.is_finite() && y.is_finite(), "crosstalk", "two numbers")?;
        Ok(Self {
            filter: FilterBank::new(filter),
            started: false,
            delay: filter.delay(),
            crosstalk: Vector2::new(lit(x), lit(y)),
        })
    }

    /// How late the filtered wrench is, s.
    pub fn delay(&self) -> T {
        self.delay
    }
}

impl<T: Real> Law<T> for Elastostatic<T> {
    const NAME: &'static str = "elastostatic";
    const SUMMARY: &'static str = "From the measured wrench and the robot's stiffness";
    const NEEDS: Needs = Needs { force_sensor: true, ..Needs::NOTHING };
    const BANDWIDTH_GAINS: &'static [&'static str] = &["wrench_filter_hz"];
    type Gains = ElastostaticGains;
    type Built = Self;

    fn build(gains: &ElastostaticGains, setup: &Setup<T>) -> Result<Self, GainError> {
        Self::new(gains, setup.period)
    }
}

impl<T: Real> Compensator<T> for Elastostatic<T> {
    fn reset(&mut self) {
        self.started = false;
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let sensed = observation.sensed;
        if !sensed.wrench.is_finite() {
            return Err(Fault::Force);
        }
        let mut wrench = sensed.wrench.to_vector();
        let push = wrench[5];
        wrench[3] -= self.crosstalk.x * push;
        wrench[4] -= self.crosstalk.y * push;
        if !self.started {
            self.filter.initialize(&wrench);
            self.started = true;
        }
        let wrench = Wrench::from_vector(&self.filter.update(&wrench));
        if !wrench.is_finite() {
            // A glitch near the end of the number range: the filter would never forget it.
            self.started = false;
            return Err(Fault::Force);
        }
        let link = observation.nominal_angles(robot)?;
        Ok(observation.demand_for(robot, &robot.fake_target(&link, &wrench)))
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.filter.visit_state(visitor)?;
        visitor.flag(&mut self.started)
    }
}
