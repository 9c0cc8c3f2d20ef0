//! Smoothing of evenly sampled series: a low-pass without phase, with first and second derivative,
//! whose noise is known.
//!
//! A windowed sinc (Kaiser's window, 50 dB): flat up to half its cutoff, nothing from one and a
//! half times on. Measured and predicted series pass the same filter, so that it takes nothing from
//! one that the other keeps.

use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;

/// Kaiser's β for 50 dB.
const KAISER_BETA_50_DB: f64 = 4.55;

/// Most samples to either side: an arm's logs have some hundred in a period of any band.
const MOST_HALF: f64 = 16_384.0;

/// A low-pass filter of one sampling period.
#[derive(Debug, Clone)]
pub struct LowPass {
    /// Weights of value, first and second derivative, from the oldest sample to the newest.
    taps: [Vec<f64>; 3],
    half: usize,
}

/// Modified Bessel function I₀.
pub(super) fn bessel(x: f64) -> f64 {
    let (mut sum, mut term, mut k) = (1.0, 1.0, 1.0);
    while term > 1e-17 * sum {
        term *= (x / (2.0 * k)) * (x / (2.0 * k));
        sum += term;
        k += 1.0;
    }
    sum
}

/// Weight of an ideal low-pass in Kaiser's window at `k` samples from the middle. `band`: twice the
/// cut-off frequency, per sample; `reach`: half the window's width, samples.
fn windowed_sinc(k: f64, band: f64, reach: f64) -> f64 {
    let u = k / reach;
    if u.abs() >= 1.0 {
        return 0.0;
    }
    let x = band * k;
    let sinc = if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    sinc * bessel(KAISER_BETA_50_DB * (1.0 - u * u).sqrt()) / bessel(KAISER_BETA_50_DB)
}

impl LowPass {
    /// A filter with its half-power point near `cutoff` Hz, for samples every `period` s; higher
    /// where the samples are so dense that it would not end.
    pub fn new(cutoff: f64, period: f64) -> Self {
        let cutoff = cutoff.max(1.46 / (MOST_HALF * period));
        let half = ((1.46 / (cutoff * period)).ceil() as usize).max(1);
        let reach = half as f64 + 1.0;
        let kernel = |k: f64| windowed_sinc(k, 2.0 * cutoff * period, reach);
        let at = |k: usize| k as f64 - half as f64;
        let n = 2 * half + 1;
        let mut value: Vec<f64> = (0..n).map(|k| kernel(at(k))).collect();
        let step = 1e-3;
        let mut first: Vec<f64> =
            (0..n).map(|k| -(kernel(at(k) + step) - kernel(at(k) - step)) / (2.0 * step)).collect();
        let mut second: Vec<f64> = (0..n)
            .map(|k| {
                (kernel(at(k) + step) - 2.0 * kernel(at(k)) + kernel(at(k) - step)) / (step * step)
            })
            .collect();
        // Exact on constants, ramps and parabolas: a mass's inertia acts in proportion to just what
        // a parabola has.
        let moment = |taps: &[f64], p: i32| {
            taps.iter().enumerate().map(|(k, w)| w * at(k).powi(p)).sum::<f64>()
        };
        let sum = moment(&value, 0);
        value.iter_mut().for_each(|w| *w /= sum);
        let slope = moment(&first, 1) * period;
        first.iter_mut().for_each(|w| *w /= slope);
        let mean = moment(&second, 0);
        second.iter_mut().zip(&value).for_each(|(w, v)| *w -= mean * v);
        let curvature = moment(&second, 2) * 0.5 * period * period;
        second.iter_mut().for_each(|w| *w /= curvature);
        let bend = moment(&value, 2) * 0.5 * period * period;
        value.iter_mut().zip(&second).for_each(|(w, s)| *w -= bend * s);
        Self { taps: [value, first, second], half }
    }

    /// How much of a sine of `frequency` Hz the smoothed value keeps.
    pub fn response(&self, frequency: f64, period: f64) -> f64 {
        let turn = std::f64::consts::TAU * frequency * period;
        self.taps[0]
            .iter()
            .enumerate()
            .map(|(k, w)| w * (turn * (k as f64 - self.half as f64)).cos())
            .sum()
    }

    /// Samples on either side that one smoothed value needs.
    pub fn half(&self) -> usize {
        self.half
    }

    /// Samples between two of the smoothed series that tell all of it.
    pub fn stride(&self) -> usize {
        (self.half / 12).max(1)
    }

