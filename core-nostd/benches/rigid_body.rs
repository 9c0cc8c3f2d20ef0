//! Time per call of the core's algorithms, beside the crate `dynibo` on the same arm and the same
//! states.
//!
//! Every call starts from joint angles: nothing is carried over from one state to the next. Before
//! anything is timed, both engines must agree on all 1024 states, so that equal work is compared.
//! `docs/speed.md` says how to read it.

mod support;

use core::hint::black_box;
use criterion::{Criterion, criterion_group, criterion_main};
use nalgebra::Vector3;
use support::{Random, STATES, arm, converted};
use trueweld_core::compensation::{Compensated, Compensator, LoopLimits, Observation};
use trueweld_core::control::{
    External, ExternalGains, ForceGains, HybridController, JointGains, Parallel, SensorReadings,
    Setpoint, Superposed,
};
use trueweld_core::ldlt::Ldlt;
use trueweld_core::scalar::lit;
use trueweld_core::{Fault, JOINTS, JointVector, Pose, Real, Robot, Twist, Wrench};

/// Acceleration of gravity that dynibo has built in, m/s².
const GRAVITY: f64 = 9.80665;

/// Relative agreement asked of the engines before they are timed.
const AGREEMENT: f64 = 1e-9;

/// A pose with the tool down, away from singularities.
const WORK: [f64; JOINTS] = [0.2, -0.6, 0.9, 0.3, 0.8, -0.4];

/// Control period, s.
const PERIOD: f64 = 0.012;

/// Random states as plain numbers: whole range for the algorithms, near `WORK` for what runs in a
/// weld.
struct States {
    q: Vec<[f64; JOINTS]>,
    v: Vec<[f64; JOINTS]>,
    a: Vec<[f64; JOINTS]>,
    torque: Vec<[f64; JOINTS]>,
    near_work: Vec<[f64; JOINTS]>,
}

impl States {
    fn new() -> Self {
        let mut random = Random::new();
        let zero = [0.0; JOINTS];
        Self {
            q: random.vectors(zero, 2.5),
            v: random.vectors(zero, 1.0),
            a: random.vectors(zero, 2.0),
            torque: random.vectors(zero, 5000.0),
            near_work: random.vectors(WORK, 0.02),
        }
    }
}

/// Times `call` on state 0, 1, 2, … in turn.
fn time<R>(criterion: &mut Criterion, name: &str, mut call: impl FnMut(usize) -> R) {
    criterion.bench_function(name, |bencher| {
        let mut i = 0;
        bencher.iter(|| {
            i = (i + 1) % STATES;
            call(i)
        });
    });
}

/// The algorithms, each from joint angles.
fn algorithms<T: Real>(criterion: &mut Criterion, scalar: &str) {
    let robot = arm::<T>(GRAVITY);
    let robot = black_box(&robot);
    let states = States::new();
    let (q, v, a) =
        (converted::<T>(&states.q), converted::<T>(&states.v), converted::<T>(&states.a));
    let torque = converted::<T>(&states.torque);
    let none = Wrench::zero();
    time(criterion, &format!("{scalar}/six sine-cosine pairs"), |i| q[i].map(|x| x.sin_cos()));
    time(criterion, &format!("{scalar}/forward kinematics"), |i| robot.forward_kinematics(&q[i]));
    time(criterion, &format!("{scalar}/all frames"), |i| robot.frames(&q[i]));
    time(criterion, &format!("{scalar}/Jacobian"), |i| robot.frames(&q[i]).jacobian());
    time(criterion, &format!("{scalar}/gravity"), |i| robot.gravity_torque(&robot.frames(&q[i])));
    time(criterion, &format!("{scalar}/RNEA"), |i| {
        robot.rnea(&robot.frames(&q[i]), &v[i], &a[i], &none)
    });
    time(criterion, &format!("{scalar}/bias"), |i| {
        robot.nonlinear_effects(&robot.frames(&q[i]), &v[i])
    });
    time(criterion, &format!("{scalar}/CRBA"), |i| robot.crba(&robot.frames(&q[i])));
    time(criterion, &format!("{scalar}/CRBA, Cholesky, solve"), |i| {
        Ldlt::new(robot.crba(&robot.frames(&q[i]))).map(|m| m.solve(&torque[i]))
    });
    time(criterion, &format!("{scalar}/forward dynamics"), |i| {
        robot.forward_dynamics(&robot.frames(&q[i]), &v[i], &torque[i], &none)
    });
}

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

