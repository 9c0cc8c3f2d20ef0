//! What runs amount to: the figures of a weld and of a force step, and what many welds prove of a
//! law, or show of several side by side.

pub mod certify;
mod figure;
pub mod laws;
pub mod margins;
mod rate;
mod requirements;
mod step;
mod weld;

pub use figure::{Figure, FigureOf, Limit};
pub use rate::Rate;
pub use requirements::{Faults, MarginLimits, Requirements, Uncertainty};
pub use step::StepFigures;
pub use weld::{FirstLimit, ForceFigures, JudgedFigure, Spread, WELD_FIGURES, WeldFigures};
