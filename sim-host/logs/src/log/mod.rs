//! A recorded log: a folder with `log.toml`, which says what was done, and the files that hold what
//! was measured.
//!
//! `samples.csv` with the columns of [`crate::channel`] needs no more; other files are mapped
//! by `files`, `[clock]`, `[columns]` and `[reflectors]`. One way leads through both:
//!
//! ```text
//! file ─ rows ─► named columns ─ columns ─► SI units, checked ─ track ─► join ─► rows of the log
//! text, …                        [columns]                      [clock], [reflectors]
//! ```
//!
//! A log that was read is complete and plausible: every required column is there, every number
//! parsed, the time rises, and no channel is in another unit than its name says. Rows are read as a
//! stream; what is held is the columns. Left out: filtering, and filling in of missing values but
//! short gaps of the encoders, which are up to the prediction.

mod arrays;
mod blocks;
mod bursts;
mod columns;
pub mod computed;
mod coupling;
mod files;
mod format;
mod gaps;
pub mod import;
mod join;
mod kuka;
mod lines;
mod matlab;
#[cfg(feature = "mcap")]
mod mcap;
mod misplaced;
mod noise;
mod notice;
mod numpy;
#[cfg(feature = "parquet")]
mod parquet;
mod plausible;
mod pose;
#[cfg(any(feature = "mcap", feature = "rosbag"))]
mod ros;
#[cfg(feature = "rosbag")]
mod rosbag;
mod rows;
mod rows_at;
mod samples;
mod screen;
mod sentinel;
mod slow_channels;
mod source;
mod text;
mod time_of_day;
mod track;
pub mod units;

pub use columns::channel_named;
pub use columns::{ColumnMapping, channel_name, dimension};
pub use coupling::Coupling;
pub use files::SAMPLES_FILE;
pub use join::LogClock;
pub use noise::{NoiseLevel, NoiseLevels};
pub use notice::{FoundFactor, LogNotice};
pub use samples::{Payload, Samples};

use super::channel::LogChannel;
pub use super::kind::LogKind;
use crate::register::Mounting;
use columns::{Bound, LogHeader, TIME_COLUMN};
use files::ReadingPlan;
use join::{Join, JoinedFiles};
use nalgebra::Vector3;
use rows::RowSource;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use track::{Expected, FileTrack};
use trueweld_core::spatial::rotation_from_vector;
use trueweld_core::{JOINTS, Pose, Robot};
use trueweld_plant::input::{
    Accuracy, Bounds, FileKind, InputError, InputFile, Process, RobotFile, Source, TomlDocument,
    TomlTable, Weld, nearest, read_text,
};
use trueweld_plant::simulate::Seam;

/// Name of the file that says what a log is.
pub const LOG_FILE: &str = "log.toml";

/// A log that was read and checked.
#[derive(Debug, Clone)]
pub struct Log {
    /// The folder.
    pub path: PathBuf,
    /// Every file that it was read from, and the list of the campaign it was read as a part of.
    pub files: Vec<PathBuf>,
    /// Name of the folder; in a campaign, as the campaign lists it.
    pub name: String,
    /// What was done.
    pub kind: LogKind,
    /// The robot it was recorded on.
    pub robot: RobotFile,
    /// The weld that was made; every weld log has one.
    pub weld: Option<Weld>,
    /// The process that was expected; every weld log has one.
    pub process: Option<Process>,
    /// Sampling period, s; `None` of rows at rest. Where it is stated, each step of the time, and
    /// their mean, keep it within 1 % and what rounding of the written times makes; elsewhere it is
    /// the median step.
    pub period: Option<f64>,
    /// Noise as stated.
    pub noise: NoiseLevels,
    /// How exact predictions of it need be, as its campaign says.
    pub accuracy: Accuracy,
    /// The rows.
    pub samples: Samples,
    /// What a person should know although nothing is wrong: columns that were left out.
    pub notices: Vec<LogNotice>,
    /// Text of `log.toml`, for errors that point into it.
    pub source: Source,
    /// How the files became the rows.
    pub origin: LogOrigin,
    /// The first value that cannot be right, in the files as they are.
    pub implausible: Option<InputError>,
}

