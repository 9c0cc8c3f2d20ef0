//! Formulas that may stand for a free curve: sums of parts of a small grammar, each part with a size
//! of its own, over shapes that they share.

use super::context::DiscoveryContext;
use super::curve::{CurveCandidate, FittedCurve, SPRING};
use super::hypotheses::{self, Hypothesis, replaced};
use crate::rules;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use std::f64::consts::{LN_10, PI, TAU};
use trueweld_estimate::fit::{self, Fitted, Quadratic, ReducedNormal, SolverOptions};
use trueweld_plant::effects::Effect;
use trueweld_plant::effects::expression::Expression;
use trueweld_plant::effects::formula::{CustomParameter, CustomRole, Definition};
use trueweld_plant::effects::table::Places;

/// What a shape is, and so where it is looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum ParameterShape {
    /// A place along the variable.
    Place,
    /// A width, in the variable's unit.
    Width,
    /// Radians of a sine per unit of the variable.
    Order,
    /// An exponent.
    Power,
    /// The way over which a loop turns round: that of the screened one.
    Turning,
}

impl ParameterShape {
    /// How many values of it are told apart: as many places as the curve has, orders by half a turn over
    /// the range, scales by a factor e.
    fn told_apart(self, places: &[f64], turns_over: Option<f64>) -> f64 {
        let [low, high] = range(self, places, turns_over);
        match self {
            Self::Place => places.len() as f64,
            Self::Order => 1.0 + high * (places[places.len() - 1] - places[0]) / PI,
            Self::Width | Self::Power | Self::Turning => 1.0 + (high / low).ln(),
        }
    }
}

/// A part of a formula over `u`, of a surface over `u` and `v`.
#[derive(Debug)]
struct FormulaPart {
    /// Name of its size.
    size: &'static str,
    /// Powers of the variables' units in it.
    powers: [i8; 2],
    of: &'static str,
}

const fn part(size: &'static str, power: i8, of: &'static str) -> FormulaPart {
    part_of_two(size, [power, 0], of)
}

const fn part_of_two(size: &'static str, powers: [i8; 2], of: &'static str) -> FormulaPart {
    FormulaPart { size, powers, of }
}

/// A formula.
#[derive(Debug)]
struct FormulaForm {
    parts: &'static [FormulaPart],
    shapes: &'static [(&'static str, ParameterShape)],
}

const fn form(
    parts: &'static [FormulaPart],
    shapes: &'static [(&'static str, ParameterShape)],
) -> FormulaForm {
    FormulaForm { parts, shapes }
}

const CENTRE_SHAPE: (&str, ParameterShape) = ("centre", ParameterShape::Place);
const EDGE_SHAPE: (&str, ParameterShape) = ("edge", ParameterShape::Place);
const WIDTH_SHAPE: (&str, ParameterShape) = ("width", ParameterShape::Width);

