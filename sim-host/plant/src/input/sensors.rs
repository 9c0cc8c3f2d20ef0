//! What the controller's sensors add to the truth.

use std::collections::BTreeMap;
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
    /// Of any further sensor that the file has: its numbers by their keys.
    pub others: BTreeMap<&'static str, BTreeMap<&'static str, Vec<f64>>>,
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
