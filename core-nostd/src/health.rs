//! Health signals of the machine, in the approximate mathematics of `micromath`: how much a signal
//! vibrates, and what the spindle's turning leaves in a force channel.
//!
//! They are for trends and thresholds that a person or a supervisor looks at: a bearing that begins
//! to shake, a tool that wears, a probe that runs out of round. Those change by tens of percent
//! before anyone acts, so a level known to 6 % and a phase known to a third of a degree are enough,
//! and `micromath` gives them in a few integer and multiply instructions, without tables and
//! without a square root unit:
//!
//! | used here | error of `micromath` | what becomes of it |
//! |---|---|---|
//! | `sqrt` | 0 … +6.1 % of the value | [`VibrationLevel`] and the amplitude of [`SpindleLine`]: the same share |
//! | `sin_cos` | 1.2e-3 | [`SpindleLine`]: 2e-3 of the amplitude |
//! | `atan2` | 2.8e-3 rad | phase of [`SpindleLine`]: 5e-3 rad, that is 0.3° |
//!
//! Left out: everything that moves the robot. A sine that is off by 1e-3 is two millimetres at 2 m
//! reach; kinematics and control therefore use the full-precision functions of
//! [`Real`](crate::Real), and nothing here feeds back into them.
//!
//! Both take a stated time constant τ and average to first order, y ← y + T/(τ + T)·(x − y): of all
//! such averages the one that is late by exactly τ for slow changes, at any period T. A sample that
//! is not a number is passed over.

use crate::state::{StateResult, StateVisitor, Stateful};
// Always called by the trait's name: on a host, where std is somewhere in the build, f32's own
// methods would be taken.
use micromath::F32Ext;

/// Share of the new sample in a first-order average, T/(τ + T); `None` unless both times are
/// positive and finite.
pub(crate) fn share(time_constant: f32, period: f32) -> Option<f32> {
    let usable = |t: f32| t.is_finite() && t > 0.0;
    (usable(time_constant) && usable(period)).then(|| period / (time_constant + period))
}

/// RMS of a signal about its own mean, old samples forgotten exponentially.
///
/// The mean is averaged with the same time constant, so that what is slower than 1/(2πτ) counts as
/// mean and not as vibration. After a start the level rises from zero within a few τ.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VibrationLevel {
    share: f32,
    time_constant: f32,
    /// Mean and variance; `None` before the first sample.
    moments: Option<(f32, f32)>,
}

impl VibrationLevel {
    /// `time_constant` τ and `period` between samples, s.
    ///
    /// `None` unless both are positive and finite.
    pub fn new(time_constant: f32, period: f32) -> Option<Self> {
        Some(Self { share: share(time_constant, period)?, time_constant, moments: None })
    }

    /// Takes one sample, in any unit; returns the level in the same unit.
    pub fn update(&mut self, sample: f32) -> f32 {
        let next = match self.moments {
            None => (sample, 0.0),
            // The weighted form of Welford's update (Finch 2009): no difference of two large
            // squares.
            Some((mean, variance)) => {
                let apart = sample - mean;
                let step = self.share * apart;
                (mean + step, (1.0 - self.share) * (variance + apart * step))
            }
        };
        if next.0.is_finite() && next.1.is_finite() {
            self.moments = Some(next);
        }
        self.level()
    }

    /// Root of the variance, in the unit of the samples, to −0.2 % … +6.2 %; zero before the first
    /// sample.
    pub fn level(&self) -> f32 {
        root(self.moments.map_or(0.0, |(_, variance)| variance))
    }

    /// How late the variance is for slow changes, s: the time constant.
    pub fn delay(&self) -> f32 {
        self.time_constant
    }

    /// Forgets what was seen.
    pub fn reset(&mut self) {
        self.moments = None;
    }
}

