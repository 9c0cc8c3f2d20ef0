//! What a sensor is to the rest of the plant: a line of the table.

use crate::input::{ForceSensor, InputError, SeamSensor, Sensors, TomlTable};
use std::collections::BTreeMap;
use trueweld_core::Twist;
use trueweld_core::compensation::DeviationMeasurement;
use trueweld_core::control::ForceSensorLimits;
use trueweld_core::state::{StateResult, StateVisitor};

/// A number of the sensors by its table and key: one place, or one for every joint or axis. None
/// where the cell has no such sensor.
pub type SensorNumber = (&'static str, fn(&mut Sensors) -> Vec<&mut f64>);

/// One sensor of the table.
pub struct SensorEntry {
    /// Its table in a sensor file.
    pub name: &'static str,
    /// What it reads, and what is wrong with its readings.
    pub about: &'static str,
    /// True for one that a cell may lack.
    pub optional: bool,
    /// Reads its table.
    pub read: fn(table: &TomlTable<'_>, sensors: &mut Sensors) -> Result<(), InputError>,
    /// Every number that its table states.
    pub numbers: &'static [SensorNumber],
    /// For one that measures the tool's deviation from outside the robot: the sensor of a run, where
    /// the cell has it, with noise that begins at a seed.
    pub outside: Option<BuildSensor>,
}

/// Makes the sensor of a run, where the cell has it, with noise that begins at a seed.
pub type BuildSensor = fn(sensors: &Sensors, seed: u64) -> Option<Box<dyn DeviationSensor>>;

/// A sensor that measures the tool's deviation from outside the robot.
pub trait DeviationSensor: std::fmt::Debug + Send + Sync {
    /// The same sensor in the same state: it is copied with a run in progress.
    fn copied(&self) -> Box<dyn DeviationSensor>;

    /// How far ahead of the tool it looks, m.
    fn ahead(&self) -> f64 {
        0.0
    }

    /// What reaches the controller at `time`, s. `deviation`: of the real tool from its nominal
    /// pose, axes of W. `bend`: how far across the seam lies where the sensor looks, m, beyond what
    /// the controller knows of its shape.
    fn read(
        &mut self,
        time: f64,
        deviation: &Twist<f64>,
        bend: f64,
    ) -> Vec<DeviationMeasurement<f64>>;

    /// Shows its state, as [`Stateful`](trueweld_core::state::Stateful) does.
    ///
    /// # Errors
    /// [`StateError`](trueweld_core::state::StateError).
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult;
}

impl Clone for Box<dyn DeviationSensor> {
    fn clone(&self) -> Self {
        (**self).copied()
    }
}

/// A sensor file before the sensors' tables are read: all ideal, and no seam sensor.
pub(crate) fn ideal(seed: u64) -> Sensors {
    Sensors {
        encoder_resolution: [0.0; 6],
        torque_noise: [0.0; 6],
        force: ForceSensor {
            noise_force: 0.0,
            noise_moment: 0.0,
            filter: 0.0,
            delay: 0.0,
            resolution: 0.0,
            limits: ForceSensorLimits { moment: 0.0, force: 0.0, disagreement: 0.0 },
            zero_moment: [0.0; 3],
            misalignment: [0.0; 3],
            jitter: 0.0,
        },
        seam: None,
        others: BTreeMap::new(),
        seed,
    }
}

/// What a file may state of three axes of an instrument; zeros where it does not.
pub(super) fn errors(table: &TomlTable<'_>, key: &str) -> Result<[f64; 3], InputError> {
    if table.has(key) { table.quantities(key) } else { Ok([0.0; 3]) }
}

/// Numbers of the seam sensor, where the cell has one.
pub(super) fn of_seam<'s>(
    sensors: &'s mut Sensors,
    number: impl Fn(&'s mut SeamSensor) -> Vec<&'s mut f64>,
) -> Vec<&'s mut f64> {
    sensors.seam.as_mut().map_or(Vec::new(), number)
}

/// The value on an instrument's grid; 0 is a grid without steps.
pub(super) fn stepped(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (value / resolution).round() * resolution } else { value }
}
