//! What is to be recorded of which cell, as a user states it: `protocol/1`.
//!
//! ```toml
//! schema = "protocol/1"
//! robot = "robot.toml"                     # or model = "model.toml", with effects that are known
//! seed = 1
//!
//! [[effect]]                               # of the cell, and not of the campaign's model
//! id = "stiffness-error"
//! at = "A2"
//! relative = -0.4
//!
//! [[log]]
//! name = "loads"
//! kind = "static-load"
//! [[log.load]]
//! posture_deg = [20, -50, 95, 0, 45, 0]
//! payload_kg = 500
//! shares = [0, 0.5, 1, 0.5, 0]
//!
//! [[log]]
//! name = "stop"
//! kind = "ring-down"
//! posture_deg = [20, -50, 95, 0, 45, 0]
//! rate_deg_s = [3, 0, 0, 0, 0, 0]
//! ```
//!
//! Everything is checked against the robot when it is read: postures within the joints' limits, rates
//! below the drives'. Left out: what stands in the arm's way.

use crate::instruments::InstrumentNoise;
use crate::laboratory::Laboratory;
use crate::motion::{MOVE_DWELL, Waypoint};
use crate::recipe::Recipe;
use crate::static_arm::AppliedLoad;
use nalgebra::Vector3;
use std::path::Path;
use trueweld_core::{JOINTS, JointVector, Wrench};
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{
    Bounds, Control, FileKind, InputError, InputFile, ModelEffect, ModelFile, RobotFile, Sensors,
    TomlDocument, TomlTable, Weld, folder_of, read_text,
};

/// A protocol that was read and checked.
#[derive(Debug)]
pub struct ProtocolFile {
    /// The model of the campaign: what is known of the cell.
    pub model: ModelFile,
    /// Effects that the cell has beyond its model.
    pub effects: Vec<Effect>,
    /// Gains of the controllers that weld; `None` where the file names none.
    pub control: Option<Control>,
    /// Sensors of the controllers that weld; `None` where the file names none.
    pub sensors: Option<Sensors>,
    /// Noise of the instruments.
    pub noise: InstrumentNoise,
    /// True where the logs state the noise.
    pub noise_stated: bool,
    /// Where the tracker's reflectors sit in T, m; `None` where static logs hold a pose.
    pub reflectors: Option<[Vector3<f64>; 3]>,
    /// Seed of everything random.
    pub seed: u64,
    /// The logs, in the file's order.
    pub logs: Vec<PlannedLog>,
}

/// A log to be recorded.
#[derive(Debug)]
pub struct PlannedLog {
    /// Its folder.
    pub name: String,
    /// What is done in it.
    pub plan: LogPlan,
}

/// What is done in a log. Angles: encoders on the joint side, rad.
#[derive(Debug)]
pub enum LogPlan {
    /// Loads at rest, one after the other.
    Loads(Vec<LoadRow>),
    /// Joints that run evenly and are stopped by their brakes.
    Stop {
        /// Where they are when the log begins.
        start: JointVector<f64>,
        /// Their rates, rad/s.
        rate: JointVector<f64>,
        /// Length of the log, s.
        lasts: f64,
    },
    /// Moves from point to point.
    Moves {
        /// Where the arm rests first.
        start: JointVector<f64>,
        /// The points, in order.
        waypoints: Vec<Waypoint>,
    },
    /// Random moves and waves.
    Wander {
        /// Length of the log, s.
        lasts: f64,
    },
    /// A weld.
    Weld(Box<PlannedWeld>),
}

/// A load at rest.
#[derive(Debug, Clone, Copy)]
pub struct LoadRow {
    /// When, s from the log's start.
    pub time: f64,
    /// Encoders, rad.
    pub motor: JointVector<f64>,
    pub(crate) load: AppliedLoad,
}

/// A weld to be recorded.
#[derive(Debug)]
pub struct PlannedWeld {
    /// The weld.
    pub weld: Weld,
    /// Text of its file.
    pub text: String,
    /// Spindle speed, rad/s.
    pub spindle: f64,
}

