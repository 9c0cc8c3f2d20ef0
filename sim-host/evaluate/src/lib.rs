//! What runs amount to: the figures of a weld and of a force step.

mod step;
mod weld;

pub use step::StepFigures;
pub use weld::{ForceFigures, Spread, WeldFigures};
