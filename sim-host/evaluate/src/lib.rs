//! What runs amount to: figures, margins, certificates, comparisons of laws.
//!
//! Figures ([`WeldFigures`], [`StepFigures`]) reduce one recording to numbers; [`margins`] opens the
//! loop at places of a weld; [`certify`] runs many sampled cells against requirements, [`laws`]
//! sets laws side by side on the same cells, and [`study`] asks where a part is best put, how far the
//! process can be driven and what its figures depend on. All take a
//! [`Scenario`](trueweld_plant::simulate::Scenario) and run the plant's own code.
//!
//! ```
//! use trueweld_evaluate::WeldFigures;
//! use trueweld_plant::simulate::{RunError, Scenario, run};
//!
//! /// Largest lateral deviation in the steady part, m; nothing where there is none.
//! fn lateral(scenario: &Scenario<'_>) -> Result<Option<f64>, RunError> {
//!     let recording = run(scenario, |_| {})?;
//!     Ok(WeldFigures::of(&recording).map(|figures| figures.lateral.max_abs))
//! }
//! ```

mod arm;
pub mod certify;
mod core_replay;
mod figure;
pub mod laws;
pub mod margins;
mod rate;
mod replayed;
mod requirements;
mod step;
pub mod study;
pub mod tune;
mod uncertain;
mod weld;

pub use arm::{ArmAt, PlacedSeam};
pub use core_replay::{
    CoreDifference, CoreOutput, CoreOutputs, CorePeriod, CoreReadings, CoreReplay, CoreRun,
    CoreScalar, MEASUREMENT_NUMBERS, PERIOD_NUMBERS,
};
pub use figure::{Figure, FigureOf, Limit};
pub use rate::Rate;
pub use replayed::{RecordedRow, ReplayCheck, TrackFigures};
pub use requirements::{Faults, IdleLimit, MarginLimits, NotRequired, Requirements};
pub use step::StepFigures;
pub use uncertain::{
    Distribution, Group, NoSuchNumber, ReplacedAssumption, SHORT_SOURCE, UncertainCell,
    UncertainEntry, UncertainNumber, Uncertainty,
};
pub use weld::{
    ASKED_FIGURES, AskedWeld, DriveLoad, FirstLimit, ForceFigures, JudgedFigure, PhaseFigures,
    Spread, WELD_FIGURES, WELD_PHASES, WeldFigures,
};
