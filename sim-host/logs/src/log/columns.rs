//! The columns that files of samples may have, how each becomes a channel, and the headers that say
//! which of them there are.

use super::notice::LogNotice;
use super::rows::RowSource;
use super::units::{Dimension, names_of, unit_named};
use crate::channel::{COUNT, LOG_CHANNELS, LogChannel, column_name};
use crate::kind::LogKind;
use trueweld_plant::input::{
    Bounds, InputError, TomlTable, did_you_mean, nearest, toml_string, unit_of,
};

/// Other forms in which a pose is recorded: name, dimension, largest magnitude.
const POSE_FORMS: [(&str, Dimension, f64); 25] = [
    ("a", Dimension::Angle, 7.0),
    ("b", Dimension::Angle, 7.0),
    ("c", Dimension::Angle, 7.0),
    ("qw", Dimension::Number, 1.1),
    ("qx", Dimension::Number, 1.1),
    ("qy", Dimension::Number, 1.1),
    ("qz", Dimension::Number, 1.1),
    ("r11", Dimension::Number, 1.1),
    ("r12", Dimension::Number, 1.1),
    ("r13", Dimension::Number, 1.1),
    ("r21", Dimension::Number, 1.1),
    ("r22", Dimension::Number, 1.1),
    ("r23", Dimension::Number, 1.1),
    ("r31", Dimension::Number, 1.1),
    ("r32", Dimension::Number, 1.1),
    ("r33", Dimension::Number, 1.1),
    ("reflector1_x", Dimension::Length, 100.0),
    ("reflector1_y", Dimension::Length, 100.0),
    ("reflector1_z", Dimension::Length, 100.0),
    ("reflector2_x", Dimension::Length, 100.0),
    ("reflector2_y", Dimension::Length, 100.0),
    ("reflector2_z", Dimension::Length, 100.0),
    ("reflector3_x", Dimension::Length, 100.0),
    ("reflector3_y", Dimension::Length, 100.0),
    ("reflector3_z", Dimension::Length, 100.0),
];

/// Number of columns that a file may be mapped to: those of a plain log, then [`POSE_FORMS`].
pub(super) const MAPPABLE_COLUMNS: usize = COUNT + POSE_FORMS.len();

/// Column of the time.
pub(super) const TIME_COLUMN: usize = LogChannel::Time.columns().start;

/// Columns of the forms of a pose.
pub(super) const ABC: std::ops::Range<usize> = COUNT..COUNT + 3;
pub(super) const QUATERNION: std::ops::Range<usize> = COUNT + 3..COUNT + 7;
pub(super) const MATRIX: std::ops::Range<usize> = COUNT + 7..COUNT + 16;

/// Columns of a reflector, from 0.
pub(super) fn reflector(index: usize) -> std::ops::Range<usize> {
    let first = COUNT + 16 + 3 * index;
    first..first + 3
}

/// Number of reflectors that may be tracked.
pub(super) const REFLECTOR_COUNT: usize = 3;

/// Name of a channel's column in `[columns]`: that of a plain log without its unit.
pub fn channel_name(column: usize) -> &'static str {
    match POSE_FORMS.get(column.wrapping_sub(COUNT)) {
        Some((name, ..)) => name,
        None => column_name(column).split_once('_').map_or("", |(name, _)| name),
    }
}

/// Name of a column in messages.
pub(super) fn shown_name(column: usize) -> &'static str {
    if column < COUNT { column_name(column) } else { channel_name(column) }
}

/// What the numbers of a column measure.
pub fn dimension(column: usize) -> Dimension {
    if let Some((_, dimension, _)) = POSE_FORMS.get(column.wrapping_sub(COUNT)) {
        return *dimension;
    }
    match unit_of(column_name(column)) {
        Some("s") => Dimension::Time,
        Some("rad") => Dimension::Angle,
        Some("rad/s") => Dimension::AngularSpeed,
        Some("N") => Dimension::Force,
        Some("N·m") => Dimension::Torque,
        Some("kg") => Dimension::Mass,
        _ => Dimension::Length,
    }
}

