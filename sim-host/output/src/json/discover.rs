//! Laws that the library does not hold.

use super::effects::{FittedEffectValues, FittedValue};
use super::finite;
use crate::words;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use trueweld_diagnose::discover::{Discovery, FreeSurface, Hypothesis};
use trueweld_plant::input::RobotFile;

/// A law outside the library: what is added at a port of the plant, over variables of the logs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DiscoveredLaw {
    /// The port, as an effect of one's own names it.
    pub port: String,
    /// A joint's name, or nothing for the whole cell.
    pub at: String,
    /// Variables of the port, that of the curve first.
    pub over: Vec<String>,
    /// What the curve is multiplied by, an expression over the port's variables.
    pub times: String,
    /// True for a loop: it depends on the way that the variable has come, and the curve is over the
    /// way since a reversal.
    pub history: bool,
    /// The free curve.
    pub curve: DiscoveredCurve,
    /// The formula; null where the curve itself is the law.
    pub expression: Option<String>,
    /// Values of the formula, or of the curve at its places.
    pub parameters: BTreeMap<String, FittedValue>,
    /// Score on rows left out of the fit, of the model as given.
    pub holdout_score_before: Option<f64>,
    /// Score on rows left out of the fit, with it.
    pub holdout_score_after: Option<f64>,
    /// Share of what is above the noise floor that it leaves.
    pub left: Option<f64>,
    /// Laws that the data do not tell from it.
    pub indistinguishable: Vec<DiscoveredPlace>,
    /// Effects of the library that are like it, and whose form does not hold.
    pub like: Vec<FittedEffectValues>,
    /// The same in words.
    pub explanation: String,
}

/// Where a law may act, and what it may depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct DiscoveredPlace {
    pub port: String,
    pub at: String,
    pub over: Vec<String>,
    pub times: String,
    pub history: bool,
}

/// A free curve with its 95 % band.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct DiscoveredCurve {
    pub x_name: String,
    pub x_unit: String,
    pub y_name: String,
    pub y_unit: String,
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub low: Vec<Option<f64>>,
    pub high: Vec<Option<f64>>,
    /// Half the 95 % interval of what all values have in common, where that is most of the band's
    /// width: a constant that calibrations make as well.
    pub level: Option<f64>,
    /// The surface whose curve in the middle of its second variable this is; null where the law is over
    /// one variable.
    pub surface: Option<DiscoveredSurface>,
}

/// A free surface with its 95 % band: a row over `x` of the curve for each value of the second variable.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)]
pub struct DiscoveredSurface {
    pub across_name: String,
    pub across_unit: String,
    pub across: Vec<f64>,
    pub y: Vec<Vec<f64>>,
    pub low: Vec<Vec<Option<f64>>>,
    pub high: Vec<Vec<Option<f64>>>,
}

impl DiscoveredSurface {
    fn of(surface: &FreeSurface, hypothesis: &Hypothesis) -> Self {
        let end = |end: usize| {
            let row = |row: &Vec<[f64; 2]>| row.iter().map(|band| finite(band[end])).collect();
            surface.band.iter().map(row).collect()
        };
        Self {
            across_name: hypothesis.across.unwrap_or_default().to_owned(),
            across_unit: hypothesis.across_unit().to_owned(),
            across: surface.across.clone(),
            y: surface.y.clone(),
            low: end(0),
            high: end(1),
        }
    }
}

impl DiscoveredPlace {
    fn of(hypothesis: &Hypothesis, robot: &RobotFile) -> Self {
        Self {
            port: hypothesis.port.name.to_owned(),
            at: words::discover::joint(hypothesis.at, robot).to_owned(),
            over: hypothesis.variables().into_iter().map(str::to_owned).collect(),
            times: hypothesis.times.to_owned(),
            history: hypothesis.turns_over.is_some(),
        }
    }
}

impl DiscoveredLaw {
    pub(super) fn all(all: &[Discovery], robot: &RobotFile) -> Vec<Self> {
        all.iter().map(|discovery| Self::of(discovery, robot)).collect()
    }

    fn of(discovery: &Discovery, robot: &RobotFile) -> Self {
        let hypothesis = &discovery.hypothesis;
        let DiscoveredPlace { port, at, over, times, history } =
            DiscoveredPlace::of(hypothesis, robot);
        let curve = &discovery.curve;
        let end = |end: usize| curve.band.iter().map(|band| finite(band[end])).collect();
        let tied = discovery.tied.iter();
        let like = discovery.like.as_ref().map_or(&[][..], |like| &like.effects);
        Self {
            port,
            at,
            over,
            times,
            history,
            curve: DiscoveredCurve {
                x_name: hypothesis.over.to_owned(),
                x_unit: hypothesis.x_unit().to_owned(),
                y_name: words::discover::quantity(hypothesis, robot),
                y_unit: hypothesis.y_unit(),
                x: curve.x.clone(),
                y: curve.y.clone(),
                low: end(0),
                high: end(1),
                level: curve.level,
                surface: curve.surface.as_ref().map(|s| DiscoveredSurface::of(s, hypothesis)),
            },
            expression: discovery.expression.clone(),
            parameters: FittedEffectValues::of(&discovery.effect, robot, &[]).parameters,
            holdout_score_before: finite(discovery.held_out_before),
            holdout_score_after: finite(discovery.held_out_after),
            left: finite(discovery.left),
            indistinguishable: tied.map(|t| DiscoveredPlace::of(&t.hypothesis, robot)).collect(),
            like: FittedEffectValues::all(like, robot, &[]),
            explanation: words::discover::told(discovery, robot),
        }
    }
}
