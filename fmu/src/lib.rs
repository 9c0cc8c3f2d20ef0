//! Laws and simulated cells as functional mock-up units (FMU) for co-simulation, FMI 2.0 and 3.0.
//!
//! A *law* FMU is the controller of a cell with a compensation law: it takes what the instruments
//! read and gives motor torques and the correction. A *plant* FMU is the cell: it takes motor
//! torques, or the correction, and gives what the instruments read. Both take one step a control
//! period; a plant's own steps are shorter and inside. Coupled, the law first, they are `trueweld
//! weld` to the last digit.
//!
//! * [`FmuExport`] writes the file: model description, the cell's files, shared libraries, and the
//!   sources of this library;
//! * the groups of variables are declared once; model description, getting and setting follow;
//! * an instance knows what may be called when, and gives its state as bytes that another process
//!   takes;
//! * `abi` is what importers call, and all of this crate's `unsafe`: the functions of FMI 2.0 and
//!   3.0, from which no panic leaves.
//!
//! ```no_run
//! use trueweld::CellFiles;
//! use trueweld_fmu::{FmiVersion, FmuExport, FmuLibrary, FmuModel};
//! use trueweld_plant::controllers::ControllerKind;
//!
//! let files = CellFiles::new();
//! let export = FmuExport {
//!     files: &files,
//!     controller: ControllerKind::EXTERNAL,
//!     model: FmuModel::Law(trueweld::law("seam-tracking")?),
//!     version: FmiVersion::Fmi2,
//! };
//! let (bytes, summary) = export.package(&files.read()?, &[FmuLibrary::of_program()?])?;
//! std::fs::write("seam-tracking.fmu", bytes).expect("a file");
//! println!("one step each {} s", summary.step);
//! # Ok::<(), miette::Report>(())
//! ```
//!
//! Left out: model exchange, scheduled execution, derivatives of outputs, laws of one's own.

pub mod abi;
mod contents;
mod description;
mod groups;
mod instance;
mod law;
mod model;
mod package;
mod plant;
mod variable;

pub use contents::FmuModel;
pub use description::FmiVersion;
pub use package::{FmuExport, FmuLibrary, FmuSummary, carry_library};
pub use plant::CellInput;
