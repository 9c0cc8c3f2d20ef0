//! What a residual follows, as it is reported, and the names of joints and columns.

use crate::data::log::{Log, LogKind};
use crate::predict::Quantity;

/// A score up to here is the noise floor: the deviations that residuals are judged by, propagated
/// through the model to first order, are themselves known to about a tenth.
pub const FLOOR: f64 = 1.1;

/// In which way a residual goes with a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Statistic {
    /// Its mean changes with it.
    Mean,
    /// Its size changes with it.
    Size,
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
    /// The condition, such as `A5 spring torque`.
    pub variable: String,
    /// Its unit; empty for natural categories.
    pub unit: &'static str,
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
    /// Name of the category where it shows most; empty where the condition is a number.
    pub category: String,
    /// Share of the squared residual that lies there.
    pub share_there: f64,
    /// Share of the samples that lie there.
    pub samples_there: f64,
    /// Other conditions that this channel's residual goes with nearly as much: these data do not
    /// tell them apart.
    pub similar: Vec<String>,
    /// The residual over the condition.
    pub curve: Curve,
}

impl Finding {
    /// Share beyond chance, which findings are ordered by.
    pub fn excess(&self) -> f64 {
        self.share - self.by_chance
    }
}

/// A residual over a condition, for one column.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The condition.
    pub x_name: String,
    /// Its unit; empty for natural categories.
    pub x_unit: &'static str,
    /// Names of the categories, one a point; empty where the condition is a number.
    pub categories: Vec<String>,
    /// What is drawn, with the column where the condition shows most.
    pub y_name: String,
    /// Unit of `y` and `error`.
    pub y_unit: &'static str,
    /// The points, in the order of the condition.
    pub points: Vec<CurvePoint>,
}

/// One bin of a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Mean of the condition in the bin; of a category its number.
    pub x: f64,
    /// Mean of the residual there, or its root mean square.
    pub y: f64,
    /// Standard error of `y`, with as many independent samples as the residual's memory leaves.
    pub error: f64,
}

/// Name of a joint of the robot that a log is of.
pub(crate) fn joint_name(log: &Log, joint: usize) -> String {
    log.robot.joint_names.get(joint).cloned().unwrap_or_else(|| format!("joint {}", joint + 1))
}

/// What people call a column of a channel.
pub(crate) fn column_label(log: &Log, quantity: Quantity, column: u8) -> String {
    match quantity {
        Quantity::LinkEncoder | Quantity::MotorTorque => joint_name(log, usize::from(column)),
        _ => ["x", "y", "z"][usize::from(column).min(2)].to_owned(),
    }
}
