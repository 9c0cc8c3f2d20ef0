//! The worst cell within the uncertainty: a search over the whole set that the trials are drawn
//! from.
//!
//! A figure over a box of uncertain numbers is mostly largest in a corner. The search begins in the
//! corners next to the worst trials and in corners drawn at random, turns every number of the worst
//! cell so far to its other end, then those together that made it worse, and goes on from the worst
//! cell not yet turned. What is maximised is the figure closest to its limit, as a share of the
//! limit.
//!
//! The cells asked for depend on the seed and on what earlier cells came to, in batches of fixed
//! size: the number of threads changes nothing. Where there are many uncertain numbers, those are
//! turned that the trials show to matter most, and the search begins in the corner that the trials
//! point at too. A search finds; that nothing is worse it cannot
//! prove.

use super::{Criterion, SampledCell, Trial, largest_share, within};
use crate::figure::share_of_limit;
use crate::requirements::Requirements;
use crate::uncertain::UncertainCell;
use crate::weld::WELD_FIGURES;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use statrs::distribution::{ContinuousCDF, Normal};
use std::collections::HashSet;
use std::f64::consts::PI;

/// Its stream of random numbers: no trial has this index.
const STREAM: u64 = u64::MAX;

/// Corners that the search begins in next to the worst trials, and corners at random in every
/// batch.
const STARTS: [usize; 2] = [4, 4];

/// Numbers of the short keys: stiffness of six joints, five gains of the process, size and phase of
/// the ripple, cross-talk along two axes, delay. The latents of an [`UncertainCell`] come after.
pub(crate) const SHORT: usize = 16;

/// Most numbers that are turned at once.
const MOST_TURNS: usize = 16;

/// A latent at an end of its range, standard deviations: 1 − Φ is 6·10⁻¹⁶.
const END: f64 = 8.0;

/// Which of them is the phase, which has no ends.
pub(super) const PHASE: usize = 12;

/// The worst of all cells that were run.
#[derive(Debug, Clone, PartialEq)]
pub struct WorstCase {
    /// The worst cell, of those known before the search if it found none worse. `None` where no run
    /// was made.
    pub worst: Option<Trial>,
    /// Its figure that is closest to its limit, or farthest beyond it, by its name.
    pub name: &'static str,
    /// That figure over its limit; infinite for a run without an end.
    pub of_limit: f64,
    /// So many runs of the search are beyond a limit.
    pub beyond: usize,
    /// Every run of the search, in the order in which they were asked for.
    pub runs: Vec<Trial>,
}

impl WorstCase {
    /// The worst of the nominal cell, the trials and the runs of a search. Of equals the first.
    pub fn among(
        requirements: &Requirements,
        nominal: &Trial,
        trials: &[Trial],
        runs: Vec<Trial>,
    ) -> Self {
        let limits = limits_of(requirements, nominal);
        let all = std::iter::once(nominal).chain(trials).chain(&runs);
        let worst = all
            .reduce(|a, b| if badness(&limits, b) > badness(&limits, a) { b } else { a })
            .cloned();
        let farthest =
            worst.as_ref().and_then(|trial| Some((largest_share(&limits, trial)?.0, trial)));
        let name = farthest.map_or(WELD_FIGURES[0].figure.key, |(of, _)| of.key);
        let of_limit =
            farthest.map_or(0.0, |(of, trial)| share_of_limit(trial.figure(of.key), 0.0, of.limit));
        let is_beyond =
            |trial: &&Trial| limits.iter().any(|of| !within(trial.figure(of.key), of.limit));
        let beyond = runs.iter().filter(is_beyond).count();
        Self { worst, name, of_limit, beyond, runs }
    }
}

/// Of every figure the limit that a search looks at: that of the worst case, where there is one.
fn limits_of(requirements: &Requirements, nominal: &Trial) -> Vec<Criterion> {
    let limit = |key| {
        let mut all = requirements.worst_case.iter().chain(&requirements.limits);
        Some(Criterion::new(all.find(|limit| limit.figure.key == key)?, nominal))
    };
    WELD_FIGURES.iter().filter_map(|of| limit(of.figure.key)).collect()
}

