//! The control cycle: what happens in one control period, whatever the plant and the controller.
//!
//! At the start of a period the instruments are read and the controller commands a torque; the plant
//! then moves in small steps with the torque held, and the force sensor samples at each step. Runs
//! step the nonlinear cell, stability margins its linearisation.
//!
//! What changes is in [`PlantSide`] and [`ControlSide`]; what does not, the scenario, comes with
//! every call and is the one that they were made of.

use super::{ProgramTarget, Scenario, TaughtOffset};
use crate::integrate::Diverged;
use crate::process::planned;
use crate::robot::{Drives, Readings};
use crate::seam::Seam;
use crate::sensors::{
    DeviationSensor, FaultyInstruments, Instruments, outside, visit_measurements,
};
use nalgebra::Vector3;
use trueweld_core::compensation::{Compensated, Compensator, DeviationMeasurement, Observation};
use trueweld_core::control::{DriveCommand, HybridController, SensorReadings, Setpoint};
use trueweld_core::state::{StateResult, StateVisitor, Stateful};
use trueweld_core::{JointVector, Pose, Robot, Twist, Wrench};

/// A plant that motor torques drive.
pub trait Plant {
    /// Evaluates the present state. `time` in s.
    fn evaluate(&mut self, time: f64);

    /// Joint angles and rates of the present state.
    fn drives(&self) -> Drives;

    /// Real tool in B, as last evaluated.
    fn tcp(&self) -> Pose<f64>;

    /// The process' wrench on the tool, in T, as last evaluated.
    fn wrench_in_t(&self) -> Wrench<f64>;

    /// Advances the state, last evaluated at `time`, by `step` s under motor torque, N·m.
    ///
    /// # Errors
    /// [`Diverged`] where the state leaves the finite numbers.
    fn advance(&mut self, time: f64, torque: &JointVector<f64>, step: f64) -> Result<(), Diverged>;
}

/// What is asked of the tool in one period.
#[derive(Debug, Clone, Copy)]
pub struct Reference {
    /// Where the tool should be, in B, as the seam was taught.
    pub nominal: Pose<f64>,
    /// The set-point of the encoders' pose, in B, and of the force.
    pub setpoint: Setpoint<f64>,
    /// Path position, m.
    pub path: f64,
    /// Load that the plan expects on the tool, axes of W.
    pub planned: Wrench<f64>,
}

impl Reference {
    /// What a program's target asks for. `offset`: from the nominal pose to the set-point.
    pub fn of(
        scenario: &Scenario<'_>,
        seam: &Seam,
        offset: &TaughtOffset,
        target: &ProgramTarget,
    ) -> Self {
        let b_from_w = seam.axes(target.path);
        let nominal = seam.nominal(target.path);
        let force = match target.force {
            Some(push) => planned(scenario.planned, push, target.feed),
            None if scenario.planned.bears_push() => Vector3::zeros(),
            None => planned(scenario.planned, 0.0, target.feed),
        };
        Self {
            nominal,
            setpoint: Setpoint {
                pose: nominal.displaced(&offset.in_b(&b_from_w)),
                b_from_w,
                force: target.force,
                spindle_speed: scenario.planned.spindle,
            },
            path: target.path,
            planned: Wrench { moment: Vector3::zeros(), force },
        }
    }
}

/// What the instruments give at the start of a period.
#[derive(Debug, Clone)]
pub struct InstrumentReadings {
    /// Where the real tool should be, in B: on the seam as it is, not as it was taught.
    pub nominal: Pose<f64>,
    /// What the robot's own instruments give the controller.
    pub sensed: SensorReadings<f64>,
    /// What came from outside the robot since the last period.
    pub measurements: Vec<DeviationMeasurement<f64>>,
    /// Real tool against nominal, axes of the real seam's W: m and rad.
    pub deviation_w: Twist<f64>,
}

