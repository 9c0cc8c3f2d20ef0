//! The corpus: how well a diagnosis names effects that we hid in synthetic campaigns.
//!
//! [`cases`] draws what is hidden where, how well it shows, and what a laboratory gets wrong beside
//! it. [`CorpusCase::examine`] makes the campaign, has it diagnosed and judges the answer against
//! the truth; [`Tally`] counts. Recorded campaigns play no part: rules of decision may be set by
//! what is seen here and then meet those unseen.

mod judge;
mod tally;
mod visible;

pub use judge::{Outcome, judge};
pub use tally::Tally;
pub use visible::{Context, Visibility};

use crate::campaign::random::{CASE, Random};
use crate::campaign::{CampaignError, Logs, OutOfLibrary, Recipe, Strange, draw, write};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;
use trueweld_measure::data::campaign::Campaign;
use trueweld_measure::data::log::Log;
use trueweld_measure::diagnose::{Diagnosis, diagnose};
use trueweld_measure::fit::FitProblem;
use trueweld_measure::predict::PredictError;
use trueweld_measure::residuals::compare::{baseline, experiments};
use trueweld_plant::effects::{Effect, EffectKind, Role, library};
use trueweld_plant::input::{InputError, ModelFile};

/// What is hidden in a case.
#[derive(Debug, Clone)]
pub enum Hidden {
    /// Nothing, beside what a laboratory gets wrong.
    None,
    /// An effect of the library.
    One(Effect),
    /// Two effects of the library.
    Two(Effect, Effect),
    /// Something outside the library.
    Unknown(OutOfLibrary),
}

/// One case of the corpus: a campaign yet to be made.
#[derive(Debug, Clone)]
pub struct CorpusCase {
    /// Number and contents, unique in a corpus.
    pub name: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// What is hidden, of usual size.
    pub hidden: Hidden,
    /// How well it is to show, in multiples of the limit of detection ([`Visibility::ratio`]); each
    /// of two.
    pub target: f64,
    /// The campaign without what is hidden.
    pub recipe: Recipe,
}

/// Multiples of the limit of detection that cases are drawn at.
const TARGETS: [f64; 3] = [1.0, 3.0, 10.0];

/// Factors on the noise that cases are drawn at.
const NOISES: [f64; 3] = [0.3, 1.0, 3.0];

/// Ten cases in their order: half of them one effect, two nothing, two unknown, one with two
/// effects.
const ROUND: [char; 10] = ['1', '0', '1', 'u', '1', '2', '1', '0', '1', 'u'];

/// The first `count` cases of the corpus with this seed; more cases do not change those before
/// them. Effects and strangers come in random order, each once before any comes again.
pub fn cases(seed: u64, count: usize, logs: &Logs) -> Vec<CorpusCase> {
    let mut deck = Random::new(seed, CASE);
    let (mut effects, mut strangers) = (Vec::new(), Vec::new());
    let kinds: Vec<&EffectKind> = library().collect();
    (0..count)
        .map(|index| {
            // Campaigns whose seeds are neighbours share nothing: every stream of a seed is its
            // own.
            let case_seed = seed.wrapping_mul(1_000_003).wrapping_add(index as u64);
            let mut next = || dealt(&mut effects, &kinds, &mut deck).id;
            let (hidden, what) = match ROUND[index % ROUND.len()] {
                '0' => (Hidden::None, "none".to_owned()),
                '1' => {
                    let id = next();
                    (Hidden::One(draw(id, 1.0, logs, case_seed)), id.to_owned())
                }
                '2' => {
                    let (a, b) = (next(), next());
                    let pair =
                        Hidden::Two(draw(a, 1.0, logs, case_seed), draw(b, 1.0, logs, case_seed));
                    (pair, format!("{a}+{b}"))
                }
                _ => {
                    let what = dealt(&mut strangers, &Strange::ALL, &mut deck);
                    (
                        Hidden::Unknown(OutOfLibrary::draw(what, 1.0, case_seed)),
                        what.name().to_owned(),
                    )
                }
            };
            let mut random = Random::new(case_seed, CASE);
            let target = TARGETS[random.whole(0, TARGETS.len() - 1)];
            CorpusCase {
                name: format!("{index:03}-{what}"),
                seed: case_seed,
                hidden,
                target,
                recipe: laboratory(case_seed, logs, &mut random),
            }
        })
        .collect()
}

