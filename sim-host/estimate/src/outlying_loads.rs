//! Loads at rest whose readings the other loads of the same posture contradict: a tracker that lost
//! its beam, a payload that was written down wrongly.
//!
//! What a cell does at one posture follows the load, so that its other loads show it too. A load is
//! an outlier only where it is off the median of its posture by far more than loads of this log are,
//! and where so few are that they are no part of what the cell does. One that is alone at its posture
//! is an outlier only where it is off all loads of the log, and further than loads make the arm go at
//! any posture. What a motion has of the kind is left out where logs are read, by the rows before and
//! after.

use crate::fit::{FitProblem, FitState};
use crate::predict::{ANOTHER_POSTURE, ComparedQuantity, PredictError, Prediction, PreparedLog};
use std::collections::{BTreeMap, BTreeSet};
use trueweld_logs::log::{Log, LogKind, LogNotice, Samples};
use trueweld_logs::median;
use trueweld_logs::outlier::OUTLIER_DEVIATIONS;

/// Fewest loads of a posture of which one can be told to be off.
const POSTURE_LOADS_MIN: usize = 4;

/// Most loads of a log, as a share, that are outliers: what occurs more often is how the cell is.
const OUTLYING_LOADS_SHARE_MAX: f64 = 0.05;

/// Takes from loads at rest what other loads contradict, and says so in the logs' notices. `logs`:
/// those that the problem's logs were made of. Returns true where something was taken, so that they
/// are to be made ready again.
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

/// What a load reads in one quantity, by component.
type LoadReadings = BTreeMap<u8, LoadReading>;

struct LoadReading {
    measured: f64,
    /// What it misses the model by, over the noise.
    residual: f64,
}

fn outlying_loads(
    samples: &Samples,
    experiment: &PreparedLog,
    prediction: &Prediction,
) -> Vec<OutlyingLoads> {
    let mut of_quantity: BTreeMap<ComparedQuantity, BTreeMap<usize, LoadReadings>> =
        BTreeMap::new();
    let mut unit: BTreeMap<ComparedQuantity, f64> = BTreeMap::new();
    for (compared, residual) in experiment.compared.iter().zip(&prediction.residual) {
        let loads = of_quantity.entry(compared.quantity).or_default();
        let reading = LoadReading { measured: compared.measured, residual: *residual };
        loads.entry(compared.row).or_default().insert(compared.component, reading);
        unit.insert(compared.quantity, compared.deviation);
    }
    let postures = postures(samples);
    let told = of_quantity.into_iter().filter_map(|(quantity, loads)| {
        let unit = unit[&quantity];
        let (witnessed, alone): (Vec<_>, Vec<_>) =
            rows_read(&loads, &postures).partition(|rows| rows.len() >= POSTURE_LOADS_MIN);
        let mut off = off_median(&loads, &witnessed);
        let mut rows = few(far_out(&off), off.len());
        // What no other load of its posture can contradict is held against the whole log.
        let reach = largest_reach(&loads, &witnessed, &rows) / unit;
        let everywhere = off_median(&loads, &[loads.keys().copied().collect()]);
        let alone: BTreeSet<usize> = alone.into_iter().flatten().collect();
        let beyond = |row: &usize| alone.contains(row) && everywhere[row] > reach;
        let lone = far_out(&everywhere).into_iter().filter(beyond).collect();
        let lone = few(lone, alone.len());
        off.extend(lone.iter().map(|row| (*row, everywhere[row])));
        rows.extend(lone);
        rows.sort_unstable();
        let largest = rows.iter().map(|row| off[row]).fold(0.0, f64::max) * unit;
        let told = !rows.is_empty();
        told.then_some(OutlyingLoads { quantity, rows, largest })
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

/// Rows of each posture with a reading.
fn rows_read<'a>(
    loads: &'a BTreeMap<usize, LoadReadings>,
    postures: &'a [Vec<usize>],
) -> impl Iterator<Item = Vec<usize>> + 'a {
    let is_read = |row: &usize| loads.contains_key(row);
    postures.iter().map(move |rows| rows.iter().copied().filter(is_read).collect())
}

/// By how much each load is off the median of its group, over the noise.
fn off_median(
    loads: &BTreeMap<usize, LoadReadings>,
    groups: &[Vec<usize>],
) -> BTreeMap<usize, f64> {
    let mut off: BTreeMap<usize, f64> = BTreeMap::new();
    for rows in groups {
        for component in components(loads, rows) {
            let of = |row: &usize| loads[row].get(&component).map(|reading| reading.residual);
            let Some(middle) = median(&mut rows.iter().filter_map(of).collect::<Vec<_>>()) else {
                continue;
            };
            for row in rows {
                let miss = of(row).map_or(0.0, |residual| residual - middle);
                let sum: &mut f64 = off.entry(*row).or_default();
                *sum = sum.hypot(miss);
            }
        }
    }
    off
}

fn components(loads: &BTreeMap<usize, LoadReadings>, rows: &[usize]) -> Vec<u8> {
    rows.first().map_or_else(Vec::new, |row| loads[row].keys().copied().collect())
}

/// How far a quantity goes at one posture by its loads, at most, in its unit: further off than that,
/// a reading is not what the load does to the arm. Infinite where no posture tells.
fn largest_reach(
    loads: &BTreeMap<usize, LoadReadings>,
    postures: &[Vec<usize>],
    outliers: &[usize],
) -> f64 {
    let reach = |rows: &Vec<usize>| {
        let spans = components(loads, rows).into_iter().map(|component| {
            let usual = rows.iter().filter(|row| !outliers.contains(row));
            let read = usual.filter_map(|row| loads[row].get(&component));
            let [low, high] = read.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], one| {
                [low.min(one.measured), high.max(one.measured)]
            });
            (high - low).max(0.0)
        });
        spans.fold(0.0, f64::hypot)
    };
    postures.iter().map(reach).max_by(f64::total_cmp).unwrap_or(f64::INFINITY)
}

