//! Numbers of a cell from its logs: joint stiffness, damping, and the welding process.
//!
//! What the source paper does before it simulates (Bres et al. 2010, section 1): the robot and the
//! process are known roughly, and measured. Every identification is one fit through the plant
//! (`fit`): the numbers asked for are free without a prior, as logarithms, beside every
//! calibration that the logs can show (encoder zeros, tracker registration, how links are mounted).
//! After each pass the model takes the numbers found and the logs are made ready anew, until nothing
//! moves: a robot that is known to a factor of two only comes out right.
//!
//! ```text
//! model, logs ─► fit: pass after pass ─► Fit: numbers, covariance, residuals
//!                      │ stiffness: what the poses carry, K(τ), linearity
//!                      │ damping: modes, logarithmic decrement beside the fit
//!                      │ process: orders of the ripple from the spectrum, sections of the weld
//!                      ▼
//!                 Identification ─► file: robot or process file with intervals and source
//! ```
//!
//! ```no_run
//! use trueweld_estimate::identify::{IdentificationTarget, identify};
//! use trueweld_logs::campaign::read_logs;
//! use trueweld_plant::input::ModelFile;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let model = ModelFile::read("my-campaign/model.toml")?;
//! let (_, logs) = read_logs(&["my-campaign".into()])?;
//! let found = identify(IdentificationTarget::Stiffness, &model, logs, &|_, _| ())?;
//! for number in &found.numbers {
//!     println!("{} {}: {:.3e}", number.name, number.at, number.value);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Left out: a stiffness that changes with the joint's angle, and damping that is not viscous.

mod coordinates;
mod curve;
mod error;
pub mod file;
mod fit;
mod identification;
mod modes;
mod number;
pub mod plan;
mod process;

pub use curve::{CurvePoint, StiffnessCurve};
pub use error::IdentifyError;
pub use identification::{Identification, IdentificationTarget, identify};
pub use modes::{ByDecrement, Mode};
pub use number::Number;
pub use process::{Section, WeldPart};
