//! What an effect is: its place, its parameters, how it acts, and all that other rooms ask of it.
//!
//! Nothing here knows a particular effect.

use super::curve::Curve;
use super::draw::Draw;
use super::formula::Formula;
use super::location::{INSTRUMENT_NAMES, Location, LocationKind};
use super::parameter::{Parameter, Role};
use crate::input::{Process, RobotFile, did_you_mean};
use crate::process::ProcessPart;
use crate::robot::{Channel, JointState, Port, Ports, Term, TooManyStates, mount, remembers};
use trueweld_core::{JOINTS, ModelError, Pose, Robot, RobotParameters};

/// How an effect acts, given the values of its parameters.
#[derive(Debug, Clone, Copy)]
pub enum Action {
    /// Not stated: such an effect cannot join the library.
    Unstated,
    /// A term at a port, for the joint it is at (0 for an effect of the whole cell).
    Term {
        /// The port.
        port: fn(joint: usize) -> Port,
        /// The term.
        build: fn(values: &[f64], joint: usize) -> Box<dyn Term>,
    },
    /// An extra torque on the link of the joint it is at, N·m.
    LinkTorque(LinkTorque),
    /// A term at the time base, for the instrument it is at.
    Channel(fn(values: &[f64], channel: Channel) -> Box<dyn Term>),
    /// Other numbers of the robot.
    Robot(fn(robot: &mut RobotParameters<f64>, joint: usize, values: &[f64])),
    /// The link behind the joint is mounted off by a small rigid motion p' = R p + t, in its frame.
    Mounting(fn(values: &[f64]) -> Pose<f64>),
    /// Other numbers of the process.
    Process(fn(process: &mut Process, values: &[f64])),
    /// A term at the port that the formula names: an effect of the user's own.
    Expression(&'static Formula),
}

/// Torque on a link, N·m, by the values of an effect's parameters.
pub(crate) type LinkTorque = fn(values: &[f64], at: &JointState) -> f64;

/// A torque on a link with its values.
#[derive(Debug)]
struct LinkTerm {
    values: Vec<f64>,
    torque: LinkTorque,
}

impl Term for LinkTerm {
    fn link_torque(&self, at: &JointState, _counterbalance: f64) -> f64 {
        (self.torque)(&self.values, at)
    }
}

/// One physical effect of the library.
#[derive(Debug)]
pub struct EffectKind {
    /// Identifier, as in files and on the command line.
    pub id: &'static str,
    /// What it may be attached to.
    pub place: LocationKind,
    /// Its equation.
    pub equation: &'static str,
    /// What it looks like in data.
    pub shows: &'static str,
    /// Which experiment shows it best.
    pub experiment: &'static str,
    /// Its parameters.
    pub parameters: &'static [Parameter],
    /// How it acts.
    pub action: Action,
    /// What it acts on, of a process; `None` where any process has it, or it is not of the process.
    pub acts_on: Option<ProcessPart>,
    /// What is said where it was found: a template, without capital and full stop. Empty: its
    /// identifier and its values.
    ///
    /// | in braces | stands for |
    /// |---|---|
    /// | `{joint}`, `{before}`, `{instrument}` | name of the joint, of the joint before, of the instrument |
    /// | `{0}`, `{\|0\|}` | value of the first parameter with its interval; the same without its sign |
    /// | `{0?more\|less}` | the first word, or the second where the value is below 0 |
    /// | `{plain 0}` | the value without its interval |
    /// | `{norm 0}` | length of the vector that the first three parameters are |
    /// | `{0#}` | the value with two decimals and no unit |
    pub sentence: &'static str,
    /// The curve that shows it.
    pub curve: Curve,
    /// What is known of it beforehand, for what may be a little off in any cell without anything
    /// being missing from the model.
    pub calibration: Option<Calibration>,
    /// Where and how large a simulated campaign hides it; `None` where none does.
    pub drawn: Option<DrawEffect>,
    /// The robot's own numbers that the parameters add to, in their order, for the joint it is at;
    /// `None` where they stand alone.
    pub adds_to: Option<OwnNumbers>,
    /// The effect that says the same in other numbers, which is not free beside this one.
    pub stands_for: Option<&'static EffectKind>,
    /// True for what only a drive has that its file states to be rigid.
    pub of_rigid: bool,
}

/// The numbers of a robot's own that an effect's parameters add to, of the joint from 0.
pub(crate) type OwnNumbers = fn(robot: &RobotParameters<f64>, joint: usize) -> Vec<f64>;

/// Draws a place and values of an effect for a simulated campaign.
pub(crate) type DrawEffect = fn(&mut Draw<'_>) -> (Location, Vec<f64>);

/// What is known beforehand of an effect that is a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Calibration {
    /// Expected size of each parameter, one standard deviation, in the parameter's unit.
    pub expected: &'static [f64],
    /// Which logs share a value.
    pub scope: CalibrationScope,
}

/// Which logs share the values of a calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum CalibrationScope {
    /// All logs of a campaign, where a tracker saw the tool in several postures. What sits on the
    /// last joint is the tool, which may be mounted anew for another log.
    Postures,
    /// All logs.
    AllLogs {
        /// True where only a log of an arm that moves shows it.
        motion: bool,
    },
    /// Each log has its own, where it has a channel of one of these instruments.
    EachLog(&'static [Channel]),
    /// All logs, where a torque of the joint is recorded in a unit whose factor no file states. The
    /// first value is the factor that was found beforehand, which the others correct.
    OpenFactor,
    /// All logs, where such a factor was found: what it was found by, and is only known as well as.
    BesideOpenFactor,
    /// All logs of an arm that moves, at joints whose rotor inertia the robot file does not know.
    UnknownRotor,
}

impl Calibration {
    /// The instruments that show the value a log has of its own, at a place where it has one: a log
    /// of another day is no further off than the instrument was zeroed, the tracker registered, or
    /// the tool mounted anew. `None` where the value is the cell's.
    pub fn renewed(&self, at: Location) -> Option<&'static [Channel]> {
        match self.scope {
            CalibrationScope::EachLog(channels) => Some(channels),
            CalibrationScope::Postures if at == Location::Joint(JOINTS - 1) => {
                Some(&[Channel::Tracker])
            }
            CalibrationScope::Postures
            | CalibrationScope::AllLogs { .. }
            | CalibrationScope::OpenFactor
            | CalibrationScope::BesideOpenFactor
            | CalibrationScope::UnknownRotor => None,
        }
    }
}

