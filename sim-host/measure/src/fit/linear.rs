//! The linear model at a point of a fit, as normal equations in blocks of time, and its solutions:
//! damped, with some values held, with a block left out.

use super::{BLOCKS, Residuals, Slopes};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Normal equations of a linear model in blocks: Σ (r + A u)² over each block.
#[derive(Debug, Clone)]
pub struct Linear {
    /// AᵀA of each block.
    pub square: Vec<DMatrix<f64>>,
    /// Aᵀr of each block.
    pub slope: Vec<DVector<f64>>,
    /// rᵀr of each block.
    pub rest: Vec<f64>,
    /// Number of residuals in each block.
    pub count: Vec<usize>,
    /// Weight of each prior.
    pub weight: DVector<f64>,
    /// Distance from what was expected.
    pub away: DVector<f64>,
    /// Weight of what each value is drawn to where a block is left out, and the distance from
    /// there.
    pub hold: (DVector<f64>, DVector<f64>),
}

impl Linear {
    /// The normal equations from residuals and slopes.
    pub fn new(
        blocks: &[Vec<u8>],
        at: &Residuals,
        slopes: &[&Slopes],
        weight: DVector<f64>,
        away: DVector<f64>,
    ) -> Self {
        let n = slopes.len();
        let mut linear = Self {
            square: vec![DMatrix::zeros(n, n); BLOCKS],
            slope: vec![DVector::zeros(n); BLOCKS],
            rest: vec![0.0; BLOCKS],
            count: vec![0; BLOCKS],
            weight,
            away,
            hold: (DVector::zeros(n), DVector::zeros(n)),
        };
        for (log, blocks) in blocks.iter().enumerate() {
            let r = &at[log].residual;
            let seen: Vec<(usize, &[f64])> = slopes
                .iter()
                .enumerate()
                .filter_map(|(k, s)| s[log].as_deref().map(|c| (k, c)))
                .collect();
            for run in runs(blocks) {
                let b = blocks[run.start] as usize;
                let r = &r[run.clone()];
                linear.rest[b] += dot(r, r);
                linear.count[b] += r.len();
                for (i, (k, a)) in seen.iter().enumerate() {
                    let a = &a[run.clone()];
                    linear.slope[b][*k] += dot(a, r);
                    for (l, c) in &seen[..=i] {
                        linear.square[b][(*k, *l)] += dot(a, &c[run.clone()]);
                    }
                }
            }
        }
        for square in &mut linear.square {
            square.fill_upper_triangle_with_lower_triangle();
        }
        linear
    }

    /// The same with more values, of which nothing is known beforehand: `known` are the slopes of
    /// those it has.
    pub fn extended(
        &self,
        blocks: &[Vec<u8>],
        at: &Residuals,
        known: &[Slopes],
        more: &[Slopes],
    ) -> Self {
        let (n, m) = (self.weight.len(), more.len());
        let mut linear = self.clone();
        for b in 0..BLOCKS {
            linear.square[b] = self.square[b].clone().resize(n + m, n + m, 0.0);
            linear.slope[b] = self.slope[b].clone().resize_vertically(n + m, 0.0);
        }
        linear.weight = self.weight.clone().resize_vertically(n + m, 0.0);
        linear.away = self.away.clone().resize_vertically(n + m, 0.0);
        linear.hold.0 = self.hold.0.clone().resize_vertically(n + m, 0.0);
        linear.hold.1 = self.hold.1.clone().resize_vertically(n + m, 0.0);
        for (log, blocks) in blocks.iter().enumerate() {
            let r = &at[log].residual;
            let column = |k: usize| {
                if k < n { known[k][log].as_deref() } else { more[k - n][log].as_deref() }
            };
            for (i, new) in more.iter().enumerate() {
                let Some(new) = new[log].as_deref() else {
                    continue;
                };
                for run in runs(blocks) {
                    let b = blocks[run.start] as usize;
                    let a = &new[run.clone()];
                    linear.slope[b][n + i] += dot(a, &r[run.clone()]);
                    for k in 0..=n + i {
                        let Some(c) = column(k) else { continue };
                        let product = dot(a, &c[run.clone()]);
                        linear.square[b][(n + i, k)] += product;
                        if k != n + i {
                            linear.square[b][(k, n + i)] += product;
                        }
                    }
                }
            }
        }
        linear
    }

