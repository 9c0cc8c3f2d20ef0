//! The physical effects a cell may have beyond the baseline: one file each, and the table of them.
//!
//! An effect is a term at one named port of the plant ([`Port`]). Its file holds the equation, the parameters with units and
//! plausible ranges, what it looks like in data, and the term; adding one touches that file and one line of [`TABLE`].

mod backlash;
mod joint_friction;

use crate::input::RobotFile;
use crate::robot::{Port, Ports, Term, TooManyStates};

/// Every effect of the library.
pub static TABLE: &[&Kind] = &[&backlash::KIND, &joint_friction::KIND];

/// What an effect may be attached to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// One joint, by its name in the robot file.
    Joint,
    /// The cell as a whole: `at` is empty.
    Cell,
}

/// One parameter of an effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Name, with its unit as the last part.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub meaning: &'static str,
    /// Smallest plausible value.
    pub low: f64,
    /// Largest plausible value.
    pub high: f64,
}

/// One physical effect of the library.
#[derive(Debug)]
pub struct Kind {
    /// Identifier, as in files and on the command line.
    pub id: &'static str,
    /// What it may be attached to.
    pub place: Place,
    /// Its equation.
    pub equation: &'static str,
    /// What it looks like in data.
    pub shows: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// Its port, for the joint it is at (0 for an effect of the whole cell).
    pub port: fn(joint: usize) -> Port,
    /// Builds the term from the parameters' values, in the order of [`parameters`](Self::parameters).
    pub build: fn(values: &[f64]) -> Box<dyn Term>,
}

/// One effect of a cell: a kind, where it is, and the values of its parameters.
#[derive(Debug, Clone)]
pub struct Effect {
    /// Which effect.
    pub kind: &'static Kind,
    /// Joint index (0 = A1); `None` for an effect of the whole cell.
    pub joint: Option<usize>,
    /// Values, in the order of the kind's parameters, SI units.
    pub values: Vec<f64>,
}

/// An effect that cannot be understood or installed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// Not `ID:AT:NAME=VALUE,…`.
    #[error("`{read}` is not an effect: expected ID:AT:NAME=VALUE,… such as backlash:A5:half_gap_rad=2e-4")]
    Form {
        /// What was read.
        read: String,
    },
    /// No such effect.
    #[error("no effect `{read}` in the library: expected one of {known}")]
    Unknown {
        /// What was read.
        read: String,
        /// The library's identifiers.
        known: String,
    },
    /// Attached to something that is not there.
    #[error("{id} cannot be at `{read}`: expected {expected}")]
    Place {
        /// The effect.
        id: &'static str,
        /// What was read.
        read: String,
        /// What would do.
        expected: String,
    },
    /// A parameter is missing, unknown, given twice, not a number, or far out of its range.
    #[error("{id}: {what}; its parameters are {expected}")]
    Parameter {
        /// The effect.
        id: &'static str,
        /// What is wrong.
        what: String,
        /// The parameters with units and ranges.
        expected: String,
    },
    /// More effects with an internal state than there is room for.
    #[error(transparent)]
    TooManyStates(#[from] TooManyStates),
}

impl Kind {
    fn parameters_in_words(&self) -> String {
        let one = |p: &Parameter| format!("{} ({}, plausible {:e} to {:e})", p.name, p.unit, p.low, p.high);
        self.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    fn wrong(&self, what: String) -> EffectError {
        EffectError::Parameter { id: self.id, what, expected: self.parameters_in_words() }
    }
}

impl Effect {
    /// Reads an effect from a command line, `ID:AT:NAME=VALUE,…`; AT is a joint's name, or empty for an effect of the
    /// whole cell.
    ///
    /// # Errors
    /// [`EffectError`], with what was read and what was expected. A value outside the plausible range is accepted: the
    /// user may want to see it.
    pub fn parse(text: &str, robot: &RobotFile) -> Result<Self, EffectError> {
        let form = || EffectError::Form { read: text.to_owned() };
        let mut parts = text.splitn(3, ':');
        let (Some(id), Some(at), Some(values)) = (parts.next(), parts.next(), parts.next()) else {
            return Err(form());
        };
        let kind = *TABLE.iter().find(|k| k.id == id).ok_or_else(|| EffectError::Unknown {
            read: id.to_owned(),
            known: TABLE.iter().map(|k| k.id).collect::<Vec<_>>().join(", "),
        })?;
        let place = |expected: String| EffectError::Place { id: kind.id, read: at.to_owned(), expected };
        let joint = match kind.place {
            Place::Joint => {
                let found = robot.joint_names.iter().position(|n| n == at);
                Some(found.ok_or_else(|| place(format!("one of the joints {}", robot.joint_names.join(", "))))?)
            }
            Place::Cell if at.is_empty() => None,
            Place::Cell => return Err(place("nothing, as in ID::NAME=VALUE".to_owned())),
        };
        let mut found = vec![None; kind.parameters.len()];
        for pair in values.split(',') {
            let (name, value) = pair.split_once('=').ok_or_else(form)?;
            let index = kind
                .parameters
                .iter()
                .position(|p| p.name == name)
                .ok_or_else(|| kind.wrong(format!("no parameter `{name}`")))?;
            let number: f64 = value.parse().map_err(|_| kind.wrong(format!("`{value}` is not a number")))?;
            if !number.is_finite() {
                return Err(kind.wrong(format!("{name} = {value} is not finite")));
            }
            if found[index].replace(number).is_some() {
                return Err(kind.wrong(format!("{name} is given twice")));
            }
        }
        let missing =
            |(value, p): (Option<f64>, &Parameter)| value.ok_or_else(|| kind.wrong(format!("{} is missing", p.name)));
        let values = found.into_iter().zip(kind.parameters).map(missing).collect::<Result<_, _>>()?;
        Ok(Self { kind, joint, values })
    }

    /// Puts the effect's term at its port.
    ///
    /// # Errors
    /// [`EffectError::TooManyStates`].
    pub fn install(&self, ports: &mut Ports) -> Result<(), EffectError> {
        ports.install((self.kind.port)(self.joint.unwrap_or(0)), (self.kind.build)(&self.values))?;
        Ok(())
    }
}
