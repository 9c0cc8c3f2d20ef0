//! Levenberg–Marquardt with a trust region, until the gradient shows that a fit has converged.
//!
//! Slopes are expensive and residuals cheap. Slopes are kept as long as the linear model predicts
//! what a step brings. They are taken anew where it does not, and before a fit counts as converged.

use super::Slopes;
use super::calibration::{in_proportion, is_in_proportion};
use super::{
    BLOCKS, EffectScope, FitProblem, FitState, FreeParameter, Linear, Residuals, SLOPE_STEP,
};
use super::{chi_square, count, residuals, residuals_near, slopes, step_to, value_at};
use crate::predict::{PredictError, Prediction};
use nalgebra::DVector;
use rayon::prelude::*;
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::Parameter;

/// A fitted point.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The values found.
    pub point: FitState,
    /// Residuals there.
    pub residuals: Residuals,
    /// Slopes of every free value there, or near there.
    pub slopes: Vec<Slopes>,
    /// The linear model there.
    pub linear: Linear,
    /// Sum of squares and priors.
    pub cost: f64,
    /// Why the fit ended.
    pub termination: Termination,
}

/// Why a fit ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Termination {
    /// The gradient, with slopes taken there, promises no more than chance.
    Converged,
    /// What new slopes brought is little of what is above the noise, or of no account.
    SmallDecrease,
    /// No step that the slopes ask for lowers the cost, however short: the cost is not smooth there,
    /// as with a gap.
    Stalled,
    /// The steps allowed are taken, or the time is up.
    StepLimit,
    /// The slopes do not promise what is asked for.
    Unpromising,
}

impl Termination {
    /// True where going on would hardly lower the cost.
    pub fn is_arrival(self) -> bool {
        matches!(self, Self::Converged | Self::SmallDecrease)
    }
}

/// How a fit is done.
#[derive(Debug, Clone, Copy)]
pub struct SolverOptions {
    /// Steps tried at most.
    pub steps: usize,
    /// Slopes that are taken once: those of the first so many free values.
    pub stale: usize,
    /// Cost that slopes taken at the point must promise for the fit to go on.
    pub goal: f64,
}

impl SolverOptions {
    /// So many steps, with the slopes of the first so many free values taken once.
    pub fn steps(steps: usize, stale: usize) -> Self {
        Self { steps, stale, goal: f64::INFINITY }
    }

    /// Until it converges.
    pub fn full(stale: usize) -> Self {
        Self::steps(40, stale)
    }
}

/// Fall of the cost promised by the gradient from which on a fit goes on, in what chance makes of a
/// residual: 0.5 is 0.7 standard deviations of all values together.
const CONVERGED_DECREASE: f64 = 0.5;

/// Share of the predicted fall of the cost from which on a step lets the trust region grow, and below
/// which it shrinks and slopes are taken anew.
const GAIN_RATIO_GOOD: f64 = 0.75;
const GAIN_RATIO_BAD: f64 = 0.4;

/// Share of the fall promised before a step by slopes taken elsewhere from which on what is promised
/// after it is too much for them: a dozen such steps cost what new slopes do.
const REMAINING_DECREASE_MAX: f64 = 0.5;

/// Fall of the cost from one refresh of the slopes to the next below which a fit is near enough, as a
/// share of what is above the noise; or less than what counts as converged, where slopes promise more than
/// steps bring, as with a gap.
const RELATIVE_DECREASE_MIN: f64 = 3e-3;

/// Damping of the first step, and from which on no step is short enough.
const DAMPING_INITIAL: f64 = 1e-4;
const DAMPING_MAX: f64 = 1e3;

/// The best step with every value within its bounds: one that would leave goes to its bound, and
/// the others are solved for again.
fn bounded(linear: &Linear, point: &FitState, damping: f64) -> Option<DVector<f64>> {
    let n = point.free.len();
    let mut free: Vec<usize> = (0..n).collect();
    let mut fixed = DVector::zeros(n);
    loop {
        let found = linear.solve_beside(&fixed, None, damping, Some(&free))?;
        let leaves = |k: usize| {
            room(point.parameter(&point.free[k]), point.value(&point.free[k]), found.step[k])
        };
        let out: Vec<(usize, f64)> = free.iter().filter_map(|k| Some((*k, leaves(*k)?))).collect();
        if out.is_empty() {
            return Some(found.step);
        }
        for (k, step) in out {
            fixed[k] = step;
            free.retain(|f| *f != k);
        }
    }
}

