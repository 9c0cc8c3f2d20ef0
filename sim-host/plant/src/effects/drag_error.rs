//! `drag-error`: material that resists the feed more or less than the model has it.
//!
//! c_x → c_x (1 + e).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;

pub(super) static KIND: EffectKind = EffectKind {
    id: "drag-error",
    place: LocationKind::Cell,
    equation: "c_x → c_x (1 + e)",
    shows: "force along the seam off in proportion to the feed and the push",
    experiment: "welds at two feeds",
    parameters: &[Parameter {
        name: "relative",
        role: Role::Size { step: 0.05, neutral: 0.0 },
        unit: "1",
        meaning: "e",
        low: -0.8,
        high: 3.0,
    }],
    action: Action::Process(|process, v| process.feed_drag *= 1.0 + v[0]),
};
