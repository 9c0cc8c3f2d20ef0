//! Discrete filters that state their delay: a force loop at 12 ms has little phase to spare.
//!
//! All are designed by the bilinear transform with the corner pre-warped, so that corner and notch
//! lie where they are asked for even near Nyquist. Source: Oppenheim, Schafer, Discrete-Time Signal
//! Processing, 7.2.

use crate::scalar::{Real, lit};
use crate::state::{StateResult, StateVisitor, Stateful};
use heapless::Deque;

/// A filter with a stated delay.
pub trait Filter<T: Real> {
    /// Takes one sample, returns one.
    fn update(&mut self, sample: T) -> T;
    /// Group delay for slow signals, s.
    fn delay(&self) -> T;
    /// Sets the steady state for a constant input `value`.
    fn initialize(&mut self, value: T);
}

/// Second-order section (b₀ + b₁z⁻¹ + b₂z⁻²) / (1 + a₁z⁻¹ + a₂z⁻²), transposed direct form II.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Biquad<T: Real> {
    b: [T; 3],
    a: [T; 2],
    state: [T; 2],
    period: T,
}

impl<T: Real> Biquad<T> {
    /// Second-order Butterworth low-pass. `corner` in Hz, `period` in s.
    ///
    /// `None` unless 0 < corner < Nyquist.
    pub fn low_pass(corner: T, period: T) -> Option<Self> {
        let k = Self::warped(corner, period)?;
        let k2 = k * k;
        let norm = (T::one() + lit::<T>(core::f64::consts::SQRT_2) * k + k2).recip();
        let b0 = k2 * norm;
        Some(Self {
            b: [b0, b0 + b0, b0],
            a: [
                lit::<T>(2.0) * (k2 - T::one()) * norm,
                (T::one() - lit::<T>(core::f64::consts::SQRT_2) * k + k2) * norm,
            ],
            state: [T::zero(); 2],
            period,
        })
    }

    /// Notch at `center` Hz, `width` Hz between its −3 dB points; gain 1 at rest.
    ///
    /// `None` unless 0 < center < Nyquist and width > 0.
    pub fn notch(center: T, width: T, period: T) -> Option<Self> {
        let k = Self::warped(center, period).filter(|_| width > T::zero())?;
        let k2 = k * k;
        let damping = k * width / center;
        let norm = (T::one() + damping + k2).recip();
        let b0 = (T::one() + k2) * norm;
        let b1 = lit::<T>(2.0) * (k2 - T::one()) * norm;
        let a2 = (T::one() - damping + k2) * norm;
        Some(Self { b: [b0, b1, b0], a: [b1, a2], state: [T::zero(); 2], period })
    }

    fn warped(frequency: T, period: T) -> Option<T> {
        let cycle = frequency * period;
        (period > T::zero() && cycle > T::zero() && cycle < lit(0.5))
            .then(|| (T::pi() * cycle).tan())
    }
}

impl<T: Real> Filter<T> for Biquad<T> {
    fn update(&mut self, sample: T) -> T {
        let out = self.b[0] * sample + self.state[0];
        self.state[0] = self.b[1] * sample - self.a[0] * out + self.state[1];
        self.state[1] = self.b[2] * sample - self.a[1] * out;
        out
    }

    /// −dφ/dω at ω = 0: (Σ k bₖ / Σ bₖ − Σ k aₖ / Σ aₖ) · period.
    fn delay(&self) -> T {
        let two = lit::<T>(2.0);
        let zeros = (self.b[1] + two * self.b[2]) / (self.b[0] + self.b[1] + self.b[2]);
        let poles = (self.a[0] + two * self.a[1]) / (T::one() + self.a[0] + self.a[1]);
        (zeros - poles) * self.period
    }

    fn initialize(&mut self, value: T) {
        let gain = (self.b[0] + self.b[1] + self.b[2]) / (T::one() + self.a[0] + self.a[1]);
        let out = gain * value;
        self.state[1] = self.b[2] * value - self.a[1] * out;
        self.state[0] = self.b[1] * value - self.a[0] * out + self.state[1];
    }
}

/// Mean of the last `N` samples: zero at every multiple of 1/(N · period), so it removes a spindle
/// line exactly when its window is one turn.
#[derive(Debug, Clone)]
pub struct MovingAverage<T: Real, const N: usize> {
    window: Deque<T, N>,
    period: T,
}

impl<T: Real, const N: usize> MovingAverage<T, N> {
    /// Empty window; until it has filled, the mean is over what has come.
    pub fn new(period: T) -> Self {
        Self { window: Deque::new(), period }
    }
}

impl<T: Real, const N: usize> Filter<T> for MovingAverage<T, N> {
    fn update(&mut self, sample: T) -> T {
        if self.window.is_full() {
            self.window.pop_front();
        }
        // Room was just made; N = 0 alone leaves none, and then the sample passes through.
        if self.window.push_back(sample).is_err() {
            return sample;
        }
        let sum = self.window.iter().fold(T::zero(), |sum, v| sum + *v);
        sum / lit(self.window.len() as f64)
    }

    fn delay(&self) -> T {
        lit::<T>((N.max(1) - 1) as f64 * 0.5) * self.period
    }

    fn initialize(&mut self, value: T) {
        self.window.clear();
        while self.window.push_back(value).is_ok() {}
    }
}

/// The same filter on every entry of a vector signal, such as the six channels of a wrench.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FilterBank<F, const N: usize>([F; N]);

impl<F: Clone, const N: usize> FilterBank<F, N> {
    /// `N` copies of one designed filter.
    pub fn new(filter: F) -> Self {
        Self(core::array::from_fn(|_| filter.clone()))
    }

    /// Takes one sample for each channel, returns one for each.
    pub fn update<T: Real>(&mut self, sample: &nalgebra::SVector<T, N>) -> nalgebra::SVector<T, N>
    where
        F: Filter<T>,
    {
        let mut out = *sample;
        for (value, filter) in out.iter_mut().zip(&mut self.0) {
            *value = filter.update(*value);
        }
        out
    }

    /// Sets every channel's steady state for a constant input, its entry of `value`.
    pub fn initialize<T: Real>(&mut self, value: &nalgebra::SVector<T, N>)
    where
        F: Filter<T>,
    {
        for (v, filter) in value.iter().zip(&mut self.0) {
            filter.initialize(*v);
        }
    }
}

impl<T: Real> Stateful for Biquad<T> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.scalars(&mut self.state)
    }
}

impl<F: Stateful, const N: usize> Stateful for FilterBank<F, N> {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.0.iter_mut().try_for_each(|filter| filter.visit_state(visitor))
    }
}
