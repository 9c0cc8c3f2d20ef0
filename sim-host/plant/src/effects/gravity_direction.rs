//! `gravity-direction`: a robot that does not stand level.
//!
//! Gravity is turned by the rotation vector (rx, ry, 0) about B's axes.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::Location;
use super::parameter::Parameter;
use nalgebra::Vector3;
use trueweld_core::spatial::rotation_from_vector;

pub(super) static GRAVITY_DIRECTION_EFFECT: EffectKind = EffectKind {
    id: "gravity-direction",
    equation: "gravity turned by (rx, ry, 0) about B's axes",
    shows: "torque and sag of A1 as a wave of its angle, larger at far reach; the other joints' gravity a little off",
    experiment: "free motion of A1 over its range at far reach, or unloaded poses all round",
    parameters: &[
        Parameter::size("rx_rad", "rad", "rotation about x", 1e-3, [-0.1, 0.1]),
        Parameter::size("ry_rad", "rad", "rotation about y", 1e-3, [-0.1, 0.1]),
    ],
    sentence: "gravity is turned by {0} about x and {1} about y of the base: the robot does not stand level",
    curve: Curve::Quantity(
        &[ShownQuantity::Port {
            port: "link-torque",
            joint: Some(0),
            sign: 1.0,
            name: "torque on the first joint beyond the model's gravity",
        }],
        &[CurveAxis::AngleOf(0), CurveAxis::Tool(0), CurveAxis::Tool(1)],
    ),
    drawn: Some(|d| (Location::Cell, [(); 2].map(|()| d.size * d.either(5e-3, 0.015)).to_vec())),
    action: Action::Robot(|robot, _, v| {
        robot.gravity = rotation_from_vector(&Vector3::new(v[0], v[1], 0.0)) * robot.gravity;
    }),
    ..EffectKind::DEFAULT
};
