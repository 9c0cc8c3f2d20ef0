//! `encoder-offset`: an encoder zeroed wrongly.
//!
//! Real angle = angle computed from the encoder + o.

use super::curve::{ANGLE_BEYOND_ENCODER, Curve, CurveAxis};
use super::kind::{Action, Calibration, CalibrationScope, Effect, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Term};

pub(super) static ENCODER_OFFSET_EFFECT: EffectKind = EffectKind {
    id: "encoder-offset",
    place: LocationKind::Joint,
    equation: "real angle = angle computed from the encoder + o",
    shows: "tool off by a constant rotation about the joint: a pattern over the postures, whatever the load",
    experiment: "unloaded poses all over the workspace, tracker",
    parameters: &[Parameter::size("offset_rad", "rad", "offset o", 5e-5, [-0.005, 0.005])],
    sentence: "{joint} stands {0} from where its encoder says",
    curve: Curve::Quantity(&[ANGLE_BEYOND_ENCODER], &[CurveAxis::Angle, CurveAxis::SpringTorque]),
    calibration: Some(Calibration {
        expected: &[1e-4],
        scope: CalibrationScope::EachLog(&[Channel::Tracker, Channel::LinkEncoder]),
    }),
    drawn: Some(|d| (d.here(), vec![d.size * d.either(1e-4, 3e-4)])),
    action: Action::Term {
        port: |j| Port::JointToLinkAngle(j),
        build: |v, _| Box::new(EncoderOffset { offset: v[0] }),
    },
    ..EffectKind::DEFAULT
};

/// A joint, from 0, whose encoder was zeroed wrongly by `offset`, rad.
pub fn effect(joint: usize, offset: f64) -> Effect {
    Effect { kind: &ENCODER_OFFSET_EFFECT, at: Location::Joint(joint), values: vec![offset] }
}

#[derive(Debug)]
struct EncoderOffset {
    offset: f64,
}

impl Term for EncoderOffset {
    fn link_angle(&self) -> f64 {
        self.offset
    }
}
