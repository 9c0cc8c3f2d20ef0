//! What the columns of files of unknown make probably are: channels by their headers, units by
//! header or magnitude, signs by the robot's limits and motion, clocks by correlation.
//!
//! A proposal says of every part what it rests on, and what is only a guess. Left out: zeros of
//! axes, frames and payloads, which a comparison finds once the log can be read.

use super::columns::{ALL, ColumnMapping, channel_name, channel_named, dimension, reflector};
use super::files::FileEntry;
use super::pose::to_rotation_vectors;
use super::rows::Rows;
use super::source;
use super::text::{Dialect, SEPARATORS};
use super::track::Track;
use super::units::{Dimension, unit_named};
use crate::data::channel::LogChannel;
use crate::data::clock::{ClockMap, FittedClock, Points, correlate, fit, rigid};
use crate::data::fir::LowPass;
use crate::data::kind::LogKind;
use crate::data::resample::median_step;
use nalgebra::{Matrix3, Vector3};
use std::io::Read;
use std::path::{Path, PathBuf};
use trueweld_core::spatial::{rotation_from_vector, rotation_vector};
use trueweld_core::{JOINTS, JointVector, Wrench};
use trueweld_plant::input::{InputError, RobotFile, open};

/// Rows that a proposal looks at.
const LOOKED_AT: usize = 200_000;

/// Bytes at a file's start from which its form is told.
const SNIFFED: u64 = 1 << 16;

/// A radian that the tool turned otherwise counts as so many metres.
const LEVER: f64 = 0.5;

/// Rows that signs are told by.
const TRIED: usize = 1500;

/// What a proposed part rests on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ground {
    /// The header names the channel.
    Header,
    /// The header states the unit.
    UnitInHeader,
    /// The values are of this size in one unit alone.
    Magnitude,
    /// With the other sign the axis leaves its limits.
    Limits,
    /// The tracker saw the motion that these signs make: what is left, m, and what the best of the
    /// others leaves.
    Motion {
        /// With these signs.
        left: f64,
        /// With the best others.
        others: f64,
    },
    /// The model's torque goes up and down with it: the correlation.
    ModelTorque(f64),
}

/// What is only a guess in a proposed part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Doubt {
    /// The values fit several units; this is the usual one.
    Unit,
    /// Nothing tells the sign.
    Sign,
    /// A current or a share becomes a torque by a factor that no file holds.
    Factor,
}

/// Why a column is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LeftOut {
    /// Its header says nothing that is known.
    Unknown,
    /// It was commanded, not measured.
    Commanded,
    /// Another column is the same channel.
    Twice,
    /// It does not hold numbers.
    NoNumbers,
}

/// A column of a file, with what it probably is.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedColumn {
    /// Index of the file.
    pub file: usize,
    /// Its header.
    pub header: String,
    /// Least and largest value.
    pub range: Option<[f64; 2]>,
    /// How it is mapped.
    pub mapping: Result<ColumnMapping, LeftOut>,
    /// What that rests on.
    pub grounds: Vec<Ground>,
    /// What of it is a guess.
    pub doubts: Vec<Doubt>,
}

/// A file, with how it is written.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedFile {
    /// Where it is.
    pub path: PathBuf,
    /// Which messages, of a file that holds several kinds.
    pub topic: Option<String>,
    /// True of text; the next four are of text alone.
    pub text: bool,
    /// Between the fields.
    pub delimiter: char,
    /// Decimal mark.
    pub decimal: char,
    /// Line of the header; 0 without one.
    pub header: usize,
    /// First line with values.
    pub first_row: usize,
    /// Rows that were looked at.
    pub rows: usize,
    /// Period of its rows, s.
    pub period: Option<f64>,
    /// Name of its clock; `None` for the log's own.
    pub clock: Option<String>,
    /// What its clock was fitted to be.
    pub fitted: Option<FittedClock>,
}

/// A log as files of unknown make probably are.
#[derive(Debug, Clone, PartialEq)]
pub struct Proposal {
    /// The files; the one with the encoders first.
    pub files: Vec<ProposedFile>,
    /// Their columns.
    pub columns: Vec<ProposedColumn>,
    /// What was done.
    pub kind: LogKind,
    /// True where the kind was given, or only one fits.
    pub kind_sure: bool,
    /// Channels that every log of this kind needs and no column is.
    pub missing: Vec<&'static str>,
}

/// A file's numbers.
struct Raw {
    entry: FileEntry,
    text: bool,
    names: Vec<String>,
    /// NaN where it is no number; `None` for a column without any.
    values: Vec<Option<Vec<f64>>>,
    rows: usize,
}

