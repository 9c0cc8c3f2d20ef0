//! A weld that was recorded, made again in simulation: its robot, its seam, its process, and the force
//! on the tool that the model does not explain.

use crate::cell::{CellFiles, FoundInLog, WeldingCell};
use crate::compare::compare;
use crate::measured::{GivenLogs, log_digests, must_be_of};
use miette::{Result, miette};
use nalgebra::Vector3;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use trueweld_core::Robot;
use trueweld_estimate::disturbance::{ForceDisturbance, tool_rotation};
use trueweld_evaluate::{RecordedRow, ReplayCheck};
use trueweld_logs::campaign::read_logs;
use trueweld_logs::fir::LowPass;
use trueweld_logs::log::{LOG_FILE, Log, LogKind};
use trueweld_plant::input::{Accuracy, InputError, ModelFile, TomlDocument, Weld, read_text};
use trueweld_plant::simulate::Seam;

/// Band in which a recorded tool is followed, Hz, and its largest share of the spindle's frequency: that
/// in which `compare` follows it.
const FOLLOWED_TOOL_BAND: f64 = 2.0;
const FOLLOWED_SPINDLE_SHARE: f64 = 0.3;

/// Window in which a recorded speed is a mean, s; how many of them the arm settles in after the feed rose;
/// and the share by which another speed differs.
const FEED_WINDOW: f64 = 1.0;
const FEED_WINDOWS_SETTLED: f64 = 2.0;
const FEED_CHANGE_MIN: f64 = 0.05;

/// A recorded weld, with what a simulation takes from it.
///
/// ```no_run
/// use trueweld::{CellFiles, LoggedWeld, law, simulate};
///
/// let log = LoggedWeld::read("my-campaign/weld-1".as_ref(), None)?;
/// let cell = log.cell(&CellFiles::new())?;
/// let welds = simulate(&cell).law(law("none")?).law(law("elastostatic")?).run()?;
/// # Ok::<(), miette::Report>(())
/// ```
pub struct LoggedWeld {
    /// The pieces of the log, one where no gap cuts it.
    pub pieces: Vec<Log>,
    /// The force that the model does not explain.
    pub disturbance: ForceDisturbance,
    /// Axes of W along which a simulation takes it, 0 for x.
    pub axes: Vec<usize>,
    /// What was recorded of the tool, row by row.
    pub rows: Vec<RecordedRow>,
    /// Mean speed of the spindle as recorded, rad/s; the process file's where it was not.
    pub spindle: f64,
    /// Changes of the feed that the weld file does not state: path position, m, and speed, m/s.
    pub feeds: Vec<(f64, f64)>,
    /// How far across the seam the path was taught from where the model teaches it, m: 0 until it is
    /// [found](Self::find_taught_path).
    pub taught_offset: f64,
    folder: PathBuf,
    model: Option<PathBuf>,
}

impl LoggedWeld {
    /// Reads the log of a weld and compares it with its model. `model`: a model file; where none is
    /// given, the robot and the process that the log names.
    ///
    /// # Errors
    /// A log of another kind, without force or without tracker; files that cannot be used.
    pub fn read(folder: &Path, model: Option<&Path>) -> Result<Self> {
        let (_, logs) = read_logs(&[folder.to_owned()])?;
        let logs = logs_of_weld(logs, folder)?;
        let model_file = match model {
            Some(path) => ModelFile::read(path)?,
            None => model_of(&logs[0])?,
        };
        must_be_of(&logs, &model_file)?;
        let measured = GivenLogs { model: model_file, logs }.prepare()?;
        let comparison = compare(&measured, &|_| {})?;
        let disturbance = ForceDisturbance::of(&measured.logs, &comparison.logs);
        let disturbance = disturbance.ok_or_else(|| {
            miette!(
                help = "`trueweld compare` on this log says what can be compared of it, and its notices why the force cannot.",
                "{}: the force on the tool cannot be compared with the model; expected some seconds of a weld in contact, sampled fast \
                 enough for its spindle",
                folder.display()
            )
        })?;
        let process = measured.model.process.as_ref().or(measured.logs[0].process.as_ref());
        let bears_push = process.is_none_or(|process| process.bears_push());
        let recorded = mean_spindle(&measured.logs);
        let spindle = recorded.or(process.map(|process| process.spindle)).unwrap_or(0.0);
        let robot = &measured.model.robot.robot;
        let rows = measured.logs.iter().flat_map(|log| recorded_rows(log, robot, spindle));
        let rows: Vec<RecordedRow> = rows.collect();
        let weld = measured.logs[0].weld.as_ref();
        Ok(Self {
            feeds: weld.map(|weld| feed_changes(&rows, weld)).unwrap_or_default(),
            rows,
            pieces: measured.logs,
            disturbance,
            axes: if bears_push { vec![0, 1] } else { vec![0, 1, 2] },
            spindle,
            taught_offset: 0.0,
            folder: folder.to_owned(),
            model: model.map(Path::to_owned),
        })
    }

