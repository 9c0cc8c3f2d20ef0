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
mod variables;

pub use hypotheses::Hypothesis;

use crate::data::log::{Log, LogKind};
use crate::diagnose::{self, Diagnosis, FittedEffect, Progress, Undone, Verdict, rules};
use crate::experiment::{Plan, next_experiment};
use crate::fit::calibration::is_calibration;
use crate::fit::{
    self, Condensed, EffectScope, Eliminated, FitProblem, Fitted, FreeParameter, Slopes,
};
use crate::residuals::localize::{CurvePoint, localize};
use context::Context;
use curve::{Candidate, FittedCurve, Layout, SCREENED, Smooth, fit_curve, smooth};
use grammar::{Found, Law};
use rayon::prelude::*;
use trueweld_plant::effects::formula::NamedPort;
use trueweld_plant::effects::table::Places;
use trueweld_plant::effects::{Effect, Location};

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
    pub curve: Vec<CurvePoint>,
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
    pub points: Vec<CurvePoint>,
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

/// Candidates that are screened with a formula too.
const FORMULAS: usize = 24;
/// Curves that are fitted through the plant, and surfaces, which have more values.
const FITTED: usize = 8;
const FITTED_SURFACES: usize = 3;
/// Of these, at one port and place.
const AT_ONE_PORT: usize = 2;
/// Share of what the best curve promises from which on another one is fitted.
const PROMISED: f64 = 0.7;
/// Share of what is above the floor that a discovery may leave.
const LEFT: f64 = 0.25;
/// Share of what is above the floor that an effect of the library may leave to be like a law.
const LIKE: f64 = 0.1;
/// Share of what the library explains that a curve must explain more where nothing stands out,
/// beside what chance makes: no prediction is exact, and an effect whose form holds to this holds.
const HOLDS: f64 = 0.01;