/// Looks at files and proposes how they are read as one log.
///
/// # Errors
/// A file that cannot be read at all.
pub fn propose(
    paths: &[PathBuf],
    robot: Option<&RobotFile>,
    kind: Option<LogKind>,
) -> Result<Proposal, InputError> {
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
            Some(topics) => {
                for topic in topics {
                    raws.push(read(FileEntry { topic: Some(topic), ..entry.clone() })?);
                }
            }
            None => raws.push(read(entry)?),
        }
    }
    let mut columns: Vec<ProposedColumn> = Vec::new();
    for (file, raw) in raws.iter().enumerate() {
        columns.extend(of_file(file, raw));
    }
    only_once(&mut columns);
    units_by_magnitude(&mut columns, &raws);
    signs_by_limits(&mut columns, robot);
    let mut files: Vec<ProposedFile> = raws.iter().map(proposed_file).collect();
    for (file, proposed) in files.iter_mut().enumerate() {
        let time = series(&columns, &raws, Some(file), TIME);
        proposed.period = time.as_deref().map(median_step).filter(|step| *step > 0.0);
    }
    name_clocks(&mut files, &columns, &raws);
    let (guess, sure) = kind_of(&columns, &files);
    let kind_given = kind.is_some();
    let kind = kind.unwrap_or(guess);
    if let Some(robot) = robot {
        motion(&mut columns, &mut files, &raws, robot, kind);
        torque_signs(&mut columns, &raws, robot);
    }
    let has = |column: usize| {
        columns.iter().any(|c| c.mapping.as_ref().is_ok_and(|m| m.column == column))
    };
    let needed = crate::data::channel::CHANNELS.iter().filter(|c| c.needed.contains(&kind));
    let missing = needed
        .flat_map(|channel| channel.id.columns())
        .filter(|column| !has(*column))
        .map(channel_name)
        .collect();
    Ok(Proposal { files, columns, kind, kind_sure: kind_given || sure, missing })
}

const TIME: usize = LogChannel::Time.columns().start;
const ENCODER: usize = LogChannel::Encoder.columns().start;
const TORQUE: usize = LogChannel::MotorTorque.columns().start;
const POSITION: usize = LogChannel::Position.columns().start;

/// Reads a file's first rows, having found out how it is written.
fn read(mut entry: FileEntry) -> Result<Raw, InputError> {
    let mut start = Vec::new();
    let sniffed = open(&entry.path, super::rows::MOST_ROWS)?.take(SNIFFED).read_to_end(&mut start);
    let text = sniffed.is_ok() && looks_like_text(&start);
    if text {
        entry.dialect = sniff(&start);
    }
    let mut rows: Box<dyn Rows> = source::open(&entry)?;
    let names: Vec<String> = rows.names().to_vec();
    let mut values: Vec<Option<Vec<f64>>> = vec![Some(Vec::new()); names.len()];
    let mut count = 0;
    while count < LOOKED_AT && rows.advance()? {
        for (column, values) in values.iter_mut().enumerate() {
            if let Some(values) = values {
                values.push(rows.value(column).unwrap_or(f64::NAN));
            }
        }
        count += 1;
    }
    for values in &mut values {
        if values.as_ref().is_some_and(|v| v.iter().all(|x| x.is_nan())) {
            *values = None;
        }
    }
    Ok(Raw { entry, text, names, values, rows: count })
}

fn looks_like_text(start: &[u8]) -> bool {
    let binary = start.iter().filter(|b| **b < 9 || (14..32).contains(*b)).count();
    binary == 0 && !start.starts_with(super::kuka::MAGIC)
}

/// How a text file is written, by its first lines.
fn sniff(start: &[u8]) -> Dialect {
    let text: String = start.iter().map(|byte| char::from(*byte)).collect();
    let mut lines: Vec<&str> = text.lines().collect();
    // The last one may be cut.
    if lines.len() > 2 {
        lines.pop();
    }
    let split = |line: &str, delimiter: u8| -> Vec<String> {
        let fields: Box<dyn Iterator<Item = &str>> = match delimiter {
            b' ' => Box::new(line.split_whitespace()),
            // Many programs end every line with a separator.
            _ => {
                let line = line.strip_suffix(char::from(delimiter)).unwrap_or(line);
                Box::new(line.split(char::from(delimiter)))
            }
        };
        fields.map(|f| f.trim().trim_matches('"').to_owned()).collect()
    };
    let is_number = |field: &str, decimal: u8| {
        let dotted = if decimal == b',' { field.replace(',', ".") } else { field.to_owned() };
        field.is_empty() || dotted.parse::<f64>().is_ok()
    };
    let mut best = (0, Dialect::PLAIN);
    for (delimiter, _) in SEPARATORS {
        for decimal in [b'.', b','] {
            if decimal == delimiter {
                continue;
            }
            let Some(last) = lines.iter().rev().find(|line| !line.trim().is_empty()) else {
                continue;
            };
            let width = split(last, delimiter).len();
            let numeric = |line: &&str| {
                let fields = split(line, delimiter);
                let numbers = fields.iter().filter(|f| is_number(f, decimal)).count();
                fields.len() == width
                    && fields.iter().any(|f| !f.is_empty())
                    && 2 * numbers > fields.len()
                    && is_number(&fields[0], decimal)
            };
            let rows = lines.iter().copied().filter(numeric).count();
            let numbers: usize = lines
                .iter()
                .copied()
                .filter(numeric)
                .map(|line| {
                    split(line, delimiter)
                        .iter()
                        .filter(|f| !f.is_empty() && is_number(f, decimal))
                        .count()
                })
                .sum();
            // A comma between digits is either; numbers that a dot would make two count as one.
            let score = 2 * numbers + usize::from(decimal == b'.');
            if rows > 0 && width > 1 && score > best.0 {
                let first = lines.iter().position(numeric).unwrap_or(0);
                let header = lines[..first].iter().position(|line| {
                    split(line, delimiter).len() >= width && !line.trim().is_empty()
                });
                // Of several lines of this width the names come first, units below them.
                let header = header.map_or(0, |line| line + 1);
                best = (score, Dialect { delimiter, decimal, header, rows: first + 1 });
            }
        }
    }
    best.1
}

