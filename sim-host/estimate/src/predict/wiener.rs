//! A smoothed series without what noise makes of it: Wiener's filter, scale by scale and place by
//! place.
//!
//! The contact makes tens of newtons of what a tracker's noise leaves in the tool's slow motion. In a
//! steady part of a weld there is nothing else in it, and a fit would have the material soft, for
//! what it saw of the tool to count less. So what the tool likeliest did goes through the effects, and
//! the rest as the nominal contact has it: it is in the residual whatever the model. The arm makes
//! micrometres of what a force sensor's noise leaves, and a joint that sticks would make none: there
//! the rest is left out, as it is of no use to know the pose by. The series is taken
//! apart into octaves (à trous, with the cubic spline's kernel: Starck and Murtagh 1994), of each of
//! which the share is kept that noise does not make of its mean square around a place: all of a ramp, and
//! of a steady part its mean.

use nalgebra::Vector3;
use trueweld_logs::fir::LowPass;

/// The kernel of one octave.
const KERNEL: [f64; 5] = [0.0625, 0.25, 0.375, 0.25, 0.0625];

/// Samples to either side over which the mean square is taken, in widths of an octave.
const MEAN_SQUARE_REACH: usize = 8;

/// What is kept of a series, octave by octave.
#[derive(Debug, Clone)]
pub(crate) struct WienerSmoother {
    /// Samples between two of those that are taken apart.
    stride: usize,
    /// Kept shares along each axis, for each octave and place.
    kept: Vec<Vec<Vector3<f64>>>,
    /// Shares of noise, and of its rate, in the slow force's band that each octave has, as it goes with the
    /// whole; the rest is slower than all.
    slow: [Vec<f64>; 2],
}

impl WienerSmoother {
    /// What to keep of a smoothed series in which noise has this autocovariance, at lags in samples;
    /// `slow`: the same of noise and of its rate in the slow force's band, but for a factor.
    pub(crate) fn of(
        series: &[Vector3<f64>],
        stride: usize,
        covariance: impl Fn(usize) -> f64,
        slow: [impl Fn(usize) -> f64; 2],
    ) -> Self {
        let seldom = thinned(series, stride);
        let octaves = octaves(&seldom);
        let covariance = at_strides(stride, covariance);
        let slow = slow.map(|covariance| {
            let covariance = at_strides(stride, covariance);
            let share = |octave| noise_share(octave, &covariance);
            (0..octaves.len()).map(share).collect()
        });
        let kept = octaves.iter().enumerate().map(|(octave, part)| {
            let noise = noise(octave, &covariance);
            let mut sums = vec![Vector3::zeros()];
            for part in part {
                sums.push(sums[sums.len() - 1] + part.component_mul(part));
            }
            let reach = MEAN_SQUARE_REACH << octave;
            let share = |k: usize| {
                let (from, to) = (k.saturating_sub(reach), (k + reach + 1).min(part.len()));
                let square = (sums[to] - sums[from]) / (to - from) as f64;
                square.map(|square| signal_share(square, noise))
            };
            (0..part.len()).map(share).collect()
        });
        Self { stride, kept: kept.collect(), slow }
    }

    /// The same of a series in the band of a filter, in which its noise, white before, was of variance one.
    pub(crate) fn of_noise_in(low: &LowPass, series: &[Vector3<f64>]) -> Self {
        let covariance = |lag: usize| low.covariance(0, lag);
        Self::of(series, low.stride(), covariance, [covariance; 2])
    }

    /// What a slope makes of the variance of noise, or of its rate (`derivative`), along an axis at a
    /// sample in the slow force's band, where what is not kept goes through the `nominal` slope.
    pub(crate) fn variance(
        &self,
        (derivative, axis): (usize, usize),
        sample: usize,
        [slope, nominal]: [f64; 2],
    ) -> f64 {
        let shares = &self.slow[derivative];
        let of_octave = |(kept, share): (&Vec<Vector3<f64>>, &f64)| {
            let kept = between(kept, self.stride, sample)[axis];
            share * (slope * kept + nominal * (1.0 - kept)).powi(2)
        };
        let slowest = 1.0 - shares.iter().sum::<f64>();
        self.kept.iter().zip(shares).map(of_octave).sum::<f64>() + slowest * slope.powi(2)
    }

    /// The same shares of another series, as long.
    pub(crate) fn keep(&self, series: &mut [Vector3<f64>]) {
        let octaves = octaves(&thinned(series, self.stride));
        let taken = |k: usize| -> Vector3<f64> {
            let parts = octaves.iter().zip(&self.kept);
            parts.map(|(part, kept)| part[k] - part[k].component_mul(&kept[k])).sum()
        };
        let taken: Vec<Vector3<f64>> = (0..octaves[0].len()).map(taken).collect();
        for (k, value) in series.iter_mut().enumerate() {
            *value -= between(&taken, self.stride, k);
        }
    }
}

/// An autocovariance at multiples of so many samples, as far as it goes.
fn at_strides(stride: usize, covariance: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..).map(|lag| covariance(lag * stride)).take_while(|c| *c != 0.0).collect()
}

/// Share of a mean square that noise of this one does not make (Wiener).
pub(super) fn signal_share(square: f64, noise: f64) -> f64 {
    if square > noise { 1.0 - noise / square } else { 0.0 }
}

