//! What the weld does not use and a controller may: linked here, so that the proof covers it too.

use crate::weld::Inputs;
use core::hint::black_box;
use trueweld_core::control::{ForceGains, HybridController, JointGains, Parallel, Superposed};
use trueweld_core::filter::{Biquad, Filter, MovingAverage};
use trueweld_core::scalar::lit;
use trueweld_core::{JointVector, Real, Robot};

/// Calls the other two controllers, the predicted deflection, forward and inverse dynamics, all branches of the inverse
/// kinematics and the other filters. What they answer is for the tests on the host to judge.
#[inline(never)]
pub fn link<T: Real>(robot: &Robot<T>, inputs: &Inputs<T>) {
    let (robot, inputs) = (black_box(robot), black_box(inputs));
    let sensed = &inputs.sensed;
    let gain = black_box(JointVector::repeat(lit::<T>(1e5)));
    let joint = JointGains { kp: gain, ki: gain, kd: gain };
    let force = black_box(ForceGains {
        kp: lit(0.2),
        ki: lit(8.0),
        kd: lit(1e5),
        max_correction: lit(1e4),
        max_rate: lit(1e5),
    });
    let period = black_box(lit(0.012));
    let (mut parallel, mut superposed) = (Parallel::new(joint, force, period), Superposed::new(joint, force, period));
    for controller in [&mut parallel as &mut dyn HybridController<T>, &mut superposed] {
        controller.start(robot, &sensed.encoder, &sensed.motor_torque);
        black_box(controller.cycle(robot, &inputs.setpoint, sensed));
    }
    black_box(robot.deflected(&sensed.encoder, &sensed.wrench, black_box(3)));
    let frames = robot.frames(&sensed.encoder);
    black_box(robot.forward_dynamics(&frames, &sensed.encoder_rate, &sensed.motor_torque, &sensed.wrench));
    black_box(robot.rnea(&frames, &sensed.encoder_rate, &sensed.encoder_rate, &sensed.wrench));
    black_box(robot.inverse_all(&inputs.nominal).is_ok());
    let mut mean = black_box(MovingAverage::<T, 5>::new(period));
    mean.settle(period);
    black_box(mean.update(period));
    black_box(Biquad::notch(lit(16.0), lit(2.0), period));
}
