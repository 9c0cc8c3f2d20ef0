//! How noisy a recorded series is, by itself.
//!
//! White noise lies under every frequency alike, and a machine moves slowly: above half of what a
//! series can hold, the lower half of its spectrum is noise. Lines (a spindle's) stand out of it
//! and do not count.

use nalgebra::Vector3;
use realfft::RealFftPlanner;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};

/// Samples in one section of a spectrum.
const SECTION: usize = 256;

/// Samples in the shortest series that noise is read off.
const NOISE_SAMPLES_MIN: usize = 64;

/// Rotation vectors as seen from the one before, summed up: without the flip of sign near half a
/// turn. NaN where there is none.
pub(super) fn relative_rotation(rotation: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut sum = Vector3::zeros();
    let mut before = rotation.first().map(rotation_from_vector);
    let mut relative = Vec::with_capacity(rotation.len());
    for vector in rotation {
        let now = rotation_from_vector(vector);
        if let Some(b) = before.filter(|b| b.sum().is_finite()) {
            let turned = rotation_vector(&b.tr_mul(&now));
            if turned.sum().is_finite() {
                sum += turned;
            }
        }
        if now.sum().is_finite() {
            before = Some(now);
            relative.push(sum);
        } else {
            relative.push(Vector3::repeat(f64::NAN));
        }
    }
    relative
}

/// Standard deviation of the white noise under a series: the median over the upper half of its
/// frequencies of Welch's averaged spectrum. `None` where the series is too short, or has no noise
/// at all.
pub(super) fn floor(series: &[f64]) -> Option<f64> {
    let series: Vec<f64> = series.iter().copied().filter(|v| v.is_finite()).collect();
    let upper = upper_half(&series)?;
    // The quiet half of the sections: a jump in one of them is not noise.
    let mut spectrum: Vec<f64> = upper.iter().map(|at| quiet(at)).collect();
    spectrum.sort_by(f64::total_cmp);
    let variance = median_of(&spectrum);
    // An instrument with a step and less noise than that: the step's own.
    let mut steps: Vec<f64> =
        series.windows(2).map(|w| (w[1] - w[0]).abs()).filter(|d| *d > 0.0).collect();
    steps.sort_by(f64::total_cmp);
    let step = steps.first().copied().unwrap_or(0.0) / 12f64.sqrt();
    let deviation = variance.sqrt().max(step);
    (deviation > 0.0 && deviation.is_finite()).then_some(deviation)
}

/// Standard deviation of the noise of a series that is white from beginning to end, and more than the
/// instrument's step: as strong in either part of the upper half of its frequencies, and in a
/// loud section as in a quiet one. A wave that a machine's speed sweeps through the frequencies is
/// neither, nor is what rings after an impact, or a filtered channel. `None` of any other series.
pub(super) fn white(series: &[f64]) -> Option<f64> {
    /// Fewest sections that show whether noise stays the same.
    const FLOOR_SECTIONS_MIN: usize = 4;
    /// Largest ratio of deviations that are the same: those of 64 frequencies in 4 sections scatter
    /// by 5 %.
    const EQUAL_NOISE_RATIO: f64 = 1.25;
    let step = resolution(series);
    let upper = upper_half(&even(series)?).filter(|upper| upper[0].len() >= FLOOR_SECTIONS_MIN)?;
    let deviation = |of: &dyn Fn(&[f64]) -> f64, part: &[Vec<f64>]| {
        let mut spectrum: Vec<f64> = part.iter().map(|at| of(at)).collect();
        spectrum.sort_by(f64::total_cmp);
        median_of(&spectrum).sqrt()
    };
    let (lower, higher) = upper.split_at(upper.len() / 2);
    let mean = |at: &[f64]| at.iter().sum::<f64>() / at.len() as f64;
    let all = deviation(&quiet, &upper);
    let parts = [deviation(&quiet, lower), deviation(&quiet, higher), deviation(&mean, &upper)];
    let same = |part: &f64| *part < EQUAL_NOISE_RATIO * all && all < EQUAL_NOISE_RATIO * part;
    (all > step && parts.iter().all(same)).then_some(all)
}

/// The readings of a series at even times: all, of which few are missing and filled, or those of an
/// instrument that is read more seldom. What moves would jump where readings are left out.
fn even(series: &[f64]) -> Option<Vec<f64>> {
    /// Most readings, as a share, that may be missing.
    const MISSING_READINGS_MAX: f64 = 0.1;
    let known: Vec<usize> = (0..series.len()).filter(|k| series[*k].is_finite()).collect();
    let (first, last) = (*known.first()?, *known.last()?);
    let every = known.windows(2).map(|w| w[1] - w[0]).max().unwrap_or(1);
    let all_even = known.windows(2).all(|w| w[1] - w[0] == every);
    let length = last + 1 - first;
    if !all_even && (length - known.len()) as f64 > MISSING_READINGS_MAX * length as f64 {
        return None;
    }
    let mut out = vec![series[first]];
    for (i, pair) in known.windows(2).enumerate() {
        if !all_even {
            // By the cubic through two readings on either side: a fast motion is curved.
            let around = &known[i.saturating_sub(1)..(i + 3).min(known.len())];
            out.extend((pair[0] + 1..pair[1]).map(|k| through(series, around, k)));
        }
        out.push(series[pair[1]]);
    }
    Some(out)
}