    /// Longest gap, in samples, that the straight line between its ends may bridge: the noise of these
    /// two counts by g²w²/2 where a sample's weight is w, and that of all others by w.
    pub fn bridged(&self) -> usize {
        (1.0 / self.gain(0).sqrt()) as usize
    }

    /// Variance of the `derivative`th derivative of a smoothed series per variance of its white
    /// noise.
    pub fn gain(&self, derivative: usize) -> f64 {
        self.taps[derivative].iter().map(|w| w * w).sum()
    }

    /// Covariance of the `derivative`th derivative of a smoothed series at two samples so far apart, per
    /// variance of its white noise.
    pub fn covariance(&self, derivative: usize, lag: usize) -> f64 {
        let taps = &self.taps[derivative];
        taps.iter().zip(taps.get(lag..).unwrap_or_default()).map(|(a, b)| a * b).sum()
    }

    /// The smoothed series, or its first or second derivative by time, at sample `k`. Beyond its
    /// ends the series is taken to go on as its mirror image through the last point.
    pub fn at(
        &self,
        derivative: usize,
        series: impl Fn(usize) -> f64,
        length: usize,
        k: usize,
    ) -> f64 {
        if k >= self.half && k + self.half < length {
            return self.within(derivative, k, series);
        }
        let last = length as isize - 1;
        let first = k as isize - self.half as isize;
        let taps = self.taps[derivative].iter().enumerate();
        taps.map(|(j, w)| w * mirrored(&series, last, first + j as isize)).sum()
    }

    /// The first of the samples that a smoothed value is the sum of, and each times its weight, where no end
    /// of the series is near.
    pub fn weighted(&self, series: &[f64], k: usize) -> (usize, Vec<f64>) {
        let first = k - self.half;
        let taps = self.taps[0].iter().zip(&series[first..]);
        (first, taps.map(|(w, x)| w * x).collect())
    }

    /// A value of [`Self::at`] where no end of the series is near. No sum waits for the one before it.
    fn within(&self, derivative: usize, k: usize, series: impl Fn(usize) -> f64) -> f64 {
        let (fours, rest) = self.taps[derivative].as_chunks::<4>();
        let mut sums = [0.0; 4];
        let mut i = k - self.half;
        for taps in fours {
            for (lane, tap) in taps.iter().enumerate() {
                sums[lane] += tap * series(i + lane);
            }
            i += taps.len();
        }
        let rest = rest.iter().zip(i..).map(|(tap, i)| tap * series(i));
        sums.iter().sum::<f64>() + rest.sum::<f64>()
    }

    /// The whole smoothed series or its derivative. Beyond its ends the series is taken to go on as
    /// its mirror image through the end of a straight line fitted to its last samples.
    pub fn smooth(&self, derivative: usize, series: &[f64]) -> Vec<f64> {
        let n = series.len();
        let fitted = (self.half / 2).clamp(2, n.div_ceil(2).max(2)).min(n);
        let first = end_of_line(series[..fitted].iter());
        let last = end_of_line(series[n - fitted..].iter().rev());
        let mut long = Vec::with_capacity(n + 2 * self.half);
        long.extend((1..=self.half).rev().map(|k| 2.0 * first - series[k.min(n - 1)]));
        long.extend_from_slice(series);
        long.extend((1..=self.half).map(|k| 2.0 * last - series[(n - 1).saturating_sub(k)]));
        // Tap by tap and not sample by sample: no sum waits for the one before it.
        let mut smooth = vec![0.0; n];
        for (weight, shifted) in self.taps[derivative].iter().zip(long.windows(n)) {
            smooth.iter_mut().zip(shifted).for_each(|(sum, x)| *sum += weight * x);
        }
        smooth
    }
}

/// Sum of products of two series; in four sums, so that they can run side by side.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (fours, tail) = a.as_chunks::<4>();
    let (others, other_tail) = b.as_chunks::<4>();
    for (x, y) in fours.iter().zip(others) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    sums.iter().sum::<f64>() + tail.iter().zip(other_tail).map(|(x, y)| x * y).sum::<f64>()
}

/// A series of which `last` is the last sample at sample `i`, beyond its ends as its mirror image
/// through the last point.
fn mirrored(series: &impl Fn(usize) -> f64, last: isize, i: isize) -> f64 {
    if i < 0 {
        2.0 * series(0) - series((-i).min(last) as usize)
    } else if i > last {
        2.0 * series(last as usize) - series((2 * last - i).max(0) as usize)
    } else {
        series(i as usize)
    }
}

/// Where the straight line through some values starts.
fn end_of_line<'a>(values: impl ExactSizeIterator<Item = &'a f64> + Clone) -> f64 {
    line(values).0
}

