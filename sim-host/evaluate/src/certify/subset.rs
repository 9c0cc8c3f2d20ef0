//! Subset simulation: the probability of a rare event as a product of larger ones, each that of a
//! level given the one before (Au and Beck, Probabilistic Engineering Mechanics 16 (2001) 263).
//!
//! The first level are independent points; every later one continues the best tenth of the level
//! before as Markov chains that do not fall below their level. The chains move by the conditional
//! proposal with a step that adapts to their acceptance (Papaioannou, Betz, Zwirglmaier and Straub,
//! Probabilistic Engineering Mechanics 41 (2015) 89). What a point is worth may depend on a seed
//! beside its coordinates: every other proposal draws a new one, which leaves its distribution as it
//! is.
//!
//! The error follows from the number of points and from the correlation along the chains, as Au and
//! Beck have it, with the levels taken as if their errors all went the same way: the points of a
//! level descend from the best of the one before. It assumes that the chains get about; acceptance and
//! correlation of every level are kept to judge that by.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// Share of a level's points that the next one continues, in tenths of all: 1 of so many.
const CHAIN: usize = 10;

/// Acceptance that the step of the chains adapts to.
const ACCEPTANCE: f64 = 0.44;

/// A point: independent standard normals, and a seed.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Point {
    /// Standard normals.
    pub normals: Vec<f64>,
    /// Any number.
    pub seed: u64,
}

/// A level of a subset simulation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "RareLevel", deny_unknown_fields)]
pub struct Level {
    /// Least share of any limit in its cells; `null` in the first, which are the draws.
    #[schemars(with = "Option<f64>")]
    pub from: f64,
    /// Cells.
    pub cells: usize,
    /// Share of them beyond the next level, of the last one beyond a limit.
    pub share: f64,
    /// Share of the moves that were accepted.
    pub acceptance: f64,
    // 0 for independent ones.
    /// By how much more correlation makes the variance of the share.
    pub correlation: f64,
}

/// What a subset simulation comes to.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Subset {
    /// The probability; where `reached` is false that of the last level, which failures are rarer
    /// than.
    pub probability: f64,
    /// Its coefficient of variation.
    pub variation: f64,
    /// Whether cells beyond a limit were found.
    pub reached: bool,
    /// Runs beside the draws.
    pub runs: usize,
    /// Every level.
    pub levels: Vec<Level>,
    /// What a point must be worth more than.
    #[serde(skip)]
    pub limit: f64,
}

impl Subset {
    /// What is reached or exceeded, and how probably: the levels, and the limit where it was reached.
    pub fn curve(&self) -> Vec<(f64, f64)> {
        let mut probability = 1.0;
        let mut curve = Vec::new();
        for (k, level) in self.levels.iter().enumerate() {
            probability *= level.share;
            match self.levels.get(k + 1) {
                Some(next) => curve.push((next.from, probability)),
                None if self.reached => curve.push((self.limit, probability)),
                None => {}
            }
        }
        curve
    }

    /// What is exceeded with a probability, between the places of the curve by the logarithm of theirs;
    /// the end of the curve where it does not go so far.
    pub fn quantile(&self, probability: f64) -> f64 {
        let curve = self.curve();
        let later = curve.iter().position(|(_, p)| *p <= probability);
        match (later, curve.last()) {
            (Some(0), Some(_)) => curve[0].0,
            (Some(k), Some(_)) => {
                let [(a, p), (b, q)] = [curve[k - 1], curve[k]];
                a + (b - a) * (probability / p).ln() / (q / p).ln()
            }
            (None, Some(end)) => end.0,
            (_, None) => f64::INFINITY,
        }
    }

    /// The probability is at most this, with so much confidence.
    pub fn at_most(&self, confidence: f64) -> f64 {
        (self.probability * self.factor(confidence)).min(1.0)
    }

    /// The probability is at least this, with so much confidence; 0 where the limit was not
    /// reached.
    pub fn at_least(&self, confidence: f64) -> f64 {
        if self.reached { self.probability / self.factor(confidence) } else { 0.0 }
    }

    /// Of a lognormal estimate.
    fn factor(&self, confidence: f64) -> f64 {
        let spread = self.variation.powi(2).ln_1p().sqrt();
        (spread * Normal::standard().inverse_cdf(confidence)).exp()
    }
}

