//! Residuals of one channel in all logs of one kind, row by row.

use crate::predict::{ComparedQuantity, Prediction, PreparedLog};
use crate::residuals::finding::{
    Category, ConditionBin, ConditionCurve, Finding, RowCondition, Statistic,
};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::BTreeMap;
use std::ops::Range;
use trueweld_core::JOINTS;
use trueweld_logs::log::{Log, LogKind};

/// Rows kept: of longer logs every second, third, … row.
const KEPT_ROWS_MAX: usize = 2000;

/// Fewest rows that something can be told of.
const FEWEST_ROWS: usize = 24;

/// A residual is taken to remember as long as its autocorrelation exceeds this, and no longer than
/// this share of a log.
const AUTOCORRELATION_MIN: f64 = 0.2;
const LONGEST_SHARE: usize = 8;

/// Seed of all arrangements.
const SEED: u64 = 20_100_137;

/// Largest p of what is reported, and least share above chance.
const SIGNIFICANT: f64 = 0.01;
pub(super) const EXPLAINED_ABOVE_CHANCE_MIN: f64 = 0.01;

/// A share set against chance.
#[derive(Clone, Copy)]
pub(super) struct JudgedShare {
    pub share: f64,
    pub by_chance: f64,
    pub p: f64,
}

impl JudgedShare {
    pub(crate) fn excess(self) -> f64 {
        self.share - self.by_chance
    }

    pub(crate) fn counts(self) -> bool {
        self.p <= SIGNIFICANT && self.excess() >= EXPLAINED_ABOVE_CHANCE_MIN
    }
}

/// Series of a table put together in groups: its columns, or the spindle's orders.
pub(super) struct SeriesGroup {
    pub variable: RowCondition,
    pub categories: Vec<Category>,
    /// Category of every series.
    pub of: Vec<usize>,
}

/// One compared series.
pub(super) struct ComparedSeries {
    pub quantity: ComparedQuantity,
    pub column: u8,
}

impl ComparedSeries {
    pub(crate) fn category(&self) -> Category {
        Category::Series(self.quantity, self.column)
    }
}

/// Residuals with a row for every instant and a column for every series.
pub(super) struct ResidualTable {
    pub kind: LogKind,
    pub channel: &'static str,
    pub series: Vec<ComparedSeries>,
    /// Names of the logs, and of their robot's joints.
    pub logs: Vec<String>,
    joints: [String; JOINTS],
    /// Log, by its place among all logs, and row in it.
    pub rows: Vec<(usize, usize)>,
    /// Rows of each log.
    pub spans: Vec<Range<usize>>,
    /// Σ r² of each row.
    pub squares: Vec<f64>,
    /// Residuals over their noise, and that noise.
    values: Vec<f64>,
    deviations: Vec<f64>,
    /// Rows that the residual remembers, and rows that count as one.
    memory: Vec<usize>,
    correlated: f64,
}

/// Series of a log and the rows in which all of them have a value.
type CommonRows = BTreeMap<usize, Vec<(f64, f64)>>;

/// Logs, by their place, in which the same series were recorded.
struct Gathered {
    kind: LogKind,
    series: Vec<(ComparedQuantity, u8)>,
    of_logs: Vec<(usize, CommonRows)>,
}

impl ResidualTable {
    /// All channels of all kinds of logs. Logs of which other columns were recorded make a table of
    /// their own.
    pub(crate) fn all(
        experiments: &[PreparedLog],
        predictions: &[Prediction],
        logs: &[Log],
    ) -> Vec<Self> {
        let mut groups: Vec<Gathered> = Vec::new();
        for (k, (experiment, prediction)) in experiments.iter().zip(predictions).enumerate() {
            let mut channels: Vec<(&str, Vec<(ComparedQuantity, u8)>)> = Vec::new();
            for compared in &experiment.compared {
                let (name, series) =
                    (compared.quantity.channel(), (compared.quantity, compared.component));
                match channels.iter_mut().find(|c| c.0 == name) {
                    Some((_, list)) if list.contains(&series) => {}
                    Some((_, list)) => list.push(series),
                    None => channels.push((name, vec![series])),
                }
            }
            for (name, series) in channels {
                let mut rows = CommonRows::new();
                for (compared, residual) in experiment.compared.iter().zip(&prediction.residual) {
                    if compared.quantity.channel() == name {
                        let place = series
                            .iter()
                            .position(|s| *s == (compared.quantity, compared.component));
                        let row = rows
                            .entry(compared.row)
                            .or_insert_with(|| vec![(f64::NAN, 1.0); series.len()]);
                        row[place.unwrap_or(0)] = (*residual, compared.deviation);
                    }
                }
                rows.retain(|_, values| values.iter().all(|v| v.0.is_finite()));
                match groups.iter_mut().find(|g| g.kind == experiment.kind && g.series == series) {
                    Some(group) => group.of_logs.push((k, rows)),
                    None => groups.push(Gathered {
                        kind: experiment.kind,
                        series,
                        of_logs: vec![(k, rows)],
                    }),
                }
            }
        }
        groups.into_iter().filter_map(|group| Self::new(group, logs)).collect()
    }

