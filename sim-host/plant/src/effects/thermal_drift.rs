//! `thermal-drift`: a robot that grows as it warms up.
//!
//! The real TCP gains v (1 − exp(−t/T)) in B, t from the start.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Term};
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "thermal-drift",
    place: LocationKind::Cell,
    equation: "TCP gains v (1 − exp(−t/T)) in B, t from the log's start",
    shows: "tool walks off along one line over minutes, whatever the posture and load",
    experiment: "the same unloaded pose again and again while the robot warms up",
    parameters: &[
        Parameter {
            name: "x_m",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "m",
            meaning: "final drift",
            low: -0.002,
            high: 0.002,
        },
        Parameter {
            name: "y_m",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "m",
            meaning: "final drift",
            low: -0.002,
            high: 0.002,
        },
        Parameter {
            name: "z_m",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "m",
            meaning: "final drift",
            low: -0.002,
            high: 0.002,
        },
        Parameter {
            name: "time_s",
            role: Role::Shape(&[5.0, 25.0, 120.0, 600.0, 3000.0]),
            unit: "s",
            meaning: "time constant T",
            low: 1.0,
            high: 7200.0,
        },
    ],
    action: Action::Term {
        port: |_| Port::BaseFrame,
        build: |v, _| Box::new(ThermalDrift { drift: Vector3::new(v[0], v[1], v[2]), time: v[3] }),
    },
};

#[derive(Debug)]
struct ThermalDrift {
    drift: Vector3<f64>,
    time: f64,
}

impl Term for ThermalDrift {
    fn shift(&self, time: f64) -> Vector3<f64> {
        self.drift * -(-time / self.time).exp_m1()
    }
}
