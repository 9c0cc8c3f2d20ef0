//! What a curve may be: a port of the plant, a place, the variable that the curve is over, and what
//! it is multiplied by; where it is a loop, over what is remembered of the variable's way; and what a
//! surface over two variables may be, where no curve is enough.

use trueweld_core::JOINTS;
use trueweld_plant::effects::Location;
use trueweld_plant::effects::LocationKind;
use trueweld_plant::effects::formula::{NamedPort, PORTS};

/// A curve at a port: its value is `times` × table(`over`), of a loop table(dahl(`over`, w)) beside a
/// spring in proportion to `over`, of a surface `times` × table(`over`, `across`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hypothesis {
    /// The port.
    pub port: &'static NamedPort,
    /// Where.
    pub at: Location,
    /// The variable, an expression over the port's.
    pub over: &'static str,
    /// The second variable of a surface, an expression over the port's; `None` for a curve.
    pub across: Option<&'static str>,
    /// What the curve is multiplied by, an expression over the port's variables.
    pub times: &'static str,
    /// The way over which a loop turns round, in the variable's unit; `None` for a curve.
    pub turns_over: Option<f64>,
}

/// Loops that are looked at: what rubs on a link, and friction that gives before it slides. They come
/// after the curves, which remember nothing.
const LOOP_HYPOTHESES: [(&str, &str); 2] = [("motor-friction", "encoder"), ("link-torque", "link")];

/// The sense in which a joint turns: friction turns round with it.
const MOTOR_SENSE: &str = "tanh(encoder_rate/smoothing)";
const LINK_SENSE: &str = "tanh(link_rate/smoothing)";

/// Ports, variables and factors that are looked at; of those that the logs do not tell apart the
/// first is named. What a robot carries about comes before what its gears do, and both before what
/// instruments read.
const CURVE_HYPOTHESES: &[(&str, &[(&str, &str)])] = &[
    (
        "motor-friction",
        &[
            ("encoder", MOTOR_SENSE),
            ("abs(encoder_rate)", MOTOR_SENSE),
            ("abs(spring_torque)", MOTOR_SENSE),
            ("spring_torque", MOTOR_SENSE),
            ("time", MOTOR_SENSE),
        ],
    ),
    (
        "link-torque",
        &[
            ("link", "1"),
            ("encoder_before", "1"),
            ("link_rate", "1"),
            ("link", LINK_SENSE),
            ("abs(link_rate)", LINK_SENSE),
            ("link", "link_rate"),
        ],
    ),
    // Over the angle alone the two are one law, of a gear that is uneven.
    ("twist", &[("encoder", "1"), ("encoder_before", "1")]),
    ("spring-torque", &[("encoder", "1"), ("twist", "1"), ("encoder", "twist")]),
    (
        "motor-friction",
        &[
            ("encoder", "1"),
            ("encoder_rate", "1"),
            ("encoder", "encoder_rate"),
            ("time", "encoder_rate"),
        ],
    ),
    ("process-force-x", &[("x", "1"), ("vx", "1"), ("depth_force", "1"), ("time", "1")]),
    ("process-force-y", &[("x", "1"), ("vx", "1"), ("depth_force", "1"), ("time", "1")]),
    ("process-force-z", &[("x", "1"), ("depth_force", "1"), ("time", "1")]),
    ("surface-height", &[("x", "1"), ("time", "1")]),
    ("tool-shift-x", &[("time", "1")]),
    ("tool-shift-y", &[("time", "1")]),
    ("tool-shift-z", &[("time", "1")]),
    ("link-encoder", &[("encoder", "1"), ("time", "1")]),
    ("recorded-torque", &[("encoder", "1"), ("torque", "1"), ("time", "1")]),
    ("tracker-x", &TRACKER_VARIABLES),
    ("tracker-y", &TRACKER_VARIABLES),
    ("tracker-z", &TRACKER_VARIABLES),
    ("force-sensor-x", &[("fz", "1"), ("time", "1")]),
    ("force-sensor-y", &[("fz", "1"), ("time", "1")]),
    ("force-sensor-z", &[("fz", "1"), ("time", "1")]),
];

/// What a tracker's error may depend on.
const TRACKER_VARIABLES: [(&str, &str); 7] = [
    ("px", "1"),
    ("py", "1"),
    ("pz", "1"),
    ("encoder_1", "1"),
    ("encoder_4", "1"),
    ("encoder_6", "1"),
    ("time", "1"),
];

