//! A free curve or surface at a port: a table whose values are fitted, held together by what is expected
//! of how it bends. How much that is, held-out blocks say: residuals that follow each other would have
//! any other criterion take noise for a curve.

use super::context::DiscoveryContext;
use super::hypotheses::Hypothesis;
use super::variables::ExpressionValues;
use crate::rules;
use nalgebra::DMatrix;
use std::ops::Range;
use trueweld_estimate::AUTOCORRELATION_INFLATION;
use trueweld_estimate::fit::{
    self, EffectScope, FitState, Fitted, FreeParameter, ReducedNormal, Slopes, SolverOptions,
};
use trueweld_estimate::residuals::localize::ConditionBin;
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::expression::Expression;
use trueweld_plant::effects::formula::{CustomParameter, CustomRole, Definition};
use trueweld_plant::effects::table::{DefinedTable, Places};
use trueweld_plant::effects::{Action, Effect, EffectKind};

/// Places of a curve while it is screened, and while it is fitted.
pub(super) const SCREENED_KNOTS: usize = 12;
pub(super) const FITTED_KNOTS: usize = 20;

/// The same along each variable of a surface.
fn along_each(of_curve: usize) -> usize {
    of_curve.isqrt() + 2
}

/// How places lie over the range of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum KnotLayout {
    /// Nearly even.
    Even,
    /// Half of them even, half of them where the variable often is: for one that is seldom in most of
    /// its range.
    Often,
}

/// Share of a place that goes by the variable where they are nearly even, not by how often it is there.
const EVEN_SPACING_SHARE: f64 = 0.7;

/// Share of the range by which places by how often a variable is there must be away from even ones.
const SELDOM: f64 = 0.4;

/// Ways over which loops turn round, as shares of the range of their variable.
pub(super) const LOOP_WIDTH_SHARES: [f64; 5] = [0.003, 0.01, 0.03, 0.1, 0.3];

/// How much a curve may bend from place to place, as shares of its largest value.
const BENDS: [f64; 7] = [0.001, 0.004, 0.015, 0.05, 0.15, 0.5, 2.0];

/// Range of a value, in the steps at which slopes are taken.
const CURVE_VALUE_RANGE: f64 = 1e3;

/// Least range of a variable, as a share of its largest value, over which a curve may be found.
const LEAST_RANGE: f64 = 1e-3;

/// A hypothesis with its variables on the logs.
#[derive(Debug, Clone)]
pub(super) struct CurveCandidate {
    pub hypothesis: Hypothesis,
    /// What the curve is over, and what it is multiplied by.
    pub over: ExpressionValues,
    pub times: ExpressionValues,
    /// The second variable of a surface.
    pub across: Option<ExpressionValues>,
    /// Slopes of all residuals by a constant at the port, in the port's unit.
    pub constant: Slopes,
    /// Value at which the slopes by a value of the curve are taken.
    pub step: f64,
    /// Of a loop the spring beside it.
    pub spring: Option<Spring>,
}

/// A spring over the variable whose way a loop remembers: what rubs and gives is seldom without one, and
/// a loop that is to explain both is none of the two.
#[derive(Debug, Clone)]
pub(super) struct Spring {
    /// The variable.
    over: ExpressionValues,
    /// Value at which the slopes by its stiffness are taken.
    step: f64,
}

impl CurveCandidate {
    /// Both variables in a row of a log; nothing where there is no second.
    pub(crate) fn at(&self, log: usize, row: usize) -> [f64; 2] {
        let value = |series: &ExpressionValues| series[log].get(row).copied().unwrap_or(f64::NAN);
        [value(&self.over), self.across.as_ref().map_or(0.0, value)]
    }

    /// Values of a variable where the logs show the port, rising.
    fn seen(&self, context: &DiscoveryContext<'_>, variable: usize) -> Vec<f64> {
        let mut seen = Vec::new();
        for (log, experiment) in context.problem.logs.iter().enumerate() {
            let Some(slope) = &self.constant[log] else { continue };
            let mut last = usize::MAX;
            for (k, compared) in experiment.compared.iter().enumerate() {
                let row = compared.row;
                let value = self.at(log, row)[variable];
                if slope[k] != 0.0 && row != last && value.is_finite() {
                    seen.push(value);
                    last = row;
                }
            }
        }
        seen.sort_by(f64::total_cmp);
        seen
    }

