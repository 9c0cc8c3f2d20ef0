//! Two logs of the same motion, compared without a model: clocks are aligned on the motion that the
//! encoders show, the tracker's frame is found anew, and column by column it is told by how much the
//! logs differ, how much of that is noise, and what the difference follows.
//!
//! What a tracker or a second encoder reads is compared less what the encoders say, so that a path
//! that was driven a little otherwise is no difference of the arm. Left out: why logs differ, which
//! takes a model; loads that only one of the logs has.

use crate::HALF_95_OF_TEN;
use crate::channel::LogChannel;
use crate::clock::{ClockMap, FittedClock, Points, correlate, fit, rigid};
use crate::fir::LowPass;
use crate::kind::LogKind;
use crate::log::{Log, Samples};
use crate::noise::{NoiseLevels, instruments};
use crate::resample::{Resampler, Weights, median_step};
use nalgebra::{Matrix3, Vector3};
use std::collections::BTreeSet;
use std::f64::consts::TAU;
use thiserror::Error;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, Pose};

/// Two logs side by side, the second on the rows of the first.
#[derive(Debug, Clone)]
pub struct LogPair {
    /// The second log's clock against the first's; `None` of loads at rest.
    pub clock: Option<FittedClock>,
    /// Rows that are compared.
    pub rows: usize,
    /// Rows of the first and of the second log that the other does not have; of a motion those of the
    /// first alone.
    pub unmatched: [usize; 2],
    /// How the second log's tracker stands in the frame of the first's, which is taken out; `None` where
    /// one of them has no positions.
    pub tracker: Option<TrackerMove>,
    /// Every channel that both have.
    pub channels: Vec<ChannelDifference>,
}

/// A tracker's frame that moved from one log to another.
#[derive(Debug, Clone, Copy)]
pub struct TrackerMove {
    /// From the second log's frame to the first's.
    pub motion: Pose<f64>,
    /// False where the points lie on a line and tell no turn: a shift alone.
    pub turned: bool,
}

/// By how much two logs differ in a channel.
#[derive(Debug, Clone)]
pub struct ChannelDifference {
    /// The channel.
    pub channel: LogChannel,
    /// Its columns that both logs have.
    pub columns: Vec<ColumnDifference>,
}

/// By how much two logs differ in a column: the second less the first.
#[derive(Debug, Clone)]
pub struct ColumnDifference {
    /// Axis, or joint, from 0.
    pub component: usize,
    /// Values that were compared.
    pub count: usize,
    /// Root mean square, in the channel's unit.
    pub rms: f64,
    /// Largest magnitude, in the channel's unit, and its time in the first log, s.
    pub largest: (f64, f64),
    /// Mean, and half its 95 % interval from ten stretches of the log.
    pub mean: [f64; 2],
    /// What noise alone makes of it: root mean square; `None` where neither log tells.
    pub noise: Option<f64>,
    /// What explains most of it beside the mean.
    pub follows: Option<FollowedDifference>,
    /// Times in the first log, s, and what the first and the second say there.
    pub series: Vec<[f64; 3]>,
}

/// What a difference follows.
#[derive(Debug, Clone, Copy)]
pub struct FollowedDifference {
    /// What.
    pub of: DifferenceVariable,
    /// Share of the sum of squares that it explains.
    pub share: f64,
    /// Coefficient: in the channel's unit for a whole change of what it follows.
    pub size: f64,
}

/// What a difference may follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DifferenceVariable {
    /// Time, from the log's begin to its end.
    Time,
    /// The column's own value, the mean of both logs.
    Value,
    /// The direction of a joint's motion, from standing to moving; the joint from 0.
    Direction(usize),
    /// The mass on the flange, from none to the largest.
    Payload,
}

