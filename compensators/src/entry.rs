//! Laws with their types erased: found by name, built from tables of gains.

use crate::gain::GainError;
use crate::law::{Law, Needs, Setup};
use crate::laws::{Visitor, for_each};
use crate::{Combined, CombinedGains};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::sync::{Arc, OnceLock};
use toml::Table;
use trueweld_core::compensation::{Compensator, Observation};
use trueweld_core::state::{StateResult, StateVisitor};
use trueweld_core::{Fault, Robot, Twist};

/// Between the names of two laws that are combined.
const AND: char = '+';

/// Gains by the name of the law. A law that is not in it has its defaults, and so has a gain that
/// is not in the law's table.
pub type GainTables = BTreeMap<String, Table>;

/// A law on the heap.
type Boxed = Box<dyn Compensator<f64> + Send>;

/// A law on the heap as what it is: part of another, or of a controller that owns it.
pub struct OwnedLaw(pub Box<dyn Compensator<f64> + Send>);

impl Compensator<f64> for OwnedLaw {
    fn reset(&mut self) {
        self.0.reset();
    }

    fn freeze(&mut self) {
        self.0.freeze();
    }

    fn demand(
        &mut self,
        robot: &Robot<f64>,
        observation: &Observation<'_, f64>,
    ) -> Result<Twist<f64>, Fault> {
        self.0.demand(robot, observation)
    }

    fn visit_state(&mut self, visitor: &mut dyn StateVisitor) -> StateResult {
        self.0.visit_state(visitor)
    }
}

/// A law of a list: a [`Law`] with its type erased, or two of them [`Combined`].
#[derive(Clone)]
pub struct Entry {
    name: Cow<'static, str>,
    summary: Cow<'static, str>,
    needs: Needs,
    pace: &'static [&'static str],
    recipe: LawRecipe,
}

#[derive(Clone)]
enum LawRecipe {
    Law { defaults: fn() -> Table, build: fn(Table, &Setup<f64>) -> Result<Boxed, Refusal> },
    Combined(Arc<[Entry; 2]>),
    Foreign(Arc<ForeignLaw>),
}

/// How a law is built that is written in another language.
type ForeignLaw = dyn Fn(&Setup<f64>) -> Result<Boxed, String> + Send + Sync;

/// Why a law is not built from a table.
enum Refusal {
    Gain(GainError),
    Table(toml::de::Error),
    Foreign(String),
}

/// Why a law cannot be built.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildError {
    /// Name of the law.
    pub law: String,
    /// The gain that is at fault, where it is one.
    pub key: Option<&'static str>,
    /// What was expected, or what is wrong with the table.
    pub problem: String,
}

impl fmt::Display for BuildError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "the law {} cannot be built: ", self.law)?;
        match self.key {
            Some(key) => write!(f, "`{key}` is out of range; expected {}", self.problem),
            None => f.write_str(&self.problem),
        }
    }
}

impl std::error::Error for BuildError {}

impl Entry {
    /// The entry of a law.
    pub fn of<L: Law<f64>>() -> Self {
        Self {
            name: L::NAME.into(),
            summary: L::SUMMARY.into(),
            needs: L::NEEDS,
            pace: L::BANDWIDTH_GAINS,
            recipe: LawRecipe::Law {
                defaults: || table(&L::Gains::default()),
                build: |gains, setup| {
                    let gains: L::Gains = gains.try_into().map_err(Refusal::Table)?;
                    Ok(Box::new(L::build(&gains, setup).map_err(Refusal::Gain)?))
                },
            },
        }
    }

    /// The entry of a law that is written in another language and has no gains in a control file.
    /// `build`: the law as it is before its first weld, or in words why there is none.
    pub fn foreign(
        name: String,
        summary: String,
        needs: Needs,
        build: impl Fn(&Setup<f64>) -> Result<Boxed, String> + Send + Sync + 'static,
    ) -> Self {
        Self {
            name: name.into(),
            summary: summary.into(),
            needs,
            pace: &[],
            recipe: LawRecipe::Foreign(Arc::new(build)),
        }
    }

    /// Two laws as one; see [`Combined`].
    fn combined(first: Self, second: Self) -> Self {
        Self {
            name: format!("{}{AND}{}", first.name, second.name).into(),
            summary: format!("{}, with {} beside it", first.name, second.name).into(),
            needs: Needs {
                force_sensor: first.needs.force_sensor || second.needs.force_sensor,
                motor_torque: first.needs.motor_torque || second.needs.motor_torque,
                seam_sensor: first.needs.seam_sensor || second.needs.seam_sensor,
                passes: first.needs.passes || second.needs.passes,
            },
            pace: &[],
            recipe: LawRecipe::Combined(Arc::new([first, second])),
        }
    }

    /// Its name on the command line, in control files and in results.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// What it does, in one line.
    pub fn summary(&self) -> &str {
        &self.summary
    }

    /// What it reads or keeps.
    pub fn needs(&self) -> Needs {
        self.needs
    }

