//! `material-step`: another material, or thickness, from some place on.
//!
//! All process forces × (1 + a) beyond path position x0.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, ProcessPoint, Term};
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "material-step",
    place: LocationKind::Cell,
    equation: "all process forces × (1 + a) beyond path position x0",
    shows: "forces jump at one place of the path",
    experiment: "a weld across the place, both ways",
    parameters: &[
        Parameter {
            name: "ratio",
            role: Role::Size { step: 0.05, neutral: 0.0 },
            unit: "1",
            meaning: "step a",
            low: -0.9,
            high: 2.0,
        },
        Parameter {
            name: "position_m",
            role: Role::PathPosition,
            unit: "m",
            meaning: "path position x0",
            low: 0.0,
            high: 10.0,
        },
    ],
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(MaterialStep { ratio: v[0], position: v[1] }),
    },
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
