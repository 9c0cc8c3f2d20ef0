//! `damping-error`: a drive damped more or less than the model has it.
//!
//! D → D (1 + e).

use super::kind::{Action, Calibration, CalibrationScope, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;

pub(super) static DAMPING_ERROR_EFFECT: EffectKind = EffectKind {
    id: "damping-error",
    place: LocationKind::Joint,
    equation: "D → D (1 + e)",
    shows: "ringing dies away faster or slower; nothing at rest",
    experiment: "ring-down after an abrupt stop of the joint",
    parameters: &[Parameter::size("relative", "1", "e", 0.2, [-0.9, 3.0])],
    sentence: "the damping of {joint} is {|0|} {0?higher|lower} than in the model",
    calibration: Some(Calibration {
        expected: &[0.3],
        scope: CalibrationScope::AllLogs { motion: true },
    }),
    drawn: Some(|d| (d.here(), vec![d.size * d.either(0.3, 0.6)])),
    action: Action::Robot(|robot, joint, v| robot.joints[joint].damping *= 1.0 + v[0]),
    ..EffectKind::DEFAULT
};