/// How the files of a log became its rows.
#[derive(Debug, Clone, Default)]
pub struct LogOrigin {
    /// The entries of `[columns]`.
    pub columns: Vec<ColumnMapping>,
    /// The clocks of its instruments.
    pub clocks: Vec<LogClock>,
    /// The point of the tool that the tracker saw, in T, m, where it is not the tool centre point.
    pub target: Option<Vector3<f64>>,
    /// How the force sensor sits, where `log.toml` says so: its axes, and the point that its moment is
    /// about, in T, m.
    pub wrench: Option<Pose<f64>>,
    /// Motor torques in a unit of the drive whose factor is not stated, by joint.
    pub currents: [Option<MotorCurrent>; JOINTS],
    /// Where the tracker stands, where `log.toml` says so or it was found.
    mounting: Option<Mounting>,
    /// What stands on clocks that were fitted.
    later: Arc<Vec<FileTrack>>,
}

/// Motor torques of a joint in a unit of the drive whose factor is not stated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotorCurrent {
    /// The unit.
    pub unit: &'static str,
    /// The torque at the joint, N·m, of one unit, by which the samples were multiplied; `None` before
    /// it was found: they are in the unit then.
    pub factor: Option<f64>,
}

impl LogOrigin {
    /// True where `log.toml` says where the tracker stands, or it was found.
    pub fn is_registered(&self) -> bool {
        self.mounting.is_some()
    }
}

impl Log {
    /// Reads the log in a folder, with the robot, weld and process that it names: of one that gaps
    /// cut into pieces the longest.
    ///
    /// # Errors
    /// The first thing that does not fit, with file, line and column.
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, InputError> {
        longest(Self::read_pieces(folder)?).plausible()
    }

