//! `force-offset`: a force sensor zeroed wrongly.
//!
//! The measured force gains a constant, in T.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Readings, Term};
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "force-offset",
    place: LocationKind::Cell,
    equation: "measured wrench gains a constant",
    shows: "forces measured in the air",
    experiment: "the sensor read without contact",
    parameters: &[
        Parameter {
            name: "fx_n",
            role: Role::Size { step: 50.0, neutral: 0.0 },
            unit: "N",
            meaning: "offset",
            low: -2000.0,
            high: 2000.0,
        },
        Parameter {
            name: "fy_n",
            role: Role::Size { step: 50.0, neutral: 0.0 },
            unit: "N",
            meaning: "offset",
            low: -2000.0,
            high: 2000.0,
        },
        Parameter {
            name: "fz_n",
            role: Role::Size { step: 50.0, neutral: 0.0 },
            unit: "N",
            meaning: "offset",
            low: -2000.0,
            high: 2000.0,
        },
    ],
    action: Action::Term {
        port: |_| Port::SensorChannel,
        build: |v, _| Box::new(ForceOffset { offset: Vector3::new(v[0], v[1], v[2]) }),
    },
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
