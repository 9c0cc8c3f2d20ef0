//! `backlash`: play in a gear.
//!
//! The elastic part of τ_s acts on dz(δ): δ − b above b, δ + b below −b, 0 between. The damper
//! keeps acting inside the gap.

use super::curve::{Curve, CurveAxis, TWIST_BEYOND_SPRING};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;
use crate::robot::{Port, Term};

pub(super) static BACKLASH_EFFECT: EffectKind = EffectKind {
    id: "backlash",
    place: LocationKind::Joint,
    equation: "elastic part of τ_s = K dz(δ), dz(δ) = δ − b above b, δ + b below −b, 0 between; δ = θ_E − θ",
    shows: "the tool jumps where the joint's torque changes sign; no offset elsewhere but ± b",
    experiment: "static loads that turn the joint's torque round, a little to either side of zero",
    parameters: &[Parameter::size("half_gap_rad", "rad", "half of the play, b", 5e-5, [0.0, 1e-3])],
    sentence: "{joint} has a backlash with a half gap of {0}",
    curve: Curve::Quantity(&[TWIST_BEYOND_SPRING], &[CurveAxis::SpringTorque]),
    drawn: Some(|d| (d.here(), vec![d.size * d.between(1e-4, 3e-4)])),
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(Backlash { half_gap: v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct Backlash {
    half_gap: f64,
}

impl Term for Backlash {
    fn engaged(&self, twist: f64) -> f64 {
        // Soft threshold: zero within the gap, and continuous at its ends.
        twist.signum() * (twist.abs() - self.half_gap).max(0.0)
    }

    fn play(&self) -> f64 {
        self.half_gap
    }
}
