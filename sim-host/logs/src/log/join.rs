//! Files of several clocks and rates become the rows of one log: those of the file with the
//! encoders, at whose times the others are read.

use super::columns::{REFLECTOR_COUNT, TIME_COLUMN, reflector};
use super::files::ReadingPlan;
use super::gaps::GAP_PERIODS;
use super::notice::LogNotice;
use super::pose::{fit_places, points, span_a_plane, to_rotation_vectors, to_tool, tracked};
use super::rows_at::{nearest_rows, poses_at, read_at};
use super::samples::ColumnBuffer;
use super::track::FileTrack;
use crate::channel::{COUNT, LogChannel};
use crate::clock::{ClockMap, FittedClock, Points, correlate, fit};
use crate::kind::LogKind;
use crate::resample::{is_even, median_step};
use nalgebra::Vector3;
use std::sync::Arc;
use trueweld_core::{JOINTS, JointVector, Pose};
use trueweld_plant::input::{InputError, RobotFile, TomlTable};

/// A point of every row.
type ReflectorSeries = Vec<Vector3<f64>>;

/// Rows from which on a log that is sampled faster than anything in it needs is thinned.
const MANY: usize = 100_000;

/// Period that a log is thinned to, s: nothing above some tens of hertz is compared of a motion or
/// a weld, and nothing above 200 Hz of a ring-down.
const THINNED: f64 = 4e-3;
const THINNED_RING: f64 = 1e-3;

/// Left between what both saw, m, beyond which it was hardly the same motion.
const STRANGE: f64 = 0.05;

/// The clock of one of a log's instruments.
#[derive(Debug, Clone, PartialEq)]
pub struct LogClock {
    /// Its name in `log.toml`.
    pub name: String,
    /// How it runs.
    pub map: ClockMap,
    /// What was fitted, where it was not given.
    pub fitted: Option<FittedClock>,
    /// Which of offset and drift were given.
    pub given: [bool; 2],
}

/// What the files of a log came to.
pub(super) struct JoinedFiles {
    pub columns: ColumnBuffer,
    /// Variance of the noise in each column per variance of the instrument's.
    pub gain: [f64; COUNT],
    pub clocks: Vec<LogClock>,
    /// The point of the tool that the tracker saw, in T, m; `None` for the tool centre point.
    pub target: Option<Vector3<f64>>,
    /// What stands on clocks that were fitted.
    pub later: Arc<Vec<FileTrack>>,
}

/// Brings the files of a log together.
pub(super) struct Join<'a> {
    pub kind: LogKind,
    pub robot: &'a RobotFile,
    pub period: Option<f64>,
    pub plan: &'a ReadingPlan,
    pub root: &'a TomlTable<'a>,
}

