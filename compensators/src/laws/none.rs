//! No compensation: the law every other one is compared with.

use crate::gain::GainError;
use crate::law::{Law, NoGains, Setup};
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Demands nothing, ever.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Uncompensated;

impl<T: Real> Law<T> for Uncompensated {
    const NAME: &'static str = "none";
    const SUMMARY: &'static str = "No compensation";
    type Gains = NoGains;
    type Built = Self;

    fn build(_: &NoGains, _: &Setup<T>) -> Result<Self, GainError> {
        Ok(Self)
    }
}

impl<T: Real> Compensator<T> for Uncompensated {
    fn reset(&mut self) {}

    fn demand(&mut self, _: &Robot<T>, _: &Observation<'_, T>) -> Result<Twist<T>, Fault> {
        Ok(Twist::zero())
    }

    fn visit_state(&mut self, _: &mut dyn StateVisitor) -> StateResult {
        Ok(())
    }
}
