//! The rows of a log: a vector a channel.

use super::columns::{DEPTH_FORCE, LogHeader, named, predicted, without_depth_force};
use super::notice::LogNotice;
use crate::channel::{COUNT, LogChannel, column_name};
use crate::kind::LogKind;
use crate::register::Mounting;
use nalgebra::Vector3;
use std::ops::Range;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose, Robot};

/// Extra mass hung on the flange.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// Mass, kg; 0 where nothing hangs.
    pub mass: f64,
    /// Its centre from the flange, in the frame of the last link, m.
    pub centre: Vector3<f64>,
}

/// The rows of a log, a vector a channel, all of the same length.
///
/// Time, encoders and payload are there in every row. In the other channels a value that is missing
/// in the file is NaN, each component for itself. A channel that has no value in any row is `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    /// Time, s, strictly rising; it need not begin at 0.
    pub time: Vec<f64>,
    /// Encoder angles on the joint side, rad.
    pub encoder: Vec<JointVector<f64>>,
    /// Second encoders on the link side, rad, for each joint that has one.
    pub link_encoder: [Option<Vec<f64>>; JOINTS],
    /// Motor torques seen from the joint, N·m, for each joint where recorded.
    pub motor_torque: [Option<Vec<f64>>; JOINTS],
    /// Force that the environment applies to the tool, in T, N.
    pub force: Option<Vec<Vector3<f64>>>,
    /// Components of the force that nobody measured: zero in every row.
    pub unmeasured_force: [bool; 3],
    /// Moment that the environment applies to the tool, at the tool centre point, in T, N·m.
    pub moment: Option<Vec<Vector3<f64>>>,
    /// Tool centre point in B, by the tracker, m.
    pub position: Option<Vec<Vector3<f64>>>,
    /// Rotation vector of T in B, by the tracker, rad. Near half a turn its sign may flip from row
    /// to row.
    pub rotation: Option<Vec<Vector3<f64>>>,
    /// Spindle speed, positive about the tool's z axis, rad/s.
    pub spindle: Option<Vec<f64>>,
    /// Extra mass on the flange; static-load logs only.
    pub payload: Option<Vec<Payload>>,
}

impl Samples {
    /// Takes a tracker's frame and what it sees of the tool out of its readings.
    pub fn register(&mut self, mounting: &Mounting, robot: &Robot<f64>) {
        let Some(position) = &mut self.position else { return };
        for (k, position) in position.iter_mut().enumerate() {
            let turned = self.rotation.as_ref().map(|r| rotation_from_vector(&r[k]));
            let turned = turned.filter(|r| r.sum().is_finite());
            let nominal = robot.forward_kinematics(&self.encoder[k]).rotation;
            let (at, rotation) = mounting.corrected(position, turned.as_ref(), &nominal);
            *position = at;
            if let (Some(series), Some(rotation)) = (&mut self.rotation, rotation) {
                series[k] = rotation_vector(&rotation);
            }
        }
    }