/// Start and slope (a sample) of the straight line through some values.
fn line<'a>(values: impl ExactSizeIterator<Item = &'a f64> + Clone) -> (f64, f64) {
    let n = values.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = values.clone().sum::<f64>() / n;
    let (mut top, mut bottom) = (0.0, 0.0);
    for (k, v) in values.enumerate() {
        top += (k as f64 - middle) * (v - mean);
        bottom += (k as f64 - middle).powi(2);
    }
    let slope = if bottom > 0.0 { top / bottom } else { 0.0 };
    (mean - middle * slope, slope)
}

/// Value and rate at the start of a noisy series: by a straight line through as many samples as lie
/// on one.
pub fn start(period: f64, deviation: f64, series: &[f64]) -> (f64, f64) {
    const LINE_SAMPLES_MIN: usize = 8;
    let mut found = (series[0], 0.0);
    let mut length = LINE_SAMPLES_MIN;
    while length <= series.len() {
        let samples = &series[..length];
        let (value, slope) = line(samples.iter());
        let left: f64 =
            samples.iter().enumerate().map(|(k, v)| (v - value - slope * k as f64).powi(2)).sum();
        if length > LINE_SAMPLES_MIN
            && (left / (length - 2) as f64).sqrt()
                > deviation * (1.0 + 2.0 / (length as f64).sqrt())
        {
            break;
        }
        found = (value, slope / period);
        length += length / 4;
    }
    found
}

/// How a noisy series begins: value and derivatives at its first sample, by a cubic through as many
/// samples as lie on one.
#[derive(Debug, Clone, Copy)]
pub struct Beginning {
    /// Value, and first to third derivative by time.
    pub derivatives: [f64; 4],
    /// Samples that lie on the cubic.
    pub length: usize,
    /// True where the series changes by more than its noise.
    pub moving: bool,
}

impl Beginning {
    /// Of a series with white noise of this deviation; `None` where it is too short.
    pub fn of(period: f64, deviation: f64, series: &[f64]) -> Option<Self> {
        const CUBIC_SAMPLES_MIN: usize = 24;
        /// Deviations of its slope at which a series is taken to move.
        const MOVES: f64 = 8.0;
        let mut found = None;
        let mut length = CUBIC_SAMPLES_MIN;
        while length <= series.len() {
            let span = (length - 1) as f64;
            let powers = |k: usize| {
                let u = k as f64 / span;
                SVector::<f64, 4>::new(1.0, u, u * u, u * u * u)
            };
            let (mut square, mut right) = (SMatrix::<f64, 4, 4>::zeros(), SVector::zeros());
            for (k, value) in series[..length].iter().enumerate() {
                square += powers(k) * powers(k).transpose();
                right += powers(k) * (value - series[0]);
            }
            let inverse = square.try_inverse()?;
            let fitted = inverse * right;
            let off =
                |(k, value): (usize, &f64)| (value - series[0] - fitted.dot(&powers(k))).powi(2);
            let left: f64 = series[..length].iter().enumerate().map(off).sum();
            let noise = deviation * (1.0 + 2.0 / (length as f64).sqrt());
            if found.is_some() && (left / (length - 4) as f64).sqrt() > noise {
                break;
            }
            let time = span * period;
            let [c0, c1, c2, c3] = [0, 1, 2, 3].map(|k| fitted[k] / time.powi(k as i32));
            found = Some(Self {
                derivatives: [series[0] + c0, c1, 2.0 * c2, 6.0 * c3],
                length,
                moving: c1.abs() > MOVES * deviation * inverse[(1, 1)].sqrt() / time,
            });
            length += length / 4;
        }
        found
    }

    /// Value, first and second derivative so much time after the first sample, s.
    pub fn after(&self, time: f64) -> [f64; 3] {
        let [a, b, c, d] = self.derivatives;
        [
            a + time * (b + time * (c / 2.0 + time * d / 6.0)),
            b + time * (c + time * d / 2.0),
            c + time * d,
        ]
    }
}

/// Multiples of an angle that turns with time, in a noisy series.
pub struct Orders<'a> {
    /// The angle at every sample, rad.
    pub angle: &'a [f64],
    /// Multiples 1 to this.
    pub count: usize,
    /// Half of the bands around each, Hz, widest first.
    pub bands: &'a [f64],
}

