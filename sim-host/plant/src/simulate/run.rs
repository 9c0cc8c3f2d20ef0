//! One run: the plant in small steps, the control held over its period.
//!
//! The path is taught under gravity: at the start, with the tool free of contact, the real tool
//! stands on the line. The set-point then follows the line by the encoders alone, and whatever the
//! load bends from there is deviation. Where the seam is not where it was taught
//! ([`Cell::seam`](crate::cell::Cell::seam)), deviations are from the seam as it is.

use super::simulation::Simulation;
use super::{RecordRow, Recording, RunError, Scenario, limit_spans};
use crate::process::planned;
use crate::seam::Seam;
use std::ops::ControlFlow;
use std::time::Instant;
use trueweld_core::JointVector;
use trueweld_core::compensation::Compensator;

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
    let mut simulation = Simulation::with_law(scenario, law)?;
    let ticks = simulation.cell.periods();
    let mut recording = Recording::begun(scenario, scenario.law.name());
    recording.rows.reserve_exact(ticks);
    while !simulation.cell.is_done() {
        let seen = simulation.cell.observe(scenario);
        let row = simulation.control(scenario, &seen);
        recording.rows.push(row);
        simulation
            .cell
            .advance(scenario)
            .map_err(|source| RunError::RanAway { source, limits: limit_spans(&recording) })?;
        if progress(&row).is_break() {
            break;
        }
    }
    recording.simulated = recording.rows.len() as f64 * scenario.control.period;
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
