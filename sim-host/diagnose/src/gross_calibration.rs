//! A calibration that is larger than any: an encoder zeroed two milliradians off, a joint far
//! softer than its file says. What is expected of calibrations has heavy tails: with a small probability
//! one of them is of any size at all (a contaminated normal distribution; Tukey 1960). Held small, it
//! would have an effect, or several others that act as it does, named in its place. Which one it is
//! is a hypothesis: it pays for its name among the calibrations.

use super::rules::{DECISIVE_FALL, within_noise};
use trueweld_estimate::fit::calibration::in_proportion;
use trueweld_estimate::fit::{self, FitProblem, FitState, Fitted, SolverOptions, Termination};

/// A fit with one of its calibrations free to be of any size, where that reaches the floor and costs
/// less than what it pays for, and less than `dearest`. `None` where there is none, or no time to look.
pub(super) fn gross_calibration(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    base: &Fitted,
    dearest: f64,
) -> Option<Fitted> {
    if problem.is_late() {
        return None;
    }
    let (start, dearest) = released(base, dearest)?;
    let full = SolverOptions { goal: dearest, ..SolverOptions::full(in_proportion(&start)) };
    let fitted = fit::fit_beside(problem, &start, blocks, base, full).ok()?;
    let promises = fitted.termination != Termination::Unpromising && fitted.cost < dearest;
    (promises && within_noise(problem, &fitted.residuals)).then_some(fitted)
}

/// That calibration whose size, in all logs together, lowers the cost the most by slopes, and below
/// what it may be at most: where slopes put it and the others, and that cost.
fn released(base: &Fitted, dearest: f64) -> Option<(FitState, f64)> {
    let point = &base.point;
    let name = |k: usize| {
        let free = &point.free[k];
        (point.effect(free.of).place(), free.parameter)
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for k in (0..point.free.len()).filter(|k| point.free[*k].expected.is_finite()) {
        match groups.iter_mut().find(|group| name(group[0]) == name(k)) {
            Some(group) => group.push(k),
            None => groups.push(vec![k]),
        }
    }
    // What is expected of others is given up, and no residual that follows others: each counts whole.
    let price = DECISIVE_FALL + 2.0 * (groups.len() as f64).ln();
    let dearest = dearest.min(base.cost - price);
    let tried = groups.into_iter().filter_map(|group| {
        let mut linear = base.linear.clone();
        group.iter().for_each(|k| linear.prior[(*k, *k)] = 0.0);
        let step = linear.solve(None, 0.0, None)?.step;
        let (cost, size) = (linear.cost(&step), &linear.away + &step);
        (cost < dearest).then_some((cost, group, size, step))
    });
    let (_, group, size, step) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let unit = |k: usize| {
        let free = &point.free[k];
        fit::unit(point.parameter(free), point.value(free))
    };
    let mut wide = point.clone();
    for k in &group {
        wide.free[*k].expected =
            group.iter().map(|k| (size[*k] * unit(*k)).abs()).fold(0.0, f64::max);
    }
    Some((wide.moved(&step), dearest))
}
