//! The model of a cell: `model/1`. A robot, a process, and the effects that the cell has beyond the
//! baseline.
//!
//! ```toml
//! schema = "model/1"
//! robot = "robot.toml"            # from this file's folder
//! process = "process.toml"        # left out where nothing is welded
//!
//! [[effect]]                      # of the library, or of the user's own with `port` and `expression`
//! id = "backlash"
//! at = "A5"
//! half_gap_rad = 2e-4
//! ```
//!
//! Read here and written in [`write`]; what is written is read back to the same values. What measurements leave
//! open of the numbers stands in `[posterior]`, a table of its own.

mod known;
mod write;

pub use known::KnownEffect;

use super::place::place;
use super::posterior::Posterior;
use super::quantity::warn;
use super::table::TomlTable;
use super::{
    Accuracy, Bounds, FileKind, InputError, InputFile, Process, RobotFile, TomlDocument,
    hash_of_file, hexadecimal, nearest, read_text,
};
use crate::effects::formula::{
    CustomParameter, CustomRole, Definition, MOST_PARAMETERS, NamedPort, PORTS,
};
use crate::effects::table::{DefinedTable, Places, TABLE_PLACES_MAX};
use crate::effects::{self, Effect, EffectKind, Role, library};
use sha2::{Digest, Sha256};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// For how long the values of an effect's parameters hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// For all logs of a campaign.
    Campaign,
    /// For one log: they are fitted to each anew, and the file's are where a fit starts.
    Log,
}

/// An effect of a model.
#[derive(Debug, Clone)]
pub struct ModelEffect {
    /// Kind, place and values.
    pub effect: Effect,
    /// For how long the values hold.
    pub scope: Scope,
}

/// A model file with the files it names.
#[derive(Debug, Clone)]
pub struct ModelFile {
    /// Where it was read from.
    pub path: PathBuf,
    /// The robot.
    pub robot: RobotFile,
    /// Where the robot was read from.
    pub robot_path: PathBuf,
    /// The process; none where nothing is welded.
    pub process: Option<Process>,
    /// Where the process was read from.
    pub process_path: Option<PathBuf>,
    /// The effects, in the file's order.
    pub effects: Vec<ModelEffect>,
    /// What is known of effects without the logs.
    pub known: Vec<KnownEffect>,
    /// How exact its predictions need be.
    pub accuracy: Accuracy,
    /// What measurements leave open of its numbers; none where it was not fitted.
    pub posterior: Option<Posterior>,
}

/// What a written model file says of where its numbers come from. Empty texts are left out.
#[derive(Debug, Clone, Default)]
pub struct Comments {
    /// At the head of the file.
    pub file: String,
    /// Of the posterior.
    pub posterior: String,
    /// Of each effect, in order; effects beyond the end have none.
    pub effects: Vec<EffectComments>,
}

/// What a written model file says of one effect.
#[derive(Debug, Clone, Default)]
pub struct EffectComments {
    /// Of the effect.
    pub effect: String,
    /// Of each parameter, in order; parameters beyond the end have none.
    pub parameters: Vec<String>,
}

/// Warns of an effect that stands twice, which acts twice. Two waves, or two of another shape, are two
/// effects, as are two of one's own.
fn warn_of_twins(effects: &[ModelEffect], robot: &RobotFile, path: &Path) {
    let is_shape = |role: &Role| {
        use Role::{Order, PathPosition, Shape, SpindleOrder, Wavelength};
        matches!(role, Order | SpindleOrder | Wavelength | PathPosition | Shape(_))
    };
    let shape = |effect: &Effect| -> Vec<f64> {
        let of = effect.kind.parameters.iter().zip(&effect.values);
        of.filter(|(p, _)| is_shape(&p.role)).map(|(_, v)| *v).collect()
    };
    for (k, twin) in effects.iter().enumerate() {
        let twin = &twin.effect;
        let same =
            |e: &&ModelEffect| e.effect.place() == twin.place() && shape(&e.effect) == shape(twin);
        if library().any(|kind| kind.id == twin.kind.id) && effects[..k].iter().any(|e| same(&e)) {
            warn(format!(
                "{}: {} stands twice; both act, one beside the other",
                path.display(),
                twin.name(robot)
            ));
        }
    }
}

