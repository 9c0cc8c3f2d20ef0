//! `transmission-error`: a gear whose output does not follow its input evenly.
//!
//! δ = θ_E + A sin(n θ_E + φ) − θ; the changed twist acts on both sides of the gear.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "transmission-error",
    place: LocationKind::Joint,
    equation: "δ = θ_E + A sin(n θ_E + φ) − θ",
    shows: "a wave of the tool over the joint's angle, n to the turn, at any load and speed",
    experiment: "slow motion of the joint alone through some teeth, tracker or second encoder",
    parameters: &[
        Parameter {
            name: "amplitude_rad",
            role: Role::Size { step: 5e-5, neutral: 0.0 },
            unit: "rad",
            meaning: "amplitude A",
            low: 0.0,
            high: 0.001,
        },
        Parameter {
            name: "order",
            role: Role::Order,
            unit: "1/turn",
            meaning: "periods n per turn of the joint",
            low: 0.5,
            high: 500.0,
        },
        Parameter {
            name: "phase_rad",
            role: Role::Phase,
            unit: "rad",
            meaning: "phase φ",
            low: -3.15,
            high: 3.15,
        },
    ],
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(TransmissionError { amplitude: v[0], order: v[1], phase: v[2] }),
    },
};

#[derive(Debug)]
struct TransmissionError {
    amplitude: f64,
    order: f64,
    phase: f64,
}

impl Term for TransmissionError {
    fn torsion(&self, at: &JointState) -> f64 {
        self.amplitude * (self.order * at.encoder + self.phase).sin()
    }
}
