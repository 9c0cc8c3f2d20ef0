//! A weld period by period, and many of them on all cores.
//!
//! A simulation owns what changes; cell and weld are shared by its copies. One with a law, and one
//! from a kept state, is made anew by the same corrections from the start: it is the same to the last
//! bit.

use crate::error;
use crate::law::{LawFailure, LawReadings, PythonLaw, six_of, twist};
use numpy::ndarray::{Array2, Array3, ArrayView2, ArrayViewMut2, Axis};
use numpy::{PyArray1, PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::sync::MutexExt;
use pyo3::types::PyBytes;
use rayon::prelude::*;
use sha2::{Digest, Sha256};
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::Duration;
use trueweld::core::compensation::{Compensator, Observation};
use trueweld::core::{Fault, Robot, Twist};
use trueweld::laws::{Entry, Uncompensated, find_among};
use trueweld::plant::controllers::ControllerKind;
use trueweld::plant::input::warnings;
use trueweld::plant::provenance::Provenance;
use trueweld::plant::simulate::{CellView, RecordRow, Scenario, Seam, Simulation, WeldProgram};
use trueweld::{CellFiles, WeldingCell};

/// First bytes of a kept state, with the version of its format.
const STATE_HEAD: &[u8] = b"trueweld-state/1";

/// Bytes of a digest, and of one correction in a kept state.
const DIGEST_BYTES: usize = 32;
const CORRECTION_BYTES: usize = 6 * size_of::<f64>();

/// Columns of a state: link angles, motor angles, link rates, motor rates.
const STATE_COLUMNS: usize = 24;

/// Columns of the readings: encoder angles and rates, motor torques, force, moment, seam sensor across
/// and in tilt.
const READING_COLUMNS: usize = 26;

/// Columns of the deviation: displacement, rotation.
const DEVIATION_COLUMNS: usize = 6;

/// Time between two looks at signals.
const SIGNAL_PERIOD: Duration = Duration::from_millis(50);

/// What a simulation is made of and never changes.
struct Setting {
    cell: WeldingCell,
    controller: ControllerKind,
    law: Entry,
    /// Longest plant step, s.
    plant_step: f64,
    /// What a law in Python raised.
    failure: LawFailure,
    /// Of all this and of the program.
    digest: [u8; DIGEST_BYTES],
}

impl Setting {
    fn scenario(&self, seed: u64) -> Scenario<'_> {
        let scenario = self.cell.scenario(WeldProgram::Weld, self.controller, &self.law);
        Scenario { plant_step: self.plant_step, seed, ..scenario }
    }

    /// Whether there is a law, which cannot be copied in the middle of a weld.
    fn has_law(&self) -> bool {
        self.law.name() != Entry::of::<Uncompensated>().name()
    }
}

/// SHA-256 of everything that a simulation follows from, whatever the names of its files.
fn digest(of: &Provenance) -> [u8; DIGEST_BYTES] {
    let mut digest = Sha256::new();
    let Provenance { version, sources, robot, effects, simulation, files, .. } = of;
    digest.update(format!("{version} {sources} {robot} {effects:?} {simulation:?}"));
    for file in files {
        digest.update(format!("{} {}", file.role, file.sha256));
    }
    digest.finalize().into()
}

/// A law with a correction from outside added to what it demands.
struct SteppedLaw {
    /// None where there is no law but the correction.
    inner: Option<Box<dyn Compensator<f64> + Send>>,
    added: Twist<f64>,
}

impl Compensator<f64> for SteppedLaw {
    fn reset(&mut self) {
        if let Some(law) = &mut self.inner {
            law.reset();
        }
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        match &mut self.inner {
            Some(law) => Ok(law.demand(robot, observation)? + self.added),
            None => Ok(self.added),
        }
    }
}

impl Clone for SteppedLaw {
    /// Without the law: only a simulation that has none is copied in the middle of a weld.
    fn clone(&self) -> Self {
        Self { inner: None, added: self.added }
    }
}

