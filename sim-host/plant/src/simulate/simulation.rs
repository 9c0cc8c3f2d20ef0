//! A run in progress, one control period at a time, with a state that goes on in another process.
//!
//! As with a model and its data, what does not change, the [`Scenario`], comes with every call, and is
//! the one that the run was made of. [`OpenCell`] is the cell without its controller: whoever has it
//! commands the torques. [`Simulation`] is the cell under its controller and a law.
//!
//! ```
//! # use trueweld_plant::cell::Cell;
//! # use trueweld_plant::input::{Control, InputFile, Process, RobotFile, Sensors, Weld};
//! # use trueweld_plant::integrate::Integrator;
//! # use trueweld_plant::simulate::{ControllerKind, Scenario, Seam, WeldProgram};
//! use trueweld_plant::simulate::Simulation;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let fixture = |name| format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
//! # let robot = RobotFile::read(fixture("robots/kr500-mt.toml"))?;
//! # let process = Process::read(fixture("processes/lap-weld-2024-t3.toml"))?;
//! # let weld = Weld::read(fixture("welds/vertical.toml"))?;
//! # let control = Control::read(fixture("control/kr500-mt.toml"))?;
//! # let sensors = Sensors::read(fixture("sensors/kr500-mt.toml"))?;
//! # let cell = Cell::new(&robot.robot, &[], &process, Seam::real(&weld))?;
//! # let scenario = Scenario {
//! #     name: "vertical",
//! #     cell: &cell,
//! #     controller_model: &robot.robot,
//! #     planned: &process,
//! #     weld: &weld,
//! #     program: WeldProgram::Weld,
//! #     control: &control,
//! #     sensors: &sensors,
//! #     controller: ControllerKind::EXTERNAL,
//! #     law: &trueweld_compensators::find("seam-tracking").expect("a law of the table"),
//! #     integrator: Integrator::LinearlyImplicit,
//! #     plant_step: 1e-3,
//! #     seed: 1,
//! #     fault: None,
//! # };
//! let mut first = Simulation::new(&scenario)?;
//! first.step(&scenario)?;
//! let state = first.state()?;
//! let next = first.step(&scenario)?;
//! // In the same process or another one:
//! let mut second = Simulation::new(&scenario)?;
//! second.restore(&state)?;
//! assert_eq!(second.step(&scenario)?.torque, next.torque);
//! # Ok(())
//! # }
//! ```

use super::cycle::{ControlSide, Controlled, InstrumentReadings, Plant, PlantSide, Reference};
use super::start::{Start, lateral_by_joint};
use super::{ProgramTarget, RecordRow, RunError, Scenario};
use crate::cell::{Cell, Evaluation, State};
use crate::controllers::PlantController;
use crate::integrate::{Diverged, Stepper};
use crate::robot::Drives;
use nalgebra::Vector3;
use trueweld_compensators::OwnedLaw;
use trueweld_core::compensation::Compensator;
use trueweld_core::monitor::HealthMonitor;
use trueweld_core::state::{StateError, StateResult, StateVisitor, Stateful};
use trueweld_core::{JointVector, Pose, Wrench};

/// Most control periods that a state can count.
const PERIODS_MAX: usize = 1 << 48;

/// The nonlinear cell's state, integrated.
#[derive(Debug, Clone, Copy)]
pub struct CellMotion {
    stepper: Stepper,
    /// Angles, rates, and what process and effects keep.
    pub state: State,
    /// The right-hand side where it was last evaluated.
    pub at: Evaluation,
}

impl CellMotion {
    /// A cell in this state.
    pub fn new(cell: &Cell, stepper: Stepper, state: State) -> Self {
        Self { stepper, state, at: cell.evaluate(0.0, &state) }
    }
}

/// The nonlinear cell as a plant.
#[derive(Debug)]
pub struct SimulatedCell<'a> {
    /// Robot and process.
    pub cell: &'a Cell,
    /// What changes of it.
    pub motion: &'a mut CellMotion,
}

