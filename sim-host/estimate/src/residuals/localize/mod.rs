//! Where a model fails: which conditions its residual follows, and in which of them it is large.
//!
//! Logs of one kind are put together, channel by channel. Each condition under which a row was
//! recorded (a posture, a torque, the direction of motion, the load, …) is cut into bins, and two
//! shares of the squared residual are taken: what the bins' means explain, Σ n_b (m_b − m)² / Σ r²,
//! and what would have to move from bin to bin for the squares to lie evenly. Both are set against
//! residuals of the same log put under other conditions: blocks of rows, longer than the residual
//! remembers, change places, so that a slow residual does not pass for a dependence. Left out: what
//! the reason is.

mod covariate;
mod map;
mod orders;
mod spectrum;
mod table;

pub use crate::residuals::finding::{
    Category, ConditionBin, ConditionCurve, Finding, MapAxis, ResidualMap, RowCondition, Statistic,
};

use crate::predict::{Prediction, PreparedLog};
use crate::residuals::finding::NOISE_FLOOR_SCORE;
use covariate::{Bins, Covariate};
use rayon::prelude::*;
use table::{JudgedShare, ResidualTable, SeriesGroup};
use trueweld_logs::log::Log;

/// Arrangements that a share is set against: p-values come in steps of 1/200.
pub const ARRANGEMENTS: usize = 199;

/// Exceeded so often, a share is taken for chance without trying the other arrangements.
const CHANCE_EXCEEDANCES: usize = 10;

/// Findings of one channel whose share above chance comes so near the best are named with it.
const NEAR_BEST_SHARE: f64 = 0.85;

/// What the residuals of some logs go with, largest share first; what goes with nothing beyond
/// chance is not listed.
///
/// `experiments` and `predictions` belong to `logs`, place by place; the predictions need their
/// motion. Random arrangements are seeded: the same residuals give the same findings.
pub fn localize(
    experiments: &[PreparedLog],
    predictions: &[Prediction],
    logs: &[Log],
) -> Vec<Finding> {
    let conditions: Vec<Vec<Covariate>> = logs
        .par_iter()
        .zip(predictions)
        .map(|(log, prediction)| covariate::of(log, prediction))
        .collect();
    let mut findings: Vec<Finding> = ResidualTable::all(experiments, predictions, logs)
        .par_iter()
        .flat_map(|table| {
            let mut of_table = findings_of(table, &conditions, logs);
            name_similar(&mut of_table);
            of_table
        })
        .collect();
    findings.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    findings
}

/// The worst finding of each channel of each kind of log above the noise floor, `count` at most:
/// what a person reads first. The band of frequency, which says little of a reason, stands only
/// where nothing else does.
pub fn foremost(findings: &[Finding], count: usize) -> Vec<&Finding> {
    let mut chosen: Vec<&Finding> = Vec::new();
    let by_frequency = |f: &&Finding| f.variable == RowCondition::Frequency;
    let above = || findings.iter().filter(|f| f.score > NOISE_FLOOR_SCORE);
    for finding in above().filter(|f| !by_frequency(f)).chain(above().filter(by_frequency)) {
        if !chosen.iter().any(|f| f.kind == finding.kind && f.channel == finding.channel) {
            chosen.push(finding);
        }
    }
    chosen.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    chosen.truncate(count);
    chosen
}

/// All that one channel's residual goes with.
fn findings_of(table: &ResidualTable, conditions: &[Vec<Covariate>], logs: &[Log]) -> Vec<Finding> {
    let arrangements = table.arrangements(ARRANGEMENTS);
    let joined = Covariate::joined(table, conditions);
    let mut found: Vec<Finding> = joined
        .par_iter()
        .filter_map(|condition| by_rows(table, condition, &arrangements))
        .collect();
    found.extend(table.series_groups().iter().filter_map(|group| by_series(table, group)));
    found.extend(offset(table));
    found.extend(orders::of(table, &joined, &arrangements));
    found.extend(spectrum::of(table, logs, &arrangements));
    found.sort_by(|a, b| b.excess().total_cmp(&a.excess()));
    let map = map::of(table, &joined, &found, &arrangements);
    // The first that a person is told of.
    if let Some(first) = found.iter_mut().find(|f| f.variable != RowCondition::Frequency) {
        first.map = map;
    }
    found
}

