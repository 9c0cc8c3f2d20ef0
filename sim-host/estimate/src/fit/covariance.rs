//! The joint covariance of fitted values, where residuals follow each other in time and with each
//! other.
//!
//! With the curvature H = Σ AᵀA + W, W the priors', it is H⁻¹ (S + W) H⁻¹. S is what noise makes of
//! the gradient Aᵀr: the residuals of each column are taken for an autoregressive process, of the
//! order that Akaike's criterion has (the encoders' noise makes the torque of a heavy axis blue, and
//! leaves that of a wrist white), and those of columns of the same rows go together as their
//! innovations do. A fit takes of the noise what it can, the slow part first: what residuals lack of
//! it is found by fitting simulated noise. S is made of a product with itself, so that nothing falls
//! below zero. Where the ten blocks in time disagree by more than that leaves to chance, the model is
//! not quite right, and a value is as uncertain as they disagree.
//!
//! Left out: noise that changes within a log, and noise that two quantities of different rows share.

use super::{FitProblem, Linear, Residuals, Slopes};
use crate::predict::PreparedLog;
use nalgebra::{DMatrix, DVector};
use std::collections::BTreeMap;
use trueweld_plant::random::Random;

/// Residuals of one quantity and component of a log.
#[derive(Debug, Clone)]
pub struct ResidualColumn {
    /// Which of the log's residuals, in order of time.
    pub at: Vec<usize>,
    /// Rows of the log that they belong to.
    pub rows: Vec<usize>,
    /// Columns of the same number have one noise process: those of a quantity, where each has few rows
    /// that are apart.
    pub level: usize,
    /// False where rows are apart from each other: each at rest.
    pub follows: bool,
}

/// The columns of every log.
pub fn columns(problem: &FitProblem) -> Vec<Vec<ResidualColumn>> {
    problem.logs.iter().map(columns_of).collect()
}

fn columns_of(experiment: &PreparedLog) -> Vec<ResidualColumn> {
    let mut columns = BTreeMap::new();
    let mut levels = Vec::new();
    for (k, c) in experiment.compared.iter().enumerate() {
        let follows = experiment.period.is_finite();
        let process = (c.quantity, follows.then_some(c.component));
        let level = levels.iter().position(|known| *known == process).unwrap_or_else(|| {
            levels.push(process);
            levels.len() - 1
        });
        let column = columns.entry((c.quantity, c.component)).or_insert(ResidualColumn {
            at: Vec::new(),
            rows: Vec::new(),
            level,
            follows,
        });
        column.at.push(k);
        column.rows.push(c.row);
    }
    columns.into_values().collect()
}

/// Longest memory of residuals, rows; how many rows of all its columns each of these needs, and how
/// many of its shortest one.
const ORDER: usize = 20;
const ROWS_EACH: usize = 10;
const ROWS_OF_ONE: usize = 4;

/// Rows before the first whose innovations count: what began before a log still goes on in it.
const MEMORY: usize = 400;

/// Autocovariance of the columns of every level together, from lag 0 on.
fn autocovariance(columns: &[ResidualColumn], residual: &[f64]) -> Vec<Vec<f64>> {
    let levels = columns.iter().map(|c| c.level + 1).max().unwrap_or(0);
    (0..levels).map(|level| level_autocovariance(columns, level, residual)).collect()
}

/// Autocovariance of the columns of one level together, from lag 0 on.
fn level_autocovariance(columns: &[ResidualColumn], level: usize, residual: &[f64]) -> Vec<f64> {
    let own = || columns.iter().filter(|c| c.level == level);
    let rows: usize = own().map(|c| c.at.len()).sum();
    let shortest = own().map(|c| c.at.len()).min().unwrap_or(0);
    let follows = own().all(|c| c.follows);
    let most = ORDER.min(rows / ROWS_EACH).min(shortest / ROWS_OF_ONE);
    let lagged = |k: usize| {
        let product = |(a, b): (&usize, &usize)| residual[*a] * residual[*b];
        let sums = own().map(|c| c.at.iter().zip(c.at.iter().skip(k)).map(product).sum::<f64>());
        sums.sum::<f64>() / rows.max(1) as f64
    };
    (0..=if follows { most } else { 0 }).map(lagged).collect()
}

