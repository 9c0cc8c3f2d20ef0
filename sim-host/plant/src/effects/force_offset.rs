//! `force-offset`: a force sensor zeroed wrongly.
//!
//! The measured force gains a constant, in T.

use super::curve::{Curve, CurveAxis, FORCE_SENSOR_READS_MORE};
use super::kind::{Action, Calibration, CalibrationScope, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Readings, Term};
use nalgebra::Vector3;

pub(super) static FORCE_OFFSET_EFFECT: EffectKind = EffectKind {
    id: "force-offset",
    place: LocationKind::Cell,
    equation: "measured wrench gains a constant",
    shows: "forces measured in the air",
    experiment: "the sensor read without contact",
    parameters: &[
        Parameter::size("fx_n", "N", "offset", 50.0, [-2000.0, 2000.0]),
        Parameter::size("fy_n", "N", "offset", 50.0, [-2000.0, 2000.0]),
        Parameter::size("fz_n", "N", "offset", 50.0, [-2000.0, 2000.0]),
    ],
    sentence: "the force sensor reads {0} too much along x, {1} along y and {2} along z",
    curve: Curve::Quantity(&FORCE_SENSOR_READS_MORE, &[CurveAxis::AxialForce]),
    calibration: Some(Calibration {
        expected: &[30.0; 3],
        scope: CalibrationScope::EachLog(&[Channel::Wrench]),
    }),
    drawn: Some(|d| (Location::Cell, [(); 3].map(|()| d.size * d.either(60.0, 200.0)).to_vec())),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::Wrench),
        build: |v, _| Box::new(ForceOffset { offset: Vector3::new(v[0], v[1], v[2]) }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct ForceOffset {
    offset: Vector3<f64>,
}

impl Term for ForceOffset {
    fn sense(&self, readings: &mut Readings) {
        readings.force += self.offset;
    }
}
