//! `base-compliance`: a foot that gives.
//!
//! B tilts about its x and y at the foot by c times the moment there, gravity's included.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Port, Term};
use nalgebra::Vector3;

pub(super) static BASE_COMPLIANCE_EFFECT: EffectKind = EffectKind {
    id: "base-compliance",
    place: LocationKind::Cell,
    equation: "B tilts about its x and y at the foot by c times the moment there",
    shows: "the whole arm leans with load and reach; the same at every joint angle for the same moment",
    experiment: "static loads at far and near reach, in several directions of A1",
    parameters: &[Parameter::size(
        "compliance_rad_nm",
        "rad/(N·m)",
        "compliance c",
        2e-10,
        [0.0, 2e-08],
    )],
    sentence: "the base tilts on its foot by {0} of moment",
    curve: Curve::Quantity(
        &[ShownQuantity::parameter(0, "compliance of the base to tilt")],
        &[CurveAxis::Load],
    ),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.between(1e-9, 4e-9)])),
    action: Action::Term {
        port: |_| Port::BaseFrame,
        build: |v, _| Box::new(BaseCompliance { compliance: v[0] }),
    },
    ..EffectKind::DEFAULT
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
