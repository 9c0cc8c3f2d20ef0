//! What logs fix of how links are mounted.

use super::{finite, result};
use trueweld_diagnose::{Combination, Mountings};
use trueweld_plant::effects::Location;
use trueweld_plant::input::RobotFile;

result! {
    /// What logs fix of how links are mounted: combinations of the values of `geometry-error`.
    LinkMountings of (all: &Mountings, robot: &RobotFile) {
        /// Number of values.
        values: usize = all.values,
        /// Number of combinations that the logs leave open.
        open: usize = all.values - all.fixed.len(),
        /// Combinations that they fix, the best known first.
        fixed: Vec<MountingCombination> =
            all.fixed.iter().map(|fixed| MountingCombination::of(fixed, robot)).collect(),
    }
}

result! {
    /// A combination of values, each over its expected deviation.
    MountingCombination of (fixed: &Combination, robot: &RobotFile) {
        /// What it is, in expected deviations.
        value: Option<f64> = finite(fixed.value),
        /// Its standard deviation, as a share of the expected one.
        deviation: Option<f64> = finite(fixed.deviation),
        /// Its values, the largest weight first.
        terms: Vec<MountingTerm> =
            fixed.terms.iter().map(|term| MountingTerm::of(term, robot)).collect(),
    }
}

result! {
    /// The part of one value in a combination.
    MountingTerm of (term: &(Location, &'static str, f64), robot: &RobotFile) {
        at: String = match term.0 {
            Location::Joint(joint) => robot.joint_names[joint].clone(),
            _ => String::new(),
        },
        parameter: &'static str = term.1,
        weight: Option<f64> = finite(term.2),
    }
}
