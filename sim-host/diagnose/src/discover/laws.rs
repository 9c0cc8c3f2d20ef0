//! Laws outside the library: free curves fitted through the plant with the formulas that screening found
//! in their place, and what they must do better than.

use super::context::DiscoveryContext;
use super::curve::{CurveCandidate, FittedCurve, fit_curve};
use super::grammar::{self, FittedFormula};
use super::hypotheses::{self, Hypothesis};
use super::screen::{ScreenedCurve, curves, likeliest, ports, surfaces};
use crate::diagnosis::{
    Diagnosed, DiagnosisFits, DiagnosisVerdict, PortAt, ProgressCallback, fits_anything,
};
use crate::found::effects_of;
use crate::log_evidence::{RivalEvidence, is_of_library, is_significant};
use crate::rules::{self, DECISIVE, NAMED};
use rayon::prelude::*;
use trueweld_estimate::fit::{self, EffectScope, FitProblem, Fitted};
use trueweld_plant::effects::Effect;
use trueweld_plant::robot::{Channel, Port};

/// Share of what stands out of the floor that a discovery may leave.
const DISCOVERY_REMAINDER_MAX: f64 = 0.25;
/// Share of what the library explains that a curve must explain more where nothing stands out,
/// beside what chance makes: no prediction is exact, and an effect whose form holds to this holds.
const HOLDS: f64 = 0.01;

/// What the library makes of the logs, and so what a law outside it must do better than.
pub(super) struct Library<'a> {
    problem: &'a FitProblem,
    null: &'a Fitted,
    /// Its explanations.
    within: Vec<&'a Fitted>,
    /// Those that fit anything, and so are none.
    fit_anything: Vec<&'a Fitted>,
    /// True where nothing is missing as far as it goes.
    adequate: bool,
    /// True where nothing stands out that it does not explain.
    within_noise: bool,
    /// Sum of squares that stands out of the floor by the calibrations alone.
    noise_excess: f64,
    /// Those of its explanations that may be named, where one is.
    named: Vec<&'a Fitted>,
}

impl<'a> Library<'a> {
    pub(crate) fn of(problem: &'a FitProblem, diagnosed: &'a Diagnosed) -> Self {
        let Diagnosed { diagnosis, fits } = diagnosed;
        let DiagnosisFits { null, chosen, candidates, .. } = fits;
        let adequate = diagnosis.verdict == DiagnosisVerdict::Adequate;
        let is_named = diagnosis.verdict == DiagnosisVerdict::EffectFound;
        let named = diagnosis.candidates.iter().zip(candidates);
        let named = named.filter(|(candidate, _)| is_named && candidate.may_be_named);
        let explained = chosen.last().filter(|_| is_named);
        // A partial explanation may do as well.
        let all = chosen.iter().chain(candidates);
        let (fit_anything, within) = all.partition(|fitted| fits_anything(problem, fitted));
        Self {
            problem,
            null,
            within,
            fit_anything,
            adequate,
            within_noise: adequate
                || explained.is_some_and(|fitted| rules::within_noise(problem, &fitted.residuals)),
            noise_excess: rules::noise_excess(problem, &null.residuals),
            named: named.map(|(_, fitted)| fitted).collect(),
        }
    }

    /// What a law must promise to lower blocks left out to: nothing where something stands out, or has a
    /// name that one which does as well makes doubtful.
    fn goal(&self) -> f64 {
        if !self.within_noise || !self.named.is_empty() {
            return f64::INFINITY;
        }
        let before = self.null.held_out();
        let held_out = self.within.iter().map(|fitted| fitted.held_out()).fold(before, f64::min);
        held_out - rules::DECISIVE_FALL.max(HOLDS * (before - held_out))
    }

    /// True for a law that has a name among its shapes, at the same place, seen as that is: it says the same
    /// in other words.
    fn says_the_same(&self, law: &FreeFormLaw, named: &Fitted) -> bool {
        let Some(own) = law.fitted().point.shared.last() else { return false };
        let acts_as = |effect: &Effect| effect.at == own.at && seen_as(effect) == seen_as(own);
        effects_of(named).into_iter().any(|i| acts_as(&named.point.shared[i]))
            && law.holds(self.problem, named)
    }

