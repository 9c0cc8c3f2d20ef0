//! What was found outside the library, against the law that is hidden.

use crate::LABORATORY;
use crate::outside::FreeFormEffect;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use trueweld_diagnose::discover::{Discovery, Hypothesis};
use trueweld_laboratory::Hidden;
use trueweld_plant::effects::expression::Expression;

/// A law that was found outside the library.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DiscoveredLaw {
    /// Port, place and variables in words, and its formula.
    pub law: String,
    /// True where port, place and variables are those of the law that is hidden.
    pub right: bool,
    /// True where they are those of one that it was declared not to be told from.
    pub tied: bool,
    /// Where they are, and the law is a curve: at how many places the curve's band of 95 % holds it, of
    /// how many.
    pub band: Option<[usize; 2]>,
    /// Where the formula that was found can be the law: how many of its values' intervals of 95 % hold
    /// those of the law, of how many.
    pub values: Option<[usize; 2]>,
}

impl DiscoveredLaw {
    pub(super) fn of(discovery: &Discovery, hidden: &Hidden) -> Self {
        let found = &discovery.effect.effect;
        let law = match hidden {
            Hidden::Law(law) => Some(law),
            _ => None,
        };
        let outside = law.map(|law| FreeFormEffect::named(law.kind.id).expect("one of them"));
        let is = |hypothesis: &Hypothesis| {
            let (Some(law), Some(outside)) = (law, outside) else { return false };
            let over = hypothesis.variables();
            (hypothesis.port.name, hypothesis.at) == (outside.port, law.at)
                && outside.over.iter().all(|variable| over.contains(variable))
                && outside.remembers() == hypothesis.turns_over.is_some()
        };
        let hypothesis = &discovery.hypothesis;
        let curve = || hypothesis.expression(&format!("curve({})", hypothesis.over));
        let formula = discovery.expression.clone().unwrap_or_else(curve);
        let right = is(hypothesis);
        let truth = outside.zip(law).filter(|_| right).and_then(|(outside, law)| {
            let curve = Along::of(hypothesis, outside.expression, &[])?;
            let truth = discovery.curve.x.iter().map(|x| curve.at(*x, &[]));
            truth.map(|y| Some(law.values[0] * y?)).collect::<Option<Vec<f64>>>()
        });
        Self {
            law: format!(
                "{} [{}] {formula}",
                hypothesis.port.name,
                found.at.name(&LABORATORY.robot)
            ),
            right,
            tied: discovery.tied.iter().any(|tied| is(&tied.hypothesis)),
            band: truth.as_ref().map(|truth| of_band(discovery, truth)),
            values: truth.as_ref().and_then(|truth| of_values(discovery, truth)),
        }
    }
}

/// At how many places the band holds the truth, of how many.
fn of_band(discovery: &Discovery, truth: &[f64]) -> [usize; 2] {
    let band = discovery.curve.band.iter().zip(truth);
    let held = band.filter(|([low, high], y)| (low..=high).contains(y));
    [held.count(), truth.len()]
}

/// How many intervals of a formula's values hold those with which it is the truth, of how many; `None`
/// where it is the truth with none.
fn of_values(discovery: &Discovery, truth: &[f64]) -> Option<[usize; 2]> {
    let found = &discovery.effect;
    let names: Vec<&str> = found.effect.kind.parameters.iter().map(|p| p.name).collect();
    let formula = Along::of(&discovery.hypothesis, discovery.expression.as_ref()?, &names)?;
    let free: Vec<usize> = (0..names.len()).filter(|k| found.is_fitted(*k)).collect();
    let values = formula.values_of(truth, &discovery.curve.x, &found.effect.values, &free)?;
    let holds = |k: &&usize| {
        let [low, high] = found.interval[**k];
        (low..=high).contains(&values[**k])
    };
    Some([free.iter().filter(holds).count(), free.len()])
}

/// An expression at a port along the variable of a curve, over what the curve is multiplied by.
struct Along {
    law: Expression,
    times: Expression,
    /// Number of the port's variables, and which of them the curve is over.
    variables: usize,
    over: usize,
    smoothing: Option<usize>,
}

/// Values of the other variables at which a law is the same curve, where it is one.
const OTHERS: [f64; 2] = [1.0, 0.5];
/// Share of its size to which it is the same, and to which a formula is to be the truth.
const SAME: f64 = 1e-6;
const IS_TRUTH: f64 = 1e-4;
/// Steps after which a formula is the truth or never will be.
const STEPS: usize = 200;

impl Along {
    /// `None` for a loop or a surface, and for what is no expression at the port.
    fn of(hypothesis: &Hypothesis, text: &str, parameters: &[&str]) -> Option<Self> {
        if hypothesis.turns_over.is_some() || hypothesis.across.is_some() {
            return None;
        }
        let names: Vec<&str> = hypothesis.port.variables.iter().map(|v| v.name).collect();
        let place = |wanted: &str| names.iter().position(|name| *name == wanted);
        Some(Self {
            law: Expression::parse(text, &names, parameters).ok()?,
            times: Expression::parse(hypothesis.times, &names, &[]).ok()?,
            variables: names.len(),
            over: place(hypothesis.variables().first()?)?,
            smoothing: place("smoothing"),
        })
    }

    fn with_others(&self, others: f64, x: f64, values: &[f64]) -> f64 {
        let mut at = vec![others; self.variables];
        // Friction has turned round.
        if let Some(smoothing) = self.smoothing {
            at[smoothing] = 1e-9;
        }
        at[self.over] = x;
        self.law.eval(&at, values) / self.times.eval(&at, &[])
    }

    /// The curve's value; `None` where it depends on other variables.
    fn at(&self, x: f64, values: &[f64]) -> Option<f64> {
        let [one, other] = OTHERS.map(|others| self.with_others(others, x, values));
        ((one - other).abs() <= SAME * one.abs()).then_some(one)
    }

    /// The values with which it is the truth at these places, from `start` by Levenberg's method, only
    /// those `free` changed.
    fn values_of(
        &self,
        truth: &[f64],
        places: &[f64],
        start: &[f64],
        free: &[usize],
    ) -> Option<Vec<f64>> {
        let off = |values: &[f64]| {
            let each = places.iter().zip(truth);
            let each = each.map(|(x, y)| Some(self.at(*x, values)? - y));
            Some(DVector::from_vec(each.collect::<Option<Vec<f64>>>()?))
        };
        let size = DVector::from_column_slice(truth).norm();
        let mut values = start.to_vec();
        let mut left = off(&values)?;
        let mut damping = 1e-3;
        for _ in 0..STEPS {
            if left.norm() <= IS_TRUTH * size {
                return Some(values);
            }
            let columns = free.iter().map(|k| {
                let step = 1e-6 * values[*k].abs().max(1e-3);
                let mut aside = values.clone();
                aside[*k] += step;
                Some((off(&aside)? - &left) / step)
            });
            let slopes = DMatrix::from_columns(&columns.collect::<Option<Vec<_>>>()?);
            let mut square = slopes.tr_mul(&slopes);
            let scale = square.diagonal();
            square.set_diagonal(&(&scale * (1.0 + damping)).add_scalar(f64::MIN_POSITIVE));
            let step = square.cholesky()?.solve(&slopes.tr_mul(&left));
            let mut next = values.clone();
            free.iter().zip(step.iter()).for_each(|(k, step)| next[*k] -= step);
            match off(&next).filter(|next| next.norm() < left.norm()) {
                Some(nearer) => (values, left, damping) = (next, nearer, 0.3 * damping),
                None => damping *= 10.0,
            }
        }
        None
    }
}
