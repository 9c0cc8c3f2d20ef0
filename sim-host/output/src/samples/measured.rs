//! Samples of logs beside what models predict of them, long: a row for every value.

use super::{Samples, Values};
use trueweld_measure::residuals::compare::{LogComparison, Trace};

/// Columns of words, and of numbers in the unit of the row.
const WORDS: [&str; 7] = ["model", "role", "log", "kind", "channel", "column", "unit"];
const NUMBERS: [&str; 5] = ["time_s", "measured", "predicted", "residual", "noise"];

/// Logs under models: the model's name, the part that the logs had, and the logs.
pub(crate) fn of_logs<'a>(groups: Vec<([&'static str; 2], &'a [LogComparison])>) -> Samples<'a> {
    let traces = groups.into_iter().flat_map(|(group, logs)| {
        let of_log = move |log: &'a LogComparison| {
            log.traces.iter().chain(&log.lines).map(move |t| (group, log, t))
        };
        logs.iter().flat_map(of_log)
    });
    let block = |([model, role], log, trace): ([&'static str; 2], &'a LogComparison, &'a Trace)| {
        let kind = log.kind.name();
        let words =
            [model, role, log.name.as_str(), kind, trace.channel, trace.label.as_str(), trace.unit];
        let words = words.map(Values::Word);
        let residual = trace.measured.iter().zip(&trace.predicted).map(|(m, p)| m - p).collect();
        let numbers = [
            Values::Borrowed(&trace.time),
            Values::Borrowed(&trace.measured),
            Values::Borrowed(&trace.predicted),
            Values::Numbers(residual),
            Values::Borrowed(&trace.deviation),
        ];
        words.into_iter().chain(numbers).collect()
    };
    Samples::new(WORDS, NUMBERS, traces.map(block))
}
