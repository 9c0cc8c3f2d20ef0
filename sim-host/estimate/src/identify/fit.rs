//! Pass after pass: numbers of the model free without a prior beside every calibration, until
//! nothing moves.
//!
//! Within a pass a number is drawn to where the pass began by no more than a factor of e, one
//! standard deviation: what the logs tell moves freely over the passes, and what they do not tell
//! stays. Noise that the model carries from the encoders into a prediction, trackers that are
//! registered and clocks that are fitted follow the numbers from pass to pass.

use crate::align::align_clocks;
use crate::encoder_noise;
use crate::fit::calibration::{calibrations, in_proportion};
use crate::fit::covariance::{columns, covariance};
use crate::fit::{
    EffectScope, FitProblem, FitState, Fitted, FreeParameter, Linear, SolverOptions, blocks_of,
    chi_square, count, fit, residuals, unit,
};
use crate::identify::coordinates::{FreeCoordinate, is_replaced};
use crate::identify::error::IdentifyError;
use crate::log_faults::{Found, find};
use crate::residuals::compare::{baseline, experiments, of_comparable};
use nalgebra::{DMatrix, DVector};
use trueweld_core::Robot;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Action, Effect, Location};
use trueweld_plant::input::ModelFile;

/// Passes at most; share of its deviation, and absolute step, below which a number is at rest.
const FIT_PASSES_MAX: usize = 15;
const LIKELY: f64 = 5.0;
const RESTING_DEVIATION_SHARE: f64 = 0.1;
const RESTING_STEP: f64 = 1e-4;

/// Passes after which a number that the logs do not tell stays one.
const UNTOLD_PASSES: usize = 4;

/// What a fit came to.
#[derive(Debug)]
pub(crate) struct IdentificationFit {
    /// The model with the numbers found.
    pub model: ModelFile,
    /// The logs, their trackers registered under that model.
    pub logs: Vec<Log>,
    pub problem: FitProblem,
    pub fitted: Fitted,
    /// Free values of the numbers, in the order asked, among all of the fit.
    pub indices: Vec<usize>,
    /// Covariance of their logarithms, or of parts of the ripple.
    pub covariance: DMatrix<f64>,
    /// Which of them the logs tell.
    pub told: Vec<bool>,
    /// What was found of the files.
    pub found: Found,
}

/// One pass from where the model stands.
struct Pass {
    logs: Vec<Log>,
    problem: FitProblem,
    fitted: Fitted,
    indices: Vec<usize>,
    found: Found,
}

fn pass(
    model: &ModelFile,
    given: &[Log],
    asked: &[FreeCoordinate],
    expected: &[f64],
) -> Result<Pass, IdentifyError> {
    let mut logs = given.to_vec();
    let aligned = align_clocks(&mut logs, &baseline(model));
    let found = find(&mut logs, &baseline(model))?;
    if !found.mistakes.is_empty() {
        return Err(IdentifyError::Mistakes(Box::new(found)));
    }
    aligned?;
    let ready = of_comparable(&mut logs, &baseline(model))?;
    let problem = FitProblem::new(model, ready);
    let all = calibrations(&problem);
    let mut point = FitState::empty(logs.len());
    point.per_log = all.per_log.clone();
    point.free =
        all.free.iter().filter(|f| matches!(f.of, EffectScope::Log(..))).copied().collect();
    for (index, effect) in all.shared.iter().enumerate().filter(|(_, e)| !is_replaced(e)) {
        let of = |parameter: usize| {
            let same =
                |f: &&FreeParameter| f.of == EffectScope::Shared(index) && f.parameter == parameter;
            all.free.iter().find(same).map_or(0.0, |f| f.expected)
        };
        let expected: Vec<f64> = (0..effect.values.len()).map(of).collect();
        point.add_expected(effect.clone(), &expected);
    }
    let stale = in_proportion(&point);
    let first = point.free.len();
    for (asked, expected) in asked.iter().zip(expected) {
        point.add_expected(asked.effect(0.0), &asked.expected(*expected));
    }
    let indices: Vec<usize> = (first..point.free.len()).collect();
    let fitted = fit(&problem, &point, &blocks_of(&problem), &[], SolverOptions::full(stale))?;
    Ok(Pass { logs, problem, fitted, indices, found })
}

impl Pass {
    /// Logarithms by which the numbers moved.
    fn moved(&self) -> Vec<f64> {
        let point = &self.fitted.point;
        self.indices.iter().map(|k| point.value(&point.free[*k])).collect()
    }

    /// Covariance of the logarithms; `drawn`: the standard deviations that they are drawn by.
    fn covariance(&self, drawn: &[f64]) -> Result<Option<DMatrix<f64>>, IdentifyError> {
        let (point, n) = (&self.fitted.point, self.fitted.point.free.len());
        let units = DVector::from_fn(n, |k, _| {
            unit(point.parameter(&point.free[k]), point.value(&point.free[k]))
        });
        let mut prior = self.fitted.linear.prior.clone();
        for (k, drawn) in self.indices.iter().zip(drawn) {
            prior[(*k, *k)] = (units[*k] / drawn).powi(2);
        }
        let driven = encoder_noise::covariance(&self.problem, &self.logs, &self.fitted, &prior)?;
        let linear = Linear { prior, ..self.fitted.linear.clone() };
        let own = covariance(
            &linear,
            &columns(&self.problem),
            &self.fitted.residuals,
            &self.fitted.slopes,
        );
        Ok(own.map(|own| {
            let of_all = (own + driven).component_mul(&(&units * units.transpose()));
            of_all.select_rows(&self.indices).select_columns(&self.indices)
        }))
    }

