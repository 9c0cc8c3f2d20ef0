//! Stability of the whole sampled loop at a place of a weld: how far force loop and law are from swinging.
//!
//! The cell is linear about the working tool, sampled exactly (`linear`); controller, law, instruments and their delays are the
//! code that runs (`response`). From what comes back follow the spectral radius and the margins: of each direction with the
//! others closed, and of all at once (`frequency`).

mod frequency;
mod linear;
mod response;

pub use frequency::Margin;
pub use response::{CHANNEL_NAMES, CHANNELS, SETPOINT};

use frequency::Sensitivity;
use linear::{LinearCell, operating_point};
use rayon::prelude::*;
use response::{Frozen, Passing, Run, sensitivity};
use trueweld_core::{JointVector, Wrench};
use trueweld_plant::integrate::rest;
use trueweld_plant::simulate::{RunError, Scenario, Seam, start_angles};

/// Where what is left of an impulse is lost in rounding, of its largest.
const ROUNDING: f64 = 2e-6;

/// Peak to peak of a translation that the noise of no law makes, m.
const SWING: f64 = 5e-4;

/// The loop at one place.
#[derive(Debug, Clone, PartialEq)]
pub struct Margins {
    /// Path position, m.
    pub path: f64,
    /// Largest magnitude of a closed-loop pole that an impulse shows; below 1 the loop is stable.
    pub spectral_radius: f64,
    /// Of every channel in the order of [`CHANNEL_NAMES`]; `None` where the loop is not stable.
    pub channels: Option<[Margin; CHANNELS]>,
    /// Disk margin of corrections and force all at once, and of all drives at once; 0 where the loop is not stable.
    pub disk: [f64; 2],
}

/// The loop at so many places of the weld, from its start to its end, on all cores.
///
/// # Errors
/// [`RunError`] where the seam cannot be followed or the law cannot be built.
pub fn margin_map(scenario: &Scenario<'_>, places: usize) -> Result<Vec<Margins>, RunError> {
    let seam = Seam::of(scenario.weld);
    let last = places.saturating_sub(1).max(1);
    let mut near = start_angles(&scenario.cell.robot.model, &seam)?;
    let mut along = Vec::with_capacity(places);
    for k in 0..places {
        let path = seam.length * k as f64 / last as f64;
        let reach = |_| RunError::Reach { path, reason: "out of reach" };
        near = scenario.cell.robot.model.track(&seam.nominal(path), &near).map_err(reach)?;
        along.push((path, near));
    }
    along.into_par_iter().map(|(path, near)| margins(scenario, path, &near)).collect()
}

/// The loop at a path position, m, in the posture near `near`. The cell's process should be without ripple.
///
/// # Errors
/// As [`margin_map`].
pub fn margins(scenario: &Scenario<'_>, path: f64, near: &JointVector<f64>) -> Result<Margins, RunError> {
    let frozen = frozen(scenario, path, near)?;
    let rest = frozen.run(None)?;
    let impulses = (0..CHANNELS).map(|c| frozen.run(Some(c))).collect::<Result<Vec<_>, _>>()?;
    if rest.away || impulses.iter().any(|run| run.away) {
        return Ok(unstable(path, f64::INFINITY));
    }
    let responses = sensitivity(&rest, &impulses);
    let period = scenario.control.period;
    let spectral_radius = responses.iter().map(|r| radius(r, period)).fold(0.0, f64::max);
    if spectral_radius >= 1.0 || swings(&rest) {
        return Ok(unstable(path, spectral_radius.max(1.0)));
    }
    let sensitivity = Sensitivity::of(&responses, period);
    let channels = std::array::from_fn(|c| sensitivity.margin(c));
    Ok(Margins {
        path,
        spectral_radius,
        channels: Some(channels),
        disk: [0, SETPOINT].map(|first| sensitivity.disk(first)),
    })
}

fn unstable(path: f64, spectral_radius: f64) -> Margins {
    Margins { path, spectral_radius, channels: None, disk: [0.0; 2] }
}

fn frozen<'a>(scenario: &'a Scenario<'a>, path: f64, near: &JointVector<f64>) -> Result<Frozen<'a>, RunError> {
    let Scenario { cell, weld, control, plant_step, .. } = *scenario;
    let seam = Seam::of(weld);
    let substeps = (control.period / plant_step - 1e-9).ceil().max(1.0) as usize;
    let step = control.period / substeps as f64;
    let reach = || RunError::Reach { path, reason: "no posture welds there" };
    let nominal = seam.nominal(path);
    let point = operating_point(cell, &nominal, weld.force, weld.feed, near).ok_or_else(reach)?;
    let linear = LinearCell::about(cell, &point, step).ok_or_else(reach)?;
    // As taught under gravity with the tool free, but pressed in already: the force loop is at work.
    let to_w = seam.b_from_w.rotation.transpose();
    let encoders = |motor: &JointVector<f64>| nominal.error_to(&cell.robot.model.forward(motor)).rotated(&to_w);
    let link = cell.robot.model.track(&nominal, near).map_err(|_| reach())?;
    let mut taught = encoders(&rest::motors_for(cell, &link, &Wrench::zero()));
    taught.linear.z = encoders(&point.drives().motor).linear.z;
    Ok(Frozen { scenario, linear, path, taught, step, substeps })
}

/// True where the loop does not come to rest but goes on swinging, held by a limit.
fn swings(rest: &Run) -> bool {
    let quarter = rest.rows.len() / 4;
    let [before, last] = [2, 3].map(|k| &rest.rows[k * quarter..(k + 1) * quarter]);
    (0..2).any(|i| {
        let range = |rows: &[Passing]| {
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let (low, high) = rows.iter().fold(ends, |(low, high), r| (low.min(r[i]), high.max(r[i])));
            high - low
        };
        range(last) > SWING.max(0.7 * range(before))
    })
}

/// How much of an impulse is left after a period, in the long run: the last two seconds in which it stands above rounding.
fn radius(response: &[Passing], period: f64) -> f64 {
    let second = (1.0 / period).round() as usize;
    let size = |rows: &[Passing]| -> Vec<f64> {
        (0..CHANNELS).map(|i| rows.iter().map(|r| r[i].abs()).fold(0.0, f64::max)).collect()
    };
    let whole = size(response);
    // Each channel by its own largest, so that metres and newtons count alike.
    let relative = |rows: &[Passing]| {
        size(rows).iter().zip(&whole).map(|(s, w)| if *w > 0.0 { s / w } else { 0.0 }).fold(0.0, f64::max)
    };
    let seconds: Vec<f64> = response.chunks_exact(second).map(relative).collect();
    let above = seconds.iter().take_while(|s| **s > ROUNDING).count();
    match above {
        0..=2 => 0.0,
        n => {
            let from = (n - 1) / 2;
            (seconds[n - 1] / seconds[from]).powf(1.0 / ((n - 1 - from) * second) as f64)
        }
    }
}
