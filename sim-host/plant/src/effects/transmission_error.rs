//! `transmission-error`: a gear whose output does not follow its input evenly.
//!
//! δ = θ_E + A sin(n θ_E + φ) − θ; the changed twist acts on both sides of the gear.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::{Parameter, Role};
use crate::robot::{JointState, Port, Term};

pub(super) static TRANSMISSION_ERROR_EFFECT: EffectKind = EffectKind {
    id: "transmission-error",
    place: LocationKind::Joint,
    equation: "δ = θ_E + A sin(n θ_E + φ) − θ",
    shows: "a wave of the tool over the joint's angle, n to the turn, at any load and speed",
    experiment: "slow motion of the joint alone through some teeth, tracker or second encoder",
    parameters: &[
        Parameter::size("amplitude_rad", "rad", "amplitude A", 5e-5, [0.0, 0.001]),
        Parameter::order(500.0),
        Parameter::new("phase_rad", "rad", "phase φ", Role::Phase, [-3.15, 3.15]),
    ],
    sentence: "the gear of {joint} has a transmission error of amplitude {|0|}, {1#} periods a turn",
    curve: Curve::Quantity(
        &[ShownQuantity::port("twist", "error of {joint}'s gear")],
        &[CurveAxis::Angle],
    ),
    drawn: Some(|d| {
        (d.here(), vec![d.size * d.between(5e-5, 2e-4), d.whole(10, 80) as f64, d.phase()])
    }),
    action: Action::Term {
        port: |j| Port::SpringTorque(j),
        build: |v, _| Box::new(TransmissionError { amplitude: v[0], order: v[1], phase: v[2] }),
    },
    ..EffectKind::DEFAULT
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
