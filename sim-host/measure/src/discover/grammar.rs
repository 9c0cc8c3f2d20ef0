//! Formulas that may stand for a free curve: sums of parts of a small grammar, each part with a size
//! of its own, over shapes that they share.

use super::context::Context;
use super::curve::{Candidate, FittedCurve};
use super::hypotheses::{Hypothesis, replaced};
use crate::diagnose::rules;
use crate::fit::{self, Effort, Fitted, Linear};
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use trueweld_plant::effects::Effect;
use trueweld_plant::effects::expression::Expression;
use trueweld_plant::effects::formula::{CustomParameter, CustomRole, Definition};

/// What a shape is, and so where it is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    /// A place along the variable.
    Place,
    /// A width, in the variable's unit.
    Width,
    /// Radians of a sine per unit of the variable.
    Order,
    /// An exponent.
    Power,
    /// The way over which a loop turns round, in that of the screened one.
    Turning,
}

/// A formula over `u`.
#[derive(Debug)]
struct Form {
    /// Name of the size of each part, the power of the variable's unit in it, and the part.
    parts: &'static [(&'static str, i8, &'static str)],
    shapes: &'static [(&'static str, Shape)],
    /// Of a loop, how its part is written: the part itself is over what is remembered, the width of
    /// the loop its unit.
    written: Option<&'static str>,
}

const fn form(
    parts: &'static [(&'static str, i8, &'static str)],
    shapes: &'static [(&'static str, Shape)],
) -> Form {
    Form { parts, shapes, written: None }
}

const CENTRE: (&str, Shape) = ("centre", Shape::Place);
const EDGE: (&str, Shape) = ("edge", Shape::Place);
const WIDTH: (&str, Shape) = ("width", Shape::Width);

/// The grammar.
static FORMS: &[Form] = &[
    form(&[("level", 0, "1")], &[]),
    form(&[("slope", 1, "u")], &[]),
    form(&[("level", 0, "1"), ("slope", 1, "u")], &[]),
    form(&[("square", 2, "u^2")], &[]),
    form(&[("slope", 1, "u"), ("square", 2, "u^2")], &[]),
    form(&[("level", 0, "1"), ("slope", 1, "u"), ("square", 2, "u^2")], &[]),
    form(&[("cube", 3, "u^3")], &[]),
    form(&[("slope", 1, "u"), ("cube", 3, "u^3")], &[]),
    form(&[("level", 0, "1"), ("slope", 1, "u"), ("square", 2, "u^2"), ("cube", 3, "u^3")], &[]),
    form(&[("square", 2, "u*abs(u)")], &[]),
    form(&[("slope", 1, "u"), ("square", 2, "u*abs(u)")], &[]),
    form(&[("height", 0, "sign(u - centre)")], &[CENTRE]),
    form(&[("height", 0, "step(u - edge)")], &[EDGE]),
    form(&[("level", 0, "1"), ("height", 0, "step(u - edge)")], &[EDGE]),
    form(&[("slope", 1, "abs(u - centre)")], &[CENTRE]),
    form(&[("level", 0, "1"), ("slope", 1, "abs(u - centre)")], &[CENTRE]),
    form(&[("stiffness", 1, "max(u - edge, 0)")], &[EDGE]),
    form(&[("stiffness", 1, "max(edge - u, 0)")], &[EDGE]),
    form(
        &[("stiffness", 1, "sign(u - centre)*max(abs(u - centre) - slack, 0)")],
        &[CENTRE, ("slack", Shape::Width)],
    ),
    form(
        &[("slope", 1, "max(-limit, min(limit, u - centre))")],
        &[CENTRE, ("limit", Shape::Width)],
    ),
    form(&[("height", 0, "tanh((u - centre)/width)")], &[CENTRE, WIDTH]),
    form(&[("height", 0, "exp(-u/width)")], &[WIDTH]),
    form(&[("height", 0, "1 - exp(-u/width)")], &[WIDTH]),
    form(&[("level", 0, "1"), ("height", 0, "exp(-u/width)")], &[WIDTH]),
    form(&[("height", 0, "exp(-(u/width)^2)")], &[WIDTH]),
    form(&[("height", 0, "exp(-((u - centre)/width)^2)")], &[CENTRE, WIDTH]),
    form(&[("height", 0, "sign(u)*(abs(u)/width)^power")], &[("power", Shape::Power)]),
    form(&[("height", 0, "(abs(u)/width)^power")], &[("power", Shape::Power)]),
    form(&[("slope", 1, "u*exp(-(u/width)^2)")], &[WIDTH]),
    form(&[("sine", 0, "sin(order*u)"), ("cosine", 0, "cos(order*u)")], &[("order", Shape::Order)]),
    form(
        &[("level", 0, "1"), ("sine", 0, "sin(order*u)"), ("cosine", 0, "cos(order*u)")],
        &[("order", Shape::Order)],
    ),
];

