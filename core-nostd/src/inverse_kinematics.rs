//! Inverse kinematics: closed form for an arm with a decoupled wrist, all eight branches and branch
//! tracking; for any other arm by Newton's method from joint angles nearby.
//!
//! The family that the closed form covers: A1 vertical (±z), A2 ∥ A3 horizontal (±y), then A4 ±x, A5 ±y, A6 ±x meeting
//! in one point, at the zero pose where all link frames are parallel. Offsets along and across the
//! arm are free. Shoulder and elbow follow from the wrist centre (a two-link arm in the plane of
//! A1), the wrist from the rotation that is left (R_x R_y R_x Euler angles). Source: Pieper 1968;
//! Siciliano et al., Robotics, 2009, 2.12.

use crate::error::KinematicsError;
use crate::ldlt::Ldlt;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real, lit};
use crate::spatial::Pose;
use nalgebra::{Matrix3, Vector3};

/// Which of the eight solutions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Branch {
    /// The wrist centre is behind axis A1: the arm reaches over its own shoulder.
    pub shoulder_back: bool,
    /// The elbow is on the other side of the line from A2 to the wrist centre.
    pub elbow_flipped: bool,
    /// The A5 rotation is negative instead of positive (A4 and A6 turned by half a turn).
    pub wrist_flipped: bool,
}

impl Branch {
    /// All eight branches.
    pub const ALL: [Self; 8] = {
        let mut all =
            [Self { shoulder_back: false, elbow_flipped: false, wrist_flipped: false }; 8];
        let mut i = 0;
        while i < 8 {
            all[i] = Self {
                shoulder_back: i & 4 != 0,
                elbow_flipped: i & 2 != 0,
                wrist_flipped: i & 1 != 0,
            };
            i += 1;
        }
        all
    };
}

/// Geometry of the decoupled arm, in the plane of A1: what the closed form needs.
#[derive(Debug, Clone, Copy)]
struct Decoupled<T: Real> {
    /// +1 or −1: sense of each axis against +z, +y, +y, +x, +y, +x.
    sense: JointVector<T>,
    /// Origin of A1 in B.
    foot: Vector3<T>,
    /// A2 from A1 (x, z).
    shoulder: [T; 2],
    /// A3 from A2 (x, z).
    upper: [T; 2],
    /// Wrist centre from A3 (x, z).
    fore: [T; 2],
    /// Distance of the wrist centre from the plane through A1, along y.
    lateral: T,
    /// TCP from the wrist centre, axes of A6.
    tool: Vector3<T>,
}

impl<T: Real> Robot<T> {
    /// Joint angles of one branch for the tool pose `b_from_t`, each in [−π, π).
    ///
    /// # Errors
    /// [`KinematicsError::NotDecoupled`], [`Unreachable`](KinematicsError::Unreachable),
    /// [`Singular`](KinematicsError::Singular) within 1e-6 rad of A4 ∥ A6 (in `f32` 4e-6),
    /// [`NotFinite`](KinematicsError::NotFinite).
    /// Joint limits are not checked; [`inverse_near`](Self::inverse_near) checks them.
    pub fn inverse_kinematics(
        &self,
        b_from_t: &Pose<T>,
        branch: Branch,
    ) -> Result<JointVector<T>, KinematicsError> {
        self.solve(b_from_t, branch, None)
    }

    /// All branches that exist for the tool pose, with their joint angles.
    ///
    /// # Errors
    /// As [`inverse_kinematics`](Self::inverse_kinematics); unreachable branches are left out, and
    /// it is an error only if none is left.
    pub fn inverse_all(
        &self,
        b_from_t: &Pose<T>,
    ) -> Result<heapless::Vec<(Branch, JointVector<T>), 8>, KinematicsError> {
        let mut found = heapless::Vec::new();
        let mut error = KinematicsError::Unreachable;
        for branch in Branch::ALL {
            match self.inverse_kinematics(b_from_t, branch) {
                // Eight places for eight branches: the push cannot fail.
                Ok(q) => drop(found.push((branch, q))),
                Err(e) => error = e,
            }
        }
        if found.is_empty() { Err(error) } else { Ok(found) }
    }

