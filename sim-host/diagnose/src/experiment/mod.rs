//! The experiment that would tell rival explanations apart: chosen from feasible poses, loads and
//! motions by expected separation, and written out as a plan that someone can run.
//!
//! Every procedure that the laboratory's logs show to be possible is made up as a log; the rivals
//! predict it, and what one of them, refitted together with the calibrations, leaves of the other
//! is its expected separation. Left out: how well the logs so far can be trusted beyond their
//! residuals, and what a cell has in the arm's way.

mod cell;
mod procedure;
mod separation;

pub use cell::Channels;
pub use procedure::{
    Changed, Excitation, PEAK, PROCEDURE_DWELL, PlanRow, Procedure, STOP_BRAKE_ONSET,
    STOP_RECORDING_TIME,
};

use cell::ExperimentCell;
use procedure::{ProcedureFamily, procedures};
use rayon::prelude::*;
use separation::{PlannedTrial, Rival, SeparationContext};
use trueweld_core::JOINTS;
use trueweld_estimate::fit::FitProblem;
use trueweld_estimate::fit::calibration::is_calibration;
use trueweld_estimate::predict::PreparedLog;
use trueweld_logs::log::{Log, LogKind};
use trueweld_plant::effects::{Action, Effect, EffectPlace, Location};
use trueweld_plant::robot::Port;

/// Separation from which on rivals count as told apart, standard deviations.
pub const TOLD_APART: f64 = 3.0;

/// Explanations or laws that an experiment is to tell apart, at most.
pub(crate) const RIVALS_MAX: usize = 3;

/// Separation beyond which more of it is worth little: an experiment half as long is worth more.
const PLENTIFUL_SEPARATION: f64 = 10.0;

/// Difference before any refit below which an experiment is not looked at any closer, standard
/// deviations.
const LEAST_APART: f64 = 0.3;

/// An experiment to make next.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What is done.
    pub procedure: Procedure,
    /// What is measured.
    pub channels: Channels,
    /// Names of the two explanations that it is to separate, the likelier first; empty for nothing
    /// beyond calibrations.
    pub rivals: [String; 2],
    /// By how much more of the sum of squares the second leaves in the logs so far.
    pub so_far: f64,
    /// Further explanations, and the separation of the first from each.
    pub others: Vec<(String, f64)>,
    /// Expected √Δχ² between the first two explanations, once calibrations and the values of either
    /// were refitted.
    pub separation: f64,
    /// What it takes of the cell's time, minutes: an estimate.
    pub minutes: f64,
    /// Set points in order: loads at rest, ends of moves, begin and end of a stop or a weld.
    pub rows: Vec<PlanRow>,
    /// The log as it would be driven; channels to be measured hold what a baseline at rest would
    /// show.
    pub log: Log,
}

/// One procedure with what was found of it.
#[derive(Debug)]
struct Tried<'p> {
    procedure: &'p Procedure,
    log: Log,
    rows: Vec<PlanRow>,
    trial: PlannedTrial,
    apart: f64,
}

impl Tried<'_> {
    /// What so much separation is worth for the effort; telling apart comes before all else.
    fn worth(&self, separation: f64) -> f64 {
        let told = if separation >= TOLD_APART { PLENTIFUL_SEPARATION } else { 0.0 };
        told + separation
            / (1.0 + separation / PLENTIFUL_SEPARATION)
            / self.procedure.minutes().sqrt()
    }
}

