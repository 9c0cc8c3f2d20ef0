//! Gaps in a log: in what drives the model short ones are filled, and long ones cut it into pieces; in
//! what is compared long ones are told.

use super::columns::{LogHeader, shown_name};
use super::notice::LogNotice;
use super::samples::ColumnBuffer;
use crate::channel::LogChannel;
use crate::dropout::dropouts;
use crate::kind::LogKind;
use std::ops::Range;

/// Most missing rows in a row that are interpolated: beyond, the log is cut.
const FILLED_ROWS_MAX: usize = 5;

/// Most gaps of one kind that a notice lists.
const LISTED_GAPS_MAX: usize = 6;

/// A step of rows that are brought to a grid is a gap where it is so many periods of the grid.
pub(super) const GAP_PERIODS: f64 = 10.0;

/// Fills short gaps of what drives the model, and says which rows make up the pieces between the
/// long ones.
pub(super) fn pieces(
    columns: &mut ColumnBuffer,
    kind: LogKind,
    period: f64,
    header: &LogHeader,
    notices: &mut Vec<LogNotice>,
) -> Vec<Range<usize>> {
    let encoder = LogChannel::Encoder.columns();
    let whole = |columns: &ColumnBuffer, k: usize| {
        encoder.clone().all(|c| columns.values[c].as_ref().is_some_and(|v| v[k].is_finite()))
    };
    if kind == LogKind::StaticLoad {
        let kept: Vec<usize> = (0..columns.time.len()).filter(|k| whole(columns, *k)).collect();
        let left = columns.time.len() - kept.len();
        if left > 0 {
            notices.push(LogNotice::RowsLeftOut(left));
            keep(columns, &kept);
        }
        return std::iter::once(0..columns.time.len()).collect();
    }
    insert_lost_rows(columns, period);
    let n = columns.time.len();
    let there: Vec<bool> = (0..n).map(|k| whole(columns, k)).collect();
    let step = |k: usize| columns.time[k + 1] - columns.time[k];
    let torn = |k: usize| step(k) > 1.5 * period;
    let mut pieces = Vec::new();
    let (mut start, mut filled, mut k) = (None::<usize>, 0, 0);
    let mut runs: Vec<Range<usize>> = Vec::new();
    while k < n {
        if there[k] {
            start.get_or_insert(k);
            k += 1;
        } else {
            let end = (k..n).find(|j| there[*j]).unwrap_or(n);
            let short = end - k <= FILLED_ROWS_MAX && start.is_some() && end < n;
            if short {
                runs.push(k..end);
                filled += end - k;
            } else if let Some(start) = start.take() {
                pieces.push(start..k);
            }
            k = end;
        }
        if let (Some(begin), true) = (start, k < n && k > 0 && torn(k - 1)) {
            pieces.push(begin..k);
            start = None;
        }
    }
    pieces.extend(start.map(|start| start..n));
    for run in &runs {
        for column in encoder.clone() {
            if let Some(values) = &mut columns.values[column] {
                fill(&columns.time, values, run.clone());
            }
        }
    }
    let lost = n - pieces.iter().map(|piece| piece.len()).sum::<usize>();
    if filled > 0 {
        notices.push(LogNotice::RowsInterpolated(filled));
    }
    if pieces.len() > 1 || lost > 0 {
        let first = columns.time.first().copied().unwrap_or(0.0);
        let at = |k: usize| columns.time[k.min(n - 1)] - first;
        let gaps =
            pieces.windows(2).take(LISTED_GAPS_MAX).map(|w| [at(w[0].end - 1), at(w[1].start)]);
        let encoder = encoder.start;
        notices.push(LogNotice::Cut {
            column: (!header.has(encoder)).then(|| shown_name(encoder)),
            gaps: gaps.collect(),
            pieces: pieces.len(),
        });
    }
    tell_dropouts(columns, &pieces, notices);
    pieces
}

/// Tells for how long instruments read nothing while the encoders were recorded.
fn tell_dropouts(columns: &ColumnBuffer, pieces: &[Range<usize>], notices: &mut Vec<LogNotice>) {
    let mut told: Vec<(Vec<Range<usize>>, Vec<&'static str>)> = Vec::new();
    let cut = |k: usize| !pieces.iter().any(|piece| piece.contains(&k));
    for column in LogChannel::LinkEncoder.columns().start..LogChannel::Spindle.columns().start {
        let Some(values) = &columns.values[column] else { continue };
        let read = |k: usize| values[k].is_finite() || cut(k);
        let stretches = dropouts((0..values.len()).map(read), FILLED_ROWS_MAX);
        match told.iter_mut().find(|(others, _)| *others == stretches) {
            _ if stretches.is_empty() => {}
            Some((_, names)) => names.push(shown_name(column)),
            None => told.push((stretches, vec![shown_name(column)])),
        }
    }
    let from_first = |k: usize| columns.time[k] - columns.time[0];
    for (stretches, names) in told {
        let stretches = stretches.iter().take(LISTED_GAPS_MAX);
        notices.push(LogNotice::Dropout {
            columns: names,
            stretches: stretches.map(|s| [from_first(s.start), from_first(s.end - 1)]).collect(),
        });
    }
}

/// Puts rows without values where single ones were lost.
fn insert_lost_rows(columns: &mut ColumnBuffer, period: f64) {
    let lost = |w: &[f64]| {
        let periods = ((w[1] - w[0]) / period).round();
        let few = periods >= 2.0 && periods <= (FILLED_ROWS_MAX + 1) as f64;
        if few { periods as usize - 1 } else { 0 }
    };
    if columns.time.windows(2).all(|w| lost(w) == 0) {
        return;
    }
    let old = std::mem::take(&mut columns.time);
    let mut from: Vec<Option<usize>> = Vec::with_capacity(old.len());
    for k in 0..old.len() {
        from.push(Some(k));
        columns.time.push(old[k]);
        if let Some(pair) = old.get(k..k + 2) {
            let rows = lost(pair);
            for j in 1..=rows {
                from.push(None);
                columns.time.push(pair[0] + (pair[1] - pair[0]) * j as f64 / (rows + 1) as f64);
            }
        }
    }
    for values in columns.values.iter_mut().flatten() {
        *values = from.iter().map(|row| row.map_or(f64::NAN, |k| values[k])).collect();
    }
}

fn keep(columns: &mut ColumnBuffer, rows: &[usize]) {
    columns.time = rows.iter().map(|k| columns.time[*k]).collect();
    for values in columns.values.iter_mut().flatten() {
        *values = rows.iter().map(|k| values[*k]).collect();
    }
}

/// Fills a run of missing values by the polynomial through two values on either side.
fn fill(time: &[f64], values: &mut [f64], run: Range<usize>) {
    let finite = |k: &usize| values[*k].is_finite();
    let mut around: Vec<usize> = (run.start.saturating_sub(2)..run.start).filter(finite).collect();
    around.extend((run.end..(run.end + 2).min(values.len())).filter(finite));
    if around.len() < 2 {
        return;
    }
    for k in run {
        if values[k].is_finite() {
            continue;
        }
        let weight = |i: &usize| {
            let others = around.iter().filter(|j| *j != i);
            others.map(|j| (time[k] - time[*j]) / (time[*i] - time[*j])).product::<f64>()
        };
        values[k] = around.iter().map(|i| weight(i) * values[*i]).sum();
    }
}
