//! The Python module `trueweld._core`: what the facade in `python/trueweld` stands on.
//!
//! ```text
//!   trueweld (Python)      names, documentation, pictures
//!        │
//!   _core                  command     a command of the program in process: results in all forms
//!        │                 law         a law in Python as one of the simulator's
//!        │                 log         a recorded log as arrays
//!        │                 simulation  a weld period by period: `stepped` is what changes of it
//!        │                 rollout     many of them on all cores
//!        │                 table       samples as arrays and through Arrow
//!        ▼
//!   trueweld-cli, trueweld
//! ```
//!
//! Nothing is computed here. Commands run as the program's own, so that both give the same bytes.
//! While Rust works, other threads of Python run too.

mod command;
mod error;
mod law;
mod log;
mod rollout;
mod simulation;
mod stepped;
mod table;

use pyo3::prelude::*;
use std::ffi::OsString;

/// Runs the program with these arguments, the first of which is its name, and gives its status. It
/// prints, reads and writes as the program does.
#[pyfunction]
fn run_program(py: Python<'_>, arguments: Vec<OsString>) -> u8 {
    py.detach(|| trueweld_cli::run_from(arguments))
}

/// See the crate's documentation.
#[pymodule]
mod _core {
    #[pymodule_export]
    use super::command::{CommandOutcome, FoundResult, describe_commands, run_command};
    #[pymodule_export]
    use super::law::LawReadings;
    #[pymodule_export]
    use super::log::{LogArrays, read_log};
    #[pymodule_export]
    use super::rollout::{roll_out, step_all};
    #[pymodule_export]
    use super::run_program;
    #[pymodule_export]
    use super::simulation::CellSimulation;
    #[pymodule_export]
    use super::table::ResultTable;
    use pyo3::prelude::*;

    /// The library for FMUs, built with this module.
    #[cfg(fmu_library)]
    const FMU_LIBRARY: &[u8] = include_bytes!(env!("TRUEWELD_FMU_LIBRARY"));

    #[pymodule_init]
    fn begin(module: &Bound<'_, PyModule>) -> PyResult<()> {
        #[cfg(fmu_library)]
        trueweld_fmu::carry_library(FMU_LIBRARY);
        module.add("VERSION", trueweld::VERSION)?;
        module.add("SOURCES", trueweld::SOURCES)
    }
}