/// Looks for a law outside the library where a diagnosis finds that something is missing. Where
/// there is one that does better than all within the library, the verdict is that the effect is
/// unknown, the improved model of the diagnosis has the law, and its calibrations and what it leaves
/// are those of that model. `logs`: those that the diagnosis was made from.
pub fn discover(
    bench: &FitProblem,
    logs: &[Log],
    diagnosis: &mut Diagnosis,
    progress: Progress<'_>,
) -> Vec<Discovery> {
    let named = diagnosis.chosen.last().filter(|_| diagnosis.verdict == Verdict::EffectFound);
    // A calibration that is all there is to say leaves nothing to find.
    if diagnosis.verdict == Verdict::EffectFound && named.is_none() {
        return Vec::new();
    }
    if bench.is_late() {
        diagnosis.undone.push(Undone::Outside);
        return Vec::new();
    }
    // A partial explanation within the library may do as well; one that fits anything is none.
    let within = diagnosis.chosen.iter().chain(diagnosis.candidates.iter().map(|c| &c.fitted));
    let within = within.filter(|fitted| !diagnose::fits_anything(bench, fitted));
    let within: Vec<&Fitted> = within.chain([&diagnosis.null]).collect();
    let least = |of: &dyn Fn(&Fitted) -> f64| {
        within.iter().map(|fitted| of(fitted)).fold(f64::INFINITY, f64::min)
    };
    let library = least(&|fitted| fitted.linear.held_out(None).iter().sum());
    let library_cost = least(&|fitted| fitted.cost);
    let blocks = fit::blocks_of(bench);
    let null = diagnosis.null.clone();
    let explained = null.linear.held_out(None).iter().sum::<f64>() - library;
    let adequate = diagnosis.verdict == Verdict::Adequate;
    let at_floor = adequate || named.is_some_and(|fitted| rules::at_floor(bench, &fitted.at));
    // What an effect leaves that stands out is more than what no prediction is exact to.
    let holds = if at_floor { HOLDS } else { 0.0 };
    // Where nothing is missing as far as the library goes, one of so many may promise much by chance.
    let gain = if adequate { rules::AMPLE } else { rules::GAIN };
    let better = |noise: f64| library - (gain * noise).max(holds * explained);
    // Where nothing stands out, a curve must promise more.
    let goal = if at_floor { better(1.0) } else { f64::INFINITY };
    let id = free_name(&bench.known, &[]);
    let Some(eliminated) = Eliminated::of(&null.linear) else { return Vec::new() };
    let eliminated = &eliminated;
    let context = Context { bench, logs, blocks: &blocks, null: &null, eliminated, id: &id };
    let ports = ports(&context);
    let mut laws = laws(&context, &curves(&context, &ports), goal, progress);
    let is_one = |law: &Tried| {
        let fitted = law.fitted();
        let trust = rules::trust(fitted);
        let left = rules::above(bench, &fitted.at) / rules::above(bench, &null.at).max(1.0);
        // Of what shows little, noise alone leaves a large share.
        let partial = left > LEFT && !rules::at_floor(bench, &fitted.at);
        // What is freer than an effect and fits no better is no law: what it predicts better of blocks
        // left out it owes to calibrations that are farther off than expected.
        let fits_better = fitted.cost < library_cost - rules::GAIN;
        !partial && fits_better && law.held_out() <= better(trust / rules::CORRELATED)
    };
    let mut first = laws.iter().position(is_one);
    // One variable is enough where a second one brings no more than chance, or, where nothing stands
    // out, than what no prediction is exact to.
    if first.is_some() || !at_floor {
        let beyond = first.map_or(goal, |k| {
            let (law, noise) = (&laws[k], rules::trust(laws[k].fitted()) / rules::CORRELATED);
            let explained = null.linear.held_out(None).iter().sum::<f64>() - law.held_out();
            let holds = if rules::at_floor(bench, &law.fitted().at) { HOLDS } else { 0.0 };
            law.held_out() - (gain * noise).max(holds * explained)
        });
        let surfaces = of_logs(&context, &ports, &hypotheses::surfaces());
        // What few places promise says little of what more of them bring.
        let found = self::laws(&context, &surfaces, goal, progress);
        let one = found.iter().position(|law| is_one(law) && law.held_out() < beyond);
        if one.is_some() {
            (laws, first) = (found, one);
        }
    }
    let Some(first) = first else {
        return Vec::new();
    };
    laws[..=first].rotate_right(1);
    let best = &laws[0];
    let trust = rules::trust(best.fitted());
    progress("looking for its formula", 0.8);
    let Some((mut discovery, fitted)) = described(&context, &laws) else {
        return Vec::new();
    };
    discovery.held_out_before = diagnosis.score_before;
    let (improved, _) = diagnose::sparse(bench, &blocks, &fitted);
    let is_of_calibration = |of| is_calibration(improved.point.effect(of).kind);
    diagnosis.calibration = diagnose::found_beside(bench, &improved, &fitted, is_of_calibration);
    diagnosis.unexplained = match rules::at_floor(bench, &improved.at) {
        true => Vec::new(),
        false => localize(&bench.experiments, &improved.at, logs),
    };
    diagnosis.improved = improved;
    diagnosis.full = fitted.clone();
    let near = |like: &&diagnose::Candidate| named.is_some() || (!adequate && like.left < LIKE);
    let nearest = diagnosis.candidates.first().filter(near);
    discovery.like = nearest.and_then(|like| nearest_effect(&context, &best.curve, like));
    diagnosis.verdict = Verdict::UnknownEffect;
    // What is found outside the library stands beside what was tried within.
    for candidate in &mut diagnosis.candidates {
        let worse = (candidate.fitted.cost - fitted.cost).max(0.0) / trust;
        candidate.probability *= (-0.5 * worse).exp();
    }
    vec![discovery]
}

/// The law outside the library that lowers blocks left out the most beside all that a fit has,
/// which keeps its values; of those that the blocks do not tell from it the first with which `takes` takes
/// the fit. `None` where none lowers them by more than chance.
pub(crate) fn beside(
    bench: &FitProblem,
    blocks: &[Vec<u8>],
    logs: &[Log],
    base: &Fitted,
    mut takes: impl FnMut(&Fitted) -> bool,
) -> Option<Discovery> {
    let id = free_name(&bench.known, &base.point.all);
    let eliminated = &Eliminated::of(&base.linear)?;
    let context = Context { bench, logs, blocks, null: base, eliminated, id: &id };
    let curves = curves(&context, &ports(&context));
    let mut laws = laws(&context, &curves, f64::INFINITY, &|_, _| ());
    for k in 0..laws.len() {
        laws[..=k].rotate_right(1);
        let Some((law, fitted)) = described(&context, &laws) else { continue };
        if takes(&fitted) {
            let left = (law.held_out_after / law.held_out_before).powi(2);
            return Some(Discovery { left, beside: true, ..law });
        }
    }
    None
}

/// A free curve that was fitted through the plant, and the formula that screening found in its place.
#[derive(Debug)]
struct Tried {
    curve: FittedCurve,
    formula: Option<Law>,
}