const TURNS_OVER: (&str, Shape) = ("width", Shape::Turning);

/// The grammar of loops.
static LOOPS: &[Form] = &[
    Form { written: Some("dahl(u, width)"), ..form(&[("height", 0, "u")], &[TURNS_OVER]) },
    Form {
        written: Some("(u - play(u, slack))"),
        ..form(&[("stiffness", 1, "slack*u")], &[("slack", Shape::Turning)])
    },
];

/// Formulas that may stand for a curve, or for a loop.
fn forms(hypothesis: &Hypothesis) -> &'static [Form] {
    if hypothesis.turns_over.is_some() { LOOPS } else { FORMS }
}

/// Shapes that are tried: so many of one, and so many of each of two.
const OF_ONE: usize = 60;
const OF_TWO: usize = 28;

/// Exponents that are looked for.
const POWERS: [f64; 2] = [0.2, 4.0];

/// Formulas of a curve that is screened that are judged by blocks left out: so many of the shortest, and
/// so many of those that fit best.
const SCREENED: usize = 3;

/// Formulas fitted through the plant.
const FITTED: usize = 4;

/// Steps of such a fit.
const STEPS: usize = 25;

/// A formula in the place of a curve.
#[derive(Debug, Clone)]
pub(super) struct Law {
    form: &'static Form,
    pub expression: String,
    pub fitted: Fitted,
}

/// What a curve costs as the normal equations have it, by its values at its places, all else at its
/// best: (y − y₀)ᵀ H (y − y₀) + 2 hᵀ (y − y₀).
struct Cost {
    curvature: DMatrix<f64>,
    slope: DVector<f64>,
    at: DVector<f64>,
    places: Vec<f64>,
    forms: &'static [Form],
}

impl Cost {
    fn of(curve: &FittedCurve) -> Option<Self> {
        let linear = &curve.fitted.linear;
        let at = DVector::from_column_slice(curve.values());
        Self::new(linear, &curve.places, &curve.candidate, at)
    }

    /// `linear`: the values of the curve come last in it, in units of the candidate's step; `at`:
    /// where they are.
    fn new(
        linear: &Linear,
        places: &[f64],
        candidate: &Candidate,
        at: DVector<f64>,
    ) -> Option<Self> {
        let step = candidate.step;
        let all = linear.away.len();
        let (others, of_curve): (Vec<usize>, Vec<usize>) =
            (0..all).partition(|k| k + places.len() < all);
        // What is expected of how the curve bends is not what the data say.
        let mut prior = linear.prior.clone();
        for k in &of_curve {
            prior.row_mut(*k).fill(0.0);
            prior.column_mut(*k).fill(0.0);
        }
        let square = linear.square.iter().fold(prior.clone(), |sum, block| sum + block);
        let slope = linear.slope.iter().fold(&prior * &linear.away, |sum, block| sum + block);
        let part =
            |rows: &[usize], columns: &[usize]| square.select_rows(rows).select_columns(columns);
        let (own_square, own_slope) = (part(&of_curve, &of_curve), slope.select_rows(&of_curve));
        let (curvature, slope) = match fit::Factor::new(&part(&others, &others), 0.0) {
            _ if others.is_empty() => (own_square, own_slope),
            Some(factor) => {
                let cross = part(&others, &of_curve);
                (
                    own_square - cross.tr_mul(&factor.solve(&cross)),
                    own_slope - cross.tr_mul(&factor.solve(&slope.select_rows(&others))),
                )
            }
            None => return None,
        };
        Some(Self {
            curvature: curvature / (step * step),
            slope: slope / step,
            at,
            places: places.to_vec(),
            forms: forms(&candidate.hypothesis),
        })
    }

    /// The best sizes of some parts, by their values at the places, and the cost there.
    fn least(&self, parts: &DMatrix<f64>) -> Option<(DVector<f64>, f64)> {
        let weighed = &self.curvature * parts;
        let right = weighed.tr_mul(&self.at) - parts.tr_mul(&self.slope);
        let sizes = fit::Factor::new(&parts.tr_mul(&weighed), 0.0)?.solve(&right);
        let off = parts * &sizes - &self.at;
        let cost = (&self.curvature * &off).dot(&off) + 2.0 * self.slope.dot(&off);
        cost.is_finite().then_some((sizes, cost))
    }
}

