//! One file's rows, read once from front to back into columns in SI units: every number parsed and
//! plausible, the time rising.

use super::bursts::even_times;
use super::columns::{
    Binding, Bound, MAPPABLE_COLUMNS, MATRIX, QUATERNION, TIME_COLUMN, most_of_form, shown_name,
};
use super::notice::LogNotice;
use super::rows::RowSource;
use super::sentinel::Sentinels;
use super::time_of_day::Midnights;
use crate::channel::{COUNT, LogChannel};
use crate::kind::LogKind;
use crate::resample::median_step;
use trueweld_plant::input::{InputError, RobotFile, unit_of};

/// How far an encoder may read beyond the robot's limits, rad: limits are set a little inside the
/// hard stops, and an encoder may be zeroed a little off.
const BEYOND_LIMITS: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// A step of the time, and the mean of all steps, may differ from the stated period by this share
/// of it, on top of what rounding of the written times makes. Clocks jitter by less; a lost row is
/// a whole period.
const JITTER: f64 = 0.01;

/// How far the length of a quaternion, or of a row of a rotation matrix, may be from 1.
const UNIT_VECTOR_TOLERANCE: f64 = 0.05;

/// Speed of a joint from one row to the next that no arm has, in what its drive can do; rows less
/// than `ROW_INTERVAL_MIN` seconds apart are taken to be that far apart.
const DRIVE_SPEED_RATIO_MAX: f64 = 20.0;
const ROW_INTERVAL_MIN: f64 = 1e-3;

/// Rows in which the digits show that a file writes.
pub(super) const WRITTEN: usize = 200;

/// The first column of what hangs on the flange.
const PAYLOAD: usize = LogChannel::Payload.columns().start;

/// What was read of one file.
#[derive(Debug, Clone)]
pub(super) struct FileTrack {
    /// Its clock; `None` for the log's own.
    pub clock: Option<String>,
    /// A series each column that the file has, all of the same length; NaN where a value is
    /// missing.
    pub columns: Vec<Option<Vec<f64>>>,
    /// Half a unit of the last place that a file writes of each column.
    pub rounding: Vec<f64>,
}

impl FileTrack {
    /// Times, s.
    pub(crate) fn time(&self) -> &[f64] {
        self.columns[TIME_COLUMN].as_deref().unwrap_or(&[])
    }

    /// True where it has all of these columns.
    pub(crate) fn has(&self, mut columns: std::ops::Range<usize>) -> bool {
        columns.all(|column| self.columns[column].is_some())
    }

    /// One row of three columns; NaN where a column is not there.
    pub(crate) fn vector(&self, first: usize, row: usize) -> nalgebra::Vector3<f64> {
        nalgebra::Vector3::from_fn(|i, _| {
            self.columns[first + i].as_ref().map_or(f64::NAN, |column| column[row])
        })
    }
}

/// What the rows must agree with.
pub(super) struct Expected<'a> {
    pub kind: LogKind,
    pub robot: &'a RobotFile,
    /// Period of the rows, where it is stated for this file, s.
    pub period: Option<f64>,
}

