//! A recorded run of a controller's core, fed to the same core on this machine: period for period the
//! same to the last bit, or where first not.

use nalgebra::Matrix3;
use schemars::JsonSchema;
use serde::Serialize;
use trueweld_compensators::{
    Configuration, ConfigurationError, Law, RunningCore, Visitor, for_each,
};
use trueweld_core::compensation::{Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{SensorReadings, Setpoint};
use trueweld_core::scalar::lit;
use trueweld_core::{JOINTS, JointVector, Pose, Real, Twist, Wrench};

/// Numbers of a measurement from outside the robot: deviation, along (6), noise, age, ahead.
pub const MEASUREMENT_NUMBERS: usize = 10;

/// Numbers of a period's inputs before its measurements, their count the last.
pub const PERIOD_NUMBERS: usize = 68;

/// What a core was given in one period, in the order in which the example of the C interface reads it.
#[derive(Debug, Clone, PartialEq)]
pub struct CorePeriod {
    /// Set-point in force, poses, readings, path and planned load; the last is how many measurements
    /// follow.
    pub numbers: [f64; PERIOD_NUMBERS],
    /// Measurements from outside the robot.
    pub measurements: Vec<[f64; MEASUREMENT_NUMBERS]>,
}

/// What a core commanded in one period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CoreOutputs {
    /// Status of the C interface: 0, above 0 a fault of sensor or posture, below 0 a wrong call.
    pub status: f64,
    /// Motor torque, N·m.
    pub torque: [f64; JOINTS],
    /// Correction of the set-point in force, axes of W: rotation vector, rad, then displacement, m.
    pub correction: [f64; 6],
}

/// A recorded run of a core.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CoreRun {
    /// Encoder angles, rad, and motor torque, N·m, that it started with.
    pub start: [[f64; JOINTS]; 2],
    /// What it was given, period after period.
    pub periods: Vec<CorePeriod>,
    /// What it commanded.
    pub outputs: Vec<CoreOutputs>,
}

/// In what a core computes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CoreScalar {
    /// Single precision.
    Float,
    /// Double precision.
    Double,
}

/// What of a period differs first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CoreOutput {
    /// Whether there is a fault.
    Fault,
    /// The torque of a joint.
    Torque,
    /// The correction of the set-point in an axis of W.
    Correction,
}

/// A period in which the two cores differ.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CoreDifference {
    /// The period, from 0.
    pub period: usize,
    /// Its time since the first, s.
    pub time_s: f64,
    /// What differs.
    pub output: CoreOutput,
    /// Joint from 0, or axis of the correction (three of the rotation, then three of the displacement);
    /// 0 of a fault.
    pub index: usize,
    /// As recorded: N·m, m or rad; of a fault the status.
    pub recorded: f64,
    /// As computed here, in the same unit; of a fault 1 where there is one, else 0.
    pub replayed: f64,
    /// What the core was given.
    pub readings: CoreReadings,
}

/// What a core was given in a period.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CoreReadings {
    /// Push asked for, N; nothing before the force loop is closed.
    pub force_n: Option<f64>,
    /// Path position, m.
    pub path_m: f64,
    /// Encoder angles, rad.
    pub encoder_rad: [f64; JOINTS],
    /// Encoder rates, rad/s.
    pub encoder_rate_rad_s: [f64; JOINTS],
    /// Motor torques, N·m.
    pub motor_torque_nm: [f64; JOINTS],
    /// Force sensor in T: moments, N·m, then forces, N.
    pub wrench: [f64; 6],
    /// How many measurements came from outside the robot.
    pub measurements: usize,
}

/// What the replay of a run came to.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct CoreReplay {
    /// Law of the core.
    pub law: String,
    /// SHA-256 of its constants, in hexadecimal digits.
    pub digest: String,
    /// In what it computed.
    pub scalar: CoreScalar,
    /// Periods that were compared.
    pub periods: usize,
    /// Control period, s.
    pub period_s: f64,
    /// Periods in which some bit differs.
    pub differing: usize,
    /// The first of them.
    pub first: Option<CoreDifference>,
    /// Largest difference of a torque over the drive's limit, in any period.
    pub torque_share_max: f64,
}

/// Numbers of a period as they are taken one after another.
struct InOrder<'a>(&'a [f64]);

impl InOrder<'_> {
    /// The next N; zeros past the end.
    fn next<const N: usize, T: Real>(&mut self) -> [T; N] {
        let (taken, left) = self.0.split_at(N.min(self.0.len()));
        self.0 = left;
        std::array::from_fn(|k| lit(taken.get(k).copied().unwrap_or(0.0)))
    }

    fn pose<T: Real>(&mut self) -> Pose<T> {
        let rotation = Matrix3::from_row_slice(&self.next::<9, T>());
        Pose { rotation, position: self.next::<3, T>().into() }
    }
}

