//! Which physical effect is missing: every effect of the library, at every place, as a hypothesis.
//!
//! 1. The logs are fitted with calibrations alone ([`crate::calibrate`]).
//! 2. Every hypothesis is screened: its slopes at that point, with all calibrations free beside it, say by how much the sum of
//!    squares would fall.
//! 3. The best are fitted in full, calibrations with them, and judged by blocks in time that were left out.

use crate::calibrate::{calibrations, expected, is_calibration, nothing, of_logs, places};
use crate::fit::{self, Bench, Effort, Fitted, Free, Of, Point, Residuals, Slopes};
use crate::log::LogKind;
use crate::predict::PredictError;
use nalgebra::DVector;
use rayon::prelude::*;
use std::collections::BTreeMap;
use trueweld_plant::effects::{At, Effect, Kind, Role, TABLE};

/// A hypothesis: an effect at a place, and what screening says of it.
#[derive(Debug, Clone)]
pub struct Screened {
    /// The effect, with the values to start a fit from.
    pub effect: Effect,
    /// By how much the sum of squares would fall.
    pub gain: f64,
}

/// Waves along a weld that a plate's waviness is looked for with.
const WAVES: [f64; 16] = [0.5, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 12.0];

/// Shares of a weld's length at which a step of the material is looked for.
const POSITIONS: [f64; 11] = [0.08, 0.17, 0.25, 0.33, 0.42, 0.5, 0.58, 0.67, 0.75, 0.83, 0.92];

/// Orders of the spindle that are looked for.
const SPINDLE_ORDERS: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];

/// Values of its shaping parameters that a hypothesis is screened with.
fn shapes(kind: &'static Kind, length: f64) -> Vec<Vec<(usize, f64)>> {
    let mut all = vec![Vec::new()];
    for (k, p) in kind.parameters.iter().enumerate() {
        let values: Vec<f64> = match p.role {
            Role::Shape(starts) => starts.to_vec(),
            Role::SpindleOrder => SPINDLE_ORDERS.to_vec(),
            Role::Wavelength => WAVES.iter().map(|w| length / w).collect(),
            Role::PathPosition => POSITIONS.iter().map(|s| s * length).collect(),
            _ => continue,
        };
        all = all.iter().flat_map(|a| values.iter().map(|v| [a.clone(), vec![(k, *v)]].concat())).collect();
    }
    all
}

/// Everything that screening needs of the point it is done at.
#[derive(Clone, Copy)]
pub struct Ground<'a> {
    /// The logs.
    pub bench: &'a Bench,
    /// Blocks of their values.
    pub blocks: &'a [Vec<u8>],
    /// Where all hypotheses start from.
    pub null: &'a Fitted,
    /// Longest weld, m.
    pub length: f64,
}