/// Surfaces that are looked at where no curve is enough: port, both variables, and what the surface is
/// multiplied by.
const SURFACE_HYPOTHESES: &[(&str, &str, &str, &str)] = &[
    ("motor-friction", "encoder", "abs(spring_torque)", MOTOR_SENSE),
    ("motor-friction", "abs(encoder_rate)", "abs(spring_torque)", MOTOR_SENSE),
    ("motor-friction", "encoder", "abs(encoder_rate)", MOTOR_SENSE),
    ("motor-friction", "time", "abs(encoder_rate)", MOTOR_SENSE),
    ("motor-friction", "time", "encoder", MOTOR_SENSE),
    ("link-torque", "link", "encoder_before", "1"),
    ("link-torque", "link", "link_rate", "1"),
    ("spring-torque", "encoder", "twist", "1"),
    ("process-force-x", "x", "depth_force", "1"),
    ("process-force-x", "vx", "depth_force", "1"),
    ("process-force-y", "x", "depth_force", "1"),
    ("process-force-y", "vx", "depth_force", "1"),
    ("process-force-z", "x", "depth_force", "1"),
    ("surface-height", "x", "time", "1"),
    ("recorded-torque", "encoder", "torque", "1"),
    ("tracker-x", "px", "py", "1"),
    ("tracker-x", "px", "pz", "1"),
    ("tracker-x", "py", "pz", "1"),
    ("tracker-y", "px", "py", "1"),
    ("tracker-y", "px", "pz", "1"),
    ("tracker-y", "py", "pz", "1"),
    ("tracker-z", "px", "py", "1"),
    ("tracker-z", "px", "pz", "1"),
    ("tracker-z", "py", "pz", "1"),
    ("force-sensor-x", "fz", "time", "1"),
    ("force-sensor-y", "fz", "time", "1"),
    ("force-sensor-z", "fz", "time", "1"),
];

/// Every hypothesis of a curve.
pub(super) fn all() -> Vec<Hypothesis> {
    let curves = |(name, curves): &'static (&'static str, &[(&'static str, &'static str)])| {
        places(name, curves.iter().map(|(over, times)| (*over, None, *times)).collect())
    };
    CURVE_HYPOTHESES.iter().flat_map(curves).collect()
}

/// Every hypothesis of a surface.
pub(super) fn surfaces() -> Vec<Hypothesis> {
    let of =
        |(name, over, across, times): &(&'static str, &'static str, &'static str, &'static str)| {
            places(name, vec![(*over, Some(*across), *times)])
        };
    SURFACE_HYPOTHESES.iter().flat_map(of).collect()
}

