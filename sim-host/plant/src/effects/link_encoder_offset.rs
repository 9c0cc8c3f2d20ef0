//! `link-encoder-offset`: a second encoder zeroed wrongly.
//!
//! The second encoder reads o more.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Readings, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "link-encoder-offset",
    place: LocationKind::Joint,
    equation: "second encoder reads o more",
    shows: "the second encoder off by a constant; torque and tool as they were",
    experiment: "any motion: encoder against second encoder",
    parameters: &[Parameter {
        name: "offset_rad",
        role: Role::Size { step: 5e-5, neutral: 0.0 },
        unit: "rad",
        meaning: "offset o",
        low: -0.005,
        high: 0.005,
    }],
    action: Action::Term {
        port: |_| Port::SensorChannel,
        build: |v, joint| Box::new(LinkEncoderOffset { joint, offset: v[0] }),
    },
};

#[derive(Debug)]
struct LinkEncoderOffset {
    joint: usize,
    offset: f64,
}

impl Term for LinkEncoderOffset {
    fn sense(&self, readings: &mut Readings) {
        readings.link_encoder[self.joint] += self.offset;
    }
}
