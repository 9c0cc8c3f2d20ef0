//! Encoder paths that are known exactly: angle, rate and acceleration at any time.

use trueweld_core::{JOINTS, JointVector};
use trueweld_plant::random::Random;

/// Where the encoders are.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Motor {
    /// Angle, rad.
    pub angle: JointVector<f64>,
    /// Rate, rad/s.
    pub rate: JointVector<f64>,
    /// Acceleration, rad/s².
    pub acceleration: JointVector<f64>,
}

/// A point that the arm moves to.
#[derive(Debug, Clone, Copy)]
pub struct Waypoint {
    /// Encoders, rad.
    pub to: JointVector<f64>,
    /// Time of the move, s.
    pub takes: f64,
    /// The rest there, s.
    pub dwell: f64,
}

/// A path of the encoders over time.
pub(crate) trait EncoderPath {
    /// Where they are at a time, s.
    fn at(&self, time: f64) -> Motor;
}

/// Constant rate until the brake falls, then a stop within milliseconds: a ring-down.
#[derive(Debug)]
pub(crate) struct BrakedStop {
    /// Angles at time 0, rad.
    pub start: JointVector<f64>,
    /// Rates until the brake falls, rad/s.
    pub rate: JointVector<f64>,
    /// When the brake falls, s.
    pub falls: f64,
    /// How long the brake takes, s.
    pub takes: f64,
}

impl EncoderPath for BrakedStop {
    fn at(&self, time: f64) -> Motor {
        let braked = (time - self.falls).clamp(0.0, self.takes);
        let share = 1.0 - braked / self.takes;
        let run = time.min(self.falls) + braked - 0.5 * braked * braked / self.takes;
        let slowing = if braked > 0.0 && braked < self.takes { -1.0 / self.takes } else { 0.0 };
        Motor {
            angle: self.start + self.rate * run,
            rate: self.rate * share,
            acceleration: self.rate * slowing,
        }
    }
}

/// Where free motion stays, rad: in front of the robot, the tool clear of the arm.
const FREE_MOTION_RANGE: [[f64; 2]; JOINTS] =
    [[-0.8, 0.8], [-1.25, -0.55], [1.2, 2.1], [-1.2, 1.2], [0.15, 1.5], [-1.4, 1.4]];

/// Largest rates of free motion, rad/s.
const FREE_MOTION_RATE_MAX: [f64; JOINTS] = [0.45, 0.4, 0.4, 0.6, 0.7, 0.9];

/// Rest before the first of the moves that a protocol states, and after a move where the file does
/// not say, s.
pub(crate) const MOVE_DWELL: f64 = 0.4;

/// Moves of least jerk, waves of two sines a joint, and dwells, one after the other, from rest.
#[derive(Debug)]
pub(crate) struct Moves {
    start: JointVector<f64>,
    lasts: f64,
    pieces: Vec<MotionPiece>,
}

#[derive(Debug)]
struct MotionPiece {
    begins: f64,
    takes: f64,
    from: JointVector<f64>,
    what: PieceMotion,
}

#[derive(Debug)]
enum PieceMotion {
    /// By this much, all joints together.
    Move(JointVector<f64>),
    /// Amplitudes, rates (rad/s) and phases of two sines, faded in and out.
    Wave(Box<[[JointVector<f64>; 3]; 2]>),
}

impl Moves {
    /// From rest through points, each reached by a move of least jerk and followed by a rest.
    pub(crate) fn through(start: JointVector<f64>, waypoints: &[Waypoint]) -> Self {
        let (mut from, mut time, mut pieces) = (start, MOVE_DWELL, Vec::new());
        for Waypoint { to, takes, dwell } in waypoints {
            pieces.push(MotionPiece {
                begins: time,
                takes: *takes,
                from,
                what: PieceMotion::Move(to - from),
            });
            from = *to;
            time += takes + dwell;
        }
        Self { start, lasts: time, pieces }
    }

