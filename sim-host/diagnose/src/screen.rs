//! Screening: every effect at every place, by its slopes beside all calibrations where those are at
//! their best.

use super::rules;
use super::wave_orders::{SoughtWave, likeliest_orders};
use nalgebra::DVector;
use rayon::prelude::*;
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{
    self, EffectScope, FitProblem, Fitted, FreeParameter, ReducedFit, Slopes,
};
use trueweld_plant::effects::{
    Effect, EffectKind, EffectPlace, Location, Parameter, Role, library,
};

/// Smallest size of one effect at one place that the data would have shown, beside all
/// calibrations.
#[derive(Debug, Clone)]
pub struct EffectLimit {
    /// The effect, and where.
    pub effect: EffectPlace,
    /// Index of the parameter that is its size.
    pub parameter: usize,
    /// The value of the parameter at the limit, in the parameter's unit.
    pub value: f64,
}

/// A hypothesis, and what screening says of it.
#[derive(Debug, Clone)]
pub(crate) struct ScreenedEffect {
    /// The effect with the values to start a fit from, and by how much the sum of squares would
    /// fall: beside the calibrations at their best, and beside none.
    pub starts: [(Effect, f64); 2],
    /// Smallest size that would have been seen.
    pub limit: EffectLimit,
    /// Slopes of its sizes; of a sine those at both phases.
    pub slopes: Arc<[Slopes]>,
    /// Every shape of it that was looked at, and the slopes there.
    shapes: Vec<(Effect, Arc<[Slopes]>)>,
}

/// Share of a torque's small step, which suits the strongest joint, at which its slope is taken:
/// small for the weakest as well.
const OF_TORQUE: f64 = 0.1;

/// Waves along a weld that a plate's waviness is looked for with.
const WAVES: [f64; 16] =
    [0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 12.0];

/// Shares of a weld's length at which a step of the material is looked for.
const POSITIONS: [f64; 11] = [0.08, 0.17, 0.25, 0.33, 0.42, 0.5, 0.58, 0.67, 0.75, 0.83, 0.92];

/// Orders of the spindle that are looked for.
const SPINDLE_ORDERS: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

/// How many values of a parameter are told apart by trying; 1 of one that is solved for.
pub(crate) fn alternatives_of(role: Role) -> usize {
    match role {
        Role::Shape(starts) | Role::Position { starts, .. } => starts.len().max(1),
        Role::SpindleOrder => SPINDLE_ORDERS.len(),
        Role::Wavelength => WAVES.len(),
        Role::PathPosition => POSITIONS.len(),
        _ => 1,
    }
}

/// Values of its shaping parameters that a hypothesis is screened with.
fn shapes(kind: &'static EffectKind, length: f64) -> Vec<Vec<(usize, f64)>> {
    let mut all = vec![Vec::new()];
    for (k, p) in kind.parameters.iter().enumerate() {
        let values: Vec<f64> = match p.role {
            Role::Shape(starts) | Role::Position { starts, .. } => starts.to_vec(),
            Role::SpindleOrder => SPINDLE_ORDERS.to_vec(),
            Role::Wavelength => WAVES.iter().map(|w| (length / w).clamp(p.low, p.high)).collect(),
            Role::PathPosition => POSITIONS.iter().map(|s| s * length).collect(),
            _ => continue,
        };
        all = all
            .iter()
            .flat_map(|a| values.iter().map(|v| [a.clone(), vec![(k, *v)]].concat()))
            .collect();
    }
    all
}

/// Everything that screening needs of the point it is done at.
#[derive(Clone, Copy)]
pub(crate) struct SearchContext<'a> {
    /// The logs.
    pub problem: &'a FitProblem,
    /// Blocks of their values.
    pub blocks: &'a [Vec<u8>],
    /// Where all hypotheses start from: the calibrations at their best.
    pub null: &'a Fitted,
    /// The same with no calibrations.
    pub given: &'a Fitted,
    /// Longest weld, m.
    pub length: f64,
    /// What screening beside calibrations alone found, for what is screened beside more.
    pub screened: &'a [ScreenedEffect],
}