/// Words of a header, in small letters: parted at blanks, marks, capitals and digits; and the unit
/// that stands in it.
fn words(header: &str) -> (Vec<String>, Option<&'static str>) {
    let mut unit = None;
    let mut rest = header.to_owned();
    for (open, close) in [('[', ']'), ('(', ')'), ('<', '>')] {
        if let (Some(a), Some(b)) = (rest.find(open), rest.rfind(close))
            && a < b
            && let Some(found) = unit_named(&rest[a + open.len_utf8()..b])
        {
            unit = Some(found.name);
            rest.replace_range(a..b + close.len_utf8(), " ");
        }
    }
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for c in rest.chars() {
        let starts = !last.is_alphanumeric()
            || (c.is_uppercase() && last.is_lowercase())
            || (c.is_ascii_digit() != last.is_ascii_digit());
        if c.is_alphanumeric() {
            match words.last_mut() {
                Some(word) if !starts => word.extend(c.to_lowercase()),
                _ => words.push(c.to_lowercase().collect()),
            }
        }
        last = c;
    }
    // A last word that is a unit: `px_mm`, `force N`.
    if unit.is_none()
        && words.len() > 1
        && let Some(found) = words.last().and_then(|word| unit_named(word))
        && !["a", "t", "c", "b", "h", "in", "1", "x", "y", "z", "g", "v", "m"]
            .contains(&words[words.len() - 1].as_str())
    {
        unit = Some(found.name);
        words.pop();
    }
    (words, unit)
}

/// What a header says.
enum Said {
    /// A channel's column, and what the word says besides: a current.
    Channel(usize, bool),
    LeftOut(LeftOut),
}

/// The channel that a header names, in the habits of several makers. `zero_based`: axes of this
/// file are counted from 0.
fn channel_of(words: &[String], zero_based: bool) -> Said {
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    let number = words.iter().rev().find_map(|word| word.parse::<usize>().ok());
    let axis = number.and_then(|n| if zero_based { Some(n) } else { n.checked_sub(1) });
    let axis = axis.filter(|axis| *axis < JOINTS);
    let joined = words.concat();
    // The channels' own names.
    if let Some(column) = channel_named(&joined) {
        return Said::Channel(column, false);
    }
    if has(&[
        "cmd",
        "command",
        "commanded",
        "soll",
        "target",
        "set",
        "setpoint",
        "desired",
        "des",
        "nominal",
        "ref",
        "ipo",
        "nom",
    ]) && !has(&["reflector"])
    {
        return Said::LeftOut(LeftOut::Commanded);
    }
    if has(&[
        "vel",
        "velocity",
        "acc",
        "acceleration",
        "temp",
        "temperature",
        "jerk",
        "qd",
        "qdd",
        "geschwindigkeit",
        "error",
        "status",
        "quality",
    ]) {
        return Said::LeftOut(LeftOut::Unknown);
    }
    if has(&["spindle", "spindel", "rpm"]) || joined.contains("drehzahl") {
        return Said::Channel(LogChannel::Spindle.columns().start, false);
    }
    let component = ["x", "y", "z"].iter().position(|c| has(&[c]));
    let fused = |prefixes: &[&str]| {
        let at = |prefix: &&str| {
            words.iter().any(|w| w.len() == prefix.len() + 1 && w.starts_with(*prefix))
        };
        prefixes.iter().find(|p| at(p)).and_then(|prefix| {
            ["x", "y", "z"].iter().position(|c| words.iter().any(|w| *w == format!("{prefix}{c}")))
        })
    };
    if let Some(c) = fused(&["f"]).or(component.filter(|_| has(&["force", "kraft"]))) {
        return Said::Channel(LogChannel::Force.columns().start + c, false);
    }
    let moment = ["torque", "moment", "drehmoment"];
    if let Some(c) = fused(&["m", "t"]).or(component.filter(|_| axis.is_none() && has(&moment))) {
        return Said::Channel(LogChannel::Moment.columns().start + c, false);
    }
    let current = ["current", "cur", "strom", "i"];
    let torque = ["torque", "trq", "tau", "effort", "drehmoment", "moment", "tm"];
    if let Some(axis) = axis {
        let amperes = has(&current) || joined.contains("macur") || joined.contains("strom");
        if amperes || has(&torque) || joined.contains("trq") || joined.contains("torque") {
            return Said::Channel(TORQUE + axis, amperes);
        }
        if has(&["ql", "external", "second", "secondary", "link", "load", "abtrieb", "output"]) {
            return Said::Channel(LogChannel::LinkEncoder.columns().start + axis, false);
        }
        let marker = ["r", "refl", "reflector", "smr", "marker", "t", "prism", "point", "p"];
        if let Some(c) = component.filter(|_| axis < 3 && has(&marker)) {
            return Said::Channel(reflector(axis).start + c, false);
        }
        let angle = [
            "a", "axis", "axes", "achse", "joint", "j", "q", "qe", "pos", "position", "angle",
            "winkel", "encoder", "enc",
        ];
        if component.is_none()
            && (has(&angle) || joined.contains("aipos") || joined.contains("axis"))
        {
            return Said::Channel(ENCODER + axis, false);
        }
    }
    let quaternion = ["orientation", "quat", "quaternion", "q"];
    let (w, c) = (has(&["w", "qw"]), fused(&["q"]).or(component));
    if has(&quaternion) || fused(&["q"]).is_some() || has(&["qw"]) {
        let first = super::columns::QUATERNION.start;
        if w {
            return Said::Channel(first, false);
        }
        if let Some(c) = c {
            return Said::Channel(first + 1 + c, false);
        }
        if let Some(n) = number.filter(|n| *n < 4) {
            return Said::Channel(first + n, false);
        }
    }
    if let Some(c) = fused(&["r"]).or(component.filter(|_| has(&["rot", "rotvec", "rotation"]))) {
        return Said::Channel(LogChannel::Rotation.columns().start + c, false);
    }
    if let Some(c) = fused(&["p"]).or(component) {
        return Said::Channel(POSITION + c, false);
    }
    let abc = ["a", "b", "c"].iter().position(|c| words.last().is_some_and(|word| word == c));
    if let (Some(c), None) = (abc, number) {
        return Said::Channel(super::columns::ABC.start + c, false);
    }
    if has(&["payload", "mass", "masse", "last"]) {
        return Said::Channel(LogChannel::Payload.columns().start, false);
    }
    let time = ["t", "time", "zeit", "timestamp", "stamp", "clock", "ipoc", "seconds", "sec"];
    if has(&time) {
        return Said::Channel(TIME, false);
    }
    Said::LeftOut(LeftOut::Unknown)
}