/// The largest share of a limit.
fn badness(limits: &[Criterion], trial: &Trial) -> f64 {
    largest_share(limits, trial).map_or(0.0, |(_, share)| share)
}

/// Searches for the worst cell with `budget` runs beside the trials, which are known already, and
/// gives all of these runs. `run` makes the runs of a batch: of each cell, with its number.
/// `nominal`: the run of the cell as it is believed to be.
///
/// # Errors
/// Those of `run`.
pub fn search<E>(
    requirements: &Requirements,
    uncertain: &UncertainCell,
    seed: u64,
    nominal: &Trial,
    trials: &[Trial],
    budget: usize,
    mut run: impl FnMut(&[(u64, SampledCell)]) -> Result<Vec<Trial>, E>,
) -> Result<Vec<Trial>, E> {
    let mut search = Search::new(requirements, uncertain, seed, nominal, trials);
    let mut runs: Vec<Trial> = Vec::new();
    while runs.len() < budget {
        let mut batch = search.next_batch();
        batch.truncate(budget - runs.len());
        if batch.is_empty() {
            break;
        }
        let first = runs.len() as u64;
        let numbered: Vec<(u64, SampledCell)> =
            (first..).zip(batch.iter().map(|c| search.draw(c))).collect();
        let done = run(&numbered)?;
        search.learn(&batch, &done);
        runs.extend(done);
    }
    Ok(runs)
}

/// A cell: every number as a share of its half width, from −1 to 1, and the seed of its noise. Of a
/// latent the share is 2Φ − 1.
#[derive(Debug, Clone, PartialEq)]
struct SearchPoint {
    at: Vec<f64>,
    noise: u64,
}

impl SearchPoint {
    fn key(&self) -> Vec<u64> {
        self.at.iter().map(|share| share.to_bits()).collect()
    }

    /// In how many numbers two cells differ.
    fn differs(&self, other: &Self) -> usize {
        self.at.iter().zip(&other.at).filter(|(a, b)| a != b).count()
    }
}

/// What is done next.
enum Stage {
    Start,
    /// Every number of the worst cell not yet turned is turned to its other end.
    Turn,
    /// Those turns are put together that made the cell worse: the cell, and its turns from the
    /// worst down.
    Together(SearchPoint, Vec<SearchPoint>),
}

struct Search<'a> {
    uncertain: &'a UncertainCell,
    /// Numbers that are turned, and the corner that the trials point at where there are more.
    turned_numbers: Vec<usize>,
    pointed: Option<SearchPoint>,
    limits: Vec<Criterion>,
    random: ChaCha8Rng,
    /// Cells known, and how bad they were, from the worst down.
    known: Vec<(SearchPoint, f64)>,
    asked: HashSet<Vec<u64>>,
    turned: HashSet<Vec<u64>>,
    /// The cell that the last batch turned, and how bad it is.
    turning: Option<(SearchPoint, f64)>,
    stage: Stage,
}

