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
const SHORTEST: usize = 64;

/// Rotation vectors as seen from the one before, summed up: without the flip of sign near half a
/// turn.
pub(super) fn relative_rotation(rotation: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let mut sum = Vector3::zeros();
    let mut before = rotation.first().map(rotation_from_vector);
    let step = |r: &Vector3<f64>| {
        let now = rotation_from_vector(r);
        if let Some(b) = before.filter(|b| b.sum().is_finite()) {
            let turned = rotation_vector(&b.tr_mul(&now));
            if turned.sum().is_finite() {
                sum += turned;
            }
        }
        if now.sum().is_finite() {
            before = Some(now);
        }
        sum
    };
    rotation.iter().map(step).collect()
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
    const SECTIONS: usize = 4;
    /// Largest ratio of deviations that are the same: those of 64 frequencies in 4 sections scatter
    /// by 5 %.
    const SAME: f64 = 1.25;
    let series: Vec<f64> = series.iter().copied().filter(|v| v.is_finite()).collect();
    let upper = upper_half(&series).filter(|upper| upper[0].len() >= SECTIONS)?;
    let deviation = |of: &dyn Fn(&[f64]) -> f64, part: &[Vec<f64>]| {
        let mut spectrum: Vec<f64> = part.iter().map(|at| of(at)).collect();
        spectrum.sort_by(f64::total_cmp);
        median_of(&spectrum).sqrt()
    };
    let (lower, higher) = upper.split_at(upper.len() / 2);
    let mean = |at: &[f64]| at.iter().sum::<f64>() / at.len() as f64;
    let all = deviation(&quiet, &upper);
    let parts = [deviation(&quiet, lower), deviation(&quiet, higher), deviation(&mean, &upper)];
    let same = |part: &f64| *part < SAME * all && all < SAME * part;
    (all > resolution(&series) && parts.iter().all(same)).then_some(all)
}

/// Welch's spectrum over the upper half of the frequencies of a series, by frequency and section:
/// variance per sample. `None` where the series is too short.
fn upper_half(series: &[f64]) -> Option<Vec<Vec<f64>>> {
    if series.len() < SHORTEST {
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

/// Smallest step between two readings: what the instrument resolves. What rounding of a conversion of
/// units makes is no step.
pub(super) fn resolution(series: &[f64]) -> f64 {
    let largest = series.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    let steps = series.windows(2).map(|w| (w[1] - w[0]).abs());
    steps.filter(|d| *d > 1e-13 * largest).fold(f64::INFINITY, f64::min)
}
