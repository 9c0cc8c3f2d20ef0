//! Cartesian stiffness and compliance of the arm at the tool, and where the tool goes under load.
//!
//! (1.1) τ = K Δθ, (1.2) τ = Jᵀ w, (1.3) Δx ≈ J Δθ, (1.4) K_c = J⁻ᵀ K J⁻¹. The first-order forms
//! serve margins and stiffness maps; [`Robot::deflected`] solves for the loaded pose itself, since
//! at 5 mm first order is not enough.

use crate::error::KinematicsError;
use crate::jacobian::Jacobian;
use crate::kinematics::Frames;
use crate::robot::Robot;
use crate::scalar::{JointVector, Real};
use crate::spatial::{Pose, Twist, Wrench};
use nalgebra::{Complex, Matrix6, Vector3};

/// The arm bent by its loads, at rest.
#[derive(Debug, Clone, Copy)]
pub struct Deflection<T: Real> {
    /// Real joint angles θ, rad.
    pub link: JointVector<T>,
    /// Torsion of each drive, θ_E − θ, rad.
    pub torsion: JointVector<T>,
    /// Real tool pose `b_from_t`.
    pub real: Pose<T>,
    /// Tool pose that the encoders report.
    pub encoder: Pose<T>,
    /// Size of the last iteration's step in θ, rad: what is left of the fixed-point error.
    pub residual: T,
}

impl<T: Real> Deflection<T> {
    /// How far the load moved the tool: from the encoders' pose to the real one, axes of B, at the
    /// TCP.
    pub fn displacement(&self) -> Twist<T> {
        self.encoder.error_to(&self.real)
    }
}

impl<T: Real> Robot<T> {
    /// Cartesian compliance C = J K⁻¹ Jᵀ at the TCP, axes of B, angular first: rad or m per N·m or
    /// N.
    pub fn cartesian_compliance(&self, jacobian: &Jacobian<T>) -> Matrix6<T> {
        let compliance = Matrix6::from_diagonal(&self.stiffness.map(|k| k.recip()));
        jacobian.0 * compliance * jacobian.0.transpose()
    }

    /// Compliance of the arm at the TCP along a direction, nᵀ J K⁻¹ Jᵀ n, m/N: an entry of
    /// [`Robot::cartesian_compliance`] without the rest of it. `direction`: unit vector n, axes of
    /// B.
    #[inline]
    pub fn compliance_along(&self, frames: &Frames<T>, direction: &Vector3<T>) -> T {
        let torque = frames.joint_torque(&Wrench { moment: Vector3::zeros(), force: *direction });
        torque.component_mul(&torque).component_div(&self.stiffness).sum()
    }

    /// Cartesian stiffness K_c = J⁻ᵀ K J⁻¹, (1.4), without the load-dependent term.
    ///
    /// # Errors
    /// [`KinematicsError::Singular`] where J cannot be inverted.
    pub fn cartesian_stiffness(
        &self,
        jacobian: &Jacobian<T>,
    ) -> Result<Matrix6<T>, KinematicsError> {
        let inverse = jacobian.0.try_inverse().ok_or(KinematicsError::Singular)?;
        Ok(inverse.transpose() * Matrix6::from_diagonal(&self.stiffness) * inverse)
    }

    /// Torque that every spring carries at rest, τ_s = g(θ) − τ_cb(θ₂) − Jᵀ w, N·m: (2.1) without
    /// motion.
    ///
    /// `wrench`: what the environment applies to the tool, at the TCP, in axes of B.
    #[inline]
    pub fn spring_torque_at_rest(
        &self,
        frames: &Frames<T>,
        link: &JointVector<T>,
        wrench: &Wrench<T>,
    ) -> JointVector<T> {
        let mut torque = self.gravity_torque(frames) - frames.joint_torque(wrench);
        torque[1] -= self.counterbalance_torque(link[1]);
        torque
    }