/// These rows, where they are few among so many; none otherwise.
fn few(rows: Vec<usize>, among: usize) -> Vec<usize> {
    let most = (OUTLYING_LOADS_SHARE_MAX * among as f64).ceil();
    if rows.len() as f64 <= most { rows } else { Vec::new() }
}

/// The rows that are off by far more than rows are.
fn far_out(off: &BTreeMap<usize, f64>) -> Vec<usize> {
    let usual = median(&mut off.values().copied().collect::<Vec<_>>()).unwrap_or(0.0).max(1.0);
    let far = off.iter().filter(|(_, off)| **off > OUTLIER_DEVIATIONS * usual);
    far.map(|(row, _)| *row).collect()
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
        let outliers = |off: &BTreeMap<usize, f64>| few(far_out(off), off.len());
        assert!(outliers(&loads(|_| 0.0)).is_empty());
        let far = loads(|row| if row % 25 == 7 { 100.0 } else { 0.0 });
        assert_eq!(outliers(&far), vec![7, 32, 57]);
        let near = loads(|row| if row == 7 { 5.0 } else { 0.0 });
        assert!(outliers(&near).is_empty(), "an effect that not all loads show");
        let often = loads(|row| if row % 6 == 5 { 100.0 } else { 0.0 });
        assert!(
            outliers(&often).is_empty(),
            "the largest load of every posture is how the cell is"
        );
    }

    #[test]
    fn a_load_is_judged_by_its_own_posture() {
        // Two postures whose places the tracker sees apart, and one load that is off.
        let value =
            |row: usize| if row < 5 { 3.0 } else { -40.0 } + if row == 8 { 9.0 } else { 0.0 };
        let loads = (0..10).map(|row| (row, readings(value(row)))).collect();
        let off = off_median(&loads, &[(0..5).collect(), (5..10).collect()]);
        assert!(off.iter().all(|(row, off)| (*row == 8) == (*off > 1.0)), "{off:?}");
        assert!((off[&8] - 9.0 * 2_f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn what_loads_do_at_a_posture_is_as_far_as_they_make_it_go() {
        let loads: BTreeMap<usize, LoadReadings> =
            (0..10).map(|row| (row, readings(row as f64))).collect();
        let postures = [(0..4).collect(), (4..10).collect()];
        assert!((largest_reach(&loads, &postures, &[9]) - 4.0 * 2_f64.sqrt()).abs() < 1e-12);
        assert_eq!(largest_reach(&loads, &[], &[]), f64::INFINITY);
    }

    fn readings(value: f64) -> LoadReadings {
        let reading = |value: f64| LoadReading { measured: value, residual: value };
        LoadReadings::from([(0, reading(value)), (1, reading(-value))])
    }
}
