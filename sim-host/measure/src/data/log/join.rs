//! Files of several clocks and rates become the rows of one log: those of the file with the
//! encoders, at whose times the others are read.

use super::columns::{Header, shown_name};
use super::files::Plan;
use super::notice::LogNotice;
use super::pose::{self, fit_places, points, span_a_plane, to_rotation_vectors, to_tool, tracked};
use super::samples::Columns;
use super::track::Track;
use crate::data::channel::{CHANNELS, COUNT, LogChannel};
use crate::data::clock::{ClockMap, FittedClock, Points, correlate, fit};
use crate::data::fir::interpolate;
use crate::data::kind::LogKind;
use crate::data::resample::{Resampler, Weights, median_step};
use nalgebra::Vector3;
use std::sync::Arc;
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Pose};
use trueweld_plant::input::{InputError, RobotFile, Table};

/// A point of every row.
type Series = Vec<Vector3<f64>>;

/// Rows from which on a log that is sampled faster than anything in it needs is thinned.
const MANY: usize = 100_000;

/// Period that a log is thinned to, s: nothing above some tens of hertz is compared of a motion or
/// a weld, and nothing above 200 Hz of a ring-down.
const THINNED: f64 = 4e-3;
const THINNED_RING: f64 = 1e-3;

/// Most missing rows in a row that are interpolated: beyond, the log is cut.
const FILLED: usize = 5;

/// A step of a log without a stated period is a gap where it is so many times the usual one.
const GAP: f64 = 10.0;

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
pub(super) struct Joined {
    pub columns: Columns,
    /// Variance of the noise in each column per variance of the instrument's.
    pub gain: [f64; COUNT],
    pub clocks: Vec<LogClock>,
    /// The point of the tool that the tracker saw, in T, m; `None` for the tool centre point.
    pub target: Option<Vector3<f64>>,
    /// What stands on clocks that were fitted.
    pub later: Arc<Vec<Track>>,
}

/// Brings the files of a log together.
pub(super) struct Join<'a> {
    pub kind: LogKind,
    pub robot: &'a RobotFile,
    pub period: Option<f64>,
    pub plan: &'a Plan,
    pub root: &'a Table<'a>,
}

const TIME: usize = LogChannel::Time.columns().start;

