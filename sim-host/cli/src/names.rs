//! Names of controllers and laws on the command line.

use clap::ValueEnum;
use trueweld_plant::simulate;

/// A hybrid controller.
#[derive(Clone, Copy, ValueEnum)]
pub enum Controller {
    /// Parallel hybrid control with selection matrix (2.2)
    Parallel,
    /// Superposed hybrid control (2.3)
    Superposed,
    /// External hybrid control: force loop around a position loop (2.4), (2.5)
    External,
}

impl Controller {
    pub fn controller(self) -> simulate::Controller {
        match self {
            Self::Parallel => simulate::Controller::Parallel,
            Self::Superposed => simulate::Controller::Superposed,
            Self::External => simulate::Controller::External,
        }
    }
}

/// A compensation law.
#[derive(Clone, Copy, ValueEnum)]
pub enum Compensator {
    /// No compensation
    None,
    /// From the measured wrench and the robot's stiffness
    Elastostatic,
    /// From the planned load and the robot's stiffness
    FeedForward,
    /// From motor torque and encoders
    Observer,
    /// Feed-forward, corrected by a seam sensor
    SeamTracking,
    /// Feed-forward, with stiffnesses learned from a seam sensor
    Adaptive,
    /// Feed-forward, corrected from pass to pass (--passes)
    Learning,
}

impl Compensator {
    pub fn law(self) -> &'static simulate::Law {
        match self {
            Self::None => &simulate::Law::None,
            Self::Elastostatic => &simulate::Law::Elastostatic,
            Self::FeedForward => &simulate::Law::FeedForward,
            Self::Observer => &simulate::Law::Observer,
            Self::SeamTracking => &simulate::Law::SeamTracking,
            Self::Adaptive => &simulate::Law::Adaptive,
            Self::Learning => &simulate::Law::Learning,
        }
    }
}
