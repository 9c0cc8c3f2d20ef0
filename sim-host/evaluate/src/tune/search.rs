//! The search for gains: one at a time, up or down by a factor, as an engineer turns them; margins
//! first, then the response.
//!
//! Nothing is drawn: the same robot and the same requirements give the same gains.

use super::rating::{LoopCriterion, Rating, rate_margins, rate_step, worst};
use super::{AskedResponse, TuneError};
use crate::figure::Limit;
use crate::margins::{Condition, Margins, margin_map, margins};
use crate::step::StepFigures;
use rayon::prelude::*;
use std::cmp::Ordering;
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_core::control::JointGains;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{Control, ParallelGains};
use trueweld_plant::simulate::{ControllerKind, RunError, Scenario, WeldProgram, run};

/// A gain, or several that belong together, that is turned by a factor.
#[derive(Debug, Clone, Copy)]
struct Knob {
    /// Of the position loop; the others are of the force loop.
    position: bool,
    turn: fn(&mut Control, ControllerKind, f64),
}

/// What can be turned, in the order in which it is.
const KNOBS: [Knob; 6] = [
    // The pace of the force loop.
    Knob {
        position: false,
        turn: |control, controller, f| match controller {
            ControllerKind::EXTERNAL => control.external.force.ki *= f,
            _ => parallel(control, controller).force.ki *= f,
        },
    },
    // The pace of the position loop; its damping ratio stays.
    Knob {
        position: true,
        turn: |control, controller, f| {
            let joint = joint(control, controller);
            joint.kp *= f * f;
            joint.kd *= f;
            joint.ki *= f * f * f;
        },
    },
    Knob { position: true, turn: |control, controller, f| joint(control, controller).kd *= f },
    Knob { position: true, turn: |control, controller, f| joint(control, controller).ki *= f },
    Knob {
        position: false,
        turn: |control, controller, f| match controller {
            ControllerKind::EXTERNAL => control.external.force.kp *= f,
            _ => parallel(control, controller).force.kd *= f,
        },
    },
    Knob {
        position: false,
        turn: |control, controller, f| {
            if controller != ControllerKind::EXTERNAL {
                parallel(control, controller).force.max_rate *= f;
            }
        },
    },
];

fn parallel(control: &mut Control, controller: ControllerKind) -> &mut ParallelGains {
    if controller == ControllerKind::SUPERPOSED {
        &mut control.superposed
    } else {
        &mut control.parallel
    }
}

fn joint(control: &mut Control, controller: ControllerKind) -> &mut JointGains<f64> {
    match controller {
        ControllerKind::EXTERNAL => &mut control.external.joint,
        _ => &mut parallel(control, controller).joint,
    }
}

/// Factors by which a knob is turned, the coarse first.
const KNOB_FACTORS: [f64; 3] = [1.4, 1.18, 1.08];

/// Most gains that are tried in a round.
const ROUND_GAINS_MAX: usize = 40;

/// What is to be used up at most of what is allowed, so that the last digit of a gain does not
/// decide.
const AIM: f64 = 0.97;

/// Rounds in which conditions are added that turned out to be worse than those looked at.
const CONDITION_ROUNDS: usize = 3;

/// How gains are judged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge<'a> {
    /// The run that gains are judged by.
    pub scenario: Scenario<'a>,
    /// The scenario's cell without ripple, which margins are of.
    pub still: &'a Cell,
    /// The least that each margin is to be, in the unit of its key.
    pub margins: &'a [Limit],
    /// Places along the weld.
    pub places: usize,
    /// What is asked of a step of the push.
    pub response: &'a AskedResponse,
}

/// What gains came to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JudgedGains {
    /// Margins over the places and conditions looked at.
    pub margins: Vec<Rating>,
    /// The step of the push.
    pub response: Vec<Rating>,
}

impl JudgedGains {
    /// What counts, the first before the second: 0 where all that is asked is reached.
    fn score(&self) -> [f64; 2] {
        [&self.margins, &self.response].map(|all| excess(all))
    }
}

impl JudgedGains {
    /// What is to be mended first.
    fn binding(&self) -> Option<LoopCriterion> {
        let group = if excess(&self.margins) > 0.0 { &self.margins } else { &self.response };
        worst(group).map(|rating| rating.criterion)
    }
}

/// What to turn and by which factor, the likeliest to help first.
fn turns(binding: Option<LoopCriterion>, factor: f64) -> Vec<(Knob, f64)> {
    let of_drives = binding.is_some_and(|criterion| criterion.is_of_drives());
    let faster = matches!(binding, Some(LoopCriterion::Settling | LoopCriterion::StaticError));
    let by = if faster { [factor, factor.recip()] } else { [factor.recip(), factor] };
    let mut knobs = KNOBS;
    knobs.sort_by_key(|knob| knob.position != of_drives);
    knobs.iter().flat_map(|knob| by.map(|by| (*knob, by))).collect()
}