/// An autoregressive process r_t = Σ φ_k r_{t−k} + e_t.
#[derive(Debug, Clone)]
struct Autoregression {
    coefficients: Vec<f64>,
    /// Mean square of r.
    square: f64,
    /// Mean square of r over that of e.
    gain: f64,
}

impl Autoregression {
    /// Levinson's recursion over an autocovariance of so many rows; the order by Akaike's criterion.
    /// A level below the one stated is chance.
    fn of(covariance: &[f64], rows: usize) -> Self {
        let rows = rows as f64;
        let (mut coefficients, mut left): (Vec<f64>, f64) = (Vec::new(), covariance[0]);
        let mut best = Self { coefficients: Vec::new(), square: covariance[0].max(1.0), gain: 1.0 };
        let mut least = rows * left.ln();
        for k in 1..covariance.len() {
            let known: f64 =
                coefficients.iter().zip((1..k).rev()).map(|(a, j)| a * covariance[j]).sum();
            let reflection = (covariance[k] - known) / left;
            // No process has this autocovariance.
            if reflection.is_nan() || reflection.abs() >= 1.0 {
                break;
            }
            let mirrored: Vec<f64> = coefficients.iter().rev().copied().collect();
            coefficients.iter_mut().zip(&mirrored).for_each(|(a, m)| *a -= reflection * m);
            coefficients.push(reflection);
            left *= 1.0 - reflection * reflection;
            let criterion = rows * left.ln() + 2.0 * k as f64;
            if criterion < least {
                least = criterion;
                best =
                    Self { coefficients: coefficients.clone(), gain: covariance[0] / left, ..best };
            }
        }
        best
    }

    /// So many rows of the process.
    fn simulated(&self, rows: usize, random: &mut Random) -> Vec<f64> {
        let deviation = (self.square / self.gain).sqrt();
        let before = if self.coefficients.is_empty() { 0 } else { MEMORY };
        let mut series: Vec<f64> = Vec::with_capacity(before + rows);
        for t in 0..before + rows {
            let past = self.coefficients.iter().zip(series[..t].iter().rev());
            let predicted: f64 = past.map(|(a, r)| a * r).sum();
            series.push(predicted + deviation * random.normal());
        }
        series.split_off(before)
    }

    fn innovations(&self, series: &[f64]) -> Vec<f64> {
        let predicted = |t: usize| {
            let past = self.coefficients.iter().enumerate().take(t);
            past.map(|(k, a)| a * series[t - 1 - k]).sum::<f64>()
        };
        (0..series.len()).map(|t| series[t] - predicted(t)).collect()
    }

    /// What each innovation moves Σ a_t r_t by, from `before` rows before the first on.
    fn moved(&self, slope: &[f64], before: usize) -> Vec<f64> {
        let mut moved = vec![0.0; before];
        moved.extend_from_slice(slope);
        for t in (0..moved.len()).rev() {
            let later = self
                .coefficients
                .iter()
                .enumerate()
                .filter_map(|(k, a)| moved.get(t + 1 + k).map(|b| a * b));
            let later: f64 = later.sum();
            moved[t] += later;
        }
        moved
    }
}

/// Long-run variance over variance of the residuals of every level: how many values count as one,
/// where residuals follow each other. At least 1, and at most all of a column's.
pub fn long_run_ratios(columns: &[ResidualColumn], residual: &[f64]) -> Vec<f64> {
    let of_level = |(level, covariance): (usize, Vec<f64>)| {
        let own = || columns.iter().filter(|c| c.level == level).map(|c| c.at.len());
        let process = Autoregression::of(&covariance, own().sum());
        let memory = 1.0 - process.coefficients.iter().sum::<f64>();
        let longest = own().max().unwrap_or(1).max(1) as f64;
        (1.0 / (process.gain * memory * memory)).clamp(1.0, longest)
    };
    autocovariance(columns, residual).into_iter().enumerate().map(of_level).collect()
}