fn name_similar(findings: &mut [Finding]) {
    let all: Vec<(RowCondition, f64)> = findings
        .iter()
        .filter(|f| f.variable != RowCondition::Frequency)
        .map(|f| (f.variable, f.excess()))
        .collect();
    for finding in findings.iter_mut().filter(|f| f.variable != RowCondition::Frequency) {
        let least = NEAR_BEST_SHARE * finding.excess();
        let near =
            all.iter().filter(|(other, excess)| *other != finding.variable && *excess >= least);
        finding.similar = near.take(3).map(|(other, _)| *other).collect();
    }
}

/// Shares of the squared residual in some bins.
struct Shares {
    mean: f64,
    size: f64,
}

/// Sums over the rows of each bin.
struct BinSums {
    rows: Vec<f64>,
    squares: Vec<f64>,
    /// By bin, then by series.
    values: Vec<f64>,
}

impl BinSums {
    /// With the residual of row `order(i)` under the condition of row i.
    fn of(table: &ResidualTable, bins: &Bins, order: impl Fn(usize) -> usize) -> Self {
        let width = table.series.len();
        let mut sums = Self {
            rows: vec![0.0; bins.count],
            squares: vec![0.0; bins.count],
            values: vec![0.0; bins.count * width],
        };
        for (i, bin) in bins.of.iter().enumerate() {
            let Some(bin) = bin.map(usize::from) else {
                continue;
            };
            let row = order(i);
            sums.rows[bin] += 1.0;
            sums.squares[bin] += table.squares[row];
            let values = &mut sums.values[bin * width..(bin + 1) * width];
            values.iter_mut().zip(table.row(row)).for_each(|(sum, value)| *sum += value);
        }
        sums
    }

    /// Part of each bin in what the means explain, per series: n_b (m_b − m)².
    fn explained(&self, width: usize, bin: usize, series: usize) -> f64 {
        let rows: f64 = self.rows.iter().sum();
        let sum: f64 = self.values.iter().skip(series).step_by(width).sum();
        let n = self.rows[bin];
        if n > 0.0 { n * (self.values[bin * width + series] / n - sum / rows).powi(2) } else { 0.0 }
    }

    fn shares(&self, width: usize) -> Shares {
        let (rows, total): (f64, f64) = (self.rows.iter().sum(), self.squares.iter().sum());
        let mut between = 0.0;
        for series in 0..width {
            let mut sum = 0.0;
            for (bin, n) in self.rows.iter().enumerate().filter(|(_, n)| **n > 0.0) {
                let value = self.values[bin * width + series];
                sum += value;
                between += value * value / n;
            }
            between -= sum * sum / rows;
        }
        let away = |(squares, n): (&f64, &f64)| (squares - n * total / rows).abs();
        let moved: f64 = self.squares.iter().zip(&self.rows).map(away).sum();
        Shares { mean: between.max(0.0) / total, size: 0.5 * moved / total }
    }
}

/// Sets shares against those of random arrangements, given one after the other.
fn judge<const N: usize>(
    shares: [f64; N],
    mut arranged: impl Iterator<Item = [f64; N]>,
) -> [JudgedShare; N] {
    let (mut tried, mut reached, mut sum) = (0, [0; N], [0.0; N]);
    while reached.iter().any(|r| *r < CHANCE_EXCEEDANCES)
        && let Some(chance) = arranged.next()
    {
        tried += 1;
        for k in 0..N {
            // One that arranges the rows as they were recorded reaches it but for rounding.
            reached[k] += usize::from(chance[k] >= shares[k] * (1.0 - 1e-9));
            sum[k] += chance[k];
        }
    }
    std::array::from_fn(|k| JudgedShare {
        share: shares[k],
        by_chance: sum[k] / f64::from(tried.max(1)),
        p: (reached[k] + 1) as f64 / f64::from(tried + 1),
    })
}