    /// The same slopes beside other residuals.
    pub(crate) fn beside(&self, blocks: &[Vec<u8>], at: &Residuals, slopes: &[Slopes]) -> Self {
        let mut linear = self.clone();
        linear.slope.iter_mut().for_each(|s| s.fill(0.0));
        linear.rest.fill(0.0);
        for (log, blocks) in blocks.iter().enumerate() {
            let r = &at[log].residual;
            for run in runs(blocks) {
                let b = blocks[run.start] as usize;
                linear.rest[b] += dot(&r[run.clone()], &r[run.clone()]);
                for (k, slope) in slopes.iter().enumerate() {
                    if let Some(a) = &slope[log] {
                        linear.slope[b][k] += dot(&a[run.clone()], &r[run.clone()]);
                    }
                }
            }
        }
        linear
    }

    /// Sums over all blocks but one (`None`: over all).
    fn without(&self, left_out: Option<usize>) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.weight.len();
        let (mut square, mut slope) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for b in (0..BLOCKS).filter(|b| Some(*b) != left_out) {
            square += &self.square[b];
            slope += &self.slope[b];
        }
        for k in 0..n {
            square[(k, k)] += self.weight[k];
            slope[k] += self.weight[k] * self.away[k];
            if left_out.is_some() {
                square[(k, k)] += self.hold.0[k];
                slope[k] += self.hold.0[k] * self.hold.1[k];
            }
        }
        (square, slope)
    }

    /// The best step with `damping` on the diagonal, and the covariance of the values there, in the
    /// fit's units. `only`: the values that are free; the others stay.
    pub fn solve(
        &self,
        left_out: Option<usize>,
        damping: f64,
        only: Option<&[usize]>,
    ) -> Option<Step> {
        self.solve_beside(&DVector::zeros(self.weight.len()), left_out, damping, only)
    }

    /// The same where the values that are not free step by what `fixed` says; it is 0 for those
    /// that are.
    pub(super) fn solve_beside(
        &self,
        fixed: &DVector<f64>,
        left_out: Option<usize>,
        damping: f64,
        only: Option<&[usize]>,
    ) -> Option<Step> {
        let (square, slope) = self.without(left_out);
        let slope = slope + &square * fixed;
        let n = self.weight.len();
        let every: Vec<usize> = (0..n).collect();
        let only = only.unwrap_or(&every);
        let m = only.len();
        let mut reduced = DMatrix::from_fn(m, m, |i, j| square[(only[i], only[j])]);
        let right = DVector::from_fn(m, |i, _| slope[only[i]]);
        // Scaled to ones on the diagonal; a value that nothing depends on stays where it is.
        let scale = DVector::from_fn(m, |i, _| {
            if reduced[(i, i)] > 0.0 { reduced[(i, i)].sqrt().recip() } else { 1.0 }
        });
        for i in 0..m {
            for j in 0..m {
                reduced[(i, j)] *= scale[i] * scale[j];
            }
            reduced[(i, i)] += damping + 1e-10;
        }
        let factor = reduced.cholesky()?;
        let step = factor.solve(&right.component_mul(&scale)).component_mul(&scale);
        let mut full = fixed.clone();
        for (i, k) in only.iter().enumerate() {
            full[*k] = -step[i];
        }
        Some(Step { step: full, only: only.to_vec(), scale, factor })
    }

    /// Factor of the normal equations over all blocks, priors with them.
    pub(crate) fn factor(&self) -> Option<Cholesky<f64, Dyn>> {
        let (mut square, _) = self.without(None);
        for k in 0..square.nrows() {
            square[(k, k)] = square[(k, k)] * (1.0 + 1e-10) + 1e-12;
        }
        square.cholesky()
    }

    /// The least cost with only `kept` values free and all others at nothing, and the step that
    /// leads there.
    pub fn with_only(&self, kept: &[usize]) -> Option<(f64, DVector<f64>)> {
        let (square, slope) = self.without(None);
        let n = self.weight.len();
        let mut step = -&self.away;
        for k in kept {
            step[*k] = 0.0;
        }
        let right = slope + &square * &step;
        let m = kept.len();
        let scale =
            DVector::from_fn(m, |i, _| square[(kept[i], kept[i])].max(1e-30).sqrt().recip());
        let mut reduced =
            DMatrix::from_fn(m, m, |i, j| square[(kept[i], kept[j])] * scale[i] * scale[j]);
        for i in 0..m {
            reduced[(i, i)] += 1e-10;
        }
        let found =
            reduced.cholesky()?.solve(&DVector::from_fn(m, |i, _| right[kept[i]] * scale[i]));
        for i in 0..m {
            step[kept[i]] = -found[i] * scale[i];
        }
        debug_assert_eq!(step.len(), n);
        Some((self.cost(&step), step))
    }

    /// Sum of squares in all blocks after a step, without priors.
    pub fn after(&self, step: &DVector<f64>) -> f64 {
        (0..BLOCKS).map(|b| self.block_after(b, step)).sum()
    }

    /// Sum of squares and priors together, after a step.
    pub fn cost(&self, step: &DVector<f64>) -> f64 {
        let prior: f64 =
            (0..step.len()).map(|k| self.weight[k] * (self.away[k] + step[k]).powi(2)).sum();
        self.after(step) + prior
    }

    fn block_after(&self, b: usize, step: &DVector<f64>) -> f64 {
        self.rest[b] + 2.0 * self.slope[b].dot(step) + (&self.square[b] * step).dot(step)
    }

    /// Sum of squares of each block, predicted from all the others.
    pub fn held_out(&self, only: Option<&[usize]>) -> Vec<f64> {
        (0..BLOCKS)
            .map(|b| match self.solve(Some(b), 0.0, only) {
                Some(found) => self.block_after(b, &found.step),
                None => self.rest[b],
            })
            .collect()
    }
}

