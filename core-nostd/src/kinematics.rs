//! Forward kinematics: where every link frame and the tool are, for given joint angles, and how
//! fast the tool moves.
//!
//! [`Frames`] is computed once per configuration and handed to the Jacobian, RNEA and CRBA, which
//! share it.

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

/// Small rigid motions that a real structure adds to the ideal chain: the base on its foot, and
/// each link on its bearing.
#[derive(Debug, Clone, Copy)]
pub struct Displacement<T: Real> {
    /// Pose of the arm's ideal base frame in B; identity for a rigid foot.
    pub base: Pose<T>,
    /// Extra rotation of each link about its frame's origin, as a rotation vector in link axes,
    /// rad.
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
        self.all_frames(q, &Pose::identity(), None)
    }

    /// Forward kinematics with the base and the links displaced by small rotations.
    pub fn frames_displaced(&self, q: &JointVector<T>, by: &Displacement<T>) -> Frames<T> {
        self.all_frames(q, &by.base, Some(&by.tilt))
    }

    /// Tool pose `b_from_t` at joint angles `q`, rad.
    #[inline]
    pub fn forward_kinematics(&self, q: &JointVector<T>) -> Pose<T> {
        let turns = sines_and_cosines(q);
        let mut link = Pose::identity();
        for (i, turn) in turns.into_iter().enumerate() {
            link = self.next_link(i, &link, turn);
        }
        link * self.a6_from_t
    }

    #[inline(always)]
    fn all_frames(
        &self,
        q: &JointVector<T>,
        base: &Pose<T>,
        tilt: Option<&[Vector3<T>; JOINTS]>,
    ) -> Frames<T> {
        let turns = sines_and_cosines(q);
        let mut frames = Frames {
            rotation: [Matrix3::zeros(); JOINTS],
            origin: [Vector3::zeros(); JOINTS],
            axis: [Vector3::zeros(); JOINTS],
            tcp: Pose::identity(),
        };
        let mut link = *base;
        for (i, turn) in turns.into_iter().enumerate() {
            link = self.next_link(i, &link, turn);
            if let Some(tilt) = tilt {
                link.rotation *= rotation_from_vector(&tilt[i]);
            }
            frames.rotation[i] = link.rotation;
            frames.origin[i] = link.position;
            frames.axis[i] = self.axes[i].direction(&link.rotation);
        }
        frames.tcp = link * self.a6_from_t;
        frames
    }

    /// Pose of link `i` from its parent's and the sine and cosine of its joint angle.
    #[inline(always)]
    fn next_link(&self, i: usize, parent: &Pose<T>, (s, c): (T, T)) -> Pose<T> {
        Pose {
            rotation: self.axes[i].turn(&parent.rotation, s, c),
            position: parent.transform_point(&self.parameters.joints[i].origin),
        }
    }
}

/// Of all joint angles at once: a call amid the chain would throw the running frame out of the
/// registers.
#[inline(always)]
fn sines_and_cosines<T: Real>(q: &JointVector<T>) -> [(T, T); JOINTS] {
    let mut turns = [(T::zero(), T::one()); JOINTS];
    for (turn, angle) in turns.iter_mut().zip(q.iter()) {
        *turn = angle.sin_cos();
    }
    turns
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
