//! The conditions under which each row of a log was recorded.

use super::table::ResidualTable;
use crate::data::log::{Log, LogKind};
use crate::data::rates::rate;
use crate::predict::Prediction;
use crate::residuals::finding::joint_name;
use nalgebra::Vector3;
use trueweld_core::JOINTS;
use trueweld_plant::simulate::Seam;

/// Bins of a condition, each with as many rows as the others.
const BINS: usize = 8;

/// Fewest rows in a category, as a share of all.
const LEAST_SHARE: f64 = 0.04;

/// A rate below this share of its largest is rest.
const REST: f64 = 0.03;

/// A joint that turns no faster than this is not moved on purpose, rad/s.
const STILL: f64 = 1e-4;

/// One condition, a value a row.
pub(super) struct Covariate {
    pub name: String,
    /// Empty for categories.
    pub unit: &'static str,
    /// NaN where it is not known; of categories their numbers.
    pub values: Vec<f64>,
    pub categories: Vec<String>,
}

/// Which bin each row of a table lies in.
pub(super) struct Bins {
    /// One entry a row; `None` where the condition is not known.
    pub of: Vec<Option<u16>>,
    /// Number of bins.
    pub count: usize,
}

const SIGNS: [&str; 2] = ["negative", "positive"];
const DIRECTIONS: [&str; 3] = ["negative", "at rest", "positive"];
const TENDENCIES: [&str; 3] = ["falling", "steady", "rising"];

fn number(name: impl Into<String>, unit: &'static str, values: Vec<f64>) -> Covariate {
    Covariate { name: name.into(), unit, values, categories: Vec::new() }
}

fn category(name: String, names: &[&str], values: Vec<f64>) -> Covariate {
    Covariate {
        name,
        unit: "",
        values,
        categories: names.iter().map(|n| (*n).to_owned()).collect(),
    }
}

/// All conditions of a log, a value a row of it.
pub(super) fn of(log: &Log, prediction: &Prediction) -> Vec<Covariate> {
    let samples = &log.samples;
    let (n, time) = (samples.len(), &samples.time);
    let start = time.first().copied().unwrap_or(0.0);
    let mut all = vec![number("time", "s", time.iter().map(|t| t - start).collect())];
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
        let name = joint_name(log, joint);
        let angle: Vec<f64> = match &prediction.motion {
            Some(motion) if motion.link.len() == n => {
                motion.link.iter().map(|q| q[joint]).collect()
            }
            _ => samples.encoder.iter().map(|q| q[joint]).collect(),
        };
        all.push(number(format!("{name} angle"), "rad", angle.clone()));
        if !still {
            let rate = slope(&angle);
            if rate.iter().any(|r| r.abs() > STILL) {
                all.push(category(
                    format!("direction of {name}'s motion"),
                    &DIRECTIONS,
                    tendency(&rate),
                ));
                all.push(number(format!("{name} acceleration"), "rad/s²", slope(&rate)));
                all.push(number(format!("{name} rate"), "rad/s", rate));
            }
        }
        if let Some(motion) = prediction.motion.as_ref().filter(|m| m.spring.len() == n) {
            let torque: Vec<f64> = motion.spring.iter().map(|t| t[joint]).collect();
            let sign = torque.iter().map(|t| if *t > 0.0 { 1.0 } else { 0.0 }).collect();
            all.push(category(format!("sign of {name}'s spring torque"), &SIGNS, sign));
            all.push(category(
                format!("tendency of {name}'s spring torque"),
                &TENDENCIES,
                tendency(&slope(&torque)),
            ));
            all.push(number(format!("{name} spring torque"), "N·m", torque));
        }
    }
    if let Some(payload) = &samples.payload {
        all.push(number("payload", "kg", payload.iter().map(|p| p.mass).collect()));
    }
    if let Some(force) = &samples.force {
        let load: Vec<f64> = force.iter().map(|f| f.norm()).collect();
        if still {
            all.push(category(
                "tendency of the load".to_owned(),
                &TENDENCIES,
                tendency(&slope(&load)),
            ));
        }
        all.push(number("load on the tool", "N", load));
    }
    if let Some(weld) = &log.weld {
        let seam = Seam::of(weld);
        let along: Vector3<f64> = seam.b_from_w.rotation.column(0).into();
        let on_path = |q: &trueweld_core::JointVector<f64>| {
            along.dot(&(log.robot.robot.forward_kinematics(q).position - seam.b_from_w.position))
        };
        all.push(number("path position", "m", samples.encoder.iter().map(on_path).collect()));
    }
    all
}

impl Covariate {
    /// The conditions of the rows of a table, from those of its logs; with the log itself where
    /// there are several.
    pub fn joined(table: &ResidualTable, of_logs: &[Vec<Self>]) -> Vec<Self> {
        let mut names: Vec<(&str, &Self)> = Vec::new();
        for span in &table.spans {
            let (log, _) = table.rows[span.start];
            for condition in &of_logs[log] {
                if !names.iter().any(|(name, _)| *name == condition.name) {
                    names.push((&condition.name, condition));
                }
            }
        }
        let value = |name: &str, (log, row): (usize, usize)| {
            of_logs[log].iter().find(|c| c.name == name).map_or(f64::NAN, |c| c.values[row])
        };
        let mut joined: Vec<Self> = names
            .iter()
            .map(|(name, like)| Self {
                name: (*name).to_owned(),
                unit: like.unit,
                values: table.rows.iter().map(|row| value(name, *row)).collect(),
                categories: like.categories.clone(),
            })
            .collect();
        if table.spans.len() > 1 {
            let mut which = vec![0.0; table.rows.len()];
            table.spans.iter().enumerate().for_each(|(k, span)| which[span.clone()].fill(k as f64));
            joined.push(Self {
                name: "log".to_owned(),
                unit: "",
                values: which,
                categories: table.logs.clone(),
            });
        }
        joined
    }

    /// The rows' bins; `None` where all rows are alike.
    pub fn bins(&self) -> Option<Bins> {
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
        let mut ends: Vec<f64> = (1..=BINS).map(|b| sorted[b * sorted.len() / BINS - 1]).collect();
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