/// The probability that a point is worth more than `limit`.
///
/// `first`: independent points and what they are worth, ten at least; every later level has as many,
/// but for a remainder of ten. `enough`: the simulation ends without having reached the limit once
/// the level is rarer than this. `worth` says of a batch what its points are worth; of one seed the
/// points asked for depend on what earlier ones came to, and on nothing else.
///
/// # Errors
/// Those of `worth`.
pub(crate) fn subset<E>(
    first: Vec<(Point, f64)>,
    limit: f64,
    enough: f64,
    seed: u64,
    mut worth: impl FnMut(&[Point]) -> Result<Vec<f64>, E>,
) -> Result<Subset, E> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let chains = first.len() / CHAIN;
    let mut subset = Subset {
        probability: 1.0,
        variation: 0.0,
        reached: false,
        runs: 0,
        levels: Vec::new(),
        limit,
    };
    // What the points of a level are worth, step by step of its chains.
    let mut steps: Vec<Vec<(Point, f64)>> = vec![first];
    let (mut from, mut acceptance, mut step) = (f64::NEG_INFINITY, 1.0, 0.6);
    loop {
        let mut points: Vec<&(Point, f64)> = steps.iter().flatten().collect();
        points.sort_by(|a, b| b.1.total_cmp(&a.1));
        let n = points.len();
        let beyond = points.iter().filter(|(_, worth)| *worth > limit).count();
        subset.reached = beyond >= chains;
        let next = if subset.reached || chains == 0 { limit } else { points[chains - 1].1 };
        let is_next = |worth: f64| if subset.reached { worth > limit } else { worth >= next };
        let share = points.iter().filter(|(_, worth)| is_next(*worth)).count() as f64 / n as f64;
        let correlation = match subset.levels.is_empty() {
            true => 0.0,
            false => correlation(&steps, share, is_next),
        };
        subset.levels.push(Level { from, cells: n, share, acceptance, correlation });
        subset.probability *= share;
        if share > 0.0 {
            subset.variation += ((1.0 - share) / (share * n as f64) * (1.0 + correlation)).sqrt();
        }
        // All alike: there is no next level.
        let stuck = next <= from || share >= 1.0;
        if subset.reached || subset.probability < enough || stuck || chains == 0 {
            return Ok(subset);
        }
        let best: Vec<(Point, f64)> = points[..chains].iter().map(|p| (*p).clone()).collect();
        from = next;
        let spread = spread(&best);
        let (mut accepted, mut tried) = (0, 0);
        steps = vec![best];
        for k in 1..CHAIN {
            let before = &steps[k - 1];
            let proposed: Vec<Point> = before
                .iter()
                .map(|(point, _)| propose(point, &spread, step, &mut random))
                .collect();
            let values = worth(&proposed)?;
            subset.runs += proposed.len();
            let moved = proposed.into_iter().zip(values);
            let (mut here, mut kept) = (Vec::with_capacity(chains), 0);
            for (new, old) in moved.zip(before) {
                if new.1 >= from {
                    kept += 1;
                    here.push(new);
                } else {
                    here.push(old.clone());
                }
            }
            accepted += kept;
            tried += chains;
            let rate = kept as f64 / chains as f64;
            step = (step.ln() + (rate - ACCEPTANCE) / (k as f64).sqrt()).exp().clamp(0.05, 2.0);
            steps.push(here);
        }
        acceptance = f64::from(accepted as u32) / f64::from(tried as u32);
    }
}

