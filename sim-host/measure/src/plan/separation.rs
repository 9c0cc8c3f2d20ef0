//! By how much an experiment would tell two models apart once either was refitted to what the other makes of it.
//!
//! With D the difference of their predictions over the noise, S the slopes of the second model's residuals by all that may be
//! refitted, and P what is known of those values before (priors, and what the logs so far say), the least sum of squares that
//! the second leaves of the first is
//!
//! ```text
//! Δχ² = DᵀD − DᵀS (SᵀS + P)⁻¹ SᵀD
//! ```

use crate::calibrate::{calibrations, expected, is_calibration};
use crate::fit::{self, Bench, Free, Of, Point, Residuals};
use crate::predict::Experiment;
use nalgebra::{DMatrix, DVector};
use trueweld_plant::effects::{At, Effect};

/// Share of a fit's unit over which slopes are taken.
const STEP: f64 = 0.1;

/// One rival explanation: effects as fitted, what of them and of the calibrations may be refitted for all logs, and how well it
/// is known.
#[derive(Debug)]
pub(super) struct Rival {
    /// Effects for all logs, with the values of the rival; calibrations among them.
    all: Vec<Effect>,
    /// Which of their values are free.
    free: Vec<Free>,
    /// Inverse covariance of those values, priors and logs so far together, in the fit's units.
    known: DMatrix<f64>,
    /// Least sum of squares and priors over the logs so far.
    pub cost: f64,
}

