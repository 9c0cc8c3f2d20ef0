//! The search for gains: one at a time, up or down by a factor, as an engineer turns them; margins
//! first, then the response.
//!
//! Nothing is drawn: the same robot and the same requirements give the same gains.

use super::rating::{Rating, rate_margins, rate_step, worst};
use super::{AskedResponse, TuneError};
use crate::figure::Limit;
use crate::margins::{Margins, margin_map, margins};
use crate::step::StepFigures;
use rayon::prelude::*;
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_core::control::JointGains;
use trueweld_plant::cell::Cell;
use trueweld_plant::input::{Control, ParallelGains};
use trueweld_plant::simulate::{Controller, Program, RunError, Scenario, run};

/// A gain, or several that belong together, that is turned by a factor.
#[derive(Debug, Clone, Copy)]
struct Knob(fn(&mut Control, Controller, f64));

/// What can be turned, in the order in which it is.
const KNOBS: [Knob; 6] = [
    Knob(|control, controller, f| match controller {
        Controller::External => control.external.force.ki *= f,
        _ => parallel(control, controller).force.ki *= f,
    }),
    // The pace of the position loop; its damping ratio stays.
    Knob(|control, controller, f| {
        let joint = joint(control, controller);
        joint.kp *= f * f;
        joint.kd *= f;
        joint.ki *= f * f * f;
    }),
    Knob(|control, controller, f| joint(control, controller).kd *= f),
    Knob(|control, controller, f| joint(control, controller).ki *= f),
    Knob(|control, controller, f| match controller {
        Controller::External => control.external.force.kp *= f,
        _ => parallel(control, controller).force.kd *= f,
    }),
    Knob(|control, controller, f| match controller {
        Controller::External => {}
        _ => parallel(control, controller).force.max_rate *= f,
    }),
];

fn parallel(control: &mut Control, controller: Controller) -> &mut ParallelGains {
    if controller == Controller::Superposed {
        &mut control.superposed
    } else {
        &mut control.parallel
    }
}

fn joint(control: &mut Control, controller: Controller) -> &mut JointGains<f64> {
    match controller {
        Controller::External => &mut control.external.joint,
        _ => &mut parallel(control, controller).joint,
    }
}

/// Factors by which a knob is turned, the coarse first.
const FACTORS: [f64; 3] = [1.4, 1.18, 1.08];

/// Most gains that are tried of a controller.
const MOST: usize = 80;

/// What is to be used up at most of what is allowed, so that the last digit of a gain does not
/// decide.
const AIM: f64 = 0.97;

/// Rounds in which places are added that turned out to be worse than those looked at.
const ROUNDS: usize = 4;

/// How gains are judged.
#[derive(Debug, Clone, Copy)]
pub(super) struct Judge<'a> {
    pub scenario: Scenario<'a>,
    /// The scenario's cell without ripple, which margins are of.
    pub still: &'a Cell,
    pub margins: &'a [Limit],
    /// Places along the weld.
    pub places: usize,
    pub response: &'a AskedResponse,
}

/// What gains came to.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Judged {
    pub margins: Vec<Rating>,
    pub response: Vec<Rating>,
}

impl Judged {
    /// What counts, the first before the second: 0 where all that is asked is reached.
    fn score(&self) -> [f64; 2] {
        [&self.margins, &self.response].map(|all| excess(all))
    }
}

fn excess(ratings: &[Rating]) -> f64 {
    let used = worst(ratings).map_or(0.0, |rating| rating.used);
    if used <= AIM { 0.0 } else { used }
}

/// The step of the push, s: time to rest before it, and time recorded after it.
const STEP: [f64; 2] = [1.0, 3.0];

