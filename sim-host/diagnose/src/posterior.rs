//! What logs leave open of the numbers of a cell, all of them together: the posterior of a model.
//!
//! An improved model lists the calibrations that count. What does not count is not known exactly
//! either: here every calibration that the logs could show is free beside the effects, and so are the
//! model's own numbers that no calibration is (friction, the tool's mass, gains of the process). What
//! the logs say next to nothing of is left out, and named. Values of one log (a tracker
//! registered, an encoder zeroed) become a mean and what they vary by from log to log.
//!
//! Left out: a distribution that is not normal, such as one of a value at its bound, which is told.

use crate::found::{effects_of, same_effects};
use crate::improve::{Improved, Improvement};
use crate::score;
use nalgebra::{DMatrix, DVector};
use trueweld_estimate::encoder_noise;
use trueweld_estimate::fit::calibration::{in_proportion, is_calibration};
use trueweld_estimate::fit::covariance::{columns, covariance};
use trueweld_estimate::fit::{
    self, EffectScope, FitProblem, FitState, Fitted, Linear, SolverOptions,
};
use trueweld_estimate::predict::PredictError;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Action, Effect, EffectKind, Parameter, Role, library};
use trueweld_plant::input::{InputError, MeasuredNumber, Posterior, RobotFile};
use trueweld_plant::provenance::{FileDigest, sha256};

