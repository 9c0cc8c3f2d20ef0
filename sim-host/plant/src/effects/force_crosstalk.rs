//! `force-crosstalk`: a force sensor whose lateral channels pick up the axial force.
//!
//! Measured lateral forces gain c_x F_z, c_y F_z, in T.

use super::curve::{Curve, CurveAxis, FORCE_SENSOR_READS_MORE};
use super::kind::{Action, Effect, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Readings, Term};

pub(super) static FORCE_CROSSTALK_EFFECT: EffectKind = EffectKind {
    id: "force-crosstalk",
    place: LocationKind::Cell,
    equation: "measured lateral forces gain c_x F_z, c_y F_z",
    shows: "lateral forces measured where there are none, in proportion to the axial one",
    experiment: "axial push without feed",
    parameters: &[
        Parameter::size("fx_per_fz", "1", "c_x", 0.005, [-0.1, 0.1]),
        Parameter::size("fy_per_fz", "1", "c_y", 0.005, [-0.1, 0.1]),
    ],
    sentence: "the force sensor reads {0} of the axial force along x and {1} along y",
    curve: Curve::Quantity(
        &[FORCE_SENSOR_READS_MORE[0], FORCE_SENSOR_READS_MORE[1]],
        &[CurveAxis::AxialForce],
    ),
    drawn: Some(|d| {
        (Location::Cell, vec![d.size * d.either(0.005, 0.015), d.size * d.either(0.005, 0.015)])
    }),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::Wrench),
        build: |v, _| Box::new(ForceCrosstalk { x: v[0], y: v[1] }),
    },
    ..EffectKind::DEFAULT
};

/// A force sensor whose x and y read these shares of the axial force.
pub fn effect(share: [f64; 2]) -> Effect {
    Effect { kind: &FORCE_CROSSTALK_EFFECT, at: Location::Cell, values: share.to_vec() }
}

#[derive(Debug)]
struct ForceCrosstalk {
    x: f64,
    y: f64,
}

impl Term for ForceCrosstalk {
    fn sense(&self, readings: &mut Readings) {
        readings.force.x += self.x * readings.force.z;
        readings.force.y += self.y * readings.force.z;
    }
}