/// Amplitude and phase of one order of the spindle in a channel, by synchronous demodulation with
/// the spindle's angle.
///
/// The channel is taken as mean + A cos(n·angle − phase) with slowly changing mean, A and phase.
/// What it differs by from the present estimate is multiplied by 1, 2 cos(n·angle) and 2
/// sin(n·angle) and averaged into the mean, A cos(phase) and A sin(phase). Demodulating the
/// difference, not the channel, keeps the push out of the line and leaves no ripple at rest.
/// Because the angle is measured, the line is found at any speed, also while it changes; what is
/// not locked to the spindle averages out, a component Δω away by a factor 1/(Δω τ). τ is to be
/// several turns long.
///
/// Needs n spindle turns a second to stay below half of the sampling rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpindleLine {
    order: f32,
    share: f32,
    time_constant: f32,
    /// Mean of the channel; `None` before the first sample.
    mean: Option<f32>,
    /// A cos(phase) and A sin(phase).
    cosine: f32,
    sine: f32,
}

impl SpindleLine {
    /// `order` n: cycles a turn, 1 for run-out, the number of flutes for the probe's;
    /// `time_constant` τ and `period` between samples, s.
    ///
    /// `None` unless `order` is at least 1 and both times are positive and finite.
    pub fn new(order: u8, time_constant: f32, period: f32) -> Option<Self> {
        let share = share(time_constant, period).filter(|_| order > 0)?;
        Some(Self {
            order: f32::from(order),
            share,
            time_constant,
            mean: None,
            cosine: 0.0,
            sine: 0.0,
        })
    }

    /// Takes one sample of the channel, in any unit, and the spindle's angle at that moment, rad.
    ///
    /// The angle is best kept within a few turns of zero: f32 knows an angle of a thousand turns to
    /// 5e-4 rad.
    pub fn update(&mut self, sample: f32, spindle_angle: f32) {
        self.take(sample, F32Ext::sin_cos(self.order * spindle_angle));
    }

    /// The same with sine and cosine of n times the spindle's angle; returns what mean and line
    /// leave of the sample.
    pub(crate) fn take(&mut self, sample: f32, (s, c): (f32, f32)) -> f32 {
        let before = self.mean.unwrap_or(sample);
        let rest = sample - before - self.cosine * c - self.sine * s;
        let step = self.share * rest;
        let mean = before + step;
        let (cosine, sine) = (self.cosine + 2.0 * step * c, self.sine + 2.0 * step * s);
        if mean.is_finite() && cosine.is_finite() && sine.is_finite() {
            (self.mean, self.cosine, self.sine) = (Some(mean), cosine, sine);
        }
        rest
    }

    /// Amplitude A of the line, in the unit of the samples, to −0.5 % … +6.5 %.
    pub fn amplitude(&self) -> f32 {
        root(self.cosine * self.cosine + self.sine * self.sine)
    }

    /// Phase of the line, rad in [−π, π], to 5e-3: n times the spindle angle at which the channel
    /// is greatest. Zero where there is no line.
    pub fn phase(&self) -> f32 {
        let phase = F32Ext::atan2(self.sine, self.cosine);
        if phase.is_finite() { phase } else { 0.0 }
    }

    /// How late amplitude and phase are for slow changes, s: the time constant.
    pub fn delay(&self) -> f32 {
        self.time_constant
    }

    /// Forgets what was seen.
    pub fn reset(&mut self) {
        (self.mean, self.cosine, self.sine) = (None, 0.0, 0.0);
    }
}

/// Square root to 0 … +6.1 %; of zero exactly zero, where the approximation alone would leave
/// 1e-19.
pub(crate) fn root(square: f32) -> f32 {
    if square > 0.0 { F32Ext::sqrt(square) } else { 0.0 }
}

impl Stateful for VibrationLevel {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.option(&mut self.moments, (0.0, 0.0), |visitor, (mean, variance)| {
            visitor.single(mean)?;
            visitor.single(variance)
        })
    }
}

impl Stateful for SpindleLine {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.option(&mut self.mean, 0.0, |visitor, mean| visitor.single(mean))?;
        visitor.single(&mut self.cosine)?;
        visitor.single(&mut self.sine)
    }
}
