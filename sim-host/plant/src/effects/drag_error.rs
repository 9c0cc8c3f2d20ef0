//! `drag-error`: material that resists the feed more or less than the model has it.
//!
//! c_x → c_x (1 + e).

use super::curve::{Curve, CurveAxis, SEAM_FORCE};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::Parameter;
use crate::process::ProcessPart;

/// The number that it changes.
const FEED_DRAG: &str = "feed_drag_ns_m";

pub(super) static DRAG_ERROR_EFFECT: EffectKind = EffectKind {
    id: "drag-error",
    place: LocationKind::Cell,
    equation: "c_x → c_x (1 + e)",
    shows: "force along the seam off in proportion to the feed and the push",
    experiment: "welds at two feeds",
    parameters: &[Parameter::size("relative", "1", "e", 0.05, [-0.8, 3.0])],
    sentence: "the drag along the seam is {|0|} {0?higher|lower} than in the model",
    curve: Curve::Quantity(&[SEAM_FORCE], &[CurveAxis::Feed]),
    drawn: Some(|d| (Location::Cell, vec![d.size * d.either(0.1, 0.25)])),
    acts_on: Some(ProcessPart::Number(FEED_DRAG)),
    action: Action::Process(|process, v| process.scale(FEED_DRAG, 1.0 + v[0])),
    ..EffectKind::DEFAULT
};
