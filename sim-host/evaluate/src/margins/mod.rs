//! Stability of the whole sampled loop at a place of a weld: how far force loop and law are from
//! swinging.
//!
//! The cell is linear about the working tool, sampled exactly (`linear`); controller, law,
//! instruments and their delays are the code that runs (`response`). From what comes back follow
//! the spectral radius and the margins: of each direction with the others closed, and of all at
//! once (`frequency`).

mod frequency;
mod linear;
mod passivity;
mod response;

pub use frequency::Margin;
pub use passivity::Passivity;
pub use response::{CHANNEL_NAMES, CHANNELS, SETPOINT};

use crate::figure::FigureOf;
use frequency::Sensitivity;
use linear::{LinearCell, operating_point};
use rayon::prelude::*;
use response::{Frozen, LoopSignals, Run, sensitivity};
use serde::Serialize;
use trueweld_plant::simulate::{
    RunError, Scenario, Seam, Taught, encoder_offset, real_inverse_near, start_angles,
};

/// Where what is left of an impulse is lost in rounding, of its largest.
const ROUNDING: f64 = 2e-6;

/// Peak to peak of a translation, m, and of the force error, N, that noise alone does not make.
const SWING: [(usize, f64); 3] = [(0, 5e-4), (1, 5e-4), (5, 1000.0)];

/// The loop at one place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Margins {
    /// Path position, m.
    pub path: f64,
    /// Largest magnitude of a closed-loop pole that an impulse shows; below 1 the loop is stable.
    pub spectral_radius: f64,
    /// It comes to rest at a limit, or goes to and fro between limits: what an impulse shows there
    /// is the limit and not the loop, which counts as not stable.
    pub held: bool,
    /// Of every channel in the order of [`CHANNEL_NAMES`]; `None` where the loop is not stable.
    pub channels: Option<[Margin; CHANNELS]>,
    /// Disk margin of corrections and force all at once, and of all drives at once; 0 where the
    /// loop is not stable.
    pub disk: [f64; 2],
    /// Of the position loop, at the tool.
    pub passivity: Passivity,
}

/// The loop at so many places of the weld, from its start to its end, on all cores.
///
/// # Errors
/// As [`margins`].
pub fn margin_map(scenario: &Scenario<'_>, places: usize) -> Result<Vec<Margins>, RunError> {
    let length = Seam::of(scenario.weld).length;
    let last = places.saturating_sub(1).max(1);
    (0..places)
        .into_par_iter()
        .map(|k| margins(scenario, length * k as f64 / last as f64))
        .collect()
}

/// The loop at a path position, m, in the posture that the weld has there. The cell's process must
/// be without ripple.
///
/// # Errors
/// [`RunError`] where the seam cannot be followed or the law cannot be built.
pub fn margins(scenario: &Scenario<'_>, path: f64) -> Result<Margins, RunError> {
    let frozen = frozen(scenario, path)?;
    let rest = frozen.run(None)?;
    let impulses = (0..CHANNELS).map(|c| frozen.run(Some(c))).collect::<Result<Vec<_>, _>>()?;
    if rest.away || impulses.iter().any(|run| run.away) {
        return Ok(frozen.unstable(f64::INFINITY));
    }
    if rest.held {
        return Ok(Margins { held: true, ..frozen.unstable(f64::INFINITY) });
    }
    let responses = sensitivity(&rest, &impulses);
    let period = scenario.control.period;
    let spectral_radius = responses.iter().map(|r| radius(r, period)).fold(0.0, f64::max);
    if spectral_radius >= 1.0 || swings(&rest) {
        return Ok(frozen.unstable(spectral_radius.max(1.0)));
    }
    let sensitivity = Sensitivity::of(&responses, period);
    let channels = std::array::from_fn(|c| sensitivity.margin(c));
    Ok(Margins {
        path,
        spectral_radius,
        held: false,
        channels: Some(channels),
        disk: [0, SETPOINT].map(|first| sensitivity.disk(first)),
        passivity: frozen.passivity(),
    })
}

