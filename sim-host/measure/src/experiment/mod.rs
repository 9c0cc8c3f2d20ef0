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
mod words;

use crate::data::log::{Log, LogKind};
use crate::fit::FitProblem;
use crate::fit::calibration::is_calibration;
use crate::predict::Experiment;
use cell::ExperimentCell;
use procedure::{Family, Procedure, procedures};
use rayon::prelude::*;
use separation::{Context, PlannedTrial, Rival};
use trueweld_core::JOINTS;
use trueweld_plant::effects::{Action, Effect, Location};
use trueweld_plant::robot::Port;

/// Separation from which on rivals count as told apart, standard deviations.
pub const TOLD_APART: f64 = 3.0;

/// Separation beyond which more of it is worth little: an experiment half as long is worth more.
const PLENTY: f64 = 10.0;

/// Separation beyond which a number says no more: by then something else limits what can be told.
const MOST_SAID: f64 = 50.0;

/// Difference before any refit below which an experiment is not looked at any closer, standard
/// deviations.
const LEAST_APART: f64 = 0.3;

/// One set point of a plan.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PlanRow {
    /// When, s from the start of the log.
    pub time: f64,
    /// Encoder angles on the joint side, rad.
    pub encoder: [f64; JOINTS],
    /// Force on the tool in T, N.
    pub force: [f64; 3],
    /// Moment on the tool at the tool centre point in T, N·m.
    pub moment: [f64; 3],
    /// Extra mass on the flange, kg.
    pub payload: f64,
}

/// An experiment to make next.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Kind of log to record.
    pub kind: LogKind,
    /// What is done, in one line.
    pub title: String,
    /// What to do, in order: angles in degrees, loads in kg, N or N·m, speeds, durations, what to
    /// record at which rate.
    pub steps: Vec<String>,
    /// Which explanations it separates and by how much, and what the logs so far gave.
    pub reason: String,
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
        let told = if separation >= TOLD_APART { PLENTY } else { 0.0 };
        told + separation / (1.0 + separation / PLENTY) / self.procedure.minutes().sqrt()
    }
}

/// The experiment that tells the first two of `rivals` apart best for its effort: names and fitted
/// effects of the leading explanations, best first; of a single one, it and nothing at all. `logs`:
/// those that `bench` was made of, in its order.
///
/// `None` where no procedure is feasible, or no prediction of any differs.
pub fn next_experiment(
    bench: &FitProblem,
    logs: &[Log],
    rivals: &[(String, Vec<Effect>)],
) -> Option<Plan> {
    let nothing = ("nothing beyond calibrations".to_owned(), Vec::new());
    let (first, second) = (rivals.first()?, rivals.get(1).unwrap_or(&nothing));
    let cell = ExperimentCell::of(&bench.model.robot, logs)?;
    let claimed: Vec<(&'static str, Location)> = rivals
        .iter()
        .filter(|(_, effects)| effects.iter().all(|e| is_calibration(e.kind)))
        .flat_map(|(_, effects)| effects.iter().map(|e| (e.kind.id, e.at)))
        .collect();
    let process = bench.model.process.as_ref();
    let effects: Vec<Effect> = first.1.iter().chain(&second.1).cloned().collect();

    let all = procedures(&cell, &joints(&effects), &welds(logs));
    let mut tried: Vec<Tried<'_>> = all
        .par_iter()
        .filter(|procedure| effects.iter().any(|e| may_show(procedure.kind(), e)))
        .filter_map(|procedure| {
            let (log, rows) = procedure.log(&cell, logs, process)?;
            let experiment = Experiment::new(&log, &cell.noise(log.kind), &bench.model).ok()?;
            let trial = PlannedTrial::new(bench, experiment);
            let apart = trial.apart(&first.1, &second.1)?;
            (apart > LEAST_APART).then_some(Tried { procedure, log, rows, trial, apart })
        })
        .collect();
    if tried.is_empty() {
        return None;
    }
    let ground = Context::of(bench, claimed)?;
    let (a, b) = (ground.rival(&first.1)?, ground.rival(&second.1)?);
    // A refit only makes the difference less, so that those that promise most come first, and the
    // rest cannot win.
    tried.sort_by(|x, y| y.worth(y.apart).total_cmp(&x.worth(x.apart)));
    let mut looked_at: Vec<Family> = Vec::new();
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
        let Some(separation) = t.trial.separations(&ground, &a, &[&b]).map(|s| s[0]) else {
            continue;
        };
        if best.is_none_or(|(most, best)| t.worth(separation) > best.worth(most)) {
            best = Some((separation, t));
        }
    }
    let (separation, best) = best?;
    let more: Vec<_> = rivals
        .iter()
        .skip(2)
        .filter_map(|(name, e)| Some((name.as_str(), ground.rival(e)?)))
        .collect();
    let others: Vec<&Rival> = more.iter().map(|(_, rival)| rival).collect();
    let others = best.trial.separations(&ground, &a, &others).unwrap_or_default();
    let others: Vec<(&str, f64)> = more.iter().map(|(name, _)| *name).zip(others).collect();
    let so_far = b.cost - a.cost;
    Some(Plan {
        kind: best.procedure.kind(),
        title: best.procedure.title(&cell, &best.rows),
        steps: best.procedure.steps(&cell, &best.log, &best.rows),
        reason: reason([&first.0, &second.0], separation, so_far, &others),
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

/// `so_far`: by how much more of the sum of squares the second leaves in the logs so far.
fn reason(names: [&str; 2], separation: f64, so_far: f64, others: &[(&str, f64)]) -> String {
    let [a, b] = names;
    let deviations = |s: f64| {
        if s > MOST_SAID { format!("more than {MOST_SAID:.0}") } else { format!("{s:.1}") }
    };
    let expected = format!(
        "expected to set {a} and {b} {} standard deviations apart after refitting the calibrations and the values of either",
        deviations(separation)
    );
    let better = if so_far > 0.0 { a } else { b };
    let before = match deviations(so_far.abs().sqrt()) {
        s if so_far.abs() < 1.0 => format!("the logs so far leave them {s} apart"),
        s => format!("the logs so far set them {s} apart, in favour of {better}"),
    };
    let mut reason = if separation < TOLD_APART {
        format!(
            "No feasible experiment tells {a} from {b}: the best found is {expected}, less than {TOLD_APART:.0}; {before}."
        )
    } else {
        format!("It is {expected}; {before}.")
    };
    for (name, separation) in others {
        reason += &format!(" From {a} to {name} it is {}.", deviations(*separation));
    }
    reason
}
