//! `stribeck`: friction that falls with speed.
//!
//! τ_f gains s tanh(θ̇_E/smoothing) exp(−(θ̇_E/vs)²).

use super::curve::{Curve, CurveAxis, MORE_FRICTION};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::{Parameter, Role};
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static STRIBECK_EFFECT: EffectKind = EffectKind {
    id: "stribeck",
    place: LocationKind::Joint,
    equation: "τ_f gains s tanh(θ̇_E/smoothing) exp(−(θ̇_E/vs)²)",
    shows: "motor torque higher at creep than at speed, both ways; stick-slip",
    experiment: "slow motion at several constant rates, both ways",
    parameters: &[
        Parameter::size("torque_nm", "N·m", "extra level s at creep", 50.0, [-500.0, 2000.0]),
        Parameter::new(
            "rate_rad_s",
            "rad/s",
            "rate vs over which it fades",
            Role::Shape(&[0.004, 0.02, 0.1]),
            [0.001, 0.5],
        ),
    ],
    sentence: "{joint} has {|0|} {0?more|less} friction at creep than at speed, fading over {1}",
    curve: Curve::Quantity(&[MORE_FRICTION], &[CurveAxis::Rate]),
    drawn: Some(|d| {
        (d.here(), vec![d.size * d.friction().0 * d.between(0.4, 0.8), d.between(0.015, 0.05)])
    }),
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(Stribeck { torque: v[0], rate: v[1] }),
    },
    ..EffectKind::DEFAULT
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
