//! Stability of the whole sampled loop at a place of a weld: how far force loop and law are from
//! swinging.
//!
//! Friction is a sector: the loop is looked at with viscous friction alone, with the slope at each
//! drive's speed, and with the largest slope that a vibration sees (`friction`). Where some of these
//! are stable and others are not, what is between is a limit cycle (`cycle`).
//!
//! The cell is linear about the working tool, sampled exactly (`linear`); controller, law,
//! instruments and their delays are the code that runs (`response`). From what comes back follow
//! the spectral radius and the margins: of each direction with the others closed, and of all at
//! once (`frequency`).

mod cycle;
mod decay;
mod frequency;
mod friction;
mod linear;
mod passivity;
mod radius;
mod response;

pub use cycle::{LimitCycle, limit_cycles};
pub use frequency::Margin;
pub use friction::FrictionSlope;
pub use linear::OperatingPoint;
pub use passivity::Passivity;
pub use response::{CHANNEL_NAMES, Kick, LOOP_CHANNELS, LoopSignals, Run, SETPOINT};

use crate::figure::FigureOf;
use frequency::SensitivityFunction;
use linear::{LinearCell, operating_point};
use radius::{is_undecided, radius, radius_of_longer};
use rayon::prelude::*;
use response::{ANSWER, Answer, Frozen, LONGER_ANSWER};
use schemars::JsonSchema;
use serde::{Serialize, Serializer};
use std::collections::BTreeMap;
use trueweld_core::JointVector;
use trueweld_plant::cell::State;
use trueweld_plant::simulate::{
    RunError, Scenario, Seam, Taught, TaughtOffset, encoder_offset, real_inverse_near, start_angles,
};

/// Peak to peak of a translation, m, and of the force error, N, that noise alone does not make.
const SWING: [(usize, f64); 3] = [(0, 5e-4), (1, 5e-4), (5, 1000.0)];

/// What margins are of.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Condition {
    /// Where in the weld.
    #[serde(flatten)]
    pub at: OperatingPoint,
    /// What the drives' friction is taken for: `viscous`, `at-speed` or `full`.
    pub friction: FrictionSlope,
    /// Index of the drawn cell; `null` for the nominal one.
    pub draw: Option<u64>,
}

/// The loop at one place of the weld, with one slope of friction.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "MarginPlace", deny_unknown_fields)]
pub struct Margins {
    /// What they are of.
    #[serde(flatten)]
    pub of: Condition,
    // As an impulse shows it; below 1 the loop is stable.
    /// Largest magnitude of a closed-loop pole; `null` where the loop runs away.
    #[schemars(with = "Option<f64>")]
    pub spectral_radius: f64,
    // It comes to rest at a limit, or goes to and fro between limits: what an impulse shows there is
    // the limit and not the loop, which counts as not stable.
    /// Whether only a limit holds the loop.
    pub held_at_a_limit: bool,
    // In the order of [`CHANNEL_NAMES`].
    /// Margins of every channel by its name; `null` where the loop is not stable.
    #[serde(serialize_with = "by_channel")]
    #[schemars(with = "Option<BTreeMap<String, Margin>>")]
    pub channels: Option<[Margin; LOOP_CHANNELS]>,
    // 0 where the loop is not stable.
    /// Disk margin of corrections and force all at once.
    pub disk: f64,
    /// Disk margin of all drives at once.
    pub drive_disk: f64,
    /// Damping of the position loop at the tool.
    pub passivity: Passivity,
}

fn by_channel<S: Serializer>(
    channels: &Option<[Margin; LOOP_CHANNELS]>,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let named = channels.as_ref().map(|all| CHANNEL_NAMES.iter().zip(all));
    named.map(|named| named.collect::<BTreeMap<_, _>>()).serialize(serializer)
}

/// The loop along the whole weld, ramps included, for every slope of friction at each operating
/// point, on all cores. See [`OperatingPoint::along`].
///
/// # Errors
/// As [`margins`].
pub fn margin_map(scenario: &Scenario<'_>, places: usize) -> Result<Vec<Margins>, RunError> {
    let points = OperatingPoint::along(scenario.weld, places);
    let each: Result<Vec<_>, _> =
        points.par_iter().map(|at| sector_margins(scenario, at)).collect();
    Ok(each?.concat())
}

