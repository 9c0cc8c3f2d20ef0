//! `payload-error`: a tool heavier, or balanced elsewhere, than the model has it.
//!
//! Tool mass + m, its centre + (x, y, z) in the last link's frame; its inertia about that centre
//! stays.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use nalgebra::Vector3;

pub(super) static KIND: EffectKind = EffectKind {
    id: "payload-error",
    place: LocationKind::Cell,
    equation: "tool mass + m, its centre + (x, y, z) in the last link's frame",
    shows: "motor torque and sag with the posture of the wrist; inertia torque in motion",
    experiment: "free motion of the wrist, or static poses with the tool in several directions",
    parameters: &[
        Parameter {
            name: "mass_kg",
            role: Role::Size { step: 5.0, neutral: 0.0 },
            unit: "kg",
            meaning: "extra mass m",
            low: -100.0,
            high: 100.0,
        },
        Parameter {
            name: "x_m",
            role: Role::Size { step: 0.01, neutral: 0.0 },
            unit: "m",
            meaning: "centre further along x",
            low: -0.3,
            high: 0.3,
        },
        Parameter {
            name: "y_m",
            role: Role::Size { step: 0.01, neutral: 0.0 },
            unit: "m",
            meaning: "centre further along y",
            low: -0.3,
            high: 0.3,
        },
        Parameter {
            name: "z_m",
            role: Role::Size { step: 0.01, neutral: 0.0 },
            unit: "m",
            meaning: "centre further along z",
            low: -0.3,
            high: 0.3,
        },
    ],
    action: Action::Robot(|robot, _, v| {
        robot.tool.mass += v[0];
        robot.tool.com_from_flange += Vector3::new(v[1], v[2], v[3]);
    }),
};
