//! What belongs to a step of the push and to no single controller: the 5 % band, and the words
//! beside the plots.

use super::shown::{DrawnRun, SINCE_STEP};
use super::signals;
use super::writer::{RecordError, Store, Writer};
use crate::MILLI;
use crate::color::LIMIT;
use re_chunk::TimeColumn;
use re_sdk_types::archetypes::TextDocument;
use re_sdk_types::components::MediaType;
use std::io::Write;

/// Entity of the 5 % band.
pub(super) const SETTLING_BAND_ENTITY: &str = "/reference/band";

/// The step of the set-point.
pub(super) struct SetPointStep {
    /// When, s.
    pub at: f64,
    /// Time recorded after it, s.
    pub length: f64,
    /// Push asked for after it, N.
    pub goal: f64,
    /// 5 % of its height, N.
    pub near: f64,
}

impl SetPointStep {
    /// From the first run. `None` where it has no push asked for on both sides of `at`.
    pub(crate) fn of(shown: &[DrawnRun], at: f64) -> Option<Self> {
        let DrawnRun { recording, .. } = shown.first()?;
        let last = recording.rows.last()?;
        let goal = last.force_desired?;
        let before = recording
            .rows
            .iter()
            .rev()
            .find(|r| r.time < at - 0.5 * recording.period)?
            .force_desired?;
        Some(Self { at, length: last.time - at, goal, near: 0.05 * (goal - before).abs() })
    }
}

/// Writes the band and the words.
pub(super) fn references<W: Write>(
    writer: &mut Writer<W>,
    about: String,
    step: Option<&SetPointStep>,
) -> Result<(), RecordError> {
    let text = TextDocument::new(about).with_media_type(MediaType::MARKDOWN);
    writer.fixed(Store::Recording, "/about", &text)?;
    let Some(step) = step else { return Ok(()) };
    let times = [
        TimeColumn::new_duration_secs("time", [step.at, step.at + step.length]),
        TimeColumn::new_duration_secs(SINCE_STEP, [0.0, step.length]),
    ];
    let limits = [-1.0, 1.0].map(|side| (step.goal + side * step.near) / MILLI);
    signals::reference(writer, SETTLING_BAND_ENTITY, "±5 %", LIMIT, times, &[limits; 2])
}
