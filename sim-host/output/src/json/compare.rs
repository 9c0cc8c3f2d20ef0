//! A model against measurements.

use super::log_fault::FileMistake;
use super::register::RegisteredTracker;
use super::{finite, result};
use crate::text::compare::notice;
use crate::text::finding::{category, sentence, series, variable, x_name, y_name};
use crate::{CompareReport, text};
use trueweld_estimate::residuals::compare::{ChannelComparison, LogComparison};
use trueweld_estimate::residuals::localize::{
    ConditionBin, Finding, MapAxis, ResidualMap, Statistic, foremost,
};
use trueweld_plant::provenance::Provenance;

result! {
    /// A model against measurements.
    #[derive(Default)]
    CompareResult of (report: &CompareReport<'_>) with {
        let comparison = report.comparison;
    } {
        /// What the result is of.
        provenance: Provenance = report.provenance.clone(),
        /// Mistakes in the files; where there are any, nothing else was looked for.
        #[serde(default)]
        mistakes: Vec<FileMistake> = Vec::new(),
        /// The model file.
        model: String = report.model.display().to_string(),
        /// √mean((residual/noise)²) over all samples; 1 is the noise floor.
        score: Option<f64> = finite(comparison.score),
        /// Number of compared samples.
        samples: usize = comparison.samples,
        /// Every log.
        logs: Vec<ComparedLog> = comparison.logs.iter().map(ComparedLog::of).collect(),
        /// What the residuals follow, worst first.
        worst: Vec<ResidualFinding> = comparison.worst.iter().map(ResidualFinding::of).collect(),
        /// What a reader should know although nothing is wrong.
        notices: Vec<String> = comparison.notices.iter().map(notice).collect(),
        /// Trackers that stood elsewhere, and were registered first.
        #[serde(default)]
        registered: Vec<RegisteredTracker> = RegisteredTracker::all(&comparison.notices),
    }
}

result! {
    /// A model against one log.
    ComparedLog of (log: &LogComparison) {
        /// The log's folder.
        path: String = log.path.display().to_string(),
        /// Its name.
        name: String = log.name.clone(),
        /// Kind of the log.
        kind: &'static str = log.kind.name(),
        /// As the whole's.
        score: Option<f64> = finite(log.score),
        /// Number of compared samples.
        samples: usize = log.samples,
        /// Every channel that is compared.
        channels: Vec<ComparedChannel> = log.channels.iter().map(ComparedChannel::of).collect(),
    }
}

result! {
    /// A model against one channel of a log, or one column of it; figures in `unit`.
    ComparedChannel of (channel: &ChannelComparison) {
        /// Name of the channel; of a column, with its number from 0.
        name: String = channel.name.clone(),
        /// Unit of the figures.
        unit: &'static str = channel.unit,
        /// Root mean square of measured less predicted.
        rmse: Option<f64> = finite(channel.rmse),
        /// Largest magnitude of measured less predicted.
        max: Option<f64> = finite(channel.max),
        /// Root mean square of what the noise leaves in the difference.
        noise: Option<f64> = finite(channel.noise),
        /// Root mean square of what predictions may be off by; 0 where they are to be as exact as the
        /// noise.
        #[serde(default)]
        accuracy: f64 = channel.accuracy,
        /// Whether the logs state the noise: `stated` or `estimated`.
        noise_is: &'static str = if channel.stated { "stated" } else { "estimated" },
        /// As the whole's.
        score: Option<f64> = finite(channel.score),
        /// Number of compared samples.
        samples: usize = channel.samples,
        /// What people call a column.
        #[serde(default, skip_serializing_if = "String::is_empty")]
        label: String = channel.label.clone(),
        /// The columns.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        columns: Vec<ComparedChannel> = channel.columns.iter().map(Self::of).collect(),
    }
}

