//! The cell that a command works on: input files given, or the embedded ones.

use clap::Args;
use miette::{IntoDiagnostic, Report, Result, miette};
use nalgebra::SVector;
use std::path::{Path, PathBuf};
use trueweld_core::Robot;
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{Control, ModelFile, Process, RobotFile, Sensors, Weld};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::simulate::{BuildLaw, Controller, Program, RunError, Scenario, Seam};

/// Reads a file, or the embedded one where none is given.
macro_rules! embedded {
    ($type:ty, $path:expr, $file:literal) => {
        match $path {
            Some(path) => <$type>::read(path)?,
            None => <$type>::parse(
                include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/", $file)),
                concat!("embedded ", $file),
            )?,
        }
    };
}
pub(crate) use embedded;

/// Input files of one weld; each has an embedded default.
#[derive(Args, Default)]
pub struct Files {
    /// Weld file (default: the first published sequence)
    #[arg(long, value_name = "F")]
    weld: Option<PathBuf>,
    #[command(flatten)]
    pub cell: CellFiles,
}

impl Files {
    pub fn read(&self) -> Result<Inputs> {
        self.cell.read(self.weld.as_deref())
    }
}

/// Input files of a cell, whatever it welds.
#[derive(Args, Default)]
pub struct CellFiles {
    /// Robot file (default: KR 500 MT with FSW end effector)
    #[arg(long, value_name = "F")]
    robot: Option<PathBuf>,
    /// Model file: robot, process and effects of the real cell, instead of --robot and --process
    #[arg(long, value_name = "F", conflicts_with_all = ["robot", "process"])]
    model: Option<PathBuf>,
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

/// Longest plant step, s.
const PLANT_STEP: f64 = 1e-3;

/// Longest plant step where welds are made by the hundred, s: a weld ends within 0.03 µm and 0.4 N
/// of where it does at 0.25 ms.
pub const STEP_OF_MANY: f64 = 2e-3;

/// Fastest spindle that is believed, turns a minute: ten times what friction stir welding runs at.
const FASTEST_SPINDLE: f64 = 30_000.0;

/// Everything read and checked.
pub struct Inputs {
    /// Where the weld was read from, for messages.
    pub weld_file: String,
    pub weld_name: String,
    pub weld: Weld,
    pub robot: RobotFile,
    pub control: Control,
    pub sensors: Sensors,
    pub cell: Cell,
    /// The process as the weld is planned with it.
    pub planned: Process,
    /// The robot as the controller believes it is.
    pub controller_model: Robot<f64>,
    pub seed: u64,
}

impl CellFiles {
    /// Everything that a weld in this cell needs. `weld_file`: `None` for the embedded one.
    pub fn read(&self, weld_file: Option<&Path>) -> Result<Inputs> {
        let weld = embedded!(Weld, weld_file, "welds/vertical.toml");
        let (robot, mut process, mut effects) = self.model()?;
        if let Some(rpm) = self.spindle_rpm {
            if !(0.0..=FASTEST_SPINDLE).contains(&rpm) {
                return Err(miette!(
                    "--spindle-rpm {rpm}: expected turns a minute between 0 and {FASTEST_SPINDLE}, such as 750"
                ));
            }
            process.spindle = (rpm * std::f64::consts::TAU / 60.0).copysign(process.spindle);
        }
        let mut control = embedded!(Control, &self.control, "control/kr500-mt.toml");
        let sensors = embedded!(Sensors, &self.sensors, "sensors/kr500-mt.toml");
        if let Some(period) = self.period {
            if !(1e-4..=1.0).contains(&period) {
                return Err(miette!(
                    "--period {period}: expected seconds between 0.0001 and 1, such as 0.004"
                ));
            }
            control.period = period;
        }
        let parse = |text: &String| {
            Effect::parse(text, &robot).map_err(|error| miette!("--effect {text}: {error}"))
        };
        effects.extend(self.effect.iter().map(parse).collect::<Result<Vec<_>>>()?);
        let cell = Cell::new(&robot.robot, &effects, &process, Seam::of(&weld).b_from_w)
            .into_diagnostic()?;
        let error = self.stiffness_error.unwrap_or(0.0);
        let factor = SVector::from_element(1.0 + error);
        let controller_model = robot.robot.with_stiffness_scaled(&factor).map_err(|_| {
            miette!("--stiffness-error {error}: expected a number above -1, such as 0.1 for 10 % too stiff")
        })?;
        Ok(Inputs {
            weld_file: weld_file
                .map_or("embedded welds/vertical.toml".into(), |p| p.display().to_string()),
            weld_name: weld_file
                .and_then(Path::file_stem)
                .map_or("vertical".into(), |s| s.to_string_lossy().into_owned()),
            seed: self.seed.unwrap_or(sensors.seed),
            weld,
            robot,
            control,
            sensors,
            cell,
            planned: process,
            controller_model,
        })
    }

    /// Robot, process and effects of the real cell.
    fn model(&self) -> Result<(RobotFile, Process, Vec<Effect>)> {
        let Some(path) = &self.model else {
            let robot = embedded!(RobotFile, &self.robot, "robots/kr500-mt.toml");
            let process = embedded!(Process, &self.process, "processes/lap-weld-2024-t3.toml");
            return Ok((robot, process, Vec::new()));
        };
        let model = ModelFile::read(path)?;
        let effects = model.cell_effects();
        let process = model.process.ok_or_else(|| {
            miette!(
                help = "Add `process = \"…\"`, the path of a process file from the model file's folder.",
                "{}: names no process; expected one, to weld with",
                path.display()
            )
        })?;
        Ok((model.robot, process, effects))
    }
}

impl Inputs {
    /// What to say of a run that did not come to its end.
    pub fn failed(&self, controller: Controller, error: &RunError) -> Report {
        match error {
            RunError::Reach { .. } => miette!(
                help = "Expected a seam that the robot reaches with the tool square to it: move start_m and end_m.",
                "{}: {error}",
                self.weld_file
            ),
            _ => miette!("{}, {} control: {error}", self.weld_file, controller.name()),
        }
    }

    /// What to say of a weld that has no figures.
    pub fn too_short(&self) -> Report {
        miette!(
            help =
                "Expected a seam long enough for the feed to rise and settle: a few centimetres.",
            "{}: the weld is too short to reach its steady part",
            self.weld_file
        )
    }

    pub fn scenario(
        &self,
        program: Program,
        controller: Controller,
        law: &'static dyn BuildLaw,
    ) -> Scenario<'_> {
        Scenario {
            name: &self.weld_name,
            cell: &self.cell,
            controller_model: &self.controller_model,
            planned: &self.planned,
            weld: &self.weld,
            program,
            control: &self.control,
            sensors: &self.sensors,
            controller,
            law,
            integrator: Integrator::LinearlyImplicit,
            plant_step: PLANT_STEP,
            seed: self.seed,
            fault: None,
        }
    }
}
