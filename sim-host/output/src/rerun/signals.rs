//! Every signal of a run as columns over time and over the position on the seam, and its events.

use super::shown::{Beside, DrawnRun, SINCE_STEP};
use super::writer::{RecordError, Store, Writer, refused};
use crate::MILLI;
use crate::color::{JOINT_COLOURS as JOINT_COLORS, REFERENCE, Rgb};
use crate::path::moving;
use crate::text;
use re_chunk::TimeColumn;
use re_log_types::{TimeCell, TimePoint, Timeline};
use re_sdk_types::archetypes::{Scalars, SeriesLines, TextLog};
use re_sdk_types::components::{Color, TextLogLevel};
use std::io::Write;
use std::ops::Range;
use trueweld_core::monitor::WATCHED_ORDERS;
use trueweld_plant::simulate::{LimitKind, RecordRow, health_warnings};

/// Rows in one chunk.
pub(super) const CHUNK_ROWS: usize = 10_000;

/// One plot of the layout: entities below a run's root, and entities that belong to no run.
pub(super) struct PlotGroup {
    pub title: &'static str,
    pub entities: &'static [&'static str],
    pub references: &'static [&'static str],
    pub of: Of,
}

/// The push asked for: the same in every run of a recording, and shown once.
pub(super) const DESIRED: &str = "force/desired";

/// Whose lines a plot shows.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Of {
    /// Every run's together.
    All,
    /// The first run's.
    First,
    /// Those of runs with a compensation law.
    Compensated,
}

/// What a controller does about the force; the schemes that do without one leave it at zero.
pub(super) fn idle(shown: &DrawnRun, entity: &str) -> bool {
    let of: fn(&RecordRow) -> f64 = match entity {
        "controller/depth_correction" => |r| r.depth_correction,
        "controller/push" => |r| r.push,
        _ => return false,
    };
    shown.recording.rows.iter().all(|r| of(r) == 0.0)
}

/// The plots of the layout; the first three are always seen, the others are tabs.
pub(super) const GROUPS: &[PlotGroup] = &[
    PlotGroup {
        references: &["half_pin"],
        ..group("lateral deviation [mm]", Of::All, &["deviation/lateral"])
    },
    group("push [kN]", Of::All, &["force/real", DESIRED]),
    group("twist of the drives [mrad]", Of::First, &["twist"]),
    group(
        "correction [mm, mrad]",
        Of::Compensated,
        &["controller/correction", "controller/correction_turn"],
    ),
    group("torque of the motors [kN·m]", Of::First, &["torque"]),
    group("lateral by joint [mm]", Of::First, &["lateral_by_joint"]),
    group("tilt [°]", Of::All, &["deviation/tilt"]),
    group("longitudinal [mm]", Of::All, &["deviation/longitudinal"]),
    group("depth [mm]", Of::All, &["deviation/depth", "controller/depth_correction"]),
    group("sensed [kN]", Of::All, &["force/sensed", DESIRED]),
    group("force loop [N]", Of::All, &["controller/force_error", "controller/push"]),
    group("spindle lines in the push [N]", Of::All, &["health/spindle_lines", "health/vibration"]),
    group("vibration of the drives [mrad/s]", Of::First, &["health/drives"]),
];