    /// The branch that joint angles `q` lie on.
    ///
    /// # Errors
    /// [`KinematicsError::NotDecoupled`] for another kind of arm.
    pub fn branch_of(&self, q: &JointVector<T>) -> Result<Branch, KinematicsError> {
        let arm = self.decoupled()?;
        let b = q.component_mul(&arm.sense);
        let elbow = turned(arm.fore, b[2]);
        let wrist = turned([arm.upper[0] + elbow[0], arm.upper[1] + elbow[1]], b[1]);
        let fold = wrap(b[2] - stretched_angle(&arm));
        Ok(Branch {
            shoulder_back: arm.shoulder[0] + wrist[0] < T::zero(),
            elbow_flipped: fold < T::zero(),
            wrist_flipped: wrap(b[4]) < T::zero(),
        })
    }

    /// Joint angles for the tool pose with the shoulder and elbow of `near`, each turned by whole
    /// turns to lie nearest to `near`; of an arm without a decoupled wrist those that Newton's method
    /// comes to from `near` ([`inverse_from`](Self::inverse_from)).
    ///
    /// In line with A4 ∥ A6 only the sum of the two is defined: A4 is then held where `near` has
    /// it. The wrist's branch is that of `near` too, unless the other asks less of the wrist's
    /// joints: a path straight through the singularity has A5 change its sign, where A4 and A6
    /// would else jump by half a turn.
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`], [`Singular`](KinematicsError::Singular) where the wrist
    /// centre is on axis A1, [`NotFinite`](KinematicsError::NotFinite),
    /// [`Limit`](KinematicsError::Limit).
    pub fn inverse_near(
        &self,
        b_from_t: &Pose<T>,
        near: &JointVector<T>,
    ) -> Result<JointVector<T>, KinematicsError> {
        if !crate::scalar::all_finite(near.iter()) {
            return Err(KinematicsError::NotFinite);
        }
        let branch = match self.branch_of(near) {
            Ok(branch) => branch,
            Err(_) => return self.inverse_from(b_from_t, near),
        };
        let q = self.solve(b_from_t, branch, Some(near))?;
        let nearest =
            |q: JointVector<T>| JointVector::from_fn(|i, _| near[i] + wrap(q[i] - near[i]));
        let wrist_motion = |q: &JointVector<T>| (q - near).fixed_rows::<3>(3).amax();
        let half = T::pi();
        let same = nearest(q);
        let other = nearest(JointVector::from_column_slice(&[
            q[0],
            q[1],
            q[2],
            q[3] + half,
            -q[4],
            q[5] + half,
        ]));
        let q = if wrist_motion(&other) < wrist_motion(&same) { other } else { same };
        match self.beyond_limits(&q) {
            Some(joint) => Err(KinematicsError::Limit(joint)),
            None => Ok(q),
        }
    }

    /// Joint angles for the tool pose by Newton's method from `seed`, for an arm of any geometry:
    /// steps (JᵀJ + ε² 1)⁻¹ Jᵀ e of at most 0.3 rad a joint, e the pose error (rad, m) and ε its norm,
    /// which converge quadratically (Fan and Yuan 2005) and stay bounded next to a singular posture.
    /// They end within 1e-12 of the pose (in `f32` 8e-6), or not at all.
    ///
    /// # Errors
    /// [`KinematicsError::Unreachable`] where 64 steps do not reach the pose,
    /// [`Limit`](KinematicsError::Limit), [`NotFinite`](KinematicsError::NotFinite).
    #[inline(never)] // Its stack is none of an arm that has the closed form.
    pub fn inverse_from(
        &self,
        b_from_t: &Pose<T>,
        seed: &JointVector<T>,
    ) -> Result<JointVector<T>, KinematicsError> {
        const NEWTON_STEPS: usize = 64;
        let farthest_step = lit::<T>(0.3);
        let close = lit::<T>(1e-12).max(T::default_epsilon() * lit(64.0));
        if !b_from_t.is_finite() || !crate::scalar::all_finite(seed.iter()) {
            return Err(KinematicsError::NotFinite);
        }
        let mut q = *seed;
        for _ in 0..NEWTON_STEPS {
            let frames = self.frames(&q);
            let left = frames.tcp.error_to(b_from_t).to_vector();
            if left.amax() < close {
                return match self.beyond_limits(&q) {
                    Some(joint) => Err(KinematicsError::Limit(joint)),
                    None => Ok(q),
                };
            }
            let jacobian = frames.jacobian().0;
            let mut normal = jacobian.tr_mul(&jacobian);
            let damping = left.norm_squared().max(T::default_epsilon());
            for i in 0..JOINTS {
                normal[(i, i)] += damping;
            }
            let factors = Ldlt::new(normal).ok_or(KinematicsError::Unreachable)?;
            let step = factors.solve(&jacobian.tr_mul(&left));
            let longest = step.amax();
            q += if longest > farthest_step { step * (farthest_step / longest) } else { step };
        }
        Err(KinematicsError::Unreachable)
    }

    fn solve(
        &self,
        b_from_t: &Pose<T>,
        branch: Branch,
        near: Option<&JointVector<T>>,
    ) -> Result<JointVector<T>, KinematicsError> {
        if !b_from_t.is_finite() {
            return Err(KinematicsError::NotFinite);
        }
        let arm = self.decoupled()?;
        let zero = T::zero();
        let b_from_a6 = b_from_t.rotation * self.a6_from_t.rotation.transpose();
        let wrist = b_from_t.position - b_from_a6 * arm.tool - arm.foot;

        // Axis A1: the wrist centre's distance from the axis, less what lies across the arm's
        // plane.
        let along2 = wrist.x * wrist.x + wrist.y * wrist.y - arm.lateral * arm.lateral;
        if along2 < zero {
            return Err(KinematicsError::Unreachable);
        }
        let along = if branch.shoulder_back { -along2.sqrt() } else { along2.sqrt() };
        if along.abs() < lit(1e-9) {
            return Err(KinematicsError::Singular);
        }
        let b1 = wrist.y.atan2(wrist.x) - arm.lateral.atan2(along);

        // Axes A2, A3: a two-link arm; its fold follows from the law of cosines.
        let u = [along - arm.shoulder[0], wrist.z - arm.shoulder[1]];
        let (upper, fore) = (arm.upper, arm.fore);
        let in_line = upper[0] * fore[0] + upper[1] * fore[1];
        let across = upper[0] * fore[1] - upper[1] * fore[0];
        let reach = (in_line * in_line + across * across).sqrt();
        let square = |v: [T; 2]| v[0] * v[0] + v[1] * v[1];
        let cosine = (square(u) - square(upper) - square(fore)) / (reach + reach);
        if !cosine.is_finite() || cosine.abs() > T::one() {
            return Err(KinematicsError::Unreachable);
        }
        let fold = cosine.acos();
        let b3 = stretched_angle(&arm) + if branch.elbow_flipped { -fold } else { fold };
        let elbow = turned(fore, b3);
        let v = [upper[0] + elbow[0], upper[1] + elbow[1]];
        let b2 = v[1].atan2(v[0]) - u[1].atan2(u[0]);

        // Axes A4–A6: the rotation that the arm leaves over, as R_x(b4) R_y(b5) R_x(b6).
        let b_from_a3 = about_z(b1) * about_y(b2 + b3);
        let r = b_from_a3.transpose() * b_from_a6;
        let sine5 = (r.m12 * r.m12 + r.m13 * r.m13).sqrt();
        let flip = if branch.wrist_flipped { -T::one() } else { T::one() };
        let (b4, b5, b6) = if sine5 > in_line_below() {
            (
                (flip * r.m21).atan2(-flip * r.m31),
                (flip * sine5).atan2(r.m11),
                (flip * r.m12).atan2(flip * r.m13),
            )
        } else {
            let b4 = near.ok_or(KinematicsError::Singular)?[3] * arm.sense[3];
            // R_x(b4)ᵀ R = R_y(b5) R_x(b6), whose second row is (0, cos b6, −sin b6).
            let (s, c) = b4.sin_cos();
            (
                b4,
                (flip * sine5).atan2(r.m11),
                (-(c * r.m23 + s * r.m33)).atan2(c * r.m22 + s * r.m32),
            )
        };
        Ok(JointVector::from_column_slice(&[b1, b2, b3, b4, b5, b6])
            .component_mul(&arm.sense)
            .map(wrap))
    }

    fn decoupled(&self) -> Result<Decoupled<T>, KinematicsError> {
        let joints = &self.parameters.joints;
        let tiny = lit::<T>(1e-6);
        // Direction of each axis in the covered family: z, y, y, x, y, x.
        const DIRECTION: [usize; JOINTS] = [2, 1, 1, 0, 1, 0];
        let mut sense = JointVector::zeros();
        for i in 0..JOINTS {
            let along = joints[i].axis[DIRECTION[i]];
            if (along.abs() - T::one()).abs() > tiny {
                return Err(KinematicsError::NotDecoupled);
            }
            sense[i] = along.signum();
        }
        // A5 must lie on axis A4 and A6's origin on its own axis through A5, or the wrist has no
        // centre.
        let across = |v: &Vector3<T>| v.y.abs().max(v.z.abs());
        if across(&joints[4].origin) > tiny || across(&joints[5].origin) > tiny {
            return Err(KinematicsError::NotDecoupled);
        }
        let fore = joints[3].origin + joints[4].origin;
        Ok(Decoupled {
            sense,
            foot: joints[0].origin,
            shoulder: [joints[1].origin.x, joints[1].origin.z],
            upper: [joints[2].origin.x, joints[2].origin.z],
            fore: [fore.x, fore.z],
            lateral: joints[1].origin.y + joints[2].origin.y + fore.y,
            tool: joints[5].origin + self.a6_from_t.position,
        })
    }
}

/// Sine of A5 below which A4 and A6 count as in line: 1e-6, or the rounding of a pose where that is
/// coarser.
fn in_line_below<T: Real>() -> T {
    lit::<T>(1e-6).max(T::default_epsilon() * lit(32.0))
}

/// A3 rotation at which upper arm and forearm are in one line.
fn stretched_angle<T: Real>(arm: &Decoupled<T>) -> T {
    let (l, m) = (arm.upper, arm.fore);
    (l[0] * m[1] - l[1] * m[0]).atan2(l[0] * m[0] + l[1] * m[1])
}

/// (x, z) turned by R_y(angle).
fn turned<T: Real>(v: [T; 2], angle: T) -> [T; 2] {
    let (s, c) = angle.sin_cos();
    [c * v[0] + s * v[1], c * v[1] - s * v[0]]
}

fn about_z<T: Real>(angle: T) -> Matrix3<T> {
    let (s, c) = angle.sin_cos();
    let (o, l) = (T::zero(), T::one());
    Matrix3::new(c, -s, o, s, c, o, o, o, l)
}

fn about_y<T: Real>(angle: T) -> Matrix3<T> {
    let (s, c) = angle.sin_cos();
    let (o, l) = (T::zero(), T::one());
    Matrix3::new(c, o, s, o, l, o, -s, o, c)
}

/// The same angle in [−π, π).
fn wrap<T: Real>(angle: T) -> T {
    let turns = ((angle / T::two_pi()) + lit(0.5)).floor();
    angle - turns * T::two_pi()
}
