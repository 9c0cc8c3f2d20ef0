//! What a discovery is made at.

use super::variables::LogRows;
use trueweld_estimate::fit::{FitProblem, Fitted, Linear, ReducedNormal, SchurComplement, Slopes};
use trueweld_logs::log::Log;

/// The logs, and the calibrations beside which a law is looked for.
#[derive(Clone, Copy)]
pub(super) struct DiscoveryContext<'a> {
    /// The problem.
    pub problem: &'a FitProblem,
    /// The logs that it was made from.
    pub logs: &'a [Log],
    /// Blocks of their values.
    pub blocks: &'a [Vec<u8>],
    /// The calibrations at their best.
    pub null: &'a Fitted,
    /// Their values, ready to be taken out.
    pub eliminated: &'a SchurComplement,
    /// Identifier of what is found.
    pub id: &'a str,
}

impl DiscoveryContext<'_> {
    /// The linear model of the calibrations with more values beside them, of which nothing is known.
    pub(crate) fn beside(&self, more: &[Slopes]) -> Linear {
        let Fitted { linear, residuals, slopes, .. } = self.null;
        let all: Vec<&Slopes> = slopes.iter().chain(more).collect();
        linear.renewed(self.blocks, residuals, &all, |_| false)
    }

    /// The same, condensed onto these values.
    pub(crate) fn condensed(&self, more: &[Slopes]) -> ReducedNormal {
        self.eliminated.condensed(&self.beside(more), more.len())
    }

    /// The logs with what the calibrated model says of their links.
    pub(crate) fn rows(&self) -> LogRows<'_> {
        LogRows { problem: self.problem, logs: self.logs, at: &self.null.residuals }
    }
}