impl Ground<'_> {
    /// Screens one effect at one place with all its shapes; the best of them. `None` where the logs see nothing of it.
    fn screen(&self, kind: &'static Kind, at: At) -> Option<Screened> {
        let scans = kind.parameters.iter().any(|p| p.role == Role::Order);
        let shapes = if scans { self.orders(kind, at) } else { shapes(kind, self.length) };
        shapes
            .into_iter()
            .filter_map(|shape| self.screen_shape(kind, at, &shape))
            .max_by(|a, b| a.gain.total_cmp(&b.gain))
    }

    fn screen_shape(&self, kind: &'static Kind, at: At, shape: &[(usize, f64)]) -> Option<Screened> {
        let mut effect = nothing(kind, at);
        for (k, v) in shape {
            effect.values[*k] = *v;
        }
        let phase = kind.parameters.iter().position(|p| p.role == Role::Phase);
        let turns: &[f64] = if phase.is_some() { &[0.0, std::f64::consts::FRAC_PI_2] } else { &[0.0] };
        let sizes: Vec<usize> = (0..kind.parameters.len())
            .filter(|k| matches!(kind.parameters[*k].role, Role::Size { .. } | Role::Reciprocal { .. }))
            .collect();
        let mut more: Vec<Slopes> = Vec::new();
        for turn in turns {
            let mut point = self.null.point.clone();
            let mut effect = effect.clone();
            if let Some(phase) = phase {
                effect.values[phase] = *turn;
            }
            let of = Of::All(point.all.len());
            point.all.push(effect);
            let frees: Vec<Free> = sizes.iter().map(|k| Free { of, parameter: *k, expected: f64::INFINITY }).collect();
            more.extend(fit::slopes(self.bench, &point, &frees, &self.null.at, 1.0));
        }
        let seen: f64 = more.iter().flatten().flatten().flatten().map(|v| v * v).sum();
        if !(seen.is_finite() && seen > 1e-6) {
            return None;
        }
        let (gain, step) = self.gain(&more)?;
        let n = self.null.point.free.len();
        for (j, k) in sizes.iter().enumerate() {
            let parameter = &kind.parameters[*k];
            let cosine = step[n + j];
            let size = match phase {
                // a sin(nθ) + b cos(nθ), the second slope being that at a quarter turn.
                Some(phase) => {
                    let sine = step[n + sizes.len() + j];
                    if effect.values[*k] == 0.0 && j == 0 {
                        effect.values[phase] = sine.atan2(cosine);
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
        // A value held at the bound where there is no effect explains nothing.
        let nowhere = sizes.iter().all(|k| {
            let (p, v) = (&kind.parameters[*k], effect.values[*k]);
            v == fit::neutral(p, v) || (matches!(p.role, Role::Reciprocal { .. }) && v == p.high)
        });
        (!nowhere).then_some(Screened { effect, gain })
    }

    /// By how much the sum of squares falls with these slopes beside all that is free, and the step that does it.
    fn gain(&self, more: &[Slopes]) -> Option<(f64, DVector<f64>)> {
        let linear = self.null.linear.extended(self.blocks, &self.null.at, &self.null.slopes, more);
        let before = self.null.linear.solve(None, 0.0, None)?;
        let after = linear.solve(None, 0.0, None)?;
        let gain = self.null.linear.cost(&before.step) - linear.cost(&after.step);
        gain.is_finite().then_some((gain, after.step))
    }

    /// Orders of a sine of the joint's angle worth a closer look: the highest lines of the residual against it, with the
    /// response to a constant offset as what a slow sine meets.
    fn orders(&self, kind: &'static Kind, at: At) -> Vec<Vec<(usize, f64)>> {
        let At::Joint(joint) = at else { return Vec::new() };
        let order = kind.parameters.iter().position(|p| p.role == Role::Order);
        let (Some(order), offset) =
            (order, if kind.id == "link-encoder-ripple" { "link-encoder-offset" } else { "encoder-offset" })
        else {
            return Vec::new();
        };
        let mut point = self.null.point.clone();
        let of = Of::All(point.all.len());
        point.all.push(nothing(crate::calibrate::kind(offset), at));
        let free = Free { of, parameter: 0, expected: f64::INFINITY };
        let slope = &fit::slopes(self.bench, &point, &[free], &self.null.at, 1.0)[0];
        // What is left of the residual with all calibrations at their best.
        let Some(step) = self.null.linear.solve(None, 0.0, None) else { return Vec::new() };
        let mut samples: Vec<(f64, f64, f64)> = Vec::new();
        for (log, experiment) in self.bench.experiments.iter().enumerate() {
            let (Some(slope), Some(motion)) = (&slope[log], &self.null.at[log].motion) else { continue };
            let mut left = self.null.at[log].residual.clone();
            for (k, s) in self.null.slopes.iter().enumerate() {
                if let Some(s) = &s[log] {
                    left.iter_mut().zip(s).for_each(|(l, s)| *l += s * step.step[k]);
                }
            }
            let every = (experiment.compared.len() / SCANNED).max(1);
            // A whole row at a time would keep to one component: an odd stride visits them all.
            let every = if every.is_multiple_of(2) { every + 1 } else { every };
            for i in (0..left.len()).step_by(every) {
                if slope[i] != 0.0 {
                    let angle = motion.link[experiment.compared[i].row][joint];
                    samples.push((angle, slope[i], left[i]));
                }
            }
        }
        let (low, high) = samples.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), s| (l.min(s.0), h.max(s.0)));
        let range = high - low;
        if range.is_nan() || range <= 1e-3 {
            return Vec::new();
        }
        // Half a turn of phase over the range tells two orders apart.
        let spacing = (0.5 * std::f64::consts::PI / (high - low)).clamp(0.25, 4.0);
        let top = kind.parameters[order].high.min(HIGHEST_ORDER);
        let count = ((top - 1.0) / spacing) as usize;
        let power: Vec<(f64, f64)> = (0..count)
            .into_par_iter()
            .map(|k| {
                let n = 1.0 + k as f64 * spacing;
                let mut sums = [0.0; 5];
                for (angle, slope, left) in &samples {
                    let (sine, cosine) = (n * angle).sin_cos();
                    let (s, c) = (sine * slope, cosine * slope);
                    sums[0] += s * left;
                    sums[1] += c * left;
                    sums[2] += s * s;
                    sums[3] += s * c;
                    sums[4] += c * c;
                }
                let det = sums[2] * sums[4] - sums[3] * sums[3];
                let gain = (sums[0] * sums[0] * sums[4] - 2.0 * sums[0] * sums[1] * sums[3]
                    + sums[1] * sums[1] * sums[2])
                    / det;
                (n, if det > 1e-6 * sums[2] * sums[4] { gain } else { 0.0 })
            })
            .collect();
        let mut peaks: Vec<usize> = (0..power.len())
            .filter(|&k| {
                let at = |j: usize| power.get(j).map_or(0.0, |p| p.1);
                power[k].1 > 0.0 && power[k].1 >= at(k + 1) && (k == 0 || power[k].1 >= at(k - 1))
            })
            .collect();
        peaks.sort_by(|a, b| power[*b].1.total_cmp(&power[*a].1));
        peaks.truncate(3);
        peaks.iter().map(|k| vec![(order, power[*k].0)]).collect()
    }
}

/// Values of a log that a scan over orders looks at, and the highest order it looks for.
const SCANNED: usize = 3000;
const HIGHEST_ORDER: f64 = 300.0;

/// Screens every effect that is no calibration, at every place. Best first.
pub fn screen(ground: &Ground<'_>) -> Vec<Screened> {
    let all: Vec<(&'static Kind, At)> = TABLE
        .iter()
        .filter(|k| !is_calibration(k))
        .flat_map(|k| places(k).into_iter().map(move |at| (*k, at)))
        .collect();
    let mut screened: Vec<Screened> = all.par_iter().filter_map(|(kind, at)| ground.screen(kind, *at)).collect();
    screened.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    screened
}

/// Fits the calibrations alone: those logs first whose residuals follow them nearly in proportion, then all.
///
/// # Errors
/// [`PredictError`].
pub fn calibrated(bench: &Bench, blocks: &[Vec<u8>]) -> Result<Fitted, PredictError> {
    let point = calibrations(bench);
    let stale = of_logs(&point);
    fit::fit(bench, &point, blocks, &[], Effort { steps: 4, stale })
}

/// Fits one hypothesis in full from where screening left it.
///
/// # Errors
/// [`PredictError`].
pub fn fit_hypothesis(ground: &Ground<'_>, effect: &Effect, steps: usize) -> Result<Fitted, PredictError> {
    // Slopes at nothing say little of the size of what is not in proportion to it: a gap, a loop.
    let mut start = None;
    for factor in [1.0, 0.4, 2.5, 6.0] {
        let mut effect = effect.clone();
        for (v, p) in effect.values.iter_mut().zip(effect.kind.parameters) {
            if let Role::Size { neutral, .. } = p.role {
                *v = (neutral + (*v - neutral) * factor).clamp(p.low, p.high);
            }
        }
        let mut point: Point = ground.null.point.clone();
        point.add(effect, f64::INFINITY);
        if let Ok(at) = fit::residuals(ground.bench, &point) {
            let left = fit::chi_square(&at);
            if start.as_ref().is_none_or(|(least, _)| left < *least) {
                start = Some((left, point));
            }
        }
    }
    let point = match start {
        Some((_, point)) => point,
        None => {
            let mut point: Point = ground.null.point.clone();
            point.add(effect.clone(), f64::INFINITY);
            point
        }
    };
    let stale = ground.null.slopes.len();
    fit::fit(ground.bench, &point, ground.blocks, &ground.null.slopes, Effort { steps, stale })
}

/// Longest weld among the logs, m, for what is looked for along it.
pub fn longest_weld(logs: &[crate::log::Log]) -> f64 {
    let length = |log: &crate::log::Log| log.weld.as_ref().map(|w| (w.end - w.start).norm());
    logs.iter().filter(|l| l.kind == LogKind::Weld).filter_map(length).fold(0.5, f64::max)
}

/// Score of residuals: root mean square.
pub fn score(residuals: &Residuals) -> f64 {
    (fit::chi_square(residuals) / fit::count(residuals).max(1) as f64).sqrt()
}

/// Sum of squares and number of the residuals of one channel in one log.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Part {
    /// Sum of squares.
    pub square: f64,
    /// Number.
    pub count: usize,
}

/// Sums of squares by log and channel.
pub fn parts(bench: &Bench, residuals: &Residuals) -> BTreeMap<(usize, &'static str), Part> {
    let mut parts: BTreeMap<(usize, &'static str), Part> = BTreeMap::new();
    for (log, (experiment, prediction)) in bench.experiments.iter().zip(residuals).enumerate() {
        for (c, r) in experiment.compared.iter().zip(&prediction.residual) {
            let part = parts.entry((log, c.quantity.channel())).or_default();
            part.square += r * r;
            part.count += 1;
        }
    }
    parts
}

/// What the data say.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Nothing is missing above the floor.
    Adequate,
    /// An effect of the library, or two, explain what was missing.
    EffectFound,
    /// Something is missing that none of the library's effects explains.
    UnknownEffect,
}

impl Verdict {
    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Adequate => "adequate",
            Self::EffectFound => "effect-found",
            Self::UnknownEffect => "unknown-effect",
        }
    }
}

