//! The true state of the cell over time, and what instruments without noise read of it.

use nalgebra::Vector3;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JointVector, Pose, Wrench};
use trueweld_plant::cell::Cell;
use trueweld_plant::robot::{Channel, Readings};

/// The truth at one instant.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Instant {
    /// Encoders, rad.
    pub motor: JointVector<f64>,
    /// Links, rad.
    pub link: JointVector<f64>,
    /// Motor torque, N·m.
    pub torque: JointVector<f64>,
    /// Tool in B.
    pub pose: Pose<f64>,
    /// What the environment applies to the tool at the TCP, in T.
    pub wrench: Wrench<f64>,
}

/// The truth over time, evenly sampled.
#[derive(Debug)]
pub(crate) struct TruthTrack {
    /// Time of the first sample, s.
    pub start: f64,
    /// Time between samples, s.
    pub step: f64,
    /// The samples.
    pub instants: Vec<Instant>,
}

impl TruthTrack {
    /// The truth at any time, by the cubic through the four samples around it; as it was at the
    /// ends beyond them.
    fn at(&self, time: f64) -> Instant {
        let last = self.instants.len() - 1;
        let place = ((time - self.start) / self.step).clamp(0.0, last as f64);
        // On the grid but for rounding: no sample beyond is asked for.
        let near = place.round();
        let place = if (place - near).abs() < 1e-6 { near } else { place };
        let first = place.floor() as usize;
        let x = place - first as f64;
        if x == 0.0 {
            return self.instants[first];
        }
        let at = |offset: isize| &self.instants[first.saturating_add_signed(offset).min(last)];
        let weight = [
            -x * (x - 1.0) * (x - 2.0) / 6.0,
            (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0,
            -(x + 1.0) * x * (x - 2.0) / 2.0,
            (x + 1.0) * x * (x - 1.0) / 6.0,
        ];
        let around = [at(-1), at(0), at(1), at(2)];
        let joints = |f: fn(&Instant) -> JointVector<f64>| -> JointVector<f64> {
            around.iter().zip(weight).map(|(i, w)| f(i) * w).sum()
        };
        let vector = |f: &dyn Fn(&Instant) -> Vector3<f64>| -> Vector3<f64> {
            around.iter().zip(weight).map(|(i, w)| f(i) * w).sum()
        };
        let here = at(0).pose.rotation;
        let turned = vector(&|i| rotation_vector(&(here.transpose() * i.pose.rotation)));
        Instant {
            motor: joints(|i| i.motor),
            link: joints(|i| i.link),
            torque: joints(|i| i.torque),
            pose: Pose {
                rotation: here * rotation_from_vector(&turned),
                position: vector(&|i| i.pose.position),
            },
            wrench: Wrench {
                moment: vector(&|i| i.wrench.moment),
                force: vector(&|i| i.wrench.force),
            },
        }
    }

    /// What instruments without noise read at a time, each as late as it is.
    pub(crate) fn read(&self, cell: &Cell, time: f64) -> Readings {
        let late = |channel| self.at(time - cell.robot.ports.delay(channel));
        let (tracker, wrench) = (late(Channel::Tracker).pose, late(Channel::Wrench).wrench);
        Readings {
            motor_torque: late(Channel::MotorTorque).torque.into(),
            ..readings(
                time,
                &self.at(time).motor,
                &late(Channel::LinkEncoder).link,
                &wrench,
                &tracker,
            )
        }
    }
}

/// The truth as readings, but for the motors' torque.
pub(crate) fn readings(
    time: f64,
    motor: &JointVector<f64>,
    link: &JointVector<f64>,
    wrench_in_t: &Wrench<f64>,
    tcp: &Pose<f64>,
) -> Readings {
    Readings {
        force: wrench_in_t.force,
        moment: wrench_in_t.moment,
        ..Readings::of(time, motor, link, tcp)
    }
}
