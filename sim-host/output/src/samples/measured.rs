//! Samples of logs beside what models predict of them, long: a row for every value.

use super::{BlockTable, ColumnValues, SampleBlock};
use trueweld_estimate::residuals::compare::{LogComparison, Trace};

/// Columns of words, and of numbers in the unit of the row.
const WORD_COLUMNS: [&str; 7] = ["model", "role", "log", "kind", "channel", "column", "unit"];
const NUMBER_COLUMNS: [&str; 5] = ["time_s", "measured", "predicted", "residual", "noise"];

/// Logs under models: the model's name, the part that the logs had, and the logs.
pub(crate) fn of_logs<'a>(groups: Vec<([&'static str; 2], &'a [LogComparison])>) -> BlockTable<'a> {
    let traces = groups.into_iter().flat_map(|(group, logs)| {
        let of_log = move |log: &'a LogComparison| {
            log.traces.iter().chain(&log.lines).map(move |t| (group, log, t))
        };
        logs.iter().flat_map(of_log)
    });
    BlockTable::new(
        WORD_COLUMNS,
        NUMBER_COLUMNS,
        traces.map(|(group, log, trace)| block(group, log, trace)),
    )
}

fn block<'a>(
    [model, role]: [&'static str; 2],
    log: &'a LogComparison,
    trace: &'a Trace,
) -> SampleBlock<'a> {
    let kind = log.kind.name();
    let words =
        [model, role, log.name.as_str(), kind, trace.channel, trace.label.as_str(), trace.unit];
    let words = words.map(ColumnValues::Word);
    let residual = trace.measured.iter().zip(&trace.predicted).map(|(m, p)| m - p).collect();
    let numbers = [
        ColumnValues::Borrowed(&trace.time),
        ColumnValues::Borrowed(&trace.measured),
        ColumnValues::Borrowed(&trace.predicted),
        ColumnValues::Numbers(residual),
        ColumnValues::Borrowed(&trace.deviation),
    ];
    words.into_iter().chain(numbers).collect()
}