/// A covariance of so many rows with its correlations shrunk as far as chance makes them: in a few rows of
/// many columns some of their sums hardly change, and what they tell would be taken for sure. Schäfer and
/// Strimmer 2005, with the variance (1 − r²)²/(n − 1) of a correlation r.
fn shrunk(mut covariance: DMatrix<f64>, rows: usize) -> DMatrix<f64> {
    let own = covariance.diagonal();
    let (mut chance, mut seen) = (0.0, 0.0);
    for (i, j) in (0..own.len()).flat_map(|i| (0..i).map(move |j| (i, j))) {
        let square = covariance[(i, j)].powi(2) / (own[i] * own[j]).max(f64::MIN_POSITIVE);
        chance += (1.0 - square).powi(2) / (rows as f64 - 1.0).max(1.0);
        seen += square;
    }
    covariance *= 1.0 - (chance / seen.max(f64::MIN_POSITIVE)).min(1.0);
    covariance.set_diagonal(&own);
    covariance
}

/// What noise makes of the gradient of one log: its covariance over the values that the log sees.
/// `processes`: of every level.
fn gradient(
    columns: &[ResidualColumn],
    residual: &[f64],
    seen: &[&[f64]],
    processes: &[Autoregression],
) -> DMatrix<f64> {
    let mut sum = DMatrix::zeros(seen.len(), seen.len());
    let mut together: BTreeMap<&[usize], Vec<&ResidualColumn>> = BTreeMap::new();
    for column in columns {
        together.entry(&column.rows).or_default().push(column);
    }
    for (rows, columns) in together {
        let n = rows.len();
        let mut innovations = DMatrix::zeros(n, columns.len());
        for (c, column) in columns.iter().enumerate() {
            let process = &processes[column.level];
            let series: Vec<f64> = column.at.iter().map(|k| residual[*k]).collect();
            let own = process.innovations(&series);
            let now = own.iter().map(|e| e * e).sum::<f64>() / n as f64;
            // Of the level that its quantity has.
            let factor = if now > 0.0 { (process.square / process.gain / now).sqrt() } else { 0.0 };
            own.iter().enumerate().for_each(|(t, e)| innovations[(t, c)] = factor * e);
        }
        let mut square = shrunk(innovations.tr_mul(&innovations) / n as f64, n);
        // Columns that go together to the last digit, as those of few rows may.
        for c in 0..columns.len() {
            square[(c, c)] += 1e-9 * square[(c, c)] + f64::MIN_POSITIVE;
        }
        let Some(factor) = square.cholesky() else { continue };
        let white = columns.iter().all(|c| processes[c.level].coefficients.is_empty());
        let before = if white { 0 } else { n.min(MEMORY) };
        let moved: Vec<DMatrix<f64>> = columns
            .iter()
            .map(|column| {
                let of = |slope: &&[f64]| {
                    let own: Vec<f64> = column.at.iter().map(|k| slope[*k]).collect();
                    DVector::from_vec(processes[column.level].moved(&own, before))
                };
                DMatrix::from_columns(&seen.iter().map(of).collect::<Vec<_>>())
            })
            .collect();
        for j in 0..columns.len() {
            let mut one = DMatrix::zeros(n + before, seen.len());
            for (c, moved) in moved.iter().enumerate().skip(j) {
                one += moved * factor.l_dirty()[(c, j)];
            }
            sum += one.tr_mul(&one);
        }
    }
    sum
}

/// Simulated fits by which it is found what fits take of the noise.
const SIMULATED: u64 = 16;