    /// Standard deviations of the numbers where nothing draws them and residuals are white: what decides
    /// when a number is at rest, and whether the logs tell it.
    fn deviations(&self) -> Vec<f64> {
        let point = &self.fitted.point;
        let mut prior = self.fitted.linear.prior.clone();
        self.indices.iter().for_each(|k| prior[(*k, *k)] = 0.0);
        let linear = Linear { prior, ..self.fitted.linear.clone() };
        let deviations = linear.solve(None, 0.0, None).map(|step| step.deviations());
        let of = |k: &usize| {
            let deviation = deviations.as_ref().map_or(f64::INFINITY, |all| all[*k]);
            deviation * unit(point.parameter(&point.free[*k]), 0.0)
        };
        self.indices.iter().map(of).collect()
    }
}

/// A model with its numbers moved by logarithms.
fn rebased(model: &ModelFile, effects: &[Effect]) -> Result<ModelFile, IdentifyError> {
    let mut model = model.clone();
    for effect in effects {
        let joint = if let Location::Joint(joint) = effect.at { joint } else { 0 };
        match (effect.kind.action, &mut model.process) {
            (Action::Robot(change), _) => {
                change(&mut model.robot.parameters, joint, &effect.values);
            }
            (Action::Process(change), Some(process)) => change(process, &effect.values),
            _ => {}
        }
    }
    model.robot.robot = Robot::new(model.robot.parameters.clone()).map_err(IdentifyError::Model)?;
    Ok(model)
}

/// Fits the numbers asked for. `done` gets the share of the passes that are likely.
pub(crate) fn converge(
    given: &ModelFile,
    logs: &[Log],
    asked: &[FreeCoordinate],
    done: &dyn Fn(f64),
) -> Result<IdentificationFit, IdentifyError> {
    let n = asked.len();
    let (mut total, mut told) = (vec![0.0; n], vec![true; n]);
    let mut last = vec![0.0; n];
    let mut model = given.clone();
    for number in 0..FIT_PASSES_MAX {
        done(number as f64 / LIKELY);
        let drawn_by = |of_told: fn(&FreeCoordinate) -> f64| -> Vec<f64> {
            let of = |(asked, told): (&FreeCoordinate, &bool)| {
                if *told { of_told(asked) } else { asked.coordinate.given }
            };
            asked.iter().zip(&told).map(of).collect()
        };
        let pass = pass(&model, logs, asked, &drawn_by(|of| of.coordinate.drawn))?;
        let rows = count(&pass.fitted.residuals);
        if rows < n {
            return Err(IdentifyError::TooFew { rows, numbers: n });
        }
        let (moved, deviations) = (pass.moved(), pass.deviations());
        // What the logs do not tell goes back to the value given; first impressions may be wrong, as
        // long as the numbers are far off.
        let mut tells: Vec<bool> = (0..n)
            .map(|k| {
                (told[k] || number < UNTOLD_PASSES) && deviations[k] < asked[k].coordinate.untold
            })
            .collect();
        let rests = |tells: &[bool]| {
            (0..n).all(|k| {
                !tells[k]
                    || moved[k].abs() < (RESTING_DEVIATION_SHARE * deviations[k]).max(RESTING_STEP)
            })
        };
        let mut covariance = None;
        if tells == told && rests(&tells) {
            // What is drawn by nothing is as uncertain as the logs leave it.
            covariance = pass.covariance(&drawn_by(|_| f64::INFINITY))?;
            for k in 0..n {
                let deviation = covariance.as_ref().map_or(f64::INFINITY, |c| c[(k, k)].sqrt());
                tells[k] &= deviation < asked[k].coordinate.untold;
            }
        }
        if let Some(covariance) = covariance.filter(|_| tells == told) {
            let Pass { logs, problem, fitted, indices, found } = pass;
            return Ok(IdentificationFit {
                model,
                logs,
                problem,
                fitted,
                indices,
                covariance,
                told,
                found,
            });
        }
        for k in 0..n {
            // The noise carried into a prediction follows the numbers, and may take a number to and fro:
            // what it turns back by, it goes half of.
            last[k] = if moved[k] * last[k] < 0.0 { 0.5 * moved[k] } else { moved[k] };
            total[k] = if tells[k] { total[k] + last[k] } else { 0.0 };
        }
        told = tells;
        let moved = asked.iter().zip(&total).filter(|(_, total)| **total != 0.0);
        let effects: Vec<Effect> = moved.map(|(asked, total)| asked.effect(*total)).collect();
        model = rebased(given, &effects)?;
    }
    Err(IdentifyError::NotConverged { passes: FIT_PASSES_MAX })
}

impl IdentificationFit {
    /// √mean((residual/noise)²) of the same logs under a model with the calibrations found.
    pub(crate) fn score_of(&self, model: &ModelFile) -> Result<f64, IdentifyError> {
        let problem = FitProblem::new(model, experiments(&self.logs, &baseline(model))?);
        let mut point = self.fitted.point.clone();
        for k in &self.indices {
            let free = point.free[*k];
            if let EffectScope::Shared(index) = free.of {
                point.shared[index].values[free.parameter] = 0.0;
            }
        }
        let at = residuals(&problem, &point)?;
        Ok((chi_square(&at) / count(&at).max(1) as f64).sqrt())
    }
}