impl ModelFile {
    /// Reads a model file, and the robot and process files it names.
    ///
    /// # Errors
    /// The first thing in any of them that does not fit, with its place.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, InputError> {
        let (_, text) = read_text(path.as_ref())?;
        Self::parse(&text, path.as_ref())
    }

    /// Reads a model from text that stands, or will stand, at `path`.
    ///
    /// # Errors
    /// As [`ModelFile::read`].
    pub fn parse(text: &str, path: &Path) -> Result<Self, InputError> {
        let document = TomlDocument::parse(text, &path.display().to_string())?;
        let root = document.root_of(FileKind::Model.schema())?;
        root.only(&["schema", "robot", "process", "effect", "known", "accuracy", "posterior"])?;
        let robot_path = named_file(&root, "robot", path)?;
        let robot = RobotFile::read(&robot_path)?;
        let process_path = root.optional("process", |root, key| named_file(root, key, path))?;
        let process = process_path.as_ref().map(Process::read).transpose()?;
        let effects = root.each_table("effect", |table| ModelEffect::read(table, &robot))?;
        warn_of_twins(&effects, &robot, path);
        let known = KnownEffect::read_all(&root, &robot)?;
        let accuracy = Accuracy::read(&root)?;
        // Of these effects, and of others of the library.
        let own = |id: &str| effects.iter().map(|e| e.effect.kind).find(|kind| kind.id == id);
        let kind = |id: &str| own(id).or_else(|| EffectKind::of(id));
        let posterior =
            root.optional_table("posterior", |table| Posterior::read(table, kind, &robot))?;
        let path = path.to_owned();
        Ok(Self {
            path,
            robot,
            robot_path,
            process,
            process_path,
            effects,
            known,
            accuracy,
            posterior,
        })
    }

    /// Digest of all that a posterior belongs to, itself with it: SHA-256, hexadecimal. Where files
    /// lie is not in it.
    ///
    /// # Errors
    /// A file that the model names and that cannot be read.
    pub fn seal(&self) -> Result<String, InputError> {
        let mut text = String::new();
        for path in std::iter::once(&self.robot_path).chain(&self.process_path) {
            let _ = writeln!(text, "{:x?}", hash_of_file(path)?);
        }
        for effect in &self.effects {
            self.write_effect(&mut text, effect, &EffectComments::default());
        }
        self.known.iter().for_each(|known| self.write_known(&mut text, known));
        self.write_accuracy(&mut text);
        if let Some(posterior) = &self.posterior {
            self.write_posterior(&mut text, posterior, "");
        }
        Ok(hexadecimal(&Sha256::digest(text)))
    }

    /// This model with a posterior, sealed.
    ///
    /// # Errors
    /// As [`ModelFile::seal`].
    pub fn with_posterior(self, posterior: Posterior) -> Result<Self, InputError> {
        let mut model = Self { posterior: Some(posterior), ..self };
        let seal = model.seal()?;
        model.posterior.iter_mut().for_each(|posterior| posterior.seal.clone_from(&seal));
        Ok(model)
    }

    /// Whether the posterior is of this robot, this process and these effects, as it was written;
    /// true where there is none.
    ///
    /// # Errors
    /// As [`ModelFile::seal`].
    pub fn is_sealed(&self) -> Result<bool, InputError> {
        Ok(match &self.posterior {
            Some(posterior) => self.seal()? == posterior.seal,
            None => true,
        })
    }

    /// The effects with the values written in the file, those of one log as well.
    pub fn cell_effects(&self) -> Vec<Effect> {
        self.effects.iter().map(|e| e.effect.clone()).collect()
    }
}