result! {
    /// A condition that the residual of one channel follows.
    ResidualFinding of (finding: &Finding) {
        /// Kind of the logs.
        kind: &'static str = finding.kind.name(),
        /// The channel.
        channel: &'static str = finding.channel,
        /// Names of the logs.
        logs: Vec<String> = finding.logs.clone(),
        /// Score of this channel in these logs.
        score: Option<f64> = finite(finding.score),
        /// The condition.
        variable: String = variable(finding.variable, &finding.joints),
        /// Its unit; empty for categories.
        unit: &'static str = finding.variable.unit(),
        /// Where it shows most: range of the condition, or the category's number twice.
        low: Option<f64> = finite(finding.low),
        /// See `low`.
        high: Option<f64> = finite(finding.high),
        /// Name of the category where it shows most.
        category: Option<String> = finding.category.map(|c| category(c, finding)),
        /// Whether the `mean` or the `size` of the residual follows the condition.
        how: &'static str = match finding.how {
            Statistic::Mean => "mean",
            Statistic::Size => "size",
        },
        /// Share of the squared residual that follows it.
        share: Option<f64> = finite(finding.share),
        /// Share that chance gives.
        share_by_chance: Option<f64> = finite(finding.by_chance),
        /// How often chance does as much.
        p: Option<f64> = finite(finding.p),
        /// Share of the squared residual where it shows most.
        share_there: Option<f64> = finite(finding.share_there),
        /// Share of the samples where it shows most.
        samples_there: Option<f64> = finite(finding.samples_there),
        /// Conditions that it follows nearly as much.
        similar: Vec<String> =
            finding.similar.iter().map(|v| variable(*v, &finding.joints)).collect(),
        /// The same in words.
        sentence: String = sentence(finding),
        /// The residual over the condition.
        curve: ResidualCurve = ResidualCurve::of(finding),
        /// Two conditions that it follows together, where one does not do.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        map: Option<ResidualMapData> =
            finding.map.as_ref().map(|map| ResidualMapData::of(map, finding)),
    }
}

result! {
    /// A mean residual over two conditions.
    ResidualMapData of (map: &ResidualMap, finding: &Finding) with {
        let (quantity, column) = map.series;
    } {
        x: ResidualMapAxis = ResidualMapAxis::of(&map.x, finding),
        y: ResidualMapAxis = ResidualMapAxis::of(&map.y, finding),
        /// The column.
        series: String = series(quantity, column, &finding.joints),
        unit: &'static str = quantity.unit(),
        /// By y, then by x; null where there are too few rows.
        mean: Vec<Vec<Option<f64>>> =
            map.mean.iter().map(|row| row.iter().map(|v| finite(*v)).collect()).collect(),
        /// Share of the squared residual that follows both.
        share: Option<f64> = finite(map.share),
        /// Share that chance gives.
        share_by_chance: Option<f64> = finite(map.by_chance),
        /// How often chance does as much.
        p: Option<f64> = finite(map.p),
    }
}

result! {
    /// The bins of one condition.
    ResidualMapAxis of (axis: &MapAxis, finding: &Finding) {
        name: String = variable(axis.variable, &finding.joints),
        unit: &'static str = axis.variable.unit(),
        /// Names of the categories; empty where the condition is a number.
        categories: Vec<String> = axis.categories.iter().map(|c| category(*c, finding)).collect(),
        /// Mean of the condition in each bin.
        values: Vec<Option<f64>> = axis.values.iter().map(|v| finite(*v)).collect(),
    }
}

result! {
    /// A residual over a condition.
    ResidualCurve of (finding: &Finding) with {
        let curve = &finding.curve;
        let column =
            |of: fn(&ConditionBin) -> f64| curve.points.iter().map(|p| finite(of(p))).collect();
    } {
        x_name: String = x_name(finding),
        x_unit: &'static str = finding.variable.unit(),
        /// Names of the categories; empty where the condition is a number.
        categories: Vec<String> = curve.categories.iter().map(|c| category(*c, finding)).collect(),
        y_name: String = y_name(finding),
        y_unit: &'static str = curve.y_unit,
        x: Vec<Option<f64>> = column(|p| p.x),
        y: Vec<Option<f64>> = column(|p| p.y),
        /// Standard errors of `y`.
        error: Vec<Option<f64>> = column(|p| p.error),
    }
}

impl ResidualFinding {
    /// What is left, the foremost of it.
    pub(super) fn remaining(unexplained: &[Finding]) -> Vec<Self> {
        let all = foremost(unexplained, text::diagnose::REMAINS);
        all.into_iter().map(Self::of).collect()
    }
}
