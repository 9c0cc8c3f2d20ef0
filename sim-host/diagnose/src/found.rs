//! What a fit says of its effects: their values with intervals, and whether the logs show that a wave is
//! one.

use super::rules;
use nalgebra::Vector3;
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{
    self, EffectScope, FitProblem, FitState, Fitted, FreeParameter, LeastSquaresStep, Residuals,
    Slopes, SolverOptions,
};
use trueweld_estimate::predict::{LinkMotion, PreparedLog};
use trueweld_logs::log::LogKind;
use trueweld_logs::{HALF_95, HALF_95_OF_TEN};
use trueweld_plant::effects::{Effect, EffectPlace, Location, Role};

/// An effect with fitted values.
#[derive(Debug, Clone)]
pub struct FittedEffect {
    /// The effect.
    pub effect: Effect,
    /// Its log, where each has its own.
    pub log: Option<usize>,
    /// 95 % interval of each value.
    pub interval: Vec<[f64; 2]>,
    /// Turns of a wave that the logs hold; `None` for what is no wave over an angle or a weld.
    pub turns: Option<f64>,
}

impl FittedEffect {
    /// True for a parameter that was fitted; false for one that the data carry nothing of, which
    /// stays as it was.
    pub fn is_fitted(&self, parameter: usize) -> bool {
        self.interval.get(parameter).is_none_or(|[low, high]| low != high)
    }

    /// True for a value that the logs bound: its interval is narrower than its plausible range, whose
    /// ends do not hold it.
    pub fn is_bounded(&self, parameter: usize) -> bool {
        let plausible = &self.effect.kind.parameters[parameter];
        let width = self.interval.get(parameter).map_or(0.0, |[low, high]| high - low);
        width <= (plausible.high - plausible.low).abs() && !self.is_at_bound(parameter)
    }

    /// True for a value held at an end of its plausible range: what the logs ask for is not this.
    fn is_at_bound(&self, parameter: usize) -> bool {
        let plausible = &self.effect.kind.parameters[parameter];
        self.is_fitted(parameter) && plausible.is_at_bound(self.effect.values[parameter])
    }

    /// True where the interval of one of its sizes, which the logs bound, does not hold the value
    /// without effect.
    pub fn is_told_from_nothing(&self) -> bool {
        let sizes = self.effect.kind.parameters.iter().enumerate().filter(|(_, p)| p.is_size());
        let mut told = sizes.map(|(k, parameter)| {
            let (value, [low, high]) = (self.effect.values[k], self.interval[k]);
            let nothing = match parameter.role {
                // What is far beyond any plausible value is as good as none: 1/value is nothing.
                Role::Reciprocal { .. } => low <= 0.0 || value >= parameter.high,
                _ => (low..=high).contains(&parameter.without_effect(value)),
            };
            self.is_bounded(k) && !nothing
        });
        told.any(|told| told)
    }

    /// Draws the end of the interval that is nearer to no effect where the deviance, which is so much
    /// at no effect, reaches that of 95 %, and the other no further than what is plausible; for an
    /// effect with one fitted size alone.
    fn bound_towards_nothing(&mut self, deviance: f64) {
        let sizes = self.effect.kind.parameters.iter().enumerate();
        let sizes: Vec<_> = sizes.filter(|(k, p)| p.is_size() && self.is_fitted(*k)).collect();
        let [(k, parameter)] = sizes[..] else { return };
        if matches!(parameter.role, Role::Reciprocal { .. }) || deviance <= 0.0 {
            return;
        }
        let value = self.effect.values[k];
        let size = value - parameter.without_effect(value);
        let end = value - size * HALF_95 / deviance.sqrt();
        let [low, high] = &mut self.interval[k];
        (*low, *high) = match size > 0.0 {
            true => (low.max(end), high.min(parameter.high).max(value)),
            false => (low.max(parameter.low).min(value), high.min(end)),
        };
    }

    /// True for a wave of which the logs hold less than one turn, or do not tell its order, or its
    /// length, from none: a piece of a sine is as good as a parabola, or as a spring with slack.
    pub fn is_unseen_wave(&self) -> bool {
        self.turns.is_some_and(|turns| turns < rules::WHOLE_TURN) || self.has_open_order()
    }

