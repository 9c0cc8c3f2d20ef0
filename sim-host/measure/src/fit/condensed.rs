//! Linear models condensed onto a few of their values, all others where the sum of squares is least by
//! them. What many models have in common is factored once: many curves are judged beside the same
//! calibrations.

use super::BLOCKS;
use super::linear::{Factor, Hold, Linear, RIDGE, STAYS};
use nalgebra::{DMatrix, DVector};

/// A quadratic form of values y, but for its constant: 2 slope·y + yᵀ square y.
#[derive(Debug, Clone)]
pub(crate) struct Quadratic {
    pub square: DMatrix<f64>,
    pub slope: DVector<f64>,
}

impl Quadratic {
    /// The normal equations of all blocks, priors with them.
    pub fn of(linear: &Linear) -> Self {
        let (square, slope) = linear.without(None);
        Self { square, slope }
    }

    /// Its value.
    pub fn at(&self, y: &DVector<f64>) -> f64 {
        2.0 * self.slope.dot(y) + (&self.square * y).dot(y)
    }

    /// Where it is least; `None` where it is not positive definite.
    pub fn least(&self) -> Option<DVector<f64>> {
        Some(-Factor::new(&self.square, 0.0)?.solve(&self.slope))
    }

    /// Of the last values, all before them where it is least by them.
    pub fn of_last(self, count: usize) -> Option<Self> {
        let before = self.slope.len() - count;
        if before == 0 {
            return Some(self);
        }
        let (first, last): (Vec<usize>, Vec<usize>) =
            (0..self.slope.len()).partition(|k| *k < before);
        let part = |rows| self.square.select_rows(rows);
        let out = Out::of(&part(&first).select_columns(&first), &self.slope.select_rows(&first))?;
        let columns = self.square.select_columns(&last);
        Some(out.taken(&columns, &self.slope, &first, &last).0)
    }

    /// Of values of which y = `to` × these.
    fn of_parts(&self, to: &DMatrix<f64>) -> Self {
        Self { square: to.tr_mul(&(&self.square * to)), slope: to.tr_mul(&self.slope) }
    }
}

/// Values that are taken out of a quadratic form.
#[derive(Debug, Clone)]
struct Out {
    factor: Factor,
    /// Their step where those that are kept stay.
    step: DVector<f64>,
}

impl Out {
    fn of(square: &DMatrix<f64>, slope: &DVector<f64>) -> Option<Self> {
        let factor = Factor::new(square, 0.0)?;
        let step = -factor.solve(slope);
        Some(Self { factor, step })
    }

    /// The form of the values that are kept, and by how much those that are taken out step back by
    /// each. `columns`: of the kept values, `slope`: of all.
    fn taken(
        &self,
        columns: &DMatrix<f64>,
        slope: &DVector<f64>,
        out: &[usize],
        kept: &[usize],
    ) -> (Quadratic, DMatrix<f64>) {
        let cross = columns.select_rows(out);
        let back = self.factor.solve(&cross);
        let mut square = columns.select_rows(kept);
        // As much as keeps the whole of the normal equations positive definite.
        (0..kept.len()).for_each(|i| square[(i, i)] *= 1.0 + RIDGE);
        square -= cross.tr_mul(&back);
        let slope = slope.select_rows(kept) + cross.tr_mul(&self.step);
        (Quadratic { square, slope }, back)
    }
}

/// The values of a linear model, ready to be taken out of any model that has others beside them; all
/// but those that shape effects, which are held by what stands beside them.
#[derive(Debug, Clone)]
pub(crate) struct Eliminated {
    out: Vec<usize>,
    all: Out,
    /// With each block left out.
    without: Vec<Out>,
}

