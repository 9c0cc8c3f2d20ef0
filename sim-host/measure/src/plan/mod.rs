//! The experiment that would tell rival explanations apart: chosen from feasible poses, loads and motions by expected
//! separation, and written out as a plan that someone can run.
//!
//! Every procedure that the laboratory's logs show to be possible is made up as a log; the rivals predict it, and what one of
//! them, refitted together with the calibrations, leaves of the other is its expected separation. Left out: how well the logs
//! so far can be trusted beyond their residuals, and what a cell has in the arm's way.

mod cell;
mod procedure;
mod separation;

use crate::calibrate::is_calibration;
use crate::fit::Bench;
use crate::log::{Log, LogKind};
use crate::predict::Experiment;
use cell::Cell;
use procedure::{Procedure, procedures};
use rayon::prelude::*;
use separation::{Rival, Trial};
use trueweld_core::JOINTS;
use trueweld_plant::effects::{At, Effect};

/// Separation from which on rivals count as told apart, standard deviations.
pub const TOLD_APART: f64 = 3.0;

/// Separation beyond which more of it is worth little: an experiment half as long is worth more.
const PLENTY: f64 = 10.0;

/// Difference before any refit below which an experiment is not looked at any closer, standard deviations.
const LEAST_APART: f64 = 0.3;

/// Experiments of each kind that are looked at closely: those of loads cost next to nothing.
const CLOSELY: [(LogKind, usize); 4] =
    [(LogKind::StaticLoad, 24), (LogKind::RingDown, 3), (LogKind::FreeMotion, 3), (LogKind::Weld, 2)];

/// One set point of a plan.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Row {
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
    /// What to do, in order: angles in degrees, loads in kg, N or N·m, speeds, durations, what to record at which rate.
    pub steps: Vec<String>,
    /// Which explanations it separates and by how much, and what the logs so far gave.
    pub reason: String,
    /// Expected √Δχ² between the first two explanations, once calibrations and the values of either were refitted.
    pub separation: f64,
    /// What it takes of the cell's time, minutes: an estimate.
    pub minutes: f64,
    /// Set points in order: loads at rest, ends of moves, begin and end of a stop or a weld.
    pub rows: Vec<Row>,
    /// The log as it would be driven; channels to be measured hold what a baseline at rest would show.
    pub log: Log,
}

/// One procedure with what was found of it.
struct Option_<'p> {
    procedure: &'p Procedure,
    log: Log,
    rows: Vec<Row>,
    trial: Trial,
    apart: f64,
}

/// The experiment that tells the first two of `rivals` apart best for its effort: names and fitted effects of the leading
/// explanations, best first; of a single one, it and nothing at all. `logs`: those that `bench` was made of, in its order.
///
/// `None` where no procedure is feasible, or no prediction of any differs.
pub fn next_experiment(bench: &Bench, logs: &[Log], rivals: &[(String, Vec<Effect>)]) -> Option<Plan> {
    let nothing = ("nothing beyond calibrations".to_owned(), Vec::new());
    let (first, second) = (rivals.first()?, rivals.get(1).unwrap_or(&nothing));
    let cell = Cell::of(&bench.model.robot, logs)?;
    let claimed: Vec<(&'static str, At)> = rivals
        .iter()
        .filter(|(_, effects)| effects.iter().all(|e| is_calibration(e.kind)))
        .flat_map(|(_, effects)| effects.iter().map(|e| (e.kind.id, e.at)))
        .collect();
    let process = bench.model.process.as_ref();
    let effects: Vec<Effect> = first.1.iter().chain(&second.1).cloned().collect();

    let all = procedures(&cell, &joints(&effects), &welds(logs));
    let tried: Vec<Option_<'_>> = all
        .par_iter()
        .filter_map(|procedure| {
            let (log, rows) = procedure.log(&cell, logs, process)?;
            let experiment = Experiment::new(&log, &cell.noise(log.kind), &bench.model).ok()?;
            let trial = Trial::new(bench, experiment);
            if !trial.concerns(&effects) {
                return None;
            }
            let apart = trial.apart(&first.1, &second.1)?;
            (apart > LEAST_APART).then_some(Option_ { procedure, log, rows, trial, apart })
        })
        .collect();
    if tried.is_empty() {
        return None;
    }
    let (a, b) = (Rival::of(bench, &first.1, &claimed)?, Rival::of(bench, &second.1, &claimed)?);
    let mut closely: Vec<&Option_<'_>> = Vec::new();
    for (kind, most) in CLOSELY {
        let mut of_kind: Vec<&Option_<'_>> = tried.iter().filter(|t| t.procedure.kind() == kind).collect();
        of_kind.sort_by(|x, y| y.apart.total_cmp(&x.apart));
        closely.extend(of_kind.into_iter().take(most));
    }
    let found: Vec<(f64, &Option_<'_>)> =
        closely.par_iter().filter_map(|t| Some((t.trial.separation(&a, &b, &claimed)?, *t))).collect();
    let worth = |separation: f64, t: &Option_<'_>| separation / (1.0 + separation / PLENTY) / t.procedure.minutes().sqrt();
    let told = |separation: f64| separation >= TOLD_APART;
    let (separation, best) = found.into_iter().max_by(|x, y| {
        told(x.0).cmp(&told(y.0)).then(worth(x.0, x.1).total_cmp(&worth(y.0, y.1)))
    })?;

    let others: Vec<(&str, f64)> = rivals
        .iter()
        .skip(2)
        .filter_map(|(name, effects)| {
            let rival = Rival::of(bench, effects, &claimed)?;
            Some((name.as_str(), best.trial.separation(&a, &rival, &claimed)?))
        })
        .collect();
    let so_far = (a.cost - b.cost).abs().sqrt();
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
    let mut joints: Vec<usize> =
        effects.iter().filter_map(|e| if let At::Joint(joint) = e.at { Some(joint) } else { None }).collect();
    joints.sort_unstable();
    joints.dedup();
    if joints.is_empty() { (0..JOINTS).collect() } else { joints }
}

/// Welds to vary: one a posture is enough.
fn welds(logs: &[Log]) -> Vec<usize> {
    logs.iter().position(|l| l.kind == LogKind::Weld).into_iter().collect()
}

fn reason(names: [&str; 2], separation: f64, so_far: f64, others: &[(&str, f64)]) -> String {
    let [a, b] = names;
    let expected = format!("expected to set {a} and {b} {separation:.1} standard deviations apart");
    let refitted = "after refitting the calibrations and the values of either";
    let before = format!("the logs so far leave them {so_far:.1} apart");
    let mut reason = if separation < TOLD_APART {
        format!(
            "No feasible experiment tells {a} from {b}: this one, the best found, is {expected} {refitted}, less than {TOLD_APART:.0}; {before}."
        )
    } else {
        let mut sentence = format!("It is {expected} {refitted}; {before}.");
        if separation > 50.0 {
            sentence = format!(
                "It is expected to set {a} and {b} more than 50 standard deviations apart {refitted}; {before}."
            );
        }
        sentence
    };
    for (name, separation) in others {
        reason += &format!(" {name} would lie {separation:.1} from {a}.");
    }
    reason
}
