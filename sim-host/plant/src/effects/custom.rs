//! Effects of the user's own: an expression at a named port, stated in a model file.
//!
//! A definition becomes a [`EffectKind`] like those of the library, so that whatever simulates,
//! fits or explains effects takes it as one of them. Such a kind lives as long as the program; the
//! same definition gives the same one.

use super::curve::{Curve, ShownQuantity};
use super::expression::ExpressionMistake;
use super::formula::{CustomParameter, CustomRole, Definition, Formula};
use super::kind::{Action, EffectKind};
use super::location::LocationKind;
use super::parameter::{Parameter, Role};
use std::sync::{Mutex, PoisonError};

static REGISTRY: Mutex<Vec<(&'static Formula, &'static EffectKind)>> = Mutex::new(Vec::new());

impl Definition {
    /// The kind of this definition: the same one every time, made and kept for good at the first.
    ///
    /// `values` are those it is first used with, in the order of its parameters. There, and with
    /// each parameter in turn at its `low` and `high`, the expression must be finite wherever the
    /// port's variables may well be.
    ///
    /// # Errors
    /// [`ExpressionMistake`] in the expression: its text, a parameter it does not use, or a place
    /// where it is not finite.
    pub fn kind(self, values: &[f64]) -> Result<&'static EffectKind, ExpressionMistake> {
        let expression = self.checked(values)?;
        let mut registry = REGISTRY.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, kind)) = registry.iter().find(|(formula, _)| formula.definition == self) {
            return Ok(kind);
        }
        let formula: &'static Formula = Box::leak(Box::new(Formula::new(self, expression)));
        let own = &formula.definition;
        let kind: &'static EffectKind = Box::leak(Box::new(EffectKind {
            id: &own.id,
            place: own.port.place(),
            equation: Box::leak(
                format!("{} gains {}", own.port.name, own.expression).into_boxed_str(),
            ),
            shows: &own.shows,
            experiment: "an effect of the user's own: whatever moves the variables of its expression",
            parameters: own.parameters.iter().map(lasting).collect::<Vec<_>>().leak(),
            action: Action::Expression(formula),
            curve: curve(own),
            ..EffectKind::DEFAULT
        }));
        registry.push((formula, kind));
        Ok(kind)
    }
}

/// The value at its port, over whatever it follows.
fn curve(own: &'static Definition) -> Curve {
    let name: &'static str = match own.port.place() {
        LocationKind::Joint => {
            Box::leak(format!("{} ({{joint}})", own.port.meaning).into_boxed_str())
        }
        _ => own.port.meaning,
    };
    Curve::Quantity(Box::leak(Box::new([ShownQuantity::port(own.port.name, name)])), &[])
}

/// A parameter that lives as long as the program.
fn lasting(own: &'static CustomParameter) -> Parameter {
    let role = match &own.role {
        CustomRole::Size(step) => Role::Size { step: *step, neutral: 0.0 },
        CustomRole::Shape(starts) => Role::Shape(starts),
        CustomRole::Position(step, starts) => Role::Position { step: *step, starts },
    };
    Parameter {
        name: &own.name,
        unit: &own.unit,
        meaning: &own.meaning,
        role,
        low: own.low,
        high: own.high,
    }
}