/// Why two logs cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PairError {
    /// Other experiments.
    #[error("one is a {0} log, the other a {1} log; expected two recordings of one experiment")]
    Kinds(LogKind, LogKind),
    /// Nothing to align clocks on.
    #[error("the encoders hardly move in one of them; expected a motion that both show")]
    Rests,
    /// Another motion.
    #[error(
        "the tool's paths by the encoders are {left:.3} m apart after the clocks were aligned, of {extent:.3} m; expected the same motion"
    )]
    OtherMotion {
        /// What is left between the paths, m.
        left: f64,
        /// Extent of the path, m.
        extent: f64,
    },
    /// No row of one is in the other.
    #[error(
        "no row of one has its posture and load in the other; expected two recordings of the same postures"
    )]
    NoCommonRow,
    /// No channel in both.
    #[error(
        "no channel beside the encoders is in both; expected a tracker, torques, second encoders or forces"
    )]
    Nothing,
}

/// Angle of a joint up to which two rows are of one posture, rad, and share of a mass up to which they
/// are of one load.
const EQUAL_POSTURE_ANGLE: f64 = 0.02;
const EQUAL_MASS_SHARE: f64 = 0.02;

/// Share of the path's extent that two drives of one program are apart at most.
const SAME_MOTION_SHARE: f64 = 0.01;

/// Stretches whose means tell how sure a mean is.
const MEAN_STRETCHES: usize = 10;

/// Extent of points across their line, as a share of that along it, from which on they tell a turn.
const TURN_TELLING_SHARE: f64 = 0.05;

/// Share of a joint's largest rate below which it stands.
const STANDING_RATE_SHARE: f64 = 0.05;

/// Share of the spindle's frequency below which forces are compared.
const SLOW_SHARE: f64 = 0.25;

/// Least share of the squared difference that what it follows explains to be told.
const FOLLOWED_SHARE_MIN: f64 = 0.1;

/// Compares two logs of one experiment; the robot is the first's.
///
/// # Errors
/// [`PairError`].
pub fn compare_logs(first: &Log, second: &Log) -> Result<LogPair, PairError> {
    if first.kind != second.kind {
        return Err(PairError::Kinds(first.kind, second.kind));
    }
    let levels = instruments(&[first.clone(), second.clone()]);
    let sides = [first, second].map(|log| LogSide::new(log, first));
    let (matched, clock) = match first.kind {
        LogKind::StaticLoad => (rows_at_rest(&first.samples, &second.samples), None),
        _ => rows_in_motion(&sides)?,
    };
    if matched.is_empty() {
        return Err(PairError::NoCommonRow);
    }
    let pair = Matching { sides: &sides, rows: &matched, levels: &levels, clock: clock.as_ref() };
    let (channels, tracker) = pair.channels();
    if channels.is_empty() {
        return Err(PairError::Nothing);
    }
    let used: BTreeSet<usize> = matched.iter().map(|(_, at)| at.first).collect();
    let at_rest = first.kind == LogKind::StaticLoad;
    let unmatched = [
        first.samples.len() - matched.len(),
        if at_rest { second.samples.len() - used.len() } else { 0 },
    ];
    Ok(LogPair { clock, rows: matched.len(), unmatched, tracker, channels })
}

/// A log with what its encoders say of the tool.
struct LogSide<'l> {
    log: &'l Log,
    nominal: Vec<Pose<f64>>,
    tool: Vec<Vector3<f64>>,
}

impl<'l> LogSide<'l> {
    fn new(log: &'l Log, of_robot: &Log) -> Self {
        let robot = &of_robot.robot.robot;
        let nominal: Vec<Pose<f64>> =
            log.samples.encoder.iter().map(|q| robot.forward_kinematics(q)).collect();
        let tool = nominal.iter().map(|pose| pose.position).collect();
        Self { log, nominal, tool }
    }

    fn points(&self) -> Points<'_> {
        Points { time: &self.log.samples.time, point: &self.tool }
    }
}

/// Rows of the first log with how the second's are weighed for each.
type MatchedRows = Vec<(usize, Weights)>;

