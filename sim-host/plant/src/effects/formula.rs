//! Expressions at the ports of the plant: what a port offers to an expression, and the term that an
//! expression becomes.

use super::expression::{Expression, ExpressionMistake, may_be_named};
use super::location::LocationKind;
use super::memory::Loop;
use super::table::DefinedTable;
use crate::robot::{Channel, JointState, Port, ProcessPoint, Readings, Term, ValueDerivative};
use nalgebra::Vector3;

/// Most parameters of one effect.
pub(crate) const MOST_PARAMETERS: usize = 16;

/// Rate to either side over which the slope of friction is taken, rad/s: far below any over which
/// friction turns round, and far above rounding.
const RATE_DIFFERENCE: f64 = 1e-6;

/// A variable that expressions at a port may use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Variable {
    /// Its name in expressions.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Meaning.
    pub meaning: &'static str,
    /// Values it may well take; an expression must be finite there.
    probes: [f64; 3],
}

/// A port that an effect in a model file may act at.
#[derive(Debug, PartialEq)]
pub struct NamedPort {
    /// Its name in files.
    pub name: &'static str,
    /// Unit of the expression's value.
    pub unit: &'static str,
    /// What the value is.
    pub meaning: &'static str,
    /// What expressions may use there.
    pub variables: &'static [Variable],
    target: TermTarget,
}

/// What the value is added to; a number is the axis, 0 for x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum TermTarget {
    SpringTorque,
    Twist,
    MotorFriction,
    LinkTorque,
    ProcessForce(usize),
    SurfaceHeight,
    ToolShift(usize),
    Tracker(usize),
    ForceSensor(usize),
    LinkEncoder,
    MotorTorque,
}

const fn variable(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    probes: [f64; 3],
) -> Variable {
    Variable { name, unit, meaning, probes }
}

const fn joined<const N: usize>(first: &[Variable], second: &[Variable]) -> [Variable; N] {
    let mut all = [first[0]; N];
    let mut i = 0;
    while i < N {
        all[i] = if i < first.len() { first[i] } else { second[i - first.len()] };
        i += 1;
    }
    all
}

const TIME_VARIABLE: Variable = variable("time", "s", "from the start", [0.0, 1.0, 100.0]);
const ENCODER_VARIABLE: Variable =
    variable("encoder", "rad", "encoder angle of the joint", [0.0, 1.0, -1.0]);
const LINK: Variable = variable("link", "rad", "link angle of the joint", [0.0, 1.0, -1.0]);

/// In the order of [`joint_values`].
static JOINT: [Variable; 7] = [
    ENCODER_VARIABLE,
    variable("encoder_rate", "rad/s", "rate of the encoder", [0.0, 0.1, -0.1]),
    LINK,
    variable("link_rate", "rad/s", "rate of the link", [0.0, 0.1, -0.1]),
    variable("twist", "rad", "encoder less link", [0.0, 1e-3, -1e-3]),
    variable(
        "encoder_before",
        "rad",
        "encoder angle of the joint before, 0 for the first",
        [0.0, 1.0, -1.0],
    ),
    variable(
        "smoothing",
        "rad/s",
        "rate over which the robot's friction turns round",
        [1e-3, 1e-3, 1e-3],
    ),
];

fn joint_values(at: &JointState) -> [f64; 7] {
    [
        at.encoder,
        at.encoder_rate,
        at.link,
        at.link_rate,
        at.encoder - at.link,
        at.encoder_before,
        at.smoothing,
    ]
}

/// How fast a variable of a joint changes.
type VariableRate = fn(&JointState) -> f64;

/// The variables whose way a [`Loop`] may remember, and how they change.
const WAY_VARIABLES: [(&str, VariableRate); 3] = [
    ("encoder", |at| at.encoder_rate),
    ("link", |at| at.link_rate),
    ("twist", |at| at.encoder_rate - at.link_rate),
];

/// Those of a joint, then the load of its gear and the time.
static MOTOR_SIDE: [Variable; 9] = joined(
    &JOINT,
    &[
        variable("spring_torque", "N·m", "torque that the joint's gear carries", [0.0, 1e4, -1e4]),
        TIME_VARIABLE,
    ],
);

