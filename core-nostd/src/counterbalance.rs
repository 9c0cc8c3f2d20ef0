//! The weight counterbalance of A2: a cosine series, a table of measured torques, or both.

use crate::scalar::{Real, lit};

/// Most cosine terms of a counterbalance law.
pub const COUNTERBALANCE_TERMS: usize = 8;

/// Most points of a counterbalance table.
pub const COUNTERBALANCE_POINTS: usize = 24;

/// Torque of the counterbalance on the link about axis A2,
/// τ_cb = Σ cₙ cos(n (q₂ − φ)) + p(q₂), n = 1 …
#[derive(Debug, Clone, PartialEq)]
pub struct Counterbalance<T: Real> {
    /// c₁, c₂, …, N·m. Empty: no series.
    pub cosine: heapless::Vec<T, COUNTERBALANCE_TERMS>,
    /// φ, rad: the angle of A2 that the series counts from.
    pub phase: T,
    /// Points of p: angle of A2 in rad, rising, and torque in N·m. Empty: no table. Between points
    /// p is a cubic with the slope of the secant over the neighbours at each point, so that its
    /// derivative is continuous; beyond the ends it goes on straight.
    pub table: heapless::Vec<[T; 2], COUNTERBALANCE_POINTS>,
}

impl<T: Real> Default for Counterbalance<T> {
    fn default() -> Self {
        Self { cosine: heapless::Vec::new(), phase: T::zero(), table: heapless::Vec::new() }
    }
}

impl<T: Real> Counterbalance<T> {
    /// τ_cb at an angle of A2 in rad, N·m.
    #[inline]
    pub fn torque(&self, q2: T) -> T {
        // Chebyshev recurrence cos(n q) = 2 cos q cos((n−1) q) − cos((n−2) q): one cosine for all
        // orders.
        let c = (q2 - self.phase).cos();
        let (mut before, mut now) = (T::one(), c);
        let mut sum = T::zero();
        for a in &self.cosine {
            sum += *a * now;
            let next = (c + c) * now - before;
            before = now;
            now = next;
        }
        if self.table.is_empty() { sum } else { sum + self.interpolated(q2) }
    }

    /// ∫τ_cb dq₂ from where the series and the table begin to an angle of A2 in rad, J.
    pub fn work(&self, q2: T) -> T {
        let mut work = T::zero();
        let mut order = T::zero();
        for c in &self.cosine {
            order += T::one();
            work += *c * (order * (q2 - self.phase)).sin() / order;
        }
        let Some([first, _]) = self.table.first() else {
            return work;
        };
        // Simpson's rule is exact for the cubic between two points.
        let (mut from, two) = (*first, lit::<T>(2.0));
        let inner = self.table.iter().map(|[angle, _]| *angle).filter(|a| *a > *first && *a < q2);
        for to in inner.chain([q2]) {
            let middle = self.interpolated((from + to) / two);
            let ends = self.interpolated(from) + self.interpolated(to);
            work += (ends + middle * lit(4.0)) * (to - from) / lit(6.0);
            from = to;
        }
        work
    }

    /// p(q₂), N·m.
    fn interpolated(&self, q2: T) -> T {
        let points = self.table.as_slice();
        let (Some([first, at_first]), Some([last, at_last])) = (points.first(), points.last())
        else {
            return T::zero();
        };
        if q2 <= *first {
            return *at_first + self.slope(0) * (q2 - *first);
        }
        if q2 >= *last {
            return *at_last + self.slope(points.len() - 1) * (q2 - *last);
        }
        let next = points.iter().position(|[angle, _]| q2 < *angle).unwrap_or(1).max(1);
        let (Some([from, a]), Some([to, b])) = (points.get(next - 1), points.get(next)) else {
            return T::zero();
        };
        // Cubic Hermite polynomial in t = 0 … 1.
        let h = *to - *from;
        let t = (q2 - *from) / h;
        let (two, three) = (lit::<T>(2.0), lit::<T>(3.0));
        let rise = t * t * (three - two * t);
        let bend = t * (t - T::one());
        *a + (*b - *a) * rise
            + h * bend * ((t - T::one()) * self.slope(next - 1) + t * self.slope(next))
    }

    /// Slope of p at a point of the table: of the secant over its neighbours, N·m/rad.
    fn slope(&self, i: usize) -> T {
        let last = self.table.len().saturating_sub(1);
        let ends = (self.table.get(i.saturating_sub(1)), self.table.get((i + 1).min(last)));
        match ends {
            (Some([q, a]), Some([r, b])) if r > q => (*b - *a) / (*r - *q),
            _ => T::zero(),
        }
    }

    /// True for finite numbers and rising angles.
    pub(crate) fn is_sound(&self) -> bool {
        crate::scalar::all_finite(
            self.cosine.iter().chain([&self.phase]).chain(self.table.iter().flatten()),
        ) && self.table.windows(2).all(|pair| matches!(pair, [[a, _], [b, _]] if a < b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cosine: &[f64], phase: f64, table: &[[f64; 2]]) -> Counterbalance<f64> {
        Counterbalance {
            cosine: cosine.iter().copied().collect(),
            phase,
            table: table.iter().copied().collect(),
        }
    }

    #[test]
    fn a_phase_turns_the_series() {
        let (plain, turned) = (of(&[-9e3, 290.0], 0.0, &[]), of(&[-9e3, 290.0], 0.4, &[]));
        for q in [-2.0, -0.3, 0.0, 1.1] {
            assert!((turned.torque(q + 0.4) - plain.torque(q)).abs() < 1e-9);
        }
    }

    #[test]
    fn a_table_passes_its_points_with_a_continuous_slope_and_straight_ends() {
        let points = [[-2.0, 3e3], [-1.2, 7e3], [-0.5, 8e3], [0.3, 5e3]];
        let table = of(&[], 0.0, &points);
        let slope = |q: f64, h: f64| (table.torque(q + h) - table.torque(q)) / h;
        for [q, torque] in points {
            assert!((table.torque(q) - torque).abs() < 1e-9);
            // One-sided differences over 1e-6 of curves that bend by less than 1e5 N·m/rad².
            assert!((slope(q, 1e-6) - slope(q, -1e-6)).abs() < 0.2, "at {q}");
        }
        assert!((slope(1.0, 0.5) - slope(2.0, 0.5)).abs() < 1e-8);
        // A straight line is kept exactly.
        let line = of(&[], 0.0, &[[-1.0, -2.0], [0.5, 1.0], [2.0, 4.0]]);
        for q in [-3.0, -0.7, 0.1, 1.9, 5.0] {
            assert!((line.torque(q) - 2.0 * q).abs() < 1e-12);
        }
    }

    #[test]
    fn the_work_is_the_integral_of_the_torque() {
        let both = of(&[-9e3, -80.0], 0.2, &[[-2.0, 3e3], [-1.2, 7e3], [0.3, 5e3]]);
        let h = 1e-5;
        for q in [-2.5, -1.9, -0.4, 0.2, 0.8] {
            let slope = (both.work(q + h) - both.work(q - h)) / (2.0 * h);
            assert!((slope - both.torque(q)).abs() < 1e-4, "at {q}: {slope} {}", both.torque(q));
        }
    }
}