impl Stateful for InstrumentReadings {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        let Self { nominal, sensed, measurements, deviation_w } = self;
        visitor.matrix(&mut nominal.rotation)?;
        visitor.matrix(&mut nominal.position)?;
        let SensorReadings { encoder, encoder_rate, motor_torque, wrench } = sensed;
        [encoder, encoder_rate, motor_torque].into_iter().try_for_each(|of| visitor.matrix(of))?;
        visitor.wrench(wrench)?;
        visit_measurements(measurements, visitor)?;
        visitor.twist(deviation_w)
    }
}

/// What one period of control saw and commanded.
#[derive(Debug, Clone, Copy)]
pub struct Controlled {
    /// What the instruments gave the controller.
    pub sensed: SensorReadings<f64>,
    /// What the controller commanded.
    pub command: DriveCommand<f64>,
    /// Correction of the set-point in force, axes of W: m and rad.
    pub correction_w: Twist<f64>,
}

/// A controller of a tool that is held by position while a law acts on it: a law acts while a push
/// is asked for, and the controller is asked for none.
#[derive(Clone)]
struct HeldByPosition<H> {
    hybrid: H,
    holds: bool,
}

impl<H: HybridController<f64>> HybridController<f64> for HeldByPosition<H> {
    fn start(&mut self, robot: &Robot<f64>, encoder: &JointVector<f64>, torque: &JointVector<f64>) {
        self.hybrid.start(robot, encoder, torque);
    }

    fn cycle(
        &mut self,
        robot: &Robot<f64>,
        setpoint: &Setpoint<f64>,
        sensed: &SensorReadings<f64>,
    ) -> DriveCommand<f64> {
        let force = if self.holds { None } else { setpoint.force };
        self.hybrid.cycle(robot, &Setpoint { force, ..*setpoint }, sensed)
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.hybrid.visit_state(visitor)
    }
}

/// The controller's side of a cell: hybrid controller and law, with the limits of the control file.
#[derive(Clone)]
pub struct ControlSide<H, L> {
    controller: Compensated<f64, HeldByPosition<H>, L>,
    /// True where the depth is held by position throughout.
    by_position: bool,
}

impl<H: HybridController<f64>, L: Compensator<f64>> ControlSide<H, L> {
    /// The law.
    pub fn law(&mut self) -> &mut L {
        self.controller.law()
    }

    /// A controller and a law before [`start`](Self::start).
    pub fn new(scenario: &Scenario<'_>, hybrid: H, law: L) -> Self {
        let (period, limits) = (scenario.control.period, &scenario.control.compensation);
        let by_position = !scenario.planned.bears_push();
        let hybrid = HeldByPosition { hybrid, holds: by_position };
        let controller = Compensated::new(hybrid, law, limits.lateral, limits.orientation, period)
            .with_force_sensor_limits(scenario.sensors.force.limits);
        Self { controller, by_position }
    }

    /// Starts at rest, with the encoders at `motor`, rad, and the motors holding `torque`, N·m.
    /// `model`: the robot as the controller believes it is.
    pub fn start(
        &mut self,
        model: &Robot<f64>,
        motor: &JointVector<f64>,
        torque: &JointVector<f64>,
    ) {
        self.controller.start(model, motor, torque);
    }

    /// One period.
    pub fn cycle(
        &mut self,
        model: &Robot<f64>,
        reference: &Reference,
        sensed: &SensorReadings<f64>,
        measurements: &[DeviationMeasurement<f64>],
    ) -> Controlled {
        let force = if self.by_position { Some(0.0) } else { reference.setpoint.force };
        let observation = Observation {
            setpoint: &Setpoint { force, ..reference.setpoint },
            nominal: &reference.nominal,
            sensed,
            path: reference.path,
            planned: reference.planned,
            measurements,
            taught: None,
        };
        let command = self.controller.cycle(model, &observation);
        Controlled { sensed: *sensed, command, correction_w: self.controller.correction() }
    }
}

impl<H: HybridController<f64>, L: Compensator<f64>> Stateful for ControlSide<H, L> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.controller.visit_state(visitor)
    }
}

