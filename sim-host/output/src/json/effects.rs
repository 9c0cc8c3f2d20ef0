//! Effects with their fitted values, and the curves that show them.

use super::finite;
use crate::words::curve::{title, x_name, y_name};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueweld_diagnose::FittedEffect;
use trueweld_diagnose::evidence::EffectCurve;
use trueweld_estimate::residuals::compare::LogComparison;
use trueweld_estimate::residuals::localize::ConditionBin;
use trueweld_plant::effects::{Effect, EffectKind, Location};
use trueweld_plant::input::RobotFile;

/// An effect and what it is at: a joint, an instrument, or nothing for the whole cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct EffectPlace {
    pub effect: String,
    pub at: String,
}

/// An effect with its fitted values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FittedEffectValues {
    /// The effect.
    pub effect: String,
    /// What it is at.
    pub at: String,
    /// Its parameters by name.
    pub parameters: BTreeMap<String, FittedValue>,
    /// The log, where it is of one alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log: Option<String>,
    /// True for a calibration that is larger than any, or at the bound of its range.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub implausible: bool,
}

/// A fitted value with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct FittedValue {
    pub value: Option<f64>,
    pub low: Option<f64>,
    pub high: Option<f64>,
    pub unit: String,
}

/// What the measurements show of an effect, and the effect as fitted.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct EffectCurveData {
    pub title: String,
    pub x_name: String,
    pub x_unit: String,
    pub y_name: String,
    pub y_unit: String,
    pub x: Vec<Option<f64>>,
    pub y: Vec<Option<f64>>,
    /// Standard errors of `y`.
    pub error: Vec<Option<f64>>,
    pub fitted_x: Vec<Option<f64>>,
    pub fitted_y: Vec<Option<f64>>,
}

impl EffectPlace {
    pub(super) fn of(kind: &'static EffectKind, at: Location, robot: &RobotFile) -> Self {
        let effect = Effect { kind, at, values: Vec::new() };
        Self { effect: kind.id.to_owned(), at: effect.at_name(robot).to_owned() }
    }
}

impl FittedEffectValues {
    /// Calibrations, with those of their values that the data carry.
    pub(super) fn calibrations(
        all: &[FittedEffect],
        robot: &RobotFile,
        logs: &[LogComparison],
    ) -> Vec<Self> {
        let carried = |found: &FittedEffect| {
            let mut of = Self::of(found, robot, logs);
            let all = found.effect.kind.parameters.iter().enumerate();
            for (_, p) in all.filter(|(k, _)| !found.is_fitted(*k)) {
                of.parameters.remove(p.name);
            }
            of
        };
        all.iter().map(carried).collect()
    }

    pub(super) fn all(
        all: &[FittedEffect],
        robot: &RobotFile,
        logs: &[LogComparison],
    ) -> Vec<Self> {
        all.iter().map(|found| Self::of(found, robot, logs)).collect()
    }

    pub(super) fn of(found: &FittedEffect, robot: &RobotFile, logs: &[LogComparison]) -> Self {
        let EffectPlace { effect, at } = EffectPlace::of(found.effect.kind, found.effect.at, robot);
        let parameters = found.effect.kind.parameters.iter().enumerate().map(|(k, p)| {
            let [low, high] = found.interval[k].map(|v| finite(v).filter(|_| found.is_fitted(k)));
            let value = finite(found.effect.values[k]);
            (p.name.to_owned(), FittedValue { value, low, high, unit: p.unit.to_owned() })
        });
        let log = found.log.and_then(|log| logs.get(log)).map(|log| log.name.clone());
        Self {
            effect,
            at,
            parameters: parameters.collect(),
            log,
            implausible: found.is_implausible(),
        }
    }
}

impl EffectCurveData {
    pub(super) fn of(curve: &EffectCurve, robot: &RobotFile) -> Self {
        let joints = &robot.joint_names;
        let column =
            |of: fn(&ConditionBin) -> f64| curve.points.iter().map(|p| finite(of(p))).collect();
        let fitted = |axis: usize| curve.fitted.iter().map(|p| finite(p[axis])).collect();
        Self {
            title: title(curve, joints),
            x_name: x_name(curve, joints),
            x_unit: curve.x.unit().to_owned(),
            y_name: y_name(curve, joints),
            y_unit: curve.y_unit.to_owned(),
            x: column(|p| p.x),
            y: column(|p| p.y),
            error: column(|p| p.error),
            fitted_x: fitted(0),
            fitted_y: fitted(1),
        }
    }
}
