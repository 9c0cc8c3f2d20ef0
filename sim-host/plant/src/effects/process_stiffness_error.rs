//! `process-stiffness-error`: material stiffer or softer than the model has it.
//!
//! k_z → k_z (1 + e).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;

pub(super) static KIND: EffectKind = EffectKind {
    id: "process-stiffness-error",
    place: LocationKind::Cell,
    equation: "k_z → k_z (1 + e)",
    shows: "depth off at the same push, or push at the same depth",
    experiment: "push raised and lowered without feed, depth measured",
    parameters: &[Parameter {
        name: "relative",
        role: Role::Size { step: 0.05, neutral: 0.0 },
        unit: "1",
        meaning: "e",
        low: -0.8,
        high: 3.0,
    }],
    action: Action::Process(|process, v| process.depth_stiffness *= 1.0 + v[0]),
};