/// The plant's side of a cell: what reads it, and the torque that drives it.
#[derive(Debug, Clone)]
pub struct PlantSide {
    /// Rate of the encoders that the plant's state does not contain, rad/s: of a posture that is
    /// frozen on its way.
    pub frozen_rate: JointVector<f64>,
    /// Torque held over the period, N·m.
    pub torque: JointVector<f64>,
    /// The seam as it is, and as it was taught.
    seam: Seam,
    taught: Seam,
    instruments: Instruments,
    /// What measures the deviation from outside the robot.
    outside: Vec<Box<dyn DeviationSensor>>,
    faulty: FaultyInstruments,
    /// Plant steps in a period, and the length of each, s.
    steps: (usize, f64),
}

impl PlantSide {
    /// The scenario's instruments before the first period, the motors holding `torque`, N·m.
    pub fn new(scenario: &Scenario<'_>, torque: &JointVector<f64>) -> Self {
        let Scenario { sensors, seed, .. } = *scenario;
        let ports = &scenario.cell.robot.ports;
        let steps = scenario.plant_steps();
        Self {
            frozen_rate: JointVector::zeros(),
            torque: *torque,
            seam: scenario.cell.seam.clone(),
            taught: Seam::of(scenario.weld),
            instruments: Instruments::new(sensors, ports, steps.1, scenario.control.period, seed),
            outside: outside(sensors, seed),
            faulty: FaultyInstruments::new(scenario.fault, seed),
            steps,
        }
    }

    /// The seam as it is.
    pub fn seam(&self) -> &Seam {
        &self.seam
    }

    /// The seam as it was taught.
    pub fn taught(&self) -> &Seam {
        &self.taught
    }

    /// The start of a period: reads the instruments. `path`: where the program is, m.
    pub fn read<P: Plant>(
        &mut self,
        scenario: &Scenario<'_>,
        plant: &mut P,
        time: f64,
        path: f64,
    ) -> InstrumentReadings {
        self.sample(plant, time);
        let (drives, tcp) = (plant.drives(), plant.tcp());
        let truth = Readings::of(time, &drives.motor, &drives.link, &tcp);
        let ports = &scenario.cell.robot.ports;
        let mut sensed = self.instruments.read(ports, truth, &self.torque);
        sensed.encoder_rate += self.frozen_rate;
        let nominal = self.seam.nominal(path);
        let to_w = self.seam.axes(path).transpose();
        let deviation_w = nominal.error_to(&tcp).rotated(&to_w);
        let mut measurements = Vec::new();
        for k in 0..self.outside.len() {
            let bend = self.bend(path, self.outside[k].ahead());
            measurements.extend(self.outside[k].read(time, &deviation_w, bend));
        }
        self.faulty.pass_on(time, &mut sensed, &mut measurements);
        InstrumentReadings { nominal, sensed, measurements, deviation_w }
    }

    /// How much more the real seam bends up to where a sensor looks, m ahead, than the taught one does,
    /// across W, m: what the controller knows of the shape is taken off.
    fn bend(&self, path: f64, ahead: f64) -> f64 {
        self.seam.bend(path, ahead) - self.taught.bend(path, ahead)
    }

    /// The period itself: the plant moves with the torque held.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn advance<P: Plant>(&mut self, plant: &mut P, time: f64) -> Result<(), Diverged> {
        let (count, step) = self.steps;
        for k in 0..count {
            let now = time + k as f64 * step;
            if k > 0 {
                self.sample(plant, now);
            }
            plant.advance(now, &self.torque, step)?;
        }
        Ok(())
    }

    fn sample<P: Plant>(&mut self, plant: &mut P, time: f64) {
        plant.evaluate(time);
        self.instruments.observe(&plant.wrench_in_t());
    }
}

impl Stateful for PlantSide {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.matrix(&mut self.frozen_rate)?;
        visitor.matrix(&mut self.torque)?;
        self.instruments.visit_state(visitor)?;
        self.outside.iter_mut().try_for_each(|sensor| sensor.visit_state(visitor))?;
        self.faulty.visit_state(visitor)
    }
}
