//! Studies of a cell.

mod paper;
mod sensitivity;

pub use paper::{EnvelopeResult, PublishedStatement, StudyPaperResult};
pub use sensitivity::{
    InputDerivative, InputIndices, SensitivityFigure, StudyInput, StudySensitivityResult,
};
