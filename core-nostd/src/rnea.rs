//! Recursive Newton–Euler: joint torques of a motion, gravity, and the load every joint carries.
//!
//! The links and the tool only. Rotors, springs, friction and the counterbalance belong to the drives and are not in
//! here. Everything is formed in axes of B about each link frame's origin, so the backward pass needs no rotations.
//! Source: Luh, Walker, Paul 1980; Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5.

use crate::inertia::Body;
use crate::kinematics::Frames;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real};
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3};

impl<T: Real> Robot<T> {
    /// Inverse dynamics: τ = M(q) a + h(q, v) + g(q) − Jᵀ w, N·m.
    ///
    /// `frames` at q; `rate` v in rad/s; `acceleration` a in rad/s²; `wrench` w: what the environment applies to the
    /// tool, at the TCP, in axes of B.
    #[inline]
    pub fn rnea(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> JointVector<T> {
        let loads = self.joint_loads(frames, rate, acceleration, wrench);
        JointVector::from_fn(|i, _| frames.axis[i].dot(&loads[i].moment))
    }

    /// Velocity and gravity torques h(q, v) + g(q), N·m: inverse dynamics without acceleration and wrench.
    #[inline]
    pub fn bias(&self, frames: &Frames<T>, rate: &JointVector<T>) -> JointVector<T> {
        self.rnea(frames, rate, &JointVector::zeros(), &Wrench::zero())
    }

    /// The whole wrench each joint passes to its link, about the link frame's origin in axes of B. Its moment along
    /// the axis is the joint torque; the rest is what the bearing carries.
    #[inline]
    pub fn joint_loads(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> [Wrench<T>; JOINTS] {
        self.loads_of(&self.bodies(frames), frames, rate, acceleration, wrench)
    }

    /// The links in axes of B, each about its frame's origin.
    #[inline(always)]
    pub(crate) fn bodies(&self, frames: &Frames<T>) -> [Body<T>; JOINTS] {
        let mut bodies = self.links;
        for (body, rotation) in bodies.iter_mut().zip(&frames.rotation) {
            *body = body.turned(rotation);
        }
        bodies
    }

    /// [`joint_loads`](Self::joint_loads) with the links already in axes of B.
    #[inline(always)]
    pub(crate) fn loads_of(
        &self,
        bodies: &[Body<T>; JOINTS],
        frames: &Frames<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> [Wrench<T>; JOINTS] {
        let mut loads = [Wrench::zero(); JOINTS];
        let mut omega = Vector3::zeros();
        let mut omega_dot = Vector3::zeros();
        // Acceleration of a point at r from the frame's origin: linear + field · r. The base accelerates upwards,
        // which is what gravity feels like to the links.
        let mut linear = -self.parameters.gravity;
        let mut field = Matrix3::zeros();
        for i in 0..JOINTS {
            if i > 0 {
                linear += field * (frames.origin[i] - frames.origin[i - 1]);
            }
            let spin = frames.axis[i] * rate[i];
            omega_dot += frames.axis[i] * acceleration[i] + omega.cross(&spin);
            omega += spin;
            field = acceleration_field(&omega, &omega_dot);
            let Body { mass, first, second } = &bodies[i];
            let force = linear * *mass + field * first;
            loads[i] = Wrench { moment: second.moment_of(&field) + first.cross(&linear), force };
        }
        let mut carried = -*wrench;
        let mut at = frames.tcp.position;
        for i in (0..JOINTS).rev() {
            let lever = at - frames.origin[i];
            loads[i].moment += carried.moment + lever.cross(&carried.force);
            loads[i].force += carried.force;
            carried = loads[i];
            at = frames.origin[i];
        }
        loads
    }

    /// Gravity torque g(q) of the links and the tool, N·m.
    #[inline]
    pub fn gravity_torque(&self, frames: &Frames<T>) -> JointVector<T> {
        let mut torque = JointVector::zeros();
        let mut mass = T::zero();
        let mut first = Vector3::zeros();
        let mut at = frames.origin[JOINTS - 1];
        for i in (0..JOINTS).rev() {
            let link = &self.links[i];
            first += (at - frames.origin[i]) * mass + frames.rotation[i] * link.first;
            mass += link.mass;
            at = frames.origin[i];
            torque[i] = -frames.axis[i].dot(&first.cross(&self.parameters.gravity));
        }
        torque
    }

    /// Potential energy of the links and the tool in gravity, J, zero at the origin of B.
    pub fn potential_energy(&self, frames: &Frames<T>) -> T {
        (0..JOINTS).fold(T::zero(), |sum, i| {
            let link = &self.links[i];
            sum - self.parameters.gravity.dot(&(frames.rotation[i] * link.first + frames.origin[i] * link.mass))
        })
    }
}

/// [ω̇]× + [ω]×²: times r, the acceleration of a body's point at r against its reference point.
#[inline(always)]
fn acceleration_field<T: Real>(omega: &Vector3<T>, omega_dot: &Vector3<T>) -> Matrix3<T> {
    let (w, d) = (omega, omega_dot);
    let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
    let (xy, xz, yz) = (w.x * w.y, w.x * w.z, w.y * w.z);
    Matrix3::new(-yy - zz, xy - d.z, xz + d.y, xy + d.z, -xx - zz, yz - d.x, xz - d.y, yz + d.x, -xx - yy)
}
