//! The curve of an effect, and what it is drawn from.

use trueweld_estimate::fit::{EffectScope, FitProblem, FitState, Fitted, Residuals};
use trueweld_estimate::predict::ComparedQuantity;
use trueweld_estimate::residuals::localize::ConditionBin;
use trueweld_logs::log::Log;

/// What an effect may follow. Joints count from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Abscissa {
    /// Time from the start of the log, s.
    Time,
    /// Time up to so many seconds, s.
    TimeTo(f64),
    /// Spring torque of a joint, N·m.
    SpringTorque(usize),
    /// Angle of a joint, rad.
    Angle(usize),
    /// Angle of a joint within one period of so many a turn, rad.
    Phase(usize, f64),
    /// Rate of a joint, rad/s.
    Rate(usize),
    /// Position along the weld, m.
    Path,
    /// Speed along the weld, m/s.
    Feed,
    /// F_z in the tool's frame, N: below 0 while the tool is pressed on.
    AxialForce,
    /// −F_z, with the sign of the spindle's speed, N.
    PushBySpindle,
    /// Size of the force on the tool, N.
    Load,
    /// Size of the TCP's velocity, m/s.
    ToolSpeed,
    /// TCP in B, along x, y or z, m.
    Tool(usize),
    /// Order of the spindle.
    SpindleOrder,
}

impl Abscissa {
    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Time | Self::TimeTo(_) => "s",
            Self::SpringTorque(_) => "N·m",
            Self::Angle(_) | Self::Phase(..) => "rad",
            Self::Rate(_) => "rad/s",
            Self::Path | Self::Tool(_) => "m",
            Self::Feed | Self::ToolSpeed => "m/s",
            Self::AxialForce | Self::PushBySpindle | Self::Load => "N",
            Self::SpindleOrder => "1/turn",
        }
    }
}

/// A quantity that the data are asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Ordinate {
    /// What the effect's own file names, with `{joint}` for the name of a joint, from 0.
    Named(&'static str, usize),
    /// What a column of a channel reads beyond what is predicted without the effect.
    Column {
        /// The channel.
        quantity: ComparedQuantity,
        /// The column.
        component: u8,
        /// The effect.
        without: &'static str,
    },
    /// Amplitude of the force along x, y or z of the tool beyond the model's.
    ForceAmplitude(u8),
}

/// What the measurements say of an effect, and what it says itself.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectCurve {
    /// The variable that matters for the effect.
    pub x: Abscissa,
    /// The quantity that the data ask for.
    pub y: Ordinate,
    /// Its unit.
    pub y_unit: &'static str,
    /// What the measurements say. A loop comes in order of time, everything else in order of `x`.
    pub points: Vec<ConditionBin>,
    /// The same quantity as the effect with its fitted values has it, in the same order.
    pub fitted: Vec<[f64; 2]>,
}

/// Everything that a view is drawn from.
pub(super) struct EvidenceContext<'a> {
    /// The logs made ready, and the logs.
    pub problem: &'a FitProblem,
    pub logs: &'a [Log],
    /// The fit with the effect.
    pub found: &'a Fitted,
    /// The effect in `found`.
    pub of: EffectScope,
    /// `found` without the effect, its calibrations as they are.
    pub bare: &'a FitState,
    /// Residuals there.
    pub without: &'a Residuals,
    /// Residuals with calibrations alone, at their best.
    pub null: &'a Residuals,
}
