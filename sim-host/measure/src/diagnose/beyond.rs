//! A calibration that is larger than any: an encoder zeroed two milliradians off, a joint half as
//! stiff as its file says. What is expected of calibrations holds each of them small, so that an
//! effect, or several others that act as it does, would be named in its place.

use super::rules::{self, at_floor, counts};
use crate::fit::calibration::is_calibration;
use crate::fit::{self, Effort, End, FitProblem, FitState, Fitted};

/// The calibrations alone, one of them free to be of any size, where that is all there is to say: it
/// comes out far beyond what is expected of it, the logs fix it, it reaches the floor and costs less than `best` does, the best effect of the library. `None` where there is none.
pub(super) fn beyond_expected(
    bench: &FitProblem,
    blocks: &[Vec<u8>],
    null: &Fitted,
    best: Option<&Fitted>,
) -> Option<Fitted> {
    let goal = best.map_or(null.cost, |best| best.cost.min(null.cost));
    let mut point = released(null, goal)?;
    // Others have made up for it: from nothing, and then with the slopes that are where it stands,
    // for so far away even those that hardly bend are others.
    point.reset(|effect| is_calibration(effect.kind));
    let from_nothing = Effort::steps(FROM_NOTHING, point.free.len());
    let mut fitted = fit::fit(bench, &point, blocks, &[], from_nothing).ok()?;
    for _ in 0..AGAIN {
        fitted = fit::fit(bench, &fitted.point, blocks, &[], Effort::full(0)).ok()?;
        if matches!(fitted.end, End::Arrived | End::Near) {
            break;
        }
    }
    // Others may act as it does, each larger than expected: those explain as much, and cost more.
    let explains =
        at_floor(bench, &fitted.at) && (at_floor(bench, &null.at) || counts(bench, null, &fitted));
    let cheaper = fitted.cost < goal - rules::TIED * rules::trust(&fitted);
    (explains && cheaper).then_some(fitted)
}

/// Steps with the slopes at nothing, and how often a fit goes on with those where it stands.
const FROM_NOTHING: usize = 3;
const AGAIN: usize = 3;

/// The point of a fit with nothing expected of that calibration whose size, in all logs together,
/// lowers the cost the most by slopes, and below `goal`; `None` where none comes out beyond what is
/// expected of it.
fn released(null: &Fitted, goal: f64) -> Option<FitState> {
    let point = &null.point;
    let name = |k: usize| {
        let free = &point.free[k];
        let effect = point.effect(free.of);
        (effect.kind.id, effect.at, free.parameter)
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
        let deviations = found.deviations();
        let size = |k: usize| {
            let free = &point.free[k];
            let (parameter, value) = (point.parameter(free), point.value(free));
            let away = value - parameter.without_effect(value);
            let unit = fit::unit(parameter, value);
            ((away + found.step[k] * unit).abs(), deviations[k] * unit)
        };
        let beyond = |k: &usize| {
            let (size, deviation) = size(*k);
            size > rules::BEYOND * point.free[*k].expected.max(deviation)
        };
        let largest = group.iter().map(|k| size(*k).0).fold(0.0, f64::max);
        let cost = linear.cost(&found.step);
        (cost < goal && group.iter().any(beyond)).then_some((cost, group, largest))
    });
    let (_, group, size) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let mut point = point.clone();
    group.iter().for_each(|k| point.free[*k].expected = size);
    Some(point)
}
