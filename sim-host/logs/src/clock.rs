//! How the clock of one instrument runs against that of another, from one motion that both saw.
//!
//! The speeds that both saw are correlated, which needs no common frame; then offset and drift are
//! fitted together with the rigid motion between the frames:
//!
//! ```text
//! p(τ) = R x((τ − o)/(1 + d)) + c
//! ```
//!
//! Left out: instruments that see no point of the arm.

use super::fir::interpolate;
use super::resample::median_step;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use realfft::RealFftPlanner;
use trueweld_core::spatial::{rotation_from_vector, skew};

/// Time of an instrument = offset + (1 + drift) · the log's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClockMap {
    /// Time of the instrument where the log's is 0, s.
    pub offset: f64,
    /// What its clock gains, s per s.
    pub drift: f64,
}

impl ClockMap {
    /// A clock that is the log's own.
    pub const OWN: Self = Self { offset: 0.0, drift: 0.0 };

    /// The log's time at a time of the instrument, s.
    pub fn own(&self, instrument: f64) -> f64 {
        (instrument - self.offset) / (1.0 + self.drift)
    }
}

/// A clock that was fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FittedClock {
    /// The clock.
    pub map: ClockMap,
    /// Standard deviations of its offset, s, and its drift.
    pub deviation: [f64; 2],
    /// What is left between what both saw, m: root mean square.
    pub left: f64,
}

/// Points by time; the times rise.
pub struct Points<'p> {
    /// Times, s.
    pub time: &'p [f64],
    /// Points, m; NaN where none was seen.
    pub point: &'p [Vector3<f64>],
}

/// Crystals are good to this.
pub const DRIFT: f64 = 1e-4;

/// What an arm's effects that no model has leave between what both saw, m. It is no noise: it does not
/// average out, and a clock is not bent to it.
const UNMODELLED_MOTION: f64 = 5e-4;

/// How well a correlation finds the offset: steps of its grid.
const FOUND: f64 = 4.0;

/// Points that a clock is fitted to.
const CLOCK_FIT_POINTS: usize = 20_000;

/// A tracker that is in the base frame up to this was registered, m: the rest is a small motion.
const REGISTERED: f64 = 0.02;

/// How far a registered tracker may be off: m and rad.
const REGISTRATION_ERROR: f64 = 2e-3;

/// Most points in a correlation.
const CORRELATION_POINTS_MAX: usize = 1 << 20;

/// Offset of the clock of `other` against that of `own`, s, by the speeds that they saw, and the
/// step to which it is known. `None` where nothing moved.
pub(crate) fn correlate(own: &Points<'_>, other: &Points<'_>) -> Option<(f64, f64)> {
    let span = |p: &Points<'_>| Some(p.time.last()? - p.time.first()?);
    let (longest, shortest) = (span(own)?.max(span(other)?), span(own)?.min(span(other)?));
    let slower = median_step(own.time).max(median_step(other.time));
    let step =
        (shortest / 2048.0).max(2.0 * slower).max(2.0 * longest / CORRELATION_POINTS_MAX as f64);
    if !(step.is_finite() && step > 0.0 && shortest > 8.0 * step) {
        return None;
    }
    let (a, b) = (speeds(own, step)?, speeds(other, step)?);
    let n = (a.len() + b.len()).next_power_of_two();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, back) = (planner.plan_fft_forward(n), planner.plan_fft_inverse(n));
    let spectrum = |series: &[f64]| {
        let mut input = series.to_vec();
        input.resize(n, 0.0);
        let mut output = forward.make_output_vec();
        forward.process(&mut input, &mut output).ok().map(|()| output)
    };
    let (fa, fb) = (spectrum(&a)?, spectrum(&b)?);
    let mut product: Vec<_> = fa.iter().zip(&fb).map(|(a, b)| a.conj() * b).collect();
    if let [first, .., last] = product.as_mut_slice() {
        (first.im, last.im) = (0.0, 0.0);
    }
    let mut correlation = back.make_output_vec();
    back.process(&mut product, &mut correlation).ok()?;
    let (best, most) = correlation
        .iter()
        .enumerate()
        .max_by(|(_, a), (_, b)| a.total_cmp(b))
        .map(|(k, v)| (k, *v))?;
    if most.is_nan() || most <= 0.0 {
        return None;
    }
    let lag = if best > n / 2 { best as f64 - n as f64 } else { best as f64 };
    // b at index k is other's time t0 + k·step: it matches a at k − lag.
    Some((other.time[0] - own.time[0] + lag * step, step))
}

