//! The immutable model of the arm: geometry, inertia, elasticity, drive ratings and tool.
//!
//! [`RobotParameters`] is what a file or a controller's flash holds; [`Robot`] is the checked model
//! built from it. What is left out: state, time, and everything the process or the sensors add.

use crate::axis::Axis;
use crate::counterbalance::Counterbalance;
use crate::error::ModelError;
use crate::inertia::{Bodies, Body};
use crate::scalar::{JOINTS, JointVector, Real, lit};
use nalgebra::{Matrix3, Vector3};

/// One joint, its drive, and the link it moves. Zero pose: with all angles 0 every link frame is
/// parallel to B.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointParameters<T: Real> {
    /// Origin of this joint's frame in the previous joint's frame, m.
    pub origin: Vector3<T>,
    /// Unit vector of the axis, in the link frame.
    pub axis: Vector3<T>,
    /// Lower and upper position limit, rad.
    pub limits: [T; 2],
    /// Largest joint speed, rad/s.
    pub max_rate: T,
    /// Largest drive torque, N·m, seen from the joint.
    pub max_torque: T,
    /// Stiffness K of the drive train, N·m/rad, seen from the joint.
    pub stiffness: T,
    /// Damping D of the drive train, N·m·s/rad.
    pub damping: T,
    /// Inertia I_m of motor and gear seen from the joint, kg·m².
    pub rotor_inertia: T,
    /// Mass of the link, kg.
    pub mass: T,
    /// Centre of mass in the link frame, m.
    pub center_of_mass: Vector3<T>,
    /// Inertia about the centre of mass, in axes of the link frame, kg·m².
    pub inertia: Matrix3<T>,
}

/// Motor-side friction, seen from the joint: τ_f = viscous·θ̇_E + coulomb·tanh(θ̇_E / smoothing).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction<T: Real> {
    /// Viscous coefficient, N·m·s/rad.
    pub viscous: JointVector<T>,
    /// Coulomb level, N·m.
    pub coulomb: JointVector<T>,
    /// Rate over which the Coulomb term turns round, rad/s.
    pub smoothing: T,
}

impl<T: Real> Friction<T> {
    /// Friction torque τ_f of joint `i` at an encoder rate, rad/s: N·m, and its slope by the rate,
    /// N·m·s/rad.
    #[inline]
    pub fn torque(&self, i: usize, rate: T) -> (T, T) {
        let (sign, slope) = smooth_sign(rate, self.smoothing);
        (self.viscous[i] * rate + self.coulomb[i] * sign, self.viscous[i] + self.coulomb[i] * slope)
    }
}

/// tanh(rate/smoothing), between −1 and 1, and its slope by the rate.
#[inline]
pub fn smooth_sign<T: Real>(rate: T, smoothing: T) -> (T, T) {
    // tanh(x) = 1 − 2/(e²ˣ + 1): absolute error 1e-16 in f64, at a third of the time of tanh.
    let (one, two) = (T::one(), lit::<T>(2.0));
    let value = one - two / ((two * rate / smoothing).exp() + one);
    (value, (one - value * value) / smoothing)
}

/// The rigid tool on the flange (frame F: at the flange's centre, axes of the A6 link).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToolParameters<T: Real> {
    /// Flange centre in the A6 frame, m.
    pub flange_offset: Vector3<T>,
    /// Mass, kg.
    pub mass: T,
    /// Centre of mass from the flange, m.
    pub com_from_flange: Vector3<T>,
    /// Inertia about its centre of mass, axes of the A6 link, kg·m².
    pub inertia: Matrix3<T>,
    /// Tool centre point from the flange, m.
    pub tcp_from_flange: Vector3<T>,
    /// z axis of the tool frame T (out of the tool), in axes of the A6 link.
    pub z_axis: Vector3<T>,
    /// y axis of the tool frame T, in axes of the A6 link.
    pub y_axis: Vector3<T>,
}