/// A series known at every `stride`th sample, and at one beyond its end, at a sample, by the straight
/// line between its neighbours.
pub(super) fn between(seldom: &[Vector3<f64>], stride: usize, sample: usize) -> Vector3<f64> {
    let (before, share) = (sample / stride, (sample % stride) as f64 / stride as f64);
    seldom[before] * (1.0 - share) + seldom[before + 1] * share
}

/// Every `stride`th value, and one beyond the end.
fn thinned(series: &[Vector3<f64>], stride: usize) -> Vec<Vector3<f64>> {
    let last = series.len() - 1;
    (0..series.len() + stride).step_by(stride).map(|k| series[k.min(last)]).collect()
}

/// The octaves of a series, the shortest first; what is slower than all of them is left out. Beyond
/// its ends a series goes on as its mirror image through the last point.
fn octaves(series: &[Vector3<f64>]) -> Vec<Vec<Vector3<f64>>> {
    let mut rest = series.to_vec();
    let mut octaves = Vec::new();
    while (KERNEL.len() << octaves.len()) <= series.len() || octaves.is_empty() {
        let apart = 1 << octaves.len();
        let smooth = |k: usize| -> Vector3<f64> {
            let taps = KERNEL.iter().enumerate();
            taps.map(|(tap, w)| mirrored(&rest, k as isize + (tap as isize - 2) * apart) * *w).sum()
        };
        let slower: Vec<Vector3<f64>> = (0..rest.len()).map(smooth).collect();
        octaves.push(rest.iter().zip(&slower).map(|(a, b)| a - b).collect());
        rest = slower;
    }
    octaves
}

/// A series at a sample, beyond its ends as its mirror image through the last point.
fn mirrored(series: &[Vector3<f64>], k: isize) -> Vector3<f64> {
    let last = series.len() as isize - 1;
    let within = |k: isize| series[k.clamp(0, last) as usize];
    match k {
        k if k < 0 => within(0) * 2.0 - within(-k),
        k if k > last => within(last) * 2.0 - within(2 * last - k),
        k => within(k),
    }
}

/// Weights of the samples that an octave's value is the sum of.
fn taps(octave: usize) -> Vec<f64> {
    let mut taps = vec![1.0];
    for level in 0..=octave {
        let apart = 1 << level;
        let mut smooth = vec![0.0; taps.len() + 4 * apart];
        for (k, tap) in taps.iter().enumerate() {
            KERNEL.iter().enumerate().for_each(|(j, w)| smooth[k + j * apart] += w * tap);
        }
        if level == octave {
            smooth.iter_mut().for_each(|w| *w = -*w);
            taps.iter().enumerate().for_each(|(k, tap)| smooth[k + 2 * apart] += tap);
        }
        taps = smooth;
    }
    taps
}

/// Variance of an octave of a series with this autocovariance.
fn noise(octave: usize, covariance: &[f64]) -> f64 {
    let taps = taps(octave);
    let at_lag = |lag: usize| -> f64 {
        let products: f64 = taps.iter().zip(&taps[lag.min(taps.len())..]).map(|(a, b)| a * b).sum();
        if lag == 0 { products } else { 2.0 * products }
    };
    covariance.iter().enumerate().map(|(lag, c)| c * at_lag(lag)).sum()
}

/// Share of an octave in a series with this autocovariance: its covariance with the whole, over the variance
/// of that. All shares and that of what is slower make 1.
fn noise_share(octave: usize, covariance: &[f64]) -> f64 {
    let taps = taps(octave);
    let apart = |k: usize| k.abs_diff(taps.len() / 2);
    let with_whole =
        taps.iter().enumerate().filter_map(|(k, w)| Some(w * covariance.get(apart(k))?));
    with_whole.sum::<f64>() / covariance[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Noise of mean square 1 that is the same on every machine.
    fn white(n: usize) -> Vec<Vector3<f64>> {
        let mut state = 1_u64;
        let mut one = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5) * 12_f64.sqrt()
        };
        (0..n).map(|_| Vector3::new(one(), one(), one())).collect()
    }

    fn mean_square(series: &[Vector3<f64>]) -> f64 {
        series.iter().map(|v| v.norm_squared() / 3.0).sum::<f64>() / series.len() as f64
    }

    #[test]
    fn noise_goes_and_a_ramp_stays() {
        let noise = white(2000);
        let truth =
            |k: usize| Vector3::repeat((100.0 * (k as f64 - 500.0) / 200.0).clamp(0.0, 100.0));
        let mut seen: Vec<Vector3<f64>> =
            noise.iter().enumerate().map(|(k, n)| truth(k) + n).collect();
        let white = |lag: usize| if lag == 0 { 1.0 } else { 0.0 };
        WienerSmoother::of(&seen, 1, white, [white; 2]).keep(&mut seen);
        let left: Vec<Vector3<f64>> = seen.iter().enumerate().map(|(k, v)| v - truth(k)).collect();
        assert!(mean_square(&left[480..740]) < 1.1, "{}", mean_square(&left[480..740]));
        assert!(mean_square(&left[1000..]) < 0.15, "{}", mean_square(&left[1000..]));
    }

    #[test]
    fn octaves_have_the_noise_that_is_expected_of_them() {
        let parts = octaves(&white(20_000));
        for (octave, part) in parts.iter().enumerate().take(6) {
            let ratio = mean_square(part) / noise(octave, &[1.0]);
            assert!((ratio - 1.0).abs() < 0.2, "{octave}: {ratio}");
        }
    }
}
