//! Margins from a sampled sensitivity: of one direction with the others closed, and of all at once.

use super::response::{LoopSignals, SETPOINT};
use crate::weld::larger;
use nalgebra::{Complex, SMatrix};
use schemars::JsonSchema;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// Frequencies at which the loop is looked at, evenly in their logarithm.
const FREQUENCIES: usize = 400;

/// The lowest of them, Hz.
const FREQUENCY_MIN: f64 = 0.05;

// How far one loop, opened where the law or the force loop acts, is from instability. Infinite where
// nothing comes back.
/// Margins of one channel with the others closed; `null` where there is no limit.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "LoopMargins", deny_unknown_fields)]
pub struct Margin {
    /// Largest factor on the gain.
    #[schemars(with = "Option<f64>")]
    pub gain: f64,
    /// Smallest factor on the gain.
    #[schemars(with = "Option<f64>")]
    pub fall: f64,
    /// Smallest turn of the phase, either way, rad.
    #[schemars(with = "Option<f64>")]
    pub phase_rad: f64,
    /// Least distance of the loop from −1: the inverse of the largest sensitivity.
    #[schemars(with = "Option<f64>")]
    pub modulus: f64,
    /// Smallest further delay, s.
    #[schemars(with = "Option<f64>")]
    pub delay_s: f64,
}

/// S(e^jωT) at the frequencies from [`FREQUENCY_MIN`] to half the sampling rate.
pub(crate) struct SensitivityFunction<'a> {
    responses: &'a [Vec<LoopSignals>],
    period: f64,
    /// Factor by which the responses go on to die after their last sample.
    radius: f64,
    /// Frequencies, Hz.
    hz: Vec<f64>,
    /// Corrections and force, then drives, each among themselves: one matrix a frequency.
    groups: [Vec<GroupSensitivity>; 2],
}

/// S of the channels of a group.
type GroupSensitivity = SMatrix<Complex<f64>, SETPOINT, SETPOINT>;

impl<'a> SensitivityFunction<'a> {
    /// Of impulse responses, `period` s between their values, that have come down to the mode which
    /// dies last: it goes on with the spectral radius `radius`, as slow modes do not turn.
    pub(crate) fn of(responses: &'a [Vec<LoopSignals>], radius: f64, period: f64) -> Self {
        let highest = 0.5 / period;
        let hz: Vec<f64> = (0..FREQUENCIES)
            .map(|k| {
                FREQUENCY_MIN * (highest / FREQUENCY_MIN).powf(k as f64 / (FREQUENCIES - 1) as f64)
            })
            .collect();
        let groups = [0, SETPOINT].map(|first| {
            // All entries of a sample beside each other, column by column.
            let samples: Vec<SMatrix<f64, SETPOINT, SETPOINT>> = (0..responses[0].len())
                .map(|k| SMatrix::from_fn(|i, j| responses[first + j][k][first + i]))
                .collect();
            let turns = hz.iter().map(|hz| Complex::from_polar(1.0, -TAU * hz * period));
            turns.map(|turn| transformed(&samples, turn, radius)).collect()
        });
        Self { responses, period, radius, hz, groups }
    }

    /// L = 1/S_ii − 1 of one channel at a frequency, Hz.
    fn open(&self, channel: usize, hz: f64) -> Complex<f64> {
        let turn = Complex::from_polar(1.0, -TAU * hz * self.period);
        let rows = &self.responses[channel];
        let last = rows.last().map_or(0.0, |row| row[channel]);
        let after = self.radius * last / (1.0 - turn * self.radius);
        let s = rows.iter().rev().fold(after, |sum, row| sum * turn + row[channel]);
        s.inv() - 1.0
    }

    /// Where `sign` of the open loop changes between two frequencies, Hz, and the open loop there.
    /// A mode may turn it all the way round between them.
    fn where_changes(
        &self,
        channel: usize,
        between: &[f64],
        sign: impl Fn(Complex<f64>) -> f64,
    ) -> (f64, Complex<f64>) {
        let [mut low, mut high] = [between[0], between[1]];
        let below = sign(self.open(channel, low));
        for _ in 0..20 {
            let middle = 0.5 * (low + high);
            if sign(self.open(channel, middle)) * below > 0.0 {
                low = middle
            } else {
                high = middle
            }
        }
        (high, self.open(channel, high))
    }