/// An effect with fitted values.
#[derive(Debug, Clone)]
pub struct Found {
    /// The effect.
    pub effect: Effect,
    /// Its log, where each has its own.
    pub log: Option<usize>,
    /// 95 % interval of each value.
    pub interval: Vec<[f64; 2]>,
}

/// One explanation: an effect, or two that act together.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Its effects.
    pub effects: Vec<Found>,
    /// Score on held-out blocks of the model as it was given.
    pub held_out_before: f64,
    /// Score on held-out blocks with the effects, calibrations refitted.
    pub held_out_after: f64,
    /// How likely this explanation is, given the data and the library.
    pub probability: f64,
    /// Share of what was above the floor that is still there.
    pub left: f64,
    /// Other explanations that these data do not tell from this one, by index.
    pub indistinguishable: Vec<usize>,
    /// The fit.
    pub fitted: Fitted,
}

/// What a diagnosis found.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// What the data say.
    pub verdict: Verdict,
    /// Score of the model as it was given.
    pub score_before: f64,
    /// Residuals of the model as it was given.
    pub before: Residuals,
    /// Residuals with calibrations alone.
    pub calibrated: Residuals,
    /// Explanations, best first.
    pub candidates: Vec<Candidate>,
    /// What is a little off in the cell besides.
    pub calibration: Vec<Found>,
    /// The model with the best explanation and the calibrations that count.
    pub improved: Fitted,
    /// Smallest size of each effect that these data would have shown, in units of its first size.
    pub limits: Vec<(Effect, f64)>,
}

