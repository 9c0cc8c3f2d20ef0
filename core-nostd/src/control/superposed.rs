//! Scheme 2, (2.3): superposed control, as (2.2) with ΔX instead of SΔX.
//!
//! Both integrators act on depth, so at rest K_i J⁻¹ΔX + Jᵀn K_if Δf = 0 with n along z: a static
//! force error Δf = −(k̄_i/K_if) Δx, where Δx = nᵀΔX and k̄_i = 1/(nᵀJK_i⁻¹Jᵀn), in exchange for a
//! depth that keeps its stiffness when the sensor fails. The other directions give way with it:
//! ΔX = −K_if Δf · JK_i⁻¹Jᵀn has parts across n as well. Apart, the two integrators would wind up
//! against each other, so one set of joint integrators holds their sum, ∫(K_i J⁻¹ΔX + Jᵀn K_if Δf)
//! dt: the same law at rest, and bounded. Reconstructed (see the [module](super) text).

use super::parallel::{ForceBranch, superpose};
use super::position_loop::PositionLoop;
use super::{Command, ForceGains, HybridController, JointGains, SensorReadings, Setpoint};
use crate::robot::Robot;
use crate::scalar::{JointVector, Real};

/// Superposed hybrid controller (2.3).
#[derive(Debug, Clone, Copy)]
pub struct Superposed<T: Real> {
    position: PositionLoop<T>,
    force: ForceBranch<T>,
}

impl<T: Real> Superposed<T> {
    /// Controller at rest. `period`: s between calls of [`cycle`](HybridController::cycle).
    pub fn new(joint: JointGains<T>, force: ForceGains<T>, period: T) -> Self {
        Self { position: PositionLoop::new(joint, period), force: ForceBranch::new(force, period) }
    }
}

impl<T: Real> HybridController<T> for Superposed<T> {
    fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>) {
        self.position.start(robot, encoder, torque);
        self.force.reset();
    }

    fn cycle(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> Command<T> {
        superpose(&mut self.position, &mut self.force, robot, setpoint, sensed, false)
    }
}
