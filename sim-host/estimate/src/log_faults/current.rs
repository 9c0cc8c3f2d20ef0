//! Motor torques that are read as a current, whose factor no file states: the factor that makes of
//! them what the model needs for the motion. What it is off by is then a calibration.

use super::load::CLEAR;
use super::relation::regression;
use super::rows::LogRow;
use crate::AUTOCORRELATION_INFLATION;
use nalgebra::{Matrix4, SVector, Vector4};
use trueweld_core::{JOINTS, Robot};
use trueweld_logs::HALF_95;
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{FoundFactor, Log, LogNotice};

/// Turns such columns into torque, one factor a joint for all logs that have its current in one unit, the
/// first that shows its factor; what is in another, or shows none, is left out. True where there was one.
pub(super) fn scale(
    logs: &mut [Log],
    rows: &[Vec<LogRow>],
    robot: &Robot<f64>,
    stated: &[Option<f64>; JOINTS],
) -> bool {
    let mut is_any = false;
    let mut found_factors = vec![Vec::new(); logs.len()];
    for joint in 0..JOINTS {
        let units: Vec<Option<&'static str>> = logs
            .iter()
            .map(|log| log.origin.currents[joint].filter(|c| c.factor.is_none()).map(|c| c.unit))
            .collect();
        let mut with_factor: Option<&'static str> = None;
        for (first, unit) in units.iter().enumerate().filter_map(|(k, unit)| Some((k, (*unit)?))) {
            if units[..first].contains(&Some(unit)) {
                continue;
            }
            is_any = true;
            let same: Vec<usize> = (0..logs.len()).filter(|k| units[*k] == Some(unit)).collect();
            let moved: Vec<&LogRow> = same.iter().flat_map(|k| &rows[*k]).collect();
            let has_rotor = |joint: usize| !logs[first].robot.unknown_rotor[joint];
            let stated = stated[joint].map(|factor| (factor, None));
            let fitted =
                || factor(&moved, robot, has_rotor(joint), joint).map(|[f, half]| (f, Some(half)));
            let found = if with_factor.is_some() { None } else { stated.or_else(fitted) };
            let column = LogChannel::MotorTorque.entry().columns[joint];
            for k in same {
                logs[k].scale_current(joint, found.map(|(factor, _)| factor));
            }
            match (found, with_factor) {
                (Some((factor, interval)), _) => {
                    with_factor = Some(unit);
                    let factor = FoundFactor { column, unit, factor, interval };
                    found_factors[first].push(factor);
                }
                (None, Some(other)) => {
                    let notice = LogNotice::FactorOfAnotherUnit { column, unit, other };
                    logs[first].notices.push(notice);
                }
                (None, None) => {
                    logs[first].notices.push(LogNotice::FactorUnknown { column, unit });
                }
            }
        }
    }
    for (log, found) in logs.iter_mut().zip(found_factors).filter(|(_, found)| !found.is_empty()) {
        log.notices.push(LogNotice::FactorsFound(found));
    }
    is_any
}

/// What parts of a model's torque may be off by, one standard deviation as a share: masses and
/// inertias of a drawing, and friction, which a rule of thumb gives to a factor of two.
const MASSES_DEVIATION: f64 = 0.1;
const FRICTION_DEVIATION: f64 = 0.5;

/// Torque per unit of what was recorded, N·m, with its 95 % half-width. What was recorded is
/// u Σ (1 + e_i) p_i + c of the parts p_i of the model's torque, each off by a share e_i: the slopes
/// by the parts have a mean u, weighed by what noise and these shares leave of each. `None` where
/// nothing recorded follows the model.
fn factor(rows: &[&LogRow], robot: &Robot<f64>, has_rotor: bool, joint: usize) -> Option<[f64; 2]> {
    let friction = &robot.parameters().friction;
    let rotor = robot.rotor_inertia()[joint];
    let regressors = |row: &&LogRow| {
        let all = row.motor_torque(robot, row.motion());
        let by_rotor = rotor * row.acceleration[joint];
        let viscous = friction.viscous[joint] * row.rate[joint];
        let links = all.held[joint] + all.inertia[joint] - by_rotor;
        let parts = [links, by_rotor, viscous, all.friction[joint] - viscous, 1.0];
        (SVector::from(parts), row.torque[joint])
    };
    let (slopes, covariance) = regression(rows.iter().map(regressors))?;
    let slopes: Vector4<f64> = slopes.fixed_rows::<4>(0).into_owned();
    let noise: Matrix4<f64> = covariance.fixed_view::<4, 4>(0, 0).into_owned();
    let rotor_deviation = if has_rotor { MASSES_DEVIATION } else { 1.0 };
    let shares =
        [MASSES_DEVIATION, rotor_deviation, FRICTION_DEVIATION, FRICTION_DEVIATION].map(|s| s * s);
    let shares = Matrix4::from_diagonal(&Vector4::from(shares));
    let mean = |spread: Matrix4<f64>| {
        let weights = spread.try_inverse()? * Vector4::repeat(1.0);
        Some([weights.dot(&slopes) / weights.sum(), weights.sum().powf(-0.5)])
    };
    let [mut scale, mut deviation] = mean(noise)?;
    if scale.is_nan() || scale.abs() < CLEAR * deviation {
        return None;
    }
    // The shares are of the mean: to where it stays.
    for _ in 0..20 {
        [scale, deviation] = mean(noise * AUTOCORRELATION_INFLATION + shares * scale.powi(2))?;
    }
    Some([1.0 / scale, HALF_95 * deviation / scale.powi(2)])
}
