//! Where trackers stand.

use super::finite;
use crate::{RegisterReport, words};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_core::Pose;
use trueweld_core::spatial::rotation_vector;
use trueweld_estimate::mistakes::Registered;
use trueweld_estimate::residuals::compare::Notice;
use trueweld_plant::provenance::Provenance;

/// Where trackers stand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisterResult {
    /// Name and version of this format.
    #[schemars(extend("const" = "register/1"))]
    pub schema: String,
    /// What the result is of.
    pub provenance: Provenance,
    /// The model file.
    pub model: String,
    /// Every tracker that was found.
    pub trackers: Vec<RegisteredTracker>,
}

/// A tracker's frame and what it sees of the tool.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisteredTracker {
    /// Names of the logs.
    pub logs: Vec<String>,
    /// Poses that it rests on.
    pub poses: usize,
    /// The robot's base seen by the tracker.
    pub base: RegisteredPose,
    /// The tracked point and its axes in the tool frame.
    pub tool: RegisteredPose,
    /// Root mean square of what is left of the positions, m.
    pub left_m: Option<f64>,
    /// Root mean square of what is left of the rotations, rad.
    pub left_rad: Option<f64>,
    /// The table for `log.toml`.
    pub table: String,
}

/// A rigid motion with the half-widths of its 95 % intervals.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RegisteredPose {
    /// Position, m.
    pub position_m: [f64; 3],
    /// Rotation vector, rad.
    pub rotation_rad: [f64; 3],
    /// Half-widths of the position, m.
    pub position_interval_m: [f64; 3],
    /// Half-widths of the rotation, rad.
    pub rotation_interval_rad: [f64; 3],
}

impl RegisteredTracker {
    pub(super) fn of(registered: &Registered) -> Self {
        let pose = |pose: &Pose<f64>, interval: &[f64; 6]| RegisteredPose {
            position_m: pose.position.into(),
            rotation_rad: rotation_vector(&pose.rotation).into(),
            position_interval_m: std::array::from_fn(|k| interval[k]),
            rotation_interval_rad: std::array::from_fn(|k| interval[3 + k]),
        };
        let found = &registered.registration;
        Self {
            logs: registered.logs.clone(),
            poses: found.poses,
            base: pose(&found.mounting.frame, &found.frame_interval),
            tool: pose(&found.mounting.tool, &found.tool_interval),
            left_m: finite(found.left[0]),
            left_rad: finite(found.left[1]),
            table: words::register::table(&found.mounting),
        }
    }

    /// Those that notices tell of.
    pub(super) fn all(notices: &[Notice]) -> Vec<Self> {
        let of = |notice: &Notice| match notice {
            Notice::Registered(registered) => Some(Self::of(registered)),
            _ => None,
        };
        notices.iter().filter_map(of).collect()
    }
}

impl RegisterResult {
    pub(crate) fn of(report: &RegisterReport<'_>) -> Self {
        Self {
            schema: "register/1".to_owned(),
            provenance: report.provenance.clone(),
            model: report.model.path.display().to_string(),
            trackers: report.registered.iter().map(RegisteredTracker::of).collect(),
        }
    }
}
