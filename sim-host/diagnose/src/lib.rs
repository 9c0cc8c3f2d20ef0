//! Which physical effect is missing: every effect of the library, at every place, as a hypothesis;
//! what to record next; and the model with what was found.
//!
//! ```text
//!   logs ready, fit problem (trueweld-estimate)
//!        │
//!        ▼
//!   diagnosis: calibrations, screen, search, gate ──► Diagnosis ──► experiment: Plan
//!        │
//!        ▼
//!   discover: where none explains them, a curve at a port, then its formula
//!        │
//!        ▼
//!   improve: steps, each judged where nothing was fitted ──► Improvement ──► posterior, model.toml
//!        │ of several units
//!        ▼
//!   fleet: what they share, how far they spread, which is an outlier
//! ```
//!
//! 1. The logs are fitted with calibrations alone ([`trueweld_estimate::fit::calibration`]).
//! 2. Every hypothesis is screened: its slopes at that point, with all calibrations free beside it,
//!    say by how much the sum of squares would fall, how small an effect would have been seen, and
//!    which hypotheses these data cannot tell apart.
//! 3. The best are fitted in full, calibrations with them, and judged by blocks in time that were
//!    left out; then pairs.
//! 4. What remains above the floor says whether the library explains the data at all.

//!
//! ```no_run
//! use trueweld_diagnose::{Diagnosed, diagnose};
//! use trueweld_estimate::fit::FitProblem;
//! use trueweld_estimate::residuals::compare::{baseline, experiments};
//! use trueweld_logs::campaign::read_logs;
//! use trueweld_plant::input::ModelFile;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let (_, logs) = read_logs(&["my-campaign".into()])?;
//! let model = ModelFile::read("my-campaign/model.toml")?;
//! let experiments = experiments(&logs, &baseline(&model))?;
//! let Diagnosed { diagnosis, .. } =
//!     diagnose(&FitProblem::new(&model, experiments), &logs, &|_, _| ())?;
//! println!("{}: {} explanations", diagnosis.verdict.name(), diagnosis.candidates.len());
//! # Ok(())
//! # }
//! ```

mod calibration_selection;
mod confuse;
mod detectability;
mod diagnosis;
pub mod discover;
mod equivalent_calibrations;
mod errors;
pub mod evidence;
pub mod experiment;
mod explanation;
pub mod fleet;
mod found;
mod gate;
mod gross_calibration;
pub mod improve;
mod log_evidence;
mod mountings;
pub mod posterior;
pub mod rules;
mod screen;
mod search;
#[cfg(test)]
mod static_loads;
mod wave_orders;

pub use confuse::Confusable;
pub use detectability::{Detectability, ShownEffect, detectability};
pub use diagnosis::{
    Candidate, Diagnosed, Diagnosis, DiagnosisFits, DiagnosisVerdict, ExplainedPart, Incomplete,
    PortAt, ProgressCallback, diagnose,
};
pub use errors::DiagnosisErrors;
pub use explanation::{Explanation, ExplanationReason, ImprovedChannel, explain, reason_of_best};
pub use found::FittedEffect;
pub use mountings::{Combination, Mountings};
pub use rules::{SquareSum, held_out_score, parts, score};
pub use screen::EffectLimit;
pub use search::fit_calibrations;