/// The step that just reaches the bound which a step would pass.
fn room(parameter: &Parameter, value: f64, step: f64) -> Option<f64> {
    let reached = value_at(parameter, value, step);
    if !parameter.is_at_bound(reached) {
        return None;
    }
    let (mut within, mut beyond) = (0.0, 1.0);
    for _ in 0..40 {
        let middle = 0.5 * (within + beyond);
        if value_at(parameter, value, middle * step) == reached {
            beyond = middle
        } else {
            within = middle
        }
    }
    Some(beyond * step)
}

/// Fits the free values of a point. `known`: slopes of the first free values, near the start.
///
/// # Errors
/// [`PredictError`] where the model cannot be driven through the logs at the start.
pub fn fit(
    problem: &FitProblem,
    start: &FitState,
    blocks: &[Vec<u8>],
    known: &[Slopes],
    options: SolverOptions,
) -> Result<Fitted, PredictError> {
    let at = residuals(problem, start)?;
    let known = &known[..known.len().min(start.free.len())];
    Ok(fit_from(problem, (start, at), blocks, (&Linear::empty(), known), options))
}

/// The same of a point whose first free values are those of another fit near it.
///
/// # Errors
/// [`PredictError`] where the model cannot be driven through the logs at the start.
pub fn fit_beside(
    problem: &FitProblem,
    start: &FitState,
    blocks: &[Vec<u8>],
    near: &Fitted,
    options: SolverOptions,
) -> Result<Fitted, PredictError> {
    let at = residuals(problem, start)?;
    Ok(fit_from(problem, (start, at), blocks, (&near.linear, &near.slopes), options))
}

/// Fits on from where a fit stands, with its slopes.
pub fn resume(
    problem: &FitProblem,
    fitted: &Fitted,
    blocks: &[Vec<u8>],
    options: SolverOptions,
) -> Fitted {
    let start = (&fitted.point, fitted.residuals.clone());
    fit_from(problem, start, blocks, (&fitted.linear, &fitted.slopes), options)
}

/// Fits the free values of a point, given with the residuals there. `known`: slopes of the first free
/// values, and the linear model with these of as many of them as it has.
fn fit_from(
    problem: &FitProblem,
    (start, at): (&FitState, Residuals),
    blocks: &[Vec<u8>],
    (near, known): (&Linear, &[Slopes]),
    options: SolverOptions,
) -> Fitted {
    let n = start.free.len();
    let stale = options.stale.min(n);
    // Where slopes are kept that bend, those that hardly do are too.
    let is_rough = stale > in_proportion(start);
    let mut all = known.to_vec();
    // True where the slopes that are taken more than once are those at the point.
    let mut fresh = all.len() <= stale;
    all.extend(slopes(problem, start, &start.free[all.len()..], &at, SLOPE_STEP));
    let mut here = Fitted {
        linear: renewed(near, blocks, (start, &at, &all), |_| false),
        point: start.clone(),
        residuals: at,
        slopes: all,
        cost: 0.0,
        termination: Termination::StepLimit,
    };
    here.cost = here.linear.cost(&DVector::zeros(n));
    let (mut damping, mut steps) = (DAMPING_INITIAL, 0);
    // What slopes taken elsewhere promised before the last step, and the cost when slopes were taken:
    // those that are taken more than once, and those of values that move a tool in contact.
    let (mut before, mut taken_at, mut touched_at) = (f64::INFINITY, f64::INFINITY, f64::INFINITY);
    if fresh {
        taken_at = here.cost;
    }
    if known.is_empty() {
        touched_at = here.cost;
    }
    // True where slopes were seen to fail.
    let mut slopes_failed = false;
    while steps < options.steps && !problem.is_late() {
        let inflation =
            (chi_square(&here.residuals) / count(&here.residuals).max(1) as f64).max(1.0);
        let promised = bounded(&here.linear, &here.point, 0.0)
            .map_or(f64::INFINITY, |step| here.cost - here.linear.cost(&step));
        let converged = promised < CONVERGED_DECREASE * inflation;
        if converged || slopes_failed || (!fresh && promised > REMAINING_DECREASE_MAX * before) {
            // Where the next slopes would hardly bring more than these did.
            let above_noise = here.cost - count(&here.residuals) as f64;
            let enough = (RELATIVE_DECREASE_MIN * above_noise).max(CONVERGED_DECREASE * inflation);
            if (converged && fresh) || taken_at - here.cost < enough {
                let touched = is_rough || touched_at - here.cost <= enough;
                if touched || !here.retouch(problem, blocks) {
                    here.termination = if converged && fresh {
                        Termination::Converged
                    } else {
                        Termination::SmallDecrease
                    };
                    break;
                }
                touched_at = here.cost;
            } else {
                taken_at = here.cost;
                here.refresh(problem, blocks, stale);
                fresh = true;
            }
            (before, slopes_failed) = (f64::INFINITY, false);
            continue;
        }
        before = if fresh { f64::INFINITY } else { promised };
        if fresh && here.cost - promised > options.goal {
            here.termination = Termination::Unpromising;
            break;
        }
        let Some(step) =
            bounded(&here.linear, &here.point, damping).filter(|_| damping < DAMPING_MAX)
        else {
            here.termination = Termination::Stalled;
            break;
        };
        steps += 1;
        let predicted = here.cost - here.linear.cost(&step);
        let next = here.point.moved(&step);
        let reached = residuals_near(problem, &next, Some(&here.residuals)).ok().map(|at| {
            let (prior, away) = next.priors();
            (chi_square(&at) + (prior * &away).dot(&away), at)
        });
        match reached.filter(|(cost, _)| *cost < here.cost) {
            Some((cost, at)) => {
                let share = (here.cost - cost) / predicted;
                (here.point, here.residuals, here.cost) = (next, at, cost);
                fresh = stale == n;
                if share < GAIN_RATIO_BAD {
                    damping = (damping * 4.0).max(1e-3);
                } else if share > GAIN_RATIO_GOOD {
                    damping = (damping * 0.1).max(1e-8);
                }
                slopes_failed = share < GAIN_RATIO_BAD && !fresh;
                here.renew(blocks, |_| false);
            }
            None if fresh => damping = (damping * 20.0).max(1e-3),
            None => {
                damping = damping.max(1e-3);
                slopes_failed = true;
            }
        }
    }
    here
}

