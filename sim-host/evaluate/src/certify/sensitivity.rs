//! Which of the uncertain numbers the failures follow from: what to measure, or to build better.
//!
//! A figure of the drawn cells, by its logarithm, is fitted with a line and a parabola in every
//! uncertain number, the one that explains most first, and another only while it explains more than
//! chance would with so many to choose from (F-test, 5 % after Bonferroni). The numbers are drawn
//! independently, so that the part of each is its own. What a law of this form does not explain is
//! said as well: there no one number is at fault.

use super::worst::{PHASE, names, numbers};
use super::{Evidence, EvidenceKind, Requirement, SampledCell, within};
use crate::uncertain::UncertainCell;
use nalgebra::{DMatrix, DVector};
use schemars::JsonSchema;
use serde::Serialize;
use statrs::distribution::{ContinuousCDF, FisherSnedecor};
use trueweld_plant::{named, serialize_as_text};

/// Probability of naming any number where none matters.
const CHANCE: f64 = 0.05;

/// Draws for each term of the fit, at least.
const DRAWS_A_TERM: usize = 5;

/// What the draws say of a requirement's dependence on the uncertain numbers.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "FigureSensitivity", deny_unknown_fields)]
pub struct Sensitivity {
    /// Key of the figure.
    pub name: &'static str,
    /// Draws beyond its limit.
    pub beyond: usize,
    /// Draws in all.
    #[serde(skip)]
    pub of: usize,
    /// Share of the variance of the figure's logarithm that the numbers explain.
    pub explained: f64,
    /// The numbers that matter beyond chance, the most important first.
    #[serde(rename = "numbers")]
    pub influences: Vec<Influence>,
}

/// What one uncertain number has to do with a figure.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "NumberInfluence", deny_unknown_fields)]
pub struct Influence {
    /// The number, or the group that moves together.
    pub number: String,
    /// Share of the variance of the figure's logarithm.
    pub share: f64,
    /// How the figure follows it: `grows`, `falls`, `at-ends` or `in-middle`.
    pub trend: Trend,
    // As the fit has it.
    /// Draws beyond the limit were the number always in the middle of its range.
    pub beyond_without: usize,
}

serialize_as_text!(Trend::name);

named! {
    /// How a figure follows a number.
    pub enum Trend {
        /// It grows with it.
        Grows = "grows",
        /// It falls with it.
        Falls = "falls",
        /// It is larger at both ends than between them.
        AtEnds = "at-ends",
        /// It is larger in the middle.
        InMiddle = "in-middle",
    }
}

/// Of the requirements that draws were beyond, the most often missed first; where none was, of the
/// one that came closest to its limit.
pub fn sensitivities(
    uncertain: &UncertainCell,
    requirements: &[Requirement],
    evidence: &Evidence,
) -> Vec<Sensitivity> {
    let mut judged: Vec<(&Requirement, usize)> = requirements
        .iter()
        .filter(|r| r.case == EvidenceKind::Draws && !r.is_joint() && r.limit > 0.0)
        .filter_map(|r| Some((r, r.draws?.beyond)))
        .collect();
    let closeness = |r: &Requirement| r.achieved / r.limit;
    judged.sort_by(|(a, m), (b, n)| n.cmp(m).then(closeness(b).total_cmp(&closeness(a))));
    let missed = judged.iter().filter(|(_, beyond)| *beyond > 0).count();
    judged.truncate(missed.max(1));
    let table = Numbers::of(uncertain, evidence.trials.iter().map(|trial| &trial.draw));
    let of = |(requirement, beyond): (&Requirement, usize)| {
        let figures = evidence.trials.iter().map(|trial| trial.figure(requirement.name));
        let (influences, explained) =
            table.influences(&figures.collect::<Vec<_>>(), requirement.limit);
        let of = evidence.trials.len();
        Sensitivity { name: requirement.name, beyond, of, explained, influences }
    };
    judged.into_iter().map(of).collect()
}

/// The uncertain numbers of many cells, two columns each: how a number enters the fit.
struct Numbers {
    names: Vec<String>,
    columns: Vec<[DVector<f64>; 2]>,
}