    /// True for a wave whose order, or length, the logs do not tell from none.
    pub(super) fn has_open_order(&self) -> bool {
        let parameters = self.effect.kind.parameters.iter().zip(&self.effect.values);
        parameters.zip(&self.interval).any(|((parameter, value), [low, high])| {
            matches!(parameter.role, Role::Order | Role::Wavelength) && high - low >= 2.0 * value
        })
    }

    /// True for a calibration that is larger than any, or held at the bound of its range: a finding
    /// of its own, whatever it is that makes it.
    pub fn is_implausible(&self) -> bool {
        let Some(calibration) = self.effect.kind.calibration else {
            return false;
        };
        let parameters = self.effect.kind.parameters.iter().enumerate();
        parameters.filter(|(k, _)| self.is_fitted(*k)).any(|(k, parameter)| {
            let value = self.effect.values[k];
            let away = (value - parameter.without_effect(value)).abs();
            away > rules::GROSS_CALIBRATION_DEVIATIONS * calibration.expected[k]
                || self.is_at_bound(k)
        })
    }
}

/// The effects of a fit that are no calibrations.
pub(crate) fn effects_of(fitted: &Fitted) -> Vec<usize> {
    (0..fitted.point.shared.len())
        .filter(|i| !is_calibration(fitted.point.shared[*i].kind))
        .collect()
}

/// True for two fits with the same effects, besides calibrations, at the same places.
pub(crate) fn same_effects(a: &Fitted, b: &Fitted) -> bool {
    let own = |fitted: &Fitted| -> Vec<EffectPlace> {
        effects_of(fitted).into_iter().map(|i| fitted.point.shared[i].place()).collect()
    };
    let (a, b) = (own(a), own(b));
    a.len() == b.len() && a.iter().all(|effect| b.contains(effect))
}

/// Fitted effects with their intervals: of what noise makes of the values, or of what the blocks in
/// time disagree by, whichever is wider.
pub(crate) fn found(
    problem: &FitProblem,
    fitted: &Fitted,
    wanted: impl Fn(EffectScope) -> bool,
) -> Vec<FittedEffect> {
    found_off(problem, fitted, wanted, |_, _| 0.0)
}

/// The same of all values of a point at which the sum of squares is not least: the intervals go by how
/// far each is from where it would be as well, √(σ² + δ²).
fn found_on_the_way(problem: &FitProblem, fitted: &Fitted) -> Vec<FittedEffect> {
    found_off(problem, fitted, |_| true, |step, k| step.step[k])
}

/// All fitted effects with their intervals. Where something is left that stands out, each channel
/// is weighed by what is left in it: one that no model explains says little of the values that
/// others tell.
pub(crate) fn found_by_what_is_left(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
) -> Vec<FittedEffect> {
    let plain = || found(problem, fitted, |_| true);
    if rules::within_noise(problem, &fitted.residuals) {
        return plain();
    }
    let problem = inflate_noise(problem, &fitted.residuals);
    match fit::fit(&problem, &fitted.point, blocks, &[], SolverOptions::steps(0, 0)) {
        Ok(weighed) => found_on_the_way(&problem, &weighed),
        Err(_) => plain(),
    }
}

/// The same logs, with each channel's noise as large as what these residuals leave of it.
pub(crate) fn inflate_noise(problem: &FitProblem, at: &Residuals) -> FitProblem {
    let parts = rules::parts(problem, at);
    let factor = |log: usize, channel: &'static str| {
        parts
            .get(&(log, channel))
            .map_or(1.0, |p| (p.square / p.count.max(1) as f64).sqrt().max(1.0))
    };
    let inflated =
        |(log, e): (usize, &PreparedLog)| e.inflate_noise(|channel| factor(log, channel));
    let experiments = problem.logs.iter().enumerate().map(inflated).collect();
    FitProblem { deadline: problem.deadline, ..problem.on(experiments) }
}

