//! The motor torques as the drives report them, noisy.

use super::model::SensorEntry;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

pub(super) static MOTOR_TORQUE: SensorEntry = SensorEntry {
    name: "torque",
    about: "Motor torques as the drives report them, with noise.",
    optional: true,
    read: |table, sensors| {
        table.only(&["noise_nm"])?;
        sensors.torque_noise = table.quantities("noise_nm")?;
        Ok(())
    },
    numbers: &[("torque.noise_nm", |s| s.torque_noise.iter_mut().collect())],
    outside: None,
};

/// Adds the noise of each motor torque, N·m.
pub(super) fn add_noise(torque: &mut [f64; 6], noise: &[f64; 6], random: &mut ChaCha8Rng) {
    for (torque, noise) in torque.iter_mut().zip(noise) {
        if *noise > 0.0 {
            let unit: f64 = StandardNormal.sample(random);
            *torque += noise * unit;
        }
    }
}
