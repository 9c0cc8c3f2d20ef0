//! From readings to the recorded table: faults of the sensors, noise, columns.

use crate::random;
use crate::recipe::Recipe;
use nalgebra::Vector3;
use std::fmt::Write as _;
use std::path::Path;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::write_atomically;
use trueweld_plant::random::Random;
use trueweld_plant::robot::Readings;

/// What was done in a log.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LogKind {
    Static,
    Ring,
    Free,
    Weld,
}

impl LogKind {
    fn name(self) -> &'static str {
        match self {
            Self::Static => "static-load",
            Self::Ring => "ring-down",
            Self::Free => "free-motion",
            Self::Weld => "weld",
        }
    }

    /// Time between rows, s, where it is even.
    pub fn period(self) -> Option<f64> {
        match self {
            Self::Static => None,
            Self::Ring => Some(0.001),
            Self::Free => Some(0.004),
            Self::Weld => Some(0.012),
        }
    }

    /// Columns that are set rather than read by an instrument, and their digits: the payload and
    /// its centre; the spindle speed.
    fn given(self) -> (&'static [&'static str], usize) {
        match self {
            Self::Static => (&["payload_kg", "cx_m", "cy_m", "cz_m"], 4),
            Self::Weld => (&["spindle_rad_s"], 5),
            Self::Ring | Self::Free => (&[], 0),
        }
    }
}

/// What an instrument reads.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Encoder,
    LinkEncoder,
    MotorTorque,
    Force,
    Moment,
    Position,
    Rotation,
}

/// One instrument: its columns, and its noise as `log.toml` states it.
struct Instrument {
    quantity: Quantity,
    columns: &'static [&'static str],
    digits: usize,
    noise_key: &'static str,
    /// Standard deviation of the noise, in the unit of the columns: about that of a thousand shots
    /// of a laser tracker, and of an average of the others at rest.
    deviation: f64,
    logs: &'static [LogKind],
}

/// The instruments, in the order of their columns.
const INSTRUMENTS: [Instrument; 7] = {
    use LogKind::{Free, Ring, Static, Weld};
    [
        Instrument {
            quantity: Quantity::Encoder,
            columns: &["qe1_rad", "qe2_rad", "qe3_rad", "qe4_rad", "qe5_rad", "qe6_rad"],
            digits: 8,
            noise_key: "encoder_rad",
            deviation: 2e-6,
            logs: &[Static, Ring, Free, Weld],
        },
        Instrument {
            quantity: Quantity::LinkEncoder,
            columns: &["ql1_rad", "ql2_rad", "ql3_rad"],
            digits: 8,
            noise_key: "link_encoder_rad",
            deviation: 5e-6,
            logs: &[Free],
        },
        Instrument {
            quantity: Quantity::MotorTorque,
            columns: &["tm1_nm", "tm2_nm", "tm3_nm", "tm4_nm", "tm5_nm", "tm6_nm"],
            digits: 2,
            noise_key: "motor_torque_nm",
            deviation: 40.0,
            logs: &[Free],
        },
        Instrument {
            quantity: Quantity::Force,
            columns: &["fx_n", "fy_n", "fz_n"],
            digits: 2,
            noise_key: "force_n",
            deviation: 25.0,
            logs: &[Static, Weld],
        },
        Instrument {
            quantity: Quantity::Moment,
            columns: &["mx_nm", "my_nm", "mz_nm"],
            digits: 2,
            noise_key: "moment_nm",
            deviation: 8.0,
            logs: &[Static, Weld],
        },
        Instrument {
            quantity: Quantity::Position,
            columns: &["px_m", "py_m", "pz_m"],
            digits: 7,
            noise_key: "tcp_position_m",
            deviation: 30e-6,
            logs: &[Static, Ring, Free, Weld],
        },
        Instrument {
            quantity: Quantity::Rotation,
            columns: &["rx_rad", "ry_rad", "rz_rad"],
            digits: 7,
            noise_key: "tcp_rotation_rad",
            deviation: 50e-6,
            logs: &[Static, Free, Weld],
        },
    ]
};