    fn new(Gathered { kind, series, of_logs }: Gathered, logs: &[Log]) -> Option<Self> {
        let total: usize = of_logs.iter().map(|(_, rows)| rows.len()).sum();
        if total < FEWEST_ROWS {
            return None;
        }
        let stride = total.div_ceil(KEPT_ROWS_MAX);
        let mut table = Self {
            kind,
            channel: series[0].0.channel(),
            series: series
                .iter()
                .map(|(quantity, column)| ComparedSeries { quantity: *quantity, column: *column })
                .collect(),
            logs: of_logs.iter().map(|(k, _)| logs[*k].name.clone()).collect(),
            joints: logs[of_logs[0].0].robot.joint_names.clone(),
            rows: Vec::new(),
            spans: Vec::new(),
            squares: Vec::new(),
            values: Vec::new(),
            deviations: Vec::new(),
            memory: Vec::new(),
            correlated: 1.0,
        };
        for (k, rows) in of_logs {
            let begin = table.rows.len();
            for (row, values) in rows.iter().step_by(stride) {
                table.rows.push((k, *row));
                table.squares.push(values.iter().map(|v| v.0 * v.0).sum());
                table.values.extend(values.iter().map(|v| v.0));
                table.deviations.extend(values.iter().map(|v| v.1));
            }
            table.spans.push(begin..table.rows.len());
        }
        table.remember();
        (table.squares.iter().sum::<f64>() > 0.0).then_some(table)
    }

    /// Sum over the rows of a log of the products with the row so many later, each less the `mean`
    /// of its series.
    fn covariance(&self, span: &Range<usize>, mean: &[f64], lag: usize) -> f64 {
        let product = |i: usize| {
            let (a, b) = (self.row(i), self.row(i + lag));
            (0..mean.len()).map(|s| (a[s] - mean[s]) * (b[s] - mean[s])).sum::<f64>()
        };
        span.clone().take(span.len().saturating_sub(lag)).map(product).sum()
    }

    /// Finds how long the residual of each log remembers.
    fn remember(&mut self) {
        let width = self.series.len();
        let mut correlated: f64 = 1.0;
        for span in &self.spans {
            let (n, longest) = (span.len(), (span.len() / LONGEST_SHARE).max(1));
            let mean: Vec<f64> = (0..width)
                .map(|s| span.clone().map(|i| self.row(i)[s]).sum::<f64>() / n.max(1) as f64)
                .collect();
            let variance = self.covariance(span, &mean, 0);
            let (mut last, mut sum, mut falling) = (0, 1.0, true);
            for lag in 1..longest {
                let correlation = self.covariance(span, &mean, lag) / variance;
                if correlation.abs() > AUTOCORRELATION_MIN {
                    last = lag;
                }
                falling &= correlation > 0.05;
                if falling {
                    sum += 2.0 * correlation;
                }
                // Nothing for a while: the rest is chance.
                if lag > 4 * (last + 8) {
                    break;
                }
            }
            self.memory.push((2 * last).clamp(1, longest));
            correlated = correlated.max(sum);
        }
        self.correlated = correlated;
    }

    /// Residuals over their noise of one row.
    pub(crate) fn row(&self, row: usize) -> &[f64] {
        &self.values[row * self.series.len()..(row + 1) * self.series.len()]
    }

    /// Residual of one row and series in its unit.
    fn plain(&self, row: usize, series: usize) -> f64 {
        let place = row * self.series.len() + series;
        self.values[place] * self.deviations[place]
    }

    /// Σ r² of one series over some rows.
    pub(crate) fn squares_of(&self, series: usize, rows: impl Fn(usize) -> bool) -> f64 {
        (0..self.squares.len()).filter(|i| rows(*i)).map(|i| self.row(i)[series].powi(2)).sum()
    }

    /// √mean(r²).
    fn score(&self) -> f64 {
        (self.squares.iter().sum::<f64>() / self.values.len().max(1) as f64).sqrt()
    }

    /// Random numbers for one of several uses; the same in every run.
    pub(crate) fn random(&self, which: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(SEED);
        random.set_stream(which);
        random
    }

    /// Stretches of rows, each longer than the residual remembers.
    pub(crate) fn blocks(&self) -> Vec<Range<usize>> {
        self.cut(|_| 0)
    }

    /// Stretches of rows, the first of each log shorter by some rows.
    fn cut(&self, mut shorter: impl FnMut(usize) -> usize) -> Vec<Range<usize>> {
        let mut blocks = Vec::new();
        for (span, length) in self.spans.iter().zip(&self.memory) {
            let mut begin = span.start;
            let mut end = begin + length - shorter(*length);
            while begin < span.end {
                blocks.push(begin..end.min(span.end));
                begin = end;
                end += length;
            }
        }
        blocks
    }

