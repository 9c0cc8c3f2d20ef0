//! A cell with a weld, from its files and options to all that a run needs.

use crate::fixture::{Embedded, PUBLISHED_WELDS, read_input};
use crate::provenance::of_program;
use miette::{IntoDiagnostic, Report, Result, miette};
use nalgebra::SVector;
use std::path::{Path, PathBuf};
use trueweld_compensators::Entry;
use trueweld_core::Robot;
use trueweld_evaluate::certify::NominalCell;
use trueweld_evaluate::{Requirements, UncertainCell};
use trueweld_plant::cell::Cell;
use trueweld_plant::effects::Effect;
use trueweld_plant::input::{
    Control, InputFile, ModelFile, Posterior, Process, RobotFile, Sensors, TomlDocument, Weld,
    check_option, check_weld, read_text,
};
use trueweld_plant::integrate::Integrator;
use trueweld_plant::provenance::{
    CoreRecord, EffectRecord, FileDigest, Provenance, SimulationRecord,
};
use trueweld_plant::robot::ElasticRobot;
use trueweld_plant::simulate::{
    ControllerKind, RecordRow, RunError, Scenario, Seam, WeldProgram, check_reach,
};

/// Input files and options of a cell, whatever it welds. What is not given is that of the embedded
/// KR 500 MT with its end effector for friction stir welding.
///
/// ```
/// # let fixture = |name| format!("{}/../../fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
/// let files = trueweld::CellFiles::new()
///     .robot(fixture("robots/kr500-mt.toml"))
///     .effect("backlash:A5:half_gap_rad=2e-4");
/// let cell = files.read()?;
/// assert_eq!(cell.effects.len(), 1);
/// # Ok::<(), miette::Report>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct CellFiles {
    /// Robot file.
    pub robot: Option<PathBuf>,
    /// Model file: robot, process and effects of the real cell, instead of `robot` and `process`.
    pub model: Option<PathBuf>,
    /// The controller knows the model file's effects as well; refused where there are others than
    /// numbers of its robot.
    pub informed: bool,
    /// Process file.
    pub process: Option<PathBuf>,
    /// Control file: gains and limits of the controllers.
    pub control: Option<PathBuf>,
    /// Sensor file.
    pub sensors: Option<PathBuf>,
    /// Effects of the real robot that the controller does not know, as `ID:AT:NAME=VALUE,...`.
    pub effects: Vec<String>,
    /// Relative error of the joint stiffness that the controller believes in.
    pub stiffness_error: Option<f64>,
    /// Speed of the spindle, turns a minute, in the sense of the process file's.
    pub spindle_rpm: Option<f64>,
    /// Control period, s, instead of the control file's.
    pub period: Option<f64>,
    /// Seed of the sensors' noise, instead of the sensor file's.
    pub seed: Option<u64>,
    /// What was found of the real cell beside its files.
    pub found: FoundInLog,
    /// Files that a law was read from, or the log of `found`. Nothing is read from them here; results state
    /// them.
    pub law_files: Vec<FileDigest>,
}

/// What the log of a weld shows of its cell that no file states.
#[derive(Debug, Clone, Default)]
pub struct FoundInLog {
    /// Effects of the real cell.
    pub effects: Vec<Effect>,
    /// Speed of the spindle with its sense, rad/s, instead of the process file's.
    pub spindle: Option<f64>,
    /// Changes of the feed that the weld file does not state: path position, m, and speed, m/s.
    pub feeds: Vec<(f64, f64)>,
    /// How far across the seam the path was taught from where the model teaches it, m.
    pub taught_offset: f64,
}

/// The value of an option within the possible range of its quantity, in the quantity's unit.
/// `flag`: its name, for the message; `key`: of the quantity.
///
/// # Errors
/// A value outside.
pub fn checked_option(flag: &str, key: &str, value: f64) -> Result<f64> {
    check_option(flag, key, value).map_err(|error| miette!("{error}"))
}

/// Longest plant step of a run that is looked at, s.
pub const PLANT_STEP: f64 = 1e-3;

/// Longest plant step where welds are made by the hundred, s: a weld ends within 0.03 µm and 0.4 N
/// of where it does at 0.25 ms.
pub const STEP_OF_MANY: f64 = 2e-3;

