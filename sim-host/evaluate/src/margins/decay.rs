//! The modes of a loop, from samples of what a kick leaves: dynamic mode decomposition
//! (Schmid 2010) of the samples in the subspace that holds most of them.

use nalgebra::{Complex, DMatrix, DVector};

/// A mode of a sampled linear system.
#[derive(Debug, Clone)]
pub(crate) struct SampledMode {
    /// Factor by which it changes from sample to sample.
    pub pole: Complex<f64>,
    /// Its share in every signal.
    pub shape: DVector<Complex<f64>>,
}

/// The modes in `samples`, one column a sample, one row a signal.
pub(crate) struct Modes {
    /// Directions that hold the samples.
    held: DMatrix<f64>,
    /// What a sample becomes in them.
    reduced: DMatrix<f64>,
    /// Factors by which the modes change from sample to sample.
    pub poles: Vec<Complex<f64>>,
}

impl Modes {
    /// Directions of the samples below `share` of the largest are taken for rounding. `None` where
    /// there is no number.
    pub(crate) fn of(samples: &DMatrix<f64>, share: f64) -> Option<Self> {
        let count = samples.ncols().checked_sub(1).filter(|n| *n > 0)?;
        if samples.iter().any(|v| !v.is_finite()) {
            return None;
        }
        let svd = samples.columns(0, count).into_owned().svd(true, true);
        let (u, v) = (svd.u?, svd.v_t?.transpose());
        let largest = svd.singular_values.max();
        let rank = svd.singular_values.iter().filter(|s| **s > share * largest).count();
        let (held, v) = (u.columns(0, rank).into_owned(), v.columns(0, rank));
        let mut reduced = held.transpose() * samples.columns(1, count) * v;
        for (mut column, value) in reduced.column_iter_mut().zip(svd.singular_values.iter()) {
            column /= *value;
        }
        let poles = reduced.complex_eigenvalues().iter().copied().collect();
        Some(Self { held, reduced, poles })
    }

    /// The mode with one of the poles.
    pub(crate) fn mode(&self, pole: Complex<f64>) -> Option<SampledMode> {
        // Inverse iteration from beside the pole.
        let rank = self.reduced.nrows();
        let beside = DMatrix::identity(rank, rank) * (pole * (1.0 + 1e-9));
        let factor = (self.reduced.map(Complex::from) - beside).lu();
        let mut shape = DVector::from_element(rank, Complex::new(1.0, 0.3));
        for _ in 0..3 {
            shape = factor.solve(&shape)?.normalize();
        }
        Some(SampledMode { pole, shape: self.held.map(Complex::from) * shape })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_modes_are_told_apart() {
        // 0.99 e^(±0.3j) beside a mode that dies three times as fast, of ten times the size.
        let signal = |k: usize, phase: f64| {
            let t = k as f64;
            0.99_f64.powf(t) * (0.3 * t + phase).cos() + 10.0 * 0.97_f64.powf(t)
        };
        let samples = DMatrix::from_fn(4, 200, |i, k| signal(k + 3 * i, 0.4 * i as f64));
        let modes = Modes::of(&samples, 1e-6).expect("numbers");
        let turning = modes.poles.iter().find(|pole| pole.im > 0.1).expect("one that turns");
        assert!((turning.norm() - 0.99).abs() < 1e-9, "{turning}");
        assert!((turning.arg() - 0.3).abs() < 1e-9, "{turning}");
        // Its shape: every signal is three samples and 0.4 rad before the next.
        let shape = modes.mode(*turning).expect("a shape").shape;
        let next = shape[1] / shape[0];
        assert!((next.norm() - 0.99_f64.powi(3)).abs() < 1e-6, "{next}");
        assert!((next.arg() - 1.3).abs() < 1e-6, "{next}");
    }
}
