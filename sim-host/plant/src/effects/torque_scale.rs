//! `torque-scale`: a torque constant that is off.
//!
//! Recorded motor torque × (1 + s).

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Readings, Term};

pub(super) static TORQUE_SCALE_EFFECT: EffectKind = EffectKind {
    id: "torque-scale",
    place: LocationKind::Joint,
    equation: "recorded motor torque × (1 + s)",
    shows: "motor torque off in proportion to itself: gravity, friction and inertia alike; the tool stays",
    experiment: "motion of the joint against gravity, with and without a known payload",
    parameters: &[Parameter::size("relative", "1", "s", 0.02, [-0.5, 0.5])],
    sentence: "the recorded torque of {joint} is {|0|} too {0?large|small}",
    curve: Curve::Quantity(
        &[ShownQuantity::Factor {
            terms: &[("recorded-torque", "torque")],
            name: "share by which the torque of {joint} is recorded too large",
        }],
        &[CurveAxis::SpringTorque, CurveAxis::Rate],
    ),
    // A6 carries next to nothing.
    drawn: Some(|d| (Location::Joint(d.whole(0, 4)), vec![d.size * d.either(0.05, 0.15)])),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::MotorTorque),
        build: |v, joint| Box::new(TorqueScale { joint, factor: 1.0 + v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct TorqueScale {
    joint: usize,
    factor: f64,
}

impl Term for TorqueScale {
    fn sense(&self, readings: &mut Readings) {
        readings.motor_torque[self.joint] *= self.factor;
    }
}