fn of_file(file: usize, raw: &Raw) -> Vec<ProposedColumn> {
    // Axes from 0 to 5: no name ends in 6, and some in 0.
    let numbers: Vec<usize> =
        raw.names.iter().filter_map(|n| words(n).0.last()?.parse().ok()).collect();
    let zero_based = numbers.contains(&0) && !numbers.contains(&6);
    let column = |(k, header): (usize, &String)| {
        let (words, unit) = words(header);
        let values = raw.values[k].as_ref();
        let range = values.map(|v| {
            let finite = v.iter().copied().filter(|x| x.is_finite());
            finite.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
        });
        let rises = || {
            values
                .is_some_and(|v| v.windows(2).all(|w| w[1] > w[0] || w.iter().any(|x| x.is_nan())))
        };
        let mut said = channel_of(&words, zero_based);
        // A time rises; without a header that says so, the first column that does is it.
        if matches!(said, Said::Channel(TIME, _)) && !rises() {
            said = Said::LeftOut(LeftOut::Unknown);
        }
        if k == 0 && rises() && raw.rows > 2 && raw.entry.dialect.header == 0 {
            said = Said::Channel(TIME, false);
        }
        if values.is_none() {
            said = Said::LeftOut(LeftOut::NoNumbers);
        }
        let (mut grounds, mut doubts) = (vec![Ground::Header], Vec::new());
        let mapping = match said {
            Said::LeftOut(why) => Err(why),
            Said::Channel(column, current) => {
                let held = dimension(column);
                let of = unit.and_then(unit_named);
                let fits = of.filter(|u| u.dimension.is_none_or(|d| d == held));
                let unit = match fits {
                    Some(unit) => {
                        grounds.push(Ground::UnitInHeader);
                        unit.name
                    }
                    None if current => "A",
                    None => held.unit(),
                };
                let raw_unit = unit_named(unit).is_some_and(|u| u.dimension.is_none());
                if raw_unit {
                    doubts.push(Doubt::Factor);
                }
                let mapping = ColumnMapping {
                    header: header.clone(),
                    column,
                    unit,
                    factor: 1.0,
                    offset: 0.0,
                };
                Ok(mapping)
            }
        };
        ProposedColumn { file, header: header.clone(), range, mapping, grounds, doubts }
    };
    raw.names.iter().enumerate().map(column).collect()
}

/// A channel has one column, but for the time, of which every file has one. The first one wins.
fn only_once(columns: &mut [ProposedColumn]) {
    for k in 0..columns.len() {
        let Ok(mapping) = &columns[k].mapping else { continue };
        let (column, file) = (mapping.column, columns[k].file);
        let same = |c: &ProposedColumn| {
            c.mapping.as_ref().is_ok_and(|m| m.column == column)
                && (column != TIME || c.file == file)
        };
        if columns[..k].iter().any(same) {
            columns[k].mapping = Err(LeftOut::Twice);
        }
    }
}

