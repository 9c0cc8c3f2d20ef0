//! Where a tracker stands and where on the tool it looks: rigid motions of any size, found from
//! measured against nominal poses.
//!
//! ```text
//! p = t + R (x + X c),   P = R X S        measured position p and rotation P
//! ```
//!
//! of a nominal tool pose (x, X): R, t the tracker's frame, c, S where the tracked point and its axes
//! sit in the tool frame. Rotations follow from singular value decompositions (Kabsch), positions
//! from a linear fit; then all of it is refined by Gauss–Newton, outliers weighted down (Tukey).

use crate::{HALF_95, ROTATION_LENGTH};
use nalgebra::{DMatrix, DVector, Matrix3, SMatrix, SVector, Vector3};
use trueweld_core::Pose;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector, skew};

/// Iterations of weights and of Gauss–Newton.
const REGISTRATION_ITERATIONS: usize = 30;

/// Parameters: frame (position, rotation vector), then tool (position, rotation vector).
pub const REGISTRATION_NUMBERS: usize = 12;

/// Least extent of the positions in their second direction, m, that fixes a frame without rotations.
const POSITION_SPREAD_MIN: f64 = 0.05;

/// One measured pose and the nominal one.
#[derive(Debug, Clone, Copy)]
pub struct PosePair {
    /// Nominal pose of the tool, `b_from_t`.
    pub nominal: Pose<f64>,
    /// Measured position, m.
    pub position: Vector3<f64>,
    /// Measured rotation, where the tracker tells it.
    pub rotation: Option<Matrix3<f64>>,
}

impl PosePair {
    /// What is left of it: position, m, and rotation, rad.
    pub fn left(&self, frame: &Pose<f64>, tool: &Pose<f64>) -> (Vector3<f64>, Vector3<f64>) {
        let seen = Pose {
            rotation: frame.rotation * self.nominal.rotation * tool.rotation,
            position: frame.transform_point(&self.nominal.transform_point(&tool.position)),
        };
        let turned = self
            .rotation
            .map_or(Vector3::zeros(), |r| rotation_vector(&(r * seen.rotation.transpose())));
        (self.position - seen.position, turned)
    }

    /// Square of what is left of it, m².
    pub fn square(&self, frame: &Pose<f64>, tool: &Pose<f64>) -> f64 {
        let (position, rotation) = self.left(frame, tool);
        position.norm_squared() + ROTATION_LENGTH * ROTATION_LENGTH * rotation.norm_squared()
    }
}

/// Where a tracker stands, and what it sees of the tool.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mounting {
    /// The robot's base seen by the tracker, `tracker_from_b`.
    pub frame: Pose<f64>,
    /// The tracked point and its axes in the tool frame, `t_from_seen`.
    pub tool: Pose<f64>,
}

impl Mounting {
    /// A tracker in the robot's base that sees the tool centre point.
    pub fn none() -> Self {
        Self { frame: Pose::identity(), tool: Pose::identity() }
    }

    /// What the tracker would have measured in B, at the tool centre point. A position alone needs
    /// the `nominal` rotation of the tool.
    pub fn corrected(
        &self,
        position: &Vector3<f64>,
        rotation: Option<&Matrix3<f64>>,
        nominal: &Matrix3<f64>,
    ) -> (Vector3<f64>, Option<Matrix3<f64>>) {
        let back = self.frame.rotation.transpose();
        let turned = rotation.map(|r| back * r * self.tool.rotation.transpose());
        let seen = back * (position - self.frame.position);
        (seen - turned.unwrap_or(*nominal) * self.tool.position, turned)
    }
}

/// What is left of a mounting once the first one is taken out: both together.
impl std::ops::Mul for Mounting {
    type Output = Self;
    fn mul(self, left: Self) -> Self {
        Self { frame: self.frame * left.frame, tool: left.tool * self.tool }
    }
}

/// Frame and tool's offset as found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Registration {
    /// Where the tracker stands, and what it sees.
    pub mounting: Mounting,
    /// 95 % half-widths of the frame: position, m, and rotation about the tracker's axes, rad.
    pub frame_interval: [f64; 6],
    /// The same of the tool's offset; zero where it was not looked for.
    pub tool_interval: [f64; 6],
    /// Root mean square of what is left: position, m, and rotation, rad.
    pub left: [f64; 2],
    /// Poses that it rests on.
    pub poses: usize,
}