/// Those of a joint, then the counterbalance.
static LINK_SIDE: [Variable; 8] = joined(
    &JOINT,
    &[variable("counterbalance", "N·m", "its torque on this link, 0 but for A2", [0.0, 1e4, -1e4])],
);

/// In the order of [`surface_values`].
static SURFACE: [Variable; 9] = [
    TIME_VARIABLE,
    variable("x", "m", "tool along the seam, in W", [0.0, 0.1, 2.0]),
    variable("y", "m", "tool across the seam", [0.0, 1e-3, -1e-3]),
    variable("z", "m", "tool below the nominal surface", [0.0, 1e-3, -1e-3]),
    variable("vx", "m/s", "velocity along the seam", [0.0, 0.01, -0.01]),
    variable("vy", "m/s", "velocity across the seam", [0.0, 1e-3, -1e-3]),
    variable("vz", "m/s", "velocity into the plate", [0.0, 1e-3, -1e-3]),
    variable("spindle_angle", "rad", "spindle angle", [0.0, 1.0, 100.0]),
    variable("spindle", "rad/s", "spindle speed, signed", [0.0, 60.0, -60.0]),
];

fn surface_values(at: &ProcessPoint) -> [f64; 9] {
    let (p, v) = (&at.position, &at.velocity);
    [at.time, p.x, p.y, p.z, v.x, v.y, v.z, at.spindle_angle, at.spindle]
}

/// Those of the surface, then the forces; in the order of [`process_values`].
static PROCESS_VARIABLES: [Variable; 13] = joined(
    &SURFACE,
    &[
        variable("depth_force", "N", "F_d without ripple", [1e3, 1e4, 3e4]),
        variable("fx", "N", "force on the tool before this effect, in W", [0.0, 1e3, -4e3]),
        variable("fy", "N", "force on the tool before this effect", [0.0, 1e3, -1e3]),
        variable("fz", "N", "force on the tool before this effect, below 0", [-1e3, -1e4, -3e4]),
    ],
);

fn process_values(at: &ProcessPoint, force: &Vector3<f64>) -> [f64; 13] {
    let [a, b, c, d, e, f, g, h, i] = surface_values(at);
    [a, b, c, d, e, f, g, h, i, at.depth_force, force.x, force.y, force.z]
}

static SHIFT: [Variable; 1] = [TIME_VARIABLE];

/// In the order of [`instrument_values`].
static INSTRUMENT_VARIABLES: [Variable; 13] = [
    TIME_VARIABLE,
    variable("px", "m", "tracker, in B", [0.0, 1.0, 2.0]),
    variable("py", "m", "tracker", [0.0, 1.0, -1.0]),
    variable("pz", "m", "tracker", [0.0, 0.5, 1.0]),
    variable("fx", "N", "force sensor, in T", [0.0, 1e3, -4e3]),
    variable("fy", "N", "force sensor", [0.0, 1e3, -1e3]),
    variable("fz", "N", "force sensor", [0.0, -1e4, -3e4]),
    variable("encoder_1", "rad", "encoder angle of the first joint", [0.0, 1.0, -1.0]),
    variable("encoder_2", "rad", "encoder angle of the second joint", [0.0, -1.0, -2.0]),
    variable("encoder_3", "rad", "encoder angle of the third joint", [0.0, 1.0, 2.0]),
    variable("encoder_4", "rad", "encoder angle of the fourth joint", [0.0, 1.0, -1.0]),
    variable("encoder_5", "rad", "encoder angle of the fifth joint", [0.0, 1.0, -1.0]),
    variable("encoder_6", "rad", "encoder angle of the sixth joint", [0.0, 1.0, -1.0]),
];

fn instrument_values(at: &Readings) -> [f64; 13] {
    let (p, f, [a, b, c, d, e, g]) = (&at.tcp_position, &at.force, at.encoder);
    [at.time, p.x, p.y, p.z, f.x, f.y, f.z, a, b, c, d, e, g]
}

static SECOND_ENCODER: [Variable; 3] = [TIME_VARIABLE, ENCODER_VARIABLE, LINK];

