//! One `[[uncertain]]` table: which numbers of a cell it is of, and what they are drawn from.

use super::distribution::Distribution;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_plant::effects::{EffectKind, Location, LocationKind, library};
use trueweld_plant::input::{
    Bounds, InputError, Process, RobotFile, Sensors, TomlTable, did_you_mean, quantity, unit_of,
};
use trueweld_plant::process::{process_keys, process_quantity};
use trueweld_plant::sensors::sensor_numbers;

/// Where the seam really lies, against where it was taught, axes of the taught W about its origin:
/// m and rad.
pub(crate) const SEAM_KEYS: [&str; 6] =
    ["shift_x_m", "shift_y_m", "shift_z_m", "turn_x_rad", "turn_y_rad", "turn_z_rad"];

/// Which number of a cell.
#[derive(Debug, Clone, Copy)]
pub(super) enum Subject {
    /// A parameter of an effect, by its index.
    Effect(&'static EffectKind, usize),
    /// Of the process, by its key.
    Process(&'static str),
    /// Of [`sensor_numbers`], by its index.
    Sensor(usize),
    /// Of [`SEAM_KEYS`], by its index.
    Seam(usize),
}

/// Numbers that are uncertain together.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// Its name.
    pub name: String,
    /// Correlation of the standard normals behind any two of its numbers; 1: one number moves all.
    pub correlation: f64,
}

/// One `[[uncertain]]` table.
#[derive(Debug, Clone)]
pub struct UncertainEntry {
    pub(super) subject: Subject,
    /// Of an effect, as written; nothing for the whole cell.
    pub(super) at: String,
    pub(super) relative: bool,
    pub(super) distribution: Distribution,
    pub(super) group: Option<Group>,
    pub(super) source: String,
    /// `file:line:column`.
    pub(super) place: String,
}

impl PartialEq for UncertainEntry {
    fn eq(&self, other: &Self) -> bool {
        self.place == other.place
    }
}

impl UncertainEntry {
    /// Reads one table.
    ///
    /// # Errors
    /// [`InputError`].
    pub(crate) fn read(table: &TomlTable<'_>) -> Result<Self, InputError> {
        let (subject, own, key) = Self::subject(table)?;
        let (distribution, of_distribution) = Distribution::read(table)?;
        let common = ["distribution", "relative", "group", "correlation", "source"];
        table.only(&[own, of_distribution, &common].concat())?;
        let relative = table.has("relative") && table.truth("relative")?;
        let stands_alone = match subject {
            Subject::Effect(kind, _) => kind.adds_to.is_none(),
            Subject::Process(_) | Subject::Sensor(_) => false,
            Subject::Seam(_) => true,
        };
        if relative && stands_alone {
            return Err(table.wrong(
                "relative",
                "false: there is nothing that this number is a share of",
                "State the number itself, in the unit of its name.",
            ));
        }
        let possible = |end: f64| match subject {
            _ if relative => end > -1.0,
            // In proportion to the robot's own number, which is looked at with the robot.
            Subject::Effect(kind, _) if kind.adds_to.is_some() => true,
            Subject::Effect(kind, parameter) => kind.parameters[parameter].holds(end),
            Subject::Process(_) | Subject::Sensor(_) | Subject::Seam(_) => is_possible(key, end),
        };
        if let Some(end) = distribution.ends().into_iter().find(|end| !possible(*end)) {
            let range = match subject {
                _ if relative => "shares above −1".to_owned(),
                Subject::Effect(kind, parameter) => {
                    let of = &kind.parameters[parameter];
                    format!("values from {:e} to {:e} {}", of.low, of.high, of.unit)
                }
                _ => quantity_of(key).map_or(String::new(), |q| q.expected()),
            };
            return Err(table.wrong(
                "distribution",
                &format!("{range}; this one reaches to {end}"),
                "Set its ends with `low` and `high`.",
            ));
        }
        let group = table.optional("group", |table, key| {
            let correlation = table.number_or("correlation", Bounds::UpTo(1.0), 1.0)?;
            Ok(Group { name: table.name(key)?, correlation })
        })?;
        if group.is_none() && table.has("correlation") {
            return Err(table.wrong("correlation", "a `group` beside it", "Name the group."));
        }
        Ok(Self {
            subject,
            at: table.optional("at", TomlTable::text)?.map_or("", |at| at.text).to_owned(),
            relative,
            distribution,
            group,
            source: table.name("source")?,
            place: table.place_of("distribution"),
        })
    }

    /// The number, the keys that name it, and its own key.
    fn subject(
        table: &TomlTable<'_>,
    ) -> Result<(Subject, &'static [&'static str], &'static str), InputError> {
        if table.has("effect") {
            let ids = || library().map(|kind| kind.id);
            let id = table.text("effect")?.text;
            let kind = EffectKind::of(id).ok_or_else(|| {
                let guess = did_you_mean(id, ids());
                let expected = format!("an effect of the library{guess}");
                table.wrong("effect", &expected, "docs/effects.md lists them.")
            })?;
            let names: Vec<&str> = kind.parameters.iter().map(|p| p.name).collect();
            let (parameter, name) = among(table, "parameter", &names)?;
            return Ok((Subject::Effect(kind, parameter), &["effect", "at", "parameter"], name));
        }
        if table.has("process") {
            let (_, key) = among(table, "process", &process_keys())?;
            return Ok((Subject::Process(key), &["process"], key));
        }
        if table.has("sensor") {
            let keys: Vec<&'static str> = sensor_numbers().iter().map(|(key, _)| *key).collect();
            let (k, key) = among(table, "sensor", &keys)?;
            return Ok((Subject::Sensor(k), &["sensor"], key));
        }
        let (k, key) = among(table, "seam", &SEAM_KEYS)?;
        Ok((Subject::Seam(k), &["seam"], key))
    }
}