impl Numbers {
    fn of<'a>(uncertain: &UncertainCell, cells: impl Iterator<Item = &'a SampledCell>) -> Self {
        let shares: Vec<Vec<f64>> = cells.map(|cell| numbers(uncertain, cell)).collect();
        let mut table = Self { names: Vec::new(), columns: Vec::new() };
        for (k, name) in names(uncertain).into_iter().enumerate() {
            let of: Vec<f64> = shares.iter().map(|shares| shares[k]).collect();
            table.add(name, &of, k == PHASE);
        }
        table
    }

    /// A number by its share of its range, from −1 to 1; the middle of an angle's range is no
    /// place of its own. What does not vary is left out.
    fn add(&mut self, name: String, shares: &[f64], angle: bool) {
        let enters = |u: f64| match angle {
            true => [(std::f64::consts::PI * u).cos(), (std::f64::consts::PI * u).sin()],
            false => [u, u * u],
        };
        if shares.iter().any(|share| *share != shares[0]) {
            self.names.push(name);
            self.columns.push([0, 1].map(|term| {
                DVector::from_iterator(shares.len(), shares.iter().map(|u| enters(*u)[term]))
            }));
        }
    }

    /// The numbers that matter for a figure, and the share of its variance that they explain.
    fn influences(&self, figures: &[f64], limit: f64) -> (Vec<Influence>, f64) {
        let n = figures.len();
        // A run without an end counts as twice the worst that was seen.
        let worst = figures.iter().copied().filter(|f| f.is_finite()).fold(limit, f64::max);
        let log =
            |figure: f64| if figure.is_finite() { figure } else { 2.0 * worst }.max(1e-12).ln();
        let y = DVector::from_iterator(n, figures.iter().map(|figure| log(*figure)));
        let centred = |v: &DVector<f64>| v.add_scalar(-v.mean());
        let total = centred(&y).norm_squared();
        if n < 2 * DRAWS_A_TERM || total < 1e-20 * n as f64 {
            return (Vec::new(), 0.0);
        }
        let mut basis: Vec<DVector<f64>> = Vec::new();
        let mut rest = centred(&y);
        let mut chosen: Vec<usize> = Vec::new();
        while DRAWS_A_TERM * (basis.len() + 3) <= n {
            let left = rest.norm_squared();
            let gains = (0..self.columns.len()).filter(|k| !chosen.contains(k)).map(|k| {
                let [first, second] = &self.columns[k];
                let directions = orthonormal(&basis, [centred(first), centred(second)]);
                let gain: f64 = directions.iter().map(|d| d.dot(&rest).powi(2)).sum();
                (k, directions, gain)
            });
            let Some((k, directions, gain)) = gains.reduce(|a, b| if b.2 > a.2 { b } else { a })
            else {
                break;
            };
            let free = (n - 1 - basis.len() - directions.len()) as f64;
            let terms = directions.len() as f64;
            let ratio = (gain / terms) / ((left - gain).max(1e-12 * total) / free);
            let chance = FisherSnedecor::new(terms, free).map_or(1.0, |f| f.sf(ratio));
            if chance * self.columns.len() as f64 > CHANCE {
                break;
            }
            for direction in directions {
                rest -= &direction * direction.dot(&rest);
                basis.push(direction);
            }
            chosen.push(k);
        }
        let terms: Vec<DVector<f64>> =
            chosen.iter().flat_map(|k| &self.columns[*k]).map(centred).collect();
        if terms.is_empty() {
            return (Vec::new(), 0.0);
        }
        let matrix = DMatrix::from_columns(&terms);
        let Ok(weights) = matrix.svd(true, true).solve(&centred(&y), 1e-9) else {
            return (Vec::new(), 0.0);
        };
        let mut influences: Vec<Influence> = chosen
            .iter()
            .zip(weights.as_slice().chunks(2))
            .map(|(k, weights)| {
                let [line, parabola] = [0, 1].map(|i| &self.columns[*k][i] * weights[i]);
                let part = &line + &parabola;
                let beyond = y.iter().zip(&part).filter(|(y, p)| !within((*y - *p).exp(), limit));
                let bent = centred(&parabola).norm() > centred(&line).norm();
                Influence {
                    number: self.names[*k].clone(),
                    share: (centred(&part).dot(&centred(&y)) / total).max(0.0),
                    trend: match (bent, weights[usize::from(bent)] > 0.0) {
                        (false, true) => Trend::Grows,
                        (false, false) => Trend::Falls,
                        (true, true) => Trend::AtEnds,
                        (true, false) => Trend::InMiddle,
                    },
                    beyond_without: beyond.count(),
                }
            })
            .collect();
        influences.sort_by(|a, b| b.share.total_cmp(&a.share));
        let free = (n - 1 - basis.len()) as f64;
        let explained = 1.0 - rest.norm_squared() / free / (total / (n - 1) as f64);
        (influences, explained.max(0.0))
    }
}

