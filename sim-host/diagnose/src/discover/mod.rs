//! What the library does not hold is found too: a law at a port of the plant, over variables that
//! the logs carry.
//!
//! Where a diagnosis ends without an effect that explains the logs, every port at every place is
//! asked whether a free curve over one of its variables would, and where it ends with one, whether
//! such a curve does better:
//!
//! 1. screened, with the slopes of a constant at the port, as if every row stood still;
//! 2. the best are fitted through the plant, calibrations with them, and judged by blocks in time
//!    that were left out, as the library's effects are;
//! 3. formulas are fitted in the curve's place, and the shortest description is kept.
//!
//! Where no curve is enough, surfaces over two variables are looked at in the same way. Nothing is found
//! that does not predict blocks better that were left out of its fit.

mod context;
mod curve;
mod grammar;
mod hypotheses;
mod laws;
mod screen;
mod variables;

pub use hypotheses::Hypothesis;

use crate::calibration_selection::select_calibrations;
use crate::diagnosis::{
    Candidate, Diagnosed, Diagnosis, DiagnosisFits, DiagnosisVerdict, Incomplete, ProgressCallback,
};
use crate::errors::{DiagnosisErrors, errors_from_others};
use crate::experiment::RIVALS_MAX;
use crate::experiment::{Plan, next_experiment};
use crate::found::{FittedEffect, found, found_beside};
use crate::log_evidence::is_significant;
use crate::rules::{self, score};
use context::DiscoveryContext;
use curve::FittedCurve;
use grammar::FittedFormula;
use laws::{FreeFormLaw, Library, LibraryShare, Outside, curves_that_lower_cost, free_form_laws};
use rayon::prelude::*;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::fit::{self, EffectScope, FitProblem, Fitted, SchurComplement};
use trueweld_estimate::residuals::localize::{ConditionBin, localize};
use trueweld_logs::log::Log;
use trueweld_plant::effects::Effect;
use trueweld_plant::effects::table::Places;

/// A law at a port that the logs ask for.
#[derive(Debug, Clone)]
pub struct Discovery {
    /// Port, place and variables.
    pub hypothesis: Hypothesis,
    /// The free curve.
    pub curve: FreeCurve,
    /// What is added to the model: a formula, or the curve.
    pub effect: FittedEffect,
    /// Its expression, where a formula describes it better than the curve does.
    pub expression: Option<String>,
    /// Score on held-out blocks of the model as it was given.
    pub held_out_before: f64,
    /// Score on held-out blocks with it, calibrations refitted.
    pub held_out_after: f64,
    /// Share of what was above the floor that is still there; of a law found beside other effects
    /// share of all that these left, every channel weighed alike.
    pub left: f64,
    /// True for a law found beside other effects.
    pub beside: bool,
    /// Laws elsewhere, or over other variables, that these logs do not tell from it.
    pub tied: Vec<TiedLaw>,
    /// What the library has that is like it, and whose form does not hold; `None` where it has
    /// nothing.
    pub like: Option<LikeEffect>,
}

/// An explanation within the library that is like a law, but is not it.
#[derive(Debug, Clone)]
pub struct LikeEffect {
    /// Its effects.
    pub effects: Vec<FittedEffect>,
    /// Score on held-out blocks with them.
    pub held_out: f64,
    /// What they make of the law's curve, over the same variable.
    pub curve: Vec<ConditionBin>,
}

/// A law that the logs do not tell from the one that was found.
#[derive(Debug, Clone)]
pub struct TiedLaw {
    /// Port, place and variables.
    pub hypothesis: Hypothesis,
    /// The law, of the same form; `None` where that was not fitted.
    pub effect: Option<Effect>,
}

/// A curve with its 95 % band.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeCurve {
    /// Values of the variable.
    pub x: Vec<f64>,
    /// Values of the curve.
    pub y: Vec<f64>,
    /// Band, low and high.
    pub band: Vec<[f64; 2]>,
    /// Half the 95 % interval of what all values have in common, where that is most of the band's
    /// width: a constant that calibrations make as well.
    pub level: Option<f64>,
    /// The band but for that level; the band itself where there is none.
    pub shape: Vec<[f64; 2]>,
    /// What the measurements ask for, whatever the form.
    pub points: Vec<ConditionBin>,
    /// The formula in its place, over the same range; none where the curve itself is the law.
    pub formula: Vec<[f64; 2]>,
    /// The surface, whose curve in the middle of the second variable all of this is; `None` of a curve.
    pub surface: Option<FreeSurface>,
}

