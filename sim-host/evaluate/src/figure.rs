//! What a figure of a run is: its key in files and results, what people call it, its unit.
//!
//! The figures themselves stand in one table for each kind of run, where the run is looked at:
//! [`WELD_FIGURES`](crate::WELD_FIGURES), [`MARGIN_FIGURES`](crate::margins::MARGIN_FIGURES) and
//! [`FAULT_FIGURES`](crate::certify::FAULT_FIGURES). Limits, results and pages follow from them.

use trueweld_plant::serialize_as_text;

/// A figure of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Figure {
    /// Its key in requirements and results, the unit at its end.
    pub key: &'static str,
    /// What it is, for people.
    pub label: &'static str,
    /// SI unit: "m", "m/s", "rad", "s", "N", or "1" for a ratio.
    pub unit: &'static str,
}

serialize_as_text!(Figure::key);

impl Figure {
    fn key(&self) -> &'static str {
        self.key
    }

    /// The phase of the weld that it is of, where its key names one; nothing for the steady part
    /// and for what is of no phase.
    pub fn phase(&self) -> &'static str {
        self.key.split_once('.').map_or("", |(phase, _)| phase)
    }

    /// Its key without the phase.
    pub fn key_in_phase(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(_, key)| key)
    }
}

/// A figure and how it follows from what was recorded or computed of a run.
#[derive(Debug, Clone, Copy)]
pub struct FigureOf<S: 'static, V: 'static = f64> {
    /// Which.
    pub figure: Figure,
    /// Its value, SI units.
    pub value: fn(&S) -> V,
}

impl<S, V> FigureOf<S, V> {
    /// A row of a table.
    pub(crate) const fn new(
        key: &'static str,
        label: &'static str,
        unit: &'static str,
        value: fn(&S) -> V,
    ) -> Self {
        Self { figure: Figure { key, label, unit }, value }
    }
}

/// True for a figure within its limit. A correction held at its authority is the limit, to the last
/// digits.
pub fn within(figure: f64, limit: f64) -> bool {
    figure <= limit * (1.0 + 1e-9)
}

/// How much of what lies between `from` and a limit a figure takes up: above 1 beyond the limit,
/// infinite for what is not a number.
pub(crate) fn share_of_limit(figure: f64, from: f64, limit: f64) -> f64 {
    match (figure - from) / (limit - from) {
        _ if figure.is_nan() => f64::INFINITY,
        // Nothing lies between.
        _ if limit <= from => {
            if within(figure, limit) {
                0.0
            } else {
                f64::INFINITY
            }
        }
        share => share,
    }
}

/// The most, or of margins the least, that a figure may be, SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// Which figure.
    pub figure: &'static Figure,
    /// The limit.
    pub value: f64,
}
