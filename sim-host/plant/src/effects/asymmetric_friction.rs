//! `asymmetric-friction`: friction that differs between the two directions.
//!
//! τ_f gains a tanh(θ̇_E/smoothing), where θ̇_E > 0 only.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static KIND: EffectKind = EffectKind {
    id: "asymmetric-friction",
    place: LocationKind::Joint,
    equation: "τ_f gains a tanh(θ̇_E/smoothing) where θ̇_E > 0",
    shows: "motor torque off in one direction of motion only",
    experiment: "the same motion there and back",
    parameters: &[Parameter {
        name: "torque_nm",
        role: Role::Size { step: 50.0, neutral: 0.0 },
        unit: "N·m",
        meaning: "extra level a in positive motion",
        low: -1000.0,
        high: 2000.0,
    }],
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(AsymmetricFriction { torque: v[0] }),
    },
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
