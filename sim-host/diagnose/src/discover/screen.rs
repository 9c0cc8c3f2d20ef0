//! Which curves and surfaces are worth a fit through the plant: every port at every place and every
//! variable there, screened with the slopes of a constant at the port, as if every row stood still.

use super::context::DiscoveryContext;
use super::curve::{CurveCandidate, KnotLayout, LOOP_WIDTH_SHARES, SCREENED_KNOTS, Smooth, smooth};
use super::grammar::{self, ValuedFormula};
use super::hypotheses::{self, Hypothesis};
use super::variables::LogRows;
use crate::{evidence, rules};
use rayon::prelude::*;
use trueweld_estimate::fit::{self, EffectScope, FreeParameter, ReducedNormal, Slopes};
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::formula::NamedPort;
use trueweld_plant::effects::table::Places;
use trueweld_plant::effects::{Effect, Location};

/// Candidates that are screened with a formula too.
const FORMULAS: usize = 24;
/// Curves that are fitted through the plant, and surfaces, which have more values.
const FITTED_CURVES: usize = 8;
const FITTED_SURFACES: usize = 3;
/// Of these, at one port and place.
const AT_ONE_PORT: usize = 2;
/// Share of what the best curve promises from which on another one is fitted.
const PROMISED_GAIN_SHARE: f64 = 0.7;
/// A candidate with what screening says of it.
pub(super) struct ScreenedCurve<'c> {
    pub candidate: &'c CurveCandidate,
    pub layout: KnotLayout,
    places: Places,
    /// The linear model of the curve's values at these places.
    linear: ReducedNormal,
    /// Fall of the sum of squares of a curve that bends at will.
    most: f64,
    /// Sum of squares of blocks left out, with the curve or with the formula.
    held_out: f64,
    /// The best formula in the curve's place.
    pub formula: Option<ValuedFormula>,
}

/// The candidates that promise most, screened.
pub(super) fn likeliest<'c>(
    context: &DiscoveryContext<'_>,
    candidates: &'c [CurveCandidate],
    goal: f64,
) -> Vec<ScreenedCurve<'c>> {
    let problem = context.problem;
    let mut screened: Vec<ScreenedCurve<'_>> = candidates
        .par_iter()
        .filter(|_| !problem.is_late())
        .filter_map(|candidate| screen(context, candidate))
        .collect();
    // Of loops the one whose width promises most.
    screened.sort_by(|a, b| a.held_out.total_cmp(&b.held_out));
    let mut kept: Vec<ScreenedCurve<'_>> = Vec::new();
    for one in screened {
        let same =
            |k: &ScreenedCurve<'_>| k.candidate.hypothesis.is_like(&one.candidate.hypothesis);
        if !kept.iter().any(same) {
            kept.push(one);
        }
    }
    let mut screened = kept;
    // A formula is tried where it may bring enough.
    screened.sort_by(|a, b| b.most.total_cmp(&a.most));
    let others = screened.split_off(screened.len().min(FORMULAS));
    let tried = screened.into_par_iter().map(|screened| match problem.is_late() {
        true => screened,
        false => screened.with_formula(context),
    });
    let mut screened: Vec<ScreenedCurve<'_>> = tried.chain(others).collect();
    screened.sort_by(|a, b| a.held_out.total_cmp(&b.held_out));
    screened.retain(|screened| screened.held_out < goal);
    let before = context.null.held_out();
    let promised =
        screened.first().map_or(0.0, |best| PROMISED_GAIN_SHARE * (before - best.held_out));
    let mut wanted: Vec<ScreenedCurve<'_>> = Vec::new();
    for one in screened {
        let place = |c: &CurveCandidate| (c.hypothesis.port.name, c.hypothesis.at);
        let same = wanted.iter().filter(|w| place(w.candidate) == place(one.candidate)).count();
        let gain = before - one.held_out;
        let most = if one.candidate.across.is_some() { FITTED_SURFACES } else { FITTED_CURVES };
        if wanted.len() < most && same < AT_ONE_PORT && gain > promised.max(rules::GAIN) {
            wanted.push(one);
        }
    }
    wanted
}