/// The process behind the residuals of every level of every log, as it is where nothing was fitted.
fn processes(
    columns: &[Vec<ResidualColumn>],
    at: &Residuals,
    slopes: &[Slopes],
    inverse: &DMatrix<f64>,
) -> Vec<Vec<Autoregression>> {
    let logs = columns.len();
    let rows = |log: usize, level: usize| {
        columns[log].iter().filter(|c| c.level == level).map(|c| c.at.len()).sum()
    };
    let found = |covariances: &[Vec<Vec<f64>>]| -> Vec<Vec<Autoregression>> {
        let of_log = |(log, levels): (usize, &Vec<Vec<f64>>)| {
            let of_level = |(level, c): (usize, &Vec<f64>)| Autoregression::of(c, rows(log, level));
            levels.iter().enumerate().map(of_level).collect()
        };
        covariances.iter().enumerate().map(of_log).collect()
    };
    let mut covariances: Vec<Vec<Vec<f64>>> =
        (0..logs).map(|log| autocovariance(&columns[log], &at[log].residual)).collect();
    let first = found(&covariances);
    for seed in 0..SIMULATED {
        let mut random = Random::new(seed, 0);
        let mut noise: Vec<Vec<f64>> = at.iter().map(|p| vec![0.0; p.residual.len()]).collect();
        for (log, columns) in columns.iter().enumerate() {
            for column in columns {
                let series = first[log][column.level].simulated(column.at.len(), &mut random);
                column.at.iter().zip(series).for_each(|(k, r)| noise[log][*k] = r);
            }
        }
        let pull = |slope: &Slopes| -> f64 {
            let of_log = |(a, r): (&Option<Vec<f64>>, &Vec<f64>)| {
                a.iter().flatten().zip(r).map(|(a, r)| a * r).sum::<f64>()
            };
            slope.iter().zip(&noise).map(of_log).sum()
        };
        let step = -(inverse * DVector::from_iterator(slopes.len(), slopes.iter().map(pull)));
        for log in 0..logs {
            let mut left = noise[log].clone();
            for (slope, step) in slopes.iter().zip(&step) {
                let of = slope[log].iter().flatten();
                left.iter_mut().zip(of).for_each(|(r, a)| *r += a * step);
            }
            let before = autocovariance(&columns[log], &noise[log]);
            let after = autocovariance(&columns[log], &left);
            for (level, c) in covariances[log].iter_mut().enumerate() {
                for (k, c) in c.iter_mut().enumerate() {
                    *c += (before[level][k] - after[level][k]) / SIMULATED as f64;
                }
            }
        }
    }
    found(&covariances)
}

/// Variance of what ten blocks disagree by, over what it is, up to which chance alone may bring it:
/// χ² of nine degrees of freedom at 99 %, over nine.
const BLOCK_SCATTER_RATIO_MAX: f64 = 21.67 / 9.0;

