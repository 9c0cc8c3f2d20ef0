//! Mistakes in wrenches: columns that count the other way, are in another unit, or stand in each
//! other's place; a sensor that sits elsewhere than the log says ([`mounted`]).
//!
//! Each column is judged by what shows it. Where a tracker sees the tool, the arm gives way along its
//! load, by every column in a direction of its own. Of a weld, the push that was planned shows Fz,
//! and the process' drag the force in the plane of the plate. Columns that nothing shows to be wrong
//! keep their lines. A unit in which a column nearly vanishes explains no more than the column left
//! out does, unless the arm shows the difference or the column's own noise does.

use super::deflections::{Deflections, EQUAL_SQUARES_RATIO, TELLING_DEFLECTION_MIN};
use super::mounted::{self, Mounted};
use super::pose::column;
use super::relation::FACTOR;
use super::rows::LogRow;
use super::{ColumnChange, MisfitEvidence, Mistake, MistakeKind, Remedy, WrenchFrame};
use crate::AUTOCORRELATION_INFLATION;
use crate::predict::BaselineModel;
use nalgebra::{Matrix3, Vector2, Vector6};
use trueweld_core::{Pose, Robot};
use trueweld_logs::channel::LogChannel;
use trueweld_logs::log::{Log, LogKind};
use trueweld_logs::median;
use trueweld_plant::input::{InputError, Process};
use trueweld_plant::process::planned;
use trueweld_plant::simulate::Seam;

/// Share of the error that another sign or unit of a torque or wrench may leave.
pub(super) const UNDONE_ERROR_SHARE_MAX: f64 = 0.5;

/// Share of how far the tool moved that a load leaves which explains it.
const LOAD_UNEXPLAINED_MAX: f64 = 0.3;

/// By how much a sum of squares over its variance falls for what a column tells: four deviations.
const COLUMN_FALL_MIN: f64 = 16.0;

/// Sets of the columns fx, fy, fz, mx, my, mz, a bit each.
type WrenchColumns = u8;
const FZ_COLUMN: WrenchColumns = 0b100;
const IN_PLANE_COLUMNS: WrenchColumns = 0b011;
const FORCE_COLUMNS: WrenchColumns = 0b000_111;
const MOMENT_COLUMNS: WrenchColumns = 0b111_000;
const WRENCH_COLUMNS: WrenchColumns = FORCE_COLUMNS | MOMENT_COLUMNS;

/// A pound of force, N.
const POUND: f64 = 4.448_221_615;

/// How a wrench is to be read.
#[derive(Debug, Clone, Copy, PartialEq)]
enum WrenchReading {
    /// As it is.
    Plain,
    /// Some columns multiplied.
    Scaled(WrenchColumns, f64),
    /// Two columns for each other.
    Exchanged(usize, usize),
    /// Of a sensor that sits elsewhere.
    Mounted(Mounted),
}

impl WrenchReading {
    fn of(self, wrench: &Vector6<f64>) -> Vector6<f64> {
        let mut read = *wrench;
        match self {
            Self::Plain => {}
            Self::Scaled(set, factor) => each(set).for_each(|c| read[c] *= factor),
            Self::Exchanged(a, b) => read.swap_rows(a, b),
            Self::Mounted(Mounted { pose, .. }) => return mounted::at_tool(&pose, wrench),
        }
        read
    }

    fn columns(self) -> WrenchColumns {
        match self {
            Self::Plain => 0,
            Self::Scaled(set, _) => set,
            Self::Exchanged(a, b) => (1 << a) | (1 << b),
            Self::Mounted(_) => WRENCH_COLUMNS,
        }
    }

    /// True for the same mistake in columns that `other` has as well.
    fn is_part_of(self, other: Self) -> bool {
        match (self, other) {
            (Self::Scaled(set, factor), Self::Scaled(all, same)) => {
                factor == same && set & all == set
            }
            _ => self == other,
        }
    }
}