    /// How long they last, with the rests, s.
    pub(crate) fn lasts(&self) -> f64 {
        self.lasts
    }

    /// A random motion that lasts `length` s.
    pub(crate) fn random(length: f64, random: &mut Random) -> Self {
        let start = JointVector::from_fn(|i, _| {
            random.between(FREE_MOTION_RANGE[i][0], FREE_MOTION_RANGE[i][1])
        });
        let (mut from, mut time, mut pieces) = (start, 0.1, Vec::new());
        while time < length {
            let (takes, what) = if random.between(0.0, 1.0) < 0.6 {
                let takes = random.between(1.2, 3.0);
                let by = JointVector::from_fn(|i, _| {
                    // Peak rate of a move of least jerk: 15/8 of the mean.
                    let far = FREE_MOTION_RATE_MAX[i] * takes * 8.0 / 15.0;
                    (random.between(FREE_MOTION_RANGE[i][0], FREE_MOTION_RANGE[i][1]) - from[i])
                        .clamp(-far, far)
                });
                (takes, PieceMotion::Move(by))
            } else {
                let wave = std::array::from_fn(|_| {
                    let rate = JointVector::from_fn(|_, _| random.between(1.5, 5.0));
                    let amplitude =
                        JointVector::from_fn(|i, _| 0.4 * FREE_MOTION_RATE_MAX[i] / rate[i]);
                    [amplitude, rate, JointVector::from_fn(|_, _| random.between(-3.1, 3.1))]
                });
                (random.between(3.0, 4.5), PieceMotion::Wave(Box::new(wave)))
            };
            let to = if let PieceMotion::Move(by) = &what { from + by } else { from };
            pieces.push(MotionPiece { begins: time, takes, from, what });
            from = to;
            let dwell = if random.sign() > 0.0 { random.between(0.2, 0.6) } else { 0.0 };
            time += takes + dwell;
        }
        Self { start, lasts: length, pieces }
    }
}

impl EncoderPath for Moves {
    fn at(&self, time: f64) -> Motor {
        let rest =
            |angle| Motor { angle, rate: JointVector::zeros(), acceleration: JointVector::zeros() };
        let Some(piece) = self.pieces.iter().rfind(|p| p.begins <= time) else {
            return rest(self.start);
        };
        let s = (time - piece.begins) / piece.takes;
        let (by_time, by_time2) = (1.0 / piece.takes, 1.0 / (piece.takes * piece.takes));
        match &piece.what {
            PieceMotion::Move(by) if s >= 1.0 => rest(piece.from + by),
            PieceMotion::Wave(_) if s >= 1.0 => rest(piece.from),
            PieceMotion::Move(by) => Motor {
                angle: piece.from + by * (s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s)),
                rate: by * (30.0 * s * s * (1.0 - s).powi(2) * by_time),
                acceleration: by * (60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * by_time2),
            },
            PieceMotion::Wave(sines) => {
                // Faded in and out by 64 (s (1 − s))³, whose second derivative is still continuous.
                let (u, du) = (s * (1.0 - s), 1.0 - 2.0 * s);
                let fade = [
                    64.0 * u.powi(3),
                    192.0 * u * u * du * by_time,
                    384.0 * u * (du * du - u) * by_time2,
                ];
                let mut at = rest(piece.from);
                for [amplitude, rate, phase] in sines.iter() {
                    for i in 0..JOINTS {
                        let (sine, cosine) = (rate[i] * (time - piece.begins) + phase[i]).sin_cos();
                        let wave = [sine, rate[i] * cosine, -rate[i] * rate[i] * sine]
                            .map(|w| amplitude[i] * w);
                        at.angle[i] += fade[0] * wave[0];
                        at.rate[i] += fade[1] * wave[0] + fade[0] * wave[1];
                        at.acceleration[i] +=
                            fade[2] * wave[0] + 2.0 * fade[1] * wave[1] + fade[0] * wave[2];
                    }
                }
                at
            }
        }
    }
}
