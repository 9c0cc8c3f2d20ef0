//! Where trackers stand.

use super::{finite, result};
use crate::{RegisterReport, text};
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_vector;
use trueweld_estimate::log_faults::Registered;
use trueweld_estimate::residuals::compare::Notice;
use trueweld_plant::provenance::Provenance;

result! {
    /// Where trackers stand.
    RegisterResult<'a> of (report: &RegisterReport<'a>) {
        /// What the result is of.
        provenance: &'a Provenance = report.provenance,
        /// The model file.
        model: String = report.model.path.display().to_string(),
        /// Every tracker that was found.
        trackers: Vec<RegisteredTracker> =
            report.registered.iter().map(RegisteredTracker::of).collect(),
    }
}

result! {
    /// A tracker's frame and what it sees of the tool.
    RegisteredTracker of (registered: &Registered) with {
        let found = &registered.registration;
    } {
        /// Names of the logs.
        logs: Vec<String> = registered.logs.clone(),
        /// Poses that it rests on.
        poses: usize = found.poses,
        /// The robot's base seen by the tracker.
        base: RegisteredPose = RegisteredPose::of(&found.mounting.frame, &found.frame_interval),
        /// The tracked point and its axes in the tool frame.
        tool: RegisteredPose = RegisteredPose::of(&found.mounting.tool, &found.tool_interval),
        /// Root mean square of what is left of the positions, m.
        left_m: Option<f64> = finite(found.left[0]),
        /// Root mean square of what is left of the rotations, rad.
        left_rad: Option<f64> = finite(found.left[1]),
        /// The table for `log.toml`.
        table: String = text::register::table(&found.mounting),
    }
}

result! {
    /// A rigid motion with the half-widths of its 95 % intervals.
    RegisteredPose of (pose: &Pose<f64>, interval: &[f64; 6]) {
        /// Position, m.
        position_m: [f64; 3] = pose.position.into(),
        /// Rotation vector, rad.
        rotation_rad: [f64; 3] = rotation_vector(&pose.rotation).into(),
        /// Half-widths of the position, m.
        position_interval_m: [f64; 3] = std::array::from_fn(|k| interval[k]),
        /// Half-widths of the rotation, rad.
        rotation_interval_rad: [f64; 3] = std::array::from_fn(|k| interval[3 + k]),
    }
}

impl RegisteredTracker {
    /// Those that notices tell of.
    pub(super) fn all(notices: &[Notice]) -> Vec<Self> {
        let of = |notice: &Notice| match notice {
            Notice::Registered(registered) => Some(Self::of(registered)),
            _ => None,
        };
        notices.iter().filter_map(of).collect()
    }
}