impl Join<'_> {
    /// Joins what was read. What a person should know goes into `notices`.
    pub fn run(
        &self,
        mut tracks: Vec<Track>,
        notices: &mut Vec<LogNotice>,
    ) -> Result<Joined, InputError> {
        let encoders = |track: &Track| {
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
        let path = self.path(&own);
        for entry in &self.plan.clocks {
            if clocks.iter().any(|clock| clock.name == entry.name) {
                continue;
            }
            let given = [entry.offset.is_some(), entry.drift.is_some()];
            let members: Vec<&Track> =
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
                notices.push(told(&entry.name, fitted));
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
        let mut columns = Columns { time: grid, ..Columns::default() };
        let mut gain = [1.0; COUNT];
        if columns.time.is_empty() {
            columns.time = own.columns[TIME].take().unwrap_or_default();
            for column in (0..COUNT).filter(|column| *column != TIME) {
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
        let fitted = |track: &Track| {
            clocks.iter().any(|c| Some(&c.name) == track.clock.as_ref() && c.fitted.is_some())
        };
        tracks.retain(fitted);
        Ok(Joined { columns, gain, clocks, target, later: Arc::new(tracks) })
    }

    /// Tool poses by the encoders.
    fn path(&self, own: &Track) -> Vec<Pose<f64>> {
        let foreign =
            self.plan.files.len() > 1 || (0..3).any(|r| own.has(super::columns::reflector(r)));
        if !foreign {
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
        own: &Track,
        path: &[Pose<f64>],
        members: &[&Track],
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
        own: &Track,
        members: &'t [&'t Track],
    ) -> Option<(Series, &'t Track, Series)> {
        let link = LogChannel::LinkEncoder.columns().start;
        let of = |track: &Track| -> Vec<usize> {
            (0..JOINTS).filter(|i| track.columns[link + i].is_some()).take(3).collect()
        };
        let track = members.iter().find(|track| !of(track).is_empty())?;
        let joints = of(track);
        let series = |track: &Track, first: usize| {
            (0..track.time().len())
                .map(|k| {
                    Vector3::from_fn(|i, _| {
                        joints.get(i).map_or(0.0, |joint| {
                            track.columns[first + joint].as_ref().map_or(f64::NAN, |c| c[k])
                        })
                    })
                })
                .collect::<Vec<_>>()
        };
        let encoder = LogChannel::Encoder.columns().start;
        Some((series(own, encoder), *track, series(track, link)))
    }

    /// True where rows at rest belong together by their order.
    fn by_order(&self, own: &Track, members: &[&Track]) -> bool {
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
                let of = |t: &&Table<'_>| {
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
        own: &mut Track,
        tracks: &mut [Track],
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

    /// The times that a log is thinned to; empty where it keeps its own.
    fn grid(&self, own: &Track, period: f64, notices: &mut Vec<LogNotice>) -> Vec<f64> {
        let target = match self.kind {
            LogKind::StaticLoad => return Vec::new(),
            LogKind::RingDown => THINNED_RING,
            LogKind::FreeMotion | LogKind::Weld => THINNED,
        };
        let period = self.period.unwrap_or(period);
        let every = (target / period * (1.0 + 1e-9)).floor();
        let time = own.time();
        let (Some(first), Some(last)) = (time.first(), time.last()) else {
            return Vec::new();
        };
        if time.len() < MANY || every < 2.0 {
            return Vec::new();
        }
        let step = every * period;
        notices.push(LogNotice::Thinned { rows: time.len(), from: period, to: step });
        let count = ((last - first) / step).floor() as usize + 1;
        (0..count).map(|k| first + k as f64 * step).collect()
    }

    /// Reads rows at rest: by their order, or each at the nearest time.
    fn at_rest(&self, track: &Track, map: &ClockMap, by_order: bool, columns: &mut Columns) {
        let times: Vec<f64> = track.time().iter().map(|t| map.own(*t)).collect();
        let rows: Vec<Option<usize>> = if by_order {
            (0..columns.time.len()).map(|k| (k < times.len()).then_some(k)).collect()
        } else {
            nearest_rows(&columns.time, &times)
        };
        for column in (0..COUNT).filter(|column| *column != TIME) {
            if let Some(values) = &track.columns[column] {
                let at = |row: &Option<usize>| row.map_or(f64::NAN, |k| values[k]);
                columns.values[column] = Some(rows.iter().map(at).collect());
            }
        }
    }
}

/// For each time the row that is nearest to it, if it is nearer to no other.
fn nearest_rows(own: &[f64], other: &[f64]) -> Vec<Option<usize>> {
    let nearest = |to: f64, among: &[f64]| {
        let after = among.partition_point(|t| *t < to);
        let candidates = [after.checked_sub(1), (after < among.len()).then_some(after)];
        candidates
            .into_iter()
            .flatten()
            .min_by(|a, b| (among[*a] - to).abs().total_cmp(&(among[*b] - to).abs()))
    };
    let of = |(k, t): (usize, &f64)| {
        nearest(*t, other).filter(|row| nearest(other[*row], own) == Some(k))
    };
    own.iter().enumerate().map(of).collect()
}

fn set_time(track: &mut Track, map: &ClockMap) {
    if *map != ClockMap::OWN {
        track.columns[TIME].iter_mut().flatten().for_each(|t| *t = map.own(*t));
    }
}

fn clock_of(track: &Track, clocks: &[LogClock]) -> ClockMap {
    clocks
        .iter()
        .find(|clock| Some(&clock.name) == track.clock.as_ref())
        .map_or(ClockMap::OWN, |clock| clock.map)
}

/// What is told of a clock that was fitted.
fn told(name: &str, fitted: &FittedClock) -> LogNotice {
    LogNotice::ClockFitted {
        clock: name.to_owned(),
        offset: fitted.map.offset,
        drift: fitted.map.drift,
        left: (fitted.left > STRANGE).then_some(fitted.left),
    }
}

/// Tool poses at the times of another track; NaN where there are none.
fn poses_at(own: &[f64], path: &[Pose<f64>], times: &[f64], map: &ClockMap) -> Vec<Pose<f64>> {
    let positions: Vec<Vector3<f64>> = path.iter().map(|pose| pose.position).collect();
    let at = |tau: &f64| {
        let t = map.own(*tau);
        let after = own.partition_point(|o| *o <= t);
        let inside = after > 0 && (after < own.len() || own.last() == Some(&t));
        if !inside {
            let nowhere = Vector3::repeat(f64::NAN);
            return Pose { position: nowhere, rotation: nalgebra::Matrix3::identity() };
        }
        let k = after - 1;
        let next = (k + 1).min(own.len() - 1);
        let share = if next > k { (t - own[k]) / (own[next] - own[k]) } else { 0.0 };
        let turned = rotation_vector(&path[k].rotation.tr_mul(&path[next].rotation));
        Pose {
            position: interpolate(&positions, k as f64 + share),
            rotation: path[k].rotation * rotation_from_vector(&(turned * share)),
        }
    };
    times.iter().map(at).collect()
}

/// Reads a track's channels at the times of `columns`. `gain`: what becomes of their noise.
pub(super) fn read_at(
    track: &Track,
    map: &ClockMap,
    kind: LogKind,
    columns: &mut Columns,
    gain: &mut [f64; COUNT],
) {
    let times: Vec<f64> = track.time().iter().map(|t| map.own(*t)).collect();
    let resampler = Resampler::new(&times, median_step(&columns.time));
    for channel in CHANNELS.iter().filter(|c| !matches!(c.id, LogChannel::Time)) {
        if channel.id == LogChannel::Payload && kind != LogKind::StaticLoad {
            continue;
        }
        let all = channel.id.columns();
        let groups: Vec<std::ops::Range<usize>> =
            if channel.together { vec![all] } else { all.map(|c| c..c + 1).collect() };
        for group in groups.into_iter().filter(|group| track.has(group.clone())) {
            let series: Vec<&[f64]> =
                group.clone().filter_map(|c| track.columns[c].as_deref()).collect();
            let turns = channel.id == LogChannel::Rotation;
            let (values, variance) = if series.iter().all(|s| s.iter().all(|v| v.is_finite())) {
                group_at(&resampler, &series, &columns.time, turns)
            } else {
                // Samples that lack a value are none.
                let whole = |k: &usize| series.iter().all(|s| s[*k].is_finite());
                let kept: Vec<usize> = (0..times.len()).filter(whole).collect();
                let pick = |s: &[f64]| kept.iter().map(|k| s[*k]).collect::<Vec<f64>>();
                let (times, series): (Vec<f64>, Vec<Vec<f64>>) =
                    (pick(&times), series.iter().map(|s| pick(s)).collect());
                let series: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
                let resampler = Resampler::new(&times, median_step(&columns.time));
                group_at(&resampler, &series, &columns.time, turns)
            };
            for (column, values) in group.zip(values) {
                columns.values[column] = Some(values);
                gain[column] = variance;
            }
        }
    }
}

/// Series at a grid of times, and the mean gain of their noise.
fn group_at(
    resampler: &Resampler<'_>,
    series: &[&[f64]],
    grid: &[f64],
    turns: bool,
) -> (Vec<Vec<f64>>, f64) {
    let mut out: Vec<Vec<f64>> = series.iter().map(|_| Vec::with_capacity(grid.len())).collect();
    let (mut from, mut weights) = (0, Weights::default());
    let (mut gains, mut count) = (0.0, 0.0);
    for time in grid {
        resampler.at(*time, &mut from, &mut weights);
        let (first, all) = (weights.first, &weights.weights);
        if all.is_empty() {
            out.iter_mut().for_each(|column| column.push(f64::NAN));
            continue;
        }
        gains += weights.gain();
        count += 1.0;
        if let ([_], true) | ([_], false) = (all.as_slice(), turns) {
            out.iter_mut().zip(series).for_each(|(column, s)| column.push(s[first]));
            continue;
        }
        if turns {
            // Rotations are weighed as what they turn from one of them.
            let vector = |k: usize| Vector3::new(series[0][k], series[1][k], series[2][k]);
            let middle = rotation_from_vector(&vector(first + all.len() / 2));
            let turned = |(k, w): (usize, &f64)| {
                rotation_vector(&middle.tr_mul(&rotation_from_vector(&vector(first + k)))) * *w
            };
            let sum: Vector3<f64> = all.iter().enumerate().map(turned).sum();
            let vector = rotation_vector(&(middle * rotation_from_vector(&sum)));
            out.iter_mut().zip(vector.iter()).for_each(|(column, v)| column.push(*v));
            continue;
        }
        for (column, s) in out.iter_mut().zip(series) {
            column.push(all.iter().zip(&s[first..]).map(|(w, v)| w * v).sum());
        }
    }
    let variance: f64 = if count > 0.0 { gains / count } else { 1.0 };
    (out, variance)
}

/// Fills short gaps of what drives the model, and says which rows make up the pieces between the
/// long ones.
pub(super) fn pieces(
    columns: &mut Columns,
    kind: LogKind,
    period: Option<f64>,
    header: &Header,
    notices: &mut Vec<LogNotice>,
) -> Vec<std::ops::Range<usize>> {
    let encoder = LogChannel::Encoder.columns();
    let whole = |columns: &Columns, k: usize| {
        encoder.clone().all(|c| columns.values[c].as_ref().is_some_and(|v| v[k].is_finite()))
    };
    if kind == LogKind::StaticLoad {
        let kept: Vec<usize> = (0..columns.time.len()).filter(|k| whole(columns, *k)).collect();
        let left = columns.time.len() - kept.len();
        if left > 0 {
            notices.push(LogNotice::RowsLeftOut(left));
            keep(columns, &kept);
        }
        return std::iter::once(0..columns.time.len()).collect();
    }
    let usual = period.unwrap_or_else(|| median_step(&columns.time));
    insert_lost_rows(columns, usual, period.is_some());
    let n = columns.time.len();
    let there: Vec<bool> = (0..n).map(|k| whole(columns, k)).collect();
    let step = |k: usize| columns.time[k + 1] - columns.time[k];
    let torn = |k: usize| step(k) > if period.is_some() { 1.5 * usual } else { GAP * usual };
    let mut pieces = Vec::new();
    let (mut start, mut filled, mut k) = (None::<usize>, 0, 0);
    let mut runs: Vec<std::ops::Range<usize>> = Vec::new();
    while k < n {
        if there[k] {
            start.get_or_insert(k);
            k += 1;
        } else {
            let end = (k..n).find(|j| there[*j]).unwrap_or(n);
            let short = end - k <= FILLED && start.is_some() && end < n;
            if short {
                runs.push(k..end);
                filled += end - k;
            } else if let Some(start) = start.take() {
                pieces.push(start..k);
            }
            k = end;
        }
        if let (Some(begin), true) = (start, k < n && k > 0 && torn(k - 1)) {
            pieces.push(begin..k);
            start = None;
        }
    }
    pieces.extend(start.map(|start| start..n));
    for run in &runs {
        for column in encoder.clone() {
            if let Some(values) = &mut columns.values[column] {
                fill(&columns.time, values, run.clone());
            }
        }
    }
    let lost = n - pieces.iter().map(|piece| piece.len()).sum::<usize>();
    if filled > 0 {
        notices.push(LogNotice::RowsInterpolated(filled));
    }
    if pieces.len() > 1 || lost > 0 {
        let first = columns.time.first().copied().unwrap_or(0.0);
        let at = |k: usize| columns.time[k.min(n - 1)] - first;
        let gaps = pieces.windows(2).take(6).map(|w| [at(w[0].end - 1), at(w[1].start)]);
        let encoder = encoder.start;
        notices.push(LogNotice::Cut {
            column: (!header.has(encoder)).then(|| shown_name(encoder)),
            gaps: gaps.collect(),
            pieces: pieces.len(),
        });
    }
    pieces
}

/// Puts rows without values where single ones were lost.
fn insert_lost_rows(columns: &mut Columns, period: f64, stated: bool) {
    let lost = |w: &[f64]| {
        let periods = ((w[1] - w[0]) / period).round();
        let few = periods >= 2.0 && periods <= (FILLED + 1) as f64;
        if few && stated { periods as usize - 1 } else { 0 }
    };
    if columns.time.windows(2).all(|w| lost(w) == 0) {
        return;
    }
    let old = std::mem::take(&mut columns.time);
    let mut from: Vec<Option<usize>> = Vec::with_capacity(old.len());
    for k in 0..old.len() {
        from.push(Some(k));
        columns.time.push(old[k]);
        if let Some(pair) = old.get(k..k + 2) {
            let rows = lost(pair);
            for j in 1..=rows {
                from.push(None);
                columns.time.push(pair[0] + (pair[1] - pair[0]) * j as f64 / (rows + 1) as f64);
            }
        }
    }
    for values in columns.values.iter_mut().flatten() {
        *values = from.iter().map(|row| row.map_or(f64::NAN, |k| values[k])).collect();
    }
}

fn keep(columns: &mut Columns, rows: &[usize]) {
    columns.time = rows.iter().map(|k| columns.time[*k]).collect();
    for values in columns.values.iter_mut().flatten() {
        *values = rows.iter().map(|k| values[*k]).collect();
    }
}

/// Fills a run of missing values by the polynomial through two values on either side.
fn fill(time: &[f64], values: &mut [f64], run: std::ops::Range<usize>) {
    let finite = |k: &usize| values[*k].is_finite();
    let mut around: Vec<usize> = (run.start.saturating_sub(2)..run.start).filter(finite).collect();
    around.extend((run.end..(run.end + 2).min(values.len())).filter(finite));
    if around.len() < 2 {
        return;
    }
    for k in run {
        if values[k].is_finite() {
            continue;
        }
        let weight = |i: &usize| {
            let others = around.iter().filter(|j| *j != i);
            others.map(|j| (time[k] - time[*j]) / (time[*i] - time[*j])).product::<f64>()
        };
        values[k] = around.iter().map(|i| weight(i) * values[*i]).sum();
    }
}

/// Fits the clocks that were not given once more, to the motion that a model predicts, and reads
/// their files anew. `poses`: the tool's at the rows.
pub(super) fn refit(
    time: &[f64],
    poses: &[Pose<f64>],
    target: Option<Vector3<f64>>,
    clocks: &mut [LogClock],
    tracks: &[Track],
    kind: LogKind,
) -> Option<Columns> {
    let on_tool = target.unwrap_or_else(Vector3::zeros);
    let path: Vec<Vector3<f64>> =
        poses.iter().map(|pose| pose.position + pose.rotation * on_tool).collect();
    let own = Points { time, point: &path };
    let mut moved = false;
    for clock in clocks.iter_mut().filter(|clock| clock.fitted.is_some()) {
        let mut members = tracks.iter().filter(|t| t.clock.as_ref() == Some(&clock.name));
        let Some((track, point)) = members.find_map(|t| Some((t, pose::points(t)?))) else {
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
    let mut columns = Columns { time: time.to_vec(), ..Columns::default() };
    let mut gain = [1.0; COUNT];
    for track in tracks {
        read_at(track, &clock_of(track, clocks), kind, &mut columns, &mut gain);
    }
    Some(columns)
}
