//! Where a run starts: the posture at the start of the seam, the pose taught there under gravity, and
//! the deformed cell in contact.

use super::{RunError, Scenario};
use crate::cell::Cell;
use crate::input::Weld;
use crate::integrate::rest::{self, EquilibriumError};
use crate::robot::Drives;
use crate::seam::Seam;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use trueweld_core::{Frames, JointVector, KinematicsError, Pose, Robot, Twist, Wrench};

/// Postures that Newton's method begins from, for an arm whose inverse kinematics has no closed form.
const SEED_POSTURES: usize = 256;

/// Joint angles at a pose: all branches of an arm with a spherical wrist; of any other arm those that
/// Newton's method finds from 256 postures spread evenly over the joints' ranges, each once.
///
/// # Errors
/// Those of [`Robot::inverse_all`]; where no posture is found, why the last one was none.
pub fn postures_at(
    robot: &Robot<f64>,
    b_from_t: &Pose<f64>,
) -> Result<Vec<JointVector<f64>>, KinematicsError> {
    match robot.inverse_all(b_from_t) {
        Ok(all) => return Ok(all.iter().map(|(_, q)| *q).collect()),
        Err(KinematicsError::NotDecoupled) => {}
        Err(error) => return Err(error),
    }
    let mut found: Vec<JointVector<f64>> = Vec::new();
    let mut error = KinematicsError::Unreachable;
    for k in 0..SEED_POSTURES {
        match robot.inverse_from(b_from_t, &seed_posture(robot, k)) {
            Ok(q) if found.iter().all(|other| (other - q).amax() > SAME_POSTURE) => found.push(q),
            Ok(_) => {}
            Err(e @ KinematicsError::Limit(_)) => error = e,
            Err(e) if !matches!(error, KinematicsError::Limit(_)) => error = e,
            Err(_) => {}
        }
    }
    if found.is_empty() { Err(error) } else { Ok(found) }
}

/// Two postures closer than this are one, rad: far above what Newton's method leaves, far below what
/// parts two ways to reach a pose.
const SAME_POSTURE: f64 = 1e-6;

/// Posture `k` of a sequence that fills the joints' ranges evenly: additive recurrence by powers of
/// the root of x⁷ = x + 1 (Roberts 2018), half a turn either way at most.
fn seed_posture(robot: &Robot<f64>, k: usize) -> JointVector<f64> {
    const ROOT: f64 = 1.112_775_684_278_705_6;
    JointVector::from_fn(|i, _| {
        let joint = &robot.parameters().joints[i];
        let [low, high] = [joint.limits[0].max(-PI), joint.limits[1].min(PI)];
        let share = (0.5 + (k + 1) as f64 * ROOT.powi(-(i as i32 + 1))).fract();
        low + share * (high - low)
    })
}

/// Joint angles at the start of a seam, on the branch that follows the whole seam within the limits
/// with the smallest angles.
///
/// # Errors
/// [`RunError::Reach`] with the first point that no branch holds.
pub fn start_angles(robot: &Robot<f64>, seam: &Seam) -> Result<JointVector<f64>, RunError> {
    const BRANCH_POINTS: usize = 200;
    let found = postures_at(robot, &seam.nominal(0.0))
        .map_err(|e| RunError::Reach { path: 0.0, reason: reason(e) })?;
    let mut farthest = RunError::Reach { path: 0.0, reason: "a joint limit" };
    let mut reached = 0.0;
    let mut best: Option<JointVector<f64>> = None;
    for start in found.iter().filter(|q| robot.beyond_limits(q).is_none()) {
        let mut q = *start;
        let failed = (1..=BRANCH_POINTS).find_map(|k| {
            let path = seam.length * k as f64 / BRANCH_POINTS as f64;
            match robot.inverse_near(&seam.nominal(path), &q) {
                Ok(next) => {
                    q = next;
                    None
                }
                Err(e) => Some((path, reason(e))),
            }
        });
        match failed {
            None if best.is_none_or(|b| start.norm() < b.norm()) => best = Some(*start),
            Some((path, reason)) if path > reached => {
                reached = path;
                farthest = RunError::Reach { path, reason };
            }
            _ => {}
        }
    }
    best.ok_or(farthest)
}

