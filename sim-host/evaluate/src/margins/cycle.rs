//! Limit cycles that the drives' friction makes of an unstable loop, or of a stable one: harmonic
//! balance with the describing function of friction.
//!
//! A vibration of the drives with amplitudes aᵢ = α |vᵢ|, v the shape of the loop's slowest mode,
//! sees friction as the slopes Nᵢ(aᵢ). It neither grows nor dies where the mode's pole λ(α) is on
//! the unit circle; where λ falls through it as α grows, the vibration comes to that size from
//! either side.

use super::decay::Modes;
use super::friction::{FrictionSlope, slopes};
use super::response::{Kick, Run};
use super::{LOOP_CHANNELS, OperatingPoint, SETPOINT, frozen};
use nalgebra::{Complex, DMatrix};
use serde::Serialize;
use std::f64::consts::TAU;
use trueweld_core::JointVector;
use trueweld_plant::cell::State;
use trueweld_plant::simulate::{RunError, Scenario};

/// Amplitudes of the drive that vibrates most at which the balance is looked at, rad/s, evenly in
/// their logarithm.
const CYCLE_AMPLITUDES: (f64, f64, usize) = (1e-4, 0.1, 31);

/// Halvings of an interval in which a limit cycle is.
const CYCLE_HALVINGS: usize = 8;

/// Modes that are followed, the slowest to die first, and how near each other two limit cycles are
/// the same.
const MODES: usize = 3;
const EQUAL_CYCLE_SHARE: f64 = 0.02;

/// Kick of every drive, N·m, and when it comes and how long it is watched, s: later, an unstable
/// loop would be at its limits.
const KICK: f64 = 1.0;
const WATCHED: [f64; 2] = [2.0, 3.0];

/// Slowest vibration that is looked for, Hz: modes that turn less than some times while they are
/// watched are not told apart.
const VIBRATION_FREQUENCY_MIN: f64 = 2.0;

/// Copies of the signals, one period later each, that tell modes apart, and the share of the samples
/// below which a direction is rounding.
const LATER: usize = 8;
const CYCLE_RANK_SHARE: f64 = 1e-7;

/// A vibration that friction keeps at its size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LimitCycle {
    /// Frequency, Hz.
    pub hz: f64,
    /// Amplitude of the drives' rates, rad/s.
    pub rate: [f64; 6],
    /// Smaller ones grow to it and larger ones die down to it; otherwise it is the size below which
    /// a vibration dies and above which it grows.
    pub attracts: bool,
}

/// The limit cycles about an operating point of the modes that are slowest to die, or first to grow,
/// for small vibrations: mode by mode in the order of their size.
///
/// # Errors
/// [`RunError`] where the seam cannot be followed or the law cannot be built.
pub fn limit_cycles(
    scenario: &Scenario<'_>,
    at: &OperatingPoint,
) -> Result<Vec<LimitCycle>, RunError> {
    let small = |point: &State| FrictionSlope::AtSpeed.of(scenario.cell, point);
    let mut modes = Vibration::all(scenario, at, small)?;
    modes.sort_by(|a, b| b.pole.norm().total_cmp(&a.pole.norm()));
    modes.truncate(MODES);
    let each: Result<Vec<_>, _> =
        modes.into_iter().map(|mode| mode.limit_cycles(scenario, at)).collect();
    let mut found: Vec<LimitCycle> = Vec::new();
    for cycle in each?.concat() {
        // Two modes may become one as they grow.
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < EQUAL_CYCLE_SHARE;
        let size = |of: &LimitCycle| of.rate.iter().copied().fold(0.0, f64::max);
        if !found.iter().any(|of| near(of.hz, cycle.hz) && near(size(of), size(&cycle))) {
            found.push(cycle);
        }
    }
    Ok(found)
}

/// A mode that turns.
#[derive(Clone, Copy)]
struct Vibration {
    pole: Complex<f64>,
    /// Amplitudes of the drives' rates, the largest of them 1.
    shape: JointVector<f64>,
}

