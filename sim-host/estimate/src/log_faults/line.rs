//! The line on which the angles of one joint lie that is read wrongly: its slope and offset, from the
//! angle that the joint must have had in every row for the tool to be where it was seen, then refined
//! with all that may be off beside it.

use super::reading::{
    AT_REST, Best, EncoderReading, ExplainedReading, Tracker, is_near, misfit, plain_angle,
    pose_pairs, with,
};
use super::refine::{OUTLIER, quantile};
use super::rows::LogRow;
use crate::AUTOCORRELATION_INFLATION;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3, Vector6};
use std::f64::consts::{PI, TAU};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, Pose, Robot};
use trueweld_logs::{HALF_95, ROTATION_LENGTH, median};

/// Rows at which the angles of one joint are looked for.
const ANGLE_ROWS: usize = 40;

/// Least offset of an encoder that is a mistake in its zero, rad.
const ZERO: f64 = 0.02;

/// The line on which one joint's angles must lie, the simplest that leaves little.
pub(super) fn find(rows: &[&LogRow], robot: &Robot<f64>, joint: usize) -> Option<ExplainedReading> {
    let every = rows.len().div_ceil(ANGLE_ROWS).max(1);
    let few: Vec<&LogRow> = rows.iter().step_by(every).copied().collect();
    let points: Vec<(f64, f64)> = few
        .iter()
        .filter_map(|row| Some((row.encoder[joint], angle(row, robot, joint)?)))
        .collect();
    if points.len() < 2 {
        return None;
    }
    let mut best = Best { limit: f64::INFINITY, found: None };
    for (slope, offset) in lines(&points) {
        let reading = EncoderReading::Line(joint, slope, offset);
        let seen = pose_pairs(rows, robot, reading);
        best.take(with(&seen, Tracker::Plain).map(|e| ExplainedReading { reading, ..e }));
    }
    best.found
}

/// Lines through the points, simple ones first: slope, and offset in rad.
fn lines(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut found: Vec<(f64, f64)> = [1.0, -1.0]
        .iter()
        .map(|slope| (*slope, median_offset(points, *slope)))
        .filter(|l| l.1.abs() > ZERO)
        .collect();
    let degree = PI / 180.0;
    found.extend([degree, -degree, 1.0 / degree].map(|slope| (slope, 0.0)));
    // A gear: the slope through the points, by the medians of its two halves.
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = sorted.len() / 2;
    let middle = |part: &[(f64, f64)]| {
        let (mut x, mut y): (Vec<f64>, Vec<f64>) = part.iter().copied().unzip();
        (median(&mut x).unwrap_or(f64::NAN), median(&mut y).unwrap_or(f64::NAN))
    };
    let (low, high) = (middle(&sorted[..half]), middle(&sorted[half..]));
    let slope = (high.1 - low.1) / (high.0 - low.0);
    if slope.is_finite() && slope.abs() > 1e-4 && !is_near(slope.abs(), 1.0) {
        // Through zero, weighted by the angle, and with an offset.
        let (xy, xx) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 * p.1, s.1 + p.0 * p.0));
        found.push((xy / xx, 0.0));
        found.push((slope, low.1 - slope * low.0));
    }
    found
}

/// Offset of the line of this slope through the points, rad: their median around the circle.
fn median_offset(points: &[(f64, f64)], slope: f64) -> f64 {
    let first = points[0].1 - slope * points[0].0;
    let mut apart: Vec<f64> =
        points.iter().map(|(x, y)| (y - slope * x - first + PI).rem_euclid(TAU) - PI).collect();
    let offset = first + median(&mut apart).unwrap_or(0.0);
    (offset + PI).rem_euclid(TAU) - PI
}