/// Largest magnitude that a form of a pose can have.
pub(super) fn most_of_form(column: usize) -> Option<f64> {
    POSE_FORMS.get(column.wrapping_sub(COUNT)).map(|(_, _, most)| *most)
}

/// Number of the column with a name as in `[columns]`.
pub fn channel_named(name: &str) -> Option<usize> {
    (0..MAPPABLE_COLUMNS).find(|column| channel_name(*column) == name)
}

/// How one column of a file becomes one of a log: an entry of `[columns]`. The value is
/// (factor · number + offset) in the unit, and what other channels of the file add.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnMapping {
    /// The header, or the number of the column from 1; the file's path and a colon before it where
    /// several files have one of this name.
    pub header: String,
    /// The channel's column, as [`channel_name`] numbers it.
    pub column: usize,
    /// Name of the unit.
    pub unit: &'static str,
    /// Multiplies the number that was read.
    pub factor: f64,
    /// True of a torque in a unit of the drive whose factor is not stated: it is fitted.
    pub open: bool,
    /// Is added, in the unit.
    pub offset: f64,
    /// Columns of other channels that are added, and how many times: an axis that is counted from
    /// the horizontal holds the angle of the one before it.
    pub plus: Vec<(usize, f64)>,
}

impl ColumnMapping {
    /// Name of the channel's column.
    pub fn channel(&self) -> &'static str {
        channel_name(self.column)
    }

    /// The line of `[columns]` that says it.
    pub fn line(&self) -> String {
        let mut line = format!(
            "{} = {{ channel = \"{}\", unit = \"{}\"",
            toml_string(&self.header),
            self.channel(),
            self.unit
        );
        let raw = unit_named(self.unit).is_some_and(|unit| unit.dimension.is_none());
        if self.factor != 1.0 || (raw && !self.open) {
            line += &format!(", factor = {:?}", self.factor);
        }
        if self.offset != 0.0 {
            line += &format!(", offset = {:?}", self.offset);
        }
        line + &self.sum() + " }"
    }

    /// The entry of what other channels add; nothing where none does.
    pub fn sum(&self) -> String {
        let mut line = String::new();
        if !self.plus.is_empty() {
            let term =
                |(column, times): &(usize, f64)| format!("{} = {times:?}", channel_name(*column));
            let terms: Vec<String> = self.plus.iter().map(term).collect();
            line += &format!(", plus = {{ {} }}", terms.join(", "));
        }
        line
    }

    /// Reads an entry of `[columns]`.
    pub(super) fn read(header: &str, table: &TomlTable<'_>) -> Result<Self, InputError> {
        table.only(&["channel", "unit", "factor", "offset", "plus"])?;
        let name = table.text("channel")?.text;
        let column = channel_named(name).ok_or_else(|| {
            let names: Vec<&str> = (0..MAPPABLE_COLUMNS).map(channel_name).collect();
            let expected = format!(
                "the name of a channel{}: t, qe1 … qe6, ql1 …, tm1 …, fx fy fz, mx my mz, px py pz, rx ry rz, a b c, \
                 qw qx qy qz, r11 … r33, reflector1_x …, spindle, payload, cx cy cz",
                did_you_mean(name, names)
            );
            let help = "Without its unit, which `unit` states. A column that is not needed is left out.";
            table.wrong("channel", &expected, help)
        })?;
        let of = dimension(column);
        let unit = match table.has("unit") {
            false if of == Dimension::Number => unit_named("1"),
            _ => unit_named(table.text("unit")?.text),
        };
        let factored = matches!(of, Dimension::Torque | Dimension::Force | Dimension::Angle);
        let fits = unit.filter(|u| u.dimension.map_or(factored, |dimension| dimension == of));
        let Some(unit) = fits else {
            let expected = format!("a unit of {name}, which is held in {}", of.unit());
            return Err(table.wrong("unit", &expected, format!("Write one of {}.", names_of(of))));
        };
        let open = unit.dimension.is_none() && !table.has("factor");
        if open && !LogChannel::MotorTorque.columns().contains(&column) {
            let expected = format!("a unit of {name}, or one with a `factor`");
            let help =
                format!("Add factor = …: {} per {}, seen at the joint.", of.unit(), unit.name);
            return Err(table.wrong("unit", &expected, help));
        }
        let factor = table.number_or("factor", Bounds::Any, 1.0)?;
        let offset = table.number_or("offset", Bounds::Any, 0.0)?;
        if factor == 0.0 {
            return Err(table.wrong(
                "factor",
                "a number that is not 0",
                "It multiplies each value.",
            ));
        }
        let plus = match table.has("plus") {
            true => added_channels(&table.table("plus")?, column)?,
            false => Vec::new(),
        };
        Ok(Self { header: header.to_owned(), column, unit: unit.name, factor, open, offset, plus })
    }
}

