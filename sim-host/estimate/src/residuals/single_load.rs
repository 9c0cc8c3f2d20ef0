//! A load at rest that a model misses by far more than the others: what was hung on, or read off, may
//! be written down wrongly there.

use super::compare::Notice;
use crate::predict::{Prediction, PreparedLog};
use trueweld_logs::log::{Log, LogKind};

/// Fewest loads of which one can stand out.
const LOADS_MIN: usize = 6;

/// Least mean square of the load, in those of the noise, in the median of all loads, and in the
/// next.
const ABOVE_NOISE: f64 = 9.0;
const ABOVE_OTHERS: f64 = 9.0;
const ABOVE_NEXT: f64 = 2.0;

/// Least share of the log's squared residual.
const SQUARED_RESIDUAL_SHARE_MIN: f64 = 0.4;

/// The load of each log at rest that alone makes most of what a model that was fitted leaves of it.
pub fn single_loads(
    logs: &[Log],
    experiments: &[PreparedLog],
    fitted: &[Prediction],
) -> Vec<Notice> {
    let all = logs.iter().zip(experiments).zip(fitted);
    let at_rest = all.filter(|((log, _), _)| log.kind == LogKind::StaticLoad);
    at_rest
        .filter_map(|((log, experiment), prediction)| {
            let rows = log.samples.time.len();
            let (mut squares, mut counts) = (vec![0.0; rows], vec![0.0; rows]);
            for (compared, residual) in experiment.compared.iter().zip(&prediction.residual) {
                squares[compared.row] += residual * residual;
                counts[compared.row] += 1.0;
            }
            let (row, share) = dominant_row(&squares, &counts)?;
            let time = log.samples.time[row];
            Some(Notice::SingleLoad { log: log.name.clone(), row: row + 1, time, share })
        })
        .collect()
}

/// The row that stands out by its sum of squares of so many values, and its share of all.
fn dominant_row(squares: &[f64], counts: &[f64]) -> Option<(usize, f64)> {
    let means = squares.iter().zip(counts).map(|(square, count)| square / count);
    let means: Vec<(usize, f64)> = means.enumerate().filter(|(_, mean)| mean.is_finite()).collect();
    let (row, most) = means.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))?;
    if means.len() < LOADS_MIN {
        return None;
    }
    let mut sorted: Vec<f64> = means.iter().map(|(_, mean)| *mean).collect();
    sorted.sort_by(f64::total_cmp);
    let [median, next] = [sorted[sorted.len() / 2], sorted[sorted.len() - 2]];
    let share = squares[row] / squares.iter().sum::<f64>();
    let is_outlier = most > ABOVE_NOISE
        && most > ABOVE_OTHERS * median
        && most > ABOVE_NEXT * next
        && share > SQUARED_RESIDUAL_SHARE_MIN;
    is_outlier.then_some((row, share))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_load_stands_out_of_many_alone() {
        let counts = vec![6.0; 10];
        let mut squares = vec![6.0; 10];
        assert_eq!(dominant_row(&squares, &counts), None, "at the noise floor");
        squares[3] = 300.0;
        let (row, share) = dominant_row(&squares, &counts).expect("stands out");
        assert_eq!(row, 3);
        assert!((share - 300.0 / 354.0).abs() < 1e-12);
        squares[7] = 290.0;
        assert_eq!(dominant_row(&squares, &counts), None, "two share what is left");
        let few = dominant_row(&squares[..4], &counts[..4]);
        assert_eq!(few, None, "of four loads the fit follows each");
    }
}
