//! `link-encoder-ripple`: a second encoder mounted off centre, or with an uneven scale.
//!
//! The second encoder reads A sin(n θ + φ) more; no torque goes with it.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Readings, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "link-encoder-ripple",
    place: LocationKind::Joint,
    equation: "second encoder reads A sin(n θ + φ) more; no torque goes with it",
    shows: "a wave of the second encoder over the joint's angle, and none of the tool",
    experiment: "slow motion of the joint alone, with a tracker beside the second encoder",
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
            high: 2000.0,
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
        port: |_| Port::SensorChannel,
        build: |v, joint| {
            Box::new(LinkEncoderRipple { joint, amplitude: v[0], order: v[1], phase: v[2] })
        },
    },
};

#[derive(Debug)]
struct LinkEncoderRipple {
    joint: usize,
    amplitude: f64,
    order: f64,
    phase: f64,
}

impl Term for LinkEncoderRipple {
    fn sense(&self, readings: &mut Readings) {
        let angle = &mut readings.link_encoder[self.joint];
        *angle += self.amplitude * (self.order * *angle + self.phase).sin();
    }
}
