//! What values of several units, each with an uncertainty of its own, say of the type that they are
//! of: its mean, how far units spread about it, and how far one of them is from the others.
//!
//! Random effects: yᵢ ~ N(μ, τ² + sᵢ²), sᵢ known. Everything follows from one function that falls as
//! the spread grows, Q(τ²) = Σ wᵢ (yᵢ − μ̂)² with wᵢ = 1/(τ² + sᵢ²) and μ̂ their weighted mean, which is
//! distributed as χ² with k − 1 degrees of freedom at the true spread.
//!
//! Left out: values of one unit that are uncertain together.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};
use statrs::function::erf::erfc;
use std::f64::consts::SQRT_2;

/// Probability beyond each end of a 95 % interval.
const TAIL_95: f64 = 0.025;

/// Halvings that narrow a bracket to the last digit of a number.
const HALVINGS: usize = 200;

/// Steps of a squared spread over which probabilities are summed, as a ratio, from this share of the
/// least variance on, until what is left is negligible.
const SPREAD_RATIO: f64 = 1.05;
const LEAST_SPREAD_SHARE: f64 = 1e-3;
const UNSUMMED_MAX: f64 = 1e-9;

/// What is known of one unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitValue {
    /// Value.
    pub value: f64,
    /// Its standard deviation, greater than 0.
    pub deviation: f64,
}

/// A type of which several units are known. All in the unit of the values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomEffects {
    /// Mean of the type.
    pub mean: f64,
    /// Its 95 % interval: Student's with k − 1 degrees of freedom, never narrower than the units'
    /// own uncertainty makes it (Knapp and Hartung 2003, modified as Röver et al. 2015).
    pub mean_interval: [f64; 2],
    /// Standard deviation of its units: Q(τ²) = k − 1 (Paule and Mandel 1982), or 0.
    pub spread: f64,
    /// Its 95 % interval: Q(τ²) between the quantiles of its distribution (Viechtbauer 2007).
    pub spread_interval: [f64; 2],
    /// Variance of the mean.
    variance: f64,
}

impl RandomEffects {
    /// Of two units or more; `None` of fewer.
    pub fn of(units: &[UnitValue]) -> Option<Self> {
        let freedom = units.len().checked_sub(1).filter(|f| *f > 0)? as f64;
        let chi = ChiSquared::new(freedom).ok()?;
        let square = spread_where(units, freedom, q);
        let [least, most] = [1.0 - TAIL_95, TAIL_95].map(|p| chi.inverse_cdf(p));
        let (mean, weight) = weighted(units, square);
        let student = StudentsT::new(0.0, 1.0, freedom).ok()?;
        let half = student.inverse_cdf(1.0 - TAIL_95) / weight.sqrt();
        Some(Self {
            mean,
            mean_interval: [mean - half, mean + half],
            spread: square.sqrt(),
            spread_interval: [
                spread_where(units, least, q).sqrt(),
                spread_where(units, most, q_by_chance).sqrt(),
            ],
            variance: 1.0 / weight,
        })
    }
}

/// How far a unit is from the others of its type.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOutUnit {
    /// Distance from the mean of the others over what it varies by: its own uncertainty, the others'
    /// spread, and that of their mean.
    pub distance: f64,
    /// Probability that a unit of the type is as far away or farther: the normal distribution's, averaged
    /// over what the others leave open of the spread. Of units known alike that is Student's with k − 2
    /// degrees of freedom, as the distribution of a deleted residual (Viechtbauer and Cheung 2010).
    pub probability: f64,
}

impl LeftOutUnit {
    /// Of one of three units or more; `None` of fewer: of two that differ, either may be the odd one.
    pub fn of(units: &[UnitValue], unit: usize) -> Option<Self> {
        let mut others = units.to_vec();
        let own = others.remove(unit);
        let rest = RandomEffects::of(&others)?;
        let variance = own.deviation.powi(2) + rest.spread.powi(2) + rest.variance;
        let distance = (own.value - rest.mean) / variance.sqrt();
        Some(Self { distance, probability: beyond(own, &others)? })
    }
}

