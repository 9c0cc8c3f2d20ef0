//! `thermal-softening`: material that softens as it warms up.
//!
//! All process forces × (1 − a (1 − exp(−t/T))).

use super::curve::{ALL_FORCES, Curve, CurveAxis};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::robot::{Port, ProcessPoint, Term};
use nalgebra::Vector3;

pub(super) static THERMAL_SOFTENING_EFFECT: EffectKind = EffectKind {
    id: "thermal-softening",
    place: LocationKind::Cell,
    equation: "all process forces × (1 − a (1 − exp(−t/T))), at the same depth and speed",
    shows: "forces fall over the first part of a weld; under force control the tool sinks",
    experiment: "a weld at constant depth, or a long one at constant push",
    parameters: &[
        Parameter::size("share", "1", "share a lost in the end", 0.05, [-0.5, 0.9]),
        Parameter::new(
            "time_s",
            "s",
            "time constant T",
            Role::Shape(&[3.0, 12.0, 50.0, 200.0]),
            [0.5, 600.0],
        ),
    ],
    sentence: "the process forces {0?fall|rise} by {|0|} as the weld goes on, with a time constant of {1}",
    curve: Curve::Quantity(&[ALL_FORCES], &[CurveAxis::TimeTo { constant: 1 }]),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.between(0.05, 0.15), d.between(10.0, 40.0)])),
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(ThermalSoftening { share: v[0], time: v[1] }),
    },
    ..EffectKind::DEFAULT
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
