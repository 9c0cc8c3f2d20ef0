//! `link-encoder-offset`: a second encoder zeroed wrongly.
//!
//! The second encoder reads o more.

use super::curve::{Curve, CurveAxis, LINK_ENCODER_READS_MORE};
use super::kind::{Action, Calibration, CalibrationScope, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Readings, Term};

pub(super) static LINK_ENCODER_OFFSET_EFFECT: EffectKind = EffectKind {
    id: "link-encoder-offset",
    place: LocationKind::Joint,
    equation: "second encoder reads o more",
    shows: "the second encoder off by a constant; torque and tool as they were",
    experiment: "any motion: encoder against second encoder",
    parameters: &[Parameter::size("offset_rad", "rad", "offset o", 5e-5, [-0.005, 0.005])],
    sentence: "the second encoder of {joint} reads {0} too much",
    curve: Curve::Quantity(&[LINK_ENCODER_READS_MORE], &[CurveAxis::Angle]),
    calibration: Some(Calibration {
        expected: &[1e-4],
        scope: CalibrationScope::EachLog(&[Channel::LinkEncoder]),
    }),
    drawn: Some(|d| (Location::Joint(d.proximal), vec![d.size * d.either(5e-5, 2e-4)])),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::LinkEncoder),
        build: |v, joint| Box::new(LinkEncoderOffset { joint, offset: v[0] }),
    },
    ..EffectKind::DEFAULT
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
