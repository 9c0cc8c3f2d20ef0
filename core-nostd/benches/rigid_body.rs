//! Time per call of the core's algorithms, and of what a weld adds. Every call starts from joint
//! angles: nothing is carried over from one state to the next. `docs/speed.md` says how to read it.

mod support;

use core::hint::black_box;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use support::{GRAVITY, STATES, States, WORK, algorithms, arm, converted, short_runs, time};
use trueweld_core::compensation::{Compensated, Compensator, LoopLimits, Observation};
use trueweld_core::control::{
    External, ExternalGains, ForceGains, HybridController, JointGains, Parallel, SensorReadings,
    Setpoint, Superposed,
};
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, JointVector, Pose, Real, Robot, Twist, Wrench};

/// Control period, s.
const PERIOD: f64 = 0.012;

/// One control period on set-point, nominal pose and instruments.
type Cycle<'a, T> = dyn FnMut(&Setpoint<T>, &Pose<T>, &SensorReadings<T>) -> Option<Fault> + 'a;

/// What a weld adds: inverse kinematics, deflection, and whole control periods.
fn welding<T: Real>(criterion: &mut Criterion, scalar: &str) {
    let robot = arm::<T>(GRAVITY);
    let robot = black_box(&robot);
    let states = States::new();
    let q = converted::<T>(&states.near_work);
    let poses: Vec<Pose<T>> = q.iter().map(|q| robot.forward_kinematics(q)).collect();
    let work = JointVector::from(WORK.map(lit::<T>));
    let push = Wrench {
        moment: Vector3::new(lit(10.0), lit(20.0), lit(30.0)),
        force: Vector3::new(lit(-1000.0), lit(4000.0), lit(-18000.0)),
    };
    time(criterion, &format!("{scalar}/inverse kinematics (track)"), |i| {
        robot.inverse_near(&poses[i], &work)
    });
    time(criterion, &format!("{scalar}/deflected, 3 iterations"), |i| {
        robot.deflected(&q[i], &push, 3)
    });

    let joint = JointGains {
        kp: JointVector::repeat(lit(4e5)),
        ki: JointVector::repeat(lit(4e5)),
        kd: JointVector::repeat(lit(1e4)),
    };
    let force = ForceGains {
        kp: lit(0.1),
        ki: lit(2.0),
        kd: lit(1e3),
        max_correction: lit(5e3),
        max_rate: lit(5e4),
    };
    let outer = ExternalGains {
        kp: lit(1e-8),
        ki: lit(1e-7),
        kd: lit(1e-3),
        material_stiffness: lit(3e7),
        tuned_stiffness: lit(5e6),
        max_correction: lit(5e-3),
        max_rate: lit(1e-2),
    };
    let period = lit(PERIOD);
    let limits = LoopLimits { bandwidth: lit(5.0), size: lit(5e-3), rate: lit(5e-3) };
    let welded = |controller: &mut Cycle<'_, T>, i: usize| {
        // As a live sensor: no reading quite like the last.
        let wrench = push * lit(1.0 + 1e-3 * i as f64);
        welded(controller, &poses[(i + 1) % STATES], q[i], wrench);
    };
    let mut controllers: [(&str, Box<dyn HybridController<T>>); 3] = [
        ("parallel", Box::new(Parallel::new(joint, force, period))),
        ("superposed", Box::new(Superposed::new(joint, force, period))),
        ("external", Box::new(External::new(joint, outer, period))),
    ];
    for (name, controller) in &mut controllers {
        controller.start(robot, &work, &JointVector::zeros());
        let mut cycle = |s: &Setpoint<T>, _: &Pose<T>, m: &SensorReadings<T>| {
            black_box(controller.cycle(robot, s, m)).fault
        };
        time(criterion, &format!("{scalar}/control cycle, {name}"), |i| welded(&mut cycle, i));
    }
    let mut compensated =
        Compensated::new(External::new(joint, outer, period), FakeTarget, limits, limits, period);
    compensated.start(robot, &work, &JointVector::zeros());
    let mut cycle = |s: &Setpoint<T>, n: &Pose<T>, m: &SensorReadings<T>| {
        black_box(compensated.cycle(robot, &Observation::of_robot(s, n, m))).fault
    };
    time(criterion, &format!("{scalar}/control cycle, external + fake target"), |i| {
        welded(&mut cycle, i)
    });
}

/// One period of a weld at a pose. `q`: encoder angles, rad; `wrench`: as it is measured.
fn welded<T: Real>(
    controller: &mut Cycle<'_, T>,
    pose: &Pose<T>,
    q: JointVector<T>,
    wrench: Wrench<T>,
) {
    // W as the tool stands: y and z of the tool, which makes the depth axis the tool's own.
    let setpoint = Setpoint {
        pose: *pose,
        b_from_w: pose.rotation,
        force: Some(lit(18_000.0)),
        spindle_speed: lit(62.8),
    };
    let sensed = SensorReadings {
        encoder: q,
        encoder_rate: JointVector::zeros(),
        motor_torque: JointVector::zeros(),
        wrench,
    };
    let fault = controller(&setpoint, pose, &sensed);
    assert_eq!(fault, None, "a benchmark of the safe command would measure the wrong thing");
}

/// The costliest thing a compensation law does in a period: inverse kinematics, loads, forward
/// kinematics.
struct FakeTarget;

impl<T: Real> Compensator<T> for FakeTarget {
    fn reset(&mut self) {}

    fn demand(&mut self, robot: &Robot<T>, seen: &Observation<'_, T>) -> Result<Twist<T>, Fault> {
        let link = robot
            .inverse_near(seen.nominal, &seen.sensed.encoder)
            .map_err(|_| Fault::Compensation)?;
        Ok(seen.demand_for(robot, &robot.fake_target(&link, &seen.sensed.wrench)))
    }
}

fn all(criterion: &mut Criterion) {
    algorithms::<f64>(criterion, "f64");
    algorithms::<f32>(criterion, "f32");
    welding::<f64>(criterion, "f64");
    welding::<f32>(criterion, "f32");
}

criterion_group! {
    name = rigid_body;
    config = short_runs();
    targets = all
}
criterion_main!(rigid_body);