/// The polynomial through some readings of a series, at a row.
fn through(series: &[f64], readings: &[usize], row: usize) -> f64 {
    let apart = |a: usize, b: usize| a as f64 - b as f64;
    let weight = |i: usize| {
        let others = readings.iter().filter(|j| **j != i);
        others.map(|j| apart(row, *j) / apart(i, *j)).product::<f64>()
    };
    readings.iter().map(|i| weight(*i) * series[*i]).sum()
}

/// Welch's spectrum over the upper half of the frequencies of a series, by frequency and section:
/// variance per sample. `None` where the series is too short.
fn upper_half(series: &[f64]) -> Option<Vec<Vec<f64>>> {
    if series.len() < NOISE_SAMPLES_MIN {
        return None;
    }
    let n = SECTION.min(series.len());
    let window: Vec<f64> = (0..n)
        .map(|k| (std::f64::consts::PI * (k as f64 + 0.5) / n as f64).sin().powi(4))
        .collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let bins = n / 2;
    let mut upper = vec![Vec::new(); bins - bins / 2];
    let mut start = 0;
    while start + n <= series.len() {
        let part = &series[start..start + n];
        // The straight line through the ends, so that a slow walk does not leak upwards.
        let (a, b) = (part[0], (part[n - 1] - part[0]) / (n - 1) as f64);
        let mut input: Vec<f64> = part
            .iter()
            .zip(&window)
            .enumerate()
            .map(|(k, (v, w))| (v - a - b * k as f64) * w)
            .collect();
        let mut output = transform.make_output_vec();
        transform.process(&mut input, &mut output).ok()?;
        for (at, z) in upper.iter_mut().zip(&output[bins / 2..bins]) {
            at.push(z.norm_sqr() / power);
        }
        start += n / 2;
    }
    Some(upper)
}

/// Mean of an exponentially distributed value, by its median.
fn quiet(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    median_of(&sorted) / median_of_exponential(sorted.len())
}

fn median_of(sorted: &[f64]) -> f64 {
    let n = sorted.len();
    if n % 2 == 1 { sorted[n / 2] } else { 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]) }
}

/// Expected median of so many independent values of mean 1, exponentially distributed as a
/// spectrum's are.
fn median_of_exponential(n: usize) -> f64 {
    // The kth smallest of n has the mean Σ 1/(n − j), j = 0 … k − 1.
    let order = |k: usize| (0..k).map(|j| 1.0 / (n - j) as f64).sum::<f64>();
    if n % 2 == 1 { order(n / 2 + 1) } else { 0.5 * (order(n / 2) + order(n / 2 + 1)) }
}

/// Smallest difference between two readings: what the instrument resolves. What rounding of a
/// conversion of units makes is none.
pub(super) fn resolution(series: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = series.iter().copied().filter(|v| v.is_finite()).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    let largest =
        sorted.first().into_iter().chain(sorted.last()).fold(0.0_f64, |m, v| m.max(v.abs()));
    let apart = sorted.windows(2).map(|w| w[1] - w[0]);
    apart.filter(|d| *d > 1e-13 * largest).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    const DEVIATION: f64 = 3e-5;

    fn noise() -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || -> f64 { StandardNormal.sample(&mut random) };
        (0..2000).map(|_| DEVIATION * normal()).collect()
    }

    fn with(of: impl Fn(f64) -> f64) -> Vec<f64> {
        noise().iter().enumerate().map(|(k, n)| n + of(k as f64)).collect()
    }

    /// The medians know it to 5 %, three times of that; what is filled takes another 5 %.
    fn is_known(series: &[f64]) {
        let shown = white(series).expect("white");
        assert!((shown / DEVIATION - 1.0).abs() < 0.2, "{shown}");
    }

    #[test]
    fn white_noise_shows_under_motion_lines_and_missing_readings() {
        let motion = |k: f64| 0.5 * (k / 60.0).sin();
        is_known(&with(motion));
        is_known(&with(|k| motion(k) + 1e-3 * (2.0 * k).sin()));
        let missing = |series: Vec<f64>, lost: &dyn Fn(usize) -> bool| -> Vec<f64> {
            let of = |(k, v): (usize, f64)| if lost(k) { f64::NAN } else { v };
            series.into_iter().enumerate().map(of).collect()
        };
        is_known(&missing(with(motion), &|k| k * k % 31 == 4));
        is_known(&missing(with(motion), &|k| k % 2 == 1));
    }

    #[test]
    fn noise_that_is_not_white_throughout_is_not_taken_for_white() {
        let none = |series: &[f64]| assert_eq!(white(series), None);
        // What turns faster and slower, an impact, a filter, a value held for three rows.
        none(&with(|k| 2e-4 * (600.0 * (k / 200.0).sin()).sin()));
        none(&with(|k| 1e-2 * (-(k % 1000.0) / 30.0).exp() * (2.2 * k).sin()));
        let filtered = noise().windows(3).map(|w| w.iter().sum::<f64>() / 3.0).collect::<Vec<_>>();
        none(&filtered);
        let held: Vec<f64> = (0..2000).map(|k| noise()[k - k % 3]).collect();
        none(&held);
        // Less than the instrument resolves.
        let coarse: Vec<f64> = noise().iter().map(|v| (v / 1e-4).round() * 1e-4).collect();
        none(&coarse);
    }
}
