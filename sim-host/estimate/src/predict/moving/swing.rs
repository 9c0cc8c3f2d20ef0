//! What the tracker's first rows tell of how the links swing.

use nalgebra::{DMatrix, DVector, SVector};

/// Links that start elsewhere than the motors' motion asks for: angles, rad, then rates, rad/s.
pub(super) type Elsewhere = SVector<f64, 12>;

/// How the start of the links follows from what is left of the first rows: a step of Gauss and Newton
/// towards the likeliest start, of which it is known how far off it may be.
#[derive(Debug, Clone)]
pub struct SwingGain {
    /// Angles, rad, and rates, rad/s, per residual of the tracker's position at these rows.
    by_residual: DMatrix<f64>,
    /// By how much they are drawn back, per angle and rate.
    by_start: DMatrix<f64>,
}

impl SwingGain {
    /// The step from a start with what it leaves.
    pub(super) fn step(&self, elsewhere: &Elsewhere, left: &DVector<f64>) -> Elsewhere {
        let step = &self.by_residual * left - &self.by_start * elsewhere;
        Elsewhere::from_column_slice(step.as_slice())
    }
}

/// How what was seen in the first rows tells the start of the links.
#[derive(Debug, Clone)]
pub(super) struct Swing {
    pub(super) rows: Vec<usize>,
    /// Lowest natural frequency of the arm, rad/s.
    pub(super) lowest: f64,
    /// Variance of the tracker's position, m².
    pub(super) variance: [f64; 3],
}

impl Swing {
    /// What an angle, rad, or a rate, rad/s, may start elsewhere by.
    pub(super) fn size(&self, k: usize) -> f64 {
        if k < 6 { SWINGS } else { SWINGS * self.lowest }
    }

    /// True where a change of the start is next to nothing: it moves the tool by less than a hundredth
    /// of a tracker's noise.
    pub(super) fn has_settled(&self, by: &Elsewhere) -> bool {
        /// Share of what the start may be off by.
        const SETTLED_SHARE: f64 = 1e-4;
        by.iter().enumerate().all(|(k, by)| by.abs() < SETTLED_SHARE * self.size(k))
    }

    /// Slopes over their noise, and the normal equations.
    pub(super) fn normal(&self, slopes: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
        let weighted =
            DMatrix::from_fn(slopes.nrows(), 18, |r, k| slopes[(r, k)] / self.variance[r % 3]);
        let normal = slopes.tr_mul(&weighted) + DMatrix::identity(18, 18);
        (weighted, normal)
    }

    /// What residuals tell of the start, by these slopes.
    pub(super) fn gain(&self, slopes: &DMatrix<f64>) -> Option<SwingGain> {
        let (weighted, normal) = self.normal(slopes);
        let inverse = normal.cholesky()?.inverse();
        let mut by_residual = inverse.rows(0, 12) * weighted.transpose();
        (0..12).for_each(|k| by_residual.row_mut(k).scale_mut(self.size(k)));
        let by_start =
            DMatrix::from_fn(12, 12, |i, k| inverse[(i, k)] * self.size(i) / self.size(k));
        Some(SwingGain { by_residual, by_start })
    }
}

/// What an arm may swing by when a log begins, rad.
const SWINGS: f64 = 1e-3;