/// Rules of decision. Their numbers come from the corpus in `tests/`, never from recorded campaigns.
pub mod rules {
    /// Fall of the held-out sum of squares that chance does not reach among some hundred hypotheses.
    pub const GAIN: f64 = 30.0;
    /// The same in standard errors over blocks.
    pub const ERRORS: f64 = 2.0;
    /// Fall of one channel's sum of squares below which its noise is not known well enough, as a share.
    pub const VISIBLE: f64 = 0.08;
    /// Share of what was above the floor that an explanation may leave.
    pub const LEFT: f64 = 0.1;
    /// The same, where all together is as near to the floor as this score.
    pub const LEFT_NEAR: f64 = 0.5;
    /// Share of what one effect leaves that a second one may leave.
    pub const HALVED: f64 = 0.5;
    /// Score that is near the floor.
    pub const NEAR: f64 = 1.05;
    /// Score of any channel from which on something is above the floor.
    pub const FLOOR: f64 = 1.3;
    /// Fall of the sum of squares that a calibration must bring to be kept, and so much more for each value it has.
    pub const KEEP: f64 = 25.0;
    /// The same for each value.
    pub const KEEP_EACH: f64 = 6.0;
    /// Residuals of one channel that follow each other are not as many as they are.
    pub const CORRELATED: f64 = 4.0;
    /// Hypotheses fitted in full, first alone and then beside the best.
    pub const FITTED: usize = 8;
    /// Of these, how many beside the best.
    pub const FITTED_BESIDE: usize = 5;
}

