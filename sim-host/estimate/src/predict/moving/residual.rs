//! Measured less predicted, of links in motion.

use super::super::LinkMotion;
use super::super::columns::filled;
use super::super::instruments::{seen, sensed, unread};
use super::DynamicPrediction;
use nalgebra::Vector3;
use trueweld_core::Pose;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
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
        let begin = self.time[0];
        let lag = |channel| robot.ports.delay(channel) / self.period;
        let late = |row: usize, lag: f64| {
            if lag == 0.0 { motion.link[row] } else { interpolate(&motion.link, row as f64 - lag) }
        };
        if self.position.is_some() || self.rotation.is_some() {
            let tracker_lag = lag(Channel::Tracker);
            let pose = |row: &usize| {
                let time = self.time[*row] - begin;
                let tool = match motion.tool.as_slice() {
                    [] => robot.model.frames(&late(*row, tracker_lag)).tcp,
                    tools => between(tools, *row as f64 - tracker_lag),
                };
                seen(&robot.ports, &tool, time)
            };
            // Every row that a window reaches, or only those compared.
            let rows: Vec<usize> = if self.calm.is_some() {
                (0..motion.link.len()).collect()
            } else {
                self.pose_rows.clone()
            };
            let poses: Vec<Pose<f64>> = rows.iter().map(pose).collect();
            let mut extend = |left: Vec<Vector3<f64>>| match &self.calm {
                Some(_) => {
                    // What is left is filled, not what was measured, which moves.
                    let column = |c: usize| bridged(left.iter().map(|v| v[c]).collect());
                    let left = [0, 1, 2].map(column);
                    residual.extend(self.pose_rows.iter().flat_map(|&row| {
                        let left = &left;
                        (0..3).map(move |c| self.calmed(left[c].len(), row, |k| left[c][k]))
                    }));
                }
                None => residual.extend(left.iter().flat_map(|v| v.iter().copied())),
            };
            if let Some(measured) = &self.position {
                extend(
                    rows.iter()
                        .zip(&poses)
                        .map(|(row, pose)| measured[*row] - pose.position)
                        .collect(),
                );
            }
            if let Some(measured) = &self.rotation {
                let left = |(row, pose): (&usize, &Pose<f64>)| {
                    rotation_vector(&pose.rotation.tr_mul(&measured[*row]))
                };
                extend(rows.iter().zip(&poses).map(left).collect());
            }
        }
        let link_lag = lag(Channel::LinkEncoder);
        for (i, series) in self.link_encoder.iter().enumerate() {
            let Some(series) = series else { continue };
            let left = |row: usize| self.link_left(robot, i, late(row, link_lag)[i], row);
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
