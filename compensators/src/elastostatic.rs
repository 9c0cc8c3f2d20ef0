//! Elastostatic compensation from the measured wrench: the fake target of (1.1)–(1.3), exact in the large.
//!
//! The law asks where the encoders would have to be for the real, loaded tool to stand on its nominal pose, and demands
//! the way from the set-point to there. With θ the joint angles of the nominal pose,
//!
//! θ_E = θ + K⁻¹ (g(θ) − τ_cb(θ₂) − J(θ)ᵀ w),  demand = X(θ_E) ⊖ X_set.
//!
//! Since the set-point was taught under gravity, what remains of g − τ_cb is its change since then.
//!
//! Needs: a force sensor in six axes, and K. Sees nothing of: backlash, friction in the gears, bearings, base and
//! links; an error of K passes through one to one, and so does cross-talk of the sensor. Tuning: the wrench filter's
//! corner below the spindle's frequency, and the loops' bandwidth below the force loop's.

use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::filter::{Biquad, Filter, FilterBank};
use trueweld_core::{Fault, Real, Robot, Twist, Wrench};

/// Elastostatic law with a low-pass on the wrench.
#[derive(Debug, Clone, Copy)]
pub struct Elastostatic<T: Real> {
    filter: FilterBank<Biquad<T>, 6>,
    started: bool,
    delay: T,
}

impl<T: Real> Elastostatic<T> {
    /// `corner`: of the second-order low-pass on the wrench, Hz; `period`: of control, s.
    ///
    /// `None` unless 0 < corner < Nyquist.
    pub fn new(corner: T, period: T) -> Option<Self> {
        let filter = Biquad::low_pass(corner, period)?;
        Some(Self { filter: FilterBank::new(filter), started: false, delay: filter.delay() })
    }

    /// How late the filtered wrench is, s.
    pub fn delay(&self) -> T {
        self.delay
    }
}

impl<T: Real> Compensator<T> for Elastostatic<T> {
    fn reset(&mut self) {
        self.started = false;
    }

    fn demand(&mut self, robot: &Robot<T>, observation: &Observation<'_, T>) -> Result<Twist<T>, Fault> {
        let sensed = observation.sensed;
        if !sensed.wrench.is_finite() {
            return Err(Fault::Force);
        }
        let wrench = sensed.wrench.to_vector();
        if !self.started {
            self.filter.settle(&wrench);
            self.started = true;
        }
        let wrench = Wrench::from_vector(&self.filter.update(&wrench));
        if !wrench.is_finite() {
            // A glitch near the end of the number range: the filter would never forget it.
            self.started = false;
            return Err(Fault::Force);
        }
        let link = robot.track(observation.nominal, &sensed.encoder).map_err(|_| Fault::Compensation)?;
        let fake = robot.forward(&robot.fake_target(&link, &wrench));
        let setpoint = observation.setpoint;
        Ok(setpoint.pose.error_to(&fake).rotated(&setpoint.b_from_w.transpose()))
    }
}
