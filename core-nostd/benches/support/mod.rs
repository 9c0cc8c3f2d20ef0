//! The arm of `fixtures/robots/arm6.urdf` as this project's parameters, the random states of the
//! benchmarks, and the algorithms that are timed on them, beside those of peers too.

use core::hint::black_box;
use criterion::Criterion;
use nalgebra::{Matrix3, Vector3};
use trueweld_core::ldlt::Ldlt;
use trueweld_core::scalar::lit;
use trueweld_core::{
    Counterbalance, Friction, JOINTS, JointParameters, JointVector, Real, Robot, RobotParameters,
    ToolParameters, Wrench,
};

/// States cycled through, enough that branch prediction and caches see no repetition.
pub(crate) const STATES: usize = 1024;

/// Acceleration of gravity, m/s², as the peer `dynibo` has it built in.
pub(crate) const GRAVITY: f64 = 9.80665;

/// A pose with the tool down, away from singularities.
pub(crate) const WORK: [f64; JOINTS] = [0.2, -0.6, 0.9, 0.3, 0.8, -0.4];

/// Pitch of the tool in the last link, rad.
const TOOL_PITCH: f64 = core::f64::consts::FRAC_PI_4;

fn vector<T: Real>(v: [f64; 3]) -> Vector3<T> {
    Vector3::from(v.map(lit))
}

/// Axis, origin, mass, centre of mass, principal moments of each link, as the URDF has them.
type LinkRow = ([f64; 3], [f64; 3], f64, [f64; 3], [f64; 3]);

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];

const LINKS: [LinkRow; JOINTS] = [
    (Z, [0.0, 0.0, 0.675], 900.0, [0.2, 0.0, 0.15], [90.0, 110.0, 100.0]),
    (Y, [0.5, 0.0, 0.37], 550.0, [0.0, -0.1, 0.6], [95.0, 90.0, 20.0]),
    (Y, [0.0, 0.0, 1.3], 600.0, [0.3, 0.0, 0.1], [30.0, 120.0, 115.0]),
    (X, [1.025, 0.0, -0.055], 120.0, [0.15, 0.0, 0.0], [2.0, 6.0, 6.0]),
    (Y, [0.25, 0.0, 0.0], 80.0, [0.1, 0.0, 0.0], [1.0, 2.0, 2.0]),
    (X, [0.29, 0.0, 0.0], 250.0, [0.25, 0.0, -0.1], [8.0, 15.0, 12.0]),
];

/// The arm. Stiffness, damping and rotors, which a URDF does not have, are of the size of a KR
/// 500's; the tool has no mass of its own, since the URDF counts it into the last link.
pub(crate) fn arm<T: Real>(gravity: f64) -> Robot<T> {
    let stiffness = [13e6, 15e6, 6.2e6, 0.5e6, 0.6e6, 0.4e6];
    let (s, c) = TOOL_PITCH.sin_cos();
    let parameters = RobotParameters {
        gravity: vector([0.0, 0.0, -gravity]),
        joints: core::array::from_fn(|i| joint(LINKS[i], stiffness[i])),
        friction: Friction {
            viscous: JointVector::zeros(),
            coulomb: JointVector::zeros(),
            smoothing: lit(1e-3),
        },
        counterbalance: Counterbalance {
            cosine: [-9000.0, -80.0, 290.0].into_iter().map(lit).collect(),
            ..Counterbalance::default()
        },
        tool: ToolParameters {
            flange_offset: Vector3::zeros(),
            mass: T::zero(),
            com_from_flange: Vector3::zeros(),
            inertia: Matrix3::zeros(),
            tcp_from_flange: vector([0.4, 0.0, -0.15]),
            z_axis: vector([s, 0.0, c]),
            y_axis: vector(Y),
        },
    };
    Robot::new(parameters).expect("the benchmark's arm is a valid robot")
}

/// A joint with its link. `stiffness`: N·m/rad.
fn joint<T: Real>(
    (axis, origin, mass, com, moments): LinkRow,
    stiffness: f64,
) -> JointParameters<T> {
    JointParameters {
        origin: vector(origin),
        axis: vector(axis),
        limits: [lit(-6.0), lit(6.0)],
        max_rate: lit(10.0),
        max_torque: lit(1e6),
        stiffness: lit(stiffness),
        damping: lit(1e-3 * stiffness),
        rotor_inertia: lit(1e-4 * stiffness),
        mass: lit(mass),
        center_of_mass: vector(com),
        inertia: Matrix3::from_diagonal(&vector(moments)),
    }
}

/// Xorshift, so that every engine and every run sees the same states.
pub(crate) struct Random(u64);

impl Random {
    /// The one seed of the benchmarks.
    pub(crate) fn new() -> Self {
        Self(88_172_645_463_325_252)
    }

    /// Uniform in [−1, 1).
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
    }

    /// `STATES` joint vectors, uniform within `size` of `center`.
    pub(crate) fn vectors(&mut self, center: [f64; JOINTS], size: f64) -> Vec<[f64; JOINTS]> {
        (0..STATES).map(|_| center.map(|c| c + size * self.next())).collect()
    }
}

/// The same vectors in the scalar of a benchmark.
pub(crate) fn converted<T: Real>(vectors: &[[f64; JOINTS]]) -> Vec<JointVector<T>> {
    vectors.iter().map(|v| JointVector::from(v.map(lit))).collect()
}

/// Random states as plain numbers: whole range for the algorithms, near `WORK` for what runs in a
/// weld.
pub(crate) struct States {
    pub(crate) q: Vec<[f64; JOINTS]>,
    pub(crate) v: Vec<[f64; JOINTS]>,
    pub(crate) a: Vec<[f64; JOINTS]>,
    pub(crate) torque: Vec<[f64; JOINTS]>,
    pub(crate) near_work: Vec<[f64; JOINTS]>,
}

impl States {
    pub(crate) fn new() -> Self {
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

/// Calls of a microsecond need no longer runs.
pub(crate) fn short_runs() -> Criterion {
    Criterion::default()
        .warm_up_time(core::time::Duration::from_millis(300))
        .measurement_time(core::time::Duration::from_secs(1))
}

/// Times `call` on state 0, 1, 2, … in turn.
pub(crate) fn time<R>(criterion: &mut Criterion, name: &str, mut call: impl FnMut(usize) -> R) {
    criterion.bench_function(name, |bencher| {
        let mut i = 0;
        bencher.iter(|| {
            i = (i + 1) % STATES;
            call(i)
        });
    });
}

/// The algorithms, each from joint angles.
pub(crate) fn algorithms<T: Real>(criterion: &mut Criterion, scalar: &str) {
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
