//! A watch over the machine beside the law: the spindle's lines in the push and the vibration of
//! each drive, with a warning where a line climbs or a drive rings.
//!
//! It sees what the law sees and feeds nothing back: once a period, in `f32` with the approximate
//! mathematics of [`health`](crate::health). Its memory has a fixed size.
//!
//! **A line climbs** where the amplitude of the spindle's first or second order in the push exceeds
//! [`CLIMB`] times its usual level by [`CLIMB_NOISE_DEVIATIONS`] standard deviations of what the
//! rest of the channel leaves of noise in it. The usual level is learned for [`LEARNING`] s,
//! beginning [`SETTLING`] s after the push asked for stands still, and then follows over a minute:
//! along a seam the arm answers its spindle differently from place to place. What climbs more
//! slowly is not seen.
//!
//! **A drive rings** where for [`RINGING_TIME`] s its rate is a narrow line that dies away slower
//! than [`RINGING_DAMPING_RATIO`] of critical, or grows. Mean and spindle's orders are taken out
//! first, within 0.6 Hz, and x_k = a₁ x_{k−1} + a₂ x_{k−2} is fitted to the rest, old periods
//! forgotten exponentially. Its poles are r e^{±iθ} with r² = −a₂ and cos θ = a₁/2r; near r = 1, 2r
//! = 1 − a₂ and −ln r = (1 + a₂)/2, so that the damping is (1 + a₂)/2θ, below zero for a line that
//! grows. The line is narrow where that explains four fifths of the square. The fit has x_{k−3} and
//! x_{k−4} as instrumental variables, and not least squares: the steps of the encoders,
//! differentiated, are noise that reaches over two periods, and would damp a small line. (Young
//! 2011, 6.) Lines below [`LINE_FREQUENCY_MIN`] are not watched: the beginning of the feed makes
//! such.
//!
//! Left out: faults. A sample that is not a number is passed over, and what a dead sensor does is
//! for the controllers to see.

use crate::control::{SensorReadings, Setpoint};
use crate::health::{SpindleLine, VibrationLevel, root, share};
use crate::scalar::{JOINTS, Real};
use crate::state::{StateResult, StateVisitor, Stateful};
use core::f32::consts::TAU;
// Always called by the trait's name, as in `health`.
use micromath::F32Ext;

/// Orders of the spindle that are watched.
pub const WATCHED_ORDERS: [u8; 2] = [1, 2];

/// A line climbs beyond so many times its usual level …
pub const CLIMB: f32 = 1.5;

/// … and so many standard deviations of its noise.
pub const CLIMB_NOISE_DEVIATIONS: f32 = 5.0;

/// Time from which the push asked for stands still until its lines have settled, s: three of their
/// time constants.
pub const SETTLING: f32 = 3.0 * LINE_TIME;

/// Time over which the usual level of a line is learned before anything is judged by it, s.
pub const LEARNING: f32 = 4.0;

/// A drive rings below this share of critical damping: what dies away by less than 12 % a cycle.
pub const RINGING_DAMPING_RATIO: f32 = 0.02;

/// Time for which a drive has to ring, s: longer than what the beginning of the feed leaves.
pub const RINGING_TIME: f32 = 1.0;

/// Time constant of the lines in the push and of its vibration, s: 20 turns at 600 rpm.
const LINE_TIME: f32 = 2.0;

/// Time constant of a line's usual level, s.
const USUAL_TIME: f32 = 60.0;

/// Time constant of the lines that are taken out of a drive's rate, s: what a change of the ripple
/// leaves there dies away by itself, faster than a drive that rings.
const DRIVE_LINE_TIME: f32 = 0.25;

/// Memory of a drive's vibration, s.
const RING_TIME: f32 = 1.0;

/// Lowest frequency of a line that is watched, Hz: half of the lowest mode of a heavy arm.
pub const LINE_FREQUENCY_MIN: f32 = 4.0;

/// Share of its square that a narrow line leaves unexplained at most.
const LINE_UNEXPLAINED_MAX: f32 = 0.2;

/// A line of the spindle in the push.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LineSignal {
    /// Amplitude, N.
    pub amplitude: f32,
    /// Phase against the angle that the spindle has turned since the watch began, rad.
    pub phase: f32,
    /// Its usual amplitude, N; 0 before one is known.
    pub usual: f32,
    /// True where it climbs.
    pub climbs: bool,
}

