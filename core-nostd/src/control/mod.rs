//! Hybrid force/position control of the tool: three published structures behind one trait.
//!
//! One direction, the tool axis z of the weld frame W, is force-controlled; the selection S keeps
//! the other five under position control. The controllers see encoders and the force sensor only;
//! that the loaded tool is elsewhere is for [`compensation`](crate::compensation). Gravity
//! and the counterbalance are fed forward at the encoder angles. The spindle's line is
//! filtered out of the force error ([`SpindleFilter`]).
//!
//! Source: Bres et al. 2010, (2.2)–(2.5). The printed text of (2.3)–(2.5) was not at hand; they are
//! reconstructed from their description and from Perdereau & Drouin 1993 (external control) and
//! Khalil & Dombre 2002, ch. 16.

mod external;
mod parallel;
mod position_loop;
mod spindle;
mod superposed;
mod watch;

pub use external::{External, ExternalGains};
pub use parallel::{Branches, ForceGains, Parallel};
pub use position_loop::JointGains;
pub use spindle::{LONGEST_DELAY, SpindleFilter};
pub use superposed::Superposed;
pub use watch::{ForceSensorCheck, ForceSensorLimits, InputCheck, RepeatCounter, STUCK};

use crate::error::Fault;
use crate::robot::Robot;
use crate::scalar::{JointVector, Real};
use crate::spatial::{Pose, Wrench, is_rotation};
use crate::state::{StateError, StateResult, StateVisitor};
use nalgebra::{Matrix3, Vector3};

/// What the task asks of the tool in this period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setpoint<T: Real> {
    /// Desired tool pose in encoder kinematics, `b_from_t`.
    pub pose: Pose<T>,
    /// Axes of the weld frame W in B: x along the weld, z the tool axis into the material, y = z ×
    /// x.
    pub b_from_w: Matrix3<T>,
    /// Push into the material along z of W, N. `None`: depth under position control, no force loop.
    pub force: Option<T>,
    /// Rate of the spindle as its drive reports it, rad/s, in either sense: the force loop does not
    /// answer its line. 0 where it stands still or is not known.
    pub spindle_speed: T,
}

impl<T: Real> Setpoint<T> {
    /// The force-controlled direction: z of W in axes of B.
    pub fn depth_axis(&self) -> Vector3<T> {
        self.b_from_w.column(2).into_owned()
    }

    /// True where all numbers are finite and both rotations are rotations: scaled or left-handed
    /// axes turn a correction the wrong way.
    fn is_sound(&self) -> bool {
        let numbers = self.force.is_none_or(|f| f.is_finite()) && self.spindle_speed.is_finite();
        self.pose.is_rigid() && is_rotation(&self.b_from_w) && numbers
    }
}

/// Readings of the robot's own instruments in this period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorReadings<T: Real> {
    /// Encoder angles θ_E, rad.
    pub encoder: JointVector<T>,
    /// Encoder rates, rad/s.
    pub encoder_rate: JointVector<T>,
    /// Motor torque of the last period, seen from the joint, N·m; all 0 where it is not known.
    pub motor_torque: JointVector<T>,
    /// What the environment applies to the tool, at the TCP, in axes of the real tool frame T; tool
    /// weight removed.
    pub wrench: Wrench<T>,
}

/// Torque of the drives in this period, and the controller's internal signals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriveCommand<T: Real> {
    /// Motor torque Γ, seen from the joint, N·m, within the drives' limits.
    pub torque: JointVector<T>,
    /// Set where this is the safe command in place of the controller's; the caller decides whether
    /// to brake.
    pub fault: Option<Fault>,
    /// Force error Δf = f_d − f_s along z of W without the spindle's line, N; zero without a force
    /// loop.
    pub force_error: T,
    /// Depth the external loop adds to the set-point, m (zero for the others).
    pub depth_correction: T,
    /// Push the force branch adds through Jᵀ, N (zero for the external controller).
    pub push: T,
    /// What was held at a limit.
    pub limited: Limited,
}

/// What was held at a limit in a period.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Limited {
    /// The torque of some drive.
    pub torque: bool,
    /// What the force loop adds, in size or rate.
    pub force_loop: bool,
    /// The compensation, in size or rate.
    pub compensation: bool,
}

impl Limited {
    /// True where anything was.
    pub fn any(self) -> bool {
        self.torque || self.force_loop || self.compensation
    }
}

/// A hybrid force/position controller, called once a period.
pub trait HybridController<T: Real> {
    /// Starts from rest, holding what the drives hold: `torque` Γ at `encoder` angles.
    fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>);

    /// One control period. Always returns a command that is safe to apply:
    ///
    /// * force sensor faulty: the force branch is held where it was, position control goes on;
    /// * encoder or set-point faulty, singular Jacobian, limits exceeded: gravity is held at the
    ///   last good angles with viscous braking (K_d, where the rates are good), integrators frozen.
    fn cycle(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> DriveCommand<T>;

    /// Shows its state, as [`Stateful`](crate::state::Stateful) does.
    ///
    /// # Errors
    /// [`StateError`]; [`StateError::Unsupported`] where a controller does not list it.
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let _ = visitor;
        Err(StateError::Unsupported)
    }
}

impl<T: Real, C: HybridController<T> + ?Sized> HybridController<T> for &mut C {
    fn start(&mut self, robot: &Robot<T>, encoder: &JointVector<T>, torque: &JointVector<T>) {
        (**self).start(robot, encoder, torque);
    }

    fn cycle(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> DriveCommand<T> {
        (**self).cycle(robot, setpoint, sensed)
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        (**self).visit_state(visitor)
    }
}

/// The push that the force sensor sees along z of W, N, from the wrench in T with T placed by the
/// encoders.
///
/// `None` where any of the sensor's channels is NaN or infinite: the others are not trusted either.
fn sensed_push<T: Real>(
    b_from_t: &Pose<T>,
    depth_axis: &Vector3<T>,
    wrench: &Wrench<T>,
) -> Option<T> {
    let push = -(b_from_t.rotation * wrench.force).dot(depth_axis);
    (wrench.is_finite() && push.is_finite()).then_some(push)
}
