//! Scheme 1, (2.2): parallel hybrid control with a selection matrix in the position branch.
//!
//! Γ = K_p J⁻¹SΔX + K_d d/dt(J⁻¹SΔX) + K_i∫J⁻¹SΔX + Jᵀ(I−S)[f_d + K_pf Δf − K_df Ẋ + K_if∫Δf]. Fast
//! and without static error in force, but depth has no stiffness of its own: the drives give way
//! until the force branch has caught up.
//!
//! The gains are not scaled by the posture's stiffness, as the [external](super::External) scheme's
//! are: here force makes force. With S nothing but the contact holds the drives along z, so at rest
//! a push arrives one to one whatever the stiffness; without S the share k_eq/(k_eq + k̄_p)
//! arrives, k̄_p = 1/(nᵀJK_p⁻¹Jᵀn), and since the arm's springs and the position loop act through
//! the same J, that share hardly knows the posture (0.88 to 0.90 over both published welds).

use super::position_loop::{PositionLoop, push_torque};
use super::{
    DriveCommand, HybridController, JointGains, Limited, SensorReadings, Setpoint, SpindleFilter,
    sensed_push,
};
use crate::error::Fault;
use crate::filter::Filter;
use crate::pid::{Pid, PidGains};
use crate::robot::Robot;
use crate::scalar::{JointVector, Real, held};
use crate::state::{StateResult, StateVisitor, Stateful};

/// Gains of the force branch of (2.2) and (2.3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ForceGains<T: Real> {
    /// K_pf, N/N.
    pub kp: T,
    /// K_if, 1/s.
    pub ki: T,
    /// K_df on the encoder velocity along z, N·s/m.
    pub kd: T,
    /// Largest correction the branch may add to f_d, N.
    pub max_correction: T,
    /// Largest rate of the push, N/s: a step of f_d put on the drives at once would ring the arm's
    /// first modes.
    pub max_rate: T,
}

/// State of the force branch: what (2.2) and (2.3) have in common.
#[derive(Debug, Clone, Copy)]
struct ForceBranch<T: Real> {
    gains: ForceGains<T>,
    pid: Pid<T>,
    spindle: SpindleFilter<T>,
    period: T,
    /// Last push given, N; `None` while the force loop is open.
    push: Option<T>,
}

/// What the force branch decided in one period.
struct Push<T: Real> {
    pub push: T,
    pub error: T,
    /// The loop closed in this period: the push that the position loop must hand over.
    pub taken_over: Option<T>,
    pub limited: bool,
    pub fault: Option<Fault>,
}

impl<T: Real> ForceBranch<T> {
    pub(crate) fn new(gains: ForceGains<T>, period: T) -> Self {
        let pid = Pid::new(PidGains { kp: gains.kp, ki: gains.ki, kd: T::zero() });
        Self { gains, pid, spindle: SpindleFilter::new(period), period, push: None }
    }

    pub(crate) fn reset(&mut self) {
        *self = Self::new(self.gains, self.period);
    }

    /// f_d + K_pf Δf − K_df Ẋ + K_if∫Δf within its rate, N; `None` while the set-point asks for no
    /// force.
    pub(crate) fn update(
        &mut self,
        setpoint: &Setpoint<T>,
        sensed: Option<T>,
        velocity: T,
    ) -> Option<Push<T>> {
        let Some(desired) = setpoint.force else {
            self.reset();
            return None;
        };
        let Some(error) = sensed.map(|sensed| desired - sensed).filter(|e| e.is_finite()) else {
            // Blind: hold the last push, or what was asked for; the position loop bears that already.
            let push = self.push.unwrap_or(desired);
            let taken_over = self.push.is_none().then_some(desired);
            self.push = Some(push);
            return Some(Push {
                push,
                error: T::zero(),
                taken_over,
                limited: true,
                fault: Some(Fault::Force),
            });
        };
        let taken_over = self.push.is_none().then_some(desired);
        self.spindle.tune(setpoint.spindle_speed);
        let error = self.spindle.update(error);
        let (correction, limited) = self.pid.update(
            error,
            -self.gains.kd * velocity,
            self.gains.max_correction,
            self.period,
        );
        let wanted = desired + correction;
        let (before, step) = (self.push.unwrap_or(desired), self.gains.max_rate * self.period);
        let push = held(wanted, before, step);
        self.push = Some(push);
        Some(Push { push, error, taken_over, limited: limited || push != wanted, fault: None })
    }

