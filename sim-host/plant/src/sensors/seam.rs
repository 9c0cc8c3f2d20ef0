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
const STREAM: u64 = 1;

/// The seam sensor of one run.
#[derive(Debug)]
pub struct SeamSensing {
    sensor: SeamSensor,
    random: ChaCha8Rng,
    /// Readings taken and not yet given: when, across the seam, and tilt.
    taken: VecDeque<(f64, [f64; 2])>,
    next: f64,
}

impl SeamSensing {
    /// A sensor whose noise starts at `seed`.
    pub fn new(sensor: &SeamSensor, seed: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM);
        Self { sensor: sensor.clone(), random, taken: VecDeque::new(), next: 0.0 }
    }

    /// What reaches the controller at `time`, s. `deviation`: of the real tool from its nominal
    /// pose, axes of W.
    pub fn read(&mut self, time: f64, deviation: &Twist<f64>) -> Vec<DeviationMeasurement<f64>> {
        const INSTANT: f64 = 1e-9;
        let s = &self.sensor;
        if time + INSTANT >= self.next {
            self.next += s.period;
            let seen = [deviation.linear.y + s.ahead * deviation.angular.z, deviation.angular.x];
            let noisy = [s.noise, s.tilt_noise].map(|deviation| {
                let unit: f64 = StandardNormal.sample(&mut self.random);
                deviation * unit
            });
            let lost = self.random.random::<f64>() < s.lost;
            if !lost {
                self.taken.push_back((time, [seen[0] + noisy[0], seen[1] + noisy[1]]));
            }
        }
        let across = Twist { angular: Vector3::z() * s.ahead, linear: Vector3::y() };
        let tilted = Twist { angular: Vector3::x(), linear: Vector3::zeros() };
        let mut arrived = Vec::new();
        while let Some((taken, values)) =
            self.taken.front().copied().filter(|(at, _)| at + s.delay <= time + INSTANT)
        {
            self.taken.pop_front();
            for (deviation, along, noise) in
                [(values[0], across, s.noise), (values[1], tilted, s.tilt_noise)]
            {
                arrived.push(DeviationMeasurement {
                    deviation,
                    along,
                    noise,
                    age: time - taken,
                    ahead: s.ahead,
                });
            }
        }
        arrived
    }
}
