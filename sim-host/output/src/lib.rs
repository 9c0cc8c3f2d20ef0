//! What people and programs read of finished runs: tables for the terminal, JSON, self-contained
//! HTML pages and Rerun recordings; and the progress bar shown meanwhile.
//!
//! Everything here takes finished data and computes nothing about the robot but where to draw it.

mod certified;
mod color;
mod compared;
mod diagnosed;
mod error;
mod figures;
mod file;
pub mod html;
pub mod json;
mod laws;
mod path;
mod plot;
mod progress;
mod published;
#[cfg(feature = "rerun")]
pub mod rerun;
#[cfg(test)]
mod sample;
pub mod table;
mod words;

use trueweld_core::Robot;
use trueweld_evaluate::{StepFigures, WeldFigures};
use trueweld_plant::simulate::Recording;

pub use certified::{Certified, CertifiedWeld};
pub use diagnosed::{Diagnosed, Improved};
pub use error::OutputError;
pub use file::write_file;
pub use laws::LawsCompared;
pub use progress::Progress;

/// One finished weld, with what it amounts to and the robot that made it.
#[derive(Debug, Clone, Copy)]
pub struct WeldRun<'a> {
    /// What the run left behind.
    pub recording: &'a Recording,
    /// Its figures.
    pub figures: &'a WeldFigures,
    /// The robot, to draw it.
    pub robot: &'a Robot<f64>,
}

/// One finished step of the force set-point.
#[derive(Debug, Clone, Copy)]
pub struct StepRun<'a> {
    /// What the run left behind.
    pub recording: &'a Recording,
    /// Its figures.
    pub figures: &'a StepFigures,
}