    /// Empties the integrator and returns what it held, N, for another loop to carry.
    fn transfer_integral(&mut self) -> T {
        let load = self.pid.integral();
        self.pid.transfer_integral(-load);
        self.push = self.push.map(|push| push - load);
        load
    }
}

/// Force branch beside position branch: (2.2) where the selection acts (`SELECT`), (2.3) where the
/// whole ΔX stays under position control.
#[derive(Debug, Clone, Copy)]
pub struct Branches<T: Real, const SELECT: bool> {
    position: PositionLoop<T>,
    force: ForceBranch<T>,
}

/// Parallel hybrid controller (2.2).
pub type Parallel<T> = Branches<T, true>;

impl<T: Real, const SELECT: bool> Branches<T, SELECT> {
    /// Controller at rest. `period`: s between calls of [`cycle`](HybridController::cycle).
    pub fn new(joint: JointGains<T>, force: ForceGains<T>, period: T) -> Self {
        Self { position: PositionLoop::new(joint, period), force: ForceBranch::new(force, period) }
    }
}

impl<T: Real, const SELECT: bool> HybridController<T> for Branches<T, SELECT> {
    fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>) {
        self.position.start(robot, encoder, torque);
        self.force.reset();
    }

    fn cycle(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> DriveCommand<T> {
        let Self { position, force } = self;
        let view = match position.view(robot, setpoint, sensed) {
            Ok(view) => view,
            Err(fault) => return position.safe(robot, sensed, fault),
        };
        let z = setpoint.depth_axis();
        let tcp = &view.frames.tcp;
        let velocity = view.frames.twist(&sensed.encoder_rate).linear.dot(&z);
        let push = force.update(setpoint, sensed_push(tcp, &z, &sensed.wrench), velocity);
        let mut error = tcp.error_to(&setpoint.pose);
        let mut extra = JointVector::zeros();
        if let Some(push) = &push {
            if let Some(load) = push.taken_over {
                position.release(&view, &z, load);
            }
            // S takes depth out of the position branch as soon as the force branch has it.
            if SELECT {
                error.linear -= z * z.dot(&error.linear);
            }
            extra = push_torque(&view.frames, &z, push.push);
        }
        match position.torque(robot, &view, &sensed.encoder, &error, &extra) {
            Err(fault) => position.safe(robot, sensed, fault),
            Ok((torque, held)) => {
                // Where both integrators act on depth, each grows without end against the other at
                // rest (K_i∫ and K_if∫ of errors that do not vanish), until a limit breaks the
                // balance after some 10 s. Only their sum matters, so the position loop keeps it,
                // and the drives' limits bound it.
                if !SELECT && !held {
                    position.take_over(&view, &z, force.transfer_integral());
                }
                DriveCommand {
                    torque,
                    fault: push.as_ref().and_then(|p| p.fault),
                    force_error: push.as_ref().map_or(T::zero(), |p| p.error),
                    depth_correction: T::zero(),
                    push: push.as_ref().map_or(T::zero(), |p| p.push),
                    limited: Limited {
                        torque: held,
                        force_loop: push.is_some_and(|p| p.limited),
                        compensation: false,
                    },
                }
            }
        }
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.position.visit_state(visitor)?;
        self.force.pid.visit_state(visitor)?;
        self.force.spindle.visit_state(visitor)?;
        visitor.scalar_option(&mut self.force.push)
    }
}
