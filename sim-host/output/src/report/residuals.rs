//! Measured values beside what one model or two predict of them.

use crate::color::{self, Dash, REFERENCE, Rgb};
use crate::document::{Bar, Picture, Plot, PlotLine, Table, number, words};
use crate::text::finding::{category, variable};
use crate::text::{Scale, fixed};
use trueweld_estimate::residuals::compare::{LogComparison, Trace};
use trueweld_estimate::residuals::localize::{Finding, MapAxis, ResidualMap};
use trueweld_logs::median;

/// Columns drawn before and after.
pub(super) const BEFORE_AND_AFTER_COLUMNS: usize = 4;

/// Bars of scores begin here: their length is a logarithm.
const BAR_START_SCORE: f64 = 0.5;

/// Fall of a column's mean square, as a share, below which it is not drawn.
pub(super) const DRAWN_FALL_MIN: f64 = 0.05;

/// Measured values that span so many times the largest difference hide it: the difference is drawn
/// alone.
const HIDDEN: f64 = 50.0;

/// Beginning of the channels of which the difference is drawn alone: a way of metres says nothing,
/// and a rotation has no value of its own.
const POSES: &str = "tcp_";

/// A score's bar, logarithmic, with the noise floor marked.
pub(super) fn score_bar(score: f64, highest: f64) -> Bar {
    let share = |score: f64| {
        (score.max(BAR_START_SCORE) / BAR_START_SCORE).ln() / (highest / BAR_START_SCORE).ln()
    };
    let color = if score > 1.0 { color::run(0) } else { color::run(1) };
    Bar { share: share(score), mark: Some(share(1.0)), color }
}

/// The residual of a finding over two conditions: blue where it is negative, orange where it is
/// positive.
pub(super) fn map(map: &ResidualMap, finding: &Finding) -> Table {
    let name = |axis: &MapAxis| {
        Scale::large(axis.variable.unit()).named(&variable(axis.variable, &finding.joints))
    };
    let scale = Scale::small(map.series.0.unit());
    let most =
        map.mean.iter().flatten().filter(|v| v.is_finite()).fold(0.0, |m: f64, v| m.max(v.abs()));
    let cell = |value: &f64| match value.is_finite() {
        true => number(scale.number(*value)).shaded(shade(value / most)),
        false => number(""),
    };
    let rows = labels(&map.y, finding)
        .into_iter()
        .zip(&map.mean)
        .map(|(label, row)| std::iter::once(words(label)).chain(row.iter().map(cell)).collect());
    let above = vec![words(name(&map.y)), words(name(&map.x)).over(map.x.values.len())];
    let columns = labels(&map.x, finding).into_iter().map(number);
    let head = std::iter::once(words("")).chain(columns).collect();
    Table { head: vec![above, head], rows: rows.collect() }
}

/// The bins of an axis, by number or by category.
fn labels(axis: &MapAxis, finding: &Finding) -> Vec<String> {
    let scale = Scale::large(axis.variable.unit());
    let label = |(k, v): (usize, &f64)| match axis.categories.get(k) {
        Some(named) => category(*named, finding),
        None => scale.number(*v),
    };
    axis.values.iter().enumerate().map(label).collect()
}

/// The colour behind a value, from -1 to 1: pale enough for the number to be read.
fn shade(value: f64) -> Rgb {
    const COLORS: [Rgb; 2] = [[0, 114, 178], [213, 94, 0]];
    let full = COLORS[usize::from(value > 0.0)].map(f64::from);
    full.map(|full| (255.0 - 0.7 * value.abs() * (255.0 - full)) as u8)
}

/// One column of a log under one model or two.
pub(super) struct ColumnComparison<'a> {
    pub log: &'a str,
    /// What the title says of the scores.
    pub scores: String,
    /// Name, colour and values of each prediction.
    pub predictions: Vec<(&'static str, Rgb, &'a Trace)>,
}

