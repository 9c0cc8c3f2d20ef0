//! `torque-ripple`: a motor whose torque pulsates with its angle.
//!
//! Γ acting on the motor = commanded Γ + A sin(n θ_E + φ). What is recorded as motor torque is the
//! commanded one, which lacks what the ripple gives: a term of motor friction, τ_f gains
//! −A sin(n θ_E + φ).

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::{Parameter, Role};
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static TORQUE_RIPPLE_EFFECT: EffectKind = EffectKind {
    id: "torque-ripple",
    place: LocationKind::Joint,
    equation: "Γ acting on the motor = commanded Γ + A sin(n θ_E + φ); what is recorded as motor torque is the commanded one",
    shows: "a wave of the motor torque over the joint's angle, the same at every rate and load; the tool hardly moves with it",
    experiment: "slow motion of the joint alone at a constant rate, motor torque",
    parameters: &[
        Parameter::size("amplitude_nm", "N·m", "amplitude A", 50.0, [0.0, 1000.0]),
        Parameter::order(2000.0),
        Parameter::new("phase_rad", "rad", "phase φ", Role::Phase, [-3.15, 3.15]),
    ],
    sentence: "the motor of {joint} has a torque ripple of amplitude {|0|}, {1#} periods a turn",
    curve: Curve::Quantity(
        &[ShownQuantity::Port {
            port: "motor-friction",
            joint: None,
            sign: -1.0,
            name: "torque of {joint}'s motor beyond the commanded",
        }],
        &[CurveAxis::Angle],
    ),
    drawn: Some(|d| {
        let amplitude = d.size * d.friction().0 * d.between(0.3, 0.8);
        (d.here(), vec![amplitude, d.whole(10, 60) as f64, d.phase()])
    }),
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(TorqueRipple { amplitude: v[0], order: v[1], phase: v[2] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct TorqueRipple {
    amplitude: f64,
    order: f64,
    phase: f64,
}

impl Term for TorqueRipple {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        let wave = (self.order * at.encoder + self.phase).sin();
        ValueDerivative { value: -self.amplitude * wave, slope: 0.0 }
    }
}
