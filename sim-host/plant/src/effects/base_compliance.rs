//! `base-compliance`: a foot that gives.
//!
//! B tilts about its x and y at the foot by c times the moment there, gravity's included.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Term};
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "base-compliance",
    place: LocationKind::Cell,
    equation: "B tilts about its x and y at the foot by c times the moment there",
    shows: "the whole arm leans with load and reach; the same at every joint angle for the same moment",
    experiment: "static loads at far and near reach, in several directions of A1",
    parameters: &[Parameter {
        name: "compliance_rad_nm",
        role: Role::Size { step: 2e-10, neutral: 0.0 },
        unit: "rad/(N·m)",
        meaning: "compliance c",
        low: 0.0,
        high: 2e-08,
    }],
    action: Action::Term {
        port: |_| Port::BaseFrame,
        build: |v, _| Box::new(BaseCompliance { compliance: v[0] }),
    },
};

#[derive(Debug)]
struct BaseCompliance {
    compliance: f64,
}

impl Term for BaseCompliance {
    fn tilt(&self, moment: &Vector3<f64>, _: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(moment.x, moment.y, 0.0) * self.compliance
    }
}
