//! The front door: from a cell's files to a result in a few lines.
//!
//! ```text
//!   robot, process, weld, control,         model.toml, logs
//!   sensors, effects                            │ MeasuredLogs: read, checked, made ready
//!      │ CellFiles: read and checked            ├──► compare   how far the model is off, and where
//!      ▼                                        ├──► diagnose  which effect is missing
//!   WeldingCell ──► simulate  a weld            ├──► improve   the model with it, refitted
//!              └──► certify   what it proves    └──► identify  stiffness, damping, process
//! ```
//!
//! Every function returns data: numbers in SI units, frames by letter (B base, F flange, T tool,
//! W weld), enums. Sentences, tables and pages are made by `trueweld-output`. The program `trueweld`
//! (crate `trueweld-cli`) is arguments, these functions, and output. A file or value that cannot be
//! used ends in one error that names its place; where it came by an option, the error names that of
//! the command line.
//!
//! | layer | crate |
//! |---|---|
//! | this page: files in, results out | `trueweld` |
//! | figures, requirements, certificates | [`evaluate`] |
//! | missing effects, the next experiment, the improved model | [`diagnosis`] |
//! | prediction, residuals, fits, identification | [`estimate`] |
//! | logs | [`logs`] |
//! | simulated recordings | [`laboratory`] |
//! | input files, effects, elastic robot, process, sensors | [`plant`] |
//! | compensation laws | [`laws`] |
//! | what runs on the controller | [`core`] |
//!
//! A weld simulated, with and without a law:
//!
//! ```no_run
//! use trueweld::{CellFiles, law, simulate};
//!
//! let files = CellFiles::new().robot("my-robot.toml").effect("backlash:A5:half_gap_rad=2e-4");
//! let cell = files.weld("my-weld.toml")?;
//! for weld in simulate(&cell).law(law("none")?).law(law("elastostatic")?).run()?.runs {
//!     println!("{}: {:.2} mm", weld.recording.compensator, 1e3 * weld.figures.lateral.max_abs);
//! }
//! # Ok::<(), miette::Report>(())
//! ```
//!
//! Which effect a model lacks:
//!
//! ```no_run
//! use trueweld::{MeasuredLogs, diagnose};
//!
//! let mut measured = MeasuredLogs::read("my-campaign")?;
//! let told = diagnose(&mut measured).run()?;
//! println!("{}", told.diagnosis.verdict.name());
//! for candidate in &told.diagnosis.candidates {
//!     println!("{}: {:.2}", candidate.name(&measured.model.robot), candidate.probability);
//! }
//! # Ok::<(), miette::Report>(())
//! ```
//!
//! What a law is worth in cells that are not known exactly:
//!
//! ```no_run
//! use trueweld::{CellFiles, certify, law};
//!
//! let cell = CellFiles::new().read()?;
//! let certificate = certify(&[cell], law("seam-tracking")?).trials(200).evidence("out").run()?;
//! println!("{}", certificate.verdict().name());
//! for requirement in &certificate.welds[0].requirements {
//!     println!("{}: {} of {}", requirement.name, requirement.achieved, requirement.limit);
//! }
//! # Ok::<(), miette::Report>(())
//! ```
//!
//! A recorded weld is made again, with other laws or gains, by [`LoggedWeld`]; a recorded run of a
//! controller's core is compared with the core on this machine by [`read_core_log`] and [`CoreFile`].
//!
//! Laws and effects of one's own enter by a [`Program`]; [`prelude`] and [`gains!`] are what they are
//! written with.

mod cell;
mod certify;
mod compare;
mod compare_logs;
mod core_log;
mod diagnose;
mod fixture;
mod fleet;
mod identify;
mod improve;
mod logged_weld;
mod measured;
mod plan;
mod program;
mod provenance;
mod simulate;
mod work;

pub use cell::{
    CellFiles, FoundInLog, PLANT_STEP, STEP_OF_MANY, WeldingCell, checked_option, is_same_file,
};
pub use certify::{
    CertifyOptions, PreparedCertification, RequirementsFile, StartedCertification, certify,
};
pub use compare::compare;
pub use compare_logs::{ComparedPair, compare_logs};
pub use core_log::{
    CORE_INPUTS_FILE, CORE_OUTPUTS_FILE, CoreFile, read_core_log, record_core, write_core_log,
};
pub use diagnose::{CellDiagnosis, DiagnoseOptions, DiagnoseTask, diagnose};
pub use fixture::{Embedded, read_input};
pub use fleet::{ImprovedFleet, MeasuredUnit, hold_out, improve_fleet, read_units};
pub use identify::identify;
pub use improve::{ImproveOptions, ImproveTask, ImprovedModel, improve};
pub use logged_weld::LoggedWeld;
pub use measured::{GivenLogs, HeldOutLogs, MeasuredLogs, measured_provenance};
pub use plan::{PlannedExperiments, control_and_sensors, plan};
pub use program::Program;
pub use provenance::{SOURCES, VERSION, of_program};
pub use simulate::{SimulateOptions, SimulatedWeld, SimulatedWelds, simulate};
pub use work::{MeasuredWork, WorkProgress};

pub use miette::Result;
#[doc(hidden)]
pub use serde;
pub use trueweld_estimate::identify::IdentificationTarget;
pub use trueweld_evaluate::certify::{Certificate, CertificationOutcome, Repeat, Shard, Verdict};

/// Laws: the trait to implement, and what it is made of.
pub use trueweld_compensators as laws;
/// What a law works with: robot, poses, observations.
pub use trueweld_core as core;
pub use trueweld_diagnose as diagnosis;
pub use trueweld_estimate as estimate;
pub use trueweld_evaluate as evaluate;
pub use trueweld_laboratory as laboratory;
pub use trueweld_logs as logs;
pub use trueweld_plant as plant;
pub use trueweld_plant::{effects, robot};

/// The law of a name, or the combination of laws with a plus between their names: those of this
/// project and those that a [`Program`] installed.
///
/// # Errors
/// The name that no law has, and those that there are.
pub fn law(name: &str) -> Result<laws::Entry> {
    laws::find(name).map_err(|unknown| {
        let known: Vec<&str> = laws::library().iter().map(laws::Entry::name).collect();
        miette::miette!("{unknown}: there is no such law; expected one of {}", known.join(", "))
    })
}

/// What a law and an effect of one's own are written with.
pub mod prelude {
    pub use crate::core::compensation::{Compensator, Observation};
    pub use crate::core::{Fault, Robot, Twist};
    pub use crate::effects::{Action, EffectKind, LocationKind, Parameter};
    pub use crate::gains;
    pub use crate::laws::{FeedForward, GainError, Law, Needs, OuterIntegral, Setup, require};
    pub use crate::robot::{JointState, Port, Term};

    /// What a law asks for: a displacement of the set-point, axes of the weld frame.
    pub type Demand = Result<Twist<f64>, Fault>;
}

/// Gains of a law of one's own, each with its default: a struct that is read from the law's table
/// in a control file.
#[macro_export]
macro_rules! gains {
    ($(#[$meta:meta])* $name:ident {
        $($(#[$of:meta])* $key:ident: $kind:ty = $default:expr),* $(,)?
    }) => {
        $(#[$meta])*
        #[derive($crate::serde::Serialize, $crate::serde::Deserialize)]
        #[serde(crate = "trueweld::serde")]
        struct $name {
            $($(#[$of])* $key: $kind),*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default),* }
            }
        }
    };
}