/// One effect of a cell: a kind, where it is, and the values of its parameters.
#[derive(Debug, Clone)]
pub struct Effect {
    /// Which effect.
    pub kind: &'static EffectKind,
    /// Where it is.
    pub at: Location,
    /// Values, in the order of the kind's parameters, SI units.
    pub values: Vec<f64>,
}

/// Which effect, and where, whatever its values.
#[derive(Debug, Clone, Copy)]
pub struct EffectPlace {
    /// Which effect.
    pub kind: &'static EffectKind,
    /// Where it is.
    pub at: Location,
}

impl PartialEq for EffectPlace {
    fn eq(&self, other: &Self) -> bool {
        (self.kind.id, self.at) == (other.kind.id, other.at)
    }
}

impl EffectPlace {
    /// Its kind with its place, such as `backlash at A5`.
    pub fn name(&self, robot: &RobotFile) -> String {
        match self.at.name(robot) {
            "" => self.kind.id.to_owned(),
            at => format!("{} at {at}", self.kind.id),
        }
    }
}

/// An effect that cannot be understood or installed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum EffectError {
    /// Not `ID:AT:NAME=VALUE,…`.
    #[error(
        "`{read}` is not an effect: expected ID:AT:NAME=VALUE,… such as backlash:A5:half_gap_rad=2e-4"
    )]
    Form {
        /// What was read.
        read: String,
    },
    /// No such effect.
    #[error("no effect `{read}` in the library{guess}: expected one of {known}")]
    Unknown {
        /// What was read.
        read: String,
        /// The one it resembles, as a question, or nothing.
        guess: String,
        /// The library's identifiers.
        known: String,
    },
    /// Attached to something that is not there.
    #[error("{id} cannot be at `{read}`: expected {expected}")]
    LocationKind {
        /// The effect.
        id: &'static str,
        /// What was read.
        read: String,
        /// What would do.
        expected: String,
    },
    /// A parameter is missing, unknown, given twice, not a number, or outside its range.
    #[error("{id}: {what}; its parameters are {expected}")]
    Parameter {
        /// The effect.
        id: &'static str,
        /// What is wrong.
        what: String,
        /// The parameters with units and ranges.
        expected: String,
    },
    /// An effect that means nothing for the process.
    #[error("{id} acts on {part}, which {process} does not have")]
    NotOfProcess {
        /// The effect.
        id: &'static str,
        /// What it acts on, in words.
        part: String,
        /// The process.
        process: &'static str,
    },
    /// More effects with an internal state than there is room for.
    #[error(transparent)]
    TooManyStates(#[from] TooManyStates),
    /// The robot with the effect is no robot.
    #[error("{id} with these values leaves no possible robot ({reason:?})")]
    Model {
        /// The effect.
        id: &'static str,
        /// Why.
        reason: ModelError,
    },
}

