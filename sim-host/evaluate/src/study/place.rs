//! Where a part is put, and how the arm holds its tool along the part's seams there.
//!
//! A part is a number of welds that move together. A placement is a rigid motion of the part, and a
//! turn of the tool about its own axis, which the weld leaves free. How the arm follows a seam then
//! is one of its branches; the run is held to it by joint limits about the way that the joints take.

use crate::arm::{ArmAt, PlacedSeam};
use nalgebra::{Rotation3, Unit, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use trueweld_core::{Branch, JOINTS, JointVector, KinematicsError, ModelError, Robot, Wrench};
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{Process, Weld};
use trueweld_plant::simulate::{Seam, TaughtOffset, encoder_offset};

/// How far a joint may leave the way that was planned for it, rad: a run bends by milliradians, and
/// another branch is farther off.
const BESIDE: f64 = 0.3;

/// The arm of the real cell.
#[derive(Debug, Clone, Copy)]
pub struct RealArm<'a> {
    /// The robot as it is believed to be.
    pub robot: &'a Robot<f64>,
    /// Effects of the real cell.
    pub effects: &'a [Effect],
}

/// Welds that are made on one part, and move with it.
#[derive(Debug, Clone)]
pub struct Workpiece {
    /// The welds where their files have them.
    pub welds: Vec<Weld>,
    /// Middle of the seams' ends, in B, m.
    pub middle: Vector3<f64>,
}

/// Where a part is put.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Placement {
    /// Middle of the seams in B, m.
    pub x_m: f64,
    /// Likewise.
    pub y_m: f64,
    /// Likewise.
    pub z_m: f64,
    /// Turn about the vertical through the middle, from where the file has the part, rad.
    pub turn_rad: f64,
    /// Turn of the part about the first seam's direction, rad: positive takes the tool axis towards
    /// y of W.
    pub incline_rad: f64,
    /// Turn of the tool about its own axis, against how the robot's file has it, rad.
    pub roll_rad: f64,
}

impl Workpiece {
    /// A part of these welds, of which there is at least one.
    pub fn new(welds: Vec<Weld>) -> Self {
        let ends = welds.iter().flat_map(|weld| [weld.start, weld.end]);
        let middle = ends.sum::<Vector3<f64>>() / (2 * welds.len()).max(1) as f64;
        Self { welds, middle }
    }

    /// Where the files have the part.
    pub fn placement(&self) -> Placement {
        let [x_m, y_m, z_m] = self.middle.into();
        Placement { x_m, y_m, z_m, turn_rad: 0.0, incline_rad: 0.0, roll_rad: 0.0 }
    }

    /// The welds of the part where it is put.
    pub fn welds_at(&self, at: &Placement) -> Vec<Weld> {
        let to = Vector3::new(at.x_m, at.y_m, at.z_m);
        let along = self.welds.first().map(|weld| Seam::of(weld).b_from_w.rotation);
        let along = along.map_or(Vector3::x(), |w| w.column(0).into_owned());
        let incline = Rotation3::from_axis_angle(&Unit::new_normalize(along), -at.incline_rad);
        let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), at.turn_rad) * incline;
        let point = |p: &Vector3<f64>| to + turn * (p - self.middle);
        let moved = |weld: &Weld| Weld {
            start: point(&weld.start),
            end: point(&weld.end),
            tool_axis: turn * weld.tool_axis,
            path: weld.path.as_ref().map(|path| Arc::new(path.moved(point, turn.matrix()))),
            ..weld.clone()
        };
        self.welds.iter().map(moved).collect()
    }
}

/// The first `length` m of a weld; all of one that is shorter.
pub fn shortened(weld: &Weld, length: f64) -> Weld {
    let seam = Seam::of(weld);
    if length >= seam.length {
        return weld.clone();
    }
    let path = weld.path.as_ref().map(|path| Arc::new(path.first(length)));
    Weld { end: seam.frame(length).position, path, ..weld.clone() }
}

/// A length of a straight weld about its middle, m.
pub fn centred(weld: &Weld, length: f64) -> Weld {
    let along = weld.end - weld.start;
    let middle = weld.start + along * 0.5;
    let half = along * (0.5 * length / along.norm());
    Weld { start: middle - half, end: middle + half, ..weld.clone() }
}

