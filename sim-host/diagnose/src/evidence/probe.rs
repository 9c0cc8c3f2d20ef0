//! What residuals are projected on: a constant at a port of the plant, a value of the effect
//! itself, or one column.

use super::context::{EvidenceContext, Ordinate};
use trueweld_estimate::fit::{EffectScope, FreeParameter, Slopes, slopes, unit};
use trueweld_estimate::predict::{Compared, ComparedQuantity, PreparedLog};
use trueweld_plant::effects::formula::{CustomParameter, CustomRole, Definition, PORTS};
use trueweld_plant::effects::{Effect, EffectKind, Location};

/// A quantity that the data can be asked for.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Probe {
    /// A constant at ports of the plant, by the ports' names in model files.
    Port {
        /// Each port with what the constant is multiplied by there, an expression over the port's
        /// variables.
        terms: Vec<(&'static str, &'static str)>,
        at: Location,
        /// Unit of the constant.
        unit: &'static str,
        /// −1 where the quantity shown is that much less.
        sign: f64,
        shown: Ordinate,
    },
    /// The effect's own parameter of that index: which value the data ask for.
    Own { parameter: usize, shown: Ordinate },
    /// Nothing but what one channel reads more than is predicted.
    Column { quantity: ComparedQuantity, component: u8, shown: Ordinate },
}

/// Size at which the slope by a constant is taken, by unit: small against what any plant does,
/// large against rounding.
fn step(unit: &str) -> f64 {
    match unit {
        "rad" => 5e-5,
        "m" => 1e-4,
        "1" => 1e-2,
        _ => 50.0,
    }
}

/// A constant at a port, as an effect of the user's own.
pub(crate) fn constant(port: &'static str, times: &str, unit: &str) -> Option<&'static EffectKind> {
    let port = PORTS.iter().find(|p| p.name == port)?;
    let size = step(unit);
    let parameter = CustomParameter {
        name: "constant".to_owned(),
        unit: unit.to_owned(),
        meaning: port.meaning.to_owned(),
        role: CustomRole::Size(size),
        low: -1e3 * size,
        high: 1e3 * size,
    };
    let definition = Definition {
        id: format!("constant-{}", port.name),
        port,
        expression: format!("constant*({times})"),
        shows: port.meaning.to_owned(),
        parameters: vec![parameter],
        table: None,
    };
    definition.kind(&[0.0]).ok()
}

fn added(a: Option<Vec<f64>>, b: Option<Vec<f64>>) -> Option<Vec<f64>> {
    match (a, b) {
        (Some(mut a), Some(b)) => {
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
            Some(a)
        }
        (a, b) => a.or(b),
    }
}

/// Slopes by one of several quantities, cleared row by row of what the others could do as well:
/// what one component of a force does to the tool, another does too.
pub(super) fn apart(
    ctx: &EvidenceContext<'_>,
    all: &[Option<Slopes>],
    which: usize,
) -> Option<Slopes> {
    let mut own = all[which].clone()?;
    let others: Vec<&Slopes> = all
        .iter()
        .enumerate()
        .filter(|(k, _)| *k != which)
        .filter_map(|(_, s)| s.as_ref())
        .collect();
    for (log, experiment) in ctx.problem.logs.iter().enumerate() {
        let Some(own) = own[log].as_mut() else {
            continue;
        };
        let rows = 1 + experiment.compared.iter().map(|c| c.row).max().unwrap_or(0);
        let mut done: Vec<Vec<f64>> = Vec::new();
        for other in others.iter().filter_map(|s| s[log].as_ref()) {
            let mut other = other.clone();
            done.iter().for_each(|d| clear(&mut other, d, experiment, rows));
            clear(own, &other, experiment, rows);
            done.push(other);
        }
    }
    Some(own)
}

/// Takes out of `s`, row by row, its part along `of`.
fn clear(s: &mut [f64], of: &[f64], experiment: &PreparedLog, rows: usize) {
    let mut sums = vec![[0.0; 2]; rows];
    for (k, c) in experiment.compared.iter().enumerate() {
        sums[c.row][0] += s[k] * of[k];
        sums[c.row][1] += of[k] * of[k];
    }
    for (k, c) in experiment.compared.iter().enumerate() {
        let [product, square] = sums[c.row];
        if square > 0.0 {
            s[k] -= of[k] * product / square;
        }
    }
}

impl Probe {
    /// Slopes of all residuals by the quantity, in its unit; `None` where no log shows it.
    pub(crate) fn slopes(&self, ctx: &EvidenceContext<'_>) -> Option<Slopes> {
        let (mut slopes, size): (Slopes, f64) = match self {
            Self::Port { terms, at, unit: of, .. } => {
                let mut sum: Option<Slopes> = None;
                for (port, times) in terms {
                    let kind = constant(port, times, of)?;
                    // Without the effect, so that nothing of its form is assumed.
                    let mut point = ctx.bare.clone();
                    let of = EffectScope::Shared(point.shared.len());
                    point.shared.push(Effect { kind, at: *at, values: vec![0.0] });
                    let free = FreeParameter { of, parameter: 0, expected: f64::INFINITY };
                    let new = slopes(ctx.problem, &point, &[free], ctx.without, 1.0).pop()?;
                    sum = Some(match sum {
                        Some(sum) => sum.into_iter().zip(new).map(|(a, b)| added(a, b)).collect(),
                        None => new,
                    });
                }
                (sum?, step(of))
            }
            Self::Own { parameter, .. } => {
                let point = &ctx.found.point;
                let is = |f: &FreeParameter| f.of == ctx.of && f.parameter == *parameter;
                let k = point.free.iter().position(is)?;
                let value = point.value(&point.free[k]);
                (ctx.found.slopes.get(k)?.clone(), unit(point.parameter(&point.free[k]), value))
            }
            Self::Column { quantity, component, .. } => {
                let is_own = |c: &Compared| c.quantity == *quantity && c.component == *component;
                let slope = |c: &Compared| if is_own(c) { -1.0 / c.deviation } else { 0.0 };
                let of_column = |e: &PreparedLog| {
                    e.compared.iter().any(is_own).then(|| e.compared.iter().map(slope).collect())
                };
                (ctx.problem.logs.iter().map(of_column).collect(), 1.0)
            }
        };
        slopes.iter_mut().flatten().flatten().for_each(|s| *s /= size);
        let seen: f64 = slopes.iter().flatten().flatten().map(|s| s * s).sum();
        (seen.is_finite() && seen > 0.0).then_some(slopes)
    }

    /// The value of the effect that is asked for, as it was fitted.
    pub(crate) fn value(&self, ctx: &EvidenceContext<'_>) -> Option<f64> {
        let Self::Own { parameter, .. } = self else {
            return None;
        };
        ctx.found.point.effect(ctx.of).values.get(*parameter).copied()
    }

    pub(crate) fn sign(&self) -> f64 {
        if let Self::Port { sign, .. } = self { *sign } else { 1.0 }
    }

    /// What is shown of it.
    pub(crate) fn shown(&self) -> Ordinate {
        match self {
            Self::Port { shown, .. } | Self::Own { shown, .. } | Self::Column { shown, .. } => {
                *shown
            }
        }
    }

    pub(crate) fn y_unit(&self, ctx: &EvidenceContext<'_>) -> &'static str {
        match self {
            Self::Port { unit, .. } => unit,
            Self::Own { parameter, .. } => ctx
                .found
                .point
                .effect(ctx.of)
                .kind
                .parameters
                .get(*parameter)
                .map_or("", |p| p.unit),
            Self::Column { quantity, .. } => quantity.unit(),
        }
    }
}
