//! One run: the plant in small steps, the control held over its period.
//!
//! The path is taught under gravity: at the start, with the tool free of contact, the real tool
//! stands on the line. The set-point then follows the line by the encoders alone, and whatever the
//! load bends from there is deviation.

use super::{Program, RecordRow, Recording, Seam};
use crate::cell::{Cell, Evaluation};
use crate::input::{Control, Process, Sensors, Weld};
use crate::integrate::rest::{self, EquilibriumError};
use crate::integrate::{Diverged, Integrator, Stepper};
use crate::process::planned;
use crate::robot::{Drives, Readings};
use crate::sensors::{FaultyInstruments, InstrumentFault, Instruments, SeamSensing};
use nalgebra::Vector3;
use std::time::Instant;
use trueweld_compensators::{BuildError, Entry};
use trueweld_core::compensation::{Compensated, Compensator, Observation};
use trueweld_core::control::{
    External, HybridController, JointGains, Parallel, Setpoint, Superposed,
};
use trueweld_core::{JointVector, KinematicsError, Pose, Robot, Twist, Wrench};

/// Which hybrid controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Controller {
    /// Scheme 1, (2.2).
    Parallel,
    /// Scheme 2, (2.3).
    Superposed,
    /// Scheme 3, (2.4)–(2.5).
    External,
}

impl Controller {
    /// All of them, in the order of the published study.
    pub const ALL: [Self; 3] = [Self::Parallel, Self::Superposed, Self::External];

    /// Its name on the command line and in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Parallel => "parallel",
            Self::Superposed => "superposed",
            Self::External => "external",
        }
    }

    /// Gains of its joint position loop.
    pub fn joint_gains(self, control: &Control) -> &JointGains<f64> {
        match self {
            Self::Parallel => &control.parallel.joint,
            Self::Superposed => &control.superposed.joint,
            Self::External => &control.external.joint,
        }
    }

    /// The controller with the gains of a cell, at rest.
    pub fn build(self, control: &Control) -> Box<dyn HybridController<f64>> {
        let (joint, period) = (*self.joint_gains(control), control.period);
        match self {
            Self::Parallel => Box::new(Parallel::new(joint, control.parallel.force, period)),
            Self::Superposed => Box::new(Superposed::new(joint, control.superposed.force, period)),
            Self::External => Box::new(External::new(joint, control.external.force, period)),
        }
    }
}

/// Why a run did not come to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The tool cannot be brought to some point of the seam.
    #[error("the robot cannot hold the tool {path:.3} m along the seam: {reason}")]
    Reach {
        /// Path position, m.
        path: f64,
        /// In words.
        reason: &'static str,
    },
    /// No deformed start.
    #[error(transparent)]
    Rest(#[from] EquilibriumError),
    /// The state left the finite numbers.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// A gain that does not suit the control period.
    #[error("at a control period of {period} s {source}")]
    Law {
        /// The law and its gain.
        source: BuildError,
        /// Control period, s.
        period: f64,
    },
    /// A cell that cannot be built from what was drawn for it.
    #[error("the cell cannot be built")]
    Cell,
    /// A law that learns from a seam sensor, in a cell without one.
    #[error("the law {law} needs a seam sensor, and the sensor file has no [seam]")]
    NoSeamSensor {
        /// Its name.
        law: String,
    },
}

/// Everything one run is made of.
#[derive(Debug, Clone, Copy)]
pub struct Scenario<'a> {
    /// Name of the weld, for the record.
    pub name: &'a str,
    /// Robot and process.
    pub cell: &'a Cell,
    /// The robot as the controller believes it is.
    pub controller_model: &'a Robot<f64>,
    /// The process as the weld was planned with it.
    pub planned: &'a Process,
    /// The weld.
    pub weld: &'a Weld,
    /// What is done.
    pub program: Program,
    /// Gains and limits.
    pub control: &'a Control,
    /// Instruments.
    pub sensors: &'a Sensors,
    /// Which controller.
    pub controller: Controller,
    /// Which law.
    pub law: &'a Entry,
    /// How the plant is integrated.
    pub integrator: Integrator,
    /// Longest plant step, s; the control period is divided evenly.
    pub plant_step: f64,
    /// Seed of the instruments' noise.
    pub seed: u64,
    /// An instrument that fails, in the last run where there are several.
    pub fault: Option<InstrumentFault>,
}

