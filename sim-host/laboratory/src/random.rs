//! Seeded random numbers: one stream for each thing drawn, so that a change of one leaves the
//! others as they were.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// Streams. Those from [`REGISTRATION`] on have a log's number added.
pub(crate) const NUISANCE: u64 = 1;
pub(crate) const OUT_OF_LIBRARY: u64 = 2;
/// Of the library's first effect; the others have their place in its table added.
pub(crate) const DRAW: u64 = 100;
pub(crate) const REGISTRATION: u64 = 1000;
pub(crate) const PLAN: u64 = 2000;
pub(crate) const NOISE: u64 = 3000;
/// Of the corpus: what is drawn for one case.
pub(crate) const CASE: u64 = 4000;

/// One stream of random numbers.
#[derive(Debug)]
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        generator.set_stream(stream);
        Self(generator)
    }

    /// Evenly between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        let share: f64 = StandardUniform.sample(&mut self.0);
        low + share * (high - low)
    }

    /// Evenly between two magnitudes, of either sign.
    pub fn either(&mut self, low: f64, high: f64) -> f64 {
        self.sign() * self.between(low, high)
    }

    /// 1 or −1.
    pub fn sign(&mut self) -> f64 {
        if self.between(-1.0, 1.0) < 0.0 { -1.0 } else { 1.0 }
    }

    /// One of the whole numbers from `first` to `last`, both included.
    pub fn whole(&mut self, first: usize, last: usize) -> usize {
        (first + self.between(0.0, (last - first + 1) as f64) as usize).min(last)
    }

    /// Standard normal.
    pub fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    /// A direction in space.
    pub fn direction(&mut self) -> Vector3<f64> {
        Vector3::from_fn(|_, _| self.normal()).normalize()
    }
}