/// Held-out gain of one fit over another: sum over blocks, and its standard error.
fn gain(before: &[f64], after: &[f64]) -> (f64, f64) {
    let differences: Vec<f64> = before.iter().zip(after).map(|(b, a)| b - a).collect();
    let n = differences.len() as f64;
    let sum: f64 = differences.iter().sum();
    let variance = differences.iter().map(|d| (d - sum / n).powi(2)).sum::<f64>() / (n - 1.0);
    (sum, (n * variance).sqrt())
}

/// True where a fit explains more than chance does and than the noise is known to.
fn counts(bench: &Bench, before: &Fitted, after: &Fitted) -> bool {
    let (gain, error) = gain(&before.linear.held_out(None), &after.linear.held_out(None));
    if gain < rules::GAIN || gain < rules::ERRORS * error {
        return false;
    }
    let (b, a) = (parts(bench, &before.at), parts(bench, &after.at));
    b.iter().any(|(key, part)| {
        let fall = part.square - a.get(key).map_or(part.square, |p| p.square);
        fall > rules::VISIBLE * part.square && fall > 0.5 * rules::GAIN
    })
}

/// Sum of squares above the floor.
fn above(residuals: &Residuals) -> f64 {
    (fit::chi_square(residuals) - fit::count(residuals) as f64).max(0.0)
}

/// True where no channel of any log stands out of the floor.
fn at_floor(bench: &Bench, residuals: &Residuals) -> bool {
    parts(bench, residuals).values().all(|p| {
        let count = p.count as f64;
        p.square / count < rules::FLOOR.powi(2) + 6.0 * (2.0 / count).sqrt()
    })
}

/// What a diagnosis is at, for whoever waits.
pub type Progress<'a> = &'a (dyn Fn(&str, f64) + Sync);

/// Finds out which effect is missing.
///
/// # Errors
/// [`PredictError`] where the model as given cannot be driven through the logs.
pub fn diagnose(bench: &Bench, length: f64, progress: Progress<'_>) -> Result<Diagnosis, PredictError> {
    let blocks = fit::blocks_of(bench);
    progress("comparing", 0.0);
    let before = fit::residuals(bench, &Point::empty(bench.experiments.len()))?;
    progress("calibrating", 0.02);
    let null = calibrated(bench, &blocks)?;
    progress("screening every effect", 0.15);
    let ground = Ground { bench, blocks: &blocks, null: &null, length };
    let screened = screen(&ground);
    progress("fitting the likeliest", 0.45);
    let mut singles = fit_all(&ground, screened.iter().take(rules::FITTED));
    if let Some(best) = singles.first_mut() {
        polish(bench, &blocks, best);
    }
    singles.sort_by(|a, b| a.cost.total_cmp(&b.cost));

    let excess = above(&null.at).max(1.0);
    let mut chosen: Vec<Fitted> = Vec::new();
    if let Some(best) = singles.first().filter(|best| counts(bench, &null, best)) {
        chosen.push(best.clone());
        let left = above(&best.at) / excess;
        if left > rules::LEFT || !at_floor(bench, &best.at) {
            progress("looking for a second effect", 0.65);
            if let Some(pair) = second(&ground, best, &singles) {
                chosen.push(pair);
            }
        }
    }
    progress("weighing the evidence", 0.92);
    Ok(conclude(bench, &blocks, before, &null, singles, chosen))
}

