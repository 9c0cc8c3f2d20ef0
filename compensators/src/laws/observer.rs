//! Compensation from an observer of the flexible joints: motor torque and encoders, no force
//! sensor.
//!
//! The spring torque τ_s follows from the motor side of (2.1), I_m θ̈_E = Γ − τ_s − τ_f(θ̇_E). With
//! the rate's change over one period T and a first-order observer of bandwidth λ,
//!
//! ```text
//! τ̂ ← τ̂ + (1 − e^(−λT)) (Γ − τ_f − I_m Δθ̇_E / T − τ̂)        spring torque
//! θ̂ = θ_E − K⁻¹ τ̂                                            link angle
//! ŵ = J(θ̂)⁻ᵀ (g − τ_cb − τ̂)                                  what the environment applies to the tool, at rest
//! demand = X(θ + K⁻¹ τ̂) ⊖ X_set − its value unloaded, as taught     θ: joint angles of the nominal pose
//! ```
//!
//! In the line of Qin, Léonard, Abba (2013–2016), whose high-gain observer estimates the same from
//! the same signals; the momentum form is De Luca and Mattone's (2003).
//!
//! Needs: motor torque, encoders, K, rotor inertia, motor friction. Not observable: an error of K,
//! which passes through one to one; compliance of bearings, base and links. Friction that the model
//! lacks is taken for load: 100 N·m at A2 for 7 µrad. Like every law fed by the load it is a
//! positive feedback through the material. Tuning: λ above the rate at which the load changes,
//! below the spindle's frequency.

use crate::gain::{GainError, gains, positive, usable_period};
use crate::law::{Law, Needs, Setup};
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::scalar::{all_finite, lit};
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{Fault, Frames, JointVector, Real, Robot, Twist, Wrench};

gains! {
    /// Gains of the observer.
    pub struct ObserverGains {
        /// λ/2π, Hz. 5: half of a spindle's 600 rpm.
        pub bandwidth_hz: f64 = 5.0,
    }
}

/// Observer of spring torques, and the law on top of it.
#[derive(Debug, Clone, Copy)]
pub struct Observer<T: Real> {
    share: T,
    period: T,
    /// Spring torque and motor rate of the last period; `None` before the first one.
    last: Option<(JointVector<T>, JointVector<T>)>,
}

impl<T: Real> Observer<T> {
    /// An observer before its first period, with its law. `period`: of control, s.
    ///
    /// # Errors
    /// [`GainError`] unless bandwidth and period are positive and finite.
    pub fn new(gains: &ObserverGains, period: T) -> Result<Self, GainError> {
        positive(gains.bandwidth_hz, "bandwidth_hz")?;
        usable_period(period)?;
        let bandwidth: T = lit(gains.bandwidth_hz * core::f64::consts::TAU);
        Ok(Self { share: T::one() - (-bandwidth * period).exp(), period, last: None })
    }

    /// Spring torque τ̂, N·m; zero before the first period.
    pub fn spring_torque(&self) -> JointVector<T> {
        self.last.map_or(JointVector::zeros(), |(torque, _)| torque)
    }

    /// Link angles θ̂ under `encoder` angles, rad.
    pub fn link(&self, robot: &Robot<T>, encoder: &JointVector<T>) -> JointVector<T> {
        encoder - self.spring_torque().component_div(robot.stiffness())
    }

    /// What the environment applies to the tool, ŵ, at the TCP in axes of B. `None` where the
    /// Jacobian cannot be inverted.
    pub fn wrench(&self, robot: &Robot<T>, encoder: &JointVector<T>) -> Option<Wrench<T>> {
        let link = self.link(robot, encoder);
        let frames: Frames<T> = robot.frames(&link);
        let load =
            robot.spring_torque_at_rest(&frames, &link, &Wrench::zero()) - self.spring_torque();
        frames.jacobian().wrench_for(&load)
    }
}

impl<T: Real> Law<T> for Observer<T> {
    const NAME: &'static str = "observer";
    const SUMMARY: &'static str = "From motor torque and encoders";
    const NEEDS: Needs = Needs { motor_torque: true, ..Needs::NOTHING };
    const BANDWIDTH_GAINS: &'static [&'static str] = &["bandwidth_hz"];
    type Gains = ObserverGains;
    type Built = Self;

    fn build(gains: &ObserverGains, setup: &Setup<T>) -> Result<Self, GainError> {
        Self::new(gains, setup.period)
    }
}

impl<T: Real> Compensator<T> for Observer<T> {
    fn reset(&mut self) {
        self.last = None;
    }

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let sensed = observation.sensed;
        let rate = sensed.encoder_rate;
        let friction = &robot.parameters().friction;
        let lost = rate.component_mul(&friction.viscous)
            + friction.coulomb.component_mul(&rate.map(|r| (r / friction.smoothing).tanh()));
        let before = self.last.map_or(rate, |(_, before)| before);
        let seen = sensed.motor_torque
            - lost
            - robot.rotor_inertia().component_mul(&(rate - before)) / self.period;
        if !all_finite(seen.iter()) {
            return Err(Fault::Compensation);
        }
        let torque = self.last.map_or(seen, |(torque, _)| torque + (seen - torque) * self.share);
        self.last = Some((torque, rate));
        let link = observation.nominal_angles(robot)?;
        Ok(observation.demand_for(robot, &(link + torque.component_div(robot.stiffness()))))
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let blank = (JointVector::zeros(), JointVector::zeros());
        visitor.option(&mut self.last, blank, |visitor, (torque, rate)| {
            visitor.matrix(torque)?;
            visitor.matrix(rate)
        })
    }
}
