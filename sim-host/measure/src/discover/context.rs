//! What a discovery is made at.

use super::variables::Rows;
use crate::data::log::Log;
use crate::fit::{FitProblem, Fitted};

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
    /// Identifier of what is found.
    pub id: &'a str,
}

impl Context<'_> {
    /// The logs with what the calibrated model says of their links.
    pub fn rows(&self) -> Rows<'_> {
        Rows { bench: self.bench, logs: self.logs, at: &self.null.at }
    }
}
