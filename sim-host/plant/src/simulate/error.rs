//! Why a run did not come to its end.

use crate::integrate::Diverged;
use crate::integrate::rest::EquilibriumError;
use trueweld_compensators::BuildError;

/// Why a run did not come to its end.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RunError {
    /// The tool cannot be brought to some point of the seam.
    #[error("the robot cannot hold the tool {path:.3} m along the seam: {reason}")]
    Reach {
        /// Path position, m.
        path: f64,
        /// In words.
        reason: &'static str,
    },
    /// No deformed start.
    #[error(transparent)]
    Rest(#[from] EquilibriumError),
    /// The state left the finite numbers.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// A gain that does not suit the control period.
    #[error("at a control period of {period} s {source}")]
    Law {
        /// The law and its gain.
        source: BuildError,
        /// Control period, s.
        period: f64,
    },
    /// A cell that cannot be built from what was drawn for it.
    #[error("the cell cannot be built")]
    Cell,
    /// A law that learns from a seam sensor, in a cell without one.
    #[error("the law {law} needs a seam sensor, and the sensor file has no [seam]")]
    NoSeamSensor {
        /// Its name.
        law: String,
    },
}
