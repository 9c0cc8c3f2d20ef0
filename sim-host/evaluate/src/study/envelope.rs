//! How wide the push swings where axes 4 and 6 come together: the same weld at one place after the
//! other, as the published study has it in its section 5.3.

use super::place::{ArmAlongSeam, Placement, RealArm, Workpiece};
use crate::laws::NoFigures;
use crate::weld::WeldFigures;
use rayon::prelude::*;
use trueweld_core::KinematicsError;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::Weld;
use trueweld_plant::simulate::{Phase, Recording, RunError, Scenario, Seam, run};

/// One weld at one distance in front of the robot.
#[derive(Debug, Clone)]
pub struct EnvelopePoint {
    /// Distance of the seam's middle along x of B, m.
    pub x: f64,
    /// What came of it.
    pub outcome: Result<EnvelopeRun, NoFigures>,
}

/// A weld near collinear axes 4 and 6.
#[derive(Debug, Clone)]
pub struct EnvelopeRun {
    /// Least angle between the axes of A4 and A6 over the steady part, rad.
    pub collinearity: f64,
    /// Figures of the weld.
    pub figures: WeldFigures,
    /// Path position, m, push, N, and the angle between the axes, rad, over the steady part.
    pub trace: Vec<[f64; 3]>,
}

/// Welds of one kind at several distances.
pub fn envelopes(
    scenario: &Scenario<'_>,
    arm: &RealArm<'_>,
    weld: &Weld,
    distances: &[f64],
    progress: impl Fn() + Sync,
) -> Vec<EnvelopePoint> {
    let part = Workpiece::new(vec![weld.clone()]);
    let point = |x: &f64| {
        let at = Placement { x_m: *x, ..part.placement() };
        let outcome = one(scenario, arm, &part.welds_at(&at)[0]);
        progress();
        EnvelopePoint { x: *x, outcome }
    };
    distances.par_iter().map(point).collect()
}

fn one(scenario: &Scenario<'_>, arm: &RealArm<'_>, weld: &Weld) -> Result<EnvelopeRun, NoFigures> {
    let cell = Cell::new(arm.robot, arm.effects, scenario.planned, Seam::real(weld));
    let cell = cell.map_err(|_| RunError::Cell)?;
    let recording = run(&Scenario { cell: &cell, weld, ..*scenario }, |_| {})?;
    let figures = WeldFigures::of(&recording).ok_or(NoFigures::NotSteady)?;
    let trace = trace(&cell, &recording);
    let collinearity = trace.iter().map(|t| t[2]).fold(f64::INFINITY, f64::min);
    Ok(EnvelopeRun { collinearity, figures, trace })
}

/// Push and angle between the axes of A4 and A6 along the steady part.
fn trace(cell: &Cell, recording: &Recording) -> Vec<[f64; 3]> {
    let steady = recording.rows.iter().filter(|row| row.phase == Phase::Steady);
    let of_row = |row: &trueweld_plant::simulate::RecordRow| {
        let frames = cell.robot.model.frames(&row.link);
        let (a4, a6) = (frames.axis[3], frames.axis[5]);
        let angle = a4.cross(&a6).norm().atan2(a4.dot(&a6).abs());
        [row.path, -row.force_w.z, angle]
    };
    steady.map(of_row).collect()
}

/// Distances, evenly, at which the arm reaches the whole of a weld, within a range of x of B, m.
pub fn reachable(
    scenario: &Scenario<'_>,
    weld: &Weld,
    [low, high]: [f64; 2],
    step: f64,
) -> Vec<f64> {
    const ENVELOPE_PLACES: usize = 21;
    let part = Workpiece::new(vec![weld.clone()]);
    let count = ((high - low) / step + 1e-9).floor() as usize;
    let is_reached = |x: &f64| {
        let weld = &part.welds_at(&Placement { x_m: *x, ..part.placement() })[0];
        let ways: Result<_, (f64, KinematicsError)> =
            ArmAlongSeam::all(scenario.controller_model, scenario.planned, weld, ENVELOPE_PLACES);
        ways.is_ok()
    };
    (0..=count).map(|k| low + k as f64 * step).filter(is_reached).collect()
}
