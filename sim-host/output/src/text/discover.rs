//! What is said of a law that the library does not hold.

use super::effects::capital;
use super::{Scale, digits, listed, score, share};
use trueweld_diagnose::discover::{DISCOVERED, Discovery, Hypothesis, LikeEffect};
use trueweld_diagnose::{FittedEffect, PortAt};
use trueweld_plant::effects::{Action, Effect, Location};
use trueweld_plant::input::RobotFile;

/// Name of a joint, or nothing.
pub(crate) fn joint(at: Location, robot: &RobotFile) -> &str {
    match at {
        Location::Joint(joint) => &robot.joint_names[joint],
        _ => "",
    }
}

/// What it is, such as `a torque on the link at A4`.
pub(crate) fn quantity(hypothesis: &Hypothesis, robot: &RobotFile) -> String {
    of_port((hypothesis.port, hypothesis.at), robot)
}

/// What acts at a port.
pub(crate) fn of_port((port, at): PortAt, robot: &RobotFile) -> String {
    let name = port.name;
    let axis = name.chars().last().unwrap_or_default();
    let what = match name.trim_end_matches(['x', 'y', 'z']) {
        "spring-torque" => "a torque between motor and link".to_owned(),
        "twist" => "a twist of the gear".to_owned(),
        "motor-friction" => "a torque against the motor".to_owned(),
        "link-torque" => "a torque on the link".to_owned(),
        "process-force-" => format!("a force on the tool along {axis} of the weld"),
        "surface-height" => "a height of the plate".to_owned(),
        "tool-shift-" => format!("a displacement of the arm along {axis} of the base"),
        "tracker-" => format!("an error of the tracker along {axis} of the base"),
        "force-sensor-" => format!("an error of the force sensor along {axis} of the tool"),
        "link-encoder" => "an error of the second encoder".to_owned(),
        "recorded-torque" => "an error of the recorded motor torque".to_owned(),
        _ => port.meaning.to_owned(),
    };
    match joint(at, robot) {
        "" => what,
        at => format!("{what} at {at}"),
    }
}

/// Name of one of its variables, such as `the link angle of A4`.
pub(crate) fn variable(hypothesis: &Hypothesis, name: &str, robot: &RobotFile) -> String {
    let own = joint(hypothesis.at, robot);
    let before = match hypothesis.at {
        Location::Joint(j) if j > 0 => robot.joint_names[j - 1].as_str(),
        _ => "",
    };
    match name {
        "time" => "the time from the start of the log".to_owned(),
        "encoder" => format!("the angle of {own}"),
        "encoder_rate" => format!("the rate of {own}"),
        "encoder_before" => format!("the angle of {before}"),
        "link" => format!("the link angle of {own}"),
        "link_rate" => format!("the link rate of {own}"),
        "twist" => format!("the twist of {own}'s gear"),
        "spring_torque" => format!("the torque that {own}'s gear carries"),
        "torque" => format!("the motor torque of {own}"),
        "px" | "py" | "pz" => format!("the tool's {} in the base frame", &name[1..]),
        "fz" | "depth_force" => "the axial force on the tool".to_owned(),
        "x" => "the position along the seam".to_owned(),
        "vx" => "the feed".to_owned(),
        _ => match name.strip_prefix("encoder_").and_then(|n| n.parse::<usize>().ok()) {
            Some(n) if (1..=robot.joint_names.len()).contains(&n) => {
                format!("the angle of {}", robot.joint_names[n - 1])
            }
            _ => name.replace('_', " "),
        },
    }
}

/// What its curve is over: of a loop the way since a reversal.
pub(crate) fn axis(hypothesis: &Hypothesis, robot: &RobotFile) -> String {
    let over = hypothesis.variables().first().copied().unwrap_or_default();
    let name = variable(hypothesis, over, robot);
    match hypothesis.turns_over {
        Some(_) => format!("{name} since it turned round"),
        None => name,
    }
}

/// Name of an effect of a model: of one that was discovered what it is.
pub(crate) fn name(effect: &Effect, robot: &RobotFile) -> String {
    let name = effect.name(robot);
    if name.starts_with(DISCOVERED) { format!("the law {name}") } else { name }
}

