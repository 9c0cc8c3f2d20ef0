//! The sensors: one file each, and the table of them. Encoders with their step, the motor torques, a
//! force sensor with filter, delay, noise and step, the seam sensor; beside them what an instrument
//! gives while it is faulty. Seeded.
//!
//! A sensor's file holds its table of the sensor file, its numbers, and how it reads. To add one, write
//! its file, and its line in the table below; one that measures the deviation from outside the robot
//! reaches every law from there. What an effect does to a channel enters at the ports `SensorChannel`
//! and `TimeBase`. The tracker and the link encoders are not instruments of the robot's controller; a
//! log's reader compares with them.

mod encoders;
mod fault;
mod force;
mod model;
mod seam;
mod torque;

pub(crate) use fault::visit_measurements;
pub use fault::{Failure, FaultyInstruments, Instrument, InstrumentFault, fault_name};
pub(crate) use model::ideal;
pub use model::{BuildSensor, DeviationSensor, SensorEntry, SensorNumber};

use crate::input::Sensors;
use crate::random::visit_stream;
use crate::robot::{Channel, Ports, Readings};
use encoders::Encoders;
use force::ForceSensing;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use std::sync::LazyLock;
use trueweld_core::control::SensorReadings;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{JointVector, Wrench};

/// The sensors, in the order of a sensor file: one line each.
static SENSORS: &[&SensorEntry] =
    &[&encoders::ENCODERS, &torque::MOTOR_TORQUE, &force::FORCE_SENSOR, &seam::SEAM_SENSOR];

/// Every sensor that there is.
pub fn sensors() -> &'static [&'static SensorEntry] {
    SENSORS
}

/// Every number that a sensor file states, by table and key.
pub fn sensor_numbers() -> &'static [SensorNumber] {
    static NUMBERS: LazyLock<Vec<SensorNumber>> =
        LazyLock::new(|| SENSORS.iter().flat_map(|sensor| sensor.numbers).copied().collect());
    &NUMBERS
}

/// The sensors of a run that measure the deviation from outside the robot.
pub fn outside(sensors: &Sensors, seed: u64) -> Vec<Box<dyn DeviationSensor>> {
    let builders = SENSORS.iter().filter_map(|sensor| sensor.outside);
    builders.filter_map(|build| build(sensors, seed)).collect()
}

/// True where a run has such a sensor.
pub fn sees_deviation(sensors: &Sensors) -> bool {
    !outside(sensors, 0).is_empty()
}

/// Stream of the random numbers of what a sensor file may leave out: what it states is drawn as it
/// was without.
const SENSOR_ERROR_STREAM: u64 = 3;

/// The robot's own instruments in one run.
#[derive(Debug, Clone)]
pub struct Instruments {
    torque_noise: [f64; 6],
    noise: ChaCha8Rng,
    errors: ChaCha8Rng,
    encoders: Encoders,
    force: ForceSensing,
}

impl Instruments {
    /// Instruments sampled every `step` s and read every `period` s. `seed` starts the noise.
    pub fn new(sensors: &Sensors, ports: &Ports, step: f64, period: f64, seed: u64) -> Self {
        let mut errors = ChaCha8Rng::seed_from_u64(seed);
        errors.set_stream(SENSOR_ERROR_STREAM);
        Self {
            torque_noise: sensors.torque_noise,
            noise: ChaCha8Rng::seed_from_u64(seed),
            errors,
            encoders: Encoders::new(sensors.encoder_resolution, period),
            force: ForceSensing::new(&sensors.force, ports.delay(Channel::Wrench), step),
        }
    }

    /// Takes the true wrench on the tool, in T, once a plant step.
    pub fn observe(&mut self, wrench_in_t: &Wrench<f64>) {
        self.force.observe(wrench_in_t);
    }

    /// What the controller gets at this instant. `truth`: the undisturbed readings; its wrench is
    /// replaced by the filtered and delayed one. `torque`: Γ of the last period, N·m.
    pub fn read(
        &mut self,
        ports: &Ports,
        mut truth: Readings,
        torque: &JointVector<f64>,
    ) -> SensorReadings<f64> {
        let wrench = Wrench::from_vector(&self.force.delayed(&mut self.errors));
        (truth.force, truth.moment) = (wrench.force, wrench.moment);
        truth.motor_torque = (*torque).into();
        ports.sense(&mut truth);
        self.force.mounted(&mut [&mut truth.force, &mut truth.moment]);
        torque::add_noise(&mut truth.motor_torque, &self.torque_noise, &mut self.errors);
        let [encoder, encoder_rate] = self.encoders.read(&truth.encoder);
        let wrench = Wrench { moment: truth.moment, force: truth.force };
        SensorReadings {
            encoder,
            encoder_rate,
            motor_torque: truth.motor_torque.into(),
            wrench: self.force.read(&wrench, &mut self.noise),
        }
    }
}

impl Stateful for Instruments {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visit_stream(&mut self.noise, visitor)?;
        visit_stream(&mut self.errors, visitor)?;
        self.encoders.visit_state(visitor)?;
        self.force.visit_state(visitor)
    }
}