/// Fits hypotheses in full, best first.
fn fit_all<'s>(ground: &Ground<'_>, screened: impl Iterator<Item = &'s Screened>) -> Vec<Fitted> {
    let screened: Vec<&Screened> = screened.filter(|s| s.gain > rules::GAIN * 0.5).collect();
    let mut fits: Vec<Fitted> = screened.par_iter().filter_map(|s| fit_hypothesis(ground, &s.effect, 5).ok()).collect();
    fits.sort_by(|a, b| a.cost.total_cmp(&b.cost));
    fits
}

/// Refits with fresh slopes of all that is not in proportion.
fn polish(bench: &Bench, blocks: &[Vec<u8>], fitted: &mut Fitted) {
    let stale = of_logs(&fitted.point);
    let known = fitted.slopes[..stale].to_vec();
    if let Ok(better) = fit::fit(bench, &fitted.point, blocks, &known, Effort { steps: 3, stale })
        && better.cost <= fitted.cost * (1.0 + 1e-9)
    {
        *fitted = better;
    }
}

/// The best pair that the best single effect is a member of, if it brings more than chance; singles are dropped again that
/// the other makes needless.
fn second(ground: &Ground<'_>, best: &Fitted, singles: &[Fitted]) -> Option<Fitted> {
    let beside = Ground { null: best, ..*ground };
    let own = best.point.all.last()?;
    let screened = screen(&beside);
    let others = screened.iter().filter(|s| (s.effect.kind.id, s.effect.at) != (own.kind.id, own.at));
    let mut pairs = fit_all(&beside, others.take(rules::FITTED_BESIDE));
    let first = pairs.first_mut()?;
    polish(ground.bench, ground.blocks, first);
    let pair = first.clone();
    // What is left must fall by half at least: a prediction that is not quite right leaves a little for any effect to mend.
    if !counts(ground.bench, best, &pair) || above(&pair.at) > rules::HALVED * above(&best.at) {
        return None;
    }
    // The second effect alone may do what both do together.
    let other = pair.point.all.last()?;
    let alone =
        singles.iter().find(|s| s.point.all.last().is_some_and(|e| (e.kind.id, e.at) == (other.kind.id, other.at)));
    if alone.is_some_and(|alone| !counts(ground.bench, alone, &pair)) {
        return None;
    }
    Some(pair)
}

/// The effects of a fit that are no calibrations.
fn effects_of(fitted: &Fitted) -> Vec<usize> {
    (0..fitted.point.all.len()).filter(|i| !is_calibration(fitted.point.all[*i].kind)).collect()
}

/// Fitted effects with their intervals.
fn found(fitted: &Fitted, wanted: impl Fn(Of) -> bool) -> Vec<Found> {
    let inflation = (fit::chi_square(&fitted.at) / fit::count(&fitted.at).max(1) as f64).max(1.0) * rules::CORRELATED;
    let deviations = fitted.linear.solve(None, 0.0, None).map(|s| s.deviations());
    let mut all: Vec<Found> = Vec::new();
    let mut seen: Vec<Of> = Vec::new();
    for (k, free) in fitted.point.free.iter().enumerate() {
        if !wanted(free.of) {
            continue;
        }
        let index = seen.iter().position(|of| *of == free.of).unwrap_or_else(|| {
            let effect = fitted.point.effect(free.of).clone();
            let interval = effect.values.iter().map(|v| [*v, *v]).collect();
            all.push(Found { effect, log: if let Of::Log(log, _) = free.of { Some(log) } else { None }, interval });
            seen.push(free.of);
            all.len() - 1
        });
        let parameter = fitted.point.parameter(free);
        let value = fitted.point.value(free);
        let deviation = deviations.as_ref().map_or(f64::INFINITY, |d| d[k]);
        let reach = 1.96 * deviation * fit::unit(parameter, value) * inflation.sqrt();
        all[index].interval[free.parameter] = [value - reach, value + reach];
    }
    all
}