/// The angle of one joint with which the tool would be nearest to where it was seen.
fn angle(row: &LogRow, robot: &Robot<f64>, joint: usize) -> Option<f64> {
    /// Angles that are tried first, over a whole turn.
    const LINE_ANGLES_TRIED: usize = 72;
    let position = row.position?;
    let frames = robot.frames(&row.encoder);
    let axis = frames.rotation[joint] * robot.parameters().joints[joint].axis;
    // The point that the tracker saw.
    let at = frames.tcp.position + frames.tcp.rotation * row.point;
    let seen = Pose { position: at, ..frames.tcp };
    let square = |by: f64| {
        // Only what lies behind the joint turns with it.
        let turned = turned_about(&seen, &frames.origin[joint], &(axis * by));
        squared_distance(&turned, &position, row.rotation.as_ref())
    };
    let step = TAU / LINE_ANGLES_TRIED as f64;
    let nearest = (0..LINE_ANGLES_TRIED)
        .map(|k| k as f64 * step - PI)
        .min_by(|a, b| square(*a).total_cmp(&square(*b)))?;
    // Golden section.
    let (mut low, mut high) = (nearest - step, nearest + step);
    for _ in 0..40 {
        let (a, b) = (high - 0.618 * (high - low), low + 0.618 * (high - low));
        if square(a) < square(b) { high = b } else { low = a }
    }
    let found = row.encoder[joint] + 0.5 * (low + high);
    Some((found + PI).rem_euclid(TAU) - PI)
}

/// A pose turned about a point by a rotation vector, rad.
fn turned_about(pose: &Pose<f64>, point: &Vector3<f64>, by: &Vector3<f64>) -> Pose<f64> {
    let turn = rotation_from_vector(by);
    Pose { position: point + turn * (pose.position - point), rotation: turn * pose.rotation }
}

/// Square of how far a pose is from one that was seen, whose rotation may be unknown, m².
fn squared_distance(
    pose: &Pose<f64>,
    position: &Vector3<f64>,
    rotation: Option<&Matrix3<f64>>,
) -> f64 {
    let turned = rotation.map_or(0.0, |r| rotation_vector(&pose.rotation.tr_mul(r)).norm_squared());
    (pose.position - position).norm_squared() + ROTATION_LENGTH * ROTATION_LENGTH * turned
}

/// What is refined: zeros of all joints, rad; the tracker's frame (position, m, and rotation vector);
/// and by what share the slope changes.
const LINE_FIT_NUMBERS: usize = JOINTS + 7;
const FRAME_INDEX: usize = JOINTS;
const SLOPE_INDEX: usize = JOINTS + 6;
/// Their values.
type LineNumbers = SVector<f64, LINE_FIT_NUMBERS>;

/// What zeros and frame of a cell are off by without a mistake, m and rad.
const USUAL: f64 = 3e-3;

/// What tracker and bending leave of a pose, m.
const POSE_NOISE: f64 = 3e-4;

/// An explanation by a line, refined on the arm's kinematics until it settles, an offset near a plain
/// angle set to it; and what a fitted slope is known to, as a share of it (half of 95 %).
pub(super) fn refined(
    explanation: ExplainedReading,
    rows: &[&LogRow],
    robot: &Robot<f64>,
) -> (ExplainedReading, f64) {
    let EncoderReading::Line(joint, slope, offset) = explanation.reading else {
        return (explanation, 0.0);
    };
    let is_whole = |whole: f64| is_near(slope.abs(), whole);
    if [PI / 180.0, 180.0 / PI].into_iter().any(is_whole) {
        return (explanation, 0.0);
    }
    let mut usual = LineNumbers::repeat(USUAL);
    // Nothing is known of what is wrong.
    if offset != 0.0 {
        usual[joint] = 1.0;
    }
    usual[SLOPE_INDEX] = if is_whole(1.0) { 1e-9 } else { 1.0 };
    // An arm in motion bends by more than its load at rest.
    let still: Vec<&LogRow> = rows.iter().filter(|row| row.at_rest).copied().collect();
    let rows_used = if still.len() >= AT_REST { &still[..] } else { rows };
    let line = LineFit { rows: rows_used, robot, joint, slope, offset };
    let mut by = LineNumbers::zeros();
    let mut fitted = 0.0;
    for _ in 0..LINE_FIT_ITERATIONS {
        let Some((step, deviation)) = line.step(&by, &usual) else {
            return (explanation, 0.0);
        };
        by += step;
        fitted = HALF_95 * deviation;
        if step.amax() < 1e-9 {
            break;
        }
    }
    let turned = (offset + by[joint] + PI).rem_euclid(TAU) - PI;
    let offset = if offset == 0.0 { 0.0 } else { plain_angle(turned) };
    let reading = EncoderReading::Line(joint, slope * (1.0 + by[SLOPE_INDEX]), offset);
    let identity = Pose::identity();
    let left = misfit(&pose_pairs(rows, robot, reading), &identity, &identity);
    (ExplainedReading { reading, left, ..explanation }, if is_whole(1.0) { 0.0 } else { fitted })
}

