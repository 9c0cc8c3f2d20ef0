//! Loads at rest whose readings the other loads of the same posture contradict: a tracker that lost
//! its beam, a payload that was written down wrongly.
//!
//! What a cell does at one posture follows the load, so that its other loads show it too. A load is
//! an outlier only where it is off the median of its posture by far more than loads of this log are,
//! and where so few are that they are no part of what the cell does. What a motion has of the kind is
//! left out where logs are read, by the rows before and after.

use crate::fit::{FitProblem, FitState};
use crate::predict::{ANOTHER_POSTURE, ComparedQuantity, PredictError, Prediction, PreparedLog};
use std::collections::BTreeMap;
use trueweld_logs::log::{Log, LogKind, LogNotice, Samples};
use trueweld_logs::median;
use trueweld_logs::outlier::OUTLIER_DEVIATIONS;

/// Fewest loads of a posture of which one can be told to be off.
const POSTURE_LOADS_MIN: usize = 4;

/// Most loads of a log, as a share, that are outliers: what occurs more often is how the cell is.
const OUTLYING_LOADS_SHARE_MAX: f64 = 0.05;

/// Takes from loads at rest what the other loads of their posture contradict, and says so in the
/// logs' notices. `logs`: those that the problem's logs were made of. Returns true where something
/// was taken, so that they are to be made ready again.
///
/// # Errors
/// [`PredictError`] of a log the model cannot be driven through.
pub fn leave_out_outlying_loads(
    problem: &FitProblem,
    logs: &mut [Log],
) -> Result<bool, PredictError> {
    let point = FitState::empty(problem.logs.len());
    let mut any = false;
    for (k, (log, experiment)) in logs.iter_mut().zip(&problem.logs).enumerate() {
        if log.kind != LogKind::StaticLoad {
            continue;
        }
        let prediction = experiment.predict(&problem.model, &point.effects(problem, k), None)?;
        for outlying in outlying_loads(&log.samples, experiment, &prediction) {
            let OutlyingLoads { quantity, rows, largest } = outlying;
            rows.iter().for_each(|row| take_out(&mut log.samples, quantity, *row));
            log.notices.push(LogNotice::OutlyingLoads {
                channel: quantity.log_channel(),
                rows: rows.into_iter().map(|row| row + 1).collect(),
                largest,
            });
            any = true;
        }
    }
    Ok(any)
}

/// Loads that stand apart in one quantity.
struct OutlyingLoads {
    quantity: ComparedQuantity,
    rows: Vec<usize>,
    /// By how much the worst is off its posture's median, in the quantity's unit.
    largest: f64,
}

/// What a load misses the model by in one quantity, by component: over the noise.
type LoadResidual = BTreeMap<u8, f64>;

fn outlying_loads(
    samples: &Samples,
    experiment: &PreparedLog,
    prediction: &Prediction,
) -> Vec<OutlyingLoads> {
    let mut of_quantity: BTreeMap<ComparedQuantity, BTreeMap<usize, LoadResidual>> =
        BTreeMap::new();
    let mut unit: BTreeMap<ComparedQuantity, f64> = BTreeMap::new();
    for (compared, residual) in experiment.compared.iter().zip(&prediction.residual) {
        let loads = of_quantity.entry(compared.quantity).or_default();
        loads.entry(compared.row).or_default().insert(compared.component, *residual);
        unit.insert(compared.quantity, compared.deviation);
    }
    let postures = postures(samples);
    let told = of_quantity.into_iter().filter_map(|(quantity, loads)| {
        let off = off_posture(&loads, &postures);
        let rows = outliers(&off)?;
        let largest = rows.iter().map(|row| off[row]).fold(0.0, f64::max) * unit[&quantity];
        Some(OutlyingLoads { quantity, rows, largest })
    });
    told.collect()
}

/// Rows of each posture.
fn postures(samples: &Samples) -> Vec<Vec<usize>> {
    let mut postures: Vec<Vec<usize>> = Vec::new();
    for (row, angle) in samples.encoder.iter().enumerate() {
        let same =
            |rows: &&mut Vec<usize>| (samples.encoder[rows[0]] - angle).amax() < ANOTHER_POSTURE;
        match postures.iter_mut().find(same) {
            Some(rows) => rows.push(row),
            None => postures.push(vec![row]),
        }
    }
    postures
}