/// The file that a key names, from the folder of the model file.
fn named_file(root: &TomlTable<'_>, key: &str, model: &Path) -> Result<PathBuf, InputError> {
    let path = model.parent().unwrap_or(Path::new("")).join(root.name(key)?);
    if path.is_file() {
        return Ok(path);
    }
    let expected = format!(
        "the path of a {key} file, from this file's folder (there is no {})",
        path.display()
    );
    Err(root.wrong(key, &expected, "Paths in a file start from the folder of that file."))
}

impl ModelEffect {
    /// Reads an `[[effect]]` table.
    ///
    /// # Errors
    /// What does not fit, with its place.
    pub fn read(table: &TomlTable<'_>, robot: &RobotFile) -> Result<Self, InputError> {
        effect(table, robot)
    }
}

fn effect(table: &TomlTable<'_>, robot: &RobotFile) -> Result<ModelEffect, InputError> {
    let id = table.name("id")?;
    let table = &table.clone().called(&id);
    let scope = scope(table)?;
    let (kind, at, values) = match effects::EffectKind::of(&id) {
        Some(kind) => {
            let names = kind.parameters.iter().map(|p| p.name);
            table.only(&["id", "at", "scope"].into_iter().chain(names).collect::<Vec<_>>())?;
            let at = place(table, kind, robot)?;
            (
                kind,
                at,
                library_values(table, kind, scope, |k| {
                    kind.range(k, at, robot.robot.parameters())
                })?,
            )
        }
        None if table.has("port") || table.has("expression") => {
            let (kind, values) = own(table, id, scope)?;
            (kind, place(table, kind, robot)?, values)
        }
        None => {
            let guess =
                nearest(&id, library().map(|k| k.id)).map(|n| format!("Did you mean `{n}`? "));
            let known = library().map(|k| k.id).collect::<Vec<_>>().join(", ");
            let help = format!(
                "{}An effect of your own has `port` and `expression` (docs/your-own-effect.md).",
                guess.unwrap_or_default()
            );
            return Err(table.wrong(
                "id",
                &format!("an effect of the library, one of {known}"),
                help,
            ));
        }
    };
    Ok(ModelEffect { effect: Effect { kind, at, values }, scope })
}

fn scope(table: &TomlTable<'_>) -> Result<Scope, InputError> {
    if !table.has("scope") {
        return Ok(Scope::Campaign);
    }
    match table.text("scope")?.text {
        "campaign" => Ok(Scope::Campaign),
        "log" => Ok(Scope::Log),
        _ => {
            let help =
                "One set of values for the whole campaign, or one for each log, fitted to it.";
            Err(table.wrong("scope", "\"campaign\" or \"log\"", help))
        }
    }
}

fn library_values(
    table: &TomlTable<'_>,
    kind: &effects::EffectKind,
    scope: Scope,
    range: impl Fn(usize) -> [f64; 2],
) -> Result<Vec<f64>, InputError> {
    let value = |(k, p): (usize, &effects::Parameter)| {
        let [low, high] = range(k);
        let bounds = if p.role == Role::Phase { Bounds::Any } else { Bounds::Between(low, high) };
        value_or_start(table, p.name, scope, p.neutral(), bounds)
    };
    kind.parameters.iter().enumerate().map(value).collect()
}

/// A parameter's value; where each log has its own, it may be left to where a fit starts.
fn value_or_start(
    table: &TomlTable<'_>,
    key: &str,
    scope: Scope,
    start: f64,
    range: Bounds<'_>,
) -> Result<f64, InputError> {
    match scope {
        Scope::Log => table.number_or(key, range, start),
        Scope::Campaign => table.number(key, range),
    }
}

