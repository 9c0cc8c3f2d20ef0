//! The page of a comparison: score, every channel's, measured beside predicted, and what the
//! residual goes with.

use super::{figure, page};
use crate::color;
use crate::compared::{self, HEADINGS, cells, headline, setting};
use crate::plot::{Line, Marked, Plot, reference};
use crate::words::Scale;
use maud::{Markup, html};
use std::path::Path;
use trueweld_measure::residuals::compare::{Comparison, FLOOR, LogComparison, Trace};
use trueweld_measure::residuals::localize::{Finding, foremost};

/// Findings that are drawn.
const DRAWN: usize = 6;

/// Bars begin at this score: their length is its logarithm's.
const SHORTEST: f64 = 0.5;

/// The page of a model against measurements. `model`: where the model was read from.
pub fn compare_page(model: &Path, comparison: &Comparison) -> String {
    let told = foremost(&comparison.worst, DRAWN);
    let body = html! {
        h1 { (headline(comparison)) }
        p.setting { (setting(model, comparison)) }
        @if !told.is_empty() {
            ul { @for finding in told.iter().take(compared::TOLD) { li { (finding.sentence) } } }
        }
        (scores(comparison))
        @if !told.is_empty() {
            h2 { "What the difference goes with" }
            p.setting {
                "Measured less predicted, its mean (or its size) over the condition that it goes with most; bars are standard \
                 errors. p: how often chance does as much, with the same difference put under other conditions."
            }
            div.pairs { @for finding in &told { (finding_figure(finding)) } }
        }
        h2 { "Measured and predicted" }
        p.setting { "Of every log the column that is worst, over the time from its start." }
        @for log in &comparison.logs { (log_figures(log)) }
        @for notice in &comparison.notices { p.setting { "Note: " (notice) "." } }
    };
    page("Compare", &body)
}

/// Every channel of every log with its figures and a bar.
fn scores(comparison: &Comparison) -> Markup {
    let highest =
        comparison.logs.iter().flat_map(|log| &log.channels).map(|c| c.score).fold(2.0, f64::max);
    let percent =
        |score: f64| 100.0 * (score.max(SHORTEST) / SHORTEST).ln() / (highest / SHORTEST).ln();
    html! {
        table {
            thead { tr { @for heading in HEADINGS { th { (heading) } } th.bars { "logarithmic; the line: noise floor, 1.0" } } }
            tbody {
                @for log in &comparison.logs {
                    tr.log {
                        th scope="row" { (log.name) ", " (log.kind) }
                        td {} td {} td {}
                        td.bad[log.score > FLOOR] { (format!("{:.2}", log.score)) }
                        td {}
                    }
                    @for channel in &log.channels {
                        tr {
                            th.channel scope="row" { (channel.name) }
                            @for cell in cells(channel) { td { (cell) } }
                            td.bars {
                                div.floor style={ "left:" (format!("{:.1}%", percent(1.0))) } {}
                                div.bar.above[channel.score > FLOOR] style={ "width:" (format!("{:.1}%", percent(channel.score))) } {}
                            }
                        }
                    }
                }
            }
        }
    }
}

/// A finding's sentence and curve.
fn finding_figure(finding: &Finding) -> Markup {
    let curve = &finding.curve;
    let Scale { factor: x_factor, unit: x_unit } = Scale::large(curve.x_unit);
    let Scale { factor: y_factor, unit: y_unit } = Scale::small(curve.y_unit);
    let name = |name: &str, unit: &str| {
        if unit.is_empty() { name.to_owned() } else { format!("{name}, {unit}") }
    };
    let mark = |(k, p): (usize, &trueweld_measure::residuals::localize::CurvePoint)| Marked {
        x: if curve.categories.is_empty() { p.x * x_factor } else { k as f64 },
        y: p.y * y_factor,
        error: p.error * y_factor,
    };
    let marked: Vec<Marked> = curve.points.iter().enumerate().map(mark).collect();
    let joined = if curve.categories.is_empty() {
        let points = marked.iter().map(|m| (m.x, m.y)).collect();
        vec![Line { name: String::new(), color: color::run(0), dashed: false, points }]
    } else {
        Vec::new()
    };
    let plot = Plot {
        x_label: name(&curve.x_name, x_unit),
        y_label: y_unit.to_owned(),
        lines: joined,
        marked,
        categories: curve.categories.clone(),
        ..Plot::default()
    };
    html! {
        div.finding {
            p { (finding.sentence) }
            figure {
                figcaption { b { (finding.channel) ": " (curve.y_name) } }
                (maud::PreEscaped(plot.svg()))
            }
        }
    }
}