/// The rotation nearest to a matrix.
fn nearest_rotation(matrix: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let svd = matrix.svd(true, true);
    let (u, v_t) = (svd.u?, svd.v_t?);
    let mut flip = Matrix3::identity();
    flip[(2, 2)] = (u * v_t).determinant().signum();
    let rotation = u * flip * v_t;
    rotation.sum().is_finite().then_some(rotation)
}

/// The frame alone in closed form. `weights`: of each pair. `None` where the pairs do not
/// fix one: without rotations and all along one line.
fn closed(pose_pairs: &[PosePair], weights: &[f64], tool: &Pose<f64>) -> Option<Pose<f64>> {
    let sum: f64 = weights.iter().sum();
    let points =
        || pose_pairs.iter().map(|s| s.nominal.transform_point(&tool.position)).zip(weights);
    let from = points().map(|(p, w)| p * *w).sum::<Vector3<f64>>() / sum;
    let to =
        pose_pairs.iter().zip(weights).map(|(s, w)| s.position * *w).sum::<Vector3<f64>>() / sum;
    let (mut cross, mut spread) = (Matrix3::zeros(), Matrix3::zeros());
    let mut rotations = false;
    for ((point, w), pose_pair) in points().zip(pose_pairs) {
        let (a, b) = (point - from, pose_pair.position - to);
        cross += b * a.transpose() * *w;
        spread += a * a.transpose() * (*w / sum);
        if let Some(rotation) = pose_pair.rotation {
            let nominal = pose_pair.nominal.rotation * tool.rotation;
            cross += rotation * nominal.transpose() * (ROTATION_LENGTH * ROTATION_LENGTH * *w);
            rotations = true;
        }
    }
    let mut extent = spread.symmetric_eigenvalues();
    extent.as_mut_slice().sort_by(f64::total_cmp);
    if !rotations && extent[1] < POSITION_SPREAD_MIN * POSITION_SPREAD_MIN {
        return None;
    }
    let rotation = nearest_rotation(&cross)?;
    Some(Pose { rotation, position: to - rotation * from })
}

/// Weights by Tukey's biweight of what is left, beyond several times its median.
fn weights(pose_pairs: &[PosePair], frame: &Pose<f64>, tool: &Pose<f64>) -> Vec<f64> {
    let left: Vec<f64> = pose_pairs.iter().map(|s| s.square(frame, tool).sqrt()).collect();
    let mut sorted = left.clone();
    sorted.sort_by(f64::total_cmp);
    let scale = (6.0 * sorted[sorted.len() / 2]).max(1e-9);
    let weight = |r: &f64| (1.0 - (r / scale).powi(2)).max(1e-6).powi(2);
    left.iter().map(weight).collect()
}

/// The frame of a tracker that looks at the tool centre point. `None` where too little was seen.
pub fn frame(pose_pairs: &[PosePair]) -> Option<Registration> {
    if pose_pairs.is_empty() {
        return None;
    }
    let tool = Pose::identity();
    let mut weight = vec![1.0; pose_pairs.len()];
    let mut frame = closed(pose_pairs, &weight, &tool)?;
    for _ in 0..REGISTRATION_ITERATIONS / 3 {
        weight = weights(pose_pairs, &frame, &tool);
        frame = closed(pose_pairs, &weight, &tool)?;
    }
    Some(refined(pose_pairs, frame, tool, 6))
}

