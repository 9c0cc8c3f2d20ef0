//! `link-encoder-ripple`: a second encoder mounted off centre, or with an uneven scale.
//!
//! The second encoder reads A sin(n θ + φ) more; no torque goes with it.

use super::curve::{Curve, CurveAxis, LINK_ENCODER_READS_MORE};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::robot::{Channel, Port, Readings, Term};

pub(super) static LINK_ENCODER_RIPPLE_EFFECT: EffectKind = EffectKind {
    id: "link-encoder-ripple",
    place: LocationKind::Joint,
    equation: "second encoder reads A sin(n θ + φ) more; no torque goes with it",
    shows: "a wave of the second encoder over the joint's angle, and none of the tool",
    experiment: "slow motion of the joint alone, with a tracker beside the second encoder",
    parameters: &[
        Parameter::size("amplitude_rad", "rad", "amplitude A", 5e-5, [0.0, 0.001]),
        Parameter::order(2000.0),
        Parameter::new("phase_rad", "rad", "phase φ", Role::Phase, [-3.15, 3.15]),
    ],
    sentence: "the second encoder of {joint} has an error of its own of amplitude {|0|}, {1#} periods a turn",
    curve: Curve::Quantity(&[LINK_ENCODER_READS_MORE], &[CurveAxis::Angle]),
    drawn: Some(|d| {
        (
            Location::Joint(d.proximal),
            vec![d.size * d.between(3e-5, 1.5e-4), d.whole(10, 80) as f64, d.phase()],
        )
    }),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::LinkEncoder),
        build: |v, joint| {
            Box::new(LinkEncoderRipple { joint, amplitude: v[0], order: v[1], phase: v[2] })
        },
    },
    ..EffectKind::DEFAULT
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
