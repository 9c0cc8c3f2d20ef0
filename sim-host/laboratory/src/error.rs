//! Why a campaign could not be made.

use crate::static_arm::Unsettled;
use trueweld_plant::effects::EffectError;
use trueweld_plant::input::InputError;
use trueweld_plant::robot::TooManyStates;
use trueweld_plant::simulate::RunError;

/// Why a campaign could not be made.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// An effect cannot be installed.
    #[error(transparent)]
    Effect(#[from] EffectError),
    /// The effect outside the library needs a state of its own and there is no room.
    #[error(transparent)]
    States(#[from] TooManyStates),
    /// A posture has no equilibrium, or a motion diverged.
    #[error(transparent)]
    Links(#[from] Unsettled),
    /// The links move too fast to be followed.
    #[error("{0}")]
    TooFast(String),
    /// A weld did not come to its end.
    #[error(transparent)]
    Weld(#[from] RunError),
    /// A weld is to be made in a cell that states no process.
    #[error("{log}: a weld needs a process, and the protocol names none")]
    NoProcess {
        /// The log.
        log: String,
    },
    /// The model of the campaign cannot be written.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] std::io::Error),
}
