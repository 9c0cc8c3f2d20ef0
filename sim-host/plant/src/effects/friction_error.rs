//! `friction-error`: Coulomb and viscous friction of another size than the model has them.
//!
//! τ_f → c (1 + e_c) tanh(θ̇_E / smoothing) + v (1 + e_v) θ̇_E, with the robot's own c and v.

use super::curve::{Curve, CurveAxis, MORE_FRICTION};
use super::joint_friction::JOINT_FRICTION_EFFECT;
use super::kind::{Action, Calibration, CalibrationScope, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;

pub(super) static FRICTION_ERROR_EFFECT: EffectKind = EffectKind {
    id: "friction-error",
    place: LocationKind::Joint,
    equation: "τ_f → c (1 + e_c) tanh(θ̇_E/smoothing) + v (1 + e_v) θ̇_E, of a joint whose torque is recorded as a current \
               without a factor",
    shows: "motor torque off in proportion to the model's friction",
    experiment: "motion of the joint at several constant rates, both ways, and against gravity",
    parameters: &[
        Parameter::size("coulomb", "1", "e_c", 0.05, [-0.99, 10.0]),
        Parameter::size("viscous", "1", "e_v", 0.05, [-0.99, 10.0]),
    ],
    sentence: "{joint} has {|0|} {0?more|less} Coulomb friction and {|1|} {1?more|less} viscous friction than the model",
    curve: Curve::Quantity(&[MORE_FRICTION], &[CurveAxis::Rate]),
    calibration: Some(Calibration {
        // A rule of thumb gives friction to a factor of two.
        expected: &[0.5, 0.5],
        scope: CalibrationScope::BesideOpenFactor,
    }),
    action: Action::Robot(|robot, joint, v| {
        robot.friction.coulomb[joint] *= 1.0 + v[0];
        robot.friction.viscous[joint] *= 1.0 + v[1];
    }),
    stands_for: Some(&JOINT_FRICTION_EFFECT),
    ..EffectKind::DEFAULT
};
