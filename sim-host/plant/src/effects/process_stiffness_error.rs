//! `process-stiffness-error`: material stiffer or softer than the model has it.
//!
//! k_z → k_z (1 + e).

use super::curve::{Curve, CurveAxis, ShownQuantity};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::process::ProcessPart;

/// The number that it changes.
const DEPTH_STIFFNESS: &str = "depth_stiffness_n_m";

pub(super) static PROCESS_STIFFNESS_ERROR_EFFECT: EffectKind = EffectKind {
    id: "process-stiffness-error",
    place: LocationKind::Cell,
    equation: "k_z → k_z (1 + e)",
    shows: "depth off at the same push, or push at the same depth",
    experiment: "push raised and lowered without feed, depth measured",
    parameters: &[Parameter::size("relative", "1", "e", 0.05, [-0.8, 3.0])],
    sentence: "the material resists the push {|0|} {0?more|less} than in the model",
    curve: Curve::Quantity(
        &[ShownQuantity::port("process-force-z", "more process force along z")],
        &[CurveAxis::AxialForce],
    ),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.either(0.15, 0.4)])),
    acts_on: Some(ProcessPart::Number(DEPTH_STIFFNESS)),
    action: Action::Process(|process, v| process.scale(DEPTH_STIFFNESS, 1.0 + v[0])),
    ..EffectKind::DEFAULT
};
