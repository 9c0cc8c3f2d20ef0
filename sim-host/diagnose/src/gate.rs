//! What an explanation must show to be named, whatever led to it: values that the logs tell from no
//! effect, and blocks left out that it predicts better than what was there before it by more than
//! chance makes of any that were tried.

use super::found::FittedEffect;
use super::log_evidence::is_significant;
use trueweld_estimate::fit::{FitProblem, Fitted};

/// True where `effects`, which `after` has and `before` has not, may be named. `before`: the
/// calibrations alone, or fewer effects beside them.
pub(crate) fn may_be_named(
    problem: &FitProblem,
    (before, after): (&Fitted, &Fitted),
    effects: &[FittedEffect],
) -> bool {
    !effects.is_empty()
        && effects.iter().all(FittedEffect::is_told_from_nothing)
        && is_significant(problem, before, after)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::found::found;
    use crate::rules::evidence_weights;
    use crate::static_loads::STATIC_LOADS;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;
    use trueweld_estimate::fit::{self, FitState, Linear, Residuals, Slopes, Termination};
    use trueweld_estimate::predict::Prediction;
    use trueweld_plant::effects::{Effect, EffectKind, Location, library};
    use trueweld_plant::random::Random;

    fn random_values(seed: u64, stream: u64) -> Vec<f64> {
        let mut random = Random::new(seed, stream);
        STATIC_LOADS.logs[0].compared.iter().map(|_| random.normal()).collect()
    }

    fn residuals(residual: Vec<f64>) -> Residuals {
        vec![Prediction { residual, motion: None, late: None, not_evidence: 0.0, noise: None }]
    }

    fn fitted(point: FitState, residual: Vec<f64>, slopes: Vec<Slopes>) -> Fitted {
        let (at, n) = (residuals(residual), point.free.len());
        let columns: Vec<&Slopes> = slopes.iter().collect();
        let (prior, away) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let linear = Linear::new(&fit::blocks_of(&STATIC_LOADS), &at, &columns, prior, away);
        Fitted {
            cost: fit::chi_square(&at),
            point,
            residuals: at,
            slopes,
            linear,
            termination: Termination::Converged,
        }
    }

    /// The model without an effect and with it, where its values do to residuals what chance drew.
    /// The residuals are noise, in `runs` of as many values that are the same, and `follows`
    /// deviations of the first value, as far as that is `seen`.
    fn drawn(
        kind: &'static EffectKind,
        seed: u64,
        runs: usize,
        (follows, seen): (f64, fn(usize) -> bool),
    ) -> [Fitted; 2] {
        let mut point = FitState::empty(1);
        let at: Location = kind.places()[0];
        point.add(Effect { values: kind.neutral(at).values, kind, at });
        let mut slopes: Vec<Vec<f64>> =
            (0..point.free.len()).map(|k| random_values(seed, 1 + k as u64)).collect();
        let values = slopes.iter_mut().flat_map(|slope| slope.iter_mut().enumerate());
        values.filter(|(k, _)| !seen(*k)).for_each(|(_, value)| *value = 0.0);
        let noise = random_values(seed, 0);
        let size = follows / ((0..noise.len()).filter(|k| seen(*k)).count() as f64).sqrt();
        let residual = (0..noise.len()).map(|k| noise[k / runs * runs] - size * slopes[0][k]);
        let residual: Vec<f64> = residual.collect();
        let before = fitted(FitState::empty(1), residual.clone(), Vec::new());
        let slopes: Vec<Slopes> = slopes.into_iter().map(|s| vec![Some(s)]).collect();
        let start = fitted(point, residual.clone(), slopes.clone());
        let step = start.linear.solve(None, 0.0, None).unwrap().step;
        let mut left = residual;
        for (slope, step) in slopes.iter().zip(step.iter()) {
            let slope = slope[0].as_ref().unwrap();
            left.iter_mut().zip(slope).for_each(|(r, a)| *r += a * step);
        }
        [before, fitted(start.point.moved(&step), left, slopes)]
    }

    fn named([before, after]: &[Fitted; 2]) -> bool {
        let effects = found(&STATIC_LOADS, after, |_| true);
        may_be_named(&STATIC_LOADS, (before, after), &effects)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn chance_names_no_effect(seed: u64, runs in 1_usize..5, kind in 0..library().count()) {
            let kind = library().nth(kind).unwrap();
            prop_assert!(!named(&drawn(kind, seed, runs, (0.0, |_| true))), "{}", kind.id);
        }

        #[test]
        fn what_is_named_has_a_size_predicts_better_and_changes_a_channel(
            seed: u64,
            runs in 1_usize..5,
            follows in 0.0..100.0,
            kind in 0..library().count(),
        ) {
            let kind = library().nth(kind).unwrap();
            let both = drawn(kind, seed, runs, (follows, |_| true));
            if named(&both) {
                let [before, after] = &both;
                let found = &found(&STATIC_LOADS, after, |_| true)[0];
                let has_size = |k: usize| {
                    let (parameter, [low, high]) = (&kind.parameters[k], found.interval[k]);
                    let value = found.effect.values[k];
                    let none = parameter.without_effect(value);
                    parameter.is_size()
                        && parameter.low < value
                        && value < parameter.high
                        && high - low <= parameter.high - parameter.low
                        && (none < low || none > high)
                };
                prop_assert!((0..kind.parameters.len()).any(has_size), "{found:?}");
                prop_assert!(after.held_out() < before.held_out(), "{found:?}");
                prop_assert!(fit::chi_square(&after.residuals) < fit::chi_square(&before.residuals));
            }
        }

        #[test]
        fn what_stands_far_out_is_named(seed: u64) {
            let kind = EffectKind::of("torque-scale").unwrap();
            prop_assert!(named(&drawn(kind, seed, 1, (30.0, |_| true))));
        }
    }

    #[test]
    fn what_would_be_larger_than_plausible_is_not_named() {
        let kind = EffectKind::of("torque-scale").unwrap();
        let size = |[_, after]: &[Fitted; 2]| after.point.shared[0].values[0];
        let high = kind.parameters[0].high;
        for seed in 0..20 {
            let held = drawn(kind, seed, 1, (1e9, |_| true));
            assert_eq!(size(&held), high, "{seed}");
            assert!(!named(&held), "{seed}");
        }
    }

    #[test]
    fn what_a_few_rows_in_a_row_show_is_named() {
        // A friction that a joint shows about one reversal: none of these rows would be predicted
        // were they left out together, and that is no evidence against it.
        let kind = EffectKind::of("torque-scale").unwrap();
        for seed in 0..20 {
            assert!(named(&drawn(kind, seed, 1, (30.0, |k| k < 12))), "{seed}");
        }
    }

    #[test]
    fn values_that_are_off_alike_count_as_few_as_they_are() {
        let mut compared = STATIC_LOADS.logs[0].compared.clone();
        assert!(evidence_weights(&compared).iter().all(|weight| *weight == 1.0));
        let first = (compared[0].quantity, compared[0].component);
        let own =
            |c: &&mut trueweld_estimate::predict::Compared| (c.quantity, c.component) == first;
        compared.iter_mut().filter(own).for_each(|c| c.alike = 1.0);
        let weights = evidence_weights(&compared);
        let of_first = compared.iter().zip(&weights).filter(|(c, _)| c.alike == 1.0);
        assert!((of_first.map(|(_, weight)| weight).sum::<f64>() - 1.0).abs() < 1e-12);
        let others = compared.iter().zip(&weights).filter(|(c, _)| c.alike == 0.0);
        assert!(others.map(|(_, weight)| *weight).all(|weight| weight == 1.0));
    }
}
