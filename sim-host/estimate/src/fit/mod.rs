//! Fitting parameters of effects to logs: least squares of whitened residuals, priors on what a
//! calibration may be, and held-out blocks.
//!
//! A fit works on a [`FitState`]: effects that hold for all logs, effects that each log has of its
//! own, and which of their values are free. Its [`Linear`] model there, residuals and their slopes,
//! comes as normal equations of ten blocks in time (every tenth of every log), so that leaving
//! blocks out costs a small solve and no new simulation.

pub mod calibration;
pub mod covariance;
mod effects;
mod linear;
pub mod per_log;
mod schur;
mod solver;

pub use effects::is_own_and_nothing;
pub use effects::{PerLogEffect, SortedEffects};
pub use linear::Factor;
pub use linear::{HeldOutPrior, LeastSquaresStep, Linear};
pub use schur::{Quadratic, ReducedFit, ReducedNormal, SchurComplement};
pub use solver::{Fitted, SolverOptions, Termination, fit, fit_beside, resume};

use crate::predict::{
    BaselineModel, Compared, ComparedQuantity, PredictError, Prediction, PreparedLog, baseline,
    is_open_factor,
};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::time::Instant;
use trueweld_core::JOINTS;
use trueweld_plant::effects::table::DefinedTable;
use trueweld_plant::effects::{Action, Effect, EffectKind, Location, Parameter, Role, library};
use trueweld_plant::input::{KnownEffect, ModelFile};

/// Blocks in time that can be left out.
pub const BLOCKS: usize = 10;

/// Logs made ready, and the model they judge.
#[derive(Debug)]
pub struct FitProblem {
    /// Robot and process without effects.
    pub model: BaselineModel,
    /// Effects the model has, that are not fitted here.
    pub known: Vec<Effect>,
    /// Effects the model has whose values every log has of its own, fitted to it.
    pub per_log: Vec<PerLogEffect>,
    /// Effects of the user's own that are hypotheses, beside the library's.
    pub own: Vec<Effect>,
    /// What is known of effects without the logs.
    pub declared: Vec<KnownEffect>,
    /// The logs.
    pub logs: Vec<PreparedLog>,
    /// From when on no new work is begun; `None` where there is no hurry.
    pub deadline: Option<Instant>,
}

impl FitProblem {
    /// Makes ready what a model file and logs say.
    pub fn new(file: &ModelFile, logs: Vec<PreparedLog>) -> Self {
        let model = baseline(file);
        let SortedEffects { known, per_log, own } =
            SortedEffects::new(&file.effects, &file.known, file.posterior.as_ref());
        Self { model, known, per_log, own, declared: file.known.clone(), logs, deadline: None }
    }

    /// How far each value of a calibration may be off, one standard deviation: what is declared, or
    /// else `usual`.
    pub fn deviations<'s>(&'s self, effect: &Effect, usual: &'s [f64]) -> &'s [f64] {
        KnownEffect::of(&self.declared, effect.kind, effect.at)
            .map_or(usual, |known| &known.deviation)
    }

    /// True for an effect that is not looked for, since the model is right about it.
    pub fn is_known(&self, kind: &EffectKind, at: Location) -> bool {
        let is_rigid = matches!(at, Location::Joint(joint) if self.model.rigid[joint]);
        if let Location::Joint(joint) = at
            && is_rigid != kind.of_rigid
            && (kind.of_rigid || kind.is_of_spring(joint, self.model.robot.parameters()))
        {
            return true;
        }
        KnownEffect::of(&self.declared, kind, at).is_some_and(KnownEffect::is_exact)
    }

    /// Torque constants that were found for these logs and that a model, with such `stated` ones, does
    /// not have, as effects that correct nothing.
    pub fn open_factors(&self, stated: &[Option<f64>; JOINTS]) -> Vec<Effect> {
        let kinds = library().filter(|kind| is_open_factor(kind));
        let all = kinds.flat_map(|kind| kind.places().into_iter().map(|at| kind.neutral(at)));
        all.filter_map(|mut effect| {
            let Location::Joint(joint) = effect.at else { return None };
            let found = self.logs.iter().find_map(|log| log.factors[joint]);
            effect.values[0] = found.filter(|_| stated[joint].is_none())?;
            Some(effect)
        })
        .collect()
    }