/// The step to the least sum of squares of a linear model.
#[derive(Debug, Clone)]
pub struct Step {
    /// Of all values, in the fit's units.
    pub step: DVector<f64>,
    only: Vec<usize>,
    scale: DVector<f64>,
    factor: Cholesky<f64, Dyn>,
}

impl Step {
    /// Standard deviations of the free values, in the fit's units; 0 for those that stay.
    pub fn deviations(&self) -> DVector<f64> {
        let covariance = self.factor.inverse();
        let mut all = DVector::zeros(self.step.len());
        for (i, k) in self.only.iter().enumerate() {
            all[*k] = covariance[(i, i)].max(0.0).sqrt() * self.scale[i];
        }
        all
    }
}

/// Stretches of equal values.
fn runs(blocks: &[u8]) -> Vec<std::ops::Range<usize>> {
    let mut runs = Vec::new();
    let mut start = 0;
    for k in 1..=blocks.len() {
        if k == blocks.len() || blocks[k] != blocks[start] {
            runs.push(start..k);
            start = k;
        }
    }
    runs
}

pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    // Four sums, so that they can run side by side.
    let mut sums = [0.0; 4];
    let (fours, rest) = a.as_chunks::<4>();
    let (others, other_rest) = b.as_chunks::<4>();
    for (x, y) in fours.iter().zip(others) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + rest.iter().zip(other_rest).map(|(x, y)| x * y).sum::<f64>()
}