/// What two directions add to a basis.
fn orthonormal(basis: &[DVector<f64>], of: [DVector<f64>; 2]) -> Vec<DVector<f64>> {
    let mut new: Vec<DVector<f64>> = Vec::new();
    for mut direction in of {
        let before = direction.norm();
        for known in basis.iter().chain(&new) {
            direction -= known * known.dot(&direction);
        }
        if direction.norm() > 1e-6 * before.max(f64::MIN_POSITIVE) {
            new.push(direction.normalize());
        }
    }
    new
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Cells of 30 numbers, and a figure of each: `of` the numbers and of noise, both from −1 to 1.
    fn drawn(seed: u64, cells: usize, of: impl Fn(&[f64], f64) -> f64) -> (Numbers, Vec<f64>) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut number = || 2.0 * random.random::<f64>() - 1.0;
        let cells: Vec<Vec<f64>> =
            (0..cells).map(|_| (0..31).map(|_| number()).collect()).collect();
        let mut table = Numbers { names: Vec::new(), columns: Vec::new() };
        for k in 0..30 {
            let shares: Vec<f64> = cells.iter().map(|cell| cell[k]).collect();
            table.add(format!("number {k}"), &shares, false);
        }
        (table, cells.iter().map(|cell| of(cell, cell[30])).collect())
    }

    #[test]
    fn the_numbers_that_matter_are_named_with_their_shares_and_trends() {
        // Logarithm −u₃ + 1.5 u₈² + 0.1 ν, uniform: variances 1/3, 0.2, 1/300.
        let (table, figures) =
            drawn(3, 400, |u, noise| (-u[3] + 1.5 * u[8] * u[8] + 0.1 * noise).exp());
        let (influences, explained) = table.influences(&figures, 2.0);
        let named: Vec<(&str, Trend)> =
            influences.iter().map(|of| (of.number.as_str(), of.trend)).collect();
        assert_eq!(named, [("number 3", Trend::Falls), ("number 8", Trend::AtEnds)]);
        let all = 1.0 / 3.0 + 0.2 + 1.0 / 300.0;
        for (of, variance) in influences.iter().zip([1.0 / 3.0, 0.2]) {
            assert!((of.share - variance / all).abs() < 0.06, "{of:?}");
        }
        assert!((explained - (1.0 - 1.0 / 300.0 / all)).abs() < 0.01, "{explained}");
        // Without u₈ the logarithm is at most 1.1, and above ln 2 = 0.69 where u₃ is below −0.69.
        let expected = figures.len() as f64 * 0.5 * (1.0 - 2.0_f64.ln());
        let without = influences[1].beyond_without as f64;
        assert!((without - expected).abs() < 25.0, "{without}, expected some {expected}");
    }

    #[test]
    fn where_nothing_matters_nothing_is_named_but_by_chance() {
        let named = |seed| {
            let (table, figures) = drawn(seed, 60, |_, noise| (0.5 * noise).exp());
            !table.influences(&figures, 1.0).0.is_empty()
        };
        // At 5 % each, 22 of 300 or more have a probability of 4 %.
        let chance = (0..300).filter(|seed| named(*seed)).count();
        assert!(chance < 22, "{chance} of 300");
    }

    #[test]
    fn a_run_without_an_end_is_the_worst_and_few_or_equal_draws_say_nothing() {
        let of = |u: &[f64], _| if u[5] > 0.6 { f64::INFINITY } else { 1.0 + 0.1 * u[5] };
        let (table, figures) = drawn(1, 100, of);
        let (influences, _) = table.influences(&figures, 2.0);
        assert_eq!(influences[0].number, "number 5");
        assert_eq!(influences[0].trend, Trend::Grows);
        let (table, figures) = drawn(1, 9, of);
        assert!(table.influences(&figures, 2.0).0.is_empty());
        let (table, figures) = drawn(1, 100, |_, _| 0.5);
        assert!(table.influences(&figures, 2.0).0.is_empty());
    }
}