/// Standard deviation of every coordinate.
fn spread(points: &[(Point, f64)]) -> Vec<f64> {
    let n = points.len() as f64;
    let of = |k: usize| {
        let each = || points.iter().map(|(point, _)| point.normals[k]);
        let mean = each().sum::<f64>() / n;
        (each().map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt()
    };
    (0..points.first().map_or(0, |(point, _)| point.normals.len())).map(of).collect()
}

/// A point near another, from a kernel that leaves independent standard normals as they are.
fn propose(point: &Point, spread: &[f64], step: f64, random: &mut ChaCha8Rng) -> Point {
    let mut near = |(x, spread): (&f64, &f64)| {
        let width = (step * spread).min(1.0);
        // Between the ends, so that the quantile is finite.
        let u = random.random::<f64>().clamp(1e-16, 1.0 - 1e-16);
        (1.0 - width * width).sqrt() * x + width * Normal::standard().inverse_cdf(u)
    };
    let normals = point.normals.iter().zip(spread).map(&mut near).collect();
    let (seed, keep): (u64, bool) = (random.random(), random.random());
    Point { normals, seed: if keep { point.seed } else { seed } }
}

/// Σ 2 (1 − k/l) r(k) over the lags of chains of l steps, r the correlation of being beyond the next
/// level (Au and Beck, equation 29).
fn correlation(steps: &[Vec<(Point, f64)>], share: f64, is_next: impl Fn(f64) -> bool) -> f64 {
    let (length, chains) = (steps.len(), steps[0].len());
    let variance = share * (1.0 - share);
    if variance <= 0.0 {
        return 0.0;
    }
    let of_lag = |lag: usize| {
        let pairs = (0..length - lag).flat_map(|k| steps[k].iter().zip(&steps[k + lag]));
        let both = pairs.filter(|(a, b)| is_next(a.1) && is_next(b.1)).count() as f64;
        let r = both / ((length - lag) * chains) as f64 - share * share;
        2.0 * (1.0 - lag as f64 / length as f64) * r / variance
    };
    (1..length).map(of_lag).sum::<f64>().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::convert::Infallible;

    fn normal(random: &mut ChaCha8Rng) -> f64 {
        Normal::standard().inverse_cdf(random.random::<f64>().clamp(1e-16, 1.0 - 1e-16))
    }

    /// The simulation of `worth` with 400 points a level.
    fn simulated(
        dimensions: usize,
        seed: u64,
        limit: f64,
        worth: impl Fn(&Point) -> f64,
    ) -> Subset {
        let mut random = ChaCha8Rng::seed_from_u64(1000 + seed);
        let mut point = || Point {
            normals: (0..dimensions).map(|_| normal(&mut random)).collect(),
            seed: random.random(),
        };
        let first = (0..400).map(|_| point()).map(|p| (p.clone(), worth(&p))).collect();
        let batch = |points: &[Point]| Ok::<_, Infallible>(points.iter().map(&worth).collect());
        subset(first, limit, 1e-7, seed, batch).unwrap()
    }

    /// Of 100 simulations 95 % bound the probability from above, and 95 % from below; 90 or fewer
    /// have a probability of 3 %. Their mean is the probability, but for its standard error and a bias
    /// of the order of one over the points of a chain's start.
    fn assert_covered(probability: f64, run: impl Fn(u64) -> Subset) {
        let all: Vec<Subset> = (0..100).map(run).collect();
        let count = |is: &dyn Fn(&Subset) -> bool| all.iter().filter(|subset| is(subset)).count();
        assert_eq!(count(&|subset| subset.reached), 100);
        let above = count(&|subset| subset.at_most(0.95) >= probability);
        let below = count(&|subset| subset.at_least(0.95) <= probability);
        assert!(above > 90 && below > 90, "{above}, {below}");
        let mean = all.iter().map(|subset| subset.probability).sum::<f64>() / 100.0;
        let square = all.iter().map(|subset| (subset.probability - mean).powi(2)).sum::<f64>();
        let error = 3.0 * (square / 99.0 / 100.0).sqrt() + 0.1 * probability;
        assert!((mean - probability).abs() < error, "{mean:.2e} ± {error:.2e}, {probability:.2e}");
    }

    #[test]
    fn a_sum_of_sixty_numbers_has_the_probability_of_a_normal() {
        let probability: f64 = 1e-4;
        let limit = -Normal::standard().inverse_cdf(probability);
        let sum = |p: &Point| p.normals.iter().sum::<f64>() / 60f64.sqrt();
        assert_covered(probability, |seed| simulated(60, seed, limit, sum));
    }

    #[test]
    fn noise_behind_a_seed_counts_like_any_other_number() {
        let probability: f64 = 1e-4;
        let limit = -Normal::standard().inverse_cdf(probability);
        let noisy = |p: &Point| {
            let noise = normal(&mut ChaCha8Rng::seed_from_u64(p.seed));
            0.8 * p.normals.iter().sum::<f64>() / 20f64.sqrt() + 0.6 * noise
        };
        assert_covered(probability, |seed| simulated(20, seed, limit, noisy));
    }

    #[test]
    fn a_million_plain_draws_agree_where_failures_lie_in_several_places() {
        let worth = |p: &Point| {
            let x = &p.normals;
            (x[0] + x[1] * x[1] / 3.0).max(x[2] * x[3] - 1.0).max((x[4] + x[5] - x[6]) / 1.2)
        };
        let mut random = ChaCha8Rng::seed_from_u64(5);
        let mut beyond = 0;
        for _ in 0..1_000_000 {
            let normals = (0..8).map(|_| normal(&mut random)).collect();
            beyond += usize::from(worth(&Point { normals, seed: 0 }) > 6.0);
        }
        let plain = beyond as f64 / 1e6;
        assert_covered(plain, |seed| simulated(8, seed, 6.0, worth));
    }

    #[test]
    fn what_cannot_happen_is_rarer_than_was_looked_for() {
        let bounded = |p: &Point| p.normals[0].tanh();
        let subset = simulated(3, 1, 2.0, bounded);
        assert!(!subset.reached && subset.probability < 1e-7, "{subset:?}");
        assert_eq!(subset.at_least(0.95), 0.0);
        assert!(subset.quantile(1e-3) < 1.0 && subset.quantile(1e-3) > 0.99, "{subset:?}");
        // Of equals no next level can be told apart.
        let equal = simulated(3, 1, 2.0, |_| 1.0);
        assert!(!equal.reached && equal.probability >= 1.0, "{equal:?}");
    }
}