/// Rows of the same posture under the same load, each once, in their order.
fn rows_at_rest(first: &Samples, second: &Samples) -> MatchedRows {
    let mass = |s: &Samples, row: usize| s.payload.as_ref().map_or(0.0, |p| p[row].mass);
    let heaviest = (0..first.len()).map(|row| mass(first, row)).fold(1.0, f64::max);
    let mut free: Vec<usize> = (0..second.len()).collect();
    let mut matched = Vec::new();
    for row in 0..first.len() {
        let alike = |k: &&usize| {
            (first.encoder[row] - second.encoder[**k]).amax() < EQUAL_POSTURE_ANGLE
                && (mass(first, row) - mass(second, **k)).abs() < EQUAL_MASS_SHARE * heaviest
        };
        if let Some(found) = free.iter().find(alike).copied() {
            free.retain(|k| *k != found);
            matched.push((row, Weights { first: found, weights: vec![1.0] }));
        }
    }
    matched
}

/// Every row of the first log for which the second has a value, by clocks that are aligned on what
/// the encoders say of the tool.
fn rows_in_motion(
    [first, second]: &[LogSide<'_>; 2],
) -> Result<(MatchedRows, Option<FittedClock>), PairError> {
    let (own, other) = (first.points(), second.points());
    let (offset, step) = correlate(&own, &other).ok_or(PairError::Rests)?;
    let start = ClockMap { offset, drift: 0.0 };
    let clock = fit(&own, &other, start, step, [false, false]).ok_or(PairError::Rests)?;
    let middle = first.tool.iter().sum::<Vector3<f64>>() / first.tool.len().max(1) as f64;
    let extent = first.tool.iter().map(|p| (p - middle).norm()).fold(0.0, f64::max);
    if clock.left > SAME_MOTION_SHARE * extent {
        return Err(PairError::OtherMotion { left: clock.left, extent });
    }
    let times: Vec<f64> = other.time.iter().map(|t| clock.map.own(*t)).collect();
    let resampler = Resampler::new(&times, median_step(own.time));
    let mut from = 0;
    let weighed = |row: usize| {
        let mut weights = Weights::default();
        resampler.at(own.time[row], &mut from, &mut weights);
        (row, weights)
    };
    let matched = (0..own.time.len()).map(weighed).filter(|(_, w)| !w.weights.is_empty());
    Ok((matched.collect(), Some(clock)))
}

struct Matching<'a> {
    sides: &'a [LogSide<'a>; 2],
    rows: &'a MatchedRows,
    levels: &'a [NoiseLevels],
    clock: Option<&'a FittedClock>,
}

/// A column of both logs on the rows of the first.
struct MatchedColumn {
    channel: LogChannel,
    component: usize,
    first: Vec<f64>,
    second: Vec<f64>,
    /// Variance of the noise of a value, per that of a reading.
    gain: f64,
}