    /// Those of its gains that set how fast it acts.
    pub fn pace(&self) -> &'static [&'static str] {
        self.pace
    }

    /// Its gains where a control file is silent.
    pub fn defaults(&self) -> Table {
        match &self.recipe {
            LawRecipe::Law { defaults, .. } => defaults(),
            LawRecipe::Combined(_) => table(&CombinedGains::default()),
            LawRecipe::Foreign(_) => Table::new(),
        }
    }

    /// Its gains: what its table of a control file says, and the defaults of the others.
    pub fn gains(&self, tables: &GainTables) -> Table {
        let mut gains = self.defaults();
        gains.extend(tables.get(self.name()).cloned().unwrap_or_default());
        gains
    }

    /// The law as it is before its first weld.
    ///
    /// # Errors
    /// [`BuildError`] where a gain is out of range or does not suit the control period.
    pub fn build(&self, gains: &GainTables, setup: &Setup<f64>) -> Result<Boxed, BuildError> {
        let own = self.gains(gains);
        let built = match &self.recipe {
            LawRecipe::Law { build, .. } => build(own, setup),
            LawRecipe::Combined(laws) => {
                let [first, second] = &**laws;
                let inner = [first.build(gains, setup)?, second.build(gains, setup)?];
                combine(inner.map(OwnedLaw), own, setup)
            }
            LawRecipe::Foreign(build) => build(setup).map_err(Refusal::Foreign),
        };
        built.map_err(|refusal| BuildError {
            law: self.name().to_owned(),
            key: if let Refusal::Gain(error) = &refusal { Some(error.key) } else { None },
            problem: match refusal {
                Refusal::Gain(error) => error.expected.to_owned(),
                Refusal::Table(error) => error.message().to_owned(),
                Refusal::Foreign(why) => why,
            },
        })
    }
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)
    }
}

fn combine(inner: [OwnedLaw; 2], own: Table, setup: &Setup<f64>) -> Result<Boxed, Refusal> {
    let [first, second] = inner;
    let gains: CombinedGains = own.try_into().map_err(Refusal::Table)?;
    let law = Combined::new(first, second, &gains, setup.period).map_err(Refusal::Gain)?;
    Ok(Box::new(law))
}

/// Gains as a file has them. Gains that are no table of TOML values have no keys.
fn table(gains: &impl serde::Serialize) -> Table {
    Table::try_from(gains).unwrap_or_default()
}

static LIBRARY: OnceLock<Vec<Entry>> = OnceLock::new();

/// The laws of the table.
fn of_table() -> Vec<Entry> {
    struct List(Vec<Entry>);
    impl Visitor<f64> for List {
        fn visit<L: Law<f64>>(&mut self) {
            self.0.push(Entry::of::<L>());
        }
    }
    let mut list = List(Vec::new());
    for_each(&mut list);
    list.0
}

/// All laws that this program knows: those of the table, then those that were installed.
pub fn library() -> &'static [Entry] {
    LIBRARY.get_or_init(of_table)
}

/// Why laws are not taken into the library.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LawInstallError {
    /// Not [`may_be_name`].
    Name(String),
    /// A name that another law has.
    Taken(String),
    /// The library was installed or used before.
    Late,
}

impl fmt::Display for LawInstallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Name(name) => write!(
                f,
                "a law is called {name:?}; expected lower-case letters, digits and hyphens"
            ),
            Self::Taken(name) => write!(f, "two laws are called {name:?}; expected another name"),
            Self::Late => f.write_str("laws must be installed once, before any is looked up"),
        }
    }
}

impl std::error::Error for LawInstallError {}

/// Whether a law may be called so: lower-case letters, digits and hyphens, beginning with a letter.
pub fn may_be_name(name: &str) -> bool {
    name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
}

/// Adds laws to the library of this program: once, before any law is looked up.
///
/// # Errors
/// [`LawInstallError`]; the library is then as it was.
pub fn install(own: Vec<Entry>) -> Result<(), LawInstallError> {
    let mut all = of_table();
    for entry in own {
        let name = entry.name();
        if !may_be_name(name) {
            return Err(LawInstallError::Name(name.to_owned()));
        }
        if all.iter().any(|law| law.name == entry.name) {
            return Err(LawInstallError::Taken(name.to_owned()));
        }
        all.push(entry);
    }
    LIBRARY.set(all).map_err(|_| LawInstallError::Late)
}

/// The law of a name, or the combination of laws with a plus between their names.
///
/// # Errors
/// The name, or the part of it, that no law has.
pub fn find(name: &str) -> Result<Entry, &str> {
    find_among(name, &[])
}

/// As [`find`], among `own` laws before those of the library.
///
/// # Errors
/// Those of [`find`].
pub fn find_among<'n>(name: &'n str, own: &[Entry]) -> Result<Entry, &'n str> {
    if let Some((first, second)) = name.rsplit_once(AND) {
        return Ok(Entry::combined(find_among(first, own)?, find_among(second, own)?));
    }
    own.iter().chain(library()).find(|law| law.name() == name).cloned().ok_or(name)
}