impl Eliminated {
    /// `None` where the values are not determined.
    pub fn of(linear: &Linear) -> Option<Self> {
        let shapes = &linear.hold.shapes;
        let out: Vec<usize> = (0..linear.away.len()).filter(|k| !shapes.contains(k)).collect();
        let taken = |left_out| {
            let (square, slope) = linear.without(left_out);
            Out::of(&square.select_rows(&out).select_columns(&out), &slope.select_rows(&out))
        };
        let without: Option<Vec<Out>> = (0..BLOCKS).map(|b| taken(Some(b))).collect();
        Some(Self { all: taken(None)?, without: without?, out })
    }

    /// A model of these values and so many more, condensed onto those and what shapes effects.
    pub fn condensed(&self, linear: &Linear, own: usize) -> Condensed {
        let all = linear.away.len();
        let mut kept = linear.hold.shapes.clone();
        kept.extend(all - own..all);
        let taken = |out: &Out, left_out| {
            let columns = linear.columns_without(left_out, &kept);
            out.taken(&columns, &linear.slope_without(left_out), &self.out, &kept)
        };
        let left_out = |b: usize, out: &Out, back: &DMatrix<f64>| {
            let (mut step, mut by) = (DVector::zeros(all), DMatrix::zeros(all, kept.len()));
            for (i, k) in self.out.iter().enumerate() {
                step[*k] = out.step[i];
                by.row_mut(*k).copy_from(&-back.row(i));
            }
            kept.iter().enumerate().for_each(|(i, k)| by[(*k, i)] = 1.0);
            let (square, slope) = (&linear.square[b], &linear.slope[b]);
            let pulled = square * &step;
            let rest = linear.rest[b] + 2.0 * slope.dot(&step) + pulled.dot(&step);
            let (square, slope) = (by.tr_mul(&(square * &by)), by.tr_mul(&(slope + pulled)));
            (Quadratic { square, slope }, rest)
        };
        let each = self.without.iter().enumerate().map(|(b, out)| {
            let (without, back) = taken(out, Some(b));
            Block { without, left_out: left_out(b, out, &back) }
        });
        Condensed {
            blocks: each.collect(),
            all: taken(&self.all, None).0,
            hold: Hold {
                weight: linear.hold.weight.select_rows(&kept),
                away: linear.hold.away.select_rows(&kept),
                shapes: (0..kept.len() - own).collect(),
            },
        }
    }
}

/// A block of a condensed model.
#[derive(Debug, Clone)]
struct Block {
    /// The normal equations of all others.
    without: Quadratic,
    /// Its own sum of squares, predicted from all others, and the constant of that.
    left_out: (Quadratic, f64),
}

/// A linear model of few values: those that shape effects, and its own.
#[derive(Debug, Clone)]
pub(crate) struct Condensed {
    /// The normal equations of all blocks.
    pub all: Quadratic,
    blocks: Vec<Block>,
    hold: Hold,
}

impl Condensed {
    /// The same with something known of its last values.
    pub fn with_prior(&self, prior: &DMatrix<f64>) -> Self {
        let mut known = self.clone();
        let from = self.hold.weight.len() - prior.nrows();
        let normal = known.blocks.iter_mut().map(|block| &mut block.without);
        for normal in normal.chain([&mut known.all]) {
            let mut own = normal.square.view_mut((from, from), prior.shape());
            own += prior;
        }
        known
    }

    /// The same with fewer values in place of its own, of which each moves those by a column of `parts`.
    pub fn with_parts(&self, parts: &DMatrix<f64>) -> Self {
        let shapes = self.hold.shapes.len();
        let all = shapes + parts.ncols();
        let mut to = DMatrix::zeros(shapes + parts.nrows(), all);
        to.view_mut((0, 0), (shapes, shapes)).fill_with_identity();
        to.view_mut((shapes, shapes), parts.shape()).copy_from(parts);
        let first = |v: &DVector<f64>| v.rows(0, shapes).clone_owned();
        let longer = |v: &DVector<f64>| first(v).resize_vertically(all, 0.0);
        let of_block = |block: &Block| Block {
            without: block.without.of_parts(&to),
            left_out: (block.left_out.0.of_parts(&to), block.left_out.1),
        };
        Self {
            all: self.all.of_parts(&to),
            blocks: self.blocks.iter().map(of_block).collect(),
            hold: Hold {
                weight: longer(&self.hold.weight),
                away: longer(&self.hold.away),
                shapes: self.hold.shapes.clone(),
            },
        }
    }

