//! Stretches in which an instrument is at the end of its range: it reads its limit, not what it
//! measures.

use super::floor::resolution;
use super::median;
use std::ops::Range;

/// Rows in the shortest run at a limit: noise does not make an instrument read the same as often,
/// and a run of fewer hides little.
const LIMIT_RUN_ROWS_MIN: usize = 5;

/// Most rows between two runs at a limit that belong to the stretch: readings there are those of
/// which the noise has one sign.
const BETWEEN: usize = 5;

/// Rows on either side of a run in which the reading must be noisy.
const NOISY_NEIGHBOURS: usize = 25;

/// Least fourth difference, as a share of the first, of a series that is noisy: of white noise it is
/// 6, of an arm that comes to rest smoothly, or swings at a tenth of the rate of the rows, 0.01.
const NOISY: f64 = 0.05;

/// Least noise in steps of the instrument's resolution. Below, it may read the same often.
const RESOLVED_NOISE_STEPS: f64 = 3.0;

/// Most pairs of neighbouring readings, as a share, that are the same in a finely resolved series.
const REPEATED_SHARE_MAX: f64 = 0.1;

/// A series that is at its limit now and then.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Clipped {
    /// What it reads there.
    pub limit: f64,
    /// The stretches.
    pub stretches: Vec<Range<usize>>,
    /// Rows in them that read the limit.
    pub rows: usize,
}

/// Where a series is at its upper, or lower, limit. `others`: what the same instrument reads
/// beside it; where none of that changes either, all of it stands still for another reason,
/// such as a brake that is closed. A limit of 0 is none: nothing presses on the sensor then.
/// `centred`: a range lies about 0, so that a limit is among the largest magnitudes.
pub(crate) fn clipped(series: &[f64], others: &[&[f64]], centred: bool) -> Vec<Clipped> {
    let finite = || series.iter().copied().filter(|v| v.is_finite());
    let [least, most] = [f64::min, f64::max].map(|f| finite().reduce(f).unwrap_or(0.0));
    let largest = least.abs().max(most.abs());
    let mut limits = vec![most, least];
    limits.dedup();
    limits.retain(|limit| *limit != 0.0 && (!centred || limit.abs() > 0.5 * largest));
    let at = |limit: f64, runs: Vec<Range<usize>>| Clipped {
        limit,
        rows: runs.iter().map(Range::len).sum(),
        stretches: joined(runs),
    };
    let runs = |limit: &f64| runs(series, *limit);
    if least == most {
        // Never off its limit: what is noisy beside it tells that it should be. A coordinate may well
        // stay where it is.
        let noise = others.iter().any(|series| {
            let whole = 0..series.len();
            is_noisy(series, f64::NAN, &[whole])
        });
        let of = |limit| at(limit, runs(&limit));
        let found =
            limits.into_iter().map(of).filter(|c| centred && noise && c.rows >= LIMIT_RUN_ROWS_MIN);
        return found.collect();
    }
    let all: Vec<Range<usize>> = limits.iter().flat_map(runs).collect();
    if !is_fine(series, &all) {
        return Vec::new();
    }
    limits.retain(|limit| stays_at(series, others, *limit));
    limits.into_iter().map(|limit| at(limit, runs(&limit))).collect()
}

/// True where a series that is noisy beside a limit stays at it for long while others move.
fn stays_at(series: &[f64], others: &[&[f64]], limit: f64) -> bool {
    let mut long = runs(series, limit);
    long.retain(|run| run.len() >= LIMIT_RUN_ROWS_MIN);
    !long.is_empty()
        && is_noisy(series, limit, &neighbouring_rows(&long, series.len()))
        && (others.is_empty() || any_moves(others, &long))
}

/// Runs of rows that read a value.
fn runs(series: &[f64], value: f64) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for (k, v) in series.iter().enumerate() {
        match runs.last_mut() {
            _ if *v != value => {}
            Some(last) if last.end == k => last.end = k + 1,
            _ => runs.push(k..k + 1),
        }
    }
    runs
}

/// Runs with those that lie close together as one.
fn joined(runs: Vec<Range<usize>>) -> Vec<Range<usize>> {
    let mut out: Vec<Range<usize>> = Vec::new();
    for run in runs {
        match out.last_mut() {
            Some(last) if run.start <= last.end + BETWEEN => last.end = run.end,
            _ => out.push(run),
        }
    }
    out
}

/// True where neighbouring readings outside the runs are hardly ever the same.
fn is_fine(series: &[f64], runs: &[Range<usize>]) -> bool {
    let mut outside = vec![true; series.len()];
    runs.iter().for_each(|run| outside[run.clone()].fill(false));
    let (mut pairs, mut same) = (0, 0);
    for (pair, outside) in series.windows(2).zip(outside.windows(2)) {
        if outside == [true, true] && pair[0].is_finite() && pair[1].is_finite() {
            pairs += 1;
            same += usize::from(pair[0] == pair[1]);
        }
    }
    pairs > 0 && same as f64 <= REPEATED_SHARE_MAX * f64::from(pairs)
}

