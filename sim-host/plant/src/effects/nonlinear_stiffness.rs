//! `nonlinear-stiffness`: a gear that stiffens with its twist.
//!
//! τ_s elastic part = K δ (1 + β (1 − exp(−(δ/δc)²))).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "nonlinear-stiffness",
    place: LocationKind::Joint,
    equation: "elastic part of τ_s = K δ (1 + β (1 − exp(−(δ/δc)²)))",
    shows: "soft about zero torque and stiffer above: the torque–twist curve bends",
    experiment: "static loads from a tenth of the rating to all of it, both ways",
    parameters: &[
        Parameter {
            name: "gain",
            role: Role::Size { step: 0.2, neutral: 0.0 },
            unit: "1",
            meaning: "stiffening β far from zero",
            low: -0.5,
            high: 2.0,
        },
        Parameter {
            name: "twist_rad",
            role: Role::Shape(&[1e-4, 4e-4, 1.2e-3, 4e-3]),
            unit: "rad",
            meaning: "twist δc at which it sets in",
            low: 1e-05,
            high: 0.005,
        },
    ],
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(NonlinearStiffness { gain: v[0], twist: v[1] }),
    },
};

#[derive(Debug)]
struct NonlinearStiffness {
    gain: f64,
    twist: f64,
}

impl Term for NonlinearStiffness {
    fn stiffness(&self, engaged: f64) -> f64 {
        let share = engaged / self.twist;
        // −expm1 keeps the digits of 1 − exp(−x) at small twists.
        1.0 - self.gain * (-share * share).exp_m1()
    }
}