impl SearchContext<'_> {
    /// Cost of a fit without what is no evidence beside calibrations alone.
    pub(super) fn penalized_cost(&self, fitted: &Fitted) -> f64 {
        fitted.cost + rules::prior_penalty(&self.null.residuals, &fitted.residuals)
    }
}

/// Effects beside what the fits of a search leave of their residuals.
pub(crate) struct Screening<'a> {
    ctx: SearchContext<'a>,
    null: ReducedFit<'a>,
    given: Option<ReducedFit<'a>>,
    /// What each value counts for as evidence, log by log.
    weights: Vec<Vec<f64>>,
}

impl<'a> Screening<'a> {
    /// `None` where the calibrations are not determined.
    pub(crate) fn of(ctx: &SearchContext<'a>) -> Option<Self> {
        let null = ReducedFit::of(ctx.null)?;
        let logs = ctx.problem.logs.iter();
        let weights = logs.map(|log| rules::evidence_weights(&log.compared)).collect();
        Some(Self { ctx: *ctx, null, given: ReducedFit::of(ctx.given), weights })
    }

    /// Screens one effect at one place with all its shapes; the best of them. `None` where the logs
    /// see nothing of it.
    pub(crate) fn screen(&self, effect: EffectPlace) -> Option<ScreenedEffect> {
        let EffectPlace { kind, at } = effect;
        let scans = kind.parameters.iter().any(|p| p.role == Role::Order);
        let shapes = if scans { self.orders(kind, at) } else { shapes(kind, self.ctx.length) };
        let shaped = |shape: Vec<(usize, f64)>| {
            let mut effect = kind.neutral(at);
            shape.into_iter().for_each(|(k, v)| effect.values[k] = v);
            let slopes = self.slopes(&effect)?;
            Some((effect, slopes))
        };
        self.weighed(shapes.into_iter().filter_map(shaped).collect())
    }

    /// One that was screened before, by the slopes of then.
    pub(crate) fn weighed_again(&self, screened: &ScreenedEffect) -> Option<ScreenedEffect> {
        self.weighed(screened.shapes.clone())
    }

    /// The best of the shapes of one effect, by these slopes.
    fn weighed(&self, shapes: Vec<(Effect, Arc<[Slopes]>)>) -> Option<ScreenedEffect> {
        let all = shapes.iter().filter_map(|(effect, slopes)| self.weighed_shape(effect, slopes));
        let mut best = all.reduce(|mut a, mut b| {
            if b.starts[1].1 > a.starts[1].1 {
                a.starts[1] = b.starts[1].clone();
            } else {
                b.starts[1] = a.starts[1].clone();
            }
            if b.starts[0].1 >= a.starts[0].1 { b } else { a }
        })?;
        best.shapes = shapes;
        Some(best)
    }

    /// Slopes of an effect's sizes, where it is nothing; of a sine those at both phases. `None` where
    /// the logs see nothing of it.
    fn slopes(&self, effect: &Effect) -> Option<Arc<[Slopes]>> {
        let kind = effect.kind;
        let phase = kind.parameters.iter().position(|p| p.role == Role::Phase);
        let turns: &[f64] = if phase.is_some() { &[0.0, FRAC_PI_2] } else { &[0.0] };
        let sizes: Vec<usize> =
            (0..kind.parameters.len()).filter(|k| kind.parameters[*k].is_size()).collect();
        let mut more: Vec<Slopes> = Vec::new();
        for turn in turns {
            let mut point = self.ctx.null.point.clone();
            let mut effect = effect.clone();
            if let Some(phase) = phase {
                effect.values[phase] = *turn;
            }
            let of = EffectScope::Shared(point.shared.len());
            point.shared.push(effect);
            let frees: Vec<FreeParameter> = sizes
                .iter()
                .map(|k| FreeParameter { of, parameter: *k, expected: f64::INFINITY })
                .collect();
            let share = if kind.parameters[sizes[0]].unit == "N·m" { OF_TORQUE } else { 1.0 };
            more.extend(fit::slopes(
                self.ctx.problem,
                &point,
                &frees,
                &self.ctx.null.residuals,
                share,
            ));
        }
        let seen: f64 = more.iter().flatten().flatten().flatten().map(|v| v * v).sum();
        (seen.is_finite() && seen > 1e-6).then(|| more.into())
    }