/// Most memory that the record of one run may take, bytes.
const MOST_MEMORY: f64 = 2e9;

/// A cell with a weld: everything that was read, checked.
pub struct WeldingCell {
    /// Where the weld was read from, for messages.
    pub weld_file: String,
    /// Name of the weld: the stem of its file's.
    pub weld_name: String,
    /// The weld.
    pub weld: Weld,
    /// The robot as its file has it, without effects.
    pub robot: RobotFile,
    /// Gains and limits of the controllers and laws.
    pub control: Control,
    /// Instruments.
    pub sensors: Sensors,
    /// The real cell: robot with its effects, process, and the seam where it really lies.
    pub cell: Cell,
    /// Effects of the real cell: the model file's, then those that were given.
    pub effects: Vec<Effect>,
    /// What measurements leave open of the model file's numbers.
    posterior: Option<ModelPosterior>,
    /// The process as the weld is planned with it.
    pub planned: Process,
    /// The robot as the controller believes it is.
    pub controller_model: Robot<f64>,
    /// Seed of the sensors' noise.
    pub seed: u64,
    /// Relative error of the stiffness in `controller_model`.
    pub stiffness_error: f64,
    /// True where `controller_model` has the model file's effects.
    pub informed: bool,
    /// Every file that was read.
    pub files: Vec<FileDigest>,
}

/// The posterior of a model file.
struct ModelPosterior {
    of: Posterior,
    file: PathBuf,
    /// Whether it belongs to the robot, the process and the effects that the file has now.
    is_sealed: bool,
}

impl CellFiles {
    /// The embedded cell.
    pub fn new() -> Self {
        Self::default()
    }

    /// With this robot file.
    #[must_use]
    pub fn robot(self, file: impl Into<PathBuf>) -> Self {
        Self { robot: Some(file.into()), ..self }
    }

    /// With this model file: robot, process and effects of the real cell.
    #[must_use]
    pub fn model(self, file: impl Into<PathBuf>) -> Self {
        Self { model: Some(file.into()), ..self }
    }

    /// With this process file.
    #[must_use]
    pub fn process(self, file: impl Into<PathBuf>) -> Self {
        Self { process: Some(file.into()), ..self }
    }

    /// With this control file.
    #[must_use]
    pub fn control(self, file: impl Into<PathBuf>) -> Self {
        Self { control: Some(file.into()), ..self }
    }

    /// With this sensor file.
    #[must_use]
    pub fn sensors(self, file: impl Into<PathBuf>) -> Self {
        Self { sensors: Some(file.into()), ..self }
    }

    /// With an effect more of the real robot: `ID:AT:NAME=VALUE,...`, SI units.
    #[must_use]
    pub fn effect(mut self, effect: impl Into<String>) -> Self {
        self.effects.push(effect.into());
        self
    }

    /// With this relative error of the joint stiffness that the controller believes in.
    #[must_use]
    pub fn stiffness_error(self, error: f64) -> Self {
        Self { stiffness_error: Some(error), ..self }
    }

    /// With this seed of the sensors' noise.
    #[must_use]
    pub fn seed(self, seed: u64) -> Self {
        Self { seed: Some(seed), ..self }
    }

    /// The cell with the embedded weld, the first published sequence.
    ///
    /// # Errors
    /// Those of [`CellFiles::read_weld`].
    pub fn read(&self) -> Result<WeldingCell> {
        self.read_weld(None)
    }

    /// The cell with the weld of a file.
    ///
    /// # Errors
    /// Those of [`CellFiles::read_weld`].
    pub fn weld(&self, file: impl AsRef<Path>) -> Result<WeldingCell> {
        self.read_weld(Some(file.as_ref()))
    }

    /// Everything that a weld in this cell needs. `weld_file`: `None` for the embedded one.
    ///
    /// # Errors
    /// A file that cannot be read, a value that is not possible, an effect that does not suit the
    /// robot, a seam that the arm does not reach.
    pub fn read_weld(&self, weld_file: Option<&Path>) -> Result<WeldingCell> {
        let inputs = self.read_anywhere(weld_file)?;
        check_reach(&inputs.controller_model, &inputs.weld)
            .map_err(|error| inputs.failed(ControllerKind::EXTERNAL, &error))?;
        Ok(inputs)
    }

