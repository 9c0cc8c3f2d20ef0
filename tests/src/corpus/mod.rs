//! How well a diagnosis names effects that are hidden in synthetic campaigns.
//!
//! The laboratory draws the cases. [`examine`] makes a case's campaign, has it diagnosed and judges
//! the answer against the truth, with what was found outside the library; [`Tally`] counts. Recorded campaigns play no part, so that rules of
//! decision that were set on the corpus can be tested on campaigns not seen before.

mod discovered;
mod judge;
mod tally;
mod visible;

pub use discovered::DiscoveredLaw;
pub use judge::{Outcome, judge};
pub use tally::Tally;
pub use visible::{Context, Visibility};

use crate::{LABORATORY, fixture};
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;
use trueweld_diagnose::discover::discover;
use trueweld_diagnose::{Diagnosed, DiagnosisVerdict, diagnose, fit_calibrations};
use trueweld_estimate::fit::{self, FitProblem};
use trueweld_estimate::predict::PredictError;
use trueweld_estimate::residuals::compare::{baseline, experiments};
use trueweld_laboratory::{CampaignError, CorpusCase, Hidden, ProtocolFile, Recipe};
use trueweld_logs::campaign::Campaign;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Effect, Role};
use trueweld_plant::input::{Control, InputError, InputFile, ModelFile, Sensors};

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
    pub problem: FitProblem,
}

/// Writes a recipe's campaign into a temporary folder and reads it as a command does.
///
/// # Errors
/// [`CorpusError`].
pub fn ready(recipe: &Recipe) -> Result<Ready, CorpusError> {
    let folder = tempfile::tempdir()?;
    LABORATORY.write(recipe, folder.path())?;
    read(folder.path())
}

/// Records a protocol file's campaign into a temporary folder and reads it as a command does.
///
/// # Errors
/// [`CorpusError`].
pub fn recorded(protocol: &ProtocolFile) -> Result<Ready, CorpusError> {
    let folder = tempfile::tempdir()?;
    let control = Control::read(fixture("control/kr500-mt.toml"))?;
    let sensors = Sensors::read(fixture("sensors/kr500-mt.toml"))?;
    protocol.record(&control, &sensors, folder.path(), &|_| ())?;
    read(folder.path())
}

fn read(folder: &Path) -> Result<Ready, CorpusError> {
    let campaign = Campaign::read(folder)?;
    let file = ModelFile::read(&campaign.model)?;
    let experiments = experiments(&campaign.logs, &baseline(&file))?;
    Ok(Ready { problem: FitProblem::new(&file, experiments), logs: campaign.logs })
}

/// An effect and its place: `backlash [A5]`.
pub fn in_words(effect: &Effect) -> String {
    let at = effect.at.name(&LABORATORY.robot);
    if at.is_empty() { effect.kind.id.to_owned() } else { format!("{} [{at}]", effect.kind.id) }
}

/// An explanation as it was given.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Its effects in words.
    pub effects: Vec<String>,
    /// Its probability.
    pub probability: f64,
    /// Evidence for it against none, nats.
    #[serde(default)]
    pub evidence: f64,
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
    /// What was hidden, in words: effects, or the name of one outside the library; empty for nothing.
    pub truth: Vec<String>,
    /// The same with its values.
    pub values: Vec<String>,
    /// True for an effect outside the library.
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
    /// Score where nothing was fitted: with calibrations alone, with what was found or named, and with
    /// what is hidden, as far as a model can have it.
    pub scores: [f64; 3],
    /// Sum of squares and priors that what is hidden leaves, with its values as they are and calibrations
    /// fitted; nothing where nothing is hidden or the corpus alone has it.
    pub truth_cost: Option<f64>,
    /// The same of what was answered.
    pub answer_cost: f64,
    /// The law that was found outside the library.
    pub discovered: Option<DiscoveredLaw>,
    /// What came of it within the library alone.
    pub within: Outcome,
    /// What came of it.
    pub outcome: Outcome,
    /// Time that the diagnosis took, s.
    pub seconds: f64,
}

/// The recipe with what is hidden, of the size at which it shows as it is to, and how well it
/// does.
///
/// # Errors
/// [`CorpusError`] where the campaign without it cannot be made.
pub fn sized(case: &CorpusCase) -> Result<(Recipe, Hidden, Vec<Visibility>), CorpusError> {
    let ground = || Context::new(&case.recipe);
    let drawn = |effect: &Effect, size: f64| {
        let protocol = &case.recipe.protocol;
        LABORATORY.draw(effect.kind.id, size, protocol, case.seed).expect("drawn for the corpus")
    };
    Ok(match &case.hidden {
        Hidden::None => (case.recipe.clone(), Hidden::None, Vec::new()),
        Hidden::One(effect) => {
            let (effect, seen) = ground()?.size_effect(case.target, |s| drawn(effect, s));
            (case.recipe.clone().with_effect(effect.clone()), Hidden::One(effect), vec![seen])
        }
        Hidden::Two(a, b) => {
            let ground = ground()?;
            let (a, seen_a) = ground.size_effect(case.target, |s| drawn(a, s));
            let (b, seen_b) = ground.size_effect(case.target, |s| drawn(b, s));
            let recipe = case.recipe.clone().with_effect(a.clone()).with_effect(b.clone());
            (recipe, Hidden::Two(a, b), vec![seen_a, seen_b])
        }
        Hidden::Unknown(effect) => {
            let (effect, seen) = ground()?.size_out_of_library(case.target, *effect);
            let recipe = case.recipe.clone().with_out_of_library(effect);
            (recipe, Hidden::Unknown(effect), vec![seen])
        }
        Hidden::Law(law) => {
            let of_size = |size| Effect { values: vec![size], ..law.clone() };
            let (law, seen) = ground()?.size_effect(case.target, of_size);
            (case.recipe.clone().with_effect(law.clone()), Hidden::Law(law), vec![seen])
        }
    })
}

