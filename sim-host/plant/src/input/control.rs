//! Gains of the hybrid force/position controllers and limits of the compensation.

use std::collections::BTreeMap;
use trueweld_compensators::{FollowingGains, GainTables, Setup};
use trueweld_core::compensation::LoopLimits;
use trueweld_core::control::{ExternalGains, ForceGains, JointGains};

/// What the controllers of one cell are set to.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Control period, s.
    pub period: f64,
    /// Parallel hybrid control (2.2).
    pub parallel: ParallelGains,
    /// Superposed hybrid control (2.3).
    pub superposed: ParallelGains,
    /// External hybrid control (2.4), (2.5).
    pub external: CascadeGains,
    /// Of any further controller that the file has gains for: its numbers by their keys.
    pub others: BTreeMap<&'static str, OwnGains>,
    /// Bounds of the compensation.
    pub compensation: CompensationLimits,
    /// Gains of the laws, as far as the file states them.
    pub laws: GainTables,
}

/// Numbers of a controller by their keys.
pub type OwnGains = BTreeMap<&'static str, Vec<f64>>;

/// Gains of a scheme whose force branch gives a force, (2.2) and (2.3).
#[derive(Debug, Clone, PartialEq)]
pub struct ParallelGains {
    /// Position loop.
    pub joint: JointGains<f64>,
    /// Force branch.
    pub force: ForceGains<f64>,
}

/// Gains of the scheme whose force loop gives a depth, (2.4) and (2.5).
#[derive(Debug, Clone, PartialEq)]
pub struct CascadeGains {
    /// Inner position loop.
    pub joint: JointGains<f64>,
    /// Outer force loop.
    pub force: ExternalGains<f64>,
}

/// How far and how fast a compensation law may move the pose set-point.
#[derive(Debug, Clone, PartialEq)]
pub struct CompensationLimits {
    /// Of the translation.
    pub lateral: LoopLimits<f64>,
    /// Of the rotation.
    pub orientation: LoopLimits<f64>,
    /// What makes up for what the position loop lacks of a demand.
    pub following: FollowingGains,
}

impl Control {
    /// What laws are built for, to weld a seam of so many metres.
    pub fn setup(&self, length: f64) -> Setup<f64> {
        Setup { period: self.period, length, following: self.compensation.following }
    }
}
