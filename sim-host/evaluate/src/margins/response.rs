//! What comes back round the loop: the linear cell under the very controller and law that run on
//! the robot.
//!
//! The set-point's correction (five directions of W), the force error and the drives' torques are
//! opened in turn: a small impulse is added there, and what the loop returns, less the same run
//! without it, is a column of the sampled sensitivity S. Instruments, their delays and the noise
//! are those of the run; noise is the same with and without the impulse, and cancels.

use super::linear::LinearCell;
use nalgebra::{SVector, Vector3};
use std::cell::Cell as Shared;
use trueweld_core::compensation::{Compensated, Observation};
use trueweld_core::control::{Command, HybridController, SensorReadings, Setpoint};
use trueweld_core::{JointVector, Robot, Twist, Wrench};
use trueweld_plant::cell::STATES;
use trueweld_plant::input::Sensors;
use trueweld_plant::process::planned;
use trueweld_plant::robot::Readings;
use trueweld_plant::sensors::{Instruments, SeamSensing};
use trueweld_plant::simulate::{RunError, Scenario, Seam};

/// Where the loop is opened: corrections along x and y and about x, y and z of W, and the force
/// error; then the drives.
pub const CHANNELS: usize = 12;

/// How many of them are the set-point's; the others are the drives.
pub const SETPOINT: usize = 6;

/// Names of these places.
pub const CHANNEL_NAMES: [&str; CHANNELS] = [
    "longitudinal",
    "lateral",
    "side tilt",
    "travel angle",
    "yaw",
    "force",
    "A1",
    "A2",
    "A3",
    "A4",
    "A5",
    "A6",
];

/// Impulses: 1 µm, 1 µrad, 0.1 N and 10 N·m, far below what any limit holds and far above rounding.
const IMPULSE: [f64; CHANNELS] =
    [1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 0.1, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0];

/// Largest departure of an angle at which the linear cell is believed to run away, rad.
const AWAY: f64 = 0.1;

/// How long the loop is given to come to rest, and to answer, s.
const SETTLE: f64 = 10.0;
const ANSWER: f64 = 16.0;

/// A loop frozen at one place of a weld.
pub struct Frozen<'a> {
    pub scenario: &'a Scenario<'a>,
    pub linear: LinearCell,
    /// Path position, m.
    pub path: f64,
    /// From the nominal pose to the set-point, axes of W.
    pub taught: Twist<f64>,
    /// Step of the linear cell, s, and how many make a control period.
    pub step: f64,
    pub substeps: usize,
}

/// What passes these places, once a period: m, rad, N, N·m.
pub type LoopSignals = [f64; CHANNELS];

/// A run of the frozen loop.
pub struct Run {
    /// From the impulse on.
    pub rows: Vec<LoopSignals>,
    /// It ran away before the end.
    pub away: bool,
    /// A limit held it in most periods.
    pub held: bool,
}

/// Adds the impulse behind the law, where only the controller sees it.
struct Opened<'a> {
    controller: Box<dyn HybridController<f64>>,
    added: &'a Shared<LoopSignals>,
}

impl HybridController<f64> for Opened<'_> {
    fn start(&mut self, robot: &Robot<f64>, encoder: &JointVector<f64>, torque: &JointVector<f64>) {
        self.controller.start(robot, encoder, torque);
    }

    fn cycle(
        &mut self,
        robot: &Robot<f64>,
        setpoint: &Setpoint<f64>,
        sensed: &SensorReadings<f64>,
    ) -> Command<f64> {
        let [x, y, rx, ry, rz, force, torque @ ..] = self.added.get();
        let twist = Twist { angular: Vector3::new(rx, ry, rz), linear: Vector3::new(x, y, 0.0) };
        let setpoint = Setpoint {
            pose: setpoint.pose.displaced(&twist.rotated(&setpoint.b_from_w)),
            force: setpoint.force.map(|f| f + force),
            ..*setpoint
        };
        let mut command = self.controller.cycle(robot, &setpoint, sensed);
        command.torque += JointVector::from(torque);
        command
    }
}

