//! The rows of a log: `samples.csv`, read once from front to back.

use super::columns::{Header, RawRow, named, predicted};
use super::lines::Lines;
use crate::data::channel::{COUNT, LogChannel, column_name};
use crate::data::kind::LogKind;
use nalgebra::Vector3;
use std::io::Read;
use trueweld_core::{JOINTS, JointVector};
use trueweld_plant::input::unit_of;
use trueweld_plant::input::{InputError, RobotFile};

/// How far an encoder may read beyond the robot's limits, rad: limits are set a little inside the
/// hard stops, and an encoder may be zeroed a little off.
const BEYOND_LIMITS: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// A step of the time, and the mean of all steps, may differ from the stated period by this share
/// of it, on top of what rounding of the written times makes. Clocks jitter by less; a lost row is
/// a whole period.
const JITTER: f64 = 0.01;

/// Columns that every row is read by.
const TIME: usize = LogChannel::Time.columns().start;
const PAYLOAD: usize = LogChannel::Payload.columns().start;

/// Extra mass hung on the flange.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload {
    /// Mass, kg; 0 where nothing hangs.
    pub mass: f64,
    /// Its centre from the flange, in the frame of the last link, m.
    pub centre: Vector3<f64>,
}

/// The rows of a log, a vector a channel, all of the same length.
///
/// Time, encoders and payload are there in every row. In the other channels a value that is missing
/// in the file is NaN, each component for itself. A channel that has no value in any row is `None`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Samples {
    /// Time, s, strictly rising; it need not begin at 0.
    pub time: Vec<f64>,
    /// Encoder angles on the joint side, rad.
    pub encoder: Vec<JointVector<f64>>,
    /// Second encoders on the link side, rad, for each joint that has one.
    pub link_encoder: [Option<Vec<f64>>; JOINTS],
    /// Motor torques seen from the joint, N·m, for each joint where recorded.
    pub motor_torque: [Option<Vec<f64>>; JOINTS],
    /// Force that the environment applies to the tool, in T, N.
    pub force: Option<Vec<Vector3<f64>>>,
    /// Moment that the environment applies to the tool, at the tool centre point, in T, N·m.
    pub moment: Option<Vec<Vector3<f64>>>,
    /// Tool centre point in B, by the tracker, m.
    pub position: Option<Vec<Vector3<f64>>>,
    /// Rotation vector of T in B, by the tracker, rad. Near half a turn its sign may flip from row
    /// to row.
    pub rotation: Option<Vec<Vector3<f64>>>,
    /// Spindle speed, positive about the tool's z axis, rad/s.
    pub spindle: Option<Vec<f64>>,
    /// Extra mass on the flange; static-load logs only.
    pub payload: Option<Vec<Payload>>,
}

impl Samples {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// True where there is no row.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// No rows yet, in the channels that the header has.
    fn with(header: &Header, kind: LogKind) -> Self {
        fn channel<T>(there: bool) -> Option<Vec<T>> {
            there.then(Vec::new)
        }
        let has = |channel| header.has_channel(channel);
        Self {
            time: Vec::new(),
            encoder: Vec::new(),
            link_encoder: header.which(LogChannel::LinkEncoder).map(channel),
            motor_torque: header.which(LogChannel::MotorTorque).map(channel),
            force: channel(has(LogChannel::Force)),
            moment: channel(has(LogChannel::Moment)),
            position: channel(has(LogChannel::Position)),
            rotation: channel(has(LogChannel::Rotation)),
            spindle: channel(has(LogChannel::Spindle)),
            payload: channel(has(LogChannel::Payload) && kind == LogKind::StaticLoad),
        }
    }

    fn push(&mut self, row: &RawRow) {
        let at = |channel: LogChannel| &row[channel.columns()];
        let vector = |values: &[f64]| Vector3::new(values[0], values[1], values[2]);
        self.time.push(at(LogChannel::Time)[0]);
        self.encoder.push(JointVector::from_row_slice(at(LogChannel::Encoder)));
        for i in 0..JOINTS {
            let (link, motor) = (at(LogChannel::LinkEncoder)[i], at(LogChannel::MotorTorque)[i]);
            self.link_encoder[i].iter_mut().for_each(|c| c.push(link));
            self.motor_torque[i].iter_mut().for_each(|c| c.push(motor));
        }
        for (series, channel) in [
            (&mut self.force, LogChannel::Force),
            (&mut self.moment, LogChannel::Moment),
            (&mut self.position, LogChannel::Position),
            (&mut self.rotation, LogChannel::Rotation),
        ] {
            series.iter_mut().for_each(|s| s.push(vector(at(channel))));
        }
        self.spindle.iter_mut().for_each(|s| s.push(at(LogChannel::Spindle)[0]));
        let [mass, centre @ ..] = at(LogChannel::Payload) else { return };
        let payload = Payload { mass: *mass, centre: vector(centre) };
        self.payload.iter_mut().for_each(|s| s.push(payload));
    }

