//! How noisy each instrument is: as its maker states it, or read off the recording.
//!
//! White noise lies under every frequency alike, and a machine moves slowly: above half of what a
//! series can hold, the lower half of its spectrum is noise. Lines (a spindle's) stand out of it
//! and do not count.

pub use crate::data::log::{Level, NoiseLevels};

use crate::data::log::{Log, LogKind};
use nalgebra::Vector3;
use realfft::RealFftPlanner;
use trueweld_core::JOINTS;

/// Samples in one section of a spectrum.
const SECTION: usize = 256;

/// Samples in the shortest series that noise is read off.
const SHORTEST: usize = 64;

/// The instruments of every log. What a log neither states nor shows is taken from the other logs
/// of the campaign, whose instruments are the same.
pub fn instruments(logs: &[Log]) -> Vec<NoiseLevels> {
    let mut all: Vec<NoiseLevels> = logs.iter().map(of_log).collect();
    let mut known = all.clone();
    for one in &mut all {
        for (channel, (_, levels)) in one.channels_mut().into_iter().enumerate() {
            for (column, level) in levels.iter_mut().enumerate().filter(|(_, l)| l.is_none()) {
                let of = |known: &mut NoiseLevels| known.channels_mut()[channel].1[column];
                let mut found: Vec<Level> = known.iter_mut().filter_map(of).collect();
                found.sort_by(|a, b| a.deviation.total_cmp(&b.deviation));
                *level = found.get(found.len() / 2).copied();
            }
        }
    }
    all
}

/// What a log states, and where it does not what its recording shows.
fn of_log(log: &Log) -> NoiseLevels {
    let s = &log.samples;
    let mut levels = log.noise;
    if log.kind == LogKind::StaticLoad {
        return levels;
    }
    let read = |level: &mut Option<Level>, series: &dyn Fn() -> Option<Vec<f64>>| {
        let shown = || floor(&series()?).map(|deviation| Level { deviation, stated: false });
        *level = level.or_else(shown);
    };
    let rotation = s.rotation.as_ref().map(|r| relative_rotation(r));
    let vectors = [
        (&mut levels.position, &s.position),
        (&mut levels.rotation, &rotation),
        (&mut levels.force, &s.force),
        (&mut levels.moment, &s.moment),
    ];
    for (levels, series) in vectors {
        for (i, level) in levels.iter_mut().enumerate() {
            read(level, &|| Some(series.as_ref()?.iter().map(|x| x[i]).collect()));
        }
    }
    for i in 0..JOINTS {
        read(&mut levels.encoder[i], &|| Some(s.encoder.iter().map(|q| q[i]).collect()));
        read(&mut levels.link_encoder[i], &|| s.link_encoder[i].clone());
        read(&mut levels.motor_torque[i], &|| s.motor_torque[i].clone());
    }
    levels
}

/// Rotation vectors as seen from the one before, summed up: without the flip of sign near half a
/// turn.
fn relative_rotation(rotation: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
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
pub fn floor(series: &[f64]) -> Option<f64> {
    let series: Vec<f64> = series.iter().copied().filter(|v| v.is_finite()).collect();
    if series.len() < SHORTEST {
        return None;
    }
    let n = SECTION.min(series.len());
    let window: Vec<f64> = (0..n)
        .map(|k| (std::f64::consts::PI * (k as f64 + 0.5) / n as f64).sin().powi(4))
        .collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(n);
    let mut sections = Vec::new();
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
        sections.push(output.iter().map(|z| z.norm_sqr() / power).collect::<Vec<f64>>());
        start += n / 2;
    }
    let bins = n / 2;
    // The quiet half of the sections: a jump in one of them is not noise.
    let mut spectrum: Vec<f64> = (bins / 2..bins)
        .map(|f| {
            let mut at: Vec<f64> = sections.iter().map(|s| s[f]).collect();
            at.sort_by(f64::total_cmp);
            median_of(&at) / median_of_exponential(at.len())
        })
        .collect();
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
