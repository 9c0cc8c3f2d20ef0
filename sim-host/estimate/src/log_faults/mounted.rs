//! A wrench that was measured in other axes than the tool's, or whose moment is about another point
//! than the tool centre point: how the sensor sits, from how the arm gives way along the load.
//!
//! With axes R and point p of the sensor in T, a reading (f, m) is the wrench (R f, R m + p × R f).
//! R and p, and by how much the arm gives more than the model says, follow by Gauss–Newton from plain
//! mountings. Of a weld the model expects no moment at the tool centre point, which tells p better by
//! far; it has a say only where the arm agrees. What the load never showed stays near nothing.

use super::deflections::{COMPLIANCE_RATIO_RANGE, Deflected, Deflections, EQUAL_SQUARES_RATIO};
use crate::AUTOCORRELATION_INFLATION;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};
use std::f64::consts::FRAC_PI_2;
use trueweld_core::Pose;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector, skew};
use trueweld_logs::HALF_95;

/// What is fitted: axes, a rotation vector; point, m; how many times as much the arm gives.
const MOUNTING_NUMBERS: usize = 7;
const POINT_INDEX: usize = 3;
const COMPLIANCE_INDEX: usize = 6;

/// Steps of Gauss–Newton.
const MOUNTING_ITERATIONS: usize = 20;

/// Parts of the logs whose disagreement counts.
const LOG_PARTS: usize = 10;

/// Plain mountings from which the axes are looked for.
const MOUNTING_STARTS: usize = 3;

/// Least distance, m, and angle, rad, of a sensor that is a mistake: less is a calibration, or
/// crosstalk.
const MOUNTING_MISTAKE_MIN: [f64; 2] = [0.03, 10.0 * std::f64::consts::PI / 180.0];

/// Angle to a plain mounting within which it is one, rad.
const PLAIN_MOUNTING_ANGLE: f64 = 0.5 * std::f64::consts::PI / 180.0;

/// What a point may be away where nothing tells, m.
const ANYWHERE: f64 = 1.0;

/// How a force sensor sits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mounted {
    /// Its axes, and the point that its moment is about, in T: `t_from_sensor`.
    pub pose: Pose<f64>,
    /// 95 % half-widths of the point, m, and of the axes, rad; zero of what was not fitted.
    pub interval: [[f64; 3]; 2],
}

/// What a sensor that sits so reads, as a wrench at the tool centre point in T: force, then moment.
pub(super) fn at_tool(pose: &Pose<f64>, read: &Vector6<f64>) -> Vector6<f64> {
    let [force, moment] = parts(read).map(|v| pose.rotation * v);
    joined(&force, &(moment + pose.position.cross(&force)))
}

fn parts(wrench: &Vector6<f64>) -> [Vector3<f64>; 2] {
    [0, 3].map(|first| wrench.fixed_rows::<3>(first).into_owned())
}

fn joined(force: &Vector3<f64>, moment: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(force.x, force.y, force.z, moment.x, moment.y, moment.z)
}

/// Axes square to the tool's, and those between about the tool's.
fn plain_axes() -> Vec<Matrix3<f64>> {
    let turned = |axis: Vector3<f64>, quarters: f64| rotation_from_vector(&(axis * quarters));
    let tilts = [
        Matrix3::identity(),
        turned(Vector3::x(), FRAC_PI_2),
        turned(Vector3::x(), -FRAC_PI_2),
        turned(Vector3::x(), 2.0 * FRAC_PI_2),
        turned(Vector3::y(), FRAC_PI_2),
        turned(Vector3::y(), -FRAC_PI_2),
    ];
    let about = |k: i32| turned(Vector3::z(), 0.5 * FRAC_PI_2 * f64::from(k));
    (0..8).flat_map(|k| tilts.map(|tilt| about(k) * tilt)).collect()
}

fn angle(rotation: &Matrix3<f64>) -> f64 {
    rotation_vector(rotation).norm()
}

