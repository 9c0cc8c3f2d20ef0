//! Measured values beside what two models predict, before and after.

use super::compare::typical_noise;
use super::figure;
use crate::color;
use crate::plot::{Line, Plot};
use crate::words::Scale;
use maud::{Markup, html};
use trueweld_measure::residuals::compare::{LogComparison, Trace};

/// Fall of a column's mean square, as a share, below which it is not drawn.
const LEAST: f64 = 0.05;

/// One column of a log under both models.
struct Column<'a> {
    log: &'a str,
    kind: &'static str,
    before: &'a Trace,
    after: &'a Trace,
    /// Mean square of the residual over its noise, before and after.
    square: [f64; 2],
}

/// The columns whose error over its noise falls most, at most `count`, and of one kind of log and
/// channel only the first.
pub(super) fn before_and_after(
    before: &[LogComparison],
    after: &[LogComparison],
    count: usize,
) -> Markup {
    let mut columns: Vec<Column> = Vec::new();
    for (log, other) in before.iter().zip(after) {
        for (trace, after) in log.traces.iter().zip(&other.traces) {
            let square = [mean_square(trace), mean_square(after)];
            columns.push(Column {
                log: &log.name,
                kind: log.kind.name(),
                before: trace,
                after,
                square,
            });
        }
    }
    let fall = |c: &Column| c.square[0] - c.square[1];
    columns.sort_by(|a, b| fall(b).total_cmp(&fall(a)));
    let mut chosen: Vec<&Column> = Vec::new();
    for column in &columns {
        let same = |c: &&Column| (c.kind, c.before.channel) == (column.kind, column.before.channel);
        let changed = fall(column) > LEAST * column.square[0] || chosen.is_empty();
        if changed && chosen.len() < count && !chosen.iter().any(same) {
            chosen.push(column);
        }
    }
    html! { @for column in chosen { (figures(column)) } }
}

fn mean_square(trace: &Trace) -> f64 {
    let residual = |k: usize| (trace.measured[k] - trace.predicted[k]) / trace.deviation[k];
    (0..trace.time.len()).map(|k| residual(k).powi(2)).sum::<f64>() / trace.time.len().max(1) as f64
}

fn figures(column: &Column<'_>) -> Markup {
    let Column { before, after, .. } = *column;
    let [from, to] = column.square.map(f64::sqrt);
    let title =
        format!("{}: {}, {}; score {from:.1} → {to:.1}", column.log, before.channel, before.label);
    let line =
        |name: &str, run: usize, dashed: bool, trace: &Trace, of: &dyn Fn(usize) -> f64| Line {
            name: name.to_owned(),
            color: color::run(run),
            dashed,
            points: (0..trace.time.len()).map(|k| (trace.time[k], of(k))).collect(),
        };
    let plot = |unit: &str, lines| Plot {
        x_label: "time, s".to_owned(),
        y_label: format!("{}, {unit}", before.label),
        lines,
        ..Plot::default()
    };
    let Scale { factor, unit } = Scale::large(before.unit);
    let predictions = plot(
        unit,
        vec![
            Line {
                color: color::REFERENCE,
                ..line("measured", 0, false, before, &|k| before.measured[k] * factor)
            },
            line("predicted before", 0, true, before, &|k| before.predicted[k] * factor),
            line("predicted after", 1, true, after, &|k| after.predicted[k] * factor),
        ],
    );
    let Scale { factor, unit } = Scale::small(before.unit);
    let noise = 2.0 * typical_noise(before) * factor;
    let difference = |trace: &'_ Trace, k: usize| (trace.measured[k] - trace.predicted[k]) * factor;
    let rest = Plot {
        band: Some([-noise, noise]),
        band_name: "twice the noise",
        wide: before.channel == "tcp_rotation",
        ..plot(
            unit,
            vec![
                line("before", 0, false, before, &|k| difference(before, k)),
                line("after", 1, false, after, &|k| difference(after, k)),
            ],
        )
    };
    html! {
        // A rotation has no measured value of its own to draw: its difference is all there is.
        @if before.channel == "tcp_rotation" {
            (figure(&format!("{title}: measured less predicted"), &rest))
        } @else {
            div.pairs { (figure(&title, &predictions)) (figure("Measured less predicted", &rest)) }
        }
    }
}