fn conclude(
    bench: &Bench,
    blocks: &[Vec<u8>],
    before: Residuals,
    null: &Fitted,
    singles: Vec<Fitted>,
    chosen: Vec<Fitted>,
) -> Diagnosis {
    let n = fit::count(&before).max(1) as f64;
    let score_before = score(&before);
    let excess = above(&null.at).max(1.0);
    let best = chosen.last().unwrap_or(null);
    let left = above(&best.at) / excess;
    let explained =
        at_floor(bench, &best.at) || left < rules::LEFT || (score(&best.at) < rules::NEAR && left < rules::LEFT_NEAR);
    let verdict = if chosen.is_empty() {
        if at_floor(bench, &null.at) { Verdict::Adequate } else { Verdict::UnknownEffect }
    } else if explained {
        Verdict::EffectFound
    } else {
        Verdict::UnknownEffect
    };

    // Which calibrations count, beside the explanation.
    let (improved, kept) = sparse(bench, blocks, best);
    let calibration = found(&improved, |of| is_calibration(improved.point.effect(of).kind));

    let mut fits: Vec<Fitted> = singles;
    if chosen.len() > 1 {
        fits.insert(0, chosen[chosen.len() - 1].clone());
    }
    let mut candidates: Vec<Candidate> = fits
        .into_iter()
        .map(|fitted| {
            let own = effects_of(&fitted);
            Candidate {
                effects: found(&fitted, |of| matches!(of, Of::All(i) if own.contains(&i))),
                held_out_before: score_before,
                held_out_after: (fitted.linear.held_out(None).iter().sum::<f64>() / n).sqrt(),
                probability: 0.0,
                left: above(&fitted.at) / excess,
                indistinguishable: Vec::new(),
                fitted,
            }
        })
        .collect();
    // A single calibration that is all there is to say is the answer.
    let mut verdict = verdict;
    let stands_out = || {
        let (b, a) = (parts(bench, &before), parts(bench, &improved.at));
        b.iter().any(|(key, part)| {
            let fall = part.square - a.get(key).map_or(part.square, |p| p.square);
            fall > rules::VISIBLE * part.square && fall > 0.5 * rules::GAIN
        })
    };
    if verdict == Verdict::Adequate && kept.len() == 1 && stands_out() {
        let item = found(&improved, |_| true);
        verdict = Verdict::EffectFound;
        candidates.insert(
            0,
            Candidate {
                effects: item.into_iter().take(1).collect(),
                held_out_before: score_before,
                held_out_after: (improved.linear.held_out(None).iter().sum::<f64>() / n).sqrt(),
                probability: 0.0,
                left: above(&improved.at) / above(&before).max(1.0),
                indistinguishable: Vec::new(),
                fitted: improved.clone(),
            },
        );
    }
    weigh(&mut candidates, null, verdict);
    Diagnosis {
        verdict,
        score_before,
        before,
        calibrated: null.at.clone(),
        candidates,
        calibration,
        improved,
        limits: Vec::new(),
    }
}

/// Probabilities among the explanations, and which of them the data do not tell apart.
fn weigh(candidates: &mut [Candidate], null: &Fitted, verdict: Verdict) {
    let Some(first) = candidates.first() else { return };
    let (best, n) = (first.fitted.cost, fit::count(&first.fitted.at).max(1) as f64);
    // What is left above the floor says how far the sum of squares can be trusted.
    let trust = (fit::chi_square(&first.fitted.at) / n).max(1.0) * rules::CORRELATED;
    let weight = |cost: f64| (-0.5 * (cost - best).max(0.0) / trust).exp();
    // "None of these" stands beside them: with the calibrations alone, and with what the best leaves above the floor.
    let none = if verdict == Verdict::Adequate { 1.0 } else { weight(null.cost) };
    let sum: f64 = candidates.iter().map(|c| weight(c.fitted.cost)).sum::<f64>() + none;
    let ceiling = match verdict {
        Verdict::UnknownEffect => 0.5,
        _ => 1.0 - (fit::chi_square(&first.fitted.at) / n - 1.0).clamp(0.0, first.left.clamp(0.0, 1.0)),
    };
    let costs: Vec<f64> = candidates.iter().map(|c| c.fitted.cost).collect();
    for (k, c) in candidates.iter_mut().enumerate() {
        c.probability = weight(c.fitted.cost) / sum * ceiling;
        c.indistinguishable =
            (0..costs.len()).filter(|j| *j != k && (costs[*j] - costs[k]).abs() < 9.0 * trust).collect();
    }
}

