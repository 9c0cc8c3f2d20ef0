//! The linear model at a point of a fit, as normal equations in blocks of time, and its solutions:
//! damped, with some values held, with a block left out.

use super::{BLOCKS, Residuals, Slopes};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use std::ops::Range;
use trueweld_logs::fir::dot;

/// Normal equations of a linear model in blocks: Σ (r + J u)² over each block.
#[derive(Debug, Clone)]
pub struct Linear {
    /// JᵀJ of each block.
    pub jtj: Vec<DMatrix<f64>>,
    /// Jᵀr of each block.
    pub jtr: Vec<DVector<f64>>,
    /// rᵀr of each block.
    pub rss: Vec<f64>,
    /// Curvature of the priors: of what each value is expected to be, and how curves bend.
    pub prior: DMatrix<f64>,
    /// Distance from what was expected.
    pub away: DVector<f64>,
    /// What holds the values where a block is left out.
    pub held_out_prior: HeldOutPrior,
}

/// What values are drawn to where a block is left out: an effect of which the other blocks say
/// nothing is none, and what shapes it stays.
#[derive(Debug, Clone)]
pub struct HeldOutPrior {
    /// Weight on each value.
    pub weight: DVector<f64>,
    /// Distance from what it is drawn to.
    pub away: DVector<f64>,
    /// Values that shape an effect.
    pub shapes: Vec<usize>,
}

impl HeldOutPrior {
    /// Nothing holds so many values.
    pub fn none(values: usize) -> Self {
        Self { weight: DVector::zeros(values), away: DVector::zeros(values), shapes: Vec::new() }
    }
}

/// How far a value that shapes an effect may go where a block is left out, in deviations of what all
/// blocks tell: the only block in which a step lies tells where, and the edge of its neighbour does
/// not.
pub(super) const STAYS: f64 = 3.0;

/// Share of its diagonal that is added to normal equations: values that nothing tells apart stay together.
pub(super) const RIDGE: f64 = 1e-10;

impl Linear {
    /// The normal equations from residuals and slopes.
    pub fn new(
        blocks: &[Vec<u8>],
        at: &Residuals,
        slopes: &[&Slopes],
        prior: DMatrix<f64>,
        away: DVector<f64>,
    ) -> Self {
        Self { prior, away, ..Self::empty().renewed(blocks, at, slopes, |_| true) }
    }

    /// Of no values and no residuals.
    pub(super) fn empty() -> Self {
        Self {
            jtj: vec![DMatrix::zeros(0, 0); BLOCKS],
            jtr: vec![DVector::zeros(0); BLOCKS],
            rss: vec![0.0; BLOCKS],
            prior: DMatrix::zeros(0, 0),
            away: DVector::zeros(0),
            held_out_prior: HeldOutPrior::none(0),
        }
    }

    /// The same beside other residuals, with more values, of which nothing is known beforehand, or with
    /// other slopes of some: of those for which `is_new` is true. `slopes`: of all values.
    pub fn renewed(
        &self,
        blocks: &[Vec<u8>],
        at: &Residuals,
        slopes: &[&Slopes],
        is_new: impl Fn(usize) -> bool,
    ) -> Self {
        let (known, n) = (self.away.len(), slopes.len());
        let is_new: Vec<bool> = (0..n).map(|k| k >= known || is_new(k)).collect();
        let mut linear = self.with_more(n);
        linear.jtr = vec![DVector::zeros(n); BLOCKS];
        linear.rss = vec![0.0; BLOCKS];
        for (k, _) in is_new.iter().enumerate().filter(|(_, is_new)| **is_new) {
            for jtj in &mut linear.jtj {
                jtj.row_mut(k).fill(0.0);
                jtj.column_mut(k).fill(0.0);
            }
        }
        for (log, blocks) in blocks.iter().enumerate() {
            let seen: Vec<(usize, &[f64])> = slopes
                .iter()
                .enumerate()
                .filter_map(|(k, s)| s[log].as_deref().map(|c| (k, c)))
                .collect();
            for run in runs(blocks) {
                let b = blocks[run.start] as usize;
                let r = &at[log].residual[run.clone()];
                linear.rss[b] += dot(r, r);
                for (i, (k, a)) in seen.iter().enumerate() {
                    let a = &a[run.clone()];
                    linear.jtr[b][*k] += dot(a, r);
                    for (l, c) in seen[..=i].iter().filter(|(l, _)| is_new[*k] || is_new[*l]) {
                        let product = dot(a, &c[run.clone()]);
                        linear.jtj[b][(*k, *l)] += product;
                        if k != l {
                            linear.jtj[b][(*l, *k)] += product;
                        }
                    }
                }
            }
        }
        linear
    }

