//! Recursive Newton–Euler: joint torques of a motion, gravity, and the load every joint carries.
//!
//! The links and the tool only. Rotors, springs, friction and the counterbalance belong to the drives and are not in
//! here. Everything is formed in axes of B about each link frame's origin, so the backward pass needs no rotations.
//! Source: Luh, Walker, Paul 1980; Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 5.

use crate::kinematics::Frames;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real};
use crate::spatial::Wrench;
use nalgebra::Vector3;

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
        let mut loads = [Wrench::zero(); JOINTS];
        let mut omega = Vector3::zeros();
        let mut omega_dot = Vector3::zeros();
        // A base that accelerates upwards is what gravity feels like to the links.
        let mut linear = -self.parameters.gravity;
        let mut previous = Vector3::zeros();
        let mut com = [Vector3::zeros(); JOINTS];
        for i in 0..JOINTS {
            let link = &self.links[i];
            let rotation = &frames.rotation[i];
            if i > 0 {
                let step = frames.origin[i] - previous;
                linear += omega_dot.cross(&step) + omega.cross(&omega.cross(&step));
            }
            previous = frames.origin[i];
            let spin = frames.axis[i] * rate[i];
            omega_dot += frames.axis[i] * acceleration[i] + omega.cross(&spin);
            omega += spin;
            com[i] = rotation * link.center_of_mass;
            let force = (linear + omega_dot.cross(&com[i]) + omega.cross(&omega.cross(&com[i]))) * link.mass;
            // Euler's equation in link axes, where the inertia is constant.
            let w = rotation.tr_mul(&omega);
            let moment = link.inertia * rotation.tr_mul(&omega_dot) + w.cross(&(link.inertia * w));
            loads[i] = Wrench { moment: rotation * moment + com[i].cross(&force), force };
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
        let mut first_moment = Vector3::zeros();
        for i in (0..JOINTS).rev() {
            let link = &self.links[i];
            mass += link.mass;
            first_moment += (frames.rotation[i] * link.center_of_mass + frames.origin[i]) * link.mass;
            let lever = first_moment - frames.origin[i] * mass;
            torque[i] = -frames.axis[i].dot(&lever.cross(&self.parameters.gravity));
        }
        torque
    }

    /// Potential energy of the links and the tool in gravity, J, zero at the origin of B.
    pub fn potential_energy(&self, frames: &Frames<T>) -> T {
        (0..JOINTS).fold(T::zero(), |sum, i| {
            let link = &self.links[i];
            let com = frames.rotation[i] * link.center_of_mass + frames.origin[i];
            sum - self.parameters.gravity.dot(&com) * link.mass
        })
    }
}