/// An effect of the user's own.
fn own(
    table: &TomlTable<'_>,
    id: String,
    scope: Scope,
) -> Result<(&'static effects::EffectKind, Vec<f64>), InputError> {
    let known = ["id", "at", "scope", "port", "unit", "expression", "shows", "parameters", "table"];
    table.only(&known)?;
    let port = port(table)?;
    let text = table.text("expression")?;
    let mut parameters = Vec::new();
    let mut values = Vec::new();
    if table.has("parameters") {
        let all = table.table("parameters")?;
        for name in all.keys() {
            let (parameter, value) = own_parameter(&all.table(name)?, name, port, scope)?;
            parameters.push(parameter);
            values.push(value);
        }
        if parameters.len() > MOST_PARAMETERS {
            let message = format!(
                "has {} entries; expected at most {MOST_PARAMETERS} parameters",
                parameters.len()
            );
            return Err(
                all.error(&message, "Split the effect into two at the same port: they add up.")
            );
        }
    }
    let mut of_table = None;
    if table.has("table") {
        let of = table.table("table")?;
        let taken =
            parameters.iter().find(|p: &&CustomParameter| DefinedTable::needs_name(&p.name));
        if let Some(taken) = taken {
            let message =
                format!("stands beside a parameter `{}`; expected another name", taken.name);
            return Err(
                of.error(&message, "`table` reads the table, and `y1`, `y2`, … are its values.")
            );
        }
        let (defined, values_of_table, own) = own_table(&of, port)?;
        parameters.extend(own);
        values.extend(values_of_table);
        of_table = Some(defined);
    }
    let shows = table
        .optional("shows", TomlTable::name)?
        .unwrap_or_else(|| format!("whatever {} makes of {}", port.meaning, text.text.trim()));
    let expression = text.text.to_owned();
    let definition = Definition { id, port, expression, shows, parameters, table: of_table };
    let kind = definition
        .kind(&values)
        .map_err(|m| table.error_in_text("expression", m.at, &m.message, m.help))?;
    Ok((kind, values))
}