impl Scenario<'_> {
    /// Plant steps in a control period, and the length of each, s.
    pub fn plant_steps(&self) -> (usize, f64) {
        let period = self.control.period;
        let steps = (period / self.plant_step - 1e-9).ceil().max(1.0);
        (steps as usize, period / steps)
    }

    /// The law as it is before its first weld.
    ///
    /// # Errors
    /// [`RunError::NoSeamSensor`], and [`RunError::Law`] where a gain does not suit the control
    /// period.
    pub fn build_law(&self) -> Result<Box<dyn Compensator<f64>>, RunError> {
        if self.law.needs().seam_sensor && self.sensors.seam.is_none() {
            return Err(RunError::NoSeamSensor { law: self.law.name().to_owned() });
        }
        let setup = self.control.setup(Seam::of(self.weld).length);
        self.law
            .build(&self.control.laws, &setup)
            .map_err(|source| RunError::Law { source, period: setup.period })
    }
}

/// Joint angles at the start of a seam, on the branch that follows the whole seam within the limits
/// with the smallest angles.
///
/// # Errors
/// [`RunError::Reach`] with the first point that no branch holds.
pub fn start_angles(robot: &Robot<f64>, seam: &Seam) -> Result<JointVector<f64>, RunError> {
    const POINTS: usize = 200;
    let reason = |e: KinematicsError| match e {
        KinematicsError::NotDecoupled => {
            "closed-form inverse kinematics needs a spherical wrist and A1 vertical"
        }
        KinematicsError::Unreachable => "out of reach",
        KinematicsError::Singular => "singular posture",
        KinematicsError::Limit(_) => "a joint limit",
        KinematicsError::NotFinite => "the seam is not a number",
    };
    let found = robot
        .inverse_all(&seam.nominal(0.0))
        .map_err(|e| RunError::Reach { path: 0.0, reason: reason(e) })?;
    let mut farthest = RunError::Reach { path: 0.0, reason: "a joint limit" };
    let mut reached = 0.0;
    let mut best: Option<JointVector<f64>> = None;
    for (_, start) in found.iter().filter(|(_, q)| robot.beyond_limits(q).is_none()) {
        let mut q = *start;
        let failed = (1..=POINTS).find_map(|k| {
            let path = seam.length * k as f64 / POINTS as f64;
            match robot.inverse_near(&seam.nominal(path), &q) {
                Ok(next) => {
                    q = next;
                    None
                }
                Err(e) => Some((path, reason(e))),
            }
        });
        match failed {
            None if best.is_none_or(|b| start.norm() < b.norm()) => best = Some(*start),
            Some((path, reason)) if path > reached => {
                reached = path;
                farthest = RunError::Reach { path, reason };
            }
            _ => {}
        }
    }
    best.ok_or(farthest)
}

/// The deformed start: encoder angles of the taught pose (tool free), and the cell at rest with the
/// tool's set-point the initial depth in the material.
struct Start {
    rest: rest::Rest,
    motor: JointVector<f64>,
    /// From the nominal pose to the set-point, axes of W.
    taught: Twist<f64>,
}

fn start(scenario: &Scenario<'_>, seam: &Seam) -> Result<Start, RunError> {
    let model = &scenario.cell.robot.model;
    let link = start_angles(model, seam)?;
    let free = rest::motors_for(scenario.cell, &link, &Wrench::zero());
    if !free.sum().is_finite() {
        return Err(EquilibriumError { residual: f64::NAN }.into());
    }
    let nominal = seam.nominal(0.0);
    let w = seam.b_from_w.rotation;
    let mut taught = nominal.error_to(&model.forward_kinematics(&free)).rotated(&w.transpose());
    taught.linear.z += scenario.weld.initial_depth;
    let motor = model
        .inverse_near(&nominal.displaced(&taught.rotated(&w)), &free)
        .map_err(|_| RunError::Reach { path: 0.0, reason: "the deformed start is out of reach" })?;
    Ok(Start { rest: rest::in_contact(scenario.cell, &motor)?, motor, taught })
}

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
    for earlier in before {
        run_with(earlier, law.as_mut(), |time| progress(begun + time))?;
        begun += earlier.program.duration(earlier.weld, &seam);
    }
    run_with(scenario, law.as_mut(), |time| progress(begun + time))
}

