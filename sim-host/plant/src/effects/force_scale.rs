//! `force-scale`: a force sensor with a wrong gain.
//!
//! Recorded wrench × (1 + s), in T.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::Location;
use super::parameter::Parameter;
use crate::robot::{Channel, Port, Readings, Term};

pub(super) static FORCE_SCALE_EFFECT: EffectKind = EffectKind {
    id: "force-scale",
    equation: "recorded wrench × (1 + s)",
    shows: "deflections and process forces off in proportion to the measured force; what hangs on the flange bends the arm as it should",
    experiment: "a known weight hung on the tool, read by the force sensor",
    parameters: &[Parameter::size("relative", "1", "s", 0.02, [-0.3, 0.3])],
    sentence: "the force sensor reads {|0|} too {0?much|little}",
    curve: Curve::Quantity(
        &[ShownQuantity::Factor {
            terms: &[("force-sensor-x", "fx"), ("force-sensor-y", "fy"), ("force-sensor-z", "fz")],
            name: "share by which the force sensor reads too much",
        }],
        &[CurveAxis::AxialForce, CurveAxis::Load],
    ),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.either(0.03, 0.1)])),
    action: Action::Term {
        port: |_| Port::SensorChannel(Channel::Wrench),
        build: |v, _| Box::new(ForceScale { factor: 1.0 + v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct ForceScale {
    factor: f64,
}

impl Term for ForceScale {
    fn sense(&self, readings: &mut Readings) {
        readings.force *= self.factor;
        readings.moment *= self.factor;
    }
}
