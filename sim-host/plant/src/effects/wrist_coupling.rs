//! `wrist-coupling`: a hollow wrist's gears turning with the joint before them.
//!
//! δ of this joint gains ρ θ_E of the joint before it.

use super::curve::{ANGLE_BEYOND_ENCODER, Curve, CurveAxis};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{JointState, Port, Term};

pub(super) static WRIST_COUPLING_EFFECT: EffectKind = EffectKind {
    id: "wrist-coupling",
    place: LocationKind::Joint,
    equation: "δ of this joint gains ρ θ_E of the joint before it",
    shows: "the joint turns by a share of the one before it",
    experiment: "motion of the joint before it alone",
    parameters: &[Parameter::size("ratio", "1", "ratio ρ", 0.001, [-0.2, 0.2])],
    sentence: "{joint} turns along with {before}, by {0} of its angle",
    curve: Curve::Quantity(&[ANGLE_BEYOND_ENCODER], &[CurveAxis::AngleBefore]),
    drawn: Some(|d| (Location::Joint(d.whole(4, 5)), vec![d.size * d.either(5e-4, 2e-3)])),
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(WristCoupling { ratio: v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct WristCoupling {
    ratio: f64,
}

impl Term for WristCoupling {
    fn torsion(&self, at: &JointState) -> f64 {
        self.ratio * at.encoder_before
    }
}
