//! Gains for a robot that is not ours: from the model to gains of all three controllers and of every
//! law, by the margins that requirements ask for and the response to a step of the push.
//!
//! Closed forms from the arm along the weld ([`ArmAt`]) are the beginning; a search turns one gain at
//! a time until margins and response are as asked, or nothing gets better. What the gains are then
//! worth is shown by runs: a step and a weld with each controller, a weld with each law, and the
//! margins along the whole weld. What is closest to its limit is what limits the loop.
//!
//! Left out: ripple and noise of the instruments are in the runs and not in the margins; gains of
//! a law that set no pace (priors, cross-talk) stay as they are.

mod arm;
mod asked;
mod rating;
mod search;

pub use asked::{AskedResponse, TuneError};
pub use rating::{LoopCriterion, Rating, worst};

use crate::arm::ArmAt;
use crate::figure::Limit;
use crate::laws::NoFigures;
use crate::requirements::MarginLimits;
use crate::step::StepFigures;
use crate::weld::{JudgedFigure, WeldFigures};
use arm::{arm_along, closed_form, force_delay};
use rating::rate_step;
use rayon::prelude::*;
use search::{Judge, rounded};
use trueweld_compensators::{Entry, Uncompensated};
use trueweld_plant::cell::Cell;
use trueweld_plant::input::Control;
use trueweld_plant::simulate::{
    ControllerKind, LimitKind, LimitSpan, Scenario, WeldProgram, run_passes,
};

/// A robot to be tuned, at a weld.
#[derive(Debug, Clone, Copy)]
pub struct TuneTask<'a> {
    /// Weld, cell, instruments and what the controller believes in. Its gains are where the search
    /// begins if `from_file`; program, controller and law are not used.
    pub scenario: Scenario<'a>,
    /// The scenario's cell without ripple, which margins are of.
    pub still: &'a Cell,
    /// The search begins with the scenario's gains instead of closed forms.
    pub from_file: bool,
    /// The margins asked for.
    pub margins: &'a MarginLimits,
    /// The response asked for.
    pub response: AskedResponse,
    /// Laws to be tuned, on top of the external controller.
    pub laws: &'a [Entry],
}

/// A weld with the gains that were found, or why there is none.
pub type WeldOutcome = Result<WeldFigures, String>;

/// A tuned controller, and what it is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct TunedController {
    /// Which.
    pub controller: ControllerKind,
    /// Each margin where it is least along the weld, without compensation.
    pub margins: Vec<Rating>,
    /// What the step came to; `None` where it came to no end.
    pub step: Option<StepFigures>,
    /// The same against what is asked.
    pub response: Vec<Rating>,
    /// The weld without compensation.
    pub weld: WeldOutcome,
}

/// A tuned law, and what it is worth.
#[derive(Debug, Clone)]
pub struct TunedLaw {
    /// The law.
    pub law: Entry,
    /// Each margin where it is least along the weld.
    pub margins: Vec<Rating>,
    /// The weld.
    pub weld: WeldOutcome,
}

/// Figures of a weld that are a controller's own, whatever the arm's deflection.
const OF_CONTROLLER: [&str; 2] = ["push_mean_n", "speed_mean_m_s"];

/// What a weld stood at that no gains can be shown by: a drive at its limit, a fault.
pub fn stood(weld: &WeldFigures) -> impl Iterator<Item = &LimitSpan> {
    let stands = |kind| matches!(kind, LimitKind::Torque(_) | LimitKind::Fault(_));
    weld.limits.iter().filter(move |span| stands(span.kind))
}

impl TunedController {
    /// Margins, step and weld are as asked.
    pub fn is_confirmed(&self) -> bool {
        let own = |weld: &WeldFigures| {
            let of = |judged: &&JudgedFigure| OF_CONTROLLER.contains(&judged.figure.key);
            stood(weld).next().is_none() && weld.judged.iter().filter(of).all(|judged| judged.met)
        };
        self.ratings().all(Rating::is_met) && self.weld.as_ref().is_ok_and(own)
    }

    /// Everything that is asked of it.
    pub fn ratings(&self) -> impl Iterator<Item = &Rating> {
        self.margins.iter().chain(&self.response)
    }
}

impl TunedLaw {
    /// The margins are kept, and the weld is the one that was asked for.
    pub fn is_confirmed(&self) -> bool {
        let met = |weld: &WeldFigures| stood(weld).next().is_none() && weld.met;
        self.margins.iter().all(Rating::is_met) && self.weld.as_ref().is_ok_and(met)
    }
}

/// Gains, and what they are worth.
#[derive(Debug, Clone)]
pub struct Tuning {
    /// The gains, to three digits.
    pub control: Control,
    /// The arm along the weld.
    pub arm: Vec<ArmAt>,
    /// How late slow signals of the external force loop are, s.
    pub force_delay: f64,
    /// The response asked for.
    pub response: AskedResponse,
    /// The margins asked for, those of the drives too.
    pub asked: Vec<Limit>,
    /// The three controllers.
    pub controllers: Vec<TunedController>,
    /// The laws, on top of the external controller.
    pub laws: Vec<TunedLaw>,
}