/// Makes the campaign, has it diagnosed, and judges the answer.
///
/// # Errors
/// [`CorpusError`].
pub fn examine(case: &CorpusCase) -> Result<Judged, CorpusError> {
    let (recipe, hidden, seen) = sized(case)?;
    let mut ready = ready(&recipe)?;
    let start = Instant::now();
    let found = diagnose(&ready.problem, &ready.logs, &|_, _| {})?;
    let within = judge(&hidden, &recipe, &found.diagnosis);
    let (found, discovered) = discover(&ready.problem, &ready.logs, found, &|_, _| {});
    let seconds = start.elapsed().as_secs_f64();
    let judged = Judged { within, ..judged(case, &recipe, &hidden, seen, &found, seconds) };
    let Diagnosed { diagnosis, fits } = found;
    let discovered = discovered.first();
    let named =
        diagnosis.candidates.first().filter(|_| diagnosis.verdict != DiagnosisVerdict::Adequate);
    let null = trueweld_diagnose::held_out_score(&fits.null);
    let after = discovered
        .map(|law| law.held_out_after)
        .or(named.map(|best| best.held_out_after))
        .map_or(null, |after| after.min(null));
    let known = hidden.effects();
    let with_the_truth = if known.is_empty() {
        None
    } else {
        ready.problem.known.extend(known.into_iter().cloned());
        Some(fit_calibrations(&ready.problem, &fit::blocks_of(&ready.problem))?)
    };
    Ok(Judged {
        scores: [
            null,
            after,
            with_the_truth.as_ref().map_or(null, trueweld_diagnose::held_out_score),
        ],
        truth_cost: with_the_truth.map(|fitted| fitted.cost),
        discovered: discovered.map(|law| DiscoveredLaw::of(law, &hidden)),
        ..judged
    })
}

fn judged(
    case: &CorpusCase,
    recipe: &Recipe,
    hidden: &Hidden,
    seen: Vec<Visibility>,
    found: &Diagnosed,
    seconds: f64,
) -> Judged {
    let Diagnosed { diagnosis, fits } = found;
    let effects = hidden.effects();
    let outcome = judge(hidden, recipe, diagnosis);
    let (truth, values) = match hidden {
        Hidden::Unknown(s) => (
            vec![s.kind.name().to_owned()],
            vec![format!("{}:A{}:size={}", s.kind.name(), s.joint + 1, s.size)],
        ),
        _ => (
            effects.iter().map(|e| in_words(e)).collect(),
            effects.iter().map(|e| with_values(e)).collect(),
        ),
    };
    let ties = diagnosis.candidates.first().map_or(&[][..], |c| &c.indistinguishable);
    let fitted = diagnosis.candidates.iter().zip(&fits.candidates);
    let named = fitted.enumerate().map(|(k, (c, fitted))| Named {
        effects: c.effects.iter().map(|f| in_words(&f.effect)).collect(),
        probability: c.probability,
        evidence: c.evidence,
        cost: fitted.cost,
        tie: ties.contains(&k),
    });
    Judged {
        name: case.name.clone(),
        seed: case.seed,
        truth,
        values,
        unknown: matches!(hidden, Hidden::Unknown(_) | Hidden::Law(_)),
        target: case.target,
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
        scores: [0.0; 3],
        truth_cost: None,
        answer_cost: answer_cost(found),
        discovered: None,
        within: outcome,
        outcome,
        seconds,
    }
}

/// Cost of what was answered; of a calibration, of all of them.
fn answer_cost(Diagnosed { diagnosis, fits }: &Diagnosed) -> f64 {
    let null = fits.null.cost;
    match diagnosis.verdict {
        DiagnosisVerdict::Adequate => null,
        DiagnosisVerdict::EffectFound => {
            fits.candidates.first().map_or(null, |best| best.cost.min(null))
        }
        // The law, or what comes nearest to an explanation.
        DiagnosisVerdict::UnknownEffect => fits.full.cost,
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
    format!("{}:{}:{}", effect.kind.id, effect.at.name(&LABORATORY.robot), values.join(","))
}

/// True where every value that an effect grows with is plausible.
fn plausible(effect: &Effect) -> bool {
    effect.kind.parameters.iter().zip(&effect.values).all(|(p, v)| match p.role {
        Role::Size { .. } | Role::Reciprocal { .. } => (p.low..=p.high).contains(v),
        _ => true,
    })
}