impl EffectKind {
    /// An effect of the whole cell that is shown by the column that it improves most and is hidden
    /// in no campaign. Identifier and action are yet to be stated, and whatever else is different.
    pub const DEFAULT: Self = Self {
        id: "",
        place: LocationKind::Cell,
        equation: "",
        shows: "",
        experiment: "",
        parameters: &[],
        action: Action::Unstated,
        acts_on: None,
        sentence: "",
        curve: Curve::Column,
        calibration: None,
        drawn: None,
        adds_to: None,
        stands_for: None,
        of_rigid: false,
    };

    /// Every place that it may be at.
    pub fn places(&self) -> Vec<Location> {
        match self.place {
            LocationKind::Joint => (0..JOINTS).map(Location::Joint).collect(),
            LocationKind::Channel => {
                INSTRUMENT_NAMES.map(|(_, channel)| Location::Channel(channel)).to_vec()
            }
            LocationKind::Cell => vec![Location::Cell],
        }
    }

    /// Least and largest value of a parameter at a place: those of the parameter, and where it adds
    /// to a number of the robot's own, from nothing of that number to twice as much.
    pub fn range(&self, parameter: usize, at: Location, robot: &RobotParameters<f64>) -> [f64; 2] {
        let of = &self.parameters[parameter];
        if of.role == Role::Phase {
            return [f64::NEG_INFINITY, f64::INFINITY];
        }
        let own = self.own(parameter, at, robot).map_or(0.0, f64::abs);
        [of.low.min(-own), of.high.max(own)]
    }

    /// True for an effect that only a cell has whose files leave it open: a current's factor, a rotor's
    /// inertia, a drive that is called rigid.
    pub fn is_of_open_file(&self) -> bool {
        use CalibrationScope::{BesideOpenFactor, OpenFactor, UnknownRotor};
        let scope = self.calibration.map(|calibration| calibration.scope);
        self.of_rigid || matches!(scope, Some(OpenFactor | BesideOpenFactor | UnknownRotor))
    }

    /// True for an effect that is other numbers of a joint's spring and damper, or a term of its torque.
    pub fn is_of_spring(&self, joint: usize, robot: &RobotParameters<f64>) -> bool {
        match self.action {
            Action::Term { port, .. } => port(joint) == Port::SpringTorque(joint),
            Action::Robot(change) => {
                let mut changed = robot.clone();
                let values: Vec<f64> = self.parameters.iter().map(|p| 0.5 * p.high).collect();
                change(&mut changed, joint, &values);
                let drive = |of: &RobotParameters<f64>| {
                    (of.joints[joint].stiffness, of.joints[joint].damping)
                };
                drive(&changed) != drive(robot)
            }
            _ => false,
        }
    }

    /// The robot's own number that a parameter adds to; `None` where it stands alone.
    pub fn own(&self, parameter: usize, at: Location, robot: &RobotParameters<f64>) -> Option<f64> {
        let joint = if let Location::Joint(joint) = at { joint } else { 0 };
        self.adds_to.map(|own| own(robot, joint)[parameter])
    }

    /// The effect without effect: every size at its neutral value.
    pub fn neutral(&'static self, at: Location) -> Effect {
        Effect { kind: self, at, values: self.parameters.iter().map(Parameter::neutral).collect() }
    }

    /// What such an effect is attached to, from how files and command lines write it; nothing is
    /// for the whole cell.
    ///
    /// # Errors
    /// [`EffectError::LocationKind`].
    pub fn at(&self, written: &str, robot: &RobotFile) -> Result<Location, EffectError> {
        let wrong = |expected| EffectError::LocationKind {
            id: self.id,
            read: written.to_owned(),
            expected,
        };
        match self.place {
            LocationKind::Joint => {
                let found = robot.joint_names.iter().position(|n| n == written);
                let joints =
                    || wrong(format!("one of the joints {}", robot.joint_names.join(", ")));
                found.map(Location::Joint).ok_or_else(joints)
            }
            LocationKind::Channel => {
                let found = INSTRUMENT_NAMES.iter().find(|(name, _)| *name == written);
                let names = || {
                    let names = INSTRUMENT_NAMES.map(|(name, _)| name);
                    let guess = did_you_mean(written, names);
                    wrong(format!("one of the channels {}{guess}", names.join(", ")))
                };
                found.map(|(_, channel)| Location::Channel(*channel)).ok_or_else(names)
            }
            LocationKind::Cell if written.is_empty() => Ok(Location::Cell),
            LocationKind::Cell => {
                Err(wrong("nothing: it is an effect of the whole cell".to_owned()))
            }
        }
    }