    /// The same as a loop that turns round over this way; `None` where no log knows its variable.
    pub(crate) fn turning_over(&self, context: &DiscoveryContext<'_>, width: f64) -> Option<Self> {
        let hypothesis = Hypothesis { turns_over: Some(width), ..self.hypothesis };
        let rows = |text: &str| context.rows().of(hypothesis.port, hypothesis.at, text);
        let (over, along) = (rows(&hypothesis.over())?, rows(hypothesis.over)?);
        let known = along.iter().flatten().filter(|u| u.is_finite());
        let step = self.step / known.fold(0.0, |far: f64, u| far.max(u.abs()));
        let spring = step.is_finite().then_some(Spring { over: along, step });
        Some(Self { hypothesis, over, spring, ..self.clone() })
    }

    /// Steps of its values: of the stiffness of the spring beside a loop, and of each place.
    pub(crate) fn steps(&self, places: &Places) -> Vec<f64> {
        let spring = self.spring.iter().map(|spring| spring.step);
        spring.chain((0..places.count()).map(|_| self.step)).collect()
    }

    /// Range of the variable where the logs show the port; `None` where it hardly changes.
    pub(crate) fn range(&self, context: &DiscoveryContext<'_>) -> Option<f64> {
        range(&self.seen(context, 0))
    }

