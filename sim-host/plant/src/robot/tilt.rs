//! Bearings and base that give, in motion: a spring in series with those of the joints.
//!
//! With tilts φ about the frames that give, compliances C, and the inertia L = M_φθ that couples
//! them to the joints, the arm moves by
//!
//! ```text
//! M θ̈ + Lᵀ φ̈ + b = τ_s(θ_E − θ),    φ = −C (L β̈ + n),    β = θ + P φ,    P = M⁻¹ Lᵀ
//! ⇒  M β̈ + b = τ_s(θ_E − β + u),    u = P φ = −Q (τ_s − b) − w,    Q = P C Pᵀ,   w = P C n
//! ```
//!
//! where n is the moment at the tilts without acceleration. Left out: the inertia M_φφ − L P of what
//! no joint can follow, whose modes lie far above the joints'.

use super::{Drives, ElasticRobot};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, SMatrix, Vector3};
use trueweld_core::ldlt::Ldlt;
use trueweld_core::{Frames, JOINTS, JointVector, Wrench};

/// The series spring at one posture, linear in the joints' torques.
#[derive(Debug, Clone, Copy)]
pub struct Tilts {
    /// Q, rad/(N·m).
    compliance: Matrix6<f64>,
    /// u where the springs carry nothing, rad: Q b − w.
    rest: JointVector<f64>,
    /// u where nothing accelerates, rad: −w.
    still: JointVector<f64>,
    /// (1 + Q K)⁻¹.
    relaxed: Matrix6<f64>,
}

/// How an arm moves at one instant.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion {
    /// The real joints.
    pub joints: Drives,
    /// Their spring torque τ_s, N·m.
    pub spring: JointVector<f64>,
    /// β̈, rad/s².
    pub acceleration: JointVector<f64>,
}

impl JointMotion {
    /// Of an arm at β, `drives`; `None` where the state is not finite.
    pub fn new(
        robot: &ElasticRobot,
        frames: &Frames<f64>,
        drives: &Drives,
        internal: &[f64],
        wrench: &Wrench<f64>,
    ) -> Option<Self> {
        let (inertia, bias) = robot.model.equation_of_motion(frames, &drives.link_rate, wrench);
        let (factor, bias) = (Ldlt::new(inertia)?, bias - robot.link_torque(drives));
        let tilts = Tilts::new(robot, frames, &drives.link_rate, wrench, (&factor, &bias));
        let joints = tilts
            .map_or(*drives, |tilts| tilts.joints(robot, drives, internal, &mut tilts.at_rest()));
        let spring = robot.spring_torque(&joints, internal);
        Some(Self { joints, spring, acceleration: factor.solve(&(spring - bias)) })
    }

    /// β of an arm that stands, with its real joints at `link`, rad; `None` as above.
    pub fn standing(robot: &ElasticRobot, link: &JointVector<f64>) -> Option<JointVector<f64>> {
        let (frames, none) = (robot.model.frames(link), JointVector::zeros());
        let (inertia, bias) = robot.model.equation_of_motion(&frames, &none, &Wrench::zero());
        let factor = Ldlt::new(inertia)?;
        let tilts = Tilts::new(robot, &frames, &none, &Wrench::zero(), (&factor, &bias));
        Some(link + tilts.map_or(none, |tilts| tilts.at_rest()))
    }
}

impl Tilts {
    /// The series spring of a robot whose bearings or base give; `None` where none does, or where
    /// the state is not finite. `inertia` and `bias`: factor of M, and b without the springs, N·m.
    pub fn new(
        robot: &ElasticRobot,
        frames: &Frames<f64>,
        rate: &JointVector<f64>,
        wrench: &Wrench<f64>,
        (inertia, bias): (&Ldlt<f64>, &JointVector<f64>),
    ) -> Option<Self> {
        let ports = &robot.ports;
        if !ports.frames_give() {
            return None;
        }
        let none = JointVector::zeros();
        let loads = |rate: &JointVector<f64>, acceleration: &JointVector<f64>| {
            robot.model.joint_loads(frames, rate, acceleration, wrench)
        };
        let (moving, still) = (loads(rate, &none), loads(&none, &none));
        let one = |j: usize| JointVector::from_fn(|i, _| if i == j { 1.0 } else { 0.0 });
        let accelerated: [_; JOINTS] = std::array::from_fn(|j| loads(&none, &one(j)));
        let (mut compliance, mut turned) = (Matrix6::zeros(), JointVector::zeros());
        let mut add = |c: Matrix3<f64>, moment: &dyn Fn(&[Wrench<f64>; JOINTS]) -> Vector3<f64>| {
            let rest = moment(&still);
            let coupling =
                Matrix3x6::from_fn(|r, j| moment(&accelerated[j])[r] - rest[r]).transpose();
            let mut p = SMatrix::<f64, 6, 3>::zeros();
            for k in 0..3 {
                p.set_column(k, &inertia.solve(&coupling.column(k).into_owned()));
            }
            compliance += p * c * p.transpose();
            turned += p * (c * moment(&moving));
        };
        for i in 0..JOINTS {
            if !ports.link_frame[i].is_empty() {
                let (axis, turn) = (robot.model.parameters().joints[i].axis, frames.rotation[i]);
                let c = per_moment(|m| ports.link_frame[i].iter().map(|t| t.tilt(m, &axis)).sum());
                add(turn * c * turn.transpose(), &|loads| loads[i].moment);
            }
        }
        if !ports.base_frame.is_empty() {
            let none = Vector3::zeros();
            let c = per_moment(|m| ports.base_frame.iter().map(|t| t.tilt(m, &none)).sum());
            let origin = frames.origin[0];
            add(c, &|loads| loads[0].moment + origin.cross(&loads[0].force));
        }
        let stiffness = Matrix6::from_diagonal(robot.model.stiffness());
        let relaxed = (Matrix6::identity() + compliance * stiffness).try_inverse()?;
        Some(Self { compliance, rest: compliance * bias - turned, still: -turned, relaxed })
    }

    /// u where nothing accelerates, rad.
    pub fn at_rest(&self) -> JointVector<f64> {
        self.still
    }

    /// The real joints, θ, of an arm at β: `drives` with β and its rate as those of the links; near
    /// `u`, rad, which is brought up to date.
    pub fn joints(
        &self,
        robot: &ElasticRobot,
        drives: &Drives,
        internal: &[f64],
        u: &mut JointVector<f64>,
    ) -> Drives {
        let stiffness = robot.model.stiffness();
        // As far as the springs are straight.
        let rate = drives.motor_rate - drives.link_rate;
        let u_rate = -(self.relaxed * (self.compliance * stiffness.component_mul(&rate)));
        let mut joints = *drives;
        joints.link_rate -= u_rate;
        for _ in 0..ITERATIONS {
            joints.link = drives.link - *u;
            let torque = robot.spring_torque(&joints, internal);
            *u += self.relaxed * (self.rest - self.compliance * torque - *u);
        }
        joints.link = drives.link - *u;
        joints
    }
}

/// Newton's steps towards u: one suffices for springs that are straight.
const ITERATIONS: usize = 2;

/// Tilt per moment of what gives in proportion.
fn per_moment(tilt: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Matrix3<f64> {
    let none = tilt(&Vector3::zeros());
    let mut per_moment = Matrix3::zeros();
    for k in 0..3 {
        per_moment.set_column(k, &(tilt(&Vector3::ith(k, 1.0)) - none));
    }
    per_moment
}
