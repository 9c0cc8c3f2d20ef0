//! `rotor-inertia-error`: motor and gear of another inertia than the model has them.
//!
//! I_m → I_m (1 + e).

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, Calibration, CalibrationScope, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;

pub(super) static ROTOR_INERTIA_ERROR_EFFECT: EffectKind = EffectKind {
    id: "rotor-inertia-error",
    place: LocationKind::Joint,
    equation: "I_m → I_m (1 + e), of a robot file whose rotor inertia is \"unknown\"",
    shows: "motor torque off in proportion to the joint's acceleration",
    experiment: "motion of the joint with hard acceleration",
    parameters: &[Parameter::size("relative", "1", "e", 0.05, [-0.99, 50.0])],
    sentence: "motor and gear of {joint} have {|0|} {0?more|less} inertia than in the model",
    curve: Curve::Quantity(
        &[ShownQuantity::Port {
            port: "motor-friction",
            joint: None,
            sign: 1.0,
            name: "more torque at the motor of {joint}",
        }],
        &[CurveAxis::Rate],
    ),
    calibration: Some(Calibration {
        // Matched inertias are what gears are chosen for; drives are off that by their size again.
        expected: &[1.0],
        scope: CalibrationScope::UnknownRotor,
    }),
    action: Action::Robot(|robot, joint, v| robot.joints[joint].rotor_inertia *= 1.0 + v[0]),
    ..EffectKind::DEFAULT
};
