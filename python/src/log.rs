//! A recorded log as arrays.

use crate::error;
use numpy::ndarray::Array2;
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use std::path::PathBuf;
use std::thread;
use trueweld::logs::log::{Log, Samples};
use trueweld::plant::input::warnings;
use trueweld_output::log_notice_in_words;

/// A recorded log: its rows in SI units, in the frames of its files. What was not recorded is None;
/// of one joint alone, NaN.
#[pyclass(frozen, name = "Log", module = "trueweld")]
pub(crate) struct LogArrays {
    samples: Samples,
    /// Name of the folder.
    #[pyo3(get)]
    name: String,
    /// What was done: static-load, ring-down, free-motion or weld.
    #[pyo3(get)]
    kind: &'static str,
    /// Name of the robot.
    #[pyo3(get)]
    robot: String,
    /// Sampling period, s; None of rows at rest.
    #[pyo3(get)]
    period_s: Option<f64>,
    /// The files that it was read from.
    #[pyo3(get)]
    files: Vec<PathBuf>,
    /// What a reader should know although nothing is wrong.
    #[pyo3(get)]
    notices: Vec<String>,
    /// Values outside their plausible range, as they were read.
    #[pyo3(get)]
    warnings: Vec<String>,
}

/// Reads the log in a folder, with the robot, weld and process that it names: of one that gaps cut into
/// pieces the longest.
#[pyfunction]
pub(crate) fn read_log(py: Python<'_>, folder: PathBuf) -> PyResult<LogArrays> {
    // On a thread that has read nothing: its warnings are those of these files.
    let read = || (Log::read(&folder), warnings());
    let read = py.detach(|| thread::scope(|scope| scope.spawn(read).join()));
    let (log, warnings) = read.map_err(|_| error::fault("reading a log panicked"))?;
    let log = log.map_err(|refused| error::of_report(py, &refused.into()))?;
    Ok(LogArrays {
        name: log.name,
        kind: log.kind.name(),
        robot: log.robot.name,
        period_s: log.period,
        files: log.files,
        notices: log.notices.iter().map(log_notice_in_words).collect(),
        warnings,
        samples: log.samples,
    })
}

type RowArray<'py> = Bound<'py, PyArray2<f64>>;

#[pymethods]
impl LogArrays {
    fn __len__(&self) -> usize {
        self.samples.len()
    }

    fn __repr__(&self) -> String {
        format!("Log({:?}, {}, {} rows)", self.name, self.kind, self.samples.len())
    }

    /// Time, s, shape (time,).
    #[getter]
    fn time_s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.samples.time)
    }

    /// Encoder angles, rad, shape (time, joint).
    #[getter]
    fn encoder_rad<'py>(&self, py: Python<'py>) -> RowArray<'py> {
        rows(py, self.samples.encoder.iter().map(|row| row.as_slice()))
    }

    /// Angles by second encoders behind the gears, rad, shape (time, joint).
    #[getter]
    fn link_encoder_rad<'py>(&self, py: Python<'py>) -> Option<RowArray<'py>> {
        joints(py, &self.samples.link_encoder)
    }

    /// Motor torques seen from the joints, N·m, shape (time, joint).
    #[getter]
    fn motor_torque_nm<'py>(&self, py: Python<'py>) -> Option<RowArray<'py>> {
        joints(py, &self.samples.motor_torque)
    }

    /// Force on the tool, N, axes of T, shape (time, 3).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> Option<RowArray<'py>> {
        Some(rows(py, self.samples.force.as_ref()?.iter().map(|row| row.as_slice())))
    }

    /// Moment on the tool at its tip, N·m, axes of T, shape (time, 3).
    #[getter]
    fn moment_nm<'py>(&self, py: Python<'py>) -> Option<RowArray<'py>> {
        Some(rows(py, self.samples.moment.as_ref()?.iter().map(|row| row.as_slice())))
    }

    /// Position of the tool by the tracker, m, in B, shape (time, 3).
    #[getter]
    fn tracker_m<'py>(&self, py: Python<'py>) -> Option<RowArray<'py>> {
        Some(rows(py, self.samples.position.as_ref()?.iter().map(|row| row.as_slice())))
    }

    /// Rotation of the tool by the tracker as a rotation vector, rad, in B, shape (time, 3).
    #[getter]
    fn tracker_rad<'py>(&self, py: Python<'py>) -> Option<RowArray<'py>> {
        Some(rows(py, self.samples.rotation.as_ref()?.iter().map(|row| row.as_slice())))
    }

    /// Speed of the spindle, positive about the tool's z axis, rad/s, shape (time,).
    #[getter]
    fn spindle_rad_s<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyArray1<f64>>> {
        Some(PyArray1::from_slice(py, self.samples.spindle.as_ref()?))
    }
}

/// RowArray of equal length, C-contiguous.
fn rows<'py, 'r>(
    py: Python<'py>,
    rows: impl ExactSizeIterator<Item = &'r [f64]> + Clone,
) -> RowArray<'py> {
    let columns = rows.clone().next().map_or(0, <[f64]>::len);
    let values = rows.clone().flatten().copied().collect();
    let array = Array2::from_shape_vec((rows.len(), columns), values);
    PyArray2::from_owned_array(py, array.unwrap_or_default())
}

/// Columns of the joints side by side; None where no joint was recorded.
fn joints<'py>(py: Python<'py>, columns: &[Option<Vec<f64>>]) -> Option<RowArray<'py>> {
    let count = columns.iter().flatten().map(Vec::len).next()?;
    let value = |(row, joint): (usize, usize)| {
        columns[joint].as_ref().map_or(f64::NAN, |column| column[row])
    };
    Some(PyArray2::from_owned_array(py, Array2::from_shape_fn((count, columns.len()), value)))
}
