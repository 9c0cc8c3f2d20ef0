//! What the columns of files of unknown make probably are: channels by their headers, units by
//! header or magnitude, signs by the robot's limits and motion, clocks by correlation.
//!
//! A proposal says of every part what it rests on, and what is only a guess. Left out: zeros of
//! axes, frames and payloads, which a comparison finds once the log can be read.

mod header;
mod magnitude;
mod names;
mod preview;
mod proposal;
mod raw;
mod signs;

pub use proposal::{
    Doubt, LeftOut, Preview, Proposal, ProposalBasis, ProposedColumn, ProposedFile,
};

use super::bursts::even_times;
use super::columns::channel_name;
use super::computed;
use super::files::FileEntry;
use super::source;
use super::text::Dialect;
use crate::channel::{LOG_CHANNELS, LogChannel};
use crate::kind::LogKind;
use crate::log::columns::TIME_COLUMN;
use crate::resample::median_step;
use header::NamedColumns;
use raw::{ENCODER_COLUMN, Raw, TORQUE, file_of, series, times};
use std::path::{Path, PathBuf};
use trueweld_core::JOINTS;
use trueweld_plant::input::{InputError, RobotFile};

/// What is known of files beside what stands in them.
#[derive(Debug, Clone, Copy, Default)]
pub struct Stated {
    /// What was done.
    pub kind: Option<LogKind>,
    /// Period of the rows of the encoders' file, s, where they have no time.
    pub period: Option<f64>,
}

/// Looks at files and proposes how they are read as one log.
///
/// # Errors
/// A file that cannot be read at all.
pub fn propose(
    paths: &[PathBuf],
    robot: Option<&RobotFile>,
    stated: Stated,
) -> Result<Proposal, InputError> {
    let Stated { kind, period } = stated;
    let mut raws = Vec::new();
    for path in paths {
        let entry = FileEntry {
            written: path.display().to_string(),
            path: path.clone(),
            clock: None,
            dialect: Dialect::PLAIN,
            topic: None,
        };
        match source::topics(&entry)? {
            // Of a file with one table nothing is to be named.
            Some(topics) if !topics.is_empty() => {
                for topic in topics {
                    raws.push(raw::read(FileEntry { topic: Some(topic), ..entry.clone() })?);
                }
            }
            _ => raws.push(raw::read(entry)?),
        }
    }
    let joints = robot.map_or(&[][..], |robot| &robot.joint_names);
    let mut named: Vec<NamedColumns> =
        raws.iter().map(|raw| NamedColumns::of(raw, joints)).collect();
    if let Some(period) = period {
        let mut files = raws.iter_mut().zip(&named);
        let own = files.find(|(_, columns)| columns.has(ENCODER_COLUMN));
        own.into_iter().for_each(|(raw, _)| raw.period = Some(period));
    }
    if let Some(robot) = robot {
        leave_out_rigid(&mut named, &raws, robot, kind);
    }
    header::settle(&mut named, &raws);
    let Draft { mut columns, mut files, kind, kind_sure } = Draft::new(&named, &raws, robot, kind);
    if let Some(robot) = robot {
        signs::motion(&mut columns, &mut files, &raws, robot, kind);
        signs::torque_signs(&mut columns, &raws, robot);
    }
    preview::fill(&mut columns, &files, &raws, robot);
    let own = file_of(&columns, ENCODER_COLUMN);
    let period_open = own.is_some_and(|own| files[own].period.is_none());
    let has_time =
        own.is_some_and(|own| columns.iter().any(|c| c.file == own && c.is(TIME_COLUMN)));
    let period = period.filter(|_| own.is_some() && !has_time);
    let needed = LOG_CHANNELS.iter().filter(|c| c.needed.contains(&kind));
    let missing = needed
        .flat_map(|channel| channel.id.columns())
        .filter(|column| {
            let counted = period_open || period.is_some();
            file_of(&columns, *column).is_none() && !(counted && *column == TIME_COLUMN)
        })
        .map(channel_name)
        .collect();
    Ok(Proposal { files, columns, kind, kind_sure, period_open, period, missing })
}

/// Columns and files before signs are told by motion.
struct Draft {
    columns: Vec<ProposedColumn>,
    files: Vec<ProposedFile>,
    kind: LogKind,
    kind_sure: bool,
}