    fn parameters_in_words(&self) -> String {
        let one =
            |p: &Parameter| format!("{} ({}, from {:e} to {:e})", p.name, p.unit, p.low, p.high);
        self.parameters.iter().map(one).collect::<Vec<_>>().join(", ")
    }

    pub(super) fn wrong(&self, what: String) -> EffectError {
        EffectError::Parameter { id: self.id, what, expected: self.parameters_in_words() }
    }
}

impl Effect {
    /// The port it is installed at; `None` for other numbers of robot or process.
    pub fn port(&self) -> Option<Port> {
        let joint = if let Location::Joint(joint) = self.at { joint } else { 0 };
        match self.kind.action {
            Action::Term { port, .. } => Some(port(joint)),
            Action::LinkTorque(_) => Some(Port::LinkTorque(joint)),
            Action::Expression(formula) => Some(formula.port(joint)),
            Action::Channel(_) => Some(Port::TimeBase),
            Action::Robot(_) | Action::Mounting(_) | Action::Process(_) | Action::Unstated => None,
        }
    }

    /// True where what it does depends on the way that the joint has come.
    pub fn remembers(&self) -> bool {
        let joint = if let Location::Joint(joint) = self.at { joint } else { 0 };
        match self.kind.action {
            Action::Term { build, .. } => remembers(build(&self.values, joint).as_ref()),
            Action::Expression(formula) => remembers(formula.term(&self.values, joint).1.as_ref()),
            _ => false,
        }
    }

    /// Which effect it is, and where.
    pub fn place(&self) -> EffectPlace {
        EffectPlace { kind: self.kind, at: self.at }
    }

    /// Its kind with its place, such as `backlash at A5`.
    pub fn name(&self, robot: &RobotFile) -> String {
        self.place().name(robot)
    }

    /// One of its parameters with its kind and place, such as `backlash at A5: half_gap_rad`.
    pub fn number_name(&self, parameter: usize, robot: &RobotFile) -> String {
        format!("{}: {}", self.name(robot), self.kind.parameters[parameter].name)
    }

    /// True where it is other numbers of the robot: what a controller's model can hold. Everything else
    /// acts at a port of the plant, on the process or on an instrument.
    pub fn is_of_robot_model(&self) -> bool {
        matches!(self.kind.action, Action::Robot(_) | Action::Mounting(_))
    }

    /// Puts the effect into the making of a cell: a term at its port, or other numbers of the robot
    /// (`robot` holds them once they differ from `model`'s) or of the process.
    ///
    /// # Errors
    /// [`EffectError::TooManyStates`], [`EffectError::NotOfProcess`].
    pub(crate) fn apply(
        &self,
        model: &Robot<f64>,
        robot: &mut Option<RobotParameters<f64>>,
        process: Option<&mut Process>,
        ports: &mut Ports,
    ) -> Result<(), EffectError> {
        let joint = if let Location::Joint(joint) = self.at { joint } else { 0 };
        if let (Some(part), Some(process)) = (self.kind.acts_on, &process)
            && !process.kind().has(part)
        {
            let (id, part, process) = (self.kind.id, part.describe(), process.kind().name);
            return Err(EffectError::NotOfProcess { id, part, process });
        }
        match (self.kind.action, self.at) {
            (Action::Term { port, build }, _) => {
                ports.install(port(joint), build(&self.values, joint))?
            }
            (Action::LinkTorque(torque), _) => {
                let term = LinkTerm { values: self.values.clone(), torque };
                ports.install(Port::LinkTorque(joint), Box::new(term))?;
            }
            (Action::Channel(build), Location::Channel(channel)) => {
                ports.install(Port::TimeBase, build(&self.values, channel))?;
            }
            // The table pairs this action with that place; `parse` gives no other.
            (Action::Channel(_) | Action::Unstated, _) => {}
            (Action::Robot(change), _) => {
                change(
                    robot.get_or_insert_with(|| model.parameters().clone()),
                    joint,
                    &self.values,
                );
            }
            (Action::Mounting(motion), _) => {
                let parameters = robot.get_or_insert_with(|| model.parameters().clone());
                mount(parameters, joint, &motion(&self.values));
            }
            (Action::Process(change), _) => {
                if let Some(process) = process {
                    change(process, &self.values);
                }
            }
            (Action::Expression(formula), _) => {
                let (port, term) = formula.term(&self.values, joint);
                ports.install(port, term)?;
            }
        }
        Ok(())
    }
}
