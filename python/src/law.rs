//! A law in Python as one of the simulator's.
//!
//! Every run has a law of its own: a deep copy of the object that was given, or a new object where a
//! class was given. What it raises ends the command and is raised there.

use crate::error;
use nalgebra::{Matrix3, Vector3};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyType};
use std::sync::{Arc, Mutex, PoisonError};
use trueweld::WeldingCell;
use trueweld::core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld::core::control::{SensorReadings, Setpoint};
use trueweld::core::state::{StateError, StateResult, StateVisitor};
use trueweld::core::{Fault, Pose, Robot, Twist, Wrench};
use trueweld::laws::{Entry, FeedForward, FollowingGains, Needs, OuterIntegral, Setup};
use trueweld::plant::simulate::CellView;

/// Most periods that a state of a law can count, and most bytes that it can have.
const LAW_PERIODS_MAX: usize = 1 << 48;
const LAW_BYTES_MAX: usize = 1 << 32;

/// What a law raised, for the thread that waits for its command.
#[derive(Clone, Default)]
pub(crate) struct LawFailure(Arc<Mutex<Option<PyErr>>>);

impl LawFailure {
    fn set(&self, raised: PyErr) {
        let mut first = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        first.get_or_insert(raised);
    }

    /// True from when something was raised.
    pub(crate) fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// What was raised first.
    pub(crate) fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// A law in Python, before its first run.
pub(crate) struct PythonLaw {
    name: String,
    /// An object with `demand(readings)`, a class of such objects, or a function of the readings.
    given: Py<PyAny>,
    needs: Needs,
    /// Share of its rate across the seam with which the outer integral stands on top of it; none where
    /// it does not.
    followed: Option<f64>,
    failure: LawFailure,
}

impl PythonLaw {
    pub(crate) fn new(
        py: Python<'_>,
        name: String,
        given: Py<PyAny>,
        failure: LawFailure,
    ) -> PyResult<Self> {
        let of = given.bind(py);
        let has = |attribute: &str| -> PyResult<bool> {
            match of.getattr_opt(attribute)? {
                Some(value) => value.is_truthy(),
                None => Ok(false),
            }
        };
        must_be_law(of)?;
        let needs = Needs {
            seam_sensor: has("needs_seam_sensor")?,
            passes: has("needs_passes")?,
            ..Needs::NOTHING
        };
        let share = of.getattr_opt("outer_integral")?;
        let share = share.map(|share| share.extract::<f64>()).transpose()?;
        let followed = share.filter(|share| *share != 0.0);
        Ok(Self { name, needs, followed, failure, given })
    }

    /// The law as those of the library are listed.
    pub(crate) fn entry(self) -> Entry {
        let summary = "a law in Python".to_owned();
        Entry::foreign(self.name.clone(), summary, self.needs, move |setup| self.build(setup))
    }

    fn build(&self, setup: &Setup<f64>) -> Result<Box<dyn Compensator<f64> + Send>, String> {
        let built = Python::attach(|py| RunningPythonLaw::new(py, self, setup.period));
        let law = built.map_err(|raised| {
            let text = raised.to_string();
            self.failure.set(raised);
            text
        })?;
        let Some(share) = self.followed else {
            return Ok(Box::new(law));
        };
        let gains = FollowingGains { rate: share * setup.following.rate, ..setup.following };
        let followed = OuterIntegral::new(law, &gains, setup.period);
        followed
            .map(|law| Box::new(law) as _)
            .map_err(|gain| format!("{}: expected {}", gain.key, gain.expected))
    }
}

/// A law in Python in one run.
struct RunningPythonLaw {
    name: String,
    /// What has a state; `None` of a function.
    object: Option<Py<PyAny>>,
    demand: Py<PyAny>,
    reset: Option<Py<PyAny>>,
    freeze: Option<Py<PyAny>>,
    period: f64,
    /// Periods since the start of the weld in which it was asked.
    periods: usize,
    /// The controller's model of the robot, once it was seen.
    robot: Option<Arc<Robot<f64>>>,
    failure: LawFailure,
}

impl RunningPythonLaw {
    fn new(py: Python<'_>, law: &PythonLaw, period: f64) -> PyResult<Self> {
        let given = law.given.bind(py);
        let is_class = given.is_instance_of::<PyType>();
        let object = if is_class {
            let object = given.call0()?;
            must_be_law(&object)?;
            object
        } else if given.getattr_opt("demand")?.is_some() {
            py.import("copy")?.getattr("deepcopy")?.call1((given,))?
        } else {
            given.clone()
        };
        let method = |name: &str| -> PyResult<Option<Py<PyAny>>> {
            Ok(object.getattr_opt(name)?.map(Bound::unbind))
        };
        let demand = method("demand")?;
        let own = (is_class || demand.is_some()).then(|| object.clone().unbind());
        let demand = demand.unwrap_or_else(|| object.clone().unbind());
        let (reset, freeze) = (method("reset")?, method("freeze")?);
        let (name, failure) = (law.name.clone(), law.failure.clone());
        let (object, periods, robot) = (own, 0, None);
        Ok(Self { name, object, demand, reset, freeze, period, periods, robot, failure })
    }