/// A fit: the mounting, what it leaves, m², and the covariance of all that was fitted.
struct MountingFit {
    pose: Pose<f64>,
    left: f64,
    covariance: SMatrix<f64, MOUNTING_NUMBERS, MOUNTING_NUMBERS>,
}

/// Fits how the sensor sits, from `start`; `turned` and `moved`: whether its axes, and its point, are
/// looked for.
fn fit(rows: &[Deflected], start: Pose<f64>, [turned, moved]: [bool; 2]) -> Option<MountingFit> {
    let is_free = |k: usize| match k {
        ..POINT_INDEX => turned,
        COMPLIANCE_INDEX => true,
        _ => moved,
    };
    let (mut pose, mut more) = (start, 1.0);
    let mut fitted = None;
    for _ in 0..MOUNTING_ITERATIONS {
        let mut normal = SMatrix::<f64, MOUNTING_NUMBERS, MOUNTING_NUMBERS>::zeros();
        let mut left = 0.0;
        // What the model lacks is the same in many rows: parts of the logs disagree by more than noise.
        let mut parted = [SVector::<f64, MOUNTING_NUMBERS>::zeros(); LOG_PARTS];
        for (k, row) in rows.iter().enumerate() {
            let part = &mut parted[k * LOG_PARTS / rows.len()];
            let [force, moment] = parts(&row.wrench).map(|v| pose.rotation * v);
            let by = row.compliance * joined(&force, &(moment + pose.position.cross(&force)));
            let rest = row.moved - by * more;
            let mut slopes = SMatrix::<f64, 6, MOUNTING_NUMBERS>::zeros();
            for k in 0..3 {
                let axis = Vector3::ith(k, 1.0);
                let (sideways, twisted) = (axis.cross(&force), axis.cross(&moment));
                let turned = joined(&sideways, &(twisted + pose.position.cross(&sideways)));
                let moved = joined(&Vector3::zeros(), &sideways);
                slopes.set_column(k, &(row.compliance * turned * more));
                slopes.set_column(POINT_INDEX + k, &(row.compliance * moved * more));
            }
            slopes.set_column(COMPLIANCE_INDEX, &by);
            normal += slopes.transpose() * slopes;
            *part += slopes.transpose() * rest;
            left += rest.norm_squared();
        }
        let variance = left / (6 * rows.len()) as f64;
        let mut right = parted.iter().sum::<SVector<f64, MOUNTING_NUMBERS>>();
        for k in (0..MOUNTING_NUMBERS).filter(|k| !is_free(*k)) {
            normal.row_mut(k).fill(0.0);
            normal.column_mut(k).fill(0.0);
            normal[(k, k)] = variance;
            right[k] = 0.0;
        }
        for k in 0..3 {
            normal[(POINT_INDEX + k, POINT_INDEX + k)] += variance / (ANYWHERE * ANYWHERE);
            right[POINT_INDEX + k] -= variance / (ANYWHERE * ANYWHERE) * pose.position[k];
        }
        let inverse = normal.cholesky()?.inverse();
        let step = inverse * right;
        if !step.sum().is_finite() {
            return None;
        }
        let apart = parted.map(|part| {
            let free = SVector::from_fn(|k, _| if is_free(k) { part[k] } else { 0.0 });
            let moves = inverse * free;
            moves * moves.transpose()
        });
        let covariance = inverse * (AUTOCORRELATION_INFLATION * variance)
            + apart.iter().sum::<SMatrix<f64, MOUNTING_NUMBERS, MOUNTING_NUMBERS>>();
        fitted = Some(MountingFit { pose, left, covariance });
        pose.rotation = rotation_from_vector(&step.fixed_rows::<3>(0).into_owned()) * pose.rotation;
        pose.position += step.fixed_rows::<3>(POINT_INDEX);
        more = (more + step[COMPLIANCE_INDEX])
            .clamp(COMPLIANCE_RATIO_RANGE[0], COMPLIANCE_RATIO_RANGE[1]);
        if step.amax() < 1e-9 {
            break;
        }
    }
    fitted
}