/// Checks that the arm can weld all of a seam, run-out included, on the branch that it starts on:
/// within its limits, and no joint faster than it can turn, as one would have to near a singular
/// posture.
///
/// # Errors
/// [`RunError::Reach`] and [`RunError::TooFast`] with the first place where it cannot.
pub fn check_reach(robot: &Robot<f64>, weld: &Weld) -> Result<(), RunError> {
    const REACH_POINTS: usize = 400;
    let seam = Seam::of(weld);
    let mut q = start_angles(robot, &seam)?;
    let end = seam.length + weld.run_out;
    let step = end / REACH_POINTS as f64;
    for k in 1..=REACH_POINTS {
        let path = step * k as f64;
        let next = robot
            .inverse_near(&seam.nominal(path), &q)
            .map_err(|e| RunError::Reach { path, reason: reason(e) })?;
        let rate = (next - q).abs() * (weld.feed_at(path - step) / step);
        for (joint, limits) in robot.parameters().joints.iter().enumerate() {
            if rate[joint] > limits.max_rate {
                let (rate, most) = (rate[joint], limits.max_rate);
                return Err(RunError::TooFast { path, joint, rate, most });
            }
        }
        q = next;
    }
    Ok(())
}

fn reason(error: KinematicsError) -> &'static str {
    match error {
        KinematicsError::NotDecoupled => "branches are those of an arm with a spherical wrist",
        KinematicsError::Unreachable => "out of reach",
        KinematicsError::Singular => "singular posture",
        KinematicsError::Limit(_) => "a joint limit",
        KinematicsError::NotFinite => "the seam is not a number",
    }
}

/// Joint angles near `near` at which the tool of the real arm is at a pose. `planned`: the arm as its
/// file has it, whose inverse is known in closed form and from which the real one differs by
/// millimetres.
///
/// # Errors
/// Those of [`Robot::inverse_near`] for the planned arm; [`KinematicsError::Unreachable`] where the
/// real one does not come to the pose.
pub fn real_inverse_near(
    real: &Robot<f64>,
    planned: &Robot<f64>,
    b_from_t: &Pose<f64>,
    near: &JointVector<f64>,
) -> Result<JointVector<f64>, KinematicsError> {
    // A picometre. Each step leaves a hundredth of what is left and less; where one does not, the real
    // arm does not reach as far as the planned one.
    const START_POSITION_TOLERANCE: f64 = 1e-12;
    const START_ERROR_MAX: f64 = 1e-9;
    let mut q = planned.inverse_near(b_from_t, near)?;
    let left = |q: &JointVector<f64>| real.forward_kinematics(q).error_to(b_from_t);
    for _ in 0..20 {
        let left = left(&q);
        if left.to_vector().amax() < START_POSITION_TOLERANCE {
            return Ok(q);
        }
        q = planned.inverse_near(&planned.forward_kinematics(&q).displaced(&left), &q)?;
    }
    let arrived = left(&q).to_vector().amax() < START_ERROR_MAX;
    arrived.then_some(q).ok_or(KinematicsError::Unreachable)
}

/// The taught pose at a posture: with the tool free of contact the real tool stands on the nominal
/// pose, and the encoders show an offset from it.
#[derive(Debug, Clone, Copy)]
pub struct Taught {
    /// Encoder angles, rad.
    pub motor: JointVector<f64>,
    /// From the nominal pose to the encoders' pose, axes of W: m and rad.
    pub offset: Twist<f64>,
}

impl Taught {
    /// The pose taught at link angles `link`, at which the real tool is `path` m along the seam, as
    /// the controller's model of the arm has it.
    pub fn at(
        cell: &Cell,
        controller_model: &Robot<f64>,
        seam: &Seam,
        path: f64,
        link: &JointVector<f64>,
    ) -> Self {
        let motor = rest::motors_for(cell, link, &Wrench::zero());
        Self { motor, offset: encoder_offset(controller_model, seam, path, &motor) }
    }
}

/// From the nominal pose `path` m along the seam to the pose at encoder angles `motor`, axes of W: m
/// and rad.
pub fn encoder_offset(
    model: &Robot<f64>,
    seam: &Seam,
    path: f64,
    motor: &JointVector<f64>,
) -> Twist<f64> {
    let to_w = seam.axes(path).transpose();
    seam.nominal(path).error_to(&model.forward_kinematics(motor)).rotated(&to_w)
}

