//! `counterbalance-loss`: a counterbalance that has lost pressure or a spring.
//!
//! τ_cb × (1 − λ).

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::robot::{JointState, Port, Term};

pub(super) static COUNTERBALANCE_LOSS_EFFECT: EffectKind = EffectKind {
    id: "counterbalance-loss",
    place: LocationKind::Cell,
    equation: "τ_cb × (1 − λ)",
    shows: "A2 carries more, most where the arm leans far: motor torque and deflection of A2 with its angle",
    experiment: "free motion or static poses over the range of A2",
    parameters: &[Parameter::size("loss", "1", "share λ lost", 0.05, [-0.5, 1.0])],
    sentence: "the counterbalance gives {|0|} {0?less|more} torque than in the model",
    curve: Curve::Quantity(
        &[ShownQuantity::Port {
            port: "link-torque",
            joint: Some(1),
            sign: 1.0,
            name: "more torque on the link of {joint}",
        }],
        &[CurveAxis::AngleOf(1)],
    ),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.between(0.1, 0.3)])),
    action: Action::Term {
        port: |_| Port::LinkTorque(1),
        build: |v, _| Box::new(CounterbalanceLoss { loss: v[0] }),
    },
    ..EffectKind::DEFAULT
};

#[derive(Debug)]
struct CounterbalanceLoss {
    loss: f64,
}

impl Term for CounterbalanceLoss {
    fn link_torque(&self, _: &JointState, counterbalance: f64) -> f64 {
        -self.loss * counterbalance
    }
}
