//! A tracker's frame to the last digit.
//!
//! A frame that was found from a hundred rows is known to some of their noise. Thousands of rows see
//! what it is off by, and a diagnosis would name it. So it is refined by every pose that the logs
//! compare, each over its noise, against the arm as the model bends it.

use super::Registered;
use crate::AUTOCORRELATION_INFLATION;
use crate::predict::{BaselineModel, Compared, ComparedQuantity, PreparedLog, filled_vectors};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use trueweld_core::Pose;
use trueweld_core::spatial::{rotation_from_vector, skew};
use trueweld_logs::HALF_95;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::noise::{NoiseLevels, instruments};
use trueweld_logs::register::{Mounting, REGISTRATION_NUMBERS, Registration};

/// Residuals beyond so many times their median are outliers.
pub(super) const OUTLIER: f64 = 6.0;

/// Median of the residuals over their noise up to which the model explains a log: of normal ones it
/// is 0.67.
const EXPLAINED_MEDIAN_MAX: f64 = 0.9;

/// Refines what was found of the trackers of `logs`, whose readings are taken to B already. They are
/// taken on, and `registered` with them. Logs that cannot be predicted have no say.
pub(super) fn refine(logs: &mut [Log], registered: &mut [Registered], model: &BaselineModel) {
    let levels = instruments(logs);
    for found in registered {
        let mut normal = SMatrix::<f64, REGISTRATION_NUMBERS, REGISTRATION_NUMBERS>::zeros();
        let mut right = SVector::<f64, REGISTRATION_NUMBERS>::zeros();
        let (mut squares, mut count) = (0.0, 0.0);
        let own = |(log, _): &(&Log, &NoiseLevels)| found.logs.contains(&log.name);
        let of_logs = logs.iter().zip(&levels).filter(own).filter_map(|(log, levels)| {
            let rows = slopes(log, levels, model)?;
            Some((log.kind, unexplained(&rows)?, rows))
        });
        let of_logs: Vec<(LogKind, f64, Vec<RegistrationRow>)> = of_logs.collect();
        // An arm in motion that the model does not explain is off by more than its load at rest.
        let at_rest = of_logs.iter().any(|(kind, ..)| *kind == LogKind::StaticLoad);
        let counts = |(kind, left, _): &&(LogKind, f64, Vec<RegistrationRow>)| {
            !at_rest || *kind == LogKind::StaticLoad || *left < EXPLAINED_MEDIAN_MAX
        };
        for (_, _, rows) in of_logs.iter().filter(counts) {
            // What is left of the frame is no outlier.
            let size = quantile(rows.iter().map(|(_, residual)| residual.abs()), 5).unwrap_or(0.0);
            let most = OUTLIER * size.max(1.0);
            for (slope, residual) in rows.iter().filter(|(_, residual)| residual.abs() < most) {
                let weight = (1.0 - (residual / most).powi(2)).powi(2);
                normal += slope * slope.transpose() * weight;
                right += slope * (weight * residual);
                squares += weight * residual * residual;
                count += weight;
            }
        }
        // The tool's offset stays nothing where it was not looked for.
        let looked_for = |k: usize| k < 6 || found.registration.tool_interval[k - 6] > 0.0;
        for k in (0..REGISTRATION_NUMBERS).filter(|k| !looked_for(*k)) {
            normal.row_mut(k).fill(0.0);
            normal.column_mut(k).fill(0.0);
            normal[(k, k)] = 1.0;
            right[k] = 0.0;
        }
        let Some(factor) = normal.cholesky() else { continue };
        let by = factor.solve(&right);
        if !by.sum().is_finite() {
            continue;
        }
        let pose = |k: usize| Pose {
            rotation: rotation_from_vector(&by.fixed_rows::<3>(k + 3).into_owned()),
            position: by.fixed_rows::<3>(k).into_owned(),
        };
        let by = Mounting { frame: pose(0), tool: pose(6) };
        let mounting = &mut found.registration.mounting;
        let turn = mounting.frame.rotation;
        *mounting = *mounting * by;
        let covariance = factor.inverse()
            * AUTOCORRELATION_INFLATION
            * (squares / f64::max(count, 1.0)).max(1.0);
        intervals(&mut found.registration, &covariance, &turn);
        for log in logs.iter_mut().filter(|log| found.logs.contains(&log.name)) {
            log.register(&by, &model.robot);
        }
    }
}