/// The channels under `plus` of an entry for `column`, and how many times each is added.
fn added_channels(table: &TomlTable<'_>, column: usize) -> Result<Vec<(usize, f64)>, InputError> {
    let fits = |other: usize| other != column && dimension(other) == dimension(column);
    let mut added = Vec::new();
    for name in table.keys() {
        let Some(other) = channel_named(name).filter(|other| fits(*other)) else {
            let expected = format!(
                "another channel in {}, as {}",
                dimension(column).unit(),
                channel_name(column)
            );
            let help = "An axis counted from the horizontal: plus = { qe2 = 1.0 }.";
            return Err(table.wrong_key(name, &expected, help));
        };
        added.push((other, table.number(name, Bounds::Any)?));
    }
    Ok(added)
}

/// One column of a file that is read.
#[derive(Debug, Clone, Copy)]
pub(super) struct Binding {
    /// The log's column.
    pub column: usize,
    /// The file's.
    pub field: usize,
    /// The value is scale · number + shift.
    pub scale: f64,
    pub shift: f64,
}

impl Binding {
    pub(crate) fn apply(&self, number: f64) -> f64 {
        let same = self.scale == 1.0 && self.shift == 0.0;
        if same { number } else { self.scale * number + self.shift }
    }
}

/// What is read of one file, and the columns that are not.
pub(super) struct Bound {
    pub bindings: Vec<Binding>,
    /// A column, one that is added to it, and how many times.
    pub sums: Vec<(usize, usize, f64)>,
    pub others: Vec<(usize, String)>,
    /// Headers of the entries of `[columns]` that say what a column is.
    pub used: Vec<String>,
}

impl Bound {
    /// Finds the columns of a file that are read: those of `[columns]`, and those named as in a
    /// plain log. `path`: how log.toml calls the file.
    pub(crate) fn new(
        rows: &dyn RowSource,
        path: &str,
        mapping: &[ColumnMapping],
    ) -> Result<Self, InputError> {
        let names = rows.names();
        let (mut bindings, mut others) = (Vec::<Binding>::new(), Vec::new());
        let (mut summed, mut used) = (Vec::<&ColumnMapping>::new(), Vec::new());
        for (field, name) in names.iter().enumerate() {
            let numbered = (field + 1).to_string();
            let meant = |header: &str| {
                header == name.as_str() || (header == numbered && !names.contains(&numbered))
            };
            let of_file = |entry: &&ColumnMapping| {
                let rest = entry.header.strip_prefix(path);
                rest.and_then(|rest| rest.strip_prefix(':')).is_some_and(meant)
            };
            let entry = mapping
                .iter()
                .find(of_file)
                .or_else(|| mapping.iter().find(|entry| meant(&entry.header)));
            let plain = || {
                let column = (0..COUNT).find(|column| column_name(*column) == name)?;
                let mapped = mapping.iter().any(|entry| entry.column == column);
                (column == TIME_COLUMN || !mapped).then_some((column, 1.0, 0.0))
            };
            let found = match entry {
                Some(entry) => {
                    let unit = unit_named(entry.unit).map_or(1.0, |unit| unit.factor);
                    Some((entry.column, unit * entry.factor, unit * entry.offset))
                }
                None => plain(),
            };
            match found {
                Some((column, ..)) if bindings.iter().any(|b| b.column == column) => {
                    let again = if entry.is_some() {
                        format!(
                            "column {} is `{}`, which stands",
                            rows.shown(field),
                            channel_name(column)
                        )
                    } else {
                        format!("column `{name}` stands")
                    };
                    let message = format!("{again} here a second time; expected each column once");
                    let help = "Remove or rename one of the two.";
                    return Err(rows.error_at(Some(field), message, "again", help));
                }
                Some((column, scale, shift)) => {
                    bindings.push(Binding { column, field, scale, shift });
                    used.extend(entry.map(|entry| entry.header.clone()));
                    summed.extend(entry.filter(|entry| !entry.plus.is_empty()));
                }
                None => others.push((field, name.clone())),
            }
        }
        if !bindings.iter().any(|b| b.column < COUNT) {
            let known = |field: &str| {
                LOG_CHANNELS.iter().flat_map(|c| c.columns).any(|column| *column == field)
                    || mapping.iter().any(|entry| entry.header == field)
            };
            if let Some(error) = rows.misread(&known) {
                return Err(error);
            }
        }
        let sums = sums(rows, &bindings, &summed)?;
        Ok(Self { bindings, sums, others, used })
    }
}

