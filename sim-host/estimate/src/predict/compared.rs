//! What a prediction compares with a log: quantities, and single numbers of them.

use nalgebra::Matrix3;
use trueweld_logs::channel::LogChannel;

/// What is compared.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum ComparedQuantity {
    /// Tracker: TCP position in B, m.
    Position,
    /// Tracker: rotation from the predicted to the measured tool, in T, rad.
    Rotation,
    /// Second encoder of a joint, rad.
    LinkEncoder,
    /// Motor torque of a joint, N·m.
    MotorTorque,
    /// Force on the tool in T below the spindle's frequency, N.
    Force,
    /// Moment on the tool in T below the spindle's frequency, N·m.
    Moment,
    /// Force on the tool in T in step with a multiple of the spindle's angle: real and imaginary
    /// amplitude, N.
    Ripple {
        /// Periods per turn.
        order: u8,
        /// True for the part with the sine.
        sine: bool,
    },
}

impl ComparedQuantity {
    /// The channel of the log that it is of.
    pub fn log_channel(self) -> LogChannel {
        match self {
            Self::Position => LogChannel::Position,
            Self::Rotation => LogChannel::Rotation,
            Self::LinkEncoder => LogChannel::LinkEncoder,
            Self::MotorTorque => LogChannel::MotorTorque,
            Self::Force | Self::Ripple { .. } => LogChannel::Force,
            Self::Moment => LogChannel::Moment,
        }
    }

    /// Channel name in results.
    pub fn channel(self) -> &'static str {
        self.log_channel().entry().name
    }

    /// True for what tracker and second encoders read, false for forces and torques.
    pub(super) fn is_pose(self) -> bool {
        matches!(self, Self::Position | Self::Rotation | Self::LinkEncoder)
    }

    /// Unit.
    pub fn unit(self) -> &'static str {
        self.log_channel().entry().unit
    }
}

/// One compared number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compared {
    /// What it is.
    pub quantity: ComparedQuantity,
    /// Component: axis, or joint from 0.
    pub component: u8,
    /// Row of the log it belongs to.
    pub row: usize,
    /// Measured value, in the quantity's unit; for a rotation, from the model without effects to the measured tool.
    pub measured: f64,
    /// Standard deviation of measured and propagated noise, in the quantity's unit.
    pub deviation: f64,
    /// True where that noise was stated by the log.
    pub stated: bool,
    /// Share of the variance that is no noise, but what the prediction is exact to: it is off alike
    /// in all values of this quantity and component in a log, which together say no more of it than
    /// one.
    pub alike: f64,
    /// Part of the deviation that is no noise, but how exact the prediction need be, in the
    /// quantity's unit: rows near each other are off alike by it.
    pub accuracy: f64,
}

/// Measured value of a rotation, which is compared as what it turns from the predicted one: NaN
/// where there is none.
pub(super) fn none_where_missing(rotation: &Matrix3<f64>) -> f64 {
    if rotation.sum().is_finite() { 0.0 } else { f64::NAN }
}

/// Lists what is compared of some columns of a quantity, row by row. `of`: measured value,
/// deviation of its noise, and whether that was stated, by index of the row and by column.
pub(super) fn list(
    compared: &mut Vec<Compared>,
    quantity: ComparedQuantity,
    rows: &[usize],
    columns: std::ops::Range<usize>,
    of: impl Fn(usize, usize) -> (f64, f64, bool),
) {
    for (k, &row) in rows.iter().enumerate() {
        for c in columns.clone() {
            let (measured, deviation, stated) = of(k, c);
            let component = c as u8;
            let (alike, accuracy) = (0.0, 0.0);
            compared.push(Compared {
                quantity,
                component,
                row,
                measured,
                deviation,
                stated,
                alike,
                accuracy,
            });
        }
    }
}
