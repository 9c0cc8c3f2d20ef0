//! Certification of a compensation law: seeded Monte Carlo over what is not known of a cell, and what it proves.
//!
//! Every trial draws a cell from the uncertainties of the requirements, welds it with the law that still believes in the nominal
//! one, and keeps the figures of the last pass's steady part. A requirement is met where the probability of a weld beyond its limit
//! is at most what is allowed, with the confidence asked for, by the exact binomial bound ([`Rate::at_most`]). A run that comes to
//! no end, or never reaches its steady part, is beyond every limit.
//!
//! Trial k depends on seed and k alone: not on how many there are, who computes them, or in which order.

use crate::{Rate, WeldFigures};
use nalgebra::SVector;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use trueweld_core::{JointVector, Robot};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::{At, Effect, Kind};
use trueweld_plant::input::{LIMITS, Process, Requirements, Sensors, Uncertainty};
use trueweld_plant::simulate::{RunError, Scenario, Seam, run_passes};

/// What a cell turned out to be, relative to what it is believed to be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Draw {
    /// Factor on every joint's stiffness.
    pub stiffness: [f64; 6],
    /// Factors on depth stiffness and damping, feed drag, lateral damping, lateral stiffness, lateral ratio.
    pub process: [f64; 5],
    /// Factor on the ripple's amplitude, and what is added to its phases, rad.
    pub ripple: [f64; 2],
    /// What the force sensor shows along x and y of T per axial force.
    pub crosstalk: [f64; 2],
    /// Delay of force sensor and seam sensor, control periods.
    pub delay: f64,
    /// Seed of the instruments' noise.
    pub noise: u64,
}

impl Draw {
    /// The cell of trial `index`.
    pub fn new(uncertainty: &Uncertainty, seed: u64, index: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(index);
        let mut within = |half: f64| half * (2.0 * random.random::<f64>() - 1.0);
        let u = uncertainty;
        Self {
            stiffness: [(); 6].map(|()| 1.0 + within(u.stiffness)),
            process: [(); 5].map(|()| 1.0 + within(u.process)),
            ripple: [1.0 + within(u.ripple), within(std::f64::consts::PI)],
            crosstalk: [(); 2].map(|()| within(u.crosstalk)),
            delay: 0.5 * (u.delay[0] + u.delay[1]) + within(0.5 * (u.delay[1] - u.delay[0])),
            noise: random.random(),
        }
    }

    /// The cell as it is believed to be, with instruments without cross-talk and as late as their file says.
    pub fn nominal(noise: u64) -> Self {
        Self { stiffness: [1.0; 6], process: [1.0; 5], ripple: [1.0, 0.0], crosstalk: [0.0; 2], delay: 0.0, noise }
    }

    fn process(&self, nominal: &Process) -> Process {
        let [depth, drag, damping, stiffness, ratio] = self.process;
        let mut process = nominal.clone();
        process.depth_stiffness *= depth;
        process.depth_damping *= depth;
        process.feed_drag *= drag;
        process.lateral_damping *= damping;
        process.lateral_stiffness *= stiffness;
        process.lateral_ratio *= ratio;
        for line in &mut process.ripple {
            line.axial *= self.ripple[0];
            line.in_plane *= self.ripple[0];
            line.phase += self.ripple[1];
        }
        process
    }

    fn sensors(&self, nominal: &Sensors, period: f64) -> Sensors {
        let mut sensors = nominal.clone();
        let delay = self.delay * period;
        sensors.force.delay = sensors.force.delay.max(delay);
        if let Some(seam) = &mut sensors.seam {
            seam.delay = seam.delay.max(delay);
        }
        sensors
    }
}

/// Figures of one trial, in the order of [`LIMITS`]; a reason where there are none.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Trial {
    /// Which.
    pub index: u64,
    /// The cell.
    pub draw: Draw,
    /// The figures of the last pass, SI units.
    pub figures: Option<[f64; LIMITS.len()]>,
    /// Why there are none.
    pub failed: Option<String>,
}

/// What is to be certified.
#[derive(Debug, Clone, Copy)]
pub struct Certification<'a> {
    /// The nominal scenario: law, weld, gains, instruments. Its cell is not used.
    pub scenario: Scenario<'a>,
    /// The robot as it is believed to be.
    pub robot: &'a Robot<f64>,
    /// Requirements and uncertainties.
    pub requirements: &'a Requirements,
    /// Welds of one seam in a trial, the law kept; the last one counts.
    pub passes: usize,
    /// Of the draws.
    pub seed: u64,
}