/// The block of a log, where logs are left out whole.
fn log_block(log: usize) -> usize {
    log % BLOCKS
}

impl Fitted {
    /// Sum of squares of all blocks, each predicted from all the others.
    pub fn held_out(&self) -> f64 {
        self.linear.held_out(None).iter().sum()
    }

    /// Cost that the slopes promise at another point of the same free values.
    pub fn promised_at(&self, other: &FitState) -> f64 {
        let away = |free: &FreeParameter| {
            step_to(self.point.parameter(free), self.point.value(free), other.value(free))
        };
        let step = self.point.free.iter().map(away);
        self.linear.cost(&DVector::from_iterator(self.point.free.len(), step))
    }

    /// Sum of squares of all logs, each predicted with what the others tell; what a log has of its
    /// own is fitted to it. A log that cannot be predicted so makes it infinite.
    pub fn held_out_logs(&self, problem: &FitProblem) -> f64 {
        let block = |(log, at): (usize, &Prediction)| vec![log_block(log) as u8; at.residual.len()];
        let blocks: Vec<Vec<u8>> = self.residuals.iter().enumerate().map(block).collect();
        let here = (&self.point, &self.residuals, self.slopes.as_slice());
        let linear = renewed(&Linear::empty(), &blocks, here, |_| true);
        let points: Vec<Option<FitState>> =
            (0..BLOCKS).map(|block| self.point_from_others(&linear, block)).collect();
        let squares = |log: usize| {
            let effects = points[log_block(log)].as_ref()?.effects(problem, log);
            let near = Some((&self.residuals[log], None));
            let predicted = problem.logs[log].predict_from(&problem.model, &effects, near).ok()?;
            Some(predicted.residual.iter().map(|r| r * r).sum::<f64>())
        };
        let squares: Option<Vec<f64>> =
            (0..problem.logs.len()).into_par_iter().map(squares).collect();
        squares.map_or(f64::INFINITY, |squares| squares.iter().sum())
    }

    /// The point that the logs of all other blocks tell, but for what the block's own logs have of
    /// their own; `None` where they do not determine it. `linear`: with blocks of logs.
    fn point_from_others(&self, linear: &Linear, block: usize) -> Option<FitState> {
        let is_own = |k: &usize| match self.point.free[*k].of {
            EffectScope::Log(log, _) => log_block(log) == block,
            EffectScope::Shared(_) => false,
        };
        let own: Vec<usize> = (0..self.point.free.len()).filter(is_own).collect();
        Some(self.point.moved(&linear.step_from_others(block, &own)?))
    }

    /// Residuals of each log, every block in time predicted from all the others.
    pub fn residuals_from_others(&self, blocks: &[Vec<u8>]) -> Vec<Vec<f64>> {
        self.linear.residuals_from_others(blocks, &self.residuals, &self.slopes)
    }

