//! Linear models condensed onto a few of their values, all others where the sum of squares is least by
//! them. What many models have in common is factored once: many curves are judged beside the same
//! calibrations.

use super::linear::{Factor, HeldOutPrior, Linear, RIDGE, STAYS};
use super::{BLOCKS, Fitted, Slopes};
use nalgebra::{DMatrix, DVector};
use trueweld_logs::fir::dot;

/// A quadratic form of values y, but for its constant: 2 (Jᵀr)·y + yᵀ (JᵀJ) y.
#[derive(Debug, Clone)]
pub struct Quadratic {
    /// Normal matrix, JᵀJ.
    pub jtj: DMatrix<f64>,
    /// Right side, Jᵀr.
    pub jtr: DVector<f64>,
}

impl Quadratic {
    /// The normal equations of all blocks, priors with them.
    pub fn of(linear: &Linear) -> Self {
        let (jtj, jtr) = linear.without(None);
        Self { jtj, jtr }
    }

    /// Its value.
    pub fn at(&self, y: &DVector<f64>) -> f64 {
        2.0 * self.jtr.dot(y) + (&self.jtj * y).dot(y)
    }

    /// Where it is least; `None` where it is not positive definite.
    pub fn least(&self) -> Option<DVector<f64>> {
        Some(-Factor::new(&self.jtj, 0.0)?.solve(&self.jtr))
    }

    /// Standard deviations of the values; `None` where it is not positive definite.
    pub fn deviations(&self) -> Option<DVector<f64>> {
        Some(Factor::new(&self.jtj, 0.0)?.deviations())
    }

    /// Of the last values, all before them where it is least by them.
    pub fn of_last(self, count: usize) -> Option<Self> {
        let before = self.jtr.len() - count;
        if before == 0 {
            return Some(self);
        }
        let (first, last): (Vec<usize>, Vec<usize>) =
            (0..self.jtr.len()).partition(|k| *k < before);
        let part = |rows| self.jtj.select_rows(rows);
        let out =
            Elimination::of(&part(&first).select_columns(&first), &self.jtr.select_rows(&first))?;
        let columns = self.jtj.select_columns(&last);
        Some(out.taken_from(&columns, &self.jtr, &first, &last).0)
    }

    /// Of values of which y = `to` × these.
    fn of_parts(&self, to: &DMatrix<f64>) -> Self {
        Self { jtj: to.tr_mul(&(&self.jtj * to)), jtr: to.tr_mul(&self.jtr) }
    }
}

/// Values that are taken out of a quadratic form.
#[derive(Debug, Clone)]
struct Elimination {
    factor: Factor,
    /// Their step where those that are kept stay.
    step: DVector<f64>,
}

impl Elimination {
    fn of(jtj: &DMatrix<f64>, jtr: &DVector<f64>) -> Option<Self> {
        let factor = Factor::new(jtj, 0.0)?;
        let step = -factor.solve(jtr);
        Some(Self { factor, step })
    }

    /// The form of the values that are kept, from theirs, and by how much those that are taken out
    /// step back by each. `cross`: products of the slopes of either.
    fn taken(
        &self,
        cross: &DMatrix<f64>,
        mut jtj: DMatrix<f64>,
        jtr: DVector<f64>,
    ) -> (Quadratic, DMatrix<f64>) {
        let back = self.factor.solve(cross);
        // As much as keeps the whole of the normal equations positive definite.
        (0..jtj.nrows()).for_each(|i| jtj[(i, i)] *= 1.0 + RIDGE);
        jtj -= cross.tr_mul(&back);
        let jtr = jtr + cross.tr_mul(&self.step);
        (Quadratic { jtj, jtr }, back)
    }

    /// The same from the columns of those that are kept, and the gradient of all.
    fn taken_from(
        &self,
        columns: &DMatrix<f64>,
        jtr: &DVector<f64>,
        out: &[usize],
        kept: &[usize],
    ) -> (Quadratic, DMatrix<f64>) {
        self.taken(&columns.select_rows(out), columns.select_rows(kept), jtr.select_rows(kept))
    }
}