static MOTOR: [Variable; 3] = [
    TIME_VARIABLE,
    ENCODER_VARIABLE,
    variable("torque", "N·m", "motor torque as commanded", [0.0, 1e4, -1e4]),
];

/// Every port that an effect in a model file may act at.
pub static PORTS: &[NamedPort] = &[
    port(
        "spring-torque",
        "N·m",
        "torque on the link, and as much less on the motor",
        &JOINT,
        TermTarget::SpringTorque,
    ),
    port("twist", "rad", "more twist of the spring", &JOINT, TermTarget::Twist),
    port(
        "motor-friction",
        "N·m",
        "torque against the motor",
        &MOTOR_SIDE,
        TermTarget::MotorFriction,
    ),
    port("link-torque", "N·m", "torque on the link", &LINK_SIDE, TermTarget::LinkTorque),
    port(
        "process-force-x",
        "N",
        "force on the tool along x of W, in contact",
        &PROCESS_VARIABLES,
        TermTarget::ProcessForce(0),
    ),
    port(
        "process-force-y",
        "N",
        "force on the tool along y of W, in contact",
        &PROCESS_VARIABLES,
        TermTarget::ProcessForce(1),
    ),
    port(
        "process-force-z",
        "N",
        "force on the tool along z of W, in contact",
        &PROCESS_VARIABLES,
        TermTarget::ProcessForce(2),
    ),
    port(
        "surface-height",
        "m",
        "height of the plate towards the tool",
        &SURFACE,
        TermTarget::SurfaceHeight,
    ),
    port(
        "tool-shift-x",
        "m",
        "displacement of the arm along x of B",
        &SHIFT,
        TermTarget::ToolShift(0),
    ),
    port(
        "tool-shift-y",
        "m",
        "displacement of the arm along y of B",
        &SHIFT,
        TermTarget::ToolShift(1),
    ),
    port(
        "tool-shift-z",
        "m",
        "displacement of the arm along z of B",
        &SHIFT,
        TermTarget::ToolShift(2),
    ),
    port(
        "tracker-x",
        "m",
        "what the tracker reads more along x of B",
        &INSTRUMENT_VARIABLES,
        TermTarget::Tracker(0),
    ),
    port(
        "tracker-y",
        "m",
        "what the tracker reads more along y of B",
        &INSTRUMENT_VARIABLES,
        TermTarget::Tracker(1),
    ),
    port(
        "tracker-z",
        "m",
        "what the tracker reads more along z of B",
        &INSTRUMENT_VARIABLES,
        TermTarget::Tracker(2),
    ),
    port(
        "force-sensor-x",
        "N",
        "what the force sensor reads more along x of T",
        &INSTRUMENT_VARIABLES,
        TermTarget::ForceSensor(0),
    ),
    port(
        "force-sensor-y",
        "N",
        "what the force sensor reads more along y of T",
        &INSTRUMENT_VARIABLES,
        TermTarget::ForceSensor(1),
    ),
    port(
        "force-sensor-z",
        "N",
        "what the force sensor reads more along z of T",
        &INSTRUMENT_VARIABLES,
        TermTarget::ForceSensor(2),
    ),
    port(
        "link-encoder",
        "rad",
        "what the second encoder reads more",
        &SECOND_ENCODER,
        TermTarget::LinkEncoder,
    ),
    port(
        "recorded-torque",
        "N·m",
        "what is recorded more as motor torque",
        &MOTOR,
        TermTarget::MotorTorque,
    ),
];

const fn port(
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    variables: &'static [Variable],
    target: TermTarget,
) -> NamedPort {
    NamedPort { name, unit, meaning, variables, target }
}

impl NamedPort {
    /// A size at which a slope is taken, in the port's unit: small against what any plant does,
    /// large against rounding.
    pub fn small(&self) -> f64 {
        match self.unit {
            "rad" => 5e-5,
            "m" => 1e-4,
            _ => 50.0,
        }
    }

    /// What an effect there is attached to.
    pub fn place(&self) -> LocationKind {
        match self.target {
            TermTarget::SpringTorque
            | TermTarget::Twist
            | TermTarget::MotorFriction
            | TermTarget::LinkTorque
            | TermTarget::LinkEncoder
            | TermTarget::MotorTorque => LocationKind::Joint,
            TermTarget::ProcessForce(_)
            | TermTarget::SurfaceHeight
            | TermTarget::ToolShift(_)
            | TermTarget::Tracker(_)
            | TermTarget::ForceSensor(_) => LocationKind::Cell,
        }
    }

