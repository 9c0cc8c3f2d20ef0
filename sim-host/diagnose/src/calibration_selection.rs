//! Which calibrations count: those that bring more than their values cost.

use super::found::{FittedEffect, effects_of, found};
use super::rules::CalibrationPrice;
use nalgebra::DVector;
use rayon::prelude::*;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{
    self, EffectScope, FitProblem, FitState, Fitted, FreeParameter, Linear, Slopes, SolverOptions,
};
use trueweld_plant::effects::{CalibrationScope, Effect, EffectPlace};

/// Deviation of a value, as a share of what was expected of it before, from which on the data carry
/// little of it.
const POORLY_KNOWN_SHARE: f64 = 0.5;

/// Takes those values out of `kept` that the postures say little of: of how links are mounted, what
/// is known hardly better than before. The least known goes first, for another that it is
/// confounded with is known better without it. True where there were any.
fn drop_unknown(point: &FitState, linear: &Linear, kept: &mut Vec<usize>) -> bool {
    let before = kept.len();
    while let Some(found) = linear.solve(None, 0.0, Some(kept)) {
        let deviations = found.deviations();
        let share = |k: usize| {
            point.free.get(k).map_or(0.0, |free| expected_share(point, free, deviations[k]))
        };
        let least_known =
            (0..kept.len()).max_by(|a, b| share(kept[*a]).total_cmp(&share(kept[*b])));
        match least_known {
            Some(k) if share(kept[k]) > POORLY_KNOWN_SHARE => kept.remove(k),
            _ => break,
        };
    }
    kept.len() < before
}

/// Deviation of a value of how links are mounted, as a share of what was expected of it before; 0
/// of any other value. `deviation`: in the fit's units.
fn expected_share(point: &FitState, free: &FreeParameter, deviation: f64) -> f64 {
    let scope = point.effect(free.of).kind.calibration.map(|c| c.scope);
    let unit = fit::unit(point.parameter(free), point.value(free));
    match scope {
        Some(CalibrationScope::Postures) => deviation * unit / free.expected,
        _ => 0.0,
    }
}

/// Slopes of a free value of a point, where they are known at another, at which the same effect may
/// hold for all logs in place of one, or have values of its own in each.
fn slopes_of(
    point: &FitState,
    free: &FreeParameter,
    (there, known): (&FitState, &[Slopes]),
) -> Option<Slopes> {
    let effect = point.effect(free.of);
    let mut found: Option<Slopes> = None;
    for (other, slopes) in there.free.iter().zip(known) {
        let like = there.effect(other.of);
        let same = like.place() == effect.place() && other.parameter == free.parameter;
        // A joint has waves of several orders, each with its values.
        let own = match (free.of, other.of) {
            (EffectScope::Shared(_), EffectScope::Shared(_)) => {
                like.values == effect.values || is_calibration(like.kind)
            }
            _ => true,
        };
        if !(same && own) {
            continue;
        }
        let all = found.get_or_insert_with(|| vec![None; slopes.len()]);
        for (log, slope) in slopes.iter().enumerate() {
            let wanted = !matches!(free.of, EffectScope::Log(only, _) if only != log);
            if wanted && slope.is_some() {
                all[log].clone_from(slope);
            }
        }
    }
    found
}

/// The values of one calibration at one place: of every log, or one for all logs.
#[derive(Clone)]
struct CalibrationGroup {
    name: EffectPlace,
    /// True for how links are mounted.
    of_postures: bool,
    values: Vec<usize>,
}

/// The choice of calibrations on the linear model of a fit.
struct Choice<'f> {
    linear: &'f Linear,
    price: CalibrationPrice,
    kept: Vec<usize>,
    names: Vec<CalibrationGroup>,
    cost: f64,
    step: DVector<f64>,
}