/// Steps of Gauss–Newton.
const LINE_FIT_ITERATIONS: usize = 20;

/// A line with rows that tell of it.
struct LineFit<'r> {
    rows: &'r [&'r LogRow],
    robot: &'r Robot<f64>,
    joint: usize,
    slope: f64,
    /// rad.
    offset: f64,
}

impl LineFit<'_> {
    /// One step of Gauss–Newton with outliers weighted down, and the slope's deviation.
    fn step(&self, by: &LineNumbers, usual: &LineNumbers) -> Option<(LineNumbers, f64)> {
        /// For slopes of the residuals by differences.
        const BY: f64 = 1e-6;
        let now = self.residuals(by);
        let varied: [Vec<Vector6<f64>>; LINE_FIT_NUMBERS] = std::array::from_fn(|k| {
            let mut by = *by;
            by[k] += BY;
            self.residuals(&by)
        });
        let mut normal = SMatrix::<f64, LINE_FIT_NUMBERS, LINE_FIT_NUMBERS>::from_diagonal(
            &usual.map(|v| v.powi(-2)),
        );
        let mut right = -by.component_div(&usual.component_mul(usual));
        let size = quantile(now.iter().map(Vector6::norm), 5)?.max(1.0);
        let (mut squares, mut count) = (0.0, 0.0);
        for (row, residual) in now.iter().enumerate() {
            let weight = (1.0 - (residual.norm() / (OUTLIER * size)).powi(2)).max(0.0).powi(2);
            let slopes = SMatrix::<f64, 6, LINE_FIT_NUMBERS>::from_fn(|c, k| {
                (varied[k][row][c] - residual[c]) / BY
            });
            normal += slopes.transpose() * slopes * weight;
            right -= slopes.transpose() * residual * weight;
            squares += weight * residual.norm_squared();
            count += 6.0 * weight;
        }
        let inverse = normal.try_inverse()?;
        let excess = (squares / f64::max(count, 1.0)).max(1.0);
        let step = inverse * right;
        step.sum().is_finite().then(|| {
            (
                step,
                (AUTOCORRELATION_INFLATION * excess * inverse[(SLOPE_INDEX, SLOPE_INDEX)]).sqrt(),
            )
        })
    }

    /// How far each row's pose is off with the numbers changed, over its noise.
    fn residuals(&self, by: &LineNumbers) -> Vec<Vector6<f64>> {
        let slope = self.slope * (1.0 + by[SLOPE_INDEX]);
        let line = EncoderReading::Line(self.joint, slope, self.offset);
        let frame = Pose {
            position: by.fixed_rows::<3>(FRAME_INDEX).into_owned(),
            rotation: rotation_from_vector(&by.fixed_rows::<3>(FRAME_INDEX + 3).into_owned()),
        };
        let mut residuals = Vec::with_capacity(self.rows.len());
        for row in self.rows {
            let encoder = line.of(&row.encoder) + by.fixed_rows::<JOINTS>(0);
            let Some(seen) = row.pose_pair(self.robot, &encoder) else { continue };
            let (position, rotation) = seen.left(&frame, &Pose::identity());
            let mut left = Vector6::zeros();
            left.fixed_rows_mut::<3>(0).copy_from(&position);
            left.fixed_rows_mut::<3>(3).copy_from(&(rotation * ROTATION_LENGTH));
            residuals.push(left / POSE_NOISE);
        }
        residuals
    }
}