/// Everything a [`Robot`] is built from, SI units, angles in rad.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotParameters<T: Real> {
    /// Acceleration of gravity in B, m/s².
    pub gravity: Vector3<T>,
    /// The six joints, A1 first.
    pub joints: [JointParameters<T>; JOINTS],
    /// Friction on the motor side.
    pub friction: Friction<T>,
    /// Counterbalance of A2.
    pub counterbalance: Counterbalance<T>,
    /// The tool.
    pub tool: ToolParameters<T>,
}

/// The checked model of the arm. Build once with [`Robot::new`]; share by reference.
#[derive(Debug, Clone)]
pub struct Robot<T: Real> {
    pub(crate) parameters: RobotParameters<T>,
    /// How each joint turns its link.
    pub(crate) axes: [Axis<T>; JOINTS],
    /// Links about their frames' origins in link axes, with the tool merged into the last one.
    pub(crate) links: [Body<T>; JOINTS],
    /// The same, all links at once.
    pub(crate) bodies: Bodies<T>,
    /// Rotation of T in the A6 frame, and the TCP in it.
    pub(crate) a6_from_t: crate::spatial::Pose<T>,
    pub(crate) stiffness: JointVector<T>,
    pub(crate) damping: JointVector<T>,
    pub(crate) rotor_inertia: JointVector<T>,
    largest_tool_speed: T,
}

impl<T: Real> Robot<T> {
    /// Checks the parameters and builds the model.
    ///
    /// # Errors
    /// The first [`ModelError`] found, joint by joint.
    pub fn new(parameters: RobotParameters<T>) -> Result<Self, ModelError> {
        let tiny = lit::<T>(1e-6);
        if !crate::scalar::all_finite(parameters.gravity.iter()) {
            return Err(ModelError::NotFinite);
        }
        for (i, j) in parameters.joints.iter().enumerate() {
            let scalars = [
                j.limits[0],
                j.limits[1],
                j.max_rate,
                j.max_torque,
                j.stiffness,
                j.damping,
                j.rotor_inertia,
                j.mass,
            ];
            let vectors = j
                .origin
                .iter()
                .chain(j.axis.iter())
                .chain(j.center_of_mass.iter())
                .chain(j.inertia.iter());
            if !crate::scalar::all_finite(scalars.iter().chain(vectors)) {
                return Err(ModelError::NotFinite);
            }
            if (j.axis.norm() - T::one()).abs() > tiny {
                return Err(ModelError::AxisNotUnit(i));
            }
            if j.limits[0] >= j.limits[1] {
                return Err(ModelError::Limits(i));
            }
            if j.max_rate <= T::zero() || j.max_torque <= T::zero() {
                return Err(ModelError::Rating(i));
            }
            if j.stiffness <= T::zero() || j.rotor_inertia <= T::zero() || j.damping < T::zero() {
                return Err(ModelError::Drive(i));
            }
            if j.mass < T::zero() || !is_inertia(&j.inertia) {
                return Err(ModelError::Inertia(i));
            }
        }
        let f = &parameters.friction;
        if !crate::scalar::all_finite(
            f.viscous.iter().chain(f.coulomb.iter()).chain([&f.smoothing]),
        ) || !parameters.counterbalance.is_sound()
        {
            return Err(ModelError::NotFinite);
        }
        if f.smoothing <= T::zero()
            || f.viscous.iter().chain(f.coulomb.iter()).any(|v| *v < T::zero())
        {
            return Err(ModelError::Friction);
        }
        let t = &parameters.tool;
        let tool_numbers =
            t.flange_offset.iter().chain(t.com_from_flange.iter()).chain(t.inertia.iter());
        let tool_frame =
            t.tcp_from_flange.iter().chain(t.z_axis.iter()).chain(t.y_axis.iter()).chain([&t.mass]);
        if !crate::scalar::all_finite(tool_numbers.chain(tool_frame)) {
            return Err(ModelError::NotFinite);
        }
        if (t.z_axis.norm() - T::one()).abs() > tiny
            || (t.y_axis.norm() - T::one()).abs() > tiny
            || t.z_axis.dot(&t.y_axis).abs() > tiny
        {
            return Err(ModelError::ToolAxes);
        }
        if t.mass < T::zero() || !is_inertia(&t.inertia) {
            return Err(ModelError::ToolInertia);
        }

        let mut links =
            parameters.joints.each_ref().map(|j| Body::new(j.mass, &j.center_of_mass, &j.inertia));
        let tool = Body::new(t.mass, &(t.flange_offset + t.com_from_flange), &t.inertia);
        links[JOINTS - 1] = links[JOINTS - 1].merged(&tool);
        let last = &parameters.joints[JOINTS - 1].axis;
        if links[JOINTS - 1].about(last) <= T::zero() {
            return Err(ModelError::Massless);
        }
        // Exactly orthonormal from here on, whatever the file's last digit was.
        let z = t.z_axis.normalize();
        let y = (t.y_axis - z * z.dot(&t.y_axis)).normalize();
        let a6_from_t = crate::spatial::Pose {
            rotation: Matrix3::from_columns(&[y.cross(&z), y, z]),
            position: t.flange_offset + t.tcp_from_flange,
        };
        let stretched = (a6_from_t.position.norm(), T::zero());
        let (_, largest_tool_speed) =
            parameters.joints.iter().rev().fold(stretched, |(reach, speed), joint| {
                (reach + joint.origin.norm(), speed + joint.max_rate * reach)
            });
        Ok(Self {
            largest_tool_speed,
            stiffness: JointVector::from_fn(|i, _| parameters.joints[i].stiffness),
            damping: JointVector::from_fn(|i, _| parameters.joints[i].damping),
            rotor_inertia: JointVector::from_fn(|i, _| parameters.joints[i].rotor_inertia),
            axes: parameters.joints.each_ref().map(|j| Axis::new(&j.axis)),
            parameters,
            bodies: Bodies::new(&links),
            links,
            a6_from_t,
        })
    }

