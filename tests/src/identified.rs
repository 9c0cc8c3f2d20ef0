//! Campaigns whose numbers are off by a factor, and whether what is identified holds the truth.

use crate::LABORATORY;
use std::f64::consts::LN_2;
use trueweld_core::JOINTS;
use trueweld_estimate::identify::{IdentificationTarget, identify};
use trueweld_laboratory::{Protocol, Recipe};
use trueweld_logs::campaign::read_logs;
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::input::ModelFile;
use trueweld_plant::random::Random;

/// How many of the process' numbers, the first of them, `identify process` tells beside the ripple.
const PROCESS_NUMBERS: usize = 7;

/// A campaign with what is to be identified in it.
#[derive(Debug)]
pub struct Case {
    target: IdentificationTarget,
    recipe: Recipe,
    /// True factor on each number that the model states.
    factors: Vec<f64>,
}

/// How many intervals hold the truth.
#[derive(Debug, Clone, Copy, Default)]
pub struct Seen {
    /// Intervals that hold it.
    pub held: usize,
    /// Intervals given.
    pub told: usize,
    /// Numbers that the logs do not tell.
    pub untold: usize,
    /// Residuals over noise.
    pub score: f64,
}

/// Factors between a half and two, evenly in their logarithm.
fn factors<const N: usize>(seed: u64) -> [f64; N] {
    let mut random = Random::new(seed, 0);
    std::array::from_fn(|_| (0.98 * random.between(-LN_2, LN_2)).exp())
}

impl Case {
    /// Loads at rest; encoder zeros and the tracker are off as well.
    pub fn stiffness(seed: u64) -> Self {
        let factors = factors::<JOINTS>(seed);
        let protocol = Protocol { postures: 8, rings: 0, free: 0.0, welds: 0, ..Protocol::short() };
        let recipe = Recipe { protocol, ..Recipe::plain(seed) }.with_nuisance(0.0, 5e-5, 5e-5);
        let recipe = Recipe { stiffness_error: factors.map(|f| f - 1.0), ..recipe };
        Self { target: IdentificationTarget::Stiffness, recipe, factors: factors.to_vec() }
    }

    /// Loads at rest and three stops by the brakes.
    pub fn damping(seed: u64) -> Self {
        let factors = factors::<JOINTS>(seed);
        let protocol =
            Protocol { postures: 4, rings: 3, ring: 1.0, free: 0.0, welds: 0, ..Protocol::short() };
        let kind = EffectKind::of("damping-error").expect("an effect of the library");
        let effects = factors.iter().enumerate().map(|(joint, factor)| Effect {
            kind,
            at: Location::Joint(joint),
            values: vec![factor - 1.0],
        });
        let recipe = Recipe { protocol, effects: effects.collect(), ..Recipe::plain(seed) };
        Self { target: IdentificationTarget::Damping, recipe, factors: factors.to_vec() }
    }

    /// Loads at rest and two welds, whose process the model states wrongly.
    pub fn process(seed: u64) -> Self {
        let protocol = Protocol { rings: 0, free: 0.0, welds: 2, seam: 0.1, ..Protocol::short() };
        let recipe = Recipe { protocol, ..Recipe::plain(seed) };
        let factors = factors::<PROCESS_NUMBERS>(seed).to_vec();
        Self { target: IdentificationTarget::Process, recipe, factors }
    }
}

/// Records the campaign, identifies, and counts.
///
/// # Errors
/// A campaign that cannot be recorded or read, or from which nothing is identified.
pub fn examine(case: &Case) -> Result<Seen, Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    LABORATORY.write(&case.recipe, folder.path())?;
    let mut model = ModelFile::read(folder.path().join("model.toml"))?;
    if let (IdentificationTarget::Process, Some(process)) = (case.target, &mut model.process) {
        for (key, factor) in process.kind().keys.iter().zip(&case.factors) {
            process.numbers(key).into_iter().for_each(|number| *number /= factor);
        }
    }
    let (_, logs) = read_logs(&[folder.path().to_owned()])?;
    let found = identify(case.target, &model, logs, &|_, _| ())?;
    let mut seen = Seen { score: found.score, ..Seen::default() };
    for (number, factor) in found.numbers.iter().zip(&case.factors) {
        let truth = number.given * factor;
        match number.interval {
            None => seen.untold += 1,
            Some([low, high]) => {
                seen.told += 1;
                seen.held += usize::from((low..=high).contains(&truth));
            }
        }
    }
    Ok(seen)
}
