//! Stamps of rows that were written in bursts: several rows at once, by a program that reads a buffer.

use super::gaps::GAP_PERIODS;
use crate::resample::is_even;

/// Least number of bursts that show a rhythm: the first and the last may be cut.
const BURSTS_MIN: usize = 5;

/// Rows that were written in bursts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bursts {
    /// Times at which the rows were taken, s: even, the last row of a burst at its stamp.
    pub times: Vec<f64>,
    /// Rows in a burst.
    pub rows: usize,
}

/// Even times of rows that came in bursts, where they are certain: bursts of one length, at an even
/// rhythm, each short beside what is between them. Times do not fall.
pub(super) fn even_times(stamps: &[f64]) -> Option<Bursts> {
    let mut steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    let quarter = steps.len() / 4;
    if steps.len() < BURSTS_MIN {
        return None;
    }
    let within = *steps.select_nth_unstable_by(quarter, f64::total_cmp).1;
    let bursts: Vec<&[f64]> = stamps.chunk_by(|a, b| b - a <= GAP_PERIODS * within).collect();
    let [first, inner @ .., last] = bursts.as_slice() else { return None };
    let rows = inner.first()?.len();
    let ends: Vec<f64> = bursts.iter().map(|burst| burst[burst.len() - 1]).collect();
    let begins = bursts[1..].iter().map(|burst| burst[0]);
    let is_short = |(burst, next): (&&[f64], f64)| {
        let end = burst[burst.len() - 1];
        // A buffer is read at the speed of a program, far within the period of the rows.
        (next - end) / rows as f64 > GAP_PERIODS * (end - burst[0])
    };
    let is_whole = bursts.len() >= BURSTS_MIN
        && rows > 1
        && inner.iter().all(|burst| burst.len() == rows)
        && first.len().max(last.len()) <= rows
        && bursts.iter().zip(begins).all(is_short)
        && is_even(&ends);
    if !is_whole {
        return None;
    }
    // The last burst may have been cut: by the rows before it.
    let count = bursts.len() - 2;
    let period = (ends[count] - ends[0]) / (count * rows) as f64;
    let rows_before = (first.len() - 1) as f64;
    let times = (0..stamps.len()).map(|k| ends[0] + period * (k as f64 - rows_before)).collect();
    Some(Bursts { times, rows })
}

#[cfg(test)]
mod tests {
    use super::even_times;

    /// Four rows of 5 ms every 20 ms, as a socket gives them; the first burst was cut.
    fn stamps(within: f64) -> Vec<f64> {
        (1..42).map(|k| 0.02 * f64::from(k / 4) + within * f64::from(k % 4)).collect()
    }

    #[test]
    fn rows_in_bursts_are_even_where_the_rhythm_is() {
        for within in [0.0, 1e-5] {
            let found = even_times(&stamps(within)).expect("bursts");
            assert_eq!(found.rows, 4);
            let off = |(k, t): (usize, &f64)| (t - found.times[0] - 0.005 * k as f64).abs();
            assert!(found.times.iter().enumerate().map(off).fold(0.0, f64::max) < 1e-9);
        }
        // Even rows, a burst that is short of a row, and two recordings with a pause.
        let even: Vec<f64> = (0..40).map(|k| 0.004 * f64::from(k)).collect();
        assert_eq!(even_times(&even), None);
        let mut short = stamps(0.0);
        short.remove(9);
        assert_eq!(even_times(&short), None);
        let paused: Vec<f64> = (0..60).map(|k| 0.004 * f64::from(k) + f64::from(k / 10)).collect();
        assert_eq!(even_times(&paused), None);
    }
}
