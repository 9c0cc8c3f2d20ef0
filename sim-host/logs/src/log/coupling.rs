//! Axes that are counted from the horizontal: their angle holds that of the axis before.

use trueweld_core::{JOINTS, JointVector, Robot};

/// Cross product of two unit axes up to which they are parallel: files state them to six digits.
const PARALLEL_AXES_TOLERANCE: f64 = 1e-5;

/// The angle of another joint, so many times, makes the one that was read the joint's own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coupling {
    /// The joint, from 0.
    pub joint: usize,
    /// The joint whose angle is added.
    pub other: usize,
    /// How many times.
    pub times: f64,
}

impl Coupling {
    /// Those that an arm may have: a link that keeps its direction when the joint before turns, as a
    /// parallelogram makes it, turns about a parallel axis.
    pub fn all(robot: &Robot<f64>) -> Vec<Self> {
        let axis = |i: usize| robot.parameters().joints[i].axis.normalize();
        let are_parallel =
            |i: &usize| axis(*i).cross(&axis(i - 1)).norm() < PARALLEL_AXES_TOLERANCE;
        let both = |joint: usize| [1.0, -1.0].map(|times| Self { joint, other: joint - 1, times });
        (1..JOINTS).filter(are_parallel).flat_map(both).collect()
    }

    /// Angles of the joints, or their derivatives, from those that were read.
    #[must_use]
    pub fn of(&self, read: &JointVector<f64>) -> JointVector<f64> {
        let mut q = *read;
        q[self.joint] += self.times * read[self.other];
        q
    }
}