    /// Orders of the rows in which blocks have changed places.
    pub(crate) fn arrangements(&self, count: usize) -> Vec<Vec<u32>> {
        let mut random = self.random(0);
        (0..count)
            .map(|_| {
                let blocks = self.cut(|length| random.random_range(0..length));
                let order = shuffled(blocks.len(), &mut random);
                order.iter().flat_map(|b| blocks[*b as usize].clone()).map(|i| i as u32).collect()
            })
            .collect()
    }

    /// Groups of series that may be worse than others.
    pub(crate) fn series_groups(&self) -> Vec<SeriesGroup> {
        let mut groups = Vec::new();
        let mut columns: Vec<u8> = self.series.iter().map(|s| s.column).collect();
        columns.sort_unstable();
        columns.dedup();
        if columns.len() > 1 {
            let joints = matches!(
                self.series[0].quantity,
                ComparedQuantity::LinkEncoder | ComparedQuantity::MotorTorque
            );
            let category = |c: &u8| match joints {
                true => Category::Joint(usize::from(*c)),
                false => Category::Direction(*c),
            };
            groups.push(SeriesGroup {
                variable: if joints { RowCondition::Joint } else { RowCondition::Direction },
                categories: columns.iter().map(category).collect(),
                of: self
                    .series
                    .iter()
                    .map(|s| columns.iter().position(|c| *c == s.column).unwrap_or(0))
                    .collect(),
            });
        }
        let order = |q: ComparedQuantity| {
            if let ComparedQuantity::Ripple { order, .. } = q { usize::from(order) } else { 0 }
        };
        let most = self.series.iter().map(|s| order(s.quantity)).max().unwrap_or(0);
        if most > 0 {
            groups.push(SeriesGroup {
                variable: RowCondition::SpindleOrder,
                categories: (0..=most).map(|n| Category::SpindleOrder(n as u8)).collect(),
                of: self.series.iter().map(|s| order(s.quantity)).collect(),
            });
        }
        groups
    }

    /// Mean or root mean square of one series over some rows, in its unit.
    pub(crate) fn point(
        &self,
        x: f64,
        how: Statistic,
        series: usize,
        rows: impl Iterator<Item = usize>,
    ) -> ConditionBin {
        let values: Vec<f64> = rows.map(|i| self.plain(i, series)).collect();
        let n = values.len().max(1) as f64;
        let independent = (n / self.correlated).max(1.0);
        let mean = values.iter().sum::<f64>() / n;
        let squares = values.iter().map(|v| v * v).sum::<f64>() / n;
        match how {
            Statistic::Mean => ConditionBin {
                x,
                y: mean,
                error: ((squares - mean * mean).max(0.0) / independent).sqrt(),
            },
            Statistic::Size => {
                ConditionBin { x, y: squares.sqrt(), error: (squares / (2.0 * independent)).sqrt() }
            }
        }
    }

    /// Root mean square of several series over all rows, in their unit.
    pub(crate) fn point_of_group(&self, x: f64, series: &[usize]) -> ConditionBin {
        let rows = self.squares.len();
        let n = (rows * series.len()).max(1) as f64;
        let all = series.iter().flat_map(|s| (0..rows).map(|i| self.plain(i, *s)));
        let squares = all.map(|v| v * v).sum::<f64>() / n;
        let independent = (n / self.correlated).max(1.0);
        ConditionBin { x, y: squares.sqrt(), error: (squares / (2.0 * independent)).sqrt() }
    }

    /// A finding about this table, with everything still to be said that belongs to its condition.
    pub(crate) fn finding(&self, how: Statistic, judged: JudgedShare) -> Finding {
        Finding {
            kind: self.kind,
            channel: self.channel,
            logs: self.logs.clone(),
            score: self.score(),
            joints: self.joints.clone(),
            variable: RowCondition::Offset,
            how,
            share: judged.share,
            by_chance: judged.by_chance,
            p: judged.p,
            low: 0.0,
            high: 0.0,
            category: None,
            share_there: 0.0,
            samples_there: 0.0,
            similar: Vec::new(),
            curve: ConditionCurve {
                categories: Vec::new(),
                series: None,
                y_unit: "",
                points: Vec::new(),
            },
            map: None,
        }
    }
}

/// The numbers below `count` in random order.
pub(super) fn shuffled(count: usize, random: &mut ChaCha8Rng) -> Vec<u32> {
    let mut order: Vec<u32> = (0..count as u32).collect();
    for k in (1..count).rev() {
        order.swap(k, random.random_range(0..=k));
    }
    order
}

/// 1 or −1.
pub(super) fn sign(random: &mut ChaCha8Rng) -> f64 {
    if random.random::<bool>() { 1.0 } else { -1.0 }
}