/// Keeps of the calibrations those that count: by forward steps, each bringing the most, then a refit. Calibrations that are
/// the same in all logs become one for all. Gives the groups kept.
fn sparse(bench: &Bench, blocks: &[Vec<u8>], fitted: &Fitted) -> (Fitted, Vec<(&'static str, At)>) {
    let point = &fitted.point;
    let mut groups: Vec<((&'static str, At), Vec<usize>)> = Vec::new();
    let mut kept: Vec<usize> = Vec::new();
    for (k, free) in point.free.iter().enumerate() {
        let effect = point.effect(free.of);
        if !is_calibration(effect.kind) {
            kept.push(k);
            continue;
        }
        let key = (effect.kind.id, effect.at);
        match groups.iter_mut().find(|(g, _)| *g == key) {
            Some((_, values)) => values.push(k),
            None => groups.push((key, vec![k])),
        }
    }
    let mut names = Vec::new();
    let trust = (fit::chi_square(&fitted.at) / fit::count(&fitted.at).max(1) as f64).max(1.0) * rules::CORRELATED;
    let Some((mut cost, mut step)) = fitted.linear.with_only(&kept) else { return (fitted.clone(), names) };
    loop {
        let tried: Vec<(f64, DVector<f64>, usize)> = groups
            .par_iter()
            .enumerate()
            .filter_map(|(g, (_, values))| {
                let with: Vec<usize> = kept.iter().chain(values).copied().collect();
                let (cost, step) = fitted.linear.with_only(&with)?;
                Some((cost, step, g))
            })
            .collect();
        let gain = |t: &(f64, DVector<f64>, usize)| {
            cost - t.0 - trust * (rules::KEEP + rules::KEEP_EACH * groups[t.2].1.len() as f64)
        };
        let Some(best) = tried.into_iter().max_by(|a, b| gain(a).total_cmp(&gain(b))) else { break };
        if gain(&best) <= 0.0 {
            break;
        }
        (cost, step) = (best.0, best.1);
        let (name, values) = groups.swap_remove(best.2);
        kept.extend(values);
        names.push(name);
    }
    let all = point.moved(&step);
    let mut reduced = Point::empty(bench.experiments.len());
    // Effects first, then what is kept of the calibrations.
    for i in effects_of(fitted) {
        reduced.add(point.all[i].clone(), f64::INFINITY);
    }
    for (id, at) in &names {
        let own: Vec<&Effect> =
            all.all.iter().chain(all.each.iter().flatten()).filter(|e| e.kind.id == *id && e.at == *at).collect();
        let mean =
            (0..own[0].values.len()).map(|v| own.iter().map(|e| e.values[v]).sum::<f64>() / own.len() as f64).collect();
        reduced.add_expected(Effect { values: mean, ..own[0].clone() }, &expected(id));
    }
    let refit = |point: &Point| fit::fit(bench, point, blocks, &[], Effort { steps: 4, stale: 0 }).ok();
    let Some(common) = refit(&reduced) else { return (fitted.clone(), names) };
    // One for all, unless each log having its own brings what its values cost.
    let mut apart = common.point.clone();
    let mut split = false;
    for (id, at) in &names {
        let Some(i) = apart.all.iter().position(|e| e.kind.id == *id && e.at == *at) else { continue };
        let logs: Vec<usize> = (0..bench.experiments.len())
            .filter(|l| point.each[*l].iter().any(|e| e.kind.id == *id && e.at == *at))
            .collect();
        if logs.len() < 2 {
            continue;
        }
        let effect = apart.all[i].clone();
        apart.all[i] = Effect { values: nothing(effect.kind, effect.at).values, ..effect.clone() };
        apart.free.retain(|f| f.of != Of::All(i));
        for log in &logs {
            apart.add_to_log(*log, effect.clone(), &expected(id));
        }
        split = true;
    }
    if split && let Some(apart) = refit(&apart) {
        let more = apart.point.free.len().saturating_sub(common.point.free.len()) as f64;
        if common.cost - apart.cost > trust * (rules::KEEP + rules::KEEP_EACH * more) {
            return (apart, names);
        }
    }
    (common, names)
}