/// What goes with a condition of the rows.
fn by_rows(
    table: &ResidualTable,
    condition: &Covariate,
    arrangements: &[Vec<u32>],
) -> Option<Finding> {
    let bins = condition.bins()?;
    let sums = BinSums::of(table, &bins, |i| i);
    let width = table.series.len();
    let Shares { mean, size } = sums.shares(width);
    let arranged = arrangements.iter().map(|order| {
        let shares = BinSums::of(table, &bins, |i| order[i] as usize).shares(width);
        [shares.mean, shares.size]
    });
    let [mean, size] = judge([mean, size], arranged);
    let how = match (mean.counts(), size.counts()) {
        (false, false) => return None,
        (true, false) => Statistic::Mean,
        (false, true) => Statistic::Size,
        (true, true) => {
            if mean.excess() >= size.excess() {
                Statistic::Mean
            } else {
                Statistic::Size
            }
        }
    };
    let judged = if how == Statistic::Mean { mean } else { size };
    Some(report(table, condition, &bins, &sums, how, judged))
}

/// The finding of a condition that was judged.
fn report(
    table: &ResidualTable,
    condition: &Covariate,
    bins: &Bins,
    sums: &BinSums,
    how: Statistic,
    judged: JudgedShare,
) -> Finding {
    let width = table.series.len();
    let total: f64 = sums.squares.iter().sum();
    let rows: f64 = sums.rows.iter().sum();
    let by_bin = |bin: usize| match how {
        Statistic::Mean => {
            (0..width).map(|s| sums.explained(width, bin, s)).sum::<f64>() / sums.rows[bin].max(1.0)
        }
        Statistic::Size => sums.squares[bin] / sums.rows[bin].max(1.0),
    };
    let there = largest(bins.count, by_bin);
    // The column that it shows in most.
    let series = largest(width, |s| match how {
        Statistic::Mean => (0..bins.count).map(|b| sums.explained(width, b, s)).sum(),
        Statistic::Size => table.squares_of(s, |i| bins.of[i] == Some(there as u16)),
    });
    let inside = |bin: usize| (0..bins.of.len()).filter(move |i| bins.of[*i] == Some(bin as u16));
    let points = (0..bins.count)
        .filter(|bin| sums.rows[*bin] > 0.0)
        .map(|bin| {
            let x = inside(bin).map(|i| condition.values[i]).sum::<f64>() / sums.rows[bin];
            table.point(x, how, series, inside(bin))
        })
        .collect();
    let (low, high) = inside(there)
        .map(|i| condition.values[i])
        .fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
    let filled = condition.categories.iter().zip(&sums.rows).filter(|(_, rows)| **rows > 0.0);
    Finding {
        variable: condition.variable,
        low,
        high,
        category: condition.categories.get(there).copied(),
        share_there: sums.squares[there] / total,
        samples_there: sums.rows[there] / rows,
        curve: ConditionCurve {
            categories: filled.map(|(category, _)| *category).collect(),
            series: Some((table.series[series].quantity, table.series[series].column)),
            y_unit: table.series[series].quantity.unit(),
            points,
        },
        ..table.finding(how, judged)
    }
}

