//! `geometry-error`: a link that is not mounted where the robot file has it.
//!
//! The link behind the joint is mounted off by a small rigid motion, p' = exp(r) p + t in the frame
//! of that link; tool and later joints go with it. The offset of the tool centre is the one of the
//! last joint.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, Calibration, CalibrationScope, Effect, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use nalgebra::Vector3;
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_from_vector;

pub(super) static GEOMETRY_ERROR_EFFECT: EffectKind = EffectKind {
    id: "geometry-error",
    place: LocationKind::Joint,
    equation: "the link behind the joint is mounted off by a small rigid motion, p' = exp(r) p + t in the frame of that link; tool and later joints go with it",
    shows: "tool off by an amount that turns with the joint: a pattern over the postures, whatever the load",
    experiment: "unloaded poses all over the workspace, tracker with rotations",
    parameters: &[
        Parameter::size("x_m", "m", "translation", 1e-4, [-0.02, 0.02]),
        Parameter::size("y_m", "m", "translation", 1e-4, [-0.02, 0.02]),
        Parameter::size("z_m", "m", "translation", 1e-4, [-0.02, 0.02]),
        Parameter::size("rx_rad", "rad", "rotation vector", 1e-4, [-0.02, 0.02]),
        Parameter::size("ry_rad", "rad", "rotation vector", 1e-4, [-0.02, 0.02]),
        Parameter::size("rz_rad", "rad", "rotation vector", 1e-4, [-0.02, 0.02]),
    ],
    sentence: "the link behind {joint} is mounted {norm 0} and {norm 3} off",
    curve: Curve::Quantity(
        &[
            ShownQuantity::port("tracker-x", "tool behind {joint} further along x"),
            ShownQuantity::port("tracker-y", "tool behind {joint} further along y"),
            ShownQuantity::port("tracker-z", "tool behind {joint} further along z"),
        ],
        &[CurveAxis::Angle, CurveAxis::AngleBefore],
    ),
    calibration: Some(Calibration { expected: &[3e-4; 6], scope: CalibrationScope::Postures }),
    drawn: Some(|d| {
        let shift = d.direction() * d.between(3e-4, 8e-4);
        let turn = d.direction() * d.between(3e-4, 8e-4);
        (d.here(), shift.iter().chain(&turn).map(|v| d.size * v).collect())
    }),
    action: Action::Mounting(|v| Pose {
        rotation: rotation_from_vector(&Vector3::new(v[3], v[4], v[5])),
        position: Vector3::new(v[0], v[1], v[2]),
    }),
    ..EffectKind::DEFAULT
};

/// The link behind a joint, from 0, mounted off: translation, m, then rotation vector, rad.
pub fn effect(joint: usize, motion: [f64; 6]) -> Effect {
    Effect { kind: &GEOMETRY_ERROR_EFFECT, at: Location::Joint(joint), values: motion.to_vec() }
}
