//! Where an arm may stand, and under which loads: within its joints' limits, above the floor, clear
//! of the base and, where something is pressed, of singularities.
//!
//! Left out: what else stands in the cell.

use std::f64::consts::PI;
use trueweld_core::{JOINTS, JointVector, Robot, Wrench};

/// How far a joint stays off its limits, and the steps of postures, rad.
pub const OFF_LIMITS: f64 = 5.0 * PI / 180.0;

/// Shares of the stretched arm's length that joints and tool stay above the floor and off the
/// base's axis.
const ABOVE_FLOOR: f64 = 0.1;
const OFF_BASE: f64 = 0.25;

/// Least ratio of the Jacobian's singular values, lengths in arm's lengths, at which something is
/// pressed.
const LEAST_RATIO: f64 = 0.05;

/// Share of a drive's largest torque that a load may take.
const TORQUE_SHARE: f64 = 0.8;

/// Where an arm may stand, and under which loads.
#[derive(Debug)]
pub struct SafeSpace<'a> {
    /// The arm.
    pub robot: &'a Robot<f64>,
    /// Where each joint may go, rad.
    pub range: [[f64; 2]; JOINTS],
    /// Length of the stretched arm, m, and the floor, m.
    reach: f64,
    floor: f64,
}

impl<'a> SafeSpace<'a> {
    /// Of an arm whose joints go where their limits let them, a tenth of the stretched arm's length
    /// above its foot.
    pub fn new(robot: &'a Robot<f64>) -> Self {
        let range = robot.parameters().joints.map(|joint| {
            let [low, high] = joint.limits;
            [low + OFF_LIMITS, high - OFF_LIMITS]
        });
        Self::seen(robot, range, f64::INFINITY)
    }

    /// Of an arm whose joints go where they are let, rad, above the lower of a tenth of the
    /// stretched arm's length and the lowest height where its tool was seen, m: a robot on a
    /// pedestal has been below its own base.
    pub fn seen(robot: &'a Robot<f64>, range: [[f64; 2]; JOINTS], lowest: f64) -> Self {
        let reach = Self::reach(robot);
        Self { robot, range, reach, floor: (ABOVE_FLOOR * reach).min(lowest) }
    }

    /// Length of the stretched arm with its tool, m.
    pub fn reach(robot: &Robot<f64>) -> f64 {
        let parameters = robot.parameters();
        let tool = &parameters.tool;
        let links: f64 = parameters.joints[1..].iter().map(|j| j.origin.norm()).sum();
        links + (tool.flange_offset + tool.tcp_from_flange).norm()
    }

    /// True where the arm may stand: in range, above the floor, clear of the base.
    pub fn reaches(&self, q: &JointVector<f64>) -> bool {
        const JOINT_ROUNDING: f64 = 1e-9;
        let within = (0..JOINTS).all(|i| {
            q[i] >= self.range[i][0] - JOINT_ROUNDING && q[i] <= self.range[i][1] + JOINT_ROUNDING
        });
        if !within {
            return false;
        }
        let frames = self.robot.frames(q);
        let above =
            frames.origin[2..].iter().chain([&frames.tcp.position]).all(|p| p.z > self.floor);
        above && frames.tcp.position.xy().norm() > OFF_BASE * self.reach
    }

    /// True where the arm may be loaded so: a wrench on the tool, in axes of T.
    pub fn bears(&self, q: &JointVector<f64>, wrench_in_t: &Wrench<f64>) -> bool {
        if !self.reaches(q) {
            return false;
        }
        let frames = self.robot.frames(q);
        let mut jacobian = frames.jacobian().0;
        jacobian.fixed_rows_mut::<3>(3).scale_mut(1.0 / self.reach);
        let singular = jacobian.singular_values();
        let wrench = wrench_in_t.rotated(&frames.tcp.rotation);
        let torque = self.robot.spring_torque_at_rest(&frames, q, &wrench);
        let joints = &self.robot.parameters().joints;
        singular.min() > LEAST_RATIO * singular.max()
            && (0..JOINTS).all(|i| torque[i].abs() < TORQUE_SHARE * joints[i].max_torque)
    }

    /// Postures that fill the range evenly, in whole steps of 5°: as many as are asked for, of those
    /// that the unloaded arm may stand in.
    pub fn postures(&self, count: usize) -> Vec<JointVector<f64>> {
        const BASES: [u32; JOINTS] = [2, 3, 5, 7, 11, 13];
        let point = |k: u32| {
            JointVector::from_fn(|i, _| {
                let [low, high] = self.range[i];
                whole_steps(low + (high - low) * radical_inverse(BASES[i], k))
            })
        };
        let tried = 1..50 * count as u32;
        tried.map(point).filter(|q| self.bears(q, &Wrench::zero())).take(count).collect()
    }
}

/// An angle to whole steps of 5°.
fn whole_steps(angle: f64) -> f64 {
    (angle / OFF_LIMITS).round() * OFF_LIMITS
}

/// Digits of `k` in a base, mirrored at the point: van der Corput's sequence.
fn radical_inverse(base: u32, mut k: u32) -> f64 {
    let (mut value, mut digit) = (0.0, 1.0 / f64::from(base));
    while k > 0 {
        value += f64::from(k % base) * digit;
        k /= base;
        digit /= f64::from(base);
    }
    value
}
