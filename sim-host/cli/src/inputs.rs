//! Arguments of the commands that weld: files and options of a cell.

use crate::session;
use clap::Args;
use clap::builder::RangedI64ValueParser;
use miette::{Result, miette};
use std::path::{Path, PathBuf};
use trueweld::{CellFiles, FoundInLog, WeldingCell};

/// Input files of one weld; each has an embedded default.
#[derive(Args, Default)]
pub(crate) struct WeldArguments {
    /// Weld file (default: the first published sequence)
    #[arg(long, value_name = "F")]
    weld: Option<PathBuf>,
    #[command(flatten)]
    pub cell: CellArguments,
}

impl WeldArguments {
    /// The cell with its weld.
    pub(crate) fn read(&self) -> Result<WeldingCell> {
        self.cell.read(self.weld.as_deref())
    }
}

/// Input files of a cell, whatever it welds.
#[derive(Args, Default)]
pub(crate) struct CellArguments {
    /// Robot file (default: KR 500 MT with FSW end effector)
    #[arg(long, value_name = "F")]
    robot: Option<PathBuf>,
    /// Model file: robot, process and effects of the real cell, instead of --robot and --process
    #[arg(long, value_name = "F", conflicts_with_all = ["robot", "process"])]
    model: Option<PathBuf>,
    /// The controller knows the model file's effects as well: other numbers of its robot, such as stiffness
    /// and geometry; refused where there are others
    #[arg(long, requires = "model")]
    informed: bool,
    /// Process file (default: lap weld, stringer on 2024-T3 skin)
    #[arg(long, value_name = "F")]
    process: Option<PathBuf>,
    /// Gains and limits of the controllers (default: tuned for the KR 500 MT)
    #[arg(long, value_name = "F")]
    control: Option<PathBuf>,
    /// Sensor file (default: encoders and force sensor of the KR 500 MT cell)
    #[arg(long, value_name = "F")]
    sensors: Option<PathBuf>,
    /// Physical effect of the real robot that the controller does not know; may be given several
    /// times
    #[arg(long, value_name = "ID:AT:NAME=VALUE,...")]
    effect: Vec<String>,
    /// Relative error of the joint stiffness that the controller believes in, such as 0.1 (default:
    /// 0; of compare-laws: 0.2)
    #[arg(long, value_name = "E", allow_negative_numbers = true)]
    pub stiffness_error: Option<f64>,
    /// Speed of the spindle in turns a minute, in the sense of the process file's (default: the
    /// process file's speed)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    spindle_rpm: Option<f64>,
    /// Control period in seconds (default: the control file's)
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    period: Option<f64>,
    /// Seed of the sensors' noise (default: the sensor file's)
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
}

/// Welds of one seam that may be asked for: a law that has not learned by then does not.
pub(crate) fn passes() -> RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(1..=1000)
}

/// Checks the length to which a seam is cut, m: such a weld has a steady part worth its name.
///
/// # Errors
/// Another length.
pub(crate) fn check_length(length: f64) -> Result<()> {
    const SHORTEST: f64 = 0.02;
    match length >= SHORTEST && length.is_finite() {
        true => Ok(()),
        false => Err(miette!("--length {length}: expected a number of metres from {SHORTEST} up")),
    }
}

impl CellArguments {
    /// The cell's files and options.
    pub(crate) fn files(&self) -> CellFiles {
        CellFiles {
            robot: self.robot.clone(),
            model: self.model.clone(),
            informed: self.informed,
            process: self.process.clone(),
            control: self.control.clone(),
            sensors: self.sensors.clone(),
            effects: self.effect.clone(),
            stiffness_error: self.stiffness_error,
            spindle_rpm: self.spindle_rpm,
            period: self.period,
            seed: self.seed,
            found: FoundInLog::default(),
            law_files: session::law_files(),
        }
    }

    /// The cell with a weld. `weld_file`: `None` for the embedded one.
    pub(crate) fn read(&self, weld_file: Option<&Path>) -> Result<WeldingCell> {
        self.files().read_weld(weld_file)
    }

    /// Whether a control file is given, or the one that is part of the program stands in.
    pub(crate) fn states_control(&self) -> bool {
        self.control.is_some()
    }
}