/// From the nominal pose to the set-point all along a seam. What was taught at one place is kept as
/// it is in B, as a program is shifted as a whole; the depth goes with z of W.
#[derive(Debug, Clone, Copy)]
pub struct TaughtOffset {
    /// Where it was taught, axes of B: m and rad.
    offset: Twist<f64>,
    /// z of W there, in B.
    into: Vector3<f64>,
    /// Its part that is depth, m.
    depth: f64,
}

impl TaughtOffset {
    /// An offset in W whose axes in B are `axes` where it was taught, `depth` of it, m, along z of W.
    pub fn new(offset: &Twist<f64>, axes: &Matrix3<f64>, depth: f64) -> Self {
        Self { offset: offset.rotated(axes), into: axes.column(2).into_owned(), depth }
    }

    /// In axes of B, where the axes of W in B are `axes`.
    pub fn in_b(&self, axes: &Matrix3<f64>) -> Twist<f64> {
        let mut offset = self.offset;
        offset.linear += (axes.column(2) - self.into) * self.depth;
        offset
    }
}

/// The deformed start: the cell at rest with the tool's set-point the initial depth in the material.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub rest: rest::Rest,
    /// Encoder angles, rad.
    pub motor: JointVector<f64>,
    /// From the nominal pose to the set-point.
    pub offset: TaughtOffset,
    /// Torsion in the taught pose beyond that of gravity on the model: of effects, rad.
    pub extra_torsion: JointVector<f64>,
}

impl Start {
    pub(crate) fn of(scenario: &Scenario<'_>, seam: &Seam) -> Result<Self, RunError> {
        let (model, planned) = (&scenario.cell.robot.model, scenario.controller_model);
        let link = start_angles(planned, seam)?;
        let link = real_inverse_near(model, planned, &seam.nominal(0.0), &link)
            .map_err(|_| RunError::Reach { path: 0.0, reason: "the start is out of reach" })?;
        let taught = Taught::at(scenario.cell, planned, seam, 0.0, &link);
        if !taught.motor.sum().is_finite() {
            return Err(EquilibriumError { residual: f64::NAN }.into());
        }
        let (mut offset, axes) = (taught.offset, seam.axes(0.0));
        offset.linear.z += scenario.weld.initial_depth;
        let offset = TaughtOffset::new(&offset, &axes, scenario.weld.initial_depth);
        let setpoint = seam.nominal(0.0).displaced(&offset.in_b(&axes));
        let motor = planned.inverse_near(&setpoint, &taught.motor).map_err(|_| {
            RunError::Reach { path: 0.0, reason: "the deformed start is out of reach" }
        })?;
        let extra_torsion =
            taught.motor - link - gravity_torsion(model, &model.frames(&link), &link);
        Ok(Self { rest: rest::in_contact(scenario.cell, &motor)?, motor, offset, extra_torsion })
    }
}

/// Torsion of every drive at rest with the tool free, rad.
fn gravity_torsion(
    model: &Robot<f64>,
    frames: &Frames<f64>,
    link: &JointVector<f64>,
) -> JointVector<f64> {
    model.spring_torque_at_rest(frames, link, &Wrench::zero()).component_div(model.stiffness())
}

/// Lateral displacement of the tool by the torsion that the process adds to each joint, m: to first
/// order −(W_R_B J)_y times the torsion θ_E − θ, less that of the same posture with the tool free.
/// `axes`: of W in B where the tool is.
pub(super) fn lateral_by_joint(
    model: &Robot<f64>,
    axes: &Matrix3<f64>,
    frames: &Frames<f64>,
    drives: &Drives,
    extra_torsion: &JointVector<f64>,
) -> JointVector<f64> {
    let free = gravity_torsion(model, frames, &drives.link) + extra_torsion;
    let torsion = drives.motor - drives.link - free;
    let across = axes.column(1);
    let jacobian = frames.jacobian().0;
    JointVector::from_fn(|i, _| -across.dot(&jacobian.fixed_view::<3, 1>(3, i)) * torsion[i])
}
