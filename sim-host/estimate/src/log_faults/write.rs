//! The lines of a `log.toml` that undo a mistake: what a column really holds, composed with what its
//! entry in `[columns]` says already.

use super::{ColumnChange, ColumnLines, Mistake, Remedy};
use trueweld_logs::log::units::{UNITS, Unit, unit_named};
use trueweld_logs::log::{ColumnMapping, Log, channel_named};
use trueweld_plant::input::unit_suffix;

/// The lines for every log that a mistake is in, the same ones once.
pub(super) fn lines(mistake: &Mistake, logs: &[Log]) -> Vec<ColumnLines> {
    let Remedy::Columns(changes) = &mistake.change else {
        return Vec::new();
    };
    let mut all: Vec<ColumnLines> = Vec::new();
    for log in logs.iter().filter(|log| mistake.logs.contains(&log.name)) {
        let entries = &log.origin.columns;
        let lines: Vec<ColumnMapping> = changes.iter().flat_map(|c| of_log(c, entries)).collect();
        let replace = lines.iter().any(|line| entries.iter().any(|e| e.header == line.header));
        match all.iter_mut().find(|other| other.lines == lines && other.replace == replace) {
            Some(same) => same.logs.push(log.name.clone()),
            None => all.push(ColumnLines { logs: vec![log.name.clone()], lines, replace }),
        }
    }
    all
}

/// One change in a log with these entries: a line for each that the column is read from, or one for
/// the column of a plain log.
fn of_log(change: &ColumnChange, entries: &[ColumnMapping]) -> Vec<ColumnMapping> {
    let Some(to) = channel_named(change.channel) else { return Vec::new() };
    let name = unit_suffix(change.column).map_or(change.column, |(name, _)| name);
    let mut lines: Vec<ColumnMapping> = Vec::new();
    for entry in entries {
        // A tracker's point is a position as well.
        let reflected = |axis: &str| {
            name == format!("p{axis}")
                && entry.channel().starts_with("reflector")
                && entry.channel().ends_with(&format!("_{axis}"))
        };
        if entry.channel() == name {
            lines.push(composed(change, entry, to));
        } else if ["x", "y", "z"].into_iter().any(reflected) {
            lines.push(composed(change, entry, entry.column));
        }
    }
    if name == "t" {
        // Of several files, the one with the encoders comes first.
        lines.truncate(1);
    }
    if lines.is_empty() {
        let held = ColumnMapping {
            header: change.column.to_owned(),
            column: to,
            unit: unit_named(change.unit).map_or("1", |unit| unit.name),
            factor: 1.0,
            open: false,
            offset: 0.0,
            plus: change.plus.into_iter().collect(),
        };
        lines.push(ColumnMapping {
            factor: rounded(change.factor),
            offset: rounded(change.offset),
            ..held
        });
    }
    lines
}

/// What was read is u (f n + o) + Σ k q of an entry's unit, factor, offset and what it adds; what it
/// should be is u' (f' (u (f n + o) + Σ k q) + o') + Σ k' q of the change's.
fn composed(change: &ColumnChange, entry: &ColumnMapping, column: usize) -> ColumnMapping {
    let size = |unit: Option<&Unit>| unit.map_or(1.0, |unit| unit.factor);
    let (own, new) = (unit_named(entry.unit), unit_named(change.unit));
    let scale = size(new) * change.factor * size(own);
    // A unit that says it all, else the entry's own with a factor.
    let whole = |unit: &&Unit| (scale * entry.factor / unit.factor - 1.0).abs() < 1e-9;
    let dimension = own.and_then(|unit| unit.dimension);
    let alike = UNITS.iter().filter(|u| dimension.is_some() && u.dimension == dimension);
    let unit = own.into_iter().chain(new).chain(alike).find(whole).or(own);
    let held = size(unit);
    let times = size(new) * change.factor;
    let mut plus: Vec<(usize, f64)> =
        entry.plus.iter().map(|(other, own)| (*other, rounded(times * own))).collect();
    if let Some((other, times)) = change.plus {
        match plus.iter_mut().find(|(known, _)| *known == other) {
            Some((_, own)) => *own = rounded(*own + times),
            None => plus.push((other, times)),
        }
    }
    plus.retain(|(_, times)| *times != 0.0);
    ColumnMapping {
        header: entry.header.clone(),
        column,
        plus,
        unit: unit.map_or(entry.unit, |unit| unit.name),
        open: entry.open,
        factor: rounded(scale * entry.factor / held),
        offset: rounded((scale * entry.offset + size(new) * change.offset) / held),
    }
}

/// A number to twelve digits: products of units carry the rounding of their factors.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
