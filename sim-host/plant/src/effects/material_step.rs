//! `material-step`: another material, or thickness, from some place on.
//!
//! All process forces × (1 + a) beyond path position x0.

use super::curve::{ALL_FORCES, Curve, CurveAxis};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::robot::{Port, ProcessPoint, Term};
use nalgebra::Vector3;

pub(super) static MATERIAL_STEP_EFFECT: EffectKind = EffectKind {
    id: "material-step",
    place: LocationKind::Cell,
    equation: "all process forces × (1 + a) beyond path position x0",
    shows: "forces jump at one place of the path",
    experiment: "a weld across the place, both ways",
    parameters: &[
        Parameter::size("ratio", "1", "step a", 0.05, [-0.9, 2.0]),
        Parameter::new("position_m", "m", "path position x0", Role::PathPosition, [0.0, 10.0]),
    ],
    sentence: "the process forces are {|0|} {0?higher|lower} beyond {1} of the path",
    curve: Curve::Quantity(&[ALL_FORCES], &[CurveAxis::Path]),
    drawn: Some(|d| {
        (Location::Cell, vec![d.size * d.either(0.1, 0.25), d.seam * d.between(0.3, 0.7)])
    }),
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(MaterialStep { ratio: v[0], position: v[1] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct MaterialStep {
    ratio: f64,
    position: f64,
}

impl Term for MaterialStep {
    fn process_force(&self, at: &ProcessPoint, force: Vector3<f64>) -> Vector3<f64> {
        if at.position.x > self.position { force * (1.0 + self.ratio) } else { force }
    }
}