/// The experiment that tells the first two of `rivals` apart best for its effort: names and fitted
/// effects of the leading explanations, best first; of a single one, it and nothing at all. `logs`:
/// those that `problem` was made of, in its order.
///
/// `None` where no procedure is feasible, or no prediction of any differs.
pub fn next_experiment(
    problem: &FitProblem,
    logs: &[Log],
    rivals: &[(String, Vec<Effect>)],
) -> Option<Plan> {
    let nothing = (String::new(), Vec::new());
    let (first, second) = (rivals.first()?, rivals.get(1).unwrap_or(&nothing));
    let cell = ExperimentCell::of(&problem.model.robot, logs)?;
    let claimed: Vec<EffectPlace> = rivals
        .iter()
        .filter(|(_, effects)| effects.iter().all(|e| is_calibration(e.kind)))
        .flat_map(|(_, effects)| effects.iter().map(|e| e.place()))
        .collect();
    let process = problem.model.process.as_ref();
    let effects: Vec<Effect> = first.1.iter().chain(&second.1).cloned().collect();

    let all = procedures(&cell, &joints(&effects), &welds(logs));
    let mut tried: Vec<Tried<'_>> = all
        .par_iter()
        .filter(|procedure| effects.iter().any(|e| may_show(procedure.kind(), e)))
        .filter_map(|procedure| {
            let (log, rows) = procedure.log(&cell, logs, process)?;
            let experiment = PreparedLog::new(&log, &cell.noise(log.kind), &problem.model).ok()?;
            let trial = PlannedTrial::new(problem, experiment);
            let apart = trial.apart(&first.1, &second.1)?;
            (apart > LEAST_APART).then_some(Tried { procedure, log, rows, trial, apart })
        })
        .collect();
    if tried.is_empty() {
        return None;
    }
    let ctx = SeparationContext::of(problem, claimed)?;
    let (a, b) = (ctx.rival(&first.1)?, ctx.rival(&second.1)?);
    // A refit only makes the difference less, so that those that promise most come first, and the
    // rest cannot win.
    tried.sort_by(|x, y| y.worth(y.apart).total_cmp(&x.worth(x.apart)));
    let mut looked_at: Vec<ProcedureFamily> = Vec::new();
    let mut best: Option<(f64, &Tried<'_>)> = None;
    for t in &tried {
        if best.is_some_and(|(separation, best)| best.worth(separation) >= t.worth(t.apart)) {
            break;
        }
        let family = t.procedure.family();
        if looked_at.iter().filter(|f| **f == family).count() == family.most() {
            continue;
        }
        looked_at.push(family);
        let Some(separation) = t.trial.separations(&ctx, &a, &[&b]).map(|s| s[0]) else {
            continue;
        };
        if best.is_none_or(|(most, best)| t.worth(separation) > best.worth(most)) {
            best = Some((separation, t));
        }
    }
    let (separation, best) = best?;
    let more: Vec<_> =
        rivals.iter().skip(2).filter_map(|(name, e)| Some((name, ctx.rival(e)?))).collect();
    let others: Vec<&Rival> = more.iter().map(|(_, rival)| rival).collect();
    let others = best.trial.separations(&ctx, &a, &others).unwrap_or_default();
    Some(Plan {
        procedure: best.procedure.clone(),
        channels: cell.channels(best.procedure.kind()),
        rivals: [first.0.clone(), second.0.clone()],
        so_far: b.cost - a.cost,
        others: more.iter().map(|(name, _)| (*name).clone()).zip(others).collect(),
        separation,
        minutes: best.procedure.minutes(),
        rows: best.rows.clone(),
        log: best.log.clone(),
    })
}

/// Joints worth moving: those that the rivals are at, or all.
fn joints(effects: &[Effect]) -> Vec<usize> {
    let mut joints: Vec<usize> = effects
        .iter()
        .filter_map(|e| if let Location::Joint(joint) = e.at { Some(joint) } else { None })
        .collect();
    joints.sort_unstable();
    joints.dedup();
    if joints.is_empty() { (0..JOINTS).collect() } else { joints }
}

/// Welds to vary: one a posture is enough.
fn welds(logs: &[Log]) -> Vec<usize> {
    logs.iter().position(|l| l.kind == LogKind::Weld).into_iter().collect()
}

/// True where a kind of log can show anything of an effect.
fn may_show(kind: LogKind, effect: &Effect) -> bool {
    match (effect.kind.action, effect.port()) {
        (Action::Process(_), _) | (_, Some(Port::ProcessForce | Port::PlateSurface)) => {
            kind == LogKind::Weld
        }
        (_, Some(Port::MotorFriction(_))) => kind == LogKind::FreeMotion,
        _ => true,
    }
}