/// The second variable of a surface.
pub(crate) fn across(hypothesis: &Hypothesis, robot: &RobotFile) -> String {
    let second = hypothesis.variables().get(1).copied().unwrap_or_default();
    variable(hypothesis, second, robot)
}

/// What it depends on, in words.
fn variables(hypothesis: &Hypothesis, robot: &RobotFile) -> String {
    let names: Vec<String> =
        hypothesis.variables().into_iter().map(|name| variable(hypothesis, name, robot)).collect();
    listed(&names, "and")
}

/// A law in a few words: `a torque on the link at A4 that depends on the link angle of A4`.
pub(crate) fn law(hypothesis: &Hypothesis, robot: &RobotFile) -> String {
    let (what, variables) = (quantity(hypothesis, robot), variables(hypothesis, robot));
    match hypothesis.turns_over {
        Some(_) => format!("{what} that depends on the way that {variables} has come"),
        None => format!("{what} that depends on {variables}"),
    }
}

/// Laws that are named in a sentence.
const NAMED_LAWS_MAX: usize = 2;

/// The finding in a sentence.
pub(crate) fn headline(all: &[Discovery], robot: &RobotFile) -> String {
    let laws: Vec<String> = all.iter().map(|d| law(&d.hypothesis, robot)).collect();
    let laws = listed(&laws, "and");
    match all.iter().all(|d| d.beside) {
        true if all.len() > NAMED_LAWS_MAX => {
            format!(
                "Beside what the library explains the logs ask for {} laws outside it.",
                all.len()
            )
        }
        true => format!("Beside what the library explains the logs ask for {laws}."),
        false => format!("What is missing is no effect of the library: {laws}."),
    }
}

/// Its formula, what of the library is like it, and what the logs do not tell from it.
pub(crate) fn details(discovery: &Discovery, robot: &RobotFile) -> Vec<String> {
    let formula = match &discovery.expression {
        Some(expression) => format!("It follows {expression}: {}.", values(&discovery.effect)),
        None => {
            let what = if discovery.curve.surface.is_some() { "surface" } else { "curve" };
            let curve = ["No formula describes it better than the ", what, " does"].concat();
            let spring = values(&discovery.effect);
            match spring.is_empty() {
                true => curve + ".",
                false => [curve.as_str(), ", beside a spring over the same angle: ", &spring, "."]
                    .concat(),
            }
        }
    };
    let like = discovery.like.as_ref().map(|like| {
        let (name, left) = (like_name(like, robot), score(like.held_out));
        if like.effects.iter().any(FittedEffect::is_unseen_wave) {
            let much = "of which these logs hold too little to tell it from other curves";
            format!("The library's nearest, {name}, leaves the score at {left}, with a piece of a wave {much}.")
        } else if like.effects.iter().all(|f| f.effect.at == discovery.hypothesis.at) {
            format!("It is like {name}, but not {name}, which leaves the score at {left}.")
        } else {
            format!("The library's nearest, {name}, leaves the score at {left}.")
        }
    });
    let level = discovery.curve.level.map(|level| {
        let (unit, plain) = (discovery.hypothesis.y_unit(), discovery.hypothesis.port.unit);
        let level = match unit == plain {
            true => Scale::small(plain).quantity(level),
            false => format!("{} {unit}", digits(level, 3)),
        };
        format!(
            "These logs leave its level open by ± {level}, for a calibration makes a constant as well; lines over it are drawn at its level."
        )
    });
    let own = law(&discovery.hypothesis, robot);
    let mut tied: Vec<String> = Vec::new();
    for other in discovery.tied.iter().map(|t| law(&t.hypothesis, robot)) {
        if other != own && !tied.contains(&other) {
            tied.push(other);
        }
    }
    let tied = (!tied.is_empty())
        .then(|| format!("These logs explain as well with {}.", listed(&tied, "or")));
    std::iter::once(formula).chain(level).chain(like).chain(tied).collect()
}

/// All of it in a paragraph.
pub(crate) fn paragraph(discovery: &Discovery, robot: &RobotFile) -> String {
    let found = [headline(std::slice::from_ref(discovery), robot), explanation(discovery)];
    found.into_iter().chain(details(discovery, robot)).collect::<Vec<_>>().join(" ")
}

