//! `fixture-compliance`: a plate that is not held rigidly.
//!
//! The surface gives way by F_d/k. With d_n the depth below the undisturbed surface, F (1 +
//! k_z/k) + (b_z/k) Ḟ = k_z d_n + b_z ḋ_n; the term in Ḟ, the surface's own velocity, is left out. The
//! force at rest is exact; a change of it comes earlier by the time b_z/(k + k_z) than it should.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "fixture-compliance",
    place: LocationKind::Cell,
    equation: "the surface gives way by F_d/k",
    shows: "tool deeper at the same push, as with softer material, but in proportion to the push from zero on",
    experiment: "push raised and lowered without feed, plate and tool measured apart",
    parameters: &[Parameter {
        name: "stiffness_n_m",
        role: Role::Reciprocal { step: 1e-9 },
        unit: "N/m",
        meaning: "stiffness k of the fixture",
        low: 5000000.0,
        high: 1000000000.0,
    }],
    action: Action::Term {
        port: |_| Port::PlateSurface,
        build: |v, _| Box::new(FixtureCompliance { compliance: 1.0 / v[0] }),
    },
};

#[derive(Debug)]
struct FixtureCompliance {
    compliance: f64,
}

impl Term for FixtureCompliance {
    fn surface_compliance(&self) -> f64 {
        self.compliance
    }
}