/// What changes.
#[derive(Clone)]
struct Progressing {
    /// Of the instruments' noise.
    seed: u64,
    run: Simulation<SteppedLaw>,
    /// The start of the period that comes; after the last one, of the last one.
    period: CellView,
    /// The period that is over; none before the first.
    row: Option<RecordRow>,
    /// Corrections so far.
    corrections: Vec<[f64; 6]>,
    /// Why it cannot go on, where it cannot.
    broken: Option<String>,
}

impl Progressing {
    fn begin(setting: &Arc<Setting>, seed: u64) -> Result<Self, String> {
        let scenario = setting.scenario(seed);
        let failed = |error: trueweld::plant::simulate::RunError| error.to_string();
        let inner = match setting.has_law() {
            true => Some(scenario.build_law().map_err(failed)?),
            false => None,
        };
        let law = SteppedLaw { inner, added: Twist::zero() };
        let mut run = Simulation::with_law(&scenario, law).map_err(failed)?;
        let period = run.observe(&scenario);
        Ok(Self { seed, run, period, row: None, corrections: Vec::new(), broken: None })
    }

    /// One period with a correction; false where the weld is over or broken.
    fn step(&mut self, setting: &Setting, correction: [f64; 6]) -> bool {
        if self.run.is_done() || self.broken.is_some() {
            return false;
        }
        let scenario = setting.scenario(self.seed);
        self.run.law().added = twist(correction);
        self.row = Some(self.run.control(&scenario, &self.period));
        self.corrections.push(correction);
        if let Err(diverged) = self.run.advance(&scenario) {
            self.broken = Some(diverged.to_string());
            return true;
        }
        if !self.run.is_done() {
            self.period = self.run.observe(&scenario);
        }
        true
    }

    fn state(&self) -> [f64; STATE_COLUMNS] {
        let drives = self.run.motion().state.drives();
        let parts = [drives.link, drives.motor, drives.link_rate, drives.motor_rate];
        let mut state = [0.0; STATE_COLUMNS];
        for (columns, part) in state.chunks_exact_mut(6).zip(parts) {
            columns.copy_from_slice(part.as_slice());
        }
        state
    }

    fn readings(&self) -> [f64; READING_COLUMNS] {
        let sensed = &self.period.readings.sensed;
        let mut readings = [f64::NAN; READING_COLUMNS];
        for (columns, part) in readings.chunks_exact_mut(6).zip([
            sensed.encoder.as_slice(),
            sensed.encoder_rate.as_slice(),
            sensed.motor_torque.as_slice(),
        ]) {
            columns.copy_from_slice(part);
        }
        readings[18..21].copy_from_slice(sensed.wrench.force.as_slice());
        readings[21..24].copy_from_slice(sensed.wrench.moment.as_slice());
        for seen in self.period.readings.measurements.iter().filter(|seen| seen.is_usable()) {
            let column = if seen.along.linear.y > 0.0 { 24 } else { 25 };
            readings[column] = seen.deviation;
        }
        readings
    }

    fn deviation(&self) -> [f64; DEVIATION_COLUMNS] {
        six_of(&self.period.readings.deviation_w)
    }
}