impl Expected<'_> {
    /// Reads the rows of a file.
    pub(crate) fn read(
        &self,
        rows: &mut dyn RowSource,
        bound: &Bound,
        clock: Option<String>,
        implausible: &mut Option<InputError>,
        notices: &mut Vec<LogNotice>,
    ) -> Result<FileTrack, InputError> {
        let mut columns: Vec<Option<Vec<f64>>> = vec![None; MAPPABLE_COLUMNS];
        bound.bindings.iter().for_each(|b| columns[b.column] = Some(Vec::new()));
        let of = |column: usize| bound.bindings.iter().find(|b| b.column == column);
        let time = of(TIME_COLUMN);
        if time.is_none() {
            if self.period.is_none() {
                let message =
                    format!("missing column `{}`; expected in every file", shown_name(TIME_COLUMN));
                let help = "Map the column with the time to it in [columns]: channel = \"t\". Rows without one \
                            that are even have their period stated: period_s = ….";
                return Err(rows.error_at(None, message, "no time among these", help));
            }
            columns[TIME_COLUMN] = Some(Vec::new());
        }
        let mut decimals = vec![0; bound.bindings.len()];
        let mut repeated = 0;
        let mut swapped: Vec<(usize, InputError)> = Vec::new();
        let ranges: Vec<[f64; 2]> = bound.bindings.iter().map(|b| self.range(b.column)).collect();
        let mut clock_so_far = Clock::default();
        let mut midnights = Midnights::default();
        let mut sentinels: Vec<Sentinels> = Vec::new();
        sentinels.resize_with(bound.bindings.len(), Sentinels::default);
        let mut count = 0;
        while rows.advance()? {
            for (binding, sentinels) in bound.bindings.iter().zip(&mut sentinels) {
                let number = match binding.column {
                    TIME_COLUMN => self.time(rows, binding.field, &mut midnights),
                    _ => rows
                        .value(binding.field)
                        .map(|number| sentinels.take(count - repeated, number)),
                };
                let Some(number) = number else {
                    return Err(not_a_number(rows, binding));
                };
                if let Some(series) = &mut columns[binding.column] {
                    series.push(binding.apply(number));
                }
            }
            add_up(bound, &mut columns);
            for (binding, range) in bound.bindings.iter().zip(&ranges) {
                let value = last(&columns, binding.column);
                if !(range[0]..=range[1]).contains(&value) && !value.is_nan() {
                    // In another unit, or worse: what it is, the whole log tells.
                    implausible.get_or_insert_with(|| self.implausible(rows, binding, value));
                }
            }
            if count < WRITTEN {
                for (decimals, binding) in decimals.iter_mut().zip(&bound.bindings) {
                    *decimals = rows.decimals(binding.field).max(*decimals);
                }
            }
            count += 1;
            let before = clock_so_far.last;
            let now = match (time, self.period) {
                (Some(_), _) => last(&columns, TIME_COLUMN),
                (None, period) => period.unwrap_or_default() * (count - 1) as f64,
            };
            if let Some(time) = time {
                if now.is_nan() {
                    return Err(missing(rows, time));
                }
                if before == Some(now) && is_repeated(&columns) {
                    columns
                        .iter_mut()
                        .flatten()
                        .for_each(|series| series.truncate(series.len() - 1));
                    repeated += 1;
                    continue;
                }
                if self.is_late(&columns) {
                    unit_length(rows, bound, &columns)?;
                    let row = count - repeated - 1;
                    sentinels.iter_mut().for_each(|sentinels| sentinels.swap(row));
                    columns.iter_mut().flatten().for_each(|series| series.swap(row - 1, row));
                    swapped.push((row - 1, runs_backwards(rows, time, before.unwrap_or(now))));
                    continue;
                }
                if let Some(slow) = clock_so_far.tick(rows, time, now, self.period)? {
                    implausible.get_or_insert(slow);
                }
            } else if let Some(series) = &mut columns[TIME_COLUMN] {
                series.push(now);
                clock_so_far.last = Some(now);
            }
            if let (Some(before), None) = (before, &implausible) {
                *implausible = self.jump(rows, bound, &columns, now - before);
            }
            self.hang(rows, bound, &mut columns)?;
            unit_length(rows, bound, &columns)?;
        }
        let count = count - repeated;
        let least = if self.kind == LogKind::StaticLoad { 1 } else { 2 };
        if count < least {
            let message = match count {
                0 => "there is no row after the header; expected the samples".to_owned(),
                n => format!("there is {n} row; expected at least {least} in a {} log", self.kind),
            };
            let help = "Was the recording stopped as soon as it began?";
            return Err(rows.error_of_file(message, help));
        }
        if repeated > 0 {
            notices.push(LogNotice::RowsRepeated(repeated));
        }
        if !swapped.is_empty() {
            notices.push(LogNotice::RowsSwapped(swapped.len()));
        }
        if let (Some(times), false) = (&columns[TIME_COLUMN], swapped.is_empty()) {
            let usual = median_step(times);
            // A wrong time lies between others as well; a row that overtook another is about a usual
            // step from either neighbour.
            let fits =
                |row: usize| times[row - 1..=row + 1].windows(2).all(|t| t[1] - t[0] > 0.5 * usual);
            if let Some((_, wrong)) = swapped.into_iter().find(|(row, _)| !fits(*row)) {
                return Err(wrong);
            }
        }
        for (binding, sentinels) in bound.bindings.iter().zip(sentinels) {
            let Some(series) = &mut columns[binding.column] else { continue };
            let settled = sentinels.settle(series, |number| binding.apply(number));
            notices.extend(settled.map(|(value, rows)| {
                let column = shown_name(binding.column);
                LogNotice::Sentinel { column, value, rows }
            }));
        }
        let stamps = columns[TIME_COLUMN].as_mut().filter(|_| self.period.is_none());
        let bursts = stamps.as_ref().and_then(|stamps| even_times(stamps));
        match (stamps.zip(bursts), clock_so_far.repeated) {
            (Some((stamps, bursts)), _) if self.kind != LogKind::StaticLoad => {
                notices.push(LogNotice::Bursts { rows: bursts.rows });
                *stamps = bursts.times;
            }
            (_, Some(repeated)) => return Err(repeated),
            _ => {}
        }
        let mut rounding = vec![0.0; MAPPABLE_COLUMNS];
        for (decimals, binding) in decimals.into_iter().zip(&bound.bindings) {
            rounding[binding.column] = 0.5 * 10f64.powi(-decimals) * binding.scale.abs();
        }
        Ok(FileTrack { clock, columns, rounding })
    }

    /// True where the last row is of a time between the two before it: packets that carried rows
    /// overtook each other. Loads are in the order in which they were hung on.
    fn is_late(&self, columns: &[Option<Vec<f64>>]) -> bool {
        let time = columns[TIME_COLUMN].as_deref().unwrap_or_default();
        matches!(time, [.., a, b, c] if a < c && c < b) && self.kind != LogKind::StaticLoad
    }

    /// The time of a row in its unit: a time of day goes on over midnight.
    fn time(&self, rows: &dyn RowSource, field: usize, midnights: &mut Midnights) -> Option<f64> {
        rows.value(field).or_else(|| rows.time(field).map(|time| midnights.continued(time)))
    }

    /// Limits of an encoder, widened, rad.
    fn limits(&self, joint: usize) -> [f64; 2] {
        let [low, high] = self.robot.parameters.joints[joint].limits;
        [low - BEYOND_LIMITS, high + BEYOND_LIMITS]
    }

    /// What a column may hold.
    fn range(&self, column: usize) -> [f64; 2] {
        if let Some(most) = most_of_form(column) {
            return [-most, most];
        }
        let (channel, place) = LogChannel::of(column);
        let most = channel.most.0;
        match (channel.id, place) {
            (LogChannel::Encoder, joint) => self.limits(joint),
            (LogChannel::LinkEncoder, joint) => {
                let [low, high] = self.limits(joint);
                let most = low.abs().max(high.abs()).max(most);
                [-most, most]
            }
            (LogChannel::Payload, 0) => [0.0, most],
            (LogChannel::Payload, 1..) => [-10.0, 10.0],
            _ => [-most, most],
        }
    }

    /// Refuses what no welding cell can have measured: it is in another unit, or of another robot.
    fn implausible(&self, rows: &dyn RowSource, binding: &Binding, value: f64) -> InputError {
        let name = shown_name(binding.column);
        let shown = rows.shown(binding.field);
        // Where a factor or an offset acted, what came of it.
        let read = if binding.scale == 1.0 && binding.shift == 0.0 {
            shown
        } else {
            format!("{value:.6} of {shown}")
        };
        let at = |message: String, label: &str, help: &str| {
            rows.error_at(Some(binding.field), message, label, help)
        };
        let column = binding.column;
        if column < COUNT {
            let (channel, place) = LogChannel::of(column);
            if channel.id == LogChannel::Encoder {
                let [low, high] = self.limits(place);
                let (robot, axis) = (&self.robot.name, &self.robot.joint_names[place]);
                let message = format!(
                    "`{name}` is {read}; expected an angle in rad that {axis} of {robot} can have, its limits widened by \
                     10°: {low:.3} to {high:.3}"
                );
                let help = if value.abs() > 7.0 {
                    "This looks like degrees; multiply by π/180, or state the unit in [columns] of log.toml."
                } else {
                    "This looks like a log of another robot, or one with another zero pose or other signs; `factor` and \
                     `offset` in [columns] of log.toml set them right."
                };
                return at(message, "beyond the joint's limits", help);
            }
            if channel.id == LogChannel::Payload && place == 0 && value < 0.0 {
                let message = format!("`{name}` is {read}; expected a mass not below 0");
                return at(message, "below 0", "Write 0 where nothing hangs on the flange.");
            }
        }
        let [_, most] = self.range(column);
        let hint = if column < COUNT {
            match LogChannel::of(column) {
                (channel, 1..) if channel.id == LogChannel::Payload => "millimetres",
                (channel, _) => channel.most.1,
            }
        } else {
            "another unit"
        };
        let unit = unit_of(name).unwrap_or_default();
        let message = format!("`{name}` is {read}; expected at most {most} {unit} in magnitude");
        let help = format!(
            "Is it in {hint}? Where it marks a value that was not measured, leave the field empty."
        );
        at(message, &format!("not in {unit}?"), &help)
    }

    /// An encoder that reads another place than in the row before, `passed` seconds ago, than the
    /// joint can have reached.
    fn jump(
        &self,
        rows: &dyn RowSource,
        bound: &Bound,
        columns: &[Option<Vec<f64>>],
        passed: f64,
    ) -> Option<InputError> {
        if self.kind == LogKind::StaticLoad {
            return None;
        }
        let passed = passed.max(self.period.unwrap_or(ROW_INTERVAL_MIN)).max(ROW_INTERVAL_MIN);
        bound.bindings.iter().find_map(|binding| {
            let joint = LogChannel::Encoder.columns().position(|c| c == binding.column)?;
            let &[.., from, to] = columns[binding.column].as_deref()? else { return None };
            let most = self.robot.parameters.joints[joint].max_rate;
            // A comparison with NaN is false: a missing value jumps nowhere.
            ((to - from).abs() > DRIVE_SPEED_RATIO_MAX * most * passed).then(|| {
                let message = format!(
                    "`{}` jumps by {:.3} rad in {:.1} ms; expected a place that {} can reach at {most:.3} rad/s",
                    shown_name(binding.column),
                    to - from,
                    1e3 * passed,
                    self.robot.joint_names[joint]
                );
                let help = "Are the rows in order, and of one recording? Where it marks a value that was not measured, \
                            leave the field empty.";
                rows.error_at(Some(binding.field), message, "too far from the row before", help)
            })
        })
    }

    /// Checks the payload of a row: a mass in every row, and a centre wherever something hangs.
    fn hang(
        &self,
        rows: &dyn RowSource,
        bound: &Bound,
        columns: &mut [Option<Vec<f64>>],
    ) -> Result<(), InputError> {
        let mass = last(columns, PAYLOAD);
        let Some(binding) = bound.bindings.iter().find(|b| b.column == PAYLOAD) else {
            return Ok(());
        };
        if self.kind != LogKind::StaticLoad {
            if mass == 0.0 || mass.is_nan() {
                return Ok(());
            }
            let message = format!(
                "`payload_kg` is {}; expected 0 or nothing: masses are hung on in static-load logs only",
                rows.shown(binding.field)
            );
            let help =
                "A mass that the robot carries all the time belongs to the tool in the robot file.";
            return Err(rows.error_at(
                Some(binding.field),
                message,
                "not in this kind of log",
                help,
            ));
        }
        for column in PAYLOAD..COUNT {
            if !last(columns, column).is_nan() {
                continue;
            }
            if column != PAYLOAD && mass == 0.0 {
                if let Some(value) = columns[column].as_mut().and_then(|series| series.last_mut()) {
                    *value = 0.0;
                }
                continue;
            }
            if let Some(binding) = bound.bindings.iter().find(|b| b.column == column) {
                return Err(missing(rows, binding));
            }
        }
        Ok(())
    }
}

