//! What is said of a log although nothing is wrong with it.

use super::{Scale, counted, digits, listed};
use std::fmt::Display;
use trueweld_logs::log::{FoundFactor, LogNotice};

/// A file of a hundred columns need not be listed.
const LISTED_COLUMNS_MAX: usize = 12;

/// A notice in a sentence without its full stop.
pub fn notice(notice: &LogNotice) -> String {
    match notice {
        LogNotice::UnknownColumns(headers) => {
            let shown =
                named(headers.iter().take(LISTED_COLUMNS_MAX).map(|name| name.escape_debug()));
            let more = headers.len().saturating_sub(LISTED_COLUMNS_MAX);
            let more = if more > 0 { format!(" and {more} more") } else { String::new() };
            format!("columns that are not known, left out: {shown}{more}")
        }
        LogNotice::StaticLoadColumns { columns, kind } => format!(
            "columns of static-load logs only, left out of this {kind} log: {}",
            named(columns)
        ),
        LogNotice::EmptyColumns(columns) => {
            format!("columns without any value, read as absent: {}", named(columns))
        }
        LogNotice::ForceInPart(columns) => format!(
            "of the weld's force {} alone was measured, and is compared; the tool's pose is not, since the \
             whole force bends the arm",
            named(columns)
        ),
        LogNotice::ClockFitted { clock, offset, drift, left } => {
            let strange = left.map(|left| {
                format!(
                    "; {:.0} mm are left between what both saw: was it the same motion?",
                    1e3 * left
                )
            });
            format!(
                "clock `{clock}`: offset_s = {offset:.6}, drift = {drift:.2e}, fitted to the motion \
                 that both saw{}",
                strange.unwrap_or_default()
            )
        }
        LogNotice::ReflectorsPlaced(places) => {
            let places = places
                .iter()
                .map(|(n, p)| format!("reflector{n}_m = [{:.5}, {:.5}, {:.5}]", p.x, p.y, p.z));
            format!(
                "reflectors are placed in the tool frame as the encoders' motion tells: {}",
                places.collect::<Vec<_>>().join(", ")
            )
        }
        LogNotice::Held { columns, every } => format!(
            "{} hold each reading for {every:.1} rows: what repeats it is not compared",
            named(columns)
        ),
        LogNotice::FactorsFound(found) => {
            let one = |f: &FoundFactor| {
                let interval = f.interval.map(|half| format!(" ± {}", digits(half, 2)));
                format!(
                    "{}{} N·m per {} of `{}`",
                    digits(f.factor, 4),
                    interval.unwrap_or_default(),
                    f.unit,
                    f.column
                )
            };
            let by = match found.iter().any(|factor| factor.interval.is_some()) {
                true => "by what the model's masses and friction need",
                false => "as the model's `torque-constant` has it",
            };
            let found: Vec<String> = found.iter().map(one).collect();
            format!("factors that no file states, {by}: {}", listed(&found, "and"))
        }
        LogNotice::FactorUnknown { column, unit } => format!(
            "`{column}` is in {unit} without a factor, and does not follow the model's torque: left \
             out; state its factor, or move this joint more"
        ),
        LogNotice::FactorOfAnotherUnit { column, unit, other } => format!(
            "`{column}` is in {unit} without a factor, and in {other} in another log, whose factor a \
             model holds: left out; state its factor"
        ),
        LogNotice::Thinned { rows, from, to } => format!(
            "{rows} rows every {:.3} ms are thinned to one every {:.3} ms: nothing faster is \
             compared, and what the instruments' noise loses by it is counted",
            1e3 * from,
            1e3 * to
        ),
        LogNotice::Resampled(period) => format!(
            "the times of the rows are uneven: what was measured is brought to even ones, every \
             {:.3} ms",
            1e3 * period
        ),
        LogNotice::RowsLeftOut(rows) => {
            format!("{rows} rows without a value of every encoder are left out")
        }
        LogNotice::RowsRepeated(rows) => format!(
            "{} with the time and the values of the row before: left out",
            counted(*rows, "row")
        ),
        LogNotice::RowsSwapped(rows) => format!(
            "{} earlier than the row before, as of packets that overtook each other: put in order of time",
            counted(*rows, "row")
        ),
        LogNotice::Bursts { rows } => format!(
            "the rows came in bursts of {rows}: they are spread evenly, the last of a burst at its stamp"
        ),
        LogNotice::Sentinel { column, value, rows } => format!(
            "`{column}` is {value} in {}, which stands for no value: read as missing",
            counted(*rows, "row")
        ),
        LogNotice::RowsInterpolated(rows) => {
            format!("{rows} rows without encoders are interpolated")
        }
        LogNotice::Cut { column, gaps, pieces } => {
            let between = if gaps.is_empty() {
                "at its ends".to_owned()
            } else {
                format!("between {}", spans(gaps))
            };
            let cut = match pieces {
                0 | 1 => "is left out".to_owned(),
                n => format!("cuts the log into {n} pieces"),
            };
            format!("a stretch without {} {between} {cut}", column.unwrap_or("encoders"))
        }
        LogNotice::Dropout { columns, stretches } => format!(
            "no value of {} from {}: nothing that needs one is compared there",
            named(columns),
            spans(stretches)
        ),
        LogNotice::Folded { order, frequency, period } => format!(
            "forces are not compared: in rows {:.0} ms apart the spindle's order {order} looks like a \
             force of {frequency:.2} Hz",
            1e3 * period
        ),
        LogNotice::LeftOut { log, what } => {
            format!("the log `{log}` beside it has nothing to compare and is left out: {what}")
        }
        LogNotice::Clipped { column, limit, unit, rows } => format!(
            "`{column}` reads exactly {} in {}, the end of its instrument's range: nothing \
             that needs it is compared there",
            exactly(Scale::small(unit), *limit),
            counted(*rows, "row")
        ),
        LogNotice::Outliers { columns, rows, largest, unit, left_out } => {
            let then = if *left_out {
                "not compared"
            } else {
                "too many to leave out; is the instrument in order?"
            };
            format!(
                "outliers of {}, off their neighbours by up to {}, in {}: {then}",
                named(columns),
                Scale::small(unit).quantity(*largest),
                counted(*rows, "row")
            )
        }
        LogNotice::OutlyingLoads { channel, rows, largest } => {
            let entry = channel.entry();
            let rows: Vec<String> = rows.iter().map(usize::to_string).collect();
            format!(
                "{} of {} {} is off what the other loads say, by up to {}: not compared; check the load and its \
                 readings there",
                entry.name,
                if rows.len() == 1 { "row" } else { "rows" },
                listed(&rows, "and"),
                Scale::small(entry.unit).quantity(*largest)
            )
        }
    }
}