    /// Reads the log in a folder; a value that cannot be right is in its
    /// [`implausible`](Self::implausible). Where the encoders, which drive the model, were not
    /// recorded for a while, it is cut into pieces, each a log of its own.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn read_pieces(folder: impl AsRef<Path>) -> Result<Vec<Self>, InputError> {
        let folder = folder.as_ref();
        let (_, text) = read_text(&folder.join(LOG_FILE))?;
        Self::parse_pieces(&text, None, folder)
    }

    /// Reads a log from the text of its `log.toml` and its rows, as of `samples.csv`; `folder` is
    /// where its paths start and what errors name.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn parse(text: &str, samples: impl Read, folder: &Path) -> Result<Self, InputError> {
        let mut samples = samples;
        longest(Self::parse_pieces(text, Some(&mut samples), folder)?).plausible()
    }

    /// The log, unless a value in it cannot be right.
    ///
    /// # Errors
    /// The first such value.
    pub fn plausible(self) -> Result<Self, InputError> {
        self.implausible.clone().map_or(Ok(self), Err)
    }

    fn parse_pieces(
        text: &str,
        samples: Option<&mut dyn Read>,
        folder: &Path,
    ) -> Result<Vec<Self>, InputError> {
        let file = folder.join(LOG_FILE).display().to_string();
        let document = TomlDocument::parse(text, &file)?;
        let root = document.root_of(FileKind::Log.schema())?;
        let mut keys = vec!["schema", "kind", "robot", "weld", "process", "period_s", "noise"];
        keys.extend(files::KEYS);
        keys.extend(["tracker", "wrench"]);
        root.only(&keys)?;
        let kind = kind(&root)?;
        let mut read = vec![folder.join(LOG_FILE)];
        let mut named = |key| {
            let file = root.file(key, folder)?;
            read.push(file.clone());
            Ok::<PathBuf, InputError>(file)
        };
        let robot = RobotFile::read(named("robot")?)?;
        let wanted = |key: &str| kind == LogKind::Weld || root.has(key);
        let weld = if wanted("weld") { Some(Weld::read(named("weld")?)?) } else { None };
        let process =
            if wanted("process") { Some(Process::read(named("process")?)?) } else { None };
        let period = root.optional("period_s", |root, key| root.number(key, Bounds::Positive))?;
        let mounting = root.optional_table("tracker", mounting)?;
        let wrench = root.optional_table("wrench", sensor)?;
        let plan = ReadingPlan::read(&root, folder)?;
        read.extend(plan.files.iter().map(|file| file.path.clone()));

        let mut samples = samples;
        let mut opened: Vec<Box<dyn RowSource + '_>> = Vec::with_capacity(plan.files.len());
        for entry in &plan.files {
            opened.push(match samples.take() {
                Some(input) => source::open_text(entry, input)?,
                None => source::open(entry)?,
            });
        }
        let bounds = opened
            .iter()
            .zip(&plan.files)
            .map(|(rows, entry)| Bound::new(rows.as_ref(), &entry.written, &plan.columns))
            .collect::<Result<Vec<_>, _>>()?;
        let names: Vec<&[String]> = opened.iter().map(|rows| rows.names()).collect();
        plan.all_found(&root, &names, &bounds)?;
        once(&opened, &bounds)?;
        let leads = leader(&bounds);
        let mut header = LogHeader::of(&bounds);
        let plain = plan.columns.is_empty();
        // A plain log has a time; what instruments write may go by its period, all files row by row.
        let timed = |bound: &Bound| bound.bindings.iter().any(|b| b.column == TIME_COLUMN);
        let own_clock = plan.files.iter().all(|entry| entry.clock.is_none());
        let by_rows = !plain && period.is_some() && own_clock && !bounds.iter().any(timed);
        if by_rows {
            header.count_rows();
        }
        if plain {
            for (rows, bound) in opened.iter().zip(&bounds) {
                header.refuse_near_misses(rows.as_ref(), kind, &bound.others)?;
            }
        }
        let columns = if plain { None } else { Some(root.table("columns")?) };
        let only = match (opened.as_slice(), bounds.as_slice()) {
            ([rows], [bound]) => Some((rows.as_ref(), bound)),
            _ => None,
        };
        header.require(kind, only, columns.as_ref().unwrap_or(&root))?;
        // Before the rows, of which there may be a gigabyte.
        let noise = root.optional_table("noise", |table| NoiseLevels::read(table, &header))?;
        let noise = noise.unwrap_or_default();
        let mut notices = header.notices(kind);
        let mut tracks = Vec::with_capacity(opened.len());
        let mut implausible = None;
        let mut sketches = Vec::with_capacity(opened.len());
        let mut row_counts = Vec::with_capacity(opened.len());
        let mut last: Option<Box<dyn RowSource + '_>> = None;
        for (k, mut rows) in opened.into_iter().enumerate() {
            let period = period.filter(|_| k == leads || by_rows);
            let entry = &plan.files[k];
            let expected = Expected { kind, robot: &robot, period };
            let clock = entry.clock.clone();
            let mut track =
                expected.read(rows.as_mut(), &bounds[k], clock, &mut implausible, &mut notices)?;
            row_counts.push(track.columns[TIME_COLUMN].as_ref().map_or(0, Vec::len));
            if let Some(other) = row_counts.iter().find(|count| by_rows && **count != row_counts[k])
            {
                let message = format!(
                    "holds {} rows, another file of the log {other}; expected as many in each: none has a time",
                    row_counts[k]
                );
                let help =
                    "Files without a time go row by row. Cut them alike, or map the time of each.";
                return Err(rows.error_of_file(message, help));
            }
            sketches.push(computed::sketch(&track));
            let slower = slow_channels::split_slow_channels(&mut track, kind, &mut notices);
            tracks.push(track);
            tracks.extend(slower);
            if k == leads {
                last = Some(rows);
            }
        }
        for (sketch, entry) in sketches.iter().zip(&plan.files) {
            if let Some(found) = computed::rigid(&sketches[leads], sketch, &robot) {
                return Err(found.refusal(&entry.path));
            }
        }
        let join = Join { kind, robot: &robot, period, plan: &plan, root: &root };
        let JoinedFiles { mut columns, gain, clocks, target, later } =
            join.run(tracks, &mut notices)?;
        let file_error = |message: String, help: &str| match &last {
            Some(rows) => rows.error_of_file(message, help),
            None => Source::new(&file, "").error_of_file(message, help),
        };
        columns
            .drop_empty(kind, &header, &mut notices)
            .map_err(|(message, help)| file_error(message, help))?;
        if let Some((message, help)) = plausible::refused(&columns, kind, &robot) {
            return Err(file_error(message, help));
        }
        let force = LogChannel::Force.columns();
        let has = |column: usize| columns.values[column].is_some();
        if let Some(sensor) = wrench.filter(|_| force.clone().any(has) && !force.clone().all(has)) {
            let turned = sensor.rotation != nalgebra::Matrix3::identity();
            if turned || LogChannel::Moment.columns().any(has) {
                let message =
                    "stands with a force of which a part was not measured; expected all of it";
                let help = "A sensor that is turned, or sits beside the tool, reads all components of a force in each.";
                return Err(root.table("wrench")?.error(message, help));
            }
        }
        // A thinned log has a longer period than is stated.
        let now = super::resample::median_step(&columns.time);
        let period = period.filter(|stated| now <= 1.5 * stated).unwrap_or(now);
        let all = gaps::pieces(&mut columns, kind, period, &header, &mut notices);
        let noise = noise.propagated(&gain);
        let noise = wrench.as_ref().map_or(noise, |sensor| noise.at_tool(sensor));
        screen::leave_out(&mut columns, kind, &noise, &mut notices);
        let least = if kind == LogKind::StaticLoad { 1 } else { 2 };
        let pieces: Vec<_> = all.into_iter().filter(|piece| piece.len() >= least).collect();
        if pieces.is_empty() {
            let message =
                "no row has a value of every encoder; expected them, they drive the model";
            return Err(file_error(message.to_owned(), "Were the encoders recorded?"));
        }
        let columns_of = plan.columns.clone();
        let whole = Self {
            path: folder.to_owned(),
            files: read,
            name: name_of(folder),
            kind,
            robot,
            weld,
            process,
            period: (kind != LogKind::StaticLoad).then_some(period),
            noise,
            accuracy: Accuracy::default(),
            samples: Samples::default(),
            notices,
            source: Source::new(&file, text),
            origin: LogOrigin {
                currents: currents(&columns_of),
                columns: columns_of,
                clocks,
                target,
                wrench,
                mounting,
                later,
            },
            implausible,
        };
        let count = pieces.len();
        let mut logs = vec![whole; count];
        for (number, (log, rows)) in logs.iter_mut().zip(pieces).enumerate() {
            let mut part = if count == 1 && rows.len() == columns.time.len() {
                std::mem::take(&mut columns)
            } else {
                columns.rows(rows)
            };
            log.samples.take(&mut part, kind);
            wrench.iter().for_each(|sensor| log.samples.at_tool(sensor));
            if let Some(mounting) = &mounting {
                log.samples.register(mounting, &log.robot.robot);
            }
            log.name = piece_name(&log.name, number, count);
            if number > 0 {
                // Once, not with every piece.
                log.notices.clear();
            }
        }
        Ok(logs)
    }

    /// Where the tool was along the weld by the encoders, m; `None` where nothing is welded.
    pub fn along_weld(&self) -> Option<Vec<f64>> {
        let seam = Seam::of(self.weld.as_ref()?);
        let tool = |q| self.robot.robot.forward_kinematics(q).position;
        Some(self.samples.encoder.iter().map(|q| seam.place(&tool(q)).position.x).collect())
    }

    /// Takes a tracker's frame that was found, and what it sees of the tool, out of its readings.
    pub fn register(&mut self, found: &Mounting, robot: &Robot<f64>) {
        self.samples.register(found, robot);
        let known = self.origin.mounting.unwrap_or(Mounting::none());
        self.origin.mounting = Some(known * *found);
    }

    /// Turns what a joint's drive recorded, whose factor was not stated, into torque: `factor` N·m are
    /// one unit of it. With `None` no factor could be found, and it is left out.
    pub fn scale_current(&mut self, joint: usize, factor: Option<f64>) {
        let Some(current) = &mut self.origin.currents[joint] else { return };
        current.factor = factor;
        let torque = &mut self.samples.motor_torque[joint];
        match factor {
            Some(factor) => torque.iter_mut().flatten().for_each(|torque| *torque *= factor),
            None => *torque = None,
        }
    }

    /// Fits the clocks of instruments that were not given once more: to the motion that a model
    /// predicts, which bends as the arm does. `poses`: of the tool, at the rows.
    pub fn refit_clocks(&mut self, poses: &[Pose<f64>]) {
        let Self { samples, origin, kind, robot, .. } = self;
        let later = Arc::clone(&origin.later);
        if later.is_empty() || poses.len() != samples.time.len() {
            return;
        }
        let refitted =
            join::refit(&samples.time, poses, origin.target, &mut origin.clocks, &later, *kind);
        if let Some(mut columns) = refitted {
            columns.time.clear();
            let force = LogChannel::Force.columns().start;
            let sensor = origin.wrench.filter(|_| columns.values[force].is_some());
            samples.take(&mut columns, *kind);
            sensor.iter().for_each(|sensor| samples.at_tool(sensor));
            if let Some(mounting) = &origin.mounting {
                samples.register(mounting, &robot.robot);
            }
        }
    }

    /// Checks that the log was recorded on this robot: same name, same joints, same geometry up to
    /// the tool centre point. Masses, elasticity and friction may differ. `whose` says in the error
    /// what the robot belongs to.
    ///
    /// # Errors
    /// A log of another robot, at the `robot` of its `log.toml`, with the first difference.
    pub fn must_be_of(&self, robot: &RobotFile, whose: &str) -> Result<(), InputError> {
        let Some(difference) = difference(&self.robot, robot) else {
            return Ok(());
        };
        let expected =
            format!("the robot of {whose}; this is a log of another robot: {difference}");
        let help = "Compare logs with a model of the robot that they were recorded on.";
        match TomlDocument::parse(self.source.text(), self.source.name()) {
            Ok(document) => Err(document.root().wrong("robot", &expected, help)),
            Err(error) => Err(error),
        }
    }
}