/// The next card of a shuffled pack; a new pack where there is none left.
fn dealt<T: Copy>(pack: &mut Vec<T>, all: &[T], random: &mut Random) -> T {
    if pack.is_empty() {
        pack.extend_from_slice(all);
    }
    pack.swap_remove(random.whole(0, pack.len() - 1))
}

/// A laboratory: how noisy, whether it says so, and what it gets wrong.
fn laboratory(seed: u64, logs: &Logs, random: &mut Random) -> Recipe {
    let stiffness = [0.0, 0.03, 0.05][random.whole(0, 2)];
    let offset = [0.0, 1e-4][random.whole(0, 1)];
    let registration = [0.0, 1e-4][random.whole(0, 1)];
    let mut recipe = Recipe { logs: logs.clone(), ..Recipe::plain(seed) };
    recipe = recipe.with_nuisance(stiffness, offset, registration);
    recipe.noise = NOISES[random.whole(0, NOISES.len() - 1)];
    recipe.noise_stated = random.whole(0, 3) > 0;
    recipe
}

/// Why a case could not be examined.
#[derive(Debug, thiserror::Error)]
pub enum CorpusError {
    /// The campaign cannot be made.
    #[error(transparent)]
    Campaign(#[from] CampaignError),
    /// The campaign cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The model cannot be driven through the campaign.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// No temporary folder.
    #[error(transparent)]
    Folder(#[from] std::io::Error),
}

/// A campaign ready to be diagnosed.
#[derive(Debug)]
pub struct Ready {
    /// Its logs.
    pub logs: Vec<Log>,
    /// The same made ready, and the baseline.
    pub bench: FitProblem,
}

/// Writes a recipe's campaign, reads it as anybody would, and removes it.
///
/// # Errors
/// [`CorpusError`].
pub fn ready(recipe: &Recipe) -> Result<Ready, CorpusError> {
    let folder = tempfile::tempdir()?;
    write(recipe, folder.path())?;
    read(folder.path())
}

fn read(folder: &Path) -> Result<Ready, CorpusError> {
    let campaign = Campaign::read(folder)?;
    let file = ModelFile::read(&campaign.model)?;
    let experiments = experiments(&campaign.logs, &baseline(&file))?;
    Ok(Ready { bench: FitProblem::new(&file, experiments), logs: campaign.logs })
}

/// An effect in words: `backlash [A5]`.
pub fn in_words(effect: &Effect) -> String {
    let at = crate::campaign::at_name(effect);
    if at.is_empty() { effect.kind.id.to_owned() } else { format!("{} [{at}]", effect.kind.id) }
}

/// An explanation as it was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Its effects in words.
    pub effects: Vec<String>,
    /// Its probability.
    pub probability: f64,
    /// Sum of squares and priors that it leaves.
    pub cost: f64,
    /// True where the data do not tell it from the first.
    pub tie: bool,
}

/// What came of one case: a line of the record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Judged {
    /// The case's name.
    pub name: String,
    /// Seed of its campaign.
    pub seed: u64,
    /// What was hidden, in words: effects, or a stranger's name; empty for nothing.
    pub truth: Vec<String>,
    /// The same with its values.
    pub values: Vec<String>,
    /// True for something outside the library.
    pub unknown: bool,
    /// How well it was to show.
    pub target: f64,
    /// How well each part of the truth shows; empty for nothing.
    pub seen: Vec<Visibility>,
    /// Factor on the noise.
    pub noise: f64,
    /// True where the noise was stated.
    pub stated: bool,
    /// True where a stiffness, an encoder's zero or the tracker's registration was wrong beside it.
    pub nuisance: [bool; 3],
    /// Verdict of the diagnosis.
    pub verdict: String,
    /// Its explanations, best first.
    pub named: Vec<Named>,
    /// Calibrations that it reported.
    pub calibration: Vec<String>,
    /// Score before.
    pub score_before: f64,
    /// What came of it.
    pub outcome: Outcome,
    /// Time that the diagnosis took, s.
    pub seconds: f64,
}