/// The same, by how far each value is off, in the fit's units, as the step to the least sum of squares
/// tells.
fn found_off(
    problem: &FitProblem,
    fitted: &Fitted,
    wanted: impl Fn(EffectScope) -> bool,
    off: impl Fn(&LeastSquaresStep, usize) -> f64,
) -> Vec<FittedEffect> {
    let inflation = rules::variance_inflation(fitted);
    let step = fitted.linear.solve(None, 0.0, None).map(|step| (step.deviations(), step));
    let scatter = fitted.linear.scatter();
    let mut all: Vec<FittedEffect> = Vec::new();
    let mut seen: Vec<EffectScope> = Vec::new();
    for (k, free) in fitted.point.free.iter().enumerate() {
        if !wanted(free.of) {
            continue;
        }
        let index = seen.iter().position(|of| *of == free.of).unwrap_or_else(|| {
            let effect = fitted.point.effect(free.of).clone();
            let interval = effect.values.iter().map(|v| [*v, *v]).collect();
            all.push(FittedEffect {
                turns: turns(problem, fitted, &effect),
                effect,
                log: if let EffectScope::Log(log, _) = free.of { Some(log) } else { None },
                interval,
            });
            seen.push(free.of);
            all.len() - 1
        });
        let parameter = fitted.point.parameter(free);
        let value = fitted.point.value(free);
        let deviation = step.as_ref().map_or(f64::INFINITY, |(deviations, step)| {
            (deviations[k] * inflation.sqrt()).hypot(off(step, k))
        });
        let scattered = scatter.as_ref().map_or(f64::INFINITY, |d| d[k]);
        let reach =
            (HALF_95 * deviation).max(HALF_95_OF_TEN * scattered) * fit::unit(parameter, value);
        all[index].interval[free.parameter] = [value - reach, value + reach];
    }
    all
}

/// Fitted effects of a fit with only those calibrations that count, with intervals that allow for
/// the others: a calibration that is left out is not known to be nothing. `full`: the fit with all
/// of them free. An interval is twice the root mean square of what that fit leaves between the value
/// and the truth, √(σ² + (v − v̂)²), where this is wider.
pub(crate) fn found_beside(
    problem: &FitProblem,
    fitted: &Fitted,
    full: &Fitted,
    wanted: impl Fn(EffectScope) -> bool,
) -> Vec<FittedEffect> {
    let mut all = found(problem, fitted, wanted);
    let Some(step) = full.linear.solve(None, 0.0, None) else { return all };
    let deviations = step.deviations();
    let inflation = rules::variance_inflation(full);
    let point = &full.point;
    for of in &mut all {
        let own = of.effect.place();
        let is_of_log = |scope| match (scope, of.log) {
            (EffectScope::Log(log, _), Some(only)) => log == only,
            _ => true,
        };
        for (parameter, [low, high]) in of.interval.iter_mut().enumerate() {
            let same = |k: &usize| {
                let free = &point.free[*k];
                let effect = point.effect(free.of);
                free.parameter == parameter && effect.place() == own && is_of_log(free.of)
            };
            let alike: Vec<usize> = (0..point.free.len()).filter(same).collect();
            // A joint may have several waves, of which none can be told to be the same in both fits.
            let for_all = |k: &&usize| matches!(point.free[**k].of, EffectScope::Shared(_));
            if low == high || alike.is_empty() || alike.iter().filter(for_all).count() > 1 {
                continue;
            }
            let mean = |values: &dyn Fn(usize) -> f64| {
                alike.iter().map(|k| values(*k)).sum::<f64>() / alike.len() as f64
            };
            let value = of.effect.values[parameter];
            let off = value - mean(&|k| point.value(&point.free[k]));
            // Of values of several logs as if they were off together.
            let square = mean(&|k| {
                let free = &point.free[k];
                let unit = fit::unit(point.parameter(free), point.value(free));
                inflation * (deviations[k] * unit).powi(2)
            });
            let reach = HALF_95 * (square + off * off).sqrt();
            (*low, *high) = (low.min(value - reach), high.max(value + reach));
        }
    }
    all
}

/// Those that hold for all logs and are no calibrations.
pub(super) fn found_effects(problem: &FitProblem, fitted: &Fitted) -> Vec<FittedEffect> {
    let own = effects_of(fitted);
    found(problem, fitted, |of| matches!(of, EffectScope::Shared(i) if own.contains(&i)))
}

/// The same, with what the fit without each of them says of its size: the sum of squares rises
/// from where it is least to what it is without the effect, and its root is taken to do so evenly
/// (profile likelihood by its signed root; Bates and Watts 1988). Slopes alone say little of a size
/// where another value bends with it, as a share and its time constant do. `before`: the fit without
/// the last, if that is all it is without.
pub(super) fn found_over(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    before: &Fitted,
    fitted: &Fitted,
) -> Vec<FittedEffect> {
    let own = effects_of(fitted);
    let known = (own.len() == effects_of(before).len() + 1).then_some(before.cost);
    let mut all = found_effects(problem, fitted);
    let last = all.len().saturating_sub(1);
    for (k, (found, index)) in all.iter_mut().zip(own).enumerate() {
        let known = known.filter(|_| k == last);
        let cost = known.or_else(|| promised_without(problem, blocks, fitted, index));
        if let Some(cost) = cost {
            found.bound_towards_nothing((cost - fitted.cost) / rules::variance_inflation(fitted));
        }
    }
    all
}

