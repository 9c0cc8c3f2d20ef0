//! Seeded random numbers: one stream for each thing drawn, so that a change of one leaves the
//! others as they were.

use nalgebra::Vector3;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};
use trueweld_core::state::{StateResult, StateVisitor};

/// One stream of random numbers.
#[derive(Debug)]
pub struct Random(ChaCha8Rng);

impl Random {
    /// The stream of this number.
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

/// Shows how far a stream of random numbers has come. Its seed and its number are no state.
///
/// # Errors
/// [`StateError`].
pub(crate) fn visit_stream(stream: &mut ChaCha8Rng, visitor: &mut dyn StateVisitor) -> StateResult {
    // A position has 68 bits: two halves that an `f64` holds exactly.
    const HALF: u32 = 34;
    let position = stream.get_word_pos();
    let mut halves = [(position >> HALF) as usize, (position & ((1 << HALF) - 1)) as usize];
    for half in &mut halves {
        visitor.count(half, (1 << HALF) - 1)?;
    }
    stream.set_word_pos((halves[0] as u128) << HALF | halves[1] as u128);
    Ok(())
}