impl Join<'_> {
    /// Joins what was read. What a person should know goes into `notices`.
    pub(crate) fn run(
        &self,
        mut tracks: Vec<FileTrack>,
        notices: &mut Vec<LogNotice>,
    ) -> Result<JoinedFiles, InputError> {
        let encoders = |track: &FileTrack| {
            LogChannel::Encoder.columns().filter(|c| track.columns[*c].is_some()).count()
        };
        let leader = (0..tracks.len()).rev().max_by_key(|k| encoders(&tracks[*k])).unwrap_or(0);
        let mut own = tracks.remove(leader);
        let mut clocks: Vec<LogClock> = Vec::new();
        // The clock of the encoders is the log's own, unless it is said how it runs.
        if let Some(entry) = self.plan.clocks.iter().find(|c| Some(&c.name) == own.clock.as_ref()) {
            let map =
                ClockMap { offset: entry.offset.unwrap_or(0.0), drift: entry.drift.unwrap_or(0.0) };
            set_time(&mut own, &map);
            clocks.push(LogClock { name: entry.name.clone(), map, fitted: None, given: [true; 2] });
        }
        std::iter::once(&mut own).chain(&mut tracks).for_each(to_rotation_vectors);
        let path = self.path(&own, !tracks.is_empty());
        for entry in &self.plan.clocks {
            if clocks.iter().any(|clock| clock.name == entry.name) {
                continue;
            }
            let given = [entry.offset.is_some(), entry.drift.is_some()];
            let members: Vec<&FileTrack> =
                tracks.iter().filter(|t| t.clock.as_ref() == Some(&entry.name)).collect();
            let start =
                ClockMap { offset: entry.offset.unwrap_or(0.0), drift: entry.drift.unwrap_or(0.0) };
            let fitted = if given == [true; 2] {
                None
            } else {
                self.fitted(&own, &path, &members, start, given)
            };
            if fitted.is_none() && !given[0] && !self.by_order(&own, &members) {
                return Err(self.no_offset(&entry.name));
            }
            if let Some(fitted) = &fitted {
                notices.push(fitted_clock(&entry.name, fitted));
            }
            clocks.push(LogClock {
                name: entry.name.clone(),
                map: fitted.map_or(start, |f| f.map),
                fitted,
                given,
            });
        }
        let target = self.reflectors(&mut own, &mut tracks, &clocks, &path, notices)?;
        let own_period = median_step(own.time());
        let grid = self.grid(&own, own_period, notices);
        let mut columns = ColumnBuffer { time: grid, ..ColumnBuffer::default() };
        let mut gain = [1.0; COUNT];
        if columns.time.is_empty() {
            columns.time = own.columns[TIME_COLUMN].take().unwrap_or_default();
            for column in (0..COUNT).filter(|column| *column != TIME_COLUMN) {
                columns.values[column] = own.columns[column].take();
            }
        } else {
            read_at(&own, &ClockMap::OWN, self.kind, &mut columns, &mut gain);
        }
        for track in &tracks {
            let map = clock_of(track, &clocks);
            if self.kind == LogKind::StaticLoad {
                let fixed = track.clock.is_some()
                    && clocks.iter().any(|c| Some(&c.name) == track.clock.as_ref() && !c.given[0]);
                self.at_rest(track, &map, fixed, &mut columns);
            } else {
                read_at(track, &map, self.kind, &mut columns, &mut gain);
            }
        }
        let fitted = |track: &FileTrack| {
            clocks.iter().any(|c| Some(&c.name) == track.clock.as_ref() && c.fitted.is_some())
        };
        tracks.retain(fitted);
        Ok(JoinedFiles { columns, gain, clocks, target, later: Arc::new(tracks) })
    }

    /// Tool poses by the encoders, where something else saw the tool. `others`: true where there are
    /// other tracks than the encoders' own.
    fn path(&self, own: &FileTrack, others: bool) -> Vec<Pose<f64>> {
        if !others && !(0..REFLECTOR_COUNT).any(|r| own.has(reflector(r))) {
            return Vec::new();
        }
        let first = LogChannel::Encoder.columns().start;
        let angle = |i: usize, k: usize| own.columns[first + i].as_ref().map_or(f64::NAN, |c| c[k]);
        (0..own.time().len())
            .map(|k| {
                let q = JointVector::from_fn(|i, _| angle(i, k));
                self.robot.robot.forward_kinematics(&q)
            })
            .collect()
    }

    /// Fits a clock by what its files saw of the motion.
    fn fitted(
        &self,
        own: &FileTrack,
        path: &[Pose<f64>],
        members: &[&FileTrack],
        start: ClockMap,
        given: [bool; 2],
    ) -> Option<FittedClock> {
        if self.kind == LogKind::StaticLoad {
            return None;
        }
        let seen = members.iter().find_map(|track| Some((track, points(track)?)));
        let (own_points, track, other_points) = match seen {
            Some((track, seen)) => {
                (path.iter().map(|pose| pose.position).collect::<Vec<_>>(), *track, seen)
            }
            None => self.by_link_encoders(own, members)?,
        };
        let a = Points { time: own.time(), point: &own_points };
        let b = Points { time: track.time(), point: &other_points };
        let (start, step) = if given[0] {
            (start, 1e-3)
        } else {
            let (offset, step) = correlate(&a, &b)?;
            (ClockMap { offset, ..start }, step)
        };
        fit(&a, &b, start, step, given)
    }

    /// Second encoders turn as the encoders do: angles of three joints as a point.
    fn by_link_encoders<'t>(
        &self,
        own: &FileTrack,
        members: &'t [&'t FileTrack],
    ) -> Option<(ReflectorSeries, &'t FileTrack, ReflectorSeries)> {
        let link = LogChannel::LinkEncoder.columns().start;
        let of = |track: &FileTrack| -> Vec<usize> {
            (0..JOINTS).filter(|i| track.columns[link + i].is_some()).take(3).collect()
        };
        let track = members.iter().find(|track| !of(track).is_empty())?;
        let joints = of(track);
        let encoder = LogChannel::Encoder.columns().start;
        let columns = |first: usize| joints.iter().map(|joint| first + joint).collect::<Vec<_>>();
        Some((as_points(own, &columns(encoder)), *track, as_points(track, &columns(link))))
    }

    /// True where rows at rest belong together by their order.
    fn by_order(&self, own: &FileTrack, members: &[&FileTrack]) -> bool {
        let rows = own.time().len();
        self.kind == LogKind::StaticLoad && members.iter().all(|t| t.time().len() == rows)
    }

    fn no_offset(&self, clock: &str) -> InputError {
        let (expected, help) = if self.kind == LogKind::StaticLoad {
            (
                "as many rows as the encoders have, or how its clock runs",
                "Rows at rest are matched by their order where there are as many of each, else by their time.",
            )
        } else {
            (
                "tracker points or second encoders that saw the motion, or how its clock runs",
                "Without them its offset cannot be fitted: the clock has to be stated.",
            )
        };
        let message = format!(
            "name the clock {clock:?}, whose offset is not given and cannot be fitted; expected {expected}"
        );
        let help = format!(
            "{help} Write [clock.{clock}] with offset_s = …, its time where the log's own is 0."
        );
        match self.root.tables("files") {
            Ok(files) => {
                let of = |t: &&TomlTable<'_>| {
                    t.has("clock") && t.text("clock").is_ok_and(|c| c.text == clock)
                };
                files.iter().find(of).unwrap_or(self.root).error(&message, help)
            }
            Err(error) => error,
        }
    }

    /// Turns reflectors into a pose or a point, wherever they were tracked.
    fn reflectors(
        &self,
        own: &mut FileTrack,
        tracks: &mut [FileTrack],
        clocks: &[LogClock],
        path: &[Pose<f64>],
        notices: &mut Vec<LogNotice>,
    ) -> Result<Option<Vector3<f64>>, InputError> {
        let own_time = own.time().to_vec();
        let Some(track) =
            std::iter::once(own).chain(tracks).find(|track| !tracked(track).is_empty())
        else {
            return Ok(None);
        };
        let there = tracked(track);
        let mut places = self.plan.reflectors;
        if there.iter().any(|r| places[*r].is_none()) {
            let map = clock_of(track, clocks);
            let poses = poses_at(&own_time, path, track.time(), &map);
            let Some(found) = fit_places(track, &poses, &places) else {
                let help = "Write where each sits in the tool frame: reflector1_m = [x, y, z] under [reflectors].";
                let expected = "reflectors whose places are stated, or a motion that tells them";
                return Err(self.root.wrong("columns", expected, help));
            };
            places = found;
            let placed = there.iter().filter(|r| self.plan.reflectors[**r].is_none());
            let placed = placed.filter_map(|r| Some((r + 1, places[*r]?))).collect();
            notices.push(LogNotice::ReflectorsPlaced(placed));
        }
        if there.len() == 3 && !span_a_plane(&places) {
            let expected = "three reflectors that do not lie on a line";
            let help = "A pose cannot be told from points on a line. Map one or two of them alone.";
            let key = if self.root.has("reflectors") { "reflectors" } else { "columns" };
            return Err(self.root.wrong(key, expected, help));
        }
        Ok(to_tool(track, &places))
    }

    /// The times that a log is thinned to, or an uneven one is brought to; empty where it keeps its
    /// own.
    fn grid(&self, own: &FileTrack, period: f64, notices: &mut Vec<LogNotice>) -> Vec<f64> {
        let target = match self.kind {
            LogKind::StaticLoad => return Vec::new(),
            LogKind::RingDown => THINNED_RING,
            LogKind::FreeMotion | LogKind::Weld => THINNED,
        };
        let period = self.period.unwrap_or(period);
        let every = (target / period * (1.0 + 1e-9)).floor();
        let time = own.time();
        let Some(first) = time.first() else { return Vec::new() };
        let step = if time.len() >= MANY && every >= 2.0 {
            let step = every * period;
            notices.push(LogNotice::Thinned { rows: time.len(), from: period, to: step });
            step
        } else if self.period.is_none() && !is_even(time) {
            notices.push(LogNotice::Resampled(period));
            period
        } else {
            return Vec::new();
        };
        let mut grid = Vec::with_capacity((time.len() as f64 * period / step) as usize + 1);
        let mut k = 0.0;
        for pair in time.windows(2) {
            // No rows over a gap: a clock that was set leaves one of years.
            if pair[1] - pair[0] > GAP_PERIODS * step {
                k = ((pair[1] - first) / step).ceil();
            }
            while first + k * step <= pair[1] {
                grid.push(first + k * step);
                k += 1.0;
            }
        }
        grid
    }

    /// Reads rows at rest: by their order, or each at the nearest time.
    fn at_rest(
        &self,
        track: &FileTrack,
        map: &ClockMap,
        by_order: bool,
        columns: &mut ColumnBuffer,
    ) {
        let times: Vec<f64> = track.time().iter().map(|t| map.own(*t)).collect();
        let rows: Vec<Option<usize>> = if by_order {
            (0..columns.time.len()).map(|k| (k < times.len()).then_some(k)).collect()
        } else {
            nearest_rows(&columns.time, &times)
        };
        for column in (0..COUNT).filter(|column| *column != TIME_COLUMN) {
            if let Some(values) = &track.columns[column] {
                let at = |row: &Option<usize>| row.map_or(f64::NAN, |k| values[k]);
                columns.values[column] = Some(rows.iter().map(at).collect());
            }
        }
    }
}