/// What slopes promise that a fit would cost without one of its effects.
fn promised_without(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
    index: usize,
) -> Option<f64> {
    let linear = evaluate_without(problem, blocks, fitted, index)?.linear;
    Some(linear.cost(&linear.solve(None, 0.0, None)?.step))
}

/// A fit without one of its effects, from where it stands, with the slopes that it has.
pub(super) fn evaluate_without(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
    index: usize,
) -> Option<Fitted> {
    let (point, known) = without(fitted, &[index]);
    fit::fit(problem, &point, blocks, &known, SolverOptions::steps(0, known.len())).ok()
}

/// The point of a fit without some of its effects, given in their order, and the slopes of what stays free.
pub(super) fn without(fitted: &Fitted, effects: &[usize]) -> (FitState, Vec<Slopes>) {
    let stays = |(free, slopes): (&FreeParameter, &Slopes)| {
        let goes = effects.iter().any(|index| free.of == EffectScope::Shared(*index));
        (!goes).then(|| slopes.clone())
    };
    let known = fitted.point.free.iter().zip(&fitted.slopes).filter_map(stays);
    let last_first = effects.iter().rev();
    (last_first.fold(fitted.point.clone(), |point, index| point.without(*index)), known.collect())
}

/// True where one of these is a wave that the logs do not tell to be one.
pub(super) fn has_unseen_wave(problem: &FitProblem, fitted: &Fitted) -> bool {
    found_effects(problem, fitted).iter().any(FittedEffect::is_unseen_wave)
}

/// Parts of a turn that are told apart where the logs are seen to go through them.
const TURN_PARTS: f64 = 8.0;

/// Turns of a wave over a joint's angle, or along a weld, that the logs hold: as many parts of a turn as
/// the links were in, wherever these lie, or the longest weld. `None` for another effect, or where no
/// motion is known.
fn turns(problem: &FitProblem, fitted: &Fitted, effect: &Effect) -> Option<f64> {
    let mut waves = effect.kind.parameters.iter().zip(&effect.values);
    let (role, value) = waves.find_map(|(parameter, value)| match parameter.role {
        Role::Order | Role::Wavelength => Some((parameter.role, value)),
        _ => None,
    })?;
    match (role, effect.at) {
        (Role::Order, Location::Joint(joint)) => {
            let angles = joint_angles(fitted, joint);
            let part = |angle: f64| (TURN_PARTS * value * angle / TAU).floor() as i64;
            let parts: BTreeSet<i64> = angles.map(part).collect();
            (!parts.is_empty()).then_some(parts.len() as f64 / TURN_PARTS)
        }
        (Role::Wavelength, _) => {
            let logs = problem.logs.iter().zip(&fitted.residuals);
            let welds = logs.filter(|(log, _)| log.kind == LogKind::Weld);
            let motions = welds.filter_map(|(_, at)| at.motion.as_deref());
            let longest = motions.filter_map(length).reduce(f64::max);
            longest.map(|length| length / value)
        }
        _ => None,
    }
}

/// Angles that a joint's link was in, over all logs, rad.
fn joint_angles(fitted: &Fitted, joint: usize) -> impl Iterator<Item = f64> + '_ {
    let motions = fitted.residuals.iter().filter_map(|at| at.motion.as_deref());
    motions.flat_map(move |motion| motion.link.iter().map(move |link| link[joint]))
}

/// From the least to the largest angle that a joint's link was in, over all logs, rad.
pub(crate) fn joint_range(fitted: &Fitted, joint: usize) -> f64 {
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let [low, high] = joint_angles(fitted, joint).fold(ends, |[l, h], q| [l.min(q), h.max(q)]);
    (high - low).max(0.0)
}

/// Distance from where a tool begins to where it ends, m.
fn length(motion: &LinkMotion) -> Option<f64> {
    let [first, last] = [motion.tool.first()?, motion.tool.last()?];
    let way: Vector3<f64> = last.position - first.position;
    Some(way.norm())
}