/// Adds to the last row of columns what other columns of it hold.
fn add_up(bound: &Bound, columns: &mut [Option<Vec<f64>>]) {
    for (column, added, times) in &bound.sums {
        let value = times * last(columns, *added);
        if let Some(sum) = columns[*column].as_mut().and_then(|series| series.last_mut()) {
            *sum += value;
        }
    }
}

fn last(columns: &[Option<Vec<f64>>], column: usize) -> f64 {
    columns[column].as_ref().and_then(|series| series.last().copied()).unwrap_or(f64::NAN)
}

/// True where the last row holds what the one before does.
fn is_repeated(columns: &[Option<Vec<f64>>]) -> bool {
    columns.iter().flatten().all(|series| match series.as_slice() {
        [.., a, b] => a == b || (a.is_nan() && b.is_nan()),
        _ => false,
    })
}

/// A quaternion and the rows of a rotation matrix have the length 1.
fn unit_length(
    rows: &dyn RowSource,
    bound: &Bound,
    columns: &[Option<Vec<f64>>],
) -> Result<(), InputError> {
    let first = MATRIX.start;
    let groups = [QUATERNION, first..first + 3, first + 3..first + 6, first + 6..first + 9];
    for group in groups {
        if columns[group.start].is_none() {
            continue;
        }
        let length = group.clone().map(|column| last(columns, column).powi(2)).sum::<f64>().sqrt();
        if (length - 1.0).abs() > UNIT_VECTOR_TOLERANCE {
            let names: Vec<String> =
                group.clone().map(|column| format!("`{}`", shown_name(column))).collect();
            let message = format!("{} have the length {length:.4}; expected 1", names.join(", "));
            let field = bound.bindings.iter().find(|b| b.column == group.start).map(|b| b.field);
            let help =
                "A rotation's components are of length 1; are they mapped to the right channels?";
            return Err(rows.error_at(field, message, "not of length 1", help));
        }
    }
    Ok(())
}

