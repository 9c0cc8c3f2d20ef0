//! Values of one instrument at the times of another, with what that does to their noise.
//!
//! An even series that is as fast as the other or faster is interpolated by a windowed sinc, which
//! is cut off where the slower of the two can hold no more. A slower or uneven one keeps its own
//! samples: each goes to the nearest of the other's times, along the parabola through its
//! neighbours; the others are without a value. Every value is a weighted sum that is exact on
//! parabolas, so that the variance of its noise is known: Σ weight². Left out: extrapolation.

use super::fir::bessel;
use super::median;
use nalgebra::{Matrix3, Vector3};

/// Half the width of the sinc, in samples of the slower series, and Kaiser's β of its window.
const SINC_HALF_WIDTH: f64 = 16.0;
const SINC_KAISER_BETA: f64 = 8.0;

/// Points of the window that are tabulated.
const TABULATED: usize = 1024;

/// Fewest samples that a parabola is laid through.
const PARABOLA_SAMPLES_MIN: usize = 7;

/// Share of the samples that a sinc's window must hold: beside a gap it is a parabola's turn.
const SINC_SAMPLES_MIN: f64 = 0.95;

/// A step that varies by more than this share is uneven: a sinc would put samples where they are
/// not.
const UNEVEN: f64 = 0.05;

/// Times that are as near as this, in periods, are the same.
const EQUAL_TIME_DIFFERENCE: f64 = 1e-4;

/// A step further than this from a whole number of periods is none, of which stamps alone jitter.
const GRID_DEPARTURE_MAX: f64 = 0.25;

/// How the values at one time come from samples of a series: the first sample and the weights from
/// there on.
#[derive(Debug, Default)]
pub struct Weights {
    /// Index of the first sample.
    pub first: usize,
    /// A weight a sample; none where there is no value.
    pub weights: Vec<f64>,
}

impl Weights {
    /// Variance of the value per variance of a sample.
    pub fn gain(&self) -> f64 {
        self.weights.iter().map(|w| w * w).sum()
    }
}

/// Brings samples taken at some times to a grid of times.
pub struct Resampler<'t> {
    times: &'t [f64],
    /// Median steps of the samples and of the grid, s.
    period: f64,
    grid_period: f64,
    even: bool,
    window: Vec<f64>,
}

/// Median step of rising times, s; 0 of fewer than two.
pub fn median_step(times: &[f64]) -> f64 {
    // Of a long series some thousand steps tell it.
    let stride = (times.len() / 4096).max(1);
    let mut steps: Vec<f64> = times.windows(2).step_by(stride).map(|w| w[1] - w[0]).collect();
    median(&mut steps).unwrap_or(0.0)
}

/// True where nearly all steps are whole multiples of the median one, and most are one of it: stamps
/// jitter, and single rows were lost.
pub(crate) fn is_even(times: &[f64]) -> bool {
    let period = median_step(times);
    let periods = || times.windows(2).map(|w| (w[1] - w[0]) / period);
    let off = periods().filter(|p| (p - p.round().max(1.0)).abs() > GRID_DEPARTURE_MAX).count();
    let lost = periods().filter(|p| *p > 1.5).count();
    20 * off <= times.len() && 4 * lost <= times.len()
}

impl<'t> Resampler<'t> {
    /// Samples at `times`, which rise, for a grid of this period.
    pub fn new(times: &'t [f64], grid_period: f64) -> Self {
        let period = median_step(times);
        // Jitter of single stamps, not lost rows.
        let near = |w: &[f64]| (w[1] - w[0] - period).abs() < (1.0 - GRID_DEPARTURE_MAX) * period;
        let uneven = |w: &&[f64]| near(w) && (w[1] - w[0] - period).abs() > UNEVEN * period;
        let even = times.windows(2).filter(uneven).count() * 20 <= times.len();
        let window = (0..=TABULATED)
            .map(|k| {
                let u = k as f64 / TABULATED as f64;
                bessel(SINC_KAISER_BETA * (1.0 - u * u).max(0.0).sqrt()) / bessel(SINC_KAISER_BETA)
            })
            .collect();
        Self { times, period, grid_period, even, window }
    }