    /// Sum of squares of all blocks, each predicted from all the others.
    pub fn held_out(&self) -> f64 {
        let held = self.staying();
        let block = |Block { without, left_out: (own, rest) }: &Block| {
            let mut without = without.clone();
            for (k, more) in held.iter().enumerate() {
                without.square[(k, k)] += more;
                without.slope[k] += more * self.hold.away[k];
            }
            rest + without.least().map_or(0.0, |y| own.at(&y))
        };
        self.blocks.iter().map(block).sum()
    }

    /// By how much more the values that shape effects are held to what all blocks tell of them.
    fn staying(&self) -> Vec<f64> {
        if self.hold.shapes.is_empty() {
            return Vec::new();
        }
        let Some(factor) = Factor::new(&self.all.square, 0.0) else { return Vec::new() };
        let deviations = factor.deviations();
        let more = |k: &usize| {
            let weight = (STAYS * deviations[*k]).powi(-2);
            if weight.is_finite() { (weight - self.hold.weight[*k]).max(0.0) } else { 0.0 }
        };
        self.hold.shapes.iter().map(more).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::{Residuals, Slopes};
    use crate::predict::Prediction;

    /// Slopes, block by block.
    fn slopes(of: impl Fn(f64) -> f64) -> Slopes {
        vec![Some((0..200).map(|k| of(f64::from(k))).collect())]
    }

    #[test]
    fn a_condensed_model_predicts_blocks_left_out_as_the_whole_does() {
        let residual: Vec<f64> = (0..200).map(|k| (0.37 * f64::from(k * k % 89)).sin()).collect();
        let at: Residuals = vec![Prediction { residual, motion: None, late: None, anywhere: 0.0 }];
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
            base.hold = Hold {
                weight: DVector::from_vec(vec![0.0, 0.3, 0.01]),
                away: DVector::from_vec(vec![0.0, 1.2, 0.4]),
                shapes,
            };
            let bends = DMatrix::from_fn(3, 3, |i, j| if i == j { 2.0 } else { -0.5 });
            let parts = DMatrix::from_fn(3, 2, |i, j| (i + 2 * j) as f64 - 1.0);
            let of_more: Vec<&Slopes> = more.iter().collect();
            let whole = base.extended(&blocks, &at, &known, &of_more);
            let condensed = Eliminated::of(&base).unwrap().condensed(&whole, more.len());
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
            let fewer = base.extended(&blocks, &at, &known, &fewer.iter().collect::<Vec<_>>());
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
                let shapes = base.hold.shapes.len();
                let last = own.len() - shapes;
                let off = own.rows(shapes, last) - step.rows(step.len() - last, last);
                assert!(off.amax() < 1e-6 * step.amax(), "{step} is found as {own}");
            }
        }
    }

    #[test]
    fn beside_nothing_a_condensed_model_is_the_whole() {
        let residual: Vec<f64> = (0..200).map(|k| (0.9 * f64::from(k)).cos()).collect();
        let at: Residuals = vec![Prediction { residual, motion: None, late: None, anywhere: 0.0 }];
        let blocks: Vec<Vec<u8>> = vec![(0..200).map(|k| k / 20).collect()];
        let nothing = DVector::zeros(0);
        let base = Linear::new(&blocks, &at, &[], DMatrix::zeros(0, 0), nothing);
        let whole = base.extended(&blocks, &at, &[], &[&slopes(|k| (0.9 * k).cos())]);
        let condensed = Eliminated::of(&base).unwrap().condensed(&whole, 1);
        let expected: f64 = whole.held_out(None).iter().sum();
        assert!((condensed.held_out() - expected).abs() < 1e-9, "{expected}");
    }
}