impl<'a> Search<'a> {
    fn new(
        requirements: &'a Requirements,
        uncertain: &'a UncertainCell,
        seed: u64,
        nominal: &Trial,
        trials: &[Trial],
    ) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(STREAM);
        let mut search = Self {
            uncertain,
            turned_numbers: (0..SHORT + uncertain.latents()).collect(),
            pointed: None,
            limits: limits_of(requirements, nominal),
            random,
            known: Vec::new(),
            asked: HashSet::new(),
            turned: HashSet::new(),
            turning: None,
            stage: Stage::Start,
        };
        for trial in trials {
            let cell = SearchPoint { at: numbers(uncertain, &trial.draw), noise: trial.draw.noise };
            search.known.push((cell, badness(&search.limits, trial)));
        }
        search.known.sort_by(|a, b| b.1.total_cmp(&a.1));
        if search.turned_numbers.len() > MOST_TURNS {
            search.choose();
        }
        search
    }

    /// Chooses the numbers to be turned, and the corner to begin in: by how each number goes with
    /// the rank of a trial's badness.
    fn choose(&mut self) {
        let last = self.known.len().saturating_sub(1) as f64;
        let slope = |k: usize| -> f64 {
            let ranked = self.known.iter().enumerate();
            ranked.map(|(rank, (cell, _))| cell.at[k] * (0.5 * last - rank as f64)).sum()
        };
        let slopes: Vec<f64> = self.turned_numbers.iter().map(|k| slope(*k)).collect();
        self.turned_numbers.sort_by(|a, b| slopes[*b].abs().total_cmp(&slopes[*a].abs()));
        self.turned_numbers.truncate(MOST_TURNS);
        self.pointed = self.known.first().map(|(worst, _)| {
            let end = |(k, share): (usize, &f64)| if k == PHASE { *share } else { slopes[k] };
            let at = worst.at.iter().enumerate().map(end).collect();
            corner_of(&SearchPoint { at, noise: worst.noise })
        });
    }

    fn next_batch(&mut self) -> Vec<SearchPoint> {
        let mut batch = match std::mem::replace(&mut self.stage, Stage::Turn) {
            Stage::Start => {
                let pointed = self.pointed.take();
                let next_to = self.known.iter().take(STARTS[0]).map(|(cell, _)| corner_of(cell));
                pointed.into_iter().chain(next_to).collect()
            }
            Stage::Turn => {
                let next =
                    self.known.iter().find(|(cell, _)| !self.turned.contains(&cell.key())).cloned();
                self.turning = next.clone();
                next.map_or(Vec::new(), |(cell, _)| {
                    self.turned.insert(cell.key());
                    let numbers = self.turned_numbers.clone();
                    numbers.into_iter().map(|k| self.turn(&cell, k)).collect()
                })
            }
            Stage::Together(cell, worse) => {
                let some = [2, worse.len().div_ceil(2), worse.len()];
                some.iter().map(|n| together(&cell, worse.iter().take(*n))).collect()
            }
        };
        batch.extend((0..STARTS[1]).map(|_| self.random_corner()));
        batch.retain(|cell| self.asked.insert(self.said(cell)));
        batch
    }

    fn learn(&mut self, batch: &[SearchPoint], done: &[Trial]) {
        let mut found: Vec<(SearchPoint, f64)> =
            batch.iter().cloned().zip(done.iter().map(|t| badness(&self.limits, t))).collect();
        self.known.extend(found.iter().cloned());
        // Stable: of equals the one known first stays before.
        self.known.sort_by(|a, b| b.1.total_cmp(&a.1));
        if let Some((cell, before)) = self.turning.take() {
            found.sort_by(|a, b| b.1.total_cmp(&a.1));
            let turns = found
                .into_iter()
                .filter(|(turn, badness)| turn.differs(&cell) == 1 && *badness > before);
            let turns = turns.map(|(turn, _)| turn).collect();
            self.stage = Stage::Together(cell, turns);
        }
    }

    /// What a cell is, whatever its noise: numbers that are known exactly do not tell two apart.
    fn said(&self, cell: &SearchPoint) -> Vec<u64> {
        let at = numbers(self.uncertain, &self.draw(cell));
        SearchPoint { at, noise: cell.noise }.key()
    }

    fn random_corner(&mut self) -> SearchPoint {
        let mut end = |_| if self.random.random::<bool>() { 1.0 } else { -1.0 };
        let mut at: Vec<f64> = (0..SHORT + self.uncertain.latents()).map(&mut end).collect();
        at[PHASE] = 2.0 * self.random.random::<f64>() - 1.0;
        SearchPoint { at, noise: self.random.random() }
    }

    /// One number at its other end; the phase anywhere.
    fn turn(&mut self, cell: &SearchPoint, k: usize) -> SearchPoint {
        let mut turned = cell.clone();
        let phase = 2.0 * self.random.random::<f64>() - 1.0;
        turned.at[k] = match cell.at[k] {
            _ if k == PHASE => phase,
            v if v > 0.0 => -1.0,
            _ => 1.0,
        };
        turned
    }

    fn draw(&self, cell: &SearchPoint) -> SampledCell {
        let latents = cell.at[SHORT..].iter().map(latent).collect();
        cell_at(self.uncertain, &cell.at[..SHORT], latents, cell.noise)
    }
}

