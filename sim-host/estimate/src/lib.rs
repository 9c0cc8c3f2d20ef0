//! What a model predicts of logs, how far it is off, and effects and numbers fitted to them.
//!
//! ```text
//!   Log (trueweld-logs)                 model.toml
//!       │                                   │ plant/input
//!       ▼                                   ▼
//!      predict::PreparedLog ◄──────── BaselineModel, Effects
//!                      │ predict: the plant driven by the log
//!                      ▼
//!      Prediction: (measured − predicted)/noise ──► residuals: Comparison, Findings
//!                      │
//!                      ▼
//!      fit: FitState ──► Fitted   least squares, priors, blocks left out ──► identify: numbers
//! ```
//!
//! | room | holds |
//! |---|---|
//! | [`log_faults`] | gross mistakes in the files, found before any physics |
//! | [`outlying_loads`] | loads at rest that the others of their posture contradict |
//! | [`predict`] | what a model predicts of a log's channels |
//! | [`align`] | clocks fitted to what a model predicts |
//! | [`residuals`] | how far a model is from its logs, and under which conditions |
//! | [`fit`] | effects fitted to logs by their residuals; calibrations |
//! | [`disturbance`] | the force of a recorded weld that its model does not explain |
//! | [`encoder_noise`] | what noise that drives every prediction leaves open of fitted values |
//! | [`random_effects`] | mean and spread of values of several units |
//! | [`safe_space`] | where an arm may stand, and under which loads |
//! | [`identify`] | stiffness, damping and process from logs, without a prior; poses that tell them best |
//!
//! ```no_run
//! use trueweld_estimate::fit::FitProblem;
//! use trueweld_estimate::residuals::compare::{baseline, compare, experiments};
//! use trueweld_logs::campaign::read_logs;
//! use trueweld_plant::input::ModelFile;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (_, logs) = read_logs(&["my-campaign".into()])?;
//! let model = ModelFile::read("my-campaign/model.toml")?;
//! let problem = FitProblem::new(&model, experiments(&logs, &baseline(&model))?);
//! let comparison = compare(&model, &logs, &problem, &|_| {})?;
//! println!("{:.2} times the noise", comparison.score);
//! # Ok(())
//! # }
//! ```

pub mod align;
pub mod disturbance;
pub mod encoder_noise;
pub mod fit;
pub mod identify;
pub mod log_faults;
pub mod outlying_loads;
pub mod predict;
pub mod random_effects;
pub mod residuals;
pub mod safe_space;

/// Variance inflation of what is fitted to residuals of one channel: they follow each other, and so
/// many count as one.
pub const AUTOCORRELATION_INFLATION: f64 = 4.0;
