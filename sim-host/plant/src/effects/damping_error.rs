//! `damping-error`: a drive damped more or less than the model has it.
//!
//! D → D (1 + e).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;

pub(super) static KIND: EffectKind = EffectKind {
    id: "damping-error",
    place: LocationKind::Joint,
    equation: "D → D (1 + e)",
    shows: "ringing dies away faster or slower; nothing at rest",
    experiment: "ring-down after an abrupt stop of the joint",
    parameters: &[Parameter {
        name: "relative",
        role: Role::Size { step: 0.2, neutral: 0.0 },
        unit: "1",
        meaning: "e",
        low: -0.9,
        high: 3.0,
    }],
    action: Action::Robot(|robot, joint, v| robot.joints[joint].damping *= 1.0 + v[0]),
};