    /// True where an effect may remember the way that a joint has come.
    fn remembers(&self) -> bool {
        matches!(
            self.target,
            TermTarget::SpringTorque | TermTarget::MotorFriction | TermTarget::LinkTorque
        )
    }

    fn of_the_plant(&self, joint: usize) -> Port {
        match self.target {
            TermTarget::SpringTorque | TermTarget::Twist => Port::SpringTorque(joint),
            TermTarget::MotorFriction => Port::MotorFriction(joint),
            TermTarget::LinkTorque => Port::LinkTorque(joint),
            TermTarget::ProcessForce(_) => Port::ProcessForce,
            TermTarget::SurfaceHeight => Port::PlateSurface,
            TermTarget::ToolShift(_) => Port::BaseFrame,
            TermTarget::Tracker(_) => Port::SensorChannel(Channel::Tracker),
            TermTarget::ForceSensor(_) => Port::SensorChannel(Channel::Wrench),
            TermTarget::LinkEncoder => Port::SensorChannel(Channel::LinkEncoder),
            TermTarget::MotorTorque => Port::SensorChannel(Channel::MotorTorque),
        }
    }
}

/// What a fit makes of a parameter of the user's own.
#[derive(Debug, Clone, PartialEq)]
pub enum CustomRole {
    /// The effect grows from nothing with it; the slope is taken at this value.
    Size(f64),
    /// Shapes the effect; values a fit may start from. A fit takes steps in proportion to it.
    Shape(Vec<f64>),
    /// The same for what may pass through zero: the slope is taken over this change.
    Position(f64, Vec<f64>),
}

/// A parameter as its author states it; as [`Parameter`](super::Parameter), but owned.
#[derive(Debug, Clone, PartialEq)]
pub struct CustomParameter {
    /// Name in the expression.
    pub name: String,
    /// Unit.
    pub unit: String,
    /// Meaning.
    pub meaning: String,
    /// What a fit makes of it.
    pub role: CustomRole,
    /// Smallest plausible value.
    pub low: f64,
    /// Largest plausible value.
    pub high: f64,
}

/// An effect as its author states it.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// Identifier.
    pub id: String,
    /// Where it acts.
    pub port: &'static NamedPort,
    /// Its value, over the port's variables and the parameters.
    pub expression: String,
    /// What it looks like in data.
    pub shows: String,
    /// Its parameters, the values of its table last.
    pub parameters: Vec<CustomParameter>,
    /// Its table, where the expression reads one.
    pub table: Option<DefinedTable>,
}

/// A definition, ready to act.
#[derive(Debug)]
pub struct Formula {
    /// What it was made from.
    pub definition: Definition,
    expression: Expression,
    /// How the variable changes whose way is remembered.
    way: Option<VariableRate>,
}

impl Definition {
    /// Its parameters without the values of its table.
    pub fn named(&self) -> &[CustomParameter] {
        let places = self.table.as_ref().map_or(0, |table| table.places.count());
        &self.parameters[..self.parameters.len() - places]
    }