impl Plant for SimulatedCell<'_> {
    fn evaluate(&mut self, time: f64) {
        self.motion.at = self.cell.evaluate(time, &self.motion.state);
    }

    fn drives(&self) -> Drives {
        self.motion.state.drives()
    }

    fn tcp(&self) -> Pose<f64> {
        self.motion.at.frames.tcp
    }

    fn wrench_in_t(&self) -> Wrench<f64> {
        self.motion.at.wrench_in_t()
    }

    fn advance(&mut self, time: f64, torque: &JointVector<f64>, step: f64) -> Result<(), Diverged> {
        let CellMotion { stepper, state, at } = self.motion;
        *state = stepper.advance(self.cell, time, state, at, torque, step)?;
        Ok(())
    }
}

/// What a cell shows at the start of a control period.
#[derive(Debug, Clone)]
pub struct CellView {
    /// Time, s.
    pub time: f64,
    /// What the weld's program asks for.
    pub target: ProgramTarget,
    /// The same as poses, axes and planned load.
    pub reference: Reference,
    /// What the instruments give.
    pub readings: InstrumentReadings,
}

/// A cell in a weld without its controller: robot with effects, process, instruments and program.
#[derive(Debug, Clone)]
pub struct OpenCell {
    side: PlantSide,
    motion: CellMotion,
    start: Start,
    /// Push at rest before the force loop closes, N.
    contact: f64,
    /// Periods that are over, and of the whole program.
    tick: usize,
    periods: usize,
}