    fn call(&self, method: Option<&Py<PyAny>>) {
        if self.failure.is_set() {
            return;
        }
        if let Some(method) = method
            && let Err(raised) = Python::attach(|py| method.call0(py).map(drop))
        {
            self.failure.set(raised);
        }
    }

    /// What the object keeps, as bytes.
    fn kept(&self, object: &Py<PyAny>) -> Result<Vec<u8>, StateError> {
        self.unless_refused(|py| {
            py.import("trueweld._law")?.getattr("state_of")?.call1((object,))?.extract()
        })
    }

    /// Has the object keep what `kept` gave.
    fn keep(&self, object: &Py<PyAny>, kept: &[u8]) -> StateResult {
        self.unless_refused(|py| {
            let kept = PyBytes::new(py, kept);
            py.import("trueweld._law")?.getattr("restore")?.call1((object, kept)).map(drop)
        })
    }

    fn unless_refused<V>(
        &self,
        work: impl FnOnce(Python<'_>) -> PyResult<V>,
    ) -> Result<V, StateError> {
        Python::attach(|py| {
            work(py).map_err(|raised| {
                let text =
                    format!("the law {} does not give or take its state: {raised}", self.name);
                self.failure.set(error::of_law(py, text));
                StateError::Unsupported
            })
        })
    }

    fn ask(&self, py: Python<'_>, readings: LawReadings) -> PyResult<Twist<f64>> {
        let answer = self.demand.bind(py).call1((readings,))?;
        let demand = six_numbers(&answer).ok_or_else(|| {
            let what = answer.repr().map_or_else(|_| "an object".to_owned(), |text| text.to_string());
            error::of_law(py, format!(
                "the law {} returned {what}; expected 6 numbers: x, y, z in m, then the rotation about them in rad, axes of the weld frame",
                self.name
            ))
        })?;
        Ok(twist(demand))
    }
}

impl Compensator<f64> for RunningPythonLaw {
    fn reset(&mut self) {
        self.periods = 0;
        self.call(self.reset.as_ref());
    }

    fn freeze(&mut self) {
        self.call(self.freeze.as_ref());
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        if self.failure.is_set() {
            return Err(Fault::Compensation);
        }
        let robot = Arc::clone(self.robot.get_or_insert_with(|| Arc::new(robot.clone())));
        let time = self.periods as f64 * self.period;
        self.periods += 1;
        let readings = LawReadings::new(robot, observation, time, self.period);
        Python::attach(|py| self.ask(py, readings)).map_err(|raised| {
            self.failure.set(raised);
            Fault::Compensation
        })
    }

