//! What logs fix of how links are mounted.

use super::finite;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trueweld_diagnose::Mountings;
use trueweld_plant::effects::Location;
use trueweld_plant::input::RobotFile;

/// What logs fix of how links are mounted: combinations of the values of `geometry-error`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LinkMountings {
    /// Number of values.
    pub values: usize,
    /// Number of combinations that the logs leave open.
    pub open: usize,
    /// Combinations that they fix, the best known first.
    pub fixed: Vec<MountingCombination>,
}

/// A combination of values, each over its expected deviation.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MountingCombination {
    /// What it is, in expected deviations.
    pub value: Option<f64>,
    /// Its standard deviation, as a share of the expected one.
    pub deviation: Option<f64>,
    /// Its values, the largest weight first.
    pub terms: Vec<MountingTerm>,
}

/// The part of one value in a combination.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct MountingTerm {
    pub at: String,
    pub parameter: String,
    pub weight: Option<f64>,
}

impl LinkMountings {
    pub(super) fn of(all: &Mountings, robot: &RobotFile) -> Self {
        let term = |(at, parameter, weight): &(Location, &'static str, f64)| MountingTerm {
            at: match at {
                Location::Joint(joint) => robot.joint_names[*joint].clone(),
                _ => String::new(),
            },
            parameter: (*parameter).to_owned(),
            weight: finite(*weight),
        };
        let fixed = all.fixed.iter().map(|combination| MountingCombination {
            value: finite(combination.value),
            deviation: finite(combination.deviation),
            terms: combination.terms.iter().map(term).collect(),
        });
        Self { values: all.values, open: all.values - all.fixed.len(), fixed: fixed.collect() }
    }
}