    /// The same with so many values, of the last of which nothing is known and no slope.
    fn with_more(&self, values: usize) -> Self {
        let longer = |v: &DVector<f64>| v.clone().resize_vertically(values, 0.0);
        Self {
            jtj: self.jtj.iter().map(|s| s.clone().resize(values, values, 0.0)).collect(),
            jtr: self.jtr.iter().map(longer).collect(),
            rss: self.rss.clone(),
            prior: self.prior.clone().resize(values, values, 0.0),
            away: longer(&self.away),
            held_out_prior: HeldOutPrior {
                weight: longer(&self.held_out_prior.weight),
                away: longer(&self.held_out_prior.away),
                shapes: self.held_out_prior.shapes.clone(),
            },
        }
    }

    /// The same with one value more for each of `sums`, which moves all values of that list alike and of
    /// which is known what is known of the first of them: one for all logs in place of one for each.
    pub fn with_sums(&self, sums: &[Vec<usize>]) -> Self {
        let (n, all) = (self.away.len(), self.away.len() + sums.len());
        let mut to = DMatrix::identity(n, all);
        let mut with_sums = self.with_more(all);
        for (k, sum) in sums.iter().enumerate() {
            sum.iter().for_each(|i| to[(*i, n + k)] = 1.0);
            with_sums.prior[(n + k, n + k)] = self.prior[(sum[0], sum[0])];
        }
        with_sums.jtj = self.jtj.iter().map(|jtj| to.tr_mul(jtj) * &to).collect();
        with_sums.jtr = self.jtr.iter().map(|jtr| to.tr_mul(jtr)).collect();
        with_sums
    }

    /// JᵀJ over all blocks but one (`None`: over all), so many times smaller, and the priors.
    pub fn information(&self, left_out: Option<usize>, inflation: f64) -> DMatrix<f64> {
        let mut jtj = self.prior.clone();
        let used = (0..BLOCKS).filter(|b| Some(*b) != left_out);
        used.for_each(|b| jtj.zip_apply(&self.jtj[b], |sum, v| *sum += v / inflation));
        jtj
    }

    /// Standard deviations of the values as the blocks' own pulls at them scatter, in the fit's
    /// units: residuals that follow each other, or are none of noise, count as they are. `None`
    /// where the values are not determined.
    pub fn scatter(&self) -> Option<DVector<f64>> {
        let factor = self.factor()?;
        let mean = self.jtr.iter().sum::<DVector<f64>>() / BLOCKS as f64;
        let pulled = self.jtr.iter().map(|jtr| factor.solve(&(jtr - &mean)));
        let squares: DVector<f64> = pulled.map(|pull| pull.component_mul(&pull)).sum();
        let few = BLOCKS as f64 / (BLOCKS - 1) as f64;
        Some(squares.map(|v| (v * few).sqrt()))
    }

    /// Sums over all blocks but one (`None`: over all).
    pub(super) fn without(&self, left_out: Option<usize>) -> (DMatrix<f64>, DVector<f64>) {
        let mut jtj = self.information(left_out, 1.0);
        if left_out.is_some() {
            jtj += DMatrix::from_diagonal(&self.held_out_prior.weight);
        }
        (jtj, self.jtr_without(left_out))
    }

