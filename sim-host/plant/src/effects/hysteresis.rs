//! `hysteresis`: friction inside a gear, on the load's side of the encoder.
//!
//! τ_s gains T z, dz/dδ = (1 − z sgn δ̇)/δh, a Dahl loop; z is a state of the plant and starts at
//! 0.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "hysteresis",
    place: LocationKind::Joint,
    equation: "τ_s gains T z, dz/dδ = (1 − z sgn δ̇)/δh",
    shows: "deflection depends on which way the load came: the torque–twist loop has an area",
    experiment: "static loads up and down again, slowly, without overshoot",
    parameters: &[
        Parameter {
            name: "torque_nm",
            role: Role::Size { step: 500.0, neutral: 0.0 },
            unit: "N·m",
            meaning: "half-height T of the loop",
            low: 0.0,
            high: 10000.0,
        },
        Parameter {
            name: "twist_rad",
            role: Role::Shape(&[3e-5, 1.5e-4, 7e-4]),
            unit: "rad",
            meaning: "twist δh over which it turns round",
            low: 1e-06,
            high: 0.01,
        },
    ],
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(Hysteresis { torque: v[0], twist: v[1] }),
    },
};

#[derive(Debug)]
struct Hysteresis {
    torque: f64,
    twist: f64,
}

impl Term for Hysteresis {
    fn spring_torque(&self, _: &JointState, internal: f64) -> f64 {
        self.torque * internal
    }

    /// dz/dt = δ̇ (1 − z sgn δ̇)/δh.
    fn internal_rate(&self, at: &JointState, internal: f64) -> Option<f64> {
        let rate = at.encoder_rate - at.link_rate;
        Some((rate - internal * rate.abs()) / self.twist)
    }
}