/// A period's inputs in a scalar.
struct CoreInputs<T: Real> {
    setpoint: Setpoint<T>,
    nominal: Pose<T>,
    sensed: SensorReadings<T>,
    path: T,
    planned: Wrench<T>,
    measurements: Vec<DeviationMeasurement<T>>,
}

impl<T: Real> CoreInputs<T> {
    fn of(period: &CorePeriod) -> Self {
        let mut next = InOrder(&period.numbers);
        let [closed] = next.next::<1, f64>();
        let (pose, nominal) = (next.pose(), next.pose());
        let b_from_w = Matrix3::from_row_slice(&next.next::<9, T>());
        let [force, spindle_speed] = next.next::<2, T>();
        let setpoint =
            Setpoint { pose, b_from_w, force: (closed == 1.0).then_some(force), spindle_speed };
        let sensed = SensorReadings {
            encoder: next.next::<JOINTS, T>().into(),
            encoder_rate: next.next::<JOINTS, T>().into(),
            motor_torque: next.next::<JOINTS, T>().into(),
            wrench: Wrench::from_vector(&next.next::<6, T>().into()),
        };
        let [path] = next.next::<1, T>();
        let planned = Wrench::from_vector(&next.next::<6, T>().into());
        let measurements = period.measurements.iter().map(measurement).collect();
        Self { setpoint, nominal, sensed, path, planned, measurements }
    }
}

fn measurement<T: Real>(numbers: &[f64; MEASUREMENT_NUMBERS]) -> DeviationMeasurement<T> {
    let mut next = InOrder(numbers);
    let [deviation] = next.next::<1, T>();
    let along = Twist::from_vector(&next.next::<6, T>().into());
    let [noise, age, ahead] = next.next::<3, T>();
    DeviationMeasurement { deviation, along, noise, age, ahead }
}

impl CorePeriod {
    /// What a core is given in a period.
    pub fn of(of: &Observation<'_, f64>) -> Self {
        let Observation { setpoint, nominal, sensed, path, planned, measurements, .. } = of;
        let mut to = vec![f64::from(u8::from(setpoint.force.is_some()))];
        for pose in [&setpoint.pose, nominal] {
            to.extend(pose.rotation.transpose().iter());
            to.extend(pose.position.iter());
        }
        to.extend(setpoint.b_from_w.transpose().iter());
        to.extend([setpoint.force.unwrap_or(0.0), setpoint.spindle_speed]);
        for six in [&sensed.encoder, &sensed.encoder_rate, &sensed.motor_torque] {
            to.extend(six.iter());
        }
        to.extend(sensed.wrench.to_vector().iter());
        to.push(*path);
        to.extend(planned.to_vector().iter());
        to.push(measurements.len() as f64);
        let mut numbers = [0.0; PERIOD_NUMBERS];
        numbers.iter_mut().zip(to).for_each(|(number, value)| *number = value);
        Self { numbers, measurements: measurements.iter().map(numbers_of).collect() }
    }

    fn readings(&self) -> CoreReadings {
        let CoreInputs { setpoint, sensed, path, measurements, .. } = CoreInputs::<f64>::of(self);
        CoreReadings {
            force_n: setpoint.force,
            path_m: path,
            encoder_rad: sensed.encoder.into(),
            encoder_rate_rad_s: sensed.encoder_rate.into(),
            motor_torque_nm: sensed.motor_torque.into(),
            wrench: sensed.wrench.to_vector().into(),
            measurements: measurements.len(),
        }
    }
}

fn numbers_of(of: &DeviationMeasurement<f64>) -> [f64; MEASUREMENT_NUMBERS] {
    let [a, b, c, d, e, f] = of.along.to_vector().into();
    [of.deviation, a, b, c, d, e, f, of.noise, of.age, of.ahead]
}

/// The outputs of a core in the periods of a run.
struct FedCore<'a> {
    configuration: &'a Configuration,
    run: &'a CoreRun,
    outputs: Option<Result<Vec<CoreOutputs>, ConfigurationError>>,
}

impl<T: Real> Visitor<T> for FedCore<'_> {
    fn visit<L: Law<T>>(&mut self) {
        if self.configuration.law.name.as_str() == L::NAME {
            let core = RunningCore::<T, L::Built>::new::<L>(self.configuration);
            self.outputs = Some(core.map(|mut core| fed(&mut core, self.run)));
        }
    }
}

