//! How encoders and tracker may have to be read, and what a reading leaves of the poses.

use super::rows::LogRow;
use trueweld_core::{JOINTS, JointVector, Pose, Robot};
use trueweld_logs::log::Coupling;
use trueweld_logs::register::{PosePair, Registration};

/// Poses at rest that tell a frame by themselves.
pub(super) const AT_REST: usize = 8;

/// Share of the rows that may be outliers of the tracker.
const OUTLIERS: f64 = 0.1;

/// How near to a whole sign or unit a slope must lie.
pub(super) const WHOLE_SLOPE_TOLERANCE: f64 = 0.02;

/// How the encoders are to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum EncoderReading {
    /// As they are.
    Plain,
    /// Joints of this set, a bit each, the other way.
    Signs(u8),
    /// Two joints for each other.
    Exchanged(usize, usize),
    /// All multiplied.
    Scaled(f64),
    /// One joint on a line: slope, and offset in rad.
    Line(usize, f64, f64),
    /// One joint that holds another one's angle as well.
    Coupled(Coupling),
}

impl EncoderReading {
    pub(crate) fn of(self, read: &JointVector<f64>) -> JointVector<f64> {
        let mut q = *read;
        match self {
            Self::Plain => {}
            Self::Signs(set) => {
                (0..JOINTS).filter(|i| set & (1 << i) != 0).for_each(|i| q[i] = -q[i]);
            }
            Self::Exchanged(a, b) => q.swap_rows(a, b),
            Self::Scaled(factor) => q *= factor,
            Self::Line(i, slope, offset) => q[i] = slope * q[i] + offset,
            Self::Coupled(coupling) => q = coupling.of(read),
        }
        q
    }
}

/// How the tracker's positions are to be read.
// A handful exist at a time: a box would only take `Copy` from them.
#[allow(clippy::large_enum_variant)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Tracker {
    /// As they are.
    Plain,
    /// Multiplied.
    Scaled(f64),
    /// One axis the other way.
    Mirrored(usize),
    /// In a frame of its own.
    Registered(Registration),
}

/// An explanation and what it leaves, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct ExplainedReading {
    pub reading: EncoderReading,
    pub tracker: Tracker,
    pub left: f64,
}

/// What was seen of some rows, encoders read in one way.
pub(super) fn pose_pairs(
    rows: &[&LogRow],
    robot: &Robot<f64>,
    reading: EncoderReading,
) -> Vec<PosePair> {
    rows.iter().filter_map(|row| row.pose_pair(robot, &reading.of(&row.encoder))).collect()
}

/// Root mean square of what is left, without the outliers, m.
pub(super) fn misfit(pose_pairs: &[PosePair], frame: &Pose<f64>, tool: &Pose<f64>) -> f64 {
    let mut squares: Vec<f64> = pose_pairs.iter().map(|s| s.square(frame, tool)).collect();
    squares.sort_by(f64::total_cmp);
    let kept = squares.len() - (OUTLIERS * squares.len() as f64) as usize;
    (squares[..kept].iter().sum::<f64>() / kept.max(1) as f64).sqrt()
}

/// What is left with the tracker read in one way; nothing where it does not apply.
pub(super) fn with(seen: &[PosePair], tracker: Tracker) -> Option<ExplainedReading> {
    let identity = Pose::identity();
    let of = |tracker, left: f64| {
        let reading = EncoderReading::Plain;
        left.is_finite().then_some(ExplainedReading { reading, tracker, left })
    };
    match tracker {
        Tracker::Plain => of(tracker, misfit(seen, &identity, &identity)),
        Tracker::Scaled(factor) => {
            let read: Vec<_> =
                seen.iter().map(|s| PosePair { position: s.position * factor, ..*s }).collect();
            of(tracker, misfit(&read, &identity, &identity))
        }
        Tracker::Mirrored(axis) => {
            let mut mirrored = seen.to_vec();
            for pose_pair in &mut mirrored {
                pose_pair.position[axis] = -pose_pair.position[axis];
                // Which way a mirrored tracker counts rotations nobody knows.
                pose_pair.rotation = None;
            }
            of(tracker, misfit(&mirrored, &identity, &identity))
        }
        Tracker::Registered(found) => of(
            Tracker::Registered(found),
            misfit(seen, &found.mounting.frame, &found.mounting.tool),
        ),
    }
}

/// The best explanation so far; a later one must be much better.
pub(super) struct Best {
    /// What it may leave at most, m.
    pub limit: f64,
    pub found: Option<ExplainedReading>,
}

impl Best {
    pub(crate) fn take(&mut self, other: Option<ExplainedReading>) {
        let other = other.filter(|e| e.left < self.limit);
        if let Some(other) = other
            && self.found.is_none_or(|best| other.left < 0.5 * best.left)
        {
            self.found = Some(other);
        }
    }
}

/// The multiple of 30° or 45° that an angle, rad, lies within half a degree of, else the angle.
pub(super) fn plain_angle(angle: f64) -> f64 {
    let near = |step: f64| {
        let step = step.to_radians();
        let plain = (angle / step).round() * step;
        ((angle - plain).abs() < 0.5_f64.to_radians()).then_some(plain)
    };
    near(30.0).or_else(|| near(45.0)).unwrap_or(angle)
}

/// True for a value that is a whole one, but for what noise makes.
pub(super) fn is_near(value: f64, whole: f64) -> bool {
    (value / whole - 1.0).abs() < WHOLE_SLOPE_TOLERANCE
}
