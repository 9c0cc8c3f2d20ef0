//! Time integration of the cell, its equilibrium at rest, and the links alone under recorded
//! motors.

mod dormand_prince;
mod fastest;
mod linearly_implicit;
pub mod link_dynamics;
pub mod rest;

pub use dormand_prince::Tolerance;
pub use fastest::{FastestMode, TooFast, substeps};

use crate::cell::{Cell, Evaluation, State};
use trueweld_core::JointVector;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};

/// How the plant is integrated between two samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Integrator {
    /// Linearly implicit, third order, fixed step: the default.
    LinearlyImplicit,
    /// Adaptive Dormand–Prince 5(4): the reference.
    DormandPrince(Tolerance),
}

/// The plant's state left the finite numbers: the loop is unstable, or a model is far out of its
/// range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error(
    "the simulated state left the finite numbers at {time:.3} s: the loop is unstable or the model far out of range"
)]
pub struct Diverged {
    /// Simulated time, s.
    pub time: f64,
}

/// One integration in progress.
#[derive(Debug, Clone, Copy)]
pub struct Stepper {
    integrator: Integrator,
    suggested: f64,
}

impl Stepper {
    /// Starts an integration.
    pub fn new(integrator: Integrator) -> Self {
        Self { integrator, suggested: 1e-5 }
    }

    /// Advances `state` from `time`, where its evaluation is `at`, by `h` seconds, motor torque
    /// held.
    ///
    /// # Errors
    /// [`Diverged`].
    #[inline]
    pub fn advance(
        &mut self,
        cell: &Cell,
        time: f64,
        state: &State,
        at: &Evaluation,
        torque: &JointVector<f64>,
        h: f64,
    ) -> Result<State, Diverged> {
        match self.integrator {
            Integrator::LinearlyImplicit => {
                linearly_implicit::step(cell, time, state, at, torque, h)
            }
            Integrator::DormandPrince(tolerance) => dormand_prince::advance(
                cell,
                time,
                state,
                at,
                torque,
                h,
                tolerance,
                &mut self.suggested,
            ),
        }
        .ok_or(Diverged { time })
    }
}

impl Stateful for Stepper {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.scalar(&mut self.suggested)
    }
}
