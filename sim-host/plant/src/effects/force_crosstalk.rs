//! `force-crosstalk`: a force sensor whose lateral channels pick up the axial force.
//!
//! Measured lateral forces gain c_x F_z, c_y F_z, in T.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Readings, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "force-crosstalk",
    place: LocationKind::Cell,
    equation: "measured lateral forces gain c_x F_z, c_y F_z",
    shows: "lateral forces measured where there are none, in proportion to the axial one",
    experiment: "axial push without feed",
    parameters: &[
        Parameter {
            name: "fx_per_fz",
            role: Role::Size { step: 0.005, neutral: 0.0 },
            unit: "1",
            meaning: "c_x",
            low: -0.1,
            high: 0.1,
        },
        Parameter {
            name: "fy_per_fz",
            role: Role::Size { step: 0.005, neutral: 0.0 },
            unit: "1",
            meaning: "c_y",
            low: -0.1,
            high: 0.1,
        },
    ],
    action: Action::Term {
        port: |_| Port::SensorChannel,
        build: |v, _| Box::new(ForceCrosstalk { x: v[0], y: v[1] }),
    },
};

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
