//! Bands of frequency in which a residual compared at the log's own rate is larger than white noise
//! of its size would be.

use super::table::ResidualTable;
use super::{ConditionBin, ConditionCurve, Finding, RowCondition, Statistic, judge, largest};
use crate::predict::ComparedQuantity;
use realfft::RealFftPlanner;
use trueweld_logs::log::{Log, LogKind};

/// Bands, each an octave wide but for the lowest.
const BANDS: usize = 8;

/// Fewest rows of a spectrum.
const SPECTRUM_ROWS_MIN: usize = 64;

/// The band that stands out of a flat spectrum.
pub(super) fn of(
    table: &ResidualTable,
    logs: &[Log],
    arrangements: &[Vec<u32>],
) -> Option<Finding> {
    let even = matches!(table.kind, LogKind::RingDown | LogKind::FreeMotion);
    // What is compared in a band of its own is not white, however good the model is.
    let filtered = table.channel == ComparedQuantity::MotorTorque.channel();
    if !even || filtered || table.spans.iter().any(|s| s.len() < SPECTRUM_ROWS_MIN) {
        return None;
    }
    // Rows of one log lie evenly; so do the logs among each other, having one kind.
    let first = &table.rows[table.spans[0].clone()];
    let time = &logs[first[0].0].samples.time;
    let step = (time[first[first.len() - 1].1] - time[first[0].1]) / (first.len() - 1) as f64;
    let highest = 0.5 / step;
    let mut planner = RealFftPlanner::<f64>::new();
    let mut power = |order: &dyn Fn(usize) -> usize| band_shares(table, &mut planner, order);
    let shares = power(&|i| i);
    let away =
        |shares: &[f64; BANDS]| 0.5 * (0..BANDS).map(|b| (shares[b] - width(b)).abs()).sum::<f64>();
    // White noise: every row for itself.
    let mut random = table.random(3);
    let arranged = arrangements.iter().map(|_| {
        let order = super::table::shuffled(table.squares.len(), &mut random);
        [away(&power(&|i| order[i] as usize))]
    });
    let [judged] = judge([away(&shares)], arranged);
    if !judged.counts() {
        return None;
    }
    let there = largest(BANDS, |b| shares[b] - width(b));
    let (low, high) = edges(there);
    let point = |b: usize| {
        let (low, high) = edges(b);
        ConditionBin { x: 0.5 * (low + high) * highest, y: shares[b] / width(b), error: 0.0 }
    };
    Some(Finding {
        variable: RowCondition::Frequency,
        low: low * highest,
        high: high * highest,
        share_there: shares[there],
        samples_there: width(there),
        curve: ConditionCurve {
            categories: Vec::new(),
            series: None,
            y_unit: "",
            points: (0..BANDS).map(point).collect(),
        },
        ..table.finding(Statistic::Size, judged)
    })
}

/// Share of the power in each band, over all series of the table with its rows in this order.
fn band_shares(
    table: &ResidualTable,
    planner: &mut RealFftPlanner<f64>,
    order: &dyn Fn(usize) -> usize,
) -> [f64; BANDS] {
    let mut bands = [0.0; BANDS];
    for span in &table.spans {
        let transform = planner.plan_fft_forward(span.len());
        let (mut input, mut output) = (transform.make_input_vec(), transform.make_output_vec());
        for series in 0..table.series.len() {
            for (x, i) in input.iter_mut().zip(span.clone()) {
                *x = table.row(order(i))[series];
            }
            if transform.process(&mut input, &mut output).is_err() {
                continue;
            }
            let lines = output.len() - 1;
            for (line, z) in output.iter().enumerate().skip(1) {
                bands[band(line as f64 / lines as f64)] += z.norm_sqr();
            }
        }
    }
    let total: f64 = bands.iter().sum();
    bands.map(|b| b / total)
}

/// Band of a frequency, as a share of the highest.
fn band(share: f64) -> usize {
    (0..BANDS).find(|b| share <= edges(*b).1).unwrap_or(BANDS - 1)
}

/// Ends of a band, as shares of the highest frequency.
fn edges(band: usize) -> (f64, f64) {
    let end = |b: usize| 0.5_f64.powi((BANDS - 1 - b) as i32);
    (if band == 0 { 0.0 } else { end(band - 1) }, end(band))
}

/// Share of all frequencies in a band.
fn width(band: usize) -> f64 {
    let (low, high) = edges(band);
    high - low
}
