//! Laws outside the library: free curves fitted through the plant with the formulas that screening found
//! in their place, and what they must do better than.

use super::context::DiscoveryContext;
use super::curve::{CurveCandidate, FittedCurve, fit_curve};
use super::grammar::{self, FittedFormula};
use super::hypotheses::{self, Hypothesis};
use super::screen::{ScreenedCurve, curves, likeliest, ports, surfaces};
use crate::diagnosis::{Diagnosed, DiagnosisVerdict, ProgressCallback, fits_anything};
use crate::log_evidence::is_significant;
use crate::rules;
use rayon::prelude::*;
use trueweld_estimate::fit::{FitProblem, Fitted};

/// Share of what is above the floor that a discovery may leave.
const DISCOVERY_REMAINDER_MAX: f64 = 0.25;
/// Share of what the library explains that a curve must explain more where nothing stands out,
/// beside what chance makes: no prediction is exact, and an effect whose form holds to this holds.
const HOLDS: f64 = 0.01;

/// What the library makes of the logs, and so what a law outside it must do better than.
pub(super) struct Library<'a> {
    problem: &'a FitProblem,
    /// Sum of squares of blocks left out, by the calibrations alone.
    before: f64,
    /// The least one, and the least cost, with what it has.
    held_out: f64,
    cost: f64,
    /// Sum of squares above the floor by the calibrations alone.
    above: f64,
    /// True where nothing stands out that it does not explain.
    within_noise: bool,
    /// By how much of its noise a law must predict blocks better.
    gain: f64,
}

impl<'a> Library<'a> {
    pub(crate) fn of(problem: &'a FitProblem, diagnosed: &Diagnosed) -> Self {
        let Diagnosed { diagnosis, fits } = diagnosed;
        let null = &fits.null;
        // A partial explanation within the library may do as well; one that fits anything is none.
        let within = fits.chosen.iter().chain(&fits.candidates);
        let within = within.filter(|fitted| !fits_anything(problem, fitted));
        let within: Vec<&Fitted> = within.chain([null]).collect();
        let least = |of: &dyn Fn(&Fitted) -> f64| {
            within.iter().map(|fitted| of(fitted)).fold(f64::INFINITY, f64::min)
        };
        let adequate = diagnosis.verdict == DiagnosisVerdict::Adequate;
        let named =
            fits.chosen.last().filter(|_| diagnosis.verdict == DiagnosisVerdict::EffectFound);
        Self {
            problem,
            before: null.held_out(),
            held_out: least(&Fitted::held_out),
            cost: least(&|fitted| fitted.cost),
            above: rules::excess_chi_square(problem, &null.residuals).max(1.0),
            within_noise: adequate
                || named.is_some_and(|fitted| rules::within_noise(problem, &fitted.residuals)),
            // Where nothing is missing as far as the library goes, one of so many may promise much by
            // chance.
            gain: if adequate { rules::AMPLE } else { rules::GAIN },
        }
    }

    /// What blocks left out must be lowered to beside an explanation that leaves them at `held_out`,
    /// by what noise makes of their sum. What leaves something that stands out is to be bettered by
    /// chance alone; what does not, by more than what no prediction is exact to as well.
    fn beyond(&self, held_out: f64, within_noise: bool, noise: f64) -> f64 {
        let holds = if within_noise { HOLDS } else { 0.0 };
        held_out - (self.gain * noise).max(holds * (self.before - held_out))
    }

    /// What a law must promise to lower blocks left out to: nothing where something stands out.
    fn goal(&self) -> f64 {
        if self.within_noise { self.beyond(self.held_out, true, 1.0) } else { f64::INFINITY }
    }

    /// True for a law that does better than all that the library has.
    fn is_bettered_by(&self, law: &FreeFormLaw) -> bool {
        let fitted = law.fitted();
        let left = rules::excess_chi_square(self.problem, &fitted.residuals) / self.above;
        // Of what shows little, noise alone leaves a large share.
        let partial =
            left > DISCOVERY_REMAINDER_MAX && !rules::within_noise(self.problem, &fitted.residuals);
        // What is freer than an effect and tied with it is no law: what it predicts better of blocks
        // left out it owes to calibrations that are farther off than expected.
        let fits_better =
            fitted.cost < self.cost - rules::DECISIVE_FALL * rules::variance_inflation(fitted);
        let beyond = self.beyond(self.held_out, self.within_noise, law.noise());
        !partial && fits_better && law.held_out <= beyond
    }
}