const fn group(title: &'static str, of: Of, entities: &'static [&'static str]) -> PlotGroup {
    PlotGroup { title, entities, references: &[], of }
}

/// Writes the signals and events of one run, of the rows from `from` on.
pub(super) fn all<W: Write>(
    writer: &mut Writer<W>,
    shown: &DrawnRun,
    from: usize,
) -> Result<(), RecordError> {
    let (name, color) = (shown.name.as_str(), shown.color);
    let pale = |part: u16| color.map(|c| (u16::from(c) + (255 - u16::from(c)) * part / 10) as u8);
    // The plots' titles say what and in which unit; the lines' names say whose, and keep the
    // legends small.
    let own = [name.to_owned()];
    let label = |what: &str| [format!("{name}, {what}")];
    let mut signals = SignalWriter { writer, shown, from };

    signals
        .send("deviation/lateral", &own, &[color], |r| Some([r.deviation_w.linear.y * MILLI]))?;
    signals.send("deviation/longitudinal", &own, &[color], |r| {
        Some([r.deviation_w.linear.x * MILLI])
    })?;
    signals.send("deviation/depth", &own, &[color], |r| Some([r.deviation_w.linear.z * MILLI]))?;
    signals.send("deviation/tilt", &own, &[color], |r| Some([r.tilt.to_degrees()]))?;

    signals.send("force/sensed", &own, &[pale(6)], |r| Some([-r.force_sensed_w.z / MILLI]))?;
    signals.send("force/real", &own, &[color], |r| Some([-r.force_w.z / MILLI]))?;
    signals.send(DESIRED, &["asked for".to_owned()], &[REFERENCE], |r| {
        r.force_desired.map(|f| [f / MILLI])
    })?;

    let joints = std::array::from_fn::<String, 6, _>(|i| format!("A{}", i + 1));
    signals.send("twist", &joints, &JOINT_COLORS, |r| Some((r.torsion() * MILLI).into()))?;
    signals.send("lateral_by_joint", &joints, &JOINT_COLORS, |r| {
        Some((r.lateral_by_joint * MILLI).into())
    })?;

    signals.send("torque", &joints, &JOINT_COLORS, |r| Some((r.torque / 1e3).into()))?;

    signals.send("controller/force_error", &own, &[color], |r| Some([r.force_error]))?;
    signals.send("controller/push", &label("force branch"), &[pale(4)], |r| Some([r.push]))?;
    signals.send("controller/depth_correction", &label("added"), &[pale(4)], |r| {
        Some([r.depth_correction * MILLI])
    })?;
    let parts = ["longitudinal [mm]", "lateral [mm]"].map(|p| format!("{name}, {p}"));
    signals.send("controller/correction", &parts, &[pale(4), color], |r| {
        Some([r.correction_w.linear.x * MILLI, r.correction_w.linear.y * MILLI])
    })?;
    signals.send("controller/correction_turn", &label("turn [mrad]"), &[pale(6)], |r| {
        Some([r.correction_w.angular.norm() * MILLI])
    })?;
    let lines = WATCHED_ORDERS.map(|order| format!("{name}, order {order}"));
    signals.send("health/spindle_lines", &lines, &[color, pale(4)], |r| {
        Some(r.health.lines.map(|line| line.amplitude.into()))
    })?;
    signals.send("health/vibration", &label("RMS of the rest"), &[pale(6)], |r| {
        Some([r.health.vibration.into()])
    })?;
    signals.send("health/drives", &joints, &JOINT_COLORS, |r| {
        Some(r.health.drives.map(|drive| f64::from(drive.rate) * MILLI))
    })?;
    events(writer, shown, from)
}

/// Limits and set-points that belong to no run: at every instant of `times` the same values of `N`
/// lines.
pub(super) fn reference<const N: usize, W: Write>(
    writer: &mut Writer<W>,
    entity: &str,
    name: &str,
    color: Rgb,
    times: impl IntoIterator<Item = TimeColumn>,
    values: &[[f64; N]],
) -> Result<(), RecordError> {
    let style =
        SeriesLines::new().with_names([name; N]).with_colors([rgb(color); N]).with_widths([1.5; N]);
    writer.fixed(Store::Recording, entity, &style)?;
    let columns = Scalars::new(values.iter().flatten().copied())
        .columns(std::iter::repeat_n(N, values.len()))
        .map_err(refused)?;
    writer.columns(entity, values.len(), times, columns)
}

struct SignalWriter<'a, 'b, W: Write> {
    writer: &'a mut Writer<W>,
    shown: &'a DrawnRun<'b>,
    /// The first row to write; those before are there.
    from: usize,
}

impl<W: Write> SignalWriter<'_, '_, W> {
    /// One entity of `N` lines; rows where `value` has none are left out.
    fn send<const N: usize>(
        &mut self,
        entity: &str,
        names: &[String; N],
        colors: &[Rgb; N],
        value: impl Fn(&RecordRow) -> Option<[f64; N]>,
    ) -> Result<(), RecordError> {
        let entity = format!("/{}/{entity}", self.shown.root);
        if self.from == 0 {
            let style = SeriesLines::new()
                .with_names(names.iter().map(String::as_str))
                .with_colors(colors.iter().map(|c| rgb(*c)))
                .with_widths([1.5; N]);
            self.writer.fixed(Store::Recording, &entity, &style)?;
        }
        let rows = &self.shown.recording.rows;
        for range in chunks(rows, self.from) {
            let found: Vec<(usize, [f64; N])> =
                range.filter_map(|k| value(&rows[k]).map(|v| (k, v))).collect();
            if found.is_empty() {
                continue;
            }
            let times = self.shown.times(found.iter().map(|(k, _)| *k));
            let columns = Scalars::new(found.iter().flat_map(|(_, v)| *v))
                .columns(std::iter::repeat_n(N, found.len()))
                .map_err(refused)?;
            self.writer.columns(&entity, found.len(), times, columns)?;
        }
        Ok(())
    }
}

/// Ranges of the rows from `start` on that are all on the seam or all off it, none longer than a
/// chunk.
pub(super) fn chunks(rows: &[RecordRow], mut start: usize) -> impl Iterator<Item = Range<usize>> {
    std::iter::from_fn(move || {
        let on_path = moving(rows.get(start)?.phase);
        let length = rows[start..]
            .iter()
            .take(CHUNK_ROWS)
            .take_while(|r| moving(r.phase) == on_path)
            .count();
        let range = start..start + length;
        start = range.end;
        Some(range)
    })
}

/// A time on the timelines of a run.
fn instant(beside: &Beside, time: f64) -> TimePoint {
    let nanoseconds = |seconds: f64| TimeCell::from_duration_nanos((seconds * 1e9).round() as i64);
    let when = TimePoint::default().with(Timeline::new_duration("time"), nanoseconds(time));
    match beside {
        Beside::Step(at) => when.with(Timeline::new_duration(SINCE_STEP), nanoseconds(time - at)),
        Beside::Path(_) => when,
    }
}

/// Changes of phase, where limits and faults begin and end, and warnings.
fn events<W: Write>(
    writer: &mut Writer<W>,
    shown: &DrawnRun,
    from: usize,
) -> Result<(), RecordError> {
    let entity = format!("/{}/events", shown.root);
    let warnings = health_warnings(&shown.recording.rows, shown.recording.period);
    let (done, rows) = shown.recording.rows.split_at(from);
    let mut before = done.last();
    for row in rows {
        let mut log = |text: String, level: TextLogLevel| {
            let entry = TextLog::new(format!("{}: {text}", shown.name));
            let entry = entry.with_level(level).with_color(rgb(shown.color));
            writer.one(Store::Recording, &entity, instant(&shown.beside, row.time), &entry)
        };
        if before.is_none_or(|b| b.phase != row.phase) {
            log(row.phase.name().to_owned(), TextLogLevel::INFO.into())?;
        }
        let limited = row.limited.any();
        if limited != before.is_some_and(|b| b.limited.any()) {
            let text = if limited {
                "a limit of drive or correction reached"
            } else {
                "within limits again"
            };
            log(
                text.to_owned(),
                if limited { TextLogLevel::WARN } else { TextLogLevel::INFO }.into(),
            )?;
        }
        if row.fault != before.and_then(|b| b.fault) {
            match row.fault {
                Some(fault) => {
                    log(LimitKind::Fault(fault).to_string(), TextLogLevel::ERROR.into())?
                }
                None => log("fault gone".to_owned(), TextLogLevel::INFO.into())?,
            }
        }
        for warning in warnings.iter().filter(|warning| warning.first_s == row.time) {
            log(text::weld::warning(warning), TextLogLevel::WARN.into())?;
        }
        before = Some(row);
    }
    Ok(())
}

pub(super) fn rgb([r, g, b]: Rgb) -> Color {
    Color::from_rgb(r, g, b)
}