    /// Margins of one channel, the others closed: L = 1/S_ii − 1.
    pub(crate) fn margin(&self, channel: usize) -> Margin {
        let k = channel % SETPOINT;
        let group = &self.groups[channel / SETPOINT];
        let s: Vec<Complex<f64>> = group.iter().map(|m| m[(k, k)]).collect();
        let largest = s.iter().map(|s| s.norm()).fold(0.0, larger);
        let open: Vec<Complex<f64>> = s.iter().map(|s| s.inv() - 1.0).collect();
        let mut margin = Margin {
            gain: f64::INFINITY,
            fall: f64::INFINITY,
            phase_rad: f64::INFINITY,
            modulus: 1.0 / largest,
            delay_s: f64::INFINITY,
        };
        let mut crosses = |real: f64| {
            if real < -1.0 {
                margin.fall = margin.fall.min(-real);
            } else if real < 0.0 {
                margin.gain = margin.gain.min(-1.0 / real);
            }
        };
        // Real at rest and at half the sampling rate, whatever it is between.
        open.iter().take(1).chain(open.last()).for_each(|l| {
            if l.im.abs() < 0.1 * l.re.abs() {
                crosses(l.re);
            }
        });
        for (pair, hz) in open.windows(2).zip(self.hz.windows(2)) {
            if pair[0].im * pair[1].im < 0.0 {
                let (_, at) = self.where_changes(channel, hz, |l| l.im);
                // Through infinity, where nothing is sensed, is no crossing.
                if at.im.abs() < 0.01 * at.re.abs() {
                    crosses(at.re);
                }
            }
        }
        for (pair, hz) in open.windows(2).zip(self.hz.windows(2)) {
            if pair[0].norm().ln() * pair[1].norm().ln() < 0.0 {
                let (hz, at) = self.where_changes(channel, hz, |l| l.norm().ln());
                // How far the vector still has to turn, backwards, to −1.
                let left = (at.arg() + PI).rem_euclid(TAU);
                margin.phase_rad = margin.phase_rad.min(left.min(TAU - left));
                margin.delay_s = margin.delay_s.min(left / (TAU * hz));
            }
        }
        margin
    }

    /// Disk margin of corrections and force at once, and of the drives at once: gains and phases
    /// may leave in each by itself as far as a disk about 1 of this size, α of 2/‖S − T‖ (Seiler,
    /// Packard and Gahinet 2020, without skew), in the scaling of the channels that shows most.
    pub(crate) fn disks(&self) -> [f64; 2] {
        let two = Complex::new(2.0, 0.0);
        self.groups.each_ref().map(|group| {
            let largest = group.iter().map(|s| scaled_norm(&(s * two - SMatrix::identity())));
            2.0 / largest.fold(0.0, f64::max)
        })
    }
}

/// Σ of samples times the powers of `turn`, e^−jωT, from 0 on: after the last sample they go on to
/// die by the factor `radius`.
fn transformed(
    samples: &[SMatrix<f64, SETPOINT, SETPOINT>],
    turn: Complex<f64>,
    radius: f64,
) -> GroupSensitivity {
    let mut phase = Complex::new(1.0, 0.0);
    let (mut real, mut imaginary) = (SMatrix::zeros(), SMatrix::zeros());
    for sample in samples {
        real += sample * phase.re;
        imaginary += sample * phase.im;
        phase *= turn;
    }
    let after = phase * radius / (1.0 - turn * radius);
    let last = samples.last().copied().unwrap_or_default();
    GroupSensitivity::from_fn(|i, j| {
        Complex::new(real[(i, j)], imaginary[(i, j)]) + after * last[(i, j)]
    })
}

/// The largest gain of a matrix in the diagonal scaling that makes rows and columns alike (Osborne
/// 1960): an upper bound of what independent channels can do.
fn scaled_norm(matrix: &SMatrix<Complex<f64>, SETPOINT, SETPOINT>) -> f64 {
    let mut balanced = *matrix;
    for _ in 0..30 {
        for k in 0..SETPOINT {
            let beside = |column: bool| {
                let entries = (0..SETPOINT).filter(|i| *i != k);
                entries
                    .map(|i| balanced[if column { (i, k) } else { (k, i) }].norm_sqr())
                    .sum::<f64>()
                    .sqrt()
            };
            let (column, row) = (beside(true), beside(false));
            if column > 0.0 || row > 0.0 {
                // Where nothing goes one way, what goes the other way goes nowhere: it is scaled
                // out.
                let scale = (row / column).sqrt().clamp(1e-2, 1e2);
                for i in (0..SETPOINT).filter(|i| *i != k) {
                    balanced[(i, k)] *= scale;
                    balanced[(k, i)] /= scale;
                }
            }
        }
    }
    balanced.singular_values().max()
}