impl Rival {
    /// What the logs so far say of a rival. `claimed`: calibrations that an explanation consists of, which no other may use.
    /// `None` where the rival cannot be driven through them.
    pub fn of(bench: &Bench, effects: &[Effect], claimed: &[(&'static str, At)]) -> Option<Self> {
        let mut point = unclaimed(calibrations(bench), claimed);
        for effect in effects {
            let expected = match is_calibration(effect.kind) {
                true => expected(effect.kind.id),
                false => vec![f64::INFINITY; effect.kind.parameters.len()],
            };
            point.add_expected(effect.clone(), &expected);
        }
        let at = fit::residuals(bench, &point).ok()?;
        let slopes = fit::slopes(bench, &point, &point.free, &at, STEP);
        let n = point.free.len();
        let mut normal = DMatrix::zeros(n, n);
        let mut slope = DVector::zeros(n);
        for log in 0..bench.experiments.len() {
            let seen: Vec<(usize, &[f64])> =
                slopes.iter().enumerate().filter_map(|(k, s)| s[log].as_deref().map(|c| (k, c))).collect();
            add_normal(&mut normal, &mut slope, &seen, &at[log].residual);
        }
        // Where the model misses more than noise, the logs say less of its values than their noise would have it.
        let count = fit::count(&at).max(1) as f64;
        let square = fit::chi_square(&at);
        let step = solve(&with_priors(&normal, &point), &slope)?;
        let cost = square - slope.dot(&step);
        let trust = (cost / count).max(1.0);
        let known = with_priors(&(normal / trust), &point);
        // What each log has of its own is eliminated.
        let is_shared = |k: &usize| matches!(point.free[*k].of, Of::All(_));
        let (shared, own): (Vec<usize>, Vec<usize>) = (0..n).partition(is_shared);
        let part = |rows: &[usize], columns: &[usize]| {
            DMatrix::from_fn(rows.len(), columns.len(), |i, j| known[(rows[i], columns[j])])
        };
        let mut left = part(&shared, &shared);
        if !own.is_empty() {
            let cross = part(&own, &shared);
            left -= cross.tr_mul(&regular(part(&own, &own)).cholesky()?.solve(&cross));
        }
        let free = shared.iter().map(|k| point.free[*k]).collect();
        Some(Self { all: point.all, free, known: left, cost })
    }

    /// The rival on one new log, whose own calibrations are free as well.
    fn on(&self, bench: &Bench, claimed: &[(&'static str, At)]) -> Point {
        let fresh = unclaimed(calibrations(bench), claimed);
        let mut point = Point { all: self.all.clone(), each: fresh.each.clone(), free: self.free.clone() };
        for free in fresh.free {
            match free.of {
                Of::Log(..) => point.free.push(free),
                Of::All(i) => {
                    let effect = &fresh.all[i];
                    if !self.all.iter().any(|e| (e.kind.id, e.at) == (effect.kind.id, effect.at)) {
                        let of = Of::All(point.all.len());
                        point.all.push(effect.clone());
                        point.free.push(Free { of, ..free });
                    }
                }
            }
        }
        point
    }
}

/// Calibrations but those that an explanation consists of.
fn unclaimed(mut point: Point, claimed: &[(&'static str, At)]) -> Point {
    let free = std::mem::take(&mut point.free);
    let is_claimed = |effect: &Effect| claimed.contains(&(effect.kind.id, effect.at));
    point.free = free.into_iter().filter(|f| !is_claimed(point.effect(f.of))).collect();
    point
}

/// A new experiment, ready to be predicted.
#[derive(Debug)]
pub(super) struct Trial {
    bench: Bench,
}

impl Trial {
    pub fn new(bench: &Bench, experiment: Experiment) -> Self {
        Self { bench: Bench { model: bench.model.clone(), known: bench.known.clone(), experiments: vec![experiment] } }
    }

    /// True where the experiment can show anything of an effect.
    pub fn concerns(&self, effects: &[Effect]) -> bool {
        effects.iter().any(|e| self.bench.experiments[0].concerns(e))
    }

    fn at(&self, point: &Point) -> Option<Residuals> {
        fit::residuals(&self.bench, point).ok()
    }

    /// Difference of two rivals' predictions, in standard deviations of all compared values together: what refitting can only
    /// make less.
    pub fn apart(&self, a: &[Effect], b: &[Effect]) -> Option<f64> {
        let point = |effects: &[Effect]| Point { all: effects.to_vec(), each: vec![Vec::new()], free: Vec::new() };
        let (a, b) = (self.at(&point(a))?, self.at(&point(b))?);
        let square: f64 = a[0].residual.iter().zip(&b[0].residual).map(|(a, b)| (a - b).powi(2)).sum();
        square.is_finite().then(|| square.sqrt())
    }

    /// Expected √Δχ² between two rivals, whichever of them is true and the other refitted: the smaller of both.
    pub fn separation(&self, a: &Rival, b: &Rival, claimed: &[(&'static str, At)]) -> Option<f64> {
        let (on_a, on_b) = (a.on(&self.bench, claimed), b.on(&self.bench, claimed));
        let (at_a, at_b) = (self.at(&on_a)?, self.at(&on_b)?);
        let difference: Vec<f64> = at_b[0].residual.iter().zip(&at_a[0].residual).map(|(b, a)| b - a).collect();
        let one = self.left(b, &on_b, &at_b, &difference)?;
        let other = self.left(a, &on_a, &at_a, &difference)?;
        let least = one.min(other);
        least.is_finite().then(|| least.max(0.0).sqrt())
    }

    /// What a refit of a rival leaves of a difference.
    fn left(&self, rival: &Rival, point: &Point, at: &Residuals, difference: &[f64]) -> Option<f64> {
        let slopes = fit::slopes(&self.bench, point, &point.free, at, STEP);
        let n = point.free.len();
        let mut normal = DMatrix::zeros(n, n);
        let mut slope = DVector::zeros(n);
        let seen: Vec<(usize, &[f64])> =
            slopes.iter().enumerate().filter_map(|(k, s)| s[0].as_deref().map(|c| (k, c))).collect();
        add_normal(&mut normal, &mut slope, &seen, difference);
        let before = rival.free.len();
        let mut known = DMatrix::zeros(n, n);
        known.view_mut((0, 0), (before, before)).copy_from(&rival.known);
        let own = Point { free: point.free[before..].to_vec(), ..point.clone() };
        for (k, weight) in weights(&own).enumerate() {
            known[(before + k, before + k)] = weight;
        }
        let step = solve(&(normal + known), &slope)?;
        Some(difference.iter().map(|d| d * d).sum::<f64>() - slope.dot(&step))
    }
}

/// Adds AᵀA and Aᵀr of one log.
fn add_normal(normal: &mut DMatrix<f64>, slope: &mut DVector<f64>, seen: &[(usize, &[f64])], residual: &[f64]) {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    for (i, (k, a)) in seen.iter().enumerate() {
        slope[*k] += dot(a, residual);
        for (l, b) in &seen[..=i] {
            let product = dot(a, b);
            normal[(*k, *l)] += product;
            if k != l {
                normal[(*l, *k)] += product;
            }
        }
    }
}

/// Weight of each free value's prior, in the fit's units.
fn weights(point: &Point) -> impl Iterator<Item = f64> {
    point.free.iter().map(|free| (fit::unit(point.parameter(free), point.value(free)) / free.expected).powi(2))
}

fn with_priors(normal: &DMatrix<f64>, point: &Point) -> DMatrix<f64> {
    let mut normal = normal.clone();
    for (k, weight) in weights(point).enumerate() {
        normal[(k, k)] += weight;
    }
    normal
}

/// A little on the diagonal: a value that nothing depends on stays where it is.
fn regular(mut matrix: DMatrix<f64>) -> DMatrix<f64> {
    for k in 0..matrix.nrows() {
        let own = matrix[(k, k)];
        matrix[(k, k)] = if own > 0.0 { own * (1.0 + 1e-9) } else { 1.0 };
    }
    matrix
}

fn solve(normal: &DMatrix<f64>, slope: &DVector<f64>) -> Option<DVector<f64>> {
    Some(regular(normal.clone()).cholesky()?.solve(slope))
}
