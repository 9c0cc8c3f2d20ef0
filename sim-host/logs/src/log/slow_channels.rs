//! Instruments that are slower than the file that they are written in, and hold their readings there:
//! each is read as if it had a file of its own.

use super::columns::{
    ABC, MATRIX, QUATERNION, REFLECTOR_COUNT, TIME_COLUMN, reflector, shown_name,
};
use super::notice::LogNotice;
use super::track::FileTrack;
use crate::channel::{LOG_CHANNELS, LogChannel};
use crate::kind::LogKind;
use crate::sample_hold::{SampleHold, sample_hold};
use std::ops::Range;

/// Takes such instruments out of a track: the tracks that they make. Rows at rest have nothing between
/// them.
pub(super) fn split_slow_channels(
    track: &mut FileTrack,
    kind: LogKind,
    notices: &mut Vec<LogNotice>,
) -> Vec<FileTrack> {
    if kind == LogKind::StaticLoad {
        return Vec::new();
    }
    let measured = LOG_CHANNELS
        .iter()
        .map(|channel| channel.id)
        .filter(|id| !matches!(id, LogChannel::Time | LogChannel::Spindle | LogChannel::Payload));
    let instruments: Vec<Range<usize>> = measured
        .map(LogChannel::columns)
        .chain([ABC, QUATERNION, MATRIX])
        .chain((0..REFLECTOR_COUNT).map(reflector))
        .collect();
    let mut all: Vec<(SampleHold, FileTrack)> = Vec::new();
    for instrument in instruments {
        let there: Vec<usize> = instrument.filter(|c| track.columns[*c].is_some()).collect();
        let series: Vec<&[f64]> =
            there.iter().filter_map(|c| track.columns[*c].as_deref()).collect();
        let Some(found) = sample_hold(&series) else { continue };
        // What is read together stays together.
        let place = all.iter().position(|(known, _)| *known == found).unwrap_or_else(|| {
            let mut own = FileTrack {
                clock: track.clock.clone(),
                columns: vec![None; track.columns.len()],
                rounding: track.rounding.clone(),
            };
            own.columns[TIME_COLUMN] = Some(found.instants(track.time()));
            all.push((found, own));
            all.len() - 1
        });
        let (found, own) = &mut all[place];
        for column in &there {
            let series = track.columns[*column].take();
            own.columns[*column] = series.map(|s| found.first.iter().map(|k| s[*k]).collect());
        }
        let columns = there.into_iter().map(shown_name).collect();
        notices.push(LogNotice::Held { columns, every: found.every });
    }
    all.into_iter().map(|(_, own)| own).collect()
}
