//! What the controller's sensors add to the truth: `sensors/1`.

use super::{FileKind, InputError, InputFile, TomlTable};
use trueweld_core::control::ForceSensorLimits;

/// The sensors of one cell.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensors {
    /// Step of the motor encoders, seen from the joint, A1 first, rad. 0: ideal.
    pub encoder_resolution: [f64; 6],
    /// Standard deviation of the noise of each motor torque, A1 first, N·m.
    pub torque_noise: [f64; 6],
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
    /// The real noise over the stated one, by which laws weigh readings.
    pub noise_factor: f64,
    /// What a reading is off by where there is no deviation: across the seam, m.
    pub zero: f64,
    /// The same of the tilt, rad.
    pub tilt_zero: f64,
    /// Relative error of its scale across the seam.
    pub scale: f64,
    /// Small rotation vector by which it is mounted off, axes of W, rad. Turned about x it reads a
    /// tilt, and depth as a deviation across the seam; turned about z it reads off by `ahead` times
    /// that.
    pub misalignment: [f64; 3],
    /// By up to so much readings come later, evenly, s; their stated age tells it.
    pub jitter: f64,
    /// By so much a reading is older than its stated age, s.
    pub hidden_delay: f64,
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
    /// What it can read, and by how much the drives may contradict it.
    pub limits: ForceSensorLimits<f64>,
    /// What a moment reads without load, axes of T, N·m. Forces: the effect `force-offset`.
    pub zero_moment: [f64; 3],
    /// Small rotation vector by which the sensor is mounted off, axes of T, rad.
    pub misalignment: [f64; 3],
    /// By up to so much a reading is older than `delay`, evenly, s.
    pub jitter: f64,
}

/// A number of the sensors by its key: one place, or one for every joint or axis. None where the
/// cell has no seam sensor.
type SensorNumber = (&'static str, fn(&mut Sensors) -> Vec<&mut f64>);

fn of_seam<'s>(
    sensors: &'s mut Sensors,
    number: impl Fn(&'s mut SeamSensor) -> Vec<&'s mut f64>,
) -> Vec<&'s mut f64> {
    sensors.seam.as_mut().map_or(Vec::new(), number)
}

impl Sensors {
    /// Every number that a file states, by table and key.
    pub const NUMBERS: [SensorNumber; 26] = [
        ("encoder.resolution_rad", |s| s.encoder_resolution.iter_mut().collect()),
        ("torque.noise_nm", |s| s.torque_noise.iter_mut().collect()),
        ("force.noise_n", |s| vec![&mut s.force.noise_force]),
        ("force.noise_nm", |s| vec![&mut s.force.noise_moment]),
        ("force.filter_hz", |s| vec![&mut s.force.filter]),
        ("force.delay_s", |s| vec![&mut s.force.delay]),
        ("force.resolution_n", |s| vec![&mut s.force.resolution]),
        ("force.range_n", |s| vec![&mut s.force.limits.force]),
        ("force.range_nm", |s| vec![&mut s.force.limits.moment]),
        ("force.disagreement_n", |s| vec![&mut s.force.limits.disagreement]),
        ("force.zero_nm", |s| s.force.zero_moment.iter_mut().collect()),
        ("force.misalignment_rad", |s| s.force.misalignment.iter_mut().collect()),
        ("force.jitter_s", |s| vec![&mut s.force.jitter]),
        ("seam.ahead_m", |s| of_seam(s, |seam| vec![&mut seam.ahead])),
        ("seam.noise_m", |s| of_seam(s, |seam| vec![&mut seam.noise])),
        ("seam.tilt_noise_rad", |s| of_seam(s, |seam| vec![&mut seam.tilt_noise])),
        ("seam.period_s", |s| of_seam(s, |seam| vec![&mut seam.period])),
        ("seam.delay_s", |s| of_seam(s, |seam| vec![&mut seam.delay])),
        ("seam.lost", |s| of_seam(s, |seam| vec![&mut seam.lost])),
        ("seam.noise_factor", |s| of_seam(s, |seam| vec![&mut seam.noise_factor])),
        ("seam.zero_m", |s| of_seam(s, |seam| vec![&mut seam.zero])),
        ("seam.tilt_zero_rad", |s| of_seam(s, |seam| vec![&mut seam.tilt_zero])),
        ("seam.scale", |s| of_seam(s, |seam| vec![&mut seam.scale])),
        ("seam.misalignment_rad", |s| of_seam(s, |seam| seam.misalignment.iter_mut().collect())),
        ("seam.jitter_s", |s| of_seam(s, |seam| vec![&mut seam.jitter])),
        ("seam.hidden_delay_s", |s| of_seam(s, |seam| vec![&mut seam.hidden_delay])),
    ];
}