/// The grammar.
static CURVE_FORMS: &[FormulaForm] = &[
    form(&[part("level", 0, "1")], &[]),
    form(&[part("slope", 1, "u")], &[]),
    form(&[part("level", 0, "1"), part("slope", 1, "u")], &[]),
    form(&[part("square", 2, "u^2")], &[]),
    form(&[part("slope", 1, "u"), part("square", 2, "u^2")], &[]),
    form(&[part("level", 0, "1"), part("slope", 1, "u"), part("square", 2, "u^2")], &[]),
    form(&[part("cube", 3, "u^3")], &[]),
    form(&[part("slope", 1, "u"), part("cube", 3, "u^3")], &[]),
    form(
        &[
            part("level", 0, "1"),
            part("slope", 1, "u"),
            part("square", 2, "u^2"),
            part("cube", 3, "u^3"),
        ],
        &[],
    ),
    form(&[part("square", 2, "u*abs(u)")], &[]),
    form(&[part("slope", 1, "u"), part("square", 2, "u*abs(u)")], &[]),
    form(&[part("height", 0, "sign(u - centre)")], &[CENTRE_SHAPE]),
    form(&[part("height", 0, "step(u - edge)")], &[EDGE_SHAPE]),
    form(&[part("level", 0, "1"), part("height", 0, "step(u - edge)")], &[EDGE_SHAPE]),
    form(&[part("slope", 1, "abs(u - centre)")], &[CENTRE_SHAPE]),
    form(&[part("level", 0, "1"), part("slope", 1, "abs(u - centre)")], &[CENTRE_SHAPE]),
    form(&[part("stiffness", 1, "max(u - edge, 0)")], &[EDGE_SHAPE]),
    form(&[part("stiffness", 1, "max(edge - u, 0)")], &[EDGE_SHAPE]),
    form(
        &[part("stiffness", 1, "sign(u - centre)*max(abs(u - centre) - slack, 0)")],
        &[CENTRE_SHAPE, ("slack", ParameterShape::Width)],
    ),
    form(
        &[part("slope", 1, "max(-limit, min(limit, u - centre))")],
        &[CENTRE_SHAPE, ("limit", ParameterShape::Width)],
    ),
    form(&[part("height", 0, "tanh((u - centre)/width)")], &[CENTRE_SHAPE, WIDTH_SHAPE]),
    form(&[part("height", 0, "exp(-u/width)")], &[WIDTH_SHAPE]),
    form(&[part("height", 0, "1 - exp(-u/width)")], &[WIDTH_SHAPE]),
    form(&[part("level", 0, "1"), part("height", 0, "exp(-u/width)")], &[WIDTH_SHAPE]),
    form(&[part("height", 0, "exp(-(u/width)^2)")], &[WIDTH_SHAPE]),
    form(&[part("height", 0, "exp(-((u - centre)/width)^2)")], &[CENTRE_SHAPE, WIDTH_SHAPE]),
    form(&[part("height", 0, "sign(u)*(abs(u)/width)^power")], &[("power", ParameterShape::Power)]),
    form(&[part("height", 0, "(abs(u)/width)^power")], &[("power", ParameterShape::Power)]),
    form(&[part("slope", 1, "u*exp(-(u/width)^2)")], &[WIDTH_SHAPE]),
    form(
        &[part("sine", 0, "sin(order*u)"), part("cosine", 0, "cos(order*u)")],
        &[("order", ParameterShape::Order)],
    ),
    form(
        &[
            part("level", 0, "1"),
            part("sine", 0, "sin(order*u)"),
            part("cosine", 0, "cos(order*u)"),
        ],
        &[("order", ParameterShape::Order)],
    ),
];

const LOOP_WIDTH_SHAPE: (&str, ParameterShape) = ("width", ParameterShape::Turning);

const SLACK_SHAPE: (&str, ParameterShape) = ("slack", ParameterShape::Turning);
const LEVEL_PART: FormulaPart = part("level", 0, "1");
const SPRING_PART: FormulaPart = part(SPRING, 1, "u");
const DAHL_PART: FormulaPart = part("height", 0, "dahl(u, width)");
const PLAY_PART: FormulaPart = part("stiffness", 1, "(u - play(u, slack))");

/// The grammar of loops: alone, and beside a spring.
static LOOP_FORMS: &[FormulaForm] = &[
    form(&[DAHL_PART], &[LOOP_WIDTH_SHAPE]),
    form(&[PLAY_PART], &[SLACK_SHAPE]),
    form(&[SPRING_PART, DAHL_PART], &[LOOP_WIDTH_SHAPE]),
    form(&[SPRING_PART, PLAY_PART], &[SLACK_SHAPE]),
    form(&[LEVEL_PART, SPRING_PART, DAHL_PART], &[LOOP_WIDTH_SHAPE]),
    form(&[LEVEL_PART, SPRING_PART, PLAY_PART], &[SLACK_SHAPE]),
];

const SLOPE_ACROSS_PART: FormulaPart = part_of_two("slope_across", [0, 1], "v");
const PRODUCT_PART: FormulaPart = part_of_two("product", [1, 1], "u*v");