/// Units that no header states.
fn units_by_magnitude(columns: &mut [ProposedColumn], raws: &[Raw]) {
    for group in groups() {
        let members: Vec<usize> = (0..columns.len())
            .filter(|k| {
                let c = &columns[*k];
                c.mapping.as_ref().is_ok_and(|m| group.contains(&m.column))
                    && !c.grounds.contains(&Ground::UnitInHeader)
                    && !c.doubts.contains(&Doubt::Factor)
            })
            .collect();
        // Columns of one file are in one unit.
        for file in 0..raws.len() {
            let of_file: Vec<usize> =
                members.iter().copied().filter(|k| columns[*k].file == file).collect();
            let most = of_file
                .iter()
                .filter_map(|k| columns[*k].range)
                .map(|[a, b]| a.abs().max(b.abs()))
                .fold(0.0, f64::max);
            let Some(first) = of_file.first() else { continue };
            let step = columns[*first].header.as_str();
            let step = raws[file]
                .names
                .iter()
                .position(|name| name == step)
                .and_then(|k| raws[file].values[k].as_deref())
                .map_or(0.0, median_step);
            let (unit, sure) = by_magnitude(dimension(group.start), most, step, group.start);
            for k in of_file {
                if let Ok(mapping) = &mut columns[k].mapping {
                    mapping.unit = unit;
                }
                if sure {
                    columns[k].grounds.push(Ground::Magnitude);
                } else {
                    columns[k].doubts.push(Doubt::Unit);
                }
            }
        }
    }
}

/// Columns that share a unit.
fn groups() -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<_> = crate::data::channel::CHANNELS
        .iter()
        .map(|channel| channel.id.columns())
        .filter(|columns| *columns != LogChannel::Payload.columns())
        .collect();
    let payload = LogChannel::Payload.columns();
    groups.push(payload.start..payload.start + 1);
    groups.push(payload.start + 1..payload.end);
    groups.push(super::columns::ABC);
    groups.push(super::columns::QUATERNION);
    groups.push(super::columns::MATRIX);
    groups.push(reflector(0).start..ALL);
    groups
}

/// The unit that values of this size are in, and whether only one fits.
fn by_magnitude(dimension: Dimension, most: f64, step: f64, column: usize) -> (&'static str, bool) {
    match dimension {
        Dimension::Time if step >= 1e5 => ("ns", true),
        Dimension::Time if step >= 500.0 => ("us", true),
        // Rows at rest are seconds apart as well.
        Dimension::Time if step >= 0.5 => ("ms", (0.9..=20.0).contains(&step)),
        Dimension::Time => ("s", step > 0.0),
        Dimension::Angle if most > 6.6 => ("deg", true),
        Dimension::Angle => ("rad", most > 0.2),
        Dimension::AngularSpeed if most > 320.0 => ("rpm", true),
        Dimension::AngularSpeed => ("rad/s", most < 20.0),
        Dimension::Length if most > 2e5 => ("um", true),
        Dimension::Length if most > 20.0 => ("mm", true),
        Dimension::Length => ("m", most > 0.05 && column < LogChannel::Payload.columns().start),
        Dimension::Force if most < 60.0 => ("kN", false),
        Dimension::Force => ("N", most > 300.0),
        Dimension::Torque => ("Nm", most > 50.0),
        Dimension::Mass => ("kg", most < 2000.0),
        Dimension::Number => ("1", true),
    }
}

/// An axis has one sign alone where the other would leave its limits.
fn signs_by_limits(columns: &mut [ProposedColumn], robot: Option<&RobotFile>) {
    let room = 10f64.to_radians();
    for proposed in columns.iter_mut() {
        let Ok(mapping) = &mut proposed.mapping else { continue };
        let Some(joint) = mapping.column.checked_sub(ENCODER).filter(|j| *j < JOINTS) else {
            continue;
        };
        let (Some(robot), Some(range)) = (robot, proposed.range) else {
            proposed.doubts.push(Doubt::Sign);
            continue;
        };
        let unit = unit_named(mapping.unit).map_or(1.0, |u| u.factor);
        let [low, high] = robot.parameters.joints[joint].limits;
        let inside = |sign: f64| {
            range.iter().all(|v| (low - room..=high + room).contains(&(sign * unit * v)))
        };
        match (inside(1.0), inside(-1.0)) {
            (true, false) => proposed.grounds.push(Ground::Limits),
            (false, true) => {
                mapping.factor = -mapping.factor;
                proposed.grounds.push(Ground::Limits);
            }
            _ => proposed.doubts.push(Doubt::Sign),
        }
    }
}

/// A column's values in SI units.
fn series(
    columns: &[ProposedColumn],
    raws: &[Raw],
    file: Option<usize>,
    column: usize,
) -> Option<Vec<f64>> {
    let found = columns.iter().find(|c| {
        file.is_none_or(|file| c.file == file)
            && c.mapping.as_ref().is_ok_and(|m| m.column == column)
    })?;
    let mapping = found.mapping.as_ref().ok()?;
    let raw = &raws[found.file];
    let place = raw.names.iter().position(|name| *name == found.header)?;
    let unit = unit_named(mapping.unit)?.factor;
    let value = |v: &f64| unit * (mapping.factor * v + mapping.offset);
    Some(raw.values[place].as_ref()?.iter().map(value).collect())
}