    /// Drops the channels of columns that hold no value.
    fn drop_channel(&mut self, column: usize) {
        let (channel, place) = LogChannel::of(column);
        match channel.id {
            LogChannel::LinkEncoder => self.link_encoder[place] = None,
            LogChannel::MotorTorque => self.motor_torque[place] = None,
            LogChannel::Force => self.force = None,
            LogChannel::Moment => self.moment = None,
            LogChannel::Position => self.position = None,
            LogChannel::Rotation => self.rotation = None,
            LogChannel::Spindle => self.spindle = None,
            LogChannel::Time | LogChannel::Encoder | LogChannel::Payload => {}
        }
    }
}

/// What the rows of a log must agree with.
pub(super) struct Expected<'a> {
    pub kind: LogKind,
    pub robot: &'a RobotFile,
    pub period: Option<f64>,
}

impl Expected<'_> {
    /// Reads the rows under a header. What was left out or dropped is told in `notices`.
    pub fn read<R: Read>(
        &self,
        lines: &mut Lines<R>,
        header: &Header,
        notices: &mut Vec<String>,
    ) -> Result<Samples, InputError> {
        let mut samples = Samples::with(header, self.kind);
        let columns: Vec<_> =
            (0..COUNT).filter_map(|c| header.place[c].map(|field| (c, field))).collect();
        let mut any = [false; COUNT];
        let mut clock = Clock::default();
        while lines.advance()? {
            if lines.width() != header.width {
                return Err(uneven(lines, header.width));
            }
            let mut row = [f64::NAN; COUNT];
            for (column, field) in &columns {
                row[*column] = self.value(lines, *column, *field)?;
                any[*column] |= !row[*column].is_nan();
            }
            clock.tick(lines, header, row[TIME], self.period)?;
            if samples.payload.is_some() {
                hang(lines, header, &mut row)?;
            } else if row[PAYLOAD] != 0.0 && !row[PAYLOAD].is_nan() {
                let place = header.place[PAYLOAD].unwrap_or_default();
                let message = format!(
                    "`payload_kg` is {}; expected 0 or nothing: masses are hung on in static-load logs only",
                    lines.shown(place)
                );
                let help = "A mass that the robot carries all the time belongs to the tool in the robot file.";
                return Err(lines.error_at(place, message, "not in this kind of log", help));
            }
            samples.push(&row);
        }
        self.enough(lines, &samples)?;
        self.drop_empty(lines, header, &any, &mut samples, notices)?;
        Ok(samples)
    }

    /// The value of one field; NaN where it is missing and may be.
    fn value<R: Read>(
        &self,
        lines: &Lines<R>,
        column: usize,
        field: usize,
    ) -> Result<f64, InputError> {
        let text = lines.field(field);
        if text.is_empty() {
            return if LogChannel::of(column).0.every_row {
                Err(missing(lines, column, field))
            } else {
                Ok(f64::NAN)
            };
        }
        let number = std::str::from_utf8(text).ok().and_then(|text| text.parse::<f64>().ok());
        match number {
            Some(x) if x.is_finite() => self.plausible(lines, column, field, x),
            _ => Err(not_a_number(lines, column, field)),
        }
    }

    /// Refuses what no welding cell can have measured: it is in another unit, or of another robot.
    fn plausible<R: Read>(
        &self,
        lines: &Lines<R>,
        column: usize,
        field: usize,
        x: f64,
    ) -> Result<f64, InputError> {
        let name = column_name(column);
        let (channel, place) = LogChannel::of(column);
        let limits = |joint: usize| {
            let [low, high] = self.robot.parameters.joints[joint].limits;
            [low - BEYOND_LIMITS, high + BEYOND_LIMITS]
        };
        let (most, hint) = match (channel.id, place) {
            (LogChannel::Encoder, joint) => {
                let [low, high] = limits(joint);
                if (low..=high).contains(&x) {
                    return Ok(x);
                }
                let (robot, axis) = (&self.robot.name, &self.robot.joint_names[joint]);
                let message = format!(
                    "`{name}` is {}; expected an angle in rad that {axis} of {robot} can have, its limits widened by \
                     10°: {low:.3} to {high:.3}",
                    lines.shown(field)
                );
                let help = if x.abs() > 7.0 {
                    "This looks like degrees; multiply by π/180."
                } else {
                    "This looks like a log of another robot, or one with another zero pose or other signs."
                };
                return Err(lines.error_at(field, message, "beyond the joint's limits", help));
            }
            (LogChannel::LinkEncoder, joint) => {
                let [low, high] = limits(joint);
                (low.abs().max(high.abs()).max(channel.most.0), channel.most.1)
            }
            (LogChannel::Payload, 0) if x < 0.0 => {
                let message =
                    format!("`{name}` is {}; expected a mass not below 0", lines.shown(field));
                return Err(lines.error_at(
                    field,
                    message,
                    "below 0",
                    "Write 0 where nothing hangs on the flange.",
                ));
            }
            (LogChannel::Payload, 1..) => (10.0, "millimetres"),
            _ => channel.most,
        };
        if x.abs() <= most {
            return Ok(x);
        }
        let unit = unit_of(name).unwrap_or_default();
        let message = format!(
            "`{name}` is {}; expected at most {most} {unit} in magnitude",
            lines.shown(field)
        );
        let help = format!(
            "Is it in {hint}? Where it marks a value that was not measured, leave the field empty."
        );
        Err(lines.error_at(field, message, format!("not in {unit}?"), help))
    }

    fn enough<R: Read>(&self, lines: &Lines<R>, samples: &Samples) -> Result<(), InputError> {
        let least = if self.kind == LogKind::StaticLoad { 1 } else { 2 };
        if samples.len() >= least {
            return Ok(());
        }
        let message = match samples.len() {
            0 => "there is no row after the header; expected the samples".to_owned(),
            n => format!("there is {n} row; expected at least {least} in a {} log", self.kind),
        };
        Err(lines.error_of_file(message, "Was the recording stopped as soon as it began?"))
    }

    /// A channel without any value is one that the laboratory does not have.
    fn drop_empty<R: Read>(
        &self,
        lines: &Lines<R>,
        header: &Header,
        any: &[bool; COUNT],
        samples: &mut Samples,
        notices: &mut Vec<String>,
    ) -> Result<(), InputError> {
        let group = |column: usize| {
            let (channel, _) = LogChannel::of(column);
            if channel.together { channel.id.columns() } else { column..column + 1 }
        };
        let empty: Vec<_> = (LogChannel::LinkEncoder.columns().start..PAYLOAD)
            .filter(|column| header.has(*column) && !group(*column).any(|member| any[member]))
            .collect();
        if empty.is_empty() {
            return Ok(());
        }
        if self.kind == LogKind::Weld && empty.contains(&LogChannel::Spindle.columns().start) {
            let message = "column `spindle_rad_s` holds no value; expected the spindle's speed, which drives a weld";
            return Err(lines
                .error_of_file(message, "Write the commanded speed where it was not measured."));
        }
        let left = predicted(self.kind)
            .iter()
            .any(|column| header.has(*column) && !empty.contains(column));
        if !left {
            let message = format!(
                "{} hold no value; a {} log has nothing to compare then",
                named(&empty),
                self.kind
            );
            return Err(lines.error_of_file(message, "Was the instrument recorded?"));
        }
        empty.iter().for_each(|column| samples.drop_channel(*column));
        notices.push(format!("columns without any value, read as absent: {}", named(&empty)));
        Ok(())
    }
}

