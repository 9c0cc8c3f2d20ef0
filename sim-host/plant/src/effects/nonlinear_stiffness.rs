//! `nonlinear-stiffness`: a gear that stiffens with its twist.
//!
//! τ_s elastic part = K δ (1 + β (1 − exp(−(δ/δc)²))).

use super::curve::{Curve, CurveAxis, TWIST_BEYOND_SPRING};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::{Parameter, Role};
use crate::robot::{Port, Term};

pub(super) static NONLINEAR_STIFFNESS_EFFECT: EffectKind = EffectKind {
    id: "nonlinear-stiffness",
    place: LocationKind::Joint,
    equation: "elastic part of τ_s = K δ (1 + β (1 − exp(−(δ/δc)²)))",
    shows: "soft about zero torque and stiffer above: the torque–twist curve bends",
    experiment: "static loads from a tenth of the rating to all of it, both ways",
    parameters: &[
        Parameter::size("gain", "1", "stiffening β far from zero", 0.2, [-0.5, 2.0]),
        Parameter::new(
            "twist_rad",
            "rad",
            "twist δc at which it sets in",
            Role::Shape(&[1e-4, 4e-4, 1.2e-3, 4e-3]),
            [1e-05, 0.005],
        ),
    ],
    sentence: "the spring of {joint} becomes {|0|} {0?stiffer|softer} under load than about zero torque, from a twist of {1} on",
    curve: Curve::Quantity(&[TWIST_BEYOND_SPRING], &[CurveAxis::SpringTorque]),
    drawn: Some(|d| {
        let twist = if d.joint < 3 { d.between(2e-4, 6e-4) } else { d.between(5e-4, 1.2e-3) };
        (d.here(), vec![d.size * d.between(0.3, 0.6), twist])
    }),
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(NonlinearStiffness { gain: v[0], twist: v[1] }),
    },
    ..EffectKind::DEFAULT
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
