//! What comes back round the loop: the linear cell under the very controller and law that run on
//! the robot.
//!
//! The set-point's correction (five directions of W), the force error and the drives' torques are
//! opened in turn: a small impulse is added there, and what the loop returns, less the same run
//! without it, is a column of the sampled sensitivity S. Instruments, their delays and the noise
//! are those of the run; noise is the same with and without the impulse, and cancels.

use super::linear::{LinearCell, OperatingPoint};
use nalgebra::{SVector, Vector3};
use std::cell::Cell as Shared;
use trueweld_core::control::{DriveCommand, HybridController, SensorReadings, Setpoint};
use trueweld_core::{JointVector, Pose, Robot, Twist, Wrench};
use trueweld_plant::cell::STATES;
use trueweld_plant::controllers::PlantController;
use trueweld_plant::input::Sensors;
use trueweld_plant::integrate::{Diverged, Stepper};
use trueweld_plant::robot::Drives;
use trueweld_plant::simulate::{
    CellMotion, ControlSide, Controlled, Phase, Plant, PlantSide, ProgramTarget, Reference,
    RunError, Scenario, Seam, SimulatedCell, TaughtOffset,
};

/// Where the loop is opened: corrections along x and y and about x, y and z of W, and the force
/// error; then the drives.
pub const LOOP_CHANNELS: usize = 12;

/// How many of them are the set-point's; the others are the drives.
pub const SETPOINT: usize = 6;

/// Names of these places.
pub const CHANNEL_NAMES: [&str; LOOP_CHANNELS] = [
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
const IMPULSE: [f64; LOOP_CHANNELS] =
    [1e-6, 1e-6, 1e-6, 1e-6, 1e-6, 0.1, 10.0, 10.0, 10.0, 10.0, 10.0, 10.0];

/// Largest departure of an angle at which the linear cell is believed to run away, rad.
const RUNAWAY_ANGLE: f64 = 0.1;

/// How long the loop is given to come to rest, s.
const SETTLE: f64 = 10.0;
/// How long under a law that sees the seam: tool and channel come back to it slowly, and as long as
/// the sensor's readings are clipped they answer no impulse.
const SETTLE_ON_SEAM: f64 = 30.0;
/// How long it is watched after the impulse, s.
pub(crate) const ANSWER: f64 = 10.0;
/// Likewise where that does not tell whether the loop is stable: what dies at 0.23 1/s falls to a
/// thousandth in the time that is added.
pub(crate) const LONGER_ANSWER: f64 = 40.0;

/// A loop at one operating point of a weld.
pub(crate) struct Frozen<'a> {
    pub scenario: &'a Scenario<'a>,
    pub linear: LinearCell,
    pub at: OperatingPoint,
    /// From the nominal pose to the set-point.
    pub taught: TaughtOffset,
}

/// What passes these places, once a period: m, rad, N, N·m.
pub type LoopSignals = [f64; LOOP_CHANNELS];

/// A run of the loop.
pub struct Run {
    /// From the kick on.
    pub rows: Vec<LoopSignals>,
    /// Rates of the drives with them, rad/s.
    pub rates: Vec<JointVector<f64>>,
    /// It ran away before the end.
    pub away: bool,
    /// A limit held it in most periods.
    pub held: bool,
}

/// What comes back of an impulse at every channel.
pub(crate) struct Answer {
    /// The run without an impulse.
    pub rest: Run,
    /// Columns of the sampled sensitivity: S_ij(k) = responses[j][k][i].
    pub responses: Vec<Vec<LoopSignals>>,
    /// It runs away, or a limit holds it at rest.
    lost: bool,
}

impl Answer {
    /// The spectral radius by `radius`; infinite where an impulse shows nothing of the loop.
    pub(crate) fn judged(&self, radius: impl FnOnce(&[Vec<LoopSignals>]) -> f64) -> f64 {
        if self.lost { f64::INFINITY } else { radius(&self.responses) }
    }
}

/// Adds the impulse behind the law, where only the controller sees it.
struct Opened<'a> {
    controller: Box<dyn PlantController>,
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
    ) -> DriveCommand<f64> {
        let [x, y, rx, ry, rz, force, torque @ ..] = self.added.get();
        let twist = Twist { angular: Vector3::new(rx, ry, rz), linear: Vector3::new(x, y, 0.0) };
        let pose = setpoint.pose.displaced(&twist.rotated(&setpoint.b_from_w));
        let setpoint = Setpoint { pose, ..*setpoint };
        // At the sensor and not at the set-point, which is fed forward beside the loop.
        let mut sensed = *sensed;
        if force != 0.0 {
            let tool = robot.forward_kinematics(&sensed.encoder).rotation;
            sensed.wrench.force += tool.tr_mul(&setpoint.depth_axis()) * force;
        }
        let mut command = self.controller.cycle(robot, &setpoint, &sensed);
        command.torque += JointVector::from(torque);
        command
    }
}