/// The columns of a set.
fn each(set: WrenchColumns) -> impl Iterator<Item = usize> {
    (0..6).filter(move |c| set & (1 << c) != 0)
}

/// Readings, simpler ones first; each list takes the same number of mistakes.
fn readings(in_pounds: bool) -> [Vec<WrenchReading>; 4] {
    let pairs = [(0, 1), (0, 2), (1, 2), (3, 4), (3, 5), (4, 5)];
    let scaled = |sets: &[WrenchColumns]| -> Vec<WrenchReading> {
        sets.iter().flat_map(|set| scaled(*set, in_pounds)).collect()
    };
    let mut one = scaled(&[1, 2, 4, 8, 16, 32]);
    one.extend(pairs.map(|(a, b)| WrenchReading::Exchanged(a, b)));
    let two = pairs.map(|(a, b)| (1 << a) | (1 << b));
    [one, scaled(&[FORCE_COLUMNS, MOMENT_COLUMNS]), scaled(&two), scaled(&[WRENCH_COLUMNS])]
}

/// Readings of a set of columns that count the other way or are in another unit.
fn scaled(set: WrenchColumns, in_pounds: bool) -> impl Iterator<Item = WrenchReading> {
    let pound = (in_pounds && set & MOMENT_COLUMNS == 0).then_some(POUND);
    let factors = [-1.0, 1e3, 1e-3, -1e3, -1e-3].into_iter().chain(pound);
    factors.map(move |factor| WrenchReading::Scaled(set, factor))
}

impl Deflections {
    /// Sum of squares that is left with the wrench read in one way, m².
    fn left(&self, reading: WrenchReading) -> f64 {
        self.left_by(|wrench| reading.of(wrench))
    }

    /// True where columns that are nearly scaled away say more than columns left out: the arm moves by
    /// what is left of them, or their noise is the stated one then, and was not before.
    fn is_told(&self, reading: WrenchReading) -> bool {
        let WrenchReading::Scaled(set, factor) = reading else { return true };
        if factor.abs() >= 1.0 {
            return true;
        }
        let (left, without) = (self.left(reading), self.left(WrenchReading::Scaled(set, 0.0)));
        let told = (without - left) * (6 * self.rows.len()) as f64
            > COLUMN_FALL_MIN * AUTOCORRELATION_INFLATION * left;
        let is_stated = |times: f64| (1.0 / FACTOR..FACTOR).contains(&times);
        let by_noise = |c: usize| {
            self.scatter[c].is_some_and(|t| is_stated(t * factor.abs()) && !is_stated(t))
        };
        told || each(set).all(by_noise)
    }

    /// The reading that explains the movement, another than the plain one only where it is much better,
    /// also than springs in place of rigid drives, and every simpler one much worse: last of all, columns
    /// left out. `None` where no load explains
    /// it.
    fn explained(&self, in_pounds: bool) -> Option<(WrenchReading, MisfitEvidence)> {
        let plain = self.left(WrenchReading::Plain);
        let mut best = (WrenchReading::Plain, plain.min(self.left_by_springs()));
        for mut readings in readings(in_pounds) {
            readings.retain(|reading| self.is_told(*reading));
            best = self.better(best, &readings);
        }
        for free in [[false, true], [true, false], [true, true]] {
            // What is left tells no more.
            if self.root(best.1) > TELLING_DEFLECTION_MIN {
                let found = mounted::find(self, free).map(WrenchReading::Mounted);
                best = self.better(best, found.as_slice());
            }
        }
        let without = [1, 2, 4, 8, 16, 32, FORCE_COLUMNS, MOMENT_COLUMNS]
            .map(|set| WrenchReading::Scaled(set, 0.0));
        best = self.better(best, &without);
        let channel = LogChannel::Position;
        let evidence = MisfitEvidence {
            before: self.root(plain),
            after: self.root(best.1),
            unit: "m",
            channel,
        };
        (best.1 < LOAD_UNEXPLAINED_MAX * LOAD_UNEXPLAINED_MAX * self.squares)
            .then_some((best.0, evidence))
    }

