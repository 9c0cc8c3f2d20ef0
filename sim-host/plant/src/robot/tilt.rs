//! Bearings and base that give, in motion: a spring in series with those of the joints.
//!
//! With tilts φ about the frames that give, compliances C, and the inertia L = M_φθ that couples
//! them to the joints, the arm moves by
//!
//! ```text
//! M θ̈ + Lᵀ φ̈ + b = τ_s(θ_E − θ),    β = θ + P φ,    P = M⁻¹ Lᵀ,    φ = −C (L β̈ + n + R φ̈)
//! ⇒  M β̈ + b = τ_s(θ_E − β + u),    u = P φ = −Q (τ_s − b) − w − P C R φ̈,    Q = P C Pᵀ,   w = P C n
//! ```
//!
//! where n is the moment at the tilts without acceleration, and R = M_φφ − L P the inertia of what
//! no joint can follow. Its modes lie far above the joints', so that it follows their swing,
//!
//! ```text
//! φ̈ ≈ −C L s,    s = β⁗ = M⁻¹ K (1 + Q K)⁻¹ (θ̈_E − β̈),
//! ```
//!
//! and makes the tilt larger by the square of the ratio of the frequencies, some percent. Left out:
//! its own swing, and the inertia between several frames that give.

use super::{Drives, ElasticRobot, TiltMotion};
use nalgebra::{Matrix3, Matrix3x6, Matrix6, SMatrix, Vector3};
use trueweld_core::ldlt::Ldlt;
use trueweld_core::{Frames, JOINTS, JointVector, Wrench};

/// The series spring at one posture, linear in the joints' torques.
#[derive(Debug, Clone, Copy)]
pub struct Tilts {
    /// Q with what the inertia R adds to it, rad/(N·m).
    compliance: Matrix6<f64>,
    /// u where the springs carry nothing, rad.
    rest: JointVector<f64>,
    /// u where nothing accelerates, rad: −w.
    still: JointVector<f64>,
    /// (1 + Q K)⁻¹.
    relaxed: Matrix6<f64>,
    /// −C R φ̈ of each frame, the foot's last, by θ̈_E − β̈, s²; in axes of B.
    swing: [Matrix3x6<f64>; JOINTS + 1],
}

/// How an arm moves at one instant.
#[derive(Debug, Clone, Copy)]
pub struct JointMotion {
    /// The real joints.
    pub joints: Drives,
    /// Their spring torque τ_s, N·m.
    pub spring: JointVector<f64>,
    /// What bearings and base give to.
    pub tilts: TiltMotion,
}

impl JointMotion {
    /// Of an arm at β, `drives`; `None` where the state is not finite.
    pub fn new(
        robot: &ElasticRobot,
        frames: &Frames<f64>,
        (drives, motor_acceleration): (&Drives, &JointVector<f64>),
        internal: &[f64],
        wrench: &Wrench<f64>,
    ) -> Option<Self> {
        let (inertia, bias) = robot.model.equation_of_motion(frames, &drives.link_rate, wrench);
        let (factor, bias) = (Ldlt::new(inertia)?, bias - robot.link_torque(drives, internal));
        let rates = (&drives.link_rate, motor_acceleration);
        let tilts = Tilts::new(robot, frames, rates, wrench, (&factor, &bias));
        let joints = tilts
            .map_or(*drives, |tilts| tilts.joints(robot, drives, internal, &mut tilts.at_rest()));
        let spring = robot.spring_torque(&joints, internal);
        let acceleration = factor.solve(&(spring - bias));
        let moves =
            |tilts: Tilts| tilts.motion(&drives.link_rate, &acceleration, motor_acceleration);
        let still = TiltMotion { rate: drives.link_rate, acceleration, ..TiltMotion::default() };
        Some(Self { joints, spring, tilts: tilts.map_or(still, moves) })
    }

    /// β of an arm that stands, with its real joints at `link`, rad; `None` as above.
    pub fn standing(robot: &ElasticRobot, link: &JointVector<f64>) -> Option<JointVector<f64>> {
        let (frames, none) = (robot.model.frames(link), JointVector::zeros());
        let (inertia, bias) = robot.model.equation_of_motion(&frames, &none, &Wrench::zero());
        let factor = Ldlt::new(inertia)?;
        let tilts = Tilts::new(robot, &frames, (&none, &none), &Wrench::zero(), (&factor, &bias));
        Some(link + tilts.map_or(none, |tilts| tilts.at_rest()))
    }
}