    /// The same model, judged by other logs, in no hurry.
    pub fn on(&self, logs: Vec<PreparedLog>) -> Self {
        Self {
            model: self.model.clone(),
            known: self.known.clone(),
            per_log: self.per_log.clone(),
            own: self.own.clone(),
            declared: self.declared.clone(),
            logs,
            deadline: None,
        }
    }

    /// True where no new work is to be begun.
    pub fn is_late(&self) -> bool {
        self.deadline.is_some_and(|deadline| Instant::now() >= deadline)
    }
}

/// Which effect a free value belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EffectScope {
    /// The effect of that index among those for all logs.
    Shared(usize),
    /// The effect of that index among those of one log.
    Log(usize, usize),
}

/// One free value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeParameter {
    /// Whose.
    pub of: EffectScope,
    /// Which of the effect's parameters.
    pub parameter: usize,
    /// How far from no effect a calibration is expected to be, one standard deviation in the
    /// value's unit; infinite for a value that nothing is known of.
    pub expected: f64,
}

/// Curvature of what is expected of how a table bends, by its values in this unit.
pub fn roughness(table: &DefinedTable, unit: f64) -> DMatrix<f64> {
    let n = table.places.count();
    let mut curvature = DMatrix::zeros(n, n);
    for bend in table.bends() {
        for (i, a) in bend {
            for (j, b) in bend {
                curvature[(i, j)] += a * b * unit * unit;
            }
        }
    }
    curvature
}

/// A model being fitted.
#[derive(Debug, Clone)]
pub struct FitState {
    /// Effects that hold for all logs.
    pub shared: Vec<Effect>,
    /// Effects of each log.
    pub per_log: Vec<Vec<Effect>>,
    /// Free values.
    pub free: Vec<FreeParameter>,
}

/// Longest step of a value that shapes an effect, in the fit's units: beyond it slopes say nothing.
/// Sizes may go anywhere.
fn reach(role: Role) -> f64 {
    match role {
        Role::Size { .. } | Role::Reciprocal { .. } => f64::INFINITY,
        _ => 10.0,
    }
}

/// Step of a value in a fit's own units, in which it is of the order of 1; the fit works on value =
/// of(u).
fn value_at(parameter: &Parameter, from: f64, u: f64) -> f64 {
    let value = match parameter.role {
        Role::Size { step, .. } | Role::Position { step, .. } => from + step * u,
        Role::Reciprocal { step } => 1.0 / (1.0 / from + step * u).max(1e-12),
        Role::Shape(_) | Role::Wavelength => from * (0.1 * u).exp(),
        Role::Order => from + 0.05 * u,
        Role::SpindleOrder => from + 0.002 * u,
        Role::PathPosition => from + 1e-2 * u,
        Role::Phase => from + 0.1 * u,
    };
    match parameter.role {
        Role::Phase => value,
        _ => value.clamp(parameter.low, parameter.high),
    }
}

/// Size of one unit of a fit at a value, in the value's unit.
pub fn unit(parameter: &Parameter, value: f64) -> f64 {
    match parameter.role {
        Role::Size { step, .. } | Role::Position { step, .. } => step,
        Role::Reciprocal { step } => step * value * value,
        Role::Shape(_) | Role::Wavelength => 0.1 * value,
        Role::Order => 0.05,
        Role::SpindleOrder => 0.002,
        Role::PathPosition => 1e-2,
        Role::Phase => 0.1,
    }
}

/// Step in a fit's units from a value to one not far from it, the inverse of [`value_at`].
fn step_to(parameter: &Parameter, from: f64, to: f64) -> f64 {
    match parameter.role {
        Role::Reciprocal { step } => (1.0 / to - 1.0 / from) / step,
        _ => (to - from) / unit(parameter, from),
    }
}

impl FitState {
    /// A point without effects beyond the known.
    pub fn empty(logs: usize) -> Self {
        Self { shared: Vec::new(), per_log: vec![Vec::new(); logs], free: Vec::new() }
    }

    /// The effect a free value belongs to.
    pub fn effect(&self, of: EffectScope) -> &Effect {
        match of {
            EffectScope::Shared(i) => &self.shared[i],
            EffectScope::Log(log, i) => &self.per_log[log][i],
        }
    }

    fn effect_mut(&mut self, of: EffectScope) -> &mut Effect {
        match of {
            EffectScope::Shared(i) => &mut self.shared[i],
            EffectScope::Log(log, i) => &mut self.per_log[log][i],
        }
    }