impl<'a> Judge<'a> {
    /// The same scenario with these gains.
    pub fn with<'b>(
        &self,
        control: &'b Control,
        controller: Controller,
        law: &'b Entry,
    ) -> Scenario<'b>
    where
        'a: 'b,
    {
        Scenario { control, controller, law, ..self.scenario }
    }

    /// The loop along the whole weld.
    pub fn map(
        &self,
        control: &Control,
        controller: Controller,
        law: &Entry,
    ) -> Result<Vec<Margins>, TuneError> {
        let scenario = Scenario { cell: self.still, ..self.with(control, controller, law) };
        Ok(margin_map(&scenario, self.places)?)
    }

    /// The step; `None` where the loop runs away, or a drive is at its limit.
    pub fn step(
        &self,
        control: &Control,
        controller: Controller,
    ) -> Result<Option<StepFigures>, TuneError> {
        let none = Entry::of::<Uncompensated>();
        let [hold, length] = STEP;
        let program = Program::ForceStep { height: self.response.height, hold, length };
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

    /// Margins at some places.
    fn margins_at(
        &self,
        control: &Control,
        controller: Controller,
        law: &Entry,
        spots: &[f64],
    ) -> Result<Vec<Rating>, TuneError> {
        let scenario = Scenario { cell: self.still, ..self.with(control, controller, law) };
        let map: Result<Vec<Margins>, RunError> =
            spots.par_iter().map(|path| margins(&scenario, *path)).collect();
        Ok(rate_margins(self.margins, &map?))
    }

    /// Gains of a controller from some to begin with.
    pub fn search(&self, start: &Control, controller: Controller) -> Result<Control, TuneError> {
        let none = Entry::of::<Uncompensated>();
        let mut best = rounded(start);
        let mut spots: Vec<f64> = Vec::new();
        for _ in 0..ROUNDS {
            let map = self.map(&best, controller, &none)?;
            let new = worst_spots(self.margins, &map, &spots);
            let judged = Judged {
                margins: rate_margins(self.margins, &map),
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
        controller: Controller,
        law: &Entry,
        spots: &[f64],
    ) -> Result<Control, TuneError> {
        let judge = |control: &Control| {
            Ok::<_, TuneError>(Judged {
                margins: self.margins_at(control, controller, law, spots)?,
                response: rate_step(self.response, self.step(control, controller)?.as_ref()),
            })
        };
        let mut best = start;
        let mut score = judge(&best)?.score();
        let mut tried = 0;
        for factor in FACTORS {
            let mut improved = true;
            while improved && score != [0.0; 2] && tried < MOST {
                improved = false;
                for Knob(turn) in KNOBS {
                    for by in [factor, factor.recip()] {
                        // On, as long as it gets better.
                        while score != [0.0; 2] && tried < MOST {
                            let mut next = best.clone();
                            turn(&mut next, controller, by);
                            let next = rounded(&next);
                            if next == best {
                                break;
                            }
                            tried += 1;
                            // The step is quick: where only it can be better, it decides first.
                            if score[0] == 0.0 {
                                let step = self.step(&next, controller)?;
                                let response = rate_step(self.response, step.as_ref());
                                if excess(&response) >= score[1] {
                                    break;
                                }
                            }
                            let of_next = judge(&next)?.score();
                            if of_next.partial_cmp(&score) != Some(std::cmp::Ordering::Less) {
                                break;
                            }
                            (best, score, improved) = (next, of_next, true);
                        }
                    }
                }
            }
        }
        Ok(best)
    }

    /// The gains at the fastest pace of a law at which the margins are kept; at its own pace where
    /// none keeps them. `paced`: the gains at a share of that pace.
    pub fn pace(&self, law: &Entry, paced: impl Fn(f64) -> Control) -> Result<Control, TuneError> {
        let (controller, own) = (Controller::External, rounded(&paced(1.0)));
        let kept = |map: &[Margins]| rate_margins(self.margins, map).iter().all(Rating::is_met);
        let map = self.map(&own, controller, law)?;
        if kept(&map) {
            return Ok(own);
        }
        let mut spots = worst_spots(self.margins, &map, &[]);
        for k in 1..=PACES {
            let slower = rounded(&paced(PACE.powi(-k)));
            let there = self.margins_at(&slower, controller, law, &spots)?;
            if !there.iter().all(Rating::is_met) {
                continue;
            }
            let map = self.map(&slower, controller, law)?;
            if kept(&map) {
                return Ok(slower);
            }
            spots.extend(worst_spots(self.margins, &map, &spots));
        }
        Ok(own)
    }
}

/// Paces that are tried of a law, and the factor between them.
const PACES: i32 = 6;
const PACE: f64 = 1.25;

/// Places, not looked at yet, where something that is asked for is missed, or closest to it.
fn worst_spots(asked: &[Limit], map: &[Margins], known: &[f64]) -> Vec<f64> {
    let mut spots: Vec<f64> = Vec::new();
    for limit in asked {
        let used = |at: &Margins| {
            let ratings = rate_margins(std::slice::from_ref(limit), std::slice::from_ref(at));
            worst(&ratings).map_or(0.0, |rating| rating.used)
        };
        let worst = map.iter().reduce(|a, b| if used(b) > used(a) { b } else { a });
        // One that is nearly as bad as those looked at tells nothing new.
        let told = map
            .iter()
            .filter(|at| known.contains(&at.path) || spots.contains(&at.path))
            .map(used)
            .fold(0.0, f64::max);
        if let Some(at) = worst.filter(|at| used(at) > 1.02 * told) {
            spots.push(at.path);
        }
    }
    spots
}

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
    [&mut limits.following.rate, &mut limits.following.size].into_iter().for_each(round);
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