/// What a noisy series without its slow part has in bands around orders, as a spindle makes it of a
/// force, with little of its noise. Each order has the power that it has beyond the noise's, and is
/// left out where it has none. `deviation` of the white noise.
pub fn comb(orders: &Orders, period: f64, deviation: f64, quick: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; quick.len()];
    // Twice white noise times a wave has twice its variance.
    let noise = deviation * std::f64::consts::SQRT_2;
    for order in 1..=orders.count {
        let wave = |f: fn(f64) -> f64| -> Vec<f64> {
            orders.angle.iter().map(|a| f(order as f64 * a)).collect()
        };
        let waves = [wave(f64::cos), wave(f64::sin)];
        let amplitudes = waves.each_ref().map(|wave| {
            let carried: Vec<f64> = quick.iter().zip(wave).map(|(q, w)| 2.0 * q * w).collect();
            Bands::of(orders.bands, period, noise, &carried).in_agreement(NOT_BY_CHANCE)
        });
        let all = || amplitudes.iter().flatten();
        let power: f64 = all().map(|smoothed| smoothed.value.powi(2)).sum();
        let of_noise: f64 = all().map(|smoothed| smoothed.deviation.powi(2)).sum();
        if power <= of_noise {
            continue;
        }
        let share = (1.0 - of_noise / power).sqrt();
        for (amplitude, wave) in amplitudes.iter().zip(&waves) {
            let of_order = amplitude.iter().zip(wave).map(|(a, w)| share * a.value * w);
            sum.iter_mut().zip(of_order).for_each(|(s, a)| *s += a);
        }
    }
    sum
}

/// A sample of a noisy series, smoothed.
#[derive(Debug, Clone, Copy)]
pub struct Smoothed {
    /// Value, in the series' unit.
    pub value: f64,
    /// Its rate by time, in that unit/s.
    pub rate: f64,
    /// Index of the band it was smoothed in.
    pub band: usize,
    /// Deviation of the value that the noise leaves in this band, in the series' unit.
    pub deviation: f64,
}

/// Deviations within which [`Bands`] agree where little of the series may be lost.
pub const CLOSE_AGREEMENT_DEVIATIONS: f64 = 3.0;

/// The same where little of the noise may be left: of thousands of samples with ten comparisons each
/// some lie beyond three deviations by chance, and each has a wide band around it.
pub const NOT_BY_CHANCE: f64 = 4.0;

/// A noisy series and its rate in several bands.
///
/// A joint that rests or moves evenly is smoothed over a long time, and where a brake stops it
/// hardly at all: see [`in_agreement`](Self::in_agreement).
pub struct Bands {
    filters: Vec<LowPass>,
    /// Value and rate of every sample, by band.
    smooth: Vec<[Vec<f64>; 2]>,
    /// Deviation of the white noise of the series.
    deviation: f64,
}

impl Bands {
    /// `bands` in Hz, widest first; `deviation` of the white noise.
    pub fn of(bands: &[f64], period: f64, deviation: f64, series: &[f64]) -> Self {
        let filters: Vec<LowPass> =
            bands.iter().map(|b| LowPass::new(b.min(0.2 / period), period)).collect();
        let smooth = filters.iter().map(|f| [f.smooth(0, series), f.smooth(1, series)]).collect();
        Self { filters, smooth, deviation }
    }

    /// Each sample in the narrowest band that agrees with all wider ones within so many deviations.
    /// After Lepski: the widest window whose value lies within some deviations of what the narrower
    /// windows say.
    pub fn in_agreement(&self, within: f64) -> Vec<Smoothed> {
        // Towards an end a window has one side only, and twice the noise.
        const AT_END: f64 = 2.0;
        let Self { filters, smooth, deviation } = self;
        let n = smooth[0][0].len();
        let gains: Vec<[f64; 2]> =
            filters.iter().map(|f| [0, 1].map(|d| within * deviation * f.gain(d).sqrt())).collect();
        let mut taken = vec![filters.len() - 1; n];
        for k in 0..n {
            for b in 1..filters.len() {
                let half = filters[b].half();
                let ends = if k < half || k + half >= n { AT_END } else { 1.0 };
                let apart = |w: usize, d: usize| {
                    (smooth[b][d][k] - smooth[w][d][k]).abs() > ends * gains[w][d]
                };
                if (0..b).any(|w| apart(w, 0) || apart(w, 1)) {
                    taken[k] = b - 1;
                    break;
                }
            }
        }
        // A window that reaches over a sample where only a wider band will do would carry it here.
        let wanted = taken.clone();
        for k in 0..n {
            if wanted[k] + 1 < filters.len()
                && (k == 0
                    || k + 1 == n
                    || wanted[k - 1] != wanted[k]
                    || wanted[k + 1] != wanted[k])
            {
                let reach = filters[wanted[k] + 1].half();
                for j in k.saturating_sub(reach)..(k + reach + 1).min(n) {
                    taken[j] = taken[j].min(wanted[k]);
                }
            }
        }
        let left: Vec<f64> = filters.iter().map(|f| deviation * f.gain(0).sqrt()).collect();
        let of_sample = |(k, band): (usize, usize)| {
            let [value, rate] = [0, 1].map(|d| smooth[band][d][k]);
            Smoothed { value, rate, band, deviation: left[band] }
        };
        taken.into_iter().enumerate().map(of_sample).collect()
    }
}