    /// Takes a wrench in the axes, and about the point, of a sensor that sits so in T to one in T at
    /// the tool centre point: R f, and R m + p × R f.
    pub fn at_tool(&mut self, sensor: &Pose<f64>) {
        let turn = |v: &mut Vector3<f64>| *v = sensor.rotation * *v;
        self.force.iter_mut().flatten().for_each(turn);
        self.moment.iter_mut().flatten().for_each(turn);
        for (moment, force) in self.moment.iter_mut().flatten().zip(self.force.iter().flatten()) {
            *moment += sensor.position.cross(force);
        }
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// True where there is no row.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Takes the channels that `columns` has; others stay as they are.
    pub(super) fn take(&mut self, columns: &mut ColumnBuffer, kind: LogKind) {
        let take = |columns: &mut ColumnBuffer, column: usize| columns.values[column].take();
        if !columns.time.is_empty() {
            self.time = std::mem::take(&mut columns.time);
        }
        let encoder = LogChannel::Encoder.columns();
        if encoder.clone().all(|column| columns.values[column].is_some()) {
            let of: [Vec<f64>; JOINTS] =
                std::array::from_fn(|i| take(columns, encoder.start + i).unwrap_or_default());
            self.encoder =
                (0..of[0].len()).map(|k| JointVector::from_fn(|i, _| of[i][k])).collect();
        }
        for (series, channel) in [
            (&mut self.link_encoder, LogChannel::LinkEncoder),
            (&mut self.motor_torque, LogChannel::MotorTorque),
        ] {
            for (i, series) in series.iter_mut().enumerate() {
                *series = take(columns, channel.columns().start + i).or(series.take());
            }
        }
        let force = LogChannel::Force.columns();
        let rows = force.clone().find_map(|column| columns.values[column].as_ref().map(Vec::len));
        if let Some(rows) = rows {
            for (unmeasured, column) in self.unmeasured_force.iter_mut().zip(force) {
                *unmeasured = columns.values[column].is_none();
                columns.values[column].get_or_insert_with(|| vec![0.0; rows]);
            }
        }
        for (series, channel) in [
            (&mut self.force, LogChannel::Force),
            (&mut self.moment, LogChannel::Moment),
            (&mut self.position, LogChannel::Position),
            (&mut self.rotation, LogChannel::Rotation),
        ] {
            let first = channel.columns().start;
            if let (Some(x), Some(y), Some(z)) =
                (take(columns, first), take(columns, first + 1), take(columns, first + 2))
            {
                let rows = x.into_iter().zip(y).zip(z);
                *series = Some(rows.map(|((x, y), z)| Vector3::new(x, y, z)).collect());
            }
        }
        self.spindle = take(columns, LogChannel::Spindle.columns().start).or(self.spindle.take());
        let first = LogChannel::Payload.columns().start;
        if let (LogKind::StaticLoad, Some(mass), Some(x), Some(y), Some(z)) = (
            kind,
            take(columns, first),
            take(columns, first + 1),
            take(columns, first + 2),
            take(columns, first + 3),
        ) {
            let rows = mass.into_iter().zip(x.into_iter().zip(y).zip(z));
            let payload = |(mass, ((x, y), z))| Payload { mass, centre: Vector3::new(x, y, z) };
            self.payload = Some(rows.map(payload).collect());
        }
    }
}

/// The rows of a log while they are read: a series a column, NaN where there is no value.
#[derive(Debug, Clone)]
pub(super) struct ColumnBuffer {
    /// Time, s.
    pub time: Vec<f64>,
    /// The other columns, by number.
    pub values: [Option<Vec<f64>>; COUNT],
}

impl Default for ColumnBuffer {
    fn default() -> Self {
        Self { time: Vec::new(), values: std::array::from_fn(|_| None) }
    }
}

impl ColumnBuffer {
    /// Some of the rows.
    pub(crate) fn rows(&self, rows: Range<usize>) -> Self {
        let of = |column: &Option<Vec<f64>>| column.as_ref().map(|c| c[rows.clone()].to_vec());
        Self { time: self.time[rows.clone()].to_vec(), values: self.values.each_ref().map(of) }
    }

    /// Drops the channels that have no value in any row: ones that the laboratory does not have.
    /// Tells them in `notices`, or gives what is wrong where one of them is needed.
    pub(crate) fn drop_empty(
        &mut self,
        kind: LogKind,
        header: &LogHeader,
        notices: &mut Vec<LogNotice>,
    ) -> Result<(), (String, &'static str)> {
        let is_measured = |column: &usize| {
            let series = self.values[*column].as_ref();
            series.is_some_and(|series| series.iter().any(|v| !v.is_nan() && *v != 0.0))
        };
        let (measured, missing): (Vec<usize>, Vec<usize>) =
            LogChannel::Force.columns().partition(is_measured);
        if kind == LogKind::Weld && !measured.is_empty() && !missing.is_empty() {
            if !measured.contains(&DEPTH_FORCE) {
                return Err(without_depth_force(measured));
            }
            missing.iter().for_each(|column| self.values[*column] = None);
            notices.push(LogNotice::ForceInPart(measured.into_iter().map(column_name).collect()));
        }
        let any = |column: usize| {
            self.values[column].as_ref().is_some_and(|c| c.iter().any(|v| !v.is_nan()))
        };
        let group = |column: usize| {
            let (channel, _) = LogChannel::of(column);
            if channel.together { channel.id.columns() } else { column..column + 1 }
        };
        let first = LogChannel::LinkEncoder.columns().start;
        let empty: Vec<_> = (first..LogChannel::Payload.columns().start)
            .filter(|column| header.has(*column) && !group(*column).any(any))
            .collect();
        if empty.is_empty() {
            return Ok(());
        }
        if kind == LogKind::Weld && empty.contains(&LogChannel::Spindle.columns().start) {
            let message = "column `spindle_rad_s` holds no value; expected the spindle's speed, which drives a weld";
            let help = "Write the commanded speed where it was not measured.";
            return Err((message.to_owned(), help));
        }
        let left =
            predicted(kind).iter().any(|column| header.has(*column) && !empty.contains(column));
        if !left {
            let message = format!(
                "{} hold no value; a {kind} log has nothing to compare then",
                named(&empty)
            );
            return Err((message, "Was the instrument recorded?"));
        }
        empty.iter().for_each(|column| self.values[*column] = None);
        notices.push(LogNotice::EmptyColumns(empty.into_iter().map(column_name).collect()));
        Ok(())
    }
}
