//! `feed-power-law`: drag that is not in proportion to the feed.
//!
//! F_f = c_x v_x e (|v_x| / 0.010)^(p − 1); the transversal force follows F_f. Of a tool that all but
//! stands the drag is in proportion to its speed: for p < 1 the slope would have no bound.

use super::curve::{Curve, CurveAxis, SEAM_FORCE};
use super::kind::{Action, EffectKind};
use super::location::{Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::process::ProcessPart;
use crate::robot::{Port, ProcessPoint, Term};

pub(super) static FEED_POWER_LAW_EFFECT: EffectKind = EffectKind {
    id: "feed-power-law",
    place: LocationKind::Cell,
    equation: "F_f = c_x v_x e (|v_x| / 0.010)^(p − 1)",
    shows: "force along the seam not in proportion to the feed",
    experiment: "welds at several feeds",
    parameters: &[Parameter::new(
        "exponent",
        "1",
        "exponent p",
        Role::Size { step: 0.1, neutral: 1.0 },
        [0.1, 2.0],
    )],
    sentence: "the drag grows with the feed to the power of {0} and not in proportion",
    curve: Curve::Quantity(&[SEAM_FORCE], &[CurveAxis::Feed]),
    drawn: Some(|d| (Location::Cell, vec![1.0 - d.size * d.between(0.2, 0.5)])),
    acts_on: Some(ProcessPart::Drag),
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(FeedPowerLaw { exponent: v[0] }),
    },
    ..EffectKind::DEFAULT
};

/// Feed at which the power law meets the linear one, m/s.
const REFERENCE_FEED: f64 = 0.010;

/// Feed below which the drag is in proportion to it, m/s.
const STANDING: f64 = 1e-5;

#[derive(Debug)]
struct FeedPowerLaw {
    exponent: f64,
}

impl Term for FeedPowerLaw {
    fn drag(&self, at: &ProcessPoint) -> f64 {
        (at.velocity.x.abs().max(STANDING) / REFERENCE_FEED).powf(self.exponent - 1.0)
    }

    fn drag_exponent(&self, at: &ProcessPoint) -> f64 {
        if at.velocity.x.abs() > STANDING { self.exponent - 1.0 } else { 0.0 }
    }
}
