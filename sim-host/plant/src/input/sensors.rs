//! What the controller's sensors add to the truth: `sensors/1`.

use super::{FileKind, InputError, InputFile, Table};

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

impl InputFile for Sensors {
    const KIND: FileKind = FileKind::Sensors;

    fn from_root(root: &Table<'_>) -> Result<Self, InputError> {
        root.only(&["schema", "seed", "encoder", "force", "seam"])?;
        let seed = root.integer("seed")?;
        let encoder = root.table("encoder")?;
        encoder.only(&["resolution_rad"])?;
        let force = root.table("force")?;
        force.only(&["noise_n", "noise_nm", "filter_hz", "delay_s", "resolution_n"])?;
        Ok(Self {
            encoder_resolution: encoder.quantities("resolution_rad")?,
            force: ForceSensor {
                noise_force: force.quantity("noise_n")?,
                noise_moment: force.quantity("noise_nm")?,
                filter: force.quantity("filter_hz")?,
                delay: force.quantity("delay_s")?,
                resolution: force.quantity("resolution_n")?,
            },
            seam: if root.has("seam") { Some(seam(&root.table("seam")?)?) } else { None },
            seed,
        })
    }
}

fn seam(table: &Table<'_>) -> Result<SeamSensor, InputError> {
    table.only(&["ahead_m", "noise_m", "tilt_noise_rad", "period_s", "delay_s", "lost"])?;
    Ok(SeamSensor {
        ahead: table.quantity("ahead_m")?,
        noise: table.quantity("noise_m")?,
        tilt_noise: table.quantity("tilt_noise_rad")?,
        period: table.quantity_as("period_s", "seam.period_s")?,
        delay: table.quantity_as("delay_s", "seam.delay_s")?,
        lost: table.quantity("lost")?,
    })
}
