//! `advancing-side`: the push itself driving the tool to one side.
//!
//! F_l gains a F_d sgn(ω), and carries its ripple.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, ProcessPoint, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "advancing-side",
    place: LocationKind::Cell,
    equation: "F_l gains a F_d sgn(ω)",
    shows: "a force across the seam in proportion to the push, turning round with the spindle",
    experiment: "push without feed, spindle one way and the other",
    parameters: &[Parameter {
        name: "ratio",
        role: Role::Size { step: 0.02, neutral: 0.0 },
        unit: "1",
        meaning: "ratio a",
        low: -0.3,
        high: 0.3,
    }],
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(AdvancingSide { ratio: v[0] }),
    },
};

#[derive(Debug)]
struct AdvancingSide {
    ratio: f64,
}

impl Term for AdvancingSide {
    fn lateral_force(&self, at: &ProcessPoint) -> f64 {
        self.ratio * at.depth_force * at.spindle.signum()
    }
}