    /// The layouts that suit the variable; none where it hardly changes.
    pub(crate) fn layouts(&self, context: &DiscoveryContext<'_>) -> &'static [KnotLayout] {
        if self.across.is_some() {
            let changes = |variable| range(&self.seen(context, variable)).is_some();
            return if [0, 1].into_iter().all(changes) { &[KnotLayout::Even] } else { &[] };
        }
        let seen = self.seen(context, 0);
        let (Some(range), Some(first)) = (range(&seen), seen.first()) else {
            return &[];
        };
        let away = |(k, value): (usize, &f64)| {
            (k as f64 / (seen.len() - 1) as f64 - (value - first) / range).abs()
        };
        let seldom = seen.iter().enumerate().map(away).fold(0.0, f64::max) > SELDOM;
        if seldom { &[KnotLayout::Even, KnotLayout::Often] } else { &[KnotLayout::Even] }
    }

    /// Places over the range of each variable, so many of a curve; `None` where few are apart.
    pub(crate) fn places(
        &self,
        context: &DiscoveryContext<'_>,
        layout: KnotLayout,
        count: usize,
    ) -> Option<Places> {
        let over = |variable, count| self.places_over(context, variable, layout, count);
        Some(match self.across {
            None => Places { x: over(0, count)?, across: Vec::new() },
            Some(_) => {
                Places { x: over(0, along_each(count))?, across: over(1, along_each(count))? }
            }
        })
    }

    fn places_over(
        &self,
        context: &DiscoveryContext<'_>,
        variable: usize,
        layout: KnotLayout,
        count: usize,
    ) -> Option<Vec<f64>> {
        let seen = self.seen(context, variable);
        let (first, last) = (*seen.first()?, *seen.last()?);
        let range = last - first;
        let even = |share: f64| first + share * range;
        let often = |share: f64| seen[((seen.len() - 1) as f64 * share).round() as usize];
        let share = |k: usize, of: usize| k as f64 / (of - 1) as f64;
        let (mut places, nearest): (Vec<f64>, f64) = match layout {
            KnotLayout::Even => {
                let place =
                    |s: f64| EVEN_SPACING_SHARE * even(s) + (1.0 - EVEN_SPACING_SHARE) * often(s);
                ((0..count).map(|k| place(share(k, count))).collect(), 0.1 * range / count as f64)
            }
            KnotLayout::Often => {
                let half = count / 2 + 1;
                let each = (0..half).flat_map(|k| [even(share(k, half)), often(share(k, half))]);
                (each.collect(), 1e-3 * range / count as f64)
            }
        };
        places.sort_by(f64::total_cmp);
        places.dedup_by(|b, a| *b - *a < nearest);
        (places.len() >= 4).then_some(places)
    }

    /// Slopes of all residuals by its values, over their steps, in ring-downs by driving the plant; `None` where
    /// these say nothing of it.
    pub(crate) fn slopes_as_it_swings(
        &self,
        context: &DiscoveryContext<'_>,
        places: &Places,
    ) -> Option<Vec<Slopes>> {
        let ring_down = |log: usize| context.problem.logs[log].kind == LogKind::RingDown;
        if !self.hypothesis.swings() || !(0..context.problem.logs.len()).any(ring_down) {
            return None;
        }
        let mut all = self.slopes_at_once(context, places);
        // A ring-down hardly moves the encoders: only the places near where it is have a say.
        let mut near = vec![vec![false; places.count()]; self.over.len()];
        for log in (0..self.over.len()).filter(|log| ring_down(*log)) {
            let rows = (0..self.over[log].len()).map(|row| self.at(log, row));
            for at in rows.filter(|at| at.iter().all(|x| x.is_finite())) {
                places.shares(at).for_each(|(place, _)| near[log][place] = true);
            }
        }
        let wanted = |place: usize, log: usize| near[log][place];
        let swung = self.slopes_through_plant(context, places, wanted).unwrap_or_default();
        for (all, swung) in all.iter_mut().zip(swung) {
            all.iter_mut().zip(swung).for_each(|(all, swung)| *all = swung.or(all.take()));
        }
        Some(all)
    }

    /// The same by driving the plant with each value, of those values and logs that are wanted.
    fn slopes_through_plant(
        &self,
        context: &DiscoveryContext<'_>,
        places: &Places,
        wanted: impl Fn(usize, usize) -> bool + Sync,
    ) -> Option<Vec<Slopes>> {
        let DiscoveryContext { problem, null, .. } = *context;
        let mut point = null.point.clone();
        let table = DefinedTable { places: places.clone(), bend: f64::INFINITY };
        let of = self.add_to(&mut point, context.id, table)?;
        let own: Vec<FreeParameter> = point.free.iter().copied().filter(|f| f.of == of).collect();
        // What a loop remembers at the start is looked for once, not with each of its values.
        let with_memory = self.hypothesis.turns_over.map(|_| fit::residuals(problem, &point));
        let at = with_memory.transpose().ok()?;
        Some(fit::slopes_where(
            problem,
            &point,
            &own,
            at.as_ref().unwrap_or(&null.residuals),
            1.0,
            wanted,
        ))
    }

    /// Adds the curve, with no value anywhere, to a point of a fit.
    fn add_to(&self, point: &mut FitState, id: &str, table: DefinedTable) -> Option<EffectScope> {
        let kind = self.kind(id, table)?;
        let nothing = vec![0.0; kind.parameters.len()];
        point.add(Effect { kind, at: self.hypothesis.at, values: nothing });
        Some(EffectScope::Shared(point.shared.len() - 1))
    }

    /// The same where the port answers at once: each row as if the variable stood still.
    pub(crate) fn slopes_at_once(
        &self,
        context: &DiscoveryContext<'_>,
        places: &Places,
    ) -> Vec<Slopes> {
        let logs = context.problem.logs.len();
        let before = usize::from(self.spring.is_some());
        let mut all: Vec<Slopes> = vec![vec![None; logs]; before + places.count()];
        for (log, experiment) in context.problem.logs.iter().enumerate() {
            let Some(slope) = &self.constant[log] else { continue };
            let mut columns = vec![vec![0.0; slope.len()]; before + places.count()];
            let (springs, at) = columns.split_at_mut(before);
            for (k, compared) in experiment.compared.iter().enumerate() {
                let of_row = self.at(log, compared.row);
                let weight = slope[k] * self.step * self.times[log][compared.row];
                if weight == 0.0 || !weight.is_finite() || !of_row.iter().all(|x| x.is_finite()) {
                    continue;
                }
                if let Some(spring) = &self.spring {
                    springs[0][k] = slope[k] * spring.step * spring.over[log][compared.row];
                }
                places.shares(of_row).for_each(|(place, share)| at[place][k] += weight * share);
            }
            for (slopes, column) in all.iter_mut().zip(columns) {
                slopes[log] = Some(column);
            }
        }
        all
    }

    /// The kind of effect that this curve is.
    pub(crate) fn kind(&self, id: &str, table: DefinedTable) -> Option<&'static EffectKind> {
        let hypothesis = &self.hypothesis;
        let far = CURVE_VALUE_RANGE * self.step;
        let spring = self.spring.as_ref().map(|spring| CustomParameter {
            name: SPRING.to_owned(),
            unit: hypothesis.slope_unit([1, 0]),
            meaning: SPRING.to_owned(),
            role: CustomRole::Size(spring.step),
            low: -CURVE_VALUE_RANGE * spring.step,
            high: CURVE_VALUE_RANGE * spring.step,
        });
        let beside = spring.as_ref().map(|_| [SPRING, "*", hypothesis.over, " + "].concat());
        let places =
            CustomParameter::of_table(&table, &hypothesis.y_unit(), self.step, [-far, far]);
        let parameters: Vec<CustomParameter> = spring.into_iter().chain(places).collect();
        let values = vec![0.0; parameters.len()];
        let definition = Definition {
            id: id.to_owned(),
            port: hypothesis.port,
            expression: beside.unwrap_or_default() + &hypothesis.table(),
            shows: hypothesis.port.meaning.to_owned(),
            parameters,
            table: Some(table),
        };
        definition.kind(&values).ok()
    }
}

