//! The seam sensor: a laser line across the seam ahead of the tool, noisy, late, with lost
//! readings. Seeded.

use crate::input::SeamSensor;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;
use trueweld_core::Twist;
use trueweld_core::compensation::DeviationMeasurement;

/// Its stream of random numbers: that of the robot's own instruments stays what it was without it.
const SEAM_SENSOR_STREAM: u64 = 1;

/// Stream of the numbers of what a sensor file may leave out.
const SEAM_SENSOR_ERROR_STREAM: u64 = 4;

/// The seam sensor of one run.
#[derive(Debug)]
pub struct SeamSensing {
    sensor: SeamSensor,
    random: ChaCha8Rng,
    /// Of what a sensor file may leave out.
    errors: ChaCha8Rng,
    /// Readings taken and not yet given.
    taken: VecDeque<Taken>,
    next: f64,
}

/// One reading: when it was taken and when it is given, s, and what it shows across the seam, m,
/// and in tilt, rad.
#[derive(Debug, Clone, Copy)]
struct Taken {
    at: f64,
    given: f64,
    values: [f64; 2],
}

impl SeamSensing {
    /// A sensor whose noise starts at `seed`.
    pub fn new(sensor: &SeamSensor, seed: u64) -> Self {
        let stream = |stream| {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            random.set_stream(stream);
            random
        };
        Self {
            sensor: sensor.clone(),
            random: stream(SEAM_SENSOR_STREAM),
            errors: stream(SEAM_SENSOR_ERROR_STREAM),
            taken: VecDeque::new(),
            next: 0.0,
        }
    }

    /// How far ahead of the tool it looks, m.
    pub fn ahead(&self) -> f64 {
        self.sensor.ahead
    }

    /// What reaches the controller at `time`, s. `deviation`: of the real tool from its nominal
    /// pose, axes of W. `bend`: how far across the seam lies where the sensor looks, m, beyond what
    /// the controller knows of its shape.
    pub fn read(
        &mut self,
        time: f64,
        deviation: &Twist<f64>,
        bend: f64,
    ) -> Vec<DeviationMeasurement<f64>> {
        const CLOCK_ROUNDING: f64 = 1e-9;
        let s = &self.sensor;
        if time + CLOCK_ROUNDING >= self.next {
            self.next += s.period;
            let across = deviation.linear.y + s.ahead * deviation.angular.z - bend;
            let [about_x, _, about_z] = s.misalignment;
            let mounted = about_x * deviation.linear.z + about_z * s.ahead + s.zero;
            let seen =
                [across * (1.0 + s.scale) + mounted, deviation.angular.x + (about_x + s.tilt_zero)];
            let noisy = [s.noise, s.tilt_noise].map(|deviation| {
                let unit: f64 = StandardNormal.sample(&mut self.random);
                deviation * s.noise_factor * unit
            });
            let mut given = time + s.delay + s.hidden_delay;
            if s.jitter > 0.0 {
                given += s.jitter * self.errors.random::<f64>();
            }
            let lost = self.random.random::<f64>() < s.lost;
            if !lost {
                let values = [seen[0] + noisy[0], seen[1] + noisy[1]];
                self.taken.push_back(Taken { at: time, given, values });
            }
        }
        let across = Twist { angular: Vector3::z() * s.ahead, linear: Vector3::y() };
        let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
        let mut arrived = Vec::new();
        while let Some(Taken { at, values, .. }) =
            self.taken.front().copied().filter(|taken| taken.given <= time + CLOCK_ROUNDING)
        {
            self.taken.pop_front();
            for (deviation, along, noise) in
                [(values[0], across, s.noise), (values[1], tilted, s.tilt_noise)]
            {
                arrived.push(DeviationMeasurement {
                    deviation,
                    along,
                    noise,
                    age: time - at - s.hidden_delay,
                    ahead: s.ahead,
                });
            }
        }
        arrived
    }
}
