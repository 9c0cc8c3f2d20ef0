//! What a residual follows, as it is reported, and the names of columns.

use crate::predict::ComparedQuantity;
use trueweld_core::JOINTS;
use trueweld_logs::log::{Log, LogKind};

/// A score up to here is the noise floor: the deviations that residuals are judged by, propagated
/// through the model to first order, are themselves known to about a tenth.
pub const NOISE_FLOOR_SCORE: f64 = 1.1;

/// In which way a residual goes with a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Statistic {
    /// Its mean changes with it.
    Mean,
    /// Its size changes with it.
    Size,
}

/// A condition under which rows were recorded. Joints count from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum RowCondition {
    /// Time from the start of the log, s.
    Time,
    /// Angle of a joint, rad.
    Angle(usize),
    /// Angle of a joint within one of so many periods a turn, rad of the period.
    Wave {
        /// The joint.
        joint: usize,
        /// Periods a turn.
        order: usize,
    },
    /// Rate of a joint, rad/s.
    Rate(usize),
    /// Acceleration of a joint, rad/s².
    Acceleration(usize),
    /// Direction in which a joint moves.
    Motion(usize),
    /// Spring torque of a joint, N·m.
    SpringTorque(usize),
    /// Its sign.
    SpringSign(usize),
    /// Whether it falls or rises.
    SpringTendency(usize),
    /// Mass on the flange, kg.
    Payload,
    /// Size of the force on the tool, N.
    Load,
    /// Whether it falls or rises.
    LoadTendency,
    /// Position along the weld, m.
    Path,
    /// Which log it is.
    Log,
    /// Which joint it is.
    Joint,
    /// Which Cartesian direction it is.
    Direction,
    /// Which order of the spindle it is.
    SpindleOrder,
    /// What holds everywhere.
    Offset,
    /// Band of frequencies, Hz.
    Frequency,
}

impl RowCondition {
    /// Its unit; empty for categories.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Time => "s",
            Self::Angle(_) | Self::Wave { .. } => "rad",
            Self::Rate(_) => "rad/s",
            Self::Acceleration(_) => "rad/s²",
            Self::SpringTorque(_) => "N·m",
            Self::Payload => "kg",
            Self::Load => "N",
            Self::Path => "m",
            Self::Frequency => "Hz",
            _ => "",
        }
    }
}

/// A value of a condition that is not a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Category {
    /// A sign or a direction below zero.
    Negative,
    /// No motion.
    AtRest,
    /// A sign or a direction above zero.
    Positive,
    /// A signal that falls.
    Falling,
    /// A signal that stays.
    Steady,
    /// A signal that rises.
    Rising,
    /// A log, by its place in [`Finding::logs`].
    Log(usize),
    /// A joint, from 0.
    Joint(usize),
    /// x, y or z.
    Direction(u8),
    /// An order of the spindle; 0 below its frequency.
    SpindleOrder(u8),
    /// A compared series: a quantity and its column.
    Series(ComparedQuantity, u8),
}

/// One condition that the residual of one channel goes with.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Kind of the logs.
    pub kind: LogKind,
    /// The channel, as in a comparison.
    pub channel: &'static str,
    /// Names of the logs.
    pub logs: Vec<String>,
    /// √mean((residual/noise)²) of this channel in these logs.
    pub score: f64,
    /// Names of the robot's joints.
    pub joints: [String; JOINTS],
    /// The condition.
    pub variable: RowCondition,
    /// Mean or size.
    pub how: Statistic,
    /// Share of the channel's squared residual, 0 to 1, that goes with the condition.
    pub share: f64,
    /// The share that the same residual under other conditions shows by chance, on average.
    pub by_chance: f64,
    /// Share of the arrangements in which chance does as much; never below 1/200.
    pub p: f64,
    /// Where it shows most: range of the condition; of a natural category its number, twice.
    pub low: f64,
    /// See `low`.
    pub high: f64,
    /// The category where it shows most; `None` where the condition is a number.
    pub category: Option<Category>,
    /// Share of the squared residual that lies there.
    pub share_there: f64,
    /// Share of the samples that lie there.
    pub samples_there: f64,
    /// Other conditions that this channel's residual goes with nearly as much: these data do not
    /// tell them apart.
    pub similar: Vec<RowCondition>,
    /// The residual over the condition.
    pub curve: ConditionCurve,
    /// Two conditions that it follows together, where one does not do; with the first finding of a
    /// channel alone.
    pub map: Option<ResidualMap>,
}

impl Finding {
    /// Share beyond chance, which findings are ordered by.
    pub fn excess(&self) -> f64 {
        self.share - self.by_chance
    }
}

/// A mean residual over two conditions, for one column.
#[derive(Debug, Clone, PartialEq)]
pub struct ResidualMap {
    /// One condition.
    pub x: MapAxis,
    /// The other.
    pub y: MapAxis,
    /// The series where it shows most: its quantity and column.
    pub series: (ComparedQuantity, u8),
    /// Mean residual by y, then by x, in the quantity's unit; NaN where there are too few rows.
    pub mean: Vec<Vec<f64>>,
    /// Share of the channel's squared residual that goes with both, 0 to 1.
    pub share: f64,
    /// The share that chance gives, on average.
    pub by_chance: f64,
    /// Share of the arrangements in which chance does as much.
    pub p: f64,
}

/// The bins of one condition of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapAxis {
    /// The condition.
    pub variable: RowCondition,
    /// Its categories; empty where the condition is a number.
    pub categories: Vec<Category>,
    /// Mean of the condition in each bin; of a category its number, NaN where there is no row.
    pub values: Vec<f64>,
}

/// A residual over a condition, for one column.
#[derive(Debug, Clone, PartialEq)]
pub struct ConditionCurve {
    /// The categories, one a point; empty where the condition is a number.
    pub categories: Vec<Category>,
    /// The series where the condition shows most; `None` where all of the channel is drawn.
    pub series: Option<(ComparedQuantity, u8)>,
    /// Unit of `y` and `error`.
    pub y_unit: &'static str,
    /// The points, in the order of the condition.
    pub points: Vec<ConditionBin>,
}

/// One bin of a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ConditionBin {
    /// Mean of the condition in the bin, in the condition's unit; of a category its number.
    pub x: f64,
    /// Mean of the residual there, or its root mean square, in the curve's `y_unit`.
    pub y: f64,
    /// Standard error of `y`, with as many independent samples as the residual's memory leaves.
    pub error: f64,
}

/// What people call a column of a channel.
pub(crate) fn column_label(log: &Log, quantity: ComparedQuantity, column: u8) -> String {
    match quantity {
        ComparedQuantity::LinkEncoder | ComparedQuantity::MotorTorque => {
            log.robot.joint_names[usize::from(column)].clone()
        }
        _ => ["x", "y", "z"][usize::from(column).min(2)].to_owned(),
    }
}