/// By how much each load is off the median of its posture, over the noise; of postures with enough
/// loads.
fn off_posture(
    loads: &BTreeMap<usize, LoadResidual>,
    postures: &[Vec<usize>],
) -> BTreeMap<usize, f64> {
    let mut off: BTreeMap<usize, f64> = BTreeMap::new();
    for rows in postures {
        let own: Vec<usize> = rows.iter().copied().filter(|row| loads.contains_key(row)).collect();
        if own.len() < POSTURE_LOADS_MIN {
            continue;
        }
        let components: Vec<u8> = loads[&own[0]].keys().copied().collect();
        for component in components {
            let of = |row: &usize| loads[row].get(&component).copied();
            let Some(middle) = median(&mut own.iter().filter_map(of).collect::<Vec<_>>()) else {
                continue;
            };
            for row in &own {
                let square = of(row).map_or(0.0, |residual| (residual - middle).powi(2));
                let sum: &mut f64 = off.entry(*row).or_default();
                *sum = sum.hypot(square.sqrt());
            }
        }
    }
    off
}

/// The rows that stand far out of all, where they are few.
fn outliers(off: &BTreeMap<usize, f64>) -> Option<Vec<usize>> {
    let usual = median(&mut off.values().copied().collect::<Vec<_>>())?.max(1.0);
    let far = off.iter().filter(|(_, off)| **off > OUTLIER_DEVIATIONS * usual);
    let rows: Vec<usize> = far.map(|(row, _)| *row).collect();
    let most = (OUTLYING_LOADS_SHARE_MAX * off.len() as f64).ceil();
    (!rows.is_empty() && rows.len() as f64 <= most).then_some(rows)
}

/// Takes the reading of a quantity from a row.
fn take_out(samples: &mut Samples, quantity: ComparedQuantity, row: usize) {
    let vector = match quantity {
        ComparedQuantity::Position => samples.position.as_mut(),
        ComparedQuantity::Rotation => samples.rotation.as_mut(),
        ComparedQuantity::Force | ComparedQuantity::Ripple { .. } => samples.force.as_mut(),
        ComparedQuantity::Moment => samples.moment.as_mut(),
        ComparedQuantity::LinkEncoder => {
            return samples.link_encoder.iter_mut().flatten().for_each(|s| s[row] = f64::NAN);
        }
        ComparedQuantity::MotorTorque => {
            return samples.motor_torque.iter_mut().flatten().for_each(|s| s[row] = f64::NAN);
        }
    };
    if let Some(vectors) = vector {
        vectors[row].fill(f64::NAN);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn loads(off: impl Fn(usize) -> f64) -> BTreeMap<usize, f64> {
        (0..60).map(|row| (row, 1.0 + 0.1 * (row % 5) as f64 + off(row))).collect()
    }

    #[test]
    fn few_loads_that_stand_far_out_are_outliers() {
        assert_eq!(outliers(&loads(|_| 0.0)), None);
        let far = loads(|row| if row % 25 == 7 { 100.0 } else { 0.0 });
        assert_eq!(outliers(&far), Some(vec![7, 32, 57]));
        let near = loads(|row| if row == 7 { 5.0 } else { 0.0 });
        assert_eq!(outliers(&near), None, "an effect that not all loads show");
        let often = loads(|row| if row % 6 == 5 { 100.0 } else { 0.0 });
        assert_eq!(outliers(&often), None, "the largest load of every posture is how the cell is");
    }

    #[test]
    fn a_load_is_judged_by_its_own_posture() {
        let residual = |value: f64| LoadResidual::from([(0, value), (1, -value)]);
        // Two postures whose places the tracker sees apart, and one load that is off.
        let value =
            |row: usize| if row < 5 { 3.0 } else { -40.0 } + if row == 8 { 9.0 } else { 0.0 };
        let loads = (0..10).map(|row| (row, residual(value(row)))).collect();
        let off = off_posture(&loads, &[(0..5).collect(), (5..10).collect()]);
        assert!(off.iter().all(|(row, off)| (*row == 8) == (*off > 1.0)), "{off:?}");
        assert!((off[&8] - 9.0 * 2_f64.sqrt()).abs() < 1e-12);
    }
}
