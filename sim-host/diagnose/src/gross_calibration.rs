//! A calibration that is larger than any: an encoder zeroed two milliradians off, a joint far
//! softer than its file says. What is expected of calibrations holds each of them small, so that an
//! effect, or several others that act as it does, would be named in its place.

use super::log_evidence::is_significant;
use super::rules::{self, within_noise};
use nalgebra::DVector;
use rayon::prelude::*;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{self, FitProblem, FitState, Fitted, SolverOptions, Termination};
use trueweld_plant::effects::Location;

/// The calibrations alone, one of them free to be of any size, where that is all there is to say: it
/// comes out far beyond what is expected of it, the logs fix it, and it reaches the floor. It costs
/// less than `best` does, the best effect of the library; where that acts at the same place, the
/// calibration need only do as well, for it has less freedom. `None` where there is none, or no time to
/// look.
pub(super) fn gross_calibration(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    null: &Fitted,
    best: Option<&Fitted>,
) -> Option<Fitted> {
    if problem.is_late() {
        return None;
    }
    let tied = rules::DECISIVE_FALL * rules::variance_inflation(best.unwrap_or(null));
    let place = best.and_then(|best| Some(best.point.shared.last()?.at));
    let alone = null.cost - tied;
    let dearest = |at: Location| match best {
        Some(best) if place == Some(at) => alone.min(best.cost + tied),
        Some(best) => alone.min(best.cost - tied),
        None => alone,
    };
    // Slopes say little of what an effect at the same place is like from afar.
    let promised = |at: Location| if place == Some(at) { alone } else { dearest(at) };
    let Released { at, point, size } = released(null, promised)?;
    // Others have made up for it: from where it stands alone, and then with the slopes that are where
    // it stands, for so far away even those that hardly bend are others.
    let tried = RELEASED_SIZE_SHARES.par_iter().filter_map(|share| {
        let point = point.moved(&(&size * *share));
        Some((fit::chi_square(&fit::residuals(problem, &point).ok()?), point))
    });
    let (_, start) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let near = SolverOptions::steps(FIXED_SLOPE_STEPS, start.free.len());
    let mut fitted = fit::fit(problem, &start, blocks, &[], near).ok()?;
    let full = SolverOptions { goal: dearest(at), ..SolverOptions::full(0) };
    for _ in 0..RELEASED_FITS_MAX {
        if problem.is_late() {
            return None;
        }
        fitted = fit::fit(problem, &fitted.point, blocks, &[], full).ok()?;
        match fitted.termination {
            Termination::Unpromising => return None,
            ended if ended.is_arrival() => break,
            _ => {}
        }
    }
    // Others may act as it does, each larger than expected: those explain as much, and cost more.
    let explains = within_noise(problem, &fitted.residuals)
        && (within_noise(problem, &null.residuals) || is_significant(problem, null, &fitted));
    (explains && fitted.cost < dearest(at)).then_some(fitted)
}

/// Shares of the size that slopes give at which it is tried alone: what swings has slopes that say
/// little of it.
const RELEASED_SIZE_SHARES: [f64; 7] = [0.25, 0.5, 0.7, 0.85, 1.0, 1.4, 2.0];

/// Steps with the slopes where it stands alone, and how often a fit goes on with those where it has
/// come to.
const FIXED_SLOPE_STEPS: usize = 3;
const RELEASED_FITS_MAX: usize = 3;

/// A calibration of which nothing is expected.
struct Released {
    at: Location,
    /// All calibrations at nothing.
    point: FitState,
    /// The step to the size that slopes give it.
    size: DVector<f64>,
}

/// That calibration whose size, in all logs together, lowers the cost the most by slopes, and below
/// what is `promised` at its place. `None` where none comes out beyond what is expected of it.
fn released(null: &Fitted, promised: impl Fn(Location) -> f64) -> Option<Released> {
    let point = &null.point;
    let name = |k: usize| {
        let free = &point.free[k];
        let effect = point.effect(free.of);
        (effect.place(), free.parameter)
    };
    let unit = |k: usize| {
        let free = &point.free[k];
        fit::unit(point.parameter(free), point.value(free))
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for k in (0..point.free.len()).filter(|k| point.free[*k].expected.is_finite()) {
        match groups.iter_mut().find(|group| name(group[0]) == name(k)) {
            Some(group) => group.push(k),
            None => groups.push(vec![k]),
        }
    }
    let tried = groups.into_iter().filter_map(|group| {
        let mut linear = null.linear.clone();
        group.iter().for_each(|k| linear.prior[(*k, *k)] = 0.0);
        let found = linear.solve(None, 0.0, None)?;
        let (size, deviations) = (&linear.away + &found.step, found.deviations());
        let beyond = |k: &usize| {
            let expected = point.free[*k].expected / unit(*k);
            size[*k].abs() > rules::GROSS_CALIBRATION_DEVIATIONS * expected.max(deviations[*k])
        };
        let cost = linear.cost(&found.step);
        let promises = cost < promised(name(group[0]).0.at);
        (promises && group.iter().any(beyond)).then_some((cost, group, size))
    });
    let (_, group, all) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut nothing = point.clone();
    nothing.reset(|effect| is_calibration(effect.kind));
    let mut size = DVector::zeros(all.len());
    for k in group.iter().copied() {
        size[k] = all[k];
        nothing.free[k].expected =
            group.iter().map(|k| (all[*k] * unit(*k)).abs()).fold(0.0, f64::max);
    }
    Some(Released { at: name(group[0]).0.at, point: nothing, size })
}
