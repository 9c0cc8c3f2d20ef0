//! A weld period by period, as a class of Python.
//!
//! A simulation owns what changes; cell and weld are shared by its copies.

use crate::error;
use crate::law::{LawFailure, LawReadings, PythonLaw};
use crate::stepped::{RECORD_SIGNALS, Setting, SettingDigest, SteppedWeld};
use numpy::PyArray1;
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use trueweld::CellFiles;
use trueweld::laws::find_among;
use trueweld::plant::controllers::ControllerKind;
use trueweld::plant::input::{hexadecimal, warnings};
use trueweld::plant::simulate::Seam;

/// A weld period by period: what `trueweld.Simulation` stands on.
#[pyclass(frozen, module = "trueweld._core")]
pub(crate) struct CellSimulation {
    setting: Arc<Setting>,
    digest: SettingDigest,
    weld: Mutex<SteppedWeld>,
    /// Before the first period: what a reset goes back to.
    start: Arc<Mutex<SteppedWeld>>,
    /// Values outside their plausible range, as they were read.
    #[pyo3(get)]
    warnings: Vec<String>,
}

/// The name of a law of the library, or a name and a law in Python.
#[derive(FromPyObject)]
enum GivenLaw {
    Named(String),
    Python((String, Py<PyAny>)),
}

#[pymethods]
impl CellSimulation {
    /// A weld before its first period. Files and options as those of the command `weld`.
    #[new]
    #[pyo3(signature = (files, effects, numbers, seed, informed, controller, law, plant_step_s))]
    #[expect(clippy::too_many_arguments, reason = "the facade has them by name")]
    fn new(
        py: Python<'_>,
        files: [Option<PathBuf>; 6],
        effects: Vec<String>,
        numbers: [Option<f64>; 3],
        seed: Option<u64>,
        informed: bool,
        controller: &str,
        law: GivenLaw,
        plant_step_s: f64,
    ) -> PyResult<Self> {
        let [weld, robot, model, process, control, sensors] = files;
        let [stiffness_error, spindle_rpm, period] = numbers;
        let files = CellFiles {
            robot,
            model,
            informed,
            process,
            control,
            sensors,
            effects,
            stiffness_error,
            spindle_rpm,
            period,
            seed,
            found: Default::default(),
            law_files: Vec::new(),
        };
        let controller = ControllerKind::find(controller).map_err(|near| {
            let near = near.map_or(String::new(), |near| format!("; is {near} meant?"));
            PyValueError::new_err(format!("there is no controller {controller:?}{near}"))
        })?;
        if !(plant_step_s > 0.0 && plant_step_s.is_finite()) {
            let text = format!("plant_step_s={plant_step_s}: expected a number of seconds above 0");
            return Err(PyValueError::new_err(text));
        }
        let failure = LawFailure::default();
        let law = match law {
            GivenLaw::Named(name) => find_among(&name, &[])
                .map_err(|unknown| PyValueError::new_err(format!("there is no law {unknown:?}")))?,
            GivenLaw::Python((name, law)) => {
                PythonLaw::new(py, name, law, failure.clone())?.entry()
            }
        };
        // On a thread that has read nothing: its warnings are those of these files.
        let read = || (files.read_weld(weld.as_deref()), warnings());
        let read = py.detach(|| thread::scope(|scope| scope.spawn(read).join()));
        let (cell, warnings) = read.map_err(|_| error::fault("reading a cell panicked"))?;
        let cell = cell.map_err(|report| error::of_report(py, &report))?;
        let setting = Setting { cell, controller, law, plant_step: plant_step_s, failure };
        let start = Mutex::new(begin(py, &setting, setting.cell.seed)?);
        let weld = Mutex::new(again(py, &setting, &start)?);
        let (digest, setting, start) = (setting.digest(), Arc::new(setting), Arc::new(start));
        Ok(Self { setting, digest, weld, start, warnings })
    }

