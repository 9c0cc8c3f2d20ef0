//! What logs can show, whatever they say: the smallest size of each effect that they would show, the
//! log that shows it best, and the effects that they do not tell apart.
//!
//! Of logs that a cell as its model states it would give, this says what an experiment is worth
//! before it is made.

use crate::confuse::{Confusable, confusable};
use crate::diagnosis::longest_weld;
use crate::screen::{EffectLimit, ScreenedEffect, SearchContext, screen, screened_kinds};
use crate::search::{evaluate_uncalibrated, fit_calibrations};
use trueweld_estimate::fit::{self, FitProblem};
use trueweld_estimate::predict::PredictError;
use trueweld_logs::log::Log;
use trueweld_plant::effects::{EffectPlace, Role};

/// What logs can show.
#[derive(Debug, Clone)]
pub struct Detectability {
    /// Effects that they show, by the library's order.
    pub shown: Vec<ShownEffect>,
    /// Effects of which they show nothing, at any plausible size.
    pub not_shown: Vec<EffectPlace>,
    /// Pairs of effects that they hardly tell apart, most alike first.
    pub confusable: Vec<Confusable>,
}

/// An effect that logs show.
#[derive(Debug, Clone)]
pub struct ShownEffect {
    /// Its smallest size that all logs together would show, all calibrations free.
    pub limit: EffectLimit,
    /// The log that alone would show the smallest, by index; `None` where it takes several.
    pub best_log: Option<usize>,
}

/// What these logs can show. `logs`: those that the problem's logs were made of.
///
/// # Errors
/// [`PredictError`] where the model cannot be driven through them.
pub fn detectability(problem: &FitProblem, logs: &[Log]) -> Result<Detectability, PredictError> {
    let (all, confusable) = screened(problem, logs)?;
    let alone = (0..logs.len()).map(|log| {
        let one = problem.on(vec![problem.logs[log].clone()]);
        Ok(screened(&one, &logs[log..=log])?.0)
    });
    let alone = alone.collect::<Result<Vec<_>, PredictError>>()?;
    let mut found = Detectability { shown: Vec::new(), not_shown: Vec::new(), confusable };
    for effect in screened_kinds(problem) {
        let is_it = |s: &&ScreenedEffect| s.limit.effect == effect && is_plausible(&s.limit);
        let Some(limit) = all.iter().find(is_it).map(|s| s.limit.clone()) else {
            found.not_shown.push(effect);
            continue;
        };
        let by_log = alone.iter().enumerate();
        let by_log = by_log.filter_map(|(log, all)| Some((log, all.iter().find(is_it)?)));
        let best = by_log.min_by(|a, b| size(&a.1.limit).total_cmp(&size(&b.1.limit)));
        found.shown.push(ShownEffect { limit, best_log: best.map(|(log, _)| log) });
    }
    Ok(found)
}

fn screened(
    problem: &FitProblem,
    logs: &[Log],
) -> Result<(Vec<ScreenedEffect>, Vec<Confusable>), PredictError> {
    let blocks = fit::blocks_of(problem);
    let null = fit_calibrations(problem, &blocks)?;
    let given = evaluate_uncalibrated(problem, &blocks, &null)?;
    let length = longest_weld(logs);
    let (null, given, screened) = (&null, &given, &[]);
    let ctx = SearchContext { problem, blocks: &blocks, null, given, length, screened };
    let screened = screen(&ctx);
    let mut pairs = confusable(&ctx, &screened);
    // What is not shown at all is told apart from nothing.
    let shown = |effect: EffectPlace| {
        screened.iter().any(|s| s.limit.effect == effect && is_plausible(&s.limit))
    };
    pairs.retain(|pair| shown(pair.first) && shown(pair.second));
    Ok((screened, pairs))
}

/// How far a limit is from no effect, in the parameter's unit; of what is told by its reciprocal,
/// that.
fn size(limit: &EffectLimit) -> f64 {
    match limit.effect.kind.parameters[limit.parameter].role {
        Role::Reciprocal { .. } => 1.0 / limit.value,
        Role::Size { neutral, .. } => (limit.value - neutral).abs(),
        _ => limit.value.abs(),
    }
}

/// True for a limit that an effect of its kind may be as large as.
fn is_plausible(limit: &EffectLimit) -> bool {
    let of = &limit.effect.kind.parameters[limit.parameter];
    limit.value.is_finite() && (of.low..=of.high).contains(&limit.value)
}
