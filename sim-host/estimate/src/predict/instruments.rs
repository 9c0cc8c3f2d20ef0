//! What instruments make of what is true, and what is true behind what they read.

use nalgebra::Vector3;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{Pose, Wrench};
use trueweld_plant::robot::{Channel, Ports, Readings, Term};

/// Readings in which nothing was read yet.
pub(super) fn unread(time: f64) -> Readings {
    Readings {
        time,
        encoder: [0.0; 6],
        link_encoder: [0.0; 6],
        motor_torque: [0.0; 6],
        force: Vector3::zeros(),
        moment: Vector3::zeros(),
        tcp_position: Vector3::zeros(),
        tcp_rotation: Vector3::zeros(),
    }
}

/// What an instrument makes of what is true.
pub(super) fn sensed(ports: &Ports, instrument: Channel, mut truth: Readings) -> Readings {
    ports.sense_by(instrument, &mut truth);
    truth
}

/// A tracker that sees another point of the tool than its centre: p' = p + R b.
#[derive(Debug)]
pub(super) struct TrackedPoint {
    /// Where the point is, in T, m.
    pub(super) at: Vector3<f64>,
}

impl Term for TrackedPoint {
    fn sense(&self, readings: &mut Readings) {
        readings.tcp_position += rotation_from_vector(&readings.tcp_rotation) * self.at;
    }
}

/// What the tracker makes of a tool pose.
pub(super) fn tracker_reading(ports: &Ports, pose: &Pose<f64>, time: f64) -> Pose<f64> {
    if !ports.senses(Channel::Tracker) {
        return *pose;
    }
    let readings = Readings {
        tcp_position: pose.position,
        tcp_rotation: rotation_vector(&pose.rotation),
        ..unread(time)
    };
    let readings = sensed(ports, Channel::Tracker, readings);
    Pose { position: readings.tcp_position, rotation: rotation_from_vector(&readings.tcp_rotation) }
}

/// The true pose behind what the tracker saw.
pub(super) fn pose_behind(ports: &Ports, measured: &Pose<f64>, time: f64) -> Pose<f64> {
    if !ports.senses(Channel::Tracker) {
        return *measured;
    }
    let mut truth = *measured;
    for _ in 0..4 {
        let read = tracker_reading(ports, &truth, time);
        truth.position += measured.position - read.position;
        truth.rotation *= read.rotation.tr_mul(&measured.rotation);
    }
    truth
}

/// The true wrench behind a measured one: the sensor's terms undone. They change little, so that
/// the fixed point converges: with a gain off by a third to 1e-12 in 25 steps.
pub(super) fn wrench_behind(ports: &Ports, measured: &Wrench<f64>, time: f64) -> Wrench<f64> {
    if !ports.senses(Channel::Wrench) {
        return *measured;
    }
    let mut truth = *measured;
    let enough = 1e-12 * (measured.force.norm() + measured.moment.norm());
    for _ in 0..25 {
        let Wrench { force, moment } = truth;
        let readings = sensed(ports, Channel::Wrench, Readings { force, moment, ..unread(time) });
        let (force, moment) = (measured.force - readings.force, measured.moment - readings.moment);
        truth.force += force;
        truth.moment += moment;
        if force.norm() + moment.norm() <= enough {
            break;
        }
    }
    truth
}
