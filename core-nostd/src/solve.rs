//! Small dense linear algebra for what runs on the controller: a 6 × 6 solve and the eigenvalues of
//! a 3 × 3.
//!
//! nalgebra has both, for any size, and therefore with checks of size that can panic. Here every
//! bound is a constant, so that the optimiser removes every check and a program with the control
//! law in it links without a panic (`tests/embedded`).

use crate::scalar::{JOINTS, JointVector, Real};
use nalgebra::{Matrix3, Matrix6};

/// Cyclic Jacobi sweeps of a 3 × 3. Convergence is quadratic: four reach rounding in f64 from any
/// start.
const SWEEPS: usize = 6;

/// Factors P L U of a square matrix, by Gaussian elimination with row exchange.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lu<T: Real> {
    /// By rows: U on and above the diagonal, L below it without its unit diagonal.
    rows: [[T; JOINTS]; JOINTS],
    /// Which row of the matrix stands in each row.
    order: [usize; JOINTS],
}

impl<T: Real> Lu<T> {
    /// Factors the matrix; `None` where a pivot is not above `least` times the largest.
    pub(crate) fn new(matrix: &Matrix6<T>, least: T) -> Option<Self> {
        let mut rows: [[T; JOINTS]; JOINTS] = matrix.transpose().data.0;
        let mut order: [usize; JOINTS] = core::array::from_fn(|i| i);
        let mut size = [T::zero(); JOINTS];
        for k in 0..JOINTS {
            let mut best = k;
            for i in k + 1..JOINTS {
                if rows[i][k].abs() > rows[best][k].abs() {
                    best = i;
                }
            }
            rows.swap(k, best);
            order.swap(k, best);
            let pivot = rows[k];
            size[k] = pivot[k].abs();
            let reciprocal = pivot[k].recip();
            for row in &mut rows[k + 1..] {
                row[k] *= reciprocal;
                for j in k + 1..JOINTS {
                    let product = row[k] * pivot[j];
                    row[j] -= product;
                }
            }
        }
        let largest = size.iter().fold(T::zero(), |largest, s| largest.max(*s));
        size.iter().all(|s| *s > largest * least).then_some(Self { rows, order })
    }

    /// x of A x = b.
    pub(crate) fn solve(&self, b: &JointVector<T>) -> JointVector<T> {
        // Every row is there; an index would be checked, because the order is only known when the
        // program runs.
        let mut x =
            JointVector::from_fn(|i, _| b.get(self.order[i]).copied().unwrap_or_else(T::zero));
        for k in 0..JOINTS {
            for i in k + 1..JOINTS {
                let product = self.rows[i][k] * x[k];
                x[i] -= product;
            }
        }
        for k in (0..JOINTS).rev() {
            x[k] /= self.rows[k][k];
            for i in 0..k {
                let product = self.rows[i][k] * x[k];
                x[i] -= product;
            }
        }
        x
    }
}

/// Eigenvalues of a symmetric matrix, in no order, by Jacobi's rotations (Golub, Van Loan, Matrix
/// Computations, 8.5). The upper triangle is not looked at.
pub(crate) fn symmetric_eigenvalues<T: Real>(m: &Matrix3<T>) -> [T; 3] {
    let mut diagonal = [m.m11, m.m22, m.m33];
    // Beside each index the entry of the other two.
    let mut opposite = [m.m32, m.m31, m.m21];
    for _ in 0..SWEEPS {
        for (k, p, q) in [(0, 1, 2), (1, 2, 0), (2, 0, 1)] {
            let entry = opposite[k];
            if entry.is_zero() {
                continue;
            }
            // The smaller of the two angles that turn the entry to zero.
            let cot2 = (diagonal[q] - diagonal[p]) / (entry + entry);
            let tan = cot2.signum() / (cot2.abs() + (cot2 * cot2 + T::one()).sqrt());
            let cos = (tan * tan + T::one()).sqrt().recip();
            let sin = tan * cos;
            diagonal[p] -= tan * entry;
            diagonal[q] += tan * entry;
            opposite[k] = T::zero();
            // The entries of k with p and with q stand opposite to q and to p.
            let (kp, kq) = (opposite[q], opposite[p]);
            opposite[q] = cos * kp - sin * kq;
            opposite[p] = sin * kp + cos * kq;
        }
    }
    diagonal
}