/// The grammar of surfaces: planes, what goes with the product of both, with their sum as an angle, or with
/// the second by a curve over the first.
static SURFACE_FORMS: &[FormulaForm] = &[
    form(&[part("slope", 1, "u"), SLOPE_ACROSS_PART], &[]),
    form(&[LEVEL_PART, part("slope", 1, "u"), SLOPE_ACROSS_PART], &[]),
    form(&[PRODUCT_PART], &[]),
    form(&[LEVEL_PART, PRODUCT_PART], &[]),
    form(&[part("slope", 1, "u"), PRODUCT_PART], &[]),
    form(&[SLOPE_ACROSS_PART, PRODUCT_PART], &[]),
    form(&[LEVEL_PART, part("slope", 1, "u"), SLOPE_ACROSS_PART, PRODUCT_PART], &[]),
    form(
        &[
            LEVEL_PART,
            part("slope", 1, "u"),
            SLOPE_ACROSS_PART,
            part("square", 2, "u^2"),
            PRODUCT_PART,
            part_of_two("square_across", [0, 2], "v^2"),
        ],
        &[],
    ),
    form(&[part("sine", 0, "sin(u + v)"), part("cosine", 0, "cos(u + v)")], &[]),
    form(&[LEVEL_PART, part("sine", 0, "sin(u + v)"), part("cosine", 0, "cos(u + v)")], &[]),
    form(
        &[part_of_two("size", [0, 1], "v*(abs(u)/width)^power")],
        &[("power", ParameterShape::Power)],
    ),
    form(&[part_of_two("size", [0, 1], "v*exp(-u/width)")], &[WIDTH_SHAPE]),
    form(&[SLOPE_ACROSS_PART, part_of_two("size", [0, 1], "v*exp(-u/width)")], &[WIDTH_SHAPE]),
    form(
        &[part_of_two("size", [0, 1], "v*exp(-((u - centre)/width)^2)")],
        &[CENTRE_SHAPE, WIDTH_SHAPE],
    ),
    form(&[part_of_two("size", [0, 1], "v*step(u - edge)")], &[EDGE_SHAPE]),
    form(
        &[
            part_of_two("sine", [0, 1], "v*sin(order*u)"),
            part_of_two("cosine", [0, 1], "v*cos(order*u)"),
        ],
        &[("order", ParameterShape::Order)],
    ),
    form(
        &[
            SLOPE_ACROSS_PART,
            part_of_two("sine", [0, 1], "v*sin(order*u)"),
            part_of_two("cosine", [0, 1], "v*cos(order*u)"),
        ],
        &[("order", ParameterShape::Order)],
    ),
];

/// How many laws are proposed: every curve and surface, and each loop that may stand in its place, as
/// itself and as each formula.
pub(super) fn laws_proposed() -> usize {
    let all = hypotheses::all().into_iter().chain(hypotheses::surfaces());
    all.map(|hypothesis| descriptions(&hypothesis)).sum()
}

fn descriptions(hypothesis: &Hypothesis) -> usize {
    let own = 1 + forms(false, hypothesis.across.is_some()).len();
    own + if hypothesis.may_be_loop() { 1 + LOOP_FORMS.len() } else { 0 }
}

/// The formulas of a curve, a loop or a surface.
fn forms(turns_over: bool, across: bool) -> &'static [FormulaForm] {
    match (turns_over, across) {
        (true, _) => LOOP_FORMS,
        (_, true) => SURFACE_FORMS,
        _ => CURVE_FORMS,
    }
}

/// Shapes that are tried: so many of one, and so many of each of two.
const OF_ONE: usize = 60;
const OF_TWO: usize = 28;

/// Exponents that are looked for.
const POWERS: [f64; 2] = [0.2, 4.0];

/// Formulas of a curve that is screened that are judged by blocks left out: so many of the shortest, and
/// so many of those that fit best.
const SCREENED_FORMULAS: usize = 3;

/// Formulas fitted through the plant.
const FITTED_FORMULAS: usize = 4;

/// Steps of such a fit.
const FORMULA_FIT_STEPS: usize = 25;