impl OpenCell {
    /// A cell at the start of its weld, at rest with the tool in the material.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn new(scenario: &Scenario<'_>) -> Result<Self, RunError> {
        let Scenario { cell, weld, program, control, .. } = *scenario;
        let seam = crate::seam::Seam::of(weld);
        scenario.check_process()?;
        let start = Start::of(scenario, &seam)?;
        let stepper = Stepper::new(scenario.integrator);
        let motion = CellMotion::new(cell, stepper, start.rest.state);
        Ok(Self {
            side: PlantSide::new(scenario, &start.rest.torque),
            motion,
            contact: -motion.at.reaction.force.z,
            start,
            tick: 0,
            periods: (program.duration(weld, &seam) / control.period).round() as usize,
        })
    }

    /// Encoder angles, rad, and motor torque, N·m, at the start: what a controller starts with.
    pub fn start(&self) -> [JointVector<f64>; 2] {
        [self.start.motor, self.start.rest.torque]
    }

    /// Control periods of the whole program.
    pub fn periods(&self) -> usize {
        self.periods
    }

    /// Control periods that are over.
    pub fn periods_done(&self) -> usize {
        self.tick
    }

    /// True once the program is over; the cell may go on.
    pub fn is_done(&self) -> bool {
        self.tick >= self.periods
    }

    /// Time at the start of this period, s.
    pub fn time(&self, scenario: &Scenario<'_>) -> f64 {
        self.tick as f64 * scenario.control.period
    }

    /// Angles, rates and forces where the cell was last [observed](Self::observe).
    pub fn motion(&self) -> &CellMotion {
        &self.motion
    }

    /// Reads the instruments, which takes from their random numbers: once a period.
    pub fn observe(&mut self, scenario: &Scenario<'_>) -> CellView {
        let time = self.time(scenario);
        let (target, reference) = self.asked(scenario, time);
        let mut plant = SimulatedCell { cell: scenario.cell, motion: &mut self.motion };
        let readings = self.side.read(scenario, &mut plant, time, target.path);
        CellView { time, target, reference, readings }
    }

    /// What [`observe`](Self::observe) gave at `time`, s, with these readings. Evaluates the state:
    /// for one that was restored after the instruments were read.
    pub fn observed(
        &mut self,
        scenario: &Scenario<'_>,
        time: f64,
        readings: InstrumentReadings,
    ) -> CellView {
        self.evaluate(scenario);
        let (target, reference) = self.asked(scenario, time);
        CellView { time, target, reference, readings }
    }

    /// What the weld's program asks for at a time, s.
    fn asked(&self, scenario: &Scenario<'_>, time: f64) -> (ProgramTarget, Reference) {
        let taught = self.side.taught();
        let target = scenario.program.target(scenario.weld, taught, self.contact, time);
        (target, Reference::of(scenario, taught, &self.start.offset, &target))
    }

    /// Evaluates the present state, as [`observe`](Self::observe) does, without reading the
    /// instruments: for one that was restored after they were read.
    pub fn evaluate(&mut self, scenario: &Scenario<'_>) {
        let time = self.time(scenario);
        SimulatedCell { cell: scenario.cell, motion: &mut self.motion }.evaluate(time);
    }

    /// Motor torque of the last period, N·m.
    pub fn torque(&self) -> &JointVector<f64> {
        &self.side.torque
    }

    /// Sets the motors' torque, N·m, from this instant on.
    pub fn command(&mut self, torque: &JointVector<f64>) {
        self.side.torque = *torque;
    }

    /// The period itself, with the torque held.
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn advance(&mut self, scenario: &Scenario<'_>) -> Result<(), Diverged> {
        let time = self.time(scenario);
        let mut plant = SimulatedCell { cell: scenario.cell, motion: &mut self.motion };
        self.side.advance(&mut plant, time)?;
        self.tick += 1;
        Ok(())
    }

    /// The record of this period, but for what the watch beside the law sees.
    fn row(&self, scenario: &Scenario<'_>, view: &CellView, controlled: &Controlled) -> RecordRow {
        let CellView { time, target, reference, readings } = view;
        let Controlled { sensed, command, correction_w } = controlled;
        let (CellMotion { state, at, .. }, nominal) = (&self.motion, readings.nominal);
        let (drives, tcp) = (state.drives(), at.frames.tcp);
        let w = reference.setpoint.b_from_w;
        let axes = self.side.seam().axes(target.path);
        RecordRow {
            time: *time,
            phase: target.phase,
            path: target.path,
            axes,
            nominal,
            real: tcp,
            encoder_pose: scenario.controller_model.forward_kinematics(&drives.motor),
            deviation_w: readings.deviation_w,
            tilt: tool_axis(&tcp).angle(&tool_axis(&nominal)),
            lateral_by_joint: lateral_by_joint(
                &scenario.cell.robot.model,
                &w,
                &at.frames,
                &drives,
                &self.start.extra_torsion,
            ),
            // The tool is elsewhere on the seam than planned, and the seam may turn.
            force_w: axes.tr_mul(&at.wrench().force),
            force_sensed_w: w.tr_mul(&(tcp.rotation * sensed.wrench.force)),
            force_desired: target.force,
            link: drives.link,
            motor: drives.motor,
            torque: command.torque,
            spindle_angle: state.spindle_angle(),
            force_error: command.force_error,
            depth_correction: command.depth_correction,
            push: command.push,
            correction_w: *correction_w,
            limited: command.limited,
            health: Default::default(),
            fault: command.fault,
        }
    }
}

impl Stateful for OpenCell {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.count(&mut self.tick, PERIODS_MAX)?;
        self.motion.stepper.visit_state(visitor)?;
        visitor.matrix(&mut self.motion.state.0)?;
        self.side.visit_state(visitor)
    }
}

/// z of a tool frame: the spindle's axis.
fn tool_axis(pose: &Pose<f64>) -> Vector3<f64> {
    pose.rotation.column(2).into_owned()
}

/// A cell in a weld under its controller and a law, one control period at a time.
#[derive(Clone)]
pub struct Simulation<L> {
    /// The cell: observed before [`control`](Simulation::control), advanced after it.
    pub cell: OpenCell,
    controller: ControlSide<Box<dyn PlantController>, L>,
    monitor: Option<HealthMonitor>,
}

impl Simulation<OwnedLaw> {
    /// The start of a run, with the scenario's law as it is before its first weld.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn new(scenario: &Scenario<'_>) -> Result<Self, RunError> {
        Self::with_law(scenario, OwnedLaw(scenario.build_law()?))
    }
}

