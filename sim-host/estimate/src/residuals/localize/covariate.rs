//! The conditions under which each row of a log was recorded.

use super::table::ResidualTable;
use crate::predict::Prediction;
use crate::residuals::finding::{Category, RowCondition};
use trueweld_core::JOINTS;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::rates::rate;

/// Bins of a condition, each with as many rows as the others.
const CONDITION_BINS: usize = 8;

/// Fewest rows in a category, as a share of all.
const LEAST_SHARE: f64 = 0.04;

/// A rate below this share of its largest is rest.
const REST: f64 = 0.03;

/// A joint that turns no faster than this is not moved on purpose, rad/s.
const JOINT_RATE_MIN: f64 = 1e-4;

/// One condition, a value a row.
pub(super) struct Covariate {
    pub variable: RowCondition,
    /// NaN where it is not known; of categories their numbers.
    pub values: Vec<f64>,
    pub categories: Vec<Category>,
}

/// Which bin each row of a table lies in.
pub(super) struct Bins {
    /// One entry a row; `None` where the condition is not known.
    pub of: Vec<Option<u16>>,
    /// Number of bins.
    pub count: usize,
}

impl Bins {
    /// The same with two bins each as one.
    pub(crate) fn halved(&self) -> Self {
        Self {
            of: self.of.iter().map(|bin| bin.map(|b| b / 2)).collect(),
            count: self.count.div_ceil(2),
        }
    }

    /// The cells of two conditions: each bin of this one, then of the other.
    pub(crate) fn across(&self, other: &Self) -> Self {
        let both = |(a, b): (&Option<u16>, &Option<u16>)| Some((*a)? * other.count as u16 + (*b)?);
        Self {
            of: self.of.iter().zip(&other.of).map(both).collect(),
            count: self.count * other.count,
        }
    }
}

const SIGNS: [Category; 2] = [Category::Negative, Category::Positive];
const DIRECTIONS: [Category; 3] = [Category::Negative, Category::AtRest, Category::Positive];
const TENDENCIES: [Category; 3] = [Category::Falling, Category::Steady, Category::Rising];

fn number(variable: RowCondition, values: Vec<f64>) -> Covariate {
    category(variable, &[], values)
}

fn category(variable: RowCondition, categories: &[Category], values: Vec<f64>) -> Covariate {
    Covariate { variable, values, categories: categories.to_vec() }
}

/// All conditions of a log, a value a row of it.
pub(super) fn of(log: &Log, prediction: &Prediction) -> Vec<Covariate> {
    let samples = &log.samples;
    let (n, time) = (samples.len(), &samples.time);
    let start = time.first().copied().unwrap_or(0.0);
    let mut all = vec![number(RowCondition::Time, time.iter().map(|t| t - start).collect())];
    let still = log.kind == LogKind::StaticLoad;
    // Between loads at rest, what the last change was.
    let change = |series: &[f64]| -> Vec<f64> {
        (0..n).map(|k| series[k] - series[k.saturating_sub(1)]).collect()
    };
    let slope = |series: &[f64]| rate(log, series).unwrap_or_else(|| change(series));
    // Falling, steady or rising, by a share of the largest change.
    let tendency = |slope: &[f64]| -> Vec<f64> {
        let most = slope.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        slope.iter().map(|v| if v.abs() <= REST * most { 1.0 } else { 1.0 + v.signum() }).collect()
    };
    for joint in 0..JOINTS {
        let angle: Vec<f64> = match &prediction.motion {
            Some(motion) if motion.link.len() == n => {
                motion.link.iter().map(|q| q[joint]).collect()
            }
            _ => samples.encoder.iter().map(|q| q[joint]).collect(),
        };
        all.push(number(RowCondition::Angle(joint), angle.clone()));
        if !still {
            let rate = slope(&angle);
            if rate.iter().any(|r| r.abs() > JOINT_RATE_MIN) {
                all.push(category(RowCondition::Motion(joint), &DIRECTIONS, tendency(&rate)));
                all.push(number(RowCondition::Acceleration(joint), slope(&rate)));
                all.push(number(RowCondition::Rate(joint), rate));
            }
        }
        if let Some(motion) = prediction.motion.as_ref().filter(|m| m.spring.len() == n) {
            let torque: Vec<f64> = motion.spring.iter().map(|t| t[joint]).collect();
            let sign = torque.iter().map(|t| if *t > 0.0 { 1.0 } else { 0.0 }).collect();
            all.push(category(RowCondition::SpringSign(joint), &SIGNS, sign));
            all.push(category(
                RowCondition::SpringTendency(joint),
                &TENDENCIES,
                tendency(&slope(&torque)),
            ));
            all.push(number(RowCondition::SpringTorque(joint), torque));
        }
    }
    if let Some(payload) = &samples.payload {
        all.push(number(RowCondition::Payload, payload.iter().map(|p| p.mass).collect()));
    }
    if let Some(force) = &samples.force {
        let load: Vec<f64> = force.iter().map(|f| f.norm()).collect();
        if still {
            all.push(category(RowCondition::LoadTendency, &TENDENCIES, tendency(&slope(&load))));
        }
        all.push(number(RowCondition::Load, load));
    }
    if let Some(path) = log.along_weld() {
        all.push(number(RowCondition::Path, path));
    }
    all
}

