//! `bearing-tilt`: a bearing that gives across its axis.
//!
//! The link tilts about its frame's origin, about the two axes across the joint's, by c times the
//! moment there, gravity's included.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;
use crate::robot::{Port, Term};
use nalgebra::Vector3;

pub(super) static BEARING_TILT_EFFECT: EffectKind = EffectKind {
    id: "bearing-tilt",
    place: LocationKind::Joint,
    equation: "the link tilts about the two axes across the joint's, by c times the moment there",
    shows: "tool gives across the joint's axis, in rotation as well as position",
    experiment: "static loads that put a moment across the axis, with the tool's rotation measured",
    parameters: &[Parameter::size(
        "compliance_rad_nm",
        "rad/(N·m)",
        "compliance c",
        2e-9,
        [0.0, 2e-07],
    )],
    sentence: "the bearing of {joint} tilts by {0} of moment across its axis",
    curve: Curve::Quantity(
        &[ShownQuantity::parameter(0, "compliance of {joint}'s bearing to tilt")],
        &[CurveAxis::Load],
    ),
    drawn: Some(|d| (d.here(), vec![d.size * d.between(5e-9, 2e-8)])),
    action: Action::Term {
        port: |j| Port::LinkFrame(j),
        build: |v, _| Box::new(BearingTilt { compliance: v[0] }),
    },
    ..EffectKind::DEFAULT
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