impl Tried {
    fn new(context: &Context<'_>, screened: &Screened<'_>) -> Option<Self> {
        let curve = fit_curve(context, screened.candidate, screened.layout)?;
        let formula = screened.formula.as_ref();
        let formula = formula.and_then(|found| grammar::fitted(context, &curve, found));
        Some(Self { curve, formula })
    }

    /// The one of the two that predicts blocks better that were left out.
    fn fitted(&self) -> &Fitted {
        let formula = self.formula.as_ref().filter(|law| law.held_out() < self.curve.held_out());
        formula.map_or(&self.curve.fitted, |law| &law.fitted)
    }

    /// Sum of squares of blocks that were left out.
    fn held_out(&self) -> f64 {
        self.fitted().linear.held_out(None).iter().sum()
    }
}

/// Laws that lower blocks left out by more than chance, as far as the logs do not tell them from the
/// best: the one first that is named of these. `goal`: what such a law must promise to lower them to.
fn laws(
    context: &Context<'_>,
    candidates: &[Candidate],
    goal: f64,
    progress: Progress<'_>,
) -> Vec<Tried> {
    let Context { bench, null, .. } = *context;
    progress("looking outside the library", 0.0);
    let wanted = likeliest(context, candidates, goal);
    progress("fitting curves", 0.5);
    let mut laws: Vec<Tried> = wanted
        .par_iter()
        .filter(|_| !bench.is_late())
        .filter_map(|screened| Tried::new(context, screened))
        .filter(|law| rules::counts(bench, null, law.fitted()))
        .collect();
    laws.sort_by(|a, b| a.held_out().total_cmp(&b.held_out()));
    let Some(least) = laws.first() else {
        return Vec::new();
    };
    let reach = least.held_out() + rules::TIED * rules::trust(least.fitted());
    laws.retain(|law| law.held_out() <= reach);
    let order = hypotheses::all();
    let place = |h: &Hypothesis| order.iter().position(|one| one == h).unwrap_or(order.len());
    laws.sort_by_key(|law| place(&law.curve.candidate.hypothesis));
    laws
}

/// The first of some laws, with its formula where one describes its curve, tied with the others; and
/// the fit with it.
fn described(context: &Context<'_>, laws: &[Tried]) -> Option<(Discovery, Fitted)> {
    let Context { bench, null, .. } = *context;
    let (Tried { curve: best, formula }, others) = laws.split_first()?;
    let law = grammar::law(context, best, formula.as_ref());
    let of_width = law.as_ref().and_then(|law| best.turning_over(context, law.turns_over()?));
    let best = of_width.as_ref().unwrap_or(best);
    let elsewhere = |Tried { curve, .. }: &Tried| TiedLaw {
        hypothesis: curve.candidate.hypothesis,
        effect: law.as_ref().and_then(|law| law.elsewhere(context, curve)?.effect().cloned()),
    };
    let tied: Vec<TiedLaw> = others.par_iter().map(elsewhere).collect();
    let (fitted, expression) = match law {
        Some(law) => (law.fitted, Some(law.expression)),
        None => (best.fitted.clone(), None),
    };
    let of_last = |fitted: &Fitted| {
        let own = EffectScope::All(fitted.point.all.len() - 1);
        diagnose::found(bench, fitted, |of| of == own).into_iter().next()
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
        left: rules::above(bench, &fitted.at) / rules::above(bench, &null.at).max(1.0),
        beside: false,
        tied,
        like: None,
    };
    Some((discovery, fitted))
}

/// An explanation within the library, and what it makes of the curve: by how much it changes the
/// residuals at the port. `None` where the model without it cannot be driven through the logs.
fn nearest_effect(
    context: &Context<'_>,
    curve: &FittedCurve,
    like: &diagnose::Candidate,
) -> Option<LikeEffect> {
    let bench = context.bench;
    let mut without = like.fitted.point.clone();
    without.reset(|effect| !is_calibration(effect.kind));
    let without = fit::residuals(bench, &without).ok()?;
    let changes: Vec<Vec<f64>> = without
        .iter()
        .zip(&like.fitted.at)
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
    bench: &FitProblem,
    logs: &[Log],
    discovery: &Discovery,
) -> Option<Plan> {
    if bench.is_late() {
        return None;
    }
    let robot = &logs.first()?.robot;
    let name = |hypothesis: &Hypothesis, effect: &Effect| {
        let at = effect.at_name(robot);
        let parts = [hypothesis.port.name, at];
        let place = parts[..if at.is_empty() { 1 } else { 2 }].join(" at ");
        [place, hypothesis.variables().join(" and ")].join(" over ")
    };
    let own = &discovery.effect.effect;
    let tied = discovery.tied.iter().filter_map(|t| Some((&t.hypothesis, t.effect.as_ref()?)));
    let rivals: Vec<(String, Vec<Effect>)> = std::iter::once((&discovery.hypothesis, own))
        .chain(tied)
        .take(RIVALS)
        .map(|(hypothesis, effect)| (name(hypothesis, effect), vec![effect.clone()]))
        .collect();
    next_experiment(bench, logs, &rivals)
}

