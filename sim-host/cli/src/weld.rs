//! `trueweld weld`: a weld, with and without compensation, and how far the tool leaves its line.

use crate::certify::certificate;
use crate::inputs::{WeldArguments, passes};
use crate::names::{ControllerParser, LawList, LawListParser, LawParser};
use crate::results::{FormFiles, RecordedResults, Results, check_outputs, check_targets};
use clap::Args;
use miette::{Report, Result, miette};
use std::path::{Path, PathBuf};
use trueweld::{
    CellFiles, LoggedWeld, PLANT_STEP, STEP_OF_MANY, SimulateOptions, SimulatedWeld, simulate,
};
use trueweld_compensators::{Elastostatic, Entry, Uncompensated};
use trueweld_estimate::disturbance::WELD_AXES;
use trueweld_evaluate::ReplayCheck;
use trueweld_output::{AxisDisturbance, FromLog, WeldReport, WeldRun};
use trueweld_plant::controllers::ControllerKind;
use trueweld_plant::simulate::{Seam, WeldProgram};

/// Arguments of `weld`.
#[derive(Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    files: WeldArguments,
    /// Hybrid force/position controller
    #[arg(long, value_parser = ControllerParser, default_value = ControllerKind::default().name())]
    controller: ControllerKind,
    /// Compensation law, or several with + between them; several runs with comma between their laws
    /// (default: a run without and a run with elastostatic)
    #[arg(long, value_name = "LAW", value_parser = LawListParser)]
    compensator: Option<LawList>,
    /// Folder of the log of a weld, which is made again: its robot, seam and process, and the force on
    /// the tool that the model does not explain
    #[arg(
        long,
        value_name = "LOG",
        conflicts_with_all = ["weld", "robot", "process", "effect", "certificate"]
    )]
    from: Option<PathBuf>,
    /// Compensation law that the log was recorded under: its replay is judged by the record (default:
    /// none)
    #[arg(long, value_name = "LAW", value_parser = LawParser, requires = "from")]
    recorded_law: Option<Entry>,
    /// Control file that the log was recorded under (default: the one that is part of the program)
    #[arg(long, value_name = "F", requires = "from")]
    recorded_control: Option<PathBuf>,
    /// Welds of the same seam one after another, the law kept from one to the next; the last one is
    /// reported
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = passes())]
    passes: u32,
    /// Certificate (certify.json) that this weld is made under: refused where it is of another cell, law
    /// or weld, does not pass, or this is not the weld that was asked for
    #[arg(long, value_name = "FILE", requires = "compensator")]
    certificate: Option<PathBuf>,
    /// Factor by which the recording exaggerates deviations
    #[arg(
        long,
        value_name = "X",
        default_value_t = 50.0,
        allow_negative_numbers = true,
        requires = "rrd"
    )]
    exaggeration: f64,
    #[command(flatten)]
    results: RecordedResults,
}

impl Arguments {
    /// The first published weld with and without compensation, written to `out/`.
    pub(crate) fn first_published() -> Self {
        let forms = FormFiles::default().or_page("out/weld.html");
        let results = RecordedResults {
            files: Results { forms, ..Results::default() },
            rrd: cfg!(feature = "rerun").then(|| PathBuf::from("out/weld.rrd")),
        };
        Self {
            files: WeldArguments::default(),
            controller: ControllerKind::default(),
            compensator: None,
            from: None,
            recorded_law: None,
            recorded_control: None,
            passes: 1,
            certificate: None,
            exaggeration: 50.0,
            results,
        }
    }
}

/// Runs the command.
pub(crate) fn run(arguments: &Arguments) -> Result<()> {
    if !(arguments.exaggeration.is_finite() && arguments.exaggeration >= 1.0) {
        return Err(miette!(
            "--exaggeration {}: expected a number from 1 up",
            arguments.exaggeration
        ));
    }
    let outputs = arguments.results.outputs();
    check_targets(&outputs)?;
    let laws = arguments.laws()?;
    let recorded = arguments.from.as_deref().map(|log| WeldRecord::read(arguments, log));
    let recorded = recorded.transpose()?;
    let inputs = match &recorded {
        None => arguments.files.read()?,
        Some(recorded) => recorded.log.cell(&arguments.files.cell.files())?,
    };
    let controller = arguments.controller;
    let passes = arguments.passes as usize;
    // Under a certificate the run is the one that was certified.
    let plant_step = if arguments.certificate.is_some() { STEP_OF_MANY } else { PLANT_STEP };
    let simulation = simulate(&inputs).controller(controller).passes(passes).plant_step(plant_step);
    let simulation = laws.iter().cloned().fold(simulation, SimulateOptions::law);
    let provenance = simulation.provenance();
    let certificate = arguments.certificate.as_deref();
    let certificate = certificate
        .map(|path| Ok::<_, Report>((path, certificate::check(path, &provenance)?)))
        .transpose()?;
    check_outputs(&outputs)?;
    let duration = WeldProgram::Weld.duration(&inputs.weld, &Seam::of(&inputs.weld));
    let progress = arguments.results.files.progress("welding", duration * passes as f64);
    let welds = simulation.on_progress(&|time| progress.advance_to(time)).run();
    progress.finish();
    let welds = welds?.runs;
    if let Some((path, certificate)) = &certificate {
        welds.iter().try_for_each(|weld| certificate::tell(path, certificate, &weld.figures))?;
    }
    let from_log = recorded.map(|recorded| recorded.beside(arguments, &welds)).transpose()?;
    let robot = &inputs.robot.robot;
    let runs: Vec<WeldRun<'_>> = welds
        .iter()
        .map(|SimulatedWeld { recording, figures }| WeldRun::new(recording, figures, robot))
        .collect();
    arguments.results.write(&WeldReport {
        runs: &runs,
        from_log: from_log.as_ref(),
        exaggeration: arguments.exaggeration,
        provenance: &provenance,
    })
}

