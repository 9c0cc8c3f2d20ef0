//! What columns read over time, beside what a robot's model makes of the encoders' motion: a wrong
//! column is seen at once.

use super::proposal::{Preview, ProposedColumn, ProposedFile};
use super::raw::{ENCODER_COLUMN, POSITION, Raw, TORQUE, file_of, series, times};
use super::signs::motor_torques;
use crate::channel::LogChannel;
use crate::clock::{ClockMap, rigid};
use crate::log::columns::TIME_COLUMN;
use nalgebra::Vector3;
use trueweld_core::{JOINTS, JointVector};
use trueweld_plant::input::RobotFile;

/// Values of a preview at most: as many as a picture has pixels.
const PREVIEW_VALUES_MAX: usize = 700;

/// Every so many rows.
fn thinned(values: &[f64]) -> Vec<f64> {
    values.iter().copied().step_by(values.len().div_ceil(PREVIEW_VALUES_MAX).max(1)).collect()
}

/// The motion of the encoders.
struct Motion<'a> {
    robot: &'a RobotFile,
    file: usize,
    time: Vec<f64>,
    encoders: Vec<Vec<f64>>,
}

impl<'a> Motion<'a> {
    fn find(columns: &[ProposedColumn], raws: &[Raw], robot: &'a RobotFile) -> Option<Self> {
        let file = file_of(columns, ENCODER_COLUMN)?;
        let joint = |i: usize| series(columns, raws, Some(file), ENCODER_COLUMN + i);
        let encoders: Vec<Vec<f64>> = (0..JOINTS).map(joint).collect::<Option<_>>()?;
        let time = times(columns, raws, file)?;
        let whole = encoders.iter().flatten().chain(&time).all(|value| value.is_finite());
        whole.then_some(Self { robot, file, time, encoders })
    }

    /// The row nearest to a time.
    fn row(&self, time: f64) -> usize {
        self.time.partition_point(|own| *own < time).min(self.time.len().saturating_sub(1))
    }

    /// Where the tool is at times of another clock, in the frame in which it was seen.
    fn positions(&self, at: &[f64], clock: &ClockMap, seen: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
        let place = |time: &f64| {
            let row = self.row(clock.own(*time));
            let q = JointVector::from_fn(|i, _| self.encoders[i][row]);
            self.robot.robot.forward_kinematics(&q).position
        };
        let path: Vec<Vector3<f64>> = at.iter().map(place).collect();
        let pairs = path.iter().zip(seen).filter(|(_, seen)| seen.sum().is_finite());
        let (a, b): (Vec<_>, Vec<_>) = pairs.map(|(a, b)| (*a, *b)).unzip();
        match rigid(&a, &b) {
            Some((turn, shift)) => path.iter().map(|point| turn * point + shift).collect(),
            None => path,
        }
    }
}

/// Previews of all columns that are mapped.
pub(super) fn fill(
    columns: &mut [ProposedColumn],
    files: &[ProposedFile],
    raws: &[Raw],
    robot: Option<&RobotFile>,
) {
    let motion = robot.and_then(|robot| Motion::find(columns, raws, robot));
    let has_torques = |motion: &&Motion<'_>| {
        (0..JOINTS).any(|i| file_of(columns, TORQUE + i) == Some(motion.file))
    };
    let torques = motion
        .as_ref()
        .filter(has_torques)
        .map(|motion| motor_torques(&motion.robot.robot, &motion.encoders, &motion.time));
    let previews: Vec<Option<Preview>> = columns
        .iter()
        .map(|column| preview(column, columns, raws, motion.as_ref(), torques.as_deref()))
        .collect();
    for (column, preview) in columns.iter_mut().zip(previews) {
        column.preview = preview;
    }
    if let Some(motion) = &motion {
        predict_positions(columns, files, motion);
    }
}

/// The preview of one of the columns, with its prediction where that is of the rows of the encoders.
fn preview(
    column: &ProposedColumn,
    columns: &[ProposedColumn],
    raws: &[Raw],
    motion: Option<&Motion<'_>>,
    torques: Option<&[JointVector<f64>]>,
) -> Option<Preview> {
    let place = column.mapping.as_ref().ok()?.column;
    let time = times(columns, raws, column.file).filter(|_| place != TIME_COLUMN)?;
    let values = series(columns, raws, Some(column.file), place)?;
    let link = LogChannel::LinkEncoder.columns();
    let joint = place.checked_sub(TORQUE).filter(|i| *i < JOINTS);
    let same = motion.filter(|motion| motion.file == column.file);
    let predicted: Option<Vec<f64>> = match joint {
        Some(i) => same.and(torques).map(|all| all.iter().map(|torque| torque[i]).collect()),
        None if link.contains(&place) => same.map(|m| m.encoders[place - link.start].clone()),
        None => None,
    };
    let predicted = predicted.map(|values| thinned(&values));
    Some(Preview { time: thinned(&time), read: thinned(&values), predicted })
}

/// Adds to the previews of a tracker's position where the encoders put the tool.
fn predict_positions(columns: &mut [ProposedColumn], files: &[ProposedFile], motion: &Motion<'_>) {
    let place = |i: usize| columns.iter().position(|column| column.is(POSITION + i));
    let Some([x, y, z]) = place(0).zip(place(1)).zip(place(2)).map(|((x, y), z)| [x, y, z]) else {
        return;
    };
    let shown = [x, y, z].map(|k| columns[k].preview.clone());
    let [Some(px), Some(py), Some(pz)] = shown else { return };
    let seen: Vec<Vector3<f64>> = (0..px.read.len())
        .map(|k| Vector3::from([&px, &py, &pz].map(|p| p.read.get(k).copied().unwrap_or(f64::NAN))))
        .collect();
    let fitted = files[columns[x].file].fitted;
    let clock = fitted.map_or(ClockMap::OWN, |fitted| fitted.map);
    let positions = motion.positions(&px.time, &clock, &seen);
    for (i, k) in [x, y, z].into_iter().enumerate() {
        let predicted = positions.iter().map(|point| point[i]).collect();
        columns[k]
            .preview
            .iter_mut()
            .for_each(|preview| preview.predicted = Some(Vec::clone(&predicted)));
    }
}
