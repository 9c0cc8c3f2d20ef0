//! The part all three structures share: joint errors from a tool pose error, six PID loops, and the
//! safe command.

use super::{DriveCommand, InputCheck, Limited, SensorReadings, Setpoint};
use crate::error::Fault;
use crate::kinematics::Frames;
use crate::pid::{Pid, PidGains};
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real, all_finite, held, lit};
use crate::solve::Lu;
use crate::spatial::Twist;
use crate::state::{StateResult, StateVisitor, Stateful};
use nalgebra::Vector3;

/// Diagonal K_p, K_i, K_d of the joint position loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointGains<T: Real> {
    /// N·m/rad.
    pub kp: JointVector<T>,
    /// N·m/(rad·s).
    pub ki: JointVector<T>,
    /// N·m·s/rad.
    pub kd: JointVector<T>,
}

/// K_p J⁻¹ΔX + K_d d/dt(J⁻¹ΔX) + K_i ∫J⁻¹ΔX with gravity fed forward and every drive held within
/// its torque.
#[derive(Debug, Clone, Copy)]
pub(super) struct PositionLoop<T: Real> {
    gains: JointGains<T>,
    pid: [Pid<T>; JOINTS],
    pub period: T,
    inputs: InputCheck<T>,
}

/// The encoders' view of the arm in this period, checked.
pub(super) struct EncoderView<T: Real> {
    pub frames: Frames<T>,
    pub inverse: Lu<T>,
}

impl<T: Real> PositionLoop<T> {
    pub(crate) fn new(gains: JointGains<T>, period: T) -> Self {
        let pid = core::array::from_fn(|i| {
            Pid::new(PidGains { kp: gains.kp[i], ki: gains.ki[i], kd: gains.kd[i] })
        });
        Self { gains, pid, period, inputs: InputCheck::new(&JointVector::zeros()) }
    }

    pub(crate) fn start(
        &mut self,
        robot: &Robot<T>,
        encoder: &JointVector<T>,
        torque: &JointVector<T>,
    ) {
        let held = torque - weight(robot, &robot.frames(encoder), encoder);
        for (pid, load) in self.pid.iter_mut().zip(held.iter()) {
            pid.preload(*load);
        }
        self.inputs = InputCheck::new(encoder);
    }

    /// Kinematics at the encoder angles, or the fault that forbids it.
    pub(crate) fn view(
        &mut self,
        robot: &Robot<T>,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> Result<EncoderView<T>, Fault> {
        self.inputs.check(robot, setpoint, sensed, self.period)?;
        let frames = robot.frames(&sensed.encoder);
        // At 2 m reach, a pivot of 1e-4 of the largest is some 0.01° from singular.
        let inverse = Lu::new(&frames.jacobian().0, lit(1e-4)).ok_or(Fault::Singular)?;
        Ok(EncoderView { frames, inverse })
    }

    /// Γ for the tool pose error ΔX (axes of B) and extra torque already decided elsewhere. True if
    /// a drive saturates.
    pub(crate) fn torque(
        &mut self,
        robot: &Robot<T>,
        view: &EncoderView<T>,
        encoder: &JointVector<T>,
        error: &Twist<T>,
        extra: &JointVector<T>,
    ) -> Result<(JointVector<T>, bool), Fault> {
        let error = view.inverse.solve(&error.to_vector());
        let feed_forward = weight(robot, &view.frames, encoder) + extra;
        // Finite nonsense, such as a set-point of 1e300 m, overflows here and not before.
        if !all_finite(error.iter().chain(feed_forward.iter())) {
            return Err(Fault::Setpoint);
        }
        let mut limited = false;
        let torque = JointVector::from_fn(|i, _| {
            let limit = robot.parameters().joints[i].max_torque;
            let (torque, at_limit) =
                self.pid[i].update(error[i], feed_forward[i], limit, self.period);
            limited |= at_limit;
            torque
        });
        Ok((torque, limited))
    }

    /// Takes a push along z out of the integrators, because the force branch now carries it.
    pub(crate) fn release(&mut self, view: &EncoderView<T>, depth_axis: &Vector3<T>, push: T) {
        let load = push_torque(&view.frames, depth_axis, push);
        for (pid, load) in self.pid.iter_mut().zip(load.iter()) {
            pid.transfer_integral(-*load);
        }
    }

    /// Takes a push along z into the integrators, because the force branch gave it up.
    pub(crate) fn take_over(&mut self, view: &EncoderView<T>, depth_axis: &Vector3<T>, push: T) {
        self.release(view, depth_axis, -push);
    }

    /// The defined safe command: gravity held at the last good angles, viscous braking, integrators
    /// left as they are.
    pub(crate) fn safe(
        &self,
        robot: &Robot<T>,
        sensed: &SensorReadings<T>,
        fault: Fault,
    ) -> DriveCommand<T> {
        let last_good = self.inputs.last_good();
        let hold = weight(robot, &robot.frames(last_good), last_good);
        let torque = JointVector::from_fn(|i, _| {
            let rate = sensed.encoder_rate[i];
            let brake = if rate.is_finite() { -self.gains.kd[i] * rate } else { T::zero() };
            let limit = robot.parameters().joints[i].max_torque;
            held(hold[i] + self.pid[i].integral() + brake, T::zero(), limit)
        });
        DriveCommand {
            torque,
            fault: Some(fault),
            force_error: T::zero(),
            depth_correction: T::zero(),
            push: T::zero(),
            limited: Limited { torque: true, ..Limited::default() },
        }
    }
}

impl<T: Real> Stateful for PositionLoop<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.pid.iter_mut().try_for_each(|pid| pid.visit_state(visitor))?;
        self.inputs.visit_state(visitor)
    }
}

/// Motor torque that carries gravity less the counterbalance, N·m.
fn weight<T: Real>(robot: &Robot<T>, frames: &Frames<T>, q: &JointVector<T>) -> JointVector<T> {
    let mut torque = robot.gravity_torque(frames);
    torque[1] -= robot.counterbalance_torque(q[1]);
    torque
}

/// Jᵀ of a push along z of W, N·m.
pub(super) fn push_torque<T: Real>(
    frames: &Frames<T>,
    depth_axis: &Vector3<T>,
    push: T,
) -> JointVector<T> {
    frames.joint_torque(&crate::spatial::Wrench {
        moment: Vector3::zeros(),
        force: depth_axis * push,
    })
}