/// The longest of the pieces of a log, of which there is at least one.
pub fn longest(pieces: Vec<Log>) -> Log {
    let notices = pieces.iter().flat_map(|p| p.notices.clone()).collect();
    let longest = pieces.into_iter().max_by_key(|log| log.samples.len());
    let mut log = longest.expect("a log has a piece");
    log.notices = notices;
    log
}

/// Motor torques whose factor no entry states, by joint.
fn currents(columns: &[ColumnMapping]) -> [Option<MotorCurrent>; JOINTS] {
    let first = LogChannel::MotorTorque.columns().start;
    std::array::from_fn(|joint| {
        let own = columns.iter().find(|entry| entry.open && entry.column == first + joint)?;
        Some(MotorCurrent { unit: own.unit, factor: None })
    })
}

/// Name of a piece of a log; the log's own where it is whole.
pub(crate) fn piece_name(whole: &str, number: usize, count: usize) -> String {
    if count == 1 { whole.to_owned() } else { format!("{whole}, {} of {count}", number + 1) }
}

/// Which file has the encoders, or most of them.
fn leader(bounds: &[Bound]) -> usize {
    let encoders = |bound: &Bound| {
        let encoder = LogChannel::Encoder.columns();
        bound.bindings.iter().filter(|b| encoder.contains(&b.column)).count()
    };
    (0..bounds.len()).rev().max_by_key(|k| encoders(&bounds[*k])).unwrap_or(0)
}

