//! What the watch beside the law warned of in a run: since when, and how much of it.

use super::{Phase, RecordRow};
use crate::serialize_as_text;
use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use trueweld_core::monitor::WATCHED_ORDERS;

/// Something that is warned of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HealthWarningKind {
    /// A line of the spindle in the push climbs: that of this order, cycles a turn.
    SpindleLine(u8),
    /// This drive rings (0 = A1).
    Ringing(usize),
}

serialize_as_text!(HealthWarningKind::to_string);

impl fmt::Display for HealthWarningKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SpindleLine(order) => write!(f, "spindle line of order {order} climbs"),
            Self::Ringing(joint) => write!(f, "A{} rings", joint + 1),
        }
    }
}

/// A warning of the watch beside the law.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "HealthWarningResult", deny_unknown_fields)]
pub struct HealthWarning {
    /// What: `spindle line of order 1 climbs` or `A1 rings`.
    #[serde(rename = "what")]
    pub kind: HealthWarningKind,
    /// When first, s.
    pub first_s: f64,
    /// Where the run was in its program then.
    pub phase: Phase,
    /// For how long, s.
    pub time_s: f64,
    /// Of a spindle's line: its largest amplitude in the push, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_n: Option<f64>,
    /// Of a spindle's line: what was usual, N.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub usual_n: Option<f64>,
    /// Of a drive: largest RMS of its rate, rad/s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rate_rad_s: Option<f64>,
    /// Of a drive: the frequency at which it rings, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frequency_hz: Option<f64>,
}

impl HealthWarning {
    /// One row's, with no figures yet; its time is in rows, since sums of the period round.
    fn new(row: &RecordRow, kind: HealthWarningKind) -> Self {
        Self {
            kind,
            first_s: row.time,
            phase: row.phase,
            time_s: 1.0,
            amplitude_n: None,
            usual_n: None,
            rate_rad_s: None,
            frequency_hz: None,
        }
    }

    /// Takes the larger of both.
    fn grow(&mut self, next: &Self) {
        self.amplitude_n = self.amplitude_n.zip(next.amplitude_n).map(|(a, b)| a.max(b));
        if next.rate_rad_s > self.rate_rad_s {
            (self.rate_rad_s, self.frequency_hz) = (next.rate_rad_s, next.frequency_hz);
        }
    }
}

/// Everything that was warned of in rows that are `period` s apart, the first first.
pub fn health_warnings(rows: &[RecordRow], period: f64) -> Vec<HealthWarning> {
    let mut warnings: Vec<HealthWarning> = Vec::new();
    for row in rows.iter().filter(|row| row.health.warns()) {
        let lines = row.health.lines.iter().zip(WATCHED_ORDERS).filter(|(line, _)| line.climbs);
        let climbing = lines.map(|(line, order)| HealthWarning {
            amplitude_n: Some(line.amplitude.into()),
            usual_n: Some(line.usual.into()),
            ..HealthWarning::new(row, HealthWarningKind::SpindleLine(order))
        });
        let drives = row.health.drives.iter().enumerate().filter(|(_, drive)| drive.rings);
        let ringing = drives.map(|(joint, drive)| HealthWarning {
            rate_rad_s: Some(drive.rate.into()),
            frequency_hz: Some(drive.frequency.into()),
            ..HealthWarning::new(row, HealthWarningKind::Ringing(joint))
        });
        for next in climbing.chain(ringing) {
            match warnings.iter_mut().find(|known| known.kind == next.kind) {
                Some(known) => {
                    known.time_s += 1.0;
                    known.grow(&next);
                }
                None => warnings.push(next),
            }
        }
    }
    warnings.iter_mut().for_each(|warning| warning.time_s *= period);
    warnings
}
