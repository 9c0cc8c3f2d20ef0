//! What a run asks of the tool over time: settle, close the force loop, feed, stop; or a step of
//! force.

use super::Phase;
use crate::input::Weld;
use crate::seam::Seam;

/// Time after full feed is reached before the steady part begins, s: two of the material's memories
/// at 10 mm/s, and the compensation's rise.
const FEED_SETTLE: f64 = 2.0;

/// Time the tool stands at the end of the seam with its force held, s.
const END_HOLD_TIME: f64 = 1.0;

/// What is asked at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ProgramTarget {
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
pub enum WeldProgram {
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

/// The feed along a seam: it rises, changes where the weld says so, and falls to 0 where the run-out
/// ends, at one acceleration.
struct Feed {
    pieces: Vec<SpeedPiece>,
    /// When it has risen and when it begins to fall, s.
    full: [f64; 2],
}

/// A time of constant acceleration: v = speed + change·(t − at)/span about an anchor, which may be its
/// beginning or its end.
#[derive(Debug, Clone, Copy)]
struct SpeedPiece {
    /// When it ends, s.
    until: f64,
    /// The anchor: time, s, path position, m, and speed, m/s.
    at: f64,
    path: f64,
    speed: f64,
    change: f64,
    span: f64,
}

impl SpeedPiece {
    /// A piece at one speed.
    fn even(at: f64, path: f64, speed: f64, until: f64) -> Self {
        Self { until, at, path, speed, change: 0.0, span: 1.0 }
    }
}

impl SpeedPiece {
    fn rate(&self, time: f64) -> f64 {
        self.speed + self.gain(time) / self.span
    }

    fn path(&self, time: f64) -> f64 {
        let by = time - self.at;
        self.path + self.speed * by + 0.5 * self.gain(time) * by / self.span
    }

    /// Change times the time since the anchor.
    fn gain(&self, time: f64) -> f64 {
        self.change * (time - self.at)
    }
}

impl Feed {
    fn new(weld: &Weld, length: f64) -> Self {
        let length = length + weld.run_out;
        // A seam shorter than both ramps is run at the speed that its ramps reach.
        let speed = weld.feed.min(length / weld.feed_ramp.max(f64::MIN_POSITIVE));
        let ramp = weld.feed_ramp;
        // Time for a change of speed.
        let span = |change: f64| (ramp * change / speed).abs().max(f64::MIN_POSITIVE);
        let rise = if ramp > 0.0 { 0.5 * speed * ramp * ramp / ramp } else { 0.0 };
        let of_ramp = ramp.max(f64::MIN_POSITIVE);
        let rising = SpeedPiece {
            until: ramp,
            at: 0.0,
            path: 0.0,
            speed: 0.0,
            change: speed,
            span: of_ramp,
        };
        let mut pieces = vec![rising];
        let (mut time, mut path, mut now) = (ramp, rise, speed);
        for &(from, next) in &weld.feeds {
            let reached = time + (from - path) / now;
            pieces.push(SpeedPiece::even(time, path, now, reached));
            let takes = span(next - now);
            pieces.push(SpeedPiece {
                until: reached + takes,
                at: reached,
                path: from,
                speed: now,
                change: next - now,
                span: takes,
            });
            (time, path) = (reached + takes, from + 0.5 * (now + next) * takes);
            now = next;
        }
        // One feed: both ramps are alike, and the seam may be no longer than they are.
        let [cruise, falls, end, way] = if weld.feeds.is_empty() {
            let cruise = (length / speed - ramp).max(0.0);
            [cruise, of_ramp, cruise + 2.0 * ramp, 2.0 * rise + speed * cruise]
        } else {
            let falls = span(now);
            let cruise = (length - path - 0.5 * now * falls) / now;
            [cruise, falls, time + cruise + falls, length]
        };
        pieces.push(SpeedPiece::even(time, path, now, time + cruise));
        let falling =
            SpeedPiece { until: end, at: end, path: way, speed: 0.0, change: -now, span: falls };
        pieces.push(falling);
        Self { pieces, full: [ramp, time + cruise] }
    }