/// Probability that a unit of the others' type is as far from them as this one, or farther.
fn beyond(own: UnitValue, others: &[UnitValue]) -> Option<f64> {
    let chi = ChiSquared::new(others.len() as f64 - 1.0).ok()?;
    let spread_below = |square: f64| chi.sf(q_by_chance(others, square));
    let farther = |square: f64| {
        let (mean, weight) = weighted(others, square);
        let variance = own.deviation.powi(2) + square + 1.0 / weight;
        erfc((own.value - mean).abs() / variance.sqrt() / SQRT_2)
    };
    let deviations = others.iter().map(|unit| unit.deviation);
    let mut square = LEAST_SPREAD_SHARE * deviations.fold(f64::INFINITY, f64::min).powi(2);
    let (mut below, mut at) = (spread_below(0.0), farther(0.0));
    let mut sum = below * at;
    while below < 1.0 - UNSUMMED_MAX && square.is_finite() {
        let next = (spread_below(square), farther(square));
        sum += (next.0 - below) * 0.5 * (next.1 + at);
        (below, at) = next;
        square *= SPREAD_RATIO;
    }
    Some((sum + 1.0 - below).min(1.0))
}

/// Weighted mean, and the sum of the weights.
fn weighted(units: &[UnitValue], square: f64) -> (f64, f64) {
    let mut sums = (0.0, 0.0);
    for unit in units {
        let weight = 1.0 / (square + unit.deviation.powi(2));
        sums = (sums.0 + weight * unit.value, sums.1 + weight);
    }
    (sums.0 / sums.1, sums.1)
}

/// Q at a squared spread.
fn q(units: &[UnitValue], square: f64) -> f64 {
    let (mean, _) = weighted(units, square);
    units.iter().map(|u| (u.value - mean).powi(2) / (square + u.deviation.powi(2))).sum()
}

/// What is expected of the same of units that are alike (DerSimonian and Kacker 2007, eq. 5).
fn q_alike(units: &[UnitValue], square: f64) -> f64 {
    let (_, weight) = weighted(units, square);
    let share = |u: &UnitValue| u.deviation.powi(2) / (square + u.deviation.powi(2));
    let own: f64 = units.iter().map(share).sum();
    own - units.iter().map(|u| share(u) / (square + u.deviation.powi(2))).sum::<f64>() / weight
}

/// Q at a squared spread, of units that agree better than their uncertainty allows as if they agreed as
/// chance has it: they are no sign of a spread below it.
fn q_by_chance(units: &[UnitValue], square: f64) -> f64 {
    q(units, square).max(q_alike(units, square))
}

