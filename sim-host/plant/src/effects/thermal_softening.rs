//! `thermal-softening`: material that softens as it warms up.
//!
//! All process forces × (1 − a (1 − exp(−t/T))).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, ProcessPoint, Term};
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "thermal-softening",
    place: LocationKind::Cell,
    equation: "all process forces × (1 − a (1 − exp(−t/T))), at the same depth and speed",
    shows: "forces fall over the first part of a weld; under force control the tool sinks",
    experiment: "a weld at constant depth, or a long one at constant push",
    parameters: &[
        Parameter {
            name: "share",
            role: Role::Size { step: 0.05, neutral: 0.0 },
            unit: "1",
            meaning: "share a lost in the end",
            low: -0.5,
            high: 0.9,
        },
        Parameter {
            name: "time_s",
            role: Role::Shape(&[3.0, 12.0, 50.0, 200.0]),
            unit: "s",
            meaning: "time constant T",
            low: 0.5,
            high: 600.0,
        },
    ],
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(ThermalSoftening { share: v[0], time: v[1] }),
    },
};

#[derive(Debug)]
struct ThermalSoftening {
    share: f64,
    time: f64,
}

impl Term for ThermalSoftening {
    fn process_force(&self, at: &ProcessPoint, force: Vector3<f64>) -> Vector3<f64> {
        force * (1.0 + self.share * (-at.time / self.time).exp_m1())
    }
}
