//! One run: the plant in small steps, the control held over its period.
//!
//! The path is taught under gravity: at the start, with the tool free of contact, the real tool
//! stands on the line. The set-point then follows the line by the encoders alone, and whatever the
//! load bends from there is deviation. Where the seam is not where it was taught
//! ([`Cell::seam`]), deviations are from the seam as it is.

use super::cycle::{ControlCycle, Plant, Reference};
use super::start::{Start, lateral_by_joint};
use super::{RecordRow, Recording, RunError, Scenario, limit_spans};
use crate::cell::{Cell, Evaluation, State};
use crate::integrate::{Diverged, Stepper};
use crate::process::planned;
use crate::robot::Drives;
use crate::seam::Seam;
use nalgebra::Vector3;
use std::ops::ControlFlow;
use std::time::Instant;
use trueweld_core::compensation::Compensator;
use trueweld_core::monitor::HealthMonitor;
use trueweld_core::{JointVector, Pose, Wrench};

/// Runs a scenario to its end. `progress` is called with the simulated time, s, every control
/// period.
///
/// # Errors
/// [`RunError`].
pub fn run(scenario: &Scenario<'_>, progress: impl FnMut(f64)) -> Result<Recording, RunError> {
    run_passes(scenario, 1, progress)
}

/// The same seam so many times one after another, the law kept from one to the next and each with
/// noise of its own; the last run. `progress` goes on from pass to pass.
///
/// # Errors
/// [`RunError`].
pub fn run_passes(
    scenario: &Scenario<'_>,
    passes: usize,
    progress: impl FnMut(f64),
) -> Result<Recording, RunError> {
    // The last one has the scenario's own noise, and its fault.
    let noisy = |k: usize| Scenario {
        seed: scenario.seed.wrapping_add(k as u64),
        fault: None,
        ..*scenario
    };
    let before: Vec<Scenario<'_>> = (1..passes.max(1)).rev().map(noisy).collect();
    run_after(&before, scenario, progress)
}