/// The loop at an operating point for every slope of friction, from viscous only to all of it.
///
/// # Errors
/// As [`margins`].
pub fn sector_margins(
    scenario: &Scenario<'_>,
    at: &OperatingPoint,
) -> Result<Vec<Margins>, RunError> {
    // All drives of a tool that stands are at rest, where the slope at their speed is all of it.
    let distinct = |slope: &&FrictionSlope| at.feed > 0.0 || **slope != FrictionSlope::AtSpeed;
    FrictionSlope::ALL.iter().filter(distinct).map(|slope| margins(scenario, at, *slope)).collect()
}

/// The loop at an operating point, in the posture that the weld has there, with friction taken for
/// a slope. The cell's process must be without ripple.
///
/// # Errors
/// [`RunError`] where the seam cannot be followed or the law cannot be built.
pub fn margins(
    scenario: &Scenario<'_>,
    at: &OperatingPoint,
    friction: FrictionSlope,
) -> Result<Margins, RunError> {
    let frozen = frozen(scenario, at, |point| friction.of(scenario.cell, point))?;
    let period = scenario.control.period;
    let mut answer = frozen.answer(ANSWER)?;
    let mut spectral_radius = answer.judged(|responses| radius(responses, period));
    if spectral_radius.is_finite() && is_undecided(spectral_radius, period) {
        answer = frozen.answer(LONGER_ANSWER)?;
        let short = (ANSWER / period) as usize;
        spectral_radius = answer.judged(|responses| radius_of_longer(responses, short, period));
    }
    let Answer { rest, responses, .. } = &answer;
    let mut margins = Margins {
        of: Condition { at: *at, friction, draw: None },
        spectral_radius,
        held_at_a_limit: false,
        channels: None,
        disk: 0.0,
        drive_disk: 0.0,
        passivity: frozen.passivity(),
    };
    if spectral_radius >= 1.0 || swings(rest) {
        margins.spectral_radius = spectral_radius.max(1.0);
        margins.held_at_a_limit = !rest.away && rest.held;
    } else {
        let sensitivity = SensitivityFunction::of(responses, spectral_radius, period);
        margins.channels = Some(std::array::from_fn(|c| sensitivity.margin(c)));
        [margins.disk, margins.drive_disk] = sensitivity.disks();
    }
    Ok(margins)
}

/// A run in time of the cell as it is, along its seam from an operating point on, with a kick:
/// what linear margins are checked by. The law keeps what it learns from weld to weld.
///
/// # Errors
/// [`RunError`] where the seam cannot be followed, the law cannot be built, or the state leaves the
/// finite numbers.
pub fn run_in_time(
    scenario: &Scenario<'_>,
    from: &OperatingPoint,
    kick: &Kick,
) -> Result<Run, RunError> {
    let at_speed = |point: &State| FrictionSlope::AtSpeed.of(scenario.cell, point);
    frozen(scenario, from, at_speed)?.run_in_time(kick)
}

/// A run of the linear loop at an operating point, with a kick.
///
/// # Errors
/// As [`margins`].
pub fn run_linear(
    scenario: &Scenario<'_>,
    at: &OperatingPoint,
    friction: FrictionSlope,
    kick: &Kick,
) -> Result<Run, RunError> {
    frozen(scenario, at, |point| friction.of(scenario.cell, point))?.run(kick)
}