/// Hypotheses at every place of a port, by their variables and factors.
fn places(
    name: &str,
    of: Vec<(&'static str, Option<&'static str>, &'static str)>,
) -> Vec<Hypothesis> {
    let Some(port) = PORTS.iter().find(|p| p.name == name) else { return Vec::new() };
    let places: Vec<Location> = match port.place() {
        LocationKind::Joint => (0..JOINTS).map(Location::Joint).collect(),
        _ => vec![Location::Cell],
    };
    let at = |at: Location| {
        let one =
            move |(over, across, times): &(&'static str, Option<&'static str>, &'static str)| {
                Hypothesis { port, at, over, across: *across, times, turns_over: None }
            };
        of.iter().map(one).collect::<Vec<_>>()
    };
    places.into_iter().flat_map(at).collect()
}

impl Hypothesis {
    /// True for a curve beside which a loop is looked for.
    pub(super) fn may_be_loop(&self) -> bool {
        self.times == "1" && LOOP_HYPOTHESES.contains(&(self.port.name, self.over))
    }

    /// Names of the port's variables that it depends on, that of the curve first.
    pub fn variables(&self) -> Vec<&'static str> {
        let within = |text: &str, name: &str| {
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_';
            text.split(|c: char| !word(c)).any(|part| part == name)
        };
        // The rate over which friction turns round is a number of the robot.
        let names = || self.port.variables.iter().map(|v| v.name).filter(|n| *n != "smoothing");
        let mut found: Vec<&str> = Vec::new();
        for text in [Some(self.over), self.across, Some(self.times)].into_iter().flatten() {
            let more: Vec<&str> =
                names().filter(|n| within(text, n) && !found.contains(n)).collect();
            found.extend(more);
        }
        found
    }

    /// True for a curve that follows a link as it swings: its port does not answer at once.
    pub(super) fn swings(&self) -> bool {
        self.variables().iter().any(|name| ["twist", "link_rate"].contains(name))
    }

    /// What the curve is over, an expression over the port's variables.
    pub(super) fn over(&self) -> String {
        match self.turns_over {
            Some(width) => format!("dahl({},{width:?})", self.over),
            None => self.over.to_owned(),
        }
    }

    /// The table that it is, an expression over the port's variables.
    pub(super) fn table(&self) -> String {
        let over = self.over();
        let read = self.across.map_or(over.clone(), |across| [&over, ", ", across].concat());
        self.expression(&["table(", &read, ")"].concat())
    }

    /// True for a curve over the same variable at the same place, or a loop, whatever its width.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        let own = |h: &Self| Self { turns_over: h.turns_over.map(|_| 0.0), ..*h };
        own(self) == own(other)
    }

    /// Unit of the variable that the curve is over.
    pub fn x_unit(&self) -> &'static str {
        self.unit_of_variable(0)
    }

    /// Unit of the second variable of a surface.
    pub fn across_unit(&self) -> &'static str {
        self.unit_of_variable(1)
    }

    fn unit_of_variable(&self, index: usize) -> &'static str {
        let name = self.variables().get(index).copied().unwrap_or_default();
        self.port.variables.iter().find(|v| v.name == name).map_or("", |v| v.unit)
    }

    /// Unit of the curve: the port's, over that of what it is multiplied by.
    pub fn y_unit(&self) -> String {
        let times = self.port.variables.iter().find(|v| v.name == self.times);
        match (self.port.unit, times.map(|v| v.unit)) {
            (unit, None) => unit.to_owned(),
            ("N·m", Some("rad/s")) => "N·m·s/rad".to_owned(),
            (unit, Some(times)) => format!("{unit}/{times}"),
        }
    }

    /// Unit of the curve over powers of those of its variables.
    pub(super) fn slope_unit(&self, powers: [i8; 2]) -> String {
        let over = |unit: String, (by, power): (&str, i8)| match power {
            0 => unit,
            1 => [&unit, "/", by].concat(),
            power => format!("{unit}/({by})^{power}"),
        };
        [self.x_unit(), self.across_unit()].into_iter().zip(powers).fold(self.y_unit(), over)
    }

    /// An expression over the hypothesis' variables as one over `u` and `v` in their places, without its
    /// factor.
    pub(super) fn within(&self, expression: &str) -> String {
        let factor = format!("*{}", self.times);
        let own = replaced(expression.strip_suffix(&factor).unwrap_or(expression), self.over, "u");
        self.across.map_or(own.clone(), |across| replaced(&own, across, "v"))
    }

    /// The expression in which `of` stands for the curve.
    pub fn expression(&self, of: &str) -> String {
        if self.times == "1" { of.to_owned() } else { format!("{of}*{}", self.times) }
    }
}

/// A formula with something else read as what stands in it as a word, or as a call.
pub(super) fn replaced(text: &str, from: &str, with: &str) -> String {
    let word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '.';
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(from) {
        let (before, after) = (&rest[..at], &rest[at + from.len()..]);
        let apart = !before.ends_with(word) && !after.starts_with(word);
        out += before;
        out += if apart { with } else { from };
        rest = after;
        if !apart {
            // The rest of a longer word is no word of its own.
            let end = rest.find(|c| !word(c)).unwrap_or(rest.len());
            out += &rest[..end];
            rest = &rest[end..];
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_is_replaced_and_not_a_part_of_one() {
        let read = replaced("sign(u - centre)*unit + u^2", "u", "link");
        assert_eq!(read, "sign(link - centre)*unit + link^2");
        assert_eq!(replaced("a*exp(-x/w)", "x", "u"), "a*exp(-u/w)");
        assert_eq!(replaced("a*abs(encoder_rate)", "abs(encoder_rate)", "u"), "a*u");
    }

    #[test]
    fn every_hypothesis_is_of_variables_that_its_port_has() {
        let (curves, surfaces) = (all(), surfaces());
        assert!(curves.len() > 100 && surfaces.len() > 50);
        for hypothesis in curves.into_iter().chain(surfaces) {
            let known = [Some(hypothesis.over), hypothesis.across].into_iter().flatten().count();
            assert!(hypothesis.variables().len() >= known, "{hypothesis:?}");
            assert!(!hypothesis.x_unit().is_empty(), "{hypothesis:?}");
            assert!(known < 2 || !hypothesis.across_unit().is_empty(), "{hypothesis:?}");
        }
    }
}