/// What is added to columns of a file: other columns of it that hold nothing but their own.
fn sums(
    rows: &dyn RowSource,
    bindings: &[Binding],
    summed: &[&ColumnMapping],
) -> Result<Vec<(usize, usize, f64)>, InputError> {
    let mut sums = Vec::new();
    for entry in summed {
        for (added, times) in &entry.plus {
            let field = |column| bindings.iter().find(|b| b.column == column).map(|b| b.field);
            if field(*added).is_none() || summed.iter().any(|other| other.column == *added) {
                let message = format!(
                    "`{}` is added to `{}`; expected a channel of the same file to which nothing is added",
                    channel_name(*added),
                    entry.channel()
                );
                let help = "State each sum by the channels that the file holds.";
                return Err(rows.error_at(field(entry.column), message, "a sum", help));
            }
            sums.push((entry.column, *added, *times));
        }
    }
    Ok(sums)
}

/// Which columns a log has, in whatever file and form.
pub(super) struct LogHeader {
    has: [bool; COUNT],
    /// Names that are not known, for the notice.
    pub unknown: Vec<String>,
}

impl LogHeader {
    /// What all files of a log have together.
    pub(crate) fn of(files: &[Bound]) -> Self {
        let bound =
            |column: usize| files.iter().any(|f| f.bindings.iter().any(|b| b.column == column));
        let mut has: [bool; COUNT] = std::array::from_fn(bound);
        let all = |mut columns: std::ops::Range<usize>| columns.all(bound);
        let points = (0..REFLECTOR_COUNT).filter(|r| all(reflector(*r))).count();
        if points > 0 {
            LogChannel::Position.columns().for_each(|column| has[column] = true);
        }
        if points == REFLECTOR_COUNT || all(ABC) || all(QUATERNION) || all(MATRIX) {
            LogChannel::Rotation.columns().for_each(|column| has[column] = true);
        }
        let unknown = files.iter().flat_map(|f| &f.others).map(|(_, name)| name.clone()).collect();
        Self { has, unknown }
    }

    /// Rows are even and their period is stated: they need no time.
    pub(crate) fn count_rows(&mut self) {
        self.has[TIME_COLUMN] = true;
    }

    /// True where the column is there.
    pub(crate) fn has(&self, column: usize) -> bool {
        self.has[column]
    }

    /// Which columns of a channel are there.
    pub(crate) fn which<const N: usize>(&self, channel: LogChannel) -> [bool; N] {
        std::array::from_fn(|i| self.has(channel.columns().start + i))
    }

    /// True where a channel has any column.
    pub(crate) fn has_channel(&self, channel: LogChannel) -> bool {
        channel.columns().any(|column| self.has(column))
    }