/// The point that the moments of a weld speak for beside the arm, and its covariance: they vanish
/// there.
fn by_moments(
    deflections: &Deflections,
    MountingFit { pose, covariance, .. }: &MountingFit,
) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let read =
        || deflections.weld_wrenches.iter().map(|read| parts(read).map(|v| pose.rotation * v));
    let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for [force, moment] in read() {
        let across = skew(&force);
        normal += across.tr_mul(&across);
        right += across.tr_mul(&moment);
    }
    let least = Matrix3::from_diagonal_element(1e-9 * normal.trace());
    let alone = (normal + least).cholesky()?.solve(&right);
    let left = read().map(|[force, moment]| (moment + alone.cross(&force)).norm_squared());
    let (count, left) = left.fold((0.0, 0.0), |(count, sum), square| (count + 3.0, sum + square));
    let variance = AUTOCORRELATION_INFLATION * left / count;
    // What the arm says of the point, whatever it gives.
    let by_arm =
        covariance.fixed_view::<3, 3>(POINT_INDEX, POINT_INDEX).into_owned().cholesky()?.inverse();
    let both = (by_arm + normal / variance).cholesky()?;
    Some((both.solve(&(by_arm * pose.position + right / variance)), both.inverse()))
}

/// How the sensor sits, where its axes (`turned`), its point (`moved`) or both are elsewhere; `None`
/// where that is not so.
pub(super) fn find(deflections: &Deflections, [turned, moved]: [bool; 2]) -> Option<Mounted> {
    if moved && !deflections.has_moments {
        return None;
    }
    let rows = &deflections.rows;
    let identity = Pose::identity();
    let mut found = if turned {
        let start = |rotation| Pose { rotation, ..identity };
        let left = |pose: &Pose<f64>| deflections.left_by(|read| at_tool(pose, read));
        let mut starts: Vec<Pose<f64>> = plain_axes().into_iter().map(start).collect();
        starts.sort_by(|a, b| left(a).total_cmp(&left(b)));
        let fits =
            starts[..MOUNTING_STARTS].iter().filter_map(|start| fit(rows, *start, [true, moved]));
        fits.min_by(|a, b| a.left.total_cmp(&b.left))?
    } else {
        fit(rows, identity, [false, true])?
    };
    let widths = |fit: &MountingFit, first: usize| {
        [0, 1, 2].map(|k| HALF_95 * fit.covariance[(first + k, first + k)].sqrt())
    };
    let mut interval = [[0.0; 3]; 2];
    if turned {
        interval[1] = widths(&found, 0);
        let near = PLAIN_MOUNTING_ANGLE.max(interval[1].iter().fold(0.0, |a: f64, b| a.max(*b)));
        let away = |axes: &Matrix3<f64>| angle(&(axes.transpose() * found.pose.rotation));
        let plain = plain_axes().into_iter().min_by(|a, b| away(a).total_cmp(&away(b)));
        if let Some(rotation) = plain.filter(|axes| away(axes) < near) {
            interval[1] = [0.0; 3];
            found = fit(rows, Pose { rotation, ..found.pose }, [false, moved])?;
        }
    }
    if moved {
        interval[0] = widths(&found, POINT_INDEX);
        if let Some((point, covariance)) = by_moments(deflections, &found) {
            let pose = Pose { position: point, ..found.pose };
            if deflections.left_by(|read| at_tool(&pose, read)) < EQUAL_SQUARES_RATIO * found.left {
                found.pose = pose;
                // The moments tell the point in the sensor's axes, and these are fitted as well.
                let lever = skew(&point);
                let turns = Matrix3::from_diagonal(&Vector3::from(interval[1]).map(|w| w * w));
                let squares = covariance * (HALF_95 * HALF_95) + lever * turns * lever.transpose();
                interval[0] = [0, 1, 2].map(|k| squares[(k, k)].sqrt());
            }
        }
    }
    let is_elsewhere = (!moved || found.pose.position.norm() > MOUNTING_MISTAKE_MIN[0])
        && (!turned || angle(&found.pose.rotation) > MOUNTING_MISTAKE_MIN[1]);
    is_elsewhere.then_some(Mounted { pose: found.pose, interval })
}