    /// Finds where the path was taught by a replay of the law and the gains that were recorded: there the
    /// encoders go the same way but for that.
    pub fn find_taught_path(&mut self, replay: &ReplayCheck) {
        self.taught_offset += replay.recorded.encoder.mean - replay.replayed.encoder.mean;
    }

    /// The cell that made the weld, as far as the model and the log tell. `files`: control, sensors and
    /// options; robot, process, model and weld are those of the log.
    ///
    /// # Errors
    /// Those of [`CellFiles::read_weld`].
    pub fn cell(&self, files: &CellFiles) -> Result<WeldingCell> {
        let log = &self.pieces[0];
        let given = self.model.is_some();
        let named = |key: &str| named_file(log, key).map(Some);
        let mut files = CellFiles {
            model: self.model.clone(),
            robot: if given { None } else { named("robot")? },
            process: if given { None } else { named("process")? },
            found: FoundInLog {
                effects: self.disturbance.effects(&self.axes),
                spindle: Some(self.spindle),
                feeds: self.feeds.clone(),
                taught_offset: self.taught_offset,
            },
            ..files.clone()
        };
        files.law_files.extend(log_digests("log", &self.pieces)?);
        let mut cell = files.read_weld(Some(&named_file(log, "weld")?))?;
        let name = self.folder.file_name();
        cell.weld_name = name.map_or(cell.weld_name, |name| name.to_string_lossy().into_owned());
        Ok(cell)
    }
}

/// The pieces of a log, which is that of a weld with force and tracker.
fn logs_of_weld(logs: Vec<Log>, folder: &Path) -> Result<Vec<Log>> {
    let folder = folder.display();
    let first = logs.first().map_or("", |log| log.name.as_str());
    if let Some(other) = logs.iter().find(|log| log.kind != LogKind::Weld) {
        return Err(miette!(
            "{folder}: a log of the kind \"{}\"; expected one of the kind \"weld\", which can be welded again",
            other.kind
        ));
    }
    if logs.iter().any(|log| log.path != logs[0].path) {
        return Err(miette!(
            "{folder}: the folder of a campaign; expected that of one of its logs, such as {first}"
        ));
    }
    let missing = |what: &str, why: &str| {
        Err(miette!(
            help = "The force that the model does not explain is what was measured less what the process does where the tracker saw \
                    the tool.",
            "{folder}: the log has no {what}; expected them, {why}"
        ))
    };
    if logs.iter().all(|log| log.samples.force.is_none()) {
        return missing("force columns (fx_n, fy_n, fz_n)", "to know what disturbed the weld");
    }
    if logs.iter().all(|log| log.samples.position.is_none()) {
        return missing("tracker columns (px_m, py_m, pz_m)", "to know where the tool was");
    }
    Ok(logs)
}

/// The file that `log.toml` names under a key.
fn named_file(log: &Log, key: &str) -> Result<PathBuf, InputError> {
    let path = log.path.join(LOG_FILE);
    let (name, text) = read_text(&path)?;
    TomlDocument::parse(&text, &name)?.root().file(key, &log.path)
}