/// Laws that an experiment is to tell apart, at most.
const RIVALS: usize = 3;

/// A name that no effect of the model has, nor any that was found.
fn free_name(known: &[Effect], found: &[Effect]) -> String {
    let taken = |name: &str| known.iter().chain(found).any(|effect| effect.kind.id == name);
    let more = (2..).map(|k| format!("{DISCOVERED}-{k}"));
    let mut names = std::iter::once(DISCOVERED.to_owned()).chain(more);
    names.find(|name| !taken(name)).unwrap_or_default()
}

/// Name of an effect that was discovered; a number behind it where a model has several.
pub const DISCOVERED: &str = "discovered";

/// A candidate with what screening says of it.
struct Screened<'c> {
    candidate: &'c Candidate,
    layout: Layout,
    places: Places,
    /// The linear model of the curve's values at these places.
    linear: Condensed,
    /// Fall of the sum of squares of a curve that bends at will.
    most: f64,
    /// Sum of squares of blocks left out, with the curve or with the formula.
    held_out: f64,
    /// The best formula in the curve's place.
    formula: Option<Found>,
}

/// The candidates that promise most, screened.
fn likeliest<'c>(
    context: &Context<'_>,
    candidates: &'c [Candidate],
    goal: f64,
) -> Vec<Screened<'c>> {
    let bench = context.bench;
    let mut screened: Vec<Screened<'_>> = candidates
        .par_iter()
        .filter(|_| !bench.is_late())
        .filter_map(|candidate| screen(context, candidate))
        .collect();
    // Of loops the one whose width promises most.
    screened.sort_by(|a, b| a.held_out.total_cmp(&b.held_out));
    let mut kept: Vec<Screened<'_>> = Vec::new();
    for one in screened {
        let same = |k: &Screened<'_>| k.candidate.hypothesis.is_like(&one.candidate.hypothesis);
        if !kept.iter().any(same) {
            kept.push(one);
        }
    }
    let mut screened = kept;
    // A formula is tried where it may bring enough.
    screened.sort_by(|a, b| b.most.total_cmp(&a.most));
    let others = screened.split_off(screened.len().min(FORMULAS));
    let tried = screened.into_par_iter().map(|screened| match bench.is_late() {
        true => screened,
        false => screened.with_formula(context),
    });
    let mut screened: Vec<Screened<'_>> = tried.chain(others).collect();
    screened.sort_by(|a, b| a.held_out.total_cmp(&b.held_out));
    screened.retain(|screened| screened.held_out < goal);
    let before: f64 = context.null.linear.held_out(None).iter().sum();
    let promised = screened.first().map_or(0.0, |best| PROMISED * (before - best.held_out));
    let mut wanted: Vec<Screened<'_>> = Vec::new();
    for one in screened {
        let place = |c: &Candidate| (c.hypothesis.port.name, c.hypothesis.at);
        let same = wanted.iter().filter(|w| place(w.candidate) == place(one.candidate)).count();
        let gain = before - one.held_out;
        let most = if one.candidate.across.is_some() { FITTED_SURFACES } else { FITTED };
        if wanted.len() < most && same < AT_ONE_PORT && gain > promised.max(rules::GAIN) {
            wanted.push(one);
        }
    }
    wanted
}

