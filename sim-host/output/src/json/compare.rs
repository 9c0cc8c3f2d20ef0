//! A model against measurements.

use super::finite;
use super::mistake::FileMistake;
use super::register::RegisteredTracker;
use crate::words::compare::notice;
use crate::words::finding::{category, sentence, series, variable, x_name, y_name};
use crate::{CompareReport, words};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_diagnose::Diagnosis;
use trueweld_estimate::residuals::compare::{ChannelComparison, LogComparison};
use trueweld_estimate::residuals::localize::{
    ConditionBin, Finding, MapAxis, ResidualMap, Statistic, foremost,
};
use trueweld_plant::provenance::Provenance;

/// A model against measurements.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "compare/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// Mistakes in the files; where there are any, nothing else was looked for.
    #[serde(default)]
    pub mistakes: Vec<FileMistake>,
    /// The model file.
    pub model: String,
    /// √mean((residual/noise)²) over all samples; 1 is the noise floor.
    pub score: Option<f64>,
    /// Number of compared samples.
    pub samples: usize,
    /// Every log.
    pub logs: Vec<ComparedLog>,
    /// What the residuals follow, worst first.
    pub worst: Vec<ResidualFinding>,
    /// What a reader should know although nothing is wrong.
    pub notices: Vec<String>,
    /// Trackers that stood elsewhere, and were registered first.
    #[serde(default)]
    pub registered: Vec<RegisteredTracker>,
}

/// A model against one log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedLog {
    /// The log's folder.
    pub path: String,
    /// Its name.
    pub name: String,
    /// Kind of the log.
    pub kind: String,
    /// As the whole's.
    pub score: Option<f64>,
    /// Number of compared samples.
    pub samples: usize,
    /// Every channel that is compared.
    pub channels: Vec<ComparedChannel>,
}

/// A model against one channel of a log, or one column of it; figures in `unit`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedChannel {
    /// Name of the channel; of a column, with its number from 0.
    pub name: String,
    /// Unit of the figures.
    pub unit: String,
    /// Root mean square of measured less predicted.
    pub rmse: Option<f64>,
    /// Largest magnitude of measured less predicted.
    pub max: Option<f64>,
    /// Root mean square of what the noise leaves in the difference.
    pub noise: Option<f64>,
    /// Whether the logs state the noise: `stated` or `estimated`.
    pub noise_is: String,
    /// As the whole's.
    pub score: Option<f64>,
    /// Number of compared samples.
    pub samples: usize,
    /// What people call a column.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub label: String,
    /// The columns.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<ComparedChannel>,
}

/// A condition that the residual of one channel follows.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ResidualFinding {
    /// Kind of the logs.
    pub kind: String,
    /// The channel.
    pub channel: String,
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Score of this channel in these logs.
    pub score: Option<f64>,
    /// The condition.
    pub variable: String,
    /// Its unit; empty for categories.
    pub unit: String,
    /// Where it shows most: range of the condition, or the category's number twice.
    pub low: Option<f64>,
    /// See `low`.
    pub high: Option<f64>,
    /// Name of the category where it shows most.
    pub category: Option<String>,
    /// Whether the `mean` or the `size` of the residual follows the condition.
    pub how: String,
    /// Share of the squared residual that follows it.
    pub share: Option<f64>,
    /// Share that chance gives.
    pub share_by_chance: Option<f64>,
    /// How often chance does as much.
    pub p: Option<f64>,
    /// Share of the squared residual where it shows most.
    pub share_there: Option<f64>,
    /// Share of the samples where it shows most.
    pub samples_there: Option<f64>,
    /// Conditions that it follows nearly as much.
    pub similar: Vec<String>,
    /// The same in words.
    pub sentence: String,
    /// The residual over the condition.
    pub curve: ResidualCurve,
    /// Two conditions that it follows together, where one does not do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub map: Option<ResidualMapData>,
}

/// A mean residual over two conditions.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ResidualMapData {
    pub x: ResidualMapAxis,
    pub y: ResidualMapAxis,
    /// The column.
    pub series: String,
    pub unit: String,
    /// By y, then by x; null where there are too few rows.
    pub mean: Vec<Vec<Option<f64>>>,
    /// Share of the squared residual that follows both.
    pub share: Option<f64>,
    /// Share that chance gives.
    pub share_by_chance: Option<f64>,
    /// How often chance does as much.
    pub p: Option<f64>,
}

/// The bins of one condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ResidualMapAxis {
    pub name: String,
    pub unit: String,
    /// Names of the categories; empty where the condition is a number.
    pub categories: Vec<String>,
    /// Mean of the condition in each bin.
    pub values: Vec<Option<f64>>,
}