/// A weld period by period: what `trueweld.Simulation` stands on.
#[pyclass(frozen, module = "trueweld._core")]
pub(crate) struct CellSimulation {
    setting: Arc<Setting>,
    progressing: Mutex<Progressing>,
    /// Before the first period, where there is no law: what a reset goes back to.
    start: Mutex<Option<Progressing>>,
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
        let of = cell.simulation(&[controller], std::slice::from_ref(&law), 1, plant_step_s);
        let digest = digest(&cell.provenance("simulation", of));
        let setting = Setting { cell, controller, law, plant_step: plant_step_s, failure, digest };
        let setting = Arc::new(setting);
        let begun = begin(py, &setting, setting.cell.seed)?;
        let start = Mutex::new((!setting.has_law()).then(|| begun.clone()));
        Ok(Self { setting, progressing: Mutex::new(begun), start, warnings })
    }

    /// One control period, or several, with a correction: six numbers, added to what the law demands.
    /// Gives how many periods were made: fewer at the end of the weld.
    #[pyo3(signature = (correction, periods))]
    fn step(&self, py: Python<'_>, correction: [f64; 6], periods: usize) -> PyResult<usize> {
        must_be_finite(&correction)?;
        let made = py.detach(|| {
            let mut progressing = self.progressing_detached();
            (0..periods).take_while(|_| progressing.step(&self.setting, correction)).count()
        });
        self.must_be_sound(py)?;
        Ok(made)
    }

    /// From the start again, with noise from this seed; from that of the cell where none is given.
    #[pyo3(signature = (seed = None))]
    fn reset(&self, py: Python<'_>, seed: Option<u64>) -> PyResult<()> {
        let seed = seed.unwrap_or(self.setting.cell.seed);
        let kept = self.start().filter(|start| start.seed == seed);
        let begun = match kept {
            Some(start) => start,
            None => begin(py, &self.setting, seed)?,
        };
        *self.progressing(py) = begun;
        Ok(())
    }

    /// The same weld at the same period, on its own from here on.
    fn copy(&self, py: Python<'_>) -> PyResult<Self> {
        let progressing = Mutex::new(self.copied(py)?);
        let (setting, start) = (Arc::clone(&self.setting), Mutex::new(self.start()));
        Ok(Self { setting, progressing, start, warnings: self.warnings.clone() })
    }

    /// What the instruments show at the start of the period that comes.
    fn observe(&self, py: Python<'_>) -> LawReadings {
        let progressing = self.progressing(py);
        LawReadings::of_period(&self.setting.cell, &progressing.period)
    }

    /// Names and values of the period that is over: axes of W, SI units. None before the first one.
    fn record(&self, py: Python<'_>) -> Option<Vec<(&'static str, Vec<f64>)>> {
        let row = self.progressing(py).row?;
        let of = |values: &[f64]| values.to_vec();
        Some(vec![
            ("time_s", vec![row.time]),
            ("path_m", vec![row.path]),
            ("deviation_m", of(row.deviation_w.linear.as_slice())),
            ("deviation_rad", of(row.deviation_w.angular.as_slice())),
            ("correction_m", of(row.correction_w.linear.as_slice())),
            ("correction_rad", of(row.correction_w.angular.as_slice())),
            ("force_n", of(row.force_w.as_slice())),
            ("link_rad", of(row.link.as_slice())),
            ("motor_rad", of(row.motor.as_slice())),
            ("torque_nm", of(row.torque.as_slice())),
        ])
    }

    /// Link angles, motor angles, link rates, motor rates: rad and rad/s, shape (24,).
    #[getter]
    fn cell_state<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.progressing(py).state())
    }

    /// What the instruments show: see `roll_out`, shape (26,).
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.progressing(py).readings())
    }

    /// Real tool against where it should be, axes of W: x, y, z in m, then the rotation in rad.
    #[getter]
    fn deviation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.progressing(py).deviation())
    }

    /// Time at the start of the period that comes, s.
    #[getter]
    fn time_s(&self, py: Python<'_>) -> f64 {
        self.progressing(py).run.periods_done() as f64 * self.period_s()
    }

    /// Where the tool is along the seam, m.
    #[getter]
    fn path_m(&self, py: Python<'_>) -> f64 {
        self.progressing(py).period.target.path
    }

    /// Where the weld is in its program.
    #[getter]
    fn phase(&self, py: Python<'_>) -> &'static str {
        self.progressing(py).period.target.phase.name()
    }

    /// True where the law, and a correction, act: while the force loop is closed.
    #[getter]
    fn is_corrected(&self, py: Python<'_>) -> bool {
        self.progressing(py).period.target.force.is_some()
    }

    /// True after the last period.
    #[getter]
    fn is_over(&self, py: Python<'_>) -> bool {
        self.progressing(py).run.is_done()
    }

    /// Why the weld broke off; None where it did not.
    #[getter]
    fn broken(&self, py: Python<'_>) -> Option<String> {
        self.progressing(py).broken.clone()
    }

    /// Periods that are over, and those of the whole weld.
    #[getter]
    fn periods(&self, py: Python<'_>) -> (usize, usize) {
        let run = &self.progressing(py).run;
        (run.periods_done(), run.periods())
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
        self.setting.digest.iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// The state in bytes: the digest, and the corrections so far.
    fn state<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        let progressing = self.progressing(py);
        let numbers =
            progressing.corrections.iter().flatten().flat_map(|value| value.to_le_bytes());
        let bytes = [STATE_HEAD, &self.setting.digest, &progressing.seed.to_le_bytes()].concat();
        PyBytes::new(py, &bytes.into_iter().chain(numbers).collect::<Vec<u8>>())
    }

    /// Goes to a state that `state` gave: of a simulation of the same cell, weld, law and program.
    fn restore(&self, py: Python<'_>, state: &[u8]) -> PyResult<()> {
        let refuse = |why: &str| {
            Err(PyValueError::new_err(format!("this is no state of this simulation: {why}")))
        };
        let Some(rest) = state.strip_prefix(STATE_HEAD) else {
            return refuse("it is of another program or version");
        };
        let Some((digest, numbers)) = rest.split_at_checked(DIGEST_BYTES) else {
            return refuse("it is too short");
        };
        if digest != self.setting.digest {
            return refuse("cell, weld, law, options or the version of trueweld are others");
        }
        let Some((seed, numbers)) = numbers.split_first_chunk() else {
            return refuse("it is too short");
        };
        if !numbers.len().is_multiple_of(CORRECTION_BYTES) {
            return refuse("it is cut off");
        }
        let number = |bytes: &[u8]| f64::from_le_bytes(bytes.try_into().unwrap_or_default());
        let correction = |bytes: &[u8]| {
            let mut numbers = bytes.chunks_exact(size_of::<f64>()).map(number);
            std::array::from_fn(|_| numbers.next().unwrap_or_default())
        };
        let corrections: Vec<[f64; 6]> =
            numbers.chunks_exact(CORRECTION_BYTES).map(correction).collect();
        let restored = replayed(py, &self.setting, u64::from_le_bytes(*seed), &corrections)?;
        *self.progressing(py) = restored;
        Ok(())
    }
}

