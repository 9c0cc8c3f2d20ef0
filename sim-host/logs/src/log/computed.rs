//! A pose that the controller computes from its encoders, written where a tracker's belongs.
//!
//! Such a pose agrees with the encoders and a rigid robot as closely as its numbers are written. That
//! of a real arm cannot: gravity bends it by a thousand times as much. Rounding decides: the sum of
//! squares that is left must not be larger than what rounding can make of it. The same is asked of an
//! arm that bends as the robot file says; where that one would pass as well, the rows tell nothing.
//!
//! The controller's base and tool may be others than the robot file's. So a frame and a tool's offset
//! are fitted to the positions, of both arms, and rotations are compared by how far they turn from
//! the first one, which no frame changes.

use super::columns::{ABC, MATRIX, QUATERNION, TIME_COLUMN, named};
use super::pose::to_rotation_vectors;
use super::track::FileTrack;
use crate::channel::LogChannel;
use crate::register::{PosePair, frame_and_tool};
use nalgebra::Matrix3;
use std::ops::Range;
use std::path::Path;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose, Robot};
use trueweld_plant::input::{InputError, RobotFile, Source};

/// A pose that agrees with a rigid robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rigid {
    /// Position or rotation.
    pub channel: LogChannel,
    /// Root mean square of what is left, m or rad.
    pub left: f64,
    /// Root mean square of what gravity would leave by the robot file, m or rad.
    pub bent: f64,
}

impl Rigid {
    /// The error of a file with such a pose.
    pub(super) fn refusal(&self, path: &Path) -> InputError {
        let unit = if self.channel == LogChannel::Rotation { "µrad" } else { "µm" };
        let message = format!(
            "{} agree with the encoders and a rigid robot to {:.2} {unit}, as closely as they are written, where gravity \
             bends the arm by {:.0} {unit}; expected what a tracker saw",
            named(self.channel.columns()),
            1e6 * self.left,
            1e6 * self.bent
        );
        let help = "This is the pose that the controller computes from its encoders, not a measured one. Leave it out, \
                    or give the tracker's in its place.";
        Source::new(&path.display().to_string(), "").error_of_file(message, help)
    }
}

/// Rows that are looked at.
const RIGID_FIT_ROWS_MAX: usize = 500;

/// Rows from which on a frame and a tool's offset are fitted: 36 numbers for 9 unknowns.
const RIGID_FIT_ROWS_MIN: usize = 12;

/// A real arm may be so much stiffer than its robot file says.
const STIFFER: f64 = 2.0;

/// Rounding of a number of single precision, in which controllers compute, as a share of it.
const SINGLE: f64 = 0.5 * f32::EPSILON as f64;

/// Some rows of a track, evenly.
pub(super) fn sketch(track: &FileTrack) -> FileTrack {
    let step = track.time().len().div_ceil(RIGID_FIT_ROWS_MAX).max(1);
    let thinned = |series: &Vec<f64>| series.iter().copied().step_by(step).collect();
    let columns = track.columns.iter().map(|column| column.as_ref().map(thinned)).collect();
    FileTrack { clock: track.clock.clone(), columns, rounding: track.rounding.clone() }
}

/// A row that holds the encoders and a pose.
struct PoseRow {
    /// The tool by the encoders.
    rigid: Pose<f64>,
    /// The same where gravity bends the arm.
    bent: Pose<f64>,
    /// As it is said to be measured; NaN where a part of it is not.
    seen: Pose<f64>,
    /// What rounding can make of position, m, and rotation, rad.
    rounding: [f64; 2],
}

/// One of the poses of a row.
type PoseOf = fn(&PoseRow) -> &Pose<f64>;

/// What of the pose in `seen` agrees with the encoders in `own` and a rigid robot; `None` where they
/// are of other instants.
pub(super) fn rigid(own: &FileTrack, seen: &FileTrack, robot: &RobotFile) -> Option<Rigid> {
    if own.columns[TIME_COLUMN] != seen.columns[TIME_COLUMN] {
        return None;
    }
    let rows = PoseTracks::new(own, seen, &robot.robot).rows();
    rigid_channel(&rows, LogChannel::Position, position_left)
        .or_else(|| rigid_channel(&rows, LogChannel::Position, position_left_fitted))
        .or_else(|| rigid_channel(&rows, LogChannel::Rotation, rotation_left))
}

/// What of one channel agrees with a rigid robot to its rounding, where a robot that bends does not.
/// `left`: the sum of squares that the channel leaves of the rigid poses.
fn rigid_channel(
    rows: &[PoseRow],
    channel: LogChannel,
    left: fn(&[&PoseRow], PoseOf) -> Option<f64>,
) -> Option<Rigid> {
    let which = usize::from(channel == LogChannel::Rotation);
    let is_read = |row: &&PoseRow| match which {
        0 => row.seen.position.sum().is_finite(),
        _ => row.seen.rotation.sum().is_finite(),
    };
    let rows: Vec<&PoseRow> = rows.iter().filter(is_read).collect();
    let rounding: f64 = rows.iter().map(|row| row.rounding[which].powi(2)).sum();
    let (seen, bent) = (left(&rows, |row| &row.seen)?, left(&rows, |row| &row.bent)?);
    let mean = |square: f64| (square / rows.len() as f64).sqrt();
    (seen <= rounding && bent > STIFFER.powi(2) * rounding).then(|| Rigid {
        channel,
        left: mean(seen),
        bent: mean(bent),
    })
}

