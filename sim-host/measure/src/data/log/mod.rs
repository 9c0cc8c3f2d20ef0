//! A recorded log: a folder with `log.toml`, which says what was done, and `samples.csv`, what was
//! measured.
//!
//! A log that was read is complete and plausible: every required column is there, every number
//! parsed, the time rises, and no channel is in another unit than its name says. Rows are read as a
//! stream; what is held is the columns. Left out: resampling, filtering, and filling in of missing
//! values, which are up to the prediction.

mod columns;
mod lines;
mod samples;

pub use samples::{Payload, Samples};

use super::channel::{CHANNELS, LogChannel};
pub use super::kind::LogKind;
use columns::Header;
use lines::Lines;
use nalgebra::Vector3;
use samples::Expected;
use std::io::Read;
use std::path::{Path, PathBuf};
use trueweld_core::JOINTS;
use trueweld_plant::input::document::nearest;
use trueweld_plant::input::{
    Bounds, Document, FileKind, InputError, InputFile, Process, RobotFile, Source, Table, Weld,
    open, read_text,
};

/// Name of the file that says what a log is.
pub const LOG_FILE: &str = "log.toml";

/// Name of the file with the rows.
pub const SAMPLES_FILE: &str = "samples.csv";

/// Most bytes of the rows: the columns are held in memory, where they take about as much.
const MOST_SAMPLES: u64 = 4 << 30;

/// Noise as the instruments' makers state it: one standard deviation a column. `None`: not stated.
///
/// Of joints' channels of which only some joints have a column, an entry that was given for those
/// columns alone is NaN for the other joints.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Noise {
    /// Tracker position, m.
    pub position: Option<[f64; 3]>,
    /// Tracker rotation, rad.
    pub rotation: Option<[f64; 3]>,
    /// Encoders, rad.
    pub encoder: Option<[f64; JOINTS]>,
    /// Measured force, N.
    pub force: Option<[f64; 3]>,
    /// Measured moment, N·m.
    pub moment: Option<[f64; 3]>,
    /// Motor torque, N·m.
    pub motor_torque: Option<[f64; JOINTS]>,
    /// Encoders on the link side, rad.
    pub link_encoder: Option<[f64; JOINTS]>,
}

impl Noise {
    fn read(table: &Table<'_>, header: &Header) -> Result<Self, InputError> {
        let keys: Vec<&str> = CHANNELS.iter().map(|c| c.noise).filter(|k| !k.is_empty()).collect();
        table.only(&keys)?;
        Ok(Self {
            position: deviation(table, header, LogChannel::Position)?,
            rotation: deviation(table, header, LogChannel::Rotation)?,
            encoder: deviation(table, header, LogChannel::Encoder)?,
            force: deviation(table, header, LogChannel::Force)?,
            moment: deviation(table, header, LogChannel::Moment)?,
            motor_torque: deviation(table, header, LogChannel::MotorTorque)?,
            link_encoder: deviation(table, header, LogChannel::LinkEncoder)?,
        })
    }
}

/// One standard deviation for all columns, or one a column that the log has.
fn deviation<const N: usize>(
    table: &Table<'_>,
    header: &Header,
    channel: LogChannel,
) -> Result<Option<[f64; N]>, InputError> {
    let there: [bool; N] = header.which(channel);
    let (key, most) = (channel.entry().noise, channel.entry().most_noise);
    // A larger one is in another unit; a smaller one is a slip: squares of residuals over it
    // overflow.
    let bounds = Bounds::Between(most / 1e9, most);
    if !table.has(key) {
        return Ok(None);
    }
    if !table.is_list(key) {
        return Ok(Some([table.number(key, bounds)?; N]));
    }
    let list = table.list(key, N, bounds)?;
    if let Ok(all) = <[f64; N]>::try_from(list.as_slice()) {
        return Ok(Some(all));
    }
    let columns = there.iter().filter(|there| **there).count();
    if list.is_empty() || list.len() != columns {
        let or = if (1..N).contains(&columns) {
            format!(", or {columns}, as many as this log has")
        } else {
            String::new()
        };
        let expected = format!("one number, or a list of {N}, one a column{or}");
        return Err(table.wrong(key, &expected, "Leave the key out where the noise is not known."));
    }
    let mut stated = list.into_iter();
    Ok(Some(there.map(|there| if there { stated.next().unwrap_or(f64::NAN) } else { f64::NAN })))
}

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
    /// Sampling period where sampling is even, s. Each step of the time, and their mean, keep it
    /// within 1 % and what rounding of the written times makes.
    pub period: Option<f64>,
    /// Noise as stated.
    pub noise: Noise,
    /// The rows.
    pub samples: Samples,
    /// What a person should know although nothing is wrong: columns that were left out.
    pub notices: Vec<String>,
    /// Text of `log.toml`, for errors that point into it.
    pub source: Source,
}

impl Log {
    /// Reads the log in a folder, with the robot, weld and process that it names.
    ///
    /// # Errors
    /// The first thing that does not fit, with file, line and column.
    pub fn read(folder: impl AsRef<Path>) -> Result<Self, InputError> {
        let folder = folder.as_ref();
        let (_, text) = read_text(&folder.join(LOG_FILE))?;
        let rows = open(&folder.join(SAMPLES_FILE), MOST_SAMPLES)?;
        Self::parse(&text, rows, folder)
    }

    /// Reads a log from the text of its `log.toml` and its rows; `folder` is where its paths start
    /// and what errors name.
    ///
    /// # Errors
    /// As [`Log::read`].
    pub fn parse(text: &str, samples: impl Read, folder: &Path) -> Result<Self, InputError> {
        let file = folder.join(LOG_FILE).display().to_string();
        let document = Document::parse(text, &file)?;
        let root = document.root_of(FileKind::Log.schema())?;
        root.only(&["schema", "kind", "robot", "weld", "process", "period_s", "noise"])?;
        let kind = kind(&root)?;
        let mut files = vec![folder.join(LOG_FILE), folder.join(SAMPLES_FILE)];
        let mut named = |key| {
            let file = root.file(key, folder)?;
            files.push(file.clone());
            Ok::<PathBuf, InputError>(file)
        };
        let robot = RobotFile::read(named("robot")?)?;
        let wanted = |key: &str| kind == LogKind::Weld || root.has(key);
        let weld = if wanted("weld") { Some(Weld::read(named("weld")?)?) } else { None };
        let process =
            if wanted("process") { Some(Process::read(named("process")?)?) } else { None };
        let period =
            root.has("period_s").then(|| root.number("period_s", Bounds::Positive)).transpose()?;

        let mut lines = Lines::new(folder.join(SAMPLES_FILE).display().to_string(), samples);
        let header = Header::read(&mut lines, kind)?;
        // Before the rows, of which there may be a gigabyte.
        let noise = if root.has("noise") {
            Noise::read(&root.table("noise")?, &header)?
        } else {
            Noise::default()
        };
        let mut notices = header.notices(kind);
        let samples =
            Expected { kind, robot: &robot, period }.read(&mut lines, &header, &mut notices)?;
        Ok(Self {
            path: folder.to_owned(),
            files,
            name: name_of(folder),
            kind,
            robot,
            weld,
            process,
            period,
            noise,
            samples,
            notices,
            source: Source::new(&file, text),
        })
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
        match Document::parse(self.source.text(), self.source.name()) {
            Ok(document) => Err(document.root().wrong("robot", &expected, help)),
            Err(error) => Err(error),
        }
    }
}

fn kind(root: &Table<'_>) -> Result<LogKind, InputError> {
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