/// A limit as the instrument gives it, without what a conversion of units rounds.
fn exactly(scale: Scale, limit: f64) -> String {
    scale.with_unit(format!("{}", (limit * scale.factor * 1e6).round() / 1e6))
}

/// Stretches of time.
fn spans(stretches: &[[f64; 2]]) -> String {
    let stretches = stretches.iter().map(|[from, to]| format!("{from:.3} s to {to:.3} s"));
    stretches.collect::<Vec<_>>().join(", ")
}

fn named<T: Display>(columns: impl IntoIterator<Item = T>) -> String {
    let names: Vec<String> = columns.into_iter().map(|name| format!("`{name}`")).collect();
    names.join(", ")
}

#[cfg(test)]
mod tests {
    use super::notice;
    use trueweld_logs::channel::LogChannel;
    use trueweld_logs::log::{FoundFactor, LogKind, LogNotice};

    #[test]
    fn every_notice_is_one_clause() {
        let gaps = vec![[0.196, 0.36]];
        let all = [
            LogNotice::UnknownColumns((0..14).map(|k| format!("c{k}\u{1b}")).collect()),
            LogNotice::StaticLoadColumns { columns: vec!["cx_m"], kind: LogKind::Weld },
            LogNotice::EmptyColumns(vec!["tm5_nm", "tm6_nm"]),
            LogNotice::ForceInPart(vec!["fz_n"]),
            LogNotice::ClockFitted {
                clock: "tracker".to_owned(),
                offset: 1.25,
                drift: 2e-6,
                left: Some(0.04),
            },
            LogNotice::ReflectorsPlaced(vec![(2, [0.1, -0.2, 0.05].into())]),
            LogNotice::Held { columns: vec!["px_m", "py_m"], every: 2.5 },
            LogNotice::FactorsFound(vec![FoundFactor {
                column: "tm1_nm",
                unit: "A",
                factor: 14.87,
                interval: Some(0.31),
            }]),
            LogNotice::FactorUnknown { column: "tm6_nm", unit: "A" },
            LogNotice::FactorOfAnotherUnit { column: "tm6_nm", unit: "%", other: "A" },
            LogNotice::Thinned { rows: 2_000_000, from: 1e-3, to: 4e-3 },
            LogNotice::RowsLeftOut(3),
            LogNotice::RowsRepeated(1),
            LogNotice::RowsSwapped(2),
            LogNotice::Bursts { rows: 4 },
            LogNotice::Sentinel { column: "tm2_nm", value: -9999.0, rows: 3 },
            LogNotice::RowsInterpolated(4),
            LogNotice::Cut { column: None, gaps, pieces: 2 },
            LogNotice::Cut { column: Some("qe1_rad"), gaps: Vec::new(), pieces: 1 },
            LogNotice::Resampled(8e-3),
            LogNotice::Dropout { columns: vec!["tm2_nm"], stretches: vec![[2.668, 5.332]] },
            LogNotice::Clipped { column: "fz_n", limit: -17500.0, unit: "N", rows: 1052 },
            LogNotice::Outliers {
                columns: vec!["px_m", "py_m"],
                rows: 1,
                largest: 0.00503,
                unit: "m",
                left_out: true,
            },
            LogNotice::Outliers {
                columns: vec!["fx_n"],
                rows: 40,
                largest: 612.0,
                unit: "N",
                left_out: false,
            },
            LogNotice::OutlyingLoads {
                channel: LogChannel::Position,
                rows: vec![7, 41],
                largest: 0.0436,
            },
            LogNotice::Folded { order: 1.0, frequency: 0.41, period: 0.096 },
            LogNotice::LeftOut { log: "weld, 4 of 7".to_owned(), what: "it is too short" },
        ];
        let lines: Vec<String> = all.iter().map(notice).collect();
        insta::assert_snapshot!(lines.join("\n"));
    }
}