/// Median of what no frame takes out of the residuals of a log.
fn unexplained(rows: &[RegistrationRow]) -> Option<f64> {
    let mut normal = SMatrix::<f64, 6, 6>::zeros();
    let mut right = SVector::<f64, 6>::zeros();
    for (slope, residual) in rows {
        let slope = slope.fixed_rows::<6>(0);
        normal += slope * slope.transpose();
        right += slope * *residual;
    }
    // One posture alone fixes no frame.
    let least = 1e-9 * normal.trace();
    (0..6).for_each(|k| normal[(k, k)] += least);
    let by = normal.cholesky()?.solve(&right);
    quantile(rows.iter().map(|(slope, r)| (r - slope.fixed_rows::<6>(0).dot(&by)).abs()), 5)
}

/// The value that so many tenths of some values are below; `None` of none.
pub(super) fn quantile(values: impl Iterator<Item = f64>, tenths: usize) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() * tenths / 10).copied()
}

/// Takes over the intervals of a covariance in axes of B; `turn`: to the tracker's.
fn intervals(
    registration: &mut Registration,
    covariance: &SMatrix<f64, REGISTRATION_NUMBERS, REGISTRATION_NUMBERS>,
    turn: &Matrix3<f64>,
) {
    for part in [0, 3] {
        let own = covariance.fixed_view::<3, 3>(part, part);
        let own = turn * own * turn.transpose();
        (0..3).for_each(|k| registration.frame_interval[part + k] = HALF_95 * own[(k, k)].sqrt());
    }
    for (k, interval) in registration.tool_interval.iter_mut().enumerate() {
        if *interval > 0.0 {
            *interval = HALF_95 * covariance[(6 + k, 6 + k)].sqrt();
        }
    }
}

/// Slopes of a value by frame and tool's offset, over its noise, and its residual.
type RegistrationRow = (SVector<f64, REGISTRATION_NUMBERS>, f64);

/// Every component of a pose that a log compares. `None` where the log cannot be predicted.
fn slopes(log: &Log, levels: &NoiseLevels, model: &BaselineModel) -> Option<Vec<RegistrationRow>> {
    let experiment = PreparedLog::new(log, levels, model).ok()?;
    let residual = experiment.predict(model, &[], None).ok()?.residual;
    let samples = &log.samples;
    // Between the readings of a slow tracker its band is compared as well.
    let (positions, rotations) = (filled_vectors(&samples.position)?, samples.rotation.as_ref());
    let slope = |compared: &Compared| {
        let read = rotations.map(|r| r[compared.row]).filter(|r| r.sum().is_finite());
        let nominal = || model.robot.forward_kinematics(&samples.encoder[compared.row]).rotation;
        let rotation = read.map_or_else(nominal, |r| rotation_from_vector(&r));
        let position = Vector3::from_fn(|c, _| positions[c][compared.row]);
        registration_slope(compared, &position, &rotation)
    };
    let rows = experiment.compared.iter().zip(residual);
    Some(rows.filter_map(|(compared, residual)| Some((slope(compared)?, residual))).collect())
}

/// Slope of one component of a pose by frame and tool's offset, over its noise; `None` of another
/// quantity, or where the pose was not read. `position` in B, m; `rotation`: of T in B.
fn registration_slope(
    compared: &Compared,
    position: &Vector3<f64>,
    rotation: &Matrix3<f64>,
) -> Option<SVector<f64, REGISTRATION_NUMBERS>> {
    // Of a component of a pose alone: those of other quantities may be more than three.
    let axis = || Vector3::ith(usize::from(compared.component), 1.0);
    let mut slope = SVector::<f64, REGISTRATION_NUMBERS>::zeros();
    match compared.quantity {
        ComparedQuantity::Position => {
            slope.fixed_rows_mut::<3>(0).copy_from(&axis());
            slope.fixed_rows_mut::<3>(3).copy_from(&(skew(position) * axis()));
            slope.fixed_rows_mut::<3>(6).copy_from(&rotation.tr_mul(&axis()));
        }
        ComparedQuantity::Rotation => {
            slope.fixed_rows_mut::<3>(3).copy_from(&(rotation * axis()));
            slope.fixed_rows_mut::<3>(9).copy_from(&axis());
        }
        _ => return None,
    }
    slope /= compared.deviation;
    slope.sum().is_finite().then_some(slope)
}