impl Choice<'_> {
    /// Adds groups by steps, each the one that brings the most, as long as that is more than it
    /// costs.
    fn add(&mut self, groups: &mut Vec<CalibrationGroup>) {
        loop {
            let tried = groups.par_iter().enumerate().filter_map(|(g, group)| {
                let with: Vec<usize> = self.kept.iter().chain(&group.values).copied().collect();
                let (cost, step) = self.linear.with_only(&with)?;
                Some((self.cost - cost - self.price.of(group.values.len()), cost, step, g))
            });
            let best = tried.max_by(|a, b| a.0.total_cmp(&b.0)).filter(|best| best.0 > 0.0);
            let Some((_, cost, step, g)) = best else { break };
            (self.cost, self.step) = (cost, step);
            let group = groups.swap_remove(g);
            self.kept.extend(&group.values);
            // The same with values of other logs.
            groups.retain(|other| other.name != group.name);
            self.names.push(group);
        }
    }

    /// Takes groups out again that bring less than they cost beside those that came later, the
    /// least of them first.
    fn drop_spare(&mut self) {
        loop {
            let spare = self.names.par_iter().enumerate().filter_map(|(g, group)| {
                let mut without = self.kept.clone();
                without.retain(|k| !group.values.contains(k));
                let (cost, step) = self.linear.with_only(&without)?;
                Some((cost - self.cost - self.price.of(group.values.len()), cost, step, g))
            });
            let least = spare.min_by(|a, b| a.0.total_cmp(&b.0)).filter(|least| least.0 < 0.0);
            let Some((_, cost, step, g)) = least else { break };
            (self.cost, self.step) = (cost, step);
            let group = self.names.remove(g);
            self.kept.retain(|k| !group.values.contains(k));
        }
    }
}

/// Adds to the groups of values that every log has of its own the same with one value for all logs.
/// Gives the values that each of these moves; they come after all of the point.
fn in_all_logs(point: &FitState, groups: &mut Vec<CalibrationGroup>) -> Vec<Vec<usize>> {
    let mut sums: Vec<Vec<usize>> = Vec::new();
    for group in groups.clone() {
        let of_log = |k: &usize| matches!(point.free[*k].of, EffectScope::Log(..));
        let parameter = |k: &usize| point.free[*k].parameter;
        let mut parameters: Vec<usize> = group.values.iter().map(parameter).collect();
        parameters.sort_unstable();
        parameters.dedup();
        if parameters.len() == group.values.len() || !group.values.iter().all(of_log) {
            continue;
        }
        let first = point.free.len() + sums.len();
        sums.extend(parameters.iter().map(|wanted| {
            group.values.iter().copied().filter(|k| parameter(k) == *wanted).collect()
        }));
        let values = (first..point.free.len() + sums.len()).collect();
        groups.push(CalibrationGroup { values, ..group });
    }
    sums
}

/// The values that no calibration has, and the calibrations by place.
fn grouped(point: &FitState) -> (Vec<usize>, Vec<CalibrationGroup>) {
    let (mut others, mut groups): (Vec<usize>, Vec<CalibrationGroup>) = (Vec::new(), Vec::new());
    for (k, free) in point.free.iter().enumerate() {
        let effect = point.effect(free.of);
        let Some(calibration) = effect.kind.calibration else {
            others.push(k);
            continue;
        };
        let name = effect.place();
        match groups.iter_mut().find(|g| g.name == name) {
            Some(group) => group.values.push(k),
            None => groups.push(CalibrationGroup {
                name,
                of_postures: calibration.scope == CalibrationScope::Postures,
                values: vec![k],
            }),
        }
    }
    (others, groups)
}

/// Values of a fit that are kept, the calibrations that these are of, and the step to where the sum of
/// squares is least with these alone.
struct Kept {
    values: Vec<usize>,
    names: Vec<EffectPlace>,
    step: DVector<f64>,
}

impl Kept {
    /// By the slopes of the fit; `None` where these do not determine what is no calibration.
    fn of(fitted: &Fitted) -> Option<Self> {
        let point = &fitted.point;
        let (kept, mut groups) = grouped(point);
        let price = CalibrationPrice::new(fitted, groups.len());
        let sums = in_all_logs(point, &mut groups);
        let linear = fitted.linear.with_sums(&sums);
        let (cost, step) = linear.with_only(&kept)?;
        let (mut mounting, mut other): (Vec<CalibrationGroup>, Vec<CalibrationGroup>) =
            groups.into_iter().partition(|g| g.of_postures);
        let mut choice = Choice { linear: &linear, price, kept, names: Vec::new(), cost, step };
        choice.add(&mut other);
        choice.add(&mut mounting);
        choice.drop_spare();
        let Choice { kept: mut values, names, cost, mut step, .. } = choice;
        if drop_unknown(point, &linear, &mut values) {
            (_, step) = linear.with_only(&values).unwrap_or((cost, step));
        }
        // One for all logs is each log's own.
        let own = point.free.len();
        for (sum, of_logs) in sums.iter().enumerate().map(|(k, of_logs)| (own + k, of_logs)) {
            of_logs.iter().for_each(|k| step[*k] += step[sum]);
            if values.contains(&sum) {
                values.extend(of_logs);
            }
        }
        values.retain(|k| *k < own);
        let mut names: Vec<EffectPlace> = names.into_iter().map(|group| group.name).collect();
        let any = |name: &EffectPlace| {
            (0..name.kind.parameters.len()).any(|k| is_among(point, &values, *name, k))
        };
        names.retain(any);
        Some(Self { values, names, step: step.rows(0, own).into_owned() })
    }

