//! Laws that the library does not hold, from textbooks of machine elements, tribology and
//! measurement: what a discovery is judged by.
//!
//! They were written down before the grammar of formulas was tried on them, each as its source has
//! it; the numbers are such that it shows well in the logs of the fixtures' robot.

use crate::LABORATORY;
use trueweld_laboratory::{CorpusCase, Hidden, Protocol};
use trueweld_plant::effects::formula::{CustomParameter, CustomRole, Definition, PORTS};
use trueweld_plant::effects::{Effect, Location};

/// A law outside the library.
#[derive(Debug, Clone, Copy)]
pub struct FreeFormEffect {
    /// Its name.
    pub name: &'static str,
    /// The port that it acts at.
    pub port: &'static str,
    /// The joint, from 0; `None` for the whole cell.
    pub joint: Option<usize>,
    /// Its value, with numbers.
    pub expression: &'static str,
    /// The variables that it depends on.
    pub over: &'static [&'static str],
}

const fn law(
    name: &'static str,
    port: &'static str,
    joint: Option<usize>,
    expression: &'static str,
    over: &'static [&'static str],
) -> FreeFormEffect {
    FreeFormEffect { name, port, joint, expression, over }
}

/// The laws.
pub static LAWS: &[FreeFormEffect] = &[
    // A strap that is slack, then taut.
    law("strap", "link-torque", Some(3), "-900*max(link - 0.2, 0)", &["link"]),
    // A hose pack, slack to either side.
    law(
        "hose",
        "link-torque",
        Some(4),
        "-700*(link - 0.3 - max(-0.2, min(0.2, link - 0.3)))",
        &["link"],
    ),
    // A weight that was forgotten, on an arm of its own: m g l sin.
    law("pendulum", "link-torque", Some(5), "60*sin(link + 0.8)", &["link"]),
    // A rubber bellows, stiffening: Mullins' envelope as a cubic.
    law("bellows", "link-torque", Some(0), "-(300*link + 1500*link^3)", &["link"]),
    // A magnet that holds a position: Gaussian in the energy, its slope the torque.
    law(
        "detent",
        "link-torque",
        Some(4),
        "-1200*(link - 0.2)*exp(-((link - 0.2)/0.25)^2)",
        &["link"],
    ),
    // Churning of oil: with the square of the speed.
    law("churning", "link-torque", Some(2), "-900*link_rate*abs(link_rate)", &["link_rate"]),
    // A brake that drags where its disc is bent: friction with the angle.
    law(
        "bent-disc",
        "motor-friction",
        Some(1),
        "260*(1 + cos(2*encoder))*tanh(encoder_rate/smoothing)",
        &["encoder", "encoder_rate"],
    ),
    // Friction of meshing teeth by Niemann: with a power of the load.
    law(
        "teeth",
        "motor-friction",
        Some(2),
        "0.8*abs(spring_torque)^0.7*tanh(encoder_rate/smoothing)",
        &["spring_torque", "encoder_rate"],
    ),
    // Shear thinning of grease: v^0.4.
    law(
        "grease",
        "motor-friction",
        Some(0),
        "700*abs(encoder_rate)^0.4*tanh(encoder_rate/smoothing)",
        &["encoder_rate"],
    ),
    // A flexspline that is out of round by a parabola over its range.
    law("out-of-round", "twist", Some(0), "1.2e-3*(encoder - 0.2)^2", &["encoder"]),
    // Gear whose preload differs over its turn: stiffness with the angle.
    law("preload", "spring-torque", Some(0), "9e5*twist*cos(1.5*encoder)", &["encoder", "twist"]),
    // A force sensor that saturates softly.
    law("soft-sensor", "force-sensor-z", None, "-0.08*fz*tanh(abs(fz)/15000)", &["fz"]),
    // Refraction: a tracker that is off by the distance squared.
    law("refraction", "tracker-z", None, "6e-5*px^2", &["px"]),
    // A foundation that creeps: logarithm of time.
    law("creep", "tool-shift-z", None, "1.5e-4*ln(1 + time/2)", &["time"]),
    // A plate that was welded before and is bowed.
    law("bow", "surface-height", None, "0.02*(x - 0.1)^2 - 2e-4", &["x"]),
    // A motor constant that falls with the load: magnets that saturate.
    law("saturation", "recorded-torque", Some(1), "-2e-5*torque*abs(torque)", &["torque"]),
];

