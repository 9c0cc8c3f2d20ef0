//! `bearing-tilt`: a bearing that gives across its axis.
//!
//! The link tilts about its frame's origin, about the two axes across the joint's, by c times the
//! moment there, gravity's included.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Term};
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "bearing-tilt",
    place: LocationKind::Joint,
    equation: "the link tilts about the two axes across the joint's, by c times the moment there",
    shows: "tool gives across the joint's axis, in rotation as well as position",
    experiment: "static loads that put a moment across the axis, with the tool's rotation measured",
    parameters: &[Parameter {
        name: "compliance_rad_nm",
        role: Role::Size { step: 2e-9, neutral: 0.0 },
        unit: "rad/(N·m)",
        meaning: "compliance c",
        low: 0.0,
        high: 2e-07,
    }],
    action: Action::Term {
        port: |j| Port::LinkFrame(j),
        build: |v, _| Box::new(BearingTilt { compliance: v[0] }),
    },
};

#[derive(Debug)]
struct BearingTilt {
    compliance: f64,
}

impl Term for BearingTilt {
    fn tilt(&self, moment: &Vector3<f64>, axis: &Vector3<f64>) -> Vector3<f64> {
        (moment - axis * axis.dot(moment)) * self.compliance
    }
}