    /// What the model was built from.
    pub fn parameters(&self) -> &RobotParameters<T> {
        &self.parameters
    }

    /// Joint stiffness K, N·m/rad.
    pub fn stiffness(&self) -> &JointVector<T> {
        &self.stiffness
    }

    /// Joint damping D, N·m·s/rad.
    pub fn damping(&self) -> &JointVector<T> {
        &self.damping
    }

    /// Rotor inertia I_m seen from the joint, kg·m².
    pub fn rotor_inertia(&self) -> &JointVector<T> {
        &self.rotor_inertia
    }

    /// Counterbalance torque τ_cb(θ₂) on the A2 link, N·m.
    #[inline]
    pub fn counterbalance_torque(&self, q2: T) -> T {
        self.parameters.counterbalance.torque(q2)
    }

    /// First joint (0 = A1) outside its limits, if any.
    pub fn beyond_limits(&self, q: &JointVector<T>) -> Option<usize> {
        (0..JOINTS).find(|&i| {
            let [low, high] = self.parameters.joints[i].limits;
            !(q[i] >= low && q[i] <= high)
        })
    }

    /// What the tool's speed cannot exceed in any posture, m/s: every joint at its largest speed with
    /// the rest of the arm stretched out.
    pub fn largest_tool_speed(&self) -> T {
        self.largest_tool_speed
    }

    /// The same robot with every joint stiffness multiplied by its factor: a stiffness known with
    /// an error.
    ///
    /// # Errors
    /// [`ModelError::Drive`] where a factor is not positive.
    pub fn with_stiffness_scaled(&self, factor: &JointVector<T>) -> Result<Self, ModelError> {
        let mut parameters = self.parameters.clone();
        for (joint, f) in parameters.joints.iter_mut().zip(factor.iter()) {
            joint.stiffness *= *f;
        }
        Self::new(parameters)
    }
}

/// Symmetric, and no principal moment above the sum of the other two (with 1e-6 relative slack for
/// rounded files).
fn is_inertia<T: Real>(inertia: &Matrix3<T>) -> bool {
    let slack = inertia.amax() * lit(1e-6);
    if (inertia - inertia.transpose()).amax() > slack {
        return false;
    }
    let moments = crate::solve::symmetric_eigenvalues(inertia);
    let sum = inertia.trace();
    moments.iter().all(|m| *m >= -slack && *m + *m <= sum + slack * lit(4.0))
}
