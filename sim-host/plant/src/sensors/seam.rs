//! The seam sensor: a laser line across the seam ahead of the tool, noisy, late, with lost
//! readings. Seeded.

use super::model::{DeviationSensor, SensorEntry, errors, of_seam};
use crate::input::{InputError, SeamSensor, Sensors, TomlTable};
use crate::random::visit_stream;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::collections::VecDeque;
use trueweld_core::Twist;
use trueweld_core::compensation::DeviationMeasurement;
use trueweld_core::state::{StateResult, StateVisitor};

/// Its stream of random numbers: that of the robot's own instruments stays what it was without it.
const SEAM_SENSOR_STREAM: u64 = 1;

/// Stream of the numbers of what a sensor file may leave out.
const SEAM_SENSOR_ERROR_STREAM: u64 = 4;

pub(super) static SEAM_SENSOR: SensorEntry = SensorEntry {
    name: "seam",
    about: "How far the tool is beside the seam and tilted across it, ahead of the tool.",
    optional: true,
    read,
    numbers: &[
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
    ],
    outside: Some(|sensors, seed| {
        let sensor = sensors.seam.as_ref()?;
        Some(Box::new(SeamSensing::new(sensor, seed)))
    }),
};

fn read(table: &TomlTable<'_>, sensors: &mut Sensors) -> Result<(), InputError> {
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
    sensors.seam = Some(SeamSensor {
        ahead: table.quantity("ahead_m")?,
        noise: table.quantity("noise_m")?,
        tilt_noise: table.quantity("tilt_noise_rad")?,
        period: table.quantity_as("period_s", "seam.period_s")?,
        delay: table.quantity_as("delay_s", "seam.delay_s")?,
        lost: table.quantity("lost")?,
        noise_factor: table.quantity_or("noise_factor", 1.0)?,
        zero: table.quantity_or("zero_m", 0.0)?,
        tilt_zero: table.quantity_or("tilt_zero_rad", 0.0)?,
        scale: table.quantity_or("scale", 0.0)?,
        misalignment: errors(table, "misalignment_rad")?,
        jitter: table.quantity_or("jitter_s", 0.0)?,
        hidden_delay: table.quantity_or("hidden_delay_s", 0.0)?,
    });
    Ok(())
}

/// The seam sensor of one run.
#[derive(Debug, Clone)]
struct SeamSensing {
    sensor: SeamSensor,
    random: ChaCha8Rng,
    /// Of what a sensor file may leave out.
    errors: ChaCha8Rng,
    /// Readings taken and not yet given.
    taken: VecDeque<Taken>,
    next: f64,
}

/// Readings that a state may have on their way to the controller: more than any delay holds back.
const MOST_WAITING: usize = 1 << 16;

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
    fn new(sensor: &SeamSensor, seed: u64) -> Self {
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
}

impl DeviationSensor for SeamSensing {
    fn copied(&self) -> Box<dyn DeviationSensor> {
        Box::new(self.clone())
    }

    fn ahead(&self) -> f64 {
        self.sensor.ahead
    }

    fn read(
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
                    // Rounding must not make it younger than now.
                    age: (time - at - s.hidden_delay).max(0.0),
                    ahead: s.ahead,
                });
            }
        }
        arrived
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visit_stream(&mut self.random, visitor)?;
        visit_stream(&mut self.errors, visitor)?;
        visitor.scalar(&mut self.next)?;
        let length = visitor.length(self.taken.len(), MOST_WAITING)?;
        self.taken.resize(length, Taken { at: 0.0, given: 0.0, values: [0.0; 2] });
        self.taken.iter_mut().try_for_each(|taken| {
            visitor.scalars([&mut taken.at, &mut taken.given])?;
            visitor.scalars(&mut taken.values)
        })
    }
}
