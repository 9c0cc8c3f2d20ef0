//! What a discovery is made at.

use crate::fit::{FitProblem, Fitted};

/// The logs, and the calibrations beside which a law is looked for.
#[derive(Clone, Copy)]
pub(super) struct Context<'a> {
    /// The logs.
    pub bench: &'a FitProblem,
    /// Blocks of their values.
    pub blocks: &'a [Vec<u8>],
    /// The calibrations at their best.
    pub null: &'a Fitted,
    /// Identifier of what is found.
    pub id: &'a str,
}
