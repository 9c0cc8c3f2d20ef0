//! What a compensation law must reach, and under what uncertainty: `requirements/1`.

use super::document::Table;
use super::{Bounds, Document, FileKind, InputError, read_text};
use std::path::Path;

/// Requirements of a certification.
#[derive(Debug, Clone, PartialEq)]
pub struct Requirements {
    /// Limits of the figures of a weld's steady part, in the order of [`LIMITS`]; `None` where the
    /// file has none.
    pub limits: [Option<f64>; LIMITS.len()],
    /// Share of welds that may fail a requirement.
    pub failure_probability: f64,
    /// Confidence with which that must be shown.
    pub confidence: f64,
    /// What is not known of the cell.
    pub uncertainty: Uncertainty,
    /// Limits that the worst cell found within the uncertainty must keep, in the order of
    /// [`LIMITS`].
    pub worst_case: [Option<f64>; LIMITS.len()],
    /// Margins of the loop along the weld; `None` where none are asked for.
    pub margins: Option<MarginLimits>,
    /// Instruments that fail, and what the tool must keep to then; `None` where no fault is asked
    /// for.
    pub faults: Option<Faults>,
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

/// Margins that may be asked for, by their keys: of corrections and force loop, then of the drives.
pub const MARGINS: [&str; 10] = [
    "gain_margin",
    "phase_margin_rad",
    "modulus_margin",
    "delay_margin_s",
    "disk_margin",
    "drive_gain_margin",
    "drive_phase_margin_rad",
    "drive_modulus_margin",
    "drive_delay_margin_s",
    "drive_disk_margin",
];

/// What the margins of the loop must be at least, wherever they are looked at. A loop that is not
/// stable keeps none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarginLimits {
    /// Places along the weld, both ends included.
    pub places: usize,
    /// In the order of [`MARGINS`]; `None` where the file has none.
    pub at_least: [Option<f64>; MARGINS.len()],
}

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

/// One instrument at a time that fails in the steady part of the nominal weld and comes back, and
/// what the tool must keep to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Faults {
    /// How long a fault lasts, s.
    pub duration: f64,
    /// Time after its end in which the tool must be back within the limits of the steady part, s.
    pub recovery: f64,
    /// Largest lateral deviation from the beginning of the fault to the end of that time, m.
    pub lateral: f64,
    /// How far depth may go from its mean before the fault in the same time, m; `None` where the
    /// file does not limit it.
    pub depth: Option<f64>,
    /// Ends of the force sensor's range: of each force, N, and of each moment, N·m.
    pub force_range: [f64; 2],
    /// Ends of the seam sensor's range: across the seam, m, and in tilt, rad.
    pub seam_range: [f64; 2],
    /// Offset of a seam sensor that lies: across the seam, m, and in tilt, rad.
    pub seam_offset: [f64; 2],
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
        let root = document.root_of(FileKind::Requirements.schema())?;
        root.only(&[
            "schema",
            "failure_probability",
            "confidence",
            "limits",
            "uncertainty",
            "worst_case",
            "margins",
            "faults",
        ])?;
        let share = |key| {
            let value = root.number(key, Bounds::PositiveUpTo(1.0))?;
            let help = "0.05 for one weld in twenty, or a confidence of 0.95.";
            if value < 1.0 {
                Ok(value)
            } else {
                Err(root.wrong(key, "a number between 0 and 1", help))
            }
        };
        Ok(Self {
            limits: limits(&root.table("limits")?)?,
            failure_probability: share("failure_probability")?,
            confidence: share("confidence")?,
            uncertainty: uncertainty(&root.table("uncertainty")?)?,
            worst_case: if root.has("worst_case") {
                limits(&root.table("worst_case")?)?
            } else {
                [None; LIMITS.len()]
            },
            margins: if root.has("margins") {
                Some(margins(&root.table("margins")?)?)
            } else {
                None
            },
            faults: if root.has("faults") { Some(faults(&root.table("faults")?)?) } else { None },
        })
    }
}

fn limits(table: &Table<'_>) -> Result<[Option<f64>; LIMITS.len()], InputError> {
    table.only(&LIMITS)?;
    let mut limits = [None; LIMITS.len()];
    for (limit, key) in limits.iter_mut().zip(LIMITS) {
        if table.has(key) {
            *limit = Some(table.number(key, Bounds::Positive)?);
        }
    }
    Ok(limits)
}

fn margins(table: &Table<'_>) -> Result<MarginLimits, InputError> {
    table.only(&[&["places"], &MARGINS[..]].concat())?;
    let places = table.number("places", Bounds::PositiveUpTo(1000.0))?;
    if places < 2.0 || places.fract() != 0.0 {
        return Err(table.wrong(
            "places",
            "a whole number from 2 up",
            "Such as 11: one every tenth of the weld.",
        ));
    }
    let mut at_least = [None; MARGINS.len()];
    for (limit, key) in at_least.iter_mut().zip(MARGINS) {
        if table.has(key) {
            *limit = Some(table.number(key, Bounds::Positive)?);
        }
    }
    Ok(MarginLimits { places: places as usize, at_least })
}

fn faults(table: &Table<'_>) -> Result<Faults, InputError> {
    table.only(&[
        "duration_s",
        "recovery_s",
        "lateral_max_m",
        "depth_max_m",
        "force_range_n",
        "force_range_nm",
        "seam_range_m",
        "seam_range_rad",
        "seam_offset_m",
        "seam_offset_rad",
    ])?;
    let at_most = |key, most| table.number(key, Bounds::PositiveUpTo(most));
    let depth = if table.has("depth_max_m") { Some(at_most("depth_max_m", 1.0)?) } else { None };
    Ok(Faults {
        duration: at_most("duration_s", 1000.0)?,
        recovery: at_most("recovery_s", 1000.0)?,
        lateral: at_most("lateral_max_m", 1.0)?,
        depth,
        force_range: [
            table.number("force_range_n", Bounds::Positive)?,
            table.number("force_range_nm", Bounds::Positive)?,
        ],
        seam_range: [at_most("seam_range_m", 1.0)?, at_most("seam_range_rad", 1.0)?],
        seam_offset: [at_most("seam_offset_m", 1.0)?, at_most("seam_offset_rad", 1.0)?],
    })
}

fn uncertainty(table: &Table<'_>) -> Result<Uncertainty, InputError> {
    table.only(&["stiffness", "process", "ripple", "crosstalk", "delay_periods"])?;
    let delay = table.numbers::<2>("delay_periods", Bounds::UpTo(20.0))?;
    if delay[0] > delay[1] {
        return Err(table.wrong(
            "delay_periods",
            "the least first, then the most",
            "Such as [1.0, 2.0].",
        ));
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
