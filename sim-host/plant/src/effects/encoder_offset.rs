//! `encoder-offset`: an encoder zeroed wrongly.
//!
//! Real angle = angle computed from the encoder + o.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "encoder-offset",
    place: LocationKind::Joint,
    equation: "real angle = angle computed from the encoder + o",
    shows: "tool off by a constant rotation about the joint: a pattern over the postures, whatever the load",
    experiment: "unloaded poses all over the workspace, tracker",
    parameters: &[Parameter {
        name: "offset_rad",
        role: Role::Size { step: 5e-5, neutral: 0.0 },
        unit: "rad",
        meaning: "offset o",
        low: -0.005,
        high: 0.005,
    }],
    action: Action::Term {
        port: |j| Port::JointToLinkAngle(j),
        build: |v, _| Box::new(EncoderOffset { offset: v[0] }),
    },
};

#[derive(Debug)]
struct EncoderOffset {
    offset: f64,
}

impl Term for EncoderOffset {
    fn link_angle(&self) -> f64 {
        self.offset
    }
}