    /// What is told about columns that are not read.
    pub(crate) fn notices(&self, kind: LogKind) -> Vec<LogNotice> {
        let mut notices = Vec::new();
        if !self.unknown.is_empty() {
            notices.push(LogNotice::UnknownColumns(self.unknown.clone()));
        }
        if self.has_channel(LogChannel::Payload) && kind != LogKind::StaticLoad {
            let columns = LogChannel::Payload.columns().map(column_name).collect();
            notices.push(LogNotice::StaticLoadColumns { columns, kind });
        }
        notices
    }

    /// A column that is another spelling or another unit of one that is not there would be lost
    /// silently.
    pub(crate) fn refuse_near_misses(
        &self,
        rows: &dyn RowSource,
        kind: LogKind,
        others: &[(usize, String)],
    ) -> Result<(), InputError> {
        let bare = |name: &str| name.to_lowercase().replace(|c: char| !c.is_alphanumeric(), "");
        for (field, name) in others {
            let of_kind = |column: &usize| {
                kind == LogKind::StaticLoad || LogChannel::of(*column).0.id != LogChannel::Payload
            };
            for column in (0..COUNT).filter(|column| !self.has(*column)).filter(of_kind) {
                let right = column_name(column);
                let shown = rows.shown(*field);
                if bare(name) == bare(right) {
                    let message =
                        format!("column {shown} is not a name that is known; expected `{right}`");
                    let help =
                        format!("Write `{right}`: small letters, the unit after an underscore.");
                    let label = format!("expected `{right}`");
                    return Err(rows.error_at(Some(*field), message, &label, &help));
                }
                let lower = name.to_lowercase();
                let (stem, unit) = lower.split_once(['_', ' ']).unwrap_or((&lower, ""));
                let unit = unit.trim_matches(|c: char| !c.is_alphanumeric());
                if channel_name(column) != stem {
                    continue;
                }
                let read_in = unit_of(right).unwrap_or_default();
                let entry = |unit: &str| {
                    format!(
                        "or map it in log.toml: [columns] {name:?} = {{ channel = \"{stem}\", unit = \"{unit}\" }}"
                    )
                };
                let held = dimension(column);
                let (is, help) = match unit_named(unit) {
                    Some(other) if other.dimension == Some(held) => (
                        format!("is in {unit}"),
                        format!(
                            "Multiply the column by {} and call it `{right}`, {}.",
                            other.written,
                            entry(other.name)
                        ),
                    ),
                    None if unit.is_empty() => (
                        "names no unit".to_owned(),
                        format!(
                            "If it is in {read_in}, call it `{right}`, {}.",
                            entry(held.unit())
                        ),
                    ),
                    Some(_) => (
                        format!("names the unit {unit}"),
                        format!(
                            "If it is in {read_in}, call it `{right}`, {}.",
                            entry(held.unit())
                        ),
                    ),
                    None => continue,
                };
                let message = format!("column {shown} {is}; expected `{right}`, in {read_in}");
                let label = format!("expected `{right}`");
                return Err(rows.error_at(Some(*field), message, &label, &help));
            }
        }
        Ok(())
    }

