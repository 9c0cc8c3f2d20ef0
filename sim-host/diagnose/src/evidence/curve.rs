//! Rows of logs put together to the points of a curve.

use super::context::{Abscissa, EffectCurve, EvidenceContext, Ordinate};
use super::probe::Probe;
use super::view::CurveShape;
use std::ops::Range;
use trueweld_estimate::fit::Slopes;
use trueweld_estimate::predict::ComparedQuantity;
use trueweld_estimate::residuals::localize::ConditionBin;
use trueweld_logs::log::LogKind;

/// Points of a curve, and how many of the fitted curve's there are to each.
const CURVE_POINTS: usize = 24;
const FINER: usize = 3;

/// Points of a loop or a trace, which turns round often.
const LOOP_POINTS: usize = 100;

/// Points of a curve that lie nearer each other than this, as a share of its range, become one.
const POINT_DISTANCE_MIN: f64 = 0.005;

/// Share of the largest weight of a row up to which a row says nothing: what it has is rounding of
/// slopes.
const NEGLIGIBLE_WEIGHT: f64 = 1e-8;

/// What all compared values of one row of a log say.
#[derive(Debug, Clone, Copy)]
pub(super) struct BinRow {
    log: usize,
    row: usize,
    x: f64,
    /// Σ s², which is one over the variance of what the row asks for.
    weight: f64,
    /// −Σ s·r without the effect.
    asked: f64,
    /// The same of what the effect takes away from r.
    given: f64,
    /// Σ r² with the effect, and the number of values.
    left: f64,
    count: f64,
}

/// The rows that show anything of the quantity, log after log in order of time.
pub(super) fn rows(
    ctx: &EvidenceContext<'_>,
    probe: &Probe,
    slopes: &Slopes,
    values: &[Option<Vec<f64>>],
    shape: CurveShape,
) -> Vec<BinRow> {
    let mut rows: Vec<BinRow> = Vec::new();
    for (log, experiment) in ctx.problem.logs.iter().enumerate() {
        let (Some(slope), Some(x)) = (&slopes[log], &values[log]) else {
            continue;
        };
        // A constant says little of what swings: an arm answers its own frequencies many times
        // over.
        let swings = experiment.kind == LogKind::RingDown && matches!(probe, Probe::Port { .. });
        if swings {
            continue;
        }
        let (without, with) = (&ctx.without[log].residual, &ctx.found.residuals[log].residual);
        let mut of_row: Vec<BinRow> = x
            .iter()
            .enumerate()
            .map(|(row, x)| BinRow {
                log,
                row,
                x: *x,
                weight: 0.0,
                asked: 0.0,
                given: 0.0,
                left: 0.0,
                count: 0.0,
            })
            .collect();
        let value = probe.value(ctx);
        for (k, compared) in experiment.compared.iter().enumerate() {
            let (s, Some(row)) = (slope[k], of_row.get_mut(compared.row)) else {
                continue;
            };
            if s != 0.0 {
                // A value of the effect is asked for about where it was fitted, where the slope was
                // taken.
                let taken = value.map_or(without[k] - with[k], |v| -s * v);
                row.weight += s * s;
                row.asked -= s * (with[k] + taken);
                row.given -= s * taken;
                row.left += with[k] * with[k];
                row.count += 1.0;
            }
        }
        rows.extend(
            of_row
                .into_iter()
                .filter(|r| r.weight > 0.0 && r.x.is_finite() && shape.shows(log, r.x)),
        );
    }
    let most = rows.iter().map(|r| r.weight).fold(0.0, f64::max);
    rows.retain(|r| r.weight > NEGLIGIBLE_WEIGHT * most);
    if shape == CurveShape::Loop {
        largest_loop(&mut rows);
    }
    rows
}

/// Keeps the log with the largest loop: ∮ y dx of the effect, whose sense of turning is always the
/// same.
fn largest_loop(rows: &mut Vec<BinRow>) {
    let mut areas: Vec<(usize, f64)> = Vec::new();
    for pair in rows.windows(2).filter(|pair| pair[0].log == pair[1].log) {
        let y = |r: &BinRow| r.given / r.weight;
        let area = 0.5 * (y(&pair[0]) + y(&pair[1])) * (pair[1].x - pair[0].x);
        match areas.last_mut() {
            Some((log, sum)) if *log == pair[0].log => *sum += area,
            _ => areas.push((pair[0].log, area)),
        }
    }
    let most = areas.into_iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).map(|a| a.0);
    rows.retain(|r| Some(r.log) == most);
}