    /// A free value's parameter.
    pub fn parameter(&self, free: &FreeParameter) -> &'static Parameter {
        &self.effect(free.of).kind.parameters[free.parameter]
    }

    /// A free value.
    pub fn value(&self, free: &FreeParameter) -> f64 {
        self.effect(free.of).values[free.parameter]
    }

    /// Adds an effect for all logs, with all its values free.
    pub fn add(&mut self, effect: Effect) {
        let nothing_known = vec![f64::INFINITY; effect.values.len()];
        self.add_expected(effect, &nothing_known);
    }

    /// Adds an effect for all logs, of whose values this much is expected; one of which nothing is
    /// stays as it is.
    pub fn add_expected(&mut self, effect: Effect, expected: &[f64]) {
        let of = EffectScope::Shared(self.shared.len());
        self.shared.push(effect);
        self.release(of, expected);
    }

    /// Adds an effect of one log, with all its values free.
    pub fn add_to_log(&mut self, log: usize, effect: Effect, expected: &[f64]) {
        let of = EffectScope::Log(log, self.per_log[log].len());
        self.per_log[log].push(effect);
        self.release(of, expected);
    }

    /// What is expected of each value of an effect; 0 for one that is not free.
    pub fn expected(&self, of: EffectScope) -> Vec<f64> {
        let mut expected = vec![0.0; self.effect(of).values.len()];
        let own = self.free.iter().filter(|free| free.of == of);
        own.for_each(|free| expected[free.parameter] = free.expected);
        expected
    }

    fn release(&mut self, of: EffectScope, expected: &[f64]) {
        let free = |(parameter, e): (usize, &f64)| {
            (*e != 0.0).then_some(FreeParameter { of, parameter, expected: *e })
        };
        self.free.extend(expected.iter().enumerate().filter_map(free));
    }

    /// The same without one of the effects for all logs.
    pub fn without(&self, index: usize) -> Self {
        let mut next = self.clone();
        next.shared.remove(index);
        next.free.retain(|f| f.of != EffectScope::Shared(index));
        for free in &mut next.free {
            if let EffectScope::Shared(i) = &mut free.of
                && *i > index
            {
                *i -= 1;
            }
        }
        next
    }

    /// Takes the free values of some effects back to where the effect is not there.
    pub fn reset(&mut self, which: impl Fn(&Effect) -> bool) {
        for k in 0..self.free.len() {
            let free = self.free[k];
            if which(self.effect(free.of)) {
                let nothing = self.parameter(&free).without_effect(self.value(&free));
                self.effect_mut(free.of).values[free.parameter] = nothing;
            }
        }
    }

    /// The effects of one log.
    pub fn effects(&self, problem: &FitProblem, log: usize) -> Vec<Effect> {
        problem.known.iter().chain(&self.shared).chain(&self.per_log[log]).cloned().collect()
    }

    /// Free values moved by a step in the fit's units.
    pub fn moved(&self, step: &DVector<f64>) -> Self {
        let mut next = self.clone();
        for (k, free) in self.free.iter().enumerate() {
            let parameter = self.parameter(free);
            let step = step[k].clamp(-reach(parameter.role), reach(parameter.role));
            next.effect_mut(free.of).values[free.parameter] =
                value_at(parameter, self.value(free), step);
        }
        next.tidy();
        next
    }

    /// Sines with their amplitude above zero and their phase within half a turn.
    fn tidy(&mut self) {
        for effect in self.shared.iter_mut().chain(self.per_log.iter_mut().flatten()) {
            let Some(phase) = effect.kind.parameters.iter().position(|p| p.role == Role::Phase)
            else {
                continue;
            };
            effect.values[phase] = (effect.values[phase] + std::f64::consts::PI)
                .rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
        }
    }

    /// What holds the values while blocks are left out, in the fit's units.
    fn held_out_prior(&self) -> HeldOutPrior {
        let mut held_out_prior = HeldOutPrior::none(self.free.len());
        for (k, free) in self.free.iter().enumerate().filter(|(_, f)| !f.expected.is_finite()) {
            let (parameter, value) = (self.parameter(free), self.value(free));
            match parameter.role {
                Role::Size { step, neutral } if value != neutral => {
                    held_out_prior.away[k] = (value - neutral) / step;
                    held_out_prior.weight[k] = held_out_prior.away[k].powi(-2);
                }
                Role::Size { .. } | Role::Reciprocal { .. } => {}
                role => {
                    held_out_prior.weight[k] = reach(role).powi(-2);
                    held_out_prior.shapes.push(k);
                }
            }
        }
        held_out_prior
    }

    /// Curvature of the priors and how far each value is from where it was expected, in the fit's
    /// units.
    fn priors(&self) -> (DMatrix<f64>, DVector<f64>) {
        let n = self.free.len();
        let (mut prior, mut away) = (DMatrix::zeros(n, n), DVector::zeros(n));
        for (k, free) in self.free.iter().enumerate() {
            let parameter = self.parameter(free);
            let value = self.value(free);
            let unit = unit(parameter, value);
            if free.expected.is_finite() {
                prior[(k, k)] = (unit / free.expected).powi(2);
                away[k] = (value - parameter.without_effect(value)) / unit;
            }
        }
        for (k, free) in self.free.iter().enumerate() {
            let Action::Expression(formula) = self.effect(free.of).kind.action else { continue };
            let definition = &formula.definition;
            let Some(table) = definition.table.as_ref().filter(|t| t.bend.is_finite()) else {
                continue;
            };
            let Some(place) = free.parameter.checked_sub(definition.named().len()) else {
                continue;
            };
            let unit = unit(self.parameter(free), self.value(free));
            away[k] = self.value(free) / unit;
            if place == 0 {
                // The values of a table are freed together, in order.
                let bends = roughness(table, unit);
                let mut own = prior.view_mut((k, k), bends.shape());
                own += bends;
            }
        }
        (prior, away)
    }
}

