//! What the watch beside the law warned of in a run: since when, and how much of it.

use super::{Phase, RecordRow};
use std::fmt;
use trueweld_core::monitor::WATCHED_ORDERS;

/// Something that is warned of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum HealthWarningKind {
    /// A line of the spindle in the push climbs.
    SpindleLine {
        /// Its order: cycles a turn.
        order: u8,
        /// Largest amplitude while it was warned of, N.
        amplitude: f64,
        /// What was usual at the first warning, N.
        usual: f64,
    },
    /// A drive rings.
    Ringing {
        /// Which (0 = A1).
        joint: usize,
        /// Largest RMS of its rate while it was warned of, rad/s.
        rate: f64,
        /// Frequency then, Hz.
        frequency: f64,
    },
}

impl HealthWarningKind {
    /// True where both warn of the same thing, by how much ever.
    fn is_of(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::SpindleLine { order: a, .. }, Self::SpindleLine { order: b, .. }) => a == b,
            (Self::Ringing { joint: a, .. }, Self::Ringing { joint: b, .. }) => a == b,
            _ => false,
        }
    }

    /// Takes the larger of both.
    fn grow(&mut self, next: &Self) {
        match (self, *next) {
            (Self::SpindleLine { amplitude, .. }, Self::SpindleLine { amplitude: next, .. }) => {
                *amplitude = amplitude.max(next);
            }
            (
                Self::Ringing { rate, frequency, .. },
                Self::Ringing { rate: next, frequency: at, .. },
            ) if next > *rate => (*rate, *frequency) = (next, at),
            _ => {}
        }
    }
}

impl fmt::Display for HealthWarningKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SpindleLine { order, .. } => write!(f, "spindle line of order {order} climbs"),
            Self::Ringing { joint, .. } => write!(f, "A{} rings", joint + 1),
        }
    }
}

/// A warning of a run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HealthWarning {
    /// Of what.
    pub kind: HealthWarningKind,
    /// When first, s.
    pub first: f64,
    /// Where the run was in its program then.
    pub phase: Phase,
    /// In how many rows of the run.
    pub rows: usize,
}

/// Everything that was warned of, the first first.
pub fn health_warnings(rows: &[RecordRow]) -> Vec<HealthWarning> {
    let mut warnings: Vec<HealthWarning> = Vec::new();
    for row in rows.iter().filter(|row| row.health.warns()) {
        let lines = row.health.lines.iter().zip(WATCHED_ORDERS).filter(|(line, _)| line.climbs);
        let climbing = lines.map(|(line, order)| HealthWarningKind::SpindleLine {
            order,
            amplitude: line.amplitude.into(),
            usual: line.usual.into(),
        });
        let drives = row.health.drives.iter().enumerate().filter(|(_, drive)| drive.rings);
        let ringing = drives.map(|(joint, drive)| HealthWarningKind::Ringing {
            joint,
            rate: drive.rate.into(),
            frequency: drive.frequency.into(),
        });
        for kind in climbing.chain(ringing) {
            match warnings.iter_mut().find(|known| known.kind.is_of(&kind)) {
                Some(known) => {
                    known.rows += 1;
                    known.kind.grow(&kind);
                }
                None => {
                    let (first, phase) = (row.time, row.phase);
                    warnings.push(HealthWarning { kind, first, phase, rows: 1 });
                }
            }
        }
    }
    warnings
}
