//! What runs amount to: the figures of a weld and of a force step, and what many welds prove of a
//! law, or show of several side by side.

pub mod certify;
pub mod laws;
pub mod margins;
mod rate;
mod step;
mod weld;

pub use rate::Rate;
pub use step::StepFigures;
pub use weld::{ForceFigures, Spread, WeldFigures};
