//! What may be a little off in any cell without anything being missing from the model: stiffness
//! and damping, where encoders were zeroed and a tracker registered, a sensor's zero. Fitted under
//! every hypothesis, reported apart. Which effects these are, and what is expected of them, they
//! say themselves ([`Calibration`]).

pub use super::effects::{expected, is_calibration};

use super::{EffectScope, FitProblem, FitState, FreeParameter, PerLogEffect};
use crate::predict::PreparedLog;
use trueweld_core::spatial::rotation_vector;
use trueweld_logs::log::LogKind;
use trueweld_plant::effects::{
    Action, Calibration, CalibrationScope, Effect, EffectKind, Location, library,
};

/// Effects with values of their own in every log of a problem that shows them, all free.
pub fn per_log(problem: &FitProblem, effects: &[PerLogEffect]) -> FitState {
    let mut point = FitState::empty(problem.logs.len());
    for effect in effects {
        let start = effect.start();
        let channels = start.kind.calibration.and_then(|c| c.renewed(start.at));
        let joint = if let Location::Joint(joint) = start.at { Some(joint) } else { None };
        let expected = beside_zeros(problem, &start, &effect.expected);
        for (log, experiment) in problem.logs.iter().enumerate() {
            let measured =
                channels.is_none_or(|all| all.iter().any(|c| experiment.measures(*c, joint)));
            if measured && experiment.concerns(&start) {
                point.add_to_log(log, start.clone(), &expected);
            }
        }
    }
    point
}

/// The calibrations that these logs can show anything of, all at nothing, after what is fitted
/// in each log anyway. Those of each log come first, then how links are mounted: residuals
/// are in proportion to them, and their slopes are taken once.
pub fn calibrations(problem: &FitProblem) -> FitState {
    let mut point = per_log(problem, &problem.per_log);
    let moving =
        problem.logs.iter().any(|e| matches!(e.kind, LogKind::RingDown | LogKind::FreeMotion));
    let postures = problem.logs.iter().any(PreparedLog::sees_postures);
    let mut all: Vec<(&'static EffectKind, Calibration)> =
        library().filter_map(|kind| Some((kind, kind.calibration?))).collect();
    all.sort_by_key(|(_, calibration)| match calibration.scope {
        CalibrationScope::EachLog(_) => 0,
        CalibrationScope::Postures => 1,
        CalibrationScope::AllLogs { .. }
        | CalibrationScope::OpenFactor
        | CalibrationScope::BesideOpenFactor
        | CalibrationScope::UnknownRotor => 2,
    });
    for (kind, Calibration { expected, scope }) in all {
        for at in kind.places() {
            let mut effect = kind.neutral(at);
            let expected = problem.deviations(&effect, expected);
            if problem.is_known(kind, at) || problem.per_log.iter().any(|own| own.is(&effect)) {
                continue;
            }
            match scope {
                CalibrationScope::EachLog(channels) => {
                    for (log, experiment) in problem.logs.iter().enumerate() {
                        let measured = channels.iter().any(|c| experiment.measures(*c, None));
                        if measured && experiment.concerns(&effect) {
                            point.add_to_log(log, effect.clone(), expected);
                        }
                    }
                }
                CalibrationScope::Postures if postures => {
                    let expected = beside_zeros(problem, &effect, expected);
                    point.add_expected(effect, &expected);
                }
                CalibrationScope::AllLogs { motion } if moving || !motion => {
                    point.add_expected(effect, expected);
                }
                CalibrationScope::OpenFactor | CalibrationScope::BesideOpenFactor => {
                    let Location::Joint(joint) = at else { continue };
                    let found = problem.logs.iter().find_map(|log| log.factors[joint]);
                    if let Some(factor) = found {
                        if scope == CalibrationScope::OpenFactor {
                            effect.values[0] = factor;
                        }
                        point.add_expected(effect, expected);
                    }
                }
                CalibrationScope::UnknownRotor => {
                    let is_unknown = |joint: usize| problem.model.unknown_rotor[joint];
                    if moving && matches!(at, Location::Joint(joint) if is_unknown(joint)) {
                        point.add_expected(effect, expected);
                    }
                }
                CalibrationScope::Postures | CalibrationScope::AllLogs { .. } => {}
            }
        }
    }
    point
}

/// Expected sizes of how a link is mounted off, 0 for a value that only turns or slides it along
/// its joint's axis: such a turn is the encoder's zero, which is a calibration of its own, and such
/// a slide is the link's before, or the whole arm's.
fn beside_zeros(problem: &FitProblem, effect: &Effect, expected: &[f64]) -> Vec<f64> {
    let (Action::Mounting(motion), Location::Joint(joint)) = (effect.kind.action, effect.at) else {
        return expected.to_vec();
    };
    let axis = problem.model.robot.parameters().joints[joint].axis;
    let mut beside = expected.to_vec();
    for (k, expected) in beside.iter_mut().enumerate() {
        let mut values = effect.values.clone();
        values[k] += *expected;
        let by = motion(&values);
        let across = rotation_vector(&by.rotation).cross(&axis).norm() / *expected
            + by.position.cross(&axis).norm() / *expected;
        if across < 1e-6 {
            *expected = 0.0;
        }
    }
    beside
}

/// Free values at the head of a point to which residuals are in proportion: calibrations of one log
/// each, and how links are mounted.
pub fn in_proportion(point: &FitState) -> usize {
    point.free.iter().take_while(|f| is_in_proportion(point, f)).count()
}

/// True for a free value to which residuals are in proportion.
pub(super) fn is_in_proportion(point: &FitState, free: &FreeParameter) -> bool {
    let kind = point.effect(free.of).kind;
    (matches!(free.of, EffectScope::Log(..)) && is_calibration(kind))
        || matches!(kind.action, Action::Mounting(_))
}
