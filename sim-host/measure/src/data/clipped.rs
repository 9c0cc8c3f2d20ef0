//! Stretches in which an instrument is at the end of its range: it reads its limit, not what it
//! measures.

use super::floor::resolution;
use std::ops::Range;

/// Rows in the shortest run at a limit: noise does not make an instrument read the same as often,
/// and a run of fewer hides little.
const SHORTEST: usize = 5;

/// Most rows between two runs at a limit that belong to the stretch: readings there are those of
/// which the noise has one sign.
const BETWEEN: usize = 5;

/// Rows on either side of a run in which the reading must be noisy.
const AROUND: usize = 25;

/// Least fourth difference, as a share of the first, of a series that is noisy: of white noise it is
/// 6, of an arm that comes to rest smoothly, or swings at a tenth of the rate of the rows, 0.01.
const NOISY: f64 = 0.05;

/// Least noise in steps of the instrument's resolution. Below, it may read the same often.
const RESOLVED: f64 = 3.0;

/// Most pairs of neighbouring readings, as a share, that are the same in a finely resolved series.
const ALIKE: f64 = 0.1;

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
/// beside it; where none of that changes either, the instrument stands still for another reason,
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
        // Never off its limit: that it is noisy is told by the others alone.
        let of = |limit| at(limit, runs(&limit));
        let moves = |c: &Clipped| c.rows >= SHORTEST && any_moves(others, &c.stretches);
        return limits.into_iter().map(of).filter(moves).collect();
    }
    let all: Vec<Range<usize>> = limits.iter().flat_map(runs).collect();
    if !is_fine(series, &all) {
        return Vec::new();
    }
    let is_clipped = |limit: &f64| {
        let runs = runs(limit);
        let long: Vec<Range<usize>> =
            runs.iter().filter(|r| r.len() >= SHORTEST).cloned().collect();
        !long.is_empty()
            && is_noisy(series, *limit, &long)
            && (others.is_empty() || any_moves(others, &long))
    };
    limits.retain(is_clipped);
    limits.into_iter().map(|limit| at(limit, runs(&limit))).collect()
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
    pairs > 0 && same as f64 <= ALIKE * f64::from(pairs)
}

/// True where readings beside runs at a limit are noisy by more than the instrument resolves.
fn is_noisy(series: &[f64], limit: f64, runs: &[Range<usize>]) -> bool {
    let (mut first, mut fourth) = (Vec::new(), Vec::new());
    let mut beside = |rows: Range<usize>| {
        for w in series[rows].windows(5) {
            if w.iter().all(|v| v.is_finite() && *v != limit) {
                first.push((w[1] - w[0]).abs());
                fourth.push((w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs());
            }
        }
    };
    for run in runs {
        beside(run.start.saturating_sub(AROUND)..run.start);
        beside(run.end..(run.end + AROUND).min(series.len()));
    }
    let (Some(first), Some(fourth)) = (median(&mut first), median(&mut fourth)) else {
        return false;
    };
    // The fourth difference of white noise σ has the deviation √70 σ, and its magnitude a median of
    // 0.6745 of that.
    let deviation = fourth / (0.6745 * 70f64.sqrt());
    fourth > NOISY * first && deviation > RESOLVED * resolution(series)
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

fn median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f64::total_cmp).1)
}
