//! Symptoms of a compensation loop in a recording: which way it corrects, whether it swings,
//! whether it is held at its limits.
//!
//! They are what a failed requirement is explained by. Everything is taken over the steady part.

use super::{NominalCell, SampledCell};
use crate::weld::DriveLoad;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_core::{JOINTS, Twist};
use trueweld_plant::input::CompensationLimits;
use trueweld_plant::simulate::{Phase, RecordRow, Recording, RunError, Scenario};

/// What changes more slowly than this is followed, not swung, s: the tool's deviation changes over
/// decimetres of the seam.
const SLOW: f64 = 4.0;

/// Where the tool's deviation without compensation is below this, RMS over the steady part, there
/// is nothing to tell a direction by: m, rad, rad.
const NEGLIGIBLE: [f64; 3] = [2e-4, 2e-4, 2e-4];

/// Across the seam, tilt across it, tilt along it.
fn directions(twist: &Twist<f64>) -> [f64; 3] {
    [twist.linear.y, twist.angular.x, twist.angular.y]
}

/// What the nominal cell needs of a correction: minus the tool's deviation without one, period by
/// period.
#[derive(Debug, Clone, PartialEq)]
pub struct RequiredCorrection(Vec<[f64; 3]>);

impl RequiredCorrection {
    /// Welds the nominal cell without compensation.
    ///
    /// # Errors
    /// [`RunError`] where the weld cannot be made even so; [`None`] inside where it never reaches
    /// its steady part.
    pub fn of(scenario: &Scenario<'_>, cell: &NominalCell<'_>) -> Result<Option<Self>, RunError> {
        let none = Entry::of::<Uncompensated>();
        let bare = Scenario { law: &none, ..*scenario };
        let recording = cell.weld(&bare, &SampledCell::nominal(scenario.seed), 1)?;
        let steady = recording.rows.iter().any(|r| r.phase == Phase::Steady);
        let needed =
            recording.rows.iter().map(|r| directions(&r.deviation_w).map(|d| -d)).collect();
        Ok(steady.then_some(Self(needed)))
    }
}

/// A correction that goes to and fro.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Oscillation {
    /// Amplitude across the seam, m: that of the sine of the same root mean square.
    pub amplitude: f64,
    /// Its frequency, Hz.
    pub frequency: f64,
    /// Correlation with itself one period later: near 1 for a limit cycle, near 0 for noise.
    pub regularity: f64,
    /// Root mean square of the second half of the steady part over that of the first.
    pub growth: f64,
}

/// How the loop behaved.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Symptoms {
    /// Share of what the nominal cell needs that the correction gave: across the seam, in tilt
    /// across it, in tilt along it. Negative: the wrong way. `None` where next to nothing is
    /// needed.
    pub given: [Option<f64>; 3],
    /// Lateral deviation by how fast it changes, RMS, m: over seconds; faster, down to one turn of
    /// the spindle; within a turn.
    pub lateral: [f64; 3],
    /// Going to and fro of the correction across the seam.
    pub swing: Oscillation,
    /// Share of the periods in which the correction stood at its authority.
    pub at_authority: f64,
    /// Share of the periods in which the correction stood at a limit of its size or its rate.
    pub compensation: f64,
    /// Share of the periods in which what the force loop adds stood at a limit.
    pub force_loop: f64,
    /// Share of the periods in which a fault was raised.
    pub fault: f64,
    /// What the drives gave, A1 to A6.
    pub drives: [DriveLoad; JOINTS],
}

impl Symptoms {
    /// Of one recording. `spindle`: its speed, rad/s.
    pub(super) fn of(
        recording: &Recording,
        needed: &RequiredCorrection,
        limits: &CompensationLimits,
        spindle: f64,
    ) -> Self {
        let rows = recording.rows.iter().zip(&needed.0).filter(|(r, _)| r.phase == Phase::Steady);
        let (steady, needed): (Vec<&RecordRow>, Vec<&[f64; 3]>) = rows.unzip();
        let given = [0, 1, 2].map(|k| {
            let square: f64 = needed.iter().map(|n| n[k] * n[k]).sum();
            let product: f64 = steady
                .iter()
                .zip(&needed)
                .map(|(r, n)| directions(&r.correction_w)[k] * n[k])
                .sum();
            let share = product / square;
            ((square / steady.len().max(1) as f64).sqrt() > NEGLIGIBLE[k] && share.is_finite())
                .then_some(share)
        });
        let period = recording.period;
        let share = |is: &dyn Fn(&RecordRow) -> bool| {
            steady.iter().filter(|r| is(r)).count() as f64 / steady.len().max(1) as f64
        };
        // A correction held at its authority lies on the bound, to the last digits.
        let full = |r: &RecordRow| {
            r.correction_w.linear.norm() > 0.999 * limits.lateral.size
                || r.correction_w.angular.norm() > 0.999 * limits.orientation.size
        };
        let lateral: Vec<f64> = steady.iter().map(|r| r.deviation_w.linear.y).collect();
        let slow = moving_mean(&lateral, SLOW / period);
        let turn = if spindle > 0.0 {
            moving_mean(&lateral, TAU / spindle / period)
        } else {
            lateral.clone()
        };
        let correction: Vec<f64> = steady.iter().map(|r| r.correction_w.linear.y).collect();
        Self {
            given,
            lateral: [rms(&slow), rms(&less(&turn, &slow)), rms(&less(&lateral, &turn))],
            swing: Oscillation::of(
                &less(&correction, &moving_mean(&correction, SLOW / period)),
                period,
            ),
            at_authority: share(&full),
            compensation: share(&|r| r.limited.compensation),
            force_loop: share(&|r| r.limited.force_loop),
            fault: share(&|r| r.fault.is_some()),
            drives: DriveLoad::all(recording).0,
        }
    }
}