/// Residuals of all logs at a point.
pub type Residuals = Vec<Prediction>;

/// Residuals at a point, one entry a log.
///
/// # Errors
/// [`PredictError`] of the first log the model cannot be driven through.
pub fn residuals(problem: &FitProblem, point: &FitState) -> Result<Residuals, PredictError> {
    residuals_near(problem, point, None)
}

/// [`residuals`]; `near`: residuals at a point not far from this one.
fn residuals_near(
    problem: &FitProblem,
    point: &FitState,
    near: Option<&Residuals>,
) -> Result<Residuals, PredictError> {
    let of_log = |(log, experiment): (usize, &PreparedLog)| {
        let near = near.map(|at| (&at[log], None));
        let effects = point.effects(problem, log);
        let at = experiment.predict_from(&problem.model, &effects, near)?;
        at.with_noise(experiment, &problem.model, &effects)
    };
    problem.logs.par_iter().enumerate().map(of_log).collect()
}

/// The same at a point that has one effect more, or that effect with other values, than where
/// residuals are `at`: logs and instruments that see nothing of it are not predicted again.
///
/// # Errors
/// [`PredictError`] of the first log the model cannot be driven through.
pub fn residuals_beside(
    problem: &FitProblem,
    point: &FitState,
    (at, effect): (&Residuals, &Effect),
) -> Result<Residuals, PredictError> {
    let of_log = |(log, at): (usize, &Prediction)| {
        let experiment = &problem.logs[log];
        if !experiment.concerns(effect) {
            return Ok(at.clone());
        }
        experiment.predict(&problem.model, &point.effects(problem, log), Some((at, effect)))
    };
    at.par_iter().enumerate().map(of_log).collect()
}

/// Sum of the squares by which all residuals at two points differ.
pub fn distance(a: &Residuals, b: &Residuals) -> f64 {
    let pairs = a.iter().zip(b).flat_map(|(a, b)| a.residual.iter().zip(&b.residual));
    pairs.map(|(a, b)| (a - b).powi(2)).sum()
}

/// Sum of squares of all residuals.
pub fn chi_square(residuals: &Residuals) -> f64 {
    residuals.iter().flat_map(|p| &p.residual).map(|r| r * r).sum()
}

/// Number of all residuals.
pub fn count(residuals: &Residuals) -> usize {
    residuals.iter().map(|p| p.residual.len()).sum()
}