    /// The same of the slopes alone.
    pub(super) fn jtr_without(&self, left_out: Option<usize>) -> DVector<f64> {
        let mut jtr = &self.prior * &self.away;
        (0..BLOCKS).filter(|b| Some(*b) != left_out).for_each(|b| jtr += &self.jtr[b]);
        if left_out.is_some() {
            jtr += self.held_out_prior.weight.component_mul(&self.held_out_prior.away);
        }
        jtr
    }

    /// The same of some columns of the squares.
    pub(super) fn columns_without(
        &self,
        left_out: Option<usize>,
        columns: &[usize],
    ) -> DMatrix<f64> {
        let mut jtj = self.prior.select_columns(columns);
        for (i, k) in columns.iter().enumerate() {
            let mut own = jtj.column_mut(i);
            for b in (0..BLOCKS).filter(|b| Some(*b) != left_out) {
                own += self.jtj[b].column(*k);
            }
            if left_out.is_some() {
                own[*k] += self.held_out_prior.weight[*k];
            }
        }
        jtj
    }

    /// The best step with `damping` on the diagonal, and the covariance of the values there, in the
    /// fit's units. `only`: the values that are free; the others stay.
    pub fn solve(
        &self,
        left_out: Option<usize>,
        damping: f64,
        only: Option<&[usize]>,
    ) -> Option<LeastSquaresStep> {
        self.solve_beside(&DVector::zeros(self.away.len()), left_out, damping, only)
    }

    /// The same where the values that are not free step by what `fixed` says; it is 0 for those
    /// that are.
    pub(super) fn solve_beside(
        &self,
        fixed: &DVector<f64>,
        left_out: Option<usize>,
        damping: f64,
        only: Option<&[usize]>,
    ) -> Option<LeastSquaresStep> {
        let (jtj, jtr) = self.without(left_out);
        let jtr = jtr + &jtj * fixed;
        let only = only.map_or_else(|| (0..jtr.len()).collect(), <[usize]>::to_vec);
        let factor = Factor::new(&jtj.select_rows(&only).select_columns(&only), damping)?;
        let step = factor.solve(&jtr.select_rows(&only));
        let mut full = fixed.clone();
        for (i, k) in only.iter().enumerate() {
            full[*k] = -step[i];
        }
        Some(LeastSquaresStep { step: full, only, factor })
    }

    /// Factor of the normal equations over all blocks, priors with them.
    pub fn factor(&self) -> Option<Factor> {
        Factor::new(&self.information(None, 1.0), 0.0)
    }

    /// The least cost with only `kept` values free and all others at nothing, and the step that
    /// leads there.
    pub fn with_only(&self, kept: &[usize]) -> Option<(f64, DVector<f64>)> {
        let mut nothing = -&self.away;
        kept.iter().for_each(|k| nothing[*k] = 0.0);
        let step = self.solve_beside(&nothing, None, 0.0, Some(kept))?.step;
        Some((self.cost(&step), step))
    }

    /// Sum of squares in all blocks after a step, without priors.
    pub fn after(&self, step: &DVector<f64>) -> f64 {
        (0..BLOCKS).map(|b| self.block_after(b, step)).sum()
    }

    /// Sum of squares and priors together, after a step.
    pub fn cost(&self, step: &DVector<f64>) -> f64 {
        let away = &self.away + step;
        self.after(step) + (&self.prior * &away).dot(&away)
    }

    fn block_after(&self, b: usize, step: &DVector<f64>) -> f64 {
        self.rss[b] + 2.0 * self.jtr[b].dot(step) + (&self.jtj[b] * step).dot(step)
    }

    /// The same with the values that shape effects held to what all blocks tell of them; `None`
    /// where there are none.
    fn staying(&self, only: Option<&[usize]>) -> Option<Self> {
        if self.held_out_prior.shapes.is_empty() {
            return None;
        }
        let deviations = self.solve(None, 0.0, only)?.deviations();
        let mut held = self.clone();
        for &k in &self.held_out_prior.shapes {
            let weight = (STAYS * deviations[k]).powi(-2);
            if weight.is_finite() {
                held.held_out_prior.weight[k] = held.held_out_prior.weight[k].max(weight);
            }
        }
        Some(held)
    }