/// Speed on an even grid from the first time on, its mean taken off, m/s.
fn speeds(points: &Points<'_>, step: f64) -> Option<Vec<f64>> {
    let start = points.time[0];
    let count = ((points.time.last()? - start) / step).floor() as usize + 1;
    let mut sums = vec![(Vector3::zeros(), 0.0); count];
    for (t, p) in points.time.iter().zip(points.point).filter(|(_, p)| p.sum().is_finite()) {
        let sum = &mut sums[(((t - start) / step) as usize).min(count - 1)];
        sum.0 += p;
        sum.1 += 1.0;
    }
    // What was not seen stands still in between.
    let mut last: Option<Vector3<f64>> = None;
    let mut speeds = Vec::with_capacity(count);
    for (sum, n) in sums {
        let now = (n > 0.0).then(|| sum / n).or(last);
        let moved = match (last, now) {
            (Some(a), Some(b)) => (b - a).norm() / step,
            _ => 0.0,
        };
        speeds.push(moved);
        last = now;
    }
    let mean = speeds.iter().sum::<f64>() / count as f64;
    speeds.iter_mut().for_each(|v| *v -= mean);
    speeds.iter().any(|v| v.abs() > 1e-6).then_some(speeds)
}

/// The rigid motion that brings points nearest to others: rotation and translation, by Kabsch.
pub fn rigid(from: &[Vector3<f64>], to: &[Vector3<f64>]) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    let n = from.len().min(to.len());
    if n == 0 {
        return None;
    }
    let mean = |v: &[Vector3<f64>]| v[..n].iter().sum::<Vector3<f64>>() / n as f64;
    let (a, b) = (mean(from), mean(to));
    let covariance: Matrix3<f64> =
        from.iter().zip(to).map(|(x, y)| (y - b) * (x - a).transpose()).sum();
    let svd = covariance.svd(true, true);
    let (u, vt) = (svd.u?, svd.v_t?);
    let mut sign = Matrix3::identity();
    sign[(2, 2)] = (u * vt).determinant().signum();
    let turn = u * sign * vt;
    turn.sum().is_finite().then(|| (turn, b - turn * a))
}

/// What the log's own path does at the times of the points that another instrument saw.
#[derive(Default)]
struct Matched {
    /// On the log's own clock, s.
    times: Vec<f64>,
    /// The own path, m.
    path: Vec<Vector3<f64>>,
    /// Its velocity, m/s.
    rate: Vec<Vector3<f64>>,
    /// The point that was seen, m.
    point: Vec<Vector3<f64>>,
}

impl Matched {
    /// Points `seen`, at their times on the other clock, s, matched by `map`: but for those at the
    /// ends of the own points and in their gaps. `period`: of the own points, s.
    fn new(own: &Points<'_>, period: f64, seen: &[(f64, Vector3<f64>)], map: &ClockMap) -> Self {
        let mut matched = Self::default();
        let [first, .., last] = *own.time else { return matched };
        let mut k = 0;
        for (tau, p) in seen {
            let t = map.own(*tau);
            if t < first + period || t > last - period {
                continue;
            }
            while k + 1 < own.time.len() && own.time[k + 1] <= t {
                k += 1;
            }
            let width = own.time.get(k + 1).map_or(period, |next| next - own.time[k]);
            if width > 3.0 * period.max(f64::MIN_POSITIVE) {
                continue;
            }
            let place = k as f64 + ((t - own.time[k]) / width).clamp(0.0, 1.0);
            let half = 0.5;
            let x = interpolate(own.point, place);
            let v = (interpolate(own.point, place + half) - interpolate(own.point, place - half))
                / (2.0 * half * width);
            if x.sum().is_finite() && v.sum().is_finite() {
                matched.times.push(t);
                matched.path.push(x);
                matched.rate.push(v);
                matched.point.push(*p);
            }
        }
        matched
    }
}

