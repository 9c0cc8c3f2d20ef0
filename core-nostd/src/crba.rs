//! Composite rigid bodies: the joint-space inertia matrix, and the forward dynamics it gives.
//!
//! Links and tool only; rotors belong to the drives. Composite bodies are kept in axes of B about
//! one point, so that adding two needs no shift. Source: Featherstone, Rigid Body Dynamics
//! Algorithms, 2008, ch. 6.

use crate::inertia::Bodies;
use crate::kinematics::Frames;
use crate::lanes::Lanes3;
use crate::ldlt::Ldlt;
use crate::robot::Robot;
use crate::scalar::{JOINTS, JointVector, Real};
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Matrix6, Vector3};

impl<T: Real> Robot<T> {
    /// Inertia matrix M(q), 6 × 6, symmetric positive definite, kg·m².
    #[inline]
    pub fn crba(&self, frames: &Frames<T>) -> Matrix6<T> {
        self.inertia_matrix_of(&self.bodies_in_b(frames), frames)
    }

    /// [`crba`](Self::crba) with the links already in axes of B.
    #[inline(never)]
    fn inertia_matrix_of(&self, bodies: &Bodies<T>, frames: &Frames<T>) -> Matrix6<T> {
        // About the last link's origin: far from the base, so that the wrist's small inertias do
        // not drown in f32.
        let center = Lanes3::from_vectors(&[frames.origin[JOINTS - 1]; JOINTS]);
        let from_center = Lanes3::from_vectors(&frames.origin) - center;
        let outward = bodies.shifted(&from_center).sum_from_tool();
        // Motion of the centre point for unit rate of each joint, and the wrench that unit
        // acceleration asks for.
        let axis = Lanes3::from_vectors(&frames.axis);
        let linear = from_center.cross(&axis);
        let force = linear * outward.mass + axis.cross(&outward.first);
        let moment = outward.second.inertia_times(&axis) + outward.first.cross(&linear);
        let mut m = [[T::zero(); JOINTS]; JOINTS];
        for (i, column) in m.iter_mut().enumerate() {
            // Only the joints inward of i carry all of what is outward of i.
            *column = (axis.dot(&moment.only(i)) + linear.dot(&force.only(i))).0;
        }
        let mut matrix = Matrix6::from(m);
        matrix.fill_lower_triangle_with_upper_triangle();
        matrix
    }

    /// Inertia of joint `i`'s link and all that is outward of it as one body, about the point `about`
    /// in B: 3 × 3, symmetric, kg·m², in axes of B.
    pub fn composite_inertia(
        &self,
        frames: &Frames<T>,
        i: usize,
        about: &Vector3<T>,
    ) -> Matrix3<T> {
        let from_point = Lanes3::from_vectors(&frames.origin.map(|origin| origin - about));
        let outward = self.bodies_in_b(frames).shifted(&from_point).sum_from_tool();
        let column = |k: usize| {
            outward
                .second
                .inertia_times(&Lanes3::from_vectors(&[Vector3::ith(k, T::one()); JOINTS]))
        };
        Matrix3::from_columns(&[0, 1, 2].map(|k| column(k).vector(i)))
    }

    /// M(q) and the bias h(q, v) + g(q) − Jᵀ w, N·m, of the equation of motion M q̈ + bias = τ:
    /// [`crba`](Self::crba) and [`rnea`](Self::rnea) without acceleration, with the links turned
    /// into axes of B once for both.
    #[inline]
    pub fn equation_of_motion(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> (Matrix6<T>, JointVector<T>) {
        let bodies = self.bodies_in_b(frames);
        let (moment, _) = self.loads_of(&bodies, frames, rate, &JointVector::zeros(), wrench);
        let bias = JointVector::from(Lanes3::from_vectors(&frames.axis).dot(&moment).0);
        (self.inertia_matrix_of(&bodies, frames), bias)
    }

    /// Forward dynamics of the rigid arm: q̈ = M⁻¹ (τ − h − g + Jᵀ w), rad/s², by Cholesky.
    ///
    /// `None` only where M is not positive definite, which a [`Robot`] that passed its checks
    /// reaches for non-finite states alone.
    #[inline]
    pub fn forward_dynamics(
        &self,
        frames: &Frames<T>,
        rate: &JointVector<T>,
        torque: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> Option<JointVector<T>> {
        let (inertia, bias) = self.equation_of_motion(frames, rate, wrench);
        Some(Ldlt::new(inertia)?.solve(&(torque - bias)))
    }

    /// Kinetic energy of the links and the tool, J: ½ vᵀ M v.
    pub fn kinetic_energy(&self, frames: &Frames<T>, rate: &JointVector<T>) -> T {
        rate.dot(&(self.crba(frames) * rate)) * crate::scalar::lit(0.5)
    }
}
