//! What an FMU runs: a law with its controller, or a cell.

use crate::variable::VariableTable;
use trueweld_core::state::{StateResult, StateVisitor};

/// How a call went that was in order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Stepped {
    /// It was no step.
    Idle,
    /// A step in order.
    Well,
    /// A step with something that the importer is to know of.
    Warned(String),
}

/// A model of fixed step. Errors are sentences for the importer's log.
pub(crate) trait Model {
    /// Its variables with what they begin as.
    fn table(&self) -> &VariableTable;

    /// Its step, s.
    fn period(&self) -> f64;

    /// How long its run takes, s, where it ends by itself; otherwise a proposal.
    fn duration(&self) -> f64;

    /// Begins a run with the parameters in the row `values`, and writes the first outputs there.
    fn initialise(&mut self, values: &mut [f64]) -> Result<(), String>;

    /// One period, from the inputs in the row `values` to the outputs there.
    fn step(&mut self, values: &mut [f64]) -> Result<Stepped, String>;

    /// Shows its state, once initialised; parameters, inputs and outputs are not part of it.
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult;

    /// Called once its state was replaced.
    fn restored(&mut self);
}
