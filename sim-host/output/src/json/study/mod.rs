//! Studies of a cell.

mod layout;
mod limits;
mod paper;
mod sensitivity;

pub use layout::{
    AllowedFigure, ConfirmedPlacement, ConfirmedWeldResult, PlacementFigures, StudyLayoutResult,
};
pub use limits::{LimitResult, LimitRun, PlaceLimits, StudyLimitsResult};
pub use paper::{EnvelopeResult, PublishedStatement, StudyPaperResult};
pub use sensitivity::{
    InputDerivative, InputIndices, SensitivityFigure, StudyInput, StudySensitivityResult,
};