impl CellSimulation {
    /// What changes. Whoever else holds it may wait for the interpreter, which is let go meanwhile.
    fn progressing(&self, py: Python<'_>) -> MutexGuard<'_, Progressing> {
        self.progressing.lock_py_attached(py).unwrap_or_else(PoisonError::into_inner)
    }

    /// The same on a thread without the interpreter.
    fn progressing_detached(&self) -> MutexGuard<'_, Progressing> {
        self.progressing.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A copy of the weld before its first period, where one is kept.
    fn start(&self) -> Option<Progressing> {
        self.start.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// The weld as it is now, on its own from here on.
    fn copied(&self, py: Python<'_>) -> PyResult<Progressing> {
        if !self.setting.has_law() {
            return Ok(self.progressing(py).clone());
        }
        let (seed, corrections) = {
            let progressing = self.progressing(py);
            (progressing.seed, progressing.corrections.clone())
        };
        replayed(py, &self.setting, seed, &corrections)
    }

    /// Raises what a law raised, and why the weld broke off.
    fn must_be_sound(&self, py: Python<'_>) -> PyResult<()> {
        if let Some(raised) = self.setting.failure.take() {
            return Err(raised);
        }
        match &self.progressing(py).broken {
            Some(why) => Err(PyRuntimeError::new_err(why.clone())),
            None => Ok(()),
        }
    }
}

fn begin(py: Python<'_>, setting: &Arc<Setting>, seed: u64) -> PyResult<Progressing> {
    let begun = py.detach(|| Progressing::begin(setting, seed));
    if let Some(raised) = setting.failure.take() {
        return Err(raised);
    }
    begun.map_err(PyValueError::new_err)
}

/// The weld with these corrections from the start.
fn replayed(
    py: Python<'_>,
    setting: &Arc<Setting>,
    seed: u64,
    corrections: &[[f64; 6]],
) -> PyResult<Progressing> {
    let mut progressing = begin(py, setting, seed)?;
    py.detach(|| corrections.iter().all(|correction| progressing.step(setting, *correction)));
    Ok(progressing)
}

fn must_be_finite<'n>(correction: impl IntoIterator<Item = &'n f64>) -> PyResult<()> {
    match correction.into_iter().all(|value| value.is_finite()) {
        true => Ok(()),
        false => Err(PyValueError::new_err("a correction is not finite; expected numbers")),
    }
}

/// Arrays of a roll-out: states, readings, deviations, and the periods made.
type RolledOut<'py> =
    (Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>, Bound<'py, PyArray3<f64>>, Vec<usize>);

/// Steps copies of simulations with a correction each period, on all cores.
///
/// `simulations`: one for all rows, or one a row. `corrections`: of shape (row, period, 6), or one row
/// for all; none: no corrections. `periods`: how many, at most. `every`: a column of the result for so
/// many periods. Results are of shape (row, period, column); NaN where a weld was over before.
#[pyfunction]
#[pyo3(signature = (simulations, corrections, periods, every))]
pub(crate) fn roll_out<'py>(
    py: Python<'py>,
    simulations: Vec<Py<CellSimulation>>,
    corrections: Option<PyReadonlyArray3<'py, f64>>,
    periods: usize,
    every: usize,
) -> PyResult<RolledOut<'py>> {
    let corrections = corrections.as_ref().map(PyReadonlyArray3::as_array);
    let (rows_given, periods) = match &corrections {
        None => (1, periods),
        Some(corrections) => match *corrections.shape() {
            [rows, periods, 6] => (rows, periods),
            _ => {
                return Err(PyValueError::new_err(
                    "corrections: expected the shape (row, period, 6)",
                ));
            }
        },
    };
    if let Some(corrections) = &corrections {
        must_be_finite(corrections)?;
    }
    let rows = rows_given.max(simulations.len());
    if [rows_given, simulations.len()].iter().any(|given| *given != 1 && *given != rows) {
        let text = format!(
            "{} simulations and {rows_given} rows of corrections: expected one of them, or as many",
            simulations.len()
        );
        return Err(PyValueError::new_err(text));
    }
    let kept = periods / every.max(1);
    let mut arrays = [STATE_COLUMNS, READING_COLUMNS, DEVIATION_COLUMNS]
        .map(|columns| Array3::from_elem((rows, kept, columns), f64::NAN));
    let copies = (0..rows).map(|row| {
        let of = simulations[row % simulations.len()].get();
        Ok((Arc::clone(&of.setting), of.copied(py)?))
    });
    let mut copies = copies.collect::<PyResult<Vec<_>>>()?;
    let [states, readings, deviations] = &mut arrays;
    let views =
        states.outer_iter_mut().zip(readings.outer_iter_mut()).zip(deviations.outer_iter_mut());
    let views: Vec<RowViews<'_>> = views
        .map(|((states, readings), deviations)| RowViews { states, readings, deviations })
        .collect();
    let made = interruptible(py, |stop| {
        let work = copies.par_iter_mut().zip(views).enumerate().map(
            |(row, ((setting, progressing), views))| {
                let corrections =
                    corrections.as_ref().map(|all| all.index_axis(Axis(0), row % rows_given));
                views.fill(
                    setting,
                    progressing,
                    corrections,
                    KeptPeriods { periods, every: every.max(1) },
                    stop,
                )
            },
        );
        work.collect::<Vec<usize>>()
    })?;
    if let Some(raised) = copies.iter().find_map(|(setting, _)| setting.failure.take()) {
        return Err(raised);
    }
    let [states, readings, deviations] = arrays.map(|array| PyArray3::from_owned_array(py, array));
    Ok((states, readings, deviations, made))
}

