//! Forward kinematics: where every link frame and the tool are, for given joint angles, and how fast the tool moves.
//!
//! [`Frames`] is computed once per configuration and handed to the Jacobian, RNEA and CRBA, which share it.

use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real};
use crate::spatial::{Pose, Twist, rotation_from_vector};
use nalgebra::{Matrix3, Vector3};

/// All frames of the arm at one configuration, in axes of B.
#[derive(Debug, Clone, Copy)]
pub struct Frames<T: Real> {
    /// Link frame orientations, `b_from_link`.
    pub rotation: [Matrix3<T>; JOINTS],
    /// Link frame origins, m.
    pub origin: [Vector3<T>; JOINTS],
    /// Joint axes, unit vectors.
    pub axis: [Vector3<T>; JOINTS],
    /// The tool frame T, `b_from_t`; its origin is the TCP.
    pub tcp: Pose<T>,
}

/// Small rigid motions that a real structure adds to the ideal chain: the base on its foot, and each link on its
/// bearing.
#[derive(Debug, Clone, Copy)]
pub struct Displacement<T: Real> {
    /// Pose of the arm's ideal base frame in B; identity for a rigid foot.
    pub base: Pose<T>,
    /// Extra rotation of each link about its frame's origin, as a rotation vector in link axes, rad.
    pub tilt: [Vector3<T>; JOINTS],
}

impl<T: Real> Displacement<T> {
    /// The ideal chain: nothing displaced.
    pub fn none() -> Self {
        Self { base: Pose::identity(), tilt: [Vector3::zeros(); JOINTS] }
    }
}

impl<T: Real> Robot<T> {
    /// Forward kinematics of the ideal chain at joint angles `q`, rad.
    #[inline]
    pub fn frames(&self, q: &JointVector<T>) -> Frames<T> {
        self.chain(q, &Pose::identity(), |_, rotation| rotation)
    }

    /// Forward kinematics with the base and the links displaced by small rotations.
    pub fn frames_displaced(&self, q: &JointVector<T>, by: &Displacement<T>) -> Frames<T> {
        self.chain(q, &by.base, |i, rotation| rotation * rotation_from_vector(&by.tilt[i]))
    }

    /// Tool pose `b_from_t` at joint angles `q`, rad.
    #[inline]
    pub fn forward(&self, q: &JointVector<T>) -> Pose<T> {
        self.frames(q).tcp
    }

    #[inline(always)]
    fn chain(&self, q: &JointVector<T>, base: &Pose<T>, tilted: impl Fn(usize, Matrix3<T>) -> Matrix3<T>) -> Frames<T> {
        let mut frames = Frames {
            rotation: [Matrix3::zeros(); JOINTS],
            origin: [Vector3::zeros(); JOINTS],
            axis: [Vector3::zeros(); JOINTS],
            tcp: Pose::identity(),
        };
        let (mut parent, mut origin) = (base.rotation, base.position);
        for i in 0..JOINTS {
            let joint = &self.parameters.joints[i];
            origin += parent * joint.origin;
            let (s, c) = q[i].sin_cos();
            parent = tilted(i, rotated_about(&parent, &joint.axis, s, c));
            frames.rotation[i] = parent;
            frames.origin[i] = origin;
            frames.axis[i] = parent * joint.axis;
        }
        frames.tcp =
            Pose { rotation: parent * self.a6_from_t.rotation, position: origin + parent * self.a6_from_t.position };
        frames
    }
}

/// `parent` · R(axis, angle) by Rodrigues' formula, from the angle's sine and cosine.
#[inline(always)]
fn rotated_about<T: Real>(parent: &Matrix3<T>, axis: &Vector3<T>, s: T, c: T) -> Matrix3<T> {
    let v = T::one() - c;
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let (vx, vy, vz) = (v * x, v * y, v * z);
    let (sx, sy, sz) = (s * x, s * y, s * z);
    let rotation = Matrix3::new(
        vx * x + c,
        vx * y - sz,
        vx * z + sy,
        vx * y + sz,
        vy * y + c,
        vy * z - sx,
        vx * z - sy,
        vy * z + sx,
        vz * z + c,
    );
    parent * rotation
}

impl<T: Real> Frames<T> {
    /// Velocity of T at the TCP, in axes of B, for joint rates `rate`, rad/s: `J(q) q̇`.
    pub fn twist(&self, rate: &JointVector<T>) -> Twist<T> {
        let mut twist = Twist::zero();
        for i in 0..JOINTS {
            let spin = self.axis[i] * rate[i];
            twist.angular += spin;
            twist.linear += spin.cross(&(self.tcp.position - self.origin[i]));
        }
        twist
    }
}
