//! Many welds side by side on all cores.

use crate::error;
use crate::simulation::{CellSimulation, must_be_finite};
use crate::stepped::{DEVIATION_COLUMNS, READING_COLUMNS, STATE_COLUMNS, Setting, SteppedWeld};
use numpy::ndarray::{Array2, Array3, ArrayView2, ArrayViewMut2, Axis};
use numpy::{PyArray2, PyArray3, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// Time between two looks at signals.
const SIGNAL_PERIOD: Duration = Duration::from_millis(50);

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
        Ok((Arc::clone(of.setting()), of.copied(py)?))
    });
    let mut copies = copies.collect::<PyResult<Vec<_>>>()?;
    let [states, readings, deviations] = &mut arrays;
    let views =
        states.outer_iter_mut().zip(readings.outer_iter_mut()).zip(deviations.outer_iter_mut());
    let views: Vec<RowViews<'_>> = views
        .map(|((states, readings), deviations)| RowViews { states, readings, deviations })
        .collect();
    let made = interruptible(py, |stop| {
        let work =
            copies.par_iter_mut().zip(views).enumerate().map(|(row, ((setting, weld), views))| {
                let corrections =
                    corrections.as_ref().map(|all| all.index_axis(Axis(0), row % rows_given));
                views.fill(
                    setting,
                    weld,
                    corrections,
                    KeptPeriods { periods, every: every.max(1) },
                    stop,
                )
            });
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
        weld: &mut SteppedWeld,
        corrections: Option<ArrayView2<'_, f64>>,
        KeptPeriods { periods, every }: KeptPeriods,
        stop: &AtomicBool,
    ) -> usize {
        for k in 0..periods {
            let correction =
                corrections.map_or([0.0; 6], |all| std::array::from_fn(|i| all[[k, i]]));
            if stop.load(Ordering::Relaxed)
                || !weld.step(setting, correction)
                || weld.broken().is_some()
            {
                return k;
            }
            if (k + 1) % every == 0 {
                let at = k / every;
                let put = |view: &mut ArrayViewMut2<'_, f64>, values: &[f64]| {
                    view.row_mut(at).iter_mut().zip(values).for_each(|(to, from)| *to = *from);
                };
                put(&mut self.states, &weld.drives());
                put(&mut self.readings, &weld.readings());
                put(&mut self.deviations, &weld.deviation());
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
            let mut weld = simulation.weld_detached();
            for _ in 0..periods {
                if stop.load(Ordering::Relaxed) || !weld.step(simulation.setting(), correction) {
                    break;
                }
            }
            let over = weld.is_done() || weld.broken().is_some();
            (weld.readings(), weld.deviation(), over)
        };
        all.par_iter().enumerate().map(step).collect::<Vec<_>>()
    })?;
    for (k, (read, deviation, _)) in over.iter().enumerate() {
        readings.row_mut(k).iter_mut().zip(read).for_each(|(to, from)| *to = *from);
        deviations.row_mut(k).iter_mut().zip(deviation).for_each(|(to, from)| *to = *from);
    }
    if let Some(raised) = all.iter().find_map(|simulation| simulation.setting().failure.take()) {
        return Err(raised);
    }
    let over = over.into_iter().map(|(_, _, over)| over).collect();
    Ok((PyArray2::from_owned_array(py, readings), PyArray2::from_owned_array(py, deviations), over))
}