impl<L: Compensator<f64>> Simulation<L> {
    /// The start of a run, with a law that may have seen runs before.
    ///
    /// # Errors
    /// [`RunError`].
    pub fn with_law(scenario: &Scenario<'_>, law: L) -> Result<Self, RunError> {
        let cell = OpenCell::new(scenario)?;
        let hybrid = scenario.build_controller()?;
        let mut controller = ControlSide::new(scenario, hybrid, law);
        let [motor, torque] = cell.start();
        controller.start(scenario.controller_model, &motor, &torque);
        let monitor = HealthMonitor::new(scenario.control.period as f32);
        Ok(Self { cell, controller, monitor })
    }

    /// The law.
    pub fn law(&mut self) -> &mut L {
        self.controller.law()
    }

    /// One control period: [`OpenCell::observe`], [`control`](Self::control) and
    /// [`OpenCell::advance`].
    ///
    /// # Errors
    /// [`Diverged`].
    pub fn step(&mut self, scenario: &Scenario<'_>) -> Result<RecordRow, Diverged> {
        let seen = self.cell.observe(scenario);
        let row = self.control(scenario, &seen);
        self.cell.advance(scenario)?;
        Ok(row)
    }

    /// Has controller and law command a torque by what was observed; returns the record of the period.
    pub fn control(&mut self, scenario: &Scenario<'_>, seen: &CellView) -> RecordRow {
        let CellView { reference, readings, .. } = seen;
        let model = scenario.controller_model;
        let controlled =
            self.controller.cycle(model, reference, &readings.sensed, &readings.measurements);
        self.cell.command(&controlled.command.torque);
        let mut row = self.cell.row(scenario, seen, &controlled);
        let watch =
            |monitor: &mut HealthMonitor| monitor.watch(&reference.setpoint, &controlled.sensed);
        row.health = self.monitor.as_mut().map(watch).unwrap_or_default();
        row
    }

    /// Its state between two periods, as numbers that [`restore`](Self::restore) takes in any process
    /// of the same program and the same scenario.
    ///
    /// # Errors
    /// [`StateError::Unsupported`] of a law that does not list its state.
    pub fn state(&mut self) -> Result<Vec<f64>, StateError> {
        state_of(self)
    }

    /// Goes on from a state. Whether it is one of this scenario is for the caller to know.
    ///
    /// # Errors
    /// [`StateError`]; the run is then of no use.
    pub fn restore(&mut self, state: &[f64]) -> StateResult {
        restore_state(self, state)
    }
}

impl<L: Compensator<f64>> Stateful for Simulation<L> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.cell.visit_state(visitor)?;
        self.controller.visit_state(visitor)?;
        self.monitor.as_mut().map_or(Ok(()), |monitor| monitor.visit_state(visitor))
    }
}

/// The numbers of a state, in the order in which they are visited.
///
/// # Errors
/// [`StateError`].
pub fn state_of(of: &mut dyn Stateful) -> Result<Vec<f64>, StateError> {
    struct Copied(Vec<f64>);
    impl StateVisitor for Copied {
        fn visit(&mut self, number: &mut f64) -> StateResult {
            self.0.push(*number);
            Ok(())
        }
    }
    let mut copied = Copied(Vec::new());
    of.visit_state(&mut copied)?;
    Ok(copied.0)
}

/// Puts the numbers of [`state_of`] back.
///
/// # Errors
/// [`StateError`]; some numbers may have been put back then.
pub fn restore_state(to: &mut dyn Stateful, state: &[f64]) -> StateResult {
    struct Replaced<'a>(std::slice::Iter<'a, f64>);
    impl StateVisitor for Replaced<'_> {
        fn visit(&mut self, number: &mut f64) -> StateResult {
            *number = *self.0.next().ok_or(StateError::Length)?;
            Ok(())
        }
    }
    let mut replaced = Replaced(state.iter());
    to.visit_state(&mut replaced)?;
    if replaced.0.len() == 0 { Ok(()) } else { Err(StateError::Length) }
}
