//! What the weld does not use and a controller may: linked here, so that the proof covers it too.

use crate::weld::Inputs;
use core::hint::black_box;
use nalgebra::Vector3;
use trueweld_compensators::{
    Adaptive, AdaptiveGains, Combined, CombinedGains, Elastostatic, ElastostaticGains, FeedForward,
    Law, Observer, ObserverGains, Setup, Visitor, for_each,
};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{ForceGains, HybridController, JointGains, Parallel, Superposed};
use trueweld_core::filter::{Biquad, Filter, MovingAverage};
use trueweld_core::scalar::lit;
use trueweld_core::{JointVector, Real, Robot, Twist, Wrench};

/// Calls the other two controllers, the predicted deflection, forward and inverse dynamics, all
/// branches of the inverse kinematics and the other filters. What they answer is for the tests on
/// the host to judge.
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
    let (mut parallel, mut superposed) =
        (Parallel::new(joint, force, period), Superposed::new(joint, force, period));
    for controller in [&mut parallel as &mut dyn HybridController<T>, &mut superposed] {
        controller.start(robot, &sensed.encoder, &sensed.motor_torque);
        black_box(controller.cycle(robot, &inputs.setpoint, sensed));
    }
    black_box(robot.deflected(&sensed.encoder, &sensed.wrench, black_box(3)));
    let frames = robot.frames(&sensed.encoder);
    black_box(robot.forward_dynamics(
        &frames,
        &sensed.encoder_rate,
        &sensed.motor_torque,
        &sensed.wrench,
    ));
    black_box(robot.rnea(&frames, &sensed.encoder_rate, &sensed.encoder_rate, &sensed.wrench));
    black_box(robot.inverse_all(&inputs.nominal).is_ok());
    let mut mean = black_box(MovingAverage::<T, 5>::new(period));
    mean.initialize(period);
    black_box(mean.update(period));
    black_box(Biquad::notch(lit(16.0), lit(2.0), period));
    if let Ok(observer) = black_box(Observer::new(&black_box(ObserverGains::default()), period)) {
        black_box(observer.wrench(robot, &sensed.encoder));
    }
    if let Ok(law) = black_box(Adaptive::new(&black_box(AdaptiveGains::default()), period)) {
        black_box(law.compliance());
    }
    laws(&mut |_, law| {
        let law = black_box(law);
        law.reset();
        ask(law, robot, inputs, 0);
        law.freeze();
    });
}

/// One period of a law by itself. `k`: the period, which turns what is seen.
pub fn ask<T: Real>(law: &mut dyn Compensator<T>, robot: &Robot<T>, inputs: &Inputs<T>, k: usize) {
    observed(inputs, k, |observation| {
        black_box(black_box(law).demand(robot, observation).is_ok());
    });
}

/// What is seen in a period, with two readings of a seam sensor, the most that a period brings.
pub fn observed<T: Real>(inputs: &Inputs<T>, k: usize, of: impl FnOnce(&Observation<'_, T>)) {
    let across = Twist { angular: Vector3::z() * lit::<T>(0.02), linear: Vector3::y() };
    let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
    let seen = [across, tilted].map(|along| DeviationMeasurement {
        deviation: lit(1e-5 * (k % 7) as f64),
        along,
        noise: lit(5e-5),
        age: lit(0.012),
        ahead: lit(0.02),
    });
    let observation = Observation {
        path: black_box(lit(0.5 + 1.2e-4 * k as f64)),
        planned: black_box(Wrench {
            moment: Vector3::zeros(),
            force: Vector3::z() * lit::<T>(-18e3),
        }),
        measurements: black_box(&seen),
        ..Observation::of_robot(&inputs.setpoint, &inputs.nominal, &inputs.sensed)
    };
    of(&observation);
}

/// Hands every law on with its name.
struct Each<'a, T: Real>(&'a mut dyn FnMut(&str, &mut dyn Compensator<T>));

impl<T: Real> Visitor<T> for Each<'_, T> {
    /// In a frame of its own, and without a copy for the optimiser's sake: some laws are large.
    #[inline(never)]
    fn visit<L: Law<T>>(&mut self) {
        if let Ok(mut law) = L::build(&black_box(L::Gains::default()), &setup()) {
            (self.0)(L::NAME, &mut law);
        }
    }
}

/// As far as the optimiser knows, any.
fn setup<T: Real>() -> Setup<T> {
    black_box(Setup::new(lit(0.012), lit(2.0)))
}

/// Every compensation law with its name, one after another, and one combination.
pub fn laws<T: Real>(each: &mut dyn FnMut(&str, &mut dyn Compensator<T>)) {
    for_each(&mut Each(each));
    let gains = black_box(ElastostaticGains::default());
    if let Ok(first) = Elastostatic::new(&gains, setup().period)
        && let Ok(mut law) =
            Combined::new(first, FeedForward, &black_box(CombinedGains::default()), setup().period)
    {
        each("elastostatic+feed-forward", &mut law);
    }
}