/// All values of a fit, ready to be taken out of models that have a few more beside them, over all
/// blocks together.
#[derive(Debug)]
pub struct ReducedFit<'a> {
    fitted: &'a Fitted,
    all: Option<Elimination>,
}

impl<'a> ReducedFit<'a> {
    /// `None` where the values are not determined.
    pub fn of(fitted: &'a Fitted) -> Option<Self> {
        if fitted.slopes.is_empty() {
            return Some(Self { fitted, all: None });
        }
        let (jtj, jtr) = fitted.linear.without(None);
        Some(Self { fitted, all: Some(Elimination::of(&jtj, &jtr)?) })
    }

    /// The sum of squares by so many more values, of which nothing is known beforehand, where it is
    /// least by those of the fit.
    pub fn beside(&self, more: &[Slopes]) -> Quadratic {
        let product = |a: &Slopes, b: &Slopes| {
            let logs = a.iter().zip(b).filter_map(|(a, b)| Some((a.as_ref()?, b.as_ref()?)));
            logs.map(|(a, b)| dot(a, b)).sum::<f64>()
        };
        let with = |slopes: &[Slopes]| {
            DMatrix::from_fn(slopes.len(), more.len(), |i, k| product(&slopes[i], &more[k]))
        };
        let gradient = |slopes: &Slopes| {
            let logs = slopes.iter().zip(&self.fitted.residuals);
            logs.filter_map(|(s, at)| Some(dot(s.as_ref()?, &at.residual))).sum::<f64>()
        };
        let jtr = DVector::from_iterator(more.len(), more.iter().map(gradient));
        self.beside_products(&with(&self.fitted.slopes), with(more), jtr)
    }

    /// The same from products of slopes: of the fit's with the new ones (`cross`), of these with each
    /// other, and with the residuals.
    pub fn beside_products(
        &self,
        cross: &DMatrix<f64>,
        jtj: DMatrix<f64>,
        jtr: DVector<f64>,
    ) -> Quadratic {
        match &self.all {
            Some(all) => all.taken(cross, jtj, jtr).0,
            None => Quadratic { jtj, jtr },
        }
    }
}

/// The values of a linear model, ready to be taken out of any model that has others beside them; all
/// but those that shape effects, which are held by what stands beside them.
#[derive(Debug, Clone)]
pub struct SchurComplement {
    out: Vec<usize>,
    all: Elimination,
    /// With each block left out.
    without: Vec<Elimination>,
}

impl SchurComplement {
    /// `None` where the values are not determined.
    pub fn of(linear: &Linear) -> Option<Self> {
        let shapes = &linear.held_out_prior.shapes;
        let out: Vec<usize> = (0..linear.away.len()).filter(|k| !shapes.contains(k)).collect();
        let taken = |left_out| {
            let (jtj, jtr) = linear.without(left_out);
            Elimination::of(&jtj.select_rows(&out).select_columns(&out), &jtr.select_rows(&out))
        };
        let without: Option<Vec<Elimination>> = (0..BLOCKS).map(|b| taken(Some(b))).collect();
        Some(Self { all: taken(None)?, without: without?, out })
    }

    /// A model of these values and so many more, condensed onto those and what shapes effects.
    pub fn condensed(&self, linear: &Linear, own: usize) -> ReducedNormal {
        let all = linear.away.len();
        let mut kept = linear.held_out_prior.shapes.clone();
        kept.extend(all - own..all);
        let taken = |out: &Elimination, left_out| {
            let columns = linear.columns_without(left_out, &kept);
            out.taken_from(&columns, &linear.jtr_without(left_out), &self.out, &kept)
        };
        let each = self.without.iter().enumerate().map(|(b, out)| {
            let (without, back) = taken(out, Some(b));
            ReducedBlock { without, left_out: self.left_out(linear, b, &out.step, &back, &kept) }
        });
        ReducedNormal {
            blocks: each.collect(),
            all: taken(&self.all, None).0,
            held_out_prior: HeldOutPrior {
                weight: linear.held_out_prior.weight.select_rows(&kept),
                away: linear.held_out_prior.away.select_rows(&kept),
                shapes: (0..kept.len() - own).collect(),
            },
        }
    }

