//! `thermal-drift`: a robot that grows as it warms up.
//!
//! The real TCP gains v (1 − exp(−t/T)) in B, t from the start.

use super::curve::{Curve, CurveAxis, TOOL_DRIFTS};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::robot::{Port, Term};
use nalgebra::Vector3;

pub(super) static THERMAL_DRIFT_EFFECT: EffectKind = EffectKind {
    id: "thermal-drift",
    place: LocationKind::Cell,
    equation: "TCP gains v (1 − exp(−t/T)) in B, t from the log's start",
    shows: "tool walks off along one line over minutes, whatever the posture and load",
    experiment: "the same unloaded pose again and again while the robot warms up",
    parameters: &[
        Parameter::size("x_m", "m", "final drift", 5e-5, [-0.002, 0.002]),
        Parameter::size("y_m", "m", "final drift", 5e-5, [-0.002, 0.002]),
        Parameter::size("z_m", "m", "final drift", 5e-5, [-0.002, 0.002]),
        Parameter::new(
            "time_s",
            "s",
            "time constant T",
            Role::Shape(&[5.0, 25.0, 120.0, 600.0, 3000.0]),
            [1.0, 7200.0],
        ),
    ],
    sentence: "the tool drifts by {norm 0} in the end ({plain 0} along x, {plain 1} along y, {plain 2} along z of the base) with a time constant of {3}",
    curve: Curve::Quantity(&TOOL_DRIFTS, &[CurveAxis::TimeTo { constant: 3 }]),
    drawn: Some(|d| {
        let drift = d.direction() * (d.size * d.between(1.5e-4, 4e-4));
        (Location::Cell, vec![drift.x, drift.y, drift.z, d.between(10.0, 200.0)])
    }),
    action: Action::Term {
        port: |_| Port::BaseFrame,
        build: |v, _| Box::new(ThermalDrift { drift: Vector3::new(v[0], v[1], v[2]), time: v[3] }),
    },
    ..EffectKind::DEFAULT
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
