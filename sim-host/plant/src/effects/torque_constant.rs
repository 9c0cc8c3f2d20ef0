//! `torque-constant`: what one unit of a recorded motor current is in torque.
//!
//! Motor torque = recorded × k × (1 + s), seen from the joint. Of columns whose factor no file states,
//! k is found from the logs before anything is fitted; s is what it is off by.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, Calibration, CalibrationScope, EffectKind};
use super::location::LocationKind;
use super::parameter::{Parameter, Role};
use crate::robot::{Channel, Port, Readings, Term};

pub(super) static TORQUE_CONSTANT_EFFECT: EffectKind = EffectKind {
    id: "torque-constant",
    place: LocationKind::Joint,
    equation: "motor torque = recorded current × k × (1 + s)",
    shows: "motor torque of a current without a stated factor off in proportion to itself",
    experiment: "motion of the joint against gravity, with and without a known payload",
    parameters: &[
        Parameter::new(
            "nm_per_unit",
            "N·m",
            "k, of one unit of the column",
            Role::Shape(&[1.0]),
            [-1e6, 1e6],
        ),
        Parameter::size("relative", "1", "s", 0.02, [-0.8, 4.0]),
    ],
    sentence: "a unit of the motor current of {joint} is {|1|} {1?more|less} than {plain 0}",
    curve: Curve::Quantity(
        &[ShownQuantity::Factor {
            terms: &[("recorded-torque", "torque")],
            name: "share by which the torque of {joint} is recorded too large",
        }],
        &[CurveAxis::SpringTorque, CurveAxis::Rate],
    ),
    calibration: Some(Calibration {
        // k was found with the model's masses and friction, of which friction is rarely known to a third.
        expected: &[0.0, 0.3],
        scope: CalibrationScope::OpenFactor,
    }),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::MotorTorque),
        build: |v, joint| Box::new(TorqueConstant { joint, factor: 1.0 / (1.0 + v[1]) }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct TorqueConstant {
    joint: usize,
    factor: f64,
}

impl Term for TorqueConstant {
    fn sense(&self, readings: &mut Readings) {
        readings.motor_torque[self.joint] *= self.factor;
    }
}
