//! A PID loop in parallel form with limited output and conditional integration.

use crate::scalar::{Real, held};
use crate::state::{StateResult, StateVisitor, Stateful};

/// Gains of one loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PidGains<T: Real> {
    /// Proportional gain, output over error.
    pub kp: T,
    /// Integral gain, output over error·s.
    pub ki: T,
    /// Derivative gain, output over error/s, on the backward difference of the error.
    pub kd: T,
}

/// State of one loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pid<T: Real> {
    gains: PidGains<T>,
    /// Output held by the integrator, in output units.
    integral: T,
    previous: Option<T>,
}

impl<T: Real> Pid<T> {
    /// A loop at rest with an empty integrator.
    pub fn new(gains: PidGains<T>) -> Self {
        Self { gains, integral: T::zero(), previous: None }
    }

    /// One period: `feed_forward + kp e + ki ∫e + kd ė`, held within ±`limit`.
    ///
    /// The integrator stops while the output is at its limit and the error would drive it further
    /// (anti-windup), and so comes back the moment the error changes sign. Returns the output and
    /// whether it was limited.
    ///
    /// A limit that is negative or NaN counts as zero. Where an input or a sum is not finite, the
    /// state stays as it was and the output is the feed-forward alone.
    #[inline]
    pub fn update(&mut self, error: T, feed_forward: T, limit: T, period: T) -> (T, bool) {
        let rate = self.previous.map_or(T::zero(), |p| (error - p) / period);
        let integral = self.integral + self.gains.ki * error * period;
        let wanted = feed_forward + self.gains.kp * error + self.gains.kd * rate + integral;
        if !wanted.is_finite() || !integral.is_finite() {
            let known = if feed_forward.is_finite() { feed_forward } else { T::zero() };
            return (held(known, T::zero(), limit), true);
        }
        self.previous = Some(error);
        let output = held(wanted, T::zero(), limit);
        let limited = wanted != output;
        let deeper = (wanted - output) * self.gains.ki * error > T::zero();
        if !(limited && deeper) {
            self.integral = integral;
        }
        (output, limited)
    }

    /// Sets what the integrator holds, in output units, and forgets the last error: bumpless start.
    pub fn preload(&mut self, integral: T) {
        self.integral = integral;
        self.previous = None;
    }

    /// Adds to what the integrator holds, in output units: load handed over from or to another
    /// loop. A load that is not finite is refused.
    pub fn transfer_integral(&mut self, load: T) {
        let integral = self.integral + load;
        if integral.is_finite() {
            self.integral = integral;
        }
    }

    /// What the integrator holds, in output units.
    pub fn integral(&self) -> T {
        self.integral
    }
}

impl<T: Real> Stateful for Pid<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.scalar(&mut self.integral)?;
        visitor.scalar_option(&mut self.previous)
    }
}