/// One among several, in a paragraph.
pub(crate) fn one_of(discovery: &Discovery, robot: &RobotFile) -> String {
    let found =
        [format!("{}.", capital(&law(&discovery.hypothesis, robot))), explanation(discovery)];
    found.into_iter().chain(details(discovery, robot)).collect::<Vec<_>>().join(" ")
}

/// Names of an explanation within the library.
pub(crate) fn like_name(like: &LikeEffect, robot: &RobotFile) -> String {
    let mut names: Vec<String> = Vec::new();
    for name in like.effects.iter().map(|f| f.effect.name(robot)) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    listed(&names, "and")
}

/// Values of a law's parameters with their intervals, in the units of its expression, without those
/// of a table.
fn values(found: &FittedEffect) -> String {
    let Action::Expression(law) = found.effect.kind.action else { return String::new() };
    let named = law.definition.named().len();
    let all = found.effect.kind.parameters.iter().zip(&found.effect.values).take(named);
    let told = all.zip(&found.interval).map(|((parameter, value), interval)| {
        let scale =
            Scale { factor: 1.0, unit: if parameter.unit == "1" { "" } else { parameter.unit } };
        format!("{} {}", parameter.name.replace('_', " "), scale.with_interval(*value, *interval))
    });
    told.collect::<Vec<_>>().join(", ")
}

/// By how much the error falls, what kind of physics makes such curves, without a name for it, and
/// what it explains.
pub(crate) fn explanation(discovery: &Discovery) -> String {
    let hypothesis = &discovery.hypothesis;
    let names = hypothesis.variables();
    let has = |name: &str| names.iter().any(|n| n.contains(name));
    let kind = if hypothesis.turns_over.is_some() {
        "It turns round behind every reversal, over a way and at any speed: something rubs there that gives a little before it \
         slides."
    } else if has("time") && has("rate") {
        "It resists motion, more or less of it as time goes on: something warms up, runs in or wears there."
    } else if hypothesis.times.starts_with("tanh") {
        "It changes its sign with the sense of motion: something rubs there, more in one place, at one speed or under one load \
         than in another."
    } else if hypothesis.port.name == "recorded-torque"
        || hypothesis.port.name.contains("tracker")
        || hypothesis.port.name.contains("sensor")
        || hypothesis.port.name == "link-encoder"
    {
        "Nothing in the arm needs to move for it: an instrument reads more or less than there is, by what it measures or by when."
    } else if has("time") {
        "It follows the time since the log began, whatever the arm does: something warms up, runs in or comes to rest."
    } else if has("rate") || names.contains(&"vx") {
        "It grows with speed: something there resists motion, or is driven by it."
    } else if has("twist") || has("torque") || has("force") {
        "It follows the load that is carried: something gives, tightens or slips under it."
    } else if names.contains(&"x") {
        "It follows the place along the seam, whatever the time: the plate, its clamping or its material differ from place to \
         place."
    } else {
        "It is the same in both senses of motion and at every speed: something that is carried along, stretched, lifted or pressed \
         upon as the joint turns, and gives back what it took."
    };
    let of = match discovery.beside {
        true => "what the effects before it leave, every channel weighed alike",
        false => "what lies above the noise floor beside the calibrations",
    };
    // Of one among several the score says little: the worst channel rules it.
    let falls = match discovery.beside {
        true => String::new(),
        false => format!(
            "With it the score falls from {} to {} where it was not fitted. ",
            score(discovery.held_out_before),
            score(discovery.held_out_after)
        ),
    };
    let explained = share((1.0 - discovery.left).clamp(0.0, 1.0));
    format!("{falls}{kind} It explains {explained} of {of}.")
}

/// Above the curve.
pub(crate) const CURVE: &str = "The law that was found outside the library: points are what the \
     measurements ask for, with standard errors, the band is of 95 %";

/// Above what of it the library's nearest does not make.
pub(crate) const NEAREST_EFFECT_HEADING: &str =
    "What the library's nearest effect leaves of the curve";
