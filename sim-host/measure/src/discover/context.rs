//! What a discovery is made at.

use super::variables::Rows;
use crate::data::log::Log;
use crate::fit::{Condensed, Eliminated, FitProblem, Fitted, Linear, Slopes};

/// The logs, and the calibrations beside which a law is looked for.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    /// The problem.
    pub bench: &'a FitProblem,
    /// The logs that it was made from.
    pub logs: &'a [Log],
    /// Blocks of their values.
    pub blocks: &'a [Vec<u8>],
    /// The calibrations at their best.
    pub null: &'a Fitted,
    /// Their values, ready to be taken out.
    pub eliminated: &'a Eliminated,
    /// Identifier of what is found.
    pub id: &'a str,
}

impl Context<'_> {
    /// The linear model of the calibrations with more values beside them, of which nothing is known.
    pub fn beside(&self, more: &[Slopes]) -> Linear {
        let more: Vec<&Slopes> = more.iter().collect();
        self.null.linear.extended(self.blocks, &self.null.at, &self.null.slopes, &more)
    }

    /// The same, condensed onto these values.
    pub fn condensed(&self, more: &[Slopes]) -> Condensed {
        self.eliminated.condensed(&self.beside(more), more.len())
    }

    /// The logs with what the calibrated model says of their links.
    pub fn rows(&self) -> Rows<'_> {
        Rows { bench: self.bench, logs: self.logs, at: &self.null.at }
    }
}
