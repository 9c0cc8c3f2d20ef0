//! `stribeck`: friction that falls with speed.
//!
//! τ_f gains s tanh(θ̇_E/smoothing) exp(−(θ̇_E/vs)²).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static KIND: EffectKind = EffectKind {
    id: "stribeck",
    place: LocationKind::Joint,
    equation: "τ_f gains s tanh(θ̇_E/smoothing) exp(−(θ̇_E/vs)²)",
    shows: "motor torque higher at creep than at speed, both ways; stick-slip",
    experiment: "slow motion at several constant rates, both ways",
    parameters: &[
        Parameter {
            name: "torque_nm",
            role: Role::Size { step: 50.0, neutral: 0.0 },
            unit: "N·m",
            meaning: "extra level s at creep",
            low: -500.0,
            high: 2000.0,
        },
        Parameter {
            name: "rate_rad_s",
            role: Role::Shape(&[0.004, 0.02, 0.1]),
            unit: "rad/s",
            meaning: "rate vs over which it fades",
            low: 0.001,
            high: 0.5,
        },
    ],
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(Stribeck { torque: v[0], rate: v[1] }),
    },
};

#[derive(Debug)]
struct Stribeck {
    torque: f64,
    rate: f64,
}

impl Term for Stribeck {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        let share = at.encoder_rate / self.rate;
        let fade = (-share * share).exp();
        let slope = turn.slope - turn.value * 2.0 * share / self.rate;
        ValueDerivative {
            value: self.torque * turn.value * fade,
            slope: self.torque * fade * slope,
        }
    }
}