/// A formula in the place of a curve.
#[derive(Debug, Clone)]
pub(super) struct FittedFormula {
    form: &'static FormulaForm,
    pub expression: String,
    pub fitted: Fitted,
}

/// What a curve costs as the normal equations have it, by its values at its places, all else at its
/// best: (y − y₀)ᵀ H (y − y₀) + 2 hᵀ (y − y₀).
struct Cost {
    curvature: DMatrix<f64>,
    slope: DVector<f64>,
    at: DVector<f64>,
    places: Places,
    /// The way over which a loop turns round; `None` for a curve.
    turns_over: Option<f64>,
    /// True where the stiffness of a spring beside it comes before the values at its places.
    sprung: bool,
}

impl Cost {
    /// Of a fitted curve.
    fn of(curve: &FittedCurve) -> Option<Self> {
        let at = DVector::from_column_slice(curve.all_values());
        let mut linear = curve.fitted.linear.clone();
        // What is expected of how the curve bends is not what the data say.
        for k in linear.away.len() - at.len()..linear.away.len() {
            linear.prior.row_mut(k).fill(0.0);
            linear.prior.column_mut(k).fill(0.0);
        }
        Self::new(Quadratic::of(&linear), &curve.places, &curve.candidate, at)
    }

    /// `normal`: what the curve's values cost, in units of the candidate's steps; `at`: where they are.
    fn new(
        normal: Quadratic,
        places: &Places,
        candidate: &CurveCandidate,
        at: DVector<f64>,
    ) -> Option<Self> {
        let steps = candidate.steps(places);
        let Quadratic { jtj, jtr } = normal.of_last(steps.len())?;
        Some(Self {
            curvature: jtj.map_with_location(|i, j, c| c / (steps[i] * steps[j])),
            slope: jtr.map_with_location(|i, _, s| s / steps[i]),
            at,
            places: places.clone(),
            turns_over: candidate.hypothesis.turns_over,
            sprung: candidate.spring.is_some(),
        })
    }