/// The encoders of one track and the poses of another at the same times.
struct PoseTracks<'t> {
    own: &'t FileTrack,
    seen: &'t FileTrack,
    /// `seen`, its rotations as vectors.
    vectors: FileTrack,
    /// The columns that `seen` has its rotations in.
    form: Option<Range<usize>>,
    model: &'t Robot<f64>,
}

impl<'t> PoseTracks<'t> {
    fn new(own: &'t FileTrack, seen: &'t FileTrack, model: &'t Robot<f64>) -> Self {
        let forms = [ABC, QUATERNION, MATRIX, LogChannel::Rotation.columns()];
        let form = forms.into_iter().find(|form| seen.has(form.clone()));
        let mut vectors = seen.clone();
        to_rotation_vectors(&mut vectors);
        Self { own, seen, vectors, form, model }
    }

    /// The rows that have every encoder.
    fn rows(&self) -> Vec<PoseRow> {
        (0..self.own.time().len()).filter_map(|k| self.row(k)).collect()
    }

    /// Row `k`; `None` where an encoder is missing.
    fn row(&self, k: usize) -> Option<PoseRow> {
        let Self { own, seen, vectors, form, model } = self;
        let position = LogChannel::Position.columns();
        let encoder = LogChannel::Encoder.columns();
        let angle = |i: usize| own.columns[encoder.start + i].as_ref().map_or(f64::NAN, |c| c[k]);
        let q = JointVector::from_fn(|i, _| angle(i));
        if !q.sum().is_finite() {
            return None;
        }
        let frames = model.frames(&q);
        let mut torque = model.nonlinear_effects(&frames, &JointVector::zeros());
        torque[1] -= model.counterbalance_torque(q[1]);
        let bent = model.forward_kinematics(&(q - torque.component_div(model.stiffness())));
        let jacobian = frames.jacobian().0;
        let turns = |i: usize| rounding(own, encoder.start + i, k);
        let (mut far, mut turned) = (0.0, 0.0);
        for i in 0..JOINTS {
            far += turns(i) * jacobian.fixed_view::<3, 1>(3, i).norm();
            turned += turns(i);
        }
        let of_position: f64 = position.clone().map(|c| rounding(seen, c, k).powi(2)).sum();
        // Each number of a form turns by at most twice its own error.
        let of_form: f64 =
            form.iter().flat_map(Clone::clone).map(|c| 2.0 * rounding(seen, c, k)).sum();
        let vector = vectors.vector(LogChannel::Rotation.columns().start, k);
        let rotation = match vector.sum().is_finite() {
            true => rotation_from_vector(&vector),
            false => Matrix3::repeat(f64::NAN),
        };
        Some(PoseRow {
            rigid: model.forward_kinematics(&q),
            bent,
            seen: Pose { rotation, position: vectors.vector(position.start, k) },
            // A turn is of two rows.
            rounding: [of_position.sqrt() + far, 2.0 * (of_form + turned)],
        })
    }
}

/// What rounding can make of a value in row `k`: half a unit of the last place, or of single
/// precision where that is more.
fn rounding(track: &FileTrack, column: usize, k: usize) -> f64 {
    let value = track.columns[column].as_ref().map_or(0.0, |series| series[k].abs());
    track.rounding[column].max(SINGLE * value)
}

/// Sum of squares of what positions leave of the rigid ones, m².
fn position_left(rows: &[&PoseRow], pose: PoseOf) -> Option<f64> {
    let left = rows.iter().map(|row| (pose(row).position - row.rigid.position).norm_squared());
    (!rows.is_empty()).then(|| left.sum())
}

/// The same with a frame and a tool's offset fitted.
fn position_left_fitted(rows: &[&PoseRow], pose: PoseOf) -> Option<f64> {
    if rows.len() < RIGID_FIT_ROWS_MIN {
        return None;
    }
    let pair = |row: &&PoseRow| PosePair {
        nominal: row.rigid,
        position: pose(row).position,
        rotation: None,
    };
    let pairs: Vec<PosePair> = rows.iter().map(pair).collect();
    let mounting = frame_and_tool(&pairs)?.mounting;
    let left = pairs.iter().map(|pair| pair.left(&mounting.frame, &mounting.tool).0);
    Some(left.map(|left| left.norm_squared()).sum())
}

/// Sum of squares of how much more or less than the rigid ones rotations turn from the first, rad².
fn rotation_left(rows: &[&PoseRow], pose: PoseOf) -> Option<f64> {
    let first = rows.first()?;
    let angle =
        |a: &Pose<f64>, b: &Pose<f64>| rotation_vector(&a.rotation.tr_mul(&b.rotation)).norm();
    let left =
        rows.iter().map(|row| angle(pose(first), pose(row)) - angle(&first.rigid, &row.rigid));
    (rows.len() > 1).then(|| left.map(|left| left * left).sum())
}
