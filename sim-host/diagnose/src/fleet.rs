//! Several units of one type: which effects they share, what the type's values are and how far units
//! spread, and which unit is an outlier.
//!
//! The values of a unit are those of its own logs, with the uncertainty that its posterior has; none is
//! drawn towards the others. What one unit's logs name, another's may show too little of to name it: what
//! only others have is fitted to it as well, beside its own. That an effect is there, or is not, counts from a
//! hundred to one on, as in a diagnosis.
//!
//! Left out: laws outside the library, which differ in form from unit to unit; what each log or day has
//! of its own (zeros, registrations, how the tool is mounted).

use crate::improve::{Improvement, ImprovementStep, is_renewed};
use crate::posterior::of_fit;
use crate::rules::DECISIVE;
use crate::{DiagnosisVerdict, FittedEffect};
use trueweld_estimate::fit::calibration::{calibrations, in_proportion, is_calibration};
use trueweld_estimate::fit::{FitProblem, SolverOptions, blocks_of, fit};
use trueweld_estimate::predict::PredictError;
use trueweld_estimate::random_effects::{LeftOutUnit, RandomEffects, UnitValue};
use trueweld_logs::log::Log;
use trueweld_plant::effects::{Effect, Parameter, Role};
use trueweld_plant::input::{Posterior, RobotFile};
use trueweld_plant::named;

/// Cost by which a fit with more effects may end above one with fewer and still be at its least: each
/// ends where half of that is promised.
const FIT_COST_TOLERANCE: f64 = 1.0;

/// A unit that was improved.
#[derive(Clone, Copy)]
pub struct ImprovedUnit<'a> {
    /// Its logs as they are fitted, under the model of its type.
    pub problem: &'a FitProblem,
    /// The logs that these were made of.
    pub logs: &'a [Log],
    /// Its robot.
    pub robot: &'a RobotFile,
    /// What was done.
    pub improvement: &'a Improvement,
    /// What its logs leave open of its numbers; `None` where that is not known.
    pub posterior: Option<&'a Posterior>,
}

/// Units of one type beside each other.
#[derive(Debug, Clone)]
pub struct Fleet {
    /// Effects that any of them has.
    pub effects: Vec<FleetEffect>,
    /// Calibrations that count in any of them.
    pub calibrations: Vec<FleetEffect>,
    /// Units that are unlike the others; `None` of two, of which either may be the odd one.
    pub outliers: Option<Vec<Outlier>>,
}

/// An effect over all units.
#[derive(Debug, Clone)]
pub struct FleetEffect {
    /// The effect, with the values of the first unit that names it.
    pub effect: Effect,
    /// Whether each unit has it. A calibration is everywhere.
    pub presence: Vec<Presence>,
    /// Its parameters.
    pub parameters: Vec<FleetParameter>,
}

named! {
    /// Whether a unit has an effect.
    pub enum Presence {
        /// Its own logs name it.
        Named = "named",
        /// They do not name it among all effects, and measure it to be there.
        Measured = "measured",
        /// They measure it not to be there.
        Absent = "absent",
        /// They do not tell.
        Unknown = "unknown",
    }
}

/// A parameter over all units, in its unit.
#[derive(Debug, Clone)]
pub struct FleetParameter {
    /// What each unit's own logs measure; `None` where they say next to nothing.
    pub units: Vec<Option<UnitValue>>,
    /// The type, by the units that have the effect; `None` where these are fewer than two.
    pub fleet: Option<RandomEffects>,
    /// How far each unit is from the others; `None` where there are fewer than two others.
    pub left_out: Vec<Option<LeftOutUnit>>,
}

/// A unit that is unlike the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlier {
    /// Which.
    pub unit: usize,
    /// Why.
    pub reasons: Vec<OutlierReason>,
}

/// Why a unit is unlike the others.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutlierReason {
    /// It alone has the effect of that index.
    Alone(usize),
    /// It alone does not have it.
    Lacking(usize),
    /// A value of an effect is too far from those of the others.
    EffectValue(usize, usize),
    /// The same of a calibration.
    CalibrationValue(usize, usize),
}

impl Presence {
    /// True where the unit has the effect.
    pub fn is_there(self) -> bool {
        matches!(self, Self::Named | Self::Measured)
    }
}

impl FleetEffect {
    /// True for an effect that every unit has.
    pub fn is_shared(&self) -> bool {
        self.presence.iter().all(|p| p.is_there())
    }

