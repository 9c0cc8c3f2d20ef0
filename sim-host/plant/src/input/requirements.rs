//! What a compensation law must reach, and under what uncertainty: `requirements/1`.

use super::document::Table;
use super::{Bounds, Document, InputError, Kind, read_text};
use std::path::Path;

/// Requirements of a certification.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// Limits of the figures of a weld's steady part, in the order of [`LIMITS`]; `None` where the file has none.
    pub limits: [Option<f64>; LIMITS.len()],
    /// Share of welds that may fail a requirement.
    pub failure_probability: f64,
    /// Confidence with which that must be shown.
    pub confidence: f64,
    /// What is not known of the cell.
    pub uncertainty: Uncertainty,
}

/// Figures that may be limited, by their keys.
pub const LIMITS: [&str; 10] = [
    "lateral_rms_m",
    "lateral_max_m",
    "depth_rms_m",
    "tilt_rms_rad",
    "side_tilt_rms_rad",
    "travel_angle_rms_rad",
    "push_error_rms_n",
    "lateral_before_m",
    "correction_m",
    "correction_rad",
];

/// What is not known of a cell: half widths of uniform distributions about the nominal value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Uncertainty {
    /// Of every joint's stiffness, relative.
    pub stiffness: f64,
    /// Of every gain of the process, relative.
    pub process: f64,
    /// Of the amplitude of the spindle's ripple, relative; its phases are anything.
    pub ripple: f64,
    /// Of the force across the tool that the sensor shows per axial force, each axis.
    pub crosstalk: f64,
    /// Least and most delay of the force sensor and the seam sensor, control periods.
    pub delay: [f64; 2],
}

impl Requirements {
    /// Reads a file of requirements.
    ///
    /// # Errors
    /// The first thing in it that does not fit, with its place.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, InputError> {
        let (name, text) = read_text(path.as_ref())?;
        Self::parse(&text, &name)
    }

    /// Reads requirements from text; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Requirements::read`].
    pub fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        let document = Document::parse(text, name)?;
        let root = document.root_of(Kind::Requirements.schema())?;
        root.only(&["schema", "failure_probability", "confidence", "limits", "uncertainty"])?;
        let table = root.table("limits")?;
        table.only(&LIMITS)?;
        let mut limits = [None; LIMITS.len()];
        for (limit, key) in limits.iter_mut().zip(LIMITS) {
            if table.has(key) {
                *limit = Some(table.number(key, Bounds::Positive)?);
            }
        }
        let share = |key| {
            let value = root.number(key, Bounds::PositiveUpTo(1.0))?;
            let help = "0.05 for one weld in twenty, or a confidence of 0.95.";
            if value < 1.0 { Ok(value) } else { Err(root.wrong(key, "a number between 0 and 1", help)) }
        };
        Ok(Self {
            limits,
            failure_probability: share("failure_probability")?,
            confidence: share("confidence")?,
            uncertainty: uncertainty(&root.table("uncertainty")?)?,
        })
    }
}

fn uncertainty(table: &Table<'_>) -> Result<Uncertainty, InputError> {
    table.only(&["stiffness", "process", "ripple", "crosstalk", "delay_periods"])?;
    let delay = table.numbers::<2>("delay_periods", Bounds::UpTo(20.0))?;
    if delay[0] > delay[1] {
        return Err(table.wrong("delay_periods", "the least first, then the most", "Such as [1.0, 2.0]."));
    }
    // A stiffness or a gain of nothing is no cell.
    let relative = |key| table.number(key, Bounds::UpTo(0.9));
    Ok(Uncertainty {
        stiffness: relative("stiffness")?,
        process: relative("process")?,
        ripple: table.number("ripple", Bounds::UpTo(1.0))?,
        crosstalk: table.number("crosstalk", Bounds::UpTo(0.2))?,
        delay,
    })
}
