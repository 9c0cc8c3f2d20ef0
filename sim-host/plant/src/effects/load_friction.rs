//! `load-friction`: a gear that rubs the more the more it carries.
//!
//! τ_f gains μ |τ_s| tanh(θ̇_E/smoothing), with the robot's own smoothing rate.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static LOAD_FRICTION_EFFECT: EffectKind = EffectKind {
    id: "load-friction",
    place: LocationKind::Joint,
    equation: "τ_f gains μ abs(τ_s) tanh(θ̇_E/smoothing)",
    shows: "motor torque off by a level that changes sign with the joint's rate and grows with the torque that its gear \
            carries",
    experiment: "motion of the joint both ways under small and large load: near and far reach, with and without payload",
    parameters: &[Parameter::size("ratio", "1", "share μ of the spring torque", 0.02, [0.0, 0.5])],
    sentence: "the gear of {joint} rubs with {0} of the torque it carries",
    curve: Curve::Quantity(
        &[ShownQuantity::Factor {
            terms: &[("motor-friction", "abs(spring_torque) * tanh(encoder_rate / smoothing)")],
            name: "friction of {joint} as a share of its spring torque",
        }],
        &[CurveAxis::SpringTorque],
    ),
    // Joints that carry gravity: elsewhere there is hardly a load.
    drawn: Some(|d| {
        (Location::Joint([1, 2, 4][d.whole(0, 2)]), vec![d.size * d.between(0.05, 0.12)])
    }),
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(LoadFriction { ratio: v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct LoadFriction {
    ratio: f64,
}

impl Term for LoadFriction {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        let level = self.ratio * at.spring_torque.abs();
        ValueDerivative { value: level * turn.value, slope: level * turn.slope }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_a_share_of_the_load_against_the_motion() {
        let term = LoadFriction { ratio: 0.08 };
        for (load, rate) in [(3e3, 0.02), (-3e3, 0.02), (5e3, -4e-4), (0.0, 0.1)] {
            let still = JointState {
                encoder: 0.3,
                encoder_rate: 0.0,
                link: 0.299,
                link_rate: 0.0,
                encoder_before: 0.0,
                smoothing: 1e-3,
                spring_torque: load,
                remembered: 0.0,
                time: 0.0,
            };
            let at = |rate: f64| JointState { encoder_rate: rate, link_rate: rate, ..still };
            let friction = term.friction(&at(rate));
            let expected = 0.08 * f64::abs(load) * (rate / 1e-3).tanh();
            assert!((friction.value - expected).abs() < 1e-9, "{friction:?}, {expected}");
            // Differences over 2e-8 rad/s of 400 N·m known to 1e-13 of it.
            let step = 1e-8;
            let slope = (term.friction(&at(rate + step)).value
                - term.friction(&at(rate - step)).value)
                / (2.0 * step);
            assert!((friction.slope - slope).abs() < 1e-2, "{friction:?}, {slope}");
        }
    }
}