    /// The same of a weld that the arm may not reach where its file has it.
    ///
    /// # Errors
    /// Those of [`CellFiles::read_weld`], but for the reach.
    pub fn read_anywhere(&self, weld_file: Option<&Path>) -> Result<WeldingCell> {
        let mut files = Vec::new();
        let weld = read_input::<Weld>(weld_file, &mut files)?;
        let file = weld_file
            .map_or("embedded welds/vertical.toml".into(), |path| path.display().to_string());
        let name = weld_file
            .and_then(Path::file_stem)
            .map_or("vertical".into(), |stem| stem.to_string_lossy().into_owned());
        self.with_weld(weld, [file, name], files)
    }

    /// Both welds as they were published, in this cell.
    ///
    /// # Errors
    /// Those of [`CellFiles::read_weld`], but for the reach.
    pub fn read_published(&self) -> Result<[WeldingCell; 2]> {
        let read = |(name, [file, text]): (&str, [&str; 2])| {
            let digest = FileDigest::new(Weld::KIND.name(), file, text.as_bytes());
            let named = [file, name].map(str::to_owned);
            self.with_weld(Weld::parse(text, file)?, named, vec![digest])
        };
        let [vertical, inclined] = PUBLISHED_WELDS;
        Ok([read(vertical)?, read(inclined)?])
    }

    /// The cell with a weld, which was read from `file` and has a name.
    fn with_weld(
        &self,
        mut weld: Weld,
        [weld_file, weld_name]: [String; 2],
        mut files: Vec<FileDigest>,
    ) -> Result<WeldingCell> {
        let ReadModel { robot, mut process, mut effects, posterior } =
            self.read_model(&mut files)?;
        let known = if self.informed { self.known(&robot, &effects)? } else { robot.robot.clone() };
        weld.feeds.extend(&self.found.feeds);
        weld.real.by.linear.y -= self.found.taught_offset;
        process.spindle = self.found.spindle.unwrap_or(process.spindle);
        if let Some(rpm) = self.spindle_rpm {
            let rpm = checked_option("--spindle-rpm", "spindle_rpm", rpm)?;
            process.spindle = (rpm * std::f64::consts::TAU / 60.0).copysign(process.spindle);
        }
        let mut control: Control = read_input(self.control.as_deref(), &mut files)?;
        let sensors: Sensors = read_input(self.sensors.as_deref(), &mut files)?;
        if let Some(period) = self.period {
            control.period = checked_option("--period", "period_s", period)?;
        }
        let cycles = WeldProgram::Weld.duration(&weld, &Seam::of(&weld)) / control.period;
        let memory = cycles * size_of::<RecordRow>() as f64;
        if memory > MOST_MEMORY {
            return Err(miette!(
                help = "Raise the feed or the control period, or shorten the ramps and settle_s.",
                "the weld takes {cycles:.1e} control cycles, and its record {:.1} GB of memory; expected at most {:.1} GB",
                memory / 1e9,
                MOST_MEMORY / 1e9
            ));
        }
        let parse = |text: &String| {
            Effect::parse(text, &robot).map_err(|error| miette!("--effect {text}: {error}"))
        };
        effects.extend(self.effects.iter().map(parse).collect::<Result<Vec<_>>>()?);
        effects.extend(self.found.effects.iter().cloned());
        let cell =
            Cell::new(&robot.robot, &effects, &process, Seam::real(&weld)).into_diagnostic()?;
        let error = self.stiffness_error.unwrap_or(0.0);
        let error = checked_option("--stiffness-error", "stiffness_error", error)?;
        let factor = SVector::from_element(1.0 + error);
        let controller_model = known
            .with_stiffness_scaled(&factor)
            .map_err(|_| miette!("--stiffness-error {error} leaves no possible robot"))?;
        let inputs = WeldingCell {
            weld_file,
            weld_name,
            seed: self.seed.unwrap_or(sensors.seed),
            weld,
            robot,
            control,
            sensors,
            cell,
            effects,
            posterior,
            planned: process,
            controller_model,
            stiffness_error: error,
            informed: self.informed,
            files: files.into_iter().chain(self.law_files.iter().cloned()).collect(),
        };
        check_weld(&inputs.weld, &inputs.planned, |key| inputs.place_in_weld(key));
        Ok(inputs)
    }