    /// Units of which this is so.
    pub fn units(&self, is: impl Fn(Presence) -> bool) -> Vec<usize> {
        (0..self.presence.len()).filter(|unit| is(self.presence[*unit])).collect()
    }
}

impl Fleet {
    /// Lays units of one type beside each other.
    ///
    /// # Errors
    /// [`PredictError`] where a model with the effects of all units cannot be driven through the logs of
    /// one.
    pub fn of(units: &[ImprovedUnit<'_>]) -> Result<Self, PredictError> {
        let effects = places(units, |unit| {
            let is_law = |f: &FittedEffect| {
                let mut laws = unit.improvement.discovered.iter();
                laws.any(|law| std::ptr::eq(law.effect.effect.kind, f.effect.kind))
            };
            unit.improvement.last().effects.iter().filter(move |f| !is_law(f)).collect()
        });
        let calibrations =
            places(units, |unit| unit.improvement.last().calibration.iter().collect());
        let mut beside = Vec::new();
        for (k, unit) in units.iter().enumerate() {
            beside.push(posterior_beside(unit, k, &effects)?);
        }
        let ctx = FleetContext { units, places: &effects, beside: &beside };
        let all = |places: &[FleetPlace]| places.iter().map(|place| ctx.effect(place)).collect();
        let mut fleet =
            Self { effects: all(&effects), calibrations: all(&calibrations), outliers: None };
        fleet.outliers = (units.len() > 2).then(|| fleet.unlike(units.len()));
        Ok(fleet)
    }

    /// Units that are unlike the others, of three or more. Distances are judged all together, so that the
    /// farthest of many is no surprise (Bonferroni).
    fn unlike(&self, units: usize) -> Vec<Outlier> {
        let distances = |all: &[FleetEffect]| {
            let parameters = all.iter().flat_map(|effect| &effect.parameters);
            parameters.flat_map(|parameter| parameter.left_out.iter().flatten()).count()
        };
        let judged = distances(&self.effects) + distances(&self.calibrations);
        let surprise = (-DECISIVE).exp() / judged.max(1) as f64;
        let far = |all: &[FleetEffect], unit: usize| -> Vec<(usize, usize)> {
            let is_far = |parameter: &FleetParameter| {
                parameter.left_out[unit].is_some_and(|of| of.probability < surprise)
            };
            let each = all.iter().enumerate().flat_map(|(k, effect)| {
                effect.parameters.iter().enumerate().map(move |(p, of)| (k, p, of))
            });
            each.filter(|(.., of)| is_far(of)).map(|(k, p, _)| (k, p)).collect()
        };
        let unlike = |unit: usize| {
            let mut reasons = Vec::new();
            for (k, effect) in self.effects.iter().enumerate() {
                let only = |is: &dyn Fn(Presence) -> bool| effect.units(is) == [unit];
                let told = !effect.presence.contains(&Presence::Unknown);
                if told && only(&Presence::is_there) {
                    reasons.push(OutlierReason::Alone(k));
                } else if told && only(&|p| p == Presence::Absent) {
                    reasons.push(OutlierReason::Lacking(k));
                }
            }
            let qualitative = reasons.clone();
            let is_told = |k: &usize| {
                let told = [OutlierReason::Alone(*k), OutlierReason::Lacking(*k)];
                qualitative.iter().any(|reason| told.contains(reason))
            };
            let of_effects = far(&self.effects, unit).into_iter().filter(|(k, _)| !is_told(k));
            reasons.extend(of_effects.map(|(k, p)| OutlierReason::EffectValue(k, p)));
            let of_calibrations = far(&self.calibrations, unit).into_iter();
            reasons.extend(of_calibrations.map(|(k, p)| OutlierReason::CalibrationValue(k, p)));
            (!reasons.is_empty()).then_some(Outlier { unit, reasons })
        };
        (0..units).filter_map(unlike).collect()
    }
}

/// An effect that some units have: which of its kind at its place, and what each unit found of it.
struct FleetPlace {
    /// Of its kind at its place, from 0.
    occurrence: usize,
    found: Vec<Option<FittedEffect>>,
}

impl FleetPlace {
    /// What the first unit found that has it.
    fn first(&self) -> &FittedEffect {
        self.found.iter().flatten().next().expect("some unit has it")
    }