    /// Formulas that may stand in its place.
    fn forms(&self) -> &'static [FormulaForm] {
        forms(self.turns_over.is_some(), !self.places.across.is_empty())
    }

    /// A form's parts, ready to be evaluated over `u` and its shapes. A power is taken of the variable
    /// over its range.
    fn parsed(&self, form: &FormulaForm) -> Option<Vec<Expression>> {
        let shapes: Vec<&str> = form.shapes.iter().map(|s| s.0).collect();
        let wide = wide(&self.places);
        let parse = |part: &FormulaPart| {
            Expression::parse(&scaled(form, part.of, wide), &["u", "v"], &shapes).ok()
        };
        form.parts.iter().map(parse).collect()
    }

    /// What parts are of the curve's values; `None` where that is no number. The places of a loop are
    /// values of what it remembers.
    fn values(&self, parts: &[Expression], shapes: &[f64]) -> Option<DMatrix<f64>> {
        let rows = usize::from(self.sprung) + self.places.count();
        let value = |row: usize, part: usize| self.value(&parts[part], shapes, row);
        let values = DMatrix::from_fn(rows, parts.len(), value);
        values.iter().all(|v| v.is_finite()).then_some(values)
    }

    /// What a part is of one of the curve's values.
    fn value(&self, part: &Expression, shapes: &[f64], row: usize) -> f64 {
        let eval = |variables: &[f64]| part.eval(variables, shapes);
        match (row.checked_sub(usize::from(self.sprung)), self.turns_over) {
            // A part that goes with the variable is the spring.
            (None, _) => eval(&[1.0, 0.0, 0.0]) - eval(&[0.0; 3]),
            (Some(place), Some(_)) => eval(&[0.0, 0.0, self.places.x[place]]),
            (Some(place), None) => eval(&self.places.place(place)),
        }
    }

    /// Values of a shape that are tried.
    fn starts(&self, shape: ParameterShape, count: usize) -> Vec<f64> {
        let [low, high] = range(shape, &self.places.x, self.turns_over);
        let share = |k: usize| (k as f64 + 0.5) / count as f64;
        let all = (0..count).map(share);
        match shape {
            ParameterShape::Place => all.map(|share| low + (high - low) * share).collect(),
            ParameterShape::Width | ParameterShape::Order | ParameterShape::Power => {
                all.map(|share| low * (high / low).powf(share)).collect()
            }
            // What is remembered was screened for one way.
            ParameterShape::Turning => self.turns_over.into_iter().collect(),
        }
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
pub(super) struct ValuedFormula {
    form: &'static FormulaForm,
    sizes: Vec<f64>,
    shapes: Vec<f64>,
    /// Cost, as the normal equations have it.
    cost: f64,
    /// The same with the length of its description.
    length: f64,
}

/// Where a shape is plausible.
fn range(shape: ParameterShape, places: &[f64], turns_over: Option<f64>) -> [f64; 2] {
    let (first, last) = (places[0], places[places.len() - 1]);
    let wide = last - first;
    match shape {
        ParameterShape::Place => [first, last],
        ParameterShape::Width => [0.02 * wide, 3.0 * wide],
        // A wave needs three places at least.
        ParameterShape::Order => [1.0 / wide, TAU * places.len() as f64 / (3.0 * wide)],
        ParameterShape::Power => POWERS,
        ParameterShape::Turning => [0.1, 10.0].map(|share| share * turns_over.unwrap_or(wide)),
    }
}

/// A part in which a width that is no shape is that of the variable's range.
fn scaled(form: &FormulaForm, part: &str, wide: f64) -> String {
    match form.shapes.iter().any(|s| s.0 == "width") {
        true => part.to_owned(),
        false => part.replace("width", &format!("{wide:?}")),
    }
}

/// A width of so many as two digits say.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// The range of a curve's places.
fn wide(Places { x, .. }: &Places) -> f64 {
    rounded(x[x.len() - 1] - x[0])
}

/// Formulas in the place of a curve that are as short as any, the shortest first.
fn shortest(cost: &Cost, inflation: f64, count: usize) -> Vec<ValuedFormula> {
    let mut found: Vec<ValuedFormula> =
        cost.forms().par_iter().filter_map(|form| find(form, cost, inflation, count)).collect();
    found.sort_by(|a, b| a.length.total_cmp(&b.length));
    found
}

/// The formula in the place of a curve that predicts blocks best that were left out, among the shortest,
/// as far as slopes tell, and their sum of squares. `linear`: nothing is known of the curve's values,
/// which come last, in units of the candidate's steps; `count`: number of residuals.
pub(super) fn screened(
    linear: &ReducedNormal,
    places: &Places,
    candidate: &CurveCandidate,
    count: usize,
) -> Option<(f64, ValuedFormula)> {
    let steps = DVector::from_vec(candidate.steps(places));
    let nothing = DVector::zeros(steps.len());
    let cost = Cost::new(linear.all.clone(), places, candidate, nothing)?;
    let mut found = shortest(&cost, trueweld_estimate::AUTOCORRELATION_INFLATION, count);
    // The shortest, and of the others those that fit best.
    let from = SCREENED_FORMULAS.min(found.len());
    found[from..].sort_by(|a, b| a.cost.total_cmp(&b.cost));
    let judged = found.into_iter().take(2 * SCREENED_FORMULAS).filter_map(|found| {
        let parts = cost.values(&cost.parsed(found.form)?, &found.shapes)?;
        let parts = parts.map_with_location(|row, _, part| part / steps[row]);
        let held_out = linear.with_parts(&parts).held_out();
        held_out.is_finite().then_some((held_out, found))
    });
    judged.min_by(|a, b| a.0.total_cmp(&b.0))
}

fn find(
    form: &'static FormulaForm,
    cost: &Cost,
    inflation: f64,
    count: usize,
) -> Option<ValuedFormula> {
    let parts = cost.parsed(form)?;
    let judge = |shapes: &[f64]| cost.least(&cost.values(&parts, shapes)?);
    let grid: Vec<Vec<f64>> = match form.shapes {
        [] => vec![Vec::new()],
        [one] => cost.starts(one.1, OF_ONE).into_iter().map(|v| vec![v]).collect(),
        [one, two, ..] => {
            let second = cost.starts(two.1, OF_TWO);
            let first = cost.starts(one.1, OF_TWO);
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
    let length = least / inflation + length(form, count);
    Some(ValuedFormula { form, sizes, shapes, cost: least, length })
}

/// What a form costs to be written down: half a logarithm of the number of residuals for each
/// number, twice, as sums of squares are twice a logarithm; and its symbols.
fn length(form: &FormulaForm, count: usize) -> f64 {
    let symbols: usize =
        form.parts.iter().map(|p| p.of.split(|c: char| !c.is_alphanumeric()).count()).sum();
    let numbers = form.parts.len() + form.shapes.len();
    numbers as f64 * (count.max(2) as f64).ln() + SYMBOL * symbols as f64
}

/// What a symbol of a formula costs: twice the logarithm of some ten that may stand there.
const SYMBOL: f64 = 2.0 * LN_10;

/// The best formula in a curve's place, fitted through the plant; `None` where none is as good on
/// blocks left out. `first`: one that was fitted before.
pub(super) fn law(
    context: &DiscoveryContext<'_>,
    curve: &FittedCurve,
    first: Option<&FittedFormula>,
) -> Option<FittedFormula> {
    let cost = Cost::of(curve)?;
    let count = fit::count(&curve.fitted.residuals);
    let inflation = rules::variance_inflation(&curve.fitted);
    let mut found = shortest(&cost, inflation, count);
    found.truncate(FITTED_FORMULAS);
    let of_curve = curve.fitted.held_out();
    let least = first.map_or(of_curve, |first| first.fitted.held_out().min(of_curve));
    let best = least + rules::DECISIVE_FALL * inflation;
    let fits: Vec<FittedFormula> = found
        .into_par_iter()
        .filter(|_| !context.problem.is_late())
        .filter_map(|found| fitted(context, curve, &found))
        .collect();
    let judged = fits.into_iter().chain(first.cloned()).filter_map(|law| {
        let held_out = law.fitted.held_out();
        let length = held_out / inflation + length(law.form, count);
        (held_out <= best).then_some((length, law))
    });
    judged.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, law)| law)
}

impl FittedFormula {
    /// The logarithm of how many shapes of this form are told apart over the places of the curve that it
    /// stands for, nats.
    pub(crate) fn shape_price(&self, curve: &FittedCurve) -> f64 {
        let turns_over = curve.candidate.hypothesis.turns_over;
        let shapes = self.form.shapes.iter();
        shapes.map(|(_, shape)| shape.told_apart(&curve.places.x, turns_over).ln()).sum()
    }

    /// The way over which it turns round, where it is a Dahl loop.
    pub(crate) fn turns_over(&self) -> Option<f64> {
        let of = self.form.shapes.iter().position(|s| *s == LOOP_WIDTH_SHAPE)?;
        self.effect()?.values.get(self.form.parts.len() + of).copied()
    }

    /// The effect that the law is.
    pub(crate) fn effect(&self) -> Option<&Effect> {
        self.fitted.point.shared.last()
    }

    /// A law of the same form in another curve's place.
    pub(crate) fn elsewhere(
        &self,
        context: &DiscoveryContext<'_>,
        curve: &FittedCurve,
    ) -> Option<Self> {
        let cost = Cost::of(curve)?;
        if !cost.forms().iter().any(|form| std::ptr::eq(form, self.form)) {
            return None;
        }
        let found = find(
            self.form,
            &cost,
            trueweld_estimate::AUTOCORRELATION_INFLATION,
            fit::count(&curve.fitted.residuals),
        )?;
        fitted(context, curve, &found)
    }
}

/// A formula fitted through the plant, calibrations with it.
pub(super) fn fitted(
    context: &DiscoveryContext<'_>,
    curve: &FittedCurve,
    found: &ValuedFormula,
) -> Option<FittedFormula> {
    let DiscoveryContext { problem, blocks, null, .. } = *context;
    let hypothesis = &curve.candidate.hypothesis;
    let (definition, values) = definition(context.id, hypothesis, found, &curve.places);
    let expression = definition.expression.clone();
    let kind = definition.kind(&values).ok()?;
    let mut point = curve.fitted.point.without(curve.fitted.point.shared.len() - 1);
    point.add(Effect { kind, at: hypothesis.at, values });
    let known = &curve.fitted.slopes[..null.slopes.len()];
    let fitted = fit::fit(
        problem,
        &point,
        blocks,
        known,
        SolverOptions::steps(FORMULA_FIT_STEPS, known.len()),
    )
    .ok()?;
    Some(FittedFormula { form: found.form, expression, fitted })
}

/// A formula as an effect of the user's own. A part that stands alone has its sign before it.
fn definition(
    id: &str,
    hypothesis: &Hypothesis,
    found: &ValuedFormula,
    places: &Places,
) -> (Definition, Vec<f64>) {
    let form = found.form;
    let negative = form.parts.len() == 1 && found.sizes[0] < 0.0;
    let sizes: Vec<f64> = found.sizes.iter().map(|s| if negative { -s } else { *s }).collect();
    let wide = wide(places);
    let of = |FormulaPart { size, of, .. }: &FormulaPart| match scaled(form, of, wide).as_str() {
        "1" => (*size).to_owned(),
        // A sum stands in parentheses.
        part if part.starts_with("1 - ") => format!("{size}*({part})"),
        part => format!("{size}*{part}"),
    };
    let sum = form.parts.iter().map(of).collect::<Vec<_>>().join(" + ");
    let over = hypothesis.over;
    let sum = replaced(&sum, "u", over).replace(&format!("abs({over})"), &size_of(over));
    let sum = hypothesis.across.map_or(sum.clone(), |across| replaced(&sum, "v", across));
    let sum =
        if form.parts.len() > 1 && hypothesis.times != "1" { format!("({sum})") } else { sum };
    let sign = if negative { "-" } else { "" };
    let x_unit = hypothesis.x_unit();
    let mut parameters = Vec::new();
    for (part, size) in form.parts.iter().zip(&sizes) {
        let far = LARGER * size.abs();
        parameters.push(CustomParameter {
            name: part.size.to_owned(),
            unit: hypothesis.slope_unit(part.powers),
            meaning: part.size.to_owned(),
            role: CustomRole::Size(0.1 * size.abs()),
            low: -far,
            high: far,
        });
    }
    let mut shapes = Vec::new();
    for ((name, shape), value) in form.shapes.iter().zip(&found.shapes) {
        let value = *value;
        let [low, high] = range(*shape, &places.x, hypothesis.turns_over);
        let (unit, role) = match shape {
            ParameterShape::Place => {
                let step = 0.01 * (high - low);
                (x_unit.to_owned(), CustomRole::Position(step, vec![value]))
            }
            ParameterShape::Width | ParameterShape::Turning => {
                (x_unit.to_owned(), CustomRole::Shape(vec![value]))
            }
            ParameterShape::Order => (format!("rad/({x_unit})"), CustomRole::Shape(vec![value])),
            ParameterShape::Power => ("1".to_owned(), CustomRole::Shape(vec![value])),
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
        let loops = LOOP_FORMS.iter().map(|form| (form, Some(0.5)));
        let others = CURVE_FORMS.iter().chain(SURFACE_FORMS).map(|form| (form, None));
        for (form, turns_over) in others.chain(loops) {
            let cost = Cost {
                curvature: DMatrix::zeros(5, 5),
                slope: DVector::zeros(5),
                at: DVector::zeros(5),
                places: Places { x: vec![0.1, 0.3, 0.5, 0.9], across: Vec::new() },
                turns_over,
                sprung: turns_over.is_some(),
            };
            let parts = cost.parsed(form).expect("parts that can be read");
            let shapes = vec![0.5; form.shapes.len()];
            assert!(cost.values(&parts, &shapes).is_some(), "{:?}", form.parts);
        }
    }
}