/// The times so far, and how finely they are written.
#[derive(Default)]
struct Clock {
    first: f64,
    last: Option<f64>,
    /// Periods since the first row, lost rows included.
    steps: f64,
    decimals: i32,
    /// The first row at the time of the row before.
    repeated: Option<InputError>,
}

impl Clock {
    /// Takes the next time. Gives the error of a time that looks like milliseconds.
    fn tick(
        &mut self,
        rows: &dyn RowSource,
        binding: &Binding,
        time: f64,
        period: Option<f64>,
    ) -> Result<Option<InputError>, InputError> {
        self.decimals = self.decimals.max(rows.decimals(binding.field));
        let Some(last) = self.last.replace(time) else {
            self.first = time;
            return Ok(None);
        };
        let place = Some(binding.field);
        if time <= last {
            if time < last {
                return Err(runs_backwards(rows, binding, last));
            }
            let message = format!(
                "`t_s` is {} a second time; expected a later time than in the row before",
                rows.shown(binding.field)
            );
            let error = rows.error_at(place, message, "not later", ORDER_OF_ROWS);
            if period.is_none() {
                // Rows may have been written in bursts.
                self.repeated.get_or_insert(error);
                return Ok(None);
            }
            return Err(error);
        }
        let Some(period) = period else { return Ok(None) };
        // Two rounded times are together off by at most one unit of their last place, but never by
        // a lost row.
        let rounding = (10f64.powi(-self.decimals) * binding.scale.abs()).min(0.5 * period);
        // What subtracting two large times leaves of their own precision.
        let slack = rounding + 4.0 * f64::EPSILON * time.abs().max(last.abs());
        let step = time - last;
        let even = |passed: f64, due: f64| (passed - due).abs() <= JITTER * due + slack;
        // A lost row is a whole period.
        let periods = (step / period).round().max(1.0);
        self.steps += periods;
        // Coarsely written times hide a wrong period in a single step, but not in many.
        let all = self.steps * period;
        let due = (step - periods * period).abs() <= JITTER * period + slack;
        let looks_like_milliseconds = (step / period / 1000.0 - 1.0).abs() < 0.1;
        if due && even(time - self.first, all) && !looks_like_milliseconds {
            return Ok(None);
        }
        let shown = rows.shown(binding.field);
        let read = if even(step, period) {
            format!("{:.6} s a row since the first", (time - self.first) / self.steps)
        } else {
            format!("{step:.6} s after the row before")
        };
        let message = format!(
            "`t_s` is {shown}, {read}; expected a step of {period} s, the `period_s` of log.toml"
        );
        let help = if looks_like_milliseconds {
            "The time looks like milliseconds; write seconds."
        } else {
            "Where sampling is uneven by nature, leave `period_s` out."
        };
        let error = rows.error_at(place, message, "uneven step", help);
        if looks_like_milliseconds { Ok(Some(error)) } else { Err(error) }
    }
}