/// Tunes, and shows what came of it. `progress` is told what is being done, and the share done.
///
/// # Errors
/// [`TuneError`].
pub fn tune(
    task: &TuneTask<'_>,
    progress: impl Fn(&'static str, f64) + Sync,
) -> Result<Tuning, TuneError> {
    let scenario = &task.scenario;
    let asked = &task.margins.at_least;
    let arm = arm_along(scenario, task.margins.places)?;
    let judge = Judge {
        scenario: *scenario,
        still: task.still,
        margins: asked,
        places: task.margins.places,
        response: &task.response,
    };
    let mut control = if task.from_file {
        scenario.control.clone()
    } else {
        closed_form(scenario, &task.response, &arm)
    };
    progress("controllers", 0.0);
    let all = ControllerKind::required();
    let found = all.par_iter().map(|controller| judge.search(&control, *controller));
    for (controller, found) in all.iter().zip(found.collect::<Vec<_>>()) {
        let found = found?;
        match *controller {
            ControllerKind::PARALLEL => control.parallel = found.parallel,
            ControllerKind::SUPERPOSED => control.superposed = found.superposed,
            _ => control.external = found.external,
        }
    }
    progress("laws", 0.5);
    let control = rounded(&paced_laws(&judge, control, task.laws)?);
    progress("confirmation", 0.8);
    let controllers = all.par_iter().map(|controller| {
        let none = Entry::of::<Uncompensated>();
        let step = judge.step(&control, *controller)?;
        Ok(TunedController {
            controller: *controller,
            margins: judge.rate(&judge.map(&control, *controller, &none)?),
            response: rate_step(&task.response, step.as_ref()),
            step,
            weld: weld(&judge.with(&control, *controller, &none)),
        })
    });
    let controllers = controllers.collect::<Result<_, TuneError>>()?;
    let laws = task.laws.par_iter().map(|law| {
        Ok(TunedLaw {
            law: law.clone(),
            margins: judge.rate(&judge.map(&control, ControllerKind::EXTERNAL, law)?),
            weld: weld(&judge.with(&control, ControllerKind::EXTERNAL, law)),
        })
    });
    let laws = laws.collect::<Result<_, TuneError>>()?;
    let w = arm::pace(&control.external.joint, &arm[0]);
    Ok(Tuning {
        force_delay: force_delay(scenario, w),
        response: task.response,
        asked: asked.clone(),
        arm,
        controllers,
        laws,
        control,
    })
}

/// The gains with those of the laws: first how fast the laws' demand is followed, by the laws that
/// set no pace of their own, then each law by itself.
fn paced_laws(
    judge: &Judge<'_>,
    mut control: Control,
    laws: &[Entry],
) -> Result<Control, TuneError> {
    let reads = |law: &Entry| law.needs().force_sensor || law.needs().motor_torque;
    for law in laws.iter().filter(|law| law.pace().is_empty() && !reads(law)) {
        control = judge.pace(law, |share| {
            let mut slower = control.clone();
            slower.compensation.following.rate *= share;
            slower.compensation.following.along *= share;
            slower
        })?;
    }
    let spindle = judge.scenario.planned.spindle.abs() / std::f64::consts::TAU;
    let paced = laws.par_iter().filter(|law| !law.pace().is_empty()).map(|law| {
        Ok((law.name(), judge.pace(law, |share| paced(&control, law, spindle, share))?))
    });
    for (name, found) in paced.collect::<Result<Vec<_>, TuneError>>()? {
        if let Some(gains) = found.laws.get(name) {
            control.laws.insert(name.to_owned(), gains.clone());
        }
    }
    Ok(control)
}

/// The gains with those that set the pace of a law at a share of their values. `spindle`: its
/// speed, Hz.
fn paced(control: &Control, law: &Entry, spindle: f64, share: f64) -> Control {
    let own = law.gains(&control.laws);
    let mut gains = own.clone();
    for key in law.pace() {
        let Some(value) = own.get(*key).and_then(toml::Value::as_float) else { continue };
        // A filter stands below the spindle's line.
        let below = if key.ends_with("_hz") { 0.5 * spindle } else { f64::INFINITY };
        gains.insert((*key).to_owned(), (share * value.min(below)).into());
    }
    let mut next = control.clone();
    next.laws.insert(law.name().to_owned(), gains);
    next
}

/// The weld, after one pass where the law learns from pass to pass.
fn weld(scenario: &Scenario<'_>) -> WeldOutcome {
    let scenario = Scenario { program: WeldProgram::Weld, ..*scenario };
    let passes = if scenario.law.needs().passes { 2 } else { 1 };
    let recording = run_passes(&scenario, passes, |_| {}).map_err(|error| error.to_string())?;
    WeldFigures::of(&recording).ok_or_else(|| NoFigures::NotSteady.to_string())
}