/// Most rows, s and logs that a protocol may ask for: more is a slip.
const PROTOCOL_ROWS_MAX: usize = 2000;
const PROTOCOL_TIME_MAX: f64 = 600.0;
const PROTOCOL_LOGS_MAX: usize = 100;

/// Time between two loads, and after a change of posture, s, where the file does not say.
const PAUSE: f64 = 15.0;

/// Length of a ring-down, s, where the file does not say.
const RING_DOWN_LENGTH: f64 = 1.0;

/// Mean rate of a move of least jerk over its peak.
const MEAN: f64 = 8.0 / 15.0;

/// Largest force, N, moment, N·m, and payload, kg, that a load may have.
const MOST_FORCE: f64 = 1e5;
const MOST_MOMENT: f64 = 1e5;
const MOST_PAYLOAD: f64 = 1e4;

impl ProtocolFile {
    /// Reads a protocol, and the files it names.
    ///
    /// # Errors
    /// The first thing in any of them that does not fit, with its place.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, InputError> {
        Self::read_for(path, None)
    }

    /// The same; `robot`: a robot file in place of the one that it names.
    ///
    /// # Errors
    /// As [`ProtocolFile::read`].
    pub fn read_for(path: impl AsRef<Path>, robot: Option<&Path>) -> Result<Self, InputError> {
        let (_, text) = read_text(path.as_ref())?;
        Self::parse_for(&text, path.as_ref(), robot)
    }

    /// Reads a protocol from text that stands, or will stand, at `path`.
    ///
    /// # Errors
    /// As [`ProtocolFile::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, InputError> {
        Self::parse_for(text, path, None)
    }

    fn parse_for(text: &str, path: &Path, robot: Option<&Path>) -> Result<Self, InputError> {
        let document = TomlDocument::parse(text, &path.display().to_string())?;
        let root = document.root_of(FileKind::Protocol.schema())?;
        root.only(&[
            "schema",
            "model",
            "robot",
            "process",
            "control",
            "sensors",
            "seed",
            "noise",
            "noise_stated",
            "reflectors",
            "effect",
            "log",
        ])?;
        let folder = folder_of(path);
        let mut model = model(&root, path)?;
        if let Some(robot) = robot {
            model.robot = RobotFile::read(robot)?;
            robot.clone_into(&mut model.robot_path);
        }
        let effects =
            root.each_table("effect", |table| Ok(ModelEffect::read(table, &model.robot)?.effect))?;
        let tables = root.tables("log")?;
        if tables.is_empty() || tables.len() > PROTOCOL_LOGS_MAX {
            let expected = format!("from 1 to {PROTOCOL_LOGS_MAX} [[log]] tables");
            return Err(root.wrong("log", &expected, "Each [[log]] is one log to record."));
        }
        let mut logs: Vec<PlannedLog> = Vec::with_capacity(tables.len());
        for table in &tables {
            let log = log(table, &model, folder)?;
            if logs.iter().any(|other| other.name == log.name) {
                return Err(table.wrong("name", "a name that no other log has", "Rename one."));
            }
            logs.push(log);
        }
        let named = |key: &str| root.optional(key, |root, key| root.file(key, folder));
        Ok(Self {
            control: named("control")?.map(Control::read).transpose()?,
            sensors: named("sensors")?.map(Sensors::read).transpose()?,
            noise: root.optional_table("noise", InstrumentNoise::read)?.unwrap_or_default(),
            noise_stated: root.optional("noise_stated", TomlTable::truth)?.unwrap_or(true),
            reflectors: root.optional_table("reflectors", reflectors)?,
            seed: root.optional("seed", TomlTable::integer)?.unwrap_or(1),
            model,
            effects,
            logs,
        })
    }

    /// The cell as its model states it.
    pub(crate) fn laboratory(&self, control: Control, sensors: Sensors) -> Laboratory {
        Laboratory {
            robot: self.model.robot.clone(),
            process: self.model.process.clone(),
            control,
            sensors,
            robot_path: self.model.robot_path.clone(),
            process_path: self.model.process_path.clone(),
        }
    }

    /// The truth: the model's effects and those beyond it.
    pub(crate) fn recipe(&self) -> Recipe {
        let mut effects = self.model.cell_effects();
        effects.extend(self.effects.iter().cloned());
        Recipe {
            effects,
            instruments: self.noise.clone(),
            noise_stated: self.noise_stated,
            reflectors: self.reflectors,
            ..Recipe::plain(self.seed)
        }
    }
}