/// The values of up to three columns as a point at every row; 0 where there are fewer.
fn as_points(track: &FileTrack, columns: &[usize]) -> ReflectorSeries {
    let value = |column: usize, k: usize| track.columns[column].as_ref().map_or(f64::NAN, |c| c[k]);
    let point =
        |k: usize| Vector3::from_fn(|i, _| columns.get(i).map_or(0.0, |column| value(*column, k)));
    (0..track.time().len()).map(point).collect()
}

fn set_time(track: &mut FileTrack, map: &ClockMap) {
    if *map != ClockMap::OWN {
        track.columns[TIME_COLUMN].iter_mut().flatten().for_each(|t| *t = map.own(*t));
    }
}

fn clock_of(track: &FileTrack, clocks: &[LogClock]) -> ClockMap {
    clocks
        .iter()
        .find(|clock| Some(&clock.name) == track.clock.as_ref())
        .map_or(ClockMap::OWN, |clock| clock.map)
}

/// What is told of a clock that was fitted.
fn fitted_clock(name: &str, fitted: &FittedClock) -> LogNotice {
    LogNotice::ClockFitted {
        clock: name.to_owned(),
        offset: fitted.map.offset,
        drift: fitted.map.drift,
        left: (fitted.left > STRANGE).then_some(fitted.left),
    }
}

