//! What the encoders' noise leaves open of fitted values.
//!
//! Encoders drive every prediction, and their noise with them: it swings the arm over many rows, and
//! pose and torque together. Column by column the residuals hardly show it (some per cent of their
//! square in a ring-down), and [`crate::fit::covariance`], which goes by them, misses it. But it lies
//! where the arm resonates, and that is what damping is told by. So it is asked directly: the logs are
//! driven again with noise drawn anew on every encoder, and the fit follows linearly.
//!
//! Left out: noise of forces that drive a prediction. What the residuals do show of it counts twice.

use crate::fit::{self, FitProblem, Fitted, Linear, Residuals, Slopes};
use crate::predict::{PredictError, PreparedLog};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trueweld_logs::log::Log;
use trueweld_logs::noise::{NoiseLevels, instruments};
use trueweld_plant::random::Random;

/// Draws: a deviation is known to an eighth of itself by them. Where time is up, to a quarter by fewer.
const DRAWS: u64 = 32;
const COUNTED_DRAWS_MIN: u64 = 8;

/// Covariance that it adds to values that were fitted, in the fit's units. `logs`: those that the
/// problem's logs were made of; `prior`: the priors' curvature.
///
/// # Errors
/// [`PredictError`] where a log cannot be driven with other noise.
pub fn covariance(
    problem: &FitProblem,
    logs: &[Log],
    fitted: &Fitted,
    prior: &DMatrix<f64>,
) -> Result<DMatrix<f64>, PredictError> {
    let (levels, blocks) = (instruments(logs), fit::blocks_of(problem));
    let slopes: Vec<&Slopes> = fitted.slopes.iter().collect();
    let nowhere = DVector::zeros(slopes.len());
    let step = |draw: u64| -> Result<DVector<f64>, PredictError> {
        let change = residual_change(problem, logs, &levels, fitted, draw)?;
        let linear = Linear::new(&blocks, &change, &slopes, prior.clone(), nowhere.clone());
        Ok(linear.solve(None, 0.0, None).map_or_else(|| nowhere.clone(), |step| step.step))
    };
    let drawn =
        (0..DRAWS).into_par_iter().filter(|draw| *draw < COUNTED_DRAWS_MIN || !problem.is_late());
    let steps: Vec<DVector<f64>> = drawn.map(step).collect::<Result<_, _>>()?;
    let zero = DMatrix::zeros(slopes.len(), slopes.len());
    let sum = steps.iter().fold(zero, |sum, step| sum + step * step.transpose());
    Ok(sum / steps.len() as f64)
}

/// By how much the residuals at a fit change with one draw of the encoders' noise added, in the
/// deviations of the problem.
fn residual_change(
    problem: &FitProblem,
    logs: &[Log],
    levels: &[NoiseLevels],
    fitted: &Fitted,
    draw: u64,
) -> Result<Residuals, PredictError> {
    let experiment = |(number, (log, levels)): (usize, (&Log, &NoiseLevels))| {
        let random = Random::new(draw, number as u64);
        PreparedLog::new(&noisier(log, levels, random), levels, &problem.model)
    };
    let again = logs.iter().zip(levels).enumerate().map(experiment);
    let again = problem.on(again.collect::<Result<_, _>>()?);
    let mut change = fit::residuals(&again, &fitted.point)?;
    for (log, change) in change.iter_mut().enumerate() {
        let [now, before] = [&again, problem].map(|of| &of.logs[log].compared);
        // Where a row counts no more, the log says nothing of it.
        if now.len() != before.len() {
            change.residual = vec![0.0; before.len()];
            continue;
        }
        let own = fitted.residuals[log].residual.iter().zip(now.iter().zip(before));
        for (residual, (own, (now, before))) in change.residual.iter_mut().zip(own) {
            *residual = *residual * (now.deviation / before.deviation) - own;
        }
    }
    Ok(change)
}

/// A log whose encoders have noise once more.
fn noisier(log: &Log, levels: &NoiseLevels, mut random: Random) -> Log {
    let mut log = log.clone();
    for row in &mut log.samples.encoder {
        for (angle, level) in row.iter_mut().zip(&levels.encoder) {
            *angle += level.map_or(0.0, |level| level.deviation) * random.normal();
        }
    }
    log
}