/// What is kept of a row of a roll-out.
#[derive(Clone, Copy)]
struct KeptPeriods {
    periods: usize,
    every: usize,
}

/// Where a row of a roll-out goes.
struct RowViews<'a> {
    states: ArrayViewMut2<'a, f64>,
    readings: ArrayViewMut2<'a, f64>,
    deviations: ArrayViewMut2<'a, f64>,
}

impl RowViews<'_> {
    /// Steps one simulation; gives the periods made.
    fn fill(
        mut self,
        setting: &Setting,
        progressing: &mut Progressing,
        corrections: Option<ArrayView2<'_, f64>>,
        KeptPeriods { periods, every }: KeptPeriods,
        stop: &AtomicBool,
    ) -> usize {
        for k in 0..periods {
            let correction =
                corrections.map_or([0.0; 6], |all| std::array::from_fn(|i| all[[k, i]]));
            if stop.load(Ordering::Relaxed)
                || !progressing.step(setting, correction)
                || progressing.broken.is_some()
            {
                return k;
            }
            if (k + 1) % every == 0 {
                let at = k / every;
                let put = |view: &mut ArrayViewMut2<'_, f64>, values: &[f64]| {
                    view.row_mut(at).iter_mut().zip(values).for_each(|(to, from)| *to = *from);
                };
                put(&mut self.states, &progressing.state());
                put(&mut self.readings, &progressing.readings());
                put(&mut self.deviations, &progressing.deviation());
            }
        }
        periods
    }
}