/// The columns whose error over its noise falls most, at most `count`, and of one kind of log and
/// channel only the first.
pub(super) fn before_and_after<'a>(
    before: &'a [LogComparison],
    after: &'a [LogComparison],
    count: usize,
) -> Vec<Picture> {
    let mut all = Vec::new();
    for (log, other) in before.iter().zip(after) {
        for (trace, after) in log.traces.iter().zip(&other.traces) {
            all.push((log, trace, after, [mean_square(trace), mean_square(after)]));
        }
    }
    all.sort_by(|a, b| (b.3[0] - b.3[1]).total_cmp(&(a.3[0] - a.3[1])));
    let mut drawn: Vec<(&str, &str)> = Vec::new();
    let mut figures = Vec::new();
    for (log, before, after, square) in all {
        let of = (log.kind.name(), before.channel);
        let changed = square[0] - square[1] > DRAWN_FALL_MIN * square[0] || drawn.is_empty();
        if !changed || drawn.len() == count || drawn.contains(&of) {
            continue;
        }
        drawn.push(of);
        let [from, to] = square.map(|square| fixed(square.sqrt(), 1));
        let columns = ColumnComparison {
            log: &log.name,
            scores: format!("{from} → {to}"),
            predictions: vec![("before", color::run(0), before), ("after", color::run(1), after)],
        };
        figures.extend(columns.figures());
    }
    figures
}

impl ColumnComparison<'_> {
    /// True where a picture of the measured values would not show the difference.
    fn hides_difference(&self) -> bool {
        let trace = self.predictions[0].2;
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = trace.measured.iter().fold(ends, |[l, h], v| [l.min(*v), h.max(*v)]);
        let differences = self.predictions.iter().flat_map(|(.., trace)| {
            trace.measured.iter().zip(&trace.predicted).map(|(m, p)| (m - p).abs())
        });
        let largest = differences.fold(0.0, f64::max);
        trace.channel.starts_with(POSES) || high - low > HIDDEN * largest
    }

    /// Measured beside predicted, and their difference.
    pub(super) fn figures(&self) -> Vec<Picture> {
        let trace = self.predictions[0].2;
        let title =
            format!("{}: {}, {}; score {}", self.log, trace.channel, trace.label, self.scores);
        let wide = self.hides_difference();
        let plot = |scale: Scale, lines| Plot {
            wide,
            ..Plot::new("time, s", scale.named(&trace.label), lines)
        };
        let large = Scale::large(trace.unit);
        let predicted = self.predictions.iter().map(|(name, color, trace)| {
            line(name, *color, Dash::Dashed, trace, |k| trace.predicted[k] * large.factor)
        });
        let measured =
            line("measured", REFERENCE, Dash::Solid, trace, |k| trace.measured[k] * large.factor);
        let both = plot(large, std::iter::once(measured).chain(predicted).collect());
        let small = Scale::small(trace.unit);
        let differences = self.predictions.iter().map(|(name, color, trace)| {
            let difference = |k: usize| (trace.measured[k] - trace.predicted[k]) * small.factor;
            let (name, color) = match self.predictions.len() {
                1 => ("residual", color::run(0)),
                _ => (*name, *color),
            };
            line(name, color, Dash::Solid, trace, difference)
        });
        let noise = 2.0 * typical_noise(trace) * small.factor;
        let rest = Plot {
            band: Some([-noise, noise]),
            band_name: "twice the noise".into(),
            ..plot(small, differences.collect())
        };
        if wide {
            return vec![Picture::new(format!("{title}: measured less predicted"), rest)];
        }
        vec![Picture::new(title, both), Picture::new("Measured less predicted", rest)]
    }
}

fn line(name: &str, color: Rgb, dash: Dash, trace: &Trace, of: impl Fn(usize) -> f64) -> PlotLine {
    let points = (0..trace.time.len()).map(|k| (trace.time[k], of(k))).collect();
    PlotLine::new(name, color, points).dashed(dash)
}

fn mean_square(trace: &Trace) -> f64 {
    let residual = |k: usize| (trace.measured[k] - trace.predicted[k]) / trace.deviation[k];
    (0..trace.time.len()).map(|k| residual(k).powi(2)).sum::<f64>() / trace.time.len().max(1) as f64
}

/// Median of a trace's noise.
fn typical_noise(trace: &Trace) -> f64 {
    median(&mut trace.deviation.clone()).unwrap_or(0.0)
}