/// A free surface with its 95 % band: values over the first variable's places, for each of the second's.
#[derive(Debug, Clone, PartialEq)]
pub struct FreeSurface {
    /// Values of the second variable.
    pub across: Vec<f64>,
    /// Which of them is in the middle.
    pub middle: usize,
    /// Values of the surface.
    pub y: Vec<Vec<f64>>,
    /// Band, low and high.
    pub band: Vec<Vec<[f64; 2]>>,
}

impl FreeSurface {
    /// What was fitted as a surface, by its values' band; `None` of a curve.
    fn of(fitted: &FittedCurve, band: &[[f64; 2]]) -> Option<Self> {
        let Places { x, across } = &fitted.places;
        let rows = fitted.values().chunks(x.len()).map(<[f64]>::to_vec);
        (!across.is_empty()).then(|| Self {
            across: across.clone(),
            middle: fitted.places.middle(),
            y: rows.collect(),
            band: band.chunks(x.len()).map(<[[f64; 2]]>::to_vec).collect(),
        })
    }
}

/// Share of what is above the floor that an effect of the library may leave to be like a law.
const LIKE: f64 = 0.1;

/// Looks for a law outside the library where a diagnosis finds that something is missing; gives the
/// diagnosis as it is then. Where there is a law that does better than all within the library, the
/// verdict is that the effect is unknown, the improved model has the law, and its calibrations and
/// what it leaves are those of that model. `logs`: those that the diagnosis was made from.
pub fn discover(
    problem: &FitProblem,
    logs: &[Log],
    mut diagnosed: Diagnosed,
    progress: ProgressCallback<'_>,
) -> (Diagnosed, Vec<Discovery>) {
    // A calibration that is all there is to say leaves nothing to find.
    let Diagnosis { verdict, chosen, .. } = diagnosed.diagnosis;
    if verdict == DiagnosisVerdict::EffectFound && chosen == 0 {
        return (diagnosed, Vec::new());
    }
    if problem.is_late() {
        diagnosed.diagnosis.incomplete.push(Incomplete::Outside);
        return (diagnosed, Vec::new());
    }
    let blocks = fit::blocks_of(problem);
    let null = &diagnosed.fits.null;
    let Some(eliminated) = SchurComplement::of(&null.linear) else {
        return (diagnosed, Vec::new());
    };
    let (eliminated, id) = (&eliminated, free_name(&problem.known, &[]));
    let context = DiscoveryContext { problem, logs, blocks: &blocks, null, eliminated, id: &id };
    let library = Library::of(problem, &diagnosed);
    let Outside { better, beside } = free_form_laws(&context, &library, progress);
    match with_law(&context, (&library, &diagnosed), &better, progress) {
        Some((with_law, discovery)) => (with_law, vec![discovery]),
        None => {
            let Diagnosed { diagnosis, fits } = diagnosed;
            let diagnosis = match beside {
                Some(LibraryShare { share, ports }) => diagnosis.beside_outside(share, ports),
                None => diagnosis,
            };
            (Diagnosed { diagnosis, fits }, Vec::new())
        }
    }
}