    /// The expression, checked: every parameter occurs in it, and at `values` and with each
    /// parameter in turn at its `low` and `high` it is finite wherever the port's variables may
    /// well be.
    pub(super) fn checked(&self, values: &[f64]) -> Result<Expression, ExpressionMistake> {
        let variables: Vec<&str> = self.port.variables.iter().map(|v| v.name).collect();
        let names: Vec<&str> = self.named().iter().map(|p| p.name.as_str()).collect();
        let table = self.table.as_ref().map(|table| &table.places);
        let expression = Expression::parse_with_table(&self.expression, &variables, &names, table)?;
        let whole = 0..self.expression.len();
        let mistake = |message, help: &str| {
            Err(ExpressionMistake { at: whole.clone(), message, help: help.to_owned() })
        };
        if let Some((_, unused)) =
            self.parameters.iter().enumerate().find(|(i, _)| !expression.has_parameter(*i))
        {
            let message = if self.named().iter().any(|p| p.name == unused.name) {
                format!(
                    "the parameter `{}` does not occur; expected each parameter to be used",
                    unused.name
                )
            } else {
                "the table is not read; expected `table(…)` of a variable".to_owned()
            };
            return mistake(message, "A fit cannot find the value of what changes nothing.");
        }
        if let Some(variable) = expression.variable_remembered() {
            let name = variables[variable];
            if !self.port.remembers() {
                let ports: Vec<&str> =
                    PORTS.iter().filter(|p| p.remembers()).map(|p| p.name).collect();
                let message = format!(
                    "a loop at {}; expected one of the ports {}",
                    self.port.name,
                    ports.join(", ")
                );
                return mistake(message, "Only there the plant keeps what an effect remembers.");
            }
            if WAY_VARIABLES.iter().all(|(known, _)| *known != name) {
                let names = WAY_VARIABLES.map(|(name, _)| name).join(", ");
                let message = format!("a loop over `{name}`; expected one of {names}");
                return mistake(message, "What is remembered is the way of a joint.");
            }
        }
        let ends = self.parameters.iter().enumerate().flat_map(|(i, p)| [(i, p.low), (i, p.high)]);
        for changed in std::iter::once(None).chain(ends.map(Some)) {
            let mut values = values.to_vec();
            if let Some((i, end)) = changed {
                values[i] = end;
            }
            if let Some((_, width)) = expression.remembered(&values)
                && !(width > 0.0 && width.is_finite())
            {
                let message = format!("a loop {width} wide; expected a width above 0");
                return mistake(message, "Keep it above 0 over the range of each parameter.");
            }
            for probe in 0..3 {
                let mut point: Vec<f64> =
                    self.port.variables.iter().map(|v| v.probes[probe]).collect();
                point.push([0.0, 1.0, -1.0][probe]);
                let value = expression.eval(&point, &values);
                if value.is_finite() {
                    continue;
                }
                let variables = self.port.variables.iter().map(|v| v.name).zip(&point).enumerate();
                let variables =
                    variables.filter(|(i, _)| expression.has_variable(*i)).map(|(_, named)| named);
                let parameters = self.parameters.iter().map(|p| p.name.as_str()).zip(&values);
                let place: Vec<_> =
                    variables.chain(parameters).map(|(n, v)| format!("{n} = {v:?}")).collect();
                let message = format!(
                    "its value is {value} at {}; expected a finite number there",
                    place.join(", ")
                );
                return mistake(
                    message,
                    "Keep it finite, also at rest and over the range of each parameter.",
                );
            }
        }
        Ok(expression)
    }
}

impl CustomParameter {
    /// The values of a table as parameters, each plausible within `range`; slopes are taken at `step`.
    pub fn of_table(table: &DefinedTable, unit: &str, step: f64, range: [f64; 2]) -> Vec<Self> {
        let meaning = |k: usize| {
            let [x, across] = table.places.place(k);
            match table.places.across.is_empty() {
                true => format!("value at {x}"),
                false => format!("value at {x} and {across}"),
            }
        };
        let values = (0..table.places.count()).map(|k| Self {
            name: DefinedTable::name_of(k),
            unit: unit.to_owned(),
            meaning: meaning(k),
            role: CustomRole::Size(step),
            low: range[0],
            high: range[1],
        });
        values.collect()
    }

    /// True where it is a word that an expression at this port can use for a parameter.
    pub fn may_be_named(name: &str, port: &NamedPort) -> bool {
        may_be_named(name) && port.variables.iter().all(|v| v.name != name)
    }
}

impl Formula {
    pub(super) fn new(definition: Definition, expression: Expression) -> Self {
        let of = |variable: usize| {
            let name = definition.port.variables[variable].name;
            WAY_VARIABLES.iter().find(|(known, _)| *known == name).map(|(_, way)| *way)
        };
        let way = expression.variable_remembered().and_then(of);
        Self { definition, expression, way }
    }

    /// Where it acts in the plant.
    pub(super) fn port(&self, joint: usize) -> Port {
        self.definition.port.of_the_plant(joint)
    }

