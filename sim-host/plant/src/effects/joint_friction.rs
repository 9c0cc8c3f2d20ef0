//! `joint-friction`: more friction on the motor side than the model has.
//!
//! τ_f gains c tanh(θ̇_E / smoothing) + v θ̇_E, with the robot's own smoothing rate.

use super::curve::{Curve, CurveAxis, MORE_FRICTION};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::Parameter;
use crate::robot::{JointState, Port, Term, ValueDerivative};

pub(super) static JOINT_FRICTION_EFFECT: EffectKind = EffectKind {
    id: "joint-friction",
    place: LocationKind::Joint,
    equation: "τ_f gains c tanh(θ̇_E/smoothing) + v θ̇_E",
    shows: "motor torque off by a level that changes sign with the joint's rate, and by a share of the rate; the encoder \
            follows, so the tool stays",
    experiment: "motion of the joint at several constant rates, both ways",
    parameters: &[
        Parameter::size("coulomb_nm", "N·m", "Coulomb level c", 50.0, [-500.0, 2000.0]),
        Parameter::size(
            "viscous_nms_rad",
            "N·m·s/rad",
            "viscous coefficient v",
            200.0,
            [-1000.0, 5000.0],
        ),
    ],
    sentence: "{joint} has {|0|} {0?more|less} Coulomb friction and {|1|} {1?more|less} viscous friction than the model",
    curve: Curve::Quantity(&[MORE_FRICTION], &[CurveAxis::Rate]),
    drawn: Some(|d| {
        let (coulomb, viscous) = d.friction();
        (
            d.here(),
            vec![d.size * coulomb * d.between(0.3, 0.6), d.size * viscous * d.between(0.3, 0.6)],
        )
    }),
    action: Action::Term {
        port: |j| Port::MotorFriction(j),
        build: |v, _| Box::new(JointFriction { coulomb: v[0], viscous: v[1] }),
    },
    adds_to: Some(|robot, joint| {
        vec![robot.friction.coulomb[joint], robot.friction.viscous[joint]]
    }),
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct JointFriction {
    coulomb: f64,
    viscous: f64,
}

impl Term for JointFriction {
    fn friction(&self, at: &JointState) -> ValueDerivative {
        let turn = ValueDerivative::turn(at.encoder_rate, at.smoothing);
        ValueDerivative {
            value: self.coulomb * turn.value + self.viscous * at.encoder_rate,
            slope: self.coulomb * turn.slope + self.viscous,
        }
    }
}