    /// The reading that leaves least, with what it leaves, m², where that is much less than `best`
    /// leaves; else `best`.
    fn better(
        &self,
        best: (WrenchReading, f64),
        readings: &[WrenchReading],
    ) -> (WrenchReading, f64) {
        let all = || readings.iter().map(|reading| (*reading, self.left(*reading)));
        let least = all().map(|(_, left)| left).fold(f64::INFINITY, f64::min);
        // Of those that leave the same, the first.
        let next = all().find(|(_, left)| *left <= EQUAL_SQUARES_RATIO * least);
        next.filter(|next| next.1 < UNDONE_ERROR_SHARE_MAX * UNDONE_ERROR_SHARE_MAX * best.1)
            .unwrap_or(best)
    }

    /// The sensor's place that explains the movement by itself.
    fn mounted(&self) -> Option<(Mounted, MisfitEvidence)> {
        match self.explained(false) {
            Some((WrenchReading::Mounted(mounted), evidence)) => Some((mounted, evidence)),
            _ => None,
        }
    }

    /// True where a sensor's place leaves hardly more than the one that these tell by themselves.
    fn agrees(&self, mounted: Mounted) -> bool {
        let own = self.mounted();
        let least = own.map_or(0.0, |(own, _)| self.left(WrenchReading::Mounted(own)));
        let left = self.left(WrenchReading::Mounted(mounted));
        UNDONE_ERROR_SHARE_MAX * UNDONE_ERROR_SHARE_MAX * left < least
    }
}

/// Force of a weld in the rows that pressed most, in T, N: the median along the tool, and the mean in
/// its plane; and the mean direction of the drag in that plane.
struct Pressing {
    push: f64,
    in_plane: Vector2<f64>,
    drag: Vector2<f64>,
}

impl Pressing {
    fn of(log: &Log, rows: &[LogRow], robot: &Robot<f64>) -> Option<Self> {
        log.samples.force.as_ref()?;
        // Without a push that was asked for, none tells.
        let weld = log.weld.as_ref().filter(|weld| weld.force > 0.0)?;
        let seam = Seam::of(weld);
        let mut rows: Vec<&LogRow> = rows.iter().collect();
        rows.sort_by(|a, b| b.wrench.force.z.abs().total_cmp(&a.wrench.force.z.abs()));
        rows.truncate(rows.len().div_ceil(2));
        let mut along: Vec<f64> = rows.iter().map(|row| -row.wrench.force.z).collect();
        let push = median(&mut along)?;
        let mean = |of: &dyn Fn(&LogRow) -> Vector2<f64>| {
            rows.iter().map(|row| of(row)).sum::<Vector2<f64>>() / rows.len() as f64
        };
        let in_plane = mean(&|row| row.wrench.force.xy());
        let drag = mean(&|row| {
            let tool = robot.forward_kinematics(&row.encoder);
            -tool.rotation.tr_mul(&seam.place(&tool.position).axes.column(0)).xy()
        });
        (push != 0.0).then_some(Self { push, in_plane, drag })
    }

    /// True where the force in the plane, so many times what was read, can be the process': against
    /// the feed, and of its size.
    fn is_drag(&self, factor: f64, expected: f64) -> bool {
        let force = self.in_plane * factor;
        let size = force.norm() / expected;
        size > 1.0 / FACTOR && size < FACTOR && force.dot(&self.drag) > 0.5 * force.norm()
    }
}

