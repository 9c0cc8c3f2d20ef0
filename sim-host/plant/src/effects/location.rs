//! Where an effect may be, and where one is.

use crate::input::RobotFile;
use crate::robot::Channel;

/// What an effect may be attached to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LocationKind {
    /// One joint, by its name in the robot file.
    Joint,
    /// One instrument: `tracker`, `wrench`, `torque` or `link-encoder`.
    Channel,
    /// The cell as a whole: `at` is empty.
    Cell,
}

/// Where one effect is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Location {
    /// Joint index, 0 = A1.
    Joint(usize),
    /// An instrument.
    Channel(Channel),
    /// The cell as a whole.
    Cell,
}

impl Location {
    /// What it is, as files write it; nothing for the whole cell.
    pub fn name(self, robot: &RobotFile) -> &str {
        match self {
            Self::Joint(joint) => &robot.joint_names[joint],
            Self::Channel(channel) => {
                INSTRUMENT_NAMES.iter().find(|(_, c)| *c == channel).map_or("", |(name, _)| name)
            }
            Self::Cell => "",
        }
    }
}

/// Names of the instruments on the command line and in files.
pub(super) const INSTRUMENT_NAMES: [(&str, Channel); 4] = [
    ("tracker", Channel::Tracker),
    ("wrench", Channel::Wrench),
    ("torque", Channel::MotorTorque),
    ("link-encoder", Channel::LinkEncoder),
];