fn fed<T: Real, L: Compensator<T>>(
    core: &mut RunningCore<T, L>,
    run: &CoreRun,
) -> Vec<CoreOutputs> {
    let [encoder, torque] = run.start.map(|six| JointVector::from(six.map(lit::<T>)));
    core.start(&encoder, &torque);
    run.periods.iter().map(|period| cycled(core, period)).collect()
}

fn cycled<T: Real, L: Compensator<T>>(
    core: &mut RunningCore<T, L>,
    period: &CorePeriod,
) -> CoreOutputs {
    let inputs = CoreInputs::<T>::of(period);
    let command = core.cycle(&Observation {
        setpoint: &inputs.setpoint,
        nominal: &inputs.nominal,
        sensed: &inputs.sensed,
        path: inputs.path,
        planned: inputs.planned,
        measurements: &inputs.measurements,
        taught: None,
    });
    CoreOutputs {
        status: f64::from(u8::from(command.fault.is_some())),
        torque: doubles(&command.torque),
        correction: doubles(&core.correction().to_vector()),
    }
}

/// Six numbers of a scalar, which a double holds.
fn doubles<T: Real>(of: &JointVector<T>) -> [f64; 6] {
    std::array::from_fn(|k| nalgebra::try_convert(of[k]).unwrap_or(f64::NAN))
}

impl CoreRun {
    /// The outputs of a core of this configuration that is fed with the run; a status is 1 where there
    /// is a fault.
    ///
    /// # Errors
    /// A configuration that no core can be built from.
    pub fn outputs_of(
        &self,
        configuration: &Configuration,
        scalar: CoreScalar,
    ) -> Result<Vec<CoreOutputs>, ConfigurationError> {
        let mut feed = FedCore { configuration, run: self, outputs: None };
        match scalar {
            CoreScalar::Float => for_each::<f32>(&mut feed),
            CoreScalar::Double => for_each::<f64>(&mut feed),
        }
        feed.outputs.unwrap_or(Err(ConfigurationError::Law))
    }

    /// Feeds the run to a core of this configuration, and compares what it commands.
    ///
    /// # Errors
    /// A configuration that no core can be built from.
    pub fn replay(
        &self,
        configuration: &Configuration,
        scalar: CoreScalar,
    ) -> Result<CoreReplay, ConfigurationError> {
        let computed = self.outputs_of(configuration, scalar)?;
        let period_s = configuration.control.period;
        let pairs = || self.outputs.iter().zip(&computed);
        let differing: Vec<usize> = pairs()
            .enumerate()
            .filter(|(_, (a, b))| first_difference(a, b).is_some())
            .map(|(period, _)| period)
            .collect();
        let limits = configuration.robot.joints.map(|joint| joint.max_torque);
        let shares =
            pairs().flat_map(|(a, b)| (0..JOINTS).map(move |k| (a.torque[k], b.torque[k], k)));
        let torque_share_max =
            shares.map(|(a, b, k)| (a - b).abs() / limits[k]).fold(0.0, f64::max);
        let difference = |period: usize| {
            let (recorded, replayed) = (&self.outputs[period], &computed[period]);
            let (output, index, recorded, replayed) = first_difference(recorded, replayed)?;
            let time_s = period as f64 * period_s;
            let readings = self.periods[period].readings();
            Some(CoreDifference { period, time_s, output, index, recorded, replayed, readings })
        };
        Ok(CoreReplay {
            law: configuration.law.name.as_str().to_owned(),
            digest: configuration.digest_text(),
            scalar,
            periods: computed.len().min(self.outputs.len()),
            period_s,
            differing: differing.len(),
            first: differing.first().and_then(|period| difference(*period)),
            torque_share_max,
        })
    }
}

/// The first bit that differs, a fault before a torque before a correction: what and where, as recorded
/// and as computed.
fn first_difference(
    recorded: &CoreOutputs,
    computed: &CoreOutputs,
) -> Option<(CoreOutput, usize, f64, f64)> {
    // Below nothing a wrong call, above it a fault.
    let [before, now] = [recorded, computed].map(|of| of.status.partial_cmp(&0.0));
    if before != now {
        return Some((CoreOutput::Fault, 0, recorded.status, computed.status));
    }
    let six = |output, a: [f64; 6], b: [f64; 6]| {
        let k = (0..6).find(|k| a[*k].to_bits() != b[*k].to_bits())?;
        Some((output, k, a[k], b[k]))
    };
    six(CoreOutput::Torque, recorded.torque, computed.torque)
        .or_else(|| six(CoreOutput::Correction, recorded.correction, computed.correction))
}
