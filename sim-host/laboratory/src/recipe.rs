//! The truth of one campaign, what the laboratory gets wrong, and what it measures.

use crate::instruments::InstrumentNoise;
use crate::out_of_library::OutOfLibrary;
use crate::protocol::Protocol;
use crate::random;
use nalgebra::Vector3;
use trueweld_core::JOINTS;
use trueweld_plant::effects::{
    Effect, encoder_offset, geometry_error, stiffness_error, tracker_registration,
};
use trueweld_plant::random::Random;

/// What a campaign is made of.
#[derive(Debug, Clone)]
pub struct Recipe {
    /// Effects of the library that the truth has and the model lacks.
    pub effects: Vec<Effect>,
    /// An effect of the truth that the library does not have.
    pub out_of_library: Option<OutOfLibrary>,
    /// Error of each joint's stiffness, relative.
    pub stiffness_error: [f64; JOINTS],
    /// Error of each encoder's zero, rad.
    pub encoder_offset: [f64; JOINTS],
    /// Standard deviation of the tracker's registration, drawn anew for each log: translation, m,
    /// and half of it per metre as rotation, rad.
    pub registration_per_log: f64,
    /// Standard deviation of how each link is mounted off its joint: translation, m, and as much in
    /// rad as rotation.
    pub geometry_error: f64,
    /// A log before which the tracker was moved, by its number from 1, and by what: translation, m,
    /// and rotation vector, rad.
    pub tracker_moved: Option<(u64, [f64; 6])>,
    /// A joint behind which the link is mounted off besides, from 0, and by what.
    pub mounted_off: Option<(usize, [f64; 6])>,
    /// Factor on the nominal noise of every instrument.
    pub noise: f64,
    /// Noise of each instrument before that factor.
    pub instruments: InstrumentNoise,
    /// Where the tracker's reflectors sit in T, m: static logs then hold their points instead of a
    /// pose.
    pub reflectors: Option<[Vector3<f64>; 3]>,
    /// True where `log.toml` states the noise.
    pub noise_stated: bool,
    /// Which logs are recorded.
    pub protocol: Protocol,
    /// Seed of everything random: postures, motions, seams, noise.
    pub seed: u64,
}

impl Recipe {
    /// The model itself, measured in a usual protocol with nominal noise, which is stated.
    pub fn plain(seed: u64) -> Self {
        Self {
            effects: Vec::new(),
            out_of_library: None,
            stiffness_error: [0.0; JOINTS],
            encoder_offset: [0.0; JOINTS],
            registration_per_log: 0.0,
            geometry_error: 0.0,
            tracker_moved: None,
            mounted_off: None,
            noise: 1.0,
            instruments: InstrumentNoise::default(),
            reflectors: None,
            noise_stated: true,
            protocol: Protocol::usual(),
            seed,
        }
    }

    /// What the laboratory got wrong in one log: stiffnesses, encoder zeros and geometry of the
    /// campaign, the log's own tracker registration.
    pub fn miscalibrations(&self, log: u64) -> Vec<Effect> {
        let mut effects = Vec::new();
        for joint in 0..JOINTS {
            let (stiffness, zero) = (self.stiffness_error[joint], self.encoder_offset[joint]);
            if stiffness != 0.0 {
                effects.push(stiffness_error::effect(joint, stiffness));
            }
            if zero != 0.0 {
                effects.push(encoder_offset::effect(joint, zero));
            }
        }
        if self.registration_per_log != 0.0 {
            let mut random = Random::new(self.seed, random::REGISTRATION_STREAM + log);
            let deviation = |k| self.registration_per_log * if k < 3 { 1.0 } else { 0.5 };
            let motion = std::array::from_fn(|k: usize| deviation(k) * random.normal());
            effects.push(tracker_registration::effect(motion));
        }
        if let Some((_, motion)) = self.tracker_moved.filter(|(moved, _)| *moved == log) {
            effects.push(tracker_registration::effect(motion));
        }
        if let Some((joint, motion)) = self.mounted_off {
            effects.push(geometry_error::effect(joint, motion));
        }
        if self.geometry_error != 0.0 {
            let mut random = Random::new(self.seed, random::GEOMETRY_STREAM);
            effects.extend((0..JOINTS).map(|joint| {
                geometry_error::effect(
                    joint,
                    [(); 6].map(|()| self.geometry_error * random.normal()),
                )
            }));
        }
        effects
    }

    /// Adds an effect of the library.
    #[must_use]
    pub fn with_effect(mut self, effect: Effect) -> Self {
        self.effects.push(effect);
        self
    }

    /// Adds an effect that the library does not have.
    #[must_use]
    pub fn with_out_of_library(mut self, effect: OutOfLibrary) -> Self {
        self.out_of_library = Some(effect);
        self
    }

    /// Draws the laboratory's errors, normal with these standard deviations: stiffness (relative),
    /// encoder zero (rad), registration per log (m).
    #[must_use]
    pub fn with_nuisance(mut self, stiffness: f64, offset: f64, registration: f64) -> Self {
        let mut random = Random::new(self.seed, random::NUISANCE_STREAM);
        // Adding zero turns −0 into 0, which is what truth.toml shows.
        self.stiffness_error = std::array::from_fn(|_| stiffness * random.normal() + 0.0);
        self.encoder_offset = std::array::from_fn(|_| offset * random.normal() + 0.0);
        self.registration_per_log = registration;
        self
    }
}