impl Matching<'_> {
    fn channels(&self) -> (Vec<ChannelDifference>, Option<TrackerMove>) {
        let (mut columns, tracker) = self.tracker();
        for channel in [LogChannel::LinkEncoder, LogChannel::MotorTorque] {
            columns.extend((0..JOINTS).filter_map(|i| self.of_joint(channel, i)));
        }
        for channel in [LogChannel::Force, LogChannel::Moment] {
            columns.extend((0..3).filter_map(|axis| self.of_wrench(channel, axis)));
        }
        let variables = self.variables();
        let mut channels: Vec<ChannelDifference> = Vec::new();
        for column in &columns {
            let Some(difference) = self.difference(column, &variables) else { continue };
            match channels.last_mut().filter(|last| last.channel == column.channel) {
                Some(last) => last.columns.push(difference),
                None => channels
                    .push(ChannelDifference { channel: column.channel, columns: vec![difference] }),
            }
        }
        (channels, tracker)
    }

    /// A series of the second log on the first's rows.
    fn on_first(&self, series: &[f64]) -> Vec<f64> {
        let value = |at: &Weights| {
            let values = series.get(at.first..at.first + at.weights.len());
            values.map_or(f64::NAN, |v| v.iter().zip(&at.weights).map(|(v, w)| v * w).sum())
        };
        self.rows.iter().map(|(_, at)| value(at)).collect()
    }

    fn of_first(&self, series: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|(row, _)| series[*row]).collect()
    }

    fn column(
        &self,
        channel: LogChannel,
        component: usize,
        of: impl Fn(&LogSide<'_>) -> Option<(Vec<f64>, f64)>,
    ) -> Option<MatchedColumn> {
        let [(first, gain), (second, _)] = [of(&self.sides[0])?, of(&self.sides[1])?];
        let (first, second) = (self.of_first(&first), self.on_first(&second));
        Some(MatchedColumn { channel, component, first, second, gain })
    }

    fn of_joint(&self, channel: LogChannel, joint: usize) -> Option<MatchedColumn> {
        self.column(channel, joint, |side| {
            let samples = &side.log.samples;
            if channel == LogChannel::MotorTorque {
                return Some((samples.motor_torque[joint].clone()?, 1.0));
            }
            let link = samples.link_encoder[joint].as_ref()?;
            let twist = link.iter().zip(&samples.encoder).map(|(link, q)| link - q[joint]);
            Some((twist.collect(), 1.0))
        })
    }

    /// Forces and moments; of a weld what is slower than the spindle, whose phase no two welds share.
    fn of_wrench(&self, channel: LogChannel, axis: usize) -> Option<MatchedColumn> {
        self.column(channel, axis, |side| {
            let samples = &side.log.samples;
            let vectors = match channel {
                LogChannel::Force => samples.force.as_ref()?,
                _ => samples.moment.as_ref()?,
            };
            let series: Vec<f64> = vectors.iter().map(|v| v[axis]).collect();
            let turns = samples.spindle.as_ref().map(|s| s.iter().map(|w| w.abs()).sum::<f64>());
            let speed = turns.map_or(0.0, |sum| sum / samples.len() as f64) / TAU;
            if side.log.kind != LogKind::Weld || speed <= 0.0 {
                return Some((series, 1.0));
            }
            let filter = LowPass::new(SLOW_SHARE * speed, median_step(&samples.time));
            Some((filter.smooth(0, &series), filter.gain(0)))
        })
    }

    /// Positions and rotations, less what the encoders say, the second tracker in the first's frame.
    fn tracker(&self) -> (Vec<MatchedColumn>, Option<TrackerMove>) {
        let axes = [0, 1, 2];
        let of_axes = |of: &dyn Fn(&LogSide<'_>) -> Option<Vec<Vector3<f64>>>| {
            let [first, second] = [of(&self.sides[0])?, of(&self.sides[1])?];
            let series =
                |v: &[Vector3<f64>], axis: usize| v.iter().map(|v| v[axis]).collect::<Vec<_>>();
            let first = axes.map(|axis| self.of_first(&series(&first, axis)));
            let second = axes.map(|axis| self.on_first(&series(&second, axis)));
            let vectors = |of: [Vec<f64>; 3]| -> Vec<Vector3<f64>> {
                (0..of[0].len()).map(|k| Vector3::new(of[0][k], of[1][k], of[2][k])).collect()
            };
            Some([vectors(first), vectors(second)])
        };
        let nominal = of_axes(&|side| Some(side.tool.clone())).unwrap_or_default();
        let position = of_axes(&|side| side.log.samples.position.clone());
        let rotation = of_axes(&|side| {
            let turns = side.log.samples.rotation.as_ref()?.iter().zip(&side.nominal);
            let off = |(turn, pose): (&Vector3<f64>, &Pose<f64>)| {
                rotation_vector(&(rotation_from_vector(turn) * pose.rotation.transpose()))
            };
            Some(turns.map(off).collect())
        });
        let moved = position.as_ref().map(|seen| tracker_move(seen, &nominal));
        let mut columns = Vec::new();
        if let (Some([first, second]), Some(TrackerMove { motion, .. })) = (&position, &moved) {
            let off = |seen: &Vector3<f64>, nominal: &Vector3<f64>| seen - nominal;
            let first: Vec<_> = first.iter().zip(&nominal[0]).map(|(p, n)| off(p, n)).collect();
            let of_second = |(p, n): (&Vector3<f64>, &Vector3<f64>)| {
                off(&(motion.rotation * p + motion.position), n)
            };
            let second: Vec<_> = second.iter().zip(&nominal[1]).map(of_second).collect();
            columns.extend(axis_columns(LogChannel::Position, &first, &second));
        }
        if let Some([first, second]) = &rotation {
            let turn = moved.map_or_else(Matrix3::identity, |moved| moved.motion.rotation);
            // The first's own is zero: turns are compared as what leads from one to the other.
            let difference = first.iter().zip(second).map(|(a, b)| {
                let [a, b] = [a, b].map(rotation_from_vector);
                rotation_vector(&(turn * b * a.transpose()))
            });
            let second: Vec<Vector3<f64>> = difference.collect();
            let first = vec![Vector3::zeros(); second.len()];
            columns.extend(axis_columns(LogChannel::Rotation, &first, &second));
        }
        (columns, moved)
    }

    /// What differences may follow, one value a row.
    fn variables(&self) -> Vec<(DifferenceVariable, Vec<f64>)> {
        let samples = &self.sides[0].log.samples;
        let time = self.of_first(&samples.time);
        let [begin, end] = [time[0], time[time.len() - 1]];
        let span = (end - begin).max(f64::MIN_POSITIVE);
        let mut all = vec![(
            DifferenceVariable::Time,
            time.iter().map(|t| (t - begin) / span).collect::<Vec<_>>(),
        )];
        if let Some(payload) = &samples.payload {
            let heaviest = payload.iter().map(|p| p.mass).fold(f64::MIN_POSITIVE, f64::max);
            let shares: Vec<f64> = payload.iter().map(|p| p.mass / heaviest).collect();
            all.push((DifferenceVariable::Payload, self.of_first(&shares)));
        }
        if self.clock.is_some() {
            let directions = (0..JOINTS).map(|joint| {
                let of = self.of_first(&directions(samples, joint));
                (DifferenceVariable::Direction(joint), of)
            });
            all.extend(directions);
        }
        all
    }

    fn difference(
        &self,
        column: &MatchedColumn,
        variables: &[(DifferenceVariable, Vec<f64>)],
    ) -> Option<ColumnDifference> {
        let time = self.of_first(&self.sides[0].log.samples.time);
        let pairs = column.first.iter().zip(&column.second).zip(&time);
        let whole = pairs.enumerate().filter(|(_, ((a, b), _))| (*b - *a).is_finite());
        let (at, series): (Vec<usize>, Vec<[f64; 3]>) =
            whole.map(|(k, ((a, b), t))| (k, [*t, *a, *b])).unzip();
        let off: Vec<f64> = series.iter().map(|[_, a, b]| b - a).collect();
        if off.is_empty() {
            return None;
        }
        let count = off.len();
        let square = off.iter().map(|d| d * d).sum::<f64>();
        let largest = off.iter().zip(&series).max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))?;
        // Of both logs: the noise of one alone would follow itself.
        let values: Vec<f64> = series.iter().map(|[_, a, b]| 0.5 * (a + b)).collect();
        let own = [(DifferenceVariable::Value, values)];
        let of_rows = |all: &[f64]| at.iter().map(|k| all[*k]).collect::<Vec<_>>();
        let others = variables.iter().filter(|(of, _)| of.is_of(column));
        let tried = others.map(|(of, values)| (*of, of_rows(values))).chain(own);
        let follows = tried.filter_map(|(of, values)| followed(&off, &values, square, of));
        Some(ColumnDifference {
            component: column.component,
            count,
            rms: (square / count as f64).sqrt(),
            largest: (largest.0.abs(), largest.1[0]),
            mean: mean(&off),
            noise: self.noise(column, &series),
            follows: follows.max_by(|a, b| a.share.total_cmp(&b.share)),
            series,
        })
    }

    /// What noise makes of a difference: of both readings, and of clocks that are not aligned better.
    fn noise(&self, column: &MatchedColumn, series: &[[f64; 3]]) -> Option<f64> {
        let level = |side: usize, channel: LogChannel| {
            let level = self.levels[side].of(channel).get(column.component).copied().flatten();
            level.map(|level| level.deviation)
        };
        let weights = self.rows.iter().map(|(_, at)| at.gain()).sum::<f64>();
        let gain = [1.0, weights / self.rows.len() as f64];
        let mut variance = 0.0;
        for side in [0, 1] {
            let mut own = level(side, column.channel)?.powi(2);
            if column.channel == LogChannel::LinkEncoder {
                own += level(side, LogChannel::Encoder).unwrap_or(0.0).powi(2);
            }
            // What is smoothed scatters less, and is not smoothed again by being brought to other rows.
            variance += own * if column.gain < 1.0 { column.gain } else { gain[side] };
        }
        let late = self.clock.map_or(0.0, |clock| clock.deviation[0]);
        let rate = |w: &[[f64; 3]]| (w[1][1] - w[0][1]) / (w[1][0] - w[0][0]);
        let rates = series.windows(2).map(|w| rate(w).powi(2)).filter(|r| r.is_finite());
        let mean_rate = rates.sum::<f64>() / series.len() as f64;
        Some((variance + mean_rate * late * late).sqrt())
    }
}