/// The worst column of a log: measured over predicted, and their difference.
fn log_figures(log: &LogComparison) -> Markup {
    let mut columns: Vec<_> = log.channels.iter().flat_map(|channel| &channel.columns).collect();
    columns.sort_by(|a, b| b.score.total_cmp(&a.score));
    let trace_of =
        |name: &str| log.traces.iter().find(|t| format!("{}[{}]", t.channel, t.column) == name);
    let Some((column, trace)) = columns.iter().find_map(|c| trace_of(&c.name).map(|t| (c, t)))
    else {
        return html! {};
    };
    let title =
        format!("{}: {}, {}, score {:.1}", log.name, trace.channel, trace.label, column.score);
    let over_time =
        |of: &dyn Fn(usize) -> f64| (0..trace.time.len()).map(|k| (trace.time[k], of(k))).collect();
    let line = |name: &str, run: usize, points: Vec<(f64, f64)>| Line {
        name: name.to_owned(),
        color: color::run(run),
        dashed: false,
        points,
    };
    let plot = |y_label: String, lines: Vec<Line>| Plot {
        x_label: "time, s".to_owned(),
        y_label,
        lines,
        ..Plot::default()
    };
    let Scale { factor, unit } = Scale::large(trace.unit);
    let measured = line("measured", 1, over_time(&|k| trace.measured[k] * factor));
    let predicted = reference("predicted", over_time(&|k| trace.predicted[k] * factor));
    let both = plot(format!("{}, {unit}", trace.label), vec![measured, predicted]);
    let Scale { factor, unit } = Scale::small(trace.unit);
    let difference = line("", 0, over_time(&|k| (trace.measured[k] - trace.predicted[k]) * factor));
    let noise = 2.0 * typical_noise(trace) * factor;
    let rest = Plot {
        band: Some([-noise, noise]),
        band_name: "twice the noise",
        wide: trace.channel == "tcp_rotation",
        ..plot(format!("{}, {unit}", trace.label), vec![difference])
    };
    html! {
        // A rotation has no measured value of its own to draw: its difference is all there is.
        @if trace.channel == "tcp_rotation" {
            (figure(&format!("{title}: measured less predicted"), &rest))
        } @else {
            div.pairs { (figure(&title, &both)) (figure("Measured less predicted", &rest)) }
        }
    }
}

/// Median of a trace's noise.
pub(super) fn typical_noise(trace: &Trace) -> f64 {
    let mut sorted = trace.deviation.clone();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::tests::assert_self_contained;
    use crate::sample;

    #[test]
    fn the_page_says_the_result_and_draws_where_it_fails() {
        let page = compare_page(Path::new("model.toml"), &sample::comparison());
        assert_self_contained(&page);
        assert!(page.contains("<h1>Score 2.72: the model is off by more than the noise"));
        assert!(page.contains("62 % of the squared residual goes with"));
        // The finding's curve; measured over predicted, and their difference.
        assert_eq!(page.matches("<svg").count(), 3);
        assert_eq!(page.matches("class=\"bar above\"").count(), 1);
    }

    #[test]
    fn a_model_at_the_noise_floor_is_said_to_be() {
        let mut comparison = sample::comparison();
        comparison.score = 0.99;
        comparison.logs[0].score = 0.99;
        comparison.logs[0].channels[0].score = 0.99;
        comparison.worst.clear();
        let page = compare_page(Path::new("model.toml"), &comparison);
        assert!(page.contains("is as good as these measurements can tell"));
        assert!(!page.contains("What the difference goes with"));
    }
}
