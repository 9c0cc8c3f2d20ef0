//! Calibrations that do the same as the one that is the answer: where a joint's axis goes through the
//! link before it, the zero of its encoder and a link that is mounted turned about that axis are one.

use super::{FittedEffect, rules};
use trueweld_estimate::fit::{
    self, EffectScope, FitProblem, FitState, Fitted, Slopes, SolverOptions, unit,
};
use trueweld_plant::effects::EffectPlace;

/// Cosine between what two values do to the residuals from which on they do the same.
const EQUIVALENT_COSINE: f64 = 0.99;

/// One value of a calibration at one place, in all logs.
type CalibrationValue = (EffectPlace, usize);

/// Fits with another calibration in place of `named`, which is one for all logs of `improved`, that
/// the logs do not tell from it; with the name of each. `null`: the fit with all calibrations free.
pub(super) fn equivalent_calibrations(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    (null, improved): (&Fitted, &Fitted),
    named: EffectPlace,
) -> Vec<(EffectPlace, Fitted)> {
    let all = &improved.point.shared;
    let Some(index) = all.iter().position(|e| e.place() == named) else {
        return Vec::new();
    };
    let effect = &all[index];
    let expected = effect.kind.calibration.map_or(&[][..], |c| c.expected);
    let beyond = |k: &usize| (effect.values[*k] / expected[*k]).abs();
    let Some(most) = (0..expected.len()).max_by(|a, b| beyond(a).total_cmp(&beyond(b))) else {
        return Vec::new();
    };
    let Some((own, own_unit)) = column(null, (named, most)) else {
        return Vec::new();
    };
    let mut others: Vec<CalibrationValue> = Vec::new();
    for free in null.point.free.iter().filter(|free| free.expected.is_finite()) {
        let other = null.point.effect(free.of);
        let value = (other.place(), free.parameter);
        let kept = all.iter().any(|e| e.place() == value.0);
        if !kept && !others.contains(&value) {
            others.push(value);
        }
    }
    let tied_cost = improved.cost + rules::DECISIVE_FALL * rules::variance_inflation(improved);
    let mut equivalent = Vec::new();
    for value in others {
        if problem.is_late() {
            break;
        }
        let Some((column, unit)) = column(null, value) else { continue };
        let pull = dot(&own, &column);
        let square = dot(&column, &column);
        let alike = pull.abs() / (square * dot(&own, &own)).sqrt();
        if alike.is_nan() || alike < EQUIVALENT_COSINE {
            continue;
        }
        let size = effect.values[most] / own_unit * pull / square * unit;
        let point = in_place(&improved.point, (index, most), value, size);
        let fitted = fit::fit(problem, &point, blocks, &[], SolverOptions::full(0));
        if let Some(fitted) = fitted.ok().filter(|fitted| fitted.cost < tied_cost) {
            equivalent.push((value.0, fitted));
        }
    }
    equivalent
}

/// A point with another calibration's value of this size in place of one of an effect for all logs.
/// The effect's other values stay free: what they take of what is not fitted is no matter of it.
fn in_place(
    point: &FitState,
    (index, parameter): (usize, usize),
    (other, other_parameter): CalibrationValue,
    size: f64,
) -> FitState {
    let mut point = point.clone();
    let effect = &mut point.shared[index];
    effect.values[parameter] =
        effect.kind.parameters[parameter].without_effect(effect.values[parameter]);
    point.free.retain(|f| (f.of, f.parameter) != (EffectScope::Shared(index), parameter));
    let mut other = other.kind.neutral(other.at);
    other.values[other_parameter] = size;
    let mut expected = vec![0.0; other.values.len()];
    expected[other_parameter] = size.abs();
    point.add_expected(other, &expected);
    point
}

/// Widens intervals of a calibration in place of `named` to that share of its value that the logs know
/// of the latter: what two do together is known better than what each does.
pub(super) fn share(named: &[FittedEffect], other: &mut [FittedEffect]) {
    let values = |found: &FittedEffect| found.effect.values.clone().into_iter();
    let known = named.iter().flat_map(|f| values(f).zip(f.interval.clone()));
    let known = known.filter(|(value, _)| *value != 0.0);
    let share = known.map(|(value, [low, high])| 0.5 * (high - low) / value.abs());
    let share = share.reduce(f64::min).unwrap_or(0.0);
    for found in other {
        for (value, [low, high]) in found.effect.values.iter().zip(&mut found.interval) {
            let reach = share * value.abs();
            (*low, *high) = (low.min(value - reach), high.max(value + reach));
        }
    }
}

/// What a value does to the residuals in all logs, in the fit's units, and the size of one.
fn column(null: &Fitted, (name, parameter): CalibrationValue) -> Option<(Slopes, f64)> {
    let point = &null.point;
    let mut sum: Option<(Slopes, f64)> = None;
    for (free, slopes) in point.free.iter().zip(&null.slopes) {
        let effect = point.effect(free.of);
        if (effect.place(), free.parameter) != (name, parameter) {
            continue;
        }
        let unit = unit(point.parameter(free), point.value(free));
        let (all, _) = sum.get_or_insert_with(|| (vec![None; slopes.len()], unit));
        for (log, slope) in slopes.iter().enumerate().filter(|(_, slope)| slope.is_some()) {
            all[log].clone_from(slope);
        }
    }
    sum
}

fn dot(a: &Slopes, b: &Slopes) -> f64 {
    let logs = a.iter().zip(b).filter_map(|(a, b)| a.as_ref().zip(b.as_ref()));
    logs.map(|(a, b)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>()).sum()
}