    /// The count of periods, and what the object keeps, byte by byte.
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.count(&mut self.periods, LAW_PERIODS_MAX)?;
        let Some(object) = &self.object else {
            return Ok(());
        };
        let own = self.kept(object)?;
        let mut kept = own.clone();
        let length = visitor.length(kept.len(), LAW_BYTES_MAX)?;
        kept.resize(length, 0);
        kept.iter_mut().try_for_each(|byte| visitor.byte(byte))?;
        if kept == own { Ok(()) } else { self.keep(object, &kept) }
    }
}

/// # Errors
/// An object that can be asked for no demand.
fn must_be_law(object: &Bound<'_, PyAny>) -> PyResult<()> {
    if object.getattr_opt("demand")?.is_some() || object.is_callable() {
        return Ok(());
    }
    let what = object.repr()?;
    let expected =
        "expected an object with a method demand(readings), or a function of the readings";
    Err(error::of_law(object.py(), format!("{what} is no law: {expected}")))
}

/// Six numbers of an array of them, or of a sequence.
pub(crate) fn six_numbers(values: &Bound<'_, PyAny>) -> Option<[f64; 6]> {
    if let Ok(array) = values.cast::<PyArray1<f64>>() {
        return array.try_readonly().ok()?.as_array().to_vec().try_into().ok();
    }
    values.extract::<Vec<f64>>().ok()?.try_into().ok()
}

/// A displacement and a rotation, in that order.
pub(crate) fn twist([x, y, z, rx, ry, rz]: [f64; 6]) -> Twist<f64> {
    Twist { angular: Vector3::new(rx, ry, rz), linear: Vector3::new(x, y, z) }
}

/// The same as six numbers.
pub(crate) fn six_of(twist: &Twist<f64>) -> [f64; 6] {
    let (linear, angular) = (twist.linear, twist.angular);
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
}

/// What a law sees in one control period.
///
/// Arrays are new ones, in SI units. Frames: B base, T tool, W weld (x along the weld, y across it, z
/// into the material).
#[pyclass(frozen, name = "Readings", module = "trueweld")]
pub(crate) struct LawReadings {
    robot: Arc<Robot<f64>>,
    setpoint: Setpoint<f64>,
    nominal: Pose<f64>,
    sensed: SensorReadings<f64>,
    planned: Wrench<f64>,
    measurements: Vec<DeviationMeasurement<f64>>,
    taught: Option<Twist<f64>>,
    /// Time since the law was first asked in this weld, s.
    #[pyo3(get)]
    time_s: f64,
    /// Control period, s.
    #[pyo3(get)]
    period_s: f64,
    /// Where the tool is along the seam, m.
    #[pyo3(get)]
    path_m: f64,
}

type Six<'py> = Bound<'py, PyArray1<f64>>;
type Matrix<'py> = Bound<'py, PyArray2<f64>>;

#[pymethods]
impl LawReadings {
    /// Encoder angles, rad, shape (6,).
    #[getter]
    fn encoder_rad<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.sensed.encoder.as_slice())
    }

    /// Encoder rates, rad/s, shape (6,).
    #[getter]
    fn encoder_rate_rad_s<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.sensed.encoder_rate.as_slice())
    }

    /// Motor torque of the last period, seen from the joint, N·m, shape (6,); zeros where it is not
    /// known.
    #[getter]
    fn motor_torque_nm<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.sensed.motor_torque.as_slice())
    }

    /// Force on the tool by the force sensor, N, axes of T, shape (3,).
    #[getter]
    fn force_n<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.sensed.wrench.force.as_slice())
    }

    /// Moment on the tool at its tip by the force sensor, N·m, axes of T, shape (3,).
    #[getter]
    fn moment_nm<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.sensed.wrench.moment.as_slice())
    }

    /// Force on the tool that the weld was planned with, N, axes of W, shape (3,).
    #[getter]
    fn planned_force_n<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.planned.force.as_slice())
    }

    /// Push into the material that is asked for, N.
    #[getter]
    fn push_n(&self) -> f64 {
        self.setpoint.force.unwrap_or(f64::NAN)
    }

    /// Speed of the spindle, rad/s.
    #[getter]
    fn spindle_rad_s(&self) -> f64 {
        self.setpoint.spindle_speed
    }

    /// Axes of W in B, shape (3, 3): a column an axis.
    #[getter]
    fn b_from_w<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        matrix(py, &self.setpoint.b_from_w)
    }

    /// Where the real tool should be: its axes in B, shape (3, 3).
    #[getter]
    fn nominal_rotation<'py>(&self, py: Python<'py>) -> Matrix<'py> {
        matrix(py, &self.nominal.rotation)
    }

    /// Where the real tool should be: its tip in B, m, shape (3,).
    #[getter]
    fn nominal_position_m<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, self.nominal.position.as_slice())
    }

    /// How far the encoders' pose lies from the nominal one, axes of W, shape (6,): x, y, z in m, then
    /// the rotation in rad.
    #[getter]
    fn encoder_deviation<'py>(&self, py: Python<'py>) -> Six<'py> {
        PyArray1::from_slice(py, &six_of(&self.observation().encoder_deviation(&self.robot)))
    }

    /// The seam sensor's newest reading across the seam, m: positive where the tool is on the side of
    /// y of W. NaN in a period without one.
    #[getter]
    fn lateral_m(&self) -> f64 {
        self.newest(|along| along.linear.y > 0.0)
    }

    /// The seam sensor's newest reading of the tilt across the seam, rad. NaN in a period without one.
    #[getter]
    fn tilt_rad(&self) -> f64 {
        self.newest(|along| along.angular.x > 0.0)
    }

    /// Every reading of the deviation from outside the robot in this period, as (deviation, direction
    /// (6,), noise, age_s, ahead_m): the deviation is in the direction, with a noise of one standard
    /// deviation, in m or rad.
    #[getter]
    fn measurements<'py>(&self, py: Python<'py>) -> Vec<(f64, Six<'py>, f64, f64, f64)> {
        let row = |m: &DeviationMeasurement<f64>| {
            (m.deviation, PyArray1::from_slice(py, &six_of(&m.along)), m.noise, m.age, m.ahead)
        };
        self.measurements.iter().map(row).collect()
    }

    /// The demand of the law `feed-forward` in this period, shape (6,): against what the planned load
    /// does to the robot as the controller knows it. Zeros where there is none.
    fn feed_forward<'py>(&self, py: Python<'py>) -> Six<'py> {
        let demand = FeedForward.demand(&self.robot, &self.observation());
        PyArray1::from_slice(py, &demand.map_or([0.0; 6], |demand| six_of(&demand)))
    }

    fn __repr__(&self) -> String {
        format!("Readings(time_s={}, path_m={})", self.time_s, self.path_m)
    }
}