    /// The step that all blocks but one ask for; `own`, the values that this one alone shows, are
    /// those that it asks for beside it. `None` where the others do not determine it.
    pub(super) fn step_from_others(&self, block: usize, own: &[usize]) -> Option<DVector<f64>> {
        let staying = self.staying(None);
        let held = staying.as_ref().unwrap_or(self);
        let others: Vec<usize> = (0..self.away.len()).filter(|k| !own.contains(k)).collect();
        let step = held.solve(Some(block), 0.0, Some(&others))?.step;
        if own.is_empty() {
            return Some(step);
        }
        Some(self.solve_beside(&step, None, 0.0, Some(own))?.step)
    }

    /// The step of each block from all the others; `None` where these do not determine it.
    fn steps_from_others(&self, only: Option<&[usize]>) -> Vec<Option<DVector<f64>>> {
        let staying = self.staying(only);
        let held = staying.as_ref().unwrap_or(self);
        (0..BLOCKS).map(|b| Some(held.solve(Some(b), 0.0, only)?.step)).collect()
    }

    /// What all the others tell of a block, and what they tell with it; `None` where that does not
    /// determine the values.
    fn prediction_of(&self, block: usize) -> Option<BlockPrediction> {
        let (others, pull) = self.without(Some(block));
        let all = &others + &self.jtj[block];
        let (from_others, from_all) = (Factor::new(&others, 0.0)?, Factor::new(&all, 0.0)?);
        let step = -from_all.solve(&(&pull + &self.jtr[block]));
        let change = &step + from_others.solve(&pull);
        let disagreement = change.dot(&(&others * &change));
        let volume = from_all.log_determinant() - from_others.log_determinant();
        Some(BlockPrediction { step, change, disagreement, volume })
    }

    /// Logarithm of the probability of each block's residuals given all the others', summed, but for a
    /// constant, nats. Values are as uncertain as the others leave them: with V = W⁻¹ + J C Jᵀ, C their
    /// covariance, it is −½ (eᵀ V⁻¹ e + ln |V W|), which is what the block leaves with its own part in
    /// the fit, what that moved the values by against what the others say, and by how much it narrowed
    /// them (Bernardo and Smith 1994, 6.1.6). `precision`: W, by log and value.
    pub(super) fn log_score_from_others(
        &self,
        blocks: &[Vec<u8>],
        (at, slopes): (&Residuals, &[Slopes]),
        precision: &[Vec<f64>],
    ) -> f64 {
        let predictions: Vec<_> = (0..BLOCKS).map(|block| self.prediction_of(block)).collect();
        // Squares left, and of what the block's own part changes, with its weights and without.
        let (mut left, mut changed, mut plain) = (0.0, [0.0; BLOCKS], [0.0; BLOCKS]);
        for (log, blocks) in blocks.iter().enumerate() {
            let seen: Vec<(usize, &[f64])> = slopes
                .iter()
                .enumerate()
                .filter_map(|(k, s)| Some((k, s[log].as_deref()?)))
                .collect();
            for run in runs(blocks) {
                let block = usize::from(blocks[run.start]);
                let mut residual = at[log].residual[run.clone()].to_vec();
                let mut change = vec![0.0; residual.len()];
                if let Some(prediction) = &predictions[block] {
                    for (k, slope) in &seen {
                        let (step, own) = (prediction.step[*k], prediction.change[*k]);
                        for ((r, c), a) in
                            residual.iter_mut().zip(&mut change).zip(&slope[run.clone()])
                        {
                            *r += a * step;
                            *c += a * own;
                        }
                    }
                }
                for ((r, c), w) in residual.iter().zip(&change).zip(&precision[log][run]) {
                    left += w * r * r;
                    changed[block] += w * c * c;
                    plain[block] += c * c;
                }
            }
        }
        let of_block = |(block, prediction): (usize, &Option<BlockPrediction>)| {
            let Some(prediction) = prediction else { return 0.0 };
            let weight = if plain[block] > 0.0 { changed[block] / plain[block] } else { 0.0 };
            weight * prediction.disagreement + prediction.volume
        };
        -0.5 * (left + predictions.iter().enumerate().map(of_block).sum::<f64>())
    }