fn runs_backwards(rows: &dyn RowSource, binding: &Binding, last: f64) -> InputError {
    let message = format!(
        "`t_s` runs backwards: {} after {}; expected a later time than in the row before",
        rows.shown(binding.field),
        (last - binding.shift) / binding.scale
    );
    rows.error_at(Some(binding.field), message, "not later", ORDER_OF_ROWS)
}

const ORDER_OF_ROWS: &str =
    "Rows are in time order. Two recordings are two logs, each in its own folder.";

fn missing(rows: &dyn RowSource, binding: &Binding) -> InputError {
    let name = shown_name(binding.column);
    let unit = unit_of(name).unwrap_or_default();
    let message = format!("`{name}` is missing in this row; expected a number in {unit}");
    let help = match binding.column {
        PAYLOAD => "Write 0 where nothing hangs on the flange.",
        column if column > PAYLOAD => "Where a mass hangs on the flange, its centre is needed.",
        _ => "The time is needed in every row; other channels may have empty fields.",
    };
    rows.error_at(Some(binding.field), message, "empty", help)
}

fn not_a_number(rows: &dyn RowSource, binding: &Binding) -> InputError {
    let name = shown_name(binding.column);
    let unit = unit_of(name).map(|unit| format!(" in {unit}")).unwrap_or_default();
    let text = rows.text(binding.field);
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    let (expected, help) = if text.parse::<f64>().is_ok() {
        ("a finite number", "Where a value is missing, leave the field empty.")
    } else if text.contains(',') && is_number(&text.replace(',', ".")) {
        (
            "the dot as decimal mark, not the comma,",
            "Save the file with dots in its numbers, or say decimal = \",\" of it in `files` of log.toml.",
        )
    } else {
        (
            "a number",
            "Write the number alone, with one decimal mark; the unit stands in the column's name or in [columns].",
        )
    };
    let message = format!("`{name}` is {}; expected {expected}{unit}", rows.shown(binding.field));
    let label = format!("expected {expected}{unit}");
    rows.error_at(Some(binding.field), message, &label, help)
}
