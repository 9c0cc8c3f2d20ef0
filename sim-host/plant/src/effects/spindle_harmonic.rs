//! `spindle-harmonic`: one more order of the spindle's ripple.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::input::Ripple;

pub(super) static KIND: EffectKind = EffectKind {
    id: "spindle-harmonic",
    place: LocationKind::Cell,
    equation: "one more ripple order: each force × (1 + … + amplitude sin(order φ + phase))",
    shows: "a line of force and motion at a multiple of the spindle's speed",
    experiment: "a weld at constant push: spectrum over the spindle's angle",
    parameters: &[
        Parameter {
            name: "order",
            role: Role::SpindleOrder,
            unit: "1/turn",
            meaning: "periods per spindle turn",
            low: 0.1,
            high: 20.0,
        },
        Parameter {
            name: "axial",
            role: Role::Size { step: 0.01, neutral: 0.0 },
            unit: "1",
            meaning: "amplitude of the depth force",
            low: 0.0,
            high: 0.3,
        },
        Parameter {
            name: "in_plane",
            role: Role::Size { step: 0.01, neutral: 0.0 },
            unit: "1",
            meaning: "amplitude of the forces in the plane",
            low: 0.0,
            high: 0.5,
        },
        Parameter {
            name: "phase_rad",
            role: Role::Phase,
            unit: "rad",
            meaning: "phase",
            low: -3.15,
            high: 3.15,
        },
    ],
    action: Action::Process(|process, v| {
        process.ripple.push(Ripple { order: v[0], axial: v[1], in_plane: v[2], phase: v[3] });
    }),
};
