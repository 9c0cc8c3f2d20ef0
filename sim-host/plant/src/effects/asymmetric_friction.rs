//! `asymmetric-friction`: friction that differs between the two directions.
//!
//! τ_f gains a tanh(θ̇_E/smoothing), where θ̇_E > 0 only.

use super::curve::{Curve, CurveAxis, MORE_FRICTION};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static ASYMMETRIC_FRICTION_EFFECT: EffectKind = EffectKind {
    id: "asymmetric-friction",
    place: LocationKind::Joint,
    equation: "τ_f gains a tanh(θ̇_E/smoothing) where θ̇_E > 0",
    shows: "motor torque off in one direction of motion only",
    experiment: "the same motion there and back",
    parameters: &[Parameter::size(
        "torque_nm",
        "N·m",
        "extra level a in positive motion",
        50.0,
        [-1000.0, 2000.0],
    )],
    sentence: "{joint} has {|0|} {0?more|less} friction in positive than in negative motion",
    curve: Curve::Quantity(&[MORE_FRICTION], &[CurveAxis::Rate]),
    drawn: Some(|d| (d.here(), vec![d.size * d.friction().0 * d.between(0.25, 0.5)])),
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(AsymmetricFriction { torque: v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct AsymmetricFriction {
    torque: f64,
}

impl Term for AsymmetricFriction {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        if at.encoder_rate <= 0.0 {
            return ValueDerivative::default();
        }
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        ValueDerivative { value: self.torque * turn.value, slope: self.torque * turn.slope }
    }
}