/// A port at a place, with the slopes of all residuals by a constant there.
type PortAt = (&'static NamedPort, Location, Slopes);

/// Every port at every place where the logs show it.
fn ports(context: &Context<'_>) -> Vec<PortAt> {
    let mut ports: Vec<(&'static NamedPort, Location)> = Vec::new();
    for hypothesis in hypotheses::all() {
        let place = (hypothesis.port, hypothesis.at);
        if !ports.iter().any(|p| (p.0.name, p.1) == (place.0.name, place.1)) {
            ports.push(place);
        }
    }
    let on_time = ports.par_iter().filter(|_| !context.bench.is_late());
    on_time.filter_map(|(port, at)| Some((*port, *at, constant(context, port, *at)?))).collect()
}

/// Every hypothesis that the logs carry the variables of and show the port of.
fn of_logs(context: &Context<'_>, ports: &[PortAt], all: &[Hypothesis]) -> Vec<Candidate> {
    let rows = context.rows();
    let of = |hypothesis: &Hypothesis| {
        let here = |p: &&PortAt| (p.0.name, p.1) == (hypothesis.port.name, hypothesis.at);
        let constant = ports.iter().find(here)?.2.clone();
        let of_rows = |text| rows.of(hypothesis.port, hypothesis.at, text);
        let over = of_rows(hypothesis.over)?;
        let across = match hypothesis.across {
            Some(across) => Some(of_rows(across)?),
            None => None,
        };
        let times = rows.of(hypothesis.port, hypothesis.at, hypothesis.times)?;
        let known: Vec<f64> = times.iter().flatten().copied().filter(|t| t.is_finite()).collect();
        let size = (known.iter().map(|t| t * t).sum::<f64>() / known.len().max(1) as f64).sqrt();
        let step = hypothesis.port.small() / size;
        let hypothesis = *hypothesis;
        let own = Candidate { hypothesis, over, times, across, constant, step, spring: None };
        step.is_finite().then_some(own)
    };
    all.par_iter().filter_map(of).collect()
}

/// Every curve, and every loop that may stand in its place.
fn curves(context: &Context<'_>, ports: &[PortAt]) -> Vec<Candidate> {
    let mut found = of_logs(context, ports, &hypotheses::all());
    let loops = |curve: &Candidate| {
        let range = curve.range(context)?;
        let wide = |share: f64| curve.turning_over(context, grammar::rounded(share * range));
        Some(TURNS_OVER.into_iter().filter_map(wide).collect::<Vec<_>>())
    };
    let may_be = found.par_iter().filter(|curve| curve.hypothesis.may_be_loop());
    let loops: Vec<Vec<Candidate>> = may_be.filter_map(loops).collect();
    found.extend(loops.into_iter().flatten());
    found
}

/// Ways over which loops turn round, as shares of the range of their variable.
const TURNS_OVER: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];

/// Slopes of all residuals by a constant at a port, in its unit; `None` where no log shows it. What
/// swings does not answer at once: a ring-down says nothing here.
fn constant(context: &Context<'_>, port: &'static NamedPort, at: Location) -> Option<Slopes> {
    let kind = diagnose::evidence::constant(port.name, "1", port.unit)?;
    let mut point = context.null.point.clone();
    let of = EffectScope::All(point.all.len());
    point.all.push(Effect { kind, at, values: vec![0.0] });
    let free = FreeParameter { of, parameter: 0, expected: f64::INFINITY };
    let mut slopes = fit::slopes(context.bench, &point, &[free], &context.null.at, 1.0).pop()?;
    for (slope, experiment) in slopes.iter_mut().zip(&context.bench.experiments) {
        if experiment.kind == LogKind::RingDown {
            *slope = None;
        }
        slope.iter_mut().flatten().for_each(|s| *s /= port.small());
    }
    let seen: f64 = slopes.iter().flatten().flatten().map(|s| s * s).sum();
    (seen.is_finite() && seen > 0.0).then_some(slopes)
}

/// What slopes tell of a curve beside the calibrations, in the layout that suits it best.
fn screen<'c>(context: &Context<'_>, candidate: &'c Candidate) -> Option<Screened<'c>> {
    let in_layout = |layout: &Layout| {
        let layout = *layout;
        let places = candidate.places(context, layout, SCREENED)?;
        let linear = context.condensed(&candidate.slopes(context, &places));
        let Smooth { held_out, most, .. } = smooth(&linear, &places, candidate.step)?;
        Some(Screened { candidate, layout, places, linear, most, held_out, formula: None })
    };
    let all = candidate.layouts(context).iter().filter_map(in_layout);
    all.min_by(|a, b| a.held_out.total_cmp(&b.held_out))
}

impl Screened<'_> {
    /// The same with the best formula in the curve's place, as far as slopes tell.
    fn with_formula(self, context: &Context<'_>) -> Self {
        let count = fit::count(&context.null.at);
        match grammar::screened(&self.linear, &self.places, self.candidate, count) {
            Some((held_out, formula)) => {
                Self { held_out: held_out.min(self.held_out), formula: Some(formula), ..self }
            }
            None => self,
        }
    }
}