    /// What other laws leave of its names: of those at one port the likeliest counts, for the others say
    /// the same in other words. All are judged by one noise, of what the cheapest leaves.
    fn beside(&self, laws: &[FreeFormLaw]) -> Option<LibraryShare> {
        let fits = self.named.iter().copied().chain(laws.iter().map(FreeFormLaw::fitted));
        let cheapest = fits.min_by(|a, b| a.cost.total_cmp(&b.cost))?;
        let evidence = RivalEvidence::over(self.problem, self.null, &cheapest.residuals);
        let within: Vec<f64> = self.named.par_iter().map(|fitted| evidence.of(fitted)).collect();
        let best = within.iter().copied().reduce(f64::max)?;
        // What such a law follows besides a name is noise, unless it says more by more than chance.
        let is_no_rival = |law: &FreeFormLaw, own: f64| {
            let mut names = self.named.iter().zip(&within);
            names.any(|(named, evidence)| {
                own < evidence + DECISIVE && self.says_the_same(law, named)
            })
        };
        let of_law = |law: &FreeFormLaw| {
            let Hypothesis { port, at, .. } = law.curve.candidate.hypothesis;
            let own = law.evidence(&evidence);
            (!is_no_rival(law, own)).then_some(((port, at), own))
        };
        let mut outside: Vec<(PortAt, f64)> = laws.par_iter().filter_map(of_law).collect();
        outside.sort_by(|a, b| b.1.total_cmp(&a.1));
        let mut of_port: Vec<(PortAt, f64)> = Vec::new();
        for (port, evidence) in outside {
            if !of_port.iter().any(|(known, _)| *known == port) {
                of_port.push((port, evidence));
            }
        }
        let weight = |evidence: f64| (evidence - best).exp();
        let inside: f64 = within.into_iter().map(weight).sum();
        let all = inside + of_port.iter().map(|(_, evidence)| weight(*evidence)).sum::<f64>();
        let likeliest = of_port.first().map_or(0.0, |(_, evidence)| *evidence);
        of_port.retain(|(_, evidence)| *evidence > likeliest - DECISIVE);
        let ports = of_port.into_iter().map(|(port, _)| port).collect();
        Some(LibraryShare { share: inside / all, ports })
    }

    /// True for a law that does better than all that the library has, and no worse than what fits
    /// anything, which it would do too if it were right. One where nothing is missing must show as an
    /// effect does.
    fn is_bettered_by(&self, law: &FreeFormLaw) -> bool {
        self.is_bettered_by_fit(law.fitted(), law.description)
    }

    /// The same of a formula in the place of a law's curve.
    pub(super) fn is_bettered_by_formula(
        &self,
        law: &FreeFormLaw,
        formula: &FittedFormula,
    ) -> bool {
        self.is_bettered_by_fit(&formula.fitted, description(formula.shape_price(&law.curve)))
    }

    /// The same of a fit of a law with such a description, nats.
    fn is_bettered_by_fit(&self, fitted: &Fitted, description: f64) -> bool {
        let partial = rules::noise_excess(self.problem, &fitted.residuals)
            > DISCOVERY_REMAINDER_MAX * self.noise_excess;
        let evidence = RivalEvidence::over(self.problem, self.null, &fitted.residuals);
        let to_better = |fitted: &&Fitted| {
            needed([evidence.of(fitted), evidence.gain(fitted)], self.within_noise)
        };
        let of_within = self.within.par_iter().map(to_better);
        let of_anything = self.fit_anything.par_iter().map(|fitted| evidence.of(fitted));
        let least = of_within.chain(of_anything).reduce(|| DECISIVE, f64::max);
        let own = evidence.gain(fitted) - description;
        !partial && own > least && (!self.adequate || is_of_library(own) >= NAMED)
    }
}

/// The logarithm of how many laws are proposed, and shapes of this one, nats: free curves and surfaces, and
/// each formula in their place.
fn description(shapes: f64) -> f64 {
    (grammar::laws_proposed() as f64).ln() + shapes
}

/// The port of an effect; friction of a motor shows as what the motor reads does.
fn seen_as(effect: &Effect) -> Option<Port> {
    match effect.port()? {
        Port::MotorFriction(_) => Some(Port::SensorChannel(Channel::MotorTorque)),
        port => Some(port),
    }
}

/// The evidence that a law needs beside an explanation with so much of it, which predicts by so much
/// better than calibrations: more than chance, and, where that leaves nothing which stands out of the
/// noise, more than what no prediction is exact to.
fn needed([evidence, gain]: [f64; 2], within_noise: bool) -> f64 {
    evidence + if within_noise { DECISIVE.max(HOLDS * gain) } else { DECISIVE }
}

/// What was found outside the library.
pub(super) struct Outside {
    /// Laws that do better than it and that the logs do not tell apart, the one first that is named;
    /// none where there are no such laws.
    pub better: Vec<FreeFormLaw>,
    /// What laws leave of the library's names; `None` where it has none.
    pub beside: Option<LibraryShare>,
}