    /// One control period, or several, with a correction: six numbers, added to what the law demands.
    /// Gives how many periods were made: fewer at the end of the weld.
    #[pyo3(signature = (correction, periods))]
    fn step(&self, py: Python<'_>, correction: [f64; 6], periods: usize) -> PyResult<usize> {
        must_be_finite(&correction)?;
        let made = py.detach(|| {
            let mut weld = self.weld_detached();
            (0..periods).take_while(|_| weld.step(&self.setting, correction)).count()
        });
        self.must_be_sound(py)?;
        Ok(made)
    }

    /// From the start again, with noise from this seed; from that of the cell where none is given.
    #[pyo3(signature = (seed = None))]
    fn reset(&self, py: Python<'_>, seed: Option<u64>) -> PyResult<()> {
        let seed = seed.unwrap_or(self.setting.cell.seed);
        let begun = match seed == self.setting.cell.seed {
            true => again(py, &self.setting, &self.start)?,
            false => begin(py, &self.setting, seed)?,
        };
        *self.weld(py) = begun;
        Ok(())
    }

    /// The same weld at the same period, on its own from here on.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let (setting, start) = (Arc::clone(&self.setting), Arc::clone(&self.start));
        let (weld, warnings) = (Mutex::new(self.copied(py)?), self.warnings.clone());
        Ok(Self { setting, digest: self.digest, weld, start, warnings })
    }

    /// What the instruments show at the start of the period that comes.
    fn observe(&self, py: Python<'_>) -> LawReadings {
        LawReadings::of_period(&self.setting.cell, self.weld(py).period())
    }

    /// Names and values of the period that is over: axes of W, SI units. None before the first one.
    fn record(&self, py: Python<'_>) -> Option<Vec<(&'static str, Vec<f64>)>> {
        let weld = self.weld(py);
        let mut columns = weld.record()?;
        let signals = RECORD_SIGNALS.iter().map(|(name, width)| {
            let values;
            (values, columns) = columns.split_at(*width);
            (*name, values.to_vec())
        });
        Some(signals.collect())
    }

    /// Link angles, motor angles, link rates, motor rates: rad and rad/s, shape (24,).
    #[getter]
    fn cell_state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.weld(py).drives())
    }

    /// What the instruments show: see `roll_out`, shape (26,).
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.weld(py).readings())
    }

    /// Real tool against where it should be, axes of W: x, y, z in m, then the rotation in rad.
    #[getter]
    fn deviation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.weld(py).deviation())
    }

    /// Time at the start of the period that comes, s.
    #[getter]
    fn time_s(&self, py: Python<'_>) -> f64 {
        self.weld(py).periods().0 as f64 * self.period_s()
    }

    /// Where the tool is along the seam, m.
    #[getter]
    fn path_m(&self, py: Python<'_>) -> f64 {
        self.weld(py).period().target.path
    }

    /// Where the weld is in its program.
    #[getter]
    fn phase(&self, py: Python<'_>) -> &'static str {
        self.weld(py).period().target.phase.name()
    }

    /// True where the law, and a correction, act: while the force loop is closed.
    #[getter]
    fn is_corrected(&self, py: Python<'_>) -> bool {
        self.weld(py).period().target.force.is_some()
    }

    /// True after the last period.
    #[getter]
    fn is_over(&self, py: Python<'_>) -> bool {
        self.weld(py).is_done()
    }

    /// Why the weld broke off; None where it did not.
    #[getter]
    fn broken(&self, py: Python<'_>) -> Option<String> {
        self.weld(py).broken().map(str::to_owned)
    }

    /// Periods that are over, and those of the whole weld.
    #[getter]
    fn periods(&self, py: Python<'_>) -> (usize, usize) {
        self.weld(py).periods()
    }

    /// Control period, s.
    #[getter]
    fn period_s(&self) -> f64 {
        self.setting.cell.control.period
    }

    /// Length of the seam, m.
    #[getter]
    fn length_m(&self) -> f64 {
        Seam::of(&self.setting.cell.weld).length
    }

    /// Largest correction, m and rad.
    #[getter]
    fn largest_correction(&self) -> (f64, f64) {
        let limits = &self.setting.cell.control.compensation;
        (limits.lateral.size, limits.orientation.size)
    }

    /// How far beside its line the tool may be, m.
    #[getter]
    fn lateral_tolerance_m(&self) -> f64 {
        self.setting.cell.planned.model.lateral_tolerance()
    }

    /// The law's name.
    #[getter]
    fn law(&self) -> &str {
        self.setting.law.name()
    }

    /// SHA-256 of all that the simulation follows from, in hexadecimal digits.
    #[getter]
    fn digest(&self) -> String {
        hexadecimal(&self.digest)
    }

    /// The state in bytes.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let state = self.weld(py).state(&self.digest);
        Ok(PyBytes::new(py, &self.unless_raised(state)?))
    }

    /// Goes to a state that `state` gave: of a simulation of the same cell, weld, law and program.
    fn restore(&self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        let mut weld = self.weld(py);
        let restored = weld.restored(&self.setting, &self.digest, state);
        let restored =
            restored.map_err(|why| format!("this is no state of this simulation: {why}"));
        *weld = self.unless_raised(restored)?;
        Ok(())
    }
}

