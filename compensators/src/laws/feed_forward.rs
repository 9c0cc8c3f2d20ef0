//! Feed-forward from the planned load alone: the elastostatic fake target of (1.1)–(1.3), without a
//! force sensor.
//!
//! With θ the joint angles of the nominal pose and w the load that the weld was planned with,
//!
//! θ_E = θ + K⁻¹ (g(θ) − τ_cb(θ₂) − J(θ)ᵀ w),  demand = X(θ_E) ⊖ X_set − its value at w = 0 as taught.
//!
//! Needs: K, and the process forces at the planned push and feed. Measures nothing: an error of K or
//! of the planned force passes through one to one, and so does the compliance of bearings, base and
//! links. In return no load comes back to it, and by itself it closes no loop. As it is built it has
//! an [`OuterIntegral`], which does, across the seam at a share of its rate. Where drives turn round,
//! dry friction holds them: the position loop behind it is slow and oscillates at 1 Hz, and an
//! integral as fast as under a seam sensor has a gain margin of 1.3 on it (docs/margins.md). Tuning:
//! none.

use crate::gain::GainError;
use crate::law::{Law, NoGains, Setup};
use crate::{FollowingGains, OuterIntegral};
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{Fault, Real, Robot, Twist};

/// Share of the rate of the outer integral across the seam where no seam sensor's loop is beside it.
const OUTER_INTEGRAL_SHARE: f64 = 0.4;

/// Feed-forward law.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct FeedForward;

impl<T: Real> Law<T> for FeedForward {
    const NAME: &'static str = "feed-forward";
    const SUMMARY: &'static str = "From the planned load and the robot's stiffness";
    type Gains = NoGains;
    type Built = OuterIntegral<T, Self>;

    fn build(_: &NoGains, setup: &Setup<T>) -> Result<Self::Built, GainError> {
        OuterIntegral::new(Self, &Self::following(&setup.following), setup.period)
    }
}

impl FeedForward {
    /// Gains of the outer integral of a law without a seam sensor.
    pub(crate) fn following(of: &FollowingGains) -> FollowingGains {
        of.across(OUTER_INTEGRAL_SHARE)
    }
}

impl<T: Real> Compensator<T> for FeedForward {
    fn reset(&mut self) {}

    fn demand(
        &mut self,
        robot: &Robot<T>,
        observation: &Observation<'_, T>,
    ) -> Result<Twist<T>, Fault> {
        let link = observation.nominal_angles(robot)?;
        Ok(observation.demand_for(robot, &robot.fake_target(&link, &observation.planned_in_t())))
    }

    fn visit_state(&mut self, _: &mut dyn StateVisitor) -> StateResult {
        Ok(())
    }
}
