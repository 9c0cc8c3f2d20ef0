//! Effects with their fitted values, and the curves that show them.

use super::{finite, result};
use crate::text::curve::{title, x_name, y_name};
use std::collections::BTreeMap;
use trueweld_diagnose::FittedEffect;
use trueweld_diagnose::evidence::EffectCurve;
use trueweld_estimate::residuals::compare::LogComparison;
use trueweld_estimate::residuals::localize::ConditionBin;
use trueweld_plant::effects;
use trueweld_plant::input::RobotFile;

result! {
    /// An effect and what it is at: a joint, an instrument, or nothing for the whole cell.
    EffectPlace of (place: effects::EffectPlace, robot: &RobotFile) {
        effect: &'static str = place.kind.id,
        at: String = place.at.name(robot).to_owned(),
    }
}

result! {
    /// An effect with its fitted values.
    FittedEffectValues of (found: &FittedEffect, robot: &RobotFile, logs: &[LogComparison]) {
        /// The effect.
        effect: &'static str = found.effect.kind.id,
        /// What it is at.
        at: String = found.effect.at.name(robot).to_owned(),
        /// Its parameters by name.
        parameters: BTreeMap<&'static str, FittedValue> = FittedValue::all(found),
        /// The log, where it is of one alone.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        log: Option<String> =
            found.log.and_then(|log| logs.get(log)).map(|log| log.name.clone()),
        /// True for a calibration that is larger than any, or at the bound of its range.
        #[serde(default, skip_serializing_if = "std::ops::Not::not")]
        implausible: bool = found.is_implausible(),
    }
}

result! {
    /// A fitted value with its 95 % interval.
    FittedValue of (found: &FittedEffect, k: usize) with {
        let end = |k: usize, end: usize| {
            finite(found.interval[k][end]).filter(|_| found.is_fitted(k))
        };
    } {
        value: Option<f64> = finite(found.effect.values[k]),
        low: Option<f64> = end(k, 0),
        high: Option<f64> = end(k, 1),
        unit: &'static str = found.effect.kind.parameters[k].unit,
    }
}

result! {
    /// What the measurements show of an effect, and the effect as fitted.
    EffectCurveData of (curve: &EffectCurve, robot: &RobotFile) with {
        let joints = &robot.joint_names;
        let column =
            |of: fn(&ConditionBin) -> f64| curve.points.iter().map(|p| finite(of(p))).collect();
        let fitted = |axis: usize| curve.fitted.iter().map(|p| finite(p[axis])).collect();
    } {
        title: String = title(curve, joints),
        x_name: String = x_name(curve, joints),
        x_unit: &'static str = curve.x.unit(),
        y_name: String = y_name(curve, joints),
        y_unit: &'static str = curve.y_unit,
        x: Vec<Option<f64>> = column(|p| p.x),
        y: Vec<Option<f64>> = column(|p| p.y),
        /// Standard errors of `y`.
        error: Vec<Option<f64>> = column(|p| p.error),
        fitted_x: Vec<Option<f64>> = fitted(0),
        fitted_y: Vec<Option<f64>> = fitted(1),
    }
}

impl FittedValue {
    /// Of every parameter, by its name.
    pub(super) fn all(found: &FittedEffect) -> BTreeMap<&'static str, Self> {
        let parameters = found.effect.kind.parameters.iter().enumerate();
        parameters.map(|(k, parameter)| (parameter.name, Self::of(found, k))).collect()
    }
}

impl FittedEffectValues {
    /// Calibrations, with those of their values that the data carry.
    pub(super) fn calibrations(
        all: &[FittedEffect],
        robot: &RobotFile,
        logs: &[LogComparison],
    ) -> Vec<Self> {
        let mut calibrations = Self::all(all, robot, logs);
        for (of, found) in calibrations.iter_mut().zip(all) {
            let parameters = found.effect.kind.parameters.iter().enumerate();
            for (_, p) in parameters.filter(|(k, _)| !found.is_fitted(*k)) {
                of.parameters.remove(p.name);
            }
        }
        calibrations
    }

    pub(super) fn all(
        all: &[FittedEffect],
        robot: &RobotFile,
        logs: &[LogComparison],
    ) -> Vec<Self> {
        all.iter().map(|found| Self::of(found, robot, logs)).collect()
    }
}
