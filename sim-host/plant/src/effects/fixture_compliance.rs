//! `fixture-compliance`: a plate that is not held rigidly.
//!
//! The surface gives way by F_d/k. With d_n the depth below the undisturbed surface, F (1 +
//! k_z/k) + (b_z/k) Ḟ = k_z d_n + b_z ḋ_n; the term in Ḟ, the surface's own velocity, is left out. The
//! force at rest is exact; a change of it comes earlier by the time b_z/(k + k_z) than it should.

use super::curve::{Curve, CurveAxis, SURFACE_HEIGHT};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::robot::{Port, Term};

pub(super) static FIXTURE_COMPLIANCE_EFFECT: EffectKind = EffectKind {
    id: "fixture-compliance",
    place: LocationKind::Cell,
    equation: "the surface gives way by F_d/k",
    shows: "tool deeper at the same push, as with softer material, but in proportion to the push from zero on",
    experiment: "push raised and lowered without feed, plate and tool measured apart",
    parameters: &[Parameter::new(
        "stiffness_n_m",
        "N/m",
        "stiffness k of the fixture",
        Role::Reciprocal { step: 1e-9 },
        [5000000.0, 1000000000.0],
    )],
    sentence: "the fixture gives way under the push, with a stiffness of {0}",
    curve: Curve::Quantity(&[SURFACE_HEIGHT], &[CurveAxis::AxialForce]),
    drawn: Some(|d| (Location::Cell, vec![d.between(3e7, 1e8) / d.size])),
    action: Action::Term {
        port: |_| Port::PlateSurface,
        build: |v, _| Box::new(FixtureCompliance { compliance: 1.0 / v[0] }),
    },
    ..EffectKind::DEFAULT
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