/// Frame and tool's offset. `None` where too little was seen.
pub fn frame_and_tool(pose_pairs: &[PosePair]) -> Option<Registration> {
    if pose_pairs.len() < 4 {
        return None;
    }
    let even = vec![1.0; pose_pairs.len()];
    let mut tool = Pose::identity();
    let mut frame = closed(pose_pairs, &even, &tool)?;
    if pose_pairs.iter().all(|s| s.rotation.is_some()) {
        // R X S = P: each rotation in turn, the other one given.
        for _ in 0..10 * REGISTRATION_ITERATIONS {
            let sum = |of: &dyn Fn(&PosePair, &Matrix3<f64>) -> Matrix3<f64>| {
                let each = pose_pairs.iter().filter_map(|s| Some(of(s, s.rotation.as_ref()?)));
                nearest_rotation(&each.fold(Matrix3::zeros(), |a, b| a + b))
            };
            let (r, s) = (frame.rotation, tool.rotation);
            frame.rotation = sum(&|at, p| p * (at.nominal.rotation * s).transpose())?;
            tool.rotation = sum(&|at, p| (frame.rotation * at.nominal.rotation).transpose() * p)?;
            if (frame.rotation - r).amax().max((tool.rotation - s).amax()) < 1e-13 {
                break;
            }
        }
        // p − R x = t + R X c, linear in t and c.
        let mut left = SMatrix::<f64, 6, 6>::zeros();
        let mut right = SVector::<f64, 6>::zeros();
        for s in pose_pairs {
            let mut row = SMatrix::<f64, 3, 6>::zeros();
            row.fixed_columns_mut::<3>(0).copy_from(&Matrix3::identity());
            row.fixed_columns_mut::<3>(3).copy_from(&(frame.rotation * s.nominal.rotation));
            left += row.tr_mul(&row);
            right += row.tr_mul(&(s.position - frame.rotation * s.nominal.position));
        }
        // Where all poses look alike, the tool's offset stays as small as it can be.
        let least = 1e-9 * left.trace();
        (3..6).for_each(|k| left[(k, k)] += least);
        let solved = left.cholesky()?.solve(&right);
        frame.position = solved.fixed_rows::<3>(0).into_owned();
        tool.position = solved.fixed_rows::<3>(3).into_owned();
    }
    Some(refined(pose_pairs, frame, tool, REGISTRATION_NUMBERS))
}