/// Columns of a vector, by axis.
fn axis_columns<'a>(
    channel: LogChannel,
    first: &'a [Vector3<f64>],
    second: &'a [Vector3<f64>],
) -> impl Iterator<Item = MatchedColumn> + 'a {
    (0..3).map(move |component| {
        let of = |all: &[Vector3<f64>]| all.iter().map(|v| v[component]).collect();
        MatchedColumn { channel, component, first: of(first), second: of(second), gain: 1.0 }
    })
}

/// How the second tracker stands in the first's frame: what both saw of the tool, each less what its
/// encoders say, is brought together.
fn tracker_move(
    [first, second]: &[Vec<Vector3<f64>>; 2],
    nominal: &[Vec<Vector3<f64>>; 2],
) -> TrackerMove {
    let expected = first.iter().zip(&nominal[0]).zip(&nominal[1]).map(|((p, a), b)| p - a + b);
    let both = second.iter().copied().zip(expected);
    let (from, to): (Vec<_>, Vec<_>) =
        both.filter(|(a, b)| (a + b).iter().all(|v| v.is_finite())).unzip();
    let count = from.len().max(1) as f64;
    let middle = from.iter().sum::<Vector3<f64>>() / count;
    let spread: Matrix3<f64> = from.iter().map(|p| (p - middle) * (p - middle).transpose()).sum();
    let mut extents = spread.symmetric_eigenvalues().map(|v| v.max(0.0).sqrt()).as_slice().to_vec();
    extents.sort_by(f64::total_cmp);
    let turned = extents[1] > TURN_TELLING_SHARE * extents[2];
    let fitted = if turned { rigid(&from, &to) } else { None };
    let shift = || to.iter().zip(&from).map(|(b, a)| b - a).sum::<Vector3<f64>>() / count;
    let (rotation, position) = fitted.unwrap_or_else(|| (Matrix3::identity(), shift()));
    TrackerMove { motion: Pose { rotation, position }, turned: fitted.is_some() }
}

