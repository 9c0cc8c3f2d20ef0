//! The force/torque sensor between flange and tool: filter, delay, mounting, noise, step and range.

use super::model::{SensorEntry, errors, stepped};
use crate::input::{ForceSensor, InputError, Sensors, TomlTable};
use nalgebra::{Matrix3, SVector, Vector3};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;
use trueweld_core::Wrench;
use trueweld_core::control::ForceSensorLimits;
use trueweld_core::filter::{Biquad, FilterBank};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::state::{StateResult, StateVisitor, Stateful};

pub(super) static FORCE_SENSOR: SensorEntry = SensorEntry {
    name: "force",
    about: "Wrench on the tool, filtered, late and noisy, within a range.",
    optional: false,
    read,
    numbers: &[
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
    ],
    outside: None,
};

fn read(table: &TomlTable<'_>, sensors: &mut Sensors) -> Result<(), InputError> {
    table.only(&[
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
    sensors.force = ForceSensor {
        noise_force: table.quantity("noise_n")?,
        noise_moment: table.quantity("noise_nm")?,
        filter: table.quantity("filter_hz")?,
        delay: table.quantity("delay_s")?,
        resolution: table.quantity("resolution_n")?,
        limits: ForceSensorLimits {
            moment: table.quantity_or("range_nm", 0.0)?,
            force: table.quantity_or("range_n", 0.0)?,
            disagreement: table.quantity_or("disagreement_n", 0.0)?,
        },
        zero_moment: errors(table, "zero_nm")?,
        misalignment: errors(table, "misalignment_rad")?,
        jitter: table.quantity_or("jitter_s", 0.0)?,
    };
    Ok(())
}

/// The force sensor of one run.
#[derive(Debug, Clone)]
pub(super) struct ForceSensing {
    sensor: ForceSensor,
    /// From axes of T to those of a sensor that is mounted off.
    sensor_from_t: Option<Matrix3<f64>>,
    step: f64,
    filter: Option<FilterBank<Biquad<f64>, 6>>,
    /// Filtered wrenches, newest last, one a plant step, as far back as the delay reaches.
    line: VecDeque<SVector<f64, 6>>,
    /// Delay in plant steps.
    delay: f64,
}

impl ForceSensing {
    /// Sampled every `step` s, and `late` s later than the sensor states.
    ///
    /// A filter whose corner lies above half the plant's sampling rate passes everything and is
    /// left out.
    pub(super) fn new(sensor: &ForceSensor, late: f64, step: f64) -> Self {
        let misalignment = Vector3::from(sensor.misalignment);
        Self {
            sensor_from_t: (misalignment != Vector3::zeros())
                .then(|| rotation_from_vector(&misalignment).transpose()),
            step,
            filter: Biquad::low_pass(sensor.filter, step).map(FilterBank::new),
            line: VecDeque::new(),
            delay: (sensor.delay + late).max(0.0) / step,
            sensor: sensor.clone(),
        }
    }

    /// Takes the true wrench on the tool, in T, once a plant step.
    pub(super) fn observe(&mut self, wrench_in_t: &Wrench<f64>) {
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
        while self.line.len() > self.room() {
            self.line.pop_front();
        }
    }

    /// Samples as far back as the longest delay reaches.
    fn room(&self) -> usize {
        let oldest = self.delay + self.sensor.jitter / self.step;
        oldest.ceil() as usize + 1
    }

    /// The wrench of `delay` steps ago, interpolated between samples; the oldest there is until the
    /// line has filled. `random`: of the jitter.
    pub(super) fn delayed(&self, random: &mut ChaCha8Rng) -> SVector<f64, 6> {
        let mut delay = self.delay;
        if self.sensor.jitter > 0.0 {
            delay += random.random::<f64>() * self.sensor.jitter / self.step;
        }
        let at = |steps: usize| {
            let last = self.line.len().saturating_sub(1);
            self.line.get(last.saturating_sub(steps)).copied().unwrap_or_else(SVector::zeros)
        };
        let whole = delay.floor();
        let part = delay - whole;
        at(whole as usize) * (1.0 - part) + at(whole as usize + 1) * part
    }

    /// A wrench in axes of T in those of the sensor.
    pub(super) fn mounted(&self, wrench: &mut [&mut Vector3<f64>; 2]) {
        if let Some(turn) = &self.sensor_from_t {
            wrench.iter_mut().for_each(|vector| **vector = turn * **vector);
        }
    }

    /// What it reads of a wrench in its axes. `random`: of the noise.
    pub(super) fn read(&self, truth: &Wrench<f64>, random: &mut ChaCha8Rng) -> Wrench<f64> {
        let sensor = &self.sensor;
        let mut noisy = |value: f64, deviation: f64| {
            let unit: f64 = StandardNormal.sample(random);
            value + deviation * unit
        };
        Wrench {
            force: truth.force.map(|v| {
                let read = stepped(noisy(v, sensor.noise_force), sensor.resolution);
                saturated(read, sensor.limits.force)
            }),
            moment: (truth.moment.map(|v| noisy(v, sensor.noise_moment))
                + Vector3::from(sensor.zero_moment))
            .map(|v| saturated(v, sensor.limits.moment)),
        }
    }
}

impl Stateful for ForceSensing {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        if let Some(filter) = &mut self.filter {
            filter.visit_state(visitor)?;
        }
        let length = visitor.length(self.line.len(), self.room())?;
        self.line.resize(length, SVector::zeros());
        self.line.iter_mut().try_for_each(|wrench| visitor.matrix(wrench))
    }
}

/// The value within an instrument's range; 0 is no end.
fn saturated(value: f64, range: f64) -> f64 {
    if range > 0.0 { value.clamp(-range, range) } else { value }
}
