//! Rates of recorded series.

use super::log::{Log, LogKind};

/// Rows to either side over which a rate is taken: longer than noise matters, shorter than the
/// motion lasts. `None` for loads at rest, which have no rates.
pub fn reach(log: &Log) -> Option<usize> {
    let half = match log.kind {
        LogKind::StaticLoad => return None,
        LogKind::RingDown => 0.004,
        LogKind::FreeMotion => 0.02,
        LogKind::Weld => 0.2,
    };
    let time = &log.samples.time;
    let step = (time.last()? - time.first()?) / (time.len().max(2) - 1) as f64;
    let half: f64 = half / step;
    half.is_finite().then(|| (half.round() as usize).max(1))
}

/// Slope of a series by time, a value a row.
pub fn rate(log: &Log, series: &[f64]) -> Option<Vec<f64>> {
    let (reach, time) = (reach(log)?, &log.samples.time);
    let last = series.len().checked_sub(1)?;
    let slope = |k: usize| {
        let (a, b) = (k.saturating_sub(reach), (k + reach).min(last));
        (series[b] - series[a]) / (time[b] - time[a])
    };
    Some((0..series.len()).map(slope).collect())
}