/// A margin, and the channel that it is of.
pub type LeastMargin = (f64, &'static str);

/// Margins that may be asked for: of corrections and force loop, then of the drives.
pub static MARGIN_FIGURES: [FigureOf<Margins, LeastMargin>; 10] = [
    FigureOf::new("gain_margin", "gain margin", "1", |m| m.least(0, gain)),
    FigureOf::new("phase_margin_rad", "phase margin", "rad", |m| m.least(0, |c| c.phase)),
    FigureOf::new("modulus_margin", "modulus margin", "1", |m| m.least(0, |c| c.modulus)),
    FigureOf::new("delay_margin_s", "delay margin", "s", |m| m.least(0, |c| c.delay)),
    FigureOf::new("disk_margin", "disk margin, all at once", "1", |m| {
        (m.disk[0], "all of corrections and force")
    }),
    FigureOf::new("drive_gain_margin", "gain margin, drives", "1", |m| m.least(SETPOINT, gain)),
    FigureOf::new("drive_phase_margin_rad", "phase margin, drives", "rad", |m| {
        m.least(SETPOINT, |c| c.phase)
    }),
    FigureOf::new("drive_modulus_margin", "modulus margin, drives", "1", |m| {
        m.least(SETPOINT, |c| c.modulus)
    }),
    FigureOf::new("drive_delay_margin_s", "delay margin, drives", "s", |m| {
        m.least(SETPOINT, |c| c.delay)
    }),
    FigureOf::new("drive_disk_margin", "disk margin, all drives at once", "1", |m| {
        (m.disk[1], "all drives")
    }),
];

fn gain(margin: &Margin) -> f64 {
    margin.gain.min(margin.fall)
}

impl Margins {
    /// The least of six channels from `first` on, and of which it is. Nothing where the loop is not
    /// stable.
    fn least(&self, first: usize, of: fn(&Margin) -> f64) -> LeastMargin {
        let Some(channels) = &self.channels else {
            return (0.0, "the loop");
        };
        let group = CHANNEL_NAMES.iter().zip(channels).skip(first).take(SETPOINT);
        let each = group.map(|(name, margin)| (of(margin), *name));
        each.fold(
            (f64::INFINITY, "none"),
            |least, next| if next.0 < least.0 { next } else { least },
        )
    }
}

impl Frozen<'_> {
    fn unstable(&self, spectral_radius: f64) -> Margins {
        let passivity = self.passivity();
        Margins {
            path: self.path,
            spectral_radius,
            held: false,
            channels: None,
            disk: [0.0; 2],
            passivity,
        }
    }

    fn passivity(&self) -> Passivity {
        let Scenario { cell, control, controller, .. } = self.scenario;
        let gains = controller.joint_gains(control);
        let model = &cell.robot.model;
        let frames = model.frames(&self.linear.point.drives().link);
        let axis = cell.b_from_w.rotation.column(2).into_owned();
        Passivity::of(&frames, &axis, gains, &model.parameters().friction.viscous, control.period)
    }
}

fn frozen<'a>(scenario: &'a Scenario<'a>, path: f64) -> Result<Frozen<'a>, RunError> {
    /// Between the start, whose branch is known, and the place.
    const STEPS: usize = 100;
    let Scenario { cell, weld, .. } = *scenario;
    let seam = Seam::of(weld);
    let (model, planned) = (&cell.robot.model, scenario.controller_model);
    let (_, step) = scenario.plant_steps();
    let reach = || RunError::Reach { path, reason: "no posture welds there" };
    let mut near = start_angles(planned, &seam)?;
    for k in 1..=STEPS {
        near = planned
            .inverse_near(&seam.nominal(path * k as f64 / STEPS as f64), &near)
            .map_err(|_| reach())?;
    }
    let nominal = seam.nominal(path);
    near = real_inverse_near(model, planned, &nominal, &near).map_err(|_| reach())?;
    let point =
        operating_point(cell, planned, &nominal, weld.force, weld.feed, &near).ok_or_else(reach)?;
    let linear = LinearCell::about(cell, &point, step).ok_or_else(reach)?;
    // Taught under gravity with the tool free, but as deep as the force loop presses it.
    let mut taught = Taught::at(cell, planned, &seam, path, &near).offset;
    taught.linear.z = encoder_offset(planned, &seam, path, &point.drives().motor).linear.z;
    Ok(Frozen { scenario, linear, path, taught })
}

/// True where the loop does not come to rest but goes on swinging, held by a limit.
fn swings(rest: &Run) -> bool {
    let quarter = rest.rows.len() / 4;
    let [before, last] = [2, 3].map(|k| &rest.rows[k * quarter..(k + 1) * quarter]);
    SWING.into_iter().any(|(i, noise)| {
        let range = |rows: &[LoopSignals]| {
            let ends = (f64::INFINITY, f64::NEG_INFINITY);
            let (low, high) =
                rows.iter().fold(ends, |(low, high), r| (low.min(r[i]), high.max(r[i])));
            high - low
        };
        range(last) > (0.7 * range(before)).max(noise)
    })
}

/// How much of an impulse is left after a period, in the long run: over the later half of the time
/// in which it stands above rounding.
fn radius(response: &[LoopSignals], period: f64) -> f64 {
    let second = (1.0 / period).round() as usize;
    let size = |rows: &[LoopSignals]| -> Vec<f64> {
        (0..CHANNELS).map(|i| rows.iter().map(|r| r[i].abs()).fold(0.0, f64::max)).collect()
    };
    let whole = size(response);
    // Each channel by its own largest, so that metres and newtons count alike.
    let relative = |rows: &[LoopSignals]| {
        size(rows)
            .iter()
            .zip(&whole)
            .map(|(s, w)| if *w > 0.0 { s / w } else { 0.0 })
            .fold(0.0, f64::max)
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
