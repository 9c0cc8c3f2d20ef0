//! `stiffness-error`: a drive stiffer or softer than the model has it.
//!
//! K → K (1 + e).

use super::curve::{Curve, CurveAxis, TWIST_BEYOND_SPRING};
use super::kind::{Action, Calibration, CalibrationScope, Effect, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;

pub(super) static STIFFNESS_ERROR_EFFECT: EffectKind = EffectKind {
    id: "stiffness-error",
    place: LocationKind::Joint,
    equation: "K → K (1 + e)",
    shows: "deflection off in proportion to the joint's torque",
    experiment: "static loads both ways, at several postures",
    parameters: &[Parameter::size("relative", "1", "e", 0.05, [-0.5, 1.0])],
    sentence: "{joint} is {|0|} {0?stiffer|softer} than in the model",
    curve: Curve::Quantity(&[TWIST_BEYOND_SPRING], &[CurveAxis::SpringTorque]),
    calibration: Some(Calibration {
        expected: &[0.1],
        scope: CalibrationScope::AllLogs { motion: false },
    }),
    drawn: Some(|d| (d.here(), vec![d.size * d.either(0.12, 0.25)])),
    action: Action::Robot(|robot, joint, v| robot.joints[joint].stiffness *= 1.0 + v[0]),
    ..EffectKind::DEFAULT
};

/// A joint, from 0, whose drive is stiffer by this share.
pub fn effect(joint: usize, relative: f64) -> Effect {
    Effect { kind: &STIFFNESS_ERROR_EFFECT, at: Location::Joint(joint), values: vec![relative] }
}