/// dynibo on the same states, after both engines were seen to agree.
fn peer(criterion: &mut Criterion) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../fixtures/robots/arm6.urdf");
    let mut robot = dynibo::Robot::from_urdf(path).expect("dynibo reads the benchmark's arm");
    let tcp = robot.link_id("tcp").expect("the arm has a tool");
    let states = States::new();
    agree(&mut robot, tcp, &states);
    let States { q, v, a, torque, .. } = states;
    let fails = "dynibo takes what it has just been checked with";
    time(criterion, "dynibo/forward kinematics", |i| {
        robot.forward_kinematics(&q[i], tcp).expect(fails)
    });
    let mut j = [0.0; JOINTS * JOINTS];
    time(criterion, "dynibo/Jacobian", |i| {
        robot.jacobian(&q[i], tcp, &mut j).expect(fails);
        black_box(&j);
    });
    let mut out = [0.0; JOINTS];
    time(criterion, "dynibo/gravity", |i| {
        robot.gravity(&q[i], &[], &mut out).expect(fails);
        black_box(&out);
    });
    time(criterion, "dynibo/RNEA", |i| {
        robot.inverse_dynamics(&q[i], &v[i], &a[i], &[], &mut out).expect(fails);
        black_box(&out);
    });
    time(criterion, "dynibo/bias", |i| {
        robot.inverse_dynamics(&q[i], &v[i], &[0.0; JOINTS], &[], &mut out).expect(fails);
        black_box(&out);
    });
    time(criterion, "dynibo/CRBA", |i| {
        robot.mass_matrix(&q[i], &mut j).expect(fails);
        black_box(&j);
    });
    time(criterion, "dynibo/forward dynamics", |i| {
        robot.forward_dynamics(&q[i], &v[i], &torque[i], &[], &mut out).expect(fails);
        black_box(&out);
    });
}

/// Panics where the two engines differ on any state.
fn agree(peer: &mut dynibo::Robot, tcp: dynibo::LinkId, states: &States) {
    let robot = arm::<f64>(GRAVITY);
    let fails = "dynibo takes any finite state";
    for i in 0..STATES {
        let vector = |v: &[f64; JOINTS]| JointVector::from(*v);
        let (q, v, a, torque) = (&states.q[i], &states.v[i], &states.a[i], &states.torque[i]);
        let frames = robot.frames(&vector(q));
        let none = Wrench::zero();

        let frame = peer.forward_kinematics(q, tcp).expect(fails);
        same("tool position", frames.tcp.position.as_slice(), frame.translation.vector.as_slice());
        let theirs = frame.rotation.to_rotation_matrix();
        same("tool rotation", frames.tcp.rotation.as_slice(), theirs.matrix().as_slice());

        let mut out = [0.0; JOINTS];
        peer.inverse_dynamics(q, v, a, &[], &mut out).expect(fails);
        same("RNEA", robot.rnea(&frames, &vector(v), &vector(a), &none).as_slice(), &out);
        peer.inverse_dynamics(q, v, &[0.0; JOINTS], &[], &mut out).expect(fails);
        same("bias", robot.nonlinear_effects(&frames, &vector(v)).as_slice(), &out);
        peer.gravity(q, &[], &mut out).expect(fails);
        same("gravity", robot.gravity_torque(&frames).as_slice(), &out);

        // M is symmetric: rows or columns make no difference.
        let mut m = [0.0; JOINTS * JOINTS];
        peer.mass_matrix(q, &mut m).expect(fails);
        same("mass matrix", robot.crba(&frames).as_slice(), &m);
        peer.forward_dynamics(q, v, torque, &[], &mut out).expect(fails);
        let ours = robot
            .forward_dynamics(&frames, &vector(v), &vector(torque), &none)
            .expect("M is definite");
        same("forward dynamics", ours.as_slice(), &out);
        peer.jacobian(q, tcp, &mut m).expect(fails);
        same("Jacobian", frames.jacobian().0.as_slice(), &m);
    }
}

/// Panics where numbers of the two engines differ.
fn same(what: &str, ours: &[f64], theirs: &[f64]) {
    let size = ours.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let off = ours.iter().zip(theirs).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
    assert!(
        ours.len() == theirs.len() && off <= AGREEMENT * size,
        "{what} differs: {ours:?} and {theirs:?}"
    );
}

fn all(criterion: &mut Criterion) {
    algorithms::<f64>(criterion, "f64");
    peer(criterion);
    algorithms::<f32>(criterion, "f32");
    welding::<f64>(criterion, "f64");
    welding::<f32>(criterion, "f32");
}

criterion_group! {
    name = rigid_body;
    config = Criterion::default()
        .warm_up_time(core::time::Duration::from_millis(300))
        .measurement_time(core::time::Duration::from_secs(1));
    targets = all
}
criterion_main!(rigid_body);
