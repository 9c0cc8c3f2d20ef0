//! `drive-compliance`: a drive that the robot file states to be rigid, and that bends.
//!
//! K → 1/(1/K + c), and D with it so that c of nothing is the drive as it was, and a spring of its own
//! has 3 % of critical damping, as geared joints have.

use super::curve::{Curve, CurveAxis, TWIST_BEYOND_SPRING};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;
use trueweld_core::JointParameters;

/// Damping over critical of a rigid drive, whose K and D are I ω² and I ω.
const RIGID_DAMPING_RATIO: f64 = 0.5;

/// The same of a spring in its place.
pub const SPRING_DAMPING_RATIO: f64 = 0.03;

/// Damping of a spring in place of a rigid drive, of this stiffness, N·m/rad, and this share of its
/// critical damping, N·m·s/rad: 2 ζ √(K I), I by the numbers of the rigid drive.
pub fn damping(rigid: &JointParameters<f64>, stiffness: f64, ratio: f64) -> f64 {
    ratio / RIGID_DAMPING_RATIO * rigid.damping * (stiffness / rigid.stiffness).sqrt()
}

pub(super) static DRIVE_COMPLIANCE_EFFECT: EffectKind = EffectKind {
    id: "drive-compliance",
    place: LocationKind::Joint,
    equation: "1/K → 1/K + c, of a drive that the robot file states to be \"rigid\"",
    shows: "deflection in proportion to the joint's torque, where the file has none",
    experiment: "static loads both ways, at several postures",
    parameters: &[Parameter::size(
        "compliance_rad_nm",
        "rad/(N·m)",
        "compliance c",
        1e-8,
        [0.0, 1e-2],
    )],
    sentence: "the drive of {joint}, stated to be rigid, bends by {0}",
    curve: Curve::Quantity(&[TWIST_BEYOND_SPRING], &[CurveAxis::SpringTorque]),
    action: Action::Robot(|robot, joint, v| {
        let joint = &mut robot.joints[joint];
        // K over that of the rigid drive.
        let share = 1.0 / (1.0 + joint.stiffness * v[0]);
        let ratio = SPRING_DAMPING_RATIO + (RIGID_DAMPING_RATIO - SPRING_DAMPING_RATIO) * share;
        let stiffness = joint.stiffness * share;
        joint.damping = damping(joint, stiffness, ratio);
        joint.stiffness = stiffness;
    }),
    of_rigid: true,
    ..EffectKind::DEFAULT
};