    /// The mean of what the units found that have it.
    fn mean(&self) -> Effect {
        let all: Vec<&FittedEffect> = self.found.iter().flatten().collect();
        let mean =
            |k: usize| all.iter().map(|f| f.effect.values[k]).sum::<f64>() / all.len() as f64;
        let first = &self.first().effect;
        Effect { values: (0..first.values.len()).map(mean).collect(), ..first.clone() }
    }
}

/// What the units found of each effect that is the cell's own, `of`: the effects of one unit.
fn places<'a>(
    units: &[ImprovedUnit<'a>],
    of: impl Fn(&ImprovedUnit<'a>) -> Vec<&'a FittedEffect>,
) -> Vec<FleetPlace> {
    let mut places: Vec<FleetPlace> = Vec::new();
    for (k, unit) in units.iter().enumerate() {
        let own = of(unit).into_iter().filter(|f| f.log.is_none() && !is_renewed(&f.effect));
        for found in own {
            let same = |place: &&mut FleetPlace| {
                let first = &place.first().effect;
                first.place() == found.effect.place()
            };
            let occurrence = places.iter_mut().filter(same).count();
            match places.iter_mut().filter(same).find(|place| place.found[k].is_none()) {
                Some(place) => place.found[k] = Some(found.clone()),
                None => {
                    let mut all = vec![None; units.len()];
                    all[k] = Some(found.clone());
                    places.push(FleetPlace { occurrence, found: all });
                }
            }
        }
    }
    places
}

/// What a unit's logs measure of the effects that only others have, beside its own and with every
/// calibration free; `None` where it has them all, where something is left that no effect explains and
/// that these would be drawn into, or where the fit is worse than without them, so that it has not found
/// the least.
fn posterior_beside(
    ImprovedUnit { problem, logs, robot, improvement, .. }: &ImprovedUnit<'_>,
    unit: usize,
    effects: &[FleetPlace],
) -> Result<Option<Posterior>, PredictError> {
    let has_all = effects.iter().all(|place| place.found[unit].is_some());
    if has_all || improvement.verdict == DiagnosisVerdict::UnknownEffect {
        return Ok(None);
    }
    let mut point = calibrations(problem);
    let options = SolverOptions::full(in_proportion(&point));
    let own = effects.iter().filter_map(|place| place.found[unit].as_ref());
    own.for_each(|found| point.add(found.effect.clone()));
    let blocks = blocks_of(problem);
    let own = fit(problem, &point, &blocks, &[], options)?;
    let mut point = own.point.clone();
    let others = effects.iter().filter(|place| place.found[unit].is_none());
    others.for_each(|place| point.add(place.mean()));
    let all = fit(problem, &point, &blocks, &[], options)?;
    let is_least = all.cost <= own.cost + FIT_COST_TOLERANCE;
    is_least.then(|| of_fit(problem, logs, &all, robot)).transpose()
}

/// Units with what their logs measure of what only others have.
struct FleetContext<'a> {
    units: &'a [ImprovedUnit<'a>],
    /// Effects that any of them has.
    places: &'a [FleetPlace],
    beside: &'a [Option<Posterior>],
}