    fn weighed_shape(&self, effect: &Effect, more: &Arc<[Slopes]>) -> Option<ScreenedEffect> {
        let EffectPlace { kind, .. } = effect.place();
        let phase = kind.parameters.iter().position(|p| p.role == Role::Phase);
        let sizes: Vec<usize> =
            (0..kind.parameters.len()).filter(|k| kind.parameters[*k].is_size()).collect();
        let (gain, step, deviations) = gain_beside(&self.null, more)?;
        let far = (rules::GAIN / self.evidence_share(&more[0])).sqrt() * deviations[0];
        let shaped = (effect.clone(), phase);
        let here = (sized(&shaped, step.as_slice()), gain);
        let beside_none = self.given.as_ref().and_then(|given| gain_beside(given, more));
        let there = beside_none
            .map_or(here.clone(), |(gain, step, _)| (sized(&shaped, step.as_slice()), gain));
        // A value held at the bound where there is no effect explains nothing.
        let starts = [here, there].map(|(effect, gain)| {
            let nowhere = sizes.iter().all(|k| {
                let (p, v) = (&kind.parameters[*k], effect.values[*k]);
                let far = matches!(p.role, Role::Reciprocal { .. }) && v == p.high;
                v == p.without_effect(v) || far
            });
            (effect, if nowhere { 0.0 } else { gain })
        });
        // As far from nothing as would lower the sum of squares by what counts.
        let parameter = sizes[0];
        let value = match kind.parameters[parameter].role {
            Role::Reciprocal { step } => 1.0 / (step * far),
            Role::Size { step, neutral } => neutral + step * far,
            _ => f64::NAN,
        };
        let limit = EffectLimit { effect: effect.place(), parameter, value };
        Some(ScreenedEffect { starts, limit, slopes: more.clone(), shapes: Vec::new() })
    }

    /// Share of the squares of these slopes that counts as evidence.
    fn evidence_share(&self, slopes: &Slopes) -> f64 {
        let (mut counts, mut all) = (0.0, f64::MIN_POSITIVE);
        for (slope, weights) in slopes.iter().zip(&self.weights) {
            for (value, weight) in slope.iter().flatten().zip(weights) {
                let square = value * value;
                counts += weight * square;
                all += square;
            }
        }
        counts / all
    }

    /// Orders of a sine of the joint's angle worth a closer look.
    fn orders(&self, kind: &'static EffectKind, at: Location) -> Vec<Vec<(usize, f64)>> {
        let Location::Joint(joint) = at else {
            return Vec::new();
        };
        let role = |role: Role| kind.parameters.iter().position(|p| p.role == role);
        let size = kind.parameters.iter().position(Parameter::is_size);
        let (Some(order), Some(phase), Some(size)) = (role(Role::Order), role(Role::Phase), size)
        else {
            return Vec::new();
        };
        // A sine of no periods, a quarter turn on, is a constant.
        let mut constant = kind.neutral(at);
        (constant.values[order], constant.values[phase]) = (0.0, FRAC_PI_2);
        let null = self.ctx.null;
        let mut point = null.point.clone();
        let of = EffectScope::Shared(point.shared.len());
        point.shared.push(constant);
        let free = FreeParameter { of, parameter: size, expected: f64::INFINITY };
        let slope = &fit::slopes(self.ctx.problem, &point, &[free], &null.residuals, 1.0)[0];
        let largest = match kind.parameters[size].role {
            Role::Size { step, .. } => kind.parameters[size].high / step,
            _ => f64::INFINITY,
        };
        let wave = SoughtWave { joint, slope, top: kind.parameters[order].high, largest };
        let found = likeliest_orders(&self.ctx.problem.logs, (null, &self.null), &wave);
        found.into_iter().map(|found| vec![(order, found)]).collect()
    }
}