/// A formula with values.
#[derive(Debug, Clone)]
pub(super) struct Found {
    form: &'static Form,
    sizes: Vec<f64>,
    shapes: Vec<f64>,
    /// Cost, as the normal equations have it.
    cost: f64,
    /// The same with the length of its description.
    length: f64,
}

/// Values of a shape that are tried.
fn starts(shape: Shape, places: &[f64], count: usize) -> Vec<f64> {
    let [low, high] = range(shape, places);
    let share = |k: usize| (k as f64 + 0.5) / count as f64;
    let at = |k: usize| match shape {
        Shape::Place => low + (high - low) * share(k),
        Shape::Width | Shape::Order | Shape::Power => low * (high / low).powf(share(k)),
        Shape::Turning => 1.0,
    };
    // What is remembered was screened for one way.
    let count = if shape == Shape::Turning { 1 } else { count };
    (0..count).map(at).collect()
}

/// Where a shape is plausible.
fn range(shape: Shape, places: &[f64]) -> [f64; 2] {
    let (first, last) = (places[0], places[places.len() - 1]);
    let wide = last - first;
    match shape {
        Shape::Place => [first, last],
        Shape::Width => [0.02 * wide, 3.0 * wide],
        // A wave needs three places at least.
        Shape::Order => [1.0 / wide, std::f64::consts::TAU * places.len() as f64 / (3.0 * wide)],
        Shape::Power => POWERS,
        Shape::Turning => [0.1, 10.0],
    }
}

/// The parts of a form, ready to be evaluated over `u` and its shapes. A power is taken of the
/// variable over its range.
fn parsed(form: &Form, wide: f64) -> Option<Vec<Expression>> {
    let shapes: Vec<&str> = form.shapes.iter().map(|s| s.0).collect();
    let parse = |part: &str| Expression::parse(&scaled(form, part, wide), &["u"], &shapes).ok();
    form.parts.iter().map(|(_, _, part)| parse(part)).collect()
}

/// A part in which a width that is no shape is that of the variable's range.
fn scaled(form: &Form, part: &str, wide: f64) -> String {
    match form.shapes.iter().any(|s| s.0 == "width") {
        true => part.to_owned(),
        false => part.replace("width", &format!("{wide:?}")),
    }
}

/// A width of so many as two digits say.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// Values of parts at some places; `None` where they are none.
fn values(parts: &[Expression], places: &[f64], shapes: &[f64]) -> Option<DMatrix<f64>> {
    let value = |row: usize, part: usize| parts[part].eval(&[places[row]], shapes);
    let values = DMatrix::from_fn(places.len(), parts.len(), value);
    values.iter().all(|v| v.is_finite()).then_some(values)
}

/// Formulas in the place of a curve that are as short as any, the shortest first.
fn shortest(cost: &Cost, trust: f64, count: usize) -> Vec<Found> {
    let mut found: Vec<Found> =
        cost.forms.par_iter().filter_map(|form| find(form, cost, trust, count)).collect();
    found.sort_by(|a, b| a.length.total_cmp(&b.length));
    found
}