/// A port at a place, with the slopes of all residuals by a constant there.
pub(super) type PortSlopes = (&'static NamedPort, Location, Slopes);

/// Every port at every place where the logs show it.
pub(super) fn ports(context: &DiscoveryContext<'_>) -> Vec<PortSlopes> {
    let mut ports: Vec<(&'static NamedPort, Location)> = Vec::new();
    for hypothesis in hypotheses::all() {
        let place = (hypothesis.port, hypothesis.at);
        if !ports.iter().any(|p| (p.0.name, p.1) == (place.0.name, place.1)) {
            ports.push(place);
        }
    }
    let on_time = ports.par_iter().filter(|_| !context.problem.is_late());
    on_time.filter_map(|(port, at)| Some((*port, *at, constant(context, port, *at)?))).collect()
}

/// Every surface.
pub(super) fn surfaces(
    context: &DiscoveryContext<'_>,
    ports: &[PortSlopes],
) -> Vec<CurveCandidate> {
    of_logs(context, ports, &hypotheses::surfaces())
}

/// Every hypothesis that the logs carry the variables of and show the port of.
fn of_logs(
    context: &DiscoveryContext<'_>,
    ports: &[PortSlopes],
    all: &[Hypothesis],
) -> Vec<CurveCandidate> {
    let rows = context.rows();
    all.par_iter().filter_map(|hypothesis| of_rows(&rows, ports, *hypothesis)).collect()
}

/// A hypothesis with its variables by row; `None` where the logs do not carry them, or do not show
/// its port.
fn of_rows(
    rows: &LogRows<'_>,
    ports: &[PortSlopes],
    hypothesis: Hypothesis,
) -> Option<CurveCandidate> {
    let here = |p: &&PortSlopes| (p.0.name, p.1) == (hypothesis.port.name, hypothesis.at);
    let constant = ports.iter().find(here)?.2.clone();
    let values = |text| rows.of(hypothesis.port, hypothesis.at, text);
    let over = values(hypothesis.over)?;
    let across = match hypothesis.across {
        Some(across) => Some(values(across)?),
        None => None,
    };
    let times = values(hypothesis.times)?;
    let known: Vec<f64> = times.iter().flatten().copied().filter(|t| t.is_finite()).collect();
    let size = (known.iter().map(|t| t * t).sum::<f64>() / known.len().max(1) as f64).sqrt();
    let step = hypothesis.port.small() / size;
    let own = CurveCandidate { hypothesis, over, times, across, constant, step, spring: None };
    step.is_finite().then_some(own)
}

/// Every curve, and every loop that may stand in its place.
pub(super) fn curves(context: &DiscoveryContext<'_>, ports: &[PortSlopes]) -> Vec<CurveCandidate> {
    let mut found = of_logs(context, ports, &hypotheses::all());
    let loops = |curve: &CurveCandidate| {
        let range = curve.range(context)?;
        let wide = |share: f64| curve.turning_over(context, grammar::rounded(share * range));
        Some(LOOP_WIDTH_SHARES.into_iter().filter_map(wide).collect::<Vec<_>>())
    };
    let may_be = found.par_iter().filter(|curve| curve.hypothesis.may_be_loop());
    let loops: Vec<Vec<CurveCandidate>> = may_be.filter_map(loops).collect();
    found.extend(loops.into_iter().flatten());
    found
}

/// Slopes of all residuals by a constant at a port, in its unit; `None` where no log shows it. What
/// swings does not answer at once: a ring-down says nothing here.
fn constant(
    context: &DiscoveryContext<'_>,
    port: &'static NamedPort,
    at: Location,
) -> Option<Slopes> {
    let kind = evidence::constant(port.name, "1", port.unit)?;
    let mut point = context.null.point.clone();
    let of = EffectScope::Shared(point.shared.len());
    point.shared.push(Effect { kind, at, values: vec![0.0] });
    let free = FreeParameter { of, parameter: 0, expected: f64::INFINITY };
    let mut slopes =
        fit::slopes(context.problem, &point, &[free], &context.null.residuals, 1.0).pop()?;
    for (slope, experiment) in slopes.iter_mut().zip(&context.problem.logs) {
        if experiment.kind == LogKind::RingDown {
            *slope = None;
        }
        slope.iter_mut().flatten().for_each(|s| *s /= port.small());
    }
    let seen: f64 = slopes.iter().flatten().flatten().map(|s| s * s).sum();
    (seen.is_finite() && seen > 0.0).then_some(slopes)
}

/// What slopes tell of a curve beside the calibrations, in the layout that suits it best as if every row
/// stood still.
fn screen<'c>(
    context: &DiscoveryContext<'_>,
    candidate: &'c CurveCandidate,
) -> Option<ScreenedCurve<'c>> {
    let by_slopes = |(layout, places): (KnotLayout, Places), slopes: &[Slopes]| {
        let linear = context.condensed(slopes);
        let Smooth { held_out, most, .. } = smooth(&linear, &places, candidate.step)?;
        Some(ScreenedCurve { candidate, layout, places, linear, most, held_out, formula: None })
    };
    let in_layout = |layout: &KnotLayout| {
        let places = candidate.places(context, *layout, SCREENED_KNOTS)?;
        let at_once = candidate.slopes_at_once(context, &places);
        by_slopes((*layout, places), &at_once)
    };
    let all = candidate.layouts(context).iter().filter_map(in_layout);
    let best = all.min_by(|a, b| a.held_out.total_cmp(&b.held_out))?;
    match candidate.slopes_as_it_swings(context, &best.places) {
        Some(slopes) => by_slopes((best.layout, best.places), &slopes),
        None => Some(best),
    }
}

impl ScreenedCurve<'_> {
    /// The same with the best formula in the curve's place, as far as slopes tell.
    fn with_formula(self, context: &DiscoveryContext<'_>) -> Self {
        let count = fit::count(&context.null.residuals);
        match grammar::screened(&self.linear, &self.places, self.candidate, count) {
            Some((held_out, formula)) => {
                Self { held_out: held_out.min(self.held_out), formula: Some(formula), ..self }
            }
            None => self,
        }
    }
}