impl CellSimulation {
    /// What is shared with its copies, and never changes.
    pub(crate) fn setting(&self) -> &Arc<Setting> {
        &self.setting
    }

    /// What changes. Whoever else holds it may wait for the interpreter, which is let go meanwhile.
    fn weld(&self, py: Python<'_>) -> MutexGuard<'_, SteppedWeld> {
        self.weld.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    /// The same on a thread without the interpreter.
    pub(crate) fn weld_detached(&self) -> MutexGuard<'_, SteppedWeld> {
        self.weld.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The weld as it is now, on its own from here on.
    pub(crate) fn copied(&self, py: Python<'_>) -> PyResult<SteppedWeld> {
        let copied = self.weld(py).copied(&self.setting);
        self.unless_raised(copied)
    }

    /// What was done. Where it failed, raises what a law raised, or else why.
    fn unless_raised<V>(&self, done: Result<V, String>) -> PyResult<V> {
        done.map_err(|why| {
            self.setting.failure.take().unwrap_or_else(|| PyValueError::new_err(why))
        })
    }

    /// Raises what a law raised, and why the weld broke off.
    fn must_be_sound(&self, py: Python<'_>) -> PyResult<()> {
        if let Some(raised) = self.setting.failure.take() {
            return Err(raised);
        }
        match self.weld(py).broken() {
            Some(why) => Err(PyRuntimeError::new_err(why.to_owned())),
            None => Ok(()),
        }
    }
}

fn begin(py: Python<'_>, setting: &Setting, seed: u64) -> PyResult<SteppedWeld> {
    built(setting, py.detach(|| SteppedWeld::begin(setting, seed)))
}

/// The weld before its first period again.
fn again(py: Python<'_>, setting: &Setting, start: &Mutex<SteppedWeld>) -> PyResult<SteppedWeld> {
    let start = || start.lock().unwrap_or_else(PoisonError::into_inner);
    built(setting, py.detach(|| start().begun_again(setting)))
}

/// A weld that was built. Where building its law raised something, raises it.
fn built(setting: &Setting, weld: Result<SteppedWeld, String>) -> PyResult<SteppedWeld> {
    match setting.failure.take() {
        Some(raised) => Err(raised),
        None => weld.map_err(PyValueError::new_err),
    }
}

pub(crate) fn must_be_finite<'n>(correction: impl IntoIterator<Item = &'n f64>) -> PyResult<()> {
    match correction.into_iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(PyValueError::new_err("a correction is not finite; expected numbers")),
    }
}