impl FleetContext<'_> {
    /// What a unit's logs measure of a parameter of a place.
    fn value(&self, unit: usize, place: &FleetPlace, parameter: usize) -> Option<UnitValue> {
        let effect = &place.first().effect;
        let ImprovedUnit { problem, posterior, .. } = self.units[unit];
        let own = place.found[unit].is_some() || is_calibration(effect.kind);
        let of = if own { posterior } else { self.beside[unit].as_ref() }?;
        let given = problem.known.iter();
        let given = given.filter(|e| e.place() == effect.place()).count();
        let index = of.numbers.iter().position(|n| {
            n.effect() == effect.place()
                && (n.occurrence, n.parameter) == (given + place.occurrence, parameter)
        })?;
        let (value, variance) = (of.numbers[index].value, of.deviation(index).powi(2));
        // What was expected of a calibration before counts once for a fit, and would count once a unit.
        let prior = effect.kind.calibration.map_or(0.0, |calibration| {
            problem.deviations(effect, calibration.expected)[parameter].powi(-2)
        });
        let weight = 1.0 / variance - prior;
        let known = variance > 0.0 && weight > 0.0;
        known.then(|| UnitValue {
            value: value / variance / weight,
            deviation: (1.0 / weight).sqrt(),
        })
    }

    /// True for an effect that a unit's logs name and do not tell from one that only others name.
    fn is_interchangeable(&self, unit: usize, place: &FleetPlace) -> bool {
        let ImprovedUnit { improvement, .. } = self.units[unit];
        let effect = place.first().effect.place();
        let adds = |step: &&ImprovementStep| step.added.iter().any(|f| f.effect.place() == effect);
        let mut others = improvement.steps.iter().filter(adds).flat_map(|s| improvement.others(s));
        let elsewhere = |place: &FleetPlace| place.found[unit].is_none();
        let places = || self.places.iter().filter(|place| elsewhere(place));
        others.any(|other| places().any(|place| place.first().effect.place() == other.place()))
    }

    /// A place over all units.
    fn effect(&self, place: &FleetPlace) -> FleetEffect {
        let effect = place.first().effect.clone();
        let of_unit = |unit, parameter| self.value(unit, place, parameter);
        let values = |parameter| (0..self.units.len()).map(|k| of_unit(k, parameter)).collect();
        let all: Vec<Vec<Option<UnitValue>>> = (0..effect.values.len()).map(values).collect();
        let kinds = effect.kind.parameters.iter();
        let sizes: Vec<_> = kinds.clone().zip(&all).filter(|(p, _)| p.is_size()).collect();
        let named: Vec<bool> = place.found.iter().map(Option::is_some).collect();
        let presence = |unit: usize| match named[unit] {
            true if self.is_interchangeable(unit, place) => Presence::Unknown,
            true => Presence::Named,
            false if is_calibration(effect.kind) => Presence::Measured,
            false => presence(&sizes, unit, &named),
        };
        let presence: Vec<Presence> = (0..self.units.len()).map(presence).collect();
        let parameters = kinds.zip(all).map(|(kind, units)| over_units(kind, units, &presence));
        let parameters = parameters.collect();
        FleetEffect { effect, presence, parameters }
    }
}

/// Whether a unit whose logs do not name an effect has it, by its sizes: ln of the odds of what is
/// measured if it is what is measured against none, and of none against the nearest of the units that
/// have it.
fn presence(
    sizes: &[(&Parameter, &Vec<Option<UnitValue>>)],
    unit: usize,
    named: &[bool],
) -> Presence {
    let mut presence = Presence::Unknown;
    for (parameter, values) in sizes {
        let Some(own) = values[unit] else { continue };
        let nothing = match parameter.role {
            // 1/value against 0, which its uncertainty is in proportion to.
            Role::Reciprocal { .. } => 0.0,
            _ => parameter.without_effect(own.value),
        };
        let odds = |away: f64, deviation: f64| 0.5 * (away / deviation).powi(2);
        let there = odds(own.value - nothing, own.deviation);
        if there > DECISIVE {
            return Presence::Measured;
        }
        let others = values.iter().zip(named).filter(|(_, named)| **named);
        let others = others.filter_map(|(value, _)| *value);
        let nearest = others.map(|o| odds(own.value - o.value, own.deviation.hypot(o.deviation)));
        if nearest.reduce(f64::min).is_some_and(|nearest| nearest - there > DECISIVE) {
            presence = Presence::Absent;
        }
    }
    presence
}

/// A parameter over all units, of which some have its effect.
fn over_units(
    kind: &Parameter,
    units: Vec<Option<UnitValue>>,
    presence: &[Presence],
) -> FleetParameter {
    let is_comparable = kind.role != Role::Phase;
    let there = |unit: &usize| is_comparable && presence[*unit].is_there();
    let of = |which: &[usize]| which.iter().filter_map(|k| units[*k]).collect::<Vec<_>>();
    let all: Vec<usize> = (0..units.len()).collect();
    let having: Vec<usize> = all.iter().copied().filter(there).collect();
    let fleet = RandomEffects::of(&of(&having));
    // A size of nothing is one; a shape of nothing is none.
    let judged = if is_comparable && kind.is_size() { all } else { having };
    let known: Vec<usize> = judged.into_iter().filter(|k| units[*k].is_some()).collect();
    let values = of(&known);
    let left_out = |unit: usize| {
        let place = known.iter().position(|k| *k == unit)?;
        LeftOutUnit::of(&values, place)
    };
    let left_out = (0..units.len()).map(left_out).collect();
    FleetParameter { units, fleet, left_out }
}