/// Laws that do better than the library and that the logs do not tell apart, the one first that is named.
/// Where no curve is enough, and where one was found, surfaces are looked at too: one variable is enough
/// where a second one brings no more.
pub(super) fn free_form_laws(
    context: &DiscoveryContext<'_>,
    library: &Library<'_>,
    progress: ProgressCallback<'_>,
) -> Vec<FreeFormLaw> {
    let goal = library.goal();
    let ports = ports(context);
    let found = laws(context, &curves(context, &ports), goal, (progress, [0.0, 0.3]));
    let of_one = first(found, |law| library.is_bettered_by(law));
    if of_one.is_none() && library.within_noise {
        return Vec::new();
    }
    let beyond = of_one.as_ref().map_or(goal, |laws| {
        let law = &laws[0];
        let within_noise = rules::within_noise(library.problem, &law.fitted().residuals);
        library.beyond(law.held_out, within_noise, law.noise())
    });
    // What few places promise says little of what more of them bring.
    let found = laws(context, &surfaces(context, &ports), goal, (progress, [0.6, 0.7]));
    let is_better = |law: &FreeFormLaw| library.is_bettered_by(law) && law.held_out < beyond;
    first(found, is_better).or(of_one).unwrap_or_default()
}

/// The laws with the first one that is as asked before all others; `None` where there is none.
fn first(
    mut laws: Vec<FreeFormLaw>,
    is_one: impl Fn(&FreeFormLaw) -> bool,
) -> Option<Vec<FreeFormLaw>> {
    let at = laws.iter().position(is_one)?;
    laws[..=at].rotate_right(1);
    Some(laws)
}

/// Curves that lower blocks left out by more than chance, beside all that a fit has.
pub(super) fn curves_that_lower_cost(context: &DiscoveryContext<'_>) -> Vec<FreeFormLaw> {
    laws(context, &curves(context, &ports(context)), f64::INFINITY, (&|_, _| (), [0.0; 2]))
}

/// A free curve that was fitted through the plant, and the formula that screening found in its place.
#[derive(Debug)]
pub(super) struct FreeFormLaw {
    pub curve: FittedCurve,
    pub formula: Option<FittedFormula>,
    /// True where the formula predicts blocks better that were left out.
    is_formula: bool,
    /// Sum of squares of these, by the better of the two.
    held_out: f64,
}

impl FreeFormLaw {
    fn new(context: &DiscoveryContext<'_>, screened: &ScreenedCurve<'_>) -> Option<Self> {
        let curve = fit_curve(context, screened.candidate, screened.layout)?;
        let formula = screened.formula.as_ref();
        let formula = formula.and_then(|found| grammar::fitted(context, &curve, found));
        let of_curve = curve.fitted.held_out();
        let of_formula = formula.as_ref().map_or(f64::INFINITY, |law| law.fitted.held_out());
        let (is_formula, held_out) = (of_formula < of_curve, of_formula.min(of_curve));
        Some(Self { curve, formula, is_formula, held_out })
    }

    /// The one of the two that predicts blocks better that were left out.
    pub(crate) fn fitted(&self) -> &Fitted {
        let formula = self.formula.as_ref().filter(|_| self.is_formula);
        formula.map_or(&self.curve.fitted, |law| &law.fitted)
    }

    /// What noise makes of that.
    fn noise(&self) -> f64 {
        rules::variance_inflation(self.fitted()) / trueweld_estimate::AUTOCORRELATION_INFLATION
    }
}

/// Laws that lower blocks left out by more than chance, as far as the logs do not tell them from the
/// best: the one first that is named of these. `goal`: what such a law must promise to lower them to;
/// `progress`: with its shares where they are looked for, and where they are fitted.
fn laws(
    context: &DiscoveryContext<'_>,
    candidates: &[CurveCandidate],
    goal: f64,
    (progress, [looking, fitting]): (ProgressCallback<'_>, [f64; 2]),
) -> Vec<FreeFormLaw> {
    let DiscoveryContext { problem, null, .. } = *context;
    progress("looking outside the library", looking);
    let wanted = likeliest(context, candidates, goal);
    progress("fitting what may be there", fitting);
    let mut laws: Vec<FreeFormLaw> = wanted
        .par_iter()
        .filter(|_| !problem.is_late())
        .filter_map(|screened| FreeFormLaw::new(context, screened))
        .filter(|law| is_significant(problem, null, law.fitted()))
        .collect();
    laws.sort_by(|a, b| a.held_out.total_cmp(&b.held_out));
    let Some(least) = laws.first() else {
        return Vec::new();
    };
    let reach = least.held_out + rules::DECISIVE_FALL * rules::variance_inflation(least.fitted());
    laws.retain(|law| law.held_out <= reach);
    let order = hypotheses::all();
    let place = |h: &Hypothesis| order.iter().position(|one| one == h).unwrap_or(order.len());
    laws.sort_by_key(|law| place(&law.curve.candidate.hypothesis));
    laws
}