/// A margin, and the channel that it is of.
pub type LeastMargin = (f64, &'static str);

/// Margins that may be asked for: of corrections and force loop, then of the drives, then of the
/// drives at work alone, with friction at each drive's speed.
pub static MARGIN_FIGURES: [FigureOf<Margins, LeastMargin>; 14] = [
    FigureOf::new("gain_margin", "gain margin", "1", |m| m.least(0, gain)),
    FigureOf::new("phase_margin_rad", "phase margin", "rad", |m| m.least(0, |c| c.phase_rad)),
    FigureOf::new("modulus_margin", "modulus margin", "1", |m| m.least(0, |c| c.modulus)),
    FigureOf::new("delay_margin_s", "delay margin", "s", |m| m.least(0, |c| c.delay_s)),
    FigureOf::new("disk_margin", "disk margin, all at once", "1", |m| {
        (m.disk, "all of corrections and force")
    }),
    FigureOf::new("drive_gain_margin", "gain margin, drives", "1", |m| m.least(SETPOINT, gain)),
    FigureOf::new("drive_phase_margin_rad", "phase margin, drives", "rad", |m| {
        m.least(SETPOINT, |c| c.phase_rad)
    }),
    FigureOf::new("drive_modulus_margin", "modulus margin, drives", "1", |m| {
        m.least(SETPOINT, |c| c.modulus)
    }),
    FigureOf::new("drive_delay_margin_s", "delay margin, drives", "s", |m| {
        m.least(SETPOINT, |c| c.delay_s)
    }),
    FigureOf::new("drive_disk_margin", "disk margin, all drives at once", "1", |m| {
        (m.drive_disk, "all drives")
    }),
    FigureOf::new("drive_gain_margin_at_speed", "gain margin, drives at speed", "1", |m| {
        m.at_work(|| m.least(SETPOINT, gain))
    }),
    FigureOf::new("drive_phase_margin_at_speed_rad", "phase margin, drives at speed", "rad", |m| {
        m.at_work(|| m.least(SETPOINT, |c| c.phase_rad))
    }),
    FigureOf::new("drive_modulus_margin_at_speed", "modulus margin, drives at speed", "1", |m| {
        m.at_work(|| m.least(SETPOINT, |c| c.modulus))
    }),
    FigureOf::new("drive_disk_margin_at_speed", "disk margin, all drives at speed", "1", |m| {
        m.at_work(|| (m.drive_disk, "all drives"))
    }),
];

fn gain(margin: &Margin) -> f64 {
    margin.gain.min(margin.fall)
}

impl Margins {
    /// A margin of the steady part with friction at each drive's speed; no limit under any other
    /// condition.
    fn at_work(&self, of: impl FnOnce() -> LeastMargin) -> LeastMargin {
        let is = self.of.friction == FrictionSlope::AtSpeed && !self.of.at.ramp;
        if is { of() } else { (f64::INFINITY, "none") }
    }

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
    fn passivity(&self) -> Passivity {
        let Scenario { cell, control, controller, .. } = self.scenario;
        // The loop that is frozen here was built from them.
        let Some(gains) = controller.joint_gains(control) else {
            return Passivity { needed_ns_m: f64::NAN, there_ns_m: f64::NAN };
        };
        let model = &cell.robot.model;
        let frames = model.frames(&self.linear.point.drives().link);
        let axis = Seam::of(self.scenario.weld).axes(self.at.path).column(2).into_owned();
        Passivity::of(&frames, &axis, gains, &model.parameters().friction.viscous, control.period)
    }
}

/// The loop at an operating point with slopes of the drives' friction, N·m·s/rad, that follow from
/// the state there.
fn frozen<'a>(
    scenario: &'a Scenario<'a>,
    at: &OperatingPoint,
    friction: impl Fn(&State) -> JointVector<f64>,
) -> Result<Frozen<'a>, RunError> {
    /// Between the start, whose branch is known, and the place.
    const BRANCH_STEPS: usize = 100;
    let Scenario { cell, weld, .. } = *scenario;
    let (seam, path) = (Seam::of(weld), at.path);
    let (model, planned) = (&cell.robot.model, scenario.controller_model);
    let (_, step) = scenario.plant_steps();
    let reach = || RunError::Reach { path, reason: "no posture welds there" };
    let mut near = start_angles(planned, &seam)?;
    for k in 1..=BRANCH_STEPS {
        near = planned
            .inverse_near(&seam.nominal(path * k as f64 / BRANCH_STEPS as f64), &near)
            .map_err(|_| reach())?;
    }
    let nominal = seam.nominal(path);
    near = real_inverse_near(model, planned, &nominal, &near).map_err(|_| reach())?;
    let point = operating_point(cell, planned, &nominal, at, &near).ok_or_else(reach)?;
    let linear = LinearCell::about(cell, &point, &friction(&point), step).ok_or_else(reach)?;
    // Taught under gravity with the tool free, but as deep as the force loop presses it.
    let mut taught = Taught::at(cell, planned, &seam, path, &near).offset;
    taught.linear.z = encoder_offset(planned, &seam, path, &point.drives().motor).linear.z;
    let taught = TaughtOffset::new(&taught, &seam.axes(path), taught.linear.z);
    Ok(Frozen { scenario, linear, at: *at, taught })
}

/// True where the loop does not come to rest but goes on swinging, held by a limit. What only comes
/// to rest slowly passes its mean once.
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
        let mean = last.iter().map(|r| r[i]).sum::<f64>() / quarter.max(1) as f64;
        let passes = last.windows(2).filter(|r| (r[0][i] > mean) != (r[1][i] > mean)).count();
        passes > 1 && range(last) > (0.7 * range(before)).max(noise)
    })
}
