//! What gains are held against: margins of the loop, the response to a step of the push, and what is
//! closest to its limit.

use super::AskedResponse;
use crate::figure::{Figure, Limit};
use crate::margins::{MARGIN_FIGURES, Margins, SETPOINT};
use crate::step::StepFigures;

/// What may limit a loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LoopCriterion {
    /// A margin, of a channel, at a place.
    Margin {
        /// Which margin.
        figure: &'static Figure,
        /// Of which channel.
        channel: &'static str,
        /// Path position, m.
        path: f64,
    },
    /// The loop is not stable at a place.
    Unstable {
        /// Path position, m.
        path: f64,
    },
    /// Time after which the push stays within 5 % of a step.
    Settling,
    /// Overshoot of the push.
    Overshoot,
    /// Static error of the push after a step.
    StaticError,
    /// The step came to no end: the loop runs away, or a drive stands at its limit.
    NoStep,
}

/// Something that is asked, and what was reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rating {
    /// What.
    pub criterion: LoopCriterion,
    /// What was reached, SI units; infinite or 0 where there is none.
    pub value: f64,
    /// What is asked: of margins the least, of the others the most, SI units.
    pub asked: f64,
    /// How much of what is allowed is used up: at most 1 where it is met.
    pub used: f64,
}

impl Rating {
    /// True where what is asked is reached.
    pub fn is_met(&self) -> bool {
        self.used <= 1.0
    }
}

/// The worst of some ratings; `None` of none.
pub fn worst<'a>(ratings: impl IntoIterator<Item = &'a Rating>) -> Option<&'a Rating> {
    ratings.into_iter().reduce(|a, b| if b.used > a.used { b } else { a })
}

/// Of a loop that is not stable, as large as no margin makes it; the less the closer it is.
const UNSTABLE: f64 = 1e3;

/// Each margin that is asked for where it is least.
pub(super) fn rate_margins(asked: &[Limit], map: &[Margins]) -> Vec<Rating> {
    let unstable = map.iter().filter(|at| at.channels.is_none()).map(|at| {
        let radius = at.spectral_radius.min(10.0);
        let used = UNSTABLE * if at.held_at_a_limit { 10.0 } else { radius };
        let criterion = LoopCriterion::Unstable { path: at.of.at.path };
        Rating { criterion, value: at.spectral_radius, asked: 1.0, used }
    });
    let unstable: Vec<Rating> = unstable.collect();
    if let Some(first) = worst(&unstable) {
        return vec![*first];
    }
    let each = asked.iter().filter_map(|Limit { figure, value: least }| {
        let of = MARGIN_FIGURES.iter().find(|of| of.figure.key == figure.key)?;
        let ratings: Vec<Rating> = map
            .iter()
            .map(|at| {
                let (value, channel) = (of.value)(at);
                let criterion = LoopCriterion::Margin { figure, channel, path: at.of.at.path };
                Rating { criterion, value, asked: *least, used: least / value.max(1e-12) }
            })
            .collect();
        worst(&ratings).copied()
    });
    each.collect()
}

/// As much as is used up of what is never reached.
const NEVER: f64 = 20.0;

/// What a step came to; `None` where it came to no end.
pub(super) fn rate_step(asked: &AskedResponse, step: Option<&StepFigures>) -> Vec<Rating> {
    let most = |criterion, value: f64, asked: f64| {
        // An overshoot may be forbidden altogether; and what is never reached must not hide what
        // else is missed.
        Rating { criterion, value, asked, used: (value / asked.max(1e-6)).min(NEVER) }
    };
    let Some(step) = step else {
        return vec![most(LoopCriterion::NoStep, f64::INFINITY, 1.0)];
    };
    let settled = step.settle_5pct_s.unwrap_or(f64::INFINITY);
    let height = asked.height.abs();
    vec![
        most(LoopCriterion::Settling, settled, asked.settle),
        most(LoopCriterion::Overshoot, step.overshoot, asked.overshoot),
        most(LoopCriterion::StaticError, step.static_error_n.abs() / height, asked.static_error),
    ]
}

impl LoopCriterion {
    /// True for what a faster or stronger position loop is limited by.
    pub fn is_of_drives(&self) -> bool {
        matches!(self, Self::Margin { channel, .. }
            if crate::margins::CHANNEL_NAMES[SETPOINT..].contains(channel))
    }
}
