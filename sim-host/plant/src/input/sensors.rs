//! What the controller's sensors add to the truth: `sensors/1`.

use super::document::Table;
use super::{Bounds, Document, FileKind, InputError, read_text};
use std::path::Path;

/// The sensors of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensors {
    /// Step of the motor encoders, seen from the joint, A1 first, rad. 0: ideal.
    pub encoder_resolution: [f64; 6],
    /// The force/torque sensor between flange and tool.
    pub force: ForceSensor,
    /// The seam sensor; `None` where the cell has none.
    pub seam: Option<SeamSensor>,
    /// Seed of the noise.
    pub seed: u64,
}

/// A laser line across the seam, carried by the tool and looking ahead of it: it sees how far the
/// tool is beside the seam, and how far it is tilted across it.
#[derive(Debug, Clone, PartialEq)]
pub struct SeamSensor {
    /// How far ahead of the tool the line lies, m.
    pub ahead: f64,
    /// Standard deviation of a reading across the seam, m.
    pub noise: f64,
    /// Standard deviation of a reading of the tilt across the seam, rad.
    pub tilt_noise: f64,
    /// Time between readings, s.
    pub period: f64,
    /// Age of a reading when the controller gets it, s.
    pub delay: f64,
    /// Share of readings that are lost: glare, spatter.
    pub lost: f64,
}

/// The force/torque sensor.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceSensor {
    /// Standard deviation of the noise of each force, N.
    pub noise_force: f64,
    /// Standard deviation of the noise of each moment, N·m.
    pub noise_moment: f64,
    /// Corner of its second-order low-pass filter, Hz. 0: no filter.
    pub filter: f64,
    /// Age of a reading when the controller gets it, s.
    pub delay: f64,
    /// Step of a force reading, N. 0: ideal.
    pub resolution: f64,
}

impl Sensors {
    /// Reads a sensor file.
    ///
    /// # Errors
    /// The first thing in it that does not fit, with its place.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, InputError> {
        let (name, text) = read_text(path.as_ref())?;
        Self::parse(&text, &name)
    }

    /// Reads sensors from text; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Sensors::read`].
    pub fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        let document = Document::parse(text, name)?;
        let root = document.root_of(FileKind::Sensors.schema())?;
        root.only(&["schema", "seed", "encoder", "force", "seam"])?;
        let seed = root.integer("seed")?;
        let encoder = root.table("encoder")?;
        encoder.only(&["resolution_rad"])?;
        let force = root.table("force")?;
        force.only(&["noise_n", "noise_nm", "filter_hz", "delay_s", "resolution_n"])?;
        Ok(Self {
            encoder_resolution: encoder.numbers("resolution_rad", Bounds::UpTo(0.1))?,
            force: ForceSensor {
                noise_force: force.number("noise_n", Bounds::NonNegative)?,
                noise_moment: force.number("noise_nm", Bounds::NonNegative)?,
                filter: force.number("filter_hz", Bounds::NonNegative)?,
                delay: force.number("delay_s", Bounds::UpTo(1.0))?,
                resolution: force.number("resolution_n", Bounds::NonNegative)?,
            },
            seam: if root.has("seam") { Some(seam(&root.table("seam")?)?) } else { None },
            seed,
        })
    }
}

fn seam(table: &Table<'_>) -> Result<SeamSensor, InputError> {
    table.only(&["ahead_m", "noise_m", "tilt_noise_rad", "period_s", "delay_s", "lost"])?;
    Ok(SeamSensor {
        ahead: table.number("ahead_m", Bounds::UpTo(1.0))?,
        noise: table.number("noise_m", Bounds::PositiveUpTo(0.1))?,
        tilt_noise: table.number("tilt_noise_rad", Bounds::PositiveUpTo(0.1))?,
        period: table.number("period_s", Bounds::PositiveUpTo(10.0))?,
        delay: table.number("delay_s", Bounds::UpTo(0.3))?,
        lost: table.number("lost", Bounds::UpTo(1.0))?,
    })
}
