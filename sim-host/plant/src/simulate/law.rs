//! The compensation laws by their names, built from the gains of a cell.

use super::RunError;
use crate::input::{Control, Sensors};
use trueweld_compensators::{
    Adaptive, Elastostatic, FeedForward, Learning, Observer, OuterIntegral, SeamTracking,
    Uncompensated,
};
use trueweld_core::compensation::Compensator;

/// Where the law of a run comes from: one of this project's ([`Law`]), or a user's own.
pub trait BuildLaw: std::fmt::Debug + Sync {
    /// Its name in results.
    fn name(&self) -> &'static str;

    /// The law as it is before a first weld. `length`: of the weld, m.
    ///
    /// # Errors
    /// [`RunError::Law`] where a gain does not suit the control period, [`RunError::NoSeamSensor`].
    fn build(
        &self,
        control: &Control,
        sensors: &Sensors,
        length: f64,
    ) -> Result<Box<dyn Compensator<f64>>, RunError>;
}

/// Which compensation law.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Law {
    /// None.
    None,
    /// From the measured wrench.
    Elastostatic,
    /// From the planned load case.
    FeedForward,
    /// From motor torque and encoders.
    Observer,
    /// Feed-forward and a seam sensor.
    SeamTracking,
    /// Feed-forward with compliances estimated from the seam sensor.
    Adaptive,
    /// Seam tracking, corrected from pass to pass by what the seam sensor saw.
    Learning,
}

impl Law {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Elastostatic,
        Self::FeedForward,
        Self::Observer,
        Self::SeamTracking,
        Self::Adaptive,
        Self::Learning,
    ];

    /// True for a law that is no better than the one beneath it without a seam sensor.
    pub fn needs_seam_sensor(self) -> bool {
        matches!(self, Self::SeamTracking | Self::Adaptive | Self::Learning)
    }

    /// True for a law that keeps something from one weld of a seam to the next.
    pub fn learns(self) -> bool {
        matches!(self, Self::Adaptive | Self::Learning)
    }

    /// What it goes by, in a few words.
    pub fn summary(self) -> &'static str {
        match self {
            Self::None => "No compensation",
            Self::Elastostatic => "From the measured wrench and the robot's stiffness",
            Self::FeedForward => "From the planned load and the robot's stiffness",
            Self::Observer => "From motor torque and encoders",
            Self::SeamTracking => "Feed-forward, corrected by a seam sensor",
            Self::Adaptive => {
                "Feed-forward, with stiffnesses learned from a seam sensor (--passes)"
            }
            Self::Learning => "Seam tracking, corrected from pass to pass (--passes)",
        }
    }

    /// The law with the gains of a cell; `None` where one of them does not suit the control period.
    fn with(self, control: &Control, length: f64) -> Option<Box<dyn Compensator<f64>>> {
        let (gains, period) = (&control.compensation, control.period);
        match self {
            Self::None => Some(Box::new(Uncompensated)),
            Self::Elastostatic => {
                let law = Elastostatic::new(gains.wrench_filter, period)?;
                Some(Box::new(law.without_crosstalk(gains.crosstalk)))
            }
            Self::FeedForward => followed(FeedForward, control),
            Self::Observer => Some(Box::new(Observer::new(gains.observer, period)?)),
            Self::SeamTracking => {
                followed(SeamTracking::new(FeedForward, gains.tracking, period)?, control)
            }
            Self::Adaptive => followed(Adaptive::new(gains.prior, period)?, control),
            Self::Learning => {
                let learning = Learning::new(FeedForward, length, gains.learning, period)?;
                followed(SeamTracking::new(learning, gains.tracking, period)?, control)
            }
        }
    }
}

/// A law with what the position loop lacks of its demand made up for. Not for laws fed by force,
/// which answer the motion.
fn followed(
    law: impl Compensator<f64> + 'static,
    control: &Control,
) -> Option<Box<dyn Compensator<f64>>> {
    Some(Box::new(OuterIntegral::new(law, control.compensation.following, control.period)?))
}

impl BuildLaw for Law {
    fn name(&self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Elastostatic => "elastostatic",
            Self::FeedForward => "feed-forward",
            Self::Observer => "observer",
            Self::SeamTracking => "seam-tracking",
            Self::Adaptive => "adaptive",
            Self::Learning => "learning",
        }
    }

    fn build(
        &self,
        control: &Control,
        sensors: &Sensors,
        length: f64,
    ) -> Result<Box<dyn Compensator<f64>>, RunError> {
        if self.needs_seam_sensor() && sensors.seam.is_none() {
            return Err(RunError::NoSeamSensor { law: self.name() });
        }
        self.with(control, length).ok_or(RunError::Law { law: self.name(), period: control.period })
    }
}