/// Rows beside runs.
fn neighbouring_rows(runs: &[Range<usize>], length: usize) -> Vec<Range<usize>> {
    let of = |run: &Range<usize>| {
        [
            run.start.saturating_sub(NOISY_NEIGHBOURS)..run.start,
            run.end..(run.end + NOISY_NEIGHBOURS).min(length),
        ]
    };
    runs.iter().flat_map(of).collect()
}

/// True where the readings of a series in some rows, off its limit, are noisy by more than the
/// instrument resolves.
fn is_noisy(series: &[f64], limit: f64, rows: &[Range<usize>]) -> bool {
    let (mut first, mut fourth) = (Vec::new(), Vec::new());
    for w in rows.iter().flat_map(|rows| series[rows.clone()].windows(5)) {
        if w.iter().all(|v| v.is_finite() && *v != limit) {
            first.push((w[1] - w[0]).abs());
            fourth.push((w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs());
        }
    }
    let (Some(first), Some(fourth)) = (median(&mut first), median(&mut fourth)) else {
        return false;
    };
    // The fourth difference of white noise σ has the deviation √70 σ, and its magnitude a median of
    // 0.6745 of that.
    let deviation = fourth / (0.6745 * 70f64.sqrt());
    fourth > NOISY * first && deviation > RESOLVED_NOISE_STEPS * resolution(series)
}

/// True where something else that the instrument reads changes in most of each run.
fn any_moves(others: &[&[f64]], runs: &[Range<usize>]) -> bool {
    let changes = |series: &&[f64], run: &Range<usize>| {
        let pairs = series[run.clone()].windows(2);
        let changed = pairs.clone().filter(|w| w[0] != w[1] && (w[0] - w[1]).is_finite()).count();
        2 * changed > pairs.len()
    };
    runs.iter().all(|run| others.iter().any(|series| changes(series, run)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};

    fn noisy(deviation: f64, of: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut noise = || -> f64 { StandardNormal.sample(&mut random) };
        (0..1000).map(|k| of(f64::from(k)) + deviation * noise()).collect()
    }

    fn torque() -> Vec<f64> {
        noisy(20.0, |k| 4000.0 * (k / 80.0).sin())
    }

    #[test]
    fn a_drive_at_its_limit_is_clipped_where_it_is() {
        let other = noisy(20.0, |k| 500.0 * (k / 60.0).cos());
        let series: Vec<f64> = torque().iter().map(|v| v.clamp(-3500.0, 3500.0)).collect();
        let found = clipped(&series, &[&other], true);
        assert_eq!(found.iter().map(|c| c.limit).collect::<Vec<_>>(), [3500.0, -3500.0]);
        for c in &found {
            // Two crests of each sign, and at most a few rows between runs beside each.
            assert_eq!(c.rows, series.iter().filter(|v| **v == c.limit).count());
            let stretched: usize = c.stretches.iter().map(Range::len).sum();
            assert!((c.rows..c.rows + 40).contains(&stretched), "{c:?}");
        }
        // At its limit from the first row to the last: the drives beside it tell.
        let always = vec![-8000.0; 1000];
        assert_eq!(clipped(&always, &[&other], true)[0].rows, 1000);
        assert!(clipped(&always, &[], true).is_empty());
        assert!(clipped(&always, &[&always], true).is_empty());
    }

    #[test]
    fn what_is_constant_by_itself_is_not_clipped() {
        let none = |series: &[f64], others: &[&[f64]], centred: bool| {
            let found = clipped(series, others, centred);
            assert!(found.is_empty(), "{found:?}");
        };
        let other = noisy(20.0, |k| 500.0 * (k / 60.0).cos());
        none(&torque(), &[&other], true);
        // An arm that stands, moves smoothly and stands again, without noise and with one that the
        // instrument hardly resolves.
        let smooth = |k: f64| {
            let s = ((k - 300.0) / 400.0).clamp(0.0, 1.0);
            0.3 * s * s * (3.0 - 2.0 * s)
        };
        none(&noisy(0.0, smooth), &[&other], false);
        let coarse = |deviation: f64| -> Vec<f64> {
            noisy(deviation, smooth).iter().map(|v| (v / 1e-4).round() * 1e-4).collect()
        };
        none(&coarse(1e-5), &[&other], false);
        none(&coarse(1e-4), &[&other], false);
        // A sensor that reads nothing, or an offset, until it is pressed.
        for offset in [0.0, 12.0] {
            let contact = noisy(25.0, |k| -60.0 * (k - 400.0));
            let force: Vec<f64> =
                (0..1000).map(|k| if k < 400 { offset } else { contact[k] }).collect();
            none(&force, &[&other], true);
        }
        // A closed brake: none of the drives does anything.
        let braked = |series: Vec<f64>| -> Vec<f64> {
            (0..1000).map(|k| if k < 300 { 6000.0 } else { series[k] }).collect()
        };
        none(&braked(torque()), &[&braked(other.clone())], true);
    }
}