/// Robot and process of a log as a model without effects.
fn model_of(log: &Log) -> Result<ModelFile, InputError> {
    Ok(ModelFile {
        path: log.path.join(LOG_FILE),
        robot: log.robot.clone(),
        robot_path: named_file(log, "robot")?,
        process: log.process.clone(),
        process_path: Some(named_file(log, "process")?),
        effects: Vec::new(),
        known: Vec::new(),
        accuracy: Accuracy::default(),
        posterior: None,
    })
}

/// Mean speed of the spindle, rad/s, where it was recorded.
fn mean_spindle(logs: &[Log]) -> Option<f64> {
    let speeds = logs.iter().filter_map(|log| log.samples.spindle.as_ref()).flatten();
    let known: Vec<f64> = speeds.copied().filter(|speed| speed.is_finite()).collect();
    (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
}

/// Changes of the speed along the seam while the weld file states one speed: path position, m, and speed,
/// m/s.
fn feed_changes(rows: &[RecordedRow], weld: &Weld) -> Vec<(f64, f64)> {
    let mut changes = Vec::new();
    if !weld.feeds.is_empty() {
        return changes;
    }
    let way = 0.5 * weld.feed * weld.feed_ramp;
    // The arm bends while the feed rises and falls.
    let settled = way + FEED_WINDOWS_SETTLED * FEED_WINDOW * weld.feed;
    let range = settled..Seam::of(weld).length - settled;
    let speeds = speeds(rows);
    let mut now = weld.feed;
    for pair in speeds.windows(2).filter(|pair| pair.iter().all(|(at, _)| range.contains(at))) {
        let [(at, speed), (_, next)] = [pair[0], pair[1]];
        let is_other = |a: f64, b: f64| (a / b - 1.0).abs() > FEED_CHANGE_MIN;
        if is_other(speed, now) && !is_other(next, speed) && speed > 0.0 {
            now = next;
            changes.push((at, now));
        }
    }
    changes
}

/// Mean speed along the seam in windows, m/s, and where each begins, m.
fn speeds(rows: &[RecordedRow]) -> Vec<(f64, f64)> {
    let mut speeds = Vec::new();
    let Some(mut begun) = rows.first() else { return speeds };
    for row in rows {
        if row.time - begun.time >= FEED_WINDOW {
            speeds.push((begun.path, (row.path - begun.path) / (row.time - begun.time)));
            begun = row;
        }
    }
    speeds
}

/// What was recorded of the tool, where the tracker saw it throughout a window.
fn recorded_rows(log: &Log, robot: &Robot<f64>, spindle: f64) -> Vec<RecordedRow> {
    let (Some(weld), Some(position), Some(period)) = (&log.weld, &log.samples.position, log.period)
    else {
        return Vec::new();
    };
    let seam = Seam::real(weld);
    let band = FOLLOWED_TOOL_BAND.min(FOLLOWED_SPINDLE_SHARE * spindle.abs() / TAU);
    let low = LowPass::new(band.min(0.2 / period), period);
    let (n, half) = (position.len(), low.half());
    let row = |k: usize| {
        let seen = Vector3::from_fn(|c, _| low.at(0, |i| position[i][c], n, k));
        recorded_row(log, robot, &seam, k, &seen)
    };
    let rows = (half..n.saturating_sub(half)).map(row);
    rows.filter(|row| row.path.is_finite()).collect()
}

/// Row `k` of a log whose tool was `seen` in B.
fn recorded_row(
    log: &Log,
    robot: &Robot<f64>,
    seam: &Seam,
    k: usize,
    seen: &Vector3<f64>,
) -> RecordedRow {
    let place = seam.place(seen);
    let [path, lateral, depth] = place.position.into();
    let force = log.samples.force.as_ref().map(|force| tool_rotation(log, k) * force[k]);
    RecordedRow {
        time: log.samples.time[k],
        path,
        lateral,
        depth,
        push: force.map_or(f64::NAN, |force| -force.dot(&place.axes.column(2))),
        encoder: seam.across(&robot.forward_kinematics(&log.samples.encoder[k]).position),
    }
}
