//! Recursive Newton–Euler: joint torques of a motion, gravity, and the load every joint carries.
//!
//! The links and the tool only. Rotors, springs, friction and the counterbalance belong to the
//! drives and are not in here. Everything is formed in axes of B about each link frame's origin, so
//! the backward pass needs no rotations. Source: Luh, Walker, Paul 1980; Featherstone, Rigid Body
//! Dynamics Algorithms, 2008, ch. 5.

use crate::inertia::{Bodies, Matrices};
use crate::kinematics::Frames;
use crate::lanes::{Lanes, Lanes3};
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real};
use crate::spatial::Wrench;
use nalgebra::Vector3;

impl<T: Real> Robot<T> {
    /// Inverse dynamics: τ = M(q) a + h(q, v) + g(q) − Jᵀ w, N·m.
    ///
    /// `frames` at q; `rate` v in rad/s; `acceleration` a in rad/s²; `wrench` w: what the
    /// environment applies to the tool, at the TCP, in axes of B.
    #[inline]
    pub fn rnea(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> JointVector<T> {
        let (moment, _) =
            self.loads_of(&self.bodies_in_b(frames), frames, rate, acceleration, wrench);
        JointVector::from(Lanes3::from_vectors(&frames.axis).dot(&moment).0)
    }

    /// Velocity and gravity torques h(q, v) + g(q), N·m: inverse dynamics without acceleration and
    /// wrench.
    #[inline]
    pub fn nonlinear_effects(&self, frames: &Frames<T>, rate: &JointVector<T>) -> JointVector<T> {
        self.rnea(frames, rate, &JointVector::zeros(), &Wrench::zero())
    }

    /// The whole wrench each joint passes to its link, about the link frame's origin in axes of B.
    /// Its moment along the axis is the joint torque; the rest is what the bearing carries.
    #[inline]
    pub fn joint_loads(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> [Wrench<T>; JOINTS] {
        let (moment, force) =
            self.loads_of(&self.bodies_in_b(frames), frames, rate, acceleration, wrench);
        let mut loads = [Wrench::zero(); JOINTS];
        for (i, load) in loads.iter_mut().enumerate() {
            *load = Wrench { moment: moment.vector(i), force: force.vector(i) };
        }
        loads
    }

    /// The links in axes of B, each about its frame's origin.
    #[inline(never)]
    pub(crate) fn bodies_in_b(&self, frames: &Frames<T>) -> Bodies<T> {
        self.bodies.turned(&Matrices::new(&frames.rotation))
    }

    /// Moment and force of [`joint_loads`](Self::joint_loads), for all joints at once.
    #[inline(never)]
    pub(crate) fn loads_of(
        &self,
        bodies: &Bodies<T>,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> (Lanes3<T>, Lanes3<T>) {
        let origin = Lanes3::from_vectors(&frames.origin);
        // From each link's origin to the next one's, the last to the TCP.
        let step = origin.moved_inward(&frames.tcp.position) - origin;
        let motion = self.motion(frames, &step, rate, acceleration);
        let (moment, force) = motion.loads_of(bodies);

        // Inward: Fᵢ = Fᵢ₊₁ + fᵢ, Nᵢ = Nᵢ₊₁ + nᵢ + (oᵢ₊₁ − oᵢ) × Fᵢ₊₁, from the wrench at the TCP.
        let tool = -*wrench;
        let force = (force + Lanes3::last(&tool.force)).sum_from_tool();
        let lever = step.cross(&force.moved_inward(&tool.force));
        let moment = (moment + lever + Lanes3::last(&tool.moment)).sum_from_tool();
        (moment, force)
    }

    /// How the links accelerate; `step`: from each link's origin to the next one's.
    #[inline(never)]
    fn motion(
        &self,
        frames: &Frames<T>,
        step: &Lanes3<T>,
        rate: &JointVector<T>,
        acceleration: &JointVector<T>,
    ) -> LinkAcceleration<T> {
        let axis = Lanes3::from_vectors(&frames.axis);
        // Outward: ωᵢ = ωᵢ₋₁ + zᵢ vᵢ, ω̇ᵢ = ω̇ᵢ₋₁ + zᵢ aᵢ + ωᵢ₋₁ × zᵢ vᵢ.
        let spin = axis * Lanes(rate.data.0[0]);
        let omega = spin.sum_from_base();
        let before = omega.moved_outward(&Vector3::zeros());
        let omega_dot =
            (axis * Lanes(acceleration.data.0[0]) + before.cross(&spin)).sum_from_base();
        let field = acceleration_field(&omega, &omega_dot);
        // The base accelerates upwards, which is what gravity feels like to the links.
        let linear = field.times(step).moved_outward(&-self.parameters.gravity).sum_from_base();
        LinkAcceleration { field, linear }
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
            sum - self
                .parameters
                .gravity
                .dot(&(frames.rotation[i] * link.first + frames.origin[i] * link.mass))
        })
    }
}

/// Acceleration of every link: of its point at r from the frame's origin, `linear` + `field`·r.
struct LinkAcceleration<T: Real> {
    linear: Lanes3<T>,
    field: Matrices<T>,
}

impl<T: Real> LinkAcceleration<T> {
    /// Moment and force that each link alone asks for, by Newton and Euler, about its frame's
    /// origin.
    #[inline(never)]
    fn loads_of(&self, bodies: &Bodies<T>) -> (Lanes3<T>, Lanes3<T>) {
        let force = self.linear * bodies.mass + self.field.times(&bodies.first);
        let moment = bodies.second.moment_of(&self.field) + bodies.first.cross(&self.linear);
        (moment, force)
    }
}

/// [ω̇]× + [ω]×²: times r, the acceleration of a body's point at r against its reference point.
#[inline(always)]
fn acceleration_field<T: Real>(w: &Lanes3<T>, d: &Lanes3<T>) -> Matrices<T> {
    let (xx, yy, zz) = (w.x * w.x, w.y * w.y, w.z * w.z);
    let (xy, xz, yz) = (w.x * w.y, w.x * w.z, w.y * w.z);
    Matrices {
        x: Lanes3 { x: -(yy + zz), y: xy + d.z, z: xz - d.y },
        y: Lanes3 { x: xy - d.z, y: -(xx + zz), z: yz + d.x },
        z: Lanes3 { x: xz + d.y, y: yz - d.x, z: -(xx + yy) },
    }
}