    /// The robot with the model file's effects in its own numbers.
    fn known(&self, robot: &RobotFile, effects: &[Effect]) -> Result<Robot<f64>> {
        let acts = |e: &&Effect| e.values != e.kind.neutral(e.at).values;
        let others = effects.iter().filter(acts).filter(|e| !e.is_of_robot_model());
        let others: Vec<String> = others.map(|e| e.name(robot)).collect();
        if !others.is_empty() {
            let file = self.model.as_deref().unwrap_or(Path::new("")).display();
            return Err(miette!(
                help = "Give a copy of the model file without them to a controller that is to know the rest; or leave --informed out: then \
                        the law meets all effects unknown.",
                "--informed: a controller's model cannot hold {} of {file}; expected effects that are other numbers of the robot, such \
                 as its stiffness and geometry",
                others.join(" and ")
            ));
        }
        let of_robot: Vec<Effect> =
            effects.iter().filter(|e| e.is_of_robot_model()).cloned().collect();
        let known = ElasticRobot::with_effects(&robot.robot, &of_robot, None).into_diagnostic()?;
        Ok(known.model)
    }

    fn read_model(&self, files: &mut Vec<FileDigest>) -> Result<ReadModel> {
        let Some(path) = &self.model else {
            let robot = read_input(self.robot.as_deref(), files)?;
            let process = read_input(self.process.as_deref(), files)?;
            return Ok(ReadModel { robot, process, effects: Vec::new(), posterior: None });
        };
        let model = ModelFile::read(path)?;
        files.extend(FileDigest::of_model(&model)?);
        let effects = model.cell_effects();
        let is_sealed = model.is_sealed()?;
        let posterior =
            model.posterior.map(|of| ModelPosterior { of, file: path.clone(), is_sealed });
        let process = model.process.ok_or_else(|| {
            miette!(
                help = "Add `process = \"…\"`, the path of a process file from the model file's folder.",
                "{}: names no process; expected one, to weld with",
                path.display()
            )
        })?;
        Ok(ReadModel { robot: model.robot, process, effects, posterior })
    }
}

/// Robot, process and effects of the real cell.
struct ReadModel {
    robot: RobotFile,
    process: Process,
    effects: Vec<Effect>,
    posterior: Option<ModelPosterior>,
}

impl WeldingCell {
    /// Text of an input file, as it was read.
    ///
    /// # Errors
    /// A file that was changed or removed since.
    pub fn text<T: Embedded>(&self) -> Result<String> {
        let [embedded, fixture] = T::FIXTURE;
        let read = self.files.iter().find(|file| file.role == T::KIND.name());
        let Some(read) = read.filter(|file| file.file != embedded) else {
            return Ok(fixture.to_owned());
        };
        let (name, text) = read_text(Path::new(&read.file))?;
        if FileDigest::new(&read.role, &read.file, text.as_bytes()) != *read {
            return Err(miette!("{name}: it was changed since it was read"));
        }
        Ok(text)
    }

    /// What the robot file says of its own numbers: the comment that it begins with.
    ///
    /// # Errors
    /// Those of [`WeldingCell::text`].
    pub fn robot_grade(&self) -> Result<String> {
        let text = self.text::<RobotFile>()?;
        let lines = text.lines().map_while(|line| line.strip_prefix('#'));
        Ok(lines.map(str::trim).collect::<Vec<_>>().join(" "))
    }

    /// Where a key of the weld file stands.
    fn place_in_weld(&self, key: &str) -> String {
        let text = self.text::<Weld>().unwrap_or_default();
        match TomlDocument::parse(&text, &self.weld_file) {
            Ok(document) if !text.is_empty() => document.root().place_of(key),
            _ => self.weld_file.clone(),
        }
    }