impl LawReadings {
    fn new(
        robot: Arc<Robot<f64>>,
        observation: &Observation<'_, f64>,
        time_s: f64,
        period_s: f64,
    ) -> Self {
        Self {
            robot,
            setpoint: *observation.setpoint,
            nominal: *observation.nominal,
            sensed: *observation.sensed,
            planned: observation.planned,
            measurements: observation.measurements.to_vec(),
            taught: observation.taught,
            time_s,
            period_s,
            path_m: observation.path,
        }
    }

    /// Those of a period of a simulation.
    pub(crate) fn of_period(cell: &WeldingCell, period: &CellView) -> Self {
        let CellView { time, reference, readings: seen, .. } = period;
        Self {
            robot: Arc::new(cell.controller_model.clone()),
            setpoint: reference.setpoint,
            nominal: reference.nominal,
            sensed: seen.sensed,
            planned: reference.planned,
            measurements: seen.measurements.clone(),
            taught: None,
            time_s: *time,
            period_s: cell.control.period,
            path_m: reference.path,
        }
    }

    fn observation(&self) -> Observation<'_, f64> {
        Observation {
            setpoint: &self.setpoint,
            nominal: &self.nominal,
            sensed: &self.sensed,
            path: self.path_m,
            planned: self.planned,
            measurements: &self.measurements,
            taught: self.taught,
        }
    }

    /// The newest usable measurement in a direction; NaN where there is none.
    fn newest(&self, is_along: fn(&Twist<f64>) -> bool) -> f64 {
        let along = self.measurements.iter().filter(|m| m.is_usable() && is_along(&m.along));
        along.min_by(|a, b| a.age.total_cmp(&b.age)).map_or(f64::NAN, |m| m.deviation)
    }
}

fn matrix<'py>(py: Python<'py>, values: &Matrix3<f64>) -> Matrix<'py> {
    let rows = |k: usize| values.row(k).iter().copied().collect::<Vec<_>>();
    PyArray2::from_vec2(py, &[rows(0), rows(1), rows(2)]).expect("rows of one length")
}