/// Refines a registration; the first `free` of all parameters are free.
fn refined(
    pose_pairs: &[PosePair],
    mut frame: Pose<f64>,
    mut tool: Pose<f64>,
    free: usize,
) -> Registration {
    let rotations = pose_pairs.iter().any(|s| s.rotation.is_some());
    // Without rotations nothing tells how the tracked point's axes are turned.
    let free = if rotations { free } else { free.min(9) };
    let mut normal = DMatrix::<f64>::zeros(free, free);
    for _ in 0..REGISTRATION_ITERATIONS {
        let weight = weights(pose_pairs, &frame, &tool);
        normal.fill(0.0);
        let mut right = DVector::<f64>::zeros(free);
        for (s, w) in pose_pairs.iter().zip(&weight) {
            let (position, rotation) = s.left(&frame, &tool);
            let point = frame.rotation * s.nominal.transform_point(&tool.position);
            let axes = frame.rotation * s.nominal.rotation;
            // Frame: t, and a turn about the tracker's axes; tool: c, and a turn about its own.
            let mut row = SMatrix::<f64, 6, REGISTRATION_NUMBERS>::zeros();
            row.fixed_view_mut::<3, 3>(0, 0).copy_from(&Matrix3::identity());
            row.fixed_view_mut::<3, 3>(0, 3).copy_from(&-skew(&point));
            row.fixed_view_mut::<3, 3>(0, 6).copy_from(&axes);
            if s.rotation.is_some() {
                row.fixed_view_mut::<3, 3>(3, 3)
                    .copy_from(&(Matrix3::identity() * ROTATION_LENGTH));
                row.fixed_view_mut::<3, 3>(3, 9)
                    .copy_from(&(axes * tool.rotation * ROTATION_LENGTH));
            }
            let mut left = SVector::<f64, 6>::zeros();
            left.fixed_rows_mut::<3>(0).copy_from(&position);
            left.fixed_rows_mut::<3>(3).copy_from(&(rotation * ROTATION_LENGTH));
            let row = row.columns(0, free);
            normal += row.tr_mul(&row) * *w;
            right += row.tr_mul(&left) * *w;
        }
        let least = 1e-12 * normal.trace();
        (0..free).for_each(|k| normal[(k, k)] += least);
        let Some(step) = normal.clone().cholesky().map(|c| c.solve(&right)) else { break };
        let part = |k: usize| {
            let at = |i: usize| step.get(k + i).copied().unwrap_or(0.0);
            Vector3::new(at(0), at(1), at(2))
        };
        frame.position += part(0);
        frame.rotation = rotation_from_vector(&part(3)) * frame.rotation;
        tool.position += part(6);
        tool.rotation *= rotation_from_vector(&part(9));
        if step.amax() < 1e-12 {
            break;
        }
    }
    let mean = |of: &dyn Fn(&PosePair) -> f64| {
        pose_pairs.iter().map(of).sum::<f64>() / pose_pairs.len() as f64
    };
    let left = [
        mean(&|s| s.left(&frame, &tool).0.norm_squared()).sqrt(),
        mean(&|s| s.left(&frame, &tool).1.norm_squared()).sqrt(),
    ];
    let numbers = pose_pairs.len() * if rotations { 6 } else { 3 };
    let sum = mean(&|s| s.square(&frame, &tool)) * pose_pairs.len() as f64;
    let variance = sum / numbers.saturating_sub(free).max(1) as f64;
    let covariance = normal.try_inverse();
    let width = |k: usize| {
        let of = covariance.as_ref().filter(|_| k < free).map_or(0.0, |c| c[(k, k)]);
        HALF_95 * (of.max(0.0) * variance).sqrt()
    };
    Registration {
        mounting: Mounting { frame, tool },
        frame_interval: std::array::from_fn(width),
        tool_interval: std::array::from_fn(|k| width(6 + k)),
        left,
        poses: pose_pairs.len(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use trueweld_plant::random::Random;

    fn turn(x: f64, y: f64, z: f64) -> Matrix3<f64> {
        rotation_from_vector(&Vector3::new(x, y, z))
    }

    /// Sightings of a tracker at `frame` of a point at `tool`, with 30 µm and 50 µrad of noise.
    fn seen(frame: &Pose<f64>, tool: &Pose<f64>, rotations: bool) -> Vec<PosePair> {
        let mut random = Random::new(3, 1);
        let mut vector = |size: f64| Vector3::from_fn(|_, _| size * random.normal());
        (0..40)
            .map(|_| {
                let nominal = Pose {
                    rotation: turn(0.0, 2.0, 0.0) * rotation_from_vector(&vector(0.5)),
                    position: vector(0.5),
                };
                PosePair {
                    nominal,
                    position: frame.transform_point(&nominal.transform_point(&tool.position))
                        + vector(3e-5),
                    rotation: rotations.then(|| {
                        rotation_from_vector(&vector(5e-5))
                            * frame.rotation
                            * nominal.rotation
                            * tool.rotation
                    }),
                }
            })
            .collect()
    }

    #[test]
    fn a_frame_anywhere_is_found_within_its_intervals() {
        let frame_truth =
            Pose { rotation: turn(1.2, -1.5, 1.3), position: Vector3::new(3.0, -2.0, 1.5) };
        for rotations in [false, true] {
            let mut pose_pairs = seen(&frame_truth, &Pose::identity(), rotations);
            // A reading of another target.
            pose_pairs[7].position.x += 0.4;
            let found = frame(&pose_pairs).unwrap();
            let off = found.mounting.frame.position - frame_truth.position;
            // 30 µm of 40 poses, some metres from the frame's origin.
            assert!(off.norm() < 1e-4, "{off} m");
            assert!(
                rotation_vector(&found.mounting.frame.rotation.tr_mul(&frame_truth.rotation))
                    .norm()
                    < 1e-4
            );
        }
    }

    #[test]
    fn a_tool_offset_of_any_size_is_found_beside_the_frame() {
        let frame_truth =
            Pose { rotation: turn(-0.4, 2.3, 0.7), position: Vector3::new(-4.0, 0.2, 0.5) };
        let tool = Pose { rotation: turn(0.3, 0.2, -2.0), position: Vector3::new(0.1, -0.3, 0.2) };
        let found = frame_and_tool(&seen(&frame_truth, &tool, true)).unwrap();
        for (found, truth, interval) in [
            (found.mounting.frame, frame_truth, found.frame_interval),
            (found.mounting.tool, tool, found.tool_interval),
        ] {
            let off = found.position - truth.position;
            for k in 0..3 {
                assert!(
                    off[k].abs() < 2.0 * interval[k] && interval[k] < 1e-3,
                    "{off} in {interval:?}"
                );
            }
            assert!(rotation_vector(&found.rotation.tr_mul(&truth.rotation)).norm() < 1e-4);
        }
        // Positions alone tell where the point sits, not how its axes are turned.
        let found = frame_and_tool(&seen(
            &frame_truth,
            &Pose { rotation: Matrix3::identity(), ..tool },
            false,
        ))
        .unwrap();
        assert!(
            (found.mounting.tool.position - tool.position).norm() < 2e-4,
            "{}",
            found.mounting.tool.position
        );
    }
}