/// Name of the stiffness of the spring beside a loop.
pub(super) const SPRING: &str = "slope";

/// Range of rising values; `None` where they hardly change.
fn range(seen: &[f64]) -> Option<f64> {
    let (first, last) = (seen.first()?, seen.last()?);
    let range = last - first;
    (range > LEAST_RANGE * first.abs().max(last.abs())).then_some(range)
}

/// A curve in the linear model of a fit.
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    /// What is expected of how it bends, in the unit of its values.
    pub bend: f64,
    /// Sum of squares of blocks that were left out.
    pub held_out: f64,
    /// Fall of the sum of squares of a curve that bends at will: more than any formula brings.
    pub most: f64,
}

/// The curve whose bending predicts blocks best that were left out. `linear`: the values at the places
/// come last in it, and nothing is known of them.
pub(super) fn smooth(linear: &ReducedNormal, places: &Places, step: f64) -> Option<Smooth> {
    let of = |bend: f64| {
        let table = DefinedTable { places: places.clone(), bend };
        linear.with_prior(&fit::roughness(&table, step))
    };
    // As large as a curve is that bends at will.
    let free = of(1e3 * step).all.least()?;
    let most = -linear.all.at(&free);
    let size = free.rows(free.len() - places.count(), places.count()).amax() * step;
    let tried = BENDS.iter().filter_map(|share| {
        let bend = share * size;
        let held_out = of(bend).held_out();
        (bend > 0.0 && held_out.is_finite()).then_some(Smooth { bend, held_out, most })
    });
    tried.min_by(|a, b| a.held_out.total_cmp(&b.held_out))
}

/// A curve fitted through the plant.
#[derive(Debug, Clone)]
pub(super) struct FittedCurve {
    pub candidate: CurveCandidate,
    layout: KnotLayout,
    pub places: Places,
    pub fitted: Fitted,
}

/// Share of a loop that is left to turn round at the end of what is drawn.
const NEARLY_ROUND: f64 = 0.01;

/// Points that a formula is drawn by.
const FORMULA_POINTS: usize = 200;

/// Share of a band's squared width that all values have in common from which on it hides the shape.
const MOSTLY: f64 = 0.75;

/// Steps of a fit through the plant: a curve is nearly in proportion to its values.
const CURVE_FIT_STEPS: usize = 6;

/// Fits a curve beside the calibrations, through the plant.
pub(super) fn fit_curve(
    context: &DiscoveryContext<'_>,
    candidate: &CurveCandidate,
    layout: KnotLayout,
) -> Option<FittedCurve> {
    let DiscoveryContext { problem, blocks, null, eliminated, .. } = *context;
    let places = candidate.places(context, layout, FITTED_KNOTS)?;
    let own = candidate.slopes_through_plant(context, &places, |_, _| true)?;
    let mut linear = context.beside(&own);
    let Smooth { bend, .. } =
        smooth(&eliminated.condensed(&linear, own.len()), &places, candidate.step)?;
    let table = DefinedTable { places: places.clone(), bend };
    let from = linear.away.len() - places.count();
    let mut prior = linear.prior.view_mut((from, from), (places.count(), places.count()));
    prior += fit::roughness(&table, candidate.step);
    let step = linear.solve(None, 0.0, None)?.step;
    let mut start = null.point.clone();
    candidate.add_to(&mut start, context.id, table)?;
    let start = start.moved(&step);
    let known = [null.slopes.clone(), own].concat();
    let options = SolverOptions::steps(CURVE_FIT_STEPS, known.len());
    let fitted = fit::fit(problem, &start, blocks, &known, options).ok()?;
    Some(FittedCurve { candidate: candidate.clone(), layout, places, fitted })
}

