//! What a run asks of the tool over time: settle, close the force loop, feed, stop; or a step of
//! force.

use super::Phase;
use crate::input::Weld;
use nalgebra::{Matrix3, Vector3};
use trueweld_core::Pose;

/// Time after full feed is reached before the steady part begins, s: two of the material's memories
/// at 10 mm/s, and the compensation's rise.
const FEED_SETTLE: f64 = 2.0;

/// Time the tool stands at the end of the seam with its force held, s.
const HOLD: f64 = 1.0;

/// What is asked at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Target {
    /// Where in the program.
    pub phase: Phase,
    /// Path position from the start of the seam, m.
    pub path: f64,
    /// Speed along the seam, m/s.
    pub feed: f64,
    /// Push asked for, N; `None` under pure position control.
    pub force: Option<f64>,
}

/// A run's program.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Program {
    /// A weld along its whole seam.
    Weld,
    /// At the start of the seam, no feed: after settling, the contact's own force is held for
    /// `hold` s, then the set-point steps by `height` N and is held for `length` s.
    ForceStep {
        /// Height of the step, N.
        height: f64,
        /// Time from closing the force loop to the step, s.
        hold: f64,
        /// Time recorded after the step, s.
        length: f64,
    },
}

/// A weld's line and its frames.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seam {
    /// The weld frame W in B: origin at the start on the plate's surface, x along the seam, z into
    /// the material.
    pub b_from_w: Pose<f64>,
    /// Length, m.
    pub length: f64,
}

impl Seam {
    /// The seam of a weld.
    pub fn of(weld: &Weld) -> Self {
        let along = weld.end - weld.start;
        let z = weld.tool_axis;
        // Square to the tool axis, should the path not be exactly.
        let x = (along - z * z.dot(&along)).normalize();
        let b_from_w =
            Pose { rotation: Matrix3::from_columns(&[x, z.cross(&x), z]), position: weld.start };
        Self { b_from_w, length: along.norm() }
    }

    /// Nominal tool pose at a path position: on the surface, z of T along z of W, y of T along the
    /// seam.
    pub fn nominal(&self, path: f64) -> Pose<f64> {
        let w = &self.b_from_w.rotation;
        let (x, z) = (w.column(0).into_owned(), w.column(2).into_owned());
        Pose {
            rotation: Matrix3::from_columns(&[x.cross(&z), x, z]),
            position: self.b_from_w.transform_point(&Vector3::new(path, 0.0, 0.0)),
        }
    }
}

/// The feed along a seam: a trapezoid of speed.
#[derive(Debug, Clone, Copy)]
struct Feed {
    speed: f64,
    ramp: f64,
    cruise: f64,
}

impl Feed {
    fn new(weld: &Weld, length: f64) -> Self {
        // A seam shorter than both ramps is run at the speed that its ramps reach.
        let speed = weld.feed.min(length / weld.feed_ramp.max(f64::MIN_POSITIVE));
        Self { speed, ramp: weld.feed_ramp, cruise: (length / speed - weld.feed_ramp).max(0.0) }
    }

    fn duration(&self) -> f64 {
        self.cruise + 2.0 * self.ramp
    }

    /// Speed a time after the feed began, m/s.
    fn rate(&self, time: f64) -> f64 {
        let from_end = time.min(self.duration() - time);
        match from_end {
            t if t < 0.0 => 0.0,
            t if t < self.ramp => self.speed * t / self.ramp,
            _ => self.speed,
        }
    }

    /// Path position a time after the feed began, m.
    fn path(&self, time: f64) -> f64 {
        let rising = |t: f64| {
            if self.ramp > 0.0 { 0.5 * self.speed * t * t / self.ramp } else { 0.0 }
        };
        let t = time.clamp(0.0, self.duration());
        if t < self.ramp {
            rising(t)
        } else if t < self.ramp + self.cruise {
            rising(self.ramp) + self.speed * (t - self.ramp)
        } else {
            let left = self.duration() - t;
            2.0 * rising(self.ramp) + self.speed * self.cruise - rising(left)
        }
    }
}

impl Program {
    /// How long the run takes, s.
    pub fn duration(&self, weld: &Weld, seam: &Seam) -> f64 {
        match self {
            Program::Weld => {
                weld.settle + weld.force_ramp + Feed::new(weld, seam.length).duration() + HOLD
            }
            Program::ForceStep { hold, length, .. } => weld.settle + hold + length,
        }
    }

    /// When a weld's steady part begins and ends, s. `None` where the seam is too short to have
    /// one, and in a step of force.
    pub fn steady(&self, weld: &Weld, seam: &Seam) -> Option<[f64; 2]> {
        let Program::Weld = self else { return None };
        let feed = Feed::new(weld, seam.length);
        let start = weld.settle + weld.force_ramp;
        let [rises, falls] = [feed.ramp + FEED_SETTLE, feed.ramp + feed.cruise];
        (rises < falls).then_some([start + rises, start + falls])
    }

    /// What is asked at `time`, s. `contact`: the push at rest before the force loop closes, N.
    pub fn target(&self, weld: &Weld, seam: &Seam, contact: f64, time: f64) -> Target {
        let closed = time - weld.settle;
        if closed < 0.0 {
            return Target { phase: Phase::Settle, path: 0.0, feed: 0.0, force: None };
        }
        match self {
            Program::ForceStep { height, hold, .. } => {
                let stepped = closed >= *hold;
                let phase = if stepped { Phase::Hold } else { Phase::ForceRamp };
                Target {
                    phase,
                    path: 0.0,
                    feed: 0.0,
                    force: Some(contact + if stepped { *height } else { 0.0 }),
                }
            }
            Program::Weld => {
                let feed = Feed::new(weld, seam.length);
                let share =
                    if weld.force_ramp > 0.0 { (closed / weld.force_ramp).min(1.0) } else { 1.0 };
                let force = Some(contact + (weld.force - contact) * share);
                let fed = closed - weld.force_ramp;
                let full = feed.ramp + feed.cruise;
                let phase = match fed {
                    t if t < 0.0 => Phase::ForceRamp,
                    t if t < (feed.ramp + FEED_SETTLE).min(full) => Phase::FeedRamp,
                    t if t < full => Phase::Steady,
                    t if t < feed.duration() => Phase::Stop,
                    _ => Phase::Hold,
                };
                Target { phase, path: feed.path(fed), feed: feed.rate(fed), force }
            }
        }
    }
}