/// The one of `keys` that stands under a key of the table, and its place among them.
fn among(
    table: &TomlTable<'_>,
    under: &'static str,
    keys: &[&'static str],
) -> Result<(usize, &'static str), InputError> {
    let text = table.text(under)?.text;
    keys.iter().position(|key| *key == text).map(|k| (k, keys[k])).ok_or_else(|| {
        let guess = did_you_mean(text, keys.iter().copied());
        let expected = format!("one of {}{guess}", keys.join(", "));
        table.wrong(under, &expected, "It is the key of a number in such a file.")
    })
}

/// The row of a key of a file, by its table and key or by its key alone.
fn quantity_of(key: &str) -> Option<&'static trueweld_plant::input::Quantity> {
    process_quantity(key).or_else(|| quantity(key.rsplit('.').next().unwrap_or(key)))
}

fn is_possible(key: &str, value: f64) -> bool {
    quantity_of(key).is_some_and(|q| (q.possible[0]..=q.possible[1]).contains(&value))
}

/// Refuses an effect that is drawn beyond the range in which a file or an option may state it there.
pub(crate) fn within_range(
    entry: &UncertainEntry,
    at: Location,
    robot: &RobotFile,
) -> Result<(), String> {
    let Subject::Effect(kind, parameter) = entry.subject else { return Ok(()) };
    let robot = robot.robot.parameters();
    let [low, high] = kind.range(parameter, at, robot);
    let own = kind.own(parameter, at, robot).filter(|_| entry.relative).unwrap_or(1.0);
    let ends = entry.distribution.ends().map(|end| end * own);
    match ends.into_iter().find(|end| !(low..=high).contains(end)) {
        None => Ok(()),
        Some(end) => Err(format!(
            "expected values from {low:e} to {high:e} {}; this one reaches to {end}",
            kind.parameters[parameter].unit
        )),
    }
}

/// Every number of an entry: its name, the place of its effect, its component.
pub(super) fn places(
    entry: &UncertainEntry,
    robot: &RobotFile,
    process: &mut Process,
    sensors: &mut Sensors,
) -> Result<Vec<(String, Location, usize)>, String> {
    let components = |what: &str, key: &str, count: usize| match count {
        0 => Err(format!("the cell has no {what} {key}")),
        1 => Ok(vec![(format!("{what} {key}"), Location::Cell, 0)]),
        n => Ok((0..n).map(|k| (format!("{what} {key} {}", k + 1), Location::Cell, k)).collect()),
    };
    match entry.subject {
        Subject::Effect(kind, parameter) => {
            let at = match (kind.place, entry.at.as_str()) {
                (LocationKind::Joint, "all") => kind.places(),
                (_, at) => vec![kind.at(at, robot).map_err(|error| error.to_string())?],
            };
            let name = |at: Location| (kind.neutral(at).number_name(parameter, robot), at, 0);
            Ok(at.into_iter().map(name).collect())
        }
        Subject::Process(key) => {
            components("process", key, entry.possible(key, process.numbers(key))?)
        }
        Subject::Sensor(k) => {
            let (key, of) = sensor_numbers()[k];
            components("sensor", key, entry.possible(key, of(sensors))?)
        }
        Subject::Seam(k) => components("seam", SEAM_KEYS[k], 1),
    }
}

impl UncertainEntry {
    pub(super) fn unit(&self) -> &'static str {
        match self.subject {
            _ if self.relative => "1",
            Subject::Effect(kind, parameter) => kind.parameters[parameter].unit,
            Subject::Process(key) => unit_of(key).unwrap_or("1"),
            Subject::Sensor(k) => unit_of(sensor_numbers()[k].0).unwrap_or("1"),
            Subject::Seam(k) => unit_of(SEAM_KEYS[k]).unwrap_or("1"),
        }
    }

    /// How many numbers a key has, all of which may be what this makes of them.
    fn possible(&self, key: &str, nominal: Vec<&mut f64>) -> Result<usize, String> {
        if self.relative && nominal.iter().all(|nominal| **nominal == 0.0) {
            return Err(format!(
                "{key} is 0, and any share of it is 0: nothing would be drawn; expected `relative = false`"
            ));
        }
        for nominal in &nominal {
            for end in self.distribution.ends() {
                let value = if self.relative { **nominal * (1.0 + end) } else { end };
                if !is_possible(key, value) {
                    let expected = quantity_of(key).map_or(String::new(), |q| q.expected());
                    return Err(format!("{key} may become {value}; expected {expected}"));
                }
            }
        }
        Ok(nominal.len())
    }
}