/// -1, 0 or 1 by how a joint moves at each row.
fn directions(samples: &Samples, joint: usize) -> Vec<f64> {
    let n = samples.len();
    let rate = |k: usize| {
        let (a, b) = (k.saturating_sub(1), (k + 1).min(n - 1));
        let time = (samples.time[b] - samples.time[a]).max(f64::MIN_POSITIVE);
        (samples.encoder[b][joint] - samples.encoder[a][joint]) / time
    };
    let rates: Vec<f64> = (0..n).map(rate).collect();
    let standing = STANDING_RATE_SHARE * rates.iter().fold(0.0_f64, |most, r| most.max(r.abs()));
    rates.iter().map(|r| if r.abs() > standing { r.signum() } else { 0.0 }).collect()
}

impl DifferenceVariable {
    /// True for what a column may follow: of joints its own.
    fn is_of(self, column: &MatchedColumn) -> bool {
        let of_joint = matches!(column.channel, LogChannel::LinkEncoder | LogChannel::MotorTorque);
        match self {
            Self::Direction(joint) => !of_joint || joint == column.component,
            _ => true,
        }
    }
}

/// The mean, and half its 95 % interval by the means of stretches.
fn mean(off: &[f64]) -> [f64; 2] {
    let of = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let mean = of(off);
    let stretches: Vec<f64> = off.chunks(off.len().div_ceil(MEAN_STRETCHES)).map(of).collect();
    let count = stretches.len() as f64;
    let square: f64 = stretches.iter().map(|m| (m - mean).powi(2)).sum();
    let error = (square / (count - 1.0).max(1.0) / count).sqrt();
    [mean, if stretches.len() < 2 { f64::INFINITY } else { HALF_95_OF_TEN * error }]
}