impl Draft {
    fn new(
        named: &[NamedColumns],
        raws: &[Raw],
        robot: Option<&RobotFile>,
        kind: Option<LogKind>,
    ) -> Self {
        let mut columns: Vec<ProposedColumn> = Vec::new();
        for (file, (named, raw)) in named.iter().zip(raws).enumerate() {
            columns.extend(named.proposed(file, raw));
        }
        magnitude::units_by_magnitude(&mut columns, raws);
        signs::signs_by_limits(&mut columns, robot);
        let mut files: Vec<ProposedFile> = raws.iter().map(raw::proposed_file).collect();
        for (file, proposed) in files.iter_mut().enumerate() {
            let time = times(&columns, raws, file);
            let time = time.map(|stamps| even_times(&stamps).map_or(stamps, |found| found.times));
            proposed.period = time.as_deref().map(median_step).filter(|step| *step > 0.0);
        }
        name_clocks(&mut files, &columns, raws);
        let (guess, sure) = kind_of(&columns, &files);
        Self { columns, files, kind: kind.unwrap_or(guess), kind_sure: kind.is_some() || sure }
    }

    /// The draft in which no position is the tracker's but the `kept` one: its file and its family.
    fn with_position(
        named: &[NamedColumns],
        raws: &[Raw],
        robot: &RobotFile,
        kind: Option<LogKind>,
        kept: Option<(usize, &str)>,
    ) -> Self {
        let mut tried = named.to_vec();
        for (file, columns) in tried.iter_mut().enumerate() {
            let family = kept.filter(|(of, _)| *of == file).map(|(_, family)| family);
            columns.keep_position(family);
        }
        header::settle(&mut tried, raws);
        Self::new(&tried, raws, Some(robot), kind)
    }
}

/// Leaves out poses at the times of the encoders that agree with them and a rigid robot: each is tried as if
/// it were the tracker's.
fn leave_out_rigid(
    named: &mut [NamedColumns],
    raws: &[Raw],
    robot: &RobotFile,
    kind: Option<LogKind>,
) {
    let without = Draft::with_position(named, raws, robot, kind, None);
    let Some(own) = file_of(&without.columns, ENCODER_COLUMN) else { return };
    let time = |file: usize| series(&without.columns, raws, Some(file), TIME_COLUMN);
    let mut found = Vec::new();
    for file in (0..named.len()).filter(|file| *file == own || time(*file) == time(own)) {
        for family in named[file].positions() {
            let kept = Some((file, family.as_str()));
            let Draft { mut columns, mut files, kind, .. } =
                Draft::with_position(named, raws, robot, kind, kept);
            signs::motion(&mut columns, &mut files, raws, robot, kind);
            let [own, seen] = [own, file].map(|file| raw::track(&columns, raws, file));
            found.extend(computed::rigid(&own, &seen, robot).map(|rigid| (file, family, rigid)));
        }
    }
    for (file, family, rigid) in found {
        named[file].leave_out_pose(&family, &LeftOut::Rigid(rigid));
    }
}

/// A file whose times are others than those of the encoders has a clock of its own.
fn name_clocks(files: &mut [ProposedFile], columns: &[ProposedColumn], raws: &[Raw]) {
    let Some(own) = file_of(columns, ENCODER_COLUMN) else { return };
    let Some(time) = times(columns, raws, own) else { return };
    let mut taken: Vec<String> = Vec::new();
    for (file, proposed) in files.iter_mut().enumerate().filter(|(file, _)| *file != own) {
        let other = series(columns, raws, Some(file), TIME_COLUMN);
        let same = other.is_some_and(|other| {
            let ends = |v: &[f64]| Some((*v.first()?, *v.last()?));
            let period = median_step(&time);
            matches!((ends(&time), ends(&other)), (Some(a), Some(b))
                if (a.0 - b.0).abs() < period && (a.1 - b.1).abs() < period)
        });
        let ros = proposed.topic.is_some();
        if !same && !ros {
            let bare = clock_name(&proposed.path);
            let more = (2..).map(|k| format!("{bare}-{k}"));
            let mut names = std::iter::once(bare.clone()).chain(more);
            proposed.clock = names.find(|name| !taken.contains(name));
            taken.extend(proposed.clock.clone());
        }
    }
}

fn clock_name(path: &Path) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().to_lowercase());
    let stem = stem.unwrap_or_default();
    let bare: String =
        stem.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
    if bare.is_empty() { "instrument".to_owned() } else { bare }
}

/// What was done, by the channels and how fast they were sampled.
fn kind_of(columns: &[ProposedColumn], files: &[ProposedFile]) -> (LogKind, bool) {
    let has = |column: usize| file_of(columns, column).is_some();
    let own = file_of(columns, ENCODER_COLUMN).unwrap_or(0);
    let period = files.get(own).and_then(|file| file.period).unwrap_or(0.0);
    if has(LogChannel::Spindle.columns().start) {
        (LogKind::Weld, true)
    } else if has(LogChannel::Payload.columns().start) || period > 0.5 {
        (LogKind::StaticLoad, true)
    } else if (0..JOINTS).any(|i| has(TORQUE + i)) {
        (LogKind::FreeMotion, !has(LogChannel::Force.columns().start))
    } else if period < 2e-3 && period > 0.0 {
        (LogKind::RingDown, false)
    } else {
        (LogKind::FreeMotion, false)
    }
}