/// The times so far, and how finely they are written.
#[derive(Default)]
struct Clock {
    first: f64,
    last: Option<f64>,
    steps: u32,
    decimals: i32,
}

impl Clock {
    fn tick<R: Read>(
        &mut self,
        lines: &Lines<R>,
        header: &Header,
        time: f64,
        period: Option<f64>,
    ) -> Result<(), InputError> {
        let place = header.place[TIME].unwrap_or_default();
        self.decimals = self.decimals.max(decimals(lines.field(place)));
        let Some(last) = self.last.replace(time) else {
            self.first = time;
            return Ok(());
        };
        let shown = lines.shown(place);
        if time <= last {
            let message = if time < last {
                format!(
                    "`t_s` runs backwards: {shown} after {last}; expected a later time than in the row before"
                )
            } else {
                format!(
                    "`t_s` is {shown} a second time; expected a later time than in the row before"
                )
            };
            let help =
                "Rows are in time order. Two recordings are two logs, each in its own folder.";
            return Err(lines.error_at(place, message, "not later", help));
        }
        let Some(period) = period else { return Ok(()) };
        self.steps = self.steps.saturating_add(1);
        // Two rounded times are together off by at most one unit of their last place, but never by
        // a lost row.
        let rounding = 10f64.powi(-self.decimals).min(0.5 * period);
        // What subtracting two large times leaves of their own precision.
        let slack = rounding + 4.0 * f64::EPSILON * time.abs().max(last.abs());
        let step = time - last;
        let even = |passed: f64, due: f64| (passed - due).abs() <= JITTER * due + slack;
        // Coarsely written times hide a wrong period in a single step, but not in many.
        let all = f64::from(self.steps) * period;
        if even(step, period) && even(time - self.first, all) {
            return Ok(());
        }
        let read = if even(step, period) {
            format!("{:.6} s a row since the first", (time - self.first) / f64::from(self.steps))
        } else {
            format!("{step:.6} s after the row before")
        };
        let message = format!(
            "`t_s` is {shown}, {read}; expected a step of {period} s, the `period_s` of log.toml"
        );
        let help = if (step / period / 1000.0 - 1.0).abs() < 0.1 {
            "The time looks like milliseconds; write seconds."
        } else {
            "Where rows were lost, split the log there; where sampling is uneven by nature, leave `period_s` out."
        };
        Err(lines.error_at(place, message, "uneven step", help))
    }
}