impl Frozen<'_> {
    /// Runs the loop to rest and then with an impulse at `channel`, if any.
    ///
    /// # Errors
    /// [`RunError`] where the law cannot be built.
    pub fn run(&self, channel: Option<usize>) -> Result<Run, RunError> {
        let Scenario { cell, controller_model, weld, control, .. } = *self.scenario;
        let (seam, period, linear) = (Seam::of(weld), control.period, &self.linear);
        let w = seam.b_from_w.rotation;
        let added = Shared::new([0.0; CHANNELS]);
        let mut law = self.scenario.build_law()?;
        law.freeze();
        let opened = Opened { controller: self.scenario.controller.build(control), added: &added };
        let limits = &control.compensation;
        let mut controller =
            Compensated::new(opened, law.as_mut(), limits.lateral, limits.orientation, period);
        let sensors = steady(self.scenario.sensors);
        let seed = self.scenario.seed;
        let mut instruments =
            Instruments::new(&sensors, &cell.robot.ports, self.step, period, seed);
        let mut seam_sensor = sensors.seam.as_ref().map(|sensor| SeamSensing::new(sensor, seed));

        let nominal = seam.nominal(self.path);
        let setpoint = Setpoint {
            pose: nominal.displaced(&self.taught.rotated(&w)),
            b_from_w: w,
            force: Some(weld.force),
            spindle_speed: cell.process.spindle,
        };
        let rate = linear.point.drives().motor_rate;
        let load = Wrench {
            moment: Vector3::zeros(),
            force: planned(self.scenario.planned, weld.force, weld.feed),
        };
        let mut x = self.uncorrected(&setpoint)?;
        let mut torque = linear.torque;
        controller.start(controller_model, &linear.state(&x).drives().motor, &torque);
        let [settle, all] = [SETTLE, SETTLE + ANSWER].map(|time| (time / period) as usize);
        let mut run = Run { rows: Vec::with_capacity(all - settle), away: false, held: false };
        let mut held = 0;
        for tick in 0..all {
            let time = tick as f64 * period;
            let drives = linear.state(&x).drives();
            let tcp = cell.robot.model.frames(&drives.link).tcp;
            instruments.observe(&linear.wrench(&x));
            let truth = Readings::of(time, &drives.motor, &drives.link, &tcp);
            let mut sensed = instruments.read(&cell.robot.ports, truth, &torque);
            // The encoders of a frozen posture stand still; the robot's do not.
            sensed.encoder_rate += rate;
            let deviation = nominal.error_to(&tcp).rotated(&w.transpose());
            let sightings =
                seam_sensor.as_mut().map_or(Vec::new(), |sensor| sensor.read(time, &deviation));
            let mut now = [0.0; CHANNELS];
            if let Some(c) = channel.filter(|_| tick == settle) {
                now[c] = IMPULSE[c];
            }
            added.set(now);
            let observation = Observation {
                setpoint: &setpoint,
                nominal: &nominal,
                sensed: &sensed,
                path: self.path + weld.feed * time,
                planned: load,
                sightings: &sightings,
            };
            let command = controller.cycle(controller_model, &observation);
            torque = command.torque;
            if tick >= settle {
                held += usize::from(command.limited.any());
                let c = controller.correction();
                let mut row = [0.0; CHANNELS];
                row[..5].copy_from_slice(&[
                    c.linear.x,
                    c.linear.y,
                    c.angular.x,
                    c.angular.y,
                    c.angular.z,
                ]);
                // What the controller is asked for less what the sensor shows, before any filter.
                let push = -(controller_model.forward_kinematics(&sensed.encoder).rotation
                    * sensed.wrench.force)
                    .dot(&w.column(2));
                row[5] = weld.force - push;
                row.iter_mut()
                    .zip(now)
                    .take(SETPOINT)
                    .for_each(|(passing, added)| *passing += added);
                // Torque has the impulse in it already.
                row[SETPOINT..].copy_from_slice(torque.as_slice());
                run.rows.push(row);
            }
            for k in 0..self.substeps {
                if k > 0 {
                    instruments.observe(&linear.wrench(&x));
                }
                x = linear.advance(&x, &torque);
            }
            if x.fixed_rows::<12>(0).amax() > AWAY || !x.sum().is_finite() {
                run.away = true;
                return Ok(run);
            }
        }
        run.held = 2 * held > run.rows.len();
        Ok(run)
    }

    /// Where nothing is corrected yet: the encoders at the set-point, the load as at the operating
    /// point, the channel behind the tool where the tool is.
    fn uncorrected(&self, setpoint: &Setpoint<f64>) -> Result<SVector<f64, STATES>, RunError> {
        let motor = self.linear.point.drives().motor;
        let model = &self.scenario.cell.robot.model;
        let reach =
            |_| RunError::Reach { path: self.path, reason: "the set-point is out of reach" };
        let by = model.inverse_near(&setpoint.pose, &motor).map_err(reach)? - motor;
        let mut x = SVector::<f64, STATES>::zeros();
        x.fixed_rows_mut::<6>(0).copy_from(&by);
        x.fixed_rows_mut::<6>(6).copy_from(&by);
        let real = model.forward_kinematics(&self.linear.state(&x).drives().link);
        let seam = Seam::of(self.scenario.weld);
        x[24] = (real.position - seam.nominal(self.path).position)
            .dot(&seam.b_from_w.rotation.column(1));
        Ok(x)
    }
}

/// Noise of a force sensor that never stands still, N: one that does is not believed, and its loop
/// is open.
const LIVE: f64 = 1e-6;

/// Instruments without steps, which would swallow the impulse, and without lost readings: the same
/// loop in every period.
fn steady(sensors: &Sensors) -> Sensors {
    let mut sensors = sensors.clone();
    sensors.encoder_resolution = [0.0; 6];
    sensors.force.resolution = 0.0;
    sensors.force.noise_force = sensors.force.noise_force.max(LIVE);
    if let Some(seam) = &mut sensors.seam {
        seam.lost = 0.0;
    }
    sensors
}

/// Columns of the sampled sensitivity, as impulse responses: S_ij(k) = responses[j][k][i].
pub fn sensitivity(rest: &Run, impulses: &[Run]) -> Vec<Vec<LoopSignals>> {
    impulses
        .iter()
        .zip(IMPULSE)
        .map(|(run, impulse)| {
            let rows = run.rows.iter().zip(&rest.rows);
            rows.map(|(with, without)| std::array::from_fn(|i| (with[i] - without[i]) / impulse))
                .collect()
        })
        .collect()
}