/// Fits the clocks that were not given once more, to the motion that a model predicts, and reads
/// their files anew. `poses`: the tool's at the rows.
pub(super) fn refit(
    time: &[f64],
    poses: &[Pose<f64>],
    target: Option<Vector3<f64>>,
    clocks: &mut [LogClock],
    tracks: &[FileTrack],
    kind: LogKind,
) -> Option<ColumnBuffer> {
    let on_tool = target.unwrap_or_else(Vector3::zeros);
    let path: Vec<Vector3<f64>> =
        poses.iter().map(|pose| pose.position + pose.rotation * on_tool).collect();
    let own = Points { time, point: &path };
    let mut moved = false;
    for clock in clocks.iter_mut().filter(|clock| clock.fitted.is_some()) {
        let mut members = tracks.iter().filter(|t| t.clock.as_ref() == Some(&clock.name));
        let Some((track, point)) = members.find_map(|t| Some((t, points(t)?))) else {
            continue;
        };
        let other = Points { time: track.time(), point: &point };
        let step = median_step(time);
        if let Some(fitted) = fit(&own, &other, clock.map, step, clock.given) {
            (clock.map, clock.fitted) = (fitted.map, Some(fitted));
            moved = true;
        }
    }
    if !moved {
        return None;
    }
    let mut columns = ColumnBuffer { time: time.to_vec(), ..ColumnBuffer::default() };
    let mut gain = [1.0; COUNT];
    for track in tracks {
        read_at(track, &clock_of(track, clocks), kind, &mut columns, &mut gain);
    }
    Some(columns)
}