/// What laws outside the library, which are as likely beforehand, leave of its names.
pub(super) struct LibraryShare {
    /// Probability of the library's explanations together.
    pub share: f64,
    /// Ports at which the likeliest of them act that these logs do not tell apart, best first.
    pub ports: Vec<PortAt>,
}

/// Looks for laws that do better than the library. Where no curve is enough, and where one was found,
/// surfaces are looked at too: one variable is enough where a second one brings no more.
pub(super) fn free_form_laws(
    context: &DiscoveryContext<'_>,
    library: &Library<'_>,
    progress: ProgressCallback<'_>,
) -> Outside {
    let goal = library.goal();
    let ports = ports(context);
    let found = laws(context, &curves(context, &ports), goal, (progress, [0.0, 0.3]));
    let beside = library.beside(&found);
    let of_one = first(found, |law| library.is_bettered_by(law));
    if of_one.is_none() && library.within_noise {
        return Outside { better: Vec::new(), beside };
    }
    // What few places promise says little of what more of them bring.
    let found = laws(context, &surfaces(context, &ports), goal, (progress, [0.6, 0.7]));
    let of_curve = of_one.as_ref().map(|laws| &laws[0]);
    let is_better = |law: &FreeFormLaw| {
        library.is_bettered_by(law) && of_curve.is_none_or(|curve| law.betters(context, curve))
    };
    Outside { better: first(found, is_better).or(of_one).unwrap_or_default(), beside }
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
    /// What describes the one that it is, nats.
    description: f64,
}

impl FreeFormLaw {
    fn new(context: &DiscoveryContext<'_>, screened: &ScreenedCurve<'_>) -> Option<Self> {
        let curve = fit_curve(context, screened.candidate, screened.layout)?;
        let formula = screened.formula.as_ref();
        let formula = formula.and_then(|found| grammar::fitted(context, &curve, found));
        let of_curve = curve.fitted.held_out();
        let of_formula = formula.as_ref().map_or(f64::INFINITY, |law| law.fitted.held_out());
        let (is_formula, held_out) = (of_formula < of_curve, of_formula.min(of_curve));
        let shapes = match formula.as_ref().filter(|_| is_formula) {
            Some(formula) => formula.shape_price(&curve),
            None => curve.shape_price(context),
        };
        Some(Self { curve, formula, is_formula, held_out, description: description(shapes) })
    }

    /// The one of the two that predicts blocks better that were left out.
    pub(crate) fn fitted(&self) -> &Fitted {
        let formula = self.formula.as_ref().filter(|_| self.is_formula);
        formula.map_or(&self.curve.fitted, |law| &law.fitted)
    }

    /// True where one of its shapes predicts what another fit does, with its calibrations, so that these
    /// logs do not tell the two apart.
    fn holds(&self, problem: &FitProblem, other: &Fitted) -> bool {
        let left = |own: &Fitted| {
            let mut apart = own.residuals.clone();
            for (apart, other) in apart.iter_mut().zip(&other.residuals) {
                apart.residual.iter_mut().zip(&other.residual).for_each(|(a, b)| *a -= b);
            }
            let mut linear = own.beside(&fit::blocks_of(problem), &apart);
            // Of its own values any shape is as good; what calibrations are expected to be holds them
            // where the other has them.
            let law = EffectScope::Shared(own.point.shared.len().checked_sub(1)?);
            for (k, free) in own.point.free.iter().enumerate() {
                if free.of == law {
                    linear.prior.row_mut(k).fill(0.0);
                    linear.prior.column_mut(k).fill(0.0);
                } else if let Some(of_other) = other.point.free.iter().position(|o| o == free) {
                    linear.away[k] -= other.linear.away[of_other];
                }
            }
            Some(linear.cost(&linear.solve(None, 0.0, None)?.step))
        };
        let formula = self.formula.as_ref().map(|formula| &formula.fitted);
        let mut all = formula.into_iter().chain([&self.curve.fitted]);
        all.any(|own| left(own).is_some_and(|left| left < rules::DECISIVE_FALL))
    }

    /// Evidence for it, nats.
    fn evidence(&self, over: &RivalEvidence<'_>) -> f64 {
        over.gain(self.fitted()) - self.description
    }

    /// True where it predicts more than another law by more than chance.
    fn betters(&self, context: &DiscoveryContext<'_>, other: &Self) -> bool {
        let DiscoveryContext { problem, null, .. } = *context;
        let evidence = RivalEvidence::over(problem, null, &self.fitted().residuals);
        let [own, gain] = [self, other].map(|law| evidence.gain(law.fitted()));
        let within_noise = rules::within_noise(problem, &other.fitted().residuals);
        own > needed([gain, gain], within_noise)
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