impl InputFile for Sensors {
    const KIND: FileKind = FileKind::Sensors;

    fn from_root(root: &TomlTable<'_>) -> Result<Self, InputError> {
        root.only(&["schema", "seed", "encoder", "torque", "force", "seam"])?;
        let seed = root.integer("seed")?;
        let encoder = root.table("encoder")?;
        encoder.only(&["resolution_rad"])?;
        let force = root.table("force")?;
        force.only(&[
            "noise_n",
            "noise_nm",
            "filter_hz",
            "delay_s",
            "resolution_n",
            "range_n",
            "range_nm",
            "disagreement_n",
            "zero_nm",
            "misalignment_rad",
            "jitter_s",
        ])?;
        Ok(Self {
            encoder_resolution: encoder.quantities("resolution_rad")?,
            torque_noise: if root.has("torque") {
                let torque = root.table("torque")?;
                torque.only(&["noise_nm"])?;
                torque.quantities("noise_nm")?
            } else {
                [0.0; 6]
            },
            force: ForceSensor {
                noise_force: force.quantity("noise_n")?,
                noise_moment: force.quantity("noise_nm")?,
                filter: force.quantity("filter_hz")?,
                delay: force.quantity("delay_s")?,
                resolution: force.quantity("resolution_n")?,
                limits: ForceSensorLimits {
                    moment: optional(&force, "range_nm", 0.0)?,
                    force: optional(&force, "range_n", 0.0)?,
                    disagreement: optional(&force, "disagreement_n", 0.0)?,
                },
                zero_moment: errors(&force, "zero_nm")?,
                misalignment: errors(&force, "misalignment_rad")?,
                jitter: optional(&force, "jitter_s", 0.0)?,
            },
            seam: if root.has("seam") { Some(seam(&root.table("seam")?)?) } else { None },
            seed,
        })
    }
}

/// What a file may state of an instrument; `without` where it does not.
fn optional(table: &TomlTable<'_>, key: &str, without: f64) -> Result<f64, InputError> {
    if table.has(key) { table.quantity(key) } else { Ok(without) }
}

/// The same of three axes.
fn errors(table: &TomlTable<'_>, key: &str) -> Result<[f64; 3], InputError> {
    if table.has(key) { table.quantities(key) } else { Ok([0.0; 3]) }
}

fn seam(table: &TomlTable<'_>) -> Result<SeamSensor, InputError> {
    table.only(&[
        "ahead_m",
        "noise_m",
        "tilt_noise_rad",
        "period_s",
        "delay_s",
        "lost",
        "noise_factor",
        "zero_m",
        "tilt_zero_rad",
        "scale",
        "misalignment_rad",
        "jitter_s",
        "hidden_delay_s",
    ])?;
    Ok(SeamSensor {
        ahead: table.quantity("ahead_m")?,
        noise: table.quantity("noise_m")?,
        tilt_noise: table.quantity("tilt_noise_rad")?,
        period: table.quantity_as("period_s", "seam.period_s")?,
        delay: table.quantity_as("delay_s", "seam.delay_s")?,
        lost: table.quantity("lost")?,
        noise_factor: optional(table, "noise_factor", 1.0)?,
        zero: optional(table, "zero_m", 0.0)?,
        tilt_zero: optional(table, "tilt_zero_rad", 0.0)?,
        scale: optional(table, "scale", 0.0)?,
        misalignment: errors(table, "misalignment_rad")?,
        jitter: optional(table, "jitter_s", 0.0)?,
        hidden_delay: optional(table, "hidden_delay_s", 0.0)?,
    })
}