/// The robot with its tool turned on the flange about the tool's axis, rad.
///
/// # Errors
/// [`ModelError`].
pub(crate) fn rolled(robot: &Robot<f64>, roll: f64) -> Result<Robot<f64>, ModelError> {
    let mut parameters = robot.parameters().clone();
    let tool = &mut parameters.tool;
    // The frame T is turned against the tool, so that the same pose of T has the tool turned.
    let about = Rotation3::from_axis_angle(&Unit::new_normalize(tool.z_axis), -roll);
    tool.y_axis = about * tool.y_axis;
    Robot::new(parameters)
}

/// The arm along one seam, in one posture.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmAlongSeam {
    /// Shoulder, elbow and wrist at the start.
    pub branch: Branch,
    /// The arm at places evenly along the seam, both ends included.
    pub places: Vec<ArmAt>,
}

impl ArmAlongSeam {
    /// Every way along a seam within the joints' ranges, at so many places; `Err` with the farthest
    /// place that any branch reaches, m, and why not beyond.
    ///
    /// # Errors
    /// Where no branch follows the seam.
    pub fn all(
        robot: &Robot<f64>,
        planned: &Process,
        weld: &Weld,
        places: usize,
    ) -> Result<Vec<Self>, (f64, KinematicsError)> {
        let seam = Seam::of(weld);
        let of = PlacedSeam { robot, planned, weld, seam: &seam };
        let mut farthest = (0.0, KinematicsError::Unreachable);
        let mut ways = Vec::new();
        for branch in Branch::ALL {
            match robot.inverse_kinematics(&seam.nominal(0.0), branch) {
                Ok(start) => match robot.beyond_limits(&start) {
                    None => match Self::from(&of, branch, &start, places) {
                        Ok(way) => ways.push(way),
                        Err((path, error)) if path >= farthest.0 => farthest = (path, error),
                        Err(_) => {}
                    },
                    Some(joint) if farthest.0 == 0.0 => {
                        farthest.1 = KinematicsError::Limit(joint);
                    }
                    Some(_) => {}
                },
                Err(error) if farthest.0 == 0.0 && ways.is_empty() => farthest.1 = error,
                Err(_) => {}
            }
        }
        if ways.is_empty() { Err(farthest) } else { Ok(ways) }
    }

    /// The way that begins at these joint angles.
    fn from(
        of: &PlacedSeam<'_>,
        branch: Branch,
        start: &JointVector<f64>,
        places: usize,
    ) -> Result<Self, (f64, KinematicsError)> {
        let (robot, seam) = (of.robot, of.seam);
        // Taught under gravity with the tool free of contact.
        let free = robot.fake_target(start, &Wrench::zero());
        let taught = encoder_offset(robot, seam, 0.0, &free);
        let taught = TaughtOffset::new(&taught, &seam.axes(0.0), 0.0);
        let last = places.saturating_sub(1).max(1);
        let mut near = *start;
        let mut all = Vec::with_capacity(places);
        for k in 0..places {
            let path = seam.length * k as f64 / last as f64;
            near = robot.inverse_near(&seam.nominal(path), &near).map_err(|e| (path, e))?;
            let at = ArmAt::of(of, path, &near, &taught);
            all.push(at.ok_or((path, KinematicsError::Singular))?);
        }
        Ok(Self { branch, places: all })
    }

    /// The robot whose joints cannot leave this way for another branch.
    ///
    /// # Errors
    /// [`ModelError`].
    pub fn held(&self, robot: &Robot<f64>) -> Result<Robot<f64>, ModelError> {
        let mut parameters = robot.parameters().clone();
        for joint in 0..JOINTS {
            let angles = self.places.iter().map(|at| at.posture[joint]);
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let (least, most) = angles.fold(ends, |(l, m), a| (l.min(a), m.max(a)));
            let [low, high] = &mut parameters.joints[joint].limits;
            *low = low.max(least - BESIDE);
            *high = high.min(most + BESIDE);
        }
        Robot::new(parameters)
    }

    /// The largest of something along the way.
    pub fn most(&self, of: impl Fn(&ArmAt) -> f64) -> f64 {
        self.places.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The least of something along the way.
    pub fn least(&self, of: impl Fn(&ArmAt) -> f64) -> f64 {
        self.places.iter().map(of).fold(f64::INFINITY, f64::min)
    }
}