    /// The sum of squares of block `b` by the values that are kept, and its constant. `step`: of
    /// the values that are taken out, where those that are kept stay; `back`: by each of these.
    fn left_out(
        &self,
        linear: &Linear,
        b: usize,
        step: &DVector<f64>,
        back: &DMatrix<f64>,
        kept: &[usize],
    ) -> (Quadratic, f64) {
        let all = linear.away.len();
        let (mut whole, mut by) = (DVector::zeros(all), DMatrix::zeros(all, kept.len()));
        for (i, k) in self.out.iter().enumerate() {
            whole[*k] = step[i];
            by.row_mut(*k).copy_from(&-back.row(i));
        }
        kept.iter().enumerate().for_each(|(i, k)| by[(*k, i)] = 1.0);
        let (jtj, jtr) = (&linear.jtj[b], &linear.jtr[b]);
        let pulled = jtj * &whole;
        let rss = linear.rss[b] + 2.0 * jtr.dot(&whole) + pulled.dot(&whole);
        let (jtj, jtr) = (by.tr_mul(&(jtj * &by)), by.tr_mul(&(jtr + pulled)));
        (Quadratic { jtj, jtr }, rss)
    }
}

/// A block of a condensed model.
#[derive(Debug, Clone)]
struct ReducedBlock {
    /// The normal equations of all others.
    without: Quadratic,
    /// Its own sum of squares, predicted from all others, and the constant of that.
    left_out: (Quadratic, f64),
}

impl ReducedBlock {
    /// Its sum of squares, predicted from all others. `held`: by how much more the first values are
    /// held, `away`: from where they are held to.
    fn held_out(&self, held: &[f64], away: &DVector<f64>) -> f64 {
        let mut without = self.without.clone();
        for (k, more) in held.iter().enumerate() {
            without.jtj[(k, k)] += more;
            without.jtr[k] += more * away[k];
        }
        let (own, rss) = &self.left_out;
        rss + without.least().map_or(0.0, |y| own.at(&y))
    }
}

/// A linear model of few values: those that shape effects, and its own.
#[derive(Debug, Clone)]
pub struct ReducedNormal {
    /// The normal equations of all blocks.
    pub all: Quadratic,
    blocks: Vec<ReducedBlock>,
    held_out_prior: HeldOutPrior,
}

impl ReducedNormal {
    /// The same with something known of its last values.
    pub fn with_prior(&self, prior: &DMatrix<f64>) -> Self {
        let mut known = self.clone();
        let from = self.held_out_prior.weight.len() - prior.nrows();
        let normal = known.blocks.iter_mut().map(|block| &mut block.without);
        for normal in normal.chain([&mut known.all]) {
            let mut own = normal.jtj.view_mut((from, from), prior.shape());
            own += prior;
        }
        known
    }

    /// The same with fewer values in place of its own, of which each moves those by a column of `parts`.
    pub fn with_parts(&self, parts: &DMatrix<f64>) -> Self {
        let shapes = self.held_out_prior.shapes.len();
        let all = shapes + parts.ncols();
        let mut to = DMatrix::zeros(shapes + parts.nrows(), all);
        to.view_mut((0, 0), (shapes, shapes)).fill_with_identity();
        to.view_mut((shapes, shapes), parts.shape()).copy_from(parts);
        let first = |v: &DVector<f64>| v.rows(0, shapes).clone_owned();
        let longer = |v: &DVector<f64>| first(v).resize_vertically(all, 0.0);
        let of_block = |block: &ReducedBlock| ReducedBlock {
            without: block.without.of_parts(&to),
            left_out: (block.left_out.0.of_parts(&to), block.left_out.1),
        };
        Self {
            all: self.all.of_parts(&to),
            blocks: self.blocks.iter().map(of_block).collect(),
            held_out_prior: HeldOutPrior {
                weight: longer(&self.held_out_prior.weight),
                away: longer(&self.held_out_prior.away),
                shapes: self.held_out_prior.shapes.clone(),
            },
        }
    }