/// A residual over a condition.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct ResidualCurve {
    pub x_name: String,
    pub x_unit: String,
    /// Names of the categories; empty where the condition is a number.
    pub categories: Vec<String>,
    pub y_name: String,
    pub y_unit: String,
    pub x: Vec<Option<f64>>,
    pub y: Vec<Option<f64>>,
    /// Standard errors of `y`.
    pub error: Vec<Option<f64>>,
}

impl CompareResult {
    pub(crate) fn of(report: &CompareReport<'_>) -> Self {
        let comparison = report.comparison;
        let log = |log: &LogComparison| ComparedLog {
            path: log.path.display().to_string(),
            name: log.name.clone(),
            kind: log.kind.name().to_owned(),
            score: finite(log.score),
            samples: log.samples,
            channels: log.channels.iter().map(ComparedChannel::of).collect(),
        };
        Self {
            schema: "compare/1".to_owned(),
            provenance: report.provenance.clone(),
            mistakes: Vec::new(),
            model: report.model.display().to_string(),
            score: finite(comparison.score),
            samples: comparison.samples,
            logs: comparison.logs.iter().map(log).collect(),
            worst: comparison.worst.iter().map(ResidualFinding::of).collect(),
            notices: comparison.notices.iter().map(notice).collect(),
            registered: RegisteredTracker::all(&comparison.notices),
        }
    }
}

impl ComparedChannel {
    fn of(channel: &ChannelComparison) -> Self {
        Self {
            name: channel.name.clone(),
            unit: channel.unit.to_owned(),
            rmse: finite(channel.rmse),
            max: finite(channel.max),
            noise: finite(channel.noise),
            noise_is: if channel.stated { "stated" } else { "estimated" }.to_owned(),
            score: finite(channel.score),
            samples: channel.samples,
            label: channel.label.clone(),
            columns: channel.columns.iter().map(Self::of).collect(),
        }
    }
}

impl ResidualFinding {
    pub(super) fn of(finding: &Finding) -> Self {
        let curve = &finding.curve;
        let column =
            |of: fn(&ConditionBin) -> f64| curve.points.iter().map(|p| finite(of(p))).collect();
        Self {
            kind: finding.kind.name().to_owned(),
            channel: finding.channel.to_owned(),
            logs: finding.logs.clone(),
            score: finite(finding.score),
            variable: variable(finding.variable, &finding.joints),
            unit: finding.variable.unit().to_owned(),
            low: finite(finding.low),
            high: finite(finding.high),
            category: finding.category.map(|c| category(c, finding)),
            how: match finding.how {
                Statistic::Mean => "mean",
                Statistic::Size => "size",
            }
            .to_owned(),
            share: finite(finding.share),
            share_by_chance: finite(finding.by_chance),
            p: finite(finding.p),
            share_there: finite(finding.share_there),
            samples_there: finite(finding.samples_there),
            similar: finding.similar.iter().map(|v| variable(*v, &finding.joints)).collect(),
            sentence: sentence(finding),
            curve: ResidualCurve {
                x_name: x_name(finding),
                x_unit: finding.variable.unit().to_owned(),
                categories: curve.categories.iter().map(|c| category(*c, finding)).collect(),
                y_name: y_name(finding),
                y_unit: curve.y_unit.to_owned(),
                x: column(|p| p.x),
                y: column(|p| p.y),
                error: column(|p| p.error),
            },
            map: finding.map.as_ref().map(|map| ResidualMapData::of(map, finding)),
        }
    }

    /// What is left, the foremost of it.
    pub(super) fn remaining(diagnosis: &Diagnosis) -> Vec<Self> {
        let all = foremost(&diagnosis.unexplained, words::diagnose::REMAINS);
        all.into_iter().map(Self::of).collect()
    }
}

impl ResidualMapData {
    fn of(map: &ResidualMap, finding: &Finding) -> Self {
        let axis = |axis: &MapAxis| ResidualMapAxis {
            name: variable(axis.variable, &finding.joints),
            unit: axis.variable.unit().to_owned(),
            categories: axis.categories.iter().map(|c| category(*c, finding)).collect(),
            values: axis.values.iter().map(|v| finite(*v)).collect(),
        };
        let (quantity, column) = map.series;
        Self {
            x: axis(&map.x),
            y: axis(&map.y),
            series: series(quantity, column, &finding.joints),
            unit: quantity.unit().to_owned(),
            mean: map.mean.iter().map(|r| r.iter().map(|v| finite(*v)).collect()).collect(),
            share: finite(map.share),
            share_by_chance: finite(map.by_chance),
            p: finite(map.p),
        }
    }
}
