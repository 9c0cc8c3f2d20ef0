//! `joint-friction`: more friction on the motor side than the model has.
//!
//! τ_f gains c tanh(θ̇_E / smoothing) + v θ̇_E, with the robot's own smoothing rate.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static KIND: EffectKind = EffectKind {
    id: "joint-friction",
    place: LocationKind::Joint,
    equation: "τ_f gains c tanh(θ̇_E/smoothing) + v θ̇_E",
    shows: "motor torque off by a level that changes sign with the joint's rate, and by a share of the rate; the encoder \
            follows, so the tool stays",
    experiment: "motion of the joint at several constant rates, both ways",
    parameters: &[
        Parameter {
            name: "coulomb_nm",
            role: Role::Size { step: 50.0, neutral: 0.0 },
            unit: "N·m",
            meaning: "Coulomb level c",
            low: -500.0,
            high: 2000.0,
        },
        Parameter {
            name: "viscous_nms_rad",
            role: Role::Size { step: 200.0, neutral: 0.0 },
            unit: "N·m·s/rad",
            meaning: "viscous coefficient v",
            low: -1000.0,
            high: 5000.0,
        },
    ],
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(JointFriction { coulomb: v[0], viscous: v[1] }),
    },
};

#[derive(Debug)]
struct JointFriction {
    coulomb: f64,
    viscous: f64,
}

impl Term for JointFriction {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        ValueDerivative {
            value: self.coulomb * turn.value + self.viscous * at.encoder_rate,
            slope: self.coulomb * turn.slope + self.viscous,
        }
    }
}