impl Covariate {
    /// The conditions of the rows of a table, from those of its logs; with the log itself where
    /// there are several.
    pub(crate) fn joined(table: &ResidualTable, of_logs: &[Vec<Self>]) -> Vec<Self> {
        let mut known: Vec<&Self> = Vec::new();
        for span in &table.spans {
            let (log, _) = table.rows[span.start];
            for condition in &of_logs[log] {
                if !known.iter().any(|c| c.variable == condition.variable) {
                    known.push(condition);
                }
            }
        }
        let value = |variable: RowCondition, (log, row): (usize, usize)| {
            let found = of_logs[log].iter().find(|c| c.variable == variable);
            found.map_or(f64::NAN, |c| c.values[row])
        };
        let mut joined: Vec<Self> = known
            .iter()
            .map(|like| Self {
                values: table.rows.iter().map(|row| value(like.variable, *row)).collect(),
                categories: like.categories.clone(),
                ..**like
            })
            .collect();
        if table.spans.len() > 1 {
            let mut which = vec![0.0; table.rows.len()];
            table.spans.iter().enumerate().for_each(|(k, span)| which[span.clone()].fill(k as f64));
            let logs: Vec<Category> = (0..table.logs.len()).map(Category::Log).collect();
            joined.push(category(RowCondition::Log, &logs, which));
        }
        joined
    }

    /// The rows' bins; `None` where all rows are alike.
    pub(crate) fn bins(&self) -> Option<Bins> {
        let known: Vec<f64> = self.values.iter().copied().filter(|v| v.is_finite()).collect();
        if 2 * known.len() < self.values.len() {
            return None;
        }
        if !self.categories.is_empty() {
            let of: Vec<Option<u16>> =
                self.values.iter().map(|v| v.is_finite().then_some(*v as u16)).collect();
            let rows = |c: u16| of.iter().filter(|b| **b == Some(c)).count() as f64;
            let enough = (0..self.categories.len() as u16)
                .filter(|c| rows(*c) >= LEAST_SHARE * known.len() as f64);
            return (enough.count() > 1).then_some(Bins { of, count: self.categories.len() });
        }
        let mut sorted = known;
        sorted.sort_by(f64::total_cmp);
        // Upper ends; equal values stay together.
        let mut ends: Vec<f64> =
            (1..=CONDITION_BINS).map(|b| sorted[b * sorted.len() / CONDITION_BINS - 1]).collect();
        ends.dedup();
        if ends.len() < 2 {
            return None;
        }
        let bin = |v: &f64| {
            v.is_finite().then(|| ends.partition_point(|end| end < v).min(ends.len() - 1) as u16)
        };
        Some(Bins { of: self.values.iter().map(bin).collect(), count: ends.len() })
    }
}
