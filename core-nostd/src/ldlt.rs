//! Factors of a joint-space inertia matrix, and the solution of M x = b with them.

use crate::scalar::{JOINTS, JointVector, Real};
use nalgebra::Matrix6;

/// The factors L D Lᵀ of a symmetric positive definite joint-space matrix, such as M: Cholesky's
/// without square roots.
#[derive(Debug, Clone, Copy)]
pub struct Ldlt<T: Real> {
    /// Columns of L below its unit diagonal; what lies above is of no meaning.
    lower: [[T; JOINTS]; JOINTS],
    /// 1/D.
    reciprocal: [T; JOINTS],
}

impl<T: Real> Ldlt<T> {
    /// Factors a symmetric positive definite joint-space matrix; `None` where it is not one.
    #[inline]
    pub fn new(m: Matrix6<T>) -> Option<Self> {
        let mut lower = m.data.0;
        let mut reciprocal = [T::zero(); JOINTS];
        for k in 0..JOINTS {
            let column = lower[k];
            if column[k] <= T::zero() || !column[k].is_finite() {
                return None;
            }
            reciprocal[k] = column[k].recip();
            for j in k + 1..JOINTS {
                lower[k][j] = column[j] * reciprocal[k];
                for i in j..JOINTS {
                    let product = column[i] * lower[k][j];
                    lower[j][i] -= product;
                }
            }
        }
        Some(Self { lower, reciprocal })
    }

    /// M⁻¹ b.
    #[inline]
    pub fn solve(&self, b: &JointVector<T>) -> JointVector<T> {
        let mut x = *b;
        for k in 0..JOINTS {
            for i in k + 1..JOINTS {
                let product = self.lower[k][i] * x[k];
                x[i] -= product;
            }
        }
        for k in (0..JOINTS).rev() {
            x[k] *= self.reciprocal[k];
            for i in k + 1..JOINTS {
                let product = self.lower[k][i] * x[i];
                x[k] -= product;
            }
        }
        x
    }
}
