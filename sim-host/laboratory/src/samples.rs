//! From readings to the recorded table: faults of the sensors, noise, columns.

use crate::instruments::{
    INSTRUMENTS, InstrumentNoise, ReadQuantity, SimulatedInstrument, SimulatedLogKind,
};
use crate::random;
use crate::recipe::Recipe;
use nalgebra::{Matrix3, Matrix6, SMatrix, Vector3};
use std::fmt::Write as _;
use std::path::Path;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector, skew};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::write_atomically;
use trueweld_plant::random::Random;
use trueweld_plant::robot::Readings;

/// Columns of the reflectors' points.
const REFLECTOR_COLUMNS: [&str; 9] = [
    "reflector1_x",
    "reflector1_y",
    "reflector1_z",
    "reflector2_x",
    "reflector2_y",
    "reflector2_z",
    "reflector3_x",
    "reflector3_y",
    "reflector3_z",
];

/// Standard deviations of the rotation, rad, and of the position, m, of a tool whose pose follows from
/// three points in T, each coordinate seen to `point`, m: root mean squares over the axes.
fn pose_deviations(points: &[Vector3<f64>; 3], point: f64) -> [f64; 2] {
    let mut normal = Matrix6::<f64>::zeros();
    for at in points {
        let mut by_pose = SMatrix::<f64, 3, 6>::zeros();
        by_pose.fixed_columns_mut::<3>(0).copy_from(&-skew(at));
        by_pose.fixed_columns_mut::<3>(3).copy_from(&Matrix3::identity());
        normal += by_pose.tr_mul(&by_pose);
    }
    let covariance = normal.try_inverse().unwrap_or_else(Matrix6::identity);
    [0, 3].map(|first| {
        point * ((0..3).map(|k| covariance[(first + k, first + k)]).sum::<f64>() / 3.0).sqrt()
    })
}

/// A log being recorded.
#[derive(Debug)]
pub(crate) struct SampleTable {
    kind: SimulatedLogKind,
    random: Random,
    /// Factor on the noise of every instrument.
    noise: f64,
    noise_stated: bool,
    instruments: InstrumentNoise,
    /// Where the reflectors sit in T, m, where the log holds their points instead of a pose.
    reflectors: Option<[Vector3<f64>; 3]>,
    text: String,
}

impl SampleTable {
    /// An empty table of the log with this number.
    pub(crate) fn new(kind: SimulatedLogKind, recipe: &Recipe, log: u64) -> Self {
        let reflectors = recipe.reflectors.filter(|_| kind == SimulatedLogKind::Static);
        let mut columns = vec!["t_s"];
        for instrument in Self::instruments(kind) {
            columns.extend(match (instrument.quantity, reflectors) {
                (ReadQuantity::Position, Some(_)) => &REFLECTOR_COLUMNS,
                (ReadQuantity::Rotation, Some(_)) => [].as_slice(),
                _ => instrument.columns,
            });
        }
        columns.extend(kind.given().0);
        Self {
            instruments: recipe.instruments.clone(),
            reflectors,
            kind,
            random: Random::new(recipe.seed, random::NOISE_STREAM + log),
            noise: recipe.noise,
            noise_stated: recipe.noise_stated,
            text: columns.join(",") + "\n",
        }
    }

    fn instruments(kind: SimulatedLogKind) -> impl Iterator<Item = &'static SimulatedInstrument> {
        INSTRUMENTS.iter().filter(move |i| i.logs.contains(&kind))
    }

    /// Records one row: `readings` without noise, and the columns that no instrument reads.
    pub(crate) fn record(&mut self, cell: &Cell, mut readings: Readings, given: &[f64]) {
        cell.robot.ports.sense(&mut readings);
        self.put(format_args!("{:.3}", readings.time));
        for instrument in Self::instruments(self.kind) {
            let values = match instrument.quantity {
                ReadQuantity::Encoder => readings.encoder.as_slice(),
                ReadQuantity::LinkEncoder => readings.link_encoder.as_slice(),
                ReadQuantity::MotorTorque => readings.motor_torque.as_slice(),
                ReadQuantity::Force => readings.force.as_slice(),
                ReadQuantity::Moment => readings.moment.as_slice(),
                ReadQuantity::Position => readings.tcp_position.as_slice(),
                ReadQuantity::Rotation => readings.tcp_rotation.as_slice(),
            };
            let deviation = self.noise * self.instruments.of(instrument);
            if let Some(reflectors) = self.reflectors {
                match instrument.quantity {
                    ReadQuantity::Position => {
                        self.record_points(&readings, &reflectors, deviation, instrument.digits);
                        continue;
                    }
                    ReadQuantity::Rotation => continue,
                    _ => {}
                }
            }
            let mut noisy = [0.0; 6];
            let count = instrument.columns.len();
            for (noisy, value) in noisy.iter_mut().zip(values).take(count) {
                let exact =
                    if instrument.quantity == ReadQuantity::Rotation { 0.0 } else { *value };
                *noisy = exact + deviation * self.random.normal();
            }
            if instrument.quantity == ReadQuantity::Rotation {
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

    /// Records what the tracker sees of the reflectors.
    fn record_points(
        &mut self,
        readings: &Readings,
        reflectors: &[Vector3<f64>; 3],
        deviation: f64,
        digits: usize,
    ) {
        let rotation = rotation_from_vector(&readings.tcp_rotation);
        for reflector in reflectors {
            for exact in &(readings.tcp_position + rotation * reflector) {
                let noisy = exact + deviation * self.random.normal();
                self.put(format_args!(",{noisy:.digits$}"));
            }
        }
    }

    fn put(&mut self, text: std::fmt::Arguments<'_>) {
        self.text.write_fmt(text).expect("a string takes all");
    }

    /// Writes the log's folder. `references` are further lines of its `log.toml`.
    pub(crate) fn write(&self, folder: &Path, references: &str) -> std::io::Result<()> {
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
                let mut deviation = self.noise * self.instruments.of(instrument);
                if let Some(reflectors) = &self.reflectors {
                    let point = self.noise * self.instruments.of_quantity(ReadQuantity::Position);
                    let [rotation, position] = pose_deviations(reflectors, point);
                    match instrument.quantity {
                        ReadQuantity::Position => deviation = position,
                        ReadQuantity::Rotation => deviation = rotation,
                        _ => {}
                    }
                }
                log += &format!("{} = {deviation:?}\n", instrument.noise_key);
            }
        }
        if let Some(reflectors) = &self.reflectors {
            log += "\n[reflectors]\n";
            for (k, at) in reflectors.iter().enumerate() {
                log += &format!("reflector{}_m = [{:?}, {:?}, {:?}]\n", k + 1, at.x, at.y, at.z);
            }
            log += "\n[columns]\n";
            let header = self.text.lines().next().unwrap_or_default();
            for column in header.split(',') {
                let (channel, unit) = column.rsplit_once('_').unwrap_or((column, ""));
                let (channel, unit) = match unit {
                    // The axis is the end of a reflector's name, the unit is said here.
                    "x" | "y" | "z" => (column, "m"),
                    "nm" => (channel, "Nm"),
                    "n" => (channel, "N"),
                    other => (channel, other),
                };
                log += &format!("{column} = {{ channel = \"{channel}\", unit = \"{unit}\" }}\n");
            }
        }
        write_atomically(folder.join("log.toml"), log.as_bytes())?;
        write_atomically(folder.join("samples.csv"), self.text.as_bytes())
    }
}