impl CorpusCase {
    /// The recipe with what is hidden, of the size at which it shows as it is to, and how well it
    /// does.
    ///
    /// # Errors
    /// [`CorpusError`] where the campaign without it cannot be made.
    pub fn sized(&self) -> Result<(Recipe, Hidden, Vec<Visibility>), CorpusError> {
        let ground = || Context::new(&self.recipe);
        let drawn =
            |effect: &Effect, size: f64| draw(effect.kind.id, size, &self.recipe.logs, self.seed);
        Ok(match &self.hidden {
            Hidden::None => (self.recipe.clone(), Hidden::None, Vec::new()),
            Hidden::One(effect) => {
                let (effect, seen) = ground()?.size_effect(self.target, |s| drawn(effect, s));
                (self.recipe.clone().with_effect(effect.clone()), Hidden::One(effect), vec![seen])
            }
            Hidden::Two(a, b) => {
                let ground = ground()?;
                let (a, seen_a) = ground.size_effect(self.target, |s| drawn(a, s));
                let (b, seen_b) = ground.size_effect(self.target, |s| drawn(b, s));
                let recipe = self.recipe.clone().with_effect(a.clone()).with_effect(b.clone());
                (recipe, Hidden::Two(a, b), vec![seen_a, seen_b])
            }
            Hidden::Unknown(stranger) => {
                let (stranger, seen) = ground()?.size_stranger(self.target, *stranger);
                (self.recipe.clone().with_stranger(stranger), Hidden::Unknown(stranger), vec![seen])
            }
        })
    }

    /// Makes the campaign, has it diagnosed, and judges the answer.
    ///
    /// # Errors
    /// [`CorpusError`].
    pub fn examine(&self) -> Result<Judged, CorpusError> {
        let (recipe, hidden, seen) = self.sized()?;
        let ready = ready(&recipe)?;
        let start = Instant::now();
        let diagnosis = diagnose(&ready.bench, &ready.logs, &|_, _| {})?;
        let seconds = start.elapsed().as_secs_f64();
        Ok(self.judged(&recipe, &hidden, seen, &diagnosis, seconds))
    }

    fn judged(
        &self,
        recipe: &Recipe,
        hidden: &Hidden,
        seen: Vec<Visibility>,
        diagnosis: &Diagnosis,
        seconds: f64,
    ) -> Judged {
        let effects: Vec<&Effect> = match hidden {
            Hidden::One(a) => vec![a],
            Hidden::Two(a, b) => vec![a, b],
            Hidden::None | Hidden::Unknown(_) => Vec::new(),
        };
        let (truth, values) = match hidden {
            Hidden::Unknown(s) => (
                vec![s.what.name().to_owned()],
                vec![format!("{}:A{}:size={}", s.what.name(), s.joint + 1, s.size)],
            ),
            _ => (
                effects.iter().map(|e| in_words(e)).collect(),
                effects.iter().map(|e| with_values(e)).collect(),
            ),
        };
        let ties = diagnosis.candidates.first().map_or(&[][..], |c| &c.indistinguishable);
        let named = diagnosis.candidates.iter().enumerate().map(|(k, c)| Named {
            effects: c.effects.iter().map(|f| in_words(&f.effect)).collect(),
            probability: c.probability,
            cost: c.fitted.cost,
            tie: ties.contains(&k),
        });
        Judged {
            name: self.name.clone(),
            seed: self.seed,
            truth,
            values,
            unknown: matches!(hidden, Hidden::Unknown(_)),
            target: self.target,
            seen,
            noise: recipe.noise,
            stated: recipe.noise_stated,
            nuisance: [
                recipe.stiffness_error.iter().any(|e| *e != 0.0),
                recipe.encoder_offset.iter().any(|e| *e != 0.0),
                recipe.registration_per_log != 0.0,
            ],
            verdict: diagnosis.verdict.name().to_owned(),
            named: named.collect(),
            calibration: diagnosis.calibration.iter().map(|f| in_words(&f.effect)).collect(),
            score_before: diagnosis.score_before,
            outcome: judge(hidden, recipe, diagnosis),
            seconds,
        }
    }
}

/// An effect as a command line takes it.
fn with_values(effect: &Effect) -> String {
    let values: Vec<String> = effect
        .kind
        .parameters
        .iter()
        .zip(&effect.values)
        .map(|(p, v)| format!("{}={v:e}", p.name))
        .collect();
    format!("{}:{}:{}", effect.kind.id, crate::campaign::at_name(effect), values.join(","))
}

/// True where every value that an effect grows with is plausible.
fn plausible(effect: &Effect) -> bool {
    effect.kind.parameters.iter().zip(&effect.values).all(|(p, v)| match p.role {
        Role::Size { .. } | Role::Reciprocal { .. } => (p.low..=p.high).contains(v),
        _ => true,
    })
}
