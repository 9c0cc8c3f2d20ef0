//! Laws that the library does not hold.

use super::effects::{FittedEffectValues, FittedValue};
use super::{finite, result};
use crate::text;
use std::collections::BTreeMap;
use trueweld_diagnose::PortAt;
use trueweld_diagnose::discover::{Discovery, FreeSurface, Hypothesis};
use trueweld_plant::input::RobotFile;

result! {
    /// A law outside the library: what is added at a port of the plant, over variables of the logs.
    DiscoveredLaw of (discovery: &Discovery, robot: &RobotFile) with {
        let tied = discovery.tied.iter();
        let like = discovery.like.as_ref().map_or(&[][..], |like| &like.effects);
    } {
        #[serde(flatten)]
        place: DiscoveredPlace = DiscoveredPlace::of(&discovery.hypothesis, robot),
        /// The free curve.
        curve: DiscoveredCurve = DiscoveredCurve::of(discovery, robot),
        /// The formula; null where the curve itself is the law.
        expression: Option<String> = discovery.expression.clone(),
        /// Values of the formula, or of the curve at its places.
        parameters: BTreeMap<&'static str, FittedValue> = FittedValue::all(&discovery.effect),
        /// Score on rows left out of the fit, of the model as given.
        holdout_score_before: Option<f64> = finite(discovery.held_out_before),
        /// Score on rows left out of the fit, with it.
        holdout_score_after: Option<f64> = finite(discovery.held_out_after),
        /// Share of what is above the noise floor that it leaves.
        left: Option<f64> = finite(discovery.left),
        /// Laws that the data do not tell from it.
        indistinguishable: Vec<DiscoveredPlace> =
            tied.map(|t| DiscoveredPlace::of(&t.hypothesis, robot)).collect(),
        /// Effects of the library that are like it, and whose form does not hold.
        like: Vec<FittedEffectValues> = FittedEffectValues::all(like, robot, &[]),
        /// The same in words.
        explanation: String = text::discover::paragraph(discovery, robot),
    }
}

result! {
    /// A port of the plant, at a place.
    PortPlace of (port: PortAt, robot: &RobotFile) {
        /// The port, as an effect of one's own names it.
        port: String = port.0.name.to_owned(),
        /// A joint's name, or nothing for the whole cell.
        at: String = text::discover::joint(port.1, robot).to_owned(),
    }
}

result! {
    /// Where a law may act, and what it may depend on.
    DiscoveredPlace of (hypothesis: &Hypothesis, robot: &RobotFile) {
        #[serde(flatten)]
        port: PortPlace = PortPlace::of((hypothesis.port, hypothesis.at), robot),
        /// Variables of the port, that of the curve first.
        over: Vec<String> = hypothesis.variables().into_iter().map(str::to_owned).collect(),
        /// What the curve is multiplied by, an expression over the port's variables.
        times: String = hypothesis.times.to_owned(),
        /// True for a loop: it depends on the way that the variable has come, and the curve is over the
        /// way since a reversal.
        history: bool = hypothesis.turns_over.is_some(),
    }
}

result! {
    /// A free curve with its 95 % band.
    DiscoveredCurve of (discovery: &Discovery, robot: &RobotFile) with {
        let (hypothesis, curve) = (&discovery.hypothesis, &discovery.curve);
        let end = |end: usize| curve.band.iter().map(|band| finite(band[end])).collect();
    } {
        x_name: String = hypothesis.over.to_owned(),
        x_unit: String = hypothesis.x_unit().to_owned(),
        y_name: String = text::discover::quantity(hypothesis, robot),
        y_unit: String = hypothesis.y_unit(),
        x: Vec<f64> = curve.x.clone(),
        y: Vec<f64> = curve.y.clone(),
        low: Vec<Option<f64>> = end(0),
        high: Vec<Option<f64>> = end(1),
        /// Half the 95 % interval of what all values have in common, where that is most of the band's
        /// width: a constant that calibrations make as well.
        level: Option<f64> = curve.level,
        /// The surface whose curve in the middle of its second variable this is; null where the law is over
        /// one variable.
        surface: Option<DiscoveredSurface> =
            curve.surface.as_ref().map(|surface| DiscoveredSurface::of(surface, hypothesis)),
    }
}

result! {
    /// A free surface with its 95 % band: a row over `x` of the curve for each value of the second variable.
    DiscoveredSurface of (surface: &FreeSurface, hypothesis: &Hypothesis) with {
        let end = |end: usize| {
            let row = |row: &Vec<[f64; 2]>| row.iter().map(|band| finite(band[end])).collect();
            surface.band.iter().map(row).collect()
        };
    } {
        across_name: String = hypothesis.across.unwrap_or_default().to_owned(),
        across_unit: String = hypothesis.across_unit().to_owned(),
        across: Vec<f64> = surface.across.clone(),
        y: Vec<Vec<f64>> = surface.y.clone(),
        low: Vec<Vec<Option<f64>>> = end(0),
        high: Vec<Vec<Option<f64>>> = end(1),
    }
}

impl DiscoveredLaw {
    pub(super) fn all(all: &[Discovery], robot: &RobotFile) -> Vec<Self> {
        all.iter().map(|discovery| Self::of(discovery, robot)).collect()
    }
}