    /// The weights at a time; `from`: an index that is not above those of an earlier call with an
    /// earlier time, moved on here.
    pub fn at(&self, time: f64, from: &mut usize, weights: &mut Weights) {
        weights.weights.clear();
        let times = self.times;
        if times.is_empty() {
            return;
        }
        let near = 0.5 * self.period.max(self.grid_period);
        while *from + 1 < times.len() && times[*from + 1] <= time {
            *from += 1;
        }
        let nearest = match times.get(*from + 1) {
            Some(next) if next - time < time - times[*from] => *from + 1,
            _ => *from,
        };
        let apart = (times[nearest] - time).abs();
        if apart <= EQUAL_TIME_DIFFERENCE * self.period && self.period > 0.6 * self.grid_period {
            weights.first = nearest;
            weights.weights.push(1.0);
            return;
        }
        // The ends: half a step beyond the last sample there is none.
        if apart > near * (1.0 + 1e-9) {
            return;
        }
        let slower = self.period > 1.5 * self.grid_period;
        if slower && apart > 0.5 * self.grid_period * (1.0 + 1e-9) {
            return;
        }
        if self.even && !slower && self.sinc(time, nearest, weights) {
            return;
        }
        self.parabola(time, nearest, weights);
    }

    /// Weights of a windowed sinc; false where too few samples are around.
    fn sinc(&self, time: f64, nearest: usize, weights: &mut Weights) -> bool {
        let spacing = self.period.max(self.grid_period);
        let reach = SINC_HALF_WIDTH * spacing;
        let times = self.times;
        let (mut first, mut end) = (nearest, nearest + 1);
        while first > 0 && times[first - 1] > time - reach {
            first -= 1;
        }
        while end < times.len() && times[end] < time + reach {
            end += 1;
        }
        let expected = 2.0 * reach / self.period;
        if ((end - first) as f64) < SINC_SAMPLES_MIN * expected - 1.0 {
            return false;
        }
        weights.first = first;
        let mut shape = Vec::with_capacity(end - first);
        for t in &times[first..end] {
            let u = (t - time) / spacing;
            let place = (u.abs() / SINC_HALF_WIDTH).min(1.0) * TABULATED as f64;
            let (k, share) = (place as usize, place.fract());
            let after = self.window[(k + 1).min(TABULATED)];
            let window = self.window[k] * (1.0 - share) + after * share;
            let x = std::f64::consts::PI * u;
            let sinc = if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
            weights.weights.push(sinc * window);
            shape.push((u, window));
        }
        // Of a faster series the sinc covers several samples a step.
        let sum: f64 = weights.weights.iter().sum();
        weights.weights.iter_mut().for_each(|w| *w /= sum);
        exact_on_parabolas(&mut weights.weights, &shape)
    }

    /// Weights of the samples within half a step of the grid, moved along the parabola through them
    /// and their neighbours.
    fn parabola(&self, time: f64, nearest: usize, weights: &mut Weights) {
        let times = self.times;
        let cell = 0.5 * self.grid_period;
        let inside = |k: usize| (times[k] - time).abs() <= cell || k == nearest;
        let (mut first, mut end) = (nearest, nearest + 1);
        while first > 0 && inside(first - 1) {
            first -= 1;
        }
        while end < times.len() && inside(end) {
            end += 1;
        }
        let (cell_first, cell_end) = (first, end);
        let far = 3.0 * self.period;
        loop {
            let before = first > 0 && times[first] - times[first - 1] <= far;
            let after = end < times.len() && times[end] - times[end - 1] <= far;
            if end - first >= PARABOLA_SAMPLES_MIN || !(before || after) {
                break;
            }
            let earlier = before && (!after || time - times[first - 1] <= times[end] - time);
            if earlier {
                first -= 1;
            } else {
                end += 1;
            }
        }
        let count = (cell_end - cell_first) as f64;
        weights.first = first;
        let spacing = self.period.max(f64::MIN_POSITIVE);
        let mut shape = Vec::with_capacity(end - first);
        for k in first..end {
            let in_cell = (cell_first..cell_end).contains(&k);
            weights.weights.push(if in_cell { 1.0 / count } else { 0.0 });
            shape.push(((times[k] - time) / spacing, 1.0));
        }
        if !exact_on_parabolas(&mut weights.weights, &shape) {
            // Too few neighbours to tell a slope.
            weights.first = nearest;
            weights.weights.clear();
            weights.weights.push(1.0);
        }
    }
}

