//! `tracker-registration`: a tracker whose frame is not quite B.
//!
//! p' = exp(r) p + t about B's origin, and the rotation with it.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Readings, Term};
use nalgebra::{Matrix3, Vector3};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};

pub(super) static KIND: EffectKind = EffectKind {
    id: "tracker-registration",
    place: LocationKind::Cell,
    equation: "tracker pose = small rigid motion of the true pose: p' = exp(r) p + t about B's origin",
    shows: "tool off by one rigid motion of the whole workspace, whatever the load",
    experiment: "unloaded poses all over the workspace, tracker",
    parameters: &[
        Parameter {
            name: "x_m",
            role: Role::Size { step: 1e-4, neutral: 0.0 },
            unit: "m",
            meaning: "translation",
            low: -0.01,
            high: 0.01,
        },
        Parameter {
            name: "y_m",
            role: Role::Size { step: 1e-4, neutral: 0.0 },
            unit: "m",
            meaning: "translation",
            low: -0.01,
            high: 0.01,
        },
        Parameter {
            name: "z_m",
            role: Role::Size { step: 1e-4, neutral: 0.0 },
            unit: "m",
            meaning: "translation",
            low: -0.01,
            high: 0.01,
        },
        Parameter {
            name: "rx_rad",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "rad",
            meaning: "rotation vector",
            low: -0.01,
            high: 0.01,
        },
        Parameter {
            name: "ry_rad",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "rad",
            meaning: "rotation vector",
            low: -0.01,
            high: 0.01,
        },
        Parameter {
            name: "rz_rad",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "rad",
            meaning: "rotation vector",
            low: -0.01,
            high: 0.01,
        },
    ],
    action: Action::Term {
        port: |_| Port::SensorChannel,
        build: |v, _| {
            let (translation, rotation) =
                (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5]));
            Box::new(TrackerRegistration { translation, rotation: rotation_from_vector(&rotation) })
        },
    },
};

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