/// What push and drag of a weld say of its force. A weld pushes the tool out of the plate: along −z of
/// T.
fn of_process(
    log: &Log,
    rows: &[LogRow],
    robot: &Robot<f64>,
    process: Option<&Process>,
) -> Option<(WrenchReading, MisfitEvidence)> {
    let pressing = Pressing::of(log, rows, robot)?;
    let weld = log.weld.as_ref()?;
    let share = pressing.push / weld.force;
    let unit = match share.abs() {
        small if small < 1.0 / FACTOR => 1e3,
        large if large > FACTOR => 1e-3,
        _ => 1.0,
    };
    let factor = share.signum() * unit;
    let left = |factor: f64| (factor * pressing.push - weld.force).abs();
    let channel = LogChannel::Force;
    let planned = process.map(|process| planned(process, weld.force, weld.feed).xy().norm());
    let is_drag = |factor: f64| planned.is_some_and(|size| pressing.is_drag(factor, size));
    if factor == 1.0 {
        let units = [1e3, 1e-3, -1e3, -1e-3];
        let factor = units.into_iter().find(|factor| !is_drag(1.0) && is_drag(*factor))?;
        let left = |factor: f64| (factor * pressing.in_plane.norm() - planned.unwrap_or(0.0)).abs();
        let evidence =
            MisfitEvidence { before: left(1.0), after: left(factor.abs()), unit: "N", channel };
        return Some((WrenchReading::Scaled(IN_PLANE_COLUMNS, factor), evidence));
    }
    let set = if is_drag(factor) && !is_drag(1.0) { FORCE_COLUMNS } else { FZ_COLUMN };
    let evidence = MisfitEvidence { before: left(1.0), after: left(factor), unit: "N", channel };
    (evidence.after < UNDONE_ERROR_SHARE_MAX * weld.force.min(evidence.before))
        .then_some((WrenchReading::Scaled(set, factor), evidence))
}

/// True where a weld's push, read in pounds, is the one that was planned.
fn is_in_pounds(log: &Log, rows: &[LogRow], robot: &Robot<f64>) -> bool {
    /// Share of the push by which it may differ.
    const PLANNED_PUSH_TOLERANCE: f64 = 0.05;
    let planned = log.weld.as_ref().map_or(0.0, |weld| weld.force);
    Pressing::of(log, rows, robot).is_some_and(|read| {
        (read.push.abs() * POUND / planned - 1.0).abs() < PLANNED_PUSH_TOLERANCE
    })
}

/// A reading that undoes a mistake in some logs.
struct WrenchRemedy<'l> {
    reading: WrenchReading,
    evidence: MisfitEvidence,
    logs: Vec<&'l Log>,
}

