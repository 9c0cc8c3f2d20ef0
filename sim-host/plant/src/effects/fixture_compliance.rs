//! `fixture-compliance`: a plate that is not held rigidly.
//!
//! The surface gives way by F_d/k. Its own velocity is left out of the contact's damping.

use super::{Action, Kind, Parameter, Place, Role};
use crate::robot::{Port, Term};

pub(super) static KIND: Kind = Kind {
    id: "fixture-compliance",
    place: Place::Cell,
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
