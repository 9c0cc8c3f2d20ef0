//! What may be a little off in any cell without anything being missing from the model: stiffness
//! and damping, where encoders were zeroed and a tracker registered, a sensor's zero. Fitted under
//! every hypothesis, reported apart. Which effects these are, and what is expected of them, they
//! say themselves ([`Calibration`]).

use super::{EffectScope, FitProblem, FitState};
use crate::data::log::LogKind;
use trueweld_plant::effects::{Calibration, CalibrationScope, Effect, EffectKind, library};

/// True for an effect that is a calibration of what the model has.
pub fn is_calibration(kind: &EffectKind) -> bool {
    kind.calibration.is_some()
}

/// Expected size of each of an effect's values, one standard deviation: infinite for what is no
/// calibration.
pub fn expected(kind: &EffectKind) -> Vec<f64> {
    kind.calibration.map_or(vec![f64::INFINITY; kind.parameters.len()], |c| c.expected.to_vec())
}

/// Effects with values of their own in every log of a bench, all free.
pub fn per_log(bench: &FitProblem, effects: &[Effect]) -> FitState {
    let mut point = FitState::empty(bench.experiments.len());
    for effect in effects {
        for (log, experiment) in bench.experiments.iter().enumerate() {
            if experiment.concerns(effect) {
                point.add_to_log(log, effect.clone(), &expected(effect.kind));
            }
        }
    }
    point
}

/// The calibrations that these logs can show anything of, all at nothing, after what is fitted
/// afresh in each log anyway. Those of each log come first, in proportion to which the residuals
/// are: their slopes are taken once.
pub fn calibrations(bench: &FitProblem) -> FitState {
    let mut point = per_log(bench, &bench.per_log);
    let moving =
        bench.experiments.iter().any(|e| matches!(e.kind, LogKind::RingDown | LogKind::FreeMotion));
    let of = |each_log: bool| {
        library()
            .filter_map(move |kind| Some((kind, kind.calibration?)))
            .filter(move |(_, c)| matches!(c.scope, CalibrationScope::EachLog(_)) == each_log)
    };
    for (kind, Calibration { expected, scope }) in of(true).chain(of(false)) {
        for at in kind.places() {
            match scope {
                CalibrationScope::EachLog(channels) => {
                    if bench.per_log.iter().any(|e| (e.kind.id, e.at) == (kind.id, at)) {
                        continue;
                    }
                    let effect = kind.neutral(at);
                    for (log, experiment) in bench.experiments.iter().enumerate() {
                        let measured = channels.iter().any(|c| experiment.measures(*c, None));
                        if measured && experiment.concerns(&effect) {
                            point.add_to_log(log, effect.clone(), expected);
                        }
                    }
                }
                CalibrationScope::AllLogs { motion } if moving || !motion => {
                    point.add_expected(kind.neutral(at), expected);
                }
                CalibrationScope::AllLogs { .. } => {}
            }
        }
    }
    point
}

/// Free values of a point that belong to one log each: those come first.
pub fn of_logs(point: &FitState) -> usize {
    point.free.iter().filter(|f| matches!(f.of, EffectScope::Log(..))).count()
}
