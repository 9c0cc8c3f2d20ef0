//! A random place and random values for an effect of the library, of a size that a laboratory would
//! want to know of.

use crate::laboratory::Laboratory;
use crate::protocol::Protocol;
use crate::random::DRAW_STREAM;
use trueweld_plant::effects::{Draw, Effect, EffectKind, Location, library};
use trueweld_plant::random::Random;

/// An effect of the library at a place.
///
/// # Panics
/// Where the library has no such effect, or it has another number of parameters.
pub fn effect(id: &str, at: Location, values: &[f64]) -> Effect {
    let kind = EffectKind::of(id).expect("an effect of the library");
    assert_eq!(kind.parameters.len(), values.len(), "{id} has other parameters");
    Effect { kind, at, values: values.to_vec() }
}

impl Laboratory {
    /// A random place and random values for the effect `id`. `size` is a factor on what is usual: 1
    /// shows well above the noise in logs of the usual kinds, 0.3 hardly. `protocol` states the
    /// seams' length, on which some effects depend. `None` where the library has no such effect, or
    /// the effect does not state how it is drawn.
    pub fn draw(&self, id: &str, size: f64, protocol: &Protocol, seed: u64) -> Option<Effect> {
        // Each effect has a stream of its own, so that one seed does not put all of them at the same
        // joint.
        let (index, kind) = library().enumerate().find(|(_, k)| k.id == id)?;
        let drawn = kind.drawn?;
        let random = Random::new(seed, DRAW_STREAM + index as u64);
        let mut draw = Draw::new(random, size, &self.robot.parameters, protocol.seam);
        let (at, values) = drawn(&mut draw);
        Some(Effect { kind, at, values })
    }
}