/// Slope of one log's residuals by one free value in the fit's units; `None` where the log does not
/// see it.
fn slope(
    problem: &FitProblem,
    point: &FitState,
    free: &FreeParameter,
    log: usize,
    at: &Prediction,
    share: f64,
) -> Result<Option<Vec<f64>>, PredictError> {
    if matches!(free.of, EffectScope::Log(own, _) if own != log) {
        return Ok(None);
    }
    let experiment = &problem.logs[log];
    let effect = point.effect(free.of);
    if !experiment.concerns(effect) {
        return Ok(None);
    }
    let parameter = point.parameter(free);
    let value = point.value(free);
    // Away from the bound, where the value stands at one.
    let step = if value_at(parameter, value, share) == value { -share } else { share };
    let mut moved = point.clone();
    moved.effect_mut(free.of).values[free.parameter] = value_at(parameter, value, step);
    let there = match (effect.kind.action, effect.at) {
        // Of what is far cheaper to see than to play through.
        (Action::Mounting(motion), Location::Joint(joint)) if experiment.sees_tool_alone() => {
            let more = motion(&moved.effect(free.of).values) * motion(&effect.values).inverse();
            experiment.remounted(&problem.model, &point.effects(problem, log), at, joint, &more)?
        }
        _ => {
            let effects = moved.effects(problem, log);
            experiment.predict_from(&problem.model, &effects, Some((at, Some(effect))))?.residual
        }
    };
    Ok(Some(there.iter().zip(&at.residual).map(|(a, b)| (a - b) / step).collect()))
}

/// Slopes of one free value in every log.
pub type Slopes = Vec<Option<Vec<f64>>>;

/// Slopes of some free values of a point, taken over a `share` of a fit's unit, in parallel over
/// values and logs. A value that makes the model fall apart has none.
pub fn slopes(
    problem: &FitProblem,
    point: &FitState,
    frees: &[FreeParameter],
    at: &Residuals,
    share: f64,
) -> Vec<Slopes> {
    slopes_where(problem, point, frees, at, share, |_, _| true)
}

/// The same of those values in those logs, by their indices, for which `wanted` is true; none elsewhere.
pub fn slopes_where(
    problem: &FitProblem,
    point: &FitState,
    frees: &[FreeParameter],
    at: &Residuals,
    share: f64,
    wanted: impl Fn(usize, usize) -> bool + Sync,
) -> Vec<Slopes> {
    let logs = problem.logs.len();
    let one = |free: usize, log: usize| {
        slope(problem, point, &frees[free], log, &at[log], share).unwrap_or(None)
    };
    let flat: Vec<Option<Vec<f64>>> = (0..frees.len() * logs)
        .into_par_iter()
        .map(|k| (k / logs, k % logs))
        .map(|(free, log)| if wanted(free, log) { one(free, log) } else { None })
        .collect();
    let mut flat = flat.into_iter();
    frees.iter().map(|_| flat.by_ref().take(logs).collect()).collect()
}

/// Blocks of each log's compared values, one after the other in time: values of one quantity and
/// component come in order of their rows. They are as long as each other, but for a log in which the
/// push changes: half of the blocks share the time, half the change. A weld's first seconds tell most
/// of what there is to tell of its material, and one block that held them all could be predicted from
/// no other.
pub fn blocks_of(problem: &FitProblem) -> Vec<Vec<u8>> {
    problem.logs.iter().map(blocks_of_log).collect()
}

fn blocks_of_log(experiment: &PreparedLog) -> Vec<u8> {
    let compared = &experiment.compared;
    let rows = compared.iter().map(|c| c.row);
    let (first, last) = (rows.clone().min().unwrap_or(0), rows.max().unwrap_or(0));
    let is_push = |c: &&Compared| matches!(c.quantity, ComparedQuantity::Force) && c.component == 2;
    let push: Vec<&Compared> = compared.iter().filter(is_push).collect();
    // Sum of all changes up to a row.
    let mut changed = vec![(first, 0.0)];
    for [before, after] in push.array_windows() {
        let so_far = changed[changed.len() - 1].1;
        changed.push((after.row, so_far + (after.measured - before.measured).abs()));
    }
    let total = changed[changed.len() - 1].1;
    let largest = push.iter().map(|c| c.measured.abs()).fold(0.0, f64::max);
    let by_change = if total > 0.0 { 0.5 * (total / largest).min(1.0) } else { 0.0 };
    let share = |row: usize| {
        let time = (row - first) as f64 / (last - first + 1) as f64;
        let before = changed.partition_point(|(at, _)| *at <= row).max(1) - 1;
        let so_far = if total > 0.0 { changed[before].1 / total } else { 0.0 };
        time * (1.0 - by_change) + so_far * by_change
    };
    compared.iter().map(|c| (share(c.row) * BLOCKS as f64) as u8).collect()
}

/// Share of a fit's unit over which slopes are taken.
pub const SLOPE_STEP: f64 = 0.1;