    fn duration(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.until)
    }

    fn piece(&self, time: f64) -> &SpeedPiece {
        let last = self.pieces.len() - 1;
        &self.pieces[self.pieces.partition_point(|piece| piece.until <= time).min(last)]
    }

    /// Speed a time after the feed began, m/s.
    fn rate(&self, time: f64) -> f64 {
        if time < 0.0 || time > self.duration() { 0.0 } else { self.piece(time).rate(time) }
    }

    /// Path position a time after the feed began, m.
    fn path(&self, time: f64) -> f64 {
        let time = time.clamp(0.0, self.duration());
        self.piece(time).path(time)
    }

    /// When the tool reaches a path position, s: by bisection.
    fn reaches(&self, path: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.duration());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if self.path(middle) < path { low = middle } else { high = middle }
        }
        high
    }

    /// When the steady part ends: where the feed falls, or at the end of the seam.
    fn steady_until(&self, weld: &Weld, length: f64) -> f64 {
        if weld.run_out > 0.0 { self.reaches(length).min(self.full[1]) } else { self.full[1] }
    }
}

impl WeldProgram {
    /// How long the run takes, s.
    pub fn duration(&self, weld: &Weld, seam: &Seam) -> f64 {
        match self {
            WeldProgram::Weld => {
                weld.settle
                    + weld.force_ramp
                    + weld.dwell
                    + Feed::new(weld, seam.length).duration()
                    + END_HOLD_TIME
            }
            WeldProgram::ForceStep { hold, length, .. } => weld.settle + hold + length,
        }
    }

    /// When a weld's steady part begins and ends, s. `None` where the seam is too short to have
    /// one, and in a step of force.
    pub fn steady(&self, weld: &Weld, seam: &Seam) -> Option<[f64; 2]> {
        let WeldProgram::Weld = self else { return None };
        let feed = Feed::new(weld, seam.length);
        let start = weld.settle + weld.force_ramp + weld.dwell;
        let [rises, falls] = [feed.full[0] + FEED_SETTLE, feed.steady_until(weld, seam.length)];
        (rises < falls).then_some([start + rises, start + falls])
    }

    /// What is asked at `time`, s. `contact`: the push at rest before the force loop closes, N.
    pub fn target(&self, weld: &Weld, seam: &Seam, contact: f64, time: f64) -> ProgramTarget {
        let closed = time - weld.settle;
        if closed < 0.0 {
            return ProgramTarget { phase: Phase::Settle, path: 0.0, feed: 0.0, force: None };
        }
        match self {
            WeldProgram::ForceStep { height, hold, .. } => {
                let stepped = closed >= *hold;
                let phase = if stepped { Phase::Hold } else { Phase::ForceRamp };
                ProgramTarget {
                    phase,
                    path: 0.0,
                    feed: 0.0,
                    force: Some(contact + if stepped { *height } else { 0.0 }),
                }
            }
            WeldProgram::Weld => {
                let feed = Feed::new(weld, seam.length);
                let share =
                    if weld.force_ramp > 0.0 { (closed / weld.force_ramp).min(1.0) } else { 1.0 };
                let held = contact + (weld.force - contact) * share;
                let force = (weld.force > 0.0).then_some(held);
                let fed = closed - weld.force_ramp - weld.dwell;
                let full = feed.steady_until(weld, seam.length);
                let phase = match fed {
                    t if t < 0.0 => Phase::ForceRamp,
                    t if t < (feed.full[0] + FEED_SETTLE).min(full) => Phase::FeedRamp,
                    t if t < full => Phase::Steady,
                    t if t < feed.duration() => Phase::Stop,
                    _ => Phase::Hold,
                };
                ProgramTarget { phase, path: feed.path(fed), feed: feed.rate(fed), force }
            }
        }
    }
}
