//! The robot's instruments: encoders with their step, and a force sensor with filter, delay, noise
//! and step; beside them the seam sensor, and what either gives while it is faulty. Seeded.
//!
//! What an effect does to a channel enters at the ports `SensorChannel` and `TimeBase`. The tracker
//! and the link encoders are not instruments of the robot's controller; a log's reader compares
//! with them.

mod fault;
mod seam;

pub use fault::{Failure, FaultyInstruments, Instrument, InstrumentFault, fault_name};
pub use seam::SeamSensing;

use crate::input::Sensors;
use crate::robot::{Channel, Ports, Readings};
use nalgebra::{Matrix3, SVector, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;
use trueweld_core::control::SensorReadings;
use trueweld_core::filter::{Biquad, FilterBank};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{JointVector, Wrench};

/// Stream of the random numbers of what a sensor file may leave out: what it states is drawn as it
/// was without.
const SENSOR_ERROR_STREAM: u64 = 3;

/// The instruments of one run.
#[derive(Debug)]
pub struct Instruments {
    sensors: Sensors,
    noise: ChaCha8Rng,
    errors: ChaCha8Rng,
    /// From axes of T to those of a force sensor that is mounted off.
    sensor_from_t: Option<Matrix3<f64>>,
    step: f64,
    filter: Option<FilterBank<Biquad<f64>, 6>>,
    /// Filtered wrenches, newest last, one a plant step, as far back as the delay reaches.
    line: VecDeque<SVector<f64, 6>>,
    /// Delay in plant steps.
    delay: f64,
    period: f64,
    encoder: Option<JointVector<f64>>,
}

impl Instruments {
    /// Instruments sampled every `step` s and read every `period` s. `seed` starts the noise.
    ///
    /// A filter whose corner lies above half the plant's sampling rate passes everything and is
    /// left out.
    pub fn new(sensors: &Sensors, ports: &Ports, step: f64, period: f64, seed: u64) -> Self {
        let corner = sensors.force.filter;
        let misalignment = Vector3::from(sensors.force.misalignment);
        let mut errors = ChaCha8Rng::seed_from_u64(seed);
        errors.set_stream(SENSOR_ERROR_STREAM);
        Self {
            noise: ChaCha8Rng::seed_from_u64(seed),
            errors,
            sensor_from_t: (misalignment != Vector3::zeros())
                .then(|| rotation_from_vector(&misalignment).transpose()),
            step,
            filter: Biquad::low_pass(corner, step).map(FilterBank::new),
            line: VecDeque::new(),
            delay: (sensors.force.delay + ports.delay(Channel::Wrench)).max(0.0) / step,
            period,
            encoder: None,
            sensors: sensors.clone(),
        }
    }

    /// Takes the true wrench on the tool, in T, once a plant step.
    pub fn observe(&mut self, wrench_in_t: &Wrench<f64>) {
        let wrench = wrench_in_t.to_vector();
        let filtered = match &mut self.filter {
            Some(filter) => {
                if self.line.is_empty() {
                    filter.initialize(&wrench);
                }
                filter.update(&wrench)
            }
            None => wrench,
        };
        self.line.push_back(filtered);
        let oldest = self.delay + self.sensors.force.jitter / self.step;
        while self.line.len() > oldest.ceil() as usize + 1 {
            self.line.pop_front();
        }
    }

    /// What the controller gets at this instant. `truth`: the undisturbed readings; its wrench is
    /// replaced by the filtered and delayed one. `torque`: Γ of the last period, N·m.
    pub fn read(
        &mut self,
        ports: &Ports,
        mut truth: Readings,
        torque: &JointVector<f64>,
    ) -> SensorReadings<f64> {
        let wrench = Wrench::from_vector(&self.delayed());
        (truth.force, truth.moment) = (wrench.force, wrench.moment);
        truth.motor_torque = (*torque).into();
        ports.sense(&mut truth);
        if let Some(turn) = &self.sensor_from_t {
            (truth.force, truth.moment) = (turn * truth.force, turn * truth.moment);
        }
        for (torque, noise) in truth.motor_torque.iter_mut().zip(&self.sensors.torque_noise) {
            if *noise > 0.0 {
                let unit: f64 = StandardNormal.sample(&mut self.errors);
                *torque += noise * unit;
            }
        }
        let resolution = &self.sensors.encoder_resolution;
        let encoder = JointVector::from_fn(|i, _| stepped(truth.encoder[i], resolution[i]));
        let rate =
            self.encoder.map_or(JointVector::zeros(), |before| (encoder - before) / self.period);
        self.encoder = Some(encoder);
        let force = &self.sensors.force;
        let noise = &mut self.noise;
        let mut noisy = |value: f64, deviation: f64| {
            let unit: f64 = StandardNormal.sample(noise);
            value + deviation * unit
        };
        let wrench = Wrench {
            force: truth.force.map(|v| {
                let read = stepped(noisy(v, force.noise_force), force.resolution);
                saturated(read, force.limits.force)
            }),
            moment: (truth.moment.map(|v| noisy(v, force.noise_moment))
                + Vector3::from(force.zero_moment))
            .map(|v| saturated(v, force.limits.moment)),
        };
        SensorReadings {
            encoder,
            encoder_rate: rate,
            motor_torque: truth.motor_torque.into(),
            wrench,
        }
    }

    /// The wrench of `delay` steps ago, interpolated between samples; the oldest there is until the
    /// line has filled.
    fn delayed(&mut self) -> SVector<f64, 6> {
        let mut delay = self.delay;
        if self.sensors.force.jitter > 0.0 {
            delay += self.errors.random::<f64>() * self.sensors.force.jitter / self.step;
        }
        let at = |steps: usize| {
            let last = self.line.len().saturating_sub(1);
            self.line.get(last.saturating_sub(steps)).copied().unwrap_or_else(SVector::zeros)
        };
        let whole = delay.floor();
        let part = delay - whole;
        at(whole as usize) * (1.0 - part) + at(whole as usize + 1) * part
    }
}

/// The value within an instrument's range; 0 is no end.
fn saturated(value: f64, range: f64) -> f64 {
    if range > 0.0 { value.clamp(-range, range) } else { value }
}

/// The value on an instrument's grid; 0 is a grid without steps.
fn stepped(value: f64, resolution: f64) -> f64 {
    if resolution > 0.0 { (value / resolution).round() * resolution } else { value }
}
