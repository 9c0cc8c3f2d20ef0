//! Random campaigns: what is hidden in each, how well it is to show, and what the laboratory gets
//! wrong besides.

use crate::laboratory::Laboratory;
use crate::out_of_library::{OutOfLibrary, OutOfLibraryKind};
use crate::protocol::Protocol;
use crate::random::CASE_STREAM;
use crate::recipe::Recipe;
use trueweld_core::JOINTS;
use trueweld_plant::effects::{Effect, EffectKind, library};
use trueweld_plant::random::Random;

/// What is hidden in a case.
#[derive(Debug, Clone)]
pub enum Hidden {
    /// Nothing, besides what the laboratory gets wrong.
    None,
    /// An effect of the library.
    One(Effect),
    /// Two effects of the library.
    Two(Effect, Effect),
    /// An effect that the library does not have.
    Unknown(OutOfLibrary),
    /// The same, a law at a port of the plant whose one value is its size.
    Law(Effect),
}

impl Hidden {
    /// The effects that are hidden, as far as a model can have them.
    pub fn effects(&self) -> Vec<&Effect> {
        match self {
            Self::None | Self::Unknown(_) => Vec::new(),
            Self::One(a) | Self::Law(a) => vec![a],
            Self::Two(a, b) => vec![a, b],
        }
    }
}

/// One case of the corpus: a campaign yet to be made.
#[derive(Debug, Clone)]
pub struct CorpusCase {
    /// Number and contents, unique in a corpus.
    pub name: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// What is hidden, of its usual size.
    pub hidden: Hidden,
    /// How well it is to show, in multiples of the limit of detection; of two effects, each.
    pub target: f64,
    /// The campaign without what is hidden.
    pub recipe: Recipe,
}

/// Multiples of the limit of detection that are drawn.
const TARGETS: [f64; 3] = [1.0, 3.0, 10.0];

/// Factors on the noise that are drawn.
const NOISES: [f64; 3] = [0.3, 1.0, 3.0];

#[derive(Clone, Copy)]
enum CaseKind {
    None,
    One,
    Two,
    Unknown,
}

/// Ten cases in their order: five with one effect, two with nothing hidden, two outside the
/// library, one with two effects.
const ROUND: [CaseKind; 10] = {
    use CaseKind::{None, One, Two, Unknown};
    [One, None, One, Unknown, One, Two, One, None, One, Unknown]
};

impl Laboratory {
    /// The first `count` campaigns of this seed in which nothing is missing, though the laboratory
    /// errs: by turns there are welds alone, the tracker was moved before a log, and a link is
    /// mounted off, both by several times what is expected.
    pub fn flawless(&self, seed: u64, count: usize, protocol: &Protocol) -> Vec<CorpusCase> {
        (0..count).map(|index| flawless_case(case_seed(seed, index), index, protocol)).collect()
    }

    /// The first `count` cases of the corpus with this seed; a larger `count` leaves the first ones
    /// as they are. Effects come in random order, each once before any comes again.
    pub fn corpus(&self, seed: u64, count: usize, protocol: &Protocol) -> Vec<CorpusCase> {
        let mut deck = Random::new(seed, CASE_STREAM);
        let kinds: Vec<&EffectKind> = library().filter(|kind| kind.drawn.is_some()).collect();
        let (mut effects, mut foreign) = (Vec::new(), Vec::new());
        let mut cases = Vec::with_capacity(count);
        for index in 0..count {
            let seed = case_seed(seed, index);
            let mut next = || {
                let id = deal(&mut effects, &kinds, &mut deck).id;
                (self.draw(id, 1.0, protocol, seed).expect("drawn, as all of these"), id)
            };
            let (hidden, what) = match ROUND[index % ROUND.len()] {
                CaseKind::None => (Hidden::None, "none".to_owned()),
                CaseKind::One => {
                    let (effect, id) = next();
                    (Hidden::One(effect), id.to_owned())
                }
                CaseKind::Two => {
                    let ((a, id_a), (b, id_b)) = (next(), next());
                    (Hidden::Two(a, b), format!("{id_a}+{id_b}"))
                }
                CaseKind::Unknown => {
                    let kind = deal(&mut foreign, &OutOfLibraryKind::ALL, &mut deck);
                    let effect = OutOfLibrary::draw(kind, 1.0, seed);
                    (Hidden::Unknown(effect), kind.name().to_owned())
                }
            };
            let mut random = Random::new(seed, CASE_STREAM);
            let target = TARGETS[random.whole(0, TARGETS.len() - 1)];
            let recipe = nuisance(seed, protocol, &mut random);
            let name = format!("{index:03}-{what}");
            cases.push(CorpusCase { name, seed, hidden, target, recipe });
        }
        cases
    }
}

/// The seed of a case: neighbouring seeds have no stream in common.
fn case_seed(seed: u64, index: usize) -> u64 {
    seed.wrapping_mul(1_000_003).wrapping_add(index as u64)
}

/// One case of [`Laboratory::flawless`], from its own seed.
fn flawless_case(seed: u64, index: usize, protocol: &Protocol) -> CorpusCase {
    let mut random = Random::new(seed, CASE_STREAM);
    let mut recipe = nuisance(seed, protocol, &mut random);
    let off = |random: &mut Random, shift: f64, turn: f64| {
        let (shift, turn) = (random.direction() * shift, random.direction() * turn);
        [shift.x, shift.y, shift.z, turn.x, turn.y, turn.z]
    };
    let what = match index % 3 {
        0 => {
            let welds = random.whole(2, 4);
            recipe.protocol =
                Protocol { postures: 0, rings: 0, free: 0.0, welds, ..protocol.clone() };
            "welds-alone"
        }
        1 => {
            recipe.registration_per_log = 1e-4;
            recipe.tracker_moved = Some((1, off(&mut random, 8e-4, 4e-4)));
            "tracker-moved"
        }
        _ => {
            let joint = random.whole(0, JOINTS - 1);
            recipe.mounted_off = Some((joint, off(&mut random, 9e-4, 8e-4)));
            "mounted-off"
        }
    };
    let name = format!("{index:03}-none-{what}");
    CorpusCase { name, seed, hidden: Hidden::None, target: TARGETS[0], recipe }
}

/// Draws one of `all` without replacement; `pack` holds those left, and is refilled when empty.
fn deal<T: Copy>(pack: &mut Vec<T>, all: &[T], random: &mut Random) -> T {
    if pack.is_empty() {
        pack.extend_from_slice(all);
    }
    pack.swap_remove(random.whole(0, pack.len() - 1))
}

/// Draws the noise, whether it is stated, and what the laboratory gets wrong.
fn nuisance(seed: u64, protocol: &Protocol, random: &mut Random) -> Recipe {
    let stiffness = [0.0, 0.03, 0.05][random.whole(0, 2)];
    let offset = [0.0, 1e-4][random.whole(0, 1)];
    let registration = [0.0, 1e-4][random.whole(0, 1)];
    let noise = NOISES[random.whole(0, NOISES.len() - 1)];
    let noise_stated = random.whole(0, 3) > 0;
    Recipe { protocol: protocol.clone(), noise, noise_stated, ..Recipe::plain(seed) }.with_nuisance(
        stiffness,
        offset,
        registration,
    )
}