/// What a difference follows beside its mean, where it explains enough of it.
fn followed(
    off: &[f64],
    values: &[f64],
    square: f64,
    of: DifferenceVariable,
) -> Option<FollowedDifference> {
    let count = off.len() as f64;
    let [mean_off, mean] = [off, values].map(|all| all.iter().sum::<f64>() / count);
    let spread: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
    let both: f64 = off.iter().zip(values).map(|(d, v)| (d - mean_off) * (v - mean)).sum();
    if spread <= 0.0 || square <= 0.0 {
        return None;
    }
    let (size, share) = (both / spread, both * both / spread / square);
    (share >= FOLLOWED_SHARE_MIN).then_some(FollowedDifference { of, share, size })
}

impl ColumnDifference {
    /// How many times the noise the difference is; `None` where that is not known.
    pub fn score(&self) -> Option<f64> {
        self.noise.filter(|noise| *noise > 0.0).map(|noise| self.rms / noise)
    }
}

impl ChannelDifference {
    /// Root mean square over its columns, in the unit.
    pub fn rms(&self) -> f64 {
        self.root(|column| Some(column.rms)).unwrap_or(0.0)
    }

    /// What noise alone makes of it, in the unit; `None` where a column does not tell.
    pub fn noise(&self) -> Option<f64> {
        self.root(|column| column.noise)
    }

    /// How many times the noise the difference is; `None` where that is not known.
    pub fn score(&self) -> Option<f64> {
        self.noise().filter(|noise| *noise > 0.0).map(|noise| self.rms() / noise)
    }

    /// The column that differs most, in its noise where that is known.
    pub fn worst(&self) -> Option<&ColumnDifference> {
        let size = |column: &&ColumnDifference| column.rms / column.noise.unwrap_or(1.0);
        self.columns.iter().max_by(|a, b| size(a).total_cmp(&size(b)))
    }

    fn root(&self, of: impl Fn(&ColumnDifference) -> Option<f64>) -> Option<f64> {
        let squares: Option<Vec<f64>> = self
            .columns
            .iter()
            .map(|column| of(column).map(|value| value * value * column.count as f64))
            .collect();
        let count: usize = self.columns.iter().map(|column| column.count).sum();
        Some((squares?.iter().sum::<f64>() / count.max(1) as f64).sqrt())
    }
}