/// The vibration of a drive.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveSignal {
    /// RMS of its rate without mean and spindle's orders, rad/s.
    pub rate: f32,
    /// Frequency of the line in it, Hz, to 0.03 rad a period; 0 where there is none that is narrow.
    pub frequency: f32,
    /// True where it rings.
    pub rings: bool,
}

/// What is seen in a period.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HealthSignals {
    /// The spindle's lines in the push, in the order of [`WATCHED_ORDERS`]; zeros without a force
    /// loop.
    pub lines: [LineSignal; WATCHED_ORDERS.len()],
    /// RMS of the push without mean and lines, N.
    pub vibration: f32,
    /// The drives, A1 to A6.
    pub drives: [DriveSignal; JOINTS],
}

impl HealthSignals {
    /// True where anything is warned of.
    pub fn warns(&self) -> bool {
        self.lines.iter().any(|line| line.climbs) || self.drives.iter().any(|drive| drive.rings)
    }
}

/// The watch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HealthMonitor {
    period: f32,
    /// Spindle's angle since the beginning, rad, within a turn.
    angle: f32,
    /// Push asked for in the last period, N.
    asked: Option<f32>,
    /// Time since when it stands still, s.
    still: f32,
    lines: [SpindleLine; WATCHED_ORDERS.len()],
    usual: [f32; WATCHED_ORDERS.len()],
    vibration: VibrationLevel,
    /// Factor from the vibration to what noise may make of a line.
    noise: f32,
    drives: [Drive; JOINTS],
}

impl HealthMonitor {
    /// A watch that is asked every `period` s.
    ///
    /// `None` unless the period is positive and finite.
    pub fn new(period: f32) -> Option<Self> {
        let [first, second] = WATCHED_ORDERS;
        let lines = |time| {
            Some([SpindleLine::new(first, time, period)?, SpindleLine::new(second, time, period)?])
        };
        let drive = Drive {
            lines: lines(DRIVE_LINE_TIME)?,
            share: share(RING_TIME, period)?,
            past: [0.0; 4],
            sums: [0.0; 9],
            held: 0.0,
        };
        Some(Self {
            period,
            angle: 0.0,
            asked: None,
            still: 0.0,
            lines: lines(LINE_TIME)?,
            usual: [0.0; WATCHED_ORDERS.len()],
            vibration: VibrationLevel::new(LINE_TIME, period)?,
            noise: CLIMB_NOISE_DEVIATIONS * root(share(LINE_TIME, period)?),
            drives: [drive; JOINTS],
        })
    }

    /// One period of a controller: what it is asked for and what its instruments read, in whatever
    /// scalar.
    pub fn watch<T: Real + Into<f64>>(
        &mut self,
        setpoint: &Setpoint<T>,
        sensed: &SensorReadings<T>,
    ) -> HealthSignals {
        let single = |value: T| value.into() as f32;
        let rates: [f32; JOINTS] = sensed.encoder_rate.map(single).into();
        let push = -single(sensed.wrench.force.z);
        self.update(push, setpoint.force.map(single), single(setpoint.spindle_speed), &rates)
    }

    /// One period: the push that the sensor sees and the push asked for, N, the rate of the spindle
    /// and of the encoders, rad/s.
    pub fn update(
        &mut self,
        push: f32,
        asked: Option<f32>,
        spindle_speed: f32,
        encoder_rate: &[f32; JOINTS],
    ) -> HealthSignals {
        let turned = self.angle + spindle_speed * self.period;
        let angle = turned - TAU * F32Ext::floor(turned / TAU);
        if angle.is_finite() {
            self.angle = angle;
        }
        let turns = WATCHED_ORDERS.map(|order| F32Ext::sin_cos(f32::from(order) * self.angle));
        let mut seen = self.push(push, asked, turns);
        for ((drive, rate), seen) in self.drives.iter_mut().zip(encoder_rate).zip(&mut seen.drives)
        {
            *seen = drive.update(*rate, turns, self.period);
        }
        seen
    }