/// Fits the clock of `other` against that of `own`, from `start` on. `step`: how well the start's
/// offset is known, s. What is given in `given` (offset, drift) stays. `None` where both share too
/// little time.
pub fn fit(
    own: &Points<'_>,
    other: &Points<'_>,
    start: ClockMap,
    step: f64,
    given: [bool; 2],
) -> Option<FittedClock> {
    let period = median_step(own.time);
    let stride = (other.time.len() / CLOCK_FIT_POINTS).max(1);
    let seen: Vec<(f64, Vector3<f64>)> = other
        .time
        .iter()
        .zip(other.point)
        .filter(|(_, p)| p.sum().is_finite())
        .step_by(stride)
        .map(|(t, p)| (*t, *p))
        .collect();
    let (first, last) = (*own.time.first()?, *own.time.last()?);
    let mut map = start;
    let mut frame: Option<(Matrix3<f64>, Vector3<f64>, bool)> = None;
    let mut fitted = None;
    for _ in 0..25 {
        let Matched { times, path, rate, point } = Matched::new(own, period, &seen, &map);
        if times.len() < 12 {
            return None;
        }
        let (mut turn, mut shift, registered) = match frame {
            Some(frame) => frame,
            None => {
                let apart: f64 = path.iter().zip(&point).map(|(x, p)| (p - x).norm_squared()).sum();
                if (apart / times.len() as f64).sqrt() < REGISTERED {
                    (Matrix3::identity(), Vector3::zeros(), true)
                } else {
                    let (turn, shift) = rigid(&path, &point)?;
                    (turn, shift, false)
                }
            }
        };
        // Drift is told about the middle, where it does not change the offset.
        let middle = times.iter().sum::<f64>() / times.len() as f64;
        let mut normal = SMatrix::<f64, 8, 8>::zeros();
        let mut right = SVector::<f64, 8>::zeros();
        let mut squares = 0.0;
        for k in 0..times.len() {
            let moved = turn * path[k];
            let left = point[k] - moved - shift;
            squares += left.norm_squared();
            let mut rows = SMatrix::<f64, 3, 8>::zeros();
            let late = -(turn * rate[k]) / (1.0 + map.drift);
            rows.set_column(0, &late);
            rows.set_column(1, &(late * (times[k] - middle)));
            rows.fixed_view_mut::<3, 3>(0, 2).copy_from(&Matrix3::identity());
            rows.fixed_view_mut::<3, 3>(0, 5).copy_from(&-skew(&moved));
            normal += rows.transpose() * rows;
            right += rows.transpose() * left;
        }
        let variance = (squares / (3 * times.len()) as f64).max(1e-14);
        // What is known beforehand, in units of the residual.
        let offset_known = (FOUND * step).max(1e-6);
        let known = variance.max(UNMODELLED_MOTION.powi(2));
        let mut prior = |i: usize, deviation: f64, off: f64| {
            normal[(i, i)] += known / deviation.powi(2);
            right[i] -= off * known / deviation.powi(2);
        };
        let drift_off = map.drift - start.drift;
        let offset_off = map.offset + map.drift * middle - start.offset - start.drift * middle;
        prior(
            0,
            if given[0] { 1e-12 } else { offset_known },
            if given[0] { 0.0 } else { offset_off },
        );
        prior(1, if given[1] { 1e-15 } else { DRIFT }, if given[1] { 0.0 } else { drift_off });
        if registered {
            let off = shift;
            (0..3).for_each(|i| prior(2 + i, REGISTRATION_ERROR, off[i]));
            (0..3).for_each(|i| prior(5 + i, REGISTRATION_ERROR, 0.0));
        }
        let factor = normal.cholesky()?;
        let change = factor.solve(&right);
        let covariance = factor.inverse() * variance;
        let (offset, drift) = (change[0], change[1]);
        // About the middle: offset there, and what drift does to it at 0.
        if !given[1] {
            map.drift = (map.drift + drift).clamp(-0.01, 0.01);
        }
        if !given[0] {
            map.offset += offset - if given[1] { 0.0 } else { drift * middle };
        }
        shift += Vector3::new(change[2], change[3], change[4]);
        let small = rotation_from_vector(&Vector3::new(change[5], change[6], change[7]));
        turn = small * turn;
        frame = Some((turn, shift, registered));
        fitted = Some(FittedClock {
            map,
            deviation: [covariance[(0, 0)].max(0.0).sqrt(), covariance[(1, 1)].max(0.0).sqrt()],
            left: variance.sqrt(),
        });
        let done = offset.abs() < 1e-8 && (drift * (last - first)).abs() < 1e-8;
        if done || !(map.offset.is_finite() && map.drift.is_finite()) {
            break;
        }
    }
    fitted.filter(|f| f.map.offset.is_finite() && f.map.drift.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion that repeats nowhere.
    fn path(t: f64) -> Vector3<f64> {
        Vector3::new(
            1.8 + 0.3 * (1.1 * t).sin() + 0.1 * (2.7 * t + 0.4).sin(),
            0.4 * (0.7 * t).cos(),
            1.0 + 0.2 * (1.7 * t + 1.0).sin(),
        )
    }

    #[test]
    fn offset_and_drift_are_found_whatever_the_frame() {
        let own: Vec<f64> = (0..6000).map(|k| 0.004 * f64::from(k)).collect();
        let seen: Vec<Vector3<f64>> = own.iter().map(|t| path(*t)).collect();
        let map = ClockMap { offset: 1234.56789, drift: 37e-6 };
        let turn = rotation_from_vector(&Vector3::new(0.3, -0.4, 2.2));
        // 300 Hz, noise of 30 µm, from half way on.
        let other: Vec<f64> = (0..5000).map(|k| 1240.0 + f64::from(k) / 300.0).collect();
        let noise = |k: usize, c: u32| 5e-5 * ((k as f64 * 12.9898 + f64::from(c) * 78.233).sin());
        let point: Vec<Vector3<f64>> = other
            .iter()
            .enumerate()
            .map(|(k, tau)| {
                turn * path(map.own(*tau))
                    + Vector3::new(3.0, -2.0, 0.5)
                    + Vector3::new(noise(k, 0), noise(k, 1), noise(k, 2))
            })
            .collect();
        let (a, b) = (Points { time: &own, point: &seen }, Points { time: &other, point: &point });
        let (offset, step) = correlate(&a, &b).expect("a motion");
        assert!((offset - map.offset).abs() < 3.0 * step, "{offset} {step}");
        let start = ClockMap { offset, drift: 0.0 };
        let found = fit(&a, &b, start, step, [false; 2]).expect("a fit");
        let at = |m: &ClockMap| m.own(1250.0);
        assert!((at(&found.map) - at(&map)).abs() < 5e-6, "{found:?}");
        assert!((found.map.drift - map.drift).abs() < 1e-6, "{found:?}");
        assert!((2e-5..5e-5).contains(&found.left), "{found:?}");
    }

    #[test]
    fn nothing_is_found_where_nothing_moves() {
        let own: Vec<f64> = (0..1000).map(|k| 0.01 * f64::from(k)).collect();
        let still = vec![Vector3::new(1.0, 2.0, 3.0); 1000];
        let points = Points { time: &own, point: &still };
        assert!(correlate(&points, &points).is_none());
    }
}
