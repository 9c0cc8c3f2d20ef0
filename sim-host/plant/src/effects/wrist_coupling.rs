//! `wrist-coupling`: a hollow wrist's gears turning with the joint before them.
//!
//! δ of this joint gains ρ θ_E of the joint before it.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "wrist-coupling",
    place: LocationKind::Joint,
    equation: "δ of this joint gains ρ θ_E of the joint before it",
    shows: "the joint turns by a share of the one before it",
    experiment: "motion of the joint before it alone",
    parameters: &[Parameter {
        name: "ratio",
        role: Role::Size { step: 0.001, neutral: 0.0 },
        unit: "1",
        meaning: "ratio ρ",
        low: -0.2,
        high: 0.2,
    }],
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(WristCoupling { ratio: v[0] }),
    },
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