    /// The point with these alone, those of several logs one for all: effects first, then calibrations.
    fn common(&self, fitted: &Fitted) -> FitState {
        let point = &fitted.point;
        let mut common = FitState::empty(point.per_log.len());
        for i in effects_of(fitted) {
            common.add(point.shared[i].clone());
        }
        for free in point.free.iter().filter(|f| f.parameter == 0) {
            let effect = point.effect(free.of);
            if let (EffectScope::Log(log, _), false) = (free.of, is_calibration(effect.kind)) {
                common.add_to_log(log, effect.clone(), &vec![f64::INFINITY; effect.values.len()]);
            }
        }
        let all = point.moved(&self.step);
        for name in &self.names {
            let own = all.shared.iter().chain(all.per_log.iter().flatten());
            let own: Vec<&Effect> = own.filter(|e| e.place() == *name).collect();
            let mean = (0..own[0].values.len())
                .map(|v| own.iter().map(|e| e.values[v]).sum::<f64>() / own.len() as f64)
                .collect();
            let known = expected(point, *name).into_iter().enumerate();
            let known: Vec<f64> = known
                .map(|(k, e)| if is_among(point, &self.values, *name, k) { e } else { 0.0 })
                .collect();
            common.add_expected(Effect { values: mean, ..own[0].clone() }, &known);
        }
        common
    }

    /// The same with those of several logs each log's own again; `None` where there are none.
    fn apart(&self, point: &FitState, common: &FitState) -> Option<FitState> {
        let mut apart = common.clone();
        let mut any = false;
        for name in &self.names {
            let Some(i) = apart.shared.iter().position(|e| e.place() == *name) else { continue };
            let logs: Vec<usize> = (0..point.per_log.len())
                .filter(|l| point.per_log[*l].iter().any(|e| e.place() == *name))
                .collect();
            if logs.len() < 2 {
                continue;
            }
            let effect = apart.shared[i].clone();
            apart.shared[i] = effect.kind.neutral(effect.at);
            apart.free.retain(|f| f.of != EffectScope::Shared(i));
            for log in &logs {
                apart.add_to_log(*log, effect.clone(), &expected(point, *name));
            }
            any = true;
        }
        any.then_some(apart)
    }
}

/// True where a parameter of an effect is among some free values of a point.
fn is_among(point: &FitState, values: &[usize], name: EffectPlace, parameter: usize) -> bool {
    let mut free = values.iter().map(|k| &point.free[*k]);
    free.any(|f| point.effect(f.of).place() == name && f.parameter == parameter)
}

/// What is expected of a calibration of a point.
fn expected(point: &FitState, name: EffectPlace) -> Vec<f64> {
    let mut free = point.free.iter().map(|free| free.of);
    let of = free.find(|of| point.effect(*of).place() == name);
    of.map_or(Vec::new(), |of| point.expected(of))
}

/// A point fitted with the slopes known from a fit near it.
fn refit_near(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    point: &FitState,
    near: &Fitted,
) -> Option<Fitted> {
    let slopes = |free| slopes_of(point, free, (&near.point, &near.slopes));
    let known: Vec<Slopes> = point.free.iter().map_while(slopes).collect();
    fit::fit(problem, point, blocks, &known, SolverOptions::full(0)).ok()
}

