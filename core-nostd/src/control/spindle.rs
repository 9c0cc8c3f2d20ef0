//! The spindle's line taken out of the force error that the loop answers.
//!
//! The process' force carries a ripple locked to the spindle: 8 to 20 Hz at 500 to 1200 rpm, on the first modes of a heavy
//! arm and not far below the 41.7 Hz that a loop of 12 ms can tell. A loop that answers it drives those modes, at a phase
//! that its own delay decides. The rate is known to the controller, so the lines are too: a notch at the first order and
//! one at the second, retuned whenever the rate changes. It is the error that is filtered and not the push alone, so that a step
//! of the set-point and the push that answers it come equally late and their difference is not integrated meanwhile.
//!
//! With θ = 2π f T of the line as it appears and r = e^(−π B T), B = 0.15 f:
//!
//! ```text
//! H(z) = g (1 − 2 cos θ z⁻¹ + z⁻²) / (1 − 2 r cos θ z⁻¹ + r² z⁻²),   g: H(1) = 1
//! ```
//!
//! Zeros on the line, poles at the same angle inside: the gain at rest is one, the null is exact, and all that is off dies
//! away with B up to Nyquist, where a bilinear notch narrows to nothing. Source: Oppenheim, Schafer, Discrete-Time Signal
//! Processing, 5.3. Kept in direct form I, whose state is the signal itself: a signal that stands still comes through
//! unchanged whatever happens to the rate.
//!
//! A line beyond Nyquist is taken out where it appears, at |f − n/T|. A line that appears so low that its notch would make
//! slow signals later than [`LONGEST_DELAY`] is left alone: the loop needs its phase more.

use crate::filter::Filter;
use crate::scalar::{Real, lit};

/// Orders of the spindle that are taken out.
const ORDERS: [f64; 2] = [1.0, 2.0];

/// Width B between the −3 dB points over the line's frequency. The line is known as well as the rate is; of a line that is off by
/// 1 % a width of 0.15 leaves 13 %, and what is wider is later.
const RELATIVE_WIDTH: f64 = 0.15;

/// Longest delay of slow signals that a notch may cost, s: 14° at the 20 rad/s of the fastest published force loop. A line that
/// appears at 2 Hz costs as much.
pub const LONGEST_DELAY: f64 = 0.012;

/// Notches at the first and the second order of the spindle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleFilter<T: Real> {
    lines: [Line<T>; 2],
    rate: T,
    period: T,
}

impl<T: Real> SpindleFilter<T> {
    /// A filter for samples `period` s apart that passes everything until it is [tuned](Self::tune).
    pub fn new(period: T) -> Self {
        Self { lines: [Line::open(); 2], rate: T::zero(), period }
    }

    /// Follows the spindle's rate, rad/s, in either sense. At 0, and where it is no number, everything passes.
    ///
    /// A signal at rest does not notice. Where a line is given up or taken up, the output moves by no more than that line.
    pub fn tune(&mut self, rate: T) {
        if rate == self.rate {
            return;
        }
        self.rate = rate;
        for (line, order) in self.lines.iter_mut().zip(ORDERS) {
            // Turns of the line in a period, folded onto 0 … ½.
            let turns = rate.abs() * self.period * lit(order) / T::two_pi();
            let seen = (turns - turns.round()).abs();
            line.notch = Notch::new(seen).filter(|n| n.delay() * self.period <= lit(LONGEST_DELAY));
        }
    }

    /// Forgets the signal; the next sample is taken as if it had been there for ever.
    pub fn reset(&mut self) {
        for line in &mut self.lines {
            line.past = None;
        }
    }
}

impl<T: Real> Filter<T> for SpindleFilter<T> {
    /// Of a sample so large that the filter cannot compute with it nothing is remembered.
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
        each.fold(T::zero(), |sum, notch| sum + notch.delay()) * self.period
    }

    fn settle(&mut self, value: T) {
        for line in &mut self.lines {
            line.past = Some(Past { input: [value; 2], output: [value; 2] });
        }
    }
}

/// One order: its notch where there is one, and the last two samples before and behind it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line<T: Real> {
    notch: Option<Notch<T>>,
    past: Option<Past<T>>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Past<T: Real> {
    input: [T; 2],
    output: [T; 2],
}

impl<T: Real> Line<T> {
    fn open() -> Self {
        Self { notch: None, past: None }
    }

    fn update(&mut self, sample: T) -> T {
        let Past { input, output } = self.past.unwrap_or(Past { input: [sample; 2], output: [sample; 2] });
        let out = self.notch.as_ref().map_or(sample, |n| {
            let [one, two] = n.zeros;
            n.gain * (sample + one * input[0] + two * input[1]) - n.poles[0] * output[0] - n.poles[1] * output[1]
        });
        self.past = Some(Past { input: [sample, input[0]], output: [out, output[0]] });
        out
    }
}

/// Coefficients of one notch: gain, and what stands at z⁻¹ and z⁻² above and below.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Notch<T: Real> {
    gain: T,
    zeros: [T; 2],
    poles: [T; 2],
}

impl<T: Real> Notch<T> {
    /// At so many turns a sample, 0 … ½. `None` at 0 and where that is no number.
    fn new(turns: T) -> Option<Self> {
        let twice_cosine = lit::<T>(2.0) * (T::two_pi() * turns).cos();
        let r = (-T::pi() * lit(RELATIVE_WIDTH) * turns).exp();
        let (zeros, poles) = ([-twice_cosine, T::one()], [-twice_cosine * r, r * r]);
        let gain = (T::one() + poles[0] + poles[1]) / (T::one() + zeros[0] + zeros[1]);
        (turns > T::zero() && gain.is_finite()).then_some(Self { gain, zeros, poles })
    }

    /// Group delay for slow signals in samples: one of the zeros, less the poles' lead.
    fn delay(&self) -> T {
        let [one, two] = self.poles;
        T::one() - (one + two + two) / (T::one() + one + two)
    }
}
