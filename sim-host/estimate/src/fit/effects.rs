//! Effects of a model by what a fit makes of them: known, of each log's own, or a hypothesis; and which
//! are calibrations.

use trueweld_plant::effects::{Action, Effect, EffectKind, Parameter};
use trueweld_plant::input::{KnownEffect, ModelEffect, Posterior, Scope};

/// An effect of a model whose values every log has of its own. A calibration stands among the known
/// effects as the model states it, and each log has what it is off from there.
#[derive(Debug, Clone)]
pub struct PerLogEffect {
    /// As the model states it.
    pub stated: Effect,
    /// How far a log's value is expected from that, one standard deviation in the value's unit;
    /// infinite for what is no calibration.
    pub expected: Vec<f64>,
}

impl PerLogEffect {
    fn new(stated: Effect, declared: &[KnownEffect], posterior: Option<&Posterior>) -> Self {
        if let Some(known) = KnownEffect::of(declared, stated.kind, stated.at) {
            return Self { expected: known.deviation.clone(), stated };
        }
        let mut expected = expected(stated.kind);
        // What the logs of the model were off by from one another, where that is more.
        for number in posterior.iter().flat_map(|posterior| &posterior.numbers) {
            if number.effect() == stated.place() {
                let expected = &mut expected[number.parameter];
                *expected = expected.max(number.between_logs);
            }
        }
        Self { stated, expected }
    }

    /// Where a fit of a log's own starts.
    pub fn start(&self) -> Effect {
        if is_calibration(self.stated.kind) {
            self.stated.kind.neutral(self.stated.at)
        } else {
            self.stated.clone()
        }
    }

    /// All of what a log has, of which `own` was fitted to it.
    pub fn whole(&self, own: &Effect) -> Effect {
        let start = self.start().values;
        let values = self.stated.values.iter().zip(start).zip(&own.values);
        let values = values.map(|((stated, start), own)| stated + (own - start)).collect();
        Effect { values, ..self.stated.clone() }
    }

    /// True for an effect of this kind at this place.
    pub fn is(&self, other: &Effect) -> bool {
        self.stated.place() == other.place()
    }
}

/// Effects of a model by what a fit makes of them.
#[derive(Debug, Clone, Default)]
pub struct SortedEffects {
    /// Those that are not fitted.
    pub known: Vec<Effect>,
    /// Those whose values every log has of its own.
    pub per_log: Vec<PerLogEffect>,
    /// Those of the user's own that are hypotheses: all their sizes stand where there is no effect.
    pub own: Vec<Effect>,
}

impl SortedEffects {
    /// Sorts effects; `declared` and `posterior`: of the model that they are of.
    pub fn new(
        effects: &[ModelEffect],
        declared: &[KnownEffect],
        posterior: Option<&Posterior>,
    ) -> Self {
        let mut sorted = Self::default();
        for ModelEffect { effect, scope } in effects {
            match scope {
                Scope::Log => {
                    if is_calibration(effect.kind) {
                        sorted.known.push(effect.clone());
                    }
                    sorted.per_log.push(PerLogEffect::new(effect.clone(), declared, posterior));
                }
                Scope::Campaign if is_own_and_nothing(effect) => sorted.own.push(effect.clone()),
                Scope::Campaign => sorted.known.push(effect.clone()),
            }
        }
        sorted
    }
}

/// True for an effect that is a calibration of what the model has.
pub fn is_calibration(kind: &EffectKind) -> bool {
    kind.calibration.is_some()
}

/// Expected size of each of an effect's values, one standard deviation: infinite for what is no
/// calibration.
pub fn expected(kind: &EffectKind) -> Vec<f64> {
    kind.calibration.map_or(vec![f64::INFINITY; kind.parameters.len()], |c| c.expected.to_vec())
}

/// True for an effect of the user's own that does nothing with its values.
pub fn is_own_and_nothing(effect: &Effect) -> bool {
    let nothing = |(p, v): (&Parameter, &f64)| *v == p.without_effect(*v);
    matches!(effect.kind.action, Action::Expression(_))
        && effect.kind.parameters.iter().zip(&effect.values).all(nothing)
}