/// The standard normal at a share of a range, from −1 to 1.
pub(super) fn latent(share: &f64) -> f64 {
    match 0.5 * (1.0 + share) {
        u if (0.0..1.0).contains(&u) => Normal::standard().inverse_cdf(u).clamp(-END, END),
        u => END.copysign(u - 0.5),
    }
}

/// The cell at shares of the ranges of the short keys, with these latents.
pub(crate) fn cell_at(
    uncertain: &UncertainCell,
    at: &[f64],
    latents: Vec<f64>,
    noise: u64,
) -> SampledCell {
    let u = &uncertain.short;
    SampledCell {
        stiffness: [0, 1, 2, 3, 4, 5].map(|k| 1.0 + uncertain.stiffness(k) * at[k]),
        process: [6, 7, 8, 9, 10].map(|k| 1.0 + u.process * at[k]),
        ripple: [1.0 + u.ripple * at[11], PI * at[PHASE]],
        crosstalk: [13, 14].map(|k| u.crosstalk * at[k]),
        delay: 0.5 * (u.delay[0] + u.delay[1]) + 0.5 * (u.delay[1] - u.delay[0]) * at[15],
        noise,
        latents,
    }
}

/// What [`numbers`] are of, in their order.
pub(crate) fn names(uncertain: &UncertainCell) -> Vec<String> {
    let stiffness = (1..=6).map(|joint| format!("stiffness.A{joint}"));
    let others = [
        "process.depth",
        "process.feed_drag",
        "process.lateral_damping",
        "process.lateral_stiffness",
        "process.lateral_ratio",
        "ripple.size",
        "ripple.phase",
        "crosstalk.x",
        "crosstalk.y",
        "delay",
    ];
    let short = stiffness.chain(others.map(str::to_owned));
    short.chain(uncertain.latent_names().iter().cloned()).collect()
}

/// Where in the set a cell lies; 0 along what is known exactly.
pub(super) fn numbers(uncertain: &UncertainCell, draw: &SampledCell) -> Vec<f64> {
    let u = &uncertain.short;
    let share = |value: f64, half: f64| {
        if half > 0.0 { (value / half).clamp(-1.0, 1.0) } else { 0.0 }
    };
    let mut at = vec![0.0; SHORT];
    for k in 0..6 {
        at[k] = share(draw.stiffness[k] - 1.0, uncertain.stiffness(k));
    }
    for k in 0..5 {
        at[6 + k] = share(draw.process[k] - 1.0, u.process);
    }
    at[11] = share(draw.ripple[0] - 1.0, u.ripple);
    at[PHASE] = share(draw.ripple[1], PI);
    at[13] = share(draw.crosstalk[0], u.crosstalk);
    at[14] = share(draw.crosstalk[1], u.crosstalk);
    at[15] = share(draw.delay - 0.5 * (u.delay[0] + u.delay[1]), 0.5 * (u.delay[1] - u.delay[0]));
    at.extend(draw.latents.iter().map(|latent| 2.0 * Normal::standard().cdf(*latent) - 1.0));
    at
}

fn corner_of(cell: &SearchPoint) -> SearchPoint {
    let mut corner = cell.clone();
    for (k, v) in corner.at.iter_mut().enumerate() {
        if k != PHASE {
            *v = if *v < 0.0 { -1.0 } else { 1.0 };
        }
    }
    corner
}

/// A cell with every number that any of the others has otherwise.
fn together<'c>(cell: &SearchPoint, others: impl Iterator<Item = &'c SearchPoint>) -> SearchPoint {
    let mut sum = cell.clone();
    for other in others {
        for (v, (theirs, ours)) in sum.at.iter_mut().zip(other.at.iter().zip(&cell.at)) {
            if theirs != ours {
                *v = *theirs;
            }
        }
    }
    sum
}