/// The model that the file names, or that robot and process are.
fn model(root: &TomlTable<'_>, path: &Path) -> Result<ModelFile, InputError> {
    let folder = folder_of(path);
    if root.has("model") {
        for key in ["robot", "process"] {
            if root.has(key) {
                let help = "The model file names robot and process itself.";
                return Err(root.wrong_key(key, "either `model`, or `robot` and `process`", help));
            }
        }
        return ModelFile::read(root.file("model", folder)?);
    }
    let mut text = "schema = \"model/1\"\n".to_owned();
    for key in ["robot", "process"] {
        if key == "robot" || root.has(key) {
            root.file(key, folder)?;
            text += &format!("{key} = {:?}\n", root.text(key)?.text);
        }
    }
    ModelFile::parse(&text, path)
}

fn reflectors(table: &TomlTable<'_>) -> Result<[Vector3<f64>; 3], InputError> {
    const REFLECTOR_KEYS: [&str; 3] = ["reflector1_m", "reflector2_m", "reflector3_m"];
    /// Least distance of one from the line through the others, m.
    const REFLECTOR_SPREAD_MIN: f64 = 0.02;
    table.only(&REFLECTOR_KEYS)?;
    let mut at = [Vector3::zeros(); 3];
    for (at, name) in at.iter_mut().zip(REFLECTOR_KEYS) {
        *at = Vector3::from(table.numbers::<3>(name, Bounds::Between(-5.0, 5.0))?);
    }
    let [a, b, c] = at;
    let longest = [b - a, c - a, c - b].iter().map(Vector3::norm).fold(0.0, f64::max);
    if (b - a).cross(&(c - a)).norm() <= REFLECTOR_SPREAD_MIN * longest {
        let help = "Three reflectors on a line do not tell how the tool is turned.";
        return Err(table.wrong(
            REFLECTOR_KEYS[2],
            "a point off the line through the other two",
            help,
        ));
    }
    Ok(at)
}

fn log(table: &TomlTable<'_>, model: &ModelFile, folder: &Path) -> Result<PlannedLog, InputError> {
    let name = table.name("name")?;
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !name.chars().all(plain) || name.len() > 60 {
        let help = "It becomes the log's folder.";
        return Err(table.wrong("name", "a short name of letters, digits, - and _", help));
    }
    let table = &table.clone().called(&name);
    let kind = table.text("kind")?.text;
    let keys = |more: &[&str]| table.only(&[&["name", "kind"], more].concat());
    let plan = match kind {
        "static-load" => {
            keys(&["load", "pause_s"])?;
            loads(table, model)?
        }
        "ring-down" => {
            keys(&["posture_deg", "rate_deg_s", "length_s"])?;
            stop(table, model)?
        }
        "free-motion" => {
            keys(&["posture_deg", "waypoint", "length_s"])?;
            motion(table, model)?
        }
        "weld" => {
            keys(&["weld", "spindle_rad_s"])?;
            weld(table, model, folder)?
        }
        _ => {
            let expected = "static-load, ring-down, free-motion or weld";
            return Err(table.wrong("kind", expected, "A log holds one kind of experiment."));
        }
    };
    Ok(PlannedLog { name, plan })
}