impl Arguments {
    /// The laws that are run.
    fn laws(&self) -> Result<Vec<Entry>> {
        let Some(LawList(laws)) = &self.compensator else {
            return Ok(vec![Entry::of::<Uncompensated>(), Entry::of::<Elastostatic<f64>>()]);
        };
        if self.certificate.is_some() && laws.len() > 1 {
            return Err(miette!(
                "--compensator names {} laws; expected one, that of --certificate",
                laws.len()
            ));
        }
        Ok(laws.clone())
    }
}

/// A recorded weld, with the law and the gains that it was recorded under.
struct WeldRecord {
    log: LoggedWeld,
    folder: String,
    law: Entry,
    files: CellFiles,
}

impl WeldRecord {
    /// Reads the log, and finds by a first replay where its path was taught.
    fn read(arguments: &Arguments, folder: &Path) -> Result<Self> {
        let files = arguments.files.cell.files();
        let log = LoggedWeld::read(folder, files.model.as_deref())?;
        let law = arguments.recorded_law.clone().unwrap_or(Entry::of::<Uncompensated>());
        // What is asked of the weld that is run is not of the one that was recorded.
        let files = CellFiles {
            control: arguments.recorded_control.clone(),
            stiffness_error: None,
            spindle_rpm: None,
            period: None,
            ..files
        };
        let folder = folder.display().to_string();
        let mut record = Self { log, folder, law, files };
        let first = record.replay(arguments.controller)?;
        record.log.find_taught_path(&first);
        Ok(record)
    }

    /// The record beside a simulation of its law and gains.
    fn replay(&self, controller: ControllerKind) -> Result<ReplayCheck> {
        let cell = self.log.cell(&self.files)?;
        let welds = simulate(&cell).controller(controller).law(self.law.clone()).run()?.runs;
        self.check(&welds)
    }

    /// The record beside that of some welds which is of its law.
    fn check(&self, welds: &[SimulatedWeld]) -> Result<ReplayCheck> {
        let replayed = welds.iter().find(|weld| weld.recording.compensator == self.law.name());
        let check = replayed.and_then(|weld| ReplayCheck::of(&self.log.rows, &weld.recording));
        check.ok_or_else(|| {
            miette!(
                "{}: the tracker saw nothing of the steady part of the weld; expected it to see the tool there",
                self.folder
            )
        })
    }

    /// What was taken from the log, with the record beside its simulation: one of these `welds` where one
    /// is of its law and gains, else one more.
    fn beside(self, arguments: &Arguments, welds: &[SimulatedWeld]) -> Result<FromLog> {
        let asked = arguments.files.cell.files();
        let changed = [asked.stiffness_error, asked.spindle_rpm, asked.period];
        let is_run = self.files.control == asked.control
            && changed.iter().all(Option::is_none)
            && arguments.passes == 1
            && welds.iter().any(|weld| weld.recording.compensator == self.law.name());
        let check = if is_run { self.check(welds)? } else { self.replay(arguments.controller)? };
        let LoggedWeld { disturbance, axes, spindle, taught_offset, .. } = &self.log;
        let axis = |k: usize| AxisDisturbance {
            axis: WELD_AXES[k],
            rms_n: disturbance.rms[k],
            noise_n: disturbance.noise[k],
            taken: axes.contains(&k),
        };
        let control = self.files.control.as_ref();
        Ok(FromLog {
            log: self.folder,
            control: control.map_or("that of the program".to_owned(), |f| f.display().to_string()),
            spindle_rad_s: *spindle,
            taught_offset_m: *taught_offset,
            disturbance: [0, 1, 2].map(axis),
            check,
            feeds: self.log.feeds,
            rows: self.log.rows,
        })
    }
}