/// Number of decimals that a number is written with.
fn decimals(text: &[u8]) -> i32 {
    let mut parts = text.split(|byte| matches!(byte, b'e' | b'E'));
    let mantissa = parts.next().unwrap_or_default();
    let exponent =
        parts.next().and_then(|e| std::str::from_utf8(e).ok()?.parse::<i32>().ok()).unwrap_or(0);
    let after_dot =
        mantissa.iter().position(|byte| *byte == b'.').map_or(0, |dot| mantissa.len() - dot - 1);
    // Finer than this no time is.
    i32::try_from(after_dot).unwrap_or(i32::MAX).saturating_sub(exponent).clamp(0, 15)
}

/// Checks the payload of a row: a mass in every row, and a centre wherever something hangs.
fn hang<R: Read>(lines: &Lines<R>, header: &Header, row: &mut RawRow) -> Result<(), InputError> {
    for column in PAYLOAD..COUNT {
        if !row[column].is_nan() {
            continue;
        }
        if column != PAYLOAD && row[PAYLOAD] == 0.0 {
            row[column] = 0.0;
            continue;
        }
        return Err(missing(lines, column, header.place[column].unwrap_or_default()));
    }
    Ok(())
}

fn missing<R: Read>(lines: &Lines<R>, column: usize, field: usize) -> InputError {
    let unit = unit_of(column_name(column)).unwrap_or_default();
    let message =
        format!("`{}` is missing in this row; expected a number in {unit}", column_name(column));
    let help = match column {
        PAYLOAD => "Write 0 where nothing hangs on the flange.",
        column if column > PAYLOAD => "Where a mass hangs on the flange, its centre is needed.",
        _ => {
            "Time and encoders drive the model and are needed in every row; other channels may have empty fields."
        }
    };
    lines.error_at(field, message, "empty", help)
}

fn not_a_number<R: Read>(lines: &Lines<R>, column: usize, field: usize) -> InputError {
    let unit = unit_of(column_name(column)).unwrap_or_default();
    let text = String::from_utf8_lossy(lines.field(field)).into_owned();
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    let (expected, help) = if text.parse::<f64>().is_ok() {
        ("a finite number", "Where a value is missing, leave the field empty.")
    } else if text.contains(',') && is_number(&text.replace(',', ".")) {
        ("the dot as decimal mark, not the comma,", "Save the file with dots in its numbers.")
    } else if ["null", "none", "na", "n/a", "-", "--", "?"].contains(&text.to_lowercase().as_str())
    {
        ("a number or an empty field", "Where a value is missing, leave the field empty.")
    } else {
        (
            "a number",
            "Write the number alone, with a dot as decimal mark; the unit stands in the column's name.",
        )
    };
    let message = format!(
        "`{}` is {}; expected {expected} in {unit}",
        column_name(column),
        lines.shown(field)
    );
    lines.error_at(field, message, format!("expected {expected} in {unit}"), help)
}

/// A row of another width than the header's.
fn uneven<R: Read>(lines: &Lines<R>, width: usize) -> InputError {
    let read = lines.width();
    let plural = if read == 1 { "" } else { "s" };
    let message =
        format!("this row has {read} field{plural}; expected {width}, as many as the header has");
    let line = lines.line();
    let other_separator = [(b';', "`;`"), (b'\t', "a tab")]
        .into_iter()
        .find(|(byte, _)| read == 1 && line.contains(byte));
    if let Some((_, name)) = other_separator {
        let message = format!("{message}; it uses {name} as separator; expected `,`");
        return lines.error_at(
            0,
            message,
            "expected `,`",
            "Save the file with commas between the fields.",
        );
    }
    if read > width && !line.contains(&b'.') {
        let message =
            format!("{message}; no number has a dot: it seems that commas are decimal marks here");
        let help = "Save the file with dots in its numbers and commas between the fields.";
        return lines.error_at(width, message, "one too many from here on", help);
    }
    if read > width {
        return lines.error_at(
            width,
            message,
            "one too many from here on",
            "Each row has one field a column.",
        );
    }
    let help = if lines.cut() {
        "The file ends within this row: the recording was cut off. Delete the row."
    } else {
        "Each row has one field a column; a value that is missing is an empty field between two commas."
    };
    lines.error_at(read, message, "the row ends here", help)
}