    /// The same with residuals over the noise that is under the model: the linear model where the fit
    /// stands, which is no longer where it is best.
    pub fn in_own_noise(&self, blocks: &[Vec<u8>]) -> Self {
        let mut own = self.clone();
        for (log, at) in self.residuals.iter().enumerate() {
            at.divide_by_noise(&mut own.residuals[log].residual);
            let slopes = own.slopes.iter_mut().filter_map(|slopes| slopes[log].as_mut());
            slopes.for_each(|slope| at.divide_by_noise(slope));
            own.residuals[log].noise = None;
        }
        let (prior, away) = (self.linear.prior.clone(), self.linear.away.clone());
        let slopes: Vec<&Slopes> = own.slopes.iter().collect();
        let linear = Linear::new(blocks, &own.residuals, &slopes, prior, away);
        own.linear = Linear { held_out_prior: self.linear.held_out_prior.clone(), ..linear };
        own
    }

    /// Logarithm of the probability of each block in time given all the others, summed, but for a
    /// constant, nats. `precision`: what one unit of squared residual counts for, by log and value.
    pub fn log_score_from_others(&self, blocks: &[Vec<u8>], precision: &[Vec<f64>]) -> f64 {
        let at = (&self.residuals, self.slopes.as_slice());
        self.linear.log_score_from_others(blocks, at, precision)
    }

    /// Takes slopes anew where the fit stands, but for the first `stale` and for those of values that
    /// residuals are in proportion to.
    fn refresh(&mut self, problem: &FitProblem, blocks: &[Vec<u8>], stale: usize) {
        let bends = |k: &usize| !is_in_proportion(&self.point, &self.point.free[*k]);
        let anew: Vec<usize> = (stale..self.slopes.len()).filter(bends).collect();
        self.take(problem, blocks, anew);
    }

    /// Takes those slopes anew that are taken once because residuals are in proportion to their
    /// values, where a tool is in contact: what the plate makes of a tool that lies elsewhere is in
    /// proportion to that only nearby. False where there are none.
    fn retouch(&mut self, problem: &FitProblem, blocks: &[Vec<u8>]) -> bool {
        let welds = |log: usize| problem.logs[log].kind == LogKind::Weld;
        let moves = |k: &usize| match self.point.free[*k].of {
            EffectScope::Log(log, _) => welds(log),
            EffectScope::Shared(_) => {
                (0..problem.logs.len()).any(welds)
                    && is_in_proportion(&self.point, &self.point.free[*k])
            }
        };
        let anew: Vec<usize> = (0..self.slopes.len()).filter(moves).collect();
        if anew.is_empty() {
            return false;
        }
        self.take(problem, blocks, anew);
        true
    }

    /// Takes some slopes anew where the fit stands.
    fn take(&mut self, problem: &FitProblem, blocks: &[Vec<u8>], anew: Vec<usize>) {
        let free: Vec<FreeParameter> = anew.iter().map(|k| self.point.free[*k]).collect();
        let found = slopes(problem, &self.point, &free, &self.residuals, SLOPE_STEP);
        anew.iter().zip(found).for_each(|(k, slopes)| self.slopes[*k] = slopes);
        self.renew(blocks, |k| anew.contains(&k));
    }

    /// The linear model where the fit stands, with other slopes of those for which `is_new` is true.
    fn renew(&mut self, blocks: &[Vec<u8>], is_new: impl Fn(usize) -> bool) {
        let here = (&self.point, &self.residuals, self.slopes.as_slice());
        self.linear = renewed(&self.linear, blocks, here, is_new);
    }

    /// The same slopes beside other residuals.
    pub fn beside(&self, blocks: &[Vec<u8>], at: &Residuals) -> Linear {
        self.linear.renewed(blocks, at, &self.slopes.iter().collect::<Vec<_>>(), |_| false)
    }
}

/// The linear model at a point, from one with other residuals, fewer values or, of those for which `is_new`
/// is true, other slopes.
fn renewed(
    near: &Linear,
    blocks: &[Vec<u8>],
    (point, at, slopes): (&FitState, &Residuals, &[Slopes]),
    is_new: impl Fn(usize) -> bool,
) -> Linear {
    let slopes: Vec<&Slopes> = slopes.iter().collect();
    let (prior, away) = point.priors();
    let held_out_prior = point.held_out_prior();
    Linear { prior, away, held_out_prior, ..near.renewed(blocks, at, &slopes, is_new) }
}