/// A series with so many samples for each of its own, along the cubic spline through these; the first
/// two and the last two of its pieces are one cubic each. Straight lines between three or fewer.
pub fn finer(series: &[f64], parts: usize) -> Vec<f64> {
    let n = series.len();
    if parts == 1 {
        return series.to_vec();
    }
    // Second derivatives by the sample, b[k−1] + 4 b[k] + b[k+1] = 6 (y[k−1] − 2 y[k] + y[k+1]);
    // b[0] = 2 b[1] − b[2], and the same at the other end.
    let curved = |k: usize| 6.0 * (series[k - 1] - 2.0 * series[k] + series[k + 1]);
    let mut bend = vec![0.0; n];
    if n >= 4 {
        let mut share = vec![0.0; n];
        bend[1] = curved(1) / 6.0;
        for k in 2..n - 2 {
            share[k] = 1.0 / (4.0 - share[k - 1]);
            bend[k] = share[k] * (curved(k) - bend[k - 1]);
        }
        bend[n - 2] = curved(n - 2) / 6.0;
        for k in (2..n - 2).rev() {
            bend[k] -= share[k] * bend[k + 1];
        }
        bend[0] = 2.0 * bend[1] - bend[2];
        bend[n - 1] = 2.0 * bend[n - 2] - bend[n - 3];
    }
    let between = |k: usize, u: f64| {
        let v = 1.0 - u;
        let cubic = |u: f64, bend: f64| u * (u * u - 1.0) * bend / 6.0;
        v * series[k] + u * series[k + 1] + cubic(v, bend[k]) + cubic(u, bend[k + 1])
    };
    let inner = (0..n.saturating_sub(1))
        .flat_map(|k| (0..parts).map(move |j| (k, j as f64 / parts as f64)));
    inner.map(|(k, u)| between(k, u)).chain(series.last().copied()).collect()
}

/// A series at a fractional sample position, by the cubic through its four neighbours; the ends are
/// held.
pub fn interpolate<T>(series: &[T], position: f64) -> T
where
    T: Copy
        + std::ops::Add<Output = T>
        + std::ops::Sub<Output = T>
        + std::ops::Mul<f64, Output = T>,
{
    let last = series.len() - 1;
    let position = position.clamp(0.0, last as f64);
    let k = (position.floor() as usize).min(last.saturating_sub(1));
    let s = position - k as f64;
    let at = |i: isize| series[i.clamp(0, last as isize) as usize];
    let (a, b, c, d) = (at(k as isize - 1), at(k as isize), at(k as isize + 1), at(k as isize + 2));
    let (m0, m1) = ((c - a) * 0.5, (d - b) * 0.5);
    let rise = c - b;
    b + m0 * s + (rise * 3.0 - m0 * 2.0 - m1) * (s * s) + (m0 + m1 - rise * 2.0) * (s * s * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_itself_between_its_samples_and_a_sine_to_the_fourth_order() {
        let of = |f: &dyn Fn(f64) -> f64, n: usize| {
            finer(&(0..n).map(|k| f(k as f64)).collect::<Vec<f64>>(), 5)
        };
        let cubic = |t: f64| 0.3 * t * t * t - 2.0 * t * t + t - 4.0;
        for n in [4, 5, 6, 7, 30] {
            let fine = of(&cubic, n);
            assert_eq!(fine.len(), 5 * (n - 1) + 1);
            for (k, x) in fine.iter().enumerate() {
                let expected = cubic(k as f64 / 5.0);
                assert!((x - expected).abs() < 1e-9 * expected.abs().max(1.0), "{n} {k}: {x}");
            }
        }
        // (ωh)⁴/384 of the amplitude.
        let sine = |t: f64| (0.4 * t).sin();
        let fine = of(&sine, 60);
        for k in 50..250 {
            assert!((fine[k] - sine(k as f64 / 5.0)).abs() < 1.1 * 0.4_f64.powi(4) / 384.0, "{k}");
        }
        assert_eq!(finer(&[1.0, 3.0], 2), [1.0, 2.0, 3.0]);
    }
}
