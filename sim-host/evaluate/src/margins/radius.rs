//! The spectral radius of the loop, from what comes back of an impulse at every channel.
//!
//! It is that of the slowest mode in the later half of an answer. The smallest direction that the
//! decomposition keeps is disturbed by what is just below its cut, and may look like a mode that
//! lasts. Such a one dies out with the answer; a real one is left over. Where the radius is near 1 or
//! beyond, a longer answer therefore decides.

use super::decay::Modes;
use super::response::{LOOP_CHANNELS, LoopSignals};
use nalgebra::DMatrix;

/// Where what is left of an impulse is lost in rounding, of its largest.
const IMPULSE_ROUNDING: f64 = 2e-6;

/// Samples of a second from which the slowest mode is taken, and the share of them below which a
/// direction is rounding.
const A_SECOND: f64 = 10.0;
const DECAY_RANK_SHARE: f64 = 1e-3;

/// A mode that dies out more slowly than this, 1/s, may as well last: in the five seconds that it is
/// taken from it loses a tenth.
const UNDECIDED: f64 = 0.02;

/// True where a longer answer is needed to tell whether the loop is stable.
pub(crate) fn is_undecided(radius: f64, period: f64) -> bool {
    radius >= (-UNDECIDED * period).exp()
}

/// The slowest mode of what stands of impulses above rounding, over the later half of that time.
/// Samples are so far apart that a second has [`A_SECOND`] of them; what turns faster between them
/// keeps its size.
pub(crate) fn radius(responses: &[Vec<LoopSignals>], period: f64) -> f64 {
    let apart = (1.0 / (A_SECOND * period)).round().max(1.0) as usize;
    let scaled = scaled(responses, apart);
    let last =
        scaled.iter().filter_map(|s| s.iter().rposition(|v| v.abs() > IMPULSE_ROUNDING)).max();
    let from = last.unwrap_or(0) / 2;
    let count = last.map_or(0, |last| last + 1 - from);
    let samples = DMatrix::from_fn(scaled.len(), count, |i, k| scaled[i][from + k]);
    // An answer that is no number is none of a loop that is stable.
    if samples.iter().any(|sample| !sample.is_finite()) {
        return f64::INFINITY;
    }
    let modes = Modes::of(&samples, DECAY_RANK_SHARE);
    let largest = modes.map_or(0.0, |m| m.poles.iter().map(|p| p.norm()).fold(0.0, f64::max));
    largest.powf(1.0 / apart as f64)
}

/// The same of an answer that goes on after its first `short` periods. Where less than the share of a
/// mode is left at its end of what was left of the short one, nothing lasts, and the radius is that
/// of this decay.
pub(crate) fn radius_of_longer(responses: &[Vec<LoopSignals>], short: usize, period: f64) -> f64 {
    let scaled = scaled(responses, 1);
    let periods = responses.first().map_or(0, Vec::len);
    let half = short / 2;
    let [before, after] = [short, periods].map(|end| {
        let late = scaled.iter().flat_map(|s| &s[end - half..end]);
        late.map(|v| v.abs()).fold(0.0, f64::max)
    });
    if after < DECAY_RANK_SHARE * before {
        return (after / before).powf(1.0 / (periods - short) as f64);
    }
    radius(responses, period)
}

/// Every signal of every answer by its own largest, so that metres and newtons count alike; one
/// sample of every `apart`.
fn scaled(responses: &[Vec<LoopSignals>], apart: usize) -> Vec<Vec<f64>> {
    let signals = responses.iter().flat_map(|r| (0..LOOP_CHANNELS).map(move |i| (r, i)));
    let scaled = signals.map(|(r, i)| {
        let largest = r.iter().map(|row| row[i].abs()).fold(f64::MIN_POSITIVE, f64::max);
        r.iter().step_by(apart).map(|row| row[i] / largest).collect()
    });
    scaled.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PERIOD: f64 = 0.012;
    const SHORT: usize = 833;

    /// Answers whose signals hold a mode that dies at 0.376 1/s, and one of 2 % of it that changes at
    /// `rate`.
    fn answers(rate: f64) -> Vec<Vec<LoopSignals>> {
        let signal = |k: usize, channel: usize| {
            let (t, phase) = (k as f64 * PERIOD, channel as f64);
            (-0.376 * t).exp() * (2.48 * t + phase).cos()
                + 0.02 * (rate * t).exp() * (0.8 * t + 2.0 * phase).sin()
        };
        let answer =
            |c: usize| (0..4 * SHORT).map(|k| std::array::from_fn(|i| signal(k, i + c))).collect();
        (0..LOOP_CHANNELS).map(answer).collect()
    }

    #[test]
    fn a_longer_answer_tells_what_lasts_from_what_dies_out() {
        // Two modes are told exactly; what dies out is told by what is left of all.
        for rate in [-0.01, 0.0, 0.01] {
            let radius = radius_of_longer(&answers(rate), SHORT, PERIOD);
            assert!((radius.ln() / PERIOD - rate).abs() < 1e-3, "{rate}: {}", radius.ln() / PERIOD);
        }
        let radius = radius_of_longer(&answers(-0.5), SHORT, PERIOD);
        assert!((radius.ln() / PERIOD + 0.376).abs() < 0.03, "{}", radius.ln() / PERIOD);
    }
}