/// Rows in the order of the curve.
pub(super) fn sort(rows: &mut [BinRow], shape: CurveShape) {
    if shape == CurveShape::Curve {
        rows.sort_by(|a, b| a.x.total_cmp(&b.x));
    }
}

/// Rows of each point: steps of a curve go half by the variable and half by what the rows know, so
/// that both its range and its dense parts are resolved.
fn bins(rows: &[BinRow], shape: CurveShape, count: usize) -> Vec<Range<usize>> {
    let (Some(first), Some(last)) = (rows.first(), rows.last()) else {
        return Vec::new();
    };
    let total: f64 = rows.iter().map(|r| r.weight).sum();
    let by_x = if shape == CurveShape::Curve { 0.5 } else { 0.0 };
    let wide = (last.x - first.x).max(f64::MIN_POSITIVE);
    let mut known = 0.0;
    let mut bins: Vec<Range<usize>> = Vec::new();
    let mut of_last = usize::MAX;
    for (k, row) in rows.iter().enumerate() {
        let share =
            by_x * (row.x - first.x) / wide + (1.0 - by_x) * (known + 0.5 * row.weight) / total;
        known += row.weight;
        let bin = ((share * count as f64) as usize).min(count - 1);
        match bins.last_mut() {
            Some(range) if bin == of_last => range.end = k + 1,
            _ => bins.push(k..k + 1),
        }
        of_last = bin;
    }
    if shape == CurveShape::Curve {
        bins = bins.into_iter().fold(Vec::new(), |mut apart: Vec<Range<usize>>, bin| {
            match apart.last_mut() {
                Some(last)
                    if middle(&rows[bin.clone()]) - middle(&rows[last.clone()])
                        < POINT_DISTANCE_MIN * wide =>
                {
                    last.end = bin.end
                }
                _ => apart.push(bin),
            }
            apart
        });
    }
    bins
}

/// Weighted mean of the variable.
fn middle(rows: &[BinRow]) -> f64 {
    rows.iter().map(|r| r.weight * r.x).sum::<f64>() / rows.iter().map(|r| r.weight).sum::<f64>()
}

fn steps(shape: CurveShape) -> usize {
    if shape == CurveShape::Curve { CURVE_POINTS } else { LOOP_POINTS }
}

/// Σ y²/σ² of the fitted curve: how far the effect stands out along this variable.
pub(super) fn explained(rows: &[BinRow], shape: CurveShape) -> f64 {
    let of_bin = |rows: &[BinRow]| {
        let given: f64 = rows.iter().map(|r| r.given).sum();
        given * given / rows.iter().map(|r| r.weight).sum::<f64>()
    };
    bins(rows, shape, steps(shape)).into_iter().map(|range| of_bin(&rows[range])).sum()
}

/// What the rows ask for and what the effect gives; `None` where that is no curve.
pub(super) fn points(
    rows: &[BinRow],
    shape: CurveShape,
    sign: f64,
) -> Option<(Vec<ConditionBin>, Vec<[f64; 2]>)> {
    let count = steps(shape);
    let mut points: Vec<ConditionBin> =
        bins(rows, shape, count).into_iter().map(|range| point(&rows[range], sign)).collect();
    let mut fitted: Vec<[f64; 2]> =
        bins(rows, shape, if shape == CurveShape::Curve { FINER * count } else { count })
            .into_iter()
            .map(|range| {
                let sum = |f: fn(&BinRow) -> f64| rows[range.clone()].iter().map(f).sum::<f64>();
                [middle(&rows[range.clone()]), sign * sum(|r| r.given) / sum(|r| r.weight)]
            })
            .collect();
    points.retain(|p| p.x.is_finite() && p.y.is_finite() && p.error.is_finite());
    fitted.retain(|p| p[0].is_finite() && p[1].is_finite());
    (points.len() > 1 && fitted.len() > 1).then_some((points, fitted))
}

