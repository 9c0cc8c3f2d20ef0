//! `spindle-harmonic`: one more order of the spindle's ripple.

use super::curve::Curve;
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::input::Ripple;

pub(super) static SPINDLE_HARMONIC_EFFECT: EffectKind = EffectKind {
    id: "spindle-harmonic",
    place: LocationKind::Cell,
    equation: "one more ripple order: each force × (1 + … + amplitude sin(order φ + phase))",
    shows: "a line of force and motion at a multiple of the spindle's speed",
    experiment: "a weld at constant push: spectrum over the spindle's angle",
    parameters: &[
        Parameter::new(
            "order",
            "1/turn",
            "periods per spindle turn",
            Role::SpindleOrder,
            [0.1, 20.0],
        ),
        Parameter::size("axial", "1", "amplitude of the depth force", 0.01, [0.0, 0.3]),
        Parameter::size("in_plane", "1", "amplitude of the forces in the plane", 0.01, [0.0, 0.5]),
        Parameter::new("phase_rad", "rad", "phase", Role::Phase, [-3.15, 3.15]),
    ],
    sentence: "the force has one more ripple at {0#} times the spindle's speed, {|1|} of the push and {|2|} in the plane",
    curve: Curve::SpindleOrders,
    drawn: Some(|d| {
        let order = d.whole(3, 6) as f64;
        let amplitudes = (d.size * d.between(0.01, 0.03), d.size * d.between(0.03, 0.08));
        (Location::Cell, vec![order, amplitudes.0, amplitudes.1, d.phase()])
    }),
    action: Action::Process(|process, v| {
        process.ripple.push(Ripple { order: v[0], axial: v[1], in_plane: v[2], phase: v[3] });
    }),
    ..EffectKind::DEFAULT
};