/// One run with a law that may have seen runs before; the scenario's own is not built.
///
/// # Errors
/// [`RunError`].
fn run_with(
    scenario: &Scenario<'_>,
    law: &mut dyn Compensator<f64>,
    mut progress: impl FnMut(f64),
) -> Result<Recording, RunError> {
    let clock = Instant::now();
    let Scenario { cell, controller_model, weld, program, control, .. } = *scenario;
    let seam = Seam::of(weld);
    let start = start(scenario, &seam)?;
    let period = control.period;
    let (substeps, h) = scenario.plant_steps();
    let duration = program.duration(weld, &seam);
    let ticks = (duration / period).round() as usize;

    let mut hybrid = scenario.controller.build(control);
    let limits = &control.compensation;
    let mut controller =
        Compensated::new(hybrid.as_mut(), law, limits.lateral, limits.orientation, period);
    controller.start(controller_model, &start.motor, &start.rest.torque);
    let mut instruments =
        Instruments::new(scenario.sensors, &cell.robot.ports, h, period, scenario.seed);
    let mut seam_sensor =
        scenario.sensors.seam.as_ref().map(|sensor| SeamSensing::new(sensor, scenario.seed));
    let mut faulty = FaultyInstruments::new(scenario.fault, scenario.seed);
    let mut stepper = Stepper::new(scenario.integrator);

    let mut state = start.rest.state;
    let mut torque = start.rest.torque;
    let mut contact = 0.0;
    let mut rows = Vec::with_capacity(ticks);
    for tick in 0..ticks {
        let time = tick as f64 * period;
        let drives = state.drives();
        let mut at = cell.evaluate(time, &state);
        instruments.observe(&cell.wrench_in_t(&at));
        if tick == 0 {
            contact = -at.reaction.force.z;
        }
        let mut sensed = instruments.read(
            &cell.robot.ports,
            Readings::of(time, &drives.motor, &drives.link, &at.frames.tcp),
            &torque,
        );
        let target = program.target(weld, &seam, contact, time);
        let nominal = seam.nominal(target.path);
        let setpoint = Setpoint {
            pose: nominal.displaced(&start.taught.rotated(&seam.b_from_w.rotation)),
            b_from_w: seam.b_from_w.rotation,
            force: target.force,
            spindle_speed: scenario.planned.spindle,
        };
        let deviation_w =
            nominal.error_to(&at.frames.tcp).rotated(&seam.b_from_w.rotation.transpose());
        let mut sightings =
            seam_sensor.as_mut().map_or(Vec::new(), |sensor| sensor.read(time, &deviation_w));
        faulty.pass_on(time, &mut sensed, &mut sightings);
        let load = target
            .force
            .map_or(Vector3::zeros(), |push| planned(scenario.planned, push, target.feed));
        let observation = Observation {
            setpoint: &setpoint,
            nominal: &nominal,
            sensed: &sensed,
            path: target.path,
            planned: Wrench { moment: Vector3::zeros(), force: load },
            sightings: &sightings,
        };
        let command = controller.cycle(controller_model, &observation);
        torque = command.torque;
        rows.push(RecordRow {
            time,
            phase: target.phase,
            nominal,
            real: at.frames.tcp,
            encoder_pose: cell.robot.model.forward_kinematics(&drives.motor),
            deviation_w,
            tilt: tool_axis(&at.frames.tcp).angle(&tool_axis(&nominal)),
            lateral_by_joint: lateral_by_joint(&seam, &at, &drives),
            force_w: at.reaction.force,
            force_sensed_w: seam
                .b_from_w
                .rotation
                .tr_mul(&(at.frames.tcp.rotation * sensed.wrench.force)),
            force_desired: target.force,
            link: drives.link,
            motor: drives.motor,
            torque,
            spindle_angle: state.spindle_angle(),
            force_error: command.force_error,
            depth_correction: command.depth_correction,
            push: command.push,
            correction_w: controller.correction(),
            limited: command.limited,
            fault: command.fault,
        });
        for k in 0..substeps {
            let t = time + k as f64 * h;
            if k > 0 {
                at = cell.evaluate(t, &state);
                instruments.observe(&cell.wrench_in_t(&at));
            }
            state = stepper.advance(cell, t, &state, &at, &torque, h)?;
        }
        progress(time);
    }
    Ok(Recording {
        weld: scenario.name.to_owned(),
        controller: scenario.controller.name(),
        compensator: scenario.law.name().to_owned(),
        rows,
        period,
        half_pin: 0.5 * cell.process.pin_diameter,
        force: weld.force,
        planned_depth: weld.force / scenario.planned.depth_stiffness,
        seed: scenario.seed,
        simulated: ticks as f64 * period,
        wall: clock.elapsed().as_secs_f64(),
    })
}

/// z of a tool frame: the spindle's axis.
fn tool_axis(pose: &Pose<f64>) -> Vector3<f64> {
    pose.rotation.column(2).into_owned()
}

/// Row y of W_R_B · J times −twist: what each joint's twist does to the tool across the seam, m.
fn lateral_by_joint(seam: &Seam, at: &Evaluation, drives: &Drives) -> JointVector<f64> {
    let across = seam.b_from_w.rotation.column(1);
    let jacobian = at.frames.jacobian().0;
    JointVector::from_fn(|i, _| {
        across.dot(&jacobian.fixed_view::<3, 1>(3, i)) * (drives.link[i] - drives.motor[i])
    })
}