/// Those with a memory, written together with the loops of the grammar.
pub static LOOPS: &[FreeFormEffect] = &[
    // Hoses that rub on their clamps: Dahl's friction of the link.
    law("clamps", "link-torque", Some(3), "-150*dahl(link, 0.06)", &["link"]),
    // A seal that gives before it slides: Jenkins' element at the motor.
    law("seal", "motor-friction", Some(1), "2.5e4*(encoder - play(encoder, 0.012))", &["encoder"]),
];

/// Those over two variables, of which neither is enough; written together with the surfaces that are
/// looked at.
pub static PAIRS: &[FreeFormEffect] = &[
    // A hose to the arm: its lever turns with the joint before.
    law(
        "umbilical",
        "link-torque",
        Some(4),
        "-400*(link - 0.3)*cos(1.5*encoder_before)",
        &["link", "encoder_before"],
    ),
    // Friction of meshing teeth with the load, where the wheel runs out of true.
    law(
        "run-out",
        "motor-friction",
        Some(1),
        "0.06*abs(spring_torque)*(1 + 0.9*sin(3*encoder))*tanh(encoder_rate/smoothing)",
        &["encoder", "spring_torque", "encoder_rate"],
    ),
    // Grease that thins as it warms up: drag with the speed, less of it with the time.
    law(
        "warming-grease",
        "motor-friction",
        Some(0),
        "900*abs(encoder_rate)^0.5*exp(-time/6)*tanh(encoder_rate/smoothing)",
        &["time", "encoder_rate"],
    ),
    // A tracker whose axes are not square.
    law("out-of-square", "tracker-z", None, "4e-4*px*py", &["px", "py"]),
];

/// Least multiple of the limit of detection at which a law is to show; others show three and ten times
/// as well.
const SHOWS: f64 = 3.0;

/// The first `count` cases of a corpus of these laws with this seed, one law after the other, with
/// the logs, the noise and the errors of the corpus of effects; then as many of each law with a
/// memory, and of each over two variables.
pub fn cases(seed: u64, count: usize, protocol: &Protocol) -> Vec<CorpusCase> {
    let [loops, pairs] = [LOOPS, PAIRS].map(|laws| count * laws.len() / LAWS.len());
    let further = LOOPS.iter().cycle().take(loops).chain(PAIRS.iter().cycle().take(pairs));
    let laws = LAWS.iter().cycle().take(count).chain(further);
    let ground = LABORATORY.corpus(seed, count + loops + pairs, protocol).into_iter();
    let of_law = |(index, (case, law)): (usize, (CorpusCase, &FreeFormEffect))| CorpusCase {
        name: format!("{index:03}-{}", law.name),
        hidden: Hidden::Law(law.effect(1.0)),
        target: SHOWS * case.target,
        ..case
    };
    ground.zip(laws).enumerate().map(of_law).collect()
}

impl FreeFormEffect {
    /// The law of a name.
    pub fn named(name: &str) -> Option<&'static Self> {
        LAWS.iter().chain(LOOPS).chain(PAIRS).find(|law| law.name == name)
    }

    /// True where it depends on the way that its variable has come.
    pub fn remembers(&self) -> bool {
        ["dahl(", "play("].iter().any(|operator| self.expression.contains(operator))
    }

    /// The law as an effect of the truth.
    ///
    /// # Panics
    /// Where its expression cannot be read.
    pub fn effect(&self, size: f64) -> Effect {
        let port = PORTS.iter().find(|p| p.name == self.port).expect("a port");
        let size_of_it = CustomParameter {
            name: "size".to_owned(),
            unit: "1".to_owned(),
            meaning: "size".to_owned(),
            role: CustomRole::Size(0.1),
            low: 0.0,
            high: 100.0,
        };
        let definition = Definition {
            id: self.name.to_owned(),
            port,
            expression: format!("size*({})", self.expression),
            shows: self.name.to_owned(),
            parameters: vec![size_of_it],
            table: None,
        };
        let kind = definition.kind(&[size]).expect("an expression");
        let at = self.joint.map_or(Location::Cell, Location::Joint);
        Effect { kind, at, values: vec![size] }
    }
}
