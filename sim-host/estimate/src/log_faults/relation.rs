//! A relation of series: what is measured per what is expected.

use nalgebra::{SMatrix, SVector};

/// Rows that a relation of two series rests on, at least.
pub(super) const RELATION_ROWS_MIN: usize = 12;

/// Correlation from which on measured follows predicted.
pub(super) const FOLLOWS: f64 = 0.85;

/// A torque that is so many times too large or too small is not an effect.
pub(super) const FACTOR: f64 = 8.0;

/// Sums of products of predicted x and measured y.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ProductSums {
    pub count: usize,
    pub xx: f64,
    pub xy: f64,
    pub yy: f64,
}

impl ProductSums {
    pub(crate) fn of(pairs: impl Iterator<Item = (f64, f64)>) -> Self {
        pairs.filter(|(x, y)| x.is_finite() && y.is_finite()).fold(Self::default(), |s, (x, y)| {
            Self { count: s.count + 1, xx: s.xx + x * x, xy: s.xy + x * y, yy: s.yy + y * y }
        })
    }

    /// Measured per predicted.
    pub(crate) fn slope(&self) -> f64 {
        self.xy / self.xx
    }

    /// Standard deviation of the slope, of independent errors.
    pub(crate) fn slope_deviation(&self) -> f64 {
        let errors = self.left(self.slope()).max(0.0) / self.count.max(1) as f64;
        (errors / self.xx).sqrt()
    }

    pub(crate) fn correlation(&self) -> f64 {
        self.xy / (self.xx * self.yy).sqrt()
    }

    /// Sum of squares that is left of the measured with the predicted taken so many times.
    pub(crate) fn left(&self, factor: f64) -> f64 {
        self.yy - 2.0 * factor * self.xy + factor * factor * self.xx
    }

    /// Root mean square of a sum of squares.
    pub(crate) fn root(&self, sum: f64) -> f64 {
        (sum.max(0.0) / self.count.max(1) as f64).sqrt()
    }

    /// Larger root mean square of both.
    pub(crate) fn size(&self) -> f64 {
        self.root(self.xx.max(self.yy))
    }
}

/// Least squares of y on regressors x: the coefficients with their covariance, of independent errors.
/// `None` for too few rows.
pub(super) fn regression<const N: usize>(
    pairs: impl Iterator<Item = (SVector<f64, N>, f64)>,
) -> Option<(SVector<f64, N>, SMatrix<f64, N, N>)> {
    let mut normal = SMatrix::<f64, N, N>::zeros();
    let mut right = SVector::<f64, N>::zeros();
    let (mut squares, mut count) = (0.0, 0usize);
    for (x, y) in pairs.filter(|(_, y)| y.is_finite()) {
        normal += x * x.transpose();
        right += x * y;
        squares += y * y;
        count += 1;
    }
    let least = 1e-9 * normal.trace();
    (0..N).for_each(|k| normal[(k, k)] += least);
    let inverse = normal.try_inverse()?;
    let found = inverse * right;
    let variance = (squares - found.dot(&right)).max(0.0)
        / count.checked_sub(RELATION_ROWS_MIN)?.max(1) as f64;
    Some((found, inverse * variance))
}
