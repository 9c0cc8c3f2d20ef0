//! The geometric Jacobian of the tool, and what (1.2) and (1.3) do with it: loads to joint torques,
//! joint torsions to tool displacements.

use crate::kinematics::Frames;
use crate::scalar::{JOINTS, JointVector, Real, lit};
use crate::solve::Lu;
use crate::spatial::Wrench;
use nalgebra::{Matrix6, Vector3};

/// Jacobian of the TCP, axes of B, angular rows first: `[ω; ṗ] = J q̇`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jacobian<T: Real>(pub Matrix6<T>);

impl<T: Real> Jacobian<T> {
    /// The wrench at the TCP, axes of B, that loads the joints with `torque`, N·m: w = J⁻ᵀ τ, (1.2)
    /// backwards. `None` next to a singular posture.
    pub fn wrench_for(&self, torque: &JointVector<T>) -> Option<Wrench<T>> {
        Some(Wrench::from_vector(&Lu::new(&self.0.transpose(), lit(1e-4))?.solve(torque)))
    }
}

impl<T: Real> Frames<T> {
    /// Geometric Jacobian of the TCP in axes of B: column i is (zᵢ, zᵢ × (p − oᵢ)).
    #[inline]
    pub fn jacobian(&self) -> Jacobian<T> {
        let mut j = Matrix6::zeros();
        for i in 0..JOINTS {
            let z = self.axis[i];
            let lever = z.cross(&(self.tcp.position - self.origin[i]));
            j.fixed_view_mut::<3, 1>(0, i).copy_from(&z);
            j.fixed_view_mut::<3, 1>(3, i).copy_from(&lever);
        }
        Jacobian(j)
    }

    /// Joint torques that balance a wrench at the TCP given in axes of B, N·m: τ = Jᵀ w, (1.2),
    /// without forming J.
    #[inline]
    pub fn joint_torque(&self, wrench: &Wrench<T>) -> JointVector<T> {
        JointVector::from_fn(|i, _| {
            let moment: Vector3<T> =
                wrench.moment + (self.tcp.position - self.origin[i]).cross(&wrench.force);
            self.axis[i].dot(&moment)
        })
    }
}