/// What lies in one group of series more than in the others.
fn by_series(table: &ResidualTable, group: &SeriesGroup) -> Option<Finding> {
    let members = |c: usize| group.of.iter().filter(|of| **of == c).count() as f64;
    let width = table.series.len();
    let blocks = table.blocks();
    let sums_by_block: Vec<Vec<f64>> = blocks
        .iter()
        .map(|block| (0..width).map(|s| table.squares_of(s, |i| block.contains(&i))).collect())
        .collect();
    let total: f64 = sums_by_block.iter().flatten().sum();
    let share = |sums: &[f64]| {
        let away = |(c, sum): (usize, &f64)| (sum - total * members(c) / width as f64).abs();
        0.5 * sums.iter().enumerate().map(away).sum::<f64>() / total
    };
    let mut sums = vec![0.0; group.categories.len()];
    sums_by_block.iter().for_each(|block| (0..width).for_each(|s| sums[group.of[s]] += block[s]));
    // By chance, each block's squares could be any series' own.
    let mut random = table.random(1);
    let arranged = (0..ARRANGEMENTS).map(|_| {
        let mut sums = vec![0.0; group.categories.len()];
        for block in &sums_by_block {
            let order = table::shuffled(width, &mut random);
            (0..width).for_each(|s| sums[group.of[order[s] as usize]] += block[s]);
        }
        [share(&sums)]
    });
    let [judged] = judge([share(&sums)], arranged);
    if !judged.counts() {
        return None;
    }
    let there = largest(sums.len(), |c| sums[c] / members(c).max(1.0));
    let points = (0..sums.len())
        .map(|c| {
            let of_group: Vec<usize> = (0..width).filter(|s| group.of[*s] == c).collect();
            table.point_of_group(c as f64, &of_group)
        })
        .collect();
    Some(Finding {
        variable: group.variable,
        low: there as f64,
        high: there as f64,
        category: Some(group.categories[there]),
        share_there: sums[there] / total,
        samples_there: members(there) / width as f64,
        curve: ConditionCurve {
            categories: group.categories.clone(),
            series: None,
            y_unit: table.series[0].quantity.unit(),
            points,
        },
        ..table.finding(Statistic::Size, judged)
    })
}

/// What stays the same in all rows: Σ n m² / Σ r², against residuals of which whole blocks change
/// their sign.
fn offset(table: &ResidualTable) -> Option<Finding> {
    let width = table.series.len();
    let sums_by_block: Vec<Vec<f64>> = table
        .blocks()
        .into_iter()
        .map(|block| (0..width).map(|s| block.clone().map(|i| table.row(i)[s]).sum()).collect())
        .collect();
    let (rows, total) = (table.squares.len() as f64, table.squares.iter().sum::<f64>());
    let share = |sign: &mut dyn FnMut() -> f64| {
        let sums = signed_sums(&sums_by_block, width, sign);
        sums.iter().map(|sum| sum * sum).sum::<f64>() / rows / total
    };
    let mut random = table.random(2);
    let arranged = (0..ARRANGEMENTS).map(|_| [share(&mut || table::sign(&mut random))]);
    let [judged] = judge([share(&mut || 1.0)], arranged);
    if !judged.counts() {
        return None;
    }
    let everywhere = || 0..table.squares.len();
    let points: Vec<ConditionBin> =
        (0..width).map(|s| table.point(s as f64, Statistic::Mean, s, everywhere())).collect();
    let mean = |s: usize| everywhere().map(|i| table.row(i)[s]).sum::<f64>().abs();
    let there = largest(width, mean);
    Some(Finding {
        variable: RowCondition::Offset,
        low: there as f64,
        high: there as f64,
        category: Some(table.series[there].category()),
        share_there: table.squares_of(there, |_| true) / total,
        samples_there: 1.0 / width as f64,
        curve: ConditionCurve {
            categories: table.series.iter().map(table::ComparedSeries::category).collect(),
            series: None,
            y_unit: table.series[0].quantity.unit(),
            points,
        },
        ..table.finding(Statistic::Mean, judged)
    })
}

/// Sum of each series over blocks, of which each is multiplied by the next sign.
fn signed_sums(
    sums_by_block: &[Vec<f64>],
    width: usize,
    sign: &mut dyn FnMut() -> f64,
) -> Vec<f64> {
    let mut sums = vec![0.0; width];
    for block in sums_by_block {
        let sign = sign();
        sums.iter_mut().zip(block).for_each(|(sum, value)| *sum += sign * value);
    }
    sums
}

/// Place of the largest of some values.
fn largest(count: usize, of: impl Fn(usize) -> f64) -> usize {
    (0..count).max_by(|a, b| of(*a).total_cmp(&of(*b))).unwrap_or(0)
}
