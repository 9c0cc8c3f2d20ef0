//! Unknowns that a law estimates and keeps: a Kalman filter over readings of one number each.
//!
//! ```text
//! s = φᵀPφ + R,   ϑ ← ϑ + P φ r / s,   P ← P − P φ φᵀ P / s + Q
//! ```
//!
//! No variance exceeds its prior; ϑ stays within three prior deviations, and no compliance below
//! 0.3 of the model's.

use nalgebra::{SMatrix, SVector};
use trueweld_core::scalar::lit;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{JOINTS, Real};

/// An unknown is held within so many of its prior deviations.
const PRIOR_DEVIATIONS_MAX: f64 = 3.0;

/// Least relative compliance error: a joint is at most 1/0.3 times as stiff as the model says.
const COMPLIANCE_ERROR_MIN: f64 = -0.7;

/// `N` unknowns, the first six of them relative errors of the joints' compliances.
#[derive(Debug, Clone)]
pub(crate) struct Estimate<T: Real, const N: usize> {
    /// Standard deviations before anything is read.
    prior: SVector<T, N>,
    /// Q of one reading, its diagonal.
    growth: SVector<T, N>,
    unknown: SVector<T, N>,
    covariance: SMatrix<T, N, N>,
}

impl<T: Real, const N: usize> Estimate<T, N> {
    /// Nothing read yet. `growth`: of a reading, as a share of the prior variance.
    pub(crate) fn new(prior: SVector<T, N>, growth: &SVector<T, N>) -> Self {
        let variance = prior.component_mul(&prior);
        Self {
            prior,
            growth: variance.component_mul(growth),
            unknown: SVector::zeros(),
            covariance: SMatrix::from_diagonal(&variance),
        }
    }

    /// ϑ.
    pub(crate) fn unknown(&self) -> &SVector<T, N> {
        &self.unknown
    }

    /// Relative errors of the six compliances, each with its standard deviation.
    pub(crate) fn compliance(&self) -> [(T, T); JOINTS] {
        core::array::from_fn(|i| (self.unknown[i], self.covariance[(i, i)].max(T::zero()).sqrt()))
    }

    /// One reading: its row φ, what it reads beyond φᵀϑ, and its variance R. Changes nothing where
    /// φᵀPφ is below the share `excited` of R, or not finite.
    pub(crate) fn update(&mut self, row: &SVector<T, N>, innovation: T, noise: T, excited: T) {
        let spread = self.covariance * row;
        let told = row.dot(&spread);
        if !(told.is_finite() && innovation.is_finite()) || told < noise * excited {
            return;
        }
        let gain = spread / (told + noise);
        self.unknown += gain * innovation;
        self.covariance -= gain * spread.transpose();
        for i in 0..N {
            let most = self.prior[i] * self.prior[i];
            let grown = self.covariance[(i, i)] + self.growth[i];
            self.covariance[(i, i)] = grown.min(most).max(most * lit(1e-9));
            let reach = self.prior[i] * lit(PRIOR_DEVIATIONS_MAX);
            let least = if i < JOINTS { (-reach).max(lit(COMPLIANCE_ERROR_MIN)) } else { -reach };
            self.unknown[i] = self.unknown[i].max(least).min(reach);
        }
        // What rounding takes from its symmetry.
        let transposed = self.covariance.transpose();
        self.covariance = (self.covariance + transposed) * lit::<T>(0.5);
    }

    /// Unknowns from `first` on are again as before the first reading.
    pub(crate) fn forget_from(&mut self, first: usize) {
        for i in first..N {
            self.unknown[i] = T::zero();
            for j in 0..N {
                (self.covariance[(i, j)], self.covariance[(j, i)]) = (T::zero(), T::zero());
            }
            self.covariance[(i, i)] = self.prior[i] * self.prior[i];
        }
    }
}

impl<T: Real, const N: usize> Stateful for Estimate<T, N> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.matrix(&mut self.unknown)?;
        visitor.matrix(&mut self.covariance)
    }
}