/// No channel but the time may be read from two files.
fn once(opened: &[Box<dyn RowSource + '_>], bounds: &[Bound]) -> Result<(), InputError> {
    for (k, bound) in bounds.iter().enumerate() {
        for binding in &bound.bindings {
            let column = binding.column;
            let earlier = bounds[..k].iter().any(|b| b.bindings.iter().any(|b| b.column == column));
            if earlier && !LogChannel::Time.columns().contains(&column) {
                let message = format!(
                    "column {} is `{}`, which another file has; expected each channel once",
                    opened[k].shown(binding.field),
                    channel_name(column)
                );
                let help = "Leave out one of the two. Where both files have a header of this name, \
                            write \"FILE:HEADER\" in [columns].";
                return Err(opened[k].error_at(Some(binding.field), message, "again", help));
            }
        }
    }
    Ok(())
}

/// Where a tracker stands, and what it sees of the tool; what is left out is nothing.
fn mounting(table: &TomlTable<'_>) -> Result<Mounting, InputError> {
    table.only(&["base_m", "base_rad", "point_m", "axes_rad"])?;
    Ok(Mounting {
        frame: pose(table, ["base_m", "base_rad"], 100.0)?,
        tool: pose(table, ["point_m", "axes_rad"], 5.0)?,
    })
}

/// How a force sensor sits in T; what is left out is nothing.
fn sensor(table: &TomlTable<'_>) -> Result<Pose<f64>, InputError> {
    table.only(&["point_m", "axes_rad"])?;
    pose(table, ["point_m", "axes_rad"], 5.0)
}

/// A position, m, at most `far` along each axis, and a rotation vector, rad, by their keys.
fn pose(
    table: &TomlTable<'_>,
    [position, rotation]: [&str; 2],
    far: f64,
) -> Result<Pose<f64>, InputError> {
    let (position, turn) = (vector(table, position, far)?, vector(table, rotation, 7.0)?);
    Ok(Pose { rotation: rotation_from_vector(&turn), position })
}

/// The three numbers under a key, of at most this magnitude; zeros without the key.
fn vector(table: &TomlTable<'_>, key: &str, most: f64) -> Result<Vector3<f64>, InputError> {
    if !table.has(key) {
        return Ok(Vector3::zeros());
    }
    let read = table.list(key, 3, Bounds::Between(-most, most))?;
    <[f64; 3]>::try_from(read)
        .map(Vector3::from)
        .map_err(|_| table.wrong(key, "a list of 3 numbers", "x, y and z."))
}

fn kind(root: &TomlTable<'_>) -> Result<LogKind, InputError> {
    let text = root.text("kind")?.text;
    LogKind::ALL.into_iter().find(|kind| kind.name() == text).ok_or_else(|| {
        let names = LogKind::ALL.map(LogKind::name);
        let help = match nearest(text, names) {
            Some(near) => format!("Did you mean \"{near}\"?"),
            None => "It says what was done while the log was recorded.".to_owned(),
        };
        root.wrong(
            "kind",
            &format!("one of {}", names.map(|name| format!("\"{name}\"")).join(", ")),
            help,
        )
    })
}

/// The last part of a folder's path, however the path is written.
pub(crate) fn name_of(folder: &Path) -> String {
    let last = |path: &Path| path.file_name().map(|name| name.to_string_lossy().into_owned());
    last(folder)
        .or_else(|| last(&folder.canonicalize().ok()?))
        .unwrap_or_else(|| folder.display().to_string())
}

/// The first thing in which two robots differ that no calibration changes.
fn difference(read: &RobotFile, expected: &RobotFile) -> Option<String> {
    // Positions to a micrometre, directions to a microradian: below what a file of the same robot
    // may be rounded to.
    let apart = |a: &Vector3<f64>, b: &Vector3<f64>| (a - b).norm() > 1e-6;
    if read.name != expected.name {
        return Some(format!("{:?} instead of {:?}", read.name, expected.name));
    }
    for (a, b) in read.joint_names.iter().zip(&expected.joint_names) {
        if a != b {
            return Some(format!("joint {a:?} instead of {b:?}"));
        }
    }
    let joints = read.parameters.joints.iter().zip(&expected.parameters.joints);
    for ((a, b), name) in joints.zip(&read.joint_names) {
        if apart(&a.origin, &b.origin) || apart(&a.axis, &b.axis) {
            return Some(format!("{name} has another origin or axis"));
        }
    }
    let (a, b) = (&read.parameters.tool, &expected.parameters.tool);
    let tool =
        apart(&(a.flange_offset + a.tcp_from_flange), &(b.flange_offset + b.tcp_from_flange))
            || apart(&a.z_axis, &b.z_axis)
            || apart(&a.y_axis, &b.y_axis);
    tool.then(|| "the tool centre point or the tool's axes lie elsewhere".to_owned())
}
