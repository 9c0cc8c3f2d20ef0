//! How links are mounted, as far as the postures tell: combinations of values that the logs fix, and
//! how many they leave open. Single values are seldom known, for what one link is off by, the next
//! takes back.

use super::rules;
use nalgebra::DMatrix;
use trueweld_estimate::fit::{self, Fitted};
use trueweld_plant::effects::{CalibrationScope, Location};

/// Deviation of a combination, as a share of what was expected of it before, up to which the logs
/// fix it.
const FIXED: f64 = 0.5;

/// What logs say of how links are mounted.
#[derive(Debug, Clone, PartialEq)]
pub struct Mountings {
    /// Number of values.
    pub values: usize,
    /// Combinations of them that the logs fix, the best known first.
    pub fixed: Vec<Combination>,
}

/// A direction in the space of values, each over its expected deviation: an eigenvector of the
/// covariance that the logs leave.
#[derive(Debug, Clone, PartialEq)]
pub struct Combination {
    /// What it is, in expected deviations.
    pub value: f64,
    /// Its standard deviation, as a share of the expected one.
    pub deviation: f64,
    /// Place, parameter and weight of its values, the largest first; squares sum up to 1.
    pub terms: Vec<(Location, &'static str, f64)>,
}

/// The combinations of a fit with all calibrations free; `None` where the logs see no postures.
pub(super) fn mountings(fitted: &Fitted) -> Option<Mountings> {
    let point = &fitted.point;
    let of_postures = |k: &usize| {
        let calibration = point.effect(point.free[*k].of).kind.calibration;
        calibration.is_some_and(|c| c.scope == CalibrationScope::Postures)
    };
    let own: Vec<usize> = (0..point.free.len()).filter(of_postures).collect();
    if own.is_empty() {
        return None;
    }
    let inflation = rules::variance_inflation(fitted);
    let covariance = fitted.linear.information(None, inflation).cholesky()?.inverse();
    let share = |k: usize| {
        let free = &point.free[k];
        fit::unit(point.parameter(free), point.value(free)) / free.expected
    };
    let scaled = DMatrix::from_fn(own.len(), own.len(), |i, j| {
        covariance[(own[i], own[j])] * share(own[i]) * share(own[j])
    });
    let modes = scaled.symmetric_eigen();
    let mut fixed: Vec<Combination> = (0..own.len())
        .map(|m| (modes.eigenvalues[m].max(0.0).sqrt(), modes.eigenvectors.column(m)))
        .filter(|(deviation, _)| *deviation < FIXED)
        .map(|(deviation, vector)| {
            let sign = if vector[vector.icamax()] < 0.0 { -1.0 } else { 1.0 };
            let mut terms = Vec::with_capacity(own.len());
            let mut value = 0.0;
            for (k, weight) in own.iter().zip(vector.iter().map(|w| sign * w)) {
                let free = &point.free[*k];
                value += weight * point.value(free) / free.expected;
                terms.push((point.effect(free.of).at, point.parameter(free).name, weight));
            }
            terms.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
            Combination { value, deviation, terms }
        })
        .collect();
    fixed.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
    Some(Mountings { values: own.len(), fixed })
}