impl Vibration {
    fn growth(&self) -> f64 {
        self.pole.norm() - 1.0
    }

    /// Where it neither grows nor dies, from small to large.
    fn limit_cycles(
        self,
        scenario: &Scenario<'_>,
        at: &OperatingPoint,
    ) -> Result<Vec<LimitCycle>, RunError> {
        let (least, most, count) = CYCLE_AMPLITUDES;
        let step = (most / least).powf(1.0 / (count - 1) as f64);
        let (mut before, mut size_before) = (self, least);
        let mut found = Vec::new();
        for k in 0..count {
            let size = least * step.powi(k as i32);
            let Some(now) = before.at_size(scenario, at, size)? else { break };
            if (now.growth() > 0.0) != (before.growth() > 0.0) {
                let attracts = before.growth() > 0.0;
                let (mut low, mut high, mut between) = (size_before, size, before);
                for _ in 0..CYCLE_HALVINGS {
                    let middle = (low * high).sqrt();
                    let Some(next) = between.at_size(scenario, at, middle)? else { break };
                    if (next.growth() > 0.0) == attracts {
                        low = middle
                    } else {
                        high = middle
                    }
                    between = next;
                }
                let hz = between.pole.arg().abs() / (TAU * scenario.control.period);
                found.push(LimitCycle { hz, rate: (between.shape * low).into(), attracts });
            }
            (before, size_before) = (now, size);
        }
        Ok(found)
    }

    /// The same one with friction as it sees it at a size, rad/s of the drive that moves most.
    fn at_size(
        &self,
        scenario: &Scenario<'_>,
        at: &OperatingPoint,
        size: f64,
    ) -> Result<Option<Self>, RunError> {
        let mut now = *self;
        for _ in 0..2 {
            let friction = |point: &State| slopes(scenario.cell, point, &(now.shape * size));
            let all = Self::all(scenario, at, friction)?;
            let off = |of: &Self| (of.pole - now.pole).norm();
            let Some(next) = all.into_iter().min_by(|a, b| off(a).total_cmp(&off(b))) else {
                return Ok(None);
            };
            now = next;
        }
        Ok(Some(now))
    }

    /// All of them with these slopes of friction.
    fn all(
        scenario: &Scenario<'_>,
        at: &OperatingPoint,
        friction: impl Fn(&State) -> JointVector<f64>,
    ) -> Result<Vec<Self>, RunError> {
        let frozen = frozen(scenario, at, friction)?;
        let mut added = [0.0; LOOP_CHANNELS];
        added[SETPOINT..].fill(KICK);
        let kick = Kick { added, periods: 1, time: WATCHED };
        let rest = frozen.run(&Kick { added: [0.0; LOOP_CHANNELS], ..kick })?;
        let kicked = frozen.run(&kick)?;
        let Some(modes) = Modes::of(&left(&rest, &kicked), CYCLE_RANK_SHARE) else {
            return Ok(Vec::new());
        };
        let slowest = VIBRATION_FREQUENCY_MIN * TAU * scenario.control.period;
        let turning = modes.poles.iter().filter(|pole| pole.arg() >= slowest);
        let all = turning.filter_map(|pole| modes.mode(*pole)).map(|mode| {
            let moved = JointVector::from_fn(|i, _| mode.shape[i].norm());
            Self { pole: mode.pole, shape: moved / moved.max() }
        });
        Ok(all.collect())
    }
}

/// What a kick leaves in the rates of the drives, with copies that come later.
fn left(rest: &Run, kicked: &Run) -> DMatrix<f64> {
    let count = rest.rates.len().min(kicked.rates.len());
    let left = |k: usize, i: usize| kicked.rates[k][i] - rest.rates[k][i];
    DMatrix::from_fn(6 * LATER, count.saturating_sub(LATER), |i, k| left(k + i / 6, i % 6))
}
