//! `hysteresis`: friction inside a gear, on the load's side of the encoder.
//!
//! τ_s gains T z, dz/dδ = (1 − z sgn δ̇)/δh, a Dahl loop; z is a state of the plant and starts at
//! 0.

use super::curve::{Curve, CurveAxis, TWIST_BEYOND_SPRING};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::memory::Loop;
use super::parameter::{Parameter, Role};
use crate::robot::{JointState, Port, Term};

pub(super) static HYSTERESIS_EFFECT: EffectKind = EffectKind {
    id: "hysteresis",
    place: LocationKind::Joint,
    equation: "τ_s gains T z, dz/dδ = (1 − z sgn δ̇)/δh",
    shows: "deflection depends on which way the load came: the torque–twist loop has an area",
    experiment: "static loads up and down again, slowly, without overshoot",
    parameters: &[
        Parameter::size("torque_nm", "N·m", "half-height T of the loop", 500.0, [0.0, 10000.0]),
        Parameter::new(
            "twist_rad",
            "rad",
            "twist δh over which it turns round",
            Role::Shape(&[3e-5, 1.5e-4, 7e-4]),
            [1e-06, 0.01],
        ),
    ],
    sentence: "the gear of {joint} has friction under load: a torque–twist loop with a half height of {0} that turns round over {1}",
    curve: Curve::Loop(&[TWIST_BEYOND_SPRING], &[CurveAxis::SpringTorque]),
    drawn: Some(|d| {
        let twist = if d.joint < 3 { d.between(7e-5, 1.5e-4) } else { d.between(1e-4, 3e-4) };
        (d.here(), vec![d.size * d.strength() * d.between(1000.0, 2500.0), twist])
    }),
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(Hysteresis { torque: v[0], twist: v[1] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct Hysteresis {
    torque: f64,
    twist: f64,
}

/// The rate of the twist δ.
fn twist_of(at: &JointState) -> f64 {
    at.encoder_rate - at.link_rate
}

impl Term for Hysteresis {
    fn spring_torque(&self, at: &JointState) -> f64 {
        self.torque * at.remembered
    }

    fn internal_rate(&self, at: &JointState) -> Option<f64> {
        Some(Loop::Dahl.rate(twist_of(at), self.twist, at.remembered))
    }

    fn remembered_after(&self, way: &JointState) -> f64 {
        Loop::Dahl.after(twist_of(way), self.twist, way.remembered)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_loop_that_a_step_goes_round_many_times_stays_within_itself() {
        let narrow = Hysteresis { torque: 1e3, twist: 1e-6 };
        let (mut z, step): (f64, f64) = (0.3, 1e-3);
        for k in 0..1000 {
            let rate = |remembered: f64| {
                let encoder_rate = 0.5 * f64::from(k).sin();
                let at = JointState { encoder_rate, remembered, ..JointState::at_zero() };
                narrow.internal_rate(&at).unwrap()
            };
            // Runge and Kutta's fourth order.
            let a = rate(z);
            let b = rate(z + 0.5 * step * a);
            let c = rate(z + 0.5 * step * b);
            let d = rate(z + step * c);
            z += step * (a + 2.0 * b + 2.0 * c + d) / 6.0;
            assert!(z.abs() <= 1.0 + 1e-9, "{z} at step {k}");
        }
    }
}