/// By how much the sum of squares falls with these slopes beside all that is free, the step that does
/// it, and its deviations.
fn gain_beside(
    base: &ReducedFit<'_>,
    more: &[Slopes],
) -> Option<(f64, DVector<f64>, DVector<f64>)> {
    let beside = base.beside(more);
    let step = beside.least()?;
    let gain = -beside.at(&step);
    gain.is_finite().then_some((gain, step, beside.deviations()?))
}

/// An effect with the sizes that a step gives it from nothing; of a sine those at both phases, the
/// second a quarter turn on.
fn sized((effect, phase): &(Effect, Option<usize>), step: &[f64]) -> Effect {
    let mut effect = effect.clone();
    let parameters = effect.kind.parameters;
    let sizes: Vec<usize> = (0..parameters.len()).filter(|k| parameters[*k].is_size()).collect();
    for (j, k) in sizes.iter().enumerate() {
        let parameter = &parameters[*k];
        let cosine = step[j];
        let size = match phase {
            // a sin(nθ) + b cos(nθ), the second slope being that at a quarter turn.
            Some(phase) => {
                let sine = step[sizes.len() + j];
                if effect.values[*k] == 0.0 && j == 0 {
                    effect.values[*phase] = sine.atan2(cosine);
                }
                cosine.hypot(sine)
            }
            None => cosine,
        };
        effect.values[*k] = match parameter.role {
            Role::Reciprocal { step } => 1.0 / (1.0 / effect.values[*k] + step * size).max(1e-12),
            Role::Size { step, neutral } => neutral + step * size,
            _ => effect.values[*k],
        }
        .clamp(parameter.low, parameter.high);
    }
    effect
}

/// The likeliest hypotheses: so many by each of their two starts.
pub(crate) fn likeliest<'s>(
    screened: impl Iterator<Item = &'s ScreenedEffect>,
    most: usize,
) -> Vec<&'s ScreenedEffect> {
    let all: Vec<&ScreenedEffect> = screened.collect();
    let mut places: Vec<usize> = Vec::new();
    for start in 0..2 {
        let mut order: Vec<usize> =
            (0..all.len()).filter(|k| all[*k].starts[start].1 > 0.5 * rules::GAIN).collect();
        order.sort_by(|a, b| all[*b].starts[start].1.total_cmp(&all[*a].starts[start].1));
        places.extend(order.into_iter().take(most));
    }
    places.sort_unstable();
    places.dedup();
    places.into_iter().map(|k| all[k]).collect()
}

/// Every effect that is no calibration, at every place, and the user's own, but for those that are
/// known.
pub(crate) fn screened_kinds(problem: &FitProblem) -> impl Iterator<Item = EffectPlace> {
    let of_library = library()
        .filter(|k| !is_calibration(k))
        .flat_map(|kind| kind.places().into_iter().map(move |at| EffectPlace { kind, at }));
    let own = problem.own.iter().map(Effect::place);
    of_library.filter(|effect| !problem.is_known(effect.kind, effect.at)).chain(own)
}

/// Screens every one of them, best first. What was screened before is weighed by its slopes of then, but for
/// waves, whose orders show in what is left.
pub(crate) fn screen(ctx: &SearchContext<'_>) -> Vec<ScreenedEffect> {
    let Some(screening) = Screening::of(ctx) else { return Vec::new() };
    let again = |screened: &ScreenedEffect| {
        let effect = screened.limit.effect;
        match effect.kind.parameters.iter().any(|p| p.role == Role::Order) {
            true => screening.screen(effect),
            false => screening.weighed_again(screened),
        }
    };
    let is_late = || ctx.problem.is_late();
    let mut screened: Vec<ScreenedEffect> = match ctx.screened {
        [] => {
            let kinds: Vec<EffectPlace> = screened_kinds(ctx.problem).collect();
            let in_time = kinds.par_iter().filter(|_| !is_late());
            in_time.filter_map(|effect| screening.screen(*effect)).collect()
        }
        known => known.par_iter().filter(|_| !is_late()).filter_map(again).collect(),
    };
    screened.sort_by(|a, b| b.starts[0].1.total_cmp(&a.starts[0].1));
    screened
}
