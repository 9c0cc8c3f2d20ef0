//! `counterbalance-loss`: a counterbalance that has lost pressure or a spring.
//!
//! τ_cb × (1 − λ).

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{JointState, Port, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "counterbalance-loss",
    place: LocationKind::Cell,
    equation: "τ_cb × (1 − λ)",
    shows: "A2 carries more, most where the arm leans far: motor torque and deflection of A2 with its angle",
    experiment: "free motion or static poses over the range of A2",
    parameters: &[Parameter {
        name: "loss",
        role: Role::Size { step: 0.05, neutral: 0.0 },
        unit: "1",
        meaning: "share λ lost",
        low: -0.5,
        high: 1.0,
    }],
    action: Action::Term {
        port: |_| Port::LinkTorque(1),
        build: |v, _| Box::new(CounterbalanceLoss { loss: v[0] }),
    },
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