/// By how much more than is aimed at is used up, over all that is asked: what is missed by most must
/// not hide the others.
fn excess(ratings: &[Rating]) -> f64 {
    ratings.iter().map(|rating| rating.used - AIM).filter(|beyond| *beyond > 0.0).sum()
}

/// The step of the push, s: time to rest before it, and time recorded after it.
const PUSH_STEP_TIMES: [f64; 2] = [1.0, 3.0];

impl<'a> Judge<'a> {
    /// The same scenario with these gains.
    pub(crate) fn with<'b>(
        &self,
        control: &'b Control,
        controller: ControllerKind,
        law: &'b Entry,
    ) -> Scenario<'b>
    where
        'a: 'b,
    {
        Scenario { control, controller, law, ..self.scenario }
    }

    /// Margins against what is asked.
    pub(crate) fn rate(&self, map: &[Margins]) -> Vec<Rating> {
        rate_margins(self.margins, map)
    }

    /// The loop along the whole weld, with every slope of friction.
    pub(crate) fn map(
        &self,
        control: &Control,
        controller: ControllerKind,
        law: &Entry,
    ) -> Result<Vec<Margins>, TuneError> {
        let scenario = Scenario { cell: self.still, ..self.with(control, controller, law) };
        Ok(margin_map(&scenario, self.places)?)
    }

    /// The step; `None` where the loop runs away, or a drive is at its limit.
    pub(crate) fn step(
        &self,
        control: &Control,
        controller: ControllerKind,
    ) -> Result<Option<StepFigures>, TuneError> {
        let none = Entry::of::<Uncompensated>();
        let [hold, length] = PUSH_STEP_TIMES;
        let program = WeldProgram::ForceStep { height: self.response.height, hold, length };
        let scenario = Scenario { program, ..self.with(control, controller, &none) };
        let at = scenario.weld.settle + hold;
        match run(&scenario, |_| {}) {
            Ok(recording) => {
                let stood = recording.rows.iter().any(|r| r.limited.torque || r.fault.is_some());
                let figures = StepFigures::of(&recording, at, self.response.height);
                Ok(figures.filter(|_| !stood))
            }
            Err(RunError::RanAway { .. }) => Ok(None),
            Err(error) => Err(error.into()),
        }
    }

    /// Margins under some conditions.
    fn margins_at(
        &self,
        control: &Control,
        controller: ControllerKind,
        law: &Entry,
        spots: &[Condition],
    ) -> Result<Vec<Rating>, TuneError> {
        let scenario = Scenario { cell: self.still, ..self.with(control, controller, law) };
        let look = |of: &Condition| margins(&scenario, &of.at, of.friction);
        let map: Result<Vec<Margins>, RunError> = spots.par_iter().map(look).collect();
        Ok(self.rate(&map?))
    }

    /// Gains of a controller from some to begin with.
    pub(crate) fn search(
        &self,
        start: &Control,
        controller: ControllerKind,
    ) -> Result<Control, TuneError> {
        let none = Entry::of::<Uncompensated>();
        let mut best = rounded(start);
        let mut spots: Vec<Condition> = Vec::new();
        for _ in 0..CONDITION_ROUNDS {
            let map = self.map(&best, controller, &none)?;
            let new = self.worst_spots(&map, &spots);
            let judged = JudgedGains {
                margins: self.rate(&map),
                response: rate_step(self.response, self.step(&best, controller)?.as_ref()),
            };
            if judged.score() == [0.0; 2] || (new.is_empty() && !spots.is_empty()) {
                break;
            }
            spots.extend(new);
            best = self.turned(best, controller, &none, &spots)?;
        }
        Ok(best)
    }

    /// Turns one knob after the other while that makes it better.
    fn turned(
        &self,
        start: Control,
        controller: ControllerKind,
        law: &Entry,
        spots: &[Condition],
    ) -> Result<Control, TuneError> {
        let judge = |control: &Control| {
            Ok::<_, TuneError>(JudgedGains {
                margins: self.margins_at(control, controller, law, spots)?,
                response: rate_step(self.response, self.step(control, controller)?.as_ref()),
            })
        };
        let mut best = start;
        let mut known = judge(&best)?;
        let mut tried = 0;
        for factor in KNOB_FACTORS {
            let mut improved = true;
            while improved {
                improved = false;
                for (knob, by) in turns(known.binding(), factor) {
                    // On in the same direction, as long as it gets better.
                    while known.score() != [0.0; 2] && tried < ROUND_GAINS_MAX {
                        let mut next = best.clone();
                        (knob.turn)(&mut next, controller, by);
                        let next = rounded(&next);
                        if next == best {
                            break;
                        }
                        tried += 1;
                        if !self.may_be_better(&next, controller, &known)? {
                            break;
                        }
                        let of_next = judge(&next)?;
                        if of_next.score().partial_cmp(&known.score()) != Some(Ordering::Less) {
                            break;
                        }
                        (best, known, improved) = (next, of_next, true);
                    }
                    // What is closest to its limit may be another now.
                    if improved {
                        break;
                    }
                }
            }
        }
        Ok(best)
    }

    /// A step is quick: where only the response can be better, it decides before the margins are
    /// looked at.
    fn may_be_better(
        &self,
        next: &Control,
        controller: ControllerKind,
        known: &JudgedGains,
    ) -> Result<bool, TuneError> {
        let [margins, response] = known.score();
        if margins > 0.0 {
            return Ok(true);
        }
        let step = self.step(next, controller)?;
        Ok(excess(&rate_step(self.response, step.as_ref())) < response)
    }

    /// The gains at the fastest pace of a law at which the margins are kept, or at which they are
    /// missed by least. `paced`: the gains at a share of its own pace.
    pub(crate) fn pace(
        &self,
        law: &Entry,
        paced: impl Fn(f64) -> Control,
    ) -> Result<Control, TuneError> {
        let (controller, own) = (ControllerKind::EXTERNAL, rounded(&paced(1.0)));
        let kept = |map: &[Margins]| self.rate(map).iter().all(Rating::is_met);
        let map = self.map(&own, controller, law)?;
        if kept(&map) {
            return Ok(own);
        }
        let mut spots = self.worst_spots(&map, &[]);
        let mut least = (excess(&self.rate(&map)), own);
        for k in 1..=PACES {
            let slower = rounded(&paced(PACE.powi(-k)));
            let mut there = self.margins_at(&slower, controller, law, &spots)?;
            if there.iter().all(Rating::is_met) {
                let map = self.map(&slower, controller, law)?;
                if kept(&map) {
                    return Ok(slower);
                }
                there = self.rate(&map);
                spots.extend(self.worst_spots(&map, &spots));
            }
            if excess(&there) < least.0 {
                least = (excess(&there), slower);
            }
        }
        Ok(least.1)
    }

    /// Conditions, not looked at yet, under which something that is asked for is missed, or closest to
    /// it.
    fn worst_spots(&self, map: &[Margins], known: &[Condition]) -> Vec<Condition> {
        let mut spots: Vec<Condition> = Vec::new();
        for limit in self.margins {
            let used = |at: &Margins| {
                let (asked, map) = (std::slice::from_ref(limit), std::slice::from_ref(at));
                worst(&rate_margins(asked, map)).map_or(0.0, |rating| rating.used)
            };
            let worst = map.iter().reduce(|a, b| if used(b) > used(a) { b } else { a });
            // One that is nearly as bad as those looked at tells nothing new.
            let told = map
                .iter()
                .filter(|at| known.contains(&at.of) || spots.contains(&at.of))
                .map(used)
                .fold(0.0, f64::max);
            if let Some(at) = worst.filter(|at| used(at) > 1.02 * told) {
                spots.push(at.of);
            }
        }
        spots
    }
}

