//! Residuals that come again several times a turn of a joint: a gear or an encoder that is not
//! quite round.

use super::covariate::{Bins, Covariate};
use super::table::{EXPLAINED_ABOVE_CHANCE_MIN, ResidualTable};
use super::{ARRANGEMENTS, BinSums, Finding, RowCondition, Statistic, judge, report};
use rayon::prelude::*;
use std::f64::consts::TAU;
use trueweld_logs::log::LogKind;

/// Periods a turn that are tried.
const TRIED_ORDERS: std::ops::RangeInclusive<usize> = 1..=160;

/// Periods that a joint must go through for a wave to be told from a slope.
const PERIODS: f64 = 2.0;

/// Rows that orders are searched in; bins of the phase.
const ORDER_SEARCH_ROWS: usize = 500;
const PHASE_BINS: u16 = 12;

/// The best wave over each joint's angle in a free motion, where it is more than chance; chance may
/// choose its order too.
pub(super) fn of(
    table: &ResidualTable,
    conditions: &[Covariate],
    arrangements: &[Vec<u32>],
) -> Vec<Finding> {
    if table.kind != LogKind::FreeMotion {
        return Vec::new();
    }
    let of = |condition: &Covariate| match condition.variable {
        RowCondition::Angle(joint) => of_angle(table, joint, condition, arrangements),
        _ => None,
    };
    conditions.par_iter().filter_map(of).collect()
}

fn of_angle(
    table: &ResidualTable,
    joint: usize,
    angle: &Covariate,
    arrangements: &[Vec<u32>],
) -> Option<Finding> {
    let (low, high) =
        angle.values.iter().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(*v), h.max(*v)));
    let first = (PERIODS * TAU / (high - low)).ceil().max(1.0);
    if !first.is_finite() || first as usize > *TRIED_ORDERS.end() {
        return None;
    }
    let picked: Vec<usize> =
        (0..table.squares.len()).step_by(table.squares.len().div_ceil(ORDER_SEARCH_ROWS)).collect();
    let waves: Vec<SineCosine> = (first as usize..=*TRIED_ORDERS.end())
        .map(|order| SineCosine::new(order, &picked, &angle.values))
        .collect();
    let width = table.series.len();
    let mut mean = vec![0.0; width];
    for i in &picked {
        mean.iter_mut()
            .zip(table.row(*i))
            .for_each(|(mean, value)| *mean += value / picked.len() as f64);
    }
    let best = |arranged: &[usize]| best_order(table, arranged, &mean, &waves);
    let (order, share) = best(&picked);
    if share < EXPLAINED_ABOVE_CHANCE_MIN {
        return None;
    }
    let arranged = arrangements.iter().take(ARRANGEMENTS).map(|arrangement| {
        let rows: Vec<usize> = picked.iter().map(|i| arrangement[*i] as usize).collect();
        [best(&rows).1]
    });
    let [judged] = judge([share], arranged);
    if !judged.counts() {
        return None;
    }
    let phase: Vec<f64> = angle.values.iter().map(|q| (order as f64 * q).rem_euclid(TAU)).collect();
    let bin = |p: &f64| Some(((p / TAU * f64::from(PHASE_BINS)) as u16).min(PHASE_BINS - 1));
    let bins = Bins { of: phase.iter().map(bin).collect(), count: usize::from(PHASE_BINS) };
    let variable = RowCondition::Wave { joint, order };
    let condition = Covariate { variable, values: phase, categories: Vec::new() };
    let sums = BinSums::of(table, &bins, |i| i);
    Some(report(table, &condition, &bins, &sums, Statistic::Mean, judged))
}

/// The order whose wave explains most of some rows, with its share of their squares; 0 where none
/// explains any. `mean`: of each series.
fn best_order(
    table: &ResidualTable,
    rows: &[usize],
    mean: &[f64],
    waves: &[SineCosine],
) -> (usize, f64) {
    let values: Vec<f64> = rows
        .iter()
        .flat_map(|i| table.row(*i).iter().zip(mean).map(|(value, mean)| value - mean))
        .collect();
    let total: f64 = rows.iter().map(|i| table.squares[*i]).sum();
    let shares = waves.iter().map(|wave| (wave.order, wave.explained(&values, mean.len()) / total));
    shares.fold((0, 0.0), |a, b| if b.1 > a.1 { b } else { a })
}

/// Sine and cosine of a multiple of an angle, less their means.
struct SineCosine {
    order: usize,
    values: Vec<[f64; 2]>,
    /// Inverse of the sums of their squares and products: sine, both, cosine.
    inverse: [f64; 3],
}

impl SineCosine {
    fn new(order: usize, rows: &[usize], angle: &[f64]) -> Self {
        let mut values: Vec<[f64; 2]> =
            rows.iter().map(|i| (order as f64 * angle[*i]).sin_cos().into()).collect();
        let n = values.len() as f64;
        for part in 0..2 {
            let mean = values.iter().map(|v| v[part]).sum::<f64>() / n;
            values.iter_mut().for_each(|v| v[part] -= mean);
        }
        let sum = |a: usize, b: usize| values.iter().map(|v| v[a] * v[b]).sum::<f64>();
        let (ss, sc, cc) = (sum(0, 0), sum(0, 1), sum(1, 1));
        let determinant = ss * cc - sc * sc;
        Self { order, values, inverse: [cc / determinant, -sc / determinant, ss / determinant] }
    }

    /// What the best multiple of this wave explains of Σ r², by least squares.
    fn explained(&self, rows: &[f64], width: usize) -> f64 {
        let mut sums = vec![[0.0; 2]; width];
        for (row, [sin, cos]) in rows.chunks_exact(width).zip(&self.values) {
            for (sum, value) in sums.iter_mut().zip(row) {
                sum[0] += value * sin;
                sum[1] += value * cos;
            }
        }
        let [ss, sc, cc] = self.inverse;
        sums.iter().map(|[s, c]| ss * s * s + 2.0 * sc * s * c + cc * c * c).sum()
    }
}