    /// The lines in the push; nothing of the drives.
    fn push(
        &mut self,
        push: f32,
        asked: Option<f32>,
        turns: [(f32, f32); WATCHED_ORDERS.len()],
    ) -> HealthSignals {
        if asked.is_none() || asked != self.asked {
            // A ramp of the push is no line.
            self.lines.iter_mut().for_each(SpindleLine::reset);
            self.vibration.reset();
            (self.still, self.usual) = (0.0, [0.0; WATCHED_ORDERS.len()]);
        }
        self.asked = asked;
        let mut seen = HealthSignals::default();
        if asked.is_none() {
            return seen;
        }
        self.still += self.period;
        let rest =
            self.lines.iter_mut().zip(turns).fold(push, |rest, (line, turn)| line.take(rest, turn));
        seen.vibration = self.vibration.update(rest);
        let learned = self.still - SETTLING;
        for ((line, usual), seen) in self.lines.iter().zip(&mut self.usual).zip(&mut seen.lines) {
            let amplitude = line.amplitude();
            if learned > 0.0 {
                let known = learned > LEARNING;
                let most = CLIMB * *usual + self.noise * self.vibration.level();
                // The mean of what was seen, then a slow average.
                let over = if known { USUAL_TIME + self.period } else { learned.max(self.period) };
                seen.climbs = known && amplitude > most;
                *usual += self.period / over * (amplitude - *usual);
            }
            (seen.amplitude, seen.phase, seen.usual) = (amplitude, line.phase(), *usual);
        }
        seen
    }
}

/// The watch over one drive.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Drive {
    lines: [SpindleLine; WATCHED_ORDERS.len()],
    share: f32,
    /// Rate of the periods before, rad/s, without mean and lines.
    past: [f32; 4],
    /// Means of its products with those: x₀x₀, x₀x₁, x₀x₂; x₀x₃, x₁x₃, x₂x₃; x₀x₄, x₁x₄, x₂x₄.
    sums: [f32; 9],
    /// Time for which it has been a line that hardly dies away, s.
    held: f32,
}

impl Drive {
    fn update(
        &mut self,
        rate: f32,
        turns: [(f32, f32); WATCHED_ORDERS.len()],
        period: f32,
    ) -> DriveSignal {
        let x =
            self.lines.iter_mut().zip(turns).fold(rate, |rest, (line, turn)| line.take(rest, turn));
        let [x1, x2, x3, x4] = self.past;
        let by = |z: f32| [x * z, x1 * z, x2 * z];
        let [[s00, s01, s02], [s03, s13, s23], [s04, s14, s24]] =
            [[x * x, x * x1, x * x2], by(x3), by(x4)];
        let products = [s00, s01, s02, s03, s13, s23, s04, s14, s24];
        if products.iter().all(|product| product.is_finite()) {
            for (sum, product) in self.sums.iter_mut().zip(products) {
                *sum += self.share * (product - *sum);
            }
            self.past = [x, x1, x2, x3];
        }
        let lowest = LINE_FREQUENCY_MIN * TAU * period;
        let line = self.line().filter(|(angle, _)| *angle > lowest);
        let lasts = line.is_some_and(|(angle, decay)| decay < RINGING_DAMPING_RATIO * angle);
        self.held = if lasts { self.held + period } else { 0.0 };
        DriveSignal {
            rate: root(self.sums[0]),
            frequency: line.map_or(0.0, |(angle, _)| angle / (TAU * period)),
            rings: self.held > RINGING_TIME,
        }
    }

    /// Angle a period, rad, and decay a period, −ln r, of the line that the rate is; `None` where it
    /// is none that is narrow.
    fn line(&self) -> Option<(f32, f32)> {
        let [s00, s01, s02, s03, s13, s23, s04, s14, s24] = self.sums;
        let determinant = s13 * s24 - s23 * s14;
        let a1 = (s03 * s24 - s23 * s04) / determinant;
        let a2 = (s13 * s04 - s14 * s03) / determinant;
        let cosine = a1 / (1.0 - a2);
        // Also false where there is no number.
        let narrow = (s00 - a1 * s01 - a2 * s02).abs() < LINE_UNEXPLAINED_MAX * s00;
        let swings = a2 < 0.0 && -1.0 < cosine && cosine < 1.0;
        (narrow && swings).then(|| (F32Ext::acos(cosine), 0.5 * (1.0 + a2)))
    }
}

impl Stateful for HealthMonitor {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        visitor.single(&mut self.angle)?;
        visitor.option(&mut self.asked, 0.0, |visitor, push| visitor.single(push))?;
        visitor.single(&mut self.still)?;
        self.lines.iter_mut().try_for_each(|line| line.visit_state(visitor))?;
        self.usual.iter_mut().try_for_each(|usual| visitor.single(usual))?;
        self.vibration.visit_state(visitor)?;
        self.drives.iter_mut().try_for_each(|drive| drive.visit_state(visitor))
    }
}

impl Stateful for Drive {
    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.lines.iter_mut().try_for_each(|line| line.visit_state(visitor))?;
        let numbers = self.past.iter_mut().chain(&mut self.sums);
        numbers.chain([&mut self.held]).try_for_each(|number| visitor.single(number))
    }
}