/// The formula in the place of a curve that predicts blocks best that were left out, among the shortest,
/// as far as slopes tell, and their sum of squares. `linear`: nothing is known of the curve's values,
/// which come last, in units of the candidate's step; `count`: number of residuals.
pub(super) fn screened(
    linear: &Linear,
    places: &[f64],
    candidate: &Candidate,
    count: usize,
) -> Option<(f64, Found)> {
    let cost = Cost::new(linear, places, candidate, DVector::zeros(places.len()))?;
    let wide = rounded(places[places.len() - 1] - places[0]);
    let mut found = shortest(&cost, rules::CORRELATED, count);
    // The shortest, and of the others those that fit best.
    let from = SCREENED.min(found.len());
    found[from..].sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let judged = found.into_iter().take(2 * SCREENED).filter_map(|found| {
        let parts = values(&parsed(found.form, wide)?, places, &found.shapes)?;
        let held_out: f64 =
            linear.with_parts(&(parts / candidate.step)).held_out(None).iter().sum();
        held_out.is_finite().then_some((held_out, found))
    });
    judged.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn find(form: &'static Form, cost: &Cost, trust: f64, count: usize) -> Option<Found> {
    let wide = rounded(cost.places[cost.places.len() - 1] - cost.places[0]);
    let parts = parsed(form, wide)?;
    let judge = |shapes: &[f64]| cost.least(&values(&parts, &cost.places, shapes)?);
    let grid: Vec<Vec<f64>> = match form.shapes {
        [] => vec![Vec::new()],
        [one] => starts(one.1, &cost.places, OF_ONE).into_iter().map(|v| vec![v]).collect(),
        [one, two, ..] => {
            let second = starts(two.1, &cost.places, OF_TWO);
            let first = starts(one.1, &cost.places, OF_TWO);
            first.iter().flat_map(|a| second.iter().map(|b| vec![*a, *b])).collect()
        }
    };
    let tried = grid.into_iter().filter_map(|shapes| {
        let (sizes, cost) = judge(&shapes)?;
        Some((cost, sizes, shapes))
    });
    let (least, sizes, shapes) = tried.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let sizes: Vec<f64> = sizes.iter().copied().collect();
    if sizes.iter().any(|size| *size == 0.0 || !size.is_finite()) {
        return None;
    }
    let length = least / trust + length(form, count);
    Some(Found { form, sizes, shapes, cost: least, length })
}

/// What a form costs to be written down: half a logarithm of the number of residuals for each
/// number, twice, as sums of squares are twice a logarithm; and its symbols.
fn length(form: &Form, count: usize) -> f64 {
    let symbols: usize =
        form.parts.iter().map(|p| p.2.split(|c: char| !c.is_alphanumeric()).count()).sum();
    let numbers = form.parts.len() + form.shapes.len();
    numbers as f64 * (count.max(2) as f64).ln() + SYMBOL * symbols as f64
}

/// What a symbol of a formula costs: twice the logarithm of some ten that may stand there.
const SYMBOL: f64 = 4.6;

/// The best formula in a curve's place, fitted through the plant; `None` where none is as good on
/// blocks left out. `first`: one that was fitted before.
pub(super) fn law(context: &Context<'_>, curve: &FittedCurve, first: Option<&Law>) -> Option<Law> {
    let cost = Cost::of(curve)?;
    let count = fit::count(&curve.fitted.at);
    let trust = rules::trust(&curve.fitted);
    let mut found = shortest(&cost, trust, count);
    found.truncate(FITTED);
    let least = first.map_or(curve.held_out(), |first| first.held_out().min(curve.held_out()));
    let best = least + rules::TIED * trust;
    let fits: Vec<Law> = found
        .into_par_iter()
        .filter(|_| !context.bench.is_late())
        .filter_map(|found| fitted(context, curve, &found))
        .collect();
    let length = |law: &Law| law.held_out() / trust + length(law.form, count);
    let fits = fits.into_iter().chain(first.cloned()).filter(|law| law.held_out() <= best);
    fits.min_by(|a, b| length(a).total_cmp(&length(b)))
}

impl Law {
    /// Sum of squares of blocks that were left out.
    pub fn held_out(&self) -> f64 {
        self.fitted.linear.held_out(None).iter().sum()
    }

    /// The way over which it turns round, where it is a Dahl loop.
    pub fn turns_over(&self) -> Option<f64> {
        let of = self.form.shapes.iter().position(|s| *s == TURNS_OVER)?;
        self.effect()?.values.get(self.form.parts.len() + of).copied()
    }

    /// The effect that the law is.
    pub fn effect(&self) -> Option<&Effect> {
        self.fitted.point.all.last()
    }

    /// A law of the same form in another curve's place.
    pub fn elsewhere(&self, context: &Context<'_>, curve: &FittedCurve) -> Option<Self> {
        let loops = curve.candidate.hypothesis.turns_over.is_some();
        if loops != self.form.written.is_some() {
            return None;
        }
        let trust = rules::CORRELATED;
        let found = find(self.form, &Cost::of(curve)?, trust, fit::count(&curve.fitted.at))?;
        fitted(context, curve, &found)
    }
}

/// A formula fitted through the plant, calibrations with it.
pub(super) fn fitted(context: &Context<'_>, curve: &FittedCurve, found: &Found) -> Option<Law> {
    let Context { bench, blocks, null, .. } = *context;
    let hypothesis = &curve.candidate.hypothesis;
    let (definition, values) = definition(context.id, hypothesis, found, &curve.places);
    let expression = definition.expression.clone();
    let kind = definition.kind(&values).ok()?;
    let mut point = curve.fitted.point.without(curve.fitted.point.all.len() - 1);
    point.add(Effect { kind, at: hypothesis.at, values });
    let known = &curve.fitted.slopes[..null.slopes.len()];
    let fitted = fit::fit(bench, &point, blocks, known, Effort::steps(STEPS, known.len())).ok()?;
    Some(Law { form: found.form, expression, fitted })
}

/// A formula as an effect of the user's own. A part that stands alone has its sign before it.
fn definition(
    id: &str,
    hypothesis: &Hypothesis,
    found: &Found,
    places: &[f64],
) -> (Definition, Vec<f64>) {
    let form = found.form;
    let wide = rounded(places[places.len() - 1] - places[0]);
    let negative = form.parts.len() == 1 && found.sizes[0] < 0.0;
    let sizes: Vec<f64> = found.sizes.iter().map(|s| if negative { -s } else { *s }).collect();
    let written = |part: &str| form.written.map_or_else(|| scaled(form, part, wide), str::to_owned);
    let of = |(size, _, part): &(&str, i8, &str)| match written(part).as_str() {
        "1" => (*size).to_owned(),
        // A sum stands in parentheses.
        part if part.starts_with("1 - ") => format!("{size}*({part})"),
        part => format!("{size}*{part}"),
    };
    let sum = form.parts.iter().map(of).collect::<Vec<_>>().join(" + ");
    let over = hypothesis.over;
    let sum = replaced(&sum, "u", over).replace(&format!("abs({over})"), &size_of(over));
    let sum =
        if form.parts.len() > 1 && hypothesis.times != "1" { format!("({sum})") } else { sum };
    let sign = if negative { "-" } else { "" };
    let (x_unit, y_unit) = (hypothesis.x_unit(), hypothesis.y_unit());
    // What a loop's numbers are in units of.
    let turns_over = hypothesis.turns_over.unwrap_or(1.0);
    let in_unit = |size: f64, power: i8| size / turns_over.powi(power.into());
    let powers = form.parts.iter().map(|part| part.1);
    let sizes: Vec<f64> = sizes.into_iter().zip(powers).map(|(s, p)| in_unit(s, p)).collect();
    let mut parameters = Vec::new();
    for ((name, power, _), size) in form.parts.iter().zip(&sizes) {
        let unit = match power {
            0 => y_unit.clone(),
            1 => format!("{y_unit}/{x_unit}"),
            power => format!("{y_unit}/({x_unit})^{power}"),
        };
        let far = LARGER * size.abs();
        parameters.push(CustomParameter {
            name: (*name).to_owned(),
            unit,
            meaning: (*name).to_owned(),
            role: CustomRole::Size(0.1 * size.abs()),
            low: -far,
            high: far,
        });
    }
    let mut shapes = Vec::new();
    for ((name, shape), value) in form.shapes.iter().zip(&found.shapes) {
        let unit_of_it = if *shape == Shape::Turning { turns_over } else { 1.0 };
        let value = value * unit_of_it;
        let [low, high] = range(*shape, places).map(|end| end * unit_of_it);
        let (unit, role) = match shape {
            Shape::Place => {
                let step = 0.01 * (high - low);
                (x_unit.to_owned(), CustomRole::Position(step, vec![value]))
            }
            Shape::Width | Shape::Turning => (x_unit.to_owned(), CustomRole::Shape(vec![value])),
            Shape::Order => (format!("rad/({x_unit})"), CustomRole::Shape(vec![value])),
            Shape::Power => ("1".to_owned(), CustomRole::Shape(vec![value])),
        };
        let name = (*name).to_owned();
        shapes.push(value);
        let (low, high) = (low.min(value), high.max(value));
        parameters.push(CustomParameter { meaning: name.clone(), name, unit, role, low, high });
    }
    let values = sizes.into_iter().chain(shapes).collect();
    let definition = Definition {
        id: id.to_owned(),
        port: hypothesis.port,
        expression: format!("{sign}{}", hypothesis.expression(&sum)),
        shows: hypothesis.port.meaning.to_owned(),
        parameters,
        table: None,
    };
    (definition, values)
}

/// The size of a variable: of what is one already, itself.
fn size_of(over: &str) -> String {
    if over.starts_with("abs(") { over.to_owned() } else { format!("abs({over})") }
}

/// How many times as large a size may be as the curve shows it.
const LARGER: f64 = 50.0;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_an_expression_of_its_shapes() {
        for form in FORMS {
            let parts = parsed(form, 2.0).expect("parts that can be read");
            let shapes = vec![0.5; form.shapes.len()];
            assert!(parts.iter().all(|p| p.eval(&[0.3], &shapes).is_finite()), "{:?}", form.parts);
        }
    }
}