impl Certification<'_> {
    /// Runs one trial.
    pub fn trial(&self, index: u64) -> Trial {
        let draw = Draw::new(&self.requirements.uncertainty, self.seed, index);
        self.weld(index, draw)
    }

    /// Runs the cell as it is believed to be.
    pub fn nominal(&self) -> Trial {
        self.weld(0, Draw::nominal(self.scenario.seed))
    }

    fn weld(&self, index: u64, draw: Draw) -> Trial {
        let (figures, failed) = match self.figures(&draw) {
            Ok(Some(figures)) => (Some(figures), None),
            Ok(None) => (None, Some("the steady part is not reached".to_owned())),
            Err(error) => (None, Some(error.to_string())),
        };
        Trial { index, draw, figures, failed }
    }

    fn figures(&self, draw: &Draw) -> Result<Option<[f64; LIMITS.len()]>, RunError> {
        let scenario = self.scenario;
        let factor: JointVector<f64> = SVector::from(draw.stiffness);
        let robot = self.robot.with_stiffness_scaled(&factor).map_err(|_| RunError::Cell)?;
        let kind = Kind::of("force-crosstalk").ok_or(RunError::Cell)?;
        let crosstalk = Effect { kind, at: At::Cell, values: draw.crosstalk.to_vec() };
        let process = draw.process(scenario.planned);
        let cell =
            Cell::new(&robot, &[crosstalk], &process, Seam::of(scenario.weld).b_from_w).map_err(|_| RunError::Cell)?;
        let sensors = draw.sensors(scenario.sensors, scenario.control.period);
        let scenario = Scenario { cell: &cell, sensors: &sensors, seed: draw.noise, ..scenario };
        let recording = run_passes(&scenario, self.passes, |_| {})?;
        Ok(WeldFigures::of(&recording).map(|f| limited(&f)))
    }
}

/// Figures that may be limited, in the order of [`LIMITS`].
fn limited(f: &WeldFigures) -> [f64; LIMITS.len()] {
    // Depth is what the push makes it; what may be limited is how far it wanders from its mean.
    let depth = (f.depth.rms.powi(2) - f.depth.mean.powi(2)).max(0.0).sqrt();
    let [correction, turned] = f.correction;
    [
        f.lateral.rms,
        f.lateral.max_abs,
        depth,
        f.tilt.rms,
        f.side_tilt.rms,
        f.travel_angle.rms,
        f.force.error_rms,
        f.lateral_before,
        correction,
        turned,
    ]
}

/// One requirement, judged.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Requirement {
    /// Its key.
    pub name: &'static str,
    /// The limit, SI units.
    pub limit: f64,
    /// The figure that all but the allowed share of the trials stay within.
    pub achieved: f64,
    /// Trials beyond the limit.
    pub beyond: usize,
    /// The probability of a weld beyond the limit is at most this, with the confidence asked for.
    pub failure_probability: f64,
    /// That confidence.
    pub confidence: f64,
    /// True where that is no more than is allowed.
    pub pass: bool,
}

/// Judges trials. Nothing passes without trials enough to show it.
pub fn judge(requirements: &Requirements, trials: &[Trial]) -> Vec<Requirement> {
    let limited = LIMITS.iter().zip(&requirements.limits).enumerate();
    limited
        .filter_map(|(k, (name, limit))| {
            let limit = (*limit)?;
            let figure = |t: &Trial| t.figures.map_or(f64::INFINITY, |f| f[k]);
            let beyond = Rate::of(trials, |t| figure(t).is_nan() || figure(t) > limit);
            let mut sorted: Vec<f64> = trials.iter().map(figure).collect();
            sorted.sort_by(f64::total_cmp);
            let within = ((1.0 - requirements.failure_probability) * sorted.len() as f64).ceil() as usize;
            let achieved = sorted.get(within.saturating_sub(1)).copied().unwrap_or(f64::INFINITY);
            let bound = beyond.at_most(requirements.confidence);
            Some(Requirement {
                name,
                limit,
                achieved,
                beyond: beyond.hits,
                failure_probability: bound,
                confidence: requirements.confidence,
                pass: bound <= requirements.failure_probability,
            })
        })
        .collect()
}
