//! Time per call of the core's algorithms beside the crate `dynibo` on the same arm and the same
//! states. Before anything is timed, both engines must agree on all 1024 states, so that equal work
//! is compared. `docs/speed.md` says how to read it.

#[allow(dead_code, reason = "what a weld adds is timed by the core's own benchmark")]
#[path = "../../../core-nostd/benches/support/mod.rs"]
mod support;

use core::hint::black_box;
use criterion::{Criterion, criterion_group, criterion_main};
use support::{GRAVITY, STATES, States, algorithms, arm, short_runs, time};
use trueweld_core::{JOINTS, JointVector, Wrench};

/// Relative agreement asked of the engines before they are timed.
const AGREEMENT: f64 = 1e-9;

/// dynibo on the same states, after both engines were seen to agree.
fn peer(criterion: &mut Criterion) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/robots/arm6.urdf");
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
}

criterion_group! {
    name = rigid_body;
    config = short_runs();
    targets = all
}
criterion_main!(rigid_body);