impl Tilts {
    /// The series spring of a robot whose bearings or base give; `None` where none does, or where
    /// the state is not finite. `rate`: β̇, rad/s; `motor_acceleration`: θ̈_E, rad/s²; `inertia` and
    /// `bias`: factor of M, and b without the springs, N·m.
    pub fn new(
        robot: &ElasticRobot,
        frames: &Frames<f64>,
        (rate, motor_acceleration): (&JointVector<f64>, &JointVector<f64>),
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
        // P C R C Pᵀ.
        let mut swung = Matrix6::zeros();
        let mut swing = [Matrix3x6::zeros(); JOINTS + 1];
        let mut add =
            |frame: usize,
             c: Matrix3<f64>,
             moment: &dyn Fn(&[Wrench<f64>; JOINTS]) -> Vector3<f64>| {
                let rest = moment(&still);
                let coupling =
                    Matrix3x6::from_fn(|r, j| moment(&accelerated[j])[r] - rest[r]).transpose();
                let mut p = SMatrix::<f64, 6, 3>::zeros();
                for k in 0..3 {
                    p.set_column(k, &inertia.solve(&coupling.column(k).into_owned()));
                }
                compliance += p * c * p.transpose();
                let about = if frame < JOINTS { frames.origin[frame] } else { Vector3::zeros() };
                let whole = robot.model.composite_inertia(frames, frame % JOINTS, &about);
                let more = c * (whole - coupling.transpose() * p) * c;
                swung += p * more * p.transpose();
                swing[frame] = more * coupling.transpose();
                turned += p * (c * moment(&moving));
            };
        for i in 0..JOINTS {
            if !ports.link_frame[i].is_empty() {
                let (axis, turn) = (robot.model.parameters().joints[i].axis, frames.rotation[i]);
                let c = per_moment(|m| ports.link_frame[i].iter().map(|t| t.tilt(m, &axis)).sum());
                add(i, turn * c * turn.transpose(), &|loads| loads[i].moment);
            }
        }
        if !ports.base_frame.is_empty() {
            let none = Vector3::zeros();
            let c = per_moment(|m| ports.base_frame.iter().map(|t| t.tilt(m, &none)).sum());
            let origin = frames.origin[0];
            add(JOINTS, c, &|loads| loads[0].moment + origin.cross(&loads[0].force));
        }
        let stiffness = Matrix6::from_diagonal(robot.model.stiffness());
        // s by θ̈_E − β̈ is M⁻¹ times this.
        let softer = stiffness * (Matrix6::identity() + compliance * stiffness).try_inverse()?;
        let solved = |m: &Matrix6<f64>| {
            let column = |k| inertia.solve(&m.column(k).into_owned());
            Matrix6::from_columns(&[0, 1, 2, 3, 4, 5].map(column))
        };
        let by_motors = swung * softer;
        let snap = solved(&softer);
        swing.iter_mut().for_each(|s| *s *= snap);
        compliance += by_motors * solved(&Matrix6::identity());
        let relaxed = (Matrix6::identity() + compliance * stiffness).try_inverse()?;
        let rest = compliance * bias - turned + by_motors * motor_acceleration;
        Some(Self { compliance, rest, still: -turned, relaxed, swing })
    }

    /// What the frames give to where an arm moves with β̇, rad/s, and β̈, and its motors with θ̈_E,
    /// rad/s².
    pub fn motion(
        &self,
        rate: &JointVector<f64>,
        acceleration: &JointVector<f64>,
        motor_acceleration: &JointVector<f64>,
    ) -> TiltMotion {
        let swing = self.swing.map(|s| s * (motor_acceleration - acceleration));
        TiltMotion { rate: *rate, acceleration: *acceleration, swing }
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
        for _ in 0..TILT_ITERATIONS {
            joints.link = drives.link - *u;
            let torque = robot.spring_torque(&joints, internal);
            *u += self.relaxed * (self.rest - self.compliance * torque - *u);
        }
        joints.link = drives.link - *u;
        joints
    }
}

/// Newton's steps towards u: one suffices for springs that are straight.
const TILT_ITERATIONS: usize = 2;

/// Tilt per moment of what gives in proportion.
fn per_moment(tilt: impl Fn(&Vector3<f64>) -> Vector3<f64>) -> Matrix3<f64> {
    let none = tilt(&Vector3::zeros());
    let mut per_moment = Matrix3::zeros();
    for k in 0..3 {
        per_moment.set_column(k, &(tilt(&Vector3::ith(k, 1.0)) - none));
    }
    per_moment
}