/// Mistakes in the wrenches of logs whose poses are right.
pub(super) fn find(logs: &[Log], rows: &[Vec<LogRow>], model: &BaselineModel) -> Vec<Mistake> {
    let robot = &model.robot;
    let each_log = || logs.iter().zip(rows);
    let in_pounds = each_log().any(|(log, rows)| is_in_pounds(log, rows, robot));
    let mut shown: Vec<(WrenchRemedy<'_>, Option<Deflections>)> = Vec::new();
    let mut sensors = SensorGroups::default();
    for (log, rows) in each_log() {
        if !matches!(log.kind, LogKind::StaticLoad | LogKind::Weld) {
            continue;
        }
        let deflections = Deflections::of(log, rows, robot);
        let of_arm = deflections.as_ref().and_then(|d| Some((d, d.explained(in_pounds)?)));
        let found = match of_arm {
            // Columns that are better left out have no name.
            Some((_, (WrenchReading::Scaled(_, 0.0), _))) => None,
            Some((_, found)) if found.0 != WrenchReading::Plain => Some(found),
            // What the arm denies is no mistake.
            of_arm => {
                let process = model.process.as_ref().or(log.process.as_ref());
                of_process(log, rows, robot, process).filter(|(reading, _)| {
                    of_arm.is_none_or(|(d, _)| d.left(*reading) < d.left(WrenchReading::Plain))
                })
            }
        };
        match found {
            Some((WrenchReading::Mounted(_), _)) => {
                sensors.elsewhere.extend(deflections.map(|d| (log, d)))
            }
            Some((reading, evidence)) => {
                shown.push((WrenchRemedy { reading, evidence, logs: vec![log] }, deflections));
            }
            None if log.samples.force.is_some() => sensors.others.push((log, deflections)),
            None => {}
        }
    }
    // A log that shows part of what another one shows has the same mistake, unless it denies the rest.
    shown.sort_by_key(|(s, _)| std::cmp::Reverse(s.reading.columns().count_ones()));
    let mut joined: Vec<WrenchRemedy<'_>> = Vec::new();
    for (next, deflections) in shown {
        let denies = |whole: WrenchReading| {
            let left = |d: &Deflections, reading| {
                UNDONE_ERROR_SHARE_MAX * UNDONE_ERROR_SHARE_MAX * d.left(reading)
            };
            deflections.as_ref().is_some_and(|d| left(d, whole) > d.left(next.reading))
        };
        let whole = joined.iter_mut().find(|whole| {
            next.reading == whole.reading
                || next.reading.is_part_of(whole.reading) && !denies(whole.reading)
        });
        match whole {
            Some(whole) => whole.logs.extend(next.logs),
            None => joined.push(next),
        }
    }
    let columns = joined.into_iter().map(|shown| named(shown, logs));
    columns.chain(sensors.mistakes(logs)).collect()
}

/// Logs by how their force sensors sit.
#[derive(Default)]
struct SensorGroups<'l> {
    /// Elsewhere than the log says.
    elsewhere: Vec<(&'l Log, Deflections)>,
    /// Nothing shows where.
    others: Vec<(&'l Log, Option<Deflections>)>,
}

impl SensorGroups<'_> {
    /// A mistake for all logs of one sensor, or one for each log where they contradict each other.
    fn mistakes(&self, campaign: &[Log]) -> Vec<Mistake> {
        let mut found = Vec::new();
        let mut left: Vec<&(&Log, Deflections)> = self.elsewhere.iter().collect();
        while let Some((first, _)) = left.first() {
            let said = first.origin.wrench;
            let is_of_it = |log: &Log| log.origin.wrench == said;
            let (same, rest): (Vec<_>, Vec<_>) =
                left.into_iter().partition(|(log, _)| is_of_it(log));
            left = rest;
            let together = Deflections::together(same.iter().map(|(_, own)| own)).mounted();
            let together =
                together.filter(|(mounted, _)| same.iter().all(|(_, own)| own.agrees(*mounted)));
            if let Some((mounted, evidence)) = together {
                let allows = |own: &Deflections| {
                    own.left(WrenchReading::Mounted(mounted))
                        < EQUAL_SQUARES_RATIO * own.left(WrenchReading::Plain)
                };
                let others = self.others.iter();
                let others = others
                    .filter(|(log, own)| is_of_it(log) && own.as_ref().is_none_or(allows))
                    .map(|(log, _)| *log);
                let logs: Vec<&Log> = same.iter().map(|(log, _)| *log).chain(others).collect();
                found.push(elsewhere(&mounted, evidence, &logs, campaign));
            } else {
                let of_log = |(log, own): &&(&Log, Deflections)| {
                    let (mounted, evidence) = own.mounted()?;
                    Some(elsewhere(&mounted, evidence, &[*log], campaign))
                };
                found.extend(same.iter().filter_map(of_log));
            }
        }
        found
    }
}

/// A sensor that sits elsewhere than some logs of a campaign say.
fn elsewhere(
    mounted: &Mounted,
    evidence: MisfitEvidence,
    logs: &[&Log],
    campaign: &[Log],
) -> Mistake {
    let said = logs[0].origin.wrench;
    let [point_interval, axes_interval] = mounted.interval;
    let (kind, channel) = match mounted.pose.rotation == Matrix3::identity() {
        true => (MistakeKind::WrenchPoint, LogChannel::Moment),
        false => (MistakeKind::WrenchAxes, LogChannel::Force),
    };
    let of_log = |log: &&Log| logs.iter().any(|other| other.name == log.name);
    Mistake {
        kind,
        channel,
        columns: Vec::new(),
        logs: campaign.iter().filter(of_log).map(|log| log.name.clone()).collect(),
        evidence,
        change: Remedy::WrenchFrame(WrenchFrame {
            pose: mounted.pose * said.unwrap_or_else(Pose::identity),
            point_interval,
            axes_interval,
            replace: said.is_some(),
        }),
        lines: Vec::new(),
    }
}

/// A log whose load moves the arm as nobody saw it, in columns that no mistake explains: without them
/// it is explained.
pub(super) fn contradicted(
    logs: &[Log],
    rows: &[Vec<LogRow>],
    robot: &Robot<f64>,
) -> Option<InputError> {
    logs.iter().zip(rows).find_map(|(log, rows)| {
        if !matches!(log.kind, LogKind::StaticLoad | LogKind::Weld) {
            return None;
        }
        let (reading, evidence) = Deflections::of(log, rows, robot)?.explained(false)?;
        let WrenchReading::Scaled(set, 0.0) = reading else { return None };
        let name = |c: usize| {
            let channel = if c < 3 { LogChannel::Force } else { LogChannel::Moment };
            channel.entry().columns[c % 3]
        };
        let columns: Vec<&str> = each(set).map(name).collect();
        Some(log.contradicted(&columns, [evidence.before, evidence.after]))
    })
}

/// A reading as a mistake in logs of a campaign.
fn named(shown: WrenchRemedy<'_>, campaign: &[Log]) -> Mistake {
    let set = shown.reading.columns();
    let channel = if set & FORCE_COLUMNS == 0 { LogChannel::Moment } else { LogChannel::Force };
    let own = if channel == LogChannel::Force { FORCE_COLUMNS } else { MOMENT_COLUMNS };
    // All of a channel's columns are none in particular.
    let columns =
        if set & own == own { Vec::new() } else { each(set & own).map(|c| c % 3).collect() };
    let kind = match shown.reading {
        WrenchReading::Exchanged(..) => MistakeKind::Exchanged,
        WrenchReading::Scaled(set, -1.0) if set & FORCE_COLUMNS == FORCE_COLUMNS => {
            MistakeKind::WrenchSide
        }
        WrenchReading::Scaled(_, -1.0) | WrenchReading::Plain | WrenchReading::Mounted(_) => {
            MistakeKind::Sign
        }
        WrenchReading::Scaled(..) => MistakeKind::Unit,
    };
    let of_log = |log: &&Log| shown.logs.iter().any(|other| other.name == log.name);
    Mistake {
        kind,
        channel,
        columns,
        logs: campaign.iter().filter(of_log).map(|log| log.name.clone()).collect(),
        evidence: shown.evidence,
        change: Remedy::Columns(changes(shown.reading)),
        lines: Vec::new(),
    }
}

/// The lines of a reading.
fn changes(reading: WrenchReading) -> Vec<ColumnChange> {
    match reading {
        WrenchReading::Plain | WrenchReading::Mounted(_) => Vec::new(),
        WrenchReading::Scaled(set, factor) => each(set).map(|c| scaled_column(c, factor)).collect(),
        WrenchReading::Exchanged(a, b) => {
            let (first, second) = (scaled_column(a, 1.0), scaled_column(b, 1.0));
            let channels = (second.channel, first.channel);
            vec![
                ColumnChange { channel: channels.0, ..first },
                ColumnChange { channel: channels.1, ..second },
            ]
        }
    }
}

/// The line of column `c` of a wrench multiplied by a factor, in the unit that the factor is of.
fn scaled_column(c: usize, factor: f64) -> ColumnChange {
    let force = c < 3;
    let (unit, factor) = match factor.abs() {
        1e3 if force => ("kN", factor.signum()),
        1e3 => ("kNm", factor.signum()),
        1e-3 if !force => ("Nmm", factor.signum()),
        POUND => ("lbf", factor.signum()),
        _ if force => ("N", factor),
        _ => ("Nm", factor),
    };
    let channel = if force { LogChannel::Force } else { LogChannel::Moment };
    column(channel, c % 3, unit, factor)
}
