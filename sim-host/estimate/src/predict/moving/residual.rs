//! Measured less predicted, of links in motion.

use super::super::LinkMotion;
use super::super::columns::filled;
use super::super::instruments::{sensed, tracker_reading, unread};
use super::DynamicPrediction;
use nalgebra::Vector3;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JointVector, Pose};
use trueweld_logs::fir::interpolate;
use trueweld_plant::robot::{Channel, Drives, ElasticRobot, INTERNAL_STATES, Readings};

impl DynamicPrediction {
    /// Measured less predicted of tracker and second encoders, in engineering units.
    pub(in super::super) fn poses(
        &self,
        robot: &ElasticRobot,
        motion: &LinkMotion,
        residual: &mut Vec<f64>,
    ) {
        if self.position.is_some() || self.rotation.is_some() {
            // Every row that a window reaches, or only those compared.
            let rows: Vec<usize> = if self.calm.is_some() {
                (0..motion.link.len()).collect()
            } else {
                self.pose_rows.clone()
            };
            let poses: Vec<Pose<f64>> =
                rows.iter().map(|row| self.seen_pose(robot, motion, *row)).collect();
            if let Some(measured) = &self.position {
                let left = |(row, pose): (&usize, &Pose<f64>)| measured[*row] - pose.position;
                self.extend(residual, rows.iter().zip(&poses).map(left).collect());
            }
            if let Some(measured) = &self.rotation {
                let left = |(row, pose): (&usize, &Pose<f64>)| {
                    rotation_vector(&pose.rotation.tr_mul(&measured[*row]))
                };
                self.extend(residual, rows.iter().zip(&poses).map(left).collect());
            }
        }
        let link_lag = robot.ports.delay(Channel::LinkEncoder) / self.period;
        for (i, series) in self.link_encoder.iter().enumerate() {
            let Some(series) = series else { continue };
            let left =
                |row: usize| self.link_left(robot, i, link_at(motion, row, link_lag)[i], row);
            match &self.calm {
                Some(_) => {
                    let all = bridged((0..series.len()).map(left).collect());
                    residual.extend(
                        self.pose_rows.iter().map(|&row| self.calmed(all.len(), row, |k| all[k])),
                    );
                }
                None => residual.extend(self.pose_rows.iter().map(|&row| left(row))),
            }
        }
    }

    /// The tool as the tracker sees it at a row.
    pub(super) fn seen_pose(
        &self,
        robot: &ElasticRobot,
        motion: &LinkMotion,
        row: usize,
    ) -> Pose<f64> {
        let lag = robot.ports.delay(Channel::Tracker) / self.period;
        let tool = match motion.tool.as_slice() {
            [] => robot.model.frames(&link_at(motion, row, lag)).tcp,
            tools => between(tools, row as f64 - lag),
        };
        tracker_reading(&robot.ports, &tool, self.time[row] - self.time[0])
    }

    /// Adds what is left of vectors to the residual, in the band they are compared in.
    fn extend(&self, residual: &mut Vec<f64>, left: Vec<Vector3<f64>>) {
        if self.calm.is_none() {
            residual.extend(left.iter().flat_map(|v| v.iter().copied()));
            return;
        }
        // What is left is filled, not what was measured, which moves.
        let left = [0, 1, 2].map(|c: usize| bridged(left.iter().map(|v| v[c]).collect()));
        for &row in &self.pose_rows {
            residual.extend(left.iter().map(|c| self.calmed(c.len(), row, |k| c[k])));
        }
    }

    /// Measured less predicted of motor torque, N·m.
    pub(in super::super) fn torques(
        &self,
        robot: &ElasticRobot,
        motion: &LinkMotion,
        residual: &mut Vec<f64>,
    ) {
        let torque_lag = robot.ports.delay(Channel::MotorTorque) / self.period;
        let begin = self.time[0];
        for (i, series) in self.torque.iter().enumerate() {
            let Some(series) = series else { continue };
            let mut predicted: Vec<f64> = (0..self.motor.len())
                .map(|k| {
                    let m = &self.motor[k];
                    let memory = motion.memory.get(k).unwrap_or(&[0.0; INTERNAL_STATES]);
                    let spring = motion.spring[k][i];
                    let drives = Drives {
                        link: motion.link[k],
                        link_rate: m.rate,
                        motor: m.angle,
                        motor_rate: m.rate,
                    };
                    robot.model.rotor_inertia()[i] * m.acceleration[i]
                        + spring
                        + robot.friction(&drives, i, spring, memory, self.time[k] - begin).value
                })
                .collect();
            if torque_lag != 0.0 {
                predicted = (0..predicted.len())
                    .map(|k| interpolate(&predicted, k as f64 - torque_lag))
                    .collect();
            }
            if robot.ports.senses(Channel::MotorTorque) {
                for (k, predicted) in predicted.iter_mut().enumerate() {
                    let mut readings = Readings {
                        encoder: self.motor[k].angle.into(),
                        ..unread(self.time[k] - begin)
                    };
                    readings.motor_torque[i] = *predicted;
                    *predicted =
                        sensed(&robot.ports, Channel::MotorTorque, readings).motor_torque[i];
                }
            }
            // What is left is filled, not what was measured: friction may turn round in a gap.
            let left: Vec<f64> = series.iter().zip(&predicted).map(|(m, p)| m - p).collect();
            let Some(left) = filled(&left) else { continue };
            for &row in &self.torque_rows {
                residual.push(self.band.at(0, |k| left[k], left.len(), row));
            }
        }
    }
}

/// Link angles so many rows before a row, rad.
fn link_at(motion: &LinkMotion, row: usize, lag: f64) -> JointVector<f64> {
    if lag == 0.0 { motion.link[row] } else { interpolate(&motion.link, row as f64 - lag) }
}

/// A series with its gaps filled, unless it has no value at all.
fn bridged(series: Vec<f64>) -> Vec<f64> {
    if series.iter().all(|v| v.is_finite()) {
        return series;
    }
    filled(&series).unwrap_or(series)
}

/// A pose at a fractional sample position, straight between its neighbours; the ends are held.
fn between(poses: &[Pose<f64>], position: f64) -> Pose<f64> {
    let position = position.clamp(0.0, (poses.len() - 1) as f64);
    let (k, share) = (position.floor() as usize, position.fract());
    let (before, after) = (&poses[k], &poses[(k + 1).min(poses.len() - 1)]);
    let turned = rotation_vector(&before.rotation.tr_mul(&after.rotation)) * share;
    Pose {
        position: before.position.lerp(&after.position, share),
        rotation: before.rotation * rotation_from_vector(&turned),
    }
}