    /// What is not known of this cell where what was measured of it stands in place of what is
    /// assumed; `None` where nothing was measured.
    ///
    /// # Errors
    /// A posterior of another model.
    pub fn measured(&self, assumed: &UncertainCell) -> Result<Option<UncertainCell>> {
        let Some(ModelPosterior { of, file, is_sealed }) = &self.posterior else {
            return Ok(None);
        };
        let file = file.display();
        if !is_sealed {
            return Err(miette!(
                help = "Run `improve` again for the model as it is; or take the table [posterior] out, and what the \
                        requirements assume stands in its place.",
                "{file}: what was measured is of another model: effects, robot, process or [posterior] were changed \
                 since; expected them as `improve` wrote them"
            ));
        }
        let cell = assumed.clone().measured(of, &self.robot, &self.planned, &self.sensors);
        cell.map(Some).map_err(|why| miette!("{file}: {why}"))
    }

    /// Requirements as they are asked of this weld in this cell. `files`: with the requirements' among
    /// them.
    ///
    /// # Errors
    /// A limit that the weld cannot be held to.
    pub fn asked(&self, of: &Requirements, files: &[FileDigest]) -> Result<Requirements> {
        let is = |file: &&FileDigest| file.role == Requirements::KIND.name();
        let name = files.iter().find(is).map_or("", |file| &file.file);
        of.of_weld(&self.weld, &self.planned, &self.control.compensation).map_err(|error| {
            miette!(
                help = "Half the pin is of the process file, push, feed and settle_s are of the weld file: a limit in another \
                        unit, or of a part that the weld has not got, would pass whatever the law does.",
                "{name}, for {}: {error}",
                self.weld_file
            )
        })
    }

    /// What the cells of a certification are made from.
    pub fn nominal<'a>(&'a self, uncertain: &'a UncertainCell) -> NominalCell<'a> {
        NominalCell { robot: &self.robot.robot, effects: &self.effects, uncertain }
    }

    /// The options of a simulation. `plant_step`: the longest, s.
    pub fn simulation(
        &self,
        controllers: &[ControllerKind],
        laws: &[Entry],
        passes: usize,
        plant_step: f64,
    ) -> SimulationRecord {
        SimulationRecord {
            welds: vec![self.weld_name.clone()],
            controllers: controllers.iter().map(|c| c.name().to_owned()).collect(),
            laws: laws.iter().map(|law| law.name().to_owned()).collect(),
            stiffness_error: self.stiffness_error,
            informed: self.informed,
            spindle_rad_s: self.planned.spindle,
            control_period_s: self.control.period,
            plant_step_s: plant_step,
            passes,
            noise_seed: self.seed,
            draws_seed: None,
            force_step_n: None,
            cores: Vec::new(),
        }
    }

    /// What a controller's core is built from for this weld; nothing for a law that no core has.
    pub fn cores(&self, controller: ControllerKind, law: &Entry) -> Vec<CoreRecord> {
        let constants = self.scenario(WeldProgram::Weld, controller, law).constants();
        let record = constants.map(|constants| CoreRecord {
            weld: self.weld_name.clone(),
            law: law.name().to_owned(),
            sha256: constants.configuration.digest_text(),
        });
        record.into_iter().collect()
    }

    /// What a result of these inputs is of.
    pub fn provenance(&self, command: &str, simulation: SimulationRecord) -> Provenance {
        Provenance {
            robot: self.robot.name.clone(),
            effects: self.effects.iter().map(|e| EffectRecord::new(e, &self.robot)).collect(),
            simulation: Some(simulation),
            files: self.files.clone(),
            ..of_program(command)
        }
    }

    /// That the process bears a push, which the force loop of a command holds. `command`: what it is.
    ///
    /// # Errors
    /// A process that bears none.
    pub fn must_bear_push(&self, command: &str) -> Result<()> {
        if self.planned.bears_push() {
            return Ok(());
        }
        let process = self.planned.kind().name;
        Err(miette!("{command} is of a process that bears a push, and {process} bears none"))
    }

    /// What to say of a run that did not come to its end.
    pub fn failed(&self, controller: ControllerKind, error: &RunError) -> Report {
        match error {
            RunError::Reach { .. } | RunError::TooFast { .. } => miette!(
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

    /// Everything that one run is made of, with plant steps of [`PLANT_STEP`] at most.
    pub fn scenario<'a>(
        &'a self,
        program: WeldProgram,
        controller: ControllerKind,
        law: &'a Entry,
    ) -> Scenario<'a> {
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

/// True for two paths of one file.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