/// Angles within the joints' limits, from degrees.
fn posture(table: &TomlTable<'_>, model: &ModelFile) -> Result<JointVector<f64>, InputError> {
    let degrees = table.numbers::<JOINTS>("posture_deg", Bounds::Any)?;
    let joints = &model.robot.parameters.joints;
    for (i, (degrees, joint)) in degrees.iter().zip(joints).enumerate() {
        let [low, high] = joint.limits.map(f64::to_degrees);
        if !(low..=high).contains(degrees) {
            let name = &model.robot.joint_names[i];
            let expected =
                format!("angles within the limits; {name} goes from {low:.1} to {high:.1}");
            return Err(table.wrong("posture_deg", &expected, "Angles of A1 to A6, degrees."));
        }
    }
    Ok(JointVector::from(degrees.map(f64::to_radians)))
}

fn length(table: &TomlTable<'_>, otherwise: f64) -> Result<f64, InputError> {
    table.number_or("length_s", Bounds::Between(0.2, PROTOCOL_TIME_MAX), otherwise)
}

fn loads(table: &TomlTable<'_>, model: &ModelFile) -> Result<LogPlan, InputError> {
    let pause = table.number_or("pause_s", Bounds::Between(0.1, 1e5), PAUSE)?;
    let mut rows = Vec::new();
    for load in table.tables("load")? {
        load.only(&[
            "posture_deg",
            "payload_kg",
            "centre_m",
            "force_n",
            "force_base_n",
            "moment_nm",
            "shares",
            "time_s",
        ])?;
        let after = rows.last().map_or(0.0, |row: &LoadRow| row.time + pause);
        let mut time = if load.has("time_s") {
            let time = load.number("time_s", Bounds::UpTo(1e6))?;
            if rows.last().is_some_and(|row| time <= row.time) {
                let help = "Loads are recorded in the order in which they stand.";
                return Err(load.wrong("time_s", "a time after that of the load before", help));
            }
            time
        } else {
            after
        };
        let motor = posture(&load, model)?;
        let vector = |key: &str, most: f64| -> Result<Vector3<f64>, InputError> {
            let bounds = Bounds::Between(-most, most);
            let read = load.optional(key, |load, key| load.numbers::<3>(key, bounds))?;
            Ok(read.unwrap_or_default().into())
        };
        let to_tool = model.robot.robot.forward_kinematics(&motor).rotation.transpose();
        let force = vector("force_n", MOST_FORCE)? + to_tool * vector("force_base_n", MOST_FORCE)?;
        let moment = vector("moment_nm", MOST_MOMENT)?;
        let payload = load.number_or("payload_kg", Bounds::UpTo(MOST_PAYLOAD), 0.0)?;
        let centre = vector("centre_m", 5.0)?;
        if load.has("centre_m") && payload == 0.0 {
            let help = "It is where the payload's centre hangs, from the flange.";
            return Err(load.wrong_key("centre_m", "`payload_kg` beside it", help));
        }
        let both = Bounds::Between(-1.0, 1.0);
        let shares =
            load.optional("shares", |load, key| load.list(key, PROTOCOL_ROWS_MAX, both))?;
        let shares = shares.unwrap_or_else(|| vec![0.0, 1.0]);
        if payload > 0.0 && shares.iter().any(|share| *share < 0.0) {
            let help = "A weight hangs down: its shares are from 0 to 1.";
            return Err(load.wrong("shares", "shares from 0 to 1, with a payload", help));
        }
        for share in shares {
            let mass = payload * share;
            rows.push(LoadRow {
                time,
                motor,
                load: AppliedLoad {
                    wrench_in_t: Wrench { moment: moment * share, force: force * share },
                    payload: mass,
                    center: if mass > 0.0 { centre } else { Vector3::zeros() },
                },
            });
            time += pause;
        }
    }
    if rows.is_empty() || rows.len() > PROTOCOL_ROWS_MAX {
        let expected =
            format!("[[log.load]] tables with from 1 to {PROTOCOL_ROWS_MAX} shares together");
        return Err(table.wrong("load", &expected, "Each share of a load is a row."));
    }
    Ok(LogPlan::Loads(rows))
}