/// Why there is no posterior.
#[derive(Debug, thiserror::Error)]
pub enum PosteriorError {
    /// The model cannot be driven through the logs.
    #[error(transparent)]
    Predict(#[from] PredictError),
    /// A file that cannot be read again.
    #[error(transparent)]
    Input(#[from] InputError),
}

/// Deviation of a calibration, as a share of what was expected of it before, up to which it counts as
/// measured.
const MEASURED_DEVIATION_MAX: f64 = 0.5;

/// The same of another number of the model, as a share of its plausible range.
const MEASURED_OF_RANGE: f64 = 0.05;

/// Variance over what residuals alone make of it, where there is no time to ask for the encoders' part.
const LEFT_OUT_UNASKED: f64 = 2.0;

/// Steps that values take once the model's own numbers are free beside them.
const POSTERIOR_FIT_STEPS: usize = 6;

/// The posterior of an improvement, not sealed yet. `logs`: those that the problem's logs were
/// made of.
///
/// # Errors
/// [`PosteriorError`].
pub fn posterior(
    problem: &FitProblem,
    logs: &[Log],
    improved: &Improved,
    robot: &RobotFile,
) -> Result<Posterior, PosteriorError> {
    let mut files = Vec::new();
    for path in logs.iter().flat_map(|log| &log.files) {
        files.push(FileDigest::of_file("log", path)?.sha256);
    }
    let campaign = sha256(files.concat().as_bytes());
    let of = of_fit(problem, logs, &with_all_calibrations(problem, improved)?, robot)?;
    // The score that the improvement tells, where nothing was fitted.
    let told =
        improved.improvement.steps.last().map(|step| step.held_out).filter(|s| s.is_finite());
    Ok(Posterior { campaign, score: told.unwrap_or(of.score), ..of })
}

/// The posterior of effects that were fitted with every calibration free beside them. `logs`: those
/// that the problem's logs were made of; their digest is left to who has the files.
///
/// # Errors
/// [`PredictError`].
pub fn of_fit(
    problem: &FitProblem,
    logs: &[Log],
    full: &Fitted,
    robot: &RobotFile,
) -> Result<Posterior, PredictError> {
    let blocks = fit::blocks_of(problem);
    let mut point = full.point.clone();
    for effect in own_numbers(problem, &point) {
        let ranges: Vec<f64> = effect.kind.parameters.iter().map(range_deviation).collect();
        let expected = problem.deviations(&effect, &ranges).to_vec();
        point.add_expected(effect, &expected);
    }
    // With the slopes that are there: what is added is small, and residuals are in proportion to it.
    let options = SolverOptions::steps(POSTERIOR_FIT_STEPS, point.free.len());
    let fitted = fit::fit(problem, &point, &blocks, &full.slopes, options)?;
    let mut posterior = Posterior {
        numbers: Vec::new(),
        covariance: Vec::new(),
        logs: problem.logs.iter().map(|log| log.name.clone()).collect(),
        campaign: String::new(),
        score: score(&fitted.residuals),
        at_bound: Vec::new(),
        undetermined: Vec::new(),
        not_measured: Vec::new(),
        seal: String::new(),
    };
    tell(problem, logs, &fitted, robot, &mut posterior)?;
    Ok(posterior)
}

/// The fit of the improved model's effects with every calibration free beside them: one that the
/// diagnosis has made, or else a new one.
fn with_all_calibrations(
    problem: &FitProblem,
    Improved { diagnosis, fitted, .. }: &Improved,
) -> Result<Fitted, PredictError> {
    let made = || [&diagnosis.null, &diagnosis.full].into_iter().chain(&diagnosis.chosen);
    let Some(reached) = fitted else { return Ok(diagnosis.null.clone()) };
    if let Some(fitted) = made().find(|fitted| same_effects(fitted, reached)) {
        return Ok(fitted.clone());
    }
    let mut point = diagnosis.null.point.clone();
    point.reset(|effect| is_calibration(effect.kind));
    effects_of(reached).into_iter().for_each(|i| point.add(reached.point.shared[i].clone()));
    let options = SolverOptions::full(in_proportion(&point));
    fit::fit(problem, &point, &fit::blocks_of(problem), &[], options)
}

/// Effects that are other values of the model's own numbers, which a point does not have and the
/// logs could show.
fn own_numbers(problem: &FitProblem, point: &FitState) -> Vec<Effect> {
    let is_own = |kind: &&EffectKind| {
        let process = matches!(kind.action, Action::Process(_));
        (process || kind.adds_to.is_some()) && kind.parameters.iter().all(Parameter::is_size)
    };
    let has = |effect: &Effect| {
        let mut all = point.shared.iter().chain(point.per_log.iter().flatten());
        all.any(|e| {
            let stands_for = e.kind.stands_for.map(|kind| kind.id);
            e.at == effect.at && (e.kind.id == effect.kind.id || stands_for == Some(effect.kind.id))
        })
    };
    let kinds = library().filter(|kind| is_own(kind) && kind.calibration.is_none());
    let all = kinds.flat_map(|kind| kind.places().into_iter().map(|at| kind.neutral(at)));
    let all = all.filter(|e| !problem.is_known(e.kind, e.at));
    all.filter(|e| !has(e) && problem.logs.iter().any(|log| log.concerns(e))).collect()
}

/// Standard deviation of a value of which only its plausible range is known.
fn range_deviation(parameter: &Parameter) -> f64 {
    (parameter.high - parameter.low) / 12f64.sqrt()
}

/// One number of a cell among the free values of a fit.
struct FreeNumber {
    effect: Effect,
    parameter: usize,
    /// Free values whose mean it is.
    of: Vec<usize>,
    per_log: bool,
    /// Standard deviation expected before; infinite where nothing was.
    expected: f64,
}

impl FreeNumber {
    fn name(&self, robot: &RobotFile) -> String {
        self.effect.number_name(self.parameter, robot)
    }
}

fn candidates(fitted: &Fitted) -> Vec<FreeNumber> {
    let mut found: Vec<FreeNumber> = Vec::new();
    for (k, free) in fitted.point.free.iter().enumerate() {
        let effect = fitted.point.effect(free.of);
        let per_log = matches!(free.of, EffectScope::Log(..));
        let same = |c: &&mut FreeNumber| {
            c.per_log && (c.effect.place(), c.parameter) == (effect.place(), free.parameter)
        };
        match found.iter_mut().find(same).filter(|_| per_log) {
            Some(candidate) => candidate.of.push(k),
            None => found.push(FreeNumber {
                effect: effect.clone(),
                parameter: free.parameter,
                of: vec![k],
                per_log,
                expected: free.expected,
            }),
        }
    }
    found
}

/// Fills in the numbers that the fit determines, with their covariance, and names the others.
fn tell(
    problem: &FitProblem,
    logs: &[Log],
    fitted: &Fitted,
    robot: &RobotFile,
    posterior: &mut Posterior,
) -> Result<(), PredictError> {
    let point = &fitted.point;
    let n = point.free.len();
    // The size of one unit of the fit, with its sign, and a weak prior that keeps every direction
    // within what is plausible.
    let unit = DVector::from_fn(n, |k, _| {
        let (parameter, value) = (point.parameter(&point.free[k]), point.value(&point.free[k]));
        let sign = if matches!(parameter.role, Role::Reciprocal { .. }) { -1.0 } else { 1.0 };
        sign * fit::unit(parameter, value)
    });
    let mut prior = fitted.linear.prior.clone();
    for (k, free) in point.free.iter().enumerate().filter(|(_, f)| !f.expected.is_finite()) {
        prior[(k, k)] += (unit[k] / range_deviation(point.parameter(free))).powi(2);
    }
    let linear = Linear { prior, ..fitted.linear.clone() };
    let Some(of_fit) = covariance(&linear, &columns(problem), &fitted.residuals, &fitted.slopes)
    else {
        // The curvature is singular: nothing that was fitted is measured.
        posterior.not_measured.extend(candidates(fitted).iter().map(|of| of.name(robot)));
        return Ok(());
    };
    // Drives all logs again: not where nothing was measured, nor where time is up.
    let covariance = if problem.is_late() {
        LEFT_OUT_UNASKED * of_fit
    } else {
        of_fit + encoder_noise::covariance(problem, logs, fitted, &linear.prior)?
    };
    let of_values = covariance.component_mul(&(&unit * unit.transpose()));
    let all = candidates(fitted);
    let mean = DMatrix::from_fn(all.len(), n, |i, k| {
        if all[i].of.contains(&k) { 1.0 / all[i].of.len() as f64 } else { 0.0 }
    });
    let of_means = &mean * &of_values * mean.transpose();
    let mut kept: Vec<usize> = Vec::new();
    for (i, candidate) in all.iter().enumerate() {
        let parameter = &candidate.effect.kind.parameters[candidate.parameter];
        let values: Vec<f64> = candidate.of.iter().map(|k| point.value(&point.free[*k])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let deviation = of_means[(i, i)].sqrt();
        let own = own_number(candidate);
        let limit = match candidate.expected {
            e if e.is_finite() && !own => {
                MEASURED_DEVIATION_MAX * e / (candidate.of.len() as f64).sqrt()
            }
            _ if own => MEASURED_OF_RANGE * (parameter.high - parameter.low),
            _ => f64::INFINITY,
        };
        let name = candidate.name(robot);
        let of_one_log = candidate.per_log && values.len() == 1 && !candidate.expected.is_finite();
        // Known no better than from its plausible range, it is not bounded by these logs.
        let limit = limit.min(range_deviation(parameter));
        if !deviation.is_finite() || deviation > limit || of_one_log {
            posterior.not_measured.push(name);
            continue;
        }
        if values.iter().any(|v| parameter.is_at_bound(*v)) {
            posterior.at_bound.push(name);
        } else if deviation > MEASURED_DEVIATION_MAX * range_deviation(parameter) {
            posterior.undetermined.push(name);
        }
        let between = if candidate.per_log {
            between_logs(candidate, &values, mean, &of_values)
        } else {
            0.0
        };
        posterior.numbers.push(MeasuredNumber {
            kind: candidate.effect.kind,
            at: candidate.effect.at,
            occurrence: occurrence(problem, &all[..i], candidate),
            parameter: candidate.parameter,
            value: mean + stated(problem, &candidate.effect, candidate.parameter),
            between_logs: between,
        });
        kept.push(i);
    }
    for (i, a) in kept.iter().enumerate() {
        posterior.covariance.extend(kept[..=i].iter().map(|b| of_means[(*a, *b)]));
    }
    Ok(())
}

/// True for a number of the model's own that is no calibration and was freed for the posterior.
fn own_number(candidate: &FreeNumber) -> bool {
    candidate.expected.is_finite() && candidate.effect.kind.calibration.is_none()
}

/// Standard deviation from log to log of a value that each has of its own: what the values vary by
/// and how well they are known, what was expected counted as one log more.
fn between_logs(candidate: &FreeNumber, values: &[f64], mean: f64, of: &DMatrix<f64>) -> f64 {
    let logs = candidate.of.len() as f64;
    let share = |k: usize, l: usize| of[(k, l)];
    let shared: f64 =
        candidate.of.iter().flat_map(|k| candidate.of.iter().map(move |l| share(*k, *l))).sum();
    let own = |(k, value): (&usize, &f64)| {
        let with: f64 = candidate.of.iter().map(|l| share(*k, *l)).sum();
        (value - mean).powi(2) + share(*k, *k) - 2.0 * with / logs + shared / (logs * logs)
    };
    let squares: f64 = candidate.of.iter().zip(values).map(own).sum();
    let expected = if candidate.expected.is_finite() { candidate.expected } else { 0.0 };
    let more = if expected > 0.0 { 1.0 } else { 0.0 };
    ((squares.max(0.0) + expected * expected) / (logs - 1.0 + more).max(1.0)).sqrt()
}

/// Which of the effects of its kind at its place a number is of: those that the model was given
/// come first.
fn occurrence(problem: &FitProblem, before: &[FreeNumber], candidate: &FreeNumber) -> usize {
    let same = |e: &Effect| e.place() == candidate.effect.place();
    let fitted = before.iter().filter(|c| same(&c.effect) && c.parameter == candidate.parameter);
    // What a log has of its own is one with what the model states of it.
    let own = problem.per_log.iter().filter(|own| own.is(&candidate.effect) && candidate.per_log);
    problem.known.iter().filter(|e| same(e)).count().saturating_sub(own.count()) + fitted.count()
}

/// What the model states already of a value that each log has of its own.
fn stated(problem: &FitProblem, effect: &Effect, parameter: usize) -> f64 {
    let own = problem.per_log.iter().find(|own| own.is(effect));
    own.map_or(0.0, |own| own.stated.values[parameter] - own.start().values[parameter])
}

/// Names of the values of an improvement's effects that its logs do not bound.
pub fn not_bounded(
    posterior: &Posterior,
    improvement: &Improvement,
    robot: &RobotFile,
) -> Vec<String> {
    let effects = improvement.last().effects.iter().map(|f| &f.effect);
    let names = effects.flat_map(|effect| {
        (0..effect.values.len()).map(|parameter| effect.number_name(parameter, robot))
    });
    names.filter(|name| posterior.not_measured.contains(name)).collect()
}
