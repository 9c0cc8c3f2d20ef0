//! Measurements judge the model: logs, comparison, diagnosis of missing effects, improvement.
//!
//! ```text
//!   log folders                         model.toml
//!       │ data: columns, units, noise       │ plant/input
//!       ▼                                   ▼
//!      Log ──► predict::PreparedLog ◄── BaselineModel, Effects
//!                      │ predict: the plant driven by the log
//!                      ▼
//!      Prediction: (measured − predicted)/noise ──► residuals: Comparison, Findings
//!                      │
//!                      ▼
//!      fit: FitState ──► Fitted   least squares, priors, blocks left out
//!                      │
//!                      ▼
//!      diagnose: every effect at every place ──► Diagnosis ──► experiment: Plan
//!                      │
//!                      ▼
//!      discover: where none explains them, a curve at a port, then its formula
//!                      │
//!                      ▼
//!      improve: steps, each judged where nothing was fitted ──► Improvement, model.toml
//! ```
//!
//! | room | holds |
//! |---|---|
//! | [`data`] | logs, campaigns of logs, their noise, filters |
//! | [`mistakes`] | gross mistakes in the files, found before any physics |
//! | [`register`] | where a tracker stands, and where on the tool it looks |
//! | [`predict`] | what a model predicts of a log's channels |
//! | [`fit`] | effects fitted to logs by their residuals; calibrations |
//! | [`residuals`] | how far a model is from its logs, and under which conditions |
//! | [`diagnose`] | which effect is missing, and the curve that shows it |
//! | [`discover`] | laws that the library does not hold |
//! | [`experiment`] | what to record next |
//! | [`improve`] | a model with what was found, step by step |
//! | [`encoder_noise`] | what noise that drives every prediction leaves open of fitted values |
//! | [`posterior`] | what logs leave open of all that was fitted, jointly |
//!
//! ```no_run
//! use trueweld_measure::data::campaign::read_logs;
//! use trueweld_measure::residuals::compare::{baseline, experiments};
//! use trueweld_measure::{diagnose::diagnose, fit::FitProblem};
//! use trueweld_plant::input::ModelFile;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (_, logs) = read_logs(&["my-campaign".into()])?;
//! let model = ModelFile::read("my-campaign/model.toml")?;
//! let experiments = experiments(&logs, &baseline(&model))?;
//! let diagnosis = diagnose(&FitProblem::new(&model, experiments), &logs, &|_, _| ())?;
//! println!("{}: {} explanations", diagnosis.verdict.name(), diagnosis.candidates.len());
//! # Ok(())
//! # }
//! ```

pub mod align;
pub mod data;
pub mod diagnose;
pub mod discover;
pub mod encoder_noise;
pub mod experiment;
pub mod fit;
pub mod improve;
pub mod mistakes;
pub mod posterior;
pub mod predict;
pub mod register;
pub mod residuals;

/// Standard deviations of half a 95 % interval of a normal distribution.
pub const HALF_95: f64 = 1.96;

/// Variance inflation of what is fitted to residuals of one channel: they follow each other, and so
/// many count as one.
pub const AUTOCORRELATION_INFLATION: f64 = 4.0;

/// A radian counts as so many metres where rotations and positions are weighed together.
pub(crate) const ROTATION_LENGTH: f64 = 0.5;