    /// Sum of squares of all blocks, each predicted from all the others.
    pub fn held_out(&self) -> f64 {
        let held = self.staying();
        self.blocks.iter().map(|block| block.held_out(&held, &self.held_out_prior.away)).sum()
    }

    /// By how much more the values that shape effects are held to what all blocks tell of them.
    fn staying(&self) -> Vec<f64> {
        if self.held_out_prior.shapes.is_empty() {
            return Vec::new();
        }
        let Some(factor) = Factor::new(&self.all.jtj, 0.0) else { return Vec::new() };
        let deviations = factor.deviations();
        let own = &self.held_out_prior.weight;
        let more = |k: &usize| {
            let weight = (STAYS * deviations[*k]).powi(-2);
            if weight.is_finite() { (weight - own[*k]).max(0.0) } else { 0.0 }
        };
        self.held_out_prior.shapes.iter().map(more).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{FitState, Residuals, Termination};
    use crate::predict::Prediction;

    /// Slopes, block by block.
    fn slopes(of: impl Fn(f64) -> f64) -> Slopes {
        vec![Some((0..200).map(|k| of(f64::from(k))).collect())]
    }

    #[test]
    fn a_condensed_model_predicts_blocks_left_out_as_the_whole_does() {
        let residual: Vec<f64> = (0..200).map(|k| (0.37 * f64::from(k * k % 89)).sin()).collect();
        let at: Residuals =
            vec![Prediction { residual, motion: None, late: None, not_evidence: 0.0, noise: None }];
        let blocks: Vec<Vec<u8>> = vec![(0..200).map(|k| k / 20).collect()];
        let known: Vec<Slopes> = vec![
            slopes(|_| 1.0),
            slopes(|k| (0.1 * k).cos()),
            slopes(|k| if k < 30.0 { 0.0 } else { 1.0 }),
        ];
        let more: Vec<Slopes> = vec![
            slopes(|k| (0.01 * k).powi(2)),
            slopes(|k| (0.3 * k).sin()),
            slopes(|k| if (50.0..70.0).contains(&k) { 1.0 } else { 0.0 }),
        ];
        let of_known: Vec<&Slopes> = known.iter().collect();
        let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![0.2, 0.0, 0.0]));
        let away = DVector::from_vec(vec![0.5, 0.0, 0.0]);
        let mut base = Linear::new(&blocks, &at, &of_known, prior, away);
        for shapes in [Vec::new(), vec![2]] {
            base.held_out_prior = HeldOutPrior {
                weight: DVector::from_vec(vec![0.0, 0.3, 0.01]),
                away: DVector::from_vec(vec![0.0, 1.2, 0.4]),
                shapes,
            };
            let bends = DMatrix::from_fn(3, 3, |i, j| if i == j { 2.0 } else { -0.5 });
            let parts = DMatrix::from_fn(3, 2, |i, j| (i + 2 * j) as f64 - 1.0);
            let with = |more: &[Slopes]| {
                let all: Vec<&Slopes> = known.iter().chain(more).collect();
                base.renewed(&blocks, &at, &all, |_| false)
            };
            let whole = with(&more);
            let condensed = SchurComplement::of(&base).unwrap().condensed(&whole, more.len());
            let mut bent = whole.clone();
            let mut own = bent.prior.view_mut((3, 3), (3, 3));
            own += &bends;
            let summed = |part: usize| {
                let columns: Vec<Vec<f64>> = (0..3).map(|k| more[k][0].clone().unwrap()).collect();
                let value =
                    |row: usize| (0..3).map(|k| columns[k][row] * parts[(k, part)]).sum::<f64>();
                vec![Some((0..200).map(value).collect())]
            };
            let fewer: Vec<Slopes> = (0..2).map(summed).collect();
            let fewer = with(&fewer);
            for (whole, condensed) in [
                (&whole, &condensed),
                (&bent, &condensed.with_prior(&bends)),
                (&fewer, &condensed.with_parts(&parts)),
            ] {
                let expected: f64 = whole.held_out(None).iter().sum();
                let found = condensed.held_out();
                assert!((found - expected).abs() < 1e-6 * expected, "{found} for {expected}");
                let step = whole.solve(None, 0.0, None).unwrap().step;
                let own = condensed.all.least().unwrap();
                let shapes = base.held_out_prior.shapes.len();
                let last = own.len() - shapes;
                let off = own.rows(shapes, last) - step.rows(step.len() - last, last);
                assert!(off.amax() < 1e-6 * step.amax(), "{step} is found as {own}");
            }
        }
    }

    #[test]
    fn what_a_few_more_values_lower_the_sum_by_is_that_of_the_whole() {
        let residual: Vec<f64> = (0..200).map(|k| (0.37 * f64::from(k * k % 89)).sin()).collect();
        let at: Residuals =
            vec![Prediction { residual, motion: None, late: None, not_evidence: 0.0, noise: None }];
        let blocks: Vec<Vec<u8>> = vec![(0..200).map(|k| k / 20).collect()];
        let known = vec![slopes(|_| 1.0), slopes(|k| (0.1 * k).cos())];
        let more = vec![slopes(|k| (0.01 * k).powi(2)), vec![None]];
        let prior = DMatrix::from_diagonal(&DVector::from_vec(vec![0.2, 0.0]));
        let away = DVector::from_vec(vec![0.5, 0.0]);
        let of_known: Vec<&Slopes> = known.iter().collect();
        let base = Linear::new(&blocks, &at, &of_known, prior, away);
        let whole =
            base.renewed(&blocks, &at, &known.iter().chain(&more).collect::<Vec<_>>(), |_| false);
        let [before, after] = [&base, &whole].map(|linear| linear.solve(None, 0.0, None).unwrap());
        let fall = base.cost(&before.step) - whole.cost(&after.step);
        let fitted = Fitted {
            point: FitState::empty(1),
            residuals: at,
            slopes: known,
            linear: base,
            cost: 0.0,
            termination: Termination::Converged,
        };
        let few = ReducedFit::of(&fitted).unwrap().beside(&more);
        let step = few.least().unwrap();
        assert!((few.at(&step) + fall).abs() < 1e-9 * fall, "{} for {fall}", few.at(&step));
        assert!((step[0] - after.step[2]).abs() < 1e-9 * step[0].abs());
        assert!((few.deviations().unwrap()[0] / after.deviations()[2] - 1.0).abs() < 1e-6);
        assert_eq!(step[1], 0.0);
    }

    #[test]
    fn beside_nothing_a_condensed_model_is_the_whole() {
        let residual: Vec<f64> = (0..200).map(|k| (0.9 * f64::from(k)).cos()).collect();
        let at: Residuals =
            vec![Prediction { residual, motion: None, late: None, not_evidence: 0.0, noise: None }];
        let blocks: Vec<Vec<u8>> = vec![(0..200).map(|k| k / 20).collect()];
        let nothing = DVector::zeros(0);
        let base = Linear::new(&blocks, &at, &[], DMatrix::zeros(0, 0), nothing);
        let whole = base.renewed(&blocks, &at, &[&slopes(|k| (0.9 * k).cos())], |_| false);
        let condensed = SchurComplement::of(&base).unwrap().condensed(&whole, 1);
        let expected: f64 = whole.held_out(None).iter().sum();
        assert!((condensed.held_out() - expected).abs() < 1e-9, "{expected}");
    }
}