/// A run whose law has been through the runs `before`, which differ from it in anything but law and
/// weld. `progress` goes on from run to run.
///
/// # Errors
/// [`RunError`], of whichever run.
pub fn run_after(
    before: &[Scenario<'_>],
    scenario: &Scenario<'_>,
    mut progress: impl FnMut(f64),
) -> Result<Recording, RunError> {
    let seam = Seam::of(scenario.weld);
    let mut law = scenario.build_law()?;
    let mut begun = 0.0;
    // Nobody stops these runs.
    let going_on = ControlFlow::Continue(());
    for earlier in before {
        run_with(earlier, law.as_mut(), |row| {
            progress(begun + row.time);
            going_on
        })?;
        begun += earlier.program.duration(earlier.weld, &seam);
    }
    run_with(scenario, law.as_mut(), |row| {
        progress(begun + row.time);
        going_on
    })
}

/// One run with a law that may have seen runs before; the scenario's own is not built. `progress` is
/// called with every row, and ends the run by breaking.
///
/// # Errors
/// [`RunError`].
pub fn run_with(
    scenario: &Scenario<'_>,
    law: &mut dyn Compensator<f64>,
    mut progress: impl FnMut(&RecordRow) -> ControlFlow<()>,
) -> Result<Recording, RunError> {
    let clock = Instant::now();
    let Scenario { cell, weld, program, control, .. } = *scenario;
    let seam = Seam::of(weld);
    scenario.check_process()?;
    let start = Start::of(scenario, &seam)?;
    let period = control.period;
    let ticks = (program.duration(weld, &seam) / period).round() as usize;

    let mut hybrid = scenario.build_controller()?;
    let plant = SimulatedCell::new(cell, Stepper::new(scenario.integrator), start.rest.state);
    let contact = -plant.at.reaction.force.z;
    let torque = &start.rest.torque;
    let mut cycle = ControlCycle::new(scenario, plant, hybrid.as_mut(), law, &start.motor, torque);
    let mut monitor = HealthMonitor::new(period as f32);
    let mut recording = Recording::begun(scenario, scenario.law.name());
    recording.rows.reserve_exact(ticks);
    for tick in 0..ticks {
        let time = tick as f64 * period;
        let target = program.target(weld, &seam, contact, time);
        let reference = Reference::of(scenario, &seam, &start.offset, &target);
        let controlled = cycle.control(time, &reference);
        let w = reference.setpoint.b_from_w;
        let axes = cycle.seam().axes(target.path);
        let (SimulatedCell { at, state, .. }, nominal) = (&cycle.plant, controlled.nominal);
        let (command, drives, tcp) = (controlled.command, state.drives(), at.frames.tcp);
        let sensed = &controlled.sensed;
        let health = monitor.as_mut().map(|monitor| monitor.watch(&reference.setpoint, sensed));
        let row = RecordRow {
            time,
            phase: target.phase,
            path: target.path,
            axes,
            nominal,
            real: tcp,
            encoder_pose: scenario.controller_model.forward_kinematics(&drives.motor),
            deviation_w: controlled.deviation_w,
            tilt: tool_axis(&tcp).angle(&tool_axis(&nominal)),
            lateral_by_joint: lateral_by_joint(
                &cell.robot.model,
                &w,
                &at.frames,
                &drives,
                &start.extra_torsion,
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
            correction_w: controlled.correction_w,
            limited: command.limited,
            health: health.unwrap_or_default(),
            fault: command.fault,
        };
        recording.rows.push(row);
        cycle
            .advance(time)
            .map_err(|source| RunError::RanAway { source, limits: limit_spans(&recording) })?;
        if progress(&row).is_break() {
            break;
        }
    }
    recording.simulated = recording.rows.len() as f64 * period;
    recording.wall = clock.elapsed().as_secs_f64();
    Ok(recording)
}

impl Recording {
    /// A run before its first row. `compensator`: the law's name.
    pub fn begun(scenario: &Scenario<'_>, compensator: &str) -> Self {
        let Scenario { cell, weld, .. } = *scenario;
        let joints = &scenario.controller_model.parameters().joints;
        Self {
            weld: scenario.name.to_owned(),
            controller: scenario.controller.name(),
            compensator: compensator.to_owned(),
            rows: Vec::new(),
            period: scenario.control.period,
            half_pin: cell.process.model.lateral_tolerance(),
            tolerance_name: cell.process.model.tolerance_name(),
            force: weld.force,
            planned_force: planned(scenario.planned, weld.force, weld.feed),
            planned_depth: scenario.planned.depth_under(weld.force),
            max_torque: JointVector::from_fn(|i, _| joints[i].max_torque),
            max_rate: JointVector::from_fn(|i, _| joints[i].max_rate),
            seed: scenario.seed,
            simulated: 0.0,
            wall: 0.0,
        }
    }
}

/// z of a tool frame: the spindle's axis.
fn tool_axis(pose: &Pose<f64>) -> Vector3<f64> {
    pose.rotation.column(2).into_owned()
}

/// The nonlinear cell, integrated.
#[derive(Debug)]
pub struct SimulatedCell<'a> {
    cell: &'a Cell,
    stepper: Stepper,
    state: State,
    at: Evaluation,
}

impl<'a> SimulatedCell<'a> {
    /// A cell in this state.
    pub fn new(cell: &'a Cell, stepper: Stepper, state: State) -> Self {
        Self { cell, stepper, state, at: cell.evaluate(0.0, &state) }
    }
}

impl Plant for SimulatedCell<'_> {
    fn evaluate(&mut self, time: f64) {
        self.at = self.cell.evaluate(time, &self.state);
    }

    fn drives(&self) -> Drives {
        self.state.drives()
    }

    fn tcp(&self) -> Pose<f64> {
        self.at.frames.tcp
    }

    fn wrench_in_t(&self) -> Wrench<f64> {
        self.at.wrench_in_t()
    }

    fn advance(&mut self, time: f64, torque: &JointVector<f64>, step: f64) -> Result<(), Diverged> {
        let Self { cell, stepper, state, at } = self;
        *state = stepper.advance(cell, time, state, at, torque, step)?;
        Ok(())
    }
}
