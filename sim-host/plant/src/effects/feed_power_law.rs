//! `feed-power-law`: drag that is not in proportion to the feed.
//!
//! F_f = c_x v_x e (|v_x| / 0.010)^(p − 1); the transversal force follows F_f.

use super::kind::{Action, EffectKind, Parameter, Role};
use super::location::LocationKind;
use crate::robot::{Port, ProcessPoint, Term};

pub(super) static KIND: EffectKind = EffectKind {
    id: "feed-power-law",
    place: LocationKind::Cell,
    equation: "F_f = c_x v_x e (|v_x| / 0.010)^(p − 1)",
    shows: "force along the seam not in proportion to the feed",
    experiment: "welds at several feeds",
    parameters: &[Parameter {
        name: "exponent",
        role: Role::Size { step: 0.1, neutral: 1.0 },
        unit: "1",
        meaning: "exponent p",
        low: 0.1,
        high: 2.0,
    }],
    action: Action::Term {
        port: |_| Port::ProcessForce,
        build: |v, _| Box::new(FeedPowerLaw { exponent: v[0] }),
    },
};

/// Feed at which the power law meets the linear one, m/s.
const REFERENCE_FEED: f64 = 0.010;

#[derive(Debug)]
struct FeedPowerLaw {
    exponent: f64,
}

impl Term for FeedPowerLaw {
    fn drag(&self, at: &ProcessPoint) -> f64 {
        let share = at.velocity.x.abs() / REFERENCE_FEED;
        // The force itself goes to zero with the feed for p > 0; its factor need not.
        if share > 0.0 { share.powf(self.exponent - 1.0) } else { 0.0 }
    }
}