fn file_of(columns: &[ProposedColumn], column: usize) -> Option<usize> {
    let of = |c: &&ProposedColumn| c.mapping.as_ref().is_ok_and(|m| m.column == column);
    columns.iter().find(of).map(|c| c.file)
}

fn proposed_file(raw: &Raw) -> ProposedFile {
    let dialect = raw.entry.dialect;
    ProposedFile {
        path: raw.entry.path.clone(),
        topic: raw.entry.topic.clone(),
        text: raw.text,
        delimiter: char::from(dialect.delimiter),
        decimal: char::from(dialect.decimal),
        header: dialect.header,
        first_row: dialect.rows,
        rows: raw.rows,
        period: None,
        clock: None,
        fitted: None,
    }
}

/// A file whose times are others than those of the encoders has a clock of its own.
fn name_clocks(files: &mut [ProposedFile], columns: &[ProposedColumn], raws: &[Raw]) {
    let Some(own) = file_of(columns, ENCODER) else { return };
    let Some(time) = series(columns, raws, Some(own), TIME) else { return };
    for (file, proposed) in files.iter_mut().enumerate().filter(|(file, _)| *file != own) {
        let other = series(columns, raws, Some(file), TIME);
        let same = other.is_some_and(|other| {
            let ends = |v: &[f64]| Some((*v.first()?, *v.last()?));
            let period = median_step(&time);
            matches!((ends(&time), ends(&other)), (Some(a), Some(b))
                if (a.0 - b.0).abs() < period && (a.1 - b.1).abs() < period)
        });
        let ros = proposed.topic.is_some();
        if !same && !ros {
            proposed.clock = Some(clock_name(&proposed.path));
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
    let own = file_of(columns, ENCODER).unwrap_or(0);
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

/// Every n-th, so that so many are left.
fn thinned<T: Copy>(values: &[T], most: usize) -> Vec<T> {
    values.iter().copied().step_by((values.len() / most).max(1)).collect()
}

/// Signs of the axes and the clock of the tracker, by the motion that both saw.
fn motion(
    columns: &mut [ProposedColumn],
    files: &mut [ProposedFile],
    raws: &[Raw],
    robot: &RobotFile,
    kind: LogKind,
) {
    let Some(own) = file_of(columns, ENCODER) else { return };
    let point_column = [POSITION, reflector(0).start]
        .into_iter()
        .find_map(|column| Some((column, file_of(columns, column)?)));
    let (Some(time), Some((first, other))) = (series(columns, raws, Some(own), TIME), point_column)
    else {
        return;
    };
    let encoders: Option<Vec<Vec<f64>>> =
        (0..JOINTS).map(|i| series(columns, raws, Some(own), ENCODER + i)).collect();
    let coordinates: Option<Vec<Vec<f64>>> =
        (0..3).map(|i| series(columns, raws, Some(other), first + i)).collect();
    let (Some(encoders), Some(coordinates), Some(other_time)) =
        (encoders, coordinates, series(columns, raws, Some(other), TIME))
    else {
        return;
    };
    let point: Vec<Vector3<f64>> = (0..other_time.len())
        .map(|k| Vector3::new(coordinates[0][k], coordinates[1][k], coordinates[2][k]))
        .collect();
    let turned = rotations(columns, raws, other);
    let by_rows = other == own || (kind == LogKind::StaticLoad && other_time.len() == time.len());
    if kind == LogKind::StaticLoad && !by_rows {
        return;
    }
    // Rows that signs are tried on.
    let rows: Vec<usize> = thinned(&(0..time.len()).collect::<Vec<_>>(), TRIED);
    let own_time: Vec<f64> = rows.iter().map(|k| time[*k]).collect();
    let paired: Vec<Vector3<f64>> =
        if by_rows { rows.iter().map(|k| point[*k]).collect() } else { Vec::new() };
    let seen = thinned(&point, 4 * TRIED);
    let seen_time = thinned(&other_time, 4 * TRIED);
    let pose = |signs: usize, k: usize| {
        let sign = |i: usize| if signs & (1 << i) == 0 { 1.0 } else { -1.0 };
        let q = JointVector::from_fn(|i, _| sign(i) * encoders[i][k]);
        robot.robot.forward_kinematics(&q)
    };
    let path = |signs: usize, rows: &[usize]| -> Vec<Vector3<f64>> {
        rows.iter().map(|k| pose(signs, *k).position).collect()
    };
    // How far the tool turned from its first pose: the same in every frame. `row`: of the tracker.
    let turn_left = |signs: usize, row: &dyn Fn(usize) -> usize| -> f64 {
        let Some(turned) = &turned else { return 0.0 };
        let pairs: Vec<_> = rows
            .iter()
            .map(|k| (pose(signs, *k).rotation, turned[row(*k).min(turned.len() - 1)]))
            .filter(|(a, b)| a.sum().is_finite() && b.sum().is_finite())
            .map(|(a, b)| (a, rotation_from_vector(&b)))
            .collect();
        let Some((a0, b0)) = pairs.first().copied() else { return 0.0 };
        let angle =
            |from: &Matrix3<f64>, to: &Matrix3<f64>| rotation_vector(&from.tr_mul(to)).norm();
        let squares: f64 = pairs.iter().map(|(a, b)| (angle(&a0, a) - angle(&b0, b)).powi(2)).sum();
        LEVER * (squares / pairs.len() as f64).sqrt()
    };
    let left = |signs: usize| -> f64 {
        let path = path(signs, &rows);
        if by_rows {
            let finite: Vec<usize> = (0..path.len())
                .filter(|k| paired[*k].sum().is_finite() && path[*k].sum().is_finite())
                .collect();
            let pick = |v: &[Vector3<f64>]| finite.iter().map(|k| v[*k]).collect::<Vec<_>>();
            let (a, b) = (pick(&path), pick(&paired));
            let Some((turn, shift)) = rigid(&a, &b) else { return f64::INFINITY };
            let squares: f64 =
                a.iter().zip(&b).map(|(x, p)| (p - turn * x - shift).norm_squared()).sum();
            return (squares / a.len().max(1) as f64).sqrt().hypot(turn_left(signs, &|k| k));
        }
        let a = Points { time: &own_time, point: &path };
        let b = Points { time: &seen_time, point: &seen };
        let Some((offset, step)) = correlate(&a, &b) else { return f64::INFINITY };
        let start = ClockMap { offset, drift: 0.0 };
        fit(&a, &b, start, step, [false; 2]).map_or(f64::INFINITY, |fitted| {
            let row = |k: usize| {
                let there = fitted.map.offset + (1.0 + fitted.map.drift) * time[k];
                other_time.partition_point(|t| *t < there)
            };
            fitted.left.hypot(turn_left(signs, &row))
        })
    };
    // Signs that the limits tell are not tried.
    let mask = (0..JOINTS)
        .filter(|i| {
            let of =
                |c: &&ProposedColumn| c.mapping.as_ref().is_ok_and(|m| m.column == ENCODER + i);
            columns.iter().find(of).is_some_and(|c| c.doubts.contains(&Doubt::Sign))
        })
        .fold(0, |mask, i| mask | (1 << i));
    let tried: Vec<usize> = (0..1 << JOINTS).filter(|signs| signs & !mask == 0).collect();
    let mut results: Vec<(f64, usize)> = {
        use rayon::prelude::*;
        tried.into_par_iter().map(|signs| (left(signs), signs)).collect()
    };
    results.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let Some(&(best, signs)) = results.first().filter(|(left, _)| left.is_finite()) else {
        return;
    };
    for i in 0..JOINTS {
        let flipped = |s: usize| s & (1 << i) != signs & (1 << i);
        let others =
            results.iter().find(|(_, s)| flipped(*s)).map_or(f64::INFINITY, |(left, _)| *left);
        let of =
            |c: &&mut ProposedColumn| c.mapping.as_ref().is_ok_and(|m| m.column == ENCODER + i);
        let Some(column) = columns.iter_mut().find(of) else { continue };
        if !column.doubts.contains(&Doubt::Sign) {
            continue;
        }
        // The arm bends by millimetres, and a reflector sits beside the tool's centre.
        let told = best < 0.15 && others > 2.0 * best + 0.002;
        if told {
            column.doubts.retain(|d| *d != Doubt::Sign);
            column.grounds.push(Ground::Motion { left: best, others });
            if signs & (1 << i) != 0
                && let Ok(mapping) = &mut column.mapping
            {
                mapping.factor = -mapping.factor;
            }
        }
    }
    if !by_rows && files[other].clock.is_some() {
        let all: Vec<usize> = (0..time.len()).collect();
        let path = path(signs, &all);
        let (a, b) =
            (Points { time: &time, point: &path }, Points { time: &other_time, point: &point });
        if let Some((offset, step)) = correlate(&a, &b) {
            let start = ClockMap { offset, drift: 0.0 };
            files[other].fitted = fit(&a, &b, start, step, [false; 2]);
        }
    }
}

/// Rotation vectors of the tool, in whatever form a file has them.
fn rotations(columns: &[ProposedColumn], raws: &[Raw], file: usize) -> Option<Vec<Vector3<f64>>> {
    let of = |column: usize| series(columns, raws, Some(file), column);
    let mut track = Track { clock: None, columns: (0..ALL).map(of).collect() };
    to_rotation_vectors(&mut track);
    let rotation = LogChannel::Rotation.columns();
    let rows = 0..track.time().len();
    track
        .has(rotation.clone())
        .then(|| rows.map(|k| track.vector(rotation.start, k)).collect::<Vec<_>>())
        .filter(|rows| !rows.is_empty())
}

/// Signs of the torques, by what the model needs for the motion.
fn torque_signs(columns: &mut [ProposedColumn], raws: &[Raw], robot: &RobotFile) {
    let own = file_of(columns, ENCODER);
    let encoders: Option<Vec<Vec<f64>>> =
        (0..JOINTS).map(|i| series(columns, raws, own, ENCODER + i)).collect();
    let time = series(columns, raws, own, TIME);
    let whole = |v: &[f64]| v.iter().all(|x| x.is_finite());
    let predicted: Option<Vec<JointVector<f64>>> = match (encoders, time) {
        (Some(q), Some(time)) if time.len() > 200 && q.iter().all(|q| whole(q)) => {
            let period = median_step(&time);
            let low = LowPass::new(5f64.min(0.2 / period), period);
            let smooth: Vec<[Vec<f64>; 3]> =
                q.iter().map(|q| [0, 1, 2].map(|d| low.smooth(d, q))).collect();
            let at = |d: usize, k: usize| JointVector::from_fn(|i, _| smooth[i][d][k]);
            let model = &robot.robot;
            let torque = |k: usize| {
                let (q, rate, acceleration) = (at(0, k), at(1, k), at(2, k));
                let mut torque =
                    model.rnea(&model.frames(&q), &rate, &acceleration, &Wrench::zero());
                torque[1] -= model.counterbalance_torque(q[1]);
                for i in 0..JOINTS {
                    torque[i] += model.rotor_inertia()[i] * acceleration[i]
                        + model.parameters().friction.torque(i, rate[i]).0;
                }
                torque
            };
            Some((0..time.len()).map(torque).collect())
        }
        _ => None,
    };
    for i in 0..JOINTS {
        let measured = series(columns, raws, own, TORQUE + i);
        let of = |c: &&mut ProposedColumn| c.mapping.as_ref().is_ok_and(|m| m.column == TORQUE + i);
        let Some(column) = columns.iter_mut().find(of) else { continue };
        let correlation = match (&predicted, measured) {
            (Some(predicted), Some(measured)) if measured.len() == predicted.len() => {
                let pairs = predicted.iter().map(|p| p[i]).zip(measured);
                correlation(
                    &pairs.filter(|(a, b)| a.is_finite() && b.is_finite()).collect::<Vec<_>>(),
                )
            }
            _ => 0.0,
        };
        if correlation.abs() < 0.5 {
            column.doubts.push(Doubt::Sign);
            continue;
        }
        column.grounds.push(Ground::ModelTorque(correlation.abs()));
        if let (true, Ok(mapping)) = (correlation < 0.0, &mut column.mapping) {
            mapping.factor = -mapping.factor;
        }
    }
}

/// Of pairs, with the sign of what they have in common about zero where both hardly vary.
fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let n = pairs.len().max(1) as f64;
    let (a, b) = pairs.iter().fold((0.0, 0.0), |(a, b), pair| (a + pair.0 / n, b + pair.1 / n));
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(x, y)| f(x - a, y - b)).sum::<f64>();
    let (xx, yy, xy) = (sum(&|x, _| x * x), sum(&|_, y| y * y), sum(&|x, y| x * y));
    if xx > 0.0 && yy > 0.0 { xy / (xx * yy).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(header: &str) -> String {
        match channel_of(&words(header).0, false) {
            Said::Channel(column, _) => channel_name(column).to_owned(),
            Said::LeftOut(why) => format!("{why:?}"),
        }
    }

    #[test]
    fn headers_of_several_makers_are_understood() {
        for (header, expected) in [
            ("Zeit [s]", "t"),
            ("Timestamp", "t"),
            ("AXIS_ACT.A3", "qe3"),
            ("$AXIS_ACT_MEAS.A1", "qe1"),
            ("AIPos_A6", "qe6"),
            ("joint_2 (deg)", "qe2"),
            ("position joint_a5", "qe5"),
            ("effort joint_a5", "tm5"),
            ("MACur_A4", "tm4"),
            ("MOT_TRQ_1", "tm1"),
            ("Drehmoment A2 [Nm]", "tm2"),
            ("Fx (N)", "fx"),
            ("force.z", "fz"),
            ("torque.x", "mx"),
            ("Tz [Nm]", "mz"),
            ("X [mm]", "px"),
            ("orientation.w", "qw"),
            ("orientation.x", "qx"),
            ("R2_Y", "reflector2_y"),
            ("SMR3 Z [mm]", "reflector3_z"),
            ("B", "b"),
            ("Rz", "rz"),
            ("Spindeldrehzahl", "spindle"),
            ("Spindle speed [rpm]", "spindle"),
            ("AXIS_SOLL_A1", "Commanded"),
            ("velocity joint_a1", "Unknown"),
            ("gripper", "Unknown"),
            ("payload_kg", "payload"),
            ("tm1_nm", "tm1"),
            ("px_mm", "px"),
        ] {
            assert_eq!(channel(header), expected, "{header}");
        }
        assert_eq!(words("AXIS_1 [deg]").1, Some("deg"));
        assert_eq!(words("px_mm").1, Some("mm"));
    }

    #[test]
    fn the_form_of_a_text_file_is_found() {
        let german = b"Messung 12\nZeit;A1;A2\nms;Grad;Grad\n0,0;1,25;-90,5\n4,0;1,26;-90,4\n";
        let found = sniff(german);
        assert_eq!((found.delimiter, found.decimal, found.header, found.rows), (b';', b',', 2, 4));
        let plain = b"t_s,qe1_rad\n0.0,1.5\n0.1,1.6\n0.2,1.7\n";
        assert_eq!(sniff(plain), Dialect::PLAIN);
        let bare = b"0.0\t1.5\t2\n0.1\t1.6\t3\n0.2\t1.7\t4\n";
        let found = sniff(bare);
        assert_eq!((found.delimiter, found.header, found.rows), (b'\t', 0, 1));
    }
}