fn stop(table: &TomlTable<'_>, model: &ModelFile) -> Result<LogPlan, InputError> {
    let start = posture(table, model)?;
    let degrees = table.numbers::<JOINTS>("rate_deg_s", Bounds::Any)?;
    let joints = &model.robot.parameters.joints;
    let rate = JointVector::from(degrees.map(f64::to_radians));
    let too_fast = (0..JOINTS).find(|i| rate[*i].abs() > joints[*i].max_rate);
    if let Some(i) = too_fast {
        let (name, most) = (&model.robot.joint_names[i], joints[i].max_rate.to_degrees());
        let expected = format!("rates that the drives have; {name} turns at up to {most:.1}");
        return Err(table.wrong("rate_deg_s", &expected, "Rates before the brakes fall."));
    }
    if rate.amax() == 0.0 {
        let help = "Joints that turn are stopped, and ring.";
        return Err(table.wrong("rate_deg_s", "a joint that turns", help));
    }
    Ok(LogPlan::Stop { start, rate, lasts: length(table, RING_DOWN_LENGTH)? })
}

fn motion(table: &TomlTable<'_>, model: &ModelFile) -> Result<LogPlan, InputError> {
    if !table.has("waypoint") {
        if table.has("posture_deg") {
            let help = "Without waypoints the motion is random and begins anywhere.";
            return Err(table.wrong_key("posture_deg", "[[log.waypoint]] tables beside it", help));
        }
        return Ok(LogPlan::Wander {
            lasts: table.number("length_s", Bounds::Between(0.5, PROTOCOL_TIME_MAX))?,
        });
    }
    if table.has("length_s") {
        let help = "The waypoints say how long the motion lasts.";
        return Err(table.wrong_key("length_s", "either `length_s` or [[log.waypoint]]", help));
    }
    let start = posture(table, model)?;
    let (mut from, mut waypoints, mut lasts) = (start, Vec::new(), 0.0);
    for table in table.tables("waypoint")? {
        table.only(&["posture_deg", "takes_s", "dwell_s"])?;
        let to = posture(&table, model)?;
        let takes = table.number("takes_s", Bounds::Between(0.1, PROTOCOL_TIME_MAX))?;
        let dwell = table.number_or("dwell_s", Bounds::UpTo(PROTOCOL_TIME_MAX), MOVE_DWELL)?;
        for (i, joint) in model.robot.parameters.joints.iter().enumerate() {
            let least = (to[i] - from[i]).abs() / (MEAN * joint.max_rate);
            if takes < least {
                let name = &model.robot.joint_names[i];
                let expected = format!("a time that the drives keep; {name} needs {least:.2} s");
                return Err(table.wrong("takes_s", &expected, "Give the move more time."));
            }
        }
        lasts += takes + dwell;
        waypoints.push(Waypoint { to, takes, dwell });
        from = to;
    }
    if waypoints.is_empty() || lasts > PROTOCOL_TIME_MAX {
        let expected = format!("waypoints of at most {PROTOCOL_TIME_MAX} s together");
        return Err(table.wrong("waypoint", &expected, "Record a longer motion as several logs."));
    }
    Ok(LogPlan::Moves { start, waypoints })
}

fn weld(table: &TomlTable<'_>, model: &ModelFile, folder: &Path) -> Result<LogPlan, InputError> {
    let Some(process) = &model.process else {
        let help = "Add `process = \"process.toml\"` at the top of the protocol.";
        return Err(table.wrong_key("weld", "a process for the weld", help));
    };
    let path = table.file("weld", folder)?;
    let (name, text) = read_text(&path)?;
    let spindle = table.quantity_or("spindle_rad_s", process.spindle)?;
    let weld = Weld::parse(&text, &name)?;
    Ok(LogPlan::Weld(Box::new(PlannedWeld { weld, text, spindle })))
}