/// A log being recorded.
#[derive(Debug)]
pub(crate) struct SampleTable {
    kind: LogKind,
    random: Random,
    /// Factor on the noise of every instrument.
    noise: f64,
    noise_stated: bool,
    text: String,
}

impl SampleTable {
    /// An empty table of the log with this number.
    pub fn new(kind: LogKind, recipe: &Recipe, log: u64) -> Self {
        let mut columns = vec!["t_s"];
        for instrument in Self::instruments(kind) {
            columns.extend(instrument.columns);
        }
        columns.extend(kind.given().0);
        Self {
            kind,
            random: Random::new(recipe.seed, random::NOISE + log),
            noise: recipe.noise,
            noise_stated: recipe.noise_stated,
            text: columns.join(",") + "\n",
        }
    }

    fn instruments(kind: LogKind) -> impl Iterator<Item = &'static Instrument> {
        INSTRUMENTS.iter().filter(move |i| i.logs.contains(&kind))
    }

    /// Records one row: `readings` without noise, and the columns that no instrument reads.
    pub fn record(&mut self, cell: &Cell, mut readings: Readings, given: &[f64]) {
        cell.robot.ports.sense(&mut readings);
        self.put(format_args!("{:.3}", readings.time));
        for instrument in Self::instruments(self.kind) {
            let values = match instrument.quantity {
                Quantity::Encoder => readings.encoder.as_slice(),
                Quantity::LinkEncoder => readings.link_encoder.as_slice(),
                Quantity::MotorTorque => readings.motor_torque.as_slice(),
                Quantity::Force => readings.force.as_slice(),
                Quantity::Moment => readings.moment.as_slice(),
                Quantity::Position => readings.tcp_position.as_slice(),
                Quantity::Rotation => readings.tcp_rotation.as_slice(),
            };
            let deviation = self.noise * instrument.deviation;
            let mut noisy = [0.0; 6];
            let count = instrument.columns.len();
            for (noisy, value) in noisy.iter_mut().zip(values).take(count) {
                let exact = if instrument.quantity == Quantity::Rotation { 0.0 } else { *value };
                *noisy = exact + deviation * self.random.normal();
            }
            if instrument.quantity == Quantity::Rotation {
                // The noise is a small rotation of the tool in its own axes.
                let error = rotation_from_vector(&Vector3::from_column_slice(&noisy[..3]));
                let turned = rotation_from_vector(&readings.tcp_rotation) * error;
                noisy[..3].copy_from_slice(rotation_vector(&turned).as_slice());
            }
            for value in &noisy[..count] {
                self.put(format_args!(",{value:.digits$}", digits = instrument.digits));
            }
        }
        for value in given {
            self.put(format_args!(",{value:.digits$}", digits = self.kind.given().1));
        }
        self.put(format_args!("\n"));
    }

    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        self.text.write_fmt(text).expect("a string takes all");
    }

    /// Writes the log's folder. `references` are further lines of its `log.toml`.
    pub fn write(&self, folder: &Path, references: &str) -> std::io::Result<()> {
        std::fs::create_dir_all(folder)?;
        let mut log = format!(
            "schema = \"log/1\"\nkind = \"{}\"\nrobot = \"../robot.toml\"\n{references}",
            self.kind.name()
        );
        if let Some(period) = self.kind.period() {
            log += &format!("period_s = {period:?}\n");
        }
        // A log without noise states none: residuals cannot be weighed by a deviation of zero.
        if self.noise_stated && self.noise > 0.0 {
            log += "\n[noise]\n";
            for instrument in Self::instruments(self.kind) {
                let deviation = self.noise * instrument.deviation;
                log += &format!("{} = {deviation:?}\n", instrument.noise_key);
            }
        }
        write_atomically(folder.join("log.toml"), log.as_bytes())?;
        write_atomically(folder.join("samples.csv"), self.text.as_bytes())
    }
}