    /// Where and how it acts in the plant, with these values of its parameters.
    pub(super) fn term(&'static self, values: &[f64], joint: usize) -> (Port, Box<dyn Term>) {
        let target = self.definition.port.target;
        (self.port(joint), Box::new(Own { formula: self, target, joint, values: values.into() }))
    }
}

#[derive(Debug)]
struct Own {
    formula: &'static Formula,
    target: TermTarget,
    joint: usize,
    values: Box<[f64]>,
}

impl Own {
    fn at(&self, variables: &[f64]) -> f64 {
        self.formula.expression.eval(variables, &self.values)
    }

    /// How it remembers, over which width, and how fast the variable changes whose way it is.
    fn remembering(&self, at: &JointState) -> Option<(Loop, f64, f64)> {
        let way = self.formula.way?;
        let (law, width) = self.formula.expression.remembered(&self.values)?;
        Some((law, width, way(at)))
    }

    fn along(&self, axis: usize, variables: &[f64]) -> Vector3<f64> {
        let mut vector = Vector3::zeros();
        vector[axis] = self.at(variables);
        vector
    }
}

impl Term for Own {
    fn torsion(&self, at: &JointState) -> f64 {
        if self.target == TermTarget::Twist { self.at(&joint_values(at)) } else { 0.0 }
    }

    fn spring_torque(&self, at: &JointState) -> f64 {
        let [a, b, c, d, e, f, g] = joint_values(at);
        match self.target {
            TermTarget::SpringTorque => self.at(&[a, b, c, d, e, f, g, at.remembered]),
            _ => 0.0,
        }
    }

    fn internal_rate(&self, at: &JointState) -> Option<f64> {
        let (law, width, rate) = self.remembering(at)?;
        Some(law.rate(rate, width, at.remembered))
    }

    fn remembered_after(&self, way: &JointState) -> f64 {
        self.remembering(way)
            .map_or(way.remembered, |(law, width, length)| law.after(length, width, way.remembered))
    }

    fn friction(&self, at: &JointState) -> ValueDerivative {
        let off = |by| {
            let at = JointState { encoder_rate: at.encoder_rate + by, ..*at };
            let [a, b, c, d, e, f, g] = joint_values(&at);
            self.at(&[a, b, c, d, e, f, g, at.spring_torque, at.time, at.remembered])
        };
        let slope = (off(RATE_DIFFERENCE) - off(-RATE_DIFFERENCE)) / (2.0 * RATE_DIFFERENCE);
        ValueDerivative { value: off(0.0), slope }
    }

    fn link_torque(&self, at: &JointState, counterbalance: f64) -> f64 {
        let [a, b, c, d, e, f, g] = joint_values(at);
        self.at(&[a, b, c, d, e, f, g, counterbalance, at.remembered])
    }

    fn shift(&self, time: f64) -> Vector3<f64> {
        match self.target {
            TermTarget::ToolShift(axis) => self.along(axis, &[time]),
            _ => Vector3::zeros(),
        }
    }

    fn process_force(&self, at: &ProcessPoint, force: Vector3<f64>) -> Vector3<f64> {
        match self.target {
            TermTarget::ProcessForce(axis) => force + self.along(axis, &process_values(at, &force)),
            _ => force,
        }
    }

    fn surface(&self, at: &ProcessPoint) -> f64 {
        self.at(&surface_values(at))
    }

    fn sense(&self, readings: &mut Readings) {
        match self.target {
            TermTarget::Tracker(axis) => {
                readings.tcp_position += self.along(axis, &instrument_values(readings))
            }
            TermTarget::ForceSensor(axis) => {
                readings.force += self.along(axis, &instrument_values(readings))
            }
            TermTarget::MotorTorque => {
                let (encoder, torque) =
                    (readings.encoder[self.joint], readings.motor_torque[self.joint]);
                readings.motor_torque[self.joint] += self.at(&[readings.time, encoder, torque]);
            }
            _ => {
                let (encoder, link) =
                    (readings.encoder[self.joint], readings.link_encoder[self.joint]);
                readings.link_encoder[self.joint] += self.at(&[readings.time, encoder, link]);
            }
        }
    }
}
