//! The spindle's line taken out of the force error that the loop answers.
//!
//! The process' force carries a ripple locked to the spindle: 8 to 20 Hz at 500 to 1200 rpm, on the
//! first modes of a heavy arm and not far below the 41.7 Hz that a loop of 12 ms can tell. A loop
//! that answers it drives those modes, at a phase that its own delay decides. The rate is known to
//! the controller, so the lines are too: a notch at the first order and one at the second, retuned
//! whenever the rate changes. It is the error that is filtered and not the push alone, so that a
//! step of the set-point and the push that answers it come equally late and their difference is not
//! integrated meanwhile.
//!
//! With θ = 2π f T of the line as it appears and r = e^(−π B T), B = 0.15 f:
//!
//! ```text
//! H(z) = g (1 − 2 cos θ z⁻¹ + z⁻²) / (1 − 2 r cos θ z⁻¹ + r² z⁻²),   g: H(1) = 1
//! ```
//!
//! Zeros on the line, poles at the same angle inside: the gain at rest is one, the null is exact,
//! and all that is off dies away with B up to Nyquist, where a bilinear notch narrows to nothing.
//! Source: Oppenheim, Schafer, Discrete-Time Signal Processing, 5.3. Computed as the sample less
//! what is to be taken out, (1 − z⁻¹)(c₀ + c₁z⁻¹)/(…), whose state is driven by the change of the
//! sample and turned by θ and shrunk by r every period: a signal that stands still comes through
//! unchanged whatever happens to the rate, and no sequence of rates can make the state grow.
//!
//! A line beyond Nyquist is taken out where it appears, at |f − n/T|. A line that appears so low
//! that its notch would make slow signals later than [`LONGEST_DELAY`] is left alone: the loop
//! needs its phase more.

use crate::filter::Filter;
use crate::scalar::{Real, lit};
use crate::state::{StateResult, StateVisitor, Stateful};

/// Orders of the spindle that are taken out.
const NOTCHED_ORDERS: [f64; 2] = [1.0, 2.0];

/// Width B between the −3 dB points over the line's frequency. The line is known as well as the
/// rate is; of a line that is off by 1 % a width of 0.15 leaves 13 %, and what is wider is later.
const RELATIVE_WIDTH: f64 = 0.15;

/// Longest delay of slow signals that a notch may cost, s: 14° at the 20 rad/s of the fastest
/// published force loop. A line that appears at 2 Hz costs as much.
pub const LONGEST_DELAY: f64 = 0.012;

/// Notches at the first and the second order of the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleFilter<T: Real> {
    lines: [SpindleOrder<T>; 2],
    rate: T,
    period: T,
}

impl<T: Real> SpindleFilter<T> {
    /// A filter for samples `period` s apart that passes everything until it is
    /// [tuned](Self::tune).
    pub fn new(period: T) -> Self {
        Self { lines: [SpindleOrder::open(); 2], rate: T::zero(), period }
    }

    /// Moves the notches to the spindle's rate, rad/s, of either sign. At 0 or NaN everything passes.
    ///
    /// A constant signal passes unchanged meanwhile. Where a notch is added or removed, the output
    /// changes by no more than the line it takes out.
    pub fn tune(&mut self, rate: T) {
        if rate == self.rate {
            return;
        }
        self.rate = rate;
        for (line, order) in self.lines.iter_mut().zip(NOTCHED_ORDERS) {
            // Turns of the line in a period, folded onto 0 … ½.
            let turns = rate.abs() * self.period * lit(order) / T::two_pi();
            let seen = (turns - turns.round()).abs();
            line.notch = Notch::new(seen).filter(|n| n.delay * self.period <= lit(LONGEST_DELAY));
        }
    }

    /// Forgets the signal; the filter starts in steady state at the next sample.
    pub fn reset(&mut self) {
        for line in &mut self.lines {
            line.initialize(None);
        }
    }
}

impl<T: Real> Filter<T> for SpindleFilter<T> {
    /// A sample with which the output is not finite passes through; the state stays as it was.
    fn update(&mut self, sample: T) -> T {
        let before = self.lines;
        let out = self.lines.iter_mut().fold(sample, |value, line| line.update(value));
        if out.is_finite() {
            return out;
        }
        self.lines = before;
        sample
    }

    fn delay(&self) -> T {
        let each = self.lines.iter().filter_map(|line| line.notch.as_ref());
        each.fold(T::zero(), |sum, notch| sum + notch.delay) * self.period
    }

    fn initialize(&mut self, value: T) {
        for line in &mut self.lines {
            line.initialize(Some(value));
        }
    }
}

/// One order: its notch, if there is one, and the filter's state.
#[derive(Debug, Clone, Copy, PartialEq)]
struct SpindleOrder<T: Real> {
    notch: Option<Notch<T>>,
    past: Option<T>,
    /// The line as a turning vector.
    state: [T; 2],
}

impl<T: Real> SpindleOrder<T> {
    fn open() -> Self {
        Self { notch: None, past: None, state: [T::zero(); 2] }
    }

    fn initialize(&mut self, past: Option<T>) {
        *self = Self { notch: self.notch, past, ..Self::open() };
    }

    fn update(&mut self, sample: T) -> T {
        let change = sample - self.past.unwrap_or(sample);
        self.past = Some(sample);
        let Some(notch) = &self.notch else {
            self.state = [T::zero(); 2];
            return sample;
        };
        let ([x, y], [cosine, sine]) = (self.state, notch.turn);
        self.state = [cosine * x - sine * y + change, sine * x + cosine * y];
        sample - notch.share[0] * self.state[0] - notch.share[1] * self.state[1]
    }
}

/// One notch: r cos θ and r sin θ, the share of the state taken out, and the delay.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Notch<T: Real> {
    turn: [T; 2],
    share: [T; 2],
    /// Group delay for slow signals, samples.
    delay: T,
}

impl<T: Real> Notch<T> {
    /// A notch at `turns` per sample, 0 … ½. `None` at 0 or NaN.
    fn new(turns: T) -> Option<Self> {
        // At Nyquist itself a line has no phase to turn; a notch a five-hundredth beside it leaves
        // 3 % of it.
        let turns = turns.min(lit(0.499));
        let (one, two) = (T::one(), lit::<T>(2.0));
        let (sine, cosine) = (T::two_pi() * turns).sin_cos();
        let r = (-T::pi() * lit(RELATIVE_WIDTH) * turns).exp();
        let at_rest = one - two * r * cosine + r * r;
        let gain = at_rest / (two - two * cosine);
        let (first, second) = (one - gain, gain - r * r);
        let share = [first, (second + first * r * cosine) / (r * sine)];
        // One sample of the zeros, less the poles' lead.
        let delay = (one - r * r) / at_rest;
        let usable = turns > T::zero() && share[0].is_finite() && share[1].is_finite();
        usable.then_some(Self { turn: [r * cosine, r * sine], share, delay })
    }
}

impl<T: Real> Stateful for SpindleFilter<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        // The notches follow from the rate.
        let mut rate = self.rate;
        visitor.scalar(&mut rate)?;
        self.tune(rate);
        for line in &mut self.lines {
            visitor.scalar_option(&mut line.past)?;
            visitor.scalars(&mut line.state)?;
        }
        Ok(())
    }
}