/// The linear cell as the control cycle drives it.
struct LinearPlant<'a> {
    frozen: &'a Frozen<'a>,
    /// What the state differs by from the operating point.
    x: SVector<f64, STATES>,
}

impl Plant for LinearPlant<'_> {
    fn evaluate(&mut self, _: f64) {}

    fn drives(&self) -> Drives {
        self.frozen.linear.state(&self.x).drives()
    }

    fn tcp(&self) -> Pose<f64> {
        self.frozen.scenario.cell.robot.model.frames(&self.drives().link).tcp
    }

    fn wrench_in_t(&self) -> Wrench<f64> {
        self.frozen.linear.wrench(&self.x)
    }

    fn advance(&mut self, _: f64, torque: &JointVector<f64>, _: f64) -> Result<(), Diverged> {
        self.x = self.frozen.linear.advance(&self.x, torque);
        Ok(())
    }
}

/// What is added to the loop's signals after it has come to rest, and how long it is watched.
#[derive(Debug, Clone, Copy)]
pub struct Kick {
    /// In every period of it.
    pub added: LoopSignals,
    /// How many periods it lasts.
    pub periods: usize,
    /// Time before and after, s.
    pub time: [f64; 2],
}

impl Frozen<'_> {
    /// What comes back of an impulse at every channel, within `time`, s.
    ///
    /// # Errors
    /// [`RunError`] where the law cannot be built.
    pub(crate) fn answer(&self, time: f64) -> Result<Answer, RunError> {
        let rest = self.run(&self.impulse(None, time))?;
        let impulses = (0..LOOP_CHANNELS).map(|c| self.run(&self.impulse(Some(c), time)));
        let impulses = impulses.collect::<Result<Vec<_>, _>>()?;
        let lost = rest.away || rest.held || impulses.iter().any(|run| run.away);
        Ok(Answer { responses: sensitivity(&rest, &impulses), rest, lost })
    }

    /// The impulse at a channel, or none, with the time that margins give it before it, and `time`
    /// after it, s.
    fn impulse(&self, channel: Option<usize>, time: f64) -> Kick {
        let mut added = [0.0; LOOP_CHANNELS];
        if let Some(c) = channel {
            added[c] = IMPULSE[c];
        }
        let seen = self.scenario.law.needs().seam_sensor;
        Kick { added, periods: 1, time: [if seen { SETTLE_ON_SEAM } else { SETTLE }, time] }
    }

    /// Runs the linear loop to rest and then with a kick.
    ///
    /// # Errors
    /// [`RunError`] where the law cannot be built.
    pub(crate) fn run(&self, kick: &Kick) -> Result<Run, RunError> {
        let plant = LinearPlant { frozen: self, x: self.uncorrected()? };
        // The encoders of a frozen posture stand still; the robot's do not.
        let rate = self.linear.point.drives().motor_rate;
        self.drive(plant, kick, &rate, |plant| {
            let x = &plant.x;
            x.fixed_rows::<12>(0).amax() > RUNAWAY_ANGLE || !x.sum().is_finite()
        })
    }

    /// The same of the cell as it is, that moves along its seam.
    ///
    /// # Errors
    /// [`RunError`] where the law cannot be built, and where the state leaves the finite numbers.
    pub(crate) fn run_in_time(&self, kick: &Kick) -> Result<Run, RunError> {
        let Scenario { cell, integrator, .. } = *self.scenario;
        let state = self.linear.state(&self.uncorrected()?);
        let mut motion = CellMotion::new(cell, Stepper::new(integrator), state);
        let plant = SimulatedCell { cell, motion: &mut motion };
        self.drive(plant, kick, &JointVector::zeros(), |_| false)
    }

    /// `standing`: rate that the plant's encoders lack, rad/s: of a plant that stands still.
    fn drive<P: Plant>(
        &self,
        mut plant: P,
        kick: &Kick,
        standing: &JointVector<f64>,
        away: impl Fn(&P) -> bool,
    ) -> Result<Run, RunError> {
        let Scenario { controller_model, weld, control, .. } = *self.scenario;
        let OperatingPoint { path, push, feed, .. } = self.at;
        let (seam, period) = (Seam::of(weld), control.period);
        let added = Shared::new([0.0; LOOP_CHANNELS]);
        let mut law = self.scenario.build_law()?;
        law.freeze();
        let opened = Opened { controller: self.scenario.build_controller()?, added: &added };
        let sensors = steady(self.scenario.sensors);
        let scenario = Scenario { sensors: &sensors, fault: None, ..*self.scenario };
        let target = |path| ProgramTarget { phase: Phase::Steady, path, feed, force: Some(push) };
        let at_place = self.reference();
        let motor = plant.drives().motor;
        let mut controller = ControlSide::new(&scenario, opened, law.as_mut());
        controller.start(controller_model, &motor, &self.linear.torque);
        let mut side = PlantSide::new(&scenario, &self.linear.torque);
        side.frozen_rate = *standing;
        let moves = standing.amax() == 0.0;
        let [settle, all] =
            [kick.time[0], kick.time[0] + kick.time[1]].map(|time| (time / period) as usize);
        let mut run = Run { rows: Vec::new(), rates: Vec::new(), away: false, held: false };
        let mut held = 0;
        for tick in 0..all {
            let time = tick as f64 * period;
            let kicked = (settle..settle + kick.periods).contains(&tick);
            let now = if kicked { kick.added } else { [0.0; LOOP_CHANNELS] };
            added.set(now);
            let here = path + feed * time;
            let reference = if moves {
                Reference::of(&scenario, &seam, &self.taught, &target(here))
            } else {
                Reference { path: here, ..at_place }
            };
            let readings = side.read(&scenario, &mut plant, time, reference.path);
            let Controlled { sensed, command, correction_w } = controller.cycle(
                controller_model,
                &reference,
                &readings.sensed,
                &readings.measurements,
            );
            side.torque = command.torque;
            if tick >= settle {
                // A controller or a law at fault lets nothing pass either.
                held += usize::from(command.limited.any() || command.fault.is_some());
                let (linear, angular) = (correction_w.linear, correction_w.angular);
                let mut row = [0.0; LOOP_CHANNELS];
                row[..5].copy_from_slice(&[linear.x, linear.y, angular.x, angular.y, angular.z]);
                // What the controller is asked for less what the sensor shows, before any filter.
                let sensed_push = -(controller_model.forward_kinematics(&sensed.encoder).rotation
                    * sensed.wrench.force)
                    .dot(&reference.setpoint.depth_axis());
                row[5] = push - sensed_push;
                row.iter_mut()
                    .zip(now)
                    .take(SETPOINT)
                    .for_each(|(passing, added)| *passing += added);
                // Torque has the impulse in it already.
                row[SETPOINT..].copy_from_slice(command.torque.as_slice());
                run.rows.push(row);
                run.rates.push(plant.drives().motor_rate);
            }
            side.advance(&mut plant, time)?;
            if away(&plant) {
                run.away = true;
                return Ok(run);
            }
        }
        run.held = 2 * held > run.rows.len();
        Ok(run)
    }

    fn reference(&self) -> Reference {
        let OperatingPoint { path, push, feed, .. } = self.at;
        let target = ProgramTarget { phase: Phase::Steady, path, feed, force: Some(push) };
        Reference::of(self.scenario, &Seam::of(self.scenario.weld), &self.taught, &target)
    }

    /// Where nothing is corrected yet: the encoders at the set-point, the load as at the operating
    /// point, the channel behind the tool where the tool is.
    fn uncorrected(&self) -> Result<SVector<f64, STATES>, RunError> {
        let (path, setpoint) = (self.at.path, self.reference().setpoint);
        let motor = self.linear.point.drives().motor;
        // The encoders are where the controller's arm has the set-point; the real arm may be bent.
        let Scenario { cell, controller_model, .. } = self.scenario;
        let model = &cell.robot.model;
        let reach = |_| RunError::Reach { path, reason: "the set-point is out of reach" };
        let by = controller_model.inverse_near(&setpoint.pose, &motor).map_err(reach)? - motor;
        let mut x = SVector::<f64, STATES>::zeros();
        x.fixed_rows_mut::<6>(0).copy_from(&by);
        x.fixed_rows_mut::<6>(6).copy_from(&by);
        let real = model.forward_kinematics(&self.linear.state(&x).drives().link);
        let seam = Seam::of(self.scenario.weld);
        // Where nothing is fed the channel stays where it was made, and the tool made it.
        if self.at.feed == 0.0 {
            return Ok(x);
        }
        x[24] = (real.position - seam.nominal(path).position).dot(&seam.axes(path).column(1));
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

/// Columns of the sampled sensitivity, as impulse responses.
fn sensitivity(rest: &Run, impulses: &[Run]) -> Vec<Vec<LoopSignals>> {
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
