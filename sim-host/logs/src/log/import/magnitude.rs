//! Units by the magnitude of the values, where no header states them.

use super::proposal::{Doubt, ProposalBasis, ProposedColumn};
use super::raw::Raw;
use crate::channel::{LOG_CHANNELS, LogChannel};
use crate::log::columns::{ABC, MAPPABLE_COLUMNS, MATRIX, QUATERNION, dimension, reflector};
use crate::log::units::Dimension;
use crate::resample::median_step;
use std::ops::Range;

/// Units that no header states.
pub(super) fn units_by_magnitude(columns: &mut [ProposedColumn], raws: &[Raw]) {
    for group in groups() {
        let members: Vec<usize> = (0..columns.len())
            .filter(|k| {
                let c = &columns[*k];
                c.mapping.as_ref().is_ok_and(|m| group.contains(&m.column))
                    && !c.bases.contains(&ProposalBasis::UnitInHeader)
                    && !c.doubts.contains(&Doubt::Factor)
                    && !c.mapping.as_ref().is_ok_and(|mapping| mapping.open)
            })
            .collect();
        // Columns of one file are in one unit.
        for file in 0..raws.len() {
            let of_file: Vec<usize> =
                members.iter().copied().filter(|k| columns[*k].file == file).collect();
            let most = of_file
                .iter()
                .filter_map(|k| columns[*k].range)
                .map(|[a, b]| a.abs().max(b.abs()))
                .fold(0.0, f64::max);
            let Some(first) = of_file.first() else { continue };
            let step = columns[*first].header.as_str();
            let step = raws[file]
                .names
                .iter()
                .position(|name| name == step)
                .and_then(|k| raws[file].values[k].as_deref())
                .map_or(0.0, median_step);
            let (unit, fits_one) = match (dimension(group.start), epoch(most, step)) {
                (Dimension::Time, Some(unit)) => (unit, true),
                (held, _) => by_magnitude(held, most, step, group.start),
            };
            // A load at rest lasts as many seconds as a row of a motion has milliseconds.
            let sure = fits_one && (unit != "ms" || raws[file].rows >= MOTION_ROWS_MIN);
            for k in of_file {
                if let Ok(mapping) = &mut columns[k].mapping {
                    mapping.unit = unit;
                }
                if sure {
                    columns[k].bases.push(ProposalBasis::Magnitude);
                } else {
                    columns[k].doubts.push(Doubt::Unit);
                }
            }
        }
    }
}

/// Rows from which on a log is none of loads at rest.
const MOTION_ROWS_MIN: usize = 100;

/// Columns that share a unit.
fn groups() -> Vec<Range<usize>> {
    let mut groups: Vec<_> = LOG_CHANNELS
        .iter()
        .map(|channel| channel.id.columns())
        .filter(|columns| *columns != LogChannel::Payload.columns())
        .collect();
    let payload = LogChannel::Payload.columns();
    groups.push(payload.start..payload.start + 1);
    groups.push(payload.start + 1..payload.end);
    groups.push(ABC);
    groups.push(QUATERNION);
    groups.push(MATRIX);
    groups.push(reflector(0).start..MAPPABLE_COLUMNS);
    groups
}

/// The unit of times that count from 1970 and of years from 2001 to 2096, where rows are then less than
/// a minute apart.
fn epoch(most: f64, step: f64) -> Option<&'static str> {
    let units = [("s", 1.0), ("ms", 1e3), ("us", 1e6), ("ns", 1e9)];
    let of_years = |factor: f64| (1e9..4e9).contains(&(most / factor)) && step < 60.0 * factor;
    units.into_iter().find(|(_, factor)| of_years(*factor)).map(|(unit, _)| unit)
}

/// The unit that values of this size are in, and whether only one fits.
fn by_magnitude(dimension: Dimension, most: f64, step: f64, column: usize) -> (&'static str, bool) {
    match dimension {
        // A tenth of a second to one in microseconds is a tenth of a millisecond to one in nanoseconds.
        Dimension::Time if step >= 9e5 => ("ns", (9e5..=2e7).contains(&step)),
        Dimension::Time if step >= 500.0 => ("us", step <= 2e4),
        // Rows at rest are seconds apart as well.
        Dimension::Time if step >= 0.5 => ("ms", (0.9..=20.0).contains(&step)),
        Dimension::Time => ("s", step > 0.0),
        Dimension::Angle if most > 6.6 => ("deg", true),
        Dimension::Angle => ("rad", most > 0.2),
        Dimension::AngularSpeed if most > 320.0 => ("rpm", true),
        Dimension::AngularSpeed => ("rad/s", most < 20.0),
        Dimension::Length if most > 2e5 => ("um", true),
        Dimension::Length if most > 20.0 => ("mm", true),
        Dimension::Length => ("m", most > 0.05 && column < LogChannel::Payload.columns().start),
        Dimension::Force if most < 60.0 => ("kN", false),
        Dimension::Force => ("N", most > 300.0),
        Dimension::Torque => ("Nm", most > 50.0),
        Dimension::Mass => ("kg", most < 2000.0),
        Dimension::Number => ("1", true),
    }
}
