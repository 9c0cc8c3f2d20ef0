//! What the weld does not use and a controller may: linked here, so that the proof covers it too.

use crate::weld::Inputs;
use core::hint::black_box;
use nalgebra::Vector3;
use trueweld_compensators::{
    Adaptive, Authority, Combined, Elastostatic, FeedForward, Following, Learning, Observer, OuterIntegral, Prior,
    SeamTracking, Tracking,
};
use trueweld_core::compensation::{Compensator, Observation, Sighting};
use trueweld_core::control::{ForceGains, HybridController, JointGains, Parallel, Superposed};
use trueweld_core::filter::{Biquad, Filter, MovingAverage};
use trueweld_core::scalar::lit;
use trueweld_core::{JointVector, Real, Robot, Twist, Wrench};

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
    laws(robot, inputs, period);
}

/// Every compensation law, with a seam sensor's readings.
fn laws<T: Real>(robot: &Robot<T>, inputs: &Inputs<T>, period: T) {
    let across = Twist { angular: Vector3::z() * lit::<T>(0.02), linear: Vector3::y() };
    let seen = Sighting { deviation: lit(1e-4), along: across, noise: lit(5e-5), age: period, ahead: lit(0.02) };
    let sightings = black_box([seen; 2]);
    let observation = Observation {
        path: black_box(lit(0.5)),
        planned: black_box(Wrench { moment: Vector3::zeros(), force: Vector3::z() * lit::<T>(-18e3) }),
        sightings: &sightings,
        ..Observation::of_robot(&inputs.setpoint, &inputs.nominal, &inputs.sensed)
    };
    let ask = |law: &mut dyn Compensator<T>| {
        let law = black_box(law);
        law.reset();
        black_box(law.demand(robot, &observation).is_ok());
    };
    let tracking = black_box(Tracking { rate: lit(8.0), shape: lit(20.0) });
    let authority = black_box(Authority { displacement: lit(5e-3), rotation: lit(0.08), fade: lit(0.5) });
    let prior = black_box(Prior { compliance: lit(0.3), force: lit(0.3), tilt: lit(5e-4), lateral: lit(5e-4) });
    if let Some(mut observer) = black_box(Observer::new(lit(30.0), period)) {
        ask(&mut observer);
        black_box(observer.wrench(robot, &inputs.sensed.encoder));
    }
    let following = black_box(Following { rate: lit(8.0), size: lit(2e-3) });
    if let Some(tracking) = black_box(SeamTracking::new(FeedForward, tracking, period))
        && let Some(mut law) = black_box(OuterIntegral::new(tracking, following, period))
    {
        ask(&mut law);
    }
    if let Some(mut law) = black_box(Adaptive::new(prior, period)) {
        ask(&mut law);
        black_box(law.compliance());
    }
    if let Some(mut law) = black_box(Learning::new(FeedForward, lit(2.0), lit(1.0), period)) {
        ask(&mut law);
    }
    if let Some(elastostatic) = black_box(Elastostatic::new(lit(5.0), period))
        && let Some(mut law) = black_box(Combined::new(elastostatic, FeedForward, [true; 6], authority, period))
    {
        ask(&mut law);
    }
}