/// Changes weights by as little as makes them exact on constants, ramps and parabolas around 0.
/// `shape`: where each sample is, and how freely its weight may change. False where they cannot be.
fn exact_on_parabolas(weights: &mut [f64], shape: &[(f64, f64)]) -> bool {
    let mut matrix = Matrix3::zeros();
    let mut left = Vector3::new(1.0, 0.0, 0.0);
    for (weight, (u, free)) in weights.iter().zip(shape) {
        let basis = Vector3::new(1.0, *u, u * u);
        matrix += basis * basis.transpose() * *free;
        left -= basis * *weight;
    }
    let Some(change) = matrix.cholesky().map(|c| c.solve(&left)) else {
        return false;
    };
    for (weight, (u, free)) in weights.iter_mut().zip(shape) {
        *weight += free * (change[0] + change[1] * u + change[2] * u * u);
    }
    weights.iter().all(|w| w.is_finite() && w.abs() < 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resampled(times: &[f64], grid: &[f64], f: impl Fn(f64) -> f64) -> Vec<(f64, f64)> {
        let resampler = Resampler::new(times, median_step(grid));
        let (mut from, mut weights) = (0, Weights::default());
        grid.iter()
            .map(|t| {
                resampler.at(*t, &mut from, &mut weights);
                if weights.weights.is_empty() {
                    return (f64::NAN, f64::NAN);
                }
                let at = |(k, w): (usize, &f64)| w * f(times[weights.first + k]);
                (weights.weights.iter().enumerate().map(at).sum(), weights.gain())
            })
            .collect()
    }

    fn times(n: usize, start: f64, step: f64) -> Vec<f64> {
        (0..n).map(|k| start + step * k as f64).collect()
    }

    #[test]
    fn jitter_and_lost_rows_are_even_and_other_steps_are_not() {
        let mut grid = times(200, 3.0, 0.004);
        assert!(is_even(&grid));
        grid.retain(|t| (t / 0.004).round() as i64 % 17 != 0);
        grid.iter_mut().enumerate().for_each(|(k, t)| *t += 0.0004 * (7.0 * k as f64).sin());
        assert!(is_even(&grid), "10 % of jitter, and every 17th row lost");
        let step = |k: usize| [1.0, 2.0, 3.0, 1.0][k % 4];
        let uneven: Vec<f64> =
            (0..200).scan(0.0, |t, k| Some(std::mem::replace(t, *t + step(k)))).collect();
        assert!(!is_even(&uneven));
    }

    #[test]
    fn the_same_times_give_the_same_values_and_noise() {
        let grid = times(50, 3.0, 0.004);
        for (k, (value, gain)) in resampled(&grid, &grid, |t| t.sin()).into_iter().enumerate() {
            assert_eq!((value, gain), (grid[k].sin(), 1.0));
        }
    }

    #[test]
    fn a_sine_at_half_the_highest_frequency_passes_a_shift_within_a_thousandth() {
        let (own, other) = (times(400, 0.0, 0.004), times(400, 0.0013, 0.004));
        let wave = |t: f64| (std::f64::consts::TAU * 60.0 * t).sin();
        for (k, (value, gain)) in resampled(&other, &own, wave).into_iter().enumerate() {
            // At the ends there is one side only.
            if (20..380).contains(&k) {
                assert!((value - wave(own[k])).abs() < 1e-3, "{k}: {value} {}", wave(own[k]));
                assert!((0.85..1.01).contains(&gain), "white noise stays what it is: {gain}");
            }
        }
    }

    #[test]
    fn a_faster_series_is_averaged_and_its_noise_falls_as_it_should() {
        let (own, other) = (times(300, 0.0, 0.004), times(1200, 0.0004, 0.001));
        let wave = |t: f64| (std::f64::consts::TAU * 30.0 * t).sin();
        for (k, (value, gain)) in resampled(&other, &own, wave).into_iter().enumerate() {
            if (20..280).contains(&k) {
                assert!((value - wave(own[k])).abs() < 2e-3, "{k}");
                assert!((0.21..0.26).contains(&gain), "a quarter: {gain}");
            }
        }
    }

    #[test]
    fn a_slower_series_keeps_its_own_samples_and_a_gap_stays_one() {
        let own = times(1000, 0.0, 0.004);
        let mut other = times(40, 0.0017, 0.1);
        other.drain(20..24);
        let values = resampled(&other, &own, |t| 2.0 + 3.0 * t - t * t);
        let there: Vec<usize> = (0..values.len()).filter(|k| values[*k].0.is_finite()).collect();
        assert_eq!(there.len(), 36, "one row a sample");
        for k in there {
            let (value, gain) = values[k];
            assert!((value - (2.0 + 3.0 * own[k] - own[k] * own[k])).abs() < 1e-9, "{k}");
            assert!((0.9..1.1).contains(&gain), "{gain}");
        }
    }
}