    /// Sum of squares of each block, predicted from all the others.
    pub fn held_out(&self, only: Option<&[usize]>) -> Vec<f64> {
        let steps = self.steps_from_others(only).into_iter().enumerate();
        steps.map(|(b, step)| step.map_or(self.rss[b], |s| self.block_after(b, &s))).collect()
    }

    /// Residuals of each log, every block predicted from all the others. `at`, `slopes`: what this
    /// is the linear model of.
    pub(super) fn residuals_from_others(
        &self,
        blocks: &[Vec<u8>],
        at: &Residuals,
        slopes: &[Slopes],
    ) -> Vec<Vec<f64>> {
        let steps = self.steps_from_others(None);
        let mut residuals: Vec<Vec<f64>> = at.iter().map(|at| at.residual.clone()).collect();
        for (log, (residual, blocks)) in residuals.iter_mut().zip(blocks).enumerate() {
            for (k, column) in slopes.iter().enumerate() {
                let Some(column) = &column[log] else { continue };
                for ((r, a), b) in residual.iter_mut().zip(column).zip(blocks) {
                    *r += a * steps[usize::from(*b)].as_ref().map_or(0.0, |step| step[k]);
                }
            }
        }
        residuals
    }
}

/// What one block adds to what all the others tell.
struct BlockPrediction {
    /// The step that all ask for.
    step: DVector<f64>,
    /// By how much it differs from that of the others.
    change: DVector<f64>,
    /// What that costs by the others.
    disagreement: f64,
    /// Logarithm of the ratio of the squared volumes that the values are known to, without the block
    /// and with it.
    volume: f64,
}

/// Factor of normal equations, scaled to ones on the diagonal; a value that nothing depends on
/// stays where it is.
#[derive(Debug, Clone)]
pub struct Factor {
    scale: DVector<f64>,
    cholesky: Cholesky<f64, Dyn>,
}

impl Factor {
    /// With `damping` added to the ones; `None` where that is not positive definite.
    pub fn new(jtj: &DMatrix<f64>, damping: f64) -> Option<Self> {
        let scale = jtj.diagonal().map(|own| if own > 0.0 { own.sqrt().recip() } else { 1.0 });
        let mut scaled = jtj.component_mul(&(&scale * scale.transpose()));
        (0..scale.len()).for_each(|i| scaled[(i, i)] += damping + RIDGE);
        Some(Self { scale, cholesky: scaled.cholesky()? })
    }

    /// The solution for a right side, a vector or several.
    pub fn solve<C: nalgebra::Dim>(&self, right: &RightSides<C>) -> RightSides<C>
    where
        nalgebra::DefaultAllocator: nalgebra::allocator::Allocator<Dyn, C>,
    {
        let scaled = |m: &RightSides<C>| {
            let mut m = m.clone();
            m.row_iter_mut().zip(&self.scale).for_each(|(mut row, s)| row *= *s);
            m
        };
        scaled(&self.cholesky.solve(&scaled(right)))
    }

    /// Logarithm of the determinant of the normal equations.
    fn log_determinant(&self) -> f64 {
        let logarithms = |values: &DVector<f64>| values.iter().map(|v| v.ln()).sum::<f64>();
        2.0 * (logarithms(&self.cholesky.l_dirty().diagonal()) - logarithms(&self.scale))
    }

    /// Standard deviations of the values.
    pub(crate) fn deviations(&self) -> DVector<f64> {
        let covariance = self.cholesky.inverse().diagonal();
        covariance.map(|v| v.max(0.0).sqrt()).component_mul(&self.scale)
    }
}

/// Right sides of normal equations.
type RightSides<C> = nalgebra::OMatrix<f64, Dyn, C>;

/// The step to the least sum of squares of a linear model.
#[derive(Debug, Clone)]
pub struct LeastSquaresStep {
    /// Of all values, in the fit's units.
    pub step: DVector<f64>,
    only: Vec<usize>,
    factor: Factor,
}

