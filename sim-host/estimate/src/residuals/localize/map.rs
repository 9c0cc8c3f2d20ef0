//! Residuals over two conditions, where one does not do: friction that grows with the torque makes a
//! residual that follows neither torque nor direction of motion as it follows both together.

use super::covariate::{Bins, Covariate};
use super::table::{JudgedShare, ResidualTable};
use super::{BinSums, Finding, RowCondition, Statistic, judge, largest};
use crate::residuals::finding::{MapAxis, ResidualMap};

/// Conditions by which the residual's mean changes most, of which each is tried with every other.
const PAIRED_CONDITIONS: usize = 3;

/// Share of the squared residual that two conditions must explain beyond chance, above what the
/// better of the two does alone, and how many times as much.
const PAIR_EXPLAINS_MIN: f64 = 0.08;
const PAIR_EXPLAINS_RATIO_MIN: f64 = 1.25;

/// Rows for each cell of a map of 8 by 8 bins; where there are fewer, two bins of a number are one.
const ROWS_PER_CELL: usize = 12;

/// Fewest rows of a cell whose mean is shown, and share of the rows that lie in such cells.
const CELL_ROWS_MIN: f64 = 4.0;
const SHOWN_ROWS_SHARE: f64 = 0.8;

/// The two conditions that the mean residual of a table follows together, where no single one
/// explains nearly as much. `found`: what it follows by one, the most first.
pub(super) fn of(
    table: &ResidualTable,
    joined: &[Covariate],
    found: &[Finding],
    arrangements: &[Vec<u32>],
) -> Option<ResidualMap> {
    let width = table.series.len();
    let few = table.squares.len() < 64 * ROWS_PER_CELL;
    let bins_of = |c: &Covariate| match c.bins()? {
        bins if few && c.categories.is_empty() => Some(bins.halved()),
        bins => Some(bins),
    };
    let binned: Vec<(&Covariate, Bins)> =
        joined.iter().filter_map(|c| Some((c, bins_of(c)?))).collect();
    let share = |bins: &Bins| BinSums::of(table, bins, |i| i).shares(width).mean;
    let alone: Vec<f64> = binned.iter().map(|(_, bins)| share(bins)).collect();
    let mut order: Vec<usize> = (0..binned.len()).collect();
    order.sort_by(|a, b| alone[*b].total_cmp(&alone[*a]));
    let pairs = order.iter().take(PAIRED_CONDITIONS).flat_map(|a| {
        let others = (0..binned.len()).filter(move |b| b != a);
        others.map(move |b| (*a, b))
    });
    let (together, a, b) = pairs
        .map(|(a, b)| (share(&binned[a].1.across(&binned[b].1)), a, b))
        .max_by(|x, y| x.0.total_cmp(&y.0))?;
    // What else is told of one condition, such as a wave of the angle, counts as well.
    let by_one = found
        .iter()
        .filter(|f| f.variable != RowCondition::Frequency)
        .map(Finding::excess)
        .fold(alone[a].max(alone[b]), f64::max);
    if together < (by_one + PAIR_EXPLAINS_MIN).max(PAIR_EXPLAINS_RATIO_MIN * by_one) {
        return None;
    }
    let cells = binned[a].1.across(&binned[b].1);
    let rows = BinSums::of(table, &cells, |i| i).rows;
    let shown: f64 = rows.iter().filter(|n| **n >= CELL_ROWS_MIN).sum();
    if shown < SHOWN_ROWS_SHARE * table.squares.len() as f64 {
        return None;
    }
    let arranged = arrangements
        .iter()
        .map(|order| [BinSums::of(table, &cells, |i| order[i] as usize).shares(width).mean]);
    let [judged] = judge([together], arranged);
    let enough =
        judged.excess() >= (by_one + PAIR_EXPLAINS_MIN).max(PAIR_EXPLAINS_RATIO_MIN * by_one);
    (judged.counts() && enough).then(|| drawn(table, [&binned[a], &binned[b]], &cells, judged))
}

/// The map of two conditions.
fn drawn(
    table: &ResidualTable,
    [x, y]: [&(&Covariate, Bins); 2],
    cells: &Bins,
    judged: JudgedShare,
) -> ResidualMap {
    let width = table.series.len();
    let sums = BinSums::of(table, cells, |i| i);
    let by_series = |s: usize| (0..cells.count).map(|c| sums.explained(width, c, s)).sum::<f64>();
    let series = largest(width, by_series);
    let mean = |cell: usize| {
        let rows = (0..cells.of.len()).filter(|i| cells.of[*i] == Some(cell as u16));
        let mean = table.point(0.0, Statistic::Mean, series, rows).y;
        if sums.rows[cell] < CELL_ROWS_MIN { f64::NAN } else { mean }
    };
    ResidualMap {
        x: axis(x),
        y: axis(y),
        series: (table.series[series].quantity, table.series[series].column),
        mean: (0..y.1.count)
            .map(|row| (0..x.1.count).map(|column| mean(column * y.1.count + row)).collect())
            .collect(),
        share: judged.share,
        by_chance: judged.by_chance,
        p: judged.p,
    }
}

fn axis((condition, bins): &(&Covariate, Bins)) -> MapAxis {
    let mean = |bin: usize| {
        let own = bins.of.iter().zip(&condition.values).filter(|(b, _)| **b == Some(bin as u16));
        let (count, sum) = own.fold((0.0, 0.0), |(n, sum), (_, v)| (n + 1.0, sum + v));
        sum / count
    };
    MapAxis {
        variable: condition.variable,
        categories: condition.categories.clone(),
        values: (0..bins.count).map(mean).collect(),
    }
}