/// Does work without the interpreter, on another thread, and sees to signals meanwhile. The work ends
/// early where it is told to.
fn interruptible<R: Send>(
    py: Python<'_>,
    work: impl FnOnce(&AtomicBool) -> R + Send,
) -> PyResult<R> {
    let stop = AtomicBool::new(false);
    let mut interrupted = Ok(());
    let done = py.detach(|| {
        thread::scope(|scope| {
            let (sender, receiver) = channel();
            let stop = &stop;
            let worker = scope.spawn(move || {
                let done = work(stop);
                // Whoever waits is there until this thread ends.
                let _ = sender.send(());
                done
            });
            while let Err(RecvTimeoutError::Timeout) = receiver.recv_timeout(SIGNAL_PERIOD) {
                if interrupted.is_ok() {
                    interrupted = Python::attach(|py| py.check_signals());
                    stop.store(interrupted.is_err(), Ordering::Relaxed);
                }
            }
            worker.join()
        })
    });
    interrupted?;
    done.map_err(|_| error::fault("a thread panicked"))
}

/// Readings, deviations, and which welds are over or broken off.
type RolledBatch<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>, Vec<bool>);

/// Steps simulations side by side, each with a correction of its own, so many periods; on all cores.
/// Gives readings and deviations, of shape (simulation, column), and which welds are over or broken off.
#[pyfunction]
#[pyo3(signature = (simulations, corrections, periods))]
pub(crate) fn step_all<'py>(
    py: Python<'py>,
    simulations: Vec<Py<CellSimulation>>,
    corrections: PyReadonlyArray2<'py, f64>,
    periods: usize,
) -> PyResult<RolledBatch<'py>> {
    let corrections = corrections.as_array();
    if *corrections.shape() != [simulations.len(), 6] {
        return Err(PyValueError::new_err("corrections: expected the shape (simulation, 6)"));
    }
    must_be_finite(corrections)?;
    let mut readings = Array2::zeros((simulations.len(), READING_COLUMNS));
    let mut deviations = Array2::zeros((simulations.len(), DEVIATION_COLUMNS));
    let all: Vec<&CellSimulation> = simulations.iter().map(|simulation| simulation.get()).collect();
    let over = interruptible(py, |stop| {
        let step = |(k, simulation): (usize, &&CellSimulation)| {
            let correction = std::array::from_fn(|i| corrections[[k, i]]);
            let mut progressing = simulation.progressing_detached();
            for _ in 0..periods {
                if stop.load(Ordering::Relaxed)
                    || !progressing.step(&simulation.setting, correction)
                {
                    break;
                }
            }
            let over = progressing.run.is_done() || progressing.broken.is_some();
            (progressing.readings(), progressing.deviation(), over)
        };
        all.par_iter().enumerate().map(step).collect::<Vec<_>>()
    })?;
    for (k, (read, deviation, _)) in over.iter().enumerate() {
        readings.row_mut(k).iter_mut().zip(read).for_each(|(to, from)| *to = *from);
        deviations.row_mut(k).iter_mut().zip(deviation).for_each(|(to, from)| *to = *from);
    }
    if let Some(raised) = all.iter().find_map(|simulation| simulation.setting.failure.take()) {
        return Err(raised);
    }
    let over = over.into_iter().map(|(_, _, over)| over).collect();
    Ok((PyArray2::from_owned_array(py, readings), PyArray2::from_owned_array(py, deviations), over))
}