impl Oscillation {
    fn of(signal: &[f64], period: f64) -> Self {
        let whole = rms(signal);
        let (first, second) = signal.split_at(signal.len() / 2);
        // Crossings of zero, those of small noise about it left out.
        let (mut side, mut crossings) = (0.0, 0_usize);
        for v in signal.iter().filter(|v| v.abs() > 0.5 * whole) {
            if side * v < 0.0 {
                crossings += 1;
            }
            side = *v;
        }
        let duration = signal.len() as f64 * period;
        let frequency = if duration > 0.0 { crossings as f64 / (2.0 * duration) } else { 0.0 };
        let over = |a: f64, b: f64| if b > 0.0 { a / b } else { 0.0 };
        let repeats = |lag: usize| {
            let pairs = signal.iter().zip(signal.iter().skip(lag));
            let (product, square) =
                pairs.fold((0.0, 0.0), |(p, s), (a, b)| (p + a * b, s + 0.5 * (a * a + b * b)));
            over(product, square)
        };
        // Counted crossings say the period to within a quarter or so, where a swing is not quite
        // regular.
        let samples =
            if frequency > 0.0 { 1.0 / (frequency * period) } else { signal.len() as f64 };
        let regularity =
            ((0.75 * samples) as usize..=(1.3 * samples) as usize).map(repeats).fold(0.0, f64::max);
        Self {
            amplitude: whole * std::f64::consts::SQRT_2,
            frequency,
            regularity,
            growth: over(rms(second), rms(first)),
        }
    }
}

fn rms(signal: &[f64]) -> f64 {
    (signal.iter().map(|v| v * v).sum::<f64>() / signal.len().max(1) as f64).sqrt()
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Mean over so many samples about each, fewer at the ends.
fn moving_mean(signal: &[f64], width: f64) -> Vec<f64> {
    let half = (0.5 * width).round().max(0.0) as usize;
    let mut sums = vec![0.0];
    for v in signal {
        sums.push(sums[sums.len() - 1] + v);
    }
    (0..signal.len())
        .map(|i| {
            let (low, high) = (i.saturating_sub(half), (i + half + 1).min(signal.len()));
            (sums[high] - sums[low]) / (high - low) as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.012;

    fn over(seconds: f64, of: impl Fn(f64) -> f64) -> Vec<f64> {
        (0..(seconds / PERIOD) as usize).map(|k| of(k as f64 * PERIOD)).collect()
    }

    #[test]
    fn a_limit_cycle_is_told_from_noise() {
        let cycle = Oscillation::of(&over(30.0, |t| 2e-3 * (TAU * 0.8 * t).sin()), PERIOD);
        assert!((cycle.frequency - 0.8).abs() < 0.03, "{cycle:?}");
        assert!((cycle.amplitude - 2e-3).abs() < 2e-5 && cycle.regularity > 0.95, "{cycle:?}");
        assert!((cycle.growth - 1.0).abs() < 0.05, "{cycle:?}");
        // As irregular as a congruential generator's digits.
        let mut state = 1_u64;
        let noise = (0..2500).map(|_| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        });
        let noise = Oscillation::of(&noise.collect::<Vec<_>>(), PERIOD);
        assert!(noise.regularity < 0.3, "{noise:?}");
    }

    #[test]
    fn an_oscillation_that_builds_up_is_said_to_grow() {
        let swing = Oscillation::of(&over(10.0, |t| (0.3 * t).exp() * (TAU * t).sin()), PERIOD);
        assert!(swing.growth > 2.0, "{swing:?}");
    }
}