/// The squared spread at which a function that falls with it is `target`; 0 where it is below that
/// without a spread.
fn spread_where(units: &[UnitValue], target: f64, of: impl Fn(&[UnitValue], f64) -> f64) -> f64 {
    if of(units, 0.0) <= target {
        return 0.0;
    }
    // Q(τ²) ≤ Σ (yᵢ − ȳ)²/τ², and what is expected of units alike ≤ Σ sᵢ²/τ².
    let plain = units.iter().map(|u| u.value).sum::<f64>() / units.len() as f64;
    let squares = units.iter().map(|u| (u.value - plain).powi(2) + u.deviation.powi(2));
    let (mut low, mut high) = (0.0, squares.sum::<f64>() / target);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if of(units, middle) > target { low = middle } else { high = middle }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::random::Random;

    fn units(values: &[f64], deviation: f64) -> Vec<UnitValue> {
        values.iter().map(|value| UnitValue { value: *value, deviation }).collect()
    }

    /// With equal uncertainties everything is a closed form of the sample's mean m and deviation d: the
    /// spread is √(d² − s²), the mean's interval m ± t d/√k, and a unit's distance that of Student's
    /// two-sample test with k − 2 degrees of freedom.
    #[test]
    fn of_units_known_alike_it_is_the_closed_form() {
        let all = units(&[1.0, 2.0, 3.0, 6.0], 0.5);
        let of = RandomEffects::of(&all).unwrap();
        let (mean, variance) = (3.0, 14.0 / 3.0);
        assert!((of.mean - mean).abs() < 1e-12, "{of:?}");
        assert!((of.spread - (variance - 0.25f64).sqrt()).abs() < 1e-9, "{of:?}");
        // Student's t of 3 degrees of freedom at 97.5 %.
        let half = 3.182_446 * (variance / 4.0).sqrt();
        assert!((of.mean_interval[1] - mean - half).abs() < 1e-5, "{of:?}");
        // χ² of 3 degrees of freedom at 2.5 % and 97.5 %.
        for (end, quantile) in of.spread_interval.iter().zip([9.348_404, 0.215_795]) {
            let expected = (3.0 * variance / quantile - 0.25).sqrt();
            assert!((end - expected).abs() < 1e-4 * expected, "{end} {expected}");
        }
        // Known to a hundredth of their spread, so that this is not cut off at nothing.
        let last = LeftOutUnit::of(&units(&[1.0, 2.0, 3.0, 6.0], 0.01), 3).unwrap();
        assert!((last.distance - 4.0 / (4f64 / 3.0).sqrt()).abs() < 1e-9, "{last:?}");
        // P(|t| > d) of 2 degrees of freedom: 1 − d/√(2 + d²); the sum over spreads is of second order
        // in their steps.
        let beyond = 1.0 - last.distance / (2.0 + last.distance.powi(2)).sqrt();
        assert!((last.probability - beyond).abs() < 1e-3 * beyond, "{last:?}");
    }

    #[test]
    fn of_two_units_the_spread_is_hardly_known_and_neither_is_the_odd_one() {
        let two = units(&[0.4, 0.44], 0.002);
        let of = RandomEffects::of(&two).unwrap();
        assert!(of.spread_interval[1] > 20.0 * of.spread, "{of:?}");
        assert!(of.mean_interval[1] - of.mean > 6.0 * of.spread, "{of:?}");
        assert!(LeftOutUnit::of(&two, 0).is_none());
        assert!(RandomEffects::of(&two[..1]).is_none());
    }

    #[test]
    fn units_that_are_the_same_to_the_digit_may_still_spread_by_what_is_not_known_of_them() {
        let of = RandomEffects::of(&units(&[1.0; 4], 0.1)).unwrap();
        assert_eq!((of.spread, of.spread_interval[0]), (0.0, 0.0));
        // As chance has it, 3 (1/(1 + τ²/s²)) = 0.2158.
        let expected = 0.1 * (3.0f64 / 0.215_795 - 1.0).sqrt();
        assert!((of.spread_interval[1] - expected).abs() < 1e-5, "{of:?}");
    }

    /// Intervals of 95 % over fleets drawn at random: of 2000, 1900 ± 3 √95 hold the truth, or more
    /// where the spread may be nothing, and units of the type are as far away as they should be.
    #[test]
    fn intervals_hold_the_truth_and_no_unit_of_the_type_stands_out_more_often_than_said() {
        const FLEETS: usize = 2000;
        const LEAST: usize = 1871;
        let mut random = Random::new(17, 0);
        for (count, spread) in [(2, 1.0), (4, 0.0), (4, 0.3), (4, 3.0), (8, 1.0)] {
            let [mut mean, mut between, mut far] = [0, 0, 0];
            for _ in 0..FLEETS {
                let unit = |k: usize| {
                    let deviation = 0.5 + 0.25 * (k % 4) as f64;
                    let value = 7.0 + spread * random.normal() + deviation * random.normal();
                    UnitValue { value, deviation }
                };
                let all: Vec<UnitValue> = (0..count).map(unit).collect();
                let of = RandomEffects::of(&all).unwrap();
                let holds = |[low, high]: [f64; 2], x| usize::from((low..=high).contains(&x));
                mean += holds(of.mean_interval, 7.0);
                between += holds(of.spread_interval, spread);
                let odd = LeftOutUnit::of(&all, 0).is_some_and(|of| of.probability < 0.05);
                far += usize::from(odd);
            }
            let told = format!("{count} {spread}: {mean} {between} {far}");
            assert!(mean >= LEAST && between >= LEAST, "{told}");
            assert!(far <= FLEETS - LEAST, "{told}");
        }
    }
}