/// The first of the laws that do better than all within the library, and the diagnosis with it; `None`
/// where there is none, or it may not be named.
fn with_law(
    context: &DiscoveryContext<'_>,
    (library, diagnosed): (&Library<'_>, &Diagnosed),
    laws: &[FreeFormLaw],
    progress: ProgressCallback<'_>,
) -> Option<(Diagnosed, Discovery)> {
    let DiscoveryContext { problem, logs, blocks, null, .. } = *context;
    let Diagnosed { diagnosis, fits } = diagnosed;
    let best = laws.first()?;
    let inflation = rules::variance_inflation(best.fitted());
    progress("looking for its formula", 0.8);
    // What the library says as well is not said by a formula in its place.
    let betters = |formula: &FittedFormula| library.is_bettered_by_formula(best, formula);
    let (mut discovery, fitted) = described(context, laws, betters)?;
    // Sizes of one formula may go together, as a sine and a cosine do whose order moves: they are told
    // from nothing together.
    if !is_significant(problem, null, &fitted) {
        return None;
    }
    discovery.held_out_before = diagnosis.score_before;
    let (improved, _) = select_calibrations(problem, blocks, &fitted);
    let is_of_calibration = |of| is_calibration(improved.point.effect(of).kind);
    let calibration = found_beside(problem, &improved, &fitted, is_of_calibration);
    let unexplained = match rules::within_noise(problem, &improved.residuals) {
        true => Vec::new(),
        false => localize(&problem.logs, &improved.residuals, logs),
    };
    let near = |(like, _): &(&Candidate, &Fitted)| match diagnosis.verdict {
        DiagnosisVerdict::EffectFound => true,
        DiagnosisVerdict::Adequate => false,
        _ => like.left < LIKE,
    };
    let nearest = diagnosis.candidates.first().zip(fits.candidates.first()).filter(near);
    discovery.like = nearest.and_then(|like| nearest_effect(context, &best.curve, like));
    // What is found outside the library stands beside what was tried within.
    let beside = diagnosis.candidates.iter().zip(&fits.candidates).map(|(candidate, within)| {
        let worse = (within.cost - fitted.cost).max(0.0) / inflation;
        let probability = candidate.probability * (-0.5 * worse).exp();
        Candidate { probability, ..candidate.clone() }
    });
    let diagnosis = Diagnosis {
        verdict: DiagnosisVerdict::UnknownEffect,
        score_after: score(&improved.residuals),
        errors: DiagnosisErrors {
            after: errors_from_others(problem, blocks, &improved),
            ..diagnosis.errors.clone()
        },
        candidates: beside.collect(),
        calibration,
        unexplained,
        ..diagnosis.clone()
    };
    let fits = DiagnosisFits { full: fitted, improved, ..fits.clone() };
    Some((Diagnosed { diagnosis, fits }, discovery))
}

/// The law outside the library that lowers blocks left out the most beside all that a fit has,
/// which keeps its values; of those that the blocks do not tell from it the first with which `takes` takes
/// the fit. `None` where none lowers them by more than chance.
pub(crate) fn beside(
    problem: &FitProblem,
    blocks: &[Vec<u8>],
    logs: &[Log],
    base: &Fitted,
    mut takes: impl FnMut(&Fitted) -> bool,
) -> Option<Discovery> {
    let id = free_name(&problem.known, &base.point.shared);
    let eliminated = &SchurComplement::of(&base.linear)?;
    let context = DiscoveryContext { problem, logs, blocks, null: base, eliminated, id: &id };
    let mut laws = curves_that_lower_cost(&context);
    for k in 0..laws.len() {
        laws[..=k].rotate_right(1);
        let Some((law, fitted)) = described(&context, &laws, |_| true) else { continue };
        if takes(&fitted) {
            let left = (law.held_out_after / law.held_out_before).powi(2);
            return Some(Discovery { left, beside: true, ..law });
        }
    }
    None
}

/// The first of some laws, with its formula where one describes its curve that `counts`, tied with the
/// others; and the fit with it.
fn described(
    context: &DiscoveryContext<'_>,
    laws: &[FreeFormLaw],
    counts: impl Fn(&FittedFormula) -> bool,
) -> Option<(Discovery, Fitted)> {
    let DiscoveryContext { problem, null, .. } = *context;
    let (FreeFormLaw { curve: best, formula, .. }, others) = laws.split_first()?;
    let law = grammar::law(context, best, formula.as_ref()).filter(counts);
    let of_width = law.as_ref().and_then(|law| best.turning_over(context, law.turns_over()?));
    let best = of_width.as_ref().unwrap_or(best);
    let elsewhere = |FreeFormLaw { curve, .. }: &FreeFormLaw| TiedLaw {
        hypothesis: curve.candidate.hypothesis,
        effect: law.as_ref().and_then(|law| law.elsewhere(context, curve)?.effect().cloned()),
    };
    let tied: Vec<TiedLaw> = others.par_iter().map(elsewhere).collect();
    let (fitted, expression) = match law {
        Some(law) => (law.fitted, Some(law.expression)),
        None => (best.fitted.clone(), None),
    };
    let of_last = |fitted: &Fitted| {
        let own = EffectScope::Shared(fitted.point.shared.len() - 1);
        found(problem, fitted, |of| of == own).into_iter().next()
    };
    let (band, effect) = (of_last(&best.fitted)?, of_last(&fitted)?);
    let formula = expression.as_ref().map_or(Vec::new(), |_| best.drawn(&effect.effect));
    let band = best.of_places(&band.interval);
    let (level, shape) = best.shape(band);
    let (middle, _) = best.middle();
    let drawn: Vec<f64> = best.places.x.iter().map(|x| best.drawn_at(*x)).collect();
    let shown: Vec<usize> = (0..drawn.len())
        .filter(|k| k.checked_sub(1).is_none_or(|b| drawn[*k] > drawn[b]))
        .collect();
    let shown_of =
        |band: &[[f64; 2]]| shown.iter().map(|k| band[middle.start + k]).collect::<Vec<_>>();
    let discovery = Discovery {
        hypothesis: best.candidate.hypothesis,
        curve: FreeCurve {
            x: shown.iter().map(|k| drawn[*k]).collect(),
            y: shown.iter().map(|k| best.values()[middle.start + k]).collect(),
            band: shown_of(band),
            level,
            shape: shown_of(&shape),
            points: best.points(context),
            formula,
            surface: FreeSurface::of(best, band),
        },
        effect,
        expression,
        held_out_before: rules::held_out_score(null),
        held_out_after: rules::held_out_score(&fitted),
        left: rules::excess_chi_square(problem, &fitted.residuals)
            / rules::excess_chi_square(problem, &null.residuals).max(1.0),
        beside: false,
        tied,
        like: None,
    };
    Some((discovery, fitted))
}

/// An explanation within the library, and what it makes of the curve: by how much it changes the
/// residuals at the port. `None` where the model without it cannot be driven through the logs.
fn nearest_effect(
    context: &DiscoveryContext<'_>,
    curve: &FittedCurve,
    (like, fitted): (&Candidate, &Fitted),
) -> Option<LikeEffect> {
    let problem = context.problem;
    let mut without = fitted.point.clone();
    without.reset(|effect| !is_calibration(effect.kind));
    let without = fit::residuals(problem, &without).ok()?;
    let changes: Vec<Vec<f64>> = without
        .iter()
        .zip(&fitted.residuals)
        .map(|(without, with)| {
            without.residual.iter().zip(&with.residual).map(|(a, b)| a - b).collect()
        })
        .collect();
    Some(LikeEffect {
        effects: like.effects.clone(),
        held_out: like.held_out_after,
        curve: curve.drawn_points(curve.asked(context, &changes)),
    })
}

/// What to record to tell a law from those that the logs do not tell from it, or, where there are
/// none, to see it best. `None` where no experiment shows it.
pub fn settling_experiment(
    problem: &FitProblem,
    logs: &[Log],
    discovery: &Discovery,
) -> Option<Plan> {
    if problem.is_late() {
        return None;
    }
    let robot = &logs.first()?.robot;
    let name = |hypothesis: &Hypothesis, effect: &Effect| {
        let at = effect.at.name(robot);
        let parts = [hypothesis.port.name, at];
        let place = parts[..if at.is_empty() { 1 } else { 2 }].join(" at ");
        [place, hypothesis.variables().join(" and ")].join(" over ")
    };
    let own = &discovery.effect.effect;
    let tied = discovery.tied.iter().filter_map(|t| Some((&t.hypothesis, t.effect.as_ref()?)));
    let rivals: Vec<(String, Vec<Effect>)> = std::iter::once((&discovery.hypothesis, own))
        .chain(tied)
        .take(RIVALS_MAX)
        .map(|(hypothesis, effect)| (name(hypothesis, effect), vec![effect.clone()]))
        .collect();
    next_experiment(problem, logs, &rivals)
}

/// A name that no effect of the model has, nor any that was found.
fn free_name(known: &[Effect], found: &[Effect]) -> String {
    let taken = |name: &str| known.iter().chain(found).any(|effect| effect.kind.id == name);
    let more = (2..).map(|k| format!("{DISCOVERED}-{k}"));
    let mut names = std::iter::once(DISCOVERED.to_owned()).chain(more);
    names.find(|name| !taken(name)).unwrap_or_default()
}

/// Name of an effect that was discovered; a number behind it where a model has several.
pub const DISCOVERED: &str = "discovered";
