//! Composite rigid bodies: the joint-space inertia matrix, and the forward dynamics it gives.
//!
//! Links and tool only; rotors belong to the drives. Composite inertias are kept about the origin of B, so that adding
//! two needs no shift. Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 6.

use crate::kinematics::Frames;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real};
use crate::spatial::Wrench;
use nalgebra::{Cholesky, Const, Matrix3, Matrix6, Vector3};

impl<T: Real> Robot<T> {
    /// Inertia matrix M(q), 6 × 6, symmetric positive definite, kg·m².
    #[inline]
    pub fn crba(&self, frames: &Frames<T>) -> Matrix6<T> {
        let mut m = Matrix6::zeros();
        // The body outward of joint i, taken as one: mass, m·c, and the inertia about a point that moves inward.
        let mut mass = T::zero();
        let mut moment = Vector3::zeros();
        let mut inertia = Matrix3::zeros();
        for i in (0..JOINTS).rev() {
            let link = &self.links[i];
            let rotation = &frames.rotation[i];
            let c = rotation * link.center_of_mass;
            if i + 1 < JOINTS {
                // Parallel-axis shift of what is already gathered, from the outer joint's origin to this one.
                let d = frames.origin[i + 1] - frames.origin[i];
                let cross = moment.dot(&d);
                let diagonal = cross + cross + mass * d.norm_squared();
                let shifted = moment + d * mass;
                inertia += Matrix3::from_diagonal_element(diagonal) - d * moment.transpose() - shifted * d.transpose();
                moment = shifted;
            }
            let mc = c * link.mass;
            inertia += rotation * link.inertia * rotation.transpose() + Matrix3::from_diagonal_element(mc.dot(&c))
                - mc * c.transpose();
            moment += mc;
            mass += link.mass;
            // Wrench about oᵢ that a unit acceleration of joint i asks for, seen by every joint inward of it.
            let z = &frames.axis[i];
            let force = z.cross(&moment);
            let torque = inertia * z;
            for j in 0..=i {
                let lever = frames.origin[i] - frames.origin[j];
                let value = frames.axis[j].dot(&(torque + lever.cross(&force)));
                m[(i, j)] = value;
                m[(j, i)] = value;
            }
        }
        m
    }

    /// Forward dynamics of the rigid arm: q̈ = M⁻¹ (τ − h − g + Jᵀ w), rad/s², by Cholesky.
    ///
    /// `None` only where M is not positive definite, which a [`Robot`] that passed its checks reaches for non-finite
    /// states alone.
    #[inline]
    pub fn forward_dynamics(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        torque: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> Option<JointVector<T>> {
        let bias = self.rnea(frames, rate, &JointVector::zeros(), wrench);
        Some(factor(self.crba(frames))?.solve(&(torque - bias)))
    }

    /// Kinetic energy of the links and the tool, J: ½ vᵀ M v.
    pub fn kinetic_energy(&self, frames: &Frames<T>, rate: &JointVector<T>) -> T {
        rate.dot(&(self.crba(frames) * rate)) * crate::scalar::lit(0.5)
    }
}

/// Cholesky factor of a symmetric positive definite joint-space matrix; `None` where it is not one.
#[inline]
pub fn factor<T: Real>(m: Matrix6<T>) -> Option<Cholesky<T, Const<6>>> {
    Cholesky::new(m)
}