impl FittedCurve {
    /// The logarithm of how many shapes of it are tried, nats: how it bends, how its places lie, and over
    /// which way a loop turns round.
    pub(crate) fn shape_price(&self, context: &DiscoveryContext<'_>) -> f64 {
        let layouts = self.candidate.layouts(context).len().max(1);
        let widths = self.candidate.hypothesis.turns_over.map_or(1, |_| LOOP_WIDTH_SHARES.len());
        ((BENDS.len() * layouts * widths) as f64).ln()
    }

    /// The same as a loop of another width, where that predicts blocks left out as well: a loop is
    /// screened for a few widths only.
    pub(crate) fn turning_over(&self, context: &DiscoveryContext<'_>, width: f64) -> Option<Self> {
        let candidate = self.candidate.turning_over(context, width)?;
        let other = fit_curve(context, &candidate, self.layout)?;
        let as_good =
            self.fitted.held_out() + rules::DECISIVE_FALL * rules::variance_inflation(&self.fitted);
        (other.fitted.held_out() < as_good).then_some(other)
    }

    /// A formula in its place, over its range.
    pub(crate) fn drawn(&self, formula: &Effect) -> Vec<[f64; 2]> {
        let Action::Expression(own) = formula.kind.action else {
            return Vec::new();
        };
        let [first, last] =
            [0, self.places.x.len() - 1].map(|place| self.drawn_at(self.places.x[place]));
        let at = |k: usize| first + (last - first) * k as f64 / FORMULA_POINTS as f64;
        let hypothesis = &self.candidate.hypothesis;
        // The formula over its variable, its factor left away.
        let text = hypothesis.within(&own.definition.expression);
        let names: Vec<&str> = own.definition.parameters.iter().map(|p| p.name.as_str()).collect();
        let Ok(curve) = Expression::parse(&text, &["u", "v"], &names) else {
            return Vec::new();
        };
        let (_, across) = self.middle();
        // Of a loop what it remembers alone, without the spring beside it.
        let value = |x: f64| match curve.remembered(&formula.values) {
            Some((law, width)) => {
                curve.eval(&[0.0, 0.0, law.after(x, width, -1.0)], &formula.values)
            }
            None => curve.eval(&[x, across], &formula.values),
        };
        (0..=FORMULA_POINTS).map(|k| [at(k), value(at(k))]).collect()
    }

    /// Where a value of what the curve is over is drawn: of a loop, the way since the variable turned
    /// round at the end of a long way back.
    pub(crate) fn drawn_at(&self, x: f64) -> f64 {
        match self.candidate.hypothesis.turns_over {
            Some(width) => -width * (0.5 * (1.0 - x)).max(NEARLY_ROUND).ln(),
            None => x,
        }
    }

    /// All its values, those at its places last.
    pub(crate) fn all_values(&self) -> &[f64] {
        self.fitted.point.shared.last().map_or(&[], |effect| &effect.values)
    }