/// One point. Its error is that of independent noise of the size that is left with the effect, and
/// no less than what the passes through this stretch differ by: what is left of one pass is often
/// of one piece.
fn point(rows: &[BinRow], sign: f64) -> ConditionBin {
    let sum = |f: fn(&BinRow) -> f64| rows.iter().map(f).sum::<f64>();
    let weight = sum(|r| r.weight);
    let y = sum(|r| r.asked) / weight;
    let white = (sum(|r| r.left) / sum(|r| r.count)).max(1.0) / weight;
    // Rows of one pass through this stretch, in order of time.
    let mut in_time: Vec<&BinRow> = rows.iter().collect();
    in_time.sort_by_key(|r| (r.log, r.row));
    let mut passes: Vec<f64> = Vec::new();
    let mut before: Option<&BinRow> = None;
    for row in in_time {
        let own = row.asked - row.weight * y;
        match passes.last_mut() {
            Some(pass)
                if before.is_some_and(|b| b.log == row.log && row.row - b.row <= PASS_GAP_ROWS) =>
            {
                *pass += own
            }
            _ => passes.push(own),
        }
        before = Some(row);
    }
    let n = passes.len() as f64;
    let between = if n > 1.0 {
        passes.iter().map(|p| p * p).sum::<f64>() * n / (n - 1.0) / weight.powi(2)
    } else {
        0.0
    };
    ConditionBin { x: middle(rows), y: sign * y, error: white.max(between).sqrt() }
}

/// Rows that belong to one pass are no further apart: the slowest log is compared at every fiftieth
/// row or so.
const PASS_GAP_ROWS: usize = 60;

/// Mean amplitudes of the force at the orders of the spindle, along the axis of the tool where they
/// are largest.
pub(super) fn orders(ctx: &EvidenceContext<'_>) -> Option<EffectCurve> {
    let mut best: Option<(f64, EffectCurve)> = None;
    for component in 0..3_u8 {
        // By order, then cosine and sine: Σ weight·value of what is asked and given, Σ weight, Σ
        // r², number.
        let mut sums: Vec<[[f64; 5]; 2]> = Vec::new();
        for (log, experiment) in ctx.problem.logs.iter().enumerate() {
            let (without, with) = (&ctx.without[log].residual, &ctx.found.residuals[log].residual);
            for (k, c) in experiment.compared.iter().enumerate() {
                let ComparedQuantity::Ripple { order, sine } = c.quantity else {
                    continue;
                };
                if c.component != component {
                    continue;
                }
                let order = usize::from(order);
                if sums.len() < order + 1 {
                    sums.resize(order + 1, [[0.0; 5]; 2]);
                }
                let of = &mut sums[order][usize::from(sine)];
                of[0] += without[k] / c.deviation;
                of[1] += (without[k] - with[k]) / c.deviation;
                of[2] += c.deviation.powi(-2);
                of[3] += with[k] * with[k];
                of[4] += 1.0;
            }
        }
        let part = |of: &[f64; 5], which: usize| of[which] / of[2];
        let known = || sums.iter().enumerate().filter(|(_, of)| of.iter().all(|o| o[2] > 0.0));
        let points: Vec<ConditionBin> = known()
            .map(|(order, [cosine, sine])| ConditionBin {
                x: order as f64,
                y: part(cosine, 0).hypot(part(sine, 0)),
                error: (0.5
                    * ((cosine[3] + sine[3]) / (cosine[4] + sine[4])).max(1.0)
                    * (1.0 / cosine[2] + 1.0 / sine[2]))
                    .sqrt(),
            })
            .collect();
        let fitted: Vec<[f64; 2]> =
            known().map(|(order, [c, s])| [order as f64, part(c, 1).hypot(part(s, 1))]).collect();
        let largest = fitted.iter().map(|p| p[1]).fold(0.0, f64::max);
        if points.len() > 1 && largest > best.as_ref().map_or(0.0, |b| b.0) {
            let evidence = EffectCurve {
                x: Abscissa::SpindleOrder,
                y: Ordinate::ForceAmplitude(component),
                y_unit: "N",
                points,
                fitted,
            };
            best = Some((largest, evidence));
        }
    }
    best.map(|b| b.1)
}