    /// Predicts the real pose from encoder angles and the measured wrench: solves K(θ_E − θ) = g(θ)
    /// − τ_cb − J(θ)ᵀ w in a fixed number of fixed-point iterations.
    ///
    /// `wrench_in_t`: as the sensor measures it, in axes of the real tool frame. Each iteration
    /// divides the error by K over the change of load torque with angle, a factor of some hundreds
    /// on a heavy robot at 18 kN; three reach rounding in f32 and five in f64.
    pub fn deflected(
        &self,
        encoder: &JointVector<T>,
        wrench_in_t: &Wrench<T>,
        iterations: usize,
    ) -> Deflection<T> {
        let encoder_frames = self.frames(encoder);
        let mut frames = encoder_frames;
        let mut link = *encoder;
        let mut residual = T::zero();
        for _ in 0..iterations {
            let wrench = wrench_in_t.rotated(&frames.tcp.rotation);
            let torsion =
                self.spring_torque_at_rest(&frames, &link, &wrench).component_div(&self.stiffness);
            let next = encoder - torsion;
            residual = (next - link).amax();
            link = next;
            frames = self.frames(&link);
        }
        Deflection {
            link,
            torsion: encoder - link,
            real: frames.tcp,
            encoder: encoder_frames.tcp,
            residual,
        }
    }

    /// The fake target: encoder angles that put the *real*, loaded tool where `link` puts the
    /// unloaded one.
    ///
    /// With the real angles given the springs' equation is explicit, θ_E = θ + K⁻¹(g(θ) − τ_cb −
    /// J(θ)ᵀ w): exact, no iteration. `wrench_in_t` in axes of the real tool frame.
    pub fn fake_target(&self, link: &JointVector<T>, wrench_in_t: &Wrench<T>) -> JointVector<T> {
        let frames = self.frames(link);
        let wrench = wrench_in_t.rotated(&frames.tcp.rotation);
        link + self.spring_torque_at_rest(&frames, link, &wrench).component_div(&self.stiffness)
    }

    /// Stiffness of the drives' springs and dampers at an angular frequency ω, rad/s: K + iωD,
    /// N·m/rad.
    pub fn dynamic_stiffness(&self, omega: T) -> JointVector<Complex<T>> {
        self.stiffness.zip_map(&self.damping, |k, d| Complex::new(k, omega * d))
    }

    /// Compliance of the links with the motors locked at an angular frequency ω, rad/s: (K + iωD −
    /// ω²M)⁻¹, rad/(N·m). `None` where there is no inverse.
    pub fn dynamic_compliance(&self, frames: &Frames<T>, omega: T) -> Option<Matrix6<Complex<T>>> {
        let inertia = self.crba(frames).map(|m| Complex::new(omega * omega * m, T::zero()));
        (Matrix6::from_diagonal(&self.dynamic_stiffness(omega)) - inertia).try_inverse()
    }

    /// Natural frequencies of the arm on its springs with the motors locked, rad/s, ascending: ω²
    /// are the eigenvalues of M⁻¹K at θ. `None` where M is not positive definite.
    pub fn natural_frequencies(&self, frames: &Frames<T>) -> Option<JointVector<T>> {
        // K^−½ M K^−½ is symmetric and has the eigenvalues 1/ω²; its largest, those of the slowest
        // modes, come out most accurately.
        let inertia = self.crba(frames);
        let soft = self.stiffness.map(|k| k.sqrt().recip());
        let scaled = Matrix6::from_fn(|i, j| soft[i] * inertia[(i, j)] * soft[j]);
        let mut squared = scaled.symmetric_eigenvalues();
        squared
            .as_mut_slice()
            .sort_unstable_by(|a, b| b.partial_cmp(a).unwrap_or(core::cmp::Ordering::Equal));
        let definite = squared.iter().all(|s| *s > T::zero());
        definite.then(|| squared.map(|s| s.sqrt().recip()))
    }
}
