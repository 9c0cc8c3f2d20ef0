//! `stiffness-error`: a drive stiffer or softer than the model has it.
//!
//! K → K (1 + e).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;

pub(super) static KIND: EffectKind = EffectKind {
    id: "stiffness-error",
    place: LocationKind::Joint,
    equation: "K → K (1 + e)",
    shows: "deflection off in proportion to the joint's torque",
    experiment: "static loads both ways, at several postures",
    parameters: &[Parameter {
        name: "relative",
        role: Role::Size { step: 0.05, neutral: 0.0 },
        unit: "1",
        meaning: "e",
        low: -0.5,
        high: 1.0,
    }],
    action: Action::Robot(|robot, joint, v| robot.joints[joint].stiffness *= 1.0 + v[0]),
};
