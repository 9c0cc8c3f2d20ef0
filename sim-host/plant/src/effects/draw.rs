//! What a random place and random sizes of an effect are drawn from.

use super::location::Location;
use crate::random::Random;
use nalgebra::Vector3;
use std::f64::consts::PI;
use trueweld_core::RobotParameters;

/// One draw: a source of random numbers, and what the sizes of effects are relative to.
#[derive(Debug)]
pub struct Draw<'a> {
    /// Factor on the usual size: 1 shows well above the noise in logs of the usual kinds, 0.3
    /// hardly.
    pub size: f64,
    /// A joint, from 0.
    pub joint: usize,
    /// One of the first three joints.
    pub proximal: usize,
    /// Length of the seam, m.
    pub seam: f64,
    robot: &'a RobotParameters<f64>,
    random: Random,
}

impl<'a> Draw<'a> {
    /// A draw for a robot that welds a seam of this length, m.
    pub fn new(mut random: Random, size: f64, robot: &'a RobotParameters<f64>, seam: f64) -> Self {
        let (joint, proximal) = (random.whole(0, 5), random.whole(0, 2));
        Self { size, joint, proximal, seam, robot, random }
    }

    /// The joint as a place.
    pub fn here(&self) -> Location {
        Location::Joint(self.joint)
    }

    /// Torque limit of the joint over that of A2, 1.
    pub fn strength(&self) -> f64 {
        self.robot.joints[self.joint].max_torque / self.robot.joints[1].max_torque
    }

    /// Coulomb level, N·m, and viscous coefficient, N·m·s/rad, of the joint.
    pub fn friction(&self) -> (f64, f64) {
        let friction = &self.robot.friction;
        (friction.coulomb[self.joint], friction.viscous[self.joint])
    }

    /// Evenly between two values.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        self.random.between(low, high)
    }

    /// Evenly between two magnitudes, of either sign.
    pub fn either(&mut self, low: f64, high: f64) -> f64 {
        self.random.either(low, high)
    }

    /// One of the whole numbers from `first` to `last`, both included.
    pub fn whole(&mut self, first: usize, last: usize) -> usize {
        self.random.whole(first, last)
    }

    /// A phase, rad.
    pub fn phase(&mut self) -> f64 {
        self.random.between(-PI, PI)
    }

    /// A direction in space.
    pub fn direction(&mut self) -> Vector3<f64> {
        self.random.direction()
    }
}
