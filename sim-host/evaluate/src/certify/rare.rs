//! Rare failures: how probable a weld beyond any of the limits is, where plain draws would be too
//! many. Subset simulation over the numbers that the draws differ in, begun with the draws
//! themselves.

use super::subset::{Point, Subset, subset};
use super::worst::{SHORT, cell_at, latent, numbers};
use super::{Criterion, SampledCell, Trial, largest_share};
use crate::figure::Figure;
use crate::requirements::Requirements;
use crate::uncertain::UncertainCell;
use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, Normal};

/// What a rare failure is judged by.
pub(crate) static RARE_FIGURE: Figure =
    Figure { key: "of_limit", label: "largest share of any limit", unit: "1" };

/// Least draws that a subset simulation may begin with.
pub(crate) const FEWEST_DRAWS: usize = 100;

/// The simulation ends where failures are rarer than this share of what is allowed.
const ENOUGH: f64 = 0.1;

/// A subset simulation.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "RareEvidence", deny_unknown_fields)]
pub struct RareFailure {
    /// Probability of a weld beyond a limit that is allowed.
    pub allowed: f64,
    /// Levels, probability and its error.
    #[serde(flatten)]
    pub subset: Subset,
}

/// The probability of a weld beyond any of the limits, from the trials that were drawn and as many
/// runs a level. `run` makes the runs of a batch: of each cell, with its number. `nominal`: the run of
/// the cell as it is believed to be.
///
/// # Errors
/// Those of `run`.
pub fn rare_failure<E>(
    requirements: &Requirements,
    nominal: &Trial,
    uncertain: &UncertainCell,
    seed: u64,
    trials: &[Trial],
    allowed: f64,
    mut run: impl FnMut(&[(u64, SampledCell)]) -> Result<Vec<Trial>, E>,
) -> Result<RareFailure, E> {
    let limits = requirements.limits.iter().map(|limit| Criterion::new(limit, nominal));
    let limits: Vec<Criterion> = limits.collect();
    let worth = |trial: &Trial| match trial.failed {
        Some(_) => f64::INFINITY,
        None => largest_share(&limits, trial).map_or(0.0, |(_, share)| share),
    };
    let first = trials.iter().map(|trial| (point(uncertain, &trial.draw), worth(trial))).collect();
    let mut next = 0;
    // A figure at its limit, to the last digits, is within it.
    let limit = 1.0 + 1e-9;
    let subset = subset(first, limit, ENOUGH * allowed, seed, |points| {
        let first = next;
        next += points.len() as u64;
        let cells = points.iter().map(|point| cell(uncertain, point));
        let batch: Vec<(u64, SampledCell)> = (first..).zip(cells).collect();
        Ok(run(&batch)?.iter().map(worth).collect())
    })?;
    Ok(RareFailure { allowed, subset })
}

/// A cell by standard normals and the seed of its noise.
fn point(uncertain: &UncertainCell, draw: &SampledCell) -> Point {
    let mut normals: Vec<f64> = numbers(uncertain, draw).iter().map(latent).collect();
    normals.truncate(SHORT);
    normals.extend(&draw.latents);
    Point { normals, seed: draw.noise }
}

fn cell(uncertain: &UncertainCell, point: &Point) -> SampledCell {
    let share = |normal: &f64| 2.0 * Normal::standard().cdf(*normal) - 1.0;
    let short: Vec<f64> = point.normals[..SHORT].iter().map(share).collect();
    cell_at(uncertain, &short, point.normals[SHORT..].to_vec(), point.seed)
}