impl LeastSquaresStep {
    /// Standard deviations of the free values, in the fit's units; 0 for those that stay.
    pub fn deviations(&self) -> DVector<f64> {
        let mut all = DVector::zeros(self.step.len());
        let own = self.factor.deviations();
        self.only.iter().zip(own.iter()).for_each(|(k, d)| all[*k] = *d);
        all
    }
}

/// Stretches of equal values.
fn runs(blocks: &[u8]) -> Vec<Range<usize>> {
    let mut start = 0;
    let run = |same: &[u8]| {
        let from = start;
        start += same.len();
        from..start
    };
    blocks.chunk_by(|a, b| a == b).map(run).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::predict::Prediction;

    #[test]
    fn what_is_renewed_is_as_if_it_were_new() {
        let at = |unit: f64| -> Residuals {
            let residual = (0..20).map(|k| unit * (f64::from(k % 7) - 2.5)).collect();
            vec![Prediction { residual, motion: None, late: None, not_evidence: 0.0, noise: None }]
        };
        let blocks: Vec<Vec<u8>> = vec![(0..20).map(|k| k / 2).collect()];
        let slopes = |rate: f64| -> Slopes {
            vec![Some((0..20).map(|k| (rate * f64::from(k)).sin()).collect())]
        };
        let new = |at: &Residuals, slopes: &[&Slopes]| {
            let n = slopes.len();
            Linear::new(&blocks, at, slopes, DMatrix::zeros(n, n), DVector::zeros(n))
        };
        let (first, other, more) = (slopes(1.0), slopes(0.4), slopes(0.7));
        let before = new(&at(2.0), &[&first, &first]);
        let after = [&other, &first, &more];
        let renewed = before.renewed(&blocks, &at(1.0), &after, |k| k == 0);
        let new = new(&at(1.0), &after);
        assert_eq!(renewed.held_out(None), new.held_out(None));
        assert_eq!((renewed.jtj, renewed.jtr, renewed.rss), (new.jtj, new.jtr, new.rss));
        assert_eq!((renewed.prior, renewed.away), (new.prior, new.away));
    }

    #[test]
    fn the_score_of_a_block_is_its_probability_given_all_others() {
        // Two values, one that all blocks show and one with a prior that the first blocks do.
        let n = 40;
        let draw = |k: usize| f64::from((k * 7919 % 97) as u8) / 40.0 - 1.2;
        let residual: Vec<f64> = (0..n).map(draw).collect();
        let shown: [Vec<f64>; 2] = [
            (0..n).map(|k| draw(k + 50)).collect(),
            (0..n).map(|k| if k < 14 { draw(k + 90) } else { 0.0 }).collect(),
        ];
        let at: Residuals = vec![Prediction {
            residual: residual.clone(),
            motion: None,
            late: None,
            not_evidence: 0.0,
            noise: None,
        }];
        let blocks: Vec<Vec<u8>> = vec![(0..n).map(|k| (k * BLOCKS / n) as u8).collect()];
        let slopes: Vec<Slopes> = shown.iter().map(|s| vec![Some(s.clone())]).collect();
        let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![0.3, 2.0]));
        let away = DVector::from_vec(vec![0.1, -0.4]);
        let columns: Vec<&Slopes> = slopes.iter().collect();
        let linear = Linear::new(&blocks, &at, &columns, prior.clone(), away.clone());
        let weight = 0.7;
        let score = linear.log_score_from_others(&blocks, (&at, &slopes), &[vec![weight; n]]);

        let j = DMatrix::from_fn(n, 2, |i, k| shown[k][i]);
        let r = DVector::from_vec(residual);
        let expected: f64 = (0..BLOCKS)
            .map(|block| {
                let (own, others): (Vec<usize>, Vec<usize>) =
                    (0..n).partition(|k| usize::from(blocks[0][*k]) == block);
                let (jo, ro) = (j.select_rows(&others), r.select_rows(&others));
                let (jb, rb) = (j.select_rows(&own), r.select_rows(&own));
                let information = jo.tr_mul(&jo) + &prior;
                let covariance = information.try_inverse().unwrap();
                let step = -(&covariance * (jo.tr_mul(&ro) + &prior * &away));
                let error = rb + &jb * step;
                // Everything is as uncertain as the weight says: the noise, and what it leaves.
                let spread =
                    DMatrix::identity(own.len(), own.len()) + &jb * &covariance * jb.transpose();
                let squares = error.dot(&(spread.clone().try_inverse().unwrap() * &error));
                -0.5 * (weight * squares + spread.determinant().ln())
            })
            .sum();
        assert!((score - expected).abs() < 1e-6, "{score} {expected}");
    }

    #[test]
    fn what_one_block_alone_tells_of_a_shape_stays_where_it_is_left_out() {
        // The first block tells it to a tenth, the second to ten, and is off by a half of that.
        let one = |value: f64| DMatrix::from_element(1, 1, value);
        let mut linear = Linear {
            jtj: vec![one(0.0); BLOCKS],
            jtr: vec![DVector::zeros(1); BLOCKS],
            rss: vec![1.0; BLOCKS],
            prior: DMatrix::zeros(1, 1),
            away: DVector::zeros(1),
            held_out_prior: HeldOutPrior::none(1),
        };
        (linear.jtj[0], linear.jtj[1]) = (one(100.0), one(0.01));
        linear.jtr[1][0] = -0.05;
        let of_size = linear.held_out(None)[0];
        linear.held_out_prior.shapes = vec![0];
        let of_shape = linear.held_out(None)[0];
        assert!((of_size - 2501.0).abs() < 1.0 && of_shape < 1.1, "{of_size} {of_shape}");
    }

    #[test]
    fn one_value_for_two_is_the_best_of_those_that_are_alike() {
        let block =
            |k: usize| DMatrix::from_fn(2, 2, |i, j| if i == j { 3.0 + k as f64 } else { 1.0 });
        let own = Linear {
            jtj: (0..BLOCKS).map(block).collect(),
            jtr: (0..BLOCKS).map(|k| DVector::from_vec(vec![k as f64, -2.0])).collect(),
            rss: vec![50.0; BLOCKS],
            prior: DMatrix::from_diagonal(&DVector::from_vec(vec![2.0, 5.0])),
            away: DVector::from_vec(vec![0.3, -0.1]),
            held_out_prior: HeldOutPrior::none(2),
        };
        let both = own.with_sums(&[vec![0, 1]]);
        let (cost, step) = both.with_only(&[2]).unwrap();
        let alike = |value: f64| DVector::from_vec(vec![value - 0.3, value + 0.1]);
        let of = |value: f64| own.after(&alike(value)) + 2.0 * value * value;
        let least = (-2000..2000).map(|v| of(f64::from(v) * 1e-3)).fold(f64::INFINITY, f64::min);
        assert!((cost - least).abs() < 1e-3 * least, "{cost} {least}");
        assert_eq!((step[0], step[1]), (-0.3, 0.1));
    }

    #[test]
    fn what_blocks_disagree_by_is_the_scatter_of_their_means() {
        // One value, the mean: the slope of each residual is −1, a block is ten of them.
        let off = |b: usize| if b.is_multiple_of(2) { 1.0 } else { -1.0 };
        let linear = Linear {
            jtj: vec![DMatrix::from_element(1, 1, 10.0); BLOCKS],
            jtr: (0..BLOCKS).map(|b| DVector::from_element(1, -10.0 * off(b))).collect(),
            rss: vec![10.0; BLOCKS],
            prior: DMatrix::zeros(1, 1),
            away: DVector::zeros(1),
            held_out_prior: HeldOutPrior::none(1),
        };
        // White noise of 1 would leave 1/√100; blocks that are off by ±1 leave √(1/9).
        assert!((linear.factor().unwrap().deviations()[0] - 0.1).abs() < 1e-6);
        assert!((linear.scatter().unwrap()[0] - (1.0_f64 / 9.0).sqrt()).abs() < 1e-6);
    }
}