    /// Of what there is for each of its values that for its places.
    pub(crate) fn of_places<'a, T>(&self, all: &'a [T]) -> &'a [T] {
        &all[all.len().saturating_sub(self.places.count())..]
    }

    /// What is drawn of a surface: indices of the values in the middle of its second variable, and where
    /// that is. Of a curve all of them.
    pub(crate) fn middle(&self) -> (Range<usize>, f64) {
        let Places { x, across } = &self.places;
        let row = self.places.middle();
        (row * x.len()..(row + 1) * x.len(), across.get(row).copied().unwrap_or(0.0))
    }

    /// The values at its places.
    pub(crate) fn values(&self) -> &[f64] {
        self.of_places(self.all_values())
    }

    /// Half the interval of what all values of its band have in common, where that is most of its
    /// width, and the band without.
    pub(crate) fn shape(&self, band: &[[f64; 2]]) -> (Option<f64>, Vec<[f64; 2]>) {
        let n = self.places.count();
        let whole = || (None, band.to_vec());
        let Some(factor) = self.fitted.linear.factor() else { return whole() };
        // The curve's values come last.
        let all = self.fitted.linear.away.len();
        let own = DMatrix::from_fn(all, n, |row, column| f64::from(row + n == all + column));
        let covariance = factor.solve(&own).rows(all - n, n).into_owned();
        let centred = DMatrix::identity(n, n).add_scalar(-1.0 / n as f64);
        let centred = (&centred * &covariance * &centred).diagonal();
        let shares: Vec<f64> =
            (0..n).map(|k| (centred[k].max(0.0) / covariance[(k, k)]).sqrt().min(1.0)).collect();
        let half = |[low, high]: [f64; 2]| 0.5 * (high - low);
        let level = (covariance.mean().max(0.0) / covariance.diagonal().mean()).sqrt();
        if level.is_nan() || level * level < MOSTLY {
            return whole();
        }
        let mean = band.iter().map(|band| half(*band)).sum::<f64>() / n as f64;
        let narrow = |(band, share): (&[f64; 2], &f64)| {
            let (middle, reach) = (0.5 * (band[0] + band[1]), share * half(*band));
            [middle - reach, middle + reach]
        };
        (Some(level * mean), band.iter().zip(&shares).map(narrow).collect())
    }

    /// What the measurements ask for along the curve, whatever its form, a point a stretch between
    /// its places: the curve and what is left of the residual there.
    pub(crate) fn points(&self, context: &DiscoveryContext<'_>) -> Vec<ConditionBin> {
        let left: Vec<&[f64]> =
            self.fitted.residuals.iter().map(|at| at.residual.as_slice()).collect();
        let mut points = self.asked(context, &left);
        let (_, across) = self.middle();
        for point in &mut points {
            point.y += self.places.value(self.values(), [point.x, across]);
        }
        self.drawn_points(points)
    }

    /// Points where they are drawn.
    pub(crate) fn drawn_points(&self, points: Vec<ConditionBin>) -> Vec<ConditionBin> {
        points
            .into_iter()
            .map(|point| ConditionBin { x: self.drawn_at(point.x), ..point })
            .collect()
    }

    /// What would take residuals away at the port, a point a stretch between the places; of a surface
    /// near the middle of its second variable.
    pub(crate) fn asked(
        &self,
        context: &DiscoveryContext<'_>,
        left: &[impl AsRef<[f64]>],
    ) -> Vec<ConditionBin> {
        let Places { x: places, across } = &self.places;
        let stretches = places.len() - 1;
        let row = self.places.middle();
        // Of a surface half way to the next places on either side.
        let near = across.windows(3).nth(row.saturating_sub(1)).map(|next| {
            let half = |to: f64| 0.5 * (next[1] + to);
            half(next[0])..=half(next[2])
        });
        // Σ s², Σ s² x, −Σ s r, Σ r², number.
        let mut sums = vec![[0.0; 5]; stretches];
        for (log, experiment) in context.problem.logs.iter().enumerate() {
            let Some(slope) = &self.candidate.constant[log] else { continue };
            let left = left[log].as_ref();
            for (k, compared) in experiment.compared.iter().enumerate() {
                let [x, second] = self.candidate.at(log, compared.row);
                let s = slope[k] * self.candidate.times[log][compared.row];
                if s == 0.0 || !s.is_finite() || !x.is_finite() {
                    continue;
                }
                if near.as_ref().is_some_and(|near| !near.contains(&second)) {
                    continue;
                }
                let above = places.partition_point(|place| *place <= x);
                let sum = &mut sums[above.clamp(1, stretches) - 1];
                let row = [s * s, s * s * x, -s * left[k], left[k] * left[k], 1.0];
                sum.iter_mut().zip(row).for_each(|(sum, row)| *sum += row);
            }
        }
        let point = |[weight, x, asked, left, count]: [f64; 5]| {
            let variance = (left / count).max(1.0) * AUTOCORRELATION_INFLATION / weight;
            ConditionBin { x: x / weight, y: asked / weight, error: variance.sqrt() }
        };
        let points = sums.into_iter().filter(|sum| sum[0] > 0.0).map(point);
        points.filter(|p| p.y.is_finite() && p.error.is_finite()).collect()
    }
}