fn port(table: &TomlTable<'_>) -> Result<&'static NamedPort, InputError> {
    let name = table.text("port")?.text;
    let Some(port) = PORTS.iter().find(|p| p.name == name) else {
        let guess =
            nearest(name, PORTS.iter().map(|p| p.name)).map(|n| format!("Did you mean `{n}`?"));
        let known = PORTS.iter().map(|p| p.name).collect::<Vec<_>>().join(", ");
        let help = guess
            .unwrap_or_else(|| "Each port is described in docs/your-own-effect.md.".to_owned());
        return Err(table.wrong("port", &format!("one of the ports {known}"), help));
    };
    if table.has("unit") && table.text("unit")?.text != port.unit {
        let help = format!(
            "The value of an expression at {} is {} in {}.",
            port.name, port.meaning, port.unit
        );
        return Err(table.wrong(
            "unit",
            &format!("{:?}, the unit of {}", port.unit, port.name),
            help,
        ));
    }
    Ok(port)
}

/// Range of a value of a table that states none, in the steps at which slopes are taken.
const TABLE_VALUE_RANGE: f64 = 1e3;

/// The places of a table over one variable.
fn rising(table: &TomlTable<'_>, key: &str) -> Result<Vec<f64>, InputError> {
    let places = table.list(key, TABLE_PLACES_MAX, Bounds::Any)?;
    if places.len() < 2 || !places.is_sorted_by(|a, b| a < b) {
        let help = "The places between which the table's values are joined by straight lines.";
        return Err(table.wrong(key, "two numbers or more, each above the one before", help));
    }
    Ok(places)
}

/// A table of an effect of the user's own: places, values there, and these as parameters.
fn own_table(
    table: &TomlTable<'_>,
    port: &NamedPort,
) -> Result<(DefinedTable, Vec<f64>, Vec<CustomParameter>), InputError> {
    table.only(&["x", "across", "y", "bend", "step", "low", "high"])?;
    let x = rising(table, "x")?;
    let across = table.optional("across", rising)?.unwrap_or_default();
    let places = Places { x, across };
    let count = places.count();
    if count > TABLE_PLACES_MAX {
        let expected = format!("places that make at most {TABLE_PLACES_MAX} values with `x`");
        let help =
            "A table over two variables has a value for each place of one at each of the other.";
        return Err(table.wrong("across", &expected, help));
    }
    let step = table.number_or("step", Bounds::Positive, port.small())?;
    let y = table.list("y", TABLE_PLACES_MAX, Bounds::Any)?;
    if y.len() != count {
        let (expected, help) = match places.across.is_empty() {
            true => ("as many as in `x`", "One value for each place in `x`."),
            false => (
                "as many as in `x` for each place in `across`",
                "Those at all places in `x` for the first place in `across`, then for the next.",
            ),
        };
        return Err(table.wrong("y", &format!("{count} numbers, {expected}"), help));
    }
    let far = y.iter().fold(TABLE_VALUE_RANGE * step, |far, y| far.max(10.0 * y.abs()));
    let low = table.number_or("low", Bounds::Any, -far)?;
    let high = table.number_or("high", Bounds::Any, far)?;
    if low >= high {
        return Err(table.wrong("high", "a number above `low`", "They bound what is plausible."));
    }
    // Each of them within what is plausible.
    table.list("y", TABLE_PLACES_MAX, Bounds::Between(low, high))?;
    let bend = table.number_or("bend", Bounds::Positive, f64::INFINITY)?;
    let defined = DefinedTable { places, bend };
    let parameters = CustomParameter::of_table(&defined, port.unit, step, [low, high]);
    Ok((defined, y, parameters))
}

fn own_parameter(
    table: &TomlTable<'_>,
    name: &str,
    port: &NamedPort,
    scope: Scope,
) -> Result<(CustomParameter, f64), InputError> {
    table.only(&["value", "unit", "meaning", "low", "high", "step", "shape"])?;
    if !CustomParameter::may_be_named(name, port) {
        let message = "is no name for a parameter; expected letters, digits and underscores, no function and no \
                       variable of this port";
        return Err(
            table.error(message, "Give the parameter another name, here and in the expression.")
        );
    }
    let (low, high) = (table.number("low", Bounds::Any)?, table.number("high", Bounds::Any)?);
    if low >= high {
        return Err(table.wrong("high", "a number above `low`", "They bound what is plausible."));
    }
    let role = match (table.has("step"), table.has("shape")) {
        (true, false) => CustomRole::Size(table.number("step", Bounds::Positive)?),
        (step, true) => {
            let starts = table.list("shape", MOST_PARAMETERS, Bounds::Between(low, high))?;
            if starts.is_empty() {
                return Err(table.wrong(
                    "shape",
                    "at least one value to start a fit from",
                    "Take plausible values.",
                ));
            }
            match step {
                true => CustomRole::Position(table.number("step", Bounds::Positive)?, starts),
                false => CustomRole::Shape(starts),
            }
        }
        _ => {
            let help = "`step`: a small value, where the effect grows from nothing with this parameter. `shape`: a list of \
                        values that a fit may start from, where the parameter shapes the effect; with a `step` as well \
                        where it may pass through zero.";
            return Err(
                table.error("has neither `step` nor `shape`; expected one of them, or both", help)
            );
        }
    };
    let start = match &role {
        CustomRole::Shape(starts) | CustomRole::Position(_, starts) => starts[0],
        CustomRole::Size(_) => 0.0,
    };
    let value = value_or_start(table, "value", scope, start, Bounds::Between(low, high))?;
    let parameter = CustomParameter {
        name: name.to_owned(),
        unit: table.name("unit")?,
        meaning: table.optional("meaning", TomlTable::name)?.unwrap_or_else(|| name.to_owned()),
        role,
        low,
        high,
    };
    Ok((parameter, value))
}