/// Covariance of the values of a linear model, in the fit's units. `columns`: of every log.
/// `None` where the curvature is singular.
pub fn covariance(
    linear: &Linear,
    columns: &[Vec<ResidualColumn>],
    at: &Residuals,
    slopes: &[Slopes],
) -> Option<DMatrix<f64>> {
    let n = linear.away.len();
    let factor = linear.factor()?;
    let inverse = factor.solve(&DMatrix::identity(n, n));
    let processes = processes(columns, at, slopes, &inverse);
    let mut score = DMatrix::zeros(n, n);
    for (log, columns) in columns.iter().enumerate() {
        let seen: Vec<usize> = (0..n).filter(|k| slopes[*k][log].is_some()).collect();
        let of: Vec<&[f64]> = seen.iter().filter_map(|k| slopes[*k][log].as_deref()).collect();
        if of.is_empty() {
            continue;
        }
        let own = gradient(columns, &at[log].residual, &of, &processes[log]);
        for (i, k) in seen.iter().enumerate() {
            for (j, l) in seen.iter().enumerate() {
                score[(*k, *l)] += own[(i, j)];
            }
        }
    }
    let of_noise = &inverse * score * &inverse;
    let of_priors = &inverse * &linear.prior * &inverse;
    let scatter = linear.scatter()?;
    let wider = DVector::from_fn(n, |k, _| {
        let (noise, priors) = (of_noise[(k, k)], of_priors[(k, k)]);
        let square = scatter[k] * scatter[k];
        if noise > 0.0 && square > BLOCK_SCATTER_RATIO_MAX * noise {
            ((square + priors) / (noise + priors)).sqrt()
        } else {
            1.0
        }
    });
    let whole = (of_noise + of_priors).component_mul(&(&wider * wider.transpose()));
    Some(0.5 * (&whole + whole.transpose()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::BLOCKS;
    use crate::predict::Prediction;
    use trueweld_logs::HALF_95;

    const ROWS: usize = 600;

    /// A line and a wave through two columns of noise that follows itself (`memory`, unit variance)
    /// and goes together: the values found, and their covariance.
    fn fitted(seed: u64, memory: f64, level: f64) -> (DVector<f64>, DMatrix<f64>) {
        let mut random = Random::new(seed, 0);
        let mut state = [random.normal(), random.normal()];
        let fresh = (1.0 - memory * memory).sqrt();
        let mut residual = vec![0.0; 2 * ROWS];
        for t in 0..ROWS {
            let shared = random.normal();
            for (c, state) in state.iter_mut().enumerate() {
                let own = 0.6 * shared + 0.8 * random.normal();
                *state = memory * *state + fresh * own;
                residual[c * ROWS + t] = level * *state;
            }
        }
        let x = |k: usize| (k % ROWS) as f64 / ROWS as f64;
        let shapes: [&dyn Fn(f64) -> f64; 3] = [&|_| 1.0, &|x| x - 0.5, &|x| (9.0 * x).sin()];
        let slopes: Vec<Slopes> = shapes
            .iter()
            .map(|shape| vec![Some((0..2 * ROWS).map(|k| shape(x(k))).collect())])
            .collect();
        let blocks = vec![(0..2 * ROWS).map(|k| (k % ROWS * BLOCKS / ROWS) as u8).collect()];
        let all: Vec<&Slopes> = slopes.iter().collect();
        let of = |residual: Vec<f64>| {
            let at = vec![Prediction {
                residual,
                motion: None,
                late: None,
                not_evidence: 0.0,
                noise: None,
            }];
            let prior = DMatrix::zeros(3, 3);
            (Linear::new(&blocks, &at, &all, prior, DVector::zeros(3)), at)
        };
        let step = of(residual.clone()).0.solve(None, 0.0, None).unwrap().step;
        for (k, slope) in slopes.iter().enumerate() {
            let slope = slope[0].as_deref().unwrap();
            residual.iter_mut().zip(slope).for_each(|(r, a)| *r += a * step[k]);
        }
        let (linear, at) = of(residual);
        let column = |c: usize| ResidualColumn {
            at: (c * ROWS..(c + 1) * ROWS).collect(),
            rows: (0..ROWS).collect(),
            level: 0,
            follows: true,
        };
        let covariance = covariance(&linear, &[vec![column(0), column(1)]], &at, &slopes);
        (step, covariance.unwrap())
    }

    /// Shares of 400 fits whose joint 95 % ellipsoid, and whose intervals of each value, hold the
    /// truth.
    fn covered(memory: f64, level: f64) -> [f64; 2] {
        let (mut joint, mut each) = (0.0, 0.0);
        for seed in 0..400 {
            let (off, covariance) = fitted(seed, memory, level);
            let own = (0..3).filter(|k| off[*k].abs() <= HALF_95 * covariance[(*k, *k)].sqrt());
            each += own.count() as f64 / 1200.0;
            let factor = covariance.cholesky().expect("positive definite");
            // χ² of three degrees of freedom at 95 %.
            joint += if off.dot(&factor.solve(&off)) <= 7.815 { 1.0 / 400.0 } else { 0.0 };
        }
        [joint, each]
    }

    #[test]
    fn the_ellipsoid_holds_the_truth_as_often_as_it_says() {
        // Of 400, 95 % are 380 ± 9 (two standard deviations); a log that holds some twenty spans of
        // its noise's memory leaves that memory known to a tenth or two.
        for memory in [0.0, 0.5, 0.9] {
            let [joint, each] = covered(memory, 1.0);
            assert!((0.90..=0.98).contains(&joint), "{memory}: {joint} jointly");
            assert!((0.90..=0.98).contains(&each), "{memory}: {each} each");
        }
    }

    #[test]
    fn a_level_that_the_instruments_do_not_state_is_found() {
        let [joint, each] = covered(0.5, 3.0);
        assert!((0.90..=0.98).contains(&joint) && (0.90..=0.98).contains(&each), "{joint} {each}");
    }
}