/// Paces that are tried of a law, and the factor between them.
const PACES: i32 = 10;
const PACE: f64 = 1.25;

/// Gains to three digits, as a file states them.
pub(super) fn rounded(control: &Control) -> Control {
    let mut control = control.clone();
    let round = |value: &mut f64| *value = three_digits(*value);
    let gains = |joint: &mut JointGains<f64>| {
        [&mut joint.kp, &mut joint.ki, &mut joint.kd]
            .into_iter()
            .for_each(|each| each.iter_mut().for_each(round));
    };
    for scheme in [&mut control.parallel, &mut control.superposed] {
        gains(&mut scheme.joint);
        let force = &mut scheme.force;
        [
            &mut force.kp,
            &mut force.ki,
            &mut force.kd,
            &mut force.max_correction,
            &mut force.max_rate,
        ]
        .into_iter()
        .for_each(round);
    }
    gains(&mut control.external.joint);
    let force = &mut control.external.force;
    [&mut force.kp, &mut force.ki, &mut force.kd, &mut force.material_stiffness]
        .into_iter()
        .chain([&mut force.tuned_stiffness, &mut force.max_correction, &mut force.max_rate])
        .for_each(round);
    let limits = &mut control.compensation;
    for each in [&mut limits.lateral, &mut limits.orientation] {
        // Stated in Hz.
        each.bandwidth =
            three_digits(each.bandwidth / std::f64::consts::TAU) * std::f64::consts::TAU;
        [&mut each.size, &mut each.rate].into_iter().for_each(round);
    }
    let following = &mut limits.following;
    [&mut following.rate, &mut following.along, &mut following.size].into_iter().for_each(round);
    for table in control.laws.values_mut() {
        for (_, value) in table.iter_mut() {
            if let toml::Value::Float(value) = value {
                round(value);
            }
        }
    }
    control
}

/// A number to three digits.
pub(super) fn three_digits(value: f64) -> f64 {
    // As it is written is what is read again.
    format!("{value:.2e}").parse().unwrap_or(value)
}
