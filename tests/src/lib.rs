//! What the tests share: the KR 500 MT of the fixtures in any scalar, the golden states of another
//! engine, random states within the arm's limits, and how answers over the corpus are judged.
//!
//! No test lives here, and nothing here computes what a test is to judge.

#[path = "../../sim-host/plant/tests/cell/support.rs"]
pub mod cell;
pub mod corpus;
pub mod identified;
pub mod mutation;
pub mod outside;
pub mod raw_files;
pub mod resonance;
#[path = "../../core-nostd/tests/algebra/support.rs"]
mod support;

pub use support::{cases, cast, number, pose_difference, seen, widen, wild, within, wrapped};

use nalgebra::{Matrix3, Matrix6, SVector, Vector3};
use proptest::prelude::*;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::LazyLock;
use trueweld_compensators::RobotNumbers;
use trueweld_core::control::{
    External, ExternalGains, ForceGains, HybridController, JointGains, Parallel, SensorReadings,
    Setpoint, Superposed,
};
use trueweld_core::{JOINTS, JointVector, Pose, Real, Robot, RobotParameters, Wrench};
use trueweld_laboratory::Laboratory;
use trueweld_plant::input::{InputFile, RobotFile};

/// The status of a program, with its error told.
pub fn ended(result: Result<(), Box<dyn std::error::Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

/// Path of a file below `fixtures/`.
pub fn fixture(relative: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../fixtures").join(relative)
}

/// The KR 500 MT with its end effector, in double precision, read once.
pub static KR500: LazyLock<Robot<f64>> = LazyLock::new(kr500);

/// The cell of the fixtures, to make campaigns of.
pub static LABORATORY: LazyLock<Laboratory> = LazyLock::new(|| {
    let read = Laboratory::read(
        fixture("robots/kr500-mt.toml"),
        fixture("processes/lap-weld-2024-t3.toml"),
        fixture("control/kr500-mt.toml"),
        fixture("sensors/kr500-mt.toml"),
    );
    read.expect("the fixtures are a cell")
});

/// The KR 500 MT of `fixtures/robots/kr500-mt.toml` in the scalar `T`.
///
/// # Panics
/// Where the fixture cannot be read or is not a robot.
pub fn kr500<T: Real>() -> Robot<T> {
    Robot::new(kr500_parameters()).expect("the fixture is a robot")
}

/// The parameters in `fixtures/robots/kr500-mt.toml`, every number rounded to `T` once.
///
/// # Panics
/// Where the fixture is not a robot.
pub fn kr500_parameters<T: Real>() -> RobotParameters<T> {
    let read = RobotFile::read(fixture("robots/kr500-mt.toml")).expect("the fixture is a robot");
    RobotNumbers::of(&read.parameters).parameters().expect("the fixture is a robot")
}

/// One state of `fixtures/golden/kr500-rigid.json`, computed by Pinocchio 4.1.0 from the same robot
/// file.
///
/// Base axes throughout, angular rows first. M, rnea, bias and gravity are the links and the tool
/// alone, without a wrench. The data settle what the file's conventions leave open: `wrench` is
/// (moment, force) on the tool at the TCP in axes of B, since Jᵀ times it in that order is
/// `wrench_torque` to 4e-12 N·m; and `forward_acceleration` answers `forward_torque` alone, with no
/// wrench, since it is M⁻¹(forward_torque − bias) to 1e-13 rad/s².
#[derive(Debug, Clone)]
pub struct GoldenState<T: Real> {
    /// Joint angles, rad.
    pub q: JointVector<T>,
    /// Joint rates, rad/s.
    pub v: JointVector<T>,
    /// Joint accelerations, rad/s².
    pub a: JointVector<T>,
    /// Tool pose `b_from_t`.
    pub tcp: Pose<T>,
    /// Jacobian of the TCP.
    pub jacobian: Matrix6<T>,
    /// Inertia matrix M(q), kg·m².
    pub mass_matrix: Matrix6<T>,
    /// M a + h + g, N·m.
    pub rnea: JointVector<T>,
    /// h + g, N·m.
    pub bias: JointVector<T>,
    /// g, N·m.
    pub gravity: JointVector<T>,
    /// A wrench on the tool at the TCP, axes of B.
    pub wrench: Wrench<T>,
    /// Jᵀ w, N·m.
    pub wrench_torque: JointVector<T>,
    /// Joint torques given to the forward dynamics, N·m.
    pub forward_torque: JointVector<T>,
    /// The acceleration they give at (q, v), rad/s².
    pub forward_acceleration: JointVector<T>,
}

/// All golden states, rounded to `T` once.
///
/// # Panics
/// Where the fixture cannot be read.
pub fn golden<T: Real>() -> Vec<GoldenState<T>> {
    use serde_json::Value;
    fn number<T: Real>(v: &Value) -> T {
        nalgebra::convert(v.as_f64().expect("a number"))
    }
    fn column<T: Real, const N: usize>(v: &Value) -> SVector<T, N> {
        SVector::from_fn(|i, _| number(&v[i]))
    }
    let text =
        std::fs::read_to_string(fixture("golden/kr500-rigid.json")).expect("the fixture is there");
    let file: Value = serde_json::from_str(&text).expect("the fixture is JSON");
    let states = file["states"].as_array().expect("a list");
    assert_eq!(states.len(), 24, "the fixture holds 24 states");
    states
        .iter()
        .map(|s| GoldenState {
            q: column(&s["q"]),
            v: column(&s["v"]),
            a: column(&s["a"]),
            tcp: Pose {
                rotation: Matrix3::from_fn(|i, j| number(&s["tcp_rotation"][i][j])),
                position: column(&s["tcp_position"]),
            },
            jacobian: Matrix6::from_fn(|i, j| number(&s["jacobian"][i][j])),
            mass_matrix: Matrix6::from_fn(|i, j| number(&s["mass_matrix"][i][j])),
            rnea: column(&s["rnea"]),
            bias: column(&s["bias"]),
            gravity: column(&s["gravity"]),
            wrench: Wrench::from_vector(&column(&s["wrench"])),
            wrench_torque: column(&s["wrench_torque"]),
            forward_torque: column(&s["forward_torque"]),
            forward_acceleration: column(&s["forward_acceleration"]),
        })
        .collect()
}

/// The same pose in another scalar, each number rounded once.
pub fn cast_pose<T: Real>(pose: &Pose<f64>) -> Pose<T> {
    Pose { rotation: cast(&pose.rotation), position: cast(&pose.position) }
}

/// The same wrench in another scalar, each number rounded once.
pub fn cast_wrench<T: Real>(wrench: &Wrench<f64>) -> Wrench<T> {
    Wrench { moment: cast(&wrench.moment), force: cast(&wrench.force) }
}

/// Largest entry of `measured − expected` over the largest entry of `expected`; over `floor` where
/// that is larger.
pub fn relative<T: Real, const R: usize, const C: usize>(
    measured: &nalgebra::SMatrix<T, R, C>,
    expected: &nalgebra::SMatrix<T, R, C>,
    floor: f64,
) -> f64 {
    (widen(measured) - widen(expected)).amax() / widen(expected).amax().max(floor)
}

/// Joint angles anywhere within the arm's limits but for the outermost thousandth, rad.
pub fn configuration() -> impl Strategy<Value = JointVector<f64>> {
    prop::array::uniform::<_, JOINTS>(0.001..=0.999_f64).prop_map(|share| {
        JointVector::from_fn(|i, _| {
            let [low, high] = KR500.parameters().joints[i].limits;
            low + share[i] * (high - low)
        })
    })
}

/// Joint angles within the limits and away from what makes the Jacobian bad: |sin A5| above 0.2,
/// the elbow at least 0.2 rad from stretched or folded, and the wrist centre 0.3 m or more from
/// axis A1.
pub fn regular_configuration() -> impl Strategy<Value = JointVector<f64>> {
    configuration().prop_filter("near a singularity", |q| {
        let frames = KR500.frames(q);
        let wrist = frames.origin[4];
        let reach = (wrist - frames.origin[1]).norm();
        let upper = (frames.origin[2] - frames.origin[1]).norm();
        let fore = (wrist - frames.origin[2]).norm();
        // Law of cosines: how far the elbow is from stretched or folded.
        let cosine = (reach * reach - upper * upper - fore * fore) / (2.0 * upper * fore);
        q[4].sin().abs() > 0.2 && cosine.abs() < 0.2_f64.cos() && wrist.xy().norm() > 0.3
    })
}

/// Joint rates within the arm's limits, rad/s.
pub fn rate() -> impl Strategy<Value = JointVector<f64>> {
    within(JointVector::from_fn(|i, _| KR500.parameters().joints[i].max_rate))
}

/// Joint accelerations up to 5 rad/s².
pub fn acceleration() -> impl Strategy<Value = JointVector<f64>> {
    within(JointVector::repeat(5.0))
}

/// A wrench of welding size: up to 500 N·m and 18 kN about and along every axis.
pub fn wrench() -> impl Strategy<Value = Wrench<f64>> {
    within(SVector::from([500.0, 500.0, 500.0, 18e3, 18e3, 18e3]))
        .prop_map(|w| Wrench::from_vector(&w))
}

/// What the published weld puts on the tool at 18 kN depth, 4 kN along and 1 kN across, in axes of
/// T, whose z points out of the tool into the material: the material pushes back along −z.
pub fn weld_wrench() -> Wrench<f64> {
    Wrench { moment: Vector3::zeros(), force: Vector3::new(-4e3, 1e3, -18e3) }
}

/// Tool pose at a point of the first published weld (vertical tool): x along the weld, z into the
/// material.
pub fn vertical_weld_pose(y: f64) -> Pose<f64> {
    // x = +Y of B (the feed), z = −Z of B, y = z × x.
    let (x, z) = (Vector3::y(), -Vector3::z());
    Pose {
        rotation: Matrix3::from_columns(&[x, z.cross(&x), z]),
        position: Vector3::new(1.7, y, 0.5),
    }
}

/// Control period of the published controller, s.
pub const PERIOD: f64 = 0.012;

/// Gains of the joint loop, in the proportions of the springs. Not tuned: what is tested with them
/// holds for any.
pub fn joint_gains<T: Real>() -> JointGains<T> {
    let stiffness = KR500.stiffness();
    JointGains {
        kp: cast(&(stiffness * 0.2)),
        ki: cast(&(stiffness * 0.4)),
        kd: cast(&(stiffness * 0.02)),
    }
}

/// Gains of the force branch of the parallel and the superposed scheme. Not tuned.
pub fn force_gains<T: Real>() -> ForceGains<T> {
    let [kp, ki, kd, max_correction, max_rate] = [0.3, 5.0, 2e4, 8e3, 5e5].map(nalgebra::convert);
    ForceGains { kp, ki, kd, max_correction, max_rate }
}

/// Gains of the outer loop of the external scheme. Not tuned.
pub fn external_gains<T: Real>() -> ExternalGains<T> {
    let [kp, ki, kd, max_correction, max_rate] =
        [2e-8, 5e-7, 1e-3, 0.02, 0.05].map(nalgebra::convert);
    let [material_stiffness, tuned_stiffness] = [30e6, 5e6].map(nalgebra::convert);
    ExternalGains { kp, ki, kd, material_stiffness, tuned_stiffness, max_correction, max_rate }
}

/// Any of the three published controllers.
pub type AnyController<T> = Box<dyn HybridController<T>>;

/// The three published controllers at [`PERIOD`], by name.
pub fn controllers<T: Real>() -> [(&'static str, AnyController<T>); 3] {
    let (joint, force, period) = (joint_gains(), force_gains(), nalgebra::convert(PERIOD));
    [
        ("parallel", Box::new(Parallel::new(joint, force, period))),
        ("superposed", Box::new(Superposed::new(joint, force, period))),
        ("external", Box::new(External::new(joint, external_gains(), period))),
    ]
}

/// Motor torque that carries the arm at rest with nothing at the tool: gravity less counterbalance,
/// N·m.
pub fn weight<T: Real>(robot: &Robot<T>, q: &JointVector<T>) -> JointVector<T> {
    let mut torque = robot.gravity_torque(&robot.frames(q));
    torque[1] -= robot.counterbalance_torque(q[1]);
    torque
}

/// A set-point at the tool pose of `q`, W in line with the tool.
pub fn setpoint_at<T: Real>(robot: &Robot<T>, q: &JointVector<T>, force: Option<T>) -> Setpoint<T> {
    let pose = robot.forward_kinematics(q);
    Setpoint { pose, b_from_w: pose.rotation, force, spindle_speed: T::zero() }
}

/// Instruments of an arm at rest at `q` with `wrench` at the tool, in axes of T.
pub fn sensed_at<T: Real>(
    robot: &Robot<T>,
    q: &JointVector<T>,
    wrench: &Wrench<T>,
) -> SensorReadings<T> {
    SensorReadings {
        encoder: *q,
        encoder_rate: JointVector::zeros(),
        motor_torque: weight(robot, q),
        wrench: *wrench,
    }
}

/// How many numbers [`spoil`] can reach.
pub const PLACES: usize = 47;

/// Overwrites one number of what a controller is given: 0–5 encoders, 6–11 rates, 12–17 motor
/// torques, 18–23 wrench (moment, force), 24–32 and 33–35 set-point rotation and position, 36–44
/// weld frame, 45 force, 46 spindle.
pub fn spoil(
    setpoint: &mut Setpoint<f64>,
    sensed: &mut SensorReadings<f64>,
    place: usize,
    value: f64,
) {
    match place {
        0..6 => sensed.encoder[place] = value,
        6..12 => sensed.encoder_rate[place - 6] = value,
        12..18 => sensed.motor_torque[place - 12] = value,
        18..21 => sensed.wrench.moment[place - 18] = value,
        21..24 => sensed.wrench.force[place - 21] = value,
        24..33 => setpoint.pose.rotation[place - 24] = value,
        33..36 => setpoint.pose.position[place - 33] = value,
        36..45 => setpoint.b_from_w[place - 36] = value,
        45 => setpoint.force = Some(value),
        _ => setpoint.spindle_speed = value,
    }
}
