//! `advancing-side`: the push itself driving the tool to one side.
//!
//! F_l gains a F_d sgn(ω), and carries its ripple.

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::process::ProcessPart;
use crate::robot::{Port, ProcessPoint, Term};

pub(super) static ADVANCING_SIDE_EFFECT: EffectKind = EffectKind {
    id: "advancing-side",
    place: LocationKind::Cell,
    equation: "F_l gains a F_d sgn(ω)",
    shows: "a force across the seam in proportion to the push, turning round with the spindle",
    experiment: "push without feed, spindle one way and the other",
    parameters: &[Parameter::size("ratio", "1", "ratio a", 0.02, [-0.3, 0.3])],
    sentence: "a force across the seam of {0} of the push acts besides, in the spindle's sense",
    curve: Curve::Quantity(
        &[ShownQuantity::port("process-force-y", "more process force along y")],
        &[CurveAxis::PushBySpindle],
    ),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.either(0.02, 0.05)])),
    acts_on: Some(ProcessPart::Push),
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(AdvancingSide { ratio: v[0] }),
    },
    ..EffectKind::DEFAULT
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
