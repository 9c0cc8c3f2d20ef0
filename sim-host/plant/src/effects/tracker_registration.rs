//! `tracker-registration`: a tracker whose frame is not quite B.
//!
//! p' = exp(r) p + t about B's origin, and the rotation with it.

use super::curve::{Curve, CurveAxis, TRACKER_READS_MORE};
use super::kind::{Action, Calibration, CalibrationScope, Effect, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Readings, Term};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};

pub(super) static TRACKER_REGISTRATION_EFFECT: EffectKind = EffectKind {
    id: "tracker-registration",
    place: LocationKind::Cell,
    equation: "tracker pose = small rigid motion of the true pose: p' = exp(r) p + t about B's origin",
    shows: "tool off by one rigid motion of the whole workspace, whatever the load",
    experiment: "unloaded poses all over the workspace, tracker",
    parameters: &[
        Parameter::size("x_m", "m", "translation", 1e-4, [-0.01, 0.01]),
        Parameter::size("y_m", "m", "translation", 1e-4, [-0.01, 0.01]),
        Parameter::size("z_m", "m", "translation", 1e-4, [-0.01, 0.01]),
        Parameter::size("rx_rad", "rad", "rotation vector", 5e-5, [-0.01, 0.01]),
        Parameter::size("ry_rad", "rad", "rotation vector", 5e-5, [-0.01, 0.01]),
        Parameter::size("rz_rad", "rad", "rotation vector", 5e-5, [-0.01, 0.01]),
    ],
    sentence: "the tracker's frame is off by {norm 0} and {norm 3}",
    curve: Curve::Quantity(
        &TRACKER_READS_MORE,
        &[CurveAxis::Tool(0), CurveAxis::Tool(1), CurveAxis::Tool(2)],
    ),
    calibration: Some(Calibration {
        expected: &[1e-4, 1e-4, 1e-4, 5e-5, 5e-5, 5e-5],
        scope: CalibrationScope::EachLog(&[Channel::Tracker]),
    }),
    drawn: Some(|d| {
        let shift = d.direction() * d.between(2e-4, 6e-4);
        let turn = d.direction() * d.between(1e-4, 2e-4);
        (Location::Cell, shift.iter().chain(&turn).map(|v| d.size * v).collect())
    }),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::Tracker),
        build: |v, _| {
            let (translation, rotation) =
                (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5]));
            Box::new(TrackerRegistration { translation, rotation: rotation_from_vector(&rotation) })
        },
    },
    ..EffectKind::DEFAULT
};

/// A tracker registered wrongly: translation, m, then rotation vector, rad.
pub fn effect(motion: [f64; 6]) -> Effect {
    Effect { kind: &TRACKER_REGISTRATION_EFFECT, at: Location::Cell, values: motion.to_vec() }
}

#[derive(Debug)]
struct TrackerRegistration {
    translation: Vector3<f64>,
    rotation: Matrix3<f64>,
}

impl Term for TrackerRegistration {
    fn sense(&self, readings: &mut Readings) {
        readings.tcp_position = self.rotation * readings.tcp_position + self.translation;
        readings.tcp_rotation =
            rotation_vector(&(self.rotation * rotation_from_vector(&readings.tcp_rotation)));
    }
}