/// Keeps of the calibrations those that count, then refits. How links are mounted comes last, for
/// what the others explain: its many values bend to a little of everything. Calibrations that are
/// the same in all logs become one for all, unless each log having its own brings what its values
/// cost. Gives those kept.
pub(crate) fn select_calibrations(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    fitted: &Fitted,
) -> (Fitted, Vec<EffectPlace>) {
    let Some(kept) = Kept::of(fitted) else { return (fitted.clone(), Vec::new()) };
    let Some(common) = refit_near(problem, blocks, &kept.common(fitted), fitted) else {
        return (fitted.clone(), kept.names);
    };
    let apart = kept.apart(&fitted.point, &common.point);
    let apart = apart.and_then(|apart| refit_near(problem, blocks, &apart, &common));
    let counts = |apart: &Fitted| {
        let more = apart.point.free.len().saturating_sub(common.point.free.len());
        common.cost - apart.cost > CalibrationPrice::new(fitted, 1).of(more)
    };
    let best = apart.filter(counts).unwrap_or(common);
    drop_insignificant(problem, blocks, (best, kept.names))
}

/// The fit without those calibrations whose intervals all hold nothing, the least sure first: those
/// that brought their price beside others that are gone, or of residuals that follow each other.
pub(super) fn drop_insignificant(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    (fitted, mut names): (Fitted, Vec<EffectPlace>),
) -> (Fitted, Vec<EffectPlace>) {
    let all = found(problem, &fitted, |of| is_calibration(fitted.point.effect(of).kind));
    let sure = |name: &EffectPlace| {
        let own = all.iter().filter(|f| f.effect.place() == *name);
        own.map(sureness).fold(0.0, f64::max)
    };
    let doubtful = names.iter().map(sure).enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let Some((least, _)) = doubtful.filter(|(_, sure)| *sure < 1.0) else {
        return (fitted, names);
    };
    let dropped = names.remove(least);
    let is_kept = |effect: &Effect| !is_calibration(effect.kind) || names.contains(&effect.place());
    let mut point = FitState::empty(problem.logs.len());
    for (i, effect) in fitted.point.shared.iter().enumerate().filter(|(_, e)| is_kept(e)) {
        point.add_expected(effect.clone(), &fitted.point.expected(EffectScope::Shared(i)));
    }
    for (log, own) in fitted.point.per_log.iter().enumerate() {
        for (i, effect) in own.iter().enumerate().filter(|(_, e)| is_kept(e)) {
            let expected = fitted.point.expected(EffectScope::Log(log, i));
            point.add_to_log(log, effect.clone(), &expected);
        }
    }
    let values = fitted.point.free.len() - point.free.len();
    let price = CalibrationPrice::new(&fitted, names.len() + 1).of(values);
    match refit_near(problem, blocks, &point, &fitted) {
        Some(fewer) if fewer.cost - fitted.cost < price => {
            drop_insignificant(problem, blocks, (fewer, names))
        }
        _ => {
            names.insert(least, dropped);
            (fitted, names)
        }
    }
}

/// How far the surest of an effect's values is from nothing, in half of its interval.
fn sureness(found: &FittedEffect) -> f64 {
    let values = found.effect.kind.parameters.iter().zip(&found.effect.values);
    values
        .zip(&found.interval)
        .filter(|(_, [low, high])| low < high)
        .map(|((parameter, value), [low, high])| {
            (value - parameter.without_effect(*value)).abs() / (0.5 * (high - low))
        })
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::effects::{EffectKind, Location};

    #[test]
    fn values_of_several_logs_may_be_one() {
        let mut point = FitState::empty(2);
        let neutral = |id: &str, at| EffectKind::of(id).unwrap().neutral(at);
        for log in 0..2 {
            point.add_to_log(log, neutral("force-offset", Location::Cell), &[1.0; 3]);
        }
        point.add_to_log(0, neutral("encoder-offset", Location::Joint(0)), &[1e-4]);
        point.add_expected(neutral("stiffness-error", Location::Joint(0)), &[0.1]);
        let group = |id, at, values| {
            let name = EffectPlace { kind: EffectKind::of(id).unwrap(), at };
            CalibrationGroup { name, of_postures: false, values }
        };
        let mut groups = vec![
            group("force-offset", Location::Cell, (0..6).collect()),
            group("encoder-offset", Location::Joint(0), vec![6]),
            group("stiffness-error", Location::Joint(0), vec![7]),
        ];
        let sums = in_all_logs(&point, &mut groups);
        assert_eq!(sums, [[0, 3], [1, 4], [2, 5]]);
        // What one log alone has, or what is one already, is not asked again.
        assert_eq!(groups.len(), 4);
        assert_eq!(
            (groups[3].name.kind.id, &groups[3].values[..]),
            ("force-offset", &[8, 9, 10][..])
        );
    }
}
