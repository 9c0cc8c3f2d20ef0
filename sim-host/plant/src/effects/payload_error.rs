//! `payload-error`: a tool heavier, or balanced elsewhere, than the model has it.
//!
//! Tool mass + m, its centre + (x, y, z) in the last link's frame; its inertia about that centre
//! stays.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use nalgebra::Vector3;

pub(super) static PAYLOAD_ERROR_EFFECT: EffectKind = EffectKind {
    id: "payload-error",
    place: LocationKind::Cell,
    equation: "tool mass + m, its centre + (x, y, z) in the last link's frame",
    shows: "motor torque and sag with the posture of the wrist; inertia torque in motion",
    experiment: "free motion of the wrist, or static poses with the tool in several directions",
    parameters: &[
        Parameter::size("mass_kg", "kg", "extra mass m", 5.0, [-100.0, 100.0]),
        Parameter::size("x_m", "m", "centre further along x", 0.01, [-0.3, 0.3]),
        Parameter::size("y_m", "m", "centre further along y", 0.01, [-0.3, 0.3]),
        Parameter::size("z_m", "m", "centre further along z", 0.01, [-0.3, 0.3]),
    ],
    sentence: "the tool is {|0|} {0?heavier|lighter} than in the model and its centre of mass lies {1} further along x, {2} along y and {3} along z of the last link",
    curve: Curve::Quantity(
        &[ShownQuantity::parameter(0, "mass that the tool has more")],
        &[CurveAxis::AngleOf(4)],
    ),
    drawn: Some(|d| {
        let centre = [(); 3].map(|()| d.between(-0.02, 0.02));
        let mass = d.size * d.between(5.0, 15.0);
        (Location::Cell, [vec![mass], centre.map(|c| d.size * c).to_vec()].concat())
    }),
    action: Action::Robot(|robot, _, v| {
        robot.tool.mass += v[0];
        robot.tool.com_from_flange += Vector3::new(v[1], v[2], v[3]);
    }),
    adds_to: Some(|robot, _| {
        let centre = robot.tool.com_from_flange;
        vec![robot.tool.mass, centre.x, centre.y, centre.z]
    }),
    ..EffectKind::DEFAULT
};