    /// Checks that the log has what its kind needs. `file`: the only file of a plain log and its
    /// columns that are not known; of others errors stand in `log.toml`, under `place`.
    pub(crate) fn require(
        &self,
        kind: LogKind,
        file: Option<(&dyn RowSource, &Bound)>,
        place: &TomlTable<'_>,
    ) -> Result<(), InputError> {
        let error = |message: String, label: &str, help: &str| match file {
            Some((rows, _)) => rows.error_at(None, message, label, help),
            None => place.error(&format!("and the files: {message}"), help),
        };
        let required = LOG_CHANNELS
            .iter()
            .filter(|channel| channel.needed.contains(&kind))
            .flat_map(|channel| channel.id.columns());
        if let Some(column) = required.into_iter().find(|column| !self.has(*column)) {
            let name = column_name(column);
            let message = format!("missing column `{name}`; expected in every {kind} log");
            let Some((rows, bound)) = file else {
                let help = format!(
                    "Map a column to it: \"HEADER\" = {{ channel = \"{}\", unit = \"{}\" }}.",
                    channel_name(column),
                    dimension(column).unit()
                );
                return Err(error(message, "", &help));
            };
            let near = nearest(name, bound.others.iter().map(|(_, other)| other.as_str()));
            return Err(match bound.others.iter().find(|(_, other)| near == Some(other)) {
                Some((field, _)) => {
                    let shown = rows.shown(*field);
                    let help = format!("If {shown} is meant, call it `{name}`.");
                    let message = format!("{message}; read {shown}");
                    rows.error_at(Some(*field), message, "meant here?", &help)
                }
                None => {
                    let help = if rows.text(0).parse::<f64>().is_ok() {
                        "The first line holds the names of the columns; this one begins with a number."
                    } else {
                        "The first line holds the names of the columns, with commas between them. Other names and units are \
                         mapped in log.toml; `trueweld import-log FILE` proposes how."
                    };
                    error(message, &format!("`{name}` is not among these"), help)
                }
            });
        }
        for columns in LOG_CHANNELS.iter().filter(|c| c.together).map(|c| c.id.columns()) {
            let there = columns.clone().find(|column| self.has(*column));
            let missing = columns.clone().find(|column| !self.has(*column));
            let in_part = kind != LogKind::StaticLoad && columns == LogChannel::Force.columns();
            if in_part && (kind != LogKind::Weld || self.has(DEPTH_FORCE)) {
                continue;
            }
            if let (Some(there), Some(missing)) = (there, missing) {
                let (message, help) = if in_part {
                    let (message, help) = without_depth_force(columns.filter(|c| self.has(*c)));
                    (message, help.to_owned())
                } else {
                    let [there, missing] = [there, missing].map(column_name);
                    let all = named(columns);
                    let message =
                        format!("`{there}` without `{missing}`; expected all of {all}, or none");
                    let help =
                        format!("Add `{missing}`, with empty fields where it has no values.");
                    (message, help)
                };
                let field = |(_, bound): (&dyn RowSource, &Bound)| {
                    bound.bindings.iter().find(|b| b.column == there).map(|b| b.field)
                };
                return Err(match file {
                    Some(file) => file.0.error_at(field(file), message, "not alone", &help),
                    None => error(message, "", &help),
                });
            }
        }
        let predicted = predicted(kind);
        if !predicted.iter().any(|column| self.has(*column)) {
            let message =
                format!("a {kind} log is compared by {}; expected at least one", named(&predicted));
            let help = "Without one there is nothing to compare.";
            return Err(error(message, "none among these", help));
        }
        Ok(())
    }
}

/// The columns that a kind of log may be compared by: the first of each channel whose columns come
/// together, all of the others.
pub(super) fn predicted(kind: LogKind) -> Vec<usize> {
    let channels = LOG_CHANNELS.iter().filter(|channel| channel.predicted.contains(&kind));
    channels
        .flat_map(|channel| channel.id.columns().take(if channel.together { 1 } else { COUNT }))
        .collect()
}

/// Column of the force along the tool.
pub(super) const DEPTH_FORCE: usize = LogChannel::Force.columns().end - 1;

/// Why a weld's force is of no use where the depth force was not measured.
pub(super) fn without_depth_force(
    measured: impl IntoIterator<Item = usize>,
) -> (String, &'static str) {
    let message = format!(
        "of the weld's force {} alone was measured; expected `{}`, with the others or alone: the forces in the plane go with it",
        named(measured),
        column_name(DEPTH_FORCE)
    );
    let help = "Neither zeros nor empty fields stand for a force that nobody measured. Leave the force out, or record the force \
                along the tool.";
    (message, help)
}

/// Names of columns as messages show them.
pub(super) fn named(columns: impl IntoIterator<Item = impl std::borrow::Borrow<usize>>) -> String {
    let names: Vec<_> =
        columns.into_iter().map(|column| format!("`{}`", column_name(*column.borrow()))).collect();
    names.join(", ")
}
